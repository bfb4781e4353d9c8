//! What naga says about types, in plain words.

use std::ops::Range;

use crate::scope::{Outline, Role};
use crate::tokens::TokenKind;
use crate::wording::{plain_message, short};

/// What naga says of a number without a type of its own beside something that it doesn't become like.
const MIXTURES: [&str; 2] = [
    "failed to convert expression to a concrete type",
    "Abstract types may only appear in constant expressions",
];

pub(super) fn is_of_mixture(message: &str) -> bool {
    MIXTURES.contains(&message)
}

/// Functions that naga doesn't compute of numbers without a type of their own.
const UNCOMPUTED: [&str; 4] = ["mix", "smoothstep", "transpose", "determinant"];

/// What is wrong where a function that declares no result returns what is at `span`: of a number without a type naga doesn't say so.
fn of_return(outline: &Outline<'_>, span: &Range<usize>) -> Option<(String, String)> {
    let tokens = &outline.tokens.tokens;
    let at = tokens.partition_point(|token| token.start < span.start);
    let mut functions = outline.functions.iter();
    let function = functions.find(|function| function.body.contains(&at))?;
    let before = (function.body.start..at).rev();
    let mut ends = before.filter(|&at| matches!(outline.word(at), ";" | "{" | "}"));
    let is_returned = outline.word(ends.next()? + 1) == "return";
    (is_returned && function.result.is_empty()).then(|| {
        let message = "a value is returned, but the function declares none";
        let remedy = "write `-> TYPE` behind its parameters";
        (message.to_owned(), remedy.to_owned())
    })
}

/// What is wrong with a call of nothing but numbers without a type, or with a number that is returned, where naga speaks of such a
/// number at `span`.
pub(super) fn of_literals(outline: &Outline<'_>, span: &Range<usize>) -> Option<(String, String)> {
    if let Some(told) = of_return(outline, span) {
        return Some(told);
    }
    let is_number = |at: usize| {
        let token = outline.tokens.tokens[at];
        token.kind != TokenKind::Word
            || outline.roles[at] == Role::Predeclared
            || matches!(token.text, "true" | "false")
    };
    let arguments = |at: usize| {
        let is_called =
            outline.roles.get(at) == Some(&Role::Predeclared) && outline.word(at + 1) == "(";
        let inside = at + 2..outline.closing(at + 1).max(at + 2);
        (is_called && inside.clone().all(is_number)).then_some(inside)
    };
    let call = (0..outline.tokens.tokens.len()).find_map(|at| {
        if !UNCOMPUTED.contains(&outline.word(at)) {
            return None;
        }
        let inside = arguments(at)?;
        let overlaps =
            outline.span(at).start < span.end && span.start < outline.span(inside.end).end;
        overlaps.then_some((outline.word(at), inside.start))
    });
    if let Some((name, first)) = call {
        let number = outline.word(first);
        let remedy = match outline.word(first + 1) {
            "," if number.contains('.') => {
                format!("give one of them a type: `{name}({number}f, ...)`")
            }
            "," => format!("give one of them a type: `{name}({number}.0f, ...)`"),
            _ => "give one of them a type, as `vec3f(...)`, `mat2x2f(...)` or `1.0f`".to_owned(),
        };
        let message =
            format!("the compiler in Patina can't compute `{name}` of numbers without a type");
        return Some((message, remedy));
    }
    // Of others naga says no more where what they give is no number.
    let at = outline
        .tokens
        .tokens
        .partition_point(|token| token.start < span.start);
    let is_name = outline.span(at) == *span && arguments(at).is_some();
    is_name.then(|| {
        let message = format!(
            "what `{}` gives here is not a finite number",
            outline.word(at)
        );
        (message, "a constant has to be finite".to_owned())
    })
}

