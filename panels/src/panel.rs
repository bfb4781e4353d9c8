//! The textures panel: what belongs to one material, as a list or as a graph.
//!
//! What is shown is read from the [`Document`] and not changed meanwhile; edits are collected, and made when all has
//! been shown.

use std::rc::Rc;
use std::sync::Arc;

use egui::{Key, Modifiers, Popup, ScrollArea, Ui};
use engine::scene::look::Section;
use engine::session::Document;

use crate::context::{Action, Context, material_names};
use crate::graph::{GraphItem, GraphView};
use crate::history::{Snapshots, history};
use crate::library::{add_menu, show_dragged};
use crate::model::Model;
use crate::preview::Previews;
use crate::rename::{Renaming, rename};
use crate::scene_view::{Placing, SceneView};
use crate::widgets::{self, Browser, FileDialogs, ImageSlot};
use crate::{Textures, lamps, light, list, node, view};

/// Of more nodes than this only the names are shown at first.
const MAX_OPEN: usize = 12;

/// Room that undo, history and snapshots take in a row.
const HISTORY_WIDTH: f32 = 320.0;
/// Of these the snapshots with their word.
const SNAPSHOTS_WIDTH: f32 = 160.0;

/// How a material is shown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Form {
    /// As rows of widgets.
    #[default]
    List,
    /// As a graph, with the widgets of the selected node below.
    Graph,
    /// As rows of widgets here, and as a graph in a panel of its own: see [`TexturesPanel::show_graph`].
    Both,
}

/// The textures panel.
#[derive(Debug, Default)]
pub struct TexturesPanel {
    material: Option<String>,
    form: Form,
    /// Why the last edit was refused.
    message: Option<String>,
    model: Option<Rc<Model>>,
    images: ImageSlot,
    browser: Browser,
    previews: Option<Previews>,
    graph: GraphView,
    /// A node that is to be seen in the list.
    wanted: Option<String>,
    /// What is looked for among the textures.
    search: String,
    snapshots: Snapshots,
    /// A light that a click is to place.
    placing: Option<(String, Placing)>,
}

/// What of the panel is shown beside the look.
struct Parts<'a> {
    material: Option<&'a str>,
    search: &'a mut String,
    graph: &'a mut GraphView,
}

impl TexturesPanel {
    /// Shows a material, as when it was clicked in the picture.
    pub fn pick(&mut self, material: &str) {
        self.material = Some(material.to_owned());
    }

    /// The material that is shown.
    pub fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    /// Why the last edit was refused, if it was.
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Shows pictures of nodes from now on.
    pub fn set_previews(&mut self, previews: Previews) {
        self.previews = Some(previews);
    }

    /// Has fields of files ask that system from now on.
    pub fn set_file_dialogs(&mut self, system: Arc<dyn FileDialogs>) {
        self.browser.set_system(system);
    }

    /// The form in which the material is shown.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Shows the material in another form.
    pub fn set_form(&mut self, form: Form) {
        self.form = form;
    }

    /// Where the cards of the graph stand, by their ids: to be kept until the next start.
    pub fn places(&self) -> impl Iterator<Item = (&str, [f32; 2])> {
        self.graph.places()
    }

    /// Another look is edited from now on: states of the former one are forgotten.
    pub fn forget_snapshots(&mut self) {
        self.snapshots = Snapshots::default();
    }

    /// Whether the picture as it was before the last edits is to be compared with that of a state that was kept; asked for once.
    pub fn take_comparison(&mut self) -> bool {
        std::mem::take(&mut self.snapshots.compares)
    }

    /// Whether the slot of an image has taken a file that was dropped; asked for once.
    pub fn take_dropped(&mut self) -> bool {
        self.images.take_dropped()
    }

    /// The light that is to be placed by the next click into the picture; asked for once.
    pub fn take_placing(&mut self) -> Option<(String, Placing)> {
        self.placing.take()
    }

    /// Puts the cards of the graph where they were.
    pub fn set_places(&mut self, places: impl IntoIterator<Item = (String, [f32; 2])>) {
        self.graph.set_places(places);
    }

