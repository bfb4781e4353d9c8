//! The generated kernel on its own: how long it takes to build it for many textures, and whether a hit costs more
//! because of textures and nodes that it doesn't use.

use std::cmp::Ordering;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;
use std::time::{Instant, SystemTime};

use glam::{Affine3A, Mat3A, Vec2, Vec3};
use serde::Serialize;
use texgen::{Diagnostics, SourceFile, TextureType};

use device::Device;
use engine::procedural::{Procedural, SourcesError, TextureSources};
use engine::renderer::{ReloadError, RenderError, RenderSettings, Renderer};
use engine::scene::look::{Look, LookError};
use engine::scene::{Camera, Environment, Instance, Material, Mesh, Projection, Scene};

/// Unused textures, and nodes on other materials, in the second measurement.
const OTHERS: usize = 100;
/// Textures of the nodes on other materials in one of its cases.
const FEW: usize = 10;
/// Side of the picture in which hits are timed, all of it covered.
const SIDE: u32 = 256;
/// Samples per pixel of one timing.
const SAMPLES: u32 = 4;
/// Timings of each case, in turn.
const ROUNDS: usize = 9;
/// More textures than these are built, but not run, on a software driver: it takes minutes or more to compile them.
pub(super) const MOST_RUN_ON_CPU: usize = 30;

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum KernelBenchError {
    /// The textures can't be read.
    #[error(transparent)]
    Sources(#[from] SourcesError),
    /// A texture that is needed is not there, or is wrong.
    #[error("{0}")]
    Textures(Diagnostics),
    /// There are none.
    #[error("there are no textures to measure: name a folder with --textures DIR")]
    Empty,
    /// The look that is made of them.
    #[error(transparent)]
    Look(#[from] LookError),
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A kernel that can't be built.
    #[error(transparent)]
    Reload(#[from] ReloadError),
}

impl From<Diagnostics> for KernelBenchError {
    fn from(problems: Diagnostics) -> Self {
        Self::Textures(problems)
    }
}

/// What it takes to make the kernel the first time, in seconds.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct FirstTime {
    /// Reading and checking the textures, one by one, and the graph of their nodes.
    pub textures: f64,
    /// Reading and checking the kernel's text.
    pub parsing: f64,
    /// Compiling it.
    pub compiling: f64,
}

/// Seconds until a changed texture is seen.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BuildTime {
    /// From the changed text to the pipeline, in the background: textures, graph, shader module, pipeline.
    pub build: f64,
    /// Of that, reading and checking the kernel's text.
    pub parsing: f64,
    /// Of that, compiling it.
    pub compiling: f64,
    /// By how much the first wave takes longer than the next: some drivers compile only then. None where no wave was
    /// run, because a software driver would compile for too long.
    pub first_wave: Option<f64>,
}

/// How long it takes to build the kernel again after one texture of several has changed.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Rebuild {
    /// Textures in the kernel.
    pub textures: usize,
    /// Lines of the kernel's generated text.
    pub lines: usize,
    /// The kernel with all of them, before any of it was known.
    pub first: FirstTime,
    /// A text that was never seen before.
    pub cold: BuildTime,
    /// A text that was built before.
    pub warm: BuildTime,
}

/// What a hit costs beside things that it doesn't use.
#[derive(Debug, Clone, Serialize)]
pub struct HitCost {
    /// What there is besides.
    pub what: &'static str,
    /// Textures in the kernel.
    pub textures: usize,
    /// Lines of the kernel's generated text.
    pub lines: usize,
    /// Of the texture kernel, nanoseconds for each hit; median.
    pub nanoseconds: f64,
    /// Median ratio to the first case, timed in turn.
    pub ratio: f64,
}

