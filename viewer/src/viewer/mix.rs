//! The panel by which lights are mixed: a fader for each group. What is mixed is what is shown; the look stays as it is.

use std::collections::BTreeMap;
use std::sync::Arc;

use egui::{RichText, ScrollArea, Slider, Ui};
use engine::film::LightMix;
use engine::scene::UNGROUPED;
use patina_panels::asks_for_menu;

use crate::link::Command;

use super::{Viewer, call};

/// The greatest strength of a slider.
const STRONGEST: f32 = 8.0;
/// The least one that isn't 0.
const WEAKEST: f64 = 0.01;
/// Points beside a slider, for its number.
const NUMBER: f32 = 70.0;
const LEAST_SLIDER: f32 = 80.0;

/// How the light of one group is shown.
#[derive(Debug, Clone, PartialEq)]
struct Fader {
    is_on: bool,
    /// All that aren't alone are off while any is.
    is_alone: bool,
    strength: f32,
    /// Linear Rec.709.
    tint: [f32; 3],
}

impl Default for Fader {
    fn default() -> Self {
        Self {
            is_on: true,
            is_alone: false,
            strength: 1.0,
            tint: [1.0; 3],
        }
    }
}

/// The faders, and what the render knows of them.
#[derive(Debug, Default)]
pub(super) struct LightMixer {
    pub(super) is_open: bool,
    /// Lights are kept apart from then on, until other files are opened.
    was_open: bool,
    /// By the name of the group.
    faders: BTreeMap<String, Fader>,
    /// `None` where the render may know anything.
    sent: Option<Option<LightMix>>,
}

impl LightMixer {
    /// Whether anything is shown otherwise than it is rendered.
    fn is_neutral(&self, groups: &[String]) -> bool {
        let neutral = Fader::default();
        let fader = |group| self.faders.get(group).unwrap_or(&neutral);
        names(groups).all(|group| *fader(group) == neutral)
    }

    /// What the light of each group is multiplied by.
    fn mix(&self, groups: &[String]) -> LightMix {
        let mut mix = LightMix::default();
        for (group, factor) in self.factors(groups) {
            mix.set(&group, factor);
        }
        mix
    }

    /// The same, by the names of the groups.
    fn factors(&self, groups: &[String]) -> Vec<(String, [f32; 3])> {
        let neutral = Fader::default();
        let fader = |group: &str| self.faders.get(group).unwrap_or(&neutral);
        let is_any_alone = names(groups).any(|group| fader(group).is_alone);
        let factor = |group: &str| {
            let fader = fader(group);
            let shines = fader.is_on && (fader.is_alone || !is_any_alone);
            let strength = if shines { fader.strength } else { 0.0 };
            fader.tint.map(|tint| tint * strength)
        };
        names(groups)
            .map(|group| (group.to_owned(), factor(group)))
            .collect()
    }
}

/// Those of the look, and what is in none.
fn names(groups: &[String]) -> impl Iterator<Item = &str> {
    groups.iter().map(String::as_str).chain([UNGROUPED])
}

impl Viewer {
    pub(super) fn mix_tool(&mut self, ui: &mut Ui) {
        let mut is_open = self.mixer.is_open;
        let toggle = ui.toggle_value(&mut is_open, "Light mix");
        let hint = "dim, tint and turn off groups of lights without rendering again (L)";
        if toggle.on_hover_text(hint).changed() {
            self.toggle_mix();
        }
    }

    pub(super) fn toggle_mix(&mut self) {
        self.mixer.is_open ^= true;
        self.lists_shortcuts &= !self.mixer.is_open;
    }

    /// Whether lights are shown otherwise than they are rendered.
    pub(super) fn mixes_lights(&self) -> bool {
        self.mixer.was_open && !self.mixer.is_neutral(&self.scene.light_groups)
    }

    /// Whether that can't be seen by the panel.
    pub(super) fn mixes_unseen(&self) -> bool {
        self.mixes_lights() && (!self.mixer.is_open || self.lists_shortcuts)
    }

    /// Other files are shown: their groups are others.
    pub(super) fn forget_mix(&mut self) {
        let is_open = self.mixer.is_open;
        self.mixer = LightMixer {
            is_open,
            ..LightMixer::default()
        };
    }

    /// Tells the render what it doesn't know.
    pub(super) fn send_mix(&mut self) {
        let groups = &self.scene.light_groups;
        let mixer = &mut self.mixer;
        mixer.was_open |= mixer.is_open && !groups.is_empty();
        let wanted = (mixer.was_open && !groups.is_empty()).then(|| mixer.mix(groups));
        if mixer.sent.as_ref() != Some(&wanted) {
            mixer.sent = Some(wanted.clone());
            self.link.send(Command::MixLights(wanted));
        }
    }

    /// In place of the panel of the look, as the list of keys: the picture keeps its size.
    pub(super) fn mix_panel(&mut self, ui: &mut Ui) {
        let scene = Arc::clone(&self.scene);
        let groups = &scene.light_groups;
        ui.horizontal(|ui| {
            ui.heading("Light mix");
            let reset = egui::Button::new("Reset");
            let is_neutral = self.mixer.is_neutral(groups);
            let reset = ui.add_enabled(!is_neutral, reset);
            if reset.on_hover_text("all lights as they are").clicked() {
                self.mixer.faders.clear();
            }
            self.lights_button(ui, groups);
            if ui.button("Close").on_hover_text("L").clicked() {
                self.mixer.is_open = false;
            }
        });
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            if groups.is_empty() {
                return how_to(ui);
            }
            if !self.status.keeps_groups {
                ui.label("The picture begins once more, to keep the groups apart.");
            }
            for group in names(groups) {
                ui.separator();
                let fader = self.mixer.faders.entry(group.to_owned()).or_default();
                fader_of(ui, group, fader);
            }
            ui.separator();
            ui.weak("Mixed is what is shown, and what is saved as .png or .jpg. The look stays as it is.");
        });
    }
}

