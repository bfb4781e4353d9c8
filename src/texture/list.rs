//! `patina texture list`: all textures with where they come from, what they give and what they take.

use std::fmt::Write;
use std::path::PathBuf;

use serde::Serialize;
use texgen::{Parameter, TextureType, Widget};

use crate::console;
use crate::failure::Failure;

use super::written;

/// Prints the table; as JSON, one object per texture. Textures with errors are warned of and left out.
///
/// # Errors
/// A folder can't be read.
pub(crate) fn run(texture_dirs: &[PathBuf]) -> Result<(), Failure> {
    let sources = super::sources(texture_dirs, None)?;
    let mut table = String::new();
    for name in sources.names() {
        let parsed = super::read(&sources, name).map_err(Into::into);
        match parsed.and_then(TextureType::parse) {
            Ok(texture) if console::is_json() => {
                let entry = Entry {
                    built_in: sources.is_built_in(name),
                    ..Entry::from(&texture)
                };
                table += &(serde_json::to_string(&entry).map_err(Failure::because)? + "\n");
            }
            Ok(texture) => {
                let origin = match sources.is_built_in(name) {
                    true => "built in",
                    false => texture.file().path(),
                };
                add(&mut table, &texture, origin);
            }
            Err(_) => console::warning(&format!(
                "texture `{name}` has errors: `patina texture check {name}` shows them"
            )),
        }
    }
    console::print(&table);
    Ok(())
}

/// The first sentence of a texture's documentation, without its full stop.
fn first_sentence(docs: &str) -> String {
    let line = docs.replace('\n', " ");
    let sentence = line.split(". ").next().unwrap_or_default();
    sentence.trim_end_matches('.').to_owned()
}

fn add(table: &mut String, texture: &TextureType, origin: &str) {
    let (name, output) = (texture.name(), texture.output());
    let outputs = (texture.outputs().iter())
        .map(|output| format!("{} {}", output.name, output.ty))
        .collect::<Vec<_>>();
    let output = match outputs.is_empty() {
        true => output.to_string(),
        false => outputs.join(", "),
    };
    let _ = writeln!(table, "{name} -> {output}  ({origin})");
    let sentence = first_sentence(texture.docs());
    if !sentence.is_empty() {
        let _ = writeln!(table, "    {sentence}");
    }
    let rows: Vec<[String; 4]> = texture.parameters().iter().map(row).collect();
    let width = |column: usize| rows.iter().map(|r| r[column].chars().count()).max();
    let widths: Vec<usize> = (0..3).map(|c| width(c).unwrap_or(0).min(28)).collect();
    for [name, ty, default, about] in &rows {
        let line = format!(
            "      {name:0$}  {ty:1$}  {default:2$}  {about}",
            widths[0], widths[1], widths[2]
        );
        let _ = writeln!(table, "{}", line.trim_end());
    }
    table.push('\n');
}

/// Name, type, default, and what else is known.
fn row(parameter: &Parameter) -> [String; 4] {
    let mut about = parameter.label.clone();
    if let Some(unit) = &parameter.unit {
        let _ = write!(about, ", {unit}");
    }
    if let Some((low, high)) = parameter.range {
        let (low, high) = (written::number(low), written::number(high));
        let _ = write!(about, " [{low} .. {high}]");
    }
    [
        parameter.name.clone(),
        parameter.ty.to_string(),
        default(parameter).unwrap_or_else(|| "(required)".to_owned()),
        about,
    ]
}

pub(super) fn default(parameter: &Parameter) -> Option<String> {
    if let Some(attribute) = &parameter.attribute {
        return Some(format!("attribute {attribute}"));
    }
    let default = parameter.default.as_ref()?;
    Some(written::value(default, parameter.widget))
}

/// A texture as JSON.
#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    /// The file; of a standard texture the name that messages give it.
    file: &'a str,
    built_in: bool,
    returns: String,
    /// What links take by name; absent where it gives one value.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    outputs: Vec<OutputEntry<'a>>,
    doc: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    group: Option<&'a str>,
    parameters: Vec<ParameterEntry<'a>>,
}

#[derive(Serialize)]
struct OutputEntry<'a> {
    name: &'a str,
    r#type: String,
    label: &'a str,
}

#[derive(Serialize)]
struct ParameterEntry<'a> {
    name: &'a str,
    r#type: String,
    label: &'a str,
    /// As a look file writes it; absent where the parameter must be set.
    #[serde(skip_serializing_if = "Option::is_none")]
    default: Option<String>,
    range: Option<(f32, f32)>,
    soft_range: Option<(f32, f32)>,
    unit: Option<&'a str>,
    /// What it takes at the hit where nothing is linked or set.
    #[serde(skip_serializing_if = "Option::is_none")]
    attribute: Option<&'a str>,
    widget: &'static str,
}

impl<'a> From<&'a TextureType> for Entry<'a> {
    fn from(texture: &'a TextureType) -> Self {
        let parameter = |parameter: &'a Parameter| ParameterEntry {
            name: &parameter.name,
            r#type: parameter.ty.to_string(),
            label: &parameter.label,
            default: (parameter.attribute.is_none())
                .then(|| default(parameter))
                .flatten(),
            attribute: parameter.attribute.as_ref().map(texgen::Attribute::name),
            range: parameter.range,
            soft_range: parameter.soft_range,
            unit: parameter.unit.as_deref(),
            widget: match parameter.widget {
                Widget::Plain => "plain",
                Widget::Color => "color",
                Widget::Angle => "angle",
                Widget::Log => "log",
                Widget::Percent => "percent",
                Widget::Seed => "seed",
            },
        };
        Self {
            name: texture.name(),
            file: texture.file().path(),
            built_in: false,
            returns: texture.output().to_string(),
            outputs: (texture.outputs().iter())
                .map(|output| OutputEntry {
                    name: &output.name,
                    r#type: output.ty.to_string(),
                    label: &output.label,
                })
                .collect(),
            doc: texture.docs(),
            group: texture.group(),
            parameters: texture.parameters().iter().map(parameter).collect(),
        }
    }
}
