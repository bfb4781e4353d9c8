//! A texture type: one user file, parsed, checked and ready to be emitted any number of times.
//!
//! The order of the checks: constructs that textures can't have (`refuse`), attributes (`reads`), WGSL itself
//! (`parse`, by naga), the signature of `userProc` (`signature`), its documentation (`metadata`); then the edits for
//! the kernel are worked out (`rewrite`) and the result is tried out.

use std::collections::BTreeSet;

use crate::args;
use crate::attribute::{Attribute, BuiltinAttribute, Global};
use crate::diagnostic::{Diagnostic, Diagnostics, Severity, SourceFile};
use crate::habits::habits;
use crate::interface::{NamedOutput, Parameter};
use crate::libraries::Whole;
use crate::memory_limit::{self, Needs};
use crate::metadata::{self, Described};
use crate::nesting;
use crate::parse;
use crate::reads::{self, ReadSource};
use crate::refuse::{self, MAX_FILE_BYTES};
use crate::rewrite::{self, Rewrite};
use crate::scope::{GlobalKind, Outline};
use crate::signature::{self, Signature};
use crate::standard;
use crate::value::{OutputType, ParameterType};

/// A valid user texture.
#[derive(Clone, Debug)]
pub struct TextureType {
    file: SourceFile,
    whole: Whole,
    docs: String,
    group: Option<String>,
    parameters: Vec<Parameter>,
    output: OutputType,
    outputs: Vec<NamedOutput>,
    attributes: BTreeSet<Attribute>,
    globals: BTreeSet<Global>,
    reads_levels: bool,
    private_bytes: u32,
    standard: BTreeSet<usize>,
    warnings: Diagnostics,
    rewrite: Rewrite,
}

impl TextureType {
    /// Whether instructions of this texture carry a word with AO slots.
    pub(crate) fn reads_occlusion(&self) -> bool {
        let mut occlusion = [BuiltinAttribute::AO, BuiltinAttribute::AO1].into_iter();
        occlusion.any(|attribute| self.attributes().contains(&Attribute::Builtin(attribute)))
    }

    /// Checks all but whether the generated kernel compiles: see [`Self::parse`].
    pub(crate) fn check(file: SourceFile) -> Result<Self, Diagnostics> {
        let whole = Whole::new(&file)?;
        match Self::check_whole(file, &whole) {
            Ok(texture) => Ok(Self {
                warnings: whole.placed(texture.warnings),
                ..texture
            }),
            Err(problems) => Err(whole.placed(problems)),
        }
    }

    /// Checks a texture as one text with the files that it uses; places are those in the whole.
    fn check_whole(own: SourceFile, whole: &Whole) -> Result<Self, Diagnostics> {
        let file = whole.file.clone();
        if file.text().len() > MAX_FILE_BYTES {
            return Err(Diagnostic::error(format!(
                "a texture of {} bytes is too long: at most {MAX_FILE_BYTES} are read",
                file.text().len()
            ))
            .with_label(&file, 0..0, "")
            .with_note("tables belong into images, ramps or `array<T, N>` parameters")
            .into());
        }
        let outline = Outline::new(file.text());
        if let Some(problem) = refuse::too_deep(&file, &outline) {
            return Err(problem.into());
        }
        let strange = refuse::strange_characters(&file, &outline);
        if !strange.is_empty() {
            return Err(strange);
        }
        let mut problems = refuse::refused(&file, &outline);
        let (reads, read_problems) = reads::find_reads(&file, &outline);
        problems.append(read_problems);
        problems.extend(second_entry(whole, &outline));
        let mut attributes: BTreeSet<Attribute> = reads
            .iter()
            .filter_map(|read| match &read.source {
                ReadSource::Attribute(attribute) => Some(attribute.clone()),
                ReadSource::Global(_) => None,
            })
            .collect();
        let globals: BTreeSet<Global> = reads
            .iter()
            .filter_map(|read| match read.source {
                ReadSource::Global(global) => Some(global),
                ReadSource::Attribute(_) => None,
            })
            .collect();

        let custom = custom_names(&attributes);
        let habits = habits(&file, &outline);
        problems.extend(habits.iter().map(|habit| habit.diagnostic.clone()));
        let module = match parse::parse(whole, &outline, &custom, &habits) {
            Ok(module) if problems.is_empty() => module,
            Ok(_) => return Err(problems),
            Err(found) => {
                add_new_places(&mut problems, found);
                problems.extend(metadata::used_by_two_slashes(&file, &outline));
                return Err(problems);
            }
        };
        let Signature {
            mut parameters,
            output,
            mut outputs,
        } = signature::read(&file, &outline, &module)?;
        let described = Described {
            parameters: &mut parameters,
            outputs: &mut outputs,
        };
        let docs = metadata::read_docs(whole, &outline, described, &mut problems);
        attributes.extend(parameters.iter().filter_map(|p| p.attribute.clone()));
        // How wide the pixel is comes with a position.
        if parameters.iter().any(Parameter::is_coordinate) {
            attributes.insert(Attribute::Builtin(BuiltinAttribute::Footprint));
        }
        if problems.has_errors() {
            problems.errors_first();
            return Err(problems);
        }
        let Needs { total, problem } = memory_limit::needs(&file, &outline, &module);
        match problem {
            Some(problem) if problem.severity == Severity::Error => return Err(problem.into()),
            problem => problems.extend(problem),
        }
        problems.extend(nesting::warnings(&file, &outline, &module));
        let types: Vec<ParameterType> = parameters.iter().map(|parameter| parameter.ty).collect();
        let rewrite = rewrite::rewrite(&outline, &reads, &types);
        Ok(Self {
            file: own,
            whole: whole.clone(),
            docs,
            group: metadata::group(&outline),
            parameters,
            output,
            outputs,
            attributes,
            globals,
            reads_levels: reads::reads_levels(&outline),
            private_bytes: total,
            standard: standard::needed_by(&outline),
            warnings: problems,
            rewrite,
        })
    }

