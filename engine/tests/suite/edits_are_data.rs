//! Edits are data: a parameter, a ramp, a link or an AO distance is changed while rendering, a thousand times, and the
//! picture is the one that the changed look would have given, without a shader or a pipeline being made.

use ::device::Device;
use engine::film::Film;
use engine::procedural::TextureSources;
use engine::scene::look::AoSettings;
use engine::scene::{Camera, Projection, Scene};
use engine::session::{Edit, Session, SessionError};
use glam::Vec3;
use texgen::{Interpolation, Ramp, Value};

use crate::support::device;
use crate::support::memory::{self, InMemory};
use crate::support::root;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, render_textured, scene, textured,
};

const SHOT: Shot = Shot {
    size: (32, 24),
    max_depth: 3,
    spp: 8,
};

/// What is edited, with the values that the look begins with.
#[derive(Clone)]
struct State {
    noise_scale: f32,
    noise_contrast: f32,
    cells_scale: f32,
    mask_amount: f32,
    mask_influence: f32,
    grain: f32,
    color: [f32; 4],
    ramp: Vec<(f32, [f32; 4])>,
    /// What decides between the two colours of the sphere.
    factor: &'static str,
    /// Metres.
    ao_distance: f32,
}

impl State {
    fn first() -> Self {
        Self {
            noise_scale: 4.0,
            noise_contrast: 1.0,
            cells_scale: 3.0,
            mask_amount: 0.3,
            mask_influence: 1.5,
            grain: 0.25,
            color: [0.1, 0.3, 0.8, 1.0],
            ramp: vec![(0.0, [0.1, 0.0, 0.0, 1.0]), (1.0, [0.9, 0.5, 0.2, 1.0])],
            factor: "noise",
            ao_distance: 0.25,
        }
    }

    /// The look that gives this state from the start. The rust is so coarse that these few pixels show its grain.
    fn look(&self) -> String {
        let stops: Vec<String> = self
            .ramp
            .iter()
            .map(|(at, color)| format!("[{at:?}, {color:?}]"))
            .collect();
        format!(
            r#"
            [ao.crevices]
            distance = {:?}
            samples = 8

            [node.noise]
            texture = "fbm"
            scale = {:?}
            contrast = {:?}

            [node.cells]
            texture = "voronoi"
            scale = {:?}

            [node.mask]
            texture = "rust_mask"
            amount = {:?}
            influence = {:?}
            occlusion = "crevices"

            [node.rust]
            texture = "rust_color"
            scale = 0.1
            grain = {:?}
            ramp = {{ interpolation = "smooth", stops = [{}] }}

            [node.paint]
            texture = "mix_color"
            a = {:?}
            b = [0.9, 0.8, 0.7, 1.0]
            factor = "{}"

            [material."material 0"]
            base_color = "rust"
            roughness = "mask"

            [material."material 1"]
            base_color = "paint"
            roughness = "mask"
            "#,
            self.ao_distance,
            self.noise_scale,
            self.noise_contrast,
            self.cells_scale,
            self.mask_amount,
            self.mask_influence,
            self.grain,
            stops.join(", "),
            self.color,
            self.factor,
        )
    }

    /// Changes the `step`-th value in turn and tells the session.
    fn change(&mut self, step: usize, session: &mut Session) {
        // Values that no other step has.
        let t = 0.1 + 0.8 * (step as f32 * 0.618_034).fract();
        let (node, parameter, value) = match step % 8 {
            0 => set(&mut self.noise_scale, 10.0 * t, "noise", "scale"),
            1 => set(&mut self.noise_contrast, 3.0 * t, "noise", "contrast"),
            2 => set(&mut self.cells_scale, 9.0 * t, "cells", "scale"),
            3 => set(&mut self.mask_amount, 0.5 * t, "mask", "amount"),
            4 => set(&mut self.mask_influence, 4.0 * t, "mask", "influence"),
            5 => set(&mut self.grain, t, "rust", "grain"),
            6 => {
                self.color = [t, 1.0 - t, 0.5, 1.0];
                ("paint", "a", Value::Vec4(self.color))
            }
            _ => {
                let last = 1 + step % 3;
                let stop = |i: usize| {
                    let at = i as f32 / last as f32;
                    (at, [t, at, 1.0 - t, 1.0])
                };
                self.ramp = (0..=last).map(stop).collect();
                let ramp = Ramp {
                    stops: self.ramp.clone(),
                    interpolation: Interpolation::Smooth,
                };
                ("rust", "ramp", Value::Ramp(ramp))
            }
        };
        session
            .edit(&Edit::argument(node, parameter, &value))
            .unwrap_or_else(|error| panic!("{node}.{parameter}: {error}"));
    }
}