    /// Shows the panel. Edits are made in `document`; [`Document::take_changes`] tells the renderer.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        document: &mut Document,
        textures: &Textures,
        scene: SceneView<'_>,
    ) {
        shortcuts(ui, document);
        let form = self.form;
        self.head(ui, document, scene);
        if self.form != form {
            // It may get another width, which a graph is to fit.
            ui.ctx().request_repaint();
        }
        let wanted = self.wanted.take();
        self.with_context(document, textures, scene, wanted, |cx, parts| match form {
            Form::List | Form::Both => {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    list_form(ui, cx, parts.material, parts.search);
                    light::occlusion(ui, cx);
                    light::environment(ui, cx);
                    lamps::lights(ui, cx);
                    view::view(ui, cx);
                });
            }
            Form::Graph => {
                let family = cx.family(parts.material);
                graph_form(ui, cx, &family, parts.graph);
            }
        });
        show_dragged(ui);
        let refusal = self.browser.take_refusal();
        self.message = refusal.or(self.message.take());
        end_group(ui, document);
    }

    /// Shows the graph alone, for a panel of its own; [`Self::show`] has the rest.
    pub fn show_graph(
        &mut self,
        ui: &mut Ui,
        document: &mut Document,
        textures: &Textures,
        scene: SceneView<'_>,
    ) {
        self.with_context(document, textures, scene, None, |cx, parts| {
            let family = cx.family(parts.material);
            let graph = parts.graph;
            let before = graph.selected().map(str::to_owned);
            graph.show(ui, cx, &family);
            // Its values are in the list.
            if let Some(node) = graph.selected().map(str::to_owned)
                && before.as_ref() != Some(&node)
            {
                cx.show_node(&node);
            }
        });
        end_group(ui, document);
    }

    /// Shows something of the look, and makes the edits that come of it.
    fn with_context(
        &mut self,
        document: &mut Document,
        textures: &Textures,
        scene: SceneView<'_>,
        wanted: Option<String>,
        show: impl FnOnce(&mut Context<'_>, Parts<'_>),
    ) {
        let model = self.model(document, textures);
        let names = material_names(document, scene);
        let mut cx = Context {
            document,
            model: &model,
            textures,
            scene,
            names: &names,
            images: &mut self.images,
            browser: &mut self.browser,
            previews: self.previews.as_mut(),
            wanted,
            actions: Vec::new(),
        };
        let parts = Parts {
            material: self.material.as_deref(),
            search: &mut self.search,
            graph: &mut self.graph,
        };
        show(&mut cx, parts);
        for action in cx.actions {
            self.make(document, action);
        }
    }

    fn model(&mut self, document: &Document, textures: &Textures) -> Rc<Model> {
        let library = &textures.library;
        let model = match self.model.take() {
            Some(model) if model.is_of(document, library) => model,
            Some(model) => Rc::new(model.renewed(document, library)),
            None => Rc::new(Model::new(document, library)),
        };
        self.model = Some(Rc::clone(&model));
        model
    }

    fn make(&mut self, document: &mut Document, action: Action) {
        match action {
            Action::Edit {
                label,
                edits,
                group,
            } => self.message = document.apply(&label, &edits, group).err(),
            Action::Rename(renaming) => self.rename(document, &renaming),
            Action::Show(node) => {
                self.graph.select(&node);
                self.wanted = Some(node);
            }
            Action::ShowMaterial(material) => self.pick(&material),
            Action::PlaceLight(light, placing) => self.placing = Some((light, placing)),
            Action::Refused(why) => self.message = Some(why),
        }
    }

    /// What is shown of it goes on being shown.
    fn rename(&mut self, document: &mut Document, renaming: &Renaming) {
        self.message = rename(document, renaming).err();
        if self.message.is_some() {
            return;
        }
        let (old, new) = (renaming.old_name(), renaming.name.as_str());
        match renaming.section {
            Section::Node(_) => self
                .graph
                .rename(GraphItem::Node(old), GraphItem::Node(new)),
            Section::Frame(_) => {}
            _ => (self.graph).rename(GraphItem::Material(old), GraphItem::Material(new)),
        }
        if matches!(renaming.section, Section::Material(_)) && self.material() == Some(old) {
            self.pick(new);
        }
    }

    /// Which material, in which form, and back and forth in the history.
    fn head(&mut self, ui: &mut Ui, document: &mut Document, scene: SceneView<'_>) {
        ui.horizontal_wrapped(|ui| {
            let names = material_names(document, scene);
            // There is none any more where a rename was undone, or another scene opened.
            let is_there = (self.material.as_ref()).is_some_and(|name| names.contains(name));
            if !is_there && !names.is_empty() {
                self.material = names.first().cloned();
            }
            let words: Vec<&str> = names.iter().map(String::as_str).collect();
            let shown = self.material.as_deref().unwrap_or("no material");
            if let Some(picked) = widgets::choice(ui, "Material", shown, &words).value {
                self.material = Some(picked);
            }
            for (form, text, hint) in [
                (Form::List, "List", "as rows of values"),
                (Form::Graph, "Graph", "as cards with links, here"),
                (
                    Form::Both,
                    "Both",
                    "the rows here, the cards below the picture",
                ),
            ] {
                let choice = ui.selectable_value(&mut self.form, form, text);
                choice.on_hover_text(hint);
            }
            // What goes back and forth stays together, in a row of its own where there is no room for all of it.
            match ui.available_size_before_wrap().x < HISTORY_WIDTH {
                true => ui.end_row(),
                false => drop(ui.separator()),
            }
            let undo = history_button(ui, "Undo", document.undo_label());
            let redo = history_button(ui, "Redo", document.redo_label());
            if undo {
                document.undo();
            }
            if redo {
                document.redo();
            }
            let went = history(ui, document);
            if undo || redo || went {
                self.message = None;
            }
            // What the letters are is told when the pointer rests on them, too.
            if ui.available_size_before_wrap().x >= SNAPSHOTS_WIDTH {
                ui.weak("Snapshots");
            }
            let refused = self.snapshots.show(ui, document);
            self.message = refused.or(self.message.take());
        });
        let mut is_read = false;
        if let Some(message) = &self.message {
            ui.horizontal_wrapped(|ui| {
                ui.colored_label(ui.visuals().error_fg_color, message);
                is_read = ui.small_button("×").clicked();
            });
        }
        if is_read {
            self.message = None;
        }
        ui.separator();
    }
}

