//! Compiles the passes' WGSL to Rust, see `src/lib.rs`.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context as _, Result, bail};

/// Where the WGSL is, seen from this crate.
const PASSES: &str = "../engine/src/passes";

/// Entry points and the files that their texts begin with.
const KERNELS: &[(&str, &str)] = &[
    ("accumulate", "accumulate/entry.wgsl"),
    ("accumulate_first", "film_layers/accumulate.wgsl"),
    ("accumulate_ids", "film_layers/accumulate_ids.wgsl"),
    ("accumulate_mean", "film_layers/accumulate.wgsl"),
    ("accumulate_means", "film_layers/accumulate.wgsl"),
    ("ao", "ao/ao.wgsl"),
    ("brdf", "brdf/entry.wgsl"),
    ("by_grid", COMPARED),
    ("by_octree", COMPARED),
    ("by_tree", COMPARED),
    ("classify", "classify/entry.wgsl"),
    ("count_again", "photons/map.wgsl"),
    ("count_leaves", "photons/map.wgsl"),
    ("count_photons", "photons/sort.wgsl"),
    ("gather_end", "irradiance/gather.wgsl"),
    ("gather_first_hit", "irradiance/first_hit.wgsl"),
    ("gather_note", "irradiance/gather.wgsl"),
    ("gather_photons", "photons/gather.wgsl"),
    ("gather_start", "irradiance/gather.wgsl"),
    ("give_photons", "photons/sort.wgsl"),
    ("give_places", "photons/map.wgsl"),
    ("join_cells", "photons/map.wgsl"),
    ("learn_light", "light_cache/learn.wgsl"),
    ("look_for_sky", "irradiance/look.wgsl"),
    ("look_up_irradiance", "irradiance/look_up.wgsl"),
    ("look_up_light", "light_cache/look_up.wgsl"),
    ("note_light", "light_cache/learn.wgsl"),
    ("photon_arrive", "photons/fly.wgsl"),
    ("photon_emit", "photons/emit.wgsl"),
    ("photon_follow", "photons/fly.wgsl"),
    ("photon_start", "photons/emit.wgsl"),
    ("put_down", "photons/map.wgsl"),
    ("raygen", "raygen/entry.wgsl"),
    ("record_last_light", LIGHT),
    ("record_layers", "film_layers/record.wgsl"),
    ("record_light", LIGHT),
    ("solve_irradiance", "irradiance/solve.wgsl"),
    ("sort_photons", "photons/sort.wgsl"),
    ("split_cells", "photons/map.wgsl"),
    ("sum_lights", "photons/lights.wgsl"),
    ("traverse_closest", "traverse/entry.wgsl"),
    ("traverse_occlusion", "traverse/entry.wgsl"),
    ("weigh_lights", "photons/lights.wgsl"),
];

/// The file of those kernels that there are only where the film keeps parts of the light apart.
const LIGHT: &str = "film_layers/light.wgsl";

/// Ways to find photons that `bench gather` compares: what comes compiled would be compared with what doesn't.
const COMPARED: &str = "../../../bench/src/gather/compare.wgsl";

/// Where the standard functions of the texture language are, seen from this crate: they know nothing of one another's files.
const STANDARD: &str = "../texgen/src/standard";

/// Those of their files that have something worth compiling, and what that calls.
const STANDARD_FILES: &[&str] = &["hash", "noise", "fractal", "cells", "shape"];

/// Standard functions that take long enough for a call to cost nothing beside them.
const FUNCTIONS: &[&str] = &[
    "perlin2D",
    "perlin3D",
    "perlin3DGrad",
    "simplex3DGrad",
    "valueNoise2D",
    "valueNoise3DGrad",
    "gabor3D",
    "fbm2D",
    "fbm3D",
    "fractalSeen",
    "turbulence2D",
    "turbulence3D",
    "ridged3D",
    "voronoi2D",
    "voronoi3D",
    "voronoiEdge2D",
    "voronoiEdge3D",
    "voronoiSmooth3D",
];