/// What is wrong where a vector and a number stand for arguments that have to be of one type.
pub(super) fn of_vector_and_number(
    message: &str,
    labels: &[(Range<usize>, String)],
    text: &str,
) -> Option<(String, String)> {
    let rest = message.strip_prefix("inconsistent type passed as argument #")?;
    let function = rest.split('`').nth(1)?;
    let typed = |is_vector: bool| {
        labels.iter().find_map(|(span, label)| {
            let ty = type_in(label)?;
            let is_scalar = matches!(
                ty,
                "f32" | "i32" | "u32" | "{AbstractFloat}" | "{AbstractInt}"
            );
            (ty.starts_with("vec") == is_vector && is_vector != is_scalar).then_some((span, ty))
        })
    };
    let ((whole, vector), (number, scalar)) = (typed(true)?, typed(false)?);
    let (count, component) = (vector.get(3..4)?, vector.get(5..6)?.replace('{', "f"));
    if !"fiu".contains(&component) {
        return None;
    }
    let message = format!("`{function}` takes vectors of one size or numbers, not both");
    // Of a `let` naga shows what it is made of, which stands further up: its name isn't known.
    let call = labels.first().map_or(0, |(span, _)| span.start);
    let is_name = |text: &&str| text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
    let written = |span: &Range<usize>| {
        let text = short(text, span.clone());
        text.filter(|text| span.start >= call || is_name(text))
            .unwrap_or("...")
    };
    let mut number = written(number).to_owned();
    // Numbers without a type become what the vector holds, but no fraction becomes an integer.
    let becomes = match scalar {
        "{AbstractInt}" => true,
        "{AbstractFloat}" => component == "f",
        _ => scalar.starts_with(&component),
    };
    // Of a vector without a sign there is none that holds it.
    if component == "u" && scalar.starts_with('{') && is_negative(&number) {
        let vector = written(whole);
        let signed = match becomes {
            true => number,
            false => format!("i32({number})"),
        };
        let remedy = format!(
            "`u32` has no numbers below 0: write `vec{count}i({vector})` for the vector and `vec{count}i({signed})` for the number"
        );
        return Some((message, remedy));
    }
    if !becomes {
        number = format!("{component}32({number})");
    }
    let remedy = format!("write `vec{count}{component}({number})` for the number");
    Some((message, remedy))
}

/// Whether a number as it is written is less than 0; of what is to be worked out, whether it may be.
fn is_negative(number: &str) -> bool {
    let value = number.parse::<f64>();
    value.map_or_else(|_| number.contains('-'), |value| value < 0.0)
}

/// The type that a label tells of an argument.
pub(super) fn type_in(label: &str) -> Option<&str> {
    label.split_once(" has type ")?.1.split(',').next()
}

/// naga's message as an author of a texture understands it, and what to do. None where others have words for it.
pub(super) fn in_plain_words(message: &str) -> Option<(String, Option<String>)> {
    let said = |text: &str| Some((text.to_owned(), None));
    if let Some(name) = lacking(message) {
        let remedy = match name.get(..1) {
            Some("f") => "use `f32`",
            Some("u") => "use `u32`",
            _ => "use `i32`",
        };
        let text = format!("`{name}` is not available in textures: not every GPU has it");
        return Some((text, Some(remedy.to_owned())));
    }
    if message.starts_with("Shader requires capability")
        || (message.starts_with("Capability ") && message.ends_with(" is required"))
    {
        return said("this is not available in textures: not every GPU has it");
    }
    if message.starts_with("Invalid access into") || message.starts_with("Invalid sub-access into")
    {
        return said("what is indexed here has no components");
    }
    if let Some(rest) = message.strip_prefix("Index ")
        && let Some((index, _)) = rest.split_once(" is out of bounds")
    {
        return said(&format!(
            "index {index} is beyond the end of what is indexed here"
        ));
    }
    if message.starts_with("Float literal is ") {
        let remedy = "a constant has to be finite".to_owned();
        return Some(("this is not a finite number".to_owned(), Some(remedy)));
    }
    if is_of_mixture(message) {
        let text = "a number meets something here that it doesn't go with";
        let remedy = "convert one of them, as by `f32(...)`: `2.0` goes with `f32` only, `2` with all numbers";
        return Some((text.to_owned(), Some(remedy.to_owned())));
    }
    if message.starts_with("inconsistent type passed as argument #") {
        let remedy = "convert the others to its type, as by `f32(...)` or `vec3f(...)`: `2.0` goes with `f32` only, `2` with all numbers";
        return Some((message.to_owned(), Some(remedy.to_owned())));
    }
    let operator = refused_operator(message)?;
    let plain = plain_message(message);
    let operands = plain.split_once(": ").map_or("", |(_, operands)| operands);
    if let Some((left, right)) = operands.split_once(" * ") {
        let text = format!("`*` can't take {} and {}", quoted(left), quoted(right));
        return Some((text, None));
    }
    let operand = operands.split_once('(').map_or("", |(_, operand)| operand);
    let operand = quoted(operand.trim_end_matches(", _)"));
    Some(match operator {
        "&&" | "||" => (
            format!("`{operator}` can't take {operand}"),
            Some(format!(
                "`{operator}` combines conditions, which are `bool`"
            )),
        ),
        _ => (
            format!("`{operator}` can't compare {operand}"),
            Some("compare numbers, or vectors component by component".to_owned()),
        ),
    })
}

