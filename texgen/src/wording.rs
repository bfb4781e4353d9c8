//! naga's words in the user's terms: its messages speak of its own structures, and know nothing of remedies.

use std::ops::Range;

use crate::habits::instead_of;
use crate::prelude::prelude_names;
use crate::scope::{FunctionDecl, GlobalKind, Outline, Role};
use crate::suggest::did_you_mean;

/// naga's note on an error of its own parser's that is the file's doing.
const PARSER_DEPTH: &str = "Parser recursion limit exceeded";

/// The beginning of naga's notes on the types that a number can't become.
const NOT_CONVERTED: &str = "the expression couldn't be converted to have ";

/// naga's notes, with its lists of types in one line and without the types that textures don't have.
pub(crate) fn plain_notes(notes: &[String]) -> Vec<String> {
    let allowed = |note: &String| note.strip_prefix("allowed type: ").map(str::to_owned);
    let types: Vec<String> = notes
        .iter()
        .filter_map(allowed)
        .filter(|ty| {
            !["f16", "f64", "i16", "u16", "i64", "u64", "Abstract"]
                .iter()
                .any(|absent| ty.contains(absent))
        })
        .collect();
    let mut plain: Vec<String> = notes
        .iter()
        .filter(|note| {
            let is_internal = *note == PARSER_DEPTH || note.starts_with(NOT_CONVERTED);
            allowed(note).is_none() && !is_internal
        })
        .cloned()
        .collect();
    if let Some(last) = plain.last_mut().filter(|_| !types.is_empty()) {
        *last = format!("{} {}", last, types.join(", "));
    }
    plain
}

/// Messages of naga's that speak of its own structures, said so that an author of a texture understands them.
pub(crate) fn in_user_terms(message: &str) -> String {
    if let Some(rest) = message.strip_prefix("Argument ")
        && let Some((number, _)) = rest.split_once(" value ")
        && let Ok(number) = number.parse::<u32>()
    {
        return format!(
            "argument {} of the call is not of the type that the function declares",
            number + 1
        );
    }
    if message.starts_with("The `return` expression None") {
        return "not every way through the function ends with a `return` of its result".into();
    }
    if message.starts_with("The `return` expression Some") {
        return "the returned value is not of the type that the function declares".into();
    }
    if [
        "internal WGSL front end error",
        "brace nesting limit reached",
    ]
    .contains(&message)
    {
        return "nested too deeply: split it up with `let` or functions".into();
    }
    if let Some((from, to)) = refused_conversion(message) {
        return type_names(format!("`{from}` doesn't become `{to}` by itself"));
    }
    let mut plain = plain_message(message);
    // One sentence style for all messages: they begin small, but for names.
    if plain.starts_with(|c: char| c.is_ascii_uppercase())
        && plain[1..].starts_with(|c: char| c.is_ascii_lowercase() || c == ' ')
    {
        plain[..1].make_ascii_lowercase();
    }
    plain
}

/// The types of a conversion that WGSL doesn't make.
fn refused_conversion(message: &str) -> Option<(&str, &str)> {
    let rest = message.strip_prefix("automatic conversions cannot convert")?;
    let mut quoted = rest.split('`');
    Some((quoted.nth(1)?, quoted.nth(1)?))
}

/// The conversion that WGSL doesn't make, to be written: of the value that naga shows, with its type.
fn conversion(message: &str, labels: &[(Range<usize>, String)], text: &str) -> Option<String> {
    let (_, to) = refused_conversion(message)?;
    let (span, ty) = labels.iter().find_map(|(span, label)| {
        let ty = label.strip_prefix("this expression has type ")?;
        Some((span.clone(), ty))
    })?;
    let operand = text.get(span).filter(|operand| !operand.contains('\n'))?;
    let to = match ty.strip_prefix("vec") {
        Some(rest) => format!("vec{}{}", rest.get(..1)?, to.get(..1)?),
        None => to.to_owned(),
    };
    let is_plain = matches!(ty, "f32" | "i32" | "u32" | "bool") || ty.starts_with("vec");
    (is_plain && operand.len() <= 60).then(|| format!("convert: `{to}({operand})`"))
}

/// What the parser had expected where it found something else.
pub(crate) fn expected(message: &str) -> Option<&str> {
    Some(message.strip_prefix("expected ")?.split_once(", found ")?.0)
}

/// naga's message without what belongs to its own tables and structures: `Expression [7]`, `Array { base: [3], .. }`.
pub(crate) fn plain_message(message: &str) -> String {
    let is_of_abstract = message.starts_with("this expression has type ");
    if message == "see msg"
        || message.starts_with("naga::")
        || is_of_abstract && message.contains("{Abstract")
    {
        return String::new();
    }
    without_structures(&type_names(without_handles(message)))
}

