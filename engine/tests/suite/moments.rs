//! A scene over time: one moment after the other is shown by the same renderer, and each picture is to the bit that of a
//! renderer that has seen no other.

use std::fs;
use std::sync::Arc;

use ::device::{Device, DeviceChoice};
use engine::film::Film;
use engine::renderer::RenderSettings;
use engine::scene::look::Value;
use engine::scene::{Moment, Motion};
use engine::session::{Edit, Inputs, Opening, Sequence, Session};
use engine::settings::Method;
use engine::system::System;
use tempfile::TempDir;

use crate::support::device;

/// A floor that stands still, and what moves: a node, a morph target, a lamp, a skin, a light, the camera, and a square that
/// shrinks to nothing after a second. From the fifth accessor on: times, ways, weights, joints, their weights, sizes.
const SCENE: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0, 1, 2, 3, 4, 5, 6, 7, 8] }],
  "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 3 }] } },
  "nodes": [
    { "name": "Floor", "mesh": 0, "scale": [4, 1, 4] },
    { "name": "Mover", "mesh": 0, "scale": [0.4, 0.4, 0.4] },
    { "name": "Bent", "mesh": 1, "translation": [-1, 0.2, 0] },
    { "name": "Lamp", "mesh": 2, "rotation": [1, 0, 0, 0], "scale": [0.3, 0.3, 0.3] },
    { "name": "Skinned", "mesh": 3, "skin": 0 },
    { "name": "Joint", "rotation": [0.5, 0, 0, 0.8660254], "scale": [0.5, 0.5, 0.5] },
    { "name": "Light", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
    { "name": "View", "camera": 0 },
    { "name": "Vanishing", "mesh": 0, "translation": [1, 0.4, 0.6] }
  ],
  "cameras": [{ "name": "View", "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }],
  "materials": [
    { "name": "Grey", "doubleSided": true, "pbrMetallicRoughness": { "baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0 } },
    { "name": "Painted", "doubleSided": true, "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.5 } },
    { "name": "Glow", "doubleSided": true, "emissiveFactor": [1, 0.8, 0.5] }
  ],
  "skins": [{ "joints": [5] }],
  "meshes": [
    { "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] },
    { "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 1, "targets": [{ "POSITION": 2 }] }] },
    { "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1, "material": 2 }] },
    { "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_0": 6, "WEIGHTS_0": 7 }, "indices": 1, "material": 1 }] }
  ],
  "animations": [{
    "name": "All",
    "channels": [
      { "sampler": 0, "target": { "node": 1, "path": "translation" } },
      { "sampler": 1, "target": { "node": 2, "path": "weights" } },
      { "sampler": 2, "target": { "node": 3, "path": "translation" } },
      { "sampler": 0, "target": { "node": 5, "path": "translation" } },
      { "sampler": 2, "target": { "node": 6, "path": "translation" } },
      { "sampler": 3, "target": { "node": 7, "path": "translation" } },
      { "sampler": 4, "target": { "node": 8, "path": "scale" } }
    ],
    "samplers": [
      { "input": 3, "output": 4 },
      { "input": 3, "output": 5 },
      { "input": 3, "output": 9 },
      { "input": 3, "output": 10 },
      { "input": 3, "output": 8 }
    ]
  }],
  "accessors": [
    { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1] },
    { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
    { "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC3" },
    { "bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR" },
    { "bufferView": 4, "componentType": 5126, "count": 2, "type": "VEC3" },
    { "bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR" },
    { "bufferView": 5, "componentType": 5121, "count": 4, "type": "VEC4" },
    { "bufferView": 6, "componentType": 5126, "count": 4, "type": "VEC4" },
    { "bufferView": 7, "componentType": 5126, "count": 2, "type": "VEC3" },
    { "bufferView": 8, "componentType": 5126, "count": 2, "type": "VEC3" },
    { "bufferView": 9, "componentType": 5126, "count": 2, "type": "VEC3" }
  ],
  "bufferViews": [VIEWS],
  "buffers": [{ "byteLength": LENGTH, "uri": "moving.bin" }]
}"#;

/// Keys of a value of a material, of an argument, and of the sky; one argument that no key changes.
const LOOK: &str = "environment = { color = [0.3, 0.4, 0.6], intensity = { keys = [[0, 0.2], [1, 1.0]] } }\n\
[node.blink]\ntexture = 'blink'\ngain = { keys = [[0, 0.25], [2, 1.0]] }\n\
[material.Grey]\nroughness = { keys = [[0.25, 0.2], [0.75, 0.9]] }\n\
[material.Painted]\nbase_color = 'blink'\n";

const BLINK: &str = "// Brighter and brighter; every other picture is redder.\n\
fn userProc(gain: f32) -> vec3f {\n\
    let seconds = readGlobal(Time).x;\n\
    let odd = readGlobal(FrameIndex).x % 2.0;\n\
    return vec3f(0.2 + 0.5 * odd, 0.2 + 0.3 * gain * seconds, 0.3);\n\
}\n";

struct Stage {
    folder: TempDir,
}

impl Stage {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let floats = |numbers: &[f32]| bytemuck::cast_slice::<f32, u8>(numbers).to_vec();
        let pieces: [Vec<u8>; 10] = [
            floats(&[
                -1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, -1.0, -1.0, 0.0, -1.0,
            ]),
            bytemuck::cast_slice::<u16, u8>(&[0, 1, 2, 0, 2, 3]).to_vec(),
            floats(&[0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0, 0.0]),
            floats(&[0.0, 1.0]),
            floats(&[-0.8, 0.6, 0.4, 0.9, 0.8, -0.3]),
            [0, 0, 0, 0].repeat(4),
            floats(&[1.0, 0.0, 0.0, 0.0].repeat(4)),
            floats(&[0.3, 0.3, 0.3, 0.0, 0.0, 0.0]),
            floats(&[-0.5, 1.6, 0.0, 0.7, 1.2, 0.5]),
            floats(&[0.0, 0.8, 4.0, 0.2, 0.9, 3.5]),
        ];
        let (mut bytes, mut views) = (Vec::new(), Vec::new());
        for piece in &pieces {
            let (start, length) = (bytes.len(), piece.len());
            views.push(format!(
                "{{ \"buffer\": 0, \"byteOffset\": {start}, \"byteLength\": {length} }}"
            ));
            bytes.extend(piece);
        }
        let scene = SCENE.replace("VIEWS", &views.join(", "));
        let scene = scene.replace("LENGTH", &bytes.len().to_string());
        let stage = Self { folder };
        let write = |name: &str, bytes: &[u8]| {
            fs::write(stage.folder.path().join(name), bytes).expect("written");
        };
        write("moving.bin", &bytes);
        write("moving.gltf", scene.as_bytes());
        write("moving.look.toml", LOOK.as_bytes());
        write("blink.wgsl", BLINK.as_bytes());
        stage
    }

    fn sequence(&self) -> Sequence {
        let inputs = Inputs {
            scene: self.folder.path().join("moving.gltf"),
            look: Some(self.folder.path().join("moving.look.toml")),
            textures: vec![self.folder.path().to_owned()],
            camera: None,
        };
        let read = Sequence::read(inputs, System::default(), &[]);
        read.unwrap_or_else(|error| panic!("{error}"))
    }

    fn at(&self, seconds: f64) -> Opening {
        let opening = self.sequence().once(&moment(seconds));
        opening.unwrap_or_else(|error| panic!("{error}"))
    }
}

fn moment(seconds: f64) -> Moment {
    Moment {
        seconds,
        motion: Motion::Usual,
    }
}

fn settings(opening: &Opening, seconds: f64, first_sample: u32) -> RenderSettings {
    by(Method::Path, opening, seconds, first_sample)
}

fn by(method: Method, opening: &Opening, seconds: f64, first_sample: u32) -> RenderSettings {
    RenderSettings {
        method,
        // Enough to teach caches what so small a picture needs.
        paths_ahead: 1 << 14,
        max_depth: 3,
        time: seconds as f32,
        frame_index: (seconds * 24.0) as u32,
        first_sample,
        ..RenderSettings::new(32, 24, &opening.loaded().camera)
    }
}

fn started(device: &Device, opening: Opening, seconds: f64, first_sample: u32) -> Session {
    let settings = settings(&opening, seconds, first_sample);
    started_with(device, opening, settings)
}

fn started_with(device: &Device, opening: Opening, settings: RenderSettings) -> Session {
    let device = device.clone();
    let session = opening.start(
        Arc::new(move || Ok(device.clone())),
        Arc::new(move |camera| RenderSettings {
            camera,
            ..settings.clone()
        }),
    );
    session.unwrap_or_else(|error| panic!("{error}"))
}

/// A session that shows what was read at another moment; a new one at first.
fn gone_on(former: Option<Session>, device: &Device, opening: Opening, seconds: f64) -> Session {
    let Some(mut session) = former else {
        return started(device, opening, seconds, 0);
    };
    let settings = settings(&opening, seconds, 0);
    session
        .show(opening, &settings, false)
        .expect("it is shown");
    session
}

fn film(session: &mut Session, spp: u32) -> Film {
    while !(session.step(spp))
        .unwrap_or_else(|error| panic!("{error}"))
        .is_done()
    {}
    let snapshot = session.snapshot();
    snapshot.unwrap_or_else(|error| panic!("{error}")).film
}

/// The device of the tests, and the processor where it is another one: hierarchies of both kinds are brought up to date.
fn devices() -> Vec<Device> {
    let usual = device::open();
    let native = Device::open(&DeviceChoice::Native(2)).ok();
    let driver = device::open_driver();
    usual.into_iter().chain(native).chain(driver).collect()
}

/// Forwards, back, and to where a square is gone.
const TIMES: [f64; 5] = [0.0, 0.25, 0.75, 0.25, 1.0];

#[test]
fn each_moment_is_as_if_there_were_no_other() {
    let stage = Stage::new();
    for device in devices() {
        let mut sequence = stage.sequence();
        let mut session: Option<Session> = None;
        let mut former: Option<Film> = None;
        for seconds in TIMES {
            let opening = sequence.at(&moment(seconds)).expect("it is read");
            let mut shown = gone_on(session.take(), &device, opening, seconds);
            let found = film(&mut shown, 4);
            let alone = film(&mut started(&device, stage.at(seconds), seconds, 0), 4);
            let name = &device.description().name;
            assert!(found == alone, "after {seconds} s on {name}");
            assert!(former.replace(found) != Some(alone), "something moves");
            session = Some(shown);
        }
    }
}

#[test]
fn a_session_goes_to_other_moments_and_is_edited_there() {
    let stage = Stage::new();
    let Some(device) = device::open() else { return };
    let rest = Moment::default();
    let opening = stage.sequence().once(&rest).expect("it is read");
    let mut session = started(&device, opening, 0.0, 0);
    let first = film(&mut session, 4);
    let made = |session: &Session| session.device().counts().pipelines;
    // Pictures of even numbers: a session knows none, and the texture asks for it.
    for seconds in [0.25, 0.75] {
        let moment = moment(seconds);
        let before = made(&session);
        session.set_moment(&moment).expect("it is shown");
        let found = film(&mut session, 4);
        assert_eq!(made(&session), before, "nothing is compiled");
        let alone = film(&mut started(&device, stage.at(seconds), seconds, 0), 4);
        assert!(found == alone, "after {seconds} s");
    }

    // What is written to buffers, and what is built anew, is of that moment: the second one leaves a value with keys.
    let edits = [
        Edit::material("Painted", "roughness", Value::number(0.3)),
        Edit::environment("color", Value::numbers(&[0.5, 0.2, 0.1])),
    ];
    for edit in edits {
        session.edit(&edit).expect("it can be edited");
        while session.is_building() {
            session.step(1).expect("rendered");
        }
        let look = stage.folder.path().join("moving.look.toml");
        fs::write(look, session.look_text()).expect("written");
        let alone = film(&mut started(&device, stage.at(0.75), 0.75, 0), 4);
        assert!(film(&mut session, 4) == alone, "after {edit:?}");
    }
    // Keys within a list, too.
    let keyed = "[material.Grey]\nbase_color = [{ keys = [[0, 0.0], [1, 1.0]] }, 0.2, 0.1]\n";
    let text = session.look_text().replace("[material.Grey]\n", keyed);
    session.replace_look(&text).expect("a look");
    while session.is_building() {
        session.step(1).expect("rendered");
    }
    fs::write(stage.folder.path().join("moving.look.toml"), &text).expect("written");
    let alone = film(&mut started(&device, stage.at(0.75), 0.75, 0), 4);
    assert!(film(&mut session, 4) == alone);
    session.set_moment(&rest).expect("it is shown");
    let opening = stage.sequence().once(&rest).expect("it is read");
    let alone = film(&mut started(&device, opening, 0.0, 0), 4);
    assert!(film(&mut session, 4) == alone && alone != first);
}

#[test]
fn a_moment_that_is_asked_for_while_something_is_built_and_makes_no_sense_is_forgotten() {
    let stage = Stage::new();
    let Some(device) = device::open() else { return };
    // After three quarters of a second the camera is where it looks at.
    let camera = "[camera]\nlook_at = [0, 0, 0]\nposition = { keys = [[0, [0, 1, 4]], [0.75, [0, 0, 0]]] }\n";
    let look = stage.folder.path().join("moving.look.toml");
    fs::write(look, format!("{LOOK}{camera}")).expect("written");
    let (first, second, none) = (moment(0.25), moment(0.5), moment(0.75));
    let mut session = started(&device, stage.at(0.25), 0.25, 0);
    let ask = |session: &mut Session, wanted: &Moment| {
        session.assets_changed();
        session.set_moment(wanted).expect("it waits");
        assert_eq!((session.moment(), session.shown_moment()), (wanted, &first));
        while session.is_building() {
            session.step(1).expect("rendered");
        }
    };
    ask(&mut session, &none);
    let problems = session.problems();
    let said: Vec<&str> = problems.iter().map(|p| p.message.as_str()).collect();
    assert_eq!(said.len(), 1, "{said:?}");
    assert_eq!((session.moment(), session.shown_moment()), (&first, &first));
    ask(&mut session, &second);
    assert!(session.problems().is_empty());
    assert_eq!(session.shown_moment(), &second);
}

#[test]
fn only_what_changes_is_made_anew() {
    let stage = Stage::new();
    let Some(device) = device::open() else { return };
    let mut sequence = stage.sequence();
    let opening = sequence.at(&moment(0.1)).expect("it is read");
    let mut session = started(&device, opening, 0.1, 0);
    film(&mut session, 1);
    let made = |session: &Session| session.device().counts().pipelines;
    let before = made(&session);
    for seconds in [0.2, 0.6] {
        let opening = sequence.at(&moment(seconds)).expect("it is read");
        let settings = settings(&opening, seconds, 0);
        session
            .show(opening, &settings, false)
            .expect("it is shown");
        film(&mut session, 1);
    }
    assert_eq!(made(&session), before, "nothing is compiled");
}

#[test]
fn an_open_shutter_gathers_what_each_moment_would() {
    let stage = Stage::new();
    let Some(device) = device::open() else { return };
    for method in [Method::Path, Method::Cache, Method::CachePhotons] {
        let mut sequence = stage.sequence();
        let mut session: Option<Session> = None;
        let mut sum: Option<Film> = None;
        const EACH: u32 = 3;
        for (number, seconds) in [0.1, 0.3, 0.5].into_iter().enumerate() {
            let first = EACH * number as u32;
            let opening = sequence.at(&moment(seconds)).expect("it is read");
            let shown = by(method, &opening, seconds, 0);
            let mut exposed = match session.take() {
                None => started_with(&device, opening, shown),
                Some(mut session) => {
                    session.show(opening, &shown, true).expect("it is shown");
                    session
                }
            };
            let gathered = film(&mut exposed, first + EACH);
            let opening = stage.at(seconds);
            let apart = by(method, &opening, seconds, first);
            let alone = film(&mut started_with(&device, opening, apart), EACH);
            match &mut sum {
                Some(sum) => sum.add(&alone),
                None => sum = Some(alone),
            }
            let is_sum = sum.as_ref() == Some(&gathered);
            assert!(is_sum, "{method:?}, after {seconds} s");
            session = Some(exposed);
        }
    }
}

/// A sky that is black at first sends no photons then, and is not taken for one that never does.
#[test]
fn a_sky_that_lights_up_sends_photons() {
    let stage = Stage::new();
    // Bright in one of eight texels.
    let texels = (0..8).flat_map(|at| {
        if at == 1 {
            [128, 128, 128, 134]
        } else {
            [128, 128, 128, 125]
        }
    });
    let mut sky = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    sky.extend(texels);
    let write = |name: &str, bytes: &[u8]| {
        fs::write(stage.folder.path().join(name), bytes).expect("written");
    };
    write("sky.hdr", &sky);
    write(
        "moving.look.toml",
        b"environment = { image = 'sky.hdr', intensity = { keys = [[0.0, 0.0], [1.0, 1.0]] } }
[material.Painted]
metallic = 1.0
roughness = 0.0
",
    );
    let Some(device) = device::open() else { return };
    let mut sequence = stage.sequence();
    let opening = sequence.at(&moment(0.0)).expect("it is read");
    // It is read once, however its light changes.
    fs::remove_file(stage.folder.path().join("sky.hdr")).expect("it was there");
    let first = by(Method::Photons, &opening, 0.0, 0);
    let mut session = started_with(&device, opening, first);
    film(&mut session, 2);
    let opening = sequence.at(&moment(1.0)).expect("it is read");
    let second = by(Method::Photons, &opening, 1.0, 0);
    session.show(opening, &second, false).expect("it is shown");
    let found = film(&mut session, 8);
    write("sky.hdr", &sky);
    let opening = stage.at(1.0);
    let alone = film(&mut started_with(&device, opening, second), 8);
    assert!(found == alone);
}

/// One square that grows from nothing within a second, as what is not to be seen at first has it.
const GROWING: &str = r#"{
  "asset": { "version": "2.0" },
  "scene": 0,
  "scenes": [{ "nodes": [0] }],
  "nodes": [{ "mesh": 0, "scale": [0, 0, 0] }],
  "materials": [{ "emissiveFactor": [1, 0.5, 0.25], "doubleSided": true }],
  "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
  "animations": [{
    "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }],
    "samplers": [{ "input": 1, "output": 2 }]
  }],
  "accessors": [
    { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] },
    { "bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR" },
    { "bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3" }
  ],
  "bufferViews": [
    { "buffer": 0, "byteLength": 36 },
    { "buffer": 0, "byteOffset": 36, "byteLength": 8 },
    { "buffer": 0, "byteOffset": 44, "byteLength": 24 }
  ],
  "buffers": [{ "byteLength": 68, "uri": "growing.bin" }]
}"#;

#[test]
fn what_is_nowhere_at_a_moment_leaves_the_sky() {
    let Some(device) = device::open() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let corners = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    let numbers: Vec<f32> = [&corners[..], &[0.0, 1.0], &[0.0; 3], &[1.0; 3]].concat();
    let path = |name: &str| folder.path().join(name);
    fs::write(
        path("growing.bin"),
        bytemuck::cast_slice::<f32, u8>(&numbers),
    )
    .expect("written");
    fs::write(path("growing.gltf"), GROWING).expect("written");
    fs::write(
        path("a.look.toml"),
        "environment = { color = [0.5, 0.25, 1] }",
    )
    .expect("written");
    let inputs = Inputs {
        scene: path("growing.gltf"),
        look: Some(path("a.look.toml")),
        textures: Vec::new(),
        camera: None,
    };
    let sequence = Sequence::read(inputs, System::default(), &[]);
    let mut sequence = sequence.unwrap_or_else(|error| panic!("{error}"));
    let mut session: Option<Session> = None;
    for seconds in [0.0, 0.5, 0.0] {
        let opening = sequence.at(&moment(seconds)).expect("it is read");
        let mut shown = gone_on(session.take(), &device, opening, seconds);
        let pixels = film(&mut shown, 4).mean();
        let is_sky = |rgb: &[f32; 3]| *rgb == [0.5, 0.25, 1.0];
        assert_eq!(pixels.iter().all(is_sky), seconds == 0.0, "{pixels:?}");
        session = Some(shown);
    }
}
