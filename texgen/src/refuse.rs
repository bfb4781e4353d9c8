//! What valid WGSL may hold and a texture may not: each construct with the reason and what to use instead.
//!
//! Works on tokens, so that a file full of them gets all its errors at once, and before naga, whose message would
//! speak of shader stages.

use std::collections::HashMap;

use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::prelude::is_prelude_name;
use crate::scope::{GlobalDecl, GlobalKind, Outline, Role};
use crate::standard;
use crate::tokens::TokenKind;

/// Largest file accepted, bytes. Far beyond any texture; keeps compile time and memory bounded.
pub(crate) const MAX_FILE_BYTES: usize = 256 * 1024;

/// Most tokens of one expression or statement, where of brackets beside each other only the deepest counts beyond itself, and
/// most module-scope declarations of a file. Compilers recurse along both, and a stack overflow can't be caught.
const MAX_CHAIN: usize = 1000;

/// Most tokens of a texture once all calls are expanded. A file of some lines can hold 2^30 calls without a loop.
const MAX_EXPANDED: u64 = 200_000;

/// Most tokens of constants, each written out wherever a function names it.
const MAX_COPIED: u64 = 1_000_000;

/// Finds all refused constructs of a file.
pub(crate) fn refused(file: &SourceFile, outline: &Outline<'_>) -> Diagnostics {
    let mut found = Diagnostics::new();
    declarations(file, outline, &mut found);
    for at in 0..outline.tokens.tokens.len() {
        if let Some((message, note)) = refused_token(outline, at) {
            found.push(
                Diagnostic::error(message)
                    .with_label(file, outline.span(at), "")
                    .with_note(note),
            );
        }
    }
    found
}

/// Finds what compilers could not survive.
pub(crate) fn too_deep(file: &SourceFile, outline: &Outline<'_>) -> Option<Diagnostic> {
    if let Some(TooLong { at, is_of_branches }) = too_long_a_chain(outline) {
        let (what, note) = match is_of_branches {
            true => (
                "this statement is too long",
                "each `else if` is within the former one: use `switch`, or several `if`s in functions of their own",
            ),
            false => ("this expression is too long", "split it up with `let`"),
        };
        return Some(
            Diagnostic::error(what)
                .with_label(
                    file,
                    outline.span(at),
                    format!("more than {MAX_CHAIN} names and operators, in brackets or in a row"),
                )
                .with_note(note),
        );
    }
    if let Some(extra) = outline.globals.get(MAX_CHAIN) {
        return Some(
            Diagnostic::error(format!("more than {MAX_CHAIN} declarations"))
                .with_label(file, outline.span(extra.keyword), "")
                .with_note("split the texture up: nodes can be linked to each other"),
        );
    }
    if let Some(name) = too_large_structure(outline) {
        return Some(
            Diagnostic::error(
                "this structure is too large once the structures in it are written out",
            )
            .with_label(
                file,
                outline.span(name),
                format!("more than {MAX_EXPANDED} names and operators"),
            )
            .with_note("hold less in it, or arrays in the place of many members"),
        );
    }
    if let Some(at) = too_much_copied(outline) {
        return Some(
            Diagnostic::error(
                "the constants are too large once they are written out wherever functions name them",
            )
            .with_label(
                file,
                outline.span(at),
                format!("more than {MAX_COPIED} names and operators up to here"),
            )
            .with_note("read a table through one function, so that it is named once; or put tables into images, or into `array<T, N>` parameters of `userProc`, which are read in place"),
        );
    }
    let entry = outline.function("userProc")?;
    let size = expanded_size(outline);
    (size > MAX_EXPANDED).then(|| {
        Diagnostic::error(
            "the texture is too large once its calls are expanded, as compilers for GPUs do",
        )
        .with_label(
            file,
            outline.span(entry.name),
            format!("more than {MAX_EXPANDED} names and operators"),
        )
        .with_note(
            "call functions from loops rather than many times in a row, or split the texture up",
        )
    })
}

