//! The `///` text above `userProc`: a texture's documentation, and its `@param` lines.
//!
//! A line reads `@param NAME label [RANGE or KEYS] = DEFAULT`, everything behind the name optional:
//! `[0 .. 10]` is the range, `[soft 0 .. 1]` the usual range, `[unit m]` a unit, and `color`, `angle`, `log`,
//! `percent`, `seed` a widget, `data` an image of numbers, `[attr LocalPos]` the attribute that is taken unlinked; several stand in brackets of their own or behind commas. `linear`, `smooth` and
//! `constant` are the interpolation of a ramp's default.
//!
//! `@output NAME label` says what a member of the struct is that `userProc` returns.

use std::ops::Range;

use crate::attribute::{Attribute, BUILTIN_ATTRIBUTES, BuiltinAttribute};
use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::interface::{NamedOutput, Parameter, Widget};
use crate::libraries::Whole;
use crate::literal::{self, Literal};
use crate::scope::Outline;
use crate::signature;
use crate::suggest::did_you_mean;
use crate::tokens::{TokenKind, tokenize};
use crate::value::{Interpolation, ParameterType, Ramp, Value};

/// One line of documentation, without its comment marker.
struct DocLine<'a> {
    text: &'a str,
    start: usize,
}

/// What documentation may be about.
pub(crate) struct Described<'a> {
    pub(crate) parameters: &'a mut [Parameter],
    pub(crate) outputs: &'a mut [NamedOutput],
}

/// Fills what is `described` from the `@param` and `@output` lines above `userProc` and returns the rest of the text. Problems of
/// defaults are errors, of anything else warnings.
pub(crate) fn read_docs(
    whole: &Whole,
    outline: &Outline<'_>,
    described: Described<'_>,
    problems: &mut Diagnostics,
) -> String {
    let Described {
        parameters,
        outputs,
    } = described;
    let file = &whole.file;
    let mut docs = String::new();
    let mut described: Vec<String> = Vec::new();
    for line in doc_lines(outline) {
        let trimmed = line.text.trim_start();
        let is_read = ["@use ", "@group "]
            .iter()
            .any(|key| trimmed.starts_with(key));
        if is_read || line.start >= whole.own_len() {
            continue; // said elsewhere, or about a shared file
        }
        if let Some(rest) = trimmed.strip_prefix("@output ") {
            let start = line.start + line.text.len() - rest.len();
            describe_output(file, rest, start, outputs, problems);
            continue;
        }
        let Some(rest) = trimmed.strip_prefix("@param") else {
            docs.push_str(line.text.strip_prefix(' ').unwrap_or(line.text).trim_end());
            docs.push('\n');
            continue;
        };
        let start = line.start + line.text.len() - rest.len();
        let more = rest.len() - rest.trim_start_matches(is_in_word).len();
        if more > 0 {
            let span = start - "@param".len()..start + more;
            let word = &trimmed[.."@param".len() + more];
            problems.push(
                Diagnostic::warning(format!("there are no `{word}` lines"))
                    .with_label(file, span, "did you mean `@param`?")
                    .with_note("write `@param NAME label [min .. max] = default`"),
            );
            continue;
        }
        let mut reader = ParamLine {
            file,
            text: rest,
            start,
            at: 0,
        };
        let Some((name, span)) = reader.name() else {
            problems.push(
                Diagnostic::warning("`@param` without a name")
                    .with_label(
                        file,
                        line.start..line.start + line.text.trim_end().len(),
                        "",
                    )
                    .with_note("write `@param NAME label [min .. max] = default`"),
            );
            continue;
        };
        if described.contains(&name.to_owned()) {
            problems.push(
                Diagnostic::warning(format!("`{name}` is described twice"))
                    .with_label(file, span, ""),
            );
            continue;
        }
        described.push(name.to_owned());
        let known: Vec<String> = parameters
            .iter()
            .map(|parameter| parameter.name.clone())
            .collect();
        match parameters
            .iter_mut()
            .find(|parameter| parameter.name == name)
        {
            Some(parameter) => reader.describe(parameter, problems),
            None => {
                let mut warning =
                    Diagnostic::warning(format!("`userProc` has no parameter `{name}`"))
                        .with_label(file, span, "");
                if let Some(near) = did_you_mean(name, known.iter().map(String::as_str)) {
                    warning = warning.with_note(format!("did you mean `{near}`?"));
                }
                problems.push(warning);
            }
        }
    }
    misplaced(file, outline, parameters, &described, problems);
    misplaced_output(whole, outline, outputs, problems);
    two_slashes(file, outline, parameters, &described, problems);
    signature::warn_of_keys(file, outline, problems);
    docs.trim().to_owned()
}

