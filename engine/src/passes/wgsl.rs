//! Composes kernels from the engine's WGSL files: `//!include FILE` lines are replaced by the file, each file once.
//!
//! A source map remembers where each line came from, so that an error points at the file that was written.

use std::{collections::HashSet, ops::Range};

use device::{Device, DeviceError, Kernel, KernelSource, KernelText, Text, Trust};
use texgen::{GeneratedKernel, SourceMap};

use super::film_layers;

/// The text of a kernel and where its lines came from.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// The composed WGSL.
    pub text: String,
    /// File and 1-based line of each line of `text`.
    pub origins: Vec<(String, u32)>,
    /// Where the generated kernel begins, and how its places map to the users' files.
    generated: Option<(usize, SourceMap)>,
}

impl Source {
    /// Composes the kernel whose root is `file`, a path below `passes/`.
    ///
    /// # Panics
    /// If a file does not exist: the files are part of the program, and a test composes each kernel.
    pub fn of(file: &str) -> Self {
        let mut source = Self::default();
        source.include(file, &mut HashSet::new());
        source
    }

    /// Reads what the files declare as a uniform from a storage buffer instead.
    ///
    /// # Panics
    /// There is no uniform of this name.
    pub fn with_storage(mut self, name: &str) -> Self {
        let uniform = format!("var<uniform> {name}:");
        assert!(self.text.contains(&uniform), "no uniform `{name}`");
        let storage = format!("var<storage, read> {name}:");
        self.text = self.text.replace(&uniform, &storage);
        self
    }

    /// Appends a constant that the files leave open.
    pub fn append_constant(&mut self, name: &str, value: u32) {
        self.text.push_str(&format!("const {name} = {value}u;\n"));
        self.origins.push(("the engine".to_owned(), 1));
    }

    /// Appends the generated texture kernel, whose lines belong to the users' files.
    pub fn append_generated(&mut self, kernel: &GeneratedKernel) {
        self.generated = Some((self.text.len(), kernel.source_map.clone()));
        self.text.push_str(&kernel.wgsl);
    }

    /// Compiles one entry point. `constants` are values of `override` constants by name; those that the text doesn't
    /// declare are left out.
    ///
    /// # Errors
    /// With file and line, if the text is not valid or the driver refuses it.
    pub fn compile(
        &self,
        device: &Device,
        entry: &str,
        trust: Trust,
        constants: &[(&'static str, f64)],
    ) -> Result<Kernel, DeviceError> {
        let source = KernelSource {
            text: self,
            entry,
            trust,
            constants,
        };
        let build = || Kernel::new(device, &source);
        match trust {
            Trust::All => build(),
            // naga has panicked on users' code that is valid: that must not end the program, and whose texture it is can be
            // found out like with a driver that refuses it. wgpu's locks are free again after a panic, and what was begun
            // is dropped.
            Trust::Nothing | Trust::Loops => texgen::guarded(build).unwrap_or_else(|panic| {
                Err(DeviceError::Refused {
                    label: entry.to_owned(),
                    message: format!(
                        "the compiler ended unexpectedly ({panic}); this is a fault of Patina or of its parts, please report it"
                    ),
                })
            }),
        }
    }

    fn include(&mut self, file: &str, seen: &mut HashSet<String>) {
        if !seen.insert(file.to_owned()) {
            return;
        }
        let written = FILES.iter().find(|(name, _)| *name == file);
        let text = match written {
            Some((_, text)) => text,
            None if file == LAYER_TABLE => film_layers::table(),
            None => panic!("`{file}` is not among the engine's WGSL files"),
        };
        for (number, line) in text.lines().enumerate() {
            if let Some(included) = line.strip_prefix("//!include ") {
                self.include(included.trim(), seen);
            } else {
                self.text.push_str(line);
                self.text.push('\n');
                self.origins.push((file.to_owned(), number as u32 + 1));
            }
        }
    }
}

impl Text for Source {
    fn capabilities(&self) -> naga::valid::Capabilities {
        texgen::CAPABILITIES
    }

    fn adapt(&self, module: &mut naga::Module) {
        texgen::copy_pointer_arguments(module);
    }

    fn wgsl(&self) -> &str {
        &self.text
    }

    fn locate(&self, span: Range<usize>, message: &str) -> Option<String> {
        if let Some((start, map)) = &self.generated
            && span.start >= *start
        {
            return Some(
                map.diagnostic(span.start - start..span.end - start, message)
                    .render(),
            );
        }
        let line = self.text.get(..span.start)?.matches('\n').count();
        self.origins
            .get(line)
            .map(|(file, line)| format!("{file}:{line}: {message}"))
    }
}

/// Bytes of private memory that a thread of a kernel asks for: see [`texgen::kernel_private_bytes`]. None for a text that
/// is not valid.
pub fn private_bytes(kernel: &KernelText) -> Option<u32> {
    let mut module = naga::front::wgsl::parse_str(kernel.text.wgsl()).ok()?;
    kernel.text.adapt(&mut module);
    let flags = naga::valid::ValidationFlags::all();
    let capabilities = kernel.text.capabilities() | naga::valid::Capabilities::RAY_QUERY;
    let validated = naga::valid::Validator::new(flags, capabilities).validate(&module);
    let mut entries = module.entry_points.iter();
    let index = entries.position(|entry| entry.name == kernel.entry)?;
    let info = validated.ok()?;
    let uses = info.get_entry_point(index);
    let entry = &module.entry_points[index];
    Some(texgen::kernel_private_bytes(&module, uses, entry))
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!($name))),*]
    };
}