/// Measures the building of a kernel of so many textures: variants of those in `sources`.
///
/// # Errors
/// The textures are wrong, or the device.
pub fn rebuild(
    device: &Device,
    sources: &TextureSources,
    textures: usize,
) -> Result<Rebuild, KernelBenchError> {
    let originals = originals(sources)?;
    let seed = fresh_number();
    let variant = |number: usize, seed: u64| {
        let texture = &originals[number % originals.len()];
        variant(texture, &format!("t{number:03}"), seed + number as u64)
    };
    let mut all = TextureSources::default();
    let mut look = String::new();
    for number in 0..textures {
        let file = variant(number, seed);
        all.insert(file.name(), file.text());
        node(&mut look, number, file.name(), number + 1);
    }
    let (mut renderer, textures_took) = renderer(device, &look, &all, textures, 64)?;
    let cost = renderer.texture_kernel_cost().unwrap_or_default();
    let first = FirstTime {
        textures: textures_took,
        parsing: cost.parsing.as_secs_f64(),
        compiling: cost.compiling.as_secs_f64(),
    };
    let lines = renderer.procedural().kernel().wgsl.lines().count();
    let is_run = !device.traits().compiles_slowly || textures <= MOST_RUN_ON_CPU;
    if is_run {
        wave(&mut renderer)?;
    }
    let mut time = |seed: u64| -> Result<BuildTime, KernelBenchError> {
        let start = Instant::now();
        let reload = renderer.begin_reload(vec![variant(0, seed)]);
        renderer.finish_reload(reload)?;
        let build = start.elapsed().as_secs_f64();
        let cost = renderer.texture_kernel_cost().unwrap_or_default();
        let first_wave = match is_run {
            true => {
                let first = wave(&mut renderer)?;
                let next = wave(&mut renderer)?.min(wave(&mut renderer)?);
                Some((first - next).max(0.0))
            }
            false => None,
        };
        Ok(BuildTime {
            build,
            parsing: cost.parsing.as_secs_f64(),
            compiling: cost.compiling.as_secs_f64(),
            first_wave,
        })
    };
    let (mut cold, mut warm) = (Vec::new(), Vec::new());
    for round in 0..3 {
        cold.push(time(seed + 1_000_000 * (round + 1))?);
        warm.push(time(seed)?);
    }
    Ok(Rebuild {
        textures,
        lines,
        first,
        cold: median_time(&cold),
        warm: median_time(&warm),
    })
}

/// Measures what a hit costs without anything besides, with unused textures in the folder, and with nodes on other
/// materials, whose textures are those of the measured one, ten others, or `most_textures` others; ten only where they are no more than
/// these. The last row is the first case once more: how far timings differ by themselves.
///
/// # Errors
/// The textures of the measured material (`rust_color`, `rust_mask`, `mix_color`) are missing or wrong, or the device.
pub fn hits(
    device: &Device,
    sources: &TextureSources,
    most_textures: usize,
) -> Result<Vec<HitCost>, KernelBenchError> {
    let can_run = if device.traits().compiles_slowly {
        MOST_RUN_ON_CPU
    } else {
        OTHERS
    };
    let most = most_textures.clamp(1, can_run);
    let originals = originals(sources)?;
    let mut more = sources.clone();
    let mut of_the_same = SUBJECT.to_owned();
    let mut of_others: Vec<_> = (others(most).into_iter())
        .map(|(what, count)| (what, count, SUBJECT.to_owned()))
        .collect();
    for number in 0..OTHERS {
        let texture = &originals[number % originals.len()];
        let name = format!("other{number:03}");
        more.insert(&name, variant(texture, &name, number as u64).text());
        for (_, count, look) in &mut of_others {
            let other = format!("other{:03}", number % *count);
            node(look, number, &other, number + 1);
        }
        let same = ["rust_color", "rust_mask", "mix_color"][number % 3];
        node(&mut of_the_same, number, same, number + 1);
    }
    let mut cases: Vec<(&'static str, &str, &TextureSources)> = vec![
        ("nothing", SUBJECT, sources),
        ("100 unused textures in the folder", SUBJECT, &more),
        (
            "100 nodes on 100 other materials",
            of_the_same.as_str(),
            sources,
        ),
    ];
    cases.extend((of_others.iter()).map(|(what, _, look)| (*what, look.as_str(), &more)));
    cases.push(("nothing, again", SUBJECT, sources));
    let mut renderers = Vec::new();
    for &(_, look, textures) in &cases {
        let (mut renderer, _) = renderer(device, look, textures, OTHERS, SIDE)?;
        time_hits(&mut renderer)?; // compiles what isn't compiled yet
        renderers.push(renderer);
    }
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..ROUNDS {
        for (renderer, times) in renderers.iter_mut().zip(&mut times) {
            times.push(time_hits(renderer)?);
        }
    }
    let rows = cases.iter().zip(&renderers).zip(&times);
    Ok(rows
        .map(|(((what, ..), renderer), own)| {
            let ratios = own.iter().zip(&times[0]).map(|(own, first)| own / first);
            HitCost {
                what,
                textures: renderer.procedural().graph().library().textures().len(),
                lines: renderer.procedural().kernel().wgsl.lines().count(),
                nanoseconds: median(own.iter().copied()),
                ratio: median(ratios),
            }
        })
        .collect())
}

