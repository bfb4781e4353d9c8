//! Several devices on one image.
//!
//! Each device has a renderer and a thread of its own, and the same scene. Paths of a picture are numbered sample by sample, and
//! within a sample block by block ([`Renderer::paths_per_sample`]); the members of a [`Fleet`] take ranges of these
//! numbers from a common queue, as many as suits their speed, and fewer towards the end. What a device gathers
//! lies in its own film and is added to the common one now and then, and at the end. The film's sums are exact in any order, so
//! the picture is that of one device, whoever rendered which range; with devices of several kinds each path is as its
//! device rounds it. What is to be known of the light before the picture begins, each device finds out by itself: the same on devices of one kind.
//!
//! A device that fails is left out from then on: what it had rendered and nobody had collected goes back to the queue. One that is
//! ready late, because its driver compiles for long, joins late.
//!
//! ```no_run
//! use std::{path::Path, sync::Arc, time::Duration};
//!
//! use device::{Device, DeviceChoice};
//! use engine::{fleet::{Fleet, Plan}, load, settings::RenderSettings, system::System};
//!
//! let loaded = load::load(Path::new("scene.glb"), None, &[])?;
//! let plan = Plan {
//!     settings: RenderSettings::new(640, 360, &loaded.camera),
//!     scene: Arc::new(loaded.scene),
//!     procedural: Arc::new(loaded.procedural),
//!     spp: 64,
//!     times_passes: false,
//!     system: System::default(),
//! };
//! let choices = [DeviceChoice::Best, DeviceChoice::Native(2)];
//! let devices = choices.iter().map(Device::open).collect::<Result<Vec<_>, _>>()?;
//! let fleet = Fleet::start(&plan, devices.iter().map(|device| plan.recruit(device)));
//! while !fleet.is_over() {
//!     let progress = fleet.wait(Duration::from_millis(200));
//!     println!("{} of {} samples", progress.samples_done, progress.samples_total);
//! }
//! let rgb = fleet.outcome().film.mean();
//! fleet.join();
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod outcome;
mod queue;
mod state;
mod worker;

use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

use device::Device;

use crate::film::{self, Film};
use crate::frame;
use crate::procedural::Procedural;
use crate::renderer::{Progress, RenderError, Renderer};
use crate::scene::Scene;
use crate::settings::RenderSettings;
use crate::stats::DeviceFacts;
use crate::system::System;

use self::queue::Queue;
use self::state::{Member, Phase, Shared, State};
use self::worker::Make;

pub use self::outcome::{DeviceShare, Outcome};
pub use self::worker::Worker;

/// What is rendered together.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The scene, which is uploaded to each device.
    pub scene: Arc<Scene>,
    /// Its textures.
    pub procedural: Arc<Procedural>,
    /// How it is rendered.
    pub settings: RenderSettings,
    /// Samples of each pixel, at most [`film::MAX_SAMPLES`].
    pub spp: u32,
    /// Each device times its passes.
    pub times_passes: bool,
    /// Time and threads.
    pub system: System,
}

impl Plan {
    /// A device for it, which is made ready (the scene uploaded, kernels compiled) on the thread that will work with it.
    pub fn recruit(&self, device: &Device) -> Recruit {
        let (plan, device) = (self.clone(), device.clone());
        Recruit {
            facts: DeviceFacts::new(device.description()),
            first: u64::from(device.traits().waves.first),
            make: Box::new(move || Ok(Box::new(plan.renderer(&device)?))),
        }
    }

    /// A renderer that can be put to work.
    fn renderer(&self, device: &Device) -> Result<Renderer, RenderError> {
        let (scene, procedural) = (&self.scene, &self.procedural);
        let renderer = Renderer::new(device, scene, procedural, &self.settings)?;
        let mut renderer = renderer.in_system(&self.system);
        renderer.warm_up()?;
        renderer.prepare()?;
        if self.times_passes {
            renderer.time_passes()?;
        }
        Ok(renderer)
    }
}

/// A device that isn't ready yet.
pub struct Recruit {
    facts: DeviceFacts,
    /// Paths of its first range at most.
    first: u64,
    make: Make,
}

impl std::fmt::Debug for Recruit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recruit")
            .field("facts", &self.facts)
            .finish_non_exhaustive()
    }
}

impl Recruit {
    /// With another worker before the one that there would be, such as one that watches it.
    #[must_use]
    pub fn wrapped(
        self,
        wrap: impl FnOnce(Box<dyn Worker>) -> Box<dyn Worker> + Send + 'static,
    ) -> Self {
        let make = self.make;
        Self {
            make: Box::new(move || make().map(wrap)),
            ..self
        }
    }
}

/// Why a device is gone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Loss {
    /// The device, in one line.
    pub device: String,
    /// What it said.
    pub reason: String,
}

/// Devices at work on one picture. See the module's description. Dropped, its members end after the waves that they are in.
#[derive(Debug)]
pub struct Fleet {
    shared: Arc<Shared>,
    facts: Vec<DeviceFacts>,
    /// The film before there is anything in it.
    empty: Film,
    first_sample: u32,
    system: System,
}

