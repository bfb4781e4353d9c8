//! What a look says about light from far away: its environment.

use glam::Vec3;

use crate::UNGROUPED;
use crate::sky::Sky;

use super::EnvironmentLook;
use super::reader::{LONGEST_NAME, Reader, unit};
use super::value::{Field, Spanned, Value};

/// The most radiance of an environment, and the largest factor on one: what becomes of it are sums of many.
const MOST: f32 = 1e30;

/// `environment = { ... }`: a picture, a colour or a sky.
pub(super) fn environment(
    reader: &mut Reader,
    value: &Spanned<Value>,
) -> Option<Spanned<EnvironmentLook>> {
    const KEYS: [&str; 6] = ["image", "color", "sky", "rotation", "intensity", "group"];
    const SHAPES: &str =
        "{ image = \"sky.hdr\" }, { color = [r, g, b] } or { sky = { sun_elevation = 35 } }";
    let table = reader.table(value, SHAPES)?;
    let (mut image, mut color, mut sky) = (None, None, None);
    let (mut rotation, mut intensity) = (None, None);
    for Field { key, value } in table {
        match key.value.as_str() {
            "image" => image = reader.text(value),
            "color" => color = reader.color(value),
            "sky" => sky = self::sky(reader, value),
            "rotation" => rotation = reader.number(value, "degrees", |_| true),
            "intensity" => {
                intensity = reader.number(value, "a number that isn't negative", |x| x >= 0.0)
            }
            "group" => {} // read by `environment_group`
            _ => reader.unknown_key(key, "`environment`", &KEYS),
        }
    }
    let intensity = intensity.map_or(1.0, |i| i.value);
    let largest = match (&color, &sky) {
        (Some(color), _) => color.value.max_element().max(1.0) * intensity,
        (None, Some(sky)) => sky.intensity.max(1.0) * intensity,
        (None, None) => intensity,
    };
    if largest > MOST {
        reader.problem(
            &value.span,
            "its light is too strong to be reckoned with: with `intensity` it may be 1e30 at most",
        );
        return None;
    }
    let has = |name: &str| table.iter().any(|f| f.key.value == name);
    let mut without_rotation = |why: &str| {
        if let Some(rotation) = &rotation {
            reader.problem(&rotation.span, format!("`rotation` needs `image`: {why}"));
        }
    };
    match (has("image"), has("color"), has("sky")) {
        (true, false, false) => Some(value.with(EnvironmentLook::Image {
            image: image?,
            rotation: rotation.map_or(0.0, |r| r.value),
            intensity,
        })),
        (false, true, false) => {
            without_rotation("a constant colour has no direction");
            Some(value.with(EnvironmentLook::Constant(color?.value * intensity)))
        }
        (false, false, true) => {
            without_rotation("a sky is turned by its `sun_azimuth`");
            let mut sky = sky?;
            sky.intensity *= intensity;
            Some(value.with(EnvironmentLook::Sky(sky)))
        }
        (false, false, false) => {
            reader.problem(&value.span, "`environment` needs `image`, `color` or `sky`");
            None
        }
        _ => {
            reader.problem(
                &value.span,
                "`environment` takes only one of `image`, `color` and `sky`",
            );
            None
        }
    }
}

/// The group of lights that an environment is in.
pub(super) fn environment_group(
    reader: &mut Reader,
    value: &Spanned<Value>,
) -> Option<Spanned<String>> {
    let Value::Table(fields) = &value.value else {
        return None; // which `environment` complains about
    };
    let field = fields.iter().find(|field| field.key.value == "group")?;
    group(reader, &field.value)
}

/// The name of a group of lights.
pub(super) fn group(reader: &mut Reader, value: &Spanned<Value>) -> Option<Spanned<String>> {
    let name = reader.text(value)?;
    let is_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if name.value.is_empty() || !name.value.chars().all(is_word) {
        reader.problem_with_note(
            &value.span,
            "a group of lights has a name of letters, digits, `_` and `-`",
            "it becomes part of the name of a layer, as in group = \"key\"",
        );
        return None;
    }
    if name.value.len() > LONGEST_NAME {
        reader.problem_with_note(
            &value.span,
            format!("the name of a group of lights is too long: {LONGEST_NAME} bytes at most"),
            "it becomes part of the names of channels, and OpenEXR files hold no longer ones; choose a shorter one",
        );
        return None;
    }
    if name.value == UNGROUPED {
        let problem = format!("`{UNGROUPED}` is what belongs to no group: choose another name");
        reader.problem(&value.span, problem);
        return None;
    }
    Some(name)
}

fn sky(reader: &mut Reader, value: &Spanned<Value>) -> Option<Sky> {
    const KEYS: [&str; 8] = [
        "sun_elevation",
        "sun_azimuth",
        "aerosol",
        "altitude",
        "ground_albedo",
        "sun",
        "sun_size",
        "intensity",
    ];
    let table = reader.table(value, "a table such as { sun_elevation = 35 }")?;
    let mut sky = Sky::default();
    for Field { key, value } in table {
        let mut number = |slot: &mut f32, wanted: &str, low: f32, high: f32| {
            if let Some(number) = reader.number(value, wanted, |x| (low..=high).contains(&x)) {
                *slot = number.value;
            }
        };
        match key.value.as_str() {
            "sun_elevation" => {
                number(
                    &mut sky.sun_elevation,
                    "degrees from -90 to 90",
                    -90.0,
                    90.0,
                );
            }
            "sun_azimuth" => {
                number(
                    &mut sky.sun_azimuth,
                    "degrees from -360 to 360",
                    -360.0,
                    360.0,
                );
            }
            "aerosol" => number(&mut sky.aerosol, "a number from 0 to 100", 0.0, 100.0),
            "altitude" => number(&mut sky.altitude, "metres from 0 to 50000", 0.0, 5e4),
            "sun_size" => number(&mut sky.sun_size, "degrees from 0 to 90", 0.0, 90.0),
            "intensity" => {
                number(
                    &mut sky.intensity,
                    "a number that isn't negative",
                    0.0,
                    f32::MAX,
                );
            }
            "ground_albedo" => {
                let albedo = match value.value {
                    Value::Text(_) | Value::List(_) => reader.color(value).map(|c| c.value),
                    _ => (reader.number(value, "a number from 0 to 1, or a colour", unit))
                        .map(|n| Vec3::splat(n.value)),
                };
                let albedo = albedo.unwrap_or(sky.ground_albedo);
                if albedo.max_element() > 1.0 {
                    reader.problem(&value.span, "the ground can't give back more than it gets");
                }
                sky.ground_albedo = albedo;
            }
            "sun" => sky.sun = reader.bool(value).is_none_or(|b| b.value),
            _ => reader.unknown_key(key, "`sky`", &KEYS),
        }
    }
    Some(sky)
}