fn history_button(ui: &mut Ui, text: &str, label: Option<&str>) -> bool {
    let button = ui.add_enabled(label.is_some(), egui::Button::new(text));
    let clicked = button.clicked();
    if let Some(label) = label {
        button.on_hover_text(label);
    }
    clicked
}

/// Undo and redo by keys, unless a text is being written, which has an undo of its own, or a question lies over the panel.
fn shortcuts(ui: &mut Ui, document: &mut Document) {
    let layer = ui.layer_id();
    if ui.text_edit_focused() || !ui.memory(|memory| memory.allows_interaction(layer)) {
        return;
    }
    let again = Modifiers::COMMAND | Modifiers::SHIFT;
    let pressed = |modifiers, key| ui.input_mut(|input| input.consume_key(modifiers, key));
    if pressed(again, Key::Z) || pressed(Modifiers::COMMAND, Key::Y) {
        document.redo();
    } else if pressed(Modifiers::COMMAND, Key::Z) {
        document.undo();
    }
}

/// A drag ends where the button is let go, and what a key does that is held where that is: what comes later is a step of its own. Fields of
/// a popup, as those of a colour, change the value letter by letter, which is one step.
fn end_group(ui: &Ui, document: &mut Document) {
    let (is_released, is_held) = ui.input(|input| {
        let is_held = input.pointer.any_down() || !input.keys_down.is_empty();
        (input.pointer.any_released(), is_held)
    });
    let is_typed = Popup::is_any_open(ui.ctx()) && ui.text_edit_focused();
    if is_released || !is_held && !is_typed {
        document.end_group();
    }
}

/// A material with all that it is made of, and what no material needs.
fn list_form(ui: &mut Ui, cx: &mut Context<'_>, material: Option<&str>, search: &mut String) {
    let model = cx.model;
    let family = cx.family(material);
    list::materials(ui, cx, material);
    for material in &family {
        list::material(ui, cx, material);
    }
    let nodes = model.nodes_of(&family);
    let is_open = nodes.len() <= MAX_OPEN;
    for node in nodes {
        node::node(ui, cx, &node, is_open);
    }
    let loose = model.loose_nodes(cx.document.look());
    if !loose.is_empty() {
        ui.weak("Nodes that no material needs");
        for node in loose {
            node::node(ui, cx, &node, is_open);
        }
    }
    let add = widgets::menu(ui, "Add a node…", |ui| add_menu(ui, cx, search));
    widgets::name(&add.response, "Add a node");
}

/// The graph, and below it the widgets of the node that is selected.
fn graph_form(ui: &mut Ui, cx: &mut Context<'_>, family: &[&str], graph: &mut GraphView) {
    // Always of the same size: a graph that is scaled by a click on it can't be worked with.
    let height = (0.6 * ui.available_height()).max(100.0);
    let size = egui::vec2(ui.available_width(), height);
    let layout = *ui.layout();
    ui.allocate_ui_with_layout(size, layout, |ui| graph.show(ui, cx, family));
    ui.separator();
    let Some(node) = graph.selected().map(str::to_owned) else {
        ui.weak("Click on a node to see its values here.");
        return;
    };
    ScrollArea::vertical()
        .auto_shrink(false)
        .show(ui, |ui| node::node(ui, cx, &node, true));
}