/// Characters that look like one of WGSL's and come with text from elsewhere, what they are, and what is meant.
const STRANGE: [(char, &str, &str); 21] = [
    ('\u{2212}', "a minus sign", "-"),
    ('\u{2010}', "a hyphen", "-"),
    ('\u{2011}', "a non-breaking hyphen", "-"),
    ('\u{2013}', "an en dash", "-"),
    ('\u{2014}', "an em dash", "-"),
    ('\u{d7}', "a multiplication sign", "*"),
    ('\u{f7}', "a division sign", "/"),
    ('\u{2264}', "a sign for less or equal", "<="),
    ('\u{2265}', "a sign for greater or equal", ">="),
    ('\u{2260}', "a sign for unequal", "!="),
    ('\u{ff08}', "a wide bracket", "("),
    ('\u{ff09}', "a wide bracket", ")"),
    ('\u{ff0c}', "a wide comma", ","),
    ('\u{ff1b}', "a wide semicolon", ";"),
    ('\u{201c}', "a quotation mark", ""),
    ('\u{201d}', "a quotation mark", ""),
    ('\u{200b}', "a space without width", ""),
    ('\u{feff}', "a byte-order mark", ""),
    ('\u{a0}', "a no-break space", " "),
    ('\u{202f}', "a no-break space", " "),
    ('\u{3000}', "a wide space", " "),
];

/// Characters outside of comments that only look like WGSL: naga would say what it had expected in their places.
pub(crate) fn strange_characters(file: &SourceFile, outline: &Outline<'_>) -> Diagnostics {
    let words = outline
        .tokens
        .tokens
        .iter()
        .filter(|token| token.kind == TokenKind::Word);
    let characters = words.flat_map(|token| {
        let inside = token.text.char_indices().filter(|(_, c)| !c.is_ascii());
        inside.map(move |(at, c)| (token.start + at, c))
    });
    let found = characters.filter_map(|(at, c)| {
        let (_, name, meant) = STRANGE.iter().find(|(strange, ..)| *strange == c)?;
        let code = u32::from(c);
        let note = match *meant {
            "" => "remove it".to_owned(),
            " " => "write a blank".to_owned(),
            meant => format!("write `{meant}`"),
        };
        let error = Diagnostic::error(format!("{name} (U+{code:04X}) is no character of WGSL"));
        Some(
            error
                .with_label(file, at..at + c.len_utf8(), "")
                .with_note(note),
        )
    });
    found.collect()
}

/// What is in a bracket, or in none, as far as it has been read: how deep a compiler recurses along it.
#[derive(Clone, Copy, Default)]
struct Depth {
    /// Tokens since the last separator: each operator may be around all before it. A bracket with what is in it is one.
    chain: usize,
    /// Of the brackets among them that of the deepest.
    inner: usize,
    /// Of all up to the last separator.
    before: usize,
    /// Of the longest branch since then, where branches are told apart.
    branch: usize,
}

impl Depth {
    fn whole(self) -> usize {
        self.before.max(self.statement())
    }

    /// Of what was read since the last separator.
    fn statement(self) -> usize {
        self.branch.max(self.chain + self.inner)
    }

    /// Begins a branch that doesn't count with the former one.
    fn part(&mut self) {
        *self = Self {
            before: self.before,
            branch: self.statement(),
            ..Self::default()
        };
    }

    fn bracket(&mut self, inner: usize) {
        self.chain += 1;
        self.inner = self.inner.max(inner);
    }

    fn separate(&mut self) {
        *self = Self {
            before: self.whole(),
            ..Self::default()
        };
    }
}

/// Where something is longer than compilers survive.
struct TooLong {
    /// The token up to which it is.
    at: usize,
    /// It is a row of `else if`, no expression.
    is_of_branches: bool,
}

/// Finds an expression or a statement that is longer than compilers survive.
fn too_long_a_chain(outline: &Outline<'_>) -> Option<TooLong> {
    let mut depth = Depth::default();
    // The same if what is behind an `else` didn't count with what is before.
    let mut apart = Depth::default();
    let mut outer = Vec::new();
    for (at, token) in outline.tokens.tokens.iter().enumerate() {
        match token.text {
            "(" | "[" | "{" => {
                outer.push((std::mem::take(&mut depth), std::mem::take(&mut apart)));
            }
            ")" | "]" | "}" => {
                let inner = [depth.whole(), apart.whole()];
                (depth, apart) = outer.pop().unwrap_or_default();
                depth.bracket(inner[0]);
                apart.bracket(inner[1]);
            }
            "," | ";" => {
                depth.separate();
                apart.separate();
            }
            _ => {
                depth.chain += 1;
                apart.chain += 1;
                if token.text == "else" {
                    apart.part();
                }
            }
        }
        if depth.whole() > MAX_CHAIN {
            // Where one of its conditions is long, that one is told.
            let is_of_branches = apart.statement() <= MAX_CHAIN / 2;
            return Some(TooLong { at, is_of_branches });
        }
        // Each `else if` is within the former one.
        if token.text == "}" && outline.word(at + 1) != "else" {
            depth.separate();
            apart.separate();
        }
    }
    None
}

