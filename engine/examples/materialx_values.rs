//! Values of MaterialX documents at points: for each `NAME.mtlx` of a folder what drives the emission of its materials, as three
//! 32-bit floats a point, in `NAME.MATERIAL.f32`. `cargo xtask materialx` compares them with those of another implementation.
//!
//! `cargo run --package engine --example materialx_values -- FOLDER POINTS.f32 [TEXTURES]`; textures of the folder TEXTURES take
//! the place of those in the program.

use std::error::Error;
use std::path::Path;

use device::{Device, DeviceChoice};
use engine::evaluate::{Evaluator, Point};
use engine::isolated::{Isolated, Subject};
use engine::procedural::TextureSources;
use engine::scene::look::{Look, Value};
use engine::system::Disk;
use materialx::{Converted, Document, Wanted, convert, look_text};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, points, textures) = match &arguments[..] {
        [folder, points] => (folder, points, &[][..]),
        [folder, points, textures @ ..] => (folder, points, textures),
        _ => return Err("usage: materialx_values FOLDER POINTS.f32 [TEXTURES]".into()),
    };
    let sources = TextureSources::search(textures)?;
    let device = Device::open(&DeviceChoice::Native(1))?;
    let bytes = std::fs::read(points)?;
    let positions = bytemuck::pod_collect_to_vec::<u8, [f32; 3]>(&bytes);
    let points: Vec<Point> = (positions.iter())
        .map(|position| {
            // A plane that looks along z.
            let normal = [0.0, 0.0, 1.0];
            let point = Point::new().with("WorldPos", position);
            point.with("Normal", &normal).with("LocalNormal", &normal)
        })
        .collect();
    let mut paths: Vec<_> = std::fs::read_dir(folder)?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "mtlx"));
    paths.sort();
    for path in paths {
        if let Err(error) = values(&device, &sources, &path, &points) {
            println!("{}: {error}", path.display());
        }
    }
    Ok(())
}

fn values(
    device: &Device,
    sources: &TextureSources,
    path: &Path,
    points: &[Point],
) -> Result<(), Box<dyn Error>> {
    let document = Document::read(&Disk, path)?;
    let wanted = Wanted {
        folder: path.parent().unwrap_or(Path::new("")).to_owned(),
        ..Wanted::default()
    };
    let converted = convert(&document, &Disk, &wanted)?;
    for warning in converted.warnings.iter() {
        println!("{}: {}", path.display(), warning.message);
    }
    for material in &converted.materials {
        let emission = material
            .parameters
            .iter()
            .find(|(key, _)| *key == "emission");
        let values = match emission.map(|(_, value)| value) {
            Some(Value::Text(link)) => driven(device, sources, path, &converted, link, points)?,
            Some(Value::List(numbers)) => {
                let number = |i: usize| numbers.get(i).and_then(|n| n.value.as_number());
                let constant = [0, 1, 2].map(|i| number(i).unwrap_or(0.0) as f32);
                vec![constant; points.len()]
            }
            _ => vec![[0.0; 3]; points.len()],
        };
        let out = path.with_extension(format!("{}.f32", material.name));
        std::fs::write(out, bytemuck::cast_slice(&values))?;
    }
    Ok(())
}

/// What a link gives at the points.
fn driven(
    device: &Device,
    sources: &TextureSources,
    path: &Path,
    converted: &Converted,
    link: &str,
    points: &[Point],
) -> Result<Vec<[f32; 3]>, Box<dyn Error>> {
    let (node, letters) = link.split_once('.').unwrap_or((link, "xyz"));
    let look = Look::parse(path, &look_text(converted))?;
    let isolated = Isolated::new(Subject::Node(node, &look), sources)?;
    let count = isolated.output().components();
    let values = Evaluator::new(device, isolated).evaluate(points)?;
    let picked: Vec<usize> = letters.chars().filter_map(|c| "xyzw".find(c)).collect();
    let pick = |value: &[f32; 4], i: usize| match (count, picked.get(i)) {
        (1, _) => value[0],
        (_, Some(&component)) => value[component],
        (_, None) => value[picked[0]],
    };
    Ok(values
        .iter()
        .map(|value| [0, 1, 2].map(|i| pick(value, i)))
        .collect())
}
