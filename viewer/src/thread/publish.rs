//! What the thread puts on the board: the picture, its figures, the scene.

use std::sync::Arc;
use std::time::{Duration, Instant};

use engine::display::{Channel, DeviceFilm, Display, DisplaySettings};
use engine::load::LoadError;
use engine::renderer::RenderError;
use engine::scene::look::LookError;
use engine::scene::{Moment, Motion};
use engine::session::SessionError;
use engine::stats::Doubt;
use patina_panels::{ModelImage, Textures};

use crate::link::{Files, LookFacts, Reply, SceneFacts, Shown, lock};

use super::mix::Place;
use super::{Displays, Render, lock_size};

/// How often figures are brought up to date.
const FIGURES: Duration = Duration::from_millis(400);

/// Most pixels of the whole picture along a side per pixel of one that has a line around what was picked.
const FINE: u32 = 2;

/// What is on the board already.
#[derive(Default)]
pub(super) struct Published {
    pictures: crate::picture::Published,
    figures: Option<Figures>,
    state: Option<State>,
    /// Of the picture, that were told.
    doubts: Vec<Doubt>,
    error: Option<f64>,
    /// The generation that it is of.
    error_of: u64,
    /// The picture that the error is of, by generation and camera paths.
    counted: Option<(u64, u64)>,
    textures_there: Option<Arc<Textures>>,
    /// Small pictures of the model's images.
    images_there: Option<Arc<[ModelImage]>>,
}

/// Figures grow over the life of a renderer; rates are those of the last while.
struct Figures {
    at: Instant,
    /// Number of the picture, its camera paths, and whether they have been shown.
    of: (u64, u64, bool),
    rays: u64,
    seconds: f64,
}

/// What is told when it changes.
#[derive(PartialEq)]
struct State {
    problems: String,
    warnings: String,
    is_unsaved: bool,
    is_building: bool,
    is_paused: bool,
    is_whole: bool,
    is_rendering: bool,
}

impl Published {
    /// Relative error of the picture of a generation, if it has been estimated.
    pub(super) fn error_of(&self, generation: u64) -> Option<f64> {
        self.error.filter(|_| self.error_of == generation)
    }

    /// Textures have changed, or may be others.
    pub(super) fn forget_textures(&mut self) {
        self.textures_there = None;
    }

    pub(super) fn forget(&mut self) {
        self.forget_textures();
        self.images_there = None;
        self.figures = None;
        self.state = None;
        self.doubts.clear();
        self.error = None;
        self.counted = None;
    }
}

impl Render {
    /// Samples per pixel of the picture.
    pub(super) fn spp(&self) -> f64 {
        let [width, height] = self.picture_size().map(f64::from);
        self.run.samples_done as f64 / (width * height)
    }