/// Tokens of `userProc` with every call replaced by the function's body, again and again. Saturates.
fn expanded_size(outline: &Outline<'_>) -> u64 {
    let functions = outline.functions.iter();
    let (own, calls): (Vec<u64>, Vec<Vec<usize>>) = functions
        .map(|function| {
            let body = function.body.clone();
            let predeclared = (body.clone()).filter(|&at| outline.roles[at] == Role::Predeclared);
            let standard = predeclared.map(|at| standard::expanded_size(outline.word(at)));
            (
                body.len() as u64 + standard.sum::<u64>(),
                outline.calls(body),
            )
        })
        .unzip();
    let entry = outline
        .functions
        .iter()
        .position(|function| outline.word(function.name) == "userProc");
    entry.map_or(0, |entry| expanded(&own, &calls)[entry])
}

/// Declarations of module scope, each with those that it uses written out in their places.
struct WrittenOut<'o, 'a> {
    declarations: Vec<&'o GlobalDecl>,
    by_name: HashMap<&'a str, usize>,
    /// Tokens of each.
    sizes: Vec<u64>,
}

impl<'o, 'a> WrittenOut<'o, 'a> {
    fn new(outline: &'o Outline<'a>, kinds: &[GlobalKind]) -> Self {
        let declarations: Vec<&GlobalDecl> = (outline.globals.iter())
            .filter(|global| kinds.contains(&global.kind))
            .collect();
        let by_name: HashMap<&str, usize> = (declarations.iter().enumerate())
            .filter_map(|(index, global)| Some((outline.word(global.name?), index)))
            .collect();
        let own: Vec<u64> = (declarations.iter())
            .map(|global| global.tokens.len() as u64)
            .collect();
        let uses: Vec<Vec<usize>> = (declarations.iter())
            .map(|global| {
                let tokens = global.tokens.clone();
                // Not its own name, nor those of members.
                let names =
                    tokens.filter(|&at| Some(at) != global.name && outline.word(at + 1) != ":");
                names
                    .filter_map(|at| by_name.get(outline.word(at)).copied())
                    .collect()
            })
            .collect();
        Self {
            sizes: expanded(&own, &uses),
            declarations,
            by_name,
        }
    }
}

/// The structure that is the largest once those in it are written out, if it is too large; naga walks through such a
/// structure member by member.
fn too_large_structure(outline: &Outline<'_>) -> Option<usize> {
    let types = WrittenOut::new(outline, &[GlobalKind::Struct, GlobalKind::Alias]);
    let largest = (0..types.declarations.len())
        .max_by_key(|&index| (types.sizes[index], std::cmp::Reverse(index)))?;
    let declaration = types.declarations[largest];
    (types.sizes[largest] > MAX_EXPANDED).then(|| declaration.name.unwrap_or(declaration.keyword))
}

/// The place in a function by which constants have been named too often for their size: naga may copy all that is in one
/// wherever it is named.
fn too_much_copied(outline: &Outline<'_>) -> Option<usize> {
    let constants = WrittenOut::new(outline, &[GlobalKind::Const]);
    let mut copied = 0u64;
    for function in &outline.functions {
        // Those of the function by their declaring tokens.
        let mut local: HashMap<usize, u64> = HashMap::new();
        let mut declared: Option<(usize, u64)> = None;
        for at in function.body.clone() {
            let word = outline.word(at);
            match word {
                "const" => declared = Some((at + 1, 0)),
                ";" => local.extend(declared.take()),
                _ => {}
            }
            let size = match outline.roles[at] {
                Role::Global => (constants.by_name.get(word)).map(|&index| constants.sizes[index]),
                Role::Local(name) => local.get(&name).copied(),
                Role::Other | Role::Predeclared => None,
            };
            let size = size.unwrap_or(0);
            if let Some((_, tokens)) = &mut declared {
                *tokens = tokens.saturating_add(size.max(1));
            }
            copied = copied.saturating_add(size);
            if copied > MAX_COPIED {
                return Some(at);
            }
        }
    }
    None
}

