//! Values as a look file writes them, so that what is shown can be copied into one.

use texgen::{Interpolation, Ramp, Value, Widget};

/// A value in the syntax of a look file. Colours are shown as `"#rrggbb"` where that is exact.
pub(super) fn value(value: &Value, widget: Widget) -> String {
    match value {
        Value::F32(v) => number(*v),
        Value::I32(v) => v.to_string(),
        Value::U32(v) => v.to_string(),
        Value::Bool(v) => v.to_string(),
        Value::Vec2(v) => list(v),
        Value::Vec3(v) => color(v, widget).unwrap_or_else(|| list(v)),
        Value::Vec4(v) => match v {
            [rgb @ .., 1.0] => color(rgb, widget).unwrap_or_else(|| list(v)),
            _ => list(v),
        },
        Value::Mat3(columns) => joined(columns.iter().map(|column| list(column))),
        Value::Mat4(columns) => joined(columns.iter().map(|column| list(column))),
        Value::Image(handle) => format!("image {handle}"),
        Value::Ramp(r) => ramp(r),
        Value::Array(values) => joined(values.iter().map(|v| self::value(v, Widget::Plain))),
    }
}

/// A number with as many digits as it needs.
pub(super) fn number(value: f32) -> String {
    if value != 0.0 && (value.abs() >= 1.0e9 || value.abs() < 1.0e-5) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

fn list(values: &[f32]) -> String {
    joined(values.iter().map(|&v| number(v)))
}

fn joined(parts: impl Iterator<Item = String>) -> String {
    format!("[{}]", parts.collect::<Vec<_>>().join(", "))
}

fn ramp(ramp: &Ramp) -> String {
    let stops = joined(ramp.stops.iter().map(|(at, rgba)| {
        let shown = value(&Value::Vec4(*rgba), Widget::Color);
        format!("[{}, {shown}]", number(*at))
    }));
    match ramp.interpolation {
        Interpolation::Linear => stops,
        Interpolation::Smooth => format!("{{ interpolation = \"smooth\", stops = {stops} }}"),
        Interpolation::Constant => format!("{{ interpolation = \"constant\", stops = {stops} }}"),
    }
}

/// The sRGB code of a linear colour, if it has one.
fn color(linear: &[f32], widget: Widget) -> Option<String> {
    if widget != Widget::Color {
        return None;
    }
    let code = |value: &f32| {
        let value = value.clamp(0.0, 1.0);
        // IEC 61966-2-1.
        let encoded = if value <= 0.003_130_8 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        };
        (encoded * 255.0).round() as u8
    };
    let codes: String = linear.iter().map(|v| format!("{:02x}", code(v))).collect();
    let text = format!("#{codes}");
    let decoded = texgen::color_from_hex(&text)?;
    let exact = linear
        .iter()
        .zip(decoded)
        .all(|(a, b)| (a - b).abs() < 1e-6);
    exact.then(|| format!("\"{text}\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_written_as_in_a_look() {
        let rust = texgen::color_from_hex("#c46a2a").expect("a colour");
        for (shown, expected) in [
            (value(&Value::F32(0.1), Widget::Plain), "0.1"),
            (value(&Value::F32(-2.0), Widget::Plain), "-2"),
            (value(&Value::F32(1.0e-7), Widget::Plain), "1e-7"),
            (value(&Value::Vec2([1.0, 0.5]), Widget::Plain), "[1, 0.5]"),
            (value(&Value::Vec4(rust), Widget::Color), "\"#c46a2a\""),
            (
                value(&Value::Vec3([2.0, 0.0, 0.0]), Widget::Color),
                "[2, 0, 0]",
            ),
            (
                value(&Value::Ramp(Ramp::black_to_white()), Widget::Plain),
                "[[0, \"#000000\"], [1, \"#ffffff\"]]",
            ),
        ] {
            assert_eq!(shown, expected);
        }
    }
}