    /// Shows the film as it is, or with its lights mixed, or without its noise.
    pub(super) fn show(&mut self) -> Result<(), SessionError> {
        let version = self.version();
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let displays = match &mut self.display {
            Some(displays) => displays,
            none => none.insert(Displays {
                now: Display::new(&self.device).map_err(RenderError::from)?,
                other: None,
                before: Display::new(&self.device).map_err(RenderError::from)?,
                beside: Display::new(&self.device).map_err(RenderError::from)?,
            }),
        };
        // Guides take as long as a sample, which a picture in motion has not; and a line of large pixels hides what it is around.
        let is_fine = !self.is_moving && self.divisor <= FINE;
        let outlined = self.outlined.as_ref().filter(|_| is_fine);
        let outlined = outlined.and_then(|name| {
            let mut materials = session.scene().materials.iter();
            materials.position(|material| material.name == *name)
        });
        let outlined = outlined.map(|place| place as u32);
        let guides = self.settings.channel.needs_guides();
        let film = session.device_film(guides || outlined.is_some())?;
        let spp = self.run.samples_done as f64 / (f64::from(film.width) * f64::from(film.height));
        let camera = session.shown_camera();
        let settings = DisplaySettings {
            distance_scale: camera.focus_distance,
            most_samples: spp.ceil() as u32,
            outlined: None,
            ..self.settings
        };
        let with_line = DisplaySettings {
            outlined,
            ..settings
        };
        let size = [film.width, film.height];
        let moment = seconds(session.shown_moment());
        let is_picture = settings.channel == Channel::Radiance;
        let factors = self.mixing.factors(session.scene());
        let factors = factors.as_ref().filter(|_| is_picture);
        let show = |display: &mut Display, film: &DeviceFilm, settings: &DisplaySettings| {
            let shown = display.show(film, settings).map_err(RenderError::from)?;
            Ok::<_, SessionError>(shown.clone())
        };
        let clean = self.denoising.clean(version, size);
        let clean = clean.filter(|_| is_picture);
        let denoised = clean.map(|(_, spp)| spp);
        // Both alike, as soon as that can be.
        let kept = match &mut self.before {
            Some(before) => {
                let film = before.film(guides)?;
                let (of, size) = (before.version(), [film.width, film.height]);
                let clean = clean.and_then(|_| self.denoising.clean(of, size));
                Some(match clean {
                    Some((clean, _)) => (clean.with_guides_of(&film), None),
                    None => (film, before.factors.as_ref().filter(|_| is_picture)),
                })
            }
            None => None,
        };
        let other = match (clean, factors) {
            (Some((clean, _)), _) => Some(clean.with_guides_of(&film)),
            (None, Some(_)) => Some(self.mixing.mixed(&self.device, &film, factors)?),
            (None, None) => None,
        };
        // Of a picture that is shown otherwise it is the error alone that is wanted of the film: nothing new before the next sample.
        let counted = Some((version.generation, self.run.samples_done));
        let now = match &other {
            Some(_) if self.published.counted == counted => None,
            _ => Some(show(&mut displays.now, &film, &with_line)?),
        };
        self.published.counted = counted;
        let shown = match &other {
            Some(other) => {
                let display = match &mut displays.other {
                    Some(display) => display,
                    none => none.insert(Display::new(&self.device).map_err(RenderError::from)?),
                };
                Some(show(display, other, &with_line)?)
            }
            None => now,
        };
        // One of both is there.
        let Some(shown) = shown else {
            return Ok(());
        };
        let mut also = |place, display: &mut Display, film: Option<(&DeviceFilm, _)>| {
            let Some((film, factors)) = film else {
                return Ok(None);
            };
            let film = self.mixing.mixed_at(place, &self.device, film, factors)?;
            show(display, &film, &settings).map(Some)
        };
        let kept = kept.as_ref().map(|(film, factors)| (film, *factors));
        let before = also(Place::Before, &mut displays.before, kept)?;
        let beside = self.beside.as_ref().map(|film| (film, factors));
        let beside = also(Place::Beside, &mut displays.beside, beside)?;
        self.run.last_shown = Instant::now();
        let images = [Some(&shown), before.as_ref(), beside.as_ref()];
        let published = &mut self.published.pictures;
        let taken = published.show(images, &self.device);
        taken.map_err(RenderError::from)?;
        let number = published.number;
        let is_whole = self.region.is_none() && size == *lock_size(&self.size);
        let mut board = lock(&self.board);
        if board
            .shown
            .as_ref()
            .is_none_or(|shown| shown.number != number)
        {
            board.shown = Some(Shown {
                pictures: published.pictures.clone(),
                size,
                number,
            });
        }
        board.status.spp = spp;
        board.status.denoised = denoised;
        board.status.moment = moment;
        board.status.keeps_groups = film.has_groups();
        board.status.size = size;
        board.status.is_whole = is_whole;
        Ok(())
    }

    /// Figures, when it is time for them.
    pub(super) fn publish_status(&mut self, now: bool) {
        let is_due = match &self.published.figures {
            Some(figures) => now || figures.at.elapsed() >= FIGURES,
            None => true,
        };
        if !is_due || self.session.is_none() {
            return;
        }
        // What has been told is not measured again: a render at rest takes no time.
        let samples = (self.run.generation, self.run.samples_done, self.run.is_seen);
        let has_more = self.published.figures.as_ref().map(|figures| figures.of) != Some(samples);
        if has_more || now {
            self.publish_figures();
        }
        let is_news = self.publish_state();
        if let Some(figures) = &mut self.published.figures {
            figures.at = Instant::now();
        }
        if has_more || is_news || now {
            (self.wake)();
        }
    }

