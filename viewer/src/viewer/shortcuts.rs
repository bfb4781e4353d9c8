//! Keys, and the list of them.

use egui::{Key, KeyboardShortcut, Modifiers, Popup, RichText, ScrollArea, Ui};
use engine::scene::view::MAX_EXPOSURE;

use crate::link::{Command, Extent};

use super::Viewer;
use super::dialogs::Dialog;

const SHIFT_COMMAND: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);
pub(super) const SAVE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::S);
pub(super) const SAVE_AS: KeyboardShortcut = KeyboardShortcut::new(SHIFT_COMMAND, Key::S);
pub(super) const SAVE_PICTURE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::E);
pub(super) const OPEN: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::O);
const UNDO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Z);
const REDO: KeyboardShortcut = KeyboardShortcut::new(SHIFT_COMMAND, Key::Z);
const REDO_TOO: KeyboardShortcut = KeyboardShortcut::new(Modifiers::COMMAND, Key::Y);
/// Stops that a key changes.
const STOP: f32 = 0.25;

/// What `?` lists: keys, and what they do.
pub const SHORTCUTS: [(&str, &str); 52] = [
    ("drag", "turn around the point in focus"),
    ("right drag", "look around"),
    ("middle drag, Shift drag", "pan"),
    ("wheel", "nearer, farther"),
    (
        "W A S D, Q E",
        "fly, with the pointer over the picture; Shift is faster",
    ),
    ("G", "walk: W A S D follow the ground; again: fly"),
    ("click", "choose the material; a line goes around it"),
    ("Ctrl click", "focus there, and turn around it"),
    ("F", "frame what was clicked, or everything"),
    ("Shift F", "frame everything"),
    (
        "arrows",
        "turn, while the picture has the keyboard (click it, or Tab)",
    ),
    ("Shift arrows", "pan, likewise"),
    ("+  -", "nearer, farther, likewise"),
    ("Enter", "choose the material in the middle, likewise"),
    ("Home", "the look's camera"),
    ("1 ... 9", "cameras of the scene"),
    ("R", "render a region only; again: everything"),
    ("C", "compare with the picture of now; again: don't"),
    ("L", "mix the lights; again: the look"),
    ("N", "take the noise out of what is shown; again: don't"),
    ("P", "pause"),
    ("[  ]", "exposure by a quarter of a stop"),
    ("0", "exposure 0"),
    ("Ctrl Z", "undo the last edit of the look"),
    ("Ctrl Shift Z, Ctrl Y", "do it again"),
    ("Ctrl S", "save the look"),
    ("Ctrl Shift S", "save the look as another file"),
    ("Ctrl E", "save the picture"),
    ("Ctrl O", "open a scene"),
    ("right-click a value", "its default"),
    (
        "right-click A, B, C",
        "keep, forget or compare a state of the look",
    ),
    ("Tab, Shift Tab", "the next widget, the one before"),
    (
        "Menu, Shift F10",
        "what a right click offers on the widget that has the keyboard",
    ),
    (
        "border: arrows, Shift arrows",
        "move the border that has the keyboard (Tab); with Shift by little",
    ),
    ("border: Home, End", "as far as it goes"),
    (
        "region: Enter",
        "after R, on the picture: a region in its middle",
    ),
    ("ramp: click, Delete", "add a stop; take one away"),
    (
        "ramp: arrows, Insert, Enter",
        "move a stop that has the keyboard; add one; its colour",
    ),
    ("graph: drag, wheel", "move, nearer and farther"),
    ("graph: Shift click", "select one more card"),
    ("graph: Shift drag", "select the cards in a rectangle"),
    ("graph: Ctrl A", "select all cards"),
    (
        "graph: Ctrl C, X, V",
        "copy, cut and paste, from look to look",
    ),
    ("graph: Ctrl D", "duplicate what is selected"),
    ("graph: Ctrl G", "a frame around what is selected"),
    ("graph: Delete", "delete what is selected"),
    ("graph: arrows", "the next card; Enter shows its values"),
    ("graph: Shift arrows", "move the card, or what is selected"),
    (
        "drag a texture",
        "from the list of textures: onto a value, or onto the graph",
    ),
    (
        "drag a material",
        "onto the model, or onto another material",
    ),
    ("?", "this list"),
    ("Esc", "close; end what was begun; nothing is picked"),
];

