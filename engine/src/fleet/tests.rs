//! Fleets of workers that need no device: each path adds a number that follows from its own.

use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};

use super::*;
use crate::procedural::TextureSources;
use crate::scene::default_camera;
use crate::scene::look::Look;
use crate::stats::Stats;
use crate::system::Clock;

/// One block of 8 x 8 pixels.
const SIDE: u32 = 8;
const PIXELS: u64 = 64;

/// Adds what a path gives.
fn add_path(film: &mut Film, path: u64) {
    let value = (path * 7919 % 1009) as f32 * 0.37;
    film.add_sample((path % PIXELS) as usize, [value, -value, 1.0]);
}

/// A worker that fails before its wave of this number.
struct Counting {
    film: Film,
    waves: u32,
    fails_at: u32,
    /// Told when it fails.
    failed: Option<Sender<()>>,
}

impl Counting {
    fn new(fails_at: u32) -> Self {
        Self {
            film: Film::new(SIDE, SIDE),
            waves: 0,
            fails_at,
            failed: None,
        }
    }
}

impl Worker for Counting {
    fn render(&mut self, paths: Range<u64>) -> Result<u64, RenderError> {
        let end = paths.end.min(paths.start + 512);
        let is_last = self.waves == self.fails_at;
        // A device that fails may have done a part of what it was given.
        let done = if is_last {
            (end - paths.start) / 2
        } else {
            end - paths.start
        };
        (paths.start..paths.start + done).for_each(|path| add_path(&mut self.film, path));
        std::thread::sleep(Duration::from_millis(1));
        if is_last {
            drop(self.failed.take());
            return Err(device::DeviceError::Lost("it was pulled out".to_owned()).into());
        }
        self.waves += 1;
        Ok(end - paths.start)
    }

    fn take_film(&mut self) -> Result<Film, RenderError> {
        Ok(std::mem::replace(&mut self.film, Film::new(SIDE, SIDE)))
    }

    fn stats(&self) -> Result<Stats, RenderError> {
        Ok(Stats {
            rays: u64::from(self.waves),
            ..Stats::default()
        })
    }
}

fn recruit(name: &str, make: impl FnOnce() -> Counting + Send + 'static) -> Recruit {
    Recruit {
        facts: DeviceFacts {
            title: format!("{name} (made up)"),
            name: name.to_owned(),
            backend: String::new(),
            driver: String::new(),
        },
        first: 1024,
        make: Box::new(move || Ok(Box::new(make()))),
    }
}

/// A device that fails at its wave of this number, and one that only begins then.
fn broken_and_sound(fails_at: u32) -> [Recruit; 2] {
    let (failed, has_failed) = channel::<()>();
    let broken = recruit("broken", move || Counting {
        failed: Some(failed),
        ..Counting::new(fails_at)
    });
    let sound = recruit("sound", move || {
        // The other end is dropped.
        let _ = has_failed.recv();
        Counting::new(u32::MAX)
    });
    [broken, sound]
}

fn plan(spp: u32) -> Plan {
    let mut scene = Scene::default();
    let nothing = Look::parse(Path::new(""), "").unwrap_or_else(|problems| panic!("{problems}"));
    let procedural = Procedural::build(&nothing, &mut scene, &TextureSources::default())
        .unwrap_or_else(|problems| panic!("{problems}"));
    Plan {
        settings: RenderSettings::new(SIDE, SIDE, &default_camera(&scene)),
        scene: Arc::new(scene),
        procedural: Arc::new(procedural),
        spp,
        times_passes: false,
        system: System::default(),
    }
}

/// What one worker would gather.
fn whole(spp: u32) -> Film {
    let mut film = Film::new(SIDE, SIDE);
    (0..PIXELS * u64::from(spp)).for_each(|path| add_path(&mut film, path));
    film
}

#[test]
fn the_film_is_that_of_one_device() {
    let recruits = ["a", "b", "c"].map(|name| recruit(name, || Counting::new(u32::MAX)));
    let fleet = Fleet::start(&plan(500), recruits);
    let outcome = fleet.outcome();
    assert!(outcome.is_complete && outcome.film == whole(500));
    assert_eq!(outcome.samples, 0..500);
    let shares: f64 = outcome.devices.iter().map(|share| share.share).sum();
    assert!((shares - 1.0).abs() < 1e-9);
    let samples: u64 = outcome.devices.iter().map(|share| share.samples).sum();
    assert_eq!(samples, 500 * PIXELS);
    let progress = fleet.wait(Duration::ZERO);
    assert!(progress.is_done() && progress.samples_total == 500 * PIXELS);
    assert!(fleet.losses().is_empty());
    fleet.join();
}