/// The size of each of some things with everything that it uses written out in its place, again and again: its own size,
/// and the things it uses, by number, each as often as it does. Saturates.
fn expanded(own: &[u64], uses: &[Vec<usize>]) -> Vec<u64> {
    let mut sizes: Vec<Option<u64>> = vec![None; own.len()];
    let mut started = vec![false; own.len()];
    let mut open = Vec::new();
    for first in 0..own.len() {
        open.push(first);
        while let Some(&thing) = open.last() {
            // One that was started and is met again uses itself: naga will say so.
            let missing = uses[thing]
                .iter()
                .copied()
                .find(|&used| sizes[used].is_none() && !started[used]);
            started[thing] = true;
            match missing {
                Some(used) => open.push(used),
                None => {
                    let used = uses[thing].iter().map(|&used| sizes[used].unwrap_or(0));
                    sizes[thing] = Some(used.fold(own[thing], u64::saturating_add));
                    open.pop();
                }
            }
        }
    }
    sizes.into_iter().map(|size| size.unwrap_or(0)).collect()
}

fn declarations(file: &SourceFile, outline: &Outline<'_>, found: &mut Diagnostics) {
    for global in &outline.globals {
        let keyword = outline.span(global.keyword);
        match global.kind {
            GlobalKind::Override => found.push(
                Diagnostic::error("a texture can't have `override` constants")
                    .with_label(file, keyword, "")
                    .with_note("they would be fixed when the kernel is built: make it a parameter of `userProc`, or `const`"),
            ),
            GlobalKind::Var => {
                let space = if outline.word(global.keyword + 1) == "<" { outline.word(global.keyword + 2) } else { "" };
                let is_bound = (global.tokens.start..global.keyword).any(|at| outline.word(at) == "@");
                let space = if space.is_empty() && !is_bound { "private" } else { space };
                found.push(module_variable(space).with_label(file, keyword.start..outline.span_of(&global.tokens).end, ""));
            }
            GlobalKind::Directive => found.push(
                Diagnostic::error(format!("a texture can't have `{}` directives", outline.word(global.keyword)))
                    .with_label(file, outline.span_of(&global.tokens), "")
                    .with_note("they would hold for the whole kernel, the other textures included: remove it"),
            ),
            _ => {}
        }
        if let Some(name) = global
            .name
            .filter(|&name| is_prelude_name(outline.word(name)))
        {
            let text = outline.word(name);
            found.push(
                Diagnostic::error(format!(
                    "`{text}` is taken: it is a name of the texture language"
                ))
                .with_label(file, outline.span(name), "declared again here")
                .with_note(format!(
                    "rename it, for example `my{text}`; a local variable may be called `{text}`"
                )),
            );
        }
    }
}

fn module_variable(space: &str) -> Diagnostic {
    match space {
        "private" => Diagnostic::error("a texture can't have module-scope variables")
            .with_note("its result must depend on its arguments and the hit only: declare the variable in the function and pass `&variable` to helpers as `ptr<function, T>`"),
        "workgroup" => Diagnostic::error("a texture can't have workgroup variables")
            .with_note("hits are evaluated independently of each other: use variables of the function"),
        _ => Diagnostic::error("a texture can't have buffers, images or samplers of its own")
            .with_note("make it a parameter of `userProc`: `sam2D` for an image, `ramp1D` for a ramp, `array<T, N>` for a table"),
    }
}

