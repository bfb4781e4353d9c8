//! How long an edit of a large look takes: from the call to the command submitted, and until there is a picture.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use std::{fs, io};

use device::{Device, DeviceChoice};
use engine::aside::Leftover;
use engine::renderer::RenderSettings;
use engine::scene::look::{AoSettings, Value};
use engine::session::{Edit, Inputs, Session, SessionError};
use texgen::{Interpolation, Ramp};

/// Nodes of a material, each linked to the one before.
const CHAIN: u32 = 10;
/// Pixels of the picture.
const SIZE: (u32, u32) = (640, 360);
/// Edits after each of which a picture is waited for.
const PICTURES: u32 = 20;

const TEXTURE: &str = "/// @param scale = 3
/// @param amount = 0.5
fn userProc(scale: f32, amount: f32, color: vec3f, ramp: ramp1D) -> f32 {
    let x = fract(dot(readAttr(WorldPos).xyz, color) * scale) * readAttr(AO).x;
    return mix(rampEval(ramp, x).x, x, amount);
}
";

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum EditBenchError {
    /// There is no room for scene and look among the temporary files.
    #[error(transparent)]
    Files(#[from] io::Error),
    /// The render, or an edit of it.
    #[error(transparent)]
    Session(#[from] SessionError),
}

/// Milliseconds of edits of one kind.
#[derive(Debug, Clone)]
pub struct EditTimes {
    /// What was edited.
    pub what: &'static str,
    /// From the call to the command submitted, of each edit.
    pub milliseconds: Vec<f64>,
}

/// What was measured.
#[derive(Debug, Clone)]
pub struct EditReport {
    /// Of the device, for people.
    pub device: String,
    /// Nodes of the look.
    pub nodes: u32,
    /// Materials that they drive.
    pub materials: u32,
    /// To the command submitted, by kind of edit.
    pub edits: Vec<EditTimes>,
    /// To a picture of a sample per pixel, after edits of arguments.
    pub pictures: EditTimes,
    /// Pipelines that the edits created.
    pub pipelines: u64,
    /// Shader modules that they created.
    pub shader_modules: u64,
}

impl EditReport {
    /// The figures as a table for people.
    pub fn table(&self) -> String {
        let mut rows = String::new();
        for times in self.edits.iter().chain([&self.pictures]) {
            // Writing to a string can't fail.
            let shown = percentiles(times.milliseconds.clone());
            let _ = writeln!(rows, "{:<36}{shown}", times.what);
        }
        format!(
            "{} nodes, {} materials, {} x {} pixels\n{}\n\n\
             milliseconds to the command submitted   median     99 %  longest\n{rows}\n\
             {} pipelines and {} shader modules were created by the edits",
            self.nodes,
            self.materials,
            SIZE.0,
            SIZE.1,
            self.device,
            self.pipelines,
            self.shader_modules
        )
    }
}

/// Measures `edits` edits of each kind on a look of so many nodes. `prepared` is called when the measuring begins.
///
/// # Errors
/// There is no device, or no room for the scene among the temporary files.
pub fn measure(
    nodes: u32,
    edits: u32,
    device: &DeviceChoice,
    prepared: impl FnOnce(),
) -> Result<EditReport, EditBenchError> {
    let folder = tempfile::tempdir()?;
    let _leftover = Leftover::new(folder.path().to_owned());
    let materials = nodes.div_ceil(CHAIN);
    write_files(folder.path(), nodes, materials)?;
    let device = device.clone();
    let inputs = Inputs {
        scene: folder.path().join("scene.gltf"),
        look: Some(folder.path().join("scene.look.toml")),
        textures: vec![folder.path().to_owned()],
        camera: None,
    };
    let settings = |camera| RenderSettings {
        max_depth: 3,
        ..RenderSettings::new(SIZE.0, SIZE.1, &camera)
    };
    let mut session = Session::open(
        inputs,
        Arc::new(move || Device::open(&device)),
        Arc::new(settings),
    )?;
    prepared();
    session.step(1)?;
    let device = session.device().clone();
    let before = device.counts();
    let mut kinds = Vec::new();
    for (what, make) in KINDS {
        let mut milliseconds = Vec::new();
        for i in 0..edits {
            for edit in make(i, nodes, materials) {
                let clock = Instant::now();
                session.edit(&edit)?;
                milliseconds.push(clock.elapsed().as_secs_f64() * 1e3);
            }
            // A wave in between now and then, as when one drags a slider.
            if i % 100 == 99 {
                session.step(1)?;
            }
        }
        kinds.push(EditTimes { what, milliseconds });
    }
    let mut milliseconds = Vec::new();
    for i in 0..PICTURES {
        let clock = Instant::now();
        for edit in argument(i, nodes, materials) {
            session.edit(&edit)?;
        }
        while !session.step(1)?.is_done() {}
        session.snapshot()?;
        milliseconds.push(clock.elapsed().as_secs_f64() * 1e3);
    }
    let after = device.counts();
    Ok(EditReport {
        device: device.description().title(),
        nodes,
        materials,
        edits: kinds,
        pictures: EditTimes {
            what: "to a picture of 1 spp",
            milliseconds,
        },
        pipelines: after.pipelines - before.pipelines,
        shader_modules: after.shader_modules - before.shader_modules,
    })
}

fn percentiles(mut times: Vec<f64>) -> String {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share).ceil() as usize];
    format!("{:>10.3}{:>9.3}{:>9.3}", at(0.5), at(0.99), at(1.0))
}