impl Fleet {
    /// Begins: each device is made ready and put to work on a thread of its own.
    pub fn start(plan: &Plan, recruits: impl IntoIterator<Item = Recruit>) -> Self {
        let RenderSettings {
            width,
            height,
            first_sample,
            ..
        } = plan.settings;
        let spp = plan.spp.min(film::MAX_SAMPLES).min(u32::MAX - first_sample);
        let of_sample = frame::paths_per_sample(width, height);
        let paths = of_sample * u64::from(spp);
        // Photons are sent out by each device that renders some of a sample.
        let grain = match plan.settings.method.has_photons() {
            true => of_sample,
            false => queue::BLOCK,
        };
        let recruits: Vec<Recruit> = recruits.into_iter().collect();
        let members = recruits.iter().map(|recruit| Member::new(recruit.first));
        let shared = Arc::new(Shared::new(Queue::new(paths, grain), members.collect()));
        let mut facts = Vec::new();
        for (number, recruit) in recruits.into_iter().enumerate() {
            facts.push(recruit.facts);
            let (own, clock) = (Arc::clone(&shared), Arc::clone(&plan.system.clock));
            let work = Box::new(move || worker::run(&own, number, recruit.make, &*clock));
            if let Err(error) = (plan.system.threads).spawn(&format!("device {number}"), work) {
                let reason = format!("no thread can be started for it: {error}");
                shared.ended(number, Some(reason));
            }
        }
        Self {
            shared,
            facts,
            empty: Film::with_layers(width, height, plan.settings.layers.clone()),
            first_sample,
            system: plan.system.clone(),
        }
    }

    /// Waits until something has happened, or for so long; how far the picture is. Where a device fails, less is done than
    /// before.
    pub fn wait(&self, most: Duration) -> Progress {
        let state = self.shared.lock();
        let state = match is_over(&state) {
            true => state,
            false => self.shared.wait(state, most),
        };
        Progress {
            samples_done: self.samples(state.done()),
            samples_total: self.samples(state.queue.end()),
        }
    }

    /// Samples of pixels, of so many paths.
    fn samples(&self, paths: u64) -> u64 {
        let (width, height) = (self.empty.width, self.empty.height);
        let padded = u128::from(frame::paths_per_sample(width, height));
        let pixels = u128::from(width) * u128::from(height);
        (u128::from(paths) * pixels / padded.max(1)) as u64
    }

    /// What one sees in what devices have handed over so far; `None` while there is nothing. None hands over more meanwhile.
    pub fn look<T>(&self, look: impl FnOnce(&Film) -> T) -> Option<T> {
        self.shared.with_film(look)
    }

    /// Whether every pixel has a sample.
    pub fn has_all_pixels(&self) -> bool {
        let (width, height) = (self.empty.width, self.empty.height);
        let state = self.shared.lock();
        let first = frame::paths_per_sample(width, height).min(state.queue.end());
        state.done_below(first) >= first
    }

    /// Whether a device has begun to render, or none ever will.
    pub fn is_ready(&self) -> bool {
        let state = self.shared.lock();
        is_over(&state) || (state.members.iter()).any(|member| member.phase == Phase::Working)
    }

    /// Whether nothing more will come: the picture is done or has been stopped, or no device is left.
    pub fn is_over(&self) -> bool {
        is_over(&self.shared.lock())
    }

    /// Devices that failed, each told once.
    pub fn losses(&self) -> Vec<Loss> {
        let mut state = self.shared.lock();
        let news = std::mem::take(&mut state.news);
        let loss = |place: usize| Loss {
            device: self.facts[place].title.clone(),
            reason: state.members[place].failure.clone().unwrap_or_default(),
        };
        news.into_iter().map(loss).collect()
    }

    /// Ends the work early: each device ends after the wave that it is in.
    pub fn stop(&self) {
        self.shared.change(|state| state.is_stopped = true);
    }

    /// Begins no sample that isn't under way somewhere already: how many samples each pixel will have then.
    pub fn stop_after_sample(&self) -> u32 {
        let padded = frame::paths_per_sample(self.empty.width, self.empty.height).max(1);
        self.shared.change(|state| {
            let spp = state.queue.reached().div_ceil(padded);
            state.queue.cut(spp * padded);
            spp as u32
        })
    }

    /// What has come of it, once the devices that have begun have handed over what they have. Those that aren't ready yet
    /// aren't waited for. It can be taken once.
    pub fn outcome(&self) -> Outcome {
        let state = self.shared.wait_until(is_over);
        let film = self.shared.take_film();
        let is_complete = film.is_some() && !state.is_stopped && state.queue.left() == 0;
        let now = self.system.clock.now();
        outcome::gather(outcome::Harvest {
            members: &state.members,
            facts: &self.facts,
            took: state.ready_at.map_or(Duration::ZERO, |ready| now - ready),
            samples: &|paths| self.samples(paths),
            sample_numbers: &|paths: &Range<u64>| self.sample_numbers(paths),
            film: film.unwrap_or_else(|| self.empty.clone()),
            is_complete,
        })
    }

    /// The numbers of the samples that some paths are of.
    fn sample_numbers(&self, paths: &Range<u64>) -> Range<u32> {
        let padded = frame::paths_per_sample(self.empty.width, self.empty.height).max(1);
        let number = |sample: u64| self.first_sample + sample as u32;
        number(paths.start / padded)..number(paths.end.div_ceil(padded))
    }

    /// Waits until all threads are at their end, those, too, in which a driver still compiles for nothing.
    pub fn join(self) {
        self.stop();
        drop(self.shared.wait_until(State::is_deserted));
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        self.stop();
    }
}

fn is_over(state: &State) -> bool {
    state.is_settled() || state.is_deserted()
}

#[cfg(test)]
mod tests;
