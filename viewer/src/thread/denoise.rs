//! The picture without its noise: made of copies of the film on a thread of its own, while rendering goes on. Nobody waits for it,
//! and what is shown of a picture that has changed meanwhile is the picture as it is.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use device::Device;
use engine::denoise::{Denoiser, Guides};
use engine::display::{Channel, DeviceFilm};
use engine::renderer::RenderError;
use engine::session::SessionError;

use crate::host::OpenDenoiser;
use crate::link::{DenoiserState, Reply, lock};

use super::Render;

/// Samples per pixel of a picture that is denoised first: with fewer there is little to go by.
const FIRST: f64 = 4.0;
/// Where samples take so long, a single one has to do: it is far from noise already.
const SLOW: Duration = Duration::from_secs(5);
/// A picture is denoised again with so many times the samples, so that most of the time goes into these.
const AGAIN: f64 = 1.5;

/// A picture, by its generation, by how its lights are mixed, and its samples per pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Version {
    generation: u64,
    mix: u64,
    spp: f64,
}

impl Version {
    /// Whether more samples are all that makes another one of it.
    fn is_of(self, generation: u64, mix: u64) -> bool {
        (self.generation, self.mix) == (generation, mix)
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
    pub(super) is_wanted: bool,
    is_ready: bool,
    /// A picture is under way.
    is_busy: bool,
    last: Option<Version>,
    clean: Option<Clean>,
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
            is_wanted: false,
            is_ready: false,
            is_busy: false,
            last: None,
            clean: None,
            orders: Some(orders),
            said,
            thread: thread.ok(),
        }
    }

    /// What is to be shown in place of a picture of this generation, mix and size, and its samples per pixel.
    pub(super) fn clean(
        &self,
        generation: u64,
        mix: u64,
        size: [u32; 2],
    ) -> Option<(&DeviceFilm, f64)> {
        let clean = self.clean.as_ref().filter(|_| self.is_wanted)?;
        let film = &clean.film;
        let is_same = clean.version.is_of(generation, mix) && [film.width, film.height] == size;
        is_same.then_some((film, clean.version.spp))
    }

    /// Whether such a picture is to be denoised now.
    fn is_due(&self, version: Version, is_done: bool, took: Duration) -> bool {
        let is_new = match self.last {
            Some(last) if last.is_of(version.generation, version.mix) => {
                let is_last = is_done && version.spp > last.spp;
                is_last || version.spp >= AGAIN * last.spp
            }
            _ => version.spp >= FIRST || is_done || took >= SLOW,
        };
        self.is_wanted && self.is_ready && !self.is_busy && is_new
    }
}

impl Render {
    /// Takes over what has been denoised, and has the picture denoised again if it is time for that.
    pub(super) fn denoise(&mut self) -> Result<(), SessionError> {
        while let Ok(said) = self.denoising.said.try_recv() {
            self.hear_denoiser(said)?;
        }
        let version = Version {
            generation: self.run.generation,
            mix: self.mixing.number(),
            spp: self.spp(),
        };
        let took = self.run.start.elapsed();
        let is_picture = self.settings.channel == Channel::Radiance && self.is_whole();
        if !is_picture
            || self.mixing.is_moving()
            || !self.denoising.is_due(version, self.run.is_done, took)
        {
            return Ok(());
        }
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let film = session.device_film(true)?;
        let factors = self.mixing.factors(session.scene());
        let film = self.mixing.mixed(&self.device, &film, factors.as_ref())?;
        let film = film.picture().copy(&self.device);
        let film = film.map_err(RenderError::from)?;
        let denoising = &mut self.denoising;
        if let Some(orders) = &denoising.orders {
            denoising.is_busy = orders.send((film, version)).is_ok();
            denoising.last = Some(version);
        }
        Ok(())
    }

    fn hear_denoiser(&mut self, said: Said) -> Result<(), SessionError> {
        match said {
            Said::Opened(opened) => {
                self.denoising.is_ready = opened.is_ok();
                lock(&self.board).status.denoiser = match opened {
                    Ok(title) => DenoiserState::Ready(title),
                    Err(why) => DenoiserState::Absent(why),
                };
                (self.wake)();
            }
            Said::Clean(clean) => {
                self.denoising.is_busy = false;
                let (generation, mix) = (self.run.generation, self.mixing.number());
                let is_same = clean.version.is_of(generation, mix);
                self.denoising.clean = is_same.then_some(*clean);
                if is_same && self.run.is_seen {
                    self.show()?;
                    (self.wake)();
                }
            }
            Said::Failed(why) => {
                self.denoising.is_busy = false;
                self.denoising.is_wanted = false;
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