/// The file that is made from the declarations of the film's layers.
const LAYER_TABLE: &str = "film_layers/table.wgsl";

/// Every other WGSL file of the engine, by its path below `passes/`.
const FILES: &[(&str, &str)] = files![
    "shared/ao_tables.wgsl",
    "shared/appearance.wgsl",
    "shared/bsdf.wgsl",
    "shared/environment.wgsl",
    "shared/estimator.wgsl",
    "shared/exact_sums.wgsl",
    "shared/filter.wgsl",
    "shared/frame.wgsl",
    "shared/geometry.wgsl",
    "shared/hash.wgsl",
    "shared/hit.wgsl",
    "shared/images.wgsl",
    "shared/light_tree.wgsl",
    "shared/lights.wgsl",
    "shared/materials.wgsl",
    "shared/media.wgsl",
    "shared/microfacet.wgsl",
    "shared/occlusion.wgsl",
    "shared/outputs.wgsl",
    "shared/paths.wgsl",
    "shared/programs.wgsl",
    "shared/queue_lists.wgsl",
    "shared/queues.wgsl",
    "shared/random.wgsl",
    "shared/rays.wgsl",
    "shared/surface.wgsl",
    "shared/thin_film.wgsl",
    "shared/traversal.wgsl",
    "shared/vectors.wgsl",
    "shared/wave_memory.wgsl",
    "accumulate/accumulate.wgsl",
    "accumulate/entry.wgsl",
    "advance/advance.wgsl",
    "ao/ao.wgsl",
    "ao/packet.wgsl",
    "brdf/brdf.wgsl",
    "brdf/entry.wgsl",
    "classify/classify.wgsl",
    "classify/entry.wgsl",
    "display/display.wgsl",
    "film_layers/accumulate.wgsl",
    "film_layers/record.wgsl",
    "film_layers/samples.wgsl",
    "guide/guide.wgsl",
    "proctex/counted_ao.wgsl",
    "proctex/entry.wgsl",
    "proctex/inlined.wgsl",
    "proctex/proctex.wgsl",
    "proctex/run.wgsl",
    "proctex/site.wgsl",
    "proctex/traced_ao.wgsl",
    "raygen/raygen.wgsl",
    "raygen/entry.wgsl",
    "rayquery/kernel.wgsl",
    "rayquery/path_memory.wgsl",
    "rayquery/plain.wgsl",
    "rayquery/queries.wgsl",
    "rayquery/textured.wgsl",
    "traverse/traverse.wgsl",
    "traverse/entry.wgsl",
];