fn is_in_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Reads what follows `@output`: a name and what it is.
fn describe_output(
    file: &SourceFile,
    text: &str,
    start: usize,
    outputs: &mut [NamedOutput],
    problems: &mut Diagnostics,
) {
    let text = text.trim_end();
    let indent = text.len() - text.trim_start().len();
    let (name, label) = text
        .trim_start()
        .split_once(char::is_whitespace)
        .unwrap_or((text.trim_start(), ""));
    let span = start + indent..start + indent + name.len();
    if let Some(output) = outputs.iter_mut().find(|output| output.name == name) {
        label.trim().clone_into(&mut output.label);
        return;
    }
    let warning = Diagnostic::warning(format!("`userProc` has no output `{name}`"));
    let names = || outputs.iter().map(|output| output.name.as_str());
    let note = match (did_you_mean(name, names()), outputs.is_empty()) {
        (Some(near), _) => format!("did you mean `{near}`?"),
        (None, true) => "outputs are the members of a struct that it returns".to_owned(),
        (None, false) => format!("it has: {}", names().collect::<Vec<_>>().join(", ")),
    };
    problems.push(warning.with_label(file, span, "").with_note(note));
}

/// What stands behind the first `@group`.
pub(crate) fn group(outline: &Outline<'_>) -> Option<String> {
    let mut lines = doc_lines(outline).into_iter();
    let group = lines.find_map(|line| line.text.trim_start().strip_prefix("@group "))?;
    Some(group.trim().to_owned()).filter(|group| !group.is_empty())
}

/// Warns of a description that stands above something else than `userProc`, where it would silently do nothing.
fn misplaced(
    file: &SourceFile,
    outline: &Outline<'_>,
    parameters: &[Parameter],
    described: &[String],
    problems: &mut Diagnostics,
) {
    let misplaced = outline.tokens.comments.iter().find(|comment| {
        let Some((_, rest)) = comment.text.split_once("@param ") else {
            return false;
        };
        let name = rest.split_whitespace().next().unwrap_or_default();
        let is_doc = comment.text.starts_with("///") || comment.text.starts_with("/**");
        let is_parameter = parameters.iter().any(|parameter| parameter.name == name);
        is_doc && is_parameter && !described.iter().any(|known| known == name)
    });
    if let Some(comment) = misplaced {
        let text = comment.text.lines().next().unwrap_or_default();
        problems.push(
            Diagnostic::warning("this describes a parameter of `userProc`, but stands elsewhere")
                .with_label(
                    file,
                    comment.start..comment.start + text.len(),
                    "is ignored",
                )
                .with_note("move the description down, right above `fn userProc`"),
        );
    }
}