type Make = fn(u32, u32, u32) -> Vec<Edit>;

const KINDS: [(&str, Make); 9] = [
    ("an argument", argument),
    ("a ramp", ramp),
    ("a link", link),
    ("a slot of a material", slot),
    ("the mask of a blend", mask),
    ("a constant of a material", constant),
    ("an AO table", ao),
    ("the sky's intensity", sky),
    ("the camera", camera),
];

/// A number that no edit before had.
fn value(i: u32) -> f32 {
    0.05 + 0.9 * (i as f32 * 0.618_034).fract()
}

fn argument(i: u32, nodes: u32, _: u32) -> Vec<Edit> {
    let node = format!("n{}", i * 7 % nodes);
    vec![Edit::argument(
        &node,
        "amount",
        &texgen::Value::F32(value(i)),
    )]
}

fn ramp(i: u32, nodes: u32, _: u32) -> Vec<Edit> {
    let stop = |j: u32| (value(j), [value(i + j), 0.5, 0.5, 1.0]);
    let ramp = Ramp {
        stops: (0..2 + i % 3).map(stop).collect(),
        interpolation: Interpolation::Smooth,
    };
    let node = format!("n{}", i * 7 % nodes);
    vec![Edit::argument(&node, "ramp", &texgen::Value::Ramp(ramp))]
}

/// The last node of a chain reads another one of it.
fn link(i: u32, nodes: u32, materials: u32) -> Vec<Edit> {
    let (last, source) = linked(i, nodes, materials);
    vec![Edit::link(
        &format!("n{last}"),
        "scale",
        &format!("n{source}"),
    )]
}

/// The last node of a chain, and the one that it is to read.
fn linked(i: u32, nodes: u32, materials: u32) -> (u32, u32) {
    let mut chain = i % materials * CHAIN;
    // The last chain may be a single node, which can't be linked to itself.
    if chain + 1 >= nodes {
        chain = chain.saturating_sub(CHAIN);
    }
    let last = (chain + CHAIN).min(nodes) - 1;
    (last, chain + i / materials % (last - chain).max(1))
}

fn slot(i: u32, nodes: u32, materials: u32) -> Vec<Edit> {
    let node = Value::Text(format!("n{}", i * 3 % nodes));
    vec![Edit::material(
        &format!("M{}", i % (materials - 1) + 1),
        "roughness",
        node,
    )]
}

fn mask(i: u32, _: u32, _: u32) -> Vec<Edit> {
    vec![Edit::material("M0", "blend.mask", Value::number(value(i)))]
}

fn constant(i: u32, _: u32, materials: u32) -> Vec<Edit> {
    let value = Value::number(value(i));
    vec![Edit::material(
        &format!("M{}", i % (materials - 1) + 1),
        "metallic",
        value,
    )]
}

fn ao(i: u32, _: u32, _: u32) -> Vec<Edit> {
    let settings = AoSettings {
        distance: value(i),
        ..AoSettings::default()
    };
    Edit::ao("near", &settings).to_vec()
}

fn sky(i: u32, _: u32, _: u32) -> Vec<Edit> {
    vec![Edit::environment("intensity", Value::number(value(i)))]
}

fn camera(i: u32, _: u32, _: u32) -> Vec<Edit> {
    vec![Edit::camera(
        "position",
        Value::numbers(&[value(i), 12.0, 9.0]),
    )]
}

