//! The generated kernel's text: the runtime, one section per texture, and the loop over a program's instructions.
//!
//! A section depends on its own texture only, so an edit of a file changes its section and nothing else. No constant
//! and no link of the graph is in the text. The `program` module describes the format of instructions.

use std::collections::{BTreeSet, HashSet};
use std::fmt::Write;

use crate::args;
use crate::interface::Parameter;
use crate::library::Library;
use crate::program::NOT_KEPT;
use crate::rewrite::{Piece, array_reader, attribute_read, element_reader};
use crate::source_map::{Segment, SourceMap};
use crate::standard;
use crate::texture::TextureType;
use crate::value::{ElementType, OutputType, ParameterType};

/// WGSL text without bindings, to be put into one module with the host's functions (see [`HOST_STUB`](crate::HOST_STUB)).
#[derive(Clone, Debug)]
pub struct GeneratedKernel {
    /// The text. Its interface to the host: `fn patina_run_program(offset: u32)` runs the program that begins at
    /// that word of the program buffer, after which `fn patina_link(word: u32) -> vec4f` reads results
    /// (see [`link_word`](crate::link_word)), `patina_overrun` tells whether a loop was cut, and `patina_non_finite` where
    /// the arguments lie of a node whose result was not finite.
    pub wgsl: String,
    /// From places in the text to places in the users' files.
    pub source_map: SourceMap,
}

/// The part of the kernel that is the same for all libraries.
const RUNTIME: &str = include_str!("runtime.wgsl");

/// Iterations that the loops of one node may use at one hit.
pub const LOOP_LIMIT: u32 = 16_384;

/// What the functions are called that load a node's arguments and call its texture, before the section's name.
const CALL: &str = "patina_call_";

/// The function of a generated kernel that runs a program: `fn(offset: u32)`.
pub const RUN: &str = "patina_run_program";

/// Whether a function of a generated kernel is that of a texture: it loads a node's arguments and calls the user's
/// function. One for each texture, and nothing else in the kernel depends on what a texture computes.
pub fn is_call(function: &str) -> bool {
    function.starts_with(CALL)
}

impl Library {
    /// The kernel's text for programs that need at most `stack_slots` slots (at least one is made).
    pub fn emit(&self, stack_slots: u32) -> GeneratedKernel {
        let mut emitter = Emitter::new(self, stack_slots);
        let names = section_names(self);
        for (texture, name) in self.textures().iter().zip(&names) {
            emitter.section(texture, name);
            emitter.line("");
            emitter.call(texture, name);
        }
        emitter.line("");
        emitter.line("// ==== programs ====");
        emitter.line("");
        emitter.line("// Runs the program at word `offset` of the program buffer: one instruction after the other, each one");
        emitter.line("// texture with its arguments, its result into a slot of the stack.");
        emitter.run(self, &names);
        emitter.finish()
    }
}

/// A WGSL name for each texture's section: letters, digits and single underscores. A name is followed by two
/// underscores in front of the file's own names, so no two textures' names can meet.
pub(crate) fn section_names(library: &Library) -> Vec<String> {
    let mut taken: HashSet<String> = HashSet::new();
    library
        .textures()
        .iter()
        .map(|texture| {
            let mut base = String::new();
            for c in texture.name().chars() {
                let c = if c.is_ascii_alphanumeric() { c } else { '_' };
                if c != '_' || !(base.is_empty() || base.ends_with('_')) {
                    base.push(c);
                }
            }
            let base = base.trim_end_matches('_');
            let base = match base.chars().next() {
                Some(first) if first.is_ascii_alphabetic() && !base.starts_with("patina") => {
                    base.to_owned()
                }
                _ => format!("t_{base}").trim_end_matches('_').to_owned(),
            };
            // A local of the file that looks like a prefixed name would capture it.
            let clashes = |name: &str| (texture.whole().file.text()).contains(&format!("{name}__"));
            let mut name = base.clone();
            let mut number = 2;
            while taken.contains(&name) || clashes(&name) {
                name = format!("{base}_{number}");
                number += 1;
            }
            taken.insert(name.clone());
            name
        })
        .collect()
}

/// Writes a kernel's text piece by piece.
pub(crate) struct Emitter {
    text: String,
    source_map: SourceMap,
}

impl Emitter {
    /// With the parts that stand before all textures.
    pub(crate) fn new(library: &Library, stack_slots: u32) -> Self {
        let mut emitter = Self {
            text: String::new(),
            source_map: SourceMap::default(),
        };
        emitter.runtime(stack_slots);
        emitter.array_readers(library);
        emitter.custom_attributes(library);
        emitter.standard_functions(library);
        emitter.keeper(library);
        emitter
    }