/// Without numbers of tables: ` [7]`.
fn without_handles(message: &str) -> String {
    let mut out = String::new();
    let mut rest = message;
    while let Some(at) = rest.find(" [") {
        let digits = rest[at + 2..]
            .bytes()
            .take_while(u8::is_ascii_digit)
            .count();
        if digits > 0 && rest[at + 2 + digits..].starts_with(']') {
            out.push_str(&rest[..at]);
            rest = &rest[at + 2 + digits + 1..];
        } else {
            out.push_str(&rest[..at + 2]);
            rest = &rest[at + 2..];
        }
    }
    out + rest
}

/// What naga shows of its structures, as one word: `Array { base: [3], size: Constant(4), stride: 4 }` is an array.
fn without_structures(message: &str) -> String {
    let mut out = String::new();
    let mut rest = message;
    while let Some(open) = rest.find(" { ") {
        let name_at = rest[..open]
            .rfind(|c: char| !c.is_ascii_alphanumeric())
            .map_or(0, |before| before + 1);
        let mut depth = 0usize;
        let end = rest[open..].char_indices().find_map(|(at, c)| {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            (c == '}' && depth == 0).then_some(open + at + 1)
        });
        let (Some(end), true) = (
            end,
            rest[name_at..].starts_with(|c: char| c.is_ascii_uppercase()),
        ) else {
            out.push_str(&rest[..open + 3]);
            rest = &rest[open + 3..];
            continue;
        };
        out.push_str(&rest[..name_at]);
        out.push_str(match &rest[name_at..open] {
            "Array" => "an array",
            "Struct" => "a structure",
            "Pointer" | "ValuePointer" => "a pointer",
            "Vector" => "a vector",
            "Matrix" => "a matrix",
            _ => "something else",
        });
        rest = &rest[end..];
    }
    out + rest
}

/// Types as WGSL writes them, where naga shows its own structures.
fn type_names(mut message: String) -> String {
    for (name, words) in [
        ("Float", "a number with a fraction"),
        ("Int", "a whole number"),
    ] {
        message = message.replace(&format!("`{{Abstract{name}}}`"), words);
    }
    if !message.contains("Scalar {") {
        return message;
    }
    let scalars = [("Float", "f32"), ("Sint", "i32"), ("Uint", "u32")];
    for (kind, name) in scalars {
        message = message.replace(&format!("Scalar {{ kind: {kind}, width: 4 }}"), name);
    }
    message = message.replace("Scalar { kind: Bool, width: 1 }", "bool");
    const SIZES: [(&str, u32); 3] = [("Bi", 2), ("Tri", 3), ("Quad", 4)];
    for scalar in ["f32", "i32", "u32", "bool"] {
        for (size, n) in SIZES {
            let vector = format!("Vector {{ size: {size}, scalar: {scalar} }}");
            message = message.replace(&vector, &format!("vec{n}<{scalar}>"));
            for (rows, m) in SIZES {
                let matrix =
                    format!("Matrix {{ columns: {size}, rows: {rows}, scalar: {scalar} }}");
                message = message.replace(&matrix, &format!("mat{n}x{m}<{scalar}>"));
            }
        }
        message = message.replace(&format!("Scalar({scalar})"), scalar);
    }
    // "(of type f32)" without the words around it that say the same again.
    message.replace("value of value ", "value of type ")
}

