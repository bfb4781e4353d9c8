//! Ways to find light beside each other: how they come nearer to a converged picture, and how a measurement ends early.

use std::path::Path;
use std::time::Duration;

use ::device::Device;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::RenderSettings;
use engine::scene::look::Look;
use patina_bench::methods::{How, MethodsReport, Setup, measure};
use patina_bench::scenes::cornell_box;

use crate::support::device;

const SIDE: u32 = 24;

/// The built-in box by paths and by `draft`, until `is_over`.
fn measured(device: &Device, is_over: fn() -> bool) -> MethodsReport {
    let mut scene = cornell_box();
    let nothing = Look::parse(Path::new(""), "").expect("an empty look");
    let procedural = Procedural::build(&nothing, &mut scene, &TextureSources::default());
    let camera = scene.cameras[0].clone();
    let setup = Setup {
        scene: &scene,
        procedural: &procedural.expect("no textures"),
        settings: RenderSettings::new(SIDE, SIDE, &camera),
        methods: vec![How::Path, How::Draft],
        reference: None,
        reference_spp: 64,
        most_spp: 16,
        runs: 1,
        exposure: 0.0,
        limit: Duration::from_secs(600),
        is_over,
    };
    measure(device, &setup, |_| {}).expect("measured")
}

#[test]
fn pictures_come_nearer_to_the_converged_one() {
    let Some(device) = device::open() else { return };
    let report = measured(&device, || false);
    assert!(report.has_figures());
    for curve in report.curves {
        let samples: Vec<u32> = curve.points.iter().map(|point| point.spp).collect();
        assert_eq!(samples, [4, 6, 8, 12, 16], "{:?}", curve.how);
        let [first, .., last] = &curve.points[..] else {
            unreachable!("there are five")
        };
        assert!(last.flip < first.flip && last.mse < first.mse);
    }
}

#[test]
fn what_is_ended_says_so_and_gives_what_there_is() {
    let Some(device) = device::open() else { return };
    let report = measured(&device, || true);
    assert!(report.left_out.contains(&"interrupted".to_owned()));
    assert_eq!(report.curves.len(), 2);
    assert!(!report.has_figures(), "no picture was done");
    assert_eq!(report.reference.len(), (SIDE * SIDE) as usize);
}