    /// The text written so far.
    pub(crate) fn finish(self) -> GeneratedKernel {
        GeneratedKernel {
            wgsl: self.text,
            source_map: self.source_map,
        }
    }

    pub(crate) fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    fn runtime(&mut self, stack_slots: u32) {
        self.line("// Generated by Patina from user textures: edit those, not this.");
        self.line("");
        let runtime = RUNTIME
            .replace("STACK_SLOTS", &stack_slots.max(1).to_string())
            .replace("LOOP_LIMIT", &format!("{LOOP_LIMIT}u"));
        self.text.push_str(&runtime);
    }

    /// Readers for the array parameters that occur.
    fn array_readers(&mut self, library: &Library) {
        let parameters = library.textures().iter().flat_map(TextureType::parameters);
        let arrays: Vec<(ElementType, u32)> = parameters
            .filter_map(|parameter| match parameter.ty {
                ParameterType::Array(element, count) => Some((element, count)),
                _ => None,
            })
            .collect();
        let mut done: BTreeSet<String> = BTreeSet::new();
        for (element, count) in arrays {
            let ty = element.parameter_type();
            let size = args::words_of(ty);
            let reader = element_reader(element);
            if done.insert(reader.clone()) {
                self.line("");
                self.line("// One element of an array that begins at word `at` of the fake stack.");
                self.line(&format!(
                    "fn {reader}(at: u32, count: u32, i: u32) -> {ty} {{"
                ));
                self.line(&format!(
                    "    return patina_arg_{ty}(at + {size}u * min(i, count - 1u));"
                ));
                self.line("}");
            }
            let reader = array_reader(element, count);
            if done.insert(reader.clone()) {
                self.line("");
                self.line(&format!("fn {reader}(at: u32) -> array<{ty}, {count}> {{"));
                self.line(&format!("    var values: array<{ty}, {count}>;"));
                self.line(&format!("    for (var i = 0u; i < {count}u; i++) {{"));
                self.line(&format!(
                    "        values[i] = patina_arg_{ty}(at + {size}u * i);"
                ));
                self.line("    }");
                self.line("    return values;");
                self.line("}");
            }
        }
    }

    /// A constant for each custom attribute, so that a new one changes no texture's section but its own.
    fn custom_attributes(&mut self, library: &Library) {
        let names = library.custom_attributes();
        if !names.is_empty() {
            self.line("");
            self.line("// Indices of custom attributes.");
        }
        for (index, name) in names.iter().enumerate() {
            self.line(&format!("const patina_custom{name} = {index}u;"));
        }
    }

    /// What stores outputs behind the first, where some texture has any.
    fn keeper(&mut self, library: &Library) {
        let mut textures = library.textures().iter();
        if textures.any(|texture| texture.outputs().len() > 1) {
            self.line("");
            self.line("// An output of several into its slot, if anything reads it.");
            self.line("fn patina_keep(slot: u32, value: vec4f, args: u32) {");
            self.line(&format!("    if slot != {NOT_KEPT}u {{"));
            self.line("        patina_check(value, args);");
            self.line("        patina_stack[slot] = value;");
            self.line("    }");
            self.line("}");
        }
    }

    /// The standard functions that some texture needs, each once.
    fn standard_functions(&mut self, library: &Library) {
        let needed: BTreeSet<usize> = (library.textures().iter())
            .flat_map(TextureType::standard)
            .copied()
            .collect();
        if !needed.is_empty() {
            self.line("");
            self.line("// ==== standard functions ====");
        }
        for place in needed {
            self.line("");
            self.line(standard::in_kernel(place));
        }
    }

    /// A texture's source under a title. Where its file lies is left out: the same textures make the same kernel on each machine, and so
    /// parts of one picture.
    pub(crate) fn section(&mut self, texture: &TextureType, name: &str) {
        self.line("");
        self.line(&format!("// ==== {} ====", comment_safe(texture.name())));
        self.line("");
        self.source(texture, name);
    }

    /// The user's text with its edits.
    fn source(&mut self, texture: &TextureType, name: &str) {
        let whole = texture.whole();
        let text = whole.file.text();
        let mut at = 0;
        for edit in &texture.rewrite().edits {
            self.copy(texture, at..edit.span.start);
            let start = self.text.len();
            for piece in &edit.pieces {
                match piece {
                    Piece::Text(text) => self.text.push_str(text),
                    Piece::Prefix => {
                        self.text.push_str(name);
                        self.text.push_str("__");
                    }
                    Piece::CustomIndex(attribute) => {
                        let _ = write!(self.text, "patina_custom{attribute}");
                    }
                }
            }
            let part = whole.part_at(edit.span.start);
            let first = part.range.start;
            self.source_map.push(Segment {
                generated: start..self.text.len(),
                file: part.file.clone(),
                source: edit.span.start - first..edit.span.end - first,
            });
            at = edit.span.end;
        }
        self.copy(texture, at..text.len());
        if !self.text.ends_with('\n') {
            self.text.push('\n');
        }
    }