fn set(
    field: &mut f32,
    value: f32,
    node: &'static str,
    parameter: &'static str,
) -> (&'static str, &'static str, Value) {
    *field = value;
    (node, parameter, Value::F32(value))
}

fn sources() -> TextureSources {
    let folder = root().join("user_textures");
    TextureSources::scan(&[folder]).unwrap_or_else(|error| panic!("{error}"))
}

/// A sphere half sunk into a floor, so that there is a crevice.
fn bare_scene() -> Scene {
    let objects = [floor(4.0), faceted_sphere(16)].map(|mesh| (mesh, lambert(Vec3::ONE)));
    let mut scene = scene(objects, Vec3::ONE);
    for material in &mut scene.materials {
        // Without gloss a roughness that changes would not be seen.
        material.specular = 1.0;
    }
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

/// The picture of a state by a renderer that knew no other.
fn fresh(device: &Device, state: &State) -> Film {
    let mut scene = bare_scene();
    let procedural = textured(&mut scene, &state.look(), &sources());
    render_textured(device, &scene, &procedural, &view(), SHOT)
}

fn opened(device: &Device, state: &State) -> Session {
    InMemory::new(bare_scene(), view(), &state.look(), &sources()).open(device, SHOT)
}

fn picture(session: &mut Session) -> Film {
    memory::film(session, SHOT.spp)
}

fn is_same(a: &Film, b: &Film) -> bool {
    a == b
}

#[test]
fn edits_change_the_picture_and_make_no_pipeline() {
    let Some(device) = device::open() else { return };
    let mut state = State::first();
    let mut session = opened(&device, &state);
    let first = picture(&mut session);
    let made = |device: &Device| (device.counts().pipelines, device.counts().shader_modules);
    let before = made(&device);
    assert!(before.0 > 0 && before.1 > 0, "the counters count");

    let mut last = first;
    for step in 0..1000 {
        state.change(step, &mut session);
        // A picture after each kind of change, and now and then a few kinds together.
        if step < 8 || step % 125 == 124 {
            let now = picture(&mut session);
            // What the cells look like is not seen yet: nothing is linked to them.
            assert_eq!(is_same(&now, &last), step == 2, "after step {step}");
            last = now;
        }
    }
    let after_arguments = (state.clone(), picture(&mut session));

    state.factor = "cells.x";
    session
        .edit(&Edit::link("paint", "factor", state.factor))
        .unwrap_or_else(|error| panic!("{error}"));
    let after_link = (state.clone(), picture(&mut session));

    state.ao_distance = 1.5;
    let settings = AoSettings {
        distance: state.ao_distance,
        samples: 8,
        ..AoSettings::default()
    };
    session
        .edit_all(&Edit::ao("crevices", &settings))
        .unwrap_or_else(|error| panic!("{error}"));
    let after_ao = (state.clone(), picture(&mut session));
    assert_eq!(made(&device), before, "pipelines and shader modules");

    assert!(!is_same(&after_arguments.1, &after_link.1));
    assert!(!is_same(&after_link.1, &after_ao.1));
    for (what, (state, film)) in [
        ("a thousand arguments", after_arguments),
        ("a link", after_link),
        ("an AO distance", after_ao),
    ] {
        assert!(
            is_same(&film, &fresh(&device, &state)),
            "after {what} the picture must be that of the same look from the start"
        );
    }
}

#[test]
fn a_refused_edit_changes_nothing() {
    let Some(device) = device::open() else { return };
    let mut session = opened(&device, &State::first());
    let before = picture(&mut session);
    let no_samples = AoSettings {
        samples: 0,
        ..AoSettings::default()
    };
    let refused = [
        Edit::argument("nose", "scale", &Value::F32(1.0)),
        Edit::argument("noise", "scales", &Value::F32(1.0)),
        Edit::argument("noise", "scale", &Value::Vec3([1.0; 3])),
        Edit::argument("noise", "scale", &Value::F32(f32::NAN)),
        Edit::link("noise", "scale", "noise"),
        Edit::link("paint", "factor", "cells.q"),
        Edit::ao("crevices", &no_samples)[2].clone(),
    ];
    for edit in refused {
        let outcome = session.edit(&edit);
        assert!(
            matches!(outcome, Err(SessionError::Refused(_))),
            "{edit:?}: {outcome:?}"
        );
    }
    assert!(is_same(&before, &picture(&mut session)), "not restarted");
    session.restart();
    assert!(is_same(&before, &picture(&mut session)), "started anew");
}
