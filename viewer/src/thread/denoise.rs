//! The picture without its noise, and what it is compared with: made of copies of the films on a thread of its own, while rendering goes on.
//! Nobody waits for it, and what is shown of a picture that has changed meanwhile is the picture as it is.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use device::Device;
use engine::denoise::{Denoiser, Guides};
use engine::display::{Channel, DeviceFilm};
use engine::renderer::RenderError;
use engine::session::SessionError;

use crate::host::OpenDenoiser;
use crate::link::{Denoise, DenoiserState, FINE, NOISY, Reply, lock};

use super::Render;
use super::mix::Place;

/// Samples per pixel of a picture that is denoised first: with fewer there is little to go by.
const FIRST: f64 = 4.0;
/// Where samples take so long, a single one has to do: it is far from noise already.
const SLOW: Duration = Duration::from_secs(5);
/// A picture is denoised again with so many times the samples, so that most of the time goes into these.
const AGAIN: f64 = 1.5;

/// Which of the pictures that are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Subject {
    Now,
    /// What that is compared with.
    Before,
}

/// A picture, by its generation, by how its lights are mixed, and its samples per pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Version {
    pub(super) subject: Subject,
    pub(super) generation: u64,
    pub(super) mix: u64,
    pub(super) spp: f64,
}

impl Version {
    /// Whether more samples are all that makes another one of it.
    fn is_of(self, other: Self) -> bool {
        (self.subject, self.generation, self.mix) == (other.subject, other.generation, other.mix)
    }
}

/// How a picture is shown by itself, while its noise becomes less.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// As it is: without its noise it would be another one with each sample.
    Noisy,
    Denoised,
    /// As it is: its noise isn't seen.
    Fine,
}

impl Stage {
    /// With an error that has been estimated; of a picture that is done nothing changes any more.
    fn then(self, error: f64, is_done: bool) -> Self {
        match self {
            // An estimate goes up and down; a picture doesn't.
            Self::Fine => Self::Fine,
            _ if error <= FINE => Self::Fine,
            Self::Noisy if error > NOISY && !is_done => Self::Noisy,
            Self::Noisy | Self::Denoised => Self::Denoised,
        }
    }
}

/// What the thread has to say.
enum Said {
    /// What the library is called, or why there is none.
    Opened(Result<String, String>),
    Clean(Box<Clean>),
    Failed(String),
}

/// A picture without noise.
struct Clean {
    film: DeviceFilm,
    version: Version,
}

/// The thread, and what has come of it.
pub(super) struct Denoising {
    pub(super) wanted: Denoise,
    /// Of the picture of a generation.
    stage: (u64, Stage),
    /// The library is looked for.
    is_opening: bool,
    is_ready: bool,
    /// A picture is under way.
    is_busy: bool,
    /// By subject, as what follows.
    last: [Option<Version>; 2],
    clean: [Option<Clean>; 2],
    /// Gone once there is nothing to be denoised any more.
    orders: Option<Sender<(DeviceFilm, Version)>>,
    said: Receiver<Said>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Denoising {
    /// The device is at rest afterwards.
    fn drop(&mut self) {
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            // What it has to say is no longer wanted.
            let _ = thread.join();
        }
    }
}

impl Denoising {
    /// Looks for the library on the new thread.
    pub(super) fn start(device: &Device, open: OpenDenoiser) -> Self {
        let (orders, ordered) = channel();
        let (sender, said) = channel();
        let device = device.clone();
        let work = move || work(&device, open, &ordered, &sender);
        let thread = std::thread::Builder::new()
            .name("denoise".to_owned())
            .spawn(work);
        Self {
            wanted: Denoise::Never,
            stage: (u64::MAX, Stage::Noisy),
            is_opening: thread.is_ok(),
            is_ready: false,
            is_busy: false,
            last: [None; 2],
            clean: [None, None],
            orders: Some(orders),
            said,
            thread: thread.ok(),
        }
    }

    /// Whether it is about to say something.
    pub(super) fn is_at_work(&self) -> bool {
        self.is_busy || self.is_opening
    }