/// Warns of a description of an output that stands above something else, such as the struct.
fn misplaced_output(
    whole: &Whole,
    outline: &Outline<'_>,
    outputs: &[NamedOutput],
    problems: &mut Diagnostics,
) {
    let read: Vec<usize> = doc_lines(outline).iter().map(|line| line.start).collect();
    let own = outline.tokens.comments.iter();
    for comment in own.take_while(|comment| comment.start < whole.own_len()) {
        let Some(rest) = comment.text.strip_prefix("///") else {
            continue;
        };
        let name = rest.trim_start().strip_prefix("@output ");
        let name = name.and_then(|rest| rest.split_whitespace().next());
        let is_output = name.is_some_and(|name| outputs.iter().any(|output| output.name == name));
        if is_output && !read.contains(&(comment.start + 3)) {
            let span = comment.start..comment.start + comment.text.trim_end().len();
            problems.push(
                Diagnostic::warning("this describes an output of `userProc`, but stands elsewhere")
                    .with_label(&whole.file, span, "is ignored")
                    .with_note("move it right above `fn userProc`"),
            );
        }
    }
}

/// What stands behind the key in a comment of two slashes, and where the comment lies.
fn behind_two_slashes<'a>(
    outline: &Outline<'a>,
    key: &'static str,
) -> impl Iterator<Item = (&'a str, Range<usize>)> {
    let comments = outline.tokens.comments.clone().into_iter();
    comments.filter_map(move |comment| {
        let text = comment.text.strip_prefix("//")?.trim_start();
        let rest = text.strip_prefix(key)?;
        Some((
            rest,
            comment.start..comment.start + comment.text.trim_end().len(),
        ))
    })
}

fn of_two_slashes(file: &SourceFile, span: Range<usize>, key: &str) -> Diagnostic {
    let key = key.trim();
    Diagnostic::warning(format!("this `{key}` is not read: it has two slashes"))
        .with_label(file, span, "")
        .with_note(format!("write `/// {key} ...`"))
}

/// Warns of a parameter that is described in a comment of two slashes only.
fn two_slashes(
    file: &SourceFile,
    outline: &Outline<'_>,
    parameters: &[Parameter],
    described: &[String],
    problems: &mut Diagnostics,
) {
    for (rest, span) in behind_two_slashes(outline, "@param ") {
        let name = rest.split_whitespace().next().unwrap_or_default();
        let is_parameter = parameters.iter().any(|parameter| parameter.name == name);
        if is_parameter && !described.iter().any(|known| known == name) {
            problems.push(of_two_slashes(file, span, "@param "));
        }
    }
}

/// Warnings of shared files that are named in comments of two slashes: what they declare isn't there.
pub(crate) fn used_by_two_slashes(file: &SourceFile, outline: &Outline<'_>) -> Diagnostics {
    let found = behind_two_slashes(outline, "@use ");
    found
        .map(|(_, span)| of_two_slashes(file, span, "@use "))
        .collect()
}

/// Documentation lines: `//!` anywhere, and the `///` and `/** */` comments right above `userProc`.
fn doc_lines<'a>(outline: &Outline<'a>) -> Vec<DocLine<'a>> {
    let first = outline
        .functions
        .iter()
        .find(|function| outline.word(function.name) == "userProc")
        .and_then(|function| {
            outline
                .globals
                .iter()
                .find(|global| global.name == Some(function.name))
        })
        .map(|global| global.tokens.start);
    let mut lines = Vec::new();
    for comment in &outline.tokens.comments {
        let text = comment.text;
        let above_entry = Some(comment.next_token) == first;
        if text.starts_with("//!")
            || (above_entry && text.starts_with("///") && !text.starts_with("////"))
        {
            lines.push(DocLine {
                text: &text[3..],
                start: comment.start + 3,
            });
        } else if above_entry && text.starts_with("/**") && text.len() > 4 {
            let inner = text[3..].strip_suffix("*/").unwrap_or(&text[3..]);
            let mut start = comment.start + 3;
            for line in inner.split('\n') {
                let stripped = line.trim_start().strip_prefix('*').unwrap_or(line);
                lines.push(DocLine {
                    text: stripped,
                    start: start + line.len() - stripped.len(),
                });
                start += line.len() + 1;
            }
        }
    }
    lines
}

