//! What the thread puts on the board: the picture, its figures, the scene.

use std::sync::Arc;
use std::time::{Duration, Instant};

use engine::display::{Display, DisplaySettings};
use engine::load::LoadError;
use engine::renderer::RenderError;
use engine::scene::LightKind;
use engine::scene::look::LookError;
use engine::session::SessionError;
use engine::stats::Doubt;
use patina_panels::Textures;

use crate::link::{Files, LookFacts, Reply, SceneFacts, Shown, lock};

use super::{Displays, Render};

/// How often figures are brought up to date.
const FIGURES: Duration = Duration::from_millis(400);

/// What is on the board already.
#[derive(Default)]
pub(super) struct Published {
    textures: [Option<wgpu::Texture>; 2],
    number: u64,
    figures: Option<Figures>,
    problems: Option<String>,
    /// Of the picture, that were told.
    doubts: Vec<Doubt>,
    error: Option<f64>,
    is_unsaved: bool,
    textures_there: Option<Arc<Textures>>,
}

/// Figures grow over the life of a renderer; rates are those of the last while.
struct Figures {
    at: Instant,
    generation: u64,
    samples: u64,
    rays: u64,
    seconds: f64,
}

impl Published {
    /// Textures have changed, or may be others.
    pub(super) fn forget_textures(&mut self) {
        self.textures_there = None;
    }

    pub(super) fn forget(&mut self) {
        self.forget_textures();
        self.figures = None;
        self.problems = None;
        self.doubts.clear();
        self.error = None;
    }
}

impl Render {
    /// Shows the film as it is.
    pub(super) fn show(&mut self) -> Result<(), SessionError> {
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let displays = match &mut self.display {
            Some(displays) => displays,
            none => none.insert(Displays {
                now: Display::new(&self.device).map_err(RenderError::from)?,
                before: Display::new(&self.device).map_err(RenderError::from)?,
            }),
        };
        let film = session.device_film(self.settings.channel.needs_guides())?;
        let pixels = u64::from(film.width) * u64::from(film.height);
        let spp = self.run.samples_done as f64 / pixels as f64;
        let camera = session.shown_camera();
        let settings = DisplaySettings {
            distance_scale: camera.focus_distance,
            most_samples: spp.ceil() as u32,
            ..self.settings
        };
        let size = [film.width, film.height];
        let now = displays.now.show(&film, &settings);
        let now = now.map_err(RenderError::from)?.texture().cloned();
        let before = match &self.before {
            Some(before) => {
                let shown = displays.before.show(before, &settings);
                shown.map_err(RenderError::from)?.texture().cloned()
            }
            None => None,
        };
        self.run.last_shown = Instant::now();
        // The window draws with the device that renders.
        let Some(now) = now else {
            return Ok(());
        };
        let textures = [Some(now.clone()), before.clone()];
        if textures != self.published.textures {
            self.published.textures = textures;
            self.published.number += 1;
        }
        let view =
            |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let number = self.published.number;
        let mut board = lock(&self.board);
        if board
            .shown
            .as_ref()
            .is_none_or(|shown| shown.texture_number != number)
        {
            board.shown = Some(Shown {
                view: view(&now),
                size,
                before: before.as_ref().map(view),
                texture_number: number,
            });
        }
        board.status.spp = spp;
        board.status.size = size;
        Ok(())
    }

