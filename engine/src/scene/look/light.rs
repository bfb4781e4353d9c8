//! What a look says about light: its environment and the lights of the glTF file.

use crate::scene::MAX_ANGULAR_DIAMETER;

use super::reader::Reader;
use super::value::{Field, Span, Spanned, Value};
use super::{EnvironmentLook, LightLook};

pub(super) fn environment(
    reader: &mut Reader,
    value: &Spanned<Value>,
) -> Option<Spanned<EnvironmentLook>> {
    const KEYS: [&str; 4] = ["image", "color", "rotation", "intensity"];
    let table = reader.table(value, "{ image = \"sky.hdr\" } or { color = [r, g, b] }")?;
    let (mut image, mut color, mut rotation, mut intensity) = (None, None, None, None);
    for Field { key, value } in table {
        match key.value.as_str() {
            "image" => image = reader.text(value),
            "color" => color = reader.color(value),
            "rotation" => rotation = reader.number(value, "degrees", |_| true),
            "intensity" => {
                intensity = reader.number(value, "a number that isn't negative", |x| x >= 0.0)
            }
            _ => reader.unknown_key(key, "`environment`", &KEYS),
        }
    }
    let intensity = intensity.map_or(1.0, |i| i.value);
    let has = |name: &str| table.iter().any(|f| f.key.value == name);
    match (has("image"), has("color")) {
        (true, true) => {
            reader.problem(
                &value.span,
                "`environment` takes either `image` or `color`, not both",
            );
            None
        }
        (true, false) => Some(value.with(EnvironmentLook::Image {
            image: image?,
            rotation: rotation.map_or(0.0, |r| r.value),
            intensity,
        })),
        (false, true) => {
            if let Some(rotation) = rotation {
                reader.problem(
                    &rotation.span,
                    "`rotation` needs `image`: a constant colour has no direction",
                );
            }
            Some(value.with(EnvironmentLook::Constant(color?.value * intensity)))
        }
        (false, false) => {
            reader.problem(&value.span, "`environment` needs `image` or `color`");
            None
        }
    }
}

/// `[light.NAME]`: overrides of a light of the glTF file.
pub(super) fn light(
    reader: &mut Reader,
    name: &Spanned<String>,
    table: &[Field],
    _: &Span,
) -> Option<LightLook> {
    const KEYS: [&str; 1] = ["angular_diameter"];
    let mut light = LightLook {
        name: name.clone(),
        angular_diameter: None,
    };
    let largest = MAX_ANGULAR_DIAMETER.to_degrees();
    for Field { key, value } in table {
        match key.value.as_str() {
            "angular_diameter" => {
                let wanted = format!("degrees from 0 to {largest:.0}");
                light.angular_diameter =
                    reader.number(value, &wanted, |x| (0.0..=largest).contains(&x));
            }
            _ => reader.unknown_key(key, "[light.NAME]", &KEYS),
        }
    }
    Some(light)
}
