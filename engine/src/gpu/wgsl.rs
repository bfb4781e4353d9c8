//! Composes kernels from the engine's WGSL files: `//!include FILE` lines are replaced by the file, each file once.
//!
//! A source map remembers where each line came from, so that an error points at the file that was written.

use std::collections::HashSet;

/// The text of a kernel and where its lines came from.
#[derive(Debug, Clone, Default)]
pub struct Source {
    /// The composed WGSL.
    pub text: String,
    /// File and 1-based line of each line of `text`.
    pub origins: Vec<(String, u32)>,
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

    /// Appends foreign text (the generated texture kernel) whose lines come from `origins`.
    pub fn append(&mut self, text: &str, origins: impl IntoIterator<Item = (String, u32)>) {
        let lines = text.lines().count();
        self.origins.extend(origins.into_iter().take(lines));
        self.text.push_str(text);
        if !text.ends_with('\n') {
            self.text.push('\n');
        }
        let total = self.text.lines().count();
        self.origins.resize(total, ("generated".to_owned(), 0));
    }

    fn include(&mut self, file: &str, seen: &mut HashSet<String>) {
        if !seen.insert(file.to_owned()) {
            return;
        }
        let Some((_, text)) = FILES.iter().find(|(name, _)| *name == file) else {
            panic!("`{file}` is not among the engine's WGSL files");
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

    /// `file:line` of a 1-based line of the composed text.
    pub fn origin(&self, line: u32) -> Option<&(String, u32)> {
        self.origins.get(line.checked_sub(1)? as usize)
    }
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../passes/", $name)))),*]
    };
}

/// Every WGSL file of the engine, by its path below `passes/`.
const FILES: &[(&str, &str)] = files![
    "shared/ao_tables.wgsl",
    "shared/bsdf.wgsl",
    "shared/environment.wgsl",
    "shared/frame.wgsl",
    "shared/geometry.wgsl",
    "shared/images.wgsl",
    "shared/lights.wgsl",
    "shared/materials.wgsl",
    "shared/paths.wgsl",
    "shared/programs.wgsl",
    "shared/queues.wgsl",
    "shared/random.wgsl",
    "shared/rays.wgsl",
    "shared/surface.wgsl",
    "shared/traversal.wgsl",
    "accumulate/accumulate.wgsl",
    "advance/advance.wgsl",
    "ao/ao.wgsl",
    "brdf/brdf.wgsl",
    "classify/classify.wgsl",
    "proctex/proctex.wgsl",
    "raygen/raygen.wgsl",
    "traverse/traverse.wgsl",
];
