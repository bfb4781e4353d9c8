//! `[light.NAME]`: lights of a look's own, and overrides of those of the scene's files.

use glam::Vec3;

use crate::MAX_ANGULAR_DIAMETER;

use super::light::group;
use super::reader::{Reader, choice};
use super::value::{Field, Span, Spanned, Value};
use super::{Aim, LampKind, LightLook};

const KEYS: [&str; 13] = [
    "type",
    "on",
    "intensity",
    "color",
    "position",
    "look_at",
    "direction",
    "size",
    "inner_cone_angle",
    "outer_cone_angle",
    "range",
    "angular_diameter",
    "group",
];

/// Keys that only some kinds of lights have, and these.
const OF_KINDS: [(&str, &[LampKind]); 5] = [
    ("size", &[LampKind::Area]),
    ("inner_cone_angle", &[LampKind::Spot]),
    ("outer_cone_angle", &[LampKind::Spot]),
    ("range", &[LampKind::Point, LampKind::Spot]),
    ("angular_diameter", &[LampKind::Directional]),
];

/// A table `[light.NAME]`.
pub(super) fn light(
    reader: &mut Reader,
    name: &Spanned<String>,
    table: &[Field],
    _: &Span,
) -> Option<LightLook> {
    let kinds = LampKind::ALL.map(|kind| (kind.word(), kind));
    let mut light = LightLook::named(name.clone());
    for Field { key, value } in table {
        match key.value.as_str() {
            "type" => light.kind = choice(reader, value, &kinds),
            "on" => light.on = reader.bool(value).map(|on| on.value),
            "intensity" => {
                light.intensity =
                    reader.number(value, "a number that isn't negative", |x| x >= 0.0);
            }
            "color" => light.color = reader.color(value),
            "position" => light.position = reader.vec3(value),
            "look_at" => light.aim = reader.vec3(value).map(|at| at.with(Aim::At(at.value))),
            "direction" => light.aim = direction(reader, value),
            "size" => light.size = size(reader, value),
            "inner_cone_angle" => light.inner_cone_angle = angle(reader, value, 0.0, 90.0),
            "outer_cone_angle" => light.outer_cone_angle = angle(reader, value, 0.1, 90.0),
            "range" => {
                light.range = reader.number(value, "metres, more than 0", |x| x > 0.0);
            }
            "angular_diameter" => {
                let largest = MAX_ANGULAR_DIAMETER.to_degrees();
                light.angular_diameter = angle(reader, value, 0.0, largest);
            }
            "group" => light.group = group(reader, value),
            _ => reader.unknown_key(key, "[light.NAME]", &KEYS),
        }
    }
    check(reader, &light, table);
    Some(light)
}

/// A light of a kind, as messages speak of it.
fn called(kind: LampKind) -> String {
    let article = match kind {
        LampKind::Area => "an",
        _ => "a",
    };
    format!("{article} {} light", kind.word())
}

/// What can't be said together.
fn check(reader: &mut Reader, light: &LightLook, table: &[Field]) {
    let key = |wanted: &str| table.iter().find(|field| field.key.value == wanted);
    if let (Some(_), Some(direction)) = (key("look_at"), key("direction")) {
        reader.problem(
            &direction.key.span,
            "a light takes only one of `look_at` and `direction`",
        );
    }
    if let (Some(inner), Some(outer)) = (&light.inner_cone_angle, &light.outer_cone_angle)
        && inner.value >= outer.value
    {
        let why = "`inner_cone_angle` has to be less than `outer_cone_angle`";
        reader.problem(&inner.span, why);
    }
    if let (Some(intensity), Some(color)) = (&light.intensity, &light.color)
        && !(color.value * intensity.value).is_finite()
    {
        let why = "`color` times `intensity` is too large a number";
        reader.problem(&intensity.span, why);
    }
    let Some(kind) = &light.kind else {
        if let Some(size) = &light.size {
            let why = "only lights of the look's own have a `size`";
            let note = "say what it is, as in type = \"area\"";
            reader.problem_with_note(&size.span, why, note);
        }
        return;
    };
    for (wanted, kinds) in OF_KINDS {
        if let Some(field) = key(wanted).filter(|_| !kinds.contains(&kind.value)) {
            let words: Vec<_> = kinds.iter().map(|kind| kind.word()).collect();
            let why = format!("{} has no `{wanted}`", called(kind.value));
            let note = format!("lights of type {} have it", words.join(" and "));
            reader.problem_with_note(&field.key.span, why, note);
        }
    }
    if kind.value == LampKind::Point
        && let Some(aim) = &light.aim
    {
        reader.problem(&aim.span, "a point shines in all directions");
    }
    if kind.value != LampKind::Directional && key("position").is_none() {
        reader.problem_with_note(
            &kind.span,
            format!("{} needs a `position`", called(kind.value)),
            "as in position = [0.0, 2.0, 1.0], metres",
        );
    }
    if let (Some(aim), None) = (&light.aim, &light.position)
        && matches!(aim.value, Aim::At(_))
    {
        let why = "`look_at` needs a `position` to look from; `direction` does without";
        reader.problem(&aim.span, why);
    }
}

impl LightLook {
    /// A table without keys.
    pub fn named(name: Spanned<String>) -> Self {
        Self {
            name,
            kind: None,
            on: None,
            intensity: None,
            color: None,
            position: None,
            aim: None,
            size: None,
            inner_cone_angle: None,
            outer_cone_angle: None,
            range: None,
            angular_diameter: None,
            group: None,
        }
    }
}

fn angle(
    reader: &mut Reader,
    value: &Spanned<Value>,
    least: f32,
    most: f32,
) -> Option<Spanned<f32>> {
    let wanted = format!("degrees from {least} to {most:.0}");
    reader.number(value, &wanted, |x| (least..=most).contains(&x))
}

fn direction(reader: &mut Reader, value: &Spanned<Value>) -> Option<Spanned<Aim>> {
    let direction = reader.vec3(value)?;
    if direction.value.try_normalize().is_none() {
        reader.problem(&value.span, "no direction has the length 0");
        return None;
    }
    Some(direction.with(Aim::Direction(direction.value)))
}

fn size(reader: &mut Reader, value: &Spanned<Value>) -> Option<Spanned<[f32; 2]>> {
    let wanted = "width and height in metres, as in [0.5, 0.3]";
    let size = reader.numbers::<2>(value, wanted)?;
    // Beyond that its area isn't a number any more.
    if size.value.iter().any(|&side| !(1e-6..=1e6).contains(&side)) {
        reader.problem(&value.span, format!("expected {wanted}: from 1e-6 to 1e6"));
        return None;
    }
    Some(size)
}

/// Where a light shines to that stands somewhere; down where that says nothing.
pub fn direction_of(aim: Option<Aim>, position: Vec3) -> Option<Vec3> {
    match aim {
        None => Some(Vec3::NEG_Y),
        Some(Aim::Direction(direction)) => direction.try_normalize(),
        Some(Aim::At(point)) => (point - position).try_normalize(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_spoken_of_with_their_article() {
        let spoken = LampKind::ALL.map(called);
        for expected in ["an area light", "a spot light", "a point light"] {
            assert!(spoken.iter().any(|s| s == expected), "{expected}");
        }
    }
}