/// What to do about an error of naga's at `place`.
pub(crate) fn remedies(
    message: &str,
    labels: &[(Range<usize>, String)],
    outline: &Outline<'_>,
) -> Vec<String> {
    let mut notes = Vec::new();
    notes.extend(conversion(message, labels, outline.text));
    let place = labels.first().map_or(0..0, |(span, _)| span.clone());
    notes.extend(of_first_steps(message, place.start, outline));
    if let Some(note) = vector_of_number(message, place.clone(), outline.text) {
        notes.push(note);
    } else if message.contains("`{AbstractFloat}`") {
        let note = "numbers with a fraction, as `2.0`, are `f32`: convert what meets them by `f32(...)`, or them by `i32(...)`";
        notes.push(note.into());
    }
    let message = message.to_lowercase();
    if message.starts_with("expected variable access")
        && let Some(word) = outline.text.get(place.clone())
    {
        notes.push(format!(
            "`{word}` is a function or a type, no value: write `{word}(...)`"
        ));
    }
    let unknown = message.contains("no definition in scope") || message.contains("unknown type");
    if let Some(word) = outline.text.get(place.clone()).filter(|_| unknown) {
        if let Some(note) = instead_of(word) {
            notes.push(note);
        } else if let Some(near) = did_you_mean(word, names_in_scope(outline, place.start, word)) {
            if near != word {
                notes.push(format!("did you mean `{near}`?"));
            } else if message.contains("no definition in scope") {
                notes.push(not_a_value(word));
            }
        }
    }
    if expected(&message).is_some_and(|what| what.contains("`{`")) {
        notes.push("braces are never left out in WGSL: `if condition { ... }`".into());
    }
    if message.contains("is recursive") || message.contains("is cyclic") {
        notes.push("WGSL has no recursion: use a loop, with a bounded number of iterations".into());
    }
    let of_values = OF_VALUES.iter();
    let of_values = of_values.filter(|(beginning, _)| message.starts_with(beginning));
    notes.extend(of_values.map(|&(_, note)| note.to_owned()));
    if message.contains("redefinition") {
        notes.push(unique_within(place.start, outline).into());
    }
    notes
}

/// Text that is short enough for a note.
pub(crate) fn short(text: &str, span: Range<usize>) -> Option<&str> {
    let found = text.get(span)?.trim();
    (!found.is_empty() && found.len() <= 60 && !found.contains('\n')).then_some(found)
}

/// What to write where a number stands for a vector, which it doesn't become.
fn vector_of_number(message: &str, place: Range<usize>, text: &str) -> Option<String> {
    let (from, to) = refused_conversion(message)?;
    let (count, component) = (to.strip_prefix("vec")?.get(..1)?, to.get(5..6)?);
    let becomes = match from {
        "{AbstractFloat}" => component == "f",
        "{AbstractInt}" => matches!(component, "f" | "i" | "u"),
        _ => false,
    };
    let number = short(text, place).filter(|text| text.starts_with(|c: char| c.is_ascii_digit()));
    let number = number.unwrap_or("...");
    becomes.then(|| format!("write `vec{count}{component}({number})`"))
}

/// What who begins with WGSL takes from other languages, where naga's parser stops.
fn of_first_steps(message: &str, place: usize, outline: &Outline<'_>) -> Option<String> {
    let tokens = &outline.tokens.tokens;
    let at = tokens.partition_point(|token| token.end() <= place);
    let within = |open: usize| {
        let span = outline.span(open).end..outline.span(outline.closing(open)).start;
        short(outline.text, span)
    };
    match outline.word(at) {
        "let" if message.starts_with("expected global item") => {
            let from = outline.span(at).end;
            let length = outline.text.get(from..)?.find(';');
            let rest = length.and_then(|length| short(outline.text, from..from + length));
            let rest =
                rest.map_or_else(|| format!("{} = ...", outline.word(at + 1)), str::to_owned);
            Some(format!("outside of functions write `const {rest};`"))
        }
        "[" if message.starts_with("expected expression") => {
            Some(format!("write `array({})`", within(at).unwrap_or("...")))
        }
        "atan" if message.starts_with("too many arguments") && outline.word(at + 1) == "(" => Some(
            format!("write `atan2({})`", within(at + 1).unwrap_or("y, x")),
        ),
        _ => None,
    }
}

/// What to do about what naga says where it works out values as it reads: it doesn't show them.
const OF_VALUES: &[(&str, &str)] = &[
    (
        "the concrete type `u32` cannot represent the abstract value `-",
        "`u32` has no numbers below 0: convert what meets this one by `i32(...)`, vectors by `vec3i(...)`",
    ),
    (
        "cannot apply the binary op",
        "both sides must be of one type, or a vector and a number of its type: convert one, as by `f32(...)`",
    ),
    (
        "cannot apply the unary op",
        "`-` takes numbers with a sign, `~` whole numbers, `!` what is true or false",
    ),
    (
        "cannot access at the index",
        "elements and components are counted from 0 on",
    ),
    (
        "not implemented as constant expression",
        "constants can't have this function: call it within a function, with a variable (`var`)",
    ),
    (
        "rhs of shift operation",
        "a number has 32 bits: shift it by 31 at most",
    ),
    (
        "cannot take the address of a vector component",
        "copy it to a variable, hand that one over, and copy it back: `var part = v.x; f(&part); v.x = part;`",
    ),
];