/// Error and remedy for the construct that begins with token `at`, if it is a refused one.
fn refused_token(outline: &Outline<'_>, at: usize) -> Option<(String, String)> {
    let token = outline.tokens.tokens[at];
    if token.kind == TokenKind::Number {
        return half_number(token.text);
    }
    if token.kind != TokenKind::Word {
        return None;
    }
    let word = token.text;
    let previous = at.checked_sub(1).map_or("", |at| outline.word(at));
    let next = outline.word(at + 1);
    let error = |message: String, note: &str| Some((message, note.to_owned()));
    if previous == "@" {
        return match word {
            "compute" | "vertex" | "fragment" => error(
                format!("a texture can't have entry points (`@{word}`)"),
                "the entry of a texture is `fn userProc(...)`, without attributes: the renderer calls it",
            ),
            "diagnostic" => error(
                "a texture can't have `@diagnostic` attributes".into(),
                "there is nothing for it to filter in a texture: remove it",
            ),
            "group" | "binding" => None, // the variable behind it is refused
            "builtin" | "location" | "workgroup_size" => error(
                format!("`@{word}` belongs to entry points, which a texture can't have"),
                "pass the value as a parameter, or read it with `readAttr(NAME)`",
            ),
            _ => None,
        };
    }
    if word == "discard" {
        return error(
            "`discard` is not possible in a texture".into(),
            "return 0 and let the texture drive the material's opacity",
        );
    }
    if word.starts_with("patina_") {
        return error(
            format!("names that begin with `patina_` are kept for the renderer (`{word}`)"),
            "rename it",
        );
    }
    match outline.roles[at] {
        Role::Predeclared => {}
        _ => return None,
    }
    if matches!(word, "sam2D" | "ramp1D") && next == "(" {
        return error(
            format!("a `{word}` can't be made by a texture"),
            "take it as a parameter of `userProc` and hand it on to helpers",
        );
    }
    refused_builtin(word, next == "(").map(|(message, note)| (message, note.to_owned()))
}

/// A number with the suffix of `f16`.
fn half_number(text: &str) -> Option<(String, String)> {
    let is_hexadecimal = text.starts_with("0x") || text.starts_with("0X");
    let number = text.strip_suffix('h')?;
    // Of hexadecimal numbers only those with an exponent have suffixes.
    let is_half = !is_hexadecimal || number.contains(['p', 'P']);
    is_half.then(|| {
        let message = format!("`{text}` is a number of 16 bits, which textures don't have");
        (message, format!("write `{number}f`"))
    })
}

/// WGSL's own functions and types that a texture can't use.
fn refused_builtin(word: &str, called: bool) -> Option<(String, &'static str)> {
    if called {
        match word {
            "dpdx" | "dpdy" | "fwidth" | "dpdxCoarse" | "dpdyCoarse" | "fwidthCoarse"
            | "dpdxFine" | "dpdyFine" | "fwidthFine" => {
                return Some((
                    format!(
                        "`{word}` is not possible in a texture: hits have no neighbouring pixels"
                    ),
                    "use `readAttr(Footprint)`: x is the pixel's width here in metres, y in uv",
                ));
            }
            "workgroupBarrier" | "storageBarrier" | "textureBarrier" | "workgroupUniformLoad" => {
                return Some((
                    format!(
                        "`{word}` is not possible in a texture: hits are evaluated independently of each other"
                    ),
                    "remove it",
                ));
            }
            "arrayLength" => {
                return Some((
                    "`arrayLength` needs a buffer, which a texture can't have".into(),
                    "an array parameter `array<T, N>` has a fixed N: write it as a `const`",
                ));
            }
            _ => {}
        }
        if word.starts_with("subgroup")
            || word.starts_with("quad") && word[4..].starts_with(char::is_uppercase)
        {
            return Some((
                format!(
                    "`{word}` is not possible in a texture: hits are evaluated independently of each other"
                ),
                "remove it",
            ));
        }
        if word.starts_with("atomic") {
            return Some((
                format!(
                    "`{word}` is not possible in a texture: there is nothing shared between hits"
                ),
                "use a variable of the function",
            ));
        }
        if word == "textureDimensions" || word == "textureNumLevels" {
            return Some((
                format!("`{word}` is not possible in a texture"),
                "use `texSize(image)`, which gives width and height",
            ));
        }
        if word.starts_with("texture") && word[7..].starts_with(char::is_uppercase) {
            return Some((
                format!("`{word}` is not possible in a texture"),
                "use `tex2D(image, uv)` or `tex2DLod(image, uv, lod)` on a `sam2D` parameter",
            ));
        }
    }
    if word == "atomic" {
        return Some((
            "a texture can't have atomics".into(),
            "there is nothing shared between hits: use the plain type",
        ));
    }
    if word == "f16"
        || word.ends_with('h') && matches!(&word[..word.len() - 1], "vec2" | "vec3" | "vec4")
    {
        return Some((
            format!("`{word}` is not available in textures: not every GPU has it"),
            "use `f32` types",
        ));
    }
    if matches!(word, "sampler" | "sampler_comparison") || word.starts_with("texture_") {
        return Some((
            format!("`{word}` is not available in textures"),
            "take the image as a `sam2D` parameter of `userProc`, and read it with `tex2D(image, uv)`",
        ));
    }
    None
}
