//! Several devices on one image: the picture is that of one, whoever rendered which part of it, and if one of them fails.

use std::ops::Range;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};

use ::device::{Device, DeviceChoice, DeviceError};
use engine::film::{Film, Layers};
use engine::fleet::{Fleet, Outcome, Plan, Worker};
use engine::renderer::{RenderError, Renderer};
use engine::scene::{Material, Projection};
use engine::stats::Stats;
use engine::system::System;
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, lamp, no_textures, quad, scene, settings,
};

const SPP: u32 = 48;

/// A picture with layers of every rule; no multiple of the blocks of eight pixels.
fn plan() -> Plan {
    let metal = Material {
        roughness: 0.3,
        ..Material::default()
    };
    let lamp_above = quad(Vec3::new(-0.5, 3.0, -0.5), Vec3::X, Vec3::Z);
    let mut scene = scene(
        [
            (floor(4.0), lambert(Vec3::splat(0.7))),
            (faceted_sphere(12), metal),
            (lamp_above, lamp(Vec3::splat(6.0))),
        ],
        Vec3::new(0.1, 0.2, 0.3),
    );
    let camera = camera(
        Vec3::new(0.5, 2.0, 5.0),
        Vec3::Y * 0.3,
        Vec3::Y,
        Projection::Perspective { y_fov: 0.9 },
    );
    let shot = Shot {
        size: (83, 45),
        max_depth: 5,
        spp: 0,
    };
    let procedural = no_textures(&mut scene);
    let mut settings = settings(&camera, shot);
    settings.first_sample = 3;
    settings.layers = Layers::named(["depth", "albedo"]).expect("there are such layers");
    Plan {
        scene: Arc::new(scene),
        procedural: Arc::new(procedural),
        settings,
        spp: SPP,
        times_passes: true,
        system: System::default(),
    }
}

fn native(threads: u32) -> Device {
    Device::open(&DeviceChoice::Native(threads)).unwrap_or_else(|error| panic!("{error}"))
}

fn renderer(plan: &Plan, device: &Device) -> Renderer {
    Renderer::new(device, &plan.scene, &plan.procedural, &plan.settings)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The whole picture by one device.
fn alone(plan: &Plan, device: &Device) -> Film {
    let mut renderer = renderer(plan, device);
    let rendered = renderer.render(plan.spp);
    rendered.unwrap_or_else(|error| panic!("{error}"));
    renderer.film().unwrap_or_else(|error| panic!("{error}"))
}

fn together(plan: &Plan, devices: &[Device]) -> Outcome {
    let fleet = Fleet::start(plan, devices.iter().map(|device| plan.recruit(device)));
    let outcome = fleet.outcome();
    assert_eq!(fleet.losses(), []);
    assert!(outcome.is_complete);
    fleet.join();
    outcome
}

#[test]
fn two_processors_render_the_picture_of_one() {
    let plan = plan();
    let outcome = together(&plan, &[native(1), native(1)]);
    assert!(outcome.film == alone(&plan, &native(2)));
    assert_eq!(outcome.samples, 3..3 + SPP);
    assert_eq!(outcome.device_names(), "native");
    let samples: u64 = outcome.devices.iter().map(|share| share.samples).sum();
    assert!(samples.abs_diff(83 * 45 * u64::from(SPP)) <= 1, "{samples}");
    assert!(outcome.stats.rays > samples && outcome.stats.timestamps);
}

#[test]
fn devices_of_two_kinds_render_what_each_renders_alone() {
    let Some(driver) = device::open_driver() else {
        return;
    };
    let plan = plan();
    let devices = [native(1), driver];
    let outcome = together(&plan, &devices);
    let mut sum = Film::with_layers(83, 45, plan.settings.layers.clone());
    for (share, device) in outcome.devices.iter().zip(&devices) {
        let mut renderer = renderer(&plan, device);
        for range in &share.paths {
            render_range(&mut renderer, range.clone());
        }
        sum.add(&renderer.film().unwrap_or_else(|error| panic!("{error}")));
    }
    assert!(outcome.film == sum);
    assert_eq!(outcome.film.sample_bounds(), (SPP, SPP));
}

fn render_range(renderer: &mut Renderer, range: Range<u64>) {
    let mut at = range.start;
    while at < range.end {
        let paths = renderer.render_paths(at..range.end);
        at += paths.unwrap_or_else(|error| panic!("{error}"));
    }
}

/// A worker that fails after some waves, of which the last one is in its film.
struct Failing {
    worker: Box<dyn Worker>,
    waves: u32,
    /// Dropped when it fails.
    failed: Option<Sender<()>>,
}

impl Worker for Failing {
    fn render(&mut self, paths: Range<u64>) -> Result<u64, RenderError> {
        let done = self.worker.render(paths)?;
        match self.waves.checked_sub(1) {
            Some(left) => self.waves = left,
            None => {
                drop(self.failed.take());
                return Err(DeviceError::Lost("it was pulled out".to_owned()).into());
            }
        }
        Ok(done)
    }

    fn take_film(&mut self) -> Result<Film, RenderError> {
        self.worker.take_film()
    }

    fn stats(&self) -> Result<Stats, RenderError> {
        self.worker.stats()
    }
}

#[test]
fn a_device_that_fails_is_replaced_by_the_others() {
    let plan = plan();
    let (failed, has_failed) = channel::<()>();
    let broken = plan.recruit(&native(1)).wrapped(|worker| {
        Box::new(Failing {
            worker,
            waves: 1,
            failed: Some(failed),
        })
    });
    let sound = plan.recruit(&native(1)).wrapped(move |worker| {
        // Or there might be nothing left for the other one.
        let _ = has_failed.recv();
        worker
    });
    let fleet = Fleet::start(&plan, [broken, sound]);
    let outcome = fleet.outcome();
    assert!(outcome.is_complete);
    assert!(outcome.film == alone(&plan, &native(2)));
    let losses = fleet.losses();
    assert_eq!(losses.len(), 1, "{losses:?}");
    assert!(losses[0].reason.contains("it was pulled out"), "{losses:?}");
}

#[test]
fn a_device_that_refuses_the_scene_is_left_out() {
    let plan = plan();
    // A texture that is refused would be such an error, too.
    let refused = Plan {
        settings: engine::renderer::RenderSettings {
            width: 0,
            ..plan.settings.clone()
        },
        ..plan.clone()
    };
    let recruits = [refused.recruit(&native(1)), plan.recruit(&native(1))];
    let fleet = Fleet::start(&plan, recruits);
    let outcome = fleet.outcome();
    assert!(outcome.is_complete && outcome.film == alone(&plan, &native(1)));
    let reason = outcome.devices[0].failure.clone();
    let losses = fleet.losses();
    fleet.join();
    // It may have been refused after the picture was done.
    assert!(losses.len() <= 1, "{losses:?}");
    assert!(reason.is_none_or(|reason| reason.contains("0 x 45")));
}
