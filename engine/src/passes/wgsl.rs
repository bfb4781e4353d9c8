//! Composes kernels from the engine's WGSL files: `//!include FILE` lines are replaced by the file, each file once.
//! Files below `generated/` are made from tables, by tests which hold them to it: those of materials by one of `material_record`, those of the
//! film by one of `film/layers_wgsl`.
//!
//! A source map remembers where each line came from, so that an error points at the file that was written. Every file below
//! `passes/` is there to be included: the build puts them into the program, there is no list to keep.

use std::{collections::HashSet, ops::Range};

use device::native::compile::{Ahead, AheadFunction};
use device::{Device, DeviceError, Kernel, KernelSource, Text, Trust};
use texgen::{GeneratedKernel, SourceMap};

use crate::gpu_scene::host_traversal;

/// A WGSL file: its path below `passes/`, by which others include it, and its text.
pub type File = (&'static str, &'static str);

/// Every WGSL file of this crate.
pub const FILES: &[File] = include!(concat!(env!("OUT_DIR"), "/wgsl_files.rs"));

/// The text of a kernel and where its lines came from.
#[derive(Debug, Clone, Default)]
pub struct ComposedWgsl {
    /// The composed WGSL.
    pub text: String,
    /// File and 1-based line of each line of `text`.
    pub origins: Vec<(String, u32)>,
    /// Where the generated kernel begins, and how its places map to the users' files.
    generated: Option<(usize, SourceMap)>,
}

impl ComposedWgsl {
    /// Composes the kernel whose root is `file`, a path below `passes/`.
    ///
    /// # Panics
    /// If a file does not exist: the files are part of the program, and a test composes each kernel.
    pub fn of(file: &str) -> Self {
        Self::with_files(file, &[])
    }

    /// As [`Self::of`], from these files (name and text) as well, which come before those of their names here.
    ///
    /// # Panics
    /// If a file does not exist.
    pub fn with_files(file: &str, files: &[File]) -> Self {
        let mut source = Self::default();
        source.include(file, files, &mut HashSet::new());
        source
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
        compile(device, &source)
    }

    fn include(&mut self, file: &str, files: &[File], seen: &mut HashSet<String>) {
        if !seen.insert(file.to_owned()) {
            return;
        }
        let mut all = files.iter().chain(FILES);
        let found = all.find(|(name, _)| *name == file);
        let text = found.map_or_else(
            || panic!("`{file}` is not among the engine's WGSL files"),
            |(_, text)| *text,
        );
        for (number, line) in text.lines().enumerate() {
            if let Some(included) = line.strip_prefix("//!include ") {
                self.include(included.trim(), files, seen);
            } else {
                self.text.push_str(line);
                self.text.push('\n');
                self.origins.push((file.to_owned(), number as u32 + 1));
            }
        }
    }
}

impl Text for ComposedWgsl {
    fn capabilities(&self) -> naga::valid::Capabilities {
        texgen::CAPABILITIES
    }

    fn host_functions(&self) -> &[&'static str] {
        &host_traversal::FUNCTIONS
    }

    fn ahead(&self) -> &'static [Ahead] {
        kernels::all()
    }

    fn ahead_functions(&self) -> &'static [AheadFunction] {
        kernels::functions()
    }

    fn omissions(&self) -> &'static [&'static str] {
        kernels::OMISSIONS
    }

    fn is_separate(&self, function: &str) -> bool {
        // What a texture is, with what calls it: a change of one texture is a change of one of these.
        texgen::is_call(function)
            || texgen::standard_function(function).is_some_and(kernels::is_function)
    }

    fn ahead_lanes(&self) -> &'static [AheadFunction] {
        kernels::functions_in_lanes()
    }

    fn runs_in_lanes(&self) -> bool {
        self.generated.is_some()
    }

    fn runs_once(&self, function: &str) -> bool {
        // Neighbouring hits mostly have the same program: it is walked once for all of them.
        function == texgen::RUN
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

/// Compiles a kernel that may hold users' code.
///
/// # Errors
/// With file and line, if the text is not valid or the driver refuses it.
pub fn compile(device: &Device, source: &KernelSource<'_>) -> Result<Kernel, DeviceError> {
    let build = || Kernel::new(device, source);
    match source.trust {
        Trust::All => build(),
        // naga has panicked on users' code that is valid: that must not end the program, and whose texture it is can be
        // found out like with a driver that refuses it. wgpu's locks are free again after a panic, and what was begun
        // is dropped.
        Trust::Nothing | Trust::Loops => texgen::guarded(build).unwrap_or_else(|panic| {
            Err(DeviceError::Refused {
                label: source.entry.to_owned(),
                message: format!(
                    "the compiler ended unexpectedly ({panic}); this is a fault of Patina or of its parts, please report it"
                ),
            })
        }),
    }
}