/// Why a name that there is means no value at a place, and what to do.
fn not_a_value(word: &str) -> String {
    if !BUILTINS.split_whitespace().any(|name| name == word) {
        return format!(
            "a variable is known from behind its declaration to the end of the block: declare `{word}` further up or out"
        );
    }
    let is_type = matches!(word, "bool" | "f32" | "i32" | "u32")
        || word.starts_with("vec")
        || word.starts_with("mat");
    let what = if is_type { "type" } else { "function" };
    format!("`{word}` is a {what}: write `{word}(...)`")
}

/// Where the name that is declared again at a place has to be the only one.
fn unique_within(place: usize, outline: &Outline<'_>) -> &'static str {
    let mut globals = outline.globals.iter();
    let around = globals.find(|global| outline.span_of(&global.tokens).contains(&place));
    let is_its_own = around
        .and_then(|global| global.name)
        .is_some_and(|name| outline.span(name).contains(&place));
    match around.map(|global| global.kind) {
        Some(GlobalKind::Function) if !is_its_own => {
            "names of variables are unique within a block, those of parameters within a function: rename one of them"
        }
        Some(GlobalKind::Struct) if !is_its_own => {
            "names of members are unique within their struct: rename one of them"
        }
        _ => {
            "names of functions, structs, constants and aliases are unique within a file: rename one of them"
        }
    }
}

/// What to do where a parameter is assigned to; naga takes it for a `let`.
pub(crate) fn parameter_to_copy(
    labels: &[(Range<usize>, String)],
    outline: &Outline<'_>,
) -> Option<String> {
    let mut labels = labels.iter();
    let (declared, _) = labels.find(|(_, text)| text == "this is an immutable binding")?;
    let functions = outline.functions.iter();
    let mut parameters = functions.flat_map(|function| &function.params);
    let parameter = parameters.find(|parameter| outline.span(parameter.name) == *declared)?;
    let name = outline.word(parameter.name);
    Some(format!(
        "a parameter can't be changed; copy it: `var my_{name} = {name};`"
    ))
}

/// WGSL's own names that a texture is likely to want.
const BUILTINS: &str = "abs acos all any asin atan atan2 bool ceil clamp cos cosh cross degrees distance dot exp \
    exp2 f32 faceForward floor fma fract i32 inverseSqrt ldexp length log log2 mat2x2f mat3x3f \
    mat4x4f max min mix modf normalize pow radians reflect refract round saturate select sign \
    sin sinh smoothstep sqrt step tan tanh transpose trunc u32 vec2f vec2i vec2u vec3f vec3i \
    vec3u vec4f vec4i vec4u";

/// Names that may be meant at a place: the file's, the prelude's, locals, and common built-ins. `word`, which stands there, is
/// among them also where a local of this name was declared before but isn't known there.
fn names_in_scope<'a>(outline: &Outline<'a>, place: usize, word: &'a str) -> Vec<&'a str> {
    let in_place = outline
        .functions
        .iter()
        .find(|function| outline.span_of(&function.body).contains(&place));
    let mut names: Vec<&'a str> = Vec::new();
    if let Some(function) = in_place {
        let params = function.params.iter();
        names.extend(params.map(|param| outline.word(param.name)));
        names.extend(locals(outline, function, place, word));
    }
    names.extend(
        outline
            .globals
            .iter()
            .filter_map(|global| global.name)
            .map(|name| outline.word(name)),
    );
    names.extend(prelude_names().map(|name| -> &'a str { name }));
    names.extend(BUILTINS.split_whitespace());
    names
}

/// Locals of a function that are known at a place in it: from behind their declarations to the ends of their blocks. `word`
/// is one of them where it is declared anywhere before the place.
fn locals<'a>(
    outline: &Outline<'a>,
    function: &FunctionDecl,
    place: usize,
    word: &'a str,
) -> Vec<&'a str> {
    let mut names: Vec<&'a str> = Vec::new();
    // How many names there were where each block around the place began; that of a loop begins at its `for`.
    let mut blocks = Vec::new();
    let mut of_loop = None;
    let mut declared = None; // known from the next `;` on
    let mut is_declared = false;
    let before = (function.body.clone()).take_while(|&at| outline.span(at).start < place);
    for at in before {
        if outline.roles[at] == Role::Local(at) {
            declared = Some(at);
            is_declared |= outline.word(at) == word;
            continue;
        }
        match outline.word(at) {
            "for" => of_loop = Some(names.len()),
            "{" => blocks.push(of_loop.take().unwrap_or(names.len())),
            "}" => {
                names.truncate(blocks.pop().unwrap_or(0));
                declared = None;
            }
            ";" => names.extend(declared.take().map(|name| outline.word(name))),
            _ => {}
        }
    }
    if is_declared {
        names.push(word);
    }
    names
}