    fn copy(&mut self, texture: &TextureType, source: std::ops::Range<usize>) {
        let whole = texture.whole();
        let mut at = source.start;
        for part in &whole.parts {
            let end = source.end.min(part.range.end);
            if at >= end {
                continue;
            }
            // What lies between two files is an end of line.
            let start = at.max(part.range.start);
            self.text.push_str(&whole.file.text()[at..start]);
            let generated = self.text.len();
            self.text.push_str(&whole.file.text()[start..end]);
            self.source_map.push(Segment {
                generated: generated..self.text.len(),
                file: part.file.clone(),
                source: start - part.range.start..end - part.range.start,
            });
            at = end;
        }
        self.text
            .push_str(&whole.file.text()[at..source.end.max(at)]);
    }

    /// The function that loads a node's arguments and calls `userProc`.
    fn call(&mut self, texture: &TextureType, name: &str) {
        let offsets = args::offsets(texture.parameters());
        let linkable: Vec<usize> = (0..offsets.len())
            .filter(|&i| texture.parameters()[i].ty.is_linkable())
            .collect();
        self.line(&format!(
            "fn {CALL}{name}(args: u32, first: u32) -> vec4f {{"
        ));
        self.line("    var at = first;");
        for (i, (parameter, offset)) in texture.parameters().iter().zip(&offsets).enumerate() {
            let word = format!("args + {offset}u");
            if let Some(attribute) = &parameter.attribute {
                let ty = parameter.ty;
                self.line(&format!(
                    "    var p{i} = {ty}(); // {}, unlinked {attribute}",
                    parameter.name
                ));
                continue;
            }
            let value = match parameter.ty {
                ParameterType::Image => format!("sam2D(patina_arg_word({word}))"),
                ParameterType::Ramp => format!("ramp1D(patina_arg_word({word}))"),
                ParameterType::Array(..) => word,
                ty => format!("patina_arg_{ty}({word})"),
            };
            let keyword = if parameter.ty.is_linkable() {
                "var"
            } else {
                "let"
            };
            self.line(&format!(
                "    {keyword} p{i} = {value}; // {}",
                parameter.name
            ));
        }
        for word in 0..linkable.len().div_ceil(32) {
            self.line(&format!("    let links{word} = patina_program_word(at);"));
            self.line("    at += 1u;");
        }
        for (word, group) in linkable.chunks(32).enumerate() {
            self.line(&format!("    if links{word} != 0u {{"));
            for (bit, &i) in group.iter().enumerate() {
                let parameter = &texture.parameters()[i];
                let value = linked("patina_next_link(&at)", parameter.ty);
                let mask = format!("(links{word} & {}u) != 0u", 1u32 << bit);
                if parameter.attribute.is_none() {
                    self.line(&format!("        if {mask} {{ p{i} = {value}; }}"));
                    continue;
                }
                self.line(&format!("        if {mask} {{"));
                self.line("            let word = patina_program_word(at);");
                self.line("            at += 1u;");
                self.line("            if word == patina_constant {");
                let (ty, offset) = (parameter.ty, offsets[i]);
                let constant = match parameter.is_coordinate() {
                    true => format!("vec4f(patina_arg_vec3f(args + {offset}u), 0.0)"),
                    false => format!("patina_arg_{ty}(args + {offset}u)"),
                };
                self.line(&format!("                p{i} = {constant};"));
                self.line("            } else {");
                let value = linked("patina_link(word)", ty);
                self.line(&format!("                p{i} = {value};"));
                self.line("            }");
                self.line("        }");
            }
            self.line("    }");
        }
        if texture.reads_occlusion() {
            self.line("    let occlusion = patina_program_word(at);");
            self.line("    at += 1u;");
            self.line(
                "    patina_occlusion = vec2u(occlusion & 0xffu, (occlusion >> 8u) & 0xffu);",
            );
        }
        let outputs = texture.outputs();
        for word in 0..outputs.len().saturating_sub(1).div_ceil(2) {
            self.line(&format!("    let kept{word} = patina_program_word(at);"));
            self.line("    at += 1u;");
        }
        // Behind the AO slots, which an attribute may need.
        for (place, &i) in linkable.iter().enumerate() {
            let parameter = &texture.parameters()[i];
            if let Some(attribute) = &parameter.attribute {
                let (word, mask) = (place / 32, 1u32 << (place % 32));
                let value = linked(&attribute_read(attribute), parameter.ty);
                let value = match parameter.is_coordinate() {
                    true => format!("vec4f({value}.xyz, 0.0)"),
                    false => value,
                };
                self.line(&format!(
                    "    if (links{word} & {mask}u) == 0u {{ p{i} = {value}; }}"
                ));
                if parameter.is_coordinate() {
                    let pixel = own_pixel(parameter);
                    self.line(&format!("    p{i} = patina_place(p{i}, {pixel});"));
                }
            }
        }
        if texture.rewrite().guards_loops {
            self.line("    patina_loops = 0u;");
        }
        let arguments: Vec<String> = (0..offsets.len()).map(|i| format!("p{i}")).collect();
        self.line(&format!(
            "    let result = {name}__userProc({});",
            arguments.join(", ")
        ));
        for (number, output) in outputs.iter().enumerate().skip(1) {
            let (word, shift) = ((number - 1) / 2, 16 * ((number - 1) % 2));
            let value = stored(&format!("result.{}", output.name), output.ty);
            self.line(&format!(
                "    patina_keep((kept{word} >> {shift}u) & 0xffffu, {value}, args);"
            ));
        }
        let value = first_result("result", texture);
        self.line(&format!("    return {value};"));
        self.line("}");
    }