/// Small functions of theirs that they call several times with different arguments: that is done in the lanes of vectors.
const CORNERS: &[&str] = &[
    "hashU1",
    "noiseGradient2",
    "noiseGradient3",
    "perlinSlope3D",
    "simplexCorner3",
    "valueCorner",
];

/// How often a device lets the loops of users' texts run; without such a limit, loops are other code.
const LOOP_LIMIT: u32 = u32::MAX;

/// The functions that the engine has in Rust.
const HOST: &[&str] = &["trace_surfaces", "trace_bundle"];

/// Override constants that only leave out what a scene doesn't have.
const OMISSIONS: &[&str] = &[
    "has_alpha",
    "has_textures",
    "has_environment",
    "has_transmission",
    "has_clear",
    "has_layers",
];

/// The others, by which a kernel does something else.
const OTHERS: &[&str] = &["energy_compensation", "has_programs", "has_program_shadows"];

/// The constant by which the film keeps parts of the light apart.
const SPLIT: &str = "splits_light";

/// The constant by which a cache of irradiance knows of surfaces that scatter light diffusely.
const LEAVES: &str = "leaves_diffuse";

/// What suits processors, as `Pass::kernel` of the engine has it: one thread traces all rays of ambient occlusion of a hit, and photons
/// are found by the grid that they are sorted into.
const FOR_PROCESSORS: [(&str, f64); 2] = [("ao_thread_per_hit", 1.0), ("photons_by_grid", 1.0)];

/// What is set, for each set of features that is compiled: those of common scenes, and those with all that may be left out,
/// which stand for the rest.
const SETS: &[(&[&str], &[&str])] = &[
    // Plain surfaces under lamps, such as a Cornell box.
    (&[], &["energy_compensation"]),
    // The same with textures.
    (&["has_textures"], &["energy_compensation"]),
    // Plain surfaces under a sky.
    (&["has_environment"], &["energy_compensation"]),
    // Textures under a sky, cut-outs among them.
    (
        &["has_textures", "has_environment"],
        &["energy_compensation"],
    ),
    (
        &["has_alpha", "has_textures", "has_environment"],
        &["energy_compensation"],
    ),
    // Plain surfaces that texture programs drive, under a sky.
    (
        &["has_environment"],
        &["energy_compensation", "has_programs"],
    ),
    // Single scattering between microfacets alone, as glTF's formula has it.
    (OMISSIONS, &[]),
    (OMISSIONS, &["energy_compensation"]),
    (OMISSIONS, &["energy_compensation", "has_programs"]),
    (OMISSIONS, OTHERS),
    (&[], &["energy_compensation", SPLIT]),
    (OMISSIONS, &["energy_compensation", SPLIT]),
    (OMISSIONS, &["energy_compensation", "has_programs", SPLIT]),
    (
        OMISSIONS,
        &[
            "energy_compensation",
            "has_programs",
            "has_program_shadows",
            SPLIT,
        ],
    ),
    (&[], &["energy_compensation", LEAVES]),
    (OMISSIONS, &["energy_compensation", LEAVES]),
    (OMISSIONS, &["energy_compensation", "has_programs", LEAVES]),
    (OMISSIONS, &["energy_compensation", LEAVES, SPLIT]),
    (
        OMISSIONS,
        &["energy_compensation", "has_programs", LEAVES, SPLIT],
    ),
];