/// What follows `@param`.
struct ParamLine<'a> {
    file: &'a SourceFile,
    text: &'a str,
    /// Byte offset of `text` in the file.
    start: usize,
    at: usize,
}

impl<'a> ParamLine<'a> {
    fn span(&self, range: Range<usize>) -> Range<usize> {
        self.start + range.start..self.start + range.end
    }

    fn skip_space(&mut self) {
        self.at += self.text[self.at..].len() - self.text[self.at..].trim_start().len();
    }

    fn name(&mut self) -> Option<(&'a str, Range<usize>)> {
        self.skip_space();
        let rest = &self.text[self.at..];
        let length = rest
            .find(|c: char| c.is_whitespace() || c == '[' || c == '=')
            .unwrap_or(rest.len());
        let span = self.span(self.at..self.at + length);
        self.at += length;
        (length > 0).then(|| (&rest[..length], span))
    }

    fn describe(&mut self, parameter: &mut Parameter, problems: &mut Diagnostics) {
        let rest = &self.text[self.at..];
        let length = rest.find(['[', '=']).unwrap_or(rest.len());
        let label = rest[..length].trim();
        if !label.is_empty() {
            parameter.label = label.to_owned();
        }
        self.at += length;
        let mut interpolation = Interpolation::Linear;
        while self.text[self.at..].starts_with('[') {
            let open = self.at + 1;
            let length = self.text[open..].find(']');
            let close = length.map_or(self.text.trim_end().len().max(open), |length| open + length);
            if length.is_none() {
                problems.push(Diagnostic::warning("`[` without `]`").with_label(
                    self.file,
                    self.span(open - 1..close),
                    "",
                ));
            }
            let mut start = open;
            for key in self.text[open..close].split(',') {
                self.key(key, start, parameter, &mut interpolation, problems);
                start += key.len() + 1;
            }
            // Blanks behind an unclosed one may be longer than a byte.
            self.at = length.map_or(self.text.len(), |_| close + 1);
            self.skip_space();
        }
        if let Some(rest) = self.text[self.at..].strip_prefix('=') {
            let start = self.at + 1;
            self.default(rest, start, parameter, interpolation, problems);
            if let Some(attribute) = &parameter.attribute {
                let name = &parameter.name;
                problems.push(
                    Diagnostic::warning(format!("the default of `{name}` is never used"))
                        .with_label(self.file, self.span(self.at..self.text.trim_end().len()), "")
                        .with_note(format!(
                            "it takes `{attribute}` where nothing is linked to it and no constant is set: leave the default or the attribute out"
                        )),
                );
            }
        } else if !self.text[self.at..].trim().is_empty() {
            problems.push(
                Diagnostic::warning("text behind the brackets is not read")
                    .with_label(
                        self.file,
                        self.span(self.at..self.text.trim_end().len()),
                        "",
                    )
                    .with_note("the label comes first: `@param NAME label [min .. max] = default`"),
            );
        }
    }

