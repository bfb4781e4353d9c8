//! `patina texture inspect`: what Patina makes of a texture or a look.
//!
//! Programs depend on names alone and not on geometry, so a look is inspected without its scene: every material that it
//! mentions is taken to exist.

use std::fmt::Write;
use std::path::Path;

use engine::isolated::{Isolated, Subject};
use engine::procedural::{Procedural, TextureSources};
use engine::scene::look::{Look, LookError};
use engine::scene::{AlphaMode, Material, Scene};
use texgen::{Library, PrivateMemory};

use crate::console;
use crate::failure::Failure;

use super::args::Part;
use super::job::{InspectJob, Inspected};
use super::programs;

/// Bytes of a slot of the kernel's stack.
const SLOT_BYTES: u32 = 16;

/// Prints one part, or all of them with titles.
///
/// # Errors
/// Mistakes in the texture or the look.
pub(crate) fn run(job: &InspectJob) -> Result<(), Failure> {
    let look = match &job.subject {
        Inspected::Look(path) => Some(path.as_path()),
        Inspected::Texture(_) => None,
    };
    let sources = super::sources(&job.texture_dirs, look)?;
    let report = match &job.subject {
        Inspected::Texture(name) => of_texture(name, &sources)?,
        Inspected::Look(path) => of_look(path, &sources)?,
    };
    console::print(&report.text(job.part));
    Ok(())
}

/// The parts as text.
struct Report {
    programs: String,
    arguments: String,
    memory: String,
    kernel: String,
}

impl Report {
    fn text(&self, part: Option<Part>) -> String {
        let parts = [
            (Part::Programs, "programs", &self.programs),
            (Part::Arguments, "arguments", &self.arguments),
            (Part::Memory, "memory", &self.memory),
            (Part::Kernel, "kernel", &self.kernel),
        ];
        let mut text = String::new();
        for (this, title, content) in parts {
            match part {
                None => {
                    let _ = writeln!(text, "==== {title} ====\n\n{}\n", content.trim_end());
                }
                Some(part) if part == this => text.push_str(content),
                Some(_) => {}
            }
        }
        text
    }
}

fn of_texture(name: &str, sources: &TextureSources) -> Result<Report, Failure> {
    let isolated = Isolated::new(Subject::Texture(name), sources)?;
    let procedural = isolated.procedural();
    console::diagnostics(procedural.warnings());
    let graph = procedural.graph();
    let nodes: Vec<_> = graph.ids().collect();
    let (programs, slots) = match graph.compile(&nodes) {
        Ok(program) => (
            programs::instructions(graph, &program, "program"),
            program.slots_needed,
        ),
        // An image is missing: the rest can still be shown.
        Err(reason) => (format!("    no program: {reason}\n"), 1),
    };
    Ok(Report {
        programs,
        arguments: programs::arguments(graph),
        memory: memory(graph.library(), slots),
        kernel: graph.library().emit(slots).wgsl,
    })
}

fn of_look(path: &Path, sources: &TextureSources) -> Result<Report, Failure> {
    let look = Look::load(path)?;
    let mut scene = scene_of(&look);
    let procedural = Procedural::build(&look, &mut scene, sources).map_err(LookError::from)?;
    console::diagnostics(procedural.warnings());
    Ok(Report {
        programs: programs::of_materials(&procedural, &scene),
        arguments: programs::arguments(procedural.graph()),
        memory: memory(procedural.graph().library(), procedural.stack_slots()),
        kernel: procedural.kernel().wgsl,
    })
}

/// A scene with all materials that a look mentions and nothing else.
fn scene_of(look: &Look) -> Scene {
    let mut scene = Scene::default();
    for table in &look.materials {
        let blend = table.blend.iter();
        let sides = blend.flat_map(|b| [&b.value.base.value, &b.value.over.value]);
        for name in [&table.name.value].into_iter().chain(sides) {
            if !scene.materials.iter().any(|known| known.name == *name) {
                scene.materials.push(Material {
                    name: name.clone(),
                    // Whatever a table says about alpha has an effect.
                    alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
                    ..Material::default()
                });
            }
        }
    }
    scene
}

fn memory(library: &Library, slots: u32) -> String {
    let mut text = format!(
        "stack            {:6} bytes per thread: {slots} slots of {SLOT_BYTES}\n",
        slots * SLOT_BYTES
    );
    for texture in library.textures() {
        let memory = PrivateMemory::of(texture);
        let _ = writeln!(
            text,
            "{:16} {:6} bytes of parameters and variables: {}",
            texture.name(),
            memory.bytes,
            memory.deepest.join(" > ")
        );
    }
    text.push_str(
        "registers        unknown: wgpu does not pass on what the driver allots; ask the vendor's profiler\n",
    );
    text
}