/// Cases of other textures than the measured ones, none of which has more than so many: what they are called, and how many they have.
fn others(most: usize) -> Vec<(&'static str, usize)> {
    let few = ("the same, of 10 other textures", FEW);
    match most.cmp(&FEW) {
        Ordering::Less => vec![("the same, of fewer other textures", most)],
        Ordering::Equal => vec![few],
        Ordering::Greater => vec![few, ("the same, of more other textures", most)],
    }
}

/// The material whose hits are timed. Occlusion is traced elsewhere, and is no matter here.
const SUBJECT: &str = r#"
[ao.least]
distance = 0.1
samples = 1
[node.mask]
texture = "rust_mask"
[node.rust]
texture = "rust_color"
[node.subject]
texture = "mix_color"
a = "rust"
factor = "mask"
[material."material 0"]
base_color = "subject"
roughness = "mask"
"#;

/// Adds a node of a texture that drives another material, to the text of a look.
fn node(look: &mut String, number: usize, texture: &str, material: usize) {
    // Writing to a string can't fail.
    let _ = write!(
        look,
        "[node.n{number}]\ntexture = \"{texture}\"\n[material.\"material {material}\"]\nmetallic = \"n{number}.x\"\n"
    );
}

/// Seconds of the texture kernel over all hits of a picture, as nanoseconds for each.
fn time_hits(renderer: &mut Renderer) -> Result<f64, KernelBenchError> {
    renderer.restart();
    renderer.time_passes()?;
    renderer.device().finish_compiling();
    let start = Instant::now();
    renderer.render(SAMPLES)?;
    let seconds = start.elapsed().as_secs_f64();
    let stats = renderer.stats()?;
    let pass = stats.passes.iter().find(|pass| pass.name == "proctex");
    // A device without timestamps: all passes together.
    let seconds = pass.map_or(seconds, |pass| pass.milliseconds * 1e-3);
    let hits = f64::from(SIDE * SIDE * SAMPLES);
    Ok(seconds * 1e9 / hits)
}

/// Seconds of the first wave of a picture.
fn wave(renderer: &mut Renderer) -> Result<f64, KernelBenchError> {
    renderer.restart();
    let start = Instant::now();
    renderer.step(1)?;
    Ok(start.elapsed().as_secs_f64())
}

/// Textures that need no image: nothing else can't be had by default.
pub(super) fn originals(sources: &TextureSources) -> Result<Vec<TextureType>, KernelBenchError> {
    let mut textures = Vec::new();
    for name in sources.names().filter_map(|name| sources.read(name)) {
        let texture = TextureType::parse(name?)?;
        if texture.parameters().iter().all(|p| p.default.is_some()) {
            textures.push(texture);
        }
    }
    match textures.is_empty() {
        true => Err(KernelBenchError::Empty),
        false => Ok(textures),
    }
}

/// The same texture under another name, with a result that differs by next to nothing: no cache knows its kernel.
pub(super) fn variant(texture: &TextureType, name: &str, number: u64) -> SourceFile {
    let text = texture.file().text();
    let entry = text.find("fn userProc").unwrap_or(0);
    let body = entry + text[entry..].find("\n}").unwrap_or(text.len() - entry);
    let returned = text[..body].rfind("return ").and_then(|at| {
        let at = at + "return ".len();
        Some(at..at + text[at..].find(';')?)
    });
    let tiny = (number % (1 << 24)) as f64 * 1e-15;
    let with = |value: String| {
        let returned = returned.clone().unwrap_or_default();
        format!(
            "{}{value}{}",
            &text[..returned.start],
            &text[returned.end..]
        )
    };
    let value = &text[returned.clone().unwrap_or_default()];
    let whole = with(format!("({value}) + {}({tiny:e})", texture.output()));
    // Of a struct the last member.
    let member = last_argument(value).map(|last| {
        let (before, after) = (&value[..last.start], &value[last.end..]);
        let last = value[last].trim();
        with(format!("{before} ({last}) + {tiny:e} * ({last}){after}"))
    });
    let path = format!("{name}.wgsl");
    let file = |text: String| SourceFile::new(name, path.clone(), text);
    let mut changed = [Some(whole), member].into_iter().flatten().map(file);
    let valid = changed.find(|changed| TextureType::parse(changed.clone()).is_ok());
    valid.unwrap_or_else(|| file(text.to_owned()))
}