    fn key(
        &self,
        key: &str,
        start: usize,
        parameter: &mut Parameter,
        interpolation: &mut Interpolation,
        problems: &mut Diagnostics,
    ) {
        let trimmed = key.trim();
        let start = start + key.len() - key.trim_start().len();
        let span = self.span(start..start + trimmed.len());
        if let Some(soft) = trimmed.strip_prefix("soft ") {
            match range(soft) {
                Some(range) => parameter.soft_range = Some(range),
                None => problems.push(bad_range(self.file, span)),
            }
            return;
        }
        if let Some(unit) = trimmed.strip_prefix("unit ") {
            parameter.unit = Some(unit.trim().to_owned());
            return;
        }
        if let Some(name) = trimmed.strip_prefix("attr ") {
            match self.attribute(name.trim(), parameter, span) {
                Ok(attribute) => parameter.attribute = Some(attribute),
                Err(problem) => problems.push(problem),
            }
            return;
        }
        if trimmed.contains("..") {
            match range(trimmed) {
                Some(range) => parameter.range = Some(range),
                None => problems.push(bad_range(self.file, span)),
            }
            return;
        }
        match trimmed {
            "" => {}
            "color" => parameter.widget = Widget::Color,
            "angle" => parameter.widget = Widget::Angle,
            "log" => parameter.widget = Widget::Log,
            "percent" => parameter.widget = Widget::Percent,
            "seed" => parameter.widget = Widget::Seed,
            "data" => parameter.is_data = true,
            "linear" => *interpolation = Interpolation::Linear,
            "smooth" => *interpolation = Interpolation::Smooth,
            "constant" => *interpolation = Interpolation::Constant,
            unknown => {
                const KEYS: &str =
                    "color angle log percent seed data soft unit attr linear smooth constant";
                let near = did_you_mean(unknown, KEYS.split(' '));
                problems.push(
                    Diagnostic::warning(format!("unknown key `{unknown}`"))
                        .with_label(self.file, span, near.map_or(String::new(), |near| format!("did you mean `{near}`?")))
                        .with_note("known are `min .. max`, `soft min .. max`, `unit NAME`, `attr NAME`, `color`, `angle`, `log`, `percent`, `seed`, for images `data`, and for ramps `linear`, `smooth`, `constant`"),
                );
            }
        }
    }

    /// The attribute that a parameter takes where nothing is linked to it.
    fn attribute(
        &self,
        name: &str,
        parameter: &Parameter,
        span: Range<usize>,
    ) -> Result<Attribute, Diagnostic> {
        let ty = parameter.ty;
        if !ty.is_linkable() {
            let message = format!("a parameter of type {ty} can't take an attribute");
            return Err(Diagnostic::error(message)
                .with_label(self.file, span, "")
                .with_note("numbers, vectors and `bool` can"));
        }
        // It becomes part of a name in the kernel.
        let tokens = tokenize(name).tokens;
        let is_word =
            matches!(&tokens[..], [one] if one.kind == TokenKind::Word && one.text == name);
        if is_word && name.len() > 1 && name.starts_with('_') {
            return Ok(Attribute::Custom(name.to_owned()));
        }
        BuiltinAttribute::from_name(name)
            .map(Attribute::Builtin)
            .ok_or_else(|| {
                let names = BUILTIN_ATTRIBUTES.iter().map(|one| one.name());
                let near = did_you_mean(name, names);
                let near = near.map_or(String::new(), |near| format!("did you mean `{near}`?"));
                Diagnostic::error(format!("there is no attribute called `{name}`"))
                    .with_label(self.file, span, near)
                    .with_note("write for example `[attr LocalPos]`; those of the mesh begin with an underscore")
            })
    }

    fn default(
        &self,
        text: &str,
        start: usize,
        parameter: &mut Parameter,
        interpolation: Interpolation,
        problems: &mut Diagnostics,
    ) {
        let trimmed = text.trim();
        let start = start + text.len() - text.trim_start().len();
        let span = self.span(start..start + trimmed.len());
        let value = literal::parse(trimmed)
            .and_then(|literal| to_value(&literal, parameter.ty, interpolation));
        match value {
            Ok(value) => parameter.default = Some(value),
            Err(problem) => {
                let note = match parameter.ty {
                    ParameterType::Image => {
                        "images have no defaults: leave it out, and set the image in the look file"
                            .to_owned()
                    }
                    ty => format!("a default of type {ty} looks like `= {}`", example(ty)),
                };
                problems.push(
                    Diagnostic::error(format!("the default of `{}` {problem}", parameter.name))
                        .with_label(self.file, span, "")
                        .with_note(note),
                );
            }
        }
    }
}

fn bad_range(file: &SourceFile, span: Range<usize>) -> Diagnostic {
    Diagnostic::warning("not a range")
        .with_label(file, span, "")
        .with_note("write `[min .. max]` with two finite numbers, the smaller one first")
}