    /// The texture's name: what a look file calls it.
    pub fn name(&self) -> &str {
        self.file.name()
    }

    /// Its source.
    pub fn file(&self) -> &SourceFile {
        &self.file
    }

    /// The text of its `///` comment without the lines that begin with `@`.
    pub fn docs(&self) -> &str {
        &self.docs
    }

    /// The group that its `@group` line puts it into, for lists.
    pub fn group(&self) -> Option<&str> {
        self.group.as_deref()
    }

    /// The parameters of `userProc` in their order.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Place and description of the parameter of that name.
    pub fn parameter(&self, name: &str) -> Option<(usize, &Parameter)> {
        self.parameters
            .iter()
            .enumerate()
            .find(|(_, parameter)| parameter.name == name)
    }

    /// Words of the fake stack that each parameter takes, as offsets from the beginning of a node's block. A ramp has
    /// one word there, the offset of its stops.
    pub fn argument_layout(&self) -> Vec<std::ops::Range<u32>> {
        let ends = self.parameters.iter().zip(args::offsets(&self.parameters));
        ends.map(|(parameter, offset)| offset..offset + args::words_of(parameter.ty))
            .collect()
    }

    /// The members of the struct that `userProc` returns, which links take by their names; empty where it returns a plain value.
    pub fn outputs(&self) -> &[NamedOutput] {
        &self.outputs
    }

    /// What `userProc` returns; of several values the first.
    pub fn output(&self) -> OutputType {
        self.output
    }

    /// The attributes it reads anywhere in the file.
    pub fn attributes(&self) -> &BTreeSet<Attribute> {
        &self.attributes
    }

    /// The globals it reads anywhere in the file.
    pub fn globals(&self) -> &BTreeSet<Global> {
        &self.globals
    }

    /// Whether it calls `tex2DLod` anywhere in the file: whether its images need mip levels.
    pub fn reads_levels(&self) -> bool {
        self.reads_levels
    }

    /// Bytes of local variables in all its functions, as naga lays them out: what it may need per thread.
    pub fn private_bytes(&self) -> u32 {
        self.private_bytes
    }

    /// What is odd but not wrong: unknown keys in `@param` lines and the like.
    pub fn warnings(&self) -> &Diagnostics {
        &self.warnings
    }

    /// Places of the standard functions that it needs.
    pub(crate) fn standard(&self) -> &BTreeSet<usize> {
        &self.standard
    }

    /// Its text with the shared files that it uses.
    pub(crate) fn whole(&self) -> &Whole {
        &self.whole
    }

    pub(crate) fn rewrite(&self) -> &Rewrite {
        &self.rewrite
    }
}

/// A shared file is no texture: what it has in common with others are functions.
fn second_entry(whole: &Whole, outline: &Outline<'_>) -> Option<Diagnostic> {
    let entry = outline.globals.iter().find(|global| {
        let is_entry = |name: usize| outline.word(name) == "userProc";
        global.kind == GlobalKind::Function
            && global.name.is_some_and(is_entry)
            && outline.span(global.keyword).start >= whole.own_len()
    })?;
    let error = Diagnostic::error("a shared file has no `userProc`: that is the texture's own");
    let label = error.with_label(&whole.file, outline.span(entry.name?), "");
    Some(label.with_note("give it another name, and call it from the texture"))
}

/// Names of the custom attributes among `attributes`, sorted.
pub(crate) fn custom_names(attributes: &BTreeSet<Attribute>) -> Vec<String> {
    attributes
        .iter()
        .filter_map(|attribute| match attribute {
            Attribute::Custom(name) => Some(name.clone()),
            Attribute::Builtin(_) => None,
        })
        .collect()
}

/// Adds naga's errors where nothing was found before: what this crate says about a place is more helpful.
fn add_new_places(problems: &mut Diagnostics, found: Diagnostics) {
    let known: Vec<_> = problems
        .iter()
        .flat_map(|problem| &problem.labels)
        .map(|label| label.span.clone())
        .collect();
    for problem in found {
        let overlaps = problem.labels.iter().any(|label| {
            known.iter().any(|span| {
                span.start < label.span.end.max(label.span.start + 1) && label.span.start < span.end
            })
        });
        if !overlaps && (known.is_empty() || !problem.labels.is_empty()) {
            problems.push(problem);
        }
    }
    problems.sort();
}