    /// Figures, when it is time for them.
    pub(super) fn publish_status(&mut self, now: bool) {
        let is_due = match &self.published.figures {
            Some(figures) => now || figures.at.elapsed() >= FIGURES,
            None => true,
        };
        let Some(session) = self.session.as_ref().filter(|_| is_due) else {
            return;
        };
        let Ok(stats) = session.stats() else {
            // The next step finds out why.
            return;
        };
        if self.run.is_seen
            && let Some(displays) = &self.display
        {
            self.published.error = displays.now.relative_error().ok().flatten();
        }
        let figures = Figures {
            at: Instant::now(),
            generation: self.run.generation,
            samples: self.run.samples_done,
            rays: stats.rays,
            seconds: stats.seconds,
        };
        let problems = session.problems();
        let text = problems.render();
        let is_unsaved = session.has_unsaved_edits();
        let doubts = stats.doubts();
        let lines: Vec<String> = doubts.iter().map(Doubt::to_string).collect();
        let told = &mut self.published.doubts;
        let is_new = |doubt: &Doubt| !told.iter().any(|other| other.is_same(doubt));
        let new: Vec<Doubt> = doubts.into_iter().filter(is_new).collect();
        let mut board = lock(&self.board);
        let tell = new.iter().map(|doubt| Reply::Failed(doubt.to_string()));
        board.replies.extend(tell);
        told.extend(new);
        let status = &mut board.status;
        status.doubts = lines.join("\n");
        if let Some(last) = &self.published.figures {
            let seconds = figures.seconds - last.seconds;
            let is_same = figures.generation == last.generation && seconds > 0.0;
            if is_same && figures.rays >= last.rays {
                let rate = |now: u64, then: u64| now.saturating_sub(then) as f64 / seconds;
                status.samples_per_second = rate(figures.samples, last.samples);
                status.mrays_per_second = rate(figures.rays, last.rays) * 1e-6;
            }
        }
        status.target = self.options.target_spp;
        status.passes = match stats.timestamps && self.times_passes {
            true => stats.passes,
            false => Vec::new(),
        };
        status.memory = stats.memory.iter().map(|(_, bytes)| bytes).sum();
        status.error = self.published.error;
        status.pipelines = stats.pipelines_created;
        status.shader_modules = stats.shader_modules_created;
        status.is_building = session.is_building();
        status.is_paused = self.is_paused;
        status.has_unsaved_edits = is_unsaved;
        status.warnings = session.warnings().render();
        // While something is built it may turn out otherwise.
        if !status.is_building {
            status.problems.clone_from(&text);
        }
        drop(board);
        let is_news = self.published.problems.as_ref() != Some(&text)
            || self.published.is_unsaved != is_unsaved
            || now;
        (self.published.problems, self.published.is_unsaved) = (Some(text), is_unsaved);
        self.published.figures = Some(figures);
        if is_news || !self.run.is_done {
            (self.wake)();
        }
    }

    pub(super) fn publish_loading(&self, is_loading: bool) {
        lock(&self.board).status.is_loading = is_loading;
        (self.wake)();
    }

    /// The look, its materials, and the textures that it may use.
    pub(super) fn publish_look(&mut self) {
        let Some(session) = &self.session else {
            return;
        };
        let textures = match &self.published.textures_there {
            Some(textures) => Arc::clone(textures),
            None => {
                let sources = session.textures();
                // A folder that can't be read is a problem of the render, which tells it.
                Arc::new(sources.map_or_else(|_| Textures::default(), |s| Textures::load(&s)))
            }
        };
        self.published.textures_there = Some(Arc::clone(&textures));
        let is_sun = |kind| matches!(kind, LightKind::Directional | LightKind::Disk { .. });
        let suns = session
            .scene()
            .lights
            .iter()
            .filter(|light| is_sun(light.kind));
        lock(&self.board).look = Some(LookFacts {
            text: session.look_text().into(),
            heard: self.pending.number,
            materials: Arc::new(session.scene().materials.clone()),
            own_materials: session.procedural().scene_materials(),
            suns: suns.map(|light| light.name.clone()).collect(),
            textures,
        });
    }

    /// What is known of the scene.
    pub(super) fn publish_scene(&mut self) {
        self.publish_look();
        let Some(session) = &self.session else {
            return;
        };
        let (scene, inputs) = (session.scene(), session.inputs());
        let facts = SceneFacts {
            files: Files {
                scene: inputs.scene.clone(),
                look: inputs.look.clone(),
                camera: inputs.camera.clone(),
            },
            cameras: scene.cameras.clone(),
            look_camera: Some(session.look_camera().clone()),
        };
        lock(&self.board).scene = Arc::new(facts);
    }
}

/// An error with places, where it has any.
pub(super) fn message(error: &SessionError) -> String {
    match error {
        SessionError::Load(LoadError::Look(LookError::Invalid(problems))) => problems.render(),
        other => other.to_string(),
    }
}
