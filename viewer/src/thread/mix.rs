//! Lights mixed in what is shown: the film keeps the light of each group apart from the first mix on, and what is shown is summed anew, by
//! each its own factor. No sample depends on it.

use std::time::{Duration, Instant};

use device::Device;
use engine::display::{DeviceFilm, Display, Mixer};
use engine::film::layers::LIGHT_GROUPS;
use engine::film::{GroupFactors, Layers, LightMix};
use engine::renderer::RenderError;
use engine::scene::Scene;
use engine::session::SessionError;

use super::{Displays, Render, publish};

/// A mix at rest for so long is worth denoising.
const STILL: Duration = Duration::from_millis(250);

/// How lights are mixed.
#[derive(Default)]
pub(super) struct Mixing {
    wanted: Option<LightMix>,
    /// Of the mix, another one with each change.
    number: u64,
    changed: Option<Instant>,
    mixers: Option<Mixers>,
}

/// What mixes the picture, and what it is compared with.
struct Mixers {
    now: Mixer,
    before: Mixer,
    beside: Mixer,
}

/// Pictures that are shown next to each other: each has a mixer of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Now,
    Before,
    Beside,
}

impl Mixing {
    /// Of the mix, to tell pictures of different ones apart.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// Whether it has just been changed, and is likely to change again.
    pub(super) fn is_moving(&self) -> bool {
        self.changed.is_some_and(|at| at.elapsed() < STILL)
    }

    /// What the groups of a scene are multiplied by; `None` where the picture is shown as it is.
    pub(super) fn factors(&self, scene: &Scene) -> Option<GroupFactors> {
        self.wanted.as_ref()?.of(&scene.light_groups)
    }

    /// Other files are shown.
    pub(super) fn forget(&mut self) {
        self.wanted = None;
        self.number += 1;
    }

    /// A film with its lights mixed, or as it is.
    pub(super) fn mixed(
        &mut self,
        device: &Device,
        film: &DeviceFilm,
        factors: Option<&GroupFactors>,
    ) -> Result<DeviceFilm, SessionError> {
        self.mixed_at(Place::Now, device, film, factors)
    }

    /// The same of one of the films that are shown next to each other.
    pub(super) fn mixed_at(
        &mut self,
        place: Place,
        device: &Device,
        film: &DeviceFilm,
        factors: Option<&GroupFactors>,
    ) -> Result<DeviceFilm, SessionError> {
        let Some(factors) = factors else {
            return Ok(film.clone());
        };
        let mixers = self.mixers(device)?;
        let mixer = match place {
            Place::Now => &mut mixers.now,
            Place::Before => &mut mixers.before,
            Place::Beside => &mut mixers.beside,
        };
        Ok(mixer.mix(film, factors).map_err(RenderError::from)?)
    }

    fn mixers(&mut self, device: &Device) -> Result<&mut Mixers, SessionError> {
        Ok(match &mut self.mixers {
            Some(mixers) => mixers,
            none => {
                let now = Mixer::new(device).map_err(RenderError::from)?;
                let (before, beside) = (now.another(), now.another());
                none.insert(Mixers {
                    now,
                    before,
                    beside,
                })
            }
        })
    }
}

impl Render {
    /// Mixes lights in what is shown. The first time the picture begins anew, once its groups are kept apart.
    pub(super) fn mix_lights(&mut self, mix: Option<LightMix>) {
        if mix == self.mixing.wanted {
            return;
        }
        if mix.is_some()
            && let Err(error) = self.keep_groups()
        {
            return self.reply(super::Reply::Failed(publish::message(&error)));
        }
        self.mixing.wanted = mix;
        self.mixing.number += 1;
        self.mixing.changed = Some(Instant::now());
        self.show_again();
    }

    /// Gathers the light of each group from now on. What a mix needs is compiled now, so that none waits for it.
    fn keep_groups(&mut self) -> Result<(), SessionError> {
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        if session.scene().light_groups.names().is_empty() {
            return Ok(());
        }
        self.mixing.mixers(&self.device)?;
        if let Some(Displays { other, .. }) = &mut self.display
            && other.is_none()
        {
            *other = Some(Display::new(&self.device).map_err(RenderError::from)?);
        }
        session.set_layers(Layers::named([LIGHT_GROUPS]).ok());
        Ok(())
    }
}