    /// Whether a picture of this generation is to be shown without its noise.
    fn is_wanted(&self, generation: u64) -> bool {
        match self.wanted {
            Denoise::Always => true,
            Denoise::Never => false,
            Denoise::ByItself => self.stage == (generation, Stage::Denoised),
        }
    }

    /// What is to be shown in place of a version of the picture, or of one with more samples, and its samples per pixel.
    pub(super) fn clean(&self, version: Version, size: [u32; 2]) -> Option<(&DeviceFilm, f64)> {
        let clean = self.clean[version.subject as usize].as_ref()?;
        let film = &clean.film;
        let is_same = clean.version.is_of(version) && [film.width, film.height] == size;
        let is_wanted = version.subject == Subject::Before || self.is_wanted(version.generation);
        (is_same && is_wanted).then_some((film, clean.version.spp))
    }

    /// Whether such a picture is to be denoised now.
    fn is_due(&self, version: Version, is_done: bool, took: Duration) -> bool {
        let is_new = match self.last[version.subject as usize] {
            Some(last) if last.is_of(version) => {
                let is_last = is_done && version.spp > last.spp;
                is_last || version.spp >= AGAIN * last.spp
            }
            _ => version.spp >= FIRST || is_done || took >= SLOW,
        };
        self.is_ready && !self.is_busy && is_new
    }

    /// Has a copy denoised.
    fn order(&mut self, film: DeviceFilm, version: Version) {
        if let Some(orders) = &self.orders {
            self.is_busy = orders.send((film, version)).is_ok();
            self.last[version.subject as usize] = Some(version);
        }
    }
}

impl Render {
    /// The picture of now, as far as it is.
    pub(super) fn version(&self) -> Version {
        Version {
            subject: Subject::Now,
            generation: self.run.generation,
            mix: self.mixing.number(),
            spp: self.spp(),
        }
    }

    /// Takes over what has been denoised, and has the picture denoised again if it is time for that; and after it what it is compared
    /// with, so that both look alike.
    pub(super) fn denoise(&mut self) -> Result<(), SessionError> {
        while let Ok(said) = self.denoising.said.try_recv() {
            self.hear_denoiser(said)?;
        }
        let is_picture = self.settings.channel == Channel::Radiance && self.is_whole();
        if !is_picture || self.mixing.is_moving() {
            return Ok(());
        }
        self.judge_noise()?;
        let version = self.version();
        if !self.denoising.is_wanted(version.generation) {
            return Ok(());
        }
        let took = self.run.start.elapsed();
        if self.denoising.is_due(version, self.run.is_done, took) {
            let Some(session) = &mut self.session else {
                return Ok(());
            };
            let film = session.device_film(true)?;
            let factors = self.mixing.factors(session.scene());
            let film = self.mixing.mixed(&self.device, &film, factors.as_ref())?;
            let film = film.picture().copy(&self.device);
            self.denoising
                .order(film.map_err(RenderError::from)?, version);
        }
        self.denoise_before()
    }

    /// What is compared with, once the picture of now is there without its noise.
    fn denoise_before(&mut self) -> Result<(), SessionError> {
        let size = self.picture_size();
        if self.denoising.clean(self.version(), size).is_none() {
            return Ok(());
        }
        let Some(before) = self.before.as_mut().filter(|before| before.is_whole(size)) else {
            return Ok(());
        };
        let version = before.version();
        if !(self.denoising).is_due(version, before.is_done(), Duration::ZERO) {
            return Ok(());
        }
        let film = before.film(true)?;
        let factors = before.factors.as_ref();
        let film = (self.mixing).mixed_at(Place::Before, &self.device, &film, factors)?;
        let film = film.picture().copy(&self.device);
        self.denoising
            .order(film.map_err(RenderError::from)?, version);
        Ok(())
    }