impl Viewer {
    /// Makes the mix that of the lights themselves, as one step of the look.
    fn lights_button(&mut self, ui: &mut Ui, groups: &[String]) {
        let edits = match self.mixer.is_neutral(groups) {
            true => Err("no light is mixed".to_owned()),
            false => self.relit(&self.mixer.factors(groups)),
        };
        let button = egui::Button::new("To the lights");
        let button = ui.add_enabled(edits.is_ok(), button);
        let hint = "writes the mix into the look, as what its lights, materials and environment give, and resets the faders";
        let button = button.on_hover_text(hint);
        match edits {
            Ok(edits) if button.clicked() => {
                let now = ui.input(|input| input.time);
                self.edit("light mix", &edits, now);
                self.mixer.faders.clear();
            }
            Ok(_) => {}
            Err(why) => drop(button.on_disabled_hover_text(why)),
        }
    }
}

fn fader_of(ui: &mut Ui, group: &str, fader: &mut Fader) {
    ui.horizontal(|ui| {
        let name = RichText::new(group).strong();
        let on = ui.checkbox(&mut fader.is_on, name);
        on.on_hover_text(match group == UNGROUPED {
            true => "all lights that are in no group",
            false => "on or off",
        });
        let alone = ui.toggle_value(&mut fader.is_alone, "Solo");
        call(&alone, &format!("Solo {group}"));
        alone.on_hover_text("those alone; several may be");
        let tint = ui.color_edit_button_rgb(&mut fader.tint);
        call(&tint, &format!("Tint of {group}"));
        if tint.secondary_clicked() || asks_for_menu(&tint) {
            fader.tint = [1.0; 3];
        }
        tint.on_hover_text("multiplies the light's colour; right-click for white");
    });
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER).max(LEAST_SLIDER);
    let slider = Slider::new(&mut fader.strength, 0.0..=STRONGEST)
        .logarithmic(true)
        .smallest_positive(WEAKEST)
        .max_decimals(3)
        .suffix(" x");
    let strength = ui.add(slider);
    call(&strength, &format!("Strength of {group}"));
    if strength.secondary_clicked() || asks_for_menu(&strength) {
        fader.strength = 1.0;
    }
    strength.on_hover_text("times as strong as it is rendered; right-click for 1");
}

/// What there is to do where no light is in any group.
fn how_to(ui: &mut Ui) {
    ui.label("No light is in a group yet. The look puts lights into groups by a name:");
    for example in [
        "[light.Spot]\ngroup = \"key\"",
        "[material.Screen]\ngroup = \"screen\"",
        "environment = { ..., group = \"day\" }",
    ] {
        ui.add_space(4.0);
        ui.label(RichText::new(example).monospace());
    }
    ui.add_space(4.0);
    ui.label("Each has a fader here then.");
}

#[cfg(test)]
mod tests {
    use engine::scene::{LightGroups, LightSource};

    use super::*;

    const GROUPS: [&str; 2] = ["key", "fill"];

    /// What comes of some faders: factors, or nothing where all is as it is.
    fn mix(faders: &[(&str, Fader)]) -> Option<engine::film::GroupFactors> {
        let mixer = LightMixer {
            faders: faders
                .iter()
                .cloned()
                .map(|(name, fader)| (name.to_owned(), fader))
                .collect(),
            ..LightMixer::default()
        };
        let groups = GROUPS.map(str::to_owned);
        let factors = mixer.mix(&groups).of(&light_groups());
        assert!(factors.is_none() || !mixer.is_neutral(&groups));
        factors
    }

    fn factors(factors: [[f32; 3]; 3]) -> Option<engine::film::GroupFactors> {
        let mut mix = LightMix::default();
        for (name, factor) in ["key", "fill", UNGROUPED].into_iter().zip(factors) {
            mix.set(name, factor);
        }
        mix.of(&light_groups())
    }

    fn light_groups() -> LightGroups {
        let mut groups = LightGroups::default();
        for name in GROUPS {
            let source = LightSource::Light(name);
            groups.assign(source, name).expect("room");
        }
        groups
    }

    #[test]
    fn faders_make_factors() {
        let (on, dark) = ([1.0; 3], [0.0; 3]);
        let neutral = Fader::default();
        assert_eq!(mix(&[]), None);
        assert_eq!(mix(&[("key", neutral.clone())]), None);
        let off = Fader {
            is_on: false,
            ..Fader::default()
        };
        assert_eq!(mix(&[("key", off.clone())]), factors([dark, on, on]));
        let alone = Fader {
            is_alone: true,
            strength: 2.0,
            tint: [1.0, 0.5, 0.0],
            ..Fader::default()
        };
        let warm = [2.0, 1.0, 0.0];
        assert_eq!(mix(&[("key", alone.clone())]), factors([warm, dark, dark]));
        let both = [("key", alone.clone()), ("rest", alone.clone())];
        assert_eq!(mix(&both), factors([warm, dark, warm]));
        // What is off is off.
        let silent = Fader {
            is_on: false,
            ..alone
        };
        assert_eq!(mix(&[("key", silent)]), factors([dark; 3]));
        // A group that there was once counts no more.
        assert_eq!(mix(&[("gone", off)]), None);
    }
}