/// Kernels that run eight invocations at a time where the processor has vectors for it. With `accumulate` nothing is gained: it
/// waits for memory. The traversal calls a function of the program for each invocation, and does little beside that. Photons are found one place
/// after the other: places that don't lie together have others around them, and lanes would wait for each other.
const IN_LANES: &[&str] = &[
    "ao",
    "brdf",
    "classify",
    "count_again",
    "count_leaves",
    "count_photons",
    "gather_end",
    "gather_first_hit",
    "gather_note",
    "gather_start",
    "give_photons",
    "give_places",
    "join_cells",
    "learn_light",
    "look_for_sky",
    "look_up_irradiance",
    "look_up_light",
    "note_light",
    "photon_arrive",
    "photon_emit",
    "photon_follow",
    "photon_start",
    "put_down",
    "raygen",
    "solve_irradiance",
    "sort_photons",
    "split_cells",
    "weigh_lights",
];

/// What the functions may use of a processor; `src/lib.rs` asks whether it is there.
const X86_64: &str = r#"#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]"#;

fn main() -> Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    let architecture = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let attributes = match architecture.as_str() {
        "x86_64" => X86_64,
        _ => "",
    };
    let out = env::var_os("OUT_DIR")
        .map(PathBuf::from)
        .context("Cargo names no OUT_DIR")?;
    let mut modules = String::new();
    let mut list = String::new();
    let mut keys = HashSet::new();
    let mut texts = HashMap::new();
    // Nothing is linked for browsers, and what isn't used needn't be compiled.
    let kernels = if architecture == "wasm32" {
        &[]
    } else {
        KERNELS
    };
    for &(entry, file) in kernels {
        if !texts.contains_key(file) {
            texts.insert(file, Text::read(file)?);
        }
        for (has, does) in SETS {
            if file == LIGHT && !does.contains(&SPLIT) {
                continue;
            }
            let program = texts[file].program(entry, &[*has, *does].concat())?;
            let key = program.key();
            if !keys.insert(key) {
                continue;
            }
            let in_lanes = architecture == "x86_64" && IN_LANES.contains(&entry);
            let lanes = in_lanes.then(|| kernel_ir::rust::lanes_module(&program, attributes));
            let rust = (lanes.flatten()).or_else(|| kernel_ir::rust::module(&program, attributes));
            let Some(rust) = rust else {
                bail!("{entry} can't be written as Rust");
            };
            let name = format!("{entry}_{}", keys.len());
            // In files of their own, since some of rustc's lints take time in proportion to all that stands before them.
            fs::write(out.join(format!("{name}.rs")), rust)?;
            let _ = writeln!(
                modules,
                "mod {name} {{ use super::*; include!(\"{name}.rs\"); }}"
            );
            // As `Ahead::new` wants it: the module was made of the program with this key.
            let _ = writeln!(list, "unsafe {{ Ahead::new({key:#034x}, {name}::entry) }},");
        }
    }
    let (mut functions, mut functions_in_lanes) = (Vec::new(), Vec::new());
    if architecture != "wasm32" {
        let in_lanes = architecture == "x86_64";
        let mut lists = [&mut functions, &mut functions_in_lanes];
        standard_functions(attributes, in_lanes, &mut modules, &mut lists)?;
    }
    let _ = writeln!(modules, "pub const NAMES: &[&str] = &{FUNCTIONS:?};");
    for (name, list) in [
        ("FUNCTIONS", functions),
        ("FUNCTIONS_IN_LANES", functions_in_lanes),
    ] {
        let _ = writeln!(
            modules,
            "pub static {name}: [AheadFunction; {}] = [\n{}];",
            list.len(),
            list.concat()
        );
    }
    let _ = writeln!(modules, "pub const OMISSIONS: &[&str] = &{OMISSIONS:?};");
    let _ = writeln!(
        modules,
        "pub static ALL: [Ahead; {}] = [\n{list}];",
        keys.len()
    );
    fs::write(out.join("kernels.rs"), modules)?;
    fs::write(out.join("tests.rs"), tests()?)?;
    Ok(())
}