fn range(text: &str) -> Option<(f32, f32)> {
    let (low, high) = text.split_once("..")?;
    let (low, high) = (
        low.trim().parse::<f32>().ok()?,
        high.trim().parse::<f32>().ok()?,
    );
    (low.is_finite() && high.is_finite() && low <= high).then_some((low, high))
}

fn example(ty: ParameterType) -> String {
    match ty {
        ParameterType::F32 => "0.5".into(),
        ParameterType::I32 => "-1".into(),
        ParameterType::U32 => "4".into(),
        ParameterType::Bool => "true".into(),
        ParameterType::Vec2 => "(0, 1)".into(),
        ParameterType::Vec3 => "(1, 0.5, 0)` or `= #ff8000".into(),
        ParameterType::Vec4 => "(1, 0.5, 0, 1)` or `= #ff8000".into(),
        ParameterType::Mat3 => "((1, 0, 0), (0, 1, 0), (0, 0, 1))".into(),
        ParameterType::Mat4 => "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))".into(),
        ParameterType::Image => "...".into(),
        ParameterType::Ramp => "[(0, #000000), (1, #ffffff)]".into(),
        ParameterType::Array(element, count) => {
            format!(
                "[{}{}]",
                example(element.parameter_type()),
                if count > 1 { ", ..." } else { "" }
            )
        }
    }
}

/// The value that a literal means for a parameter of type `ty`.
pub(crate) fn to_value(
    literal: &Literal,
    ty: ParameterType,
    interpolation: Interpolation,
) -> Result<Value, String> {
    let wrong = || format!("is not of type {ty}");
    Ok(match ty {
        ParameterType::F32 => Value::F32(literal.number().ok_or_else(wrong)?),
        ParameterType::I32 => Value::I32(
            literal
                .integer()
                .and_then(|i| i.try_into().ok())
                .ok_or_else(wrong)?,
        ),
        ParameterType::U32 => Value::U32(
            literal
                .integer()
                .and_then(|i| i.try_into().ok())
                .ok_or_else(wrong)?,
        ),
        ParameterType::Bool => match literal {
            Literal::Bool(value) => Value::Bool(*value),
            _ => return Err(wrong()),
        },
        ParameterType::Vec2 => Value::Vec2(literal.vector().ok_or_else(wrong)?),
        ParameterType::Vec3 => Value::Vec3(literal.vector().ok_or_else(wrong)?),
        ParameterType::Vec4 => Value::Vec4(literal.vector().ok_or_else(wrong)?),
        ParameterType::Mat3 => Value::Mat3(literal.columns().ok_or_else(wrong)?),
        ParameterType::Mat4 => Value::Mat4(literal.columns().ok_or_else(wrong)?),
        ParameterType::Image => return Err("can't be given: images have none".into()),
        ParameterType::Ramp => {
            let Literal::List(stops) = literal else {
                return Err(wrong());
            };
            let stops: Option<Vec<(f32, [f32; 4])>> = stops
                .iter()
                .map(|stop| match stop {
                    Literal::List(pair) if pair.len() == 2 => {
                        Some((pair[0].number()?, pair[1].vector()?))
                    }
                    _ => None,
                })
                .collect();
            let stops = stops.filter(|stops| !stops.is_empty()).ok_or_else(wrong)?;
            Value::Ramp(Ramp {
                stops,
                interpolation,
            })
        }
        ParameterType::Array(element, count) => {
            let Literal::List(items) = literal else {
                return Err(wrong());
            };
            if items.len() != count as usize {
                return Err(format!("has {} elements instead of {count}", items.len()));
            }
            let items = items
                .iter()
                .map(|item| to_value(item, element.parameter_type(), interpolation));
            Value::Array(items.collect::<Result<_, _>>()?)
        }
    })
}