/// A floor of squares, each of its own material with a chain of nodes; the first one is a blend.
fn write_files(folder: &Path, nodes: u32, materials: u32) -> std::io::Result<()> {
    let corners: [[f32; 3]; 4] = [
        [-0.5, 0.0, 0.5],
        [0.5, 0.0, 0.5],
        [0.5, 0.0, -0.5],
        [-0.5, 0.0, -0.5],
    ];
    let mut bytes = Vec::new();
    for number in corners.iter().flatten() {
        bytes.extend(number.to_le_bytes());
    }
    for index in [0u16, 1, 2, 0, 2, 3] {
        bytes.extend(index.to_le_bytes());
    }
    fs::write(folder.join("square.bin"), bytes)?;
    let side = f64::from(materials).sqrt().ceil() as u32;
    let list =
        |item: &dyn Fn(u32) -> String| (0..materials).map(item).collect::<Vec<_>>().join(",");
    let scene = serde_json::json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": (0..materials).collect::<Vec<_>>() }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
              "min": [-0.5, 0.0, -0.5], "max": [0.5, 0.0, 0.5] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
        ],
        "buffers": [{ "byteLength": 60, "uri": "square.bin" }],
    });
    let mut text = scene.to_string();
    text.pop();
    let square = |i: u32| {
        let at = |n: u32| f64::from(n) - f64::from(side) * 0.5;
        format!(
            "{{\"mesh\":{i},\"translation\":[{},0,{}]}}",
            at(i % side),
            at(i / side)
        )
    };
    let mesh = |i: u32| {
        format!(
            "{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}},\"indices\":1,\"material\":{i}}}]}}"
        )
    };
    let material = |i: u32| format!("{{\"name\":\"M{i}\"}}");
    let _ = write!(
        text,
        ",\"nodes\":[{}],\"meshes\":[{}],\"materials\":[{}]}}",
        list(&square),
        list(&mesh),
        list(&material)
    );
    fs::write(folder.join("scene.gltf"), text)?;
    for number in 0..4 {
        fs::write(folder.join(format!("bench{number}.wgsl")), TEXTURE)?;
    }
    fs::write(folder.join("scene.look.toml"), look(nodes, materials))
}

fn look(nodes: u32, materials: u32) -> String {
    let mut look = String::from(
        "environment = { color = [1, 1, 1], intensity = 1.0 }\n\n[camera]\nposition = [0, 12, 9]\nlook_at = [0, 0, 0]\n\n[ao.near]\ndistance = 0.2\nsamples = 2\n",
    );
    for node in 0..nodes {
        let _ = write!(
            look,
            "\n[node.n{node}]\ntexture = \"bench{}\"\namount = 0.25 # of one\n",
            node % 4
        );
        if node % CHAIN > 0 {
            let _ = writeln!(look, "scale = \"n{}\"", node - 1);
        }
    }
    for material in 0..materials {
        let last = ((material + 1) * CHAIN).min(nodes) - 1;
        let _ = write!(look, "\n[material.M{material}]\nbase_color = \"n{last}\"\n");
        if material == 0 {
            look.push_str("blend = { base = \"M0\", over = \"M1\", mask = 0.5 }\n");
        }
    }
    look
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_are_a_look_that_loads() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        write_files(folder.path(), 43, 5).expect("written");
        let look = folder.path().join("scene.look.toml");
        let scene = folder.path().join("scene.gltf");
        let loaded = engine::load::load(&scene, Some(&look), &[folder.path().to_owned()]);
        let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.procedural.graph().ids().len(), 43);
        assert_eq!(loaded.scene.instanced_triangles(), 10);
    }

    #[test]
    fn no_node_is_linked_to_itself() {
        for nodes in [20_u32, 21, 22, 29, 30, 31, 101] {
            let materials = nodes.div_ceil(CHAIN);
            for i in 0..300 {
                let (last, source) = linked(i, nodes, materials);
                assert!(source < last && last < nodes, "n{last} -> n{source}");
                assert_eq!(last / CHAIN, source / CHAIN, "n{last} -> n{source}");
            }
        }
    }

    #[test]
    fn percentiles_are_of_the_times() {
        let times = (1..=100).rev().map(f64::from).collect();
        let shown = percentiles(times);
        let numbers: Vec<&str> = shown.split_whitespace().collect();
        assert_eq!(numbers, ["51.000", "100.000", "100.000"]);
    }
}