/// The kernels of `tests/lanes.wgsl` in lanes, for the test beside it.
fn tests() -> Result<String> {
    let file = "tests/lanes.wgsl";
    println!("cargo::rerun-if-changed={file}");
    let text = Text::of(file, &fs::read_to_string(file)?)?;
    let (mut modules, mut list, mut names) = (String::new(), String::new(), Vec::new());
    for entry in &text.module.entry_points {
        let name = &entry.name;
        let options = kernel_ir::Options::default();
        let (module, info) = kernel_ir::with_constants(&text.module, &text.info, name, &[])?;
        let program = kernel_ir::lower(&module, &info, name, &options)?;
        let Some(rust) = kernel_ir::rust::lanes_module(&program, X86_64) else {
            bail!("{name} can't be written in lanes");
        };
        let _ = writeln!(modules, "mod {name} {{\nuse super::*;\n{rust}}}");
        let key = program.key();
        let _ = writeln!(list, "unsafe {{ Ahead::new({key:#034x}, {name}::entry) }},");
        names.push(name);
    }
    let count = names.len();
    Ok(format!(
        "{modules}const TESTS: [&str; {count}] = {names:?};\nstatic IN_LANES: [Ahead; {count}] = [\n{list}];\n"
    ))
}

/// Writes the standard functions of textures, as kernels with users' texts contain them, and lists them: for one invocation, and for
/// several at once.
fn standard_functions(
    attributes: &str,
    in_lanes: bool,
    modules: &mut String,
    [list, list_in_lanes]: &mut [&mut Vec<String>; 2],
) -> Result<()> {
    let mut text = String::new();
    for file in STANDARD_FILES {
        let path = Path::new(STANDARD).join(format!("{file}.wgsl"));
        println!("cargo::rerun-if-changed={}", path.display());
        text += &fs::read_to_string(&path)
            .with_context(|| format!("cannot read {}", path.display()))?;
    }
    // What isn't called is not in a program.
    let bare = naga::front::wgsl::parse_str(&text)
        .map_err(|error| anyhow::anyhow!("{}", error.emit_to_string(&text)))?;
    text.push_str("\n@compute @workgroup_size(1) fn call_all() {\n");
    for name in FUNCTIONS {
        let mut functions = bare.functions.iter();
        let found = functions.find(|(_, function)| function.name.as_deref() == Some(name));
        let (_, function) = found.with_context(|| format!("there is no {name}"))?;
        let arguments: Result<Vec<&str>> = (function.arguments.iter())
            .map(|argument| zero(&bare.types[argument.ty].inner))
            .collect();
        let _ = writeln!(text, "_ = {name}({});", arguments?.join(", "));
    }
    text.push('}');
    let text = Text::of("the standard functions", &text)?;
    for (number, limit) in [None, Some(LOOP_LIMIT)].into_iter().enumerate() {
        let program = |separate: &dyn Fn(&str) -> bool| -> Result<kernel_ir::ir::Program> {
            let options = kernel_ir::Options {
                separate,
                loop_limit: limit,
                ..kernel_ir::Options::default()
            };
            let (module, info) =
                kernel_ir::with_constants(&text.module, &text.info, "call_all", &[])?;
            Ok(kernel_ir::lower(&module, &info, "call_all", &options)?)
        };
        // As they are lowered at run time, and as they are written: both do the same.
        let plain = program(&|name| FUNCTIONS.contains(&name))?;
        let written =
            program(&|name| FUNCTIONS.contains(&name) || (in_lanes && CORNERS.contains(&name)))?;
        let Some(rust) = kernel_ir::rust::functions(&written, attributes, in_lanes) else {
            bail!("the standard functions can't be written as Rust");
        };
        let imports = match in_lanes {
            true => "use super::*; use core::arch::x86_64::*;",
            false => "use super::*;",
        };
        let _ = writeln!(modules, "mod standard_{number} {{\n{imports}\n{rust}}}");
        if in_lanes {
            let Some(rust) = kernel_ir::rust::lanes_functions(&plain, attributes) else {
                bail!("the standard functions can't be written in lanes");
            };
            let _ = writeln!(
                modules,
                "mod standard_in_lanes_{number} {{\nuse super::*;\n{rust}}}"
            );
        }
        for (index, function) in plain.functions.iter().enumerate().skip(1) {
            let mut functions = written.functions.iter();
            let place = functions.position(|written| written.name == function.name);
            let place = place.context("both programs have the same functions")?;
            let key = plain.function_key(index);
            // As `AheadFunction::new` wants it: what is named was made of the function with this key.
            let entry = |function: String| {
                format!(
                    "unsafe {{ AheadFunction::new({key:#034x}, [{}, {}, {}], core::mem::transmute({function} as *const ())) }},\n",
                    plain.functions[index].parameters.len(),
                    plain.functions[index].instructions.len(),
                    plain.functions[index].value_types.len(),
                )
            };
            list.push(entry(format!("standard_{number}::e{place}")));
            if in_lanes {
                list_in_lanes.push(entry(format!("standard_in_lanes_{number}::l{index}")));
            }
        }
    }
    Ok(())
}