/// The type that a message says is lacking.
fn lacking(message: &str) -> Option<&str> {
    let (name, rest) = message.strip_prefix("Using `")?.split_once("` values")?;
    rest.contains("Capabilities").then_some(name)
}

/// The operator that can't take the operands that it has.
pub(crate) fn refused_operator(message: &str) -> Option<&'static str> {
    let operands = message.strip_prefix("Incompatible operands: ")?;
    let name = operands.split_once('(').map_or(operands, |(name, _)| name);
    Some(match name {
        "Equal" => "==",
        "NotEqual" => "!=",
        "Less" => "<",
        "LessEqual" => "<=",
        "Greater" => ">",
        "GreaterEqual" => ">=",
        "LogicalAnd" => "&&",
        "LogicalOr" => "||",
        _ if operands.contains(" * ") => "*",
        _ => return None,
    })
}

/// A type between backticks, or what stands for one.
fn quoted(ty: &str) -> String {
    let is_described = ["a ", "an ", "something"]
        .iter()
        .any(|start| ty.starts_with(start));
    match (ty, is_described) {
        ("", _) => "this".to_owned(),
        (_, true) => ty.to_owned(),
        (_, false) => format!("`{ty}`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_vector_that_a_number_is_to_be_can_be_made_of_it() {
        let text = "max(a, 1.5)";
        let message = "inconsistent type passed as argument #2 to `max`";
        for (vector, scalar, remedy) in [
            ("vec3<i32>", "{AbstractFloat}", "vec3i(i32(1.5))"),
            ("vec2<u32>", "{AbstractFloat}", "vec2u(u32(1.5))"),
            ("vec3<f32>", "{AbstractFloat}", "vec3f(1.5)"),
            ("vec3<i32>", "{AbstractInt}", "vec3i(1.5)"),
            ("vec3<{AbstractInt}>", "{AbstractFloat}", "vec3f(1.5)"),
            ("vec3<u32>", "i32", "vec3u(u32(1.5))"),
            ("vec3<f32>", "f32", "vec3f(1.5)"),
        ] {
            let first = format!("this argument has type {vector}, which constrains others");
            let second = format!("argument #2 has type {scalar}");
            let labels = [(0..11, String::new()), (7..10, second), (4..5, first)];
            let told = of_vector_and_number(message, &labels, text);
            let told = told.map(|(_, remedy)| remedy);
            let wanted = format!("write `{remedy}` for the number");
            assert_eq!(told, Some(wanted), "{vector} {scalar}");
        }
    }

    #[test]
    fn what_may_be_below_zero_is_found_in_the_text() {
        for (number, is) in [("-1", true), ("1-3", true), ("2", false), ("1e-3", false)] {
            assert_eq!(is_negative(number), is, "{number}");
        }
    }

    #[test]
    fn types_are_spoken_of_without_nagas_structures() {
        for (message, plain) in [
            (
                "Using `i64` values requires the `naga::valid::Capabilities::SHADER_INT64` flag",
                "`i64` is not available in textures: not every GPU has it",
            ),
            (
                "Invalid access into expression [7], indexed: true",
                "what is indexed here has no components",
            ),
            (
                "Index 3 is out of bounds for expression [3]",
                "index 3 is beyond the end of what is indexed here",
            ),
            ("Float literal is infinite", "this is not a finite number"),
            (
                "Abstract types may only appear in constant expressions",
                "a number meets something here that it doesn't go with",
            ),
            (
                "Incompatible operands: LogicalAnd(f32, _)",
                "`&&` can't take `f32`",
            ),
            (
                "Incompatible operands: Equal(Array { base: [3], size: Constant(4), stride: 4 }, _)",
                "`==` can't compare an array",
            ),
            (
                "Incompatible operands: NotEqual(Matrix { columns: Bi, rows: Bi, scalar: Scalar { kind: Float, width: 4 } }, _)",
                "`!=` can't compare `mat2x2<f32>`",
            ),
            (
                "Incompatible operands: Struct { members: [StructMember { name: Some(\"a\"), ty: [1], binding: None, offset: 0 }], span: 4 } * Scalar(Scalar { kind: Float, width: 4 })",
                "`*` can't take a structure and `f32`",
            ),
        ] {
            let said = in_plain_words(message).map(|(text, _)| text);
            assert_eq!(said.as_deref(), Some(plain));
        }
        assert_eq!(in_plain_words("expected `;`, found \"}\""), None);
    }
}