    /// How the picture is shown by itself with the noise that it has.
    fn judge_noise(&mut self) -> Result<(), SessionError> {
        let generation = self.run.generation;
        let (of, former) = self.denoising.stage;
        let former = match of == generation {
            true => former,
            false => Stage::Noisy,
        };
        let is_known = self.spp() >= FIRST || self.run.is_done;
        let error = self.published.error_of(generation).filter(|_| is_known);
        let stage = error.map_or(former, |error| former.then(error, self.run.is_done));
        self.denoising.stage = (generation, stage);
        let is_by_itself = self.denoising.wanted == Denoise::ByItself;
        if is_by_itself && stage == Stage::Fine && former == Stage::Denoised {
            self.show()?;
            (self.wake)();
        }
        Ok(())
    }

    fn hear_denoiser(&mut self, said: Said) -> Result<(), SessionError> {
        match said {
            Said::Opened(opened) => {
                self.denoising.is_opening = false;
                self.denoising.is_ready = opened.is_ok();
                lock(&self.board).status.denoiser = match opened {
                    Ok(title) => DenoiserState::Ready(title),
                    Err(why) => DenoiserState::Absent(why),
                };
                (self.wake)();
            }
            Said::Clean(clean) => {
                self.denoising.is_busy = false;
                let subject = clean.version.subject;
                let now = match subject {
                    Subject::Now => Some(self.version()),
                    Subject::Before => self.before.as_ref().map(super::compare::Before::version),
                };
                let is_same = now.is_some_and(|now| clean.version.is_of(now));
                self.denoising.clean[subject as usize] = is_same.then_some(*clean);
                if is_same && self.run.is_seen {
                    self.show()?;
                    (self.wake)();
                }
            }
            Said::Failed(why) => {
                self.denoising.is_busy = false;
                self.denoising.wanted = Denoise::Never;
                self.reply(Reply::Failed(why));
            }
        }
        Ok(())
    }
}

/// What the thread does, until nobody wants anything of it any more.
fn work(
    device: &Device,
    open: OpenDenoiser,
    ordered: &Receiver<(DeviceFilm, Version)>,
    say: &Sender<Said>,
) {
    let denoiser = open();
    let opened = denoiser.as_ref().map(Denoiser::title);
    let is_heard = say.send(Said::Opened(opened.map_err(Clone::clone))).is_ok();
    let (Ok(denoiser), true) = (denoiser, is_heard) else {
        return;
    };
    while let Ok((film, version)) = ordered.recv() {
        let said = match denoised(device, &denoiser, &film) {
            Ok(film) => Said::Clean(Box::new(Clean { film, version })),
            Err(why) => Said::Failed(why),
        };
        if say.send(said).is_err() {
            return;
        }
    }
}

fn denoised(device: &Device, denoiser: &Denoiser, film: &DeviceFilm) -> Result<DeviceFilm, String> {
    let size = [film.width, film.height];
    let radiance = film.radiance(device).map_err(|error| error.to_string())?;
    let surfaces = film.surfaces(device).map_err(|error| error.to_string())?;
    let guides = surfaces.as_ref().map(|surfaces| Guides {
        albedo: &surfaces.base_color,
        normal: &surfaces.normal,
    });
    let clean = denoiser.picture(size, &radiance, guides);
    let clean = clean.map_err(|error| error.to_string())?;
    DeviceFilm::of_radiance(device, size, &clean).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_denoised_by_itself_between_much_noise_and_none_to_be_seen() {
        let stages = |errors: &[f64]| {
            let mut stage = Stage::Noisy;
            let then = |&error: &f64| {
                stage = stage.then(error, false);
                stage
            };
            errors.iter().map(then).collect::<Vec<_>>()
        };
        let (much, some, little) = (NOISY * 1.1, NOISY * 0.9, FINE * 0.9);
        // Estimates go up and down: what has begun goes on, and what has ended doesn't begin again.
        assert_eq!(
            stages(&[much, some, much, little, some]),
            [
                Stage::Noisy,
                Stage::Denoised,
                Stage::Denoised,
                Stage::Fine,
                Stage::Fine
            ]
        );
        assert_eq!(Stage::Noisy.then(much, true), Stage::Denoised);
        assert_eq!(Stage::Noisy.then(little, true), Stage::Fine);
    }
}
