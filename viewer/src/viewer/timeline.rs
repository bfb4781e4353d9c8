//! The bar of time of a scene that moves.

use egui::{Slider, Ui};

use crate::link::Command;

use super::{Viewer, call};

/// Longest step of time between two pictures, seconds: a picture that took longer is not made up for.
const LONGEST_STEP: f64 = 0.5;

/// Which moment is shown.
#[derive(Debug, Default)]
pub(super) struct Timeline {
    /// Seconds; `None` while the scene is at rest.
    seconds: Option<f64>,
    /// Time goes on by itself, since then.
    playing: Option<f64>,
}

impl Timeline {
    /// A moment that stays.
    pub(super) fn at(seconds: Option<f64>) -> Self {
        Self {
            seconds,
            playing: None,
        }
    }
}

impl Viewer {
    /// Time as a slider, where an animation lasts so long.
    pub(super) fn timeline(&mut self, ui: &mut Ui, end: f64, now: f64) {
        let former = self.timeline.seconds;
        ui.horizontal(|ui| {
            let mut plays = self.timeline.playing.is_some();
            let play = ui.toggle_value(&mut plays, "Play");
            let hint = "time goes on, picture by picture, as fast as they come";
            if play.on_hover_text(hint).changed() {
                self.timeline.playing = plays.then_some(now);
            }
            let rest = ui.add_enabled(former.is_some(), egui::Button::new("At rest"));
            let hint = "as the file has it without its animations";
            if rest.on_hover_text(hint).clicked() {
                self.timeline = Timeline::default();
            }
            let mut seconds = self.timeline.seconds.unwrap_or(0.0);
            ui.spacing_mut().slider_width = (ui.available_width() - 90.0).max(60.0);
            let slider = Slider::new(&mut seconds, 0.0..=end)
                .fixed_decimals(2)
                .suffix(" s");
            let slider = ui.add(slider);
            call(&slider, "Time");
            if slider.changed() {
                self.timeline.seconds = Some(seconds);
            }
        });
        self.play(end, now);
        if self.timeline.seconds != former {
            self.link.send(Command::Moment(self.timeline.seconds));
        }
    }

    /// Goes on once the moment that was wanted last has been seen.
    fn play(&mut self, end: f64, now: f64) {
        let Some(since) = self.timeline.playing else {
            return;
        };
        let seconds = self.timeline.seconds;
        if seconds.is_some() && self.status.moment != seconds {
            return;
        }
        let step = (now - since).clamp(0.0, LONGEST_STEP);
        let next = seconds.map_or(0.0, |seconds| seconds + step);
        self.timeline.seconds = Some(if next > end { 0.0 } else { next });
        self.timeline.playing = Some(now);
    }
}
