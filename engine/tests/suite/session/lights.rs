//! Lights of a look: edited while the picture refines, they are what they are from the start.

use ::device::Device;
use engine::film::Film;
use engine::procedural::TextureSources;
use engine::scene::{Camera, LightKind, Projection, PunctualLight, Scene};
use engine::session::{Edit, Session};
use glam::Vec3;

use crate::support::device;
use crate::support::memory::{self, InMemory};
use crate::support::scenes::{Shot, camera, faceted_sphere, floor, lambert, scene};

const SHOT: Shot = Shot {
    size: (32, 24),
    max_depth: 2,
    spp: 8,
};

/// A sphere on a floor in the dark, with a lamp of the file.
fn dark_scene() -> Scene {
    let objects = [floor(4.0), faceted_sphere(12)].map(|mesh| (mesh, lambert(Vec3::splat(0.8))));
    let mut scene = scene(objects, Vec3::ZERO);
    scene.lights.push(PunctualLight {
        name: "file".to_owned(),
        intensity: Vec3::new(2.0, 1.0, 0.5),
        position: Vec3::new(0.0, 3.0, 0.0),
        direction: Vec3::NEG_Y,
        range: f32::INFINITY,
        kind: LightKind::Point,
    });
    scene
}

fn view() -> Camera {
    camera(
        Vec3::new(0.5, 2.0, 4.0),
        Vec3::Y * 0.2,
        Vec3::Y,
        Projection::Perspective { y_fov: 0.8 },
    )
}

const LOOK: &str = "[light.key]\ntype = \"spot\"\nposition = [2.0, 3.0, 1.0]\nlook_at = [0.0, 0.0, 0.0]\nintensity = 20\n\n\
    [light.fill]\ntype = \"point\"\nposition = [-2.0, 2.0, 2.0]\nintensity = 3\n\n\
    [light.day]\ntype = \"directional\"\ndirection = [1.0, -2.0, 0.0]\nintensity = 0.5\n";

fn open(device: &Device, look: &str) -> Session {
    InMemory::new(dark_scene(), view(), look, &TextureSources::default()).open(device, SHOT)
}

fn fresh(device: &Device, look: &str) -> Film {
    memory::film(&mut open(device, look), SHOT.spp)
}

#[test]
fn edits_of_lights_are_writes() {
    let Some(device) = device::open() else { return };
    let mut session = open(&device, LOOK);
    let mut last = memory::film(&mut session, SHOT.spp);
    for line in [
        "light.key.intensity=40",
        "light.key.position=[1.0, 2.0, 1.5]",
        "light.key.outer_cone_angle=20",
        "light.fill.color=[0.1, 0.2, 1.0]",
        "light.day.angular_diameter=5",
        "light.fill.on=false",
        "light.file.intensity=8",
    ] {
        let edit = Edit::parse(line).expect(line);
        session
            .edit(&edit)
            .unwrap_or_else(|e| panic!("{line}: {e}"));
        assert!(session.is_up_to_date(), "{line}: nothing is built");
        let film = memory::film(&mut session, SHOT.spp);
        assert!(film != last, "{line} is seen");
        assert!(film == fresh(&device, &session.look_text()), "{line}");
        last = film;
    }
    let edited = session.look_text();
    session.replace_look(LOOK).expect("it is a look");
    memory::settle(&mut session);
    let film = memory::film(&mut session, SHOT.spp);
    assert!(film == fresh(&device, LOOK), "undone from {edited}");
}

#[test]
fn lights_come_and_go() {
    let Some(device) = device::open() else { return };
    let mut session = open(&device, LOOK);
    let area = format!(
        "{LOOK}\n[light.soft]\ntype = \"area\"\nposition = [0.0, 3.0, 2.0]\nlook_at = [0.0, 0.0, 0.0]\nsize = [1.0, 0.5]\n"
    );
    for look in [&*area, "", LOOK] {
        session.replace_look(look).expect("it is a look");
        memory::settle(&mut session);
        assert!(session.problems().is_empty(), "{}", session.problems());
        let film = memory::film(&mut session, SHOT.spp);
        assert!(film == fresh(&device, look), "{look}");
    }
}

#[test]
fn a_mistake_in_a_light_leaves_the_picture_as_it_is() {
    let Some(device) = device::open() else { return };
    let mut session = open(&device, LOOK);
    let film = memory::film(&mut session, SHOT.spp);
    let wrong = Edit::parse("light.key.look_at=[2.0, 3.0, 1.0]").expect("an edit");
    let error = session.edit(&wrong).expect_err("it looks nowhere");
    assert!(
        error.to_string().contains("stands where it looks at"),
        "{error}"
    );
    assert!(memory::film(&mut session, SHOT.spp) == film);
    assert_eq!(session.look_text(), LOOK);
}

/// A small rectangle far away is a point that shines with the cosine of its angle.
#[test]
fn a_rectangle_is_as_bright_as_its_intensity_says() {
    let Some(device) = device::open() else { return };
    let above = "position = [0.0, 30.0, 0.0]\nintensity = 2000\n";
    let dark = "[light.file]\non = false\n\n";
    let area = format!("{dark}[light.a]\ntype = \"area\"\n{above}size = [0.1, 0.1]\n");
    let point = format!("{dark}[light.a]\ntype = \"point\"\n{above}");
    let mean = |look: &str| {
        let film = memory::film(&mut open(&device, look), 64);
        let means = film.mean();
        means.iter().map(|rgb| f64::from(rgb[1])).sum::<f64>() / means.len() as f64
    };
    let (area, point) = (mean(&area), mean(&point));
    assert!(point > 0.1, "{point}");
    // The cosines are between 0.99 and 1, twice.
    assert!((area / point - 1.0).abs() < 0.02, "{area} {point}");
}