    /// What there is of the picture, and how fast it came.
    fn publish_figures(&mut self) {
        let Some(session) = &self.session else {
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
            self.published.error_of = self.run.generation;
        }
        let figures = Figures {
            at: Instant::now(),
            of: (self.run.generation, self.run.samples_done, self.run.is_seen),
            rays: stats.rays,
            seconds: stats.seconds,
        };
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
            let is_same = figures.of.0 == last.of.0 && seconds > 0.0;
            if is_same && figures.rays >= last.rays {
                let rate = |now: u64, then: u64| now.saturating_sub(then) as f64 / seconds;
                status.samples_per_second = rate(figures.of.1, last.of.1);
                status.mrays_per_second = rate(figures.rays, last.rays) * 1e-6;
            }
        }
        status.passes = match stats.timestamps && self.times_passes {
            true => stats.passes,
            false => Vec::new(),
        };
        status.memory = stats.memory.iter().map(|(_, bytes)| bytes).sum();
        status.error = self.published.error;
        status.pipelines = stats.pipelines_created;
        status.shader_modules = stats.shader_modules_created;
        self.published.figures = Some(figures);
    }

    /// What state the render is in; whether that is news.
    fn publish_state(&mut self) -> bool {
        let Some(session) = &self.session else {
            return false;
        };
        let state = State {
            problems: session.problems().render(),
            warnings: session.warnings().render(),
            is_unsaved: session.has_unsaved_edits(),
            is_building: session.is_building(),
            is_paused: self.is_paused,
            is_whole: self.is_whole(),
            is_rendering: self.is_rendering(),
        };
        let mut board = lock(&self.board);
        let status = &mut board.status;
        status.target = self.options.target_spp;
        status.is_whole = state.is_whole;
        status.is_building = state.is_building;
        status.is_paused = state.is_paused;
        status.has_unsaved_edits = state.is_unsaved;
        status.warnings.clone_from(&state.warnings);
        if !state.is_rendering {
            (status.samples_per_second, status.mrays_per_second) = (0.0, 0.0);
        }
        // While something is built it may turn out otherwise.
        if !status.is_building {
            status.problems.clone_from(&state.problems);
        }
        drop(board);
        let former = self.published.state.take();
        let told = former.as_ref().map_or("", |former| &former.problems);
        if !state.problems.is_empty() && state.problems != told {
            // A file that isn't there mends them when it comes.
            self.watch();
        }
        let is_news = former.as_ref() != Some(&state);
        self.published.state = Some(state);
        is_news
    }

    pub(super) fn publish_loading(&self, is_loading: bool) {
        lock(&self.board).status.is_loading = is_loading;
        (self.wake)();
    }

    /// The look, its materials, and the textures that it may use.
    pub(super) fn publish_look(&mut self) {
        if let Some(facts) = self.look_facts() {
            lock(&self.board).look = Some(facts);
        }
    }

    fn look_facts(&mut self) -> Option<LookFacts> {
        let session = self.session.as_ref()?;
        let textures = match &self.published.textures_there {
            Some(textures) => Arc::clone(textures),
            None => {
                let sources = session.textures();
                // A folder that can't be read is a problem of the render, which tells it.
                Arc::new(sources.map_or_else(|_| Textures::default(), |s| Textures::load(&s)))
            }
        };
        self.published.textures_there = Some(Arc::clone(&textures));
        let images = match &self.published.images_there {
            Some(images) => Arc::clone(images),
            None => session.scene().images.iter().map(ModelImage::new).collect(),
        };
        self.published.images_there = Some(Arc::clone(&images));
        Some(LookFacts {
            text: session.look_text().into(),
            saved: session.saved_text().into(),
            outside: self.outside,
            heard: self.pending.made,
            materials: Arc::new(session.scene().materials.clone()),
            has_stand_in_light: session.has_stand_in_light(),
            own_materials: session.procedural().scene_materials(),
            images,
            lights: session.scene().lights.clone().into(),
            textures,
        })
    }

    /// What is known of the scene.
    pub(super) fn publish_scene(&mut self) {
        self.published.images_there = None;
        let look = self.look_facts();
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
            end: self.end,
            light_groups: scene.light_groups.names().to_vec(),
        };
        // Together: a text that was moved makes sense beside its own path alone.
        let mut board = lock(&self.board);
        board.look = look;
        board.scene = Arc::new(facts);
    }
}

/// A moment as the bar of time has it: none while the scene is at rest.
pub(super) fn seconds(moment: &Moment) -> Option<f64> {
    (moment.motion != Motion::Rest).then_some(moment.seconds)
}

/// An error with places, where it has any.
pub(super) fn message(error: &SessionError) -> String {
    match error {
        SessionError::Load(LoadError::Look(LookError::Invalid(problems))) => problems.render(),
        other => other.to_string(),
    }
}