impl Viewer {
    pub(super) fn take_keys(&mut self, ui: &Ui) {
        let ctx = ui.ctx();
        if self.dialog.is_some() || self.questions.is_asking() || self.picture_to_use.is_some() {
            // Its own keys are taken where it is shown.
            return;
        }
        // The longer ones first: Ctrl Shift S is also Ctrl S.
        // A field has an undo of its own.
        let is_writing = ctx.text_edit_focused();
        let pressed = |shortcut| ctx.input_mut(|input| input.consume_shortcut(shortcut));
        if pressed(&SAVE_AS) {
            self.dialog = Some(Dialog::save_as(&self.scene.files));
        } else if pressed(&SAVE) {
            self.save();
        } else if pressed(&SAVE_PICTURE) {
            self.ask_for_picture();
        } else if !is_writing && (pressed(&REDO) || pressed(&REDO_TOO)) {
            self.redo();
        } else if !is_writing && pressed(&UNDO) {
            self.undo();
        } else if pressed(&OPEN) {
            self.dialog = Some(Dialog::open(&self.scene.files));
        }
        // What is written into a field or over an open menu is no shortcut.
        if is_writing || Popup::is_any_open(ctx) {
            return;
        }
        // By what was typed: where the question mark is depends on the keyboard.
        let typed: Vec<String> = ctx.input(|input| {
            let texts = input.events.iter().filter_map(|event| match event {
                egui::Event::Text(text) => Some(text.clone()),
                _ => None,
            });
            texts.collect()
        });
        for text in typed {
            self.typed(&text);
        }
        let (home, escape) = ctx.input(|i| (i.key_pressed(Key::Home), i.key_pressed(Key::Escape)));
        if home {
            self.go_home();
        }
        if escape {
            self.lists_shortcuts = false;
            self.stop_choosing_region();
            if self.viewport.placing.take().is_some() {
                return;
            }
            if self.material.take().is_some() {
                self.link.send(Command::Unpick);
            }
        }
    }

    fn typed(&mut self, text: &str) {
        let mut display = self.display;
        match text {
            "?" => self.lists_shortcuts ^= true,
            "f" => self.link.send(Command::Bounds(Extent::Picked)),
            "F" => self.link.send(Command::Bounds(Extent::Scene)),
            "r" => self.toggle_region(),
            "c" => self.toggle_compare(),
            "l" => self.toggle_mix(),
            "n" => self.toggle_denoise(),
            "g" => self.toggle_walk(),
            "p" => self.link.send(Command::Pause(!self.status.is_paused)),
            "[" | "]" => {
                let stops = if text == "]" { STOP } else { -STOP };
                let exposure = display.view.exposure + stops;
                // A look takes no more.
                display.view.exposure = exposure.clamp(-MAX_EXPOSURE, MAX_EXPOSURE);
            }
            "0" => display.view.exposure = 0.0,
            digit => {
                let number = digit.parse::<usize>().ok().and_then(|n| n.checked_sub(1));
                let camera = number.and_then(|n| self.scene.cameras.get(n).cloned());
                if let Some(camera) = camera {
                    self.look_through(camera);
                }
            }
        }
        self.set_display(display);
    }

    /// All keys, in place of the panel of the look: nothing of the picture is covered, and it keeps its size.
    pub(super) fn shortcut_list(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.heading("Keyboard and mouse");
            if ui.button("Close").clicked() {
                self.lists_shortcuts = false;
            }
        });
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for (keys, what) in SHORTCUTS {
                ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(keys).strong());
                    ui.label(what);
                });
            }
        });
    }
}