/// Where the last argument of a call stands.
fn last_argument(call: &str) -> Option<Range<usize>> {
    let (open, end) = (call.find('(')?, call.rfind(')')?);
    let mut depth = 0;
    let mut start = open + 1;
    for (at, letter) in call
        .char_indices()
        .take_while(|&(at, _)| at < end)
        .skip(open + 1)
    {
        match letter {
            '(' => depth += 1,
            ')' => depth -= 1,
            ',' if depth == 0 => start = at + 1,
            _ => {}
        }
    }
    Some(start..end)
}

/// Another number each time.
pub(super) fn fresh_number() -> u64 {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    now.map_or(0, |now| now.as_micros() as u64)
}

/// A square that fills the picture, and small ones behind the camera for the other materials; and the seconds that textures
/// and graph took.
fn renderer(
    device: &Device,
    look: &str,
    sources: &TextureSources,
    others: usize,
    side: u32,
) -> Result<(Renderer, f64), KernelBenchError> {
    let mut scene = Scene {
        environment: Environment::Constant(Vec3::ONE),
        ..Scene::default()
    };
    for number in 0..=others as u32 {
        let (half, z) = match number {
            0 => (2.0, 0.0),
            _ => (0.01, 10.0 + number as f32),
        };
        let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, z);
        scene.meshes.push(Mesh {
            name: format!("square {number}"),
            positions: vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            normals: vec![Vec3::Z; 4],
            uv0: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            triangle_materials: vec![number; 2],
            ..Mesh::default()
        });
        scene.instances.push(Instance {
            name: format!("square {number}"),
            mesh: number,
            transform: Affine3A::IDENTITY,
            asset: None,
        });
        scene.materials.push(Material {
            name: format!("material {number}"),
            ..Material::default()
        });
    }
    let look = Look::parse(Path::new("bench.look.toml"), look)?;
    let start = Instant::now();
    let procedural = Procedural::build(&look, &mut scene, sources)?;
    let textures = start.elapsed().as_secs_f64();
    let camera = Camera {
        name: "front".to_owned(),
        transform: Affine3A {
            matrix3: Mat3A::IDENTITY,
            translation: Vec3::Z.into(),
        },
        projection: Projection::Orthographic { y_mag: 1.0 },
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: 1.0,
    };
    let settings = RenderSettings {
        // Hits of the camera's rays alone.
        max_depth: 1,
        ..RenderSettings::new(side, side, &camera)
    };
    let renderer = Renderer::new(device, &scene, &procedural, &settings)?;
    Ok((renderer, textures))
}

fn median_time(times: &[BuildTime]) -> BuildTime {
    BuildTime {
        build: median(times.iter().map(|time| time.build)),
        parsing: median(times.iter().map(|time| time.parsing)),
        compiling: median(times.iter().map(|time| time.compiling)),
        first_wave: (times.first().and_then(|time| time.first_wave))
            .map(|_| median(times.iter().filter_map(|time| time.first_wave))),
    }
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_are_valid_and_differ() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../user_textures");
        let sources = TextureSources::scan(&[folder]).expect("the folder is there");
        let originals = originals(&sources).expect("they are right");
        assert!(originals.len() >= 7);
        for texture in &originals {
            let [a, b] = [1, 2].map(|number| variant(texture, "a", number));
            assert_ne!(a.text(), b.text(), "{}", texture.name());
            TextureType::parse(a).unwrap_or_else(|problems| panic!("{problems}"));
        }
    }

    #[test]
    fn no_more_other_textures_are_measured_than_are_asked_for() {
        let counts = |most: usize| -> Vec<usize> {
            others(most).into_iter().map(|(_, count)| count).collect()
        };
        assert_eq!(counts(1), [1]);
        assert_eq!(counts(9), [9]);
        assert_eq!(counts(10), [10]);
        assert_eq!(counts(30), [10, 30]);
    }

    #[test]
    fn the_middle_one_is_the_median() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), 2.0);
        assert_eq!(median([].into_iter()), 0.0);
    }
}