#[test]
fn what_a_failing_device_had_is_rendered_by_the_others() {
    let stillborn = recruit("stillborn", || panic!("no such driver"));
    let recruits = broken_and_sound(3).into_iter().chain([stillborn]);
    let fleet = Fleet::start(&plan(500), recruits);
    let outcome = fleet.outcome();
    assert!(outcome.is_complete && outcome.film == whole(500));
    let names = outcome.device_names();
    let broken = &outcome.devices[0];
    assert!(broken.failure.is_some() && broken.samples == 0);
    // The third needn't have been tried yet.
    drop(fleet.shared.wait_until(State::is_deserted));
    let mut losses = fleet.losses();
    losses.sort_by(|a, b| a.device.cmp(&b.device));
    assert_eq!(losses.len(), 2, "{losses:?}");
    assert_eq!(losses[0].device, "broken (made up)");
    assert!(losses[0].reason.contains("it was pulled out"), "{losses:?}");
    assert!(losses[1].reason.contains("no such driver"), "{losses:?}");
    assert!(fleet.losses().is_empty(), "each is told once");
    assert_eq!(names, "sound");
}

/// Each look at it takes a minute.
#[derive(Debug, Default)]
struct Slow(AtomicU64);

impl Clock for Slow {
    fn now(&self) -> Duration {
        Duration::from_secs(60 * self.0.fetch_add(1, Ordering::Relaxed))
    }
}

#[test]
fn what_has_been_collected_is_not_lost() {
    let mut plan = plan(200);
    plan.system.clock = Arc::new(Slow::default());
    let fleet = Fleet::start(&plan, broken_and_sound(4));
    let outcome = fleet.outcome();
    assert!(outcome.is_complete && outcome.film == whole(200));
    let [broken, sound] = &outcome.devices[..] else {
        panic!("there are two");
    };
    assert!(broken.failure.is_some() && broken.is_used());
    assert!(broken.samples > 0 && sound.samples > 0);
    assert_eq!(outcome.device_names(), "broken + sound");
}

#[test]
fn without_any_device_left_it_ends() {
    let recruits = [2, 5].map(|fails_at| recruit("broken", move || Counting::new(fails_at)));
    let fleet = Fleet::start(&plan(500), recruits);
    let outcome = fleet.outcome();
    assert!(!outcome.is_complete && fleet.is_over());
    assert_eq!(fleet.losses().len(), 2);
    let none = Fleet::start(&plan(4), []);
    assert!(none.is_over() && none.is_ready());
    assert_eq!(none.outcome().film.sample_bounds(), (0, 0));
}

#[test]
fn a_picture_can_be_ended_early() {
    let recruits = || ["a", "b"].map(|name| recruit(name, || Counting::new(u32::MAX)));
    let begun = |fleet: &Fleet| {
        while fleet.wait(Duration::from_millis(5)).samples_done == 0 {
            assert!(!fleet.is_over());
        }
    };
    let fleet = Fleet::start(&plan(1 << 20), recruits());
    begun(&fleet);
    fleet.stop();
    let outcome = fleet.outcome();
    assert!(!outcome.is_complete);
    // Exactly the paths that it says.
    let mut expected = Film::new(SIDE, SIDE);
    for range in outcome.devices.iter().flat_map(|share| &share.paths) {
        range.clone().for_each(|path| add_path(&mut expected, path));
    }
    assert!(outcome.film == expected);
    assert!(outcome.samples.end as u64 * PIXELS < 1 << 26);

    let fleet = Fleet::start(&plan(1 << 20), recruits());
    begun(&fleet);
    let spp = fleet.stop_after_sample();
    let outcome = fleet.outcome();
    assert!(outcome.is_complete && outcome.film == whole(spp));
    assert_eq!(outcome.samples, 0..spp);
    assert!(fleet.wait(Duration::ZERO).is_done());
}