    fn run(&mut self, library: &Library, names: &[String]) {
        self.line(&format!("fn {RUN}(offset: u32) {{"));
        self.line("    var at = offset + 1u;");
        self.line(
            "    for (var remaining = patina_program_word(offset); remaining > 0u; remaining--) {",
        );
        self.line("        let head = patina_program_word(at);");
        self.line("        let args = patina_program_word(at + 1u);");
        self.line("        at += 2u;");
        self.line("        var result = vec4f(0.0, 0.0, 0.0, 1.0);");
        self.line("        switch head & 0xffffu {");
        for (number, (texture, name)) in library.textures().iter().zip(names).enumerate() {
            self.line(&format!("            case {number}u: {{"));
            self.line(&format!("                result = {CALL}{name}(args, at);"));
            self.line(&format!("                at += {};", words_behind(texture)));
            self.report_overrun(texture, number);
            self.line("            }");
        }
        self.line("            default: {}");
        self.line("        }");
        self.line("        patina_check(result, args);");
        self.line("        patina_stack[head >> 16u] = result;");
        self.line("    }");
        self.line("}");
    }

    fn report_overrun(&mut self, texture: &TextureType, number: usize) {
        if texture.rewrite().guards_loops {
            let number = number + 1;
            self.line(&format!(
                "                if patina_loops > patina_loop_limit {{ patina_overrun = {number}u; }}"
            ));
        }
    }
}

/// How many words an instruction has behind its first two, as WGSL: at the third, `at`.
fn words_behind(texture: &TextureType) -> String {
    let parameters = texture.parameters().iter();
    let linkable = parameters.filter(|parameter| parameter.ty.is_linkable());
    let masks = linkable.count().div_ceil(32);
    let occlusion = usize::from(texture.reads_occlusion());
    let further = texture.outputs().len().saturating_sub(1).div_ceil(2);
    let mut words = format!("{}u", masks + occlusion + further);
    for mask in 0..masks {
        words += &format!(" + countOneBits(patina_program_word(at + {mask}u))");
    }
    words
}

/// Width of the hit's own pixel in the units of a place.
pub(crate) fn own_pixel(parameter: &Parameter) -> String {
    let component = parameter.pixel_component().unwrap_or("x");
    format!("patina_attr_Footprint().{component}")
}

/// A link's `vec4f` as the value of a parameter of type `ty`.
pub(crate) fn linked(link: &str, ty: ParameterType) -> String {
    match ty {
        ParameterType::F32 => format!("{link}.x"),
        ParameterType::I32 => format!("i32(round({link}.x))"),
        ParameterType::U32 => format!("u32(round({link}.x))"),
        ParameterType::Bool => format!("{link}.x > 0.5"),
        ParameterType::Vec2 => format!("{link}.xy"),
        ParameterType::Vec3 => format!("{link}.xyz"),
        _ => link.to_owned(),
    }
}

/// A result of `userProc` as it lies in a slot of the stack.
pub(crate) fn stored(result: &str, output: OutputType) -> String {
    match output {
        OutputType::F32 => format!("vec4f({result})"),
        OutputType::Vec2 => format!("vec4f({result}, 0.0, 1.0)"),
        OutputType::Vec3 => format!("vec4f({result}, 1.0)"),
        OutputType::Vec4 => result.to_owned(),
    }
}

/// The first output of a texture as it lies in a slot, from the variable that holds what `userProc` has returned.
pub(crate) fn first_result(result: &str, texture: &TextureType) -> String {
    match texture.outputs().first() {
        Some(first) => stored(&format!("{result}.{}", first.name), first.ty),
        None => stored(result, texture.output()),
    }
}

/// Text that can't end a line comment.
fn comment_safe(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') {
                ' '
            } else {
                c
            }
        })
        .collect()
}
