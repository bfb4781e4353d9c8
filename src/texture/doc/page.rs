//! The page as text.

use std::fmt::Write;

use texgen::{OutputType, Parameter, ParameterType, TextureType};

use super::super::list::default;
use super::super::written;
use super::Group;

const HEAD: &str = "\
# The textures that ship with Patina

This page is made by `patina texture doc`. All of these textures are part of the program; those that a scene doesn't use cost it nothing. In
a [look](look-file.md) a node names one as its `texture` and sets what it likes; a file of the same name in a folder of [textures of
your own](texture-language.md) takes its place. Swatches show a square metre, or a ball of that size;
of textures that change a colour, what goes in on the left and what comes of it on the right.

`position` and `texcoord` are taken from the surface where nothing is linked to them: link a node of `mapping`, `place2d`, `warp` or
`coordinates` to change them. Results of several components are taken apart in links: `\"cells.x\"`.
";

/// The whole page.
pub(super) fn page(groups: &[Group]) -> String {
    let mut text = HEAD.to_owned();
    text.push_str("\n| group | textures |\n|---|---|\n");
    for group in groups {
        let names: Vec<String> = (group.textures.iter())
            .map(|texture| format!("[{0}](#{0})", texture.name()))
            .collect();
        let _ = writeln!(
            text,
            "| [{}](#{}) | {} |",
            group.title,
            anchor(&group.title),
            names.join(", ")
        );
    }
    for group in groups {
        let _ = writeln!(text, "\n## {}", group.title);
        let names: Vec<&str> = group.textures.iter().map(TextureType::name).collect();
        let _ = writeln!(
            text,
            "\n![Swatches]({})\n\nFrom the upper left, by rows: {}.",
            sheet(&group.name),
            names.join(", ")
        );
        for texture in &group.textures {
            entry(&mut text, texture, &group.name);
        }
    }
    text
}

/// Where the page looks for a group's sheet.
fn sheet(group: &str) -> String {
    format!("images/{}", file_name(group))
}

/// What a group's sheet is called.
pub(super) fn file_name(group: &str) -> String {
    format!("textures-{}.jpg", anchor(group))
}

/// As headings are named in links.
fn anchor(title: &str) -> String {
    let kept = title.to_lowercase();
    let kept = kept
        .chars()
        .filter(|c| c.is_alphanumeric() || *c == ' ' || *c == '-');
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn entry(text: &mut String, texture: &TextureType, group: &str) {
    let _ = writeln!(text, "\n### {}", texture.name());
    let gives = match texture.outputs() {
        [] => format!("Gives `{}`.", texture.output()),
        outputs => format!("Gives {} values by name.", outputs.len()),
    };
    let _ = writeln!(text, "\n{} {gives}", texture.docs());
    if !texture.outputs().is_empty() {
        text.push_str("\n| output | type | |\n|---|---|---|\n");
        for output in texture.outputs() {
            let label = output.label.replace('|', "\\|");
            let _ = writeln!(text, "| `{}` | {} | {label} |", output.name, output.ty);
        }
    }
    if !texture.parameters().is_empty() {
        text.push_str("\n| parameter | type | default | range | |\n|---|---|---|---|---|\n");
        for parameter in texture.parameters() {
            let _ = writeln!(
                text,
                "| `{}` | {} | {} | {} | {} |",
                parameter.name,
                parameter.ty,
                shown_default(parameter),
                range(parameter),
                parameter.label.replace('|', "\\|")
            );
        }
    }
    let _ = writeln!(text, "\n```toml\n{}```", snippet(texture, group));
}

fn shown_default(parameter: &Parameter) -> String {
    match default(parameter) {
        Some(text) if parameter.attribute.is_some() => text.replacen("attribute ", "the hit's ", 1),
        Some(text) => format!("`{text}`"),
        None => "must be set".to_owned(),
    }
}

fn range(parameter: &Parameter) -> String {
    let mut parts = Vec::new();
    let numbers =
        |(low, high): (f32, f32)| format!("{} to {}", written::number(low), written::number(high));
    if let Some(range) = parameter.range {
        parts.push(numbers(range));
    }
    if let Some(range) = parameter.soft_range {
        parts.push(format!("usually {}", numbers(range)));
    }
    let mut text = parts.join(", ");
    if let Some(unit) = &parameter.unit {
        text = format!("{text} {unit}").trim_start().to_owned();
    }
    text
}

/// A node with some of its parameters, and what it may drive.
fn snippet(texture: &TextureType, group: &str) -> String {
    let name = texture.name();
    let mut text = format!("[node.my_{name}]\ntexture = \"{name}\"\n");
    let usual = texture.parameters().iter().filter(|p| {
        let is_short = !matches!(p.ty, ParameterType::Ramp | ParameterType::Array(..));
        is_short && p.attribute.is_none()
    });
    for parameter in usual.take(3) {
        match default(parameter) {
            Some(value) => {
                let _ = writeln!(text, "{} = {value}", parameter.name);
            }
            None => {
                let _ = writeln!(text, "{} = \"picture.png\"", parameter.name);
            }
        }
    }
    text.push('\n');
    let is_normal = ["normal_map", "height_to_normal", "flakes"].contains(&name);
    let drive = match (group, texture.output()) {
        _ if texture
            .outputs()
            .iter()
            .any(|output| output.name == "color") =>
        {
            format!("[material.Stone]\nbase_color = \"my_{name}.color\"\n")
        }
        ("coordinates", _) => {
            format!("[node.stone]\ntexture = \"marble\"\nposition = \"my_{name}\"\n")
        }
        _ if is_normal && texture.output() == OutputType::Vec3 => {
            format!("[material.Stone]\nnormal = \"my_{name}\"\n")
        }
        _ if is_normal => format!("[material.Stone]\nnormal = \"my_{name}.xyz\"\n"),
        ("surface", OutputType::F32) if name == "water" => {
            format!("[material.Sea]\nbump = \"my_{name}\"\n")
        }
        (_, OutputType::F32) => format!("[material.Stone]\nroughness = \"my_{name}\"\n"),
        (_, OutputType::Vec2) => format!("[material.Stone]\nroughness = \"my_{name}.x\"\n"),
        _ if super::swatch::is_color(texture) => {
            format!("[material.Stone]\nbase_color = \"my_{name}\"\n")
        }
        _ => format!("[material.Stone]\nroughness = \"my_{name}.x\"\n"),
    };
    text + &drive
}