/// A value of a type, as WGSL.
fn zero(ty: &naga::TypeInner) -> Result<&'static str> {
    use naga::{ScalarKind, TypeInner, VectorSize};
    Ok(match ty {
        TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Float => "0.0",
        TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Uint => "0u",
        TypeInner::Vector { size, scalar } if scalar.kind == ScalarKind::Float => match size {
            VectorSize::Bi => "vec2f()",
            VectorSize::Tri => "vec3f()",
            VectorSize::Quad => "vec4f()",
        },
        other => bail!("no function takes {other:?}"),
    })
}

/// A valid text with all that it includes.
struct Text {
    module: naga::Module,
    info: naga::valid::ModuleInfo,
}

impl Text {
    fn read(file: &str) -> Result<Self> {
        let mut text = String::new();
        include(file, &mut HashSet::new(), &mut text)?;
        Self::of(file, &text)
    }

    fn of(file: &str, text: &str) -> Result<Self> {
        let module = naga::front::wgsl::parse_str(text)
            .map_err(|error| anyhow::anyhow!("{file}: {}", error.emit_to_string(text)))?;
        let capabilities = naga::valid::Capabilities::all();
        let flags = naga::valid::ValidationFlags::all();
        let info = naga::valid::Validator::new(flags, capabilities)
            .validate(&module)
            .map_err(|error| anyhow::anyhow!("{file}: {}", error.emit_to_string(text)))?;
        Ok(Self { module, info })
    }

    fn program(&self, entry: &str, set: &[&str]) -> Result<kernel_ir::ir::Program> {
        let value = |name: &str| f64::from(u8::from(set.contains(&name)));
        let names = OMISSIONS.iter().chain(OTHERS).chain([&SPLIT, &LEAVES]);
        let mut constants: Vec<(&str, f64)> = names.map(|&name| (name, value(name))).collect();
        constants.extend(FOR_PROCESSORS);
        let (module, info) =
            kernel_ir::with_constants(&self.module, &self.info, entry, &constants)?;
        let options = kernel_ir::Options {
            host: HOST,
            ..kernel_ir::Options::default()
        };
        Ok(kernel_ir::lower(&module, &info, entry, &options)?)
    }
}

/// Puts a file into a text, and what its `//!include` lines name, each file once: as `engine/src/passes/wgsl.rs` does.
fn include(file: &str, seen: &mut HashSet<String>, text: &mut String) -> Result<()> {
    if !seen.insert(file.to_owned()) {
        return Ok(());
    }
    let path = Path::new(PASSES).join(file);
    // What no kernel includes is none of its business.
    println!("cargo::rerun-if-changed={}", path.display());
    let own =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    for line in own.lines() {
        match line.strip_prefix("//!include ") {
            Some(included) => include(included.trim(), seen, text)?,
            None => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
    Ok(())
}
