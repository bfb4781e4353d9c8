//! Arguments that a parameter takes but that are probably not meant so: warnings, with what to write instead.

use texgen::{Parameter, Value, Widget};

use crate::scene::look::{self, color_remedy};

use super::values::Argument;

/// What is odd about an argument, and what to do.
pub(super) fn remark(
    written: &look::Value,
    parameter: &Parameter,
    argument: &Argument,
) -> Option<(String, Option<String>)> {
    let Argument::Constant(value) = argument else {
        return None;
    };
    let numbers = numbers(value);
    if let Some((low, high)) = parameter.range {
        let outside = numbers.iter().find(|&&n| n < low || n > high)?;
        let message = format!(
            "`{}` is {outside}, outside of the range that its texture declares: {low} to {high}",
            parameter.name
        );
        return Some((message, color_note(written, parameter)));
    }
    let note = color_note(written, parameter)?;
    Some((
        format!("`{}` is a colour beyond 1", parameter.name),
        Some(note),
    ))
}

fn color_note(written: &look::Value, parameter: &Parameter) -> Option<String> {
    let is_color = parameter.widget == Widget::Color;
    is_color.then(|| color_remedy(written)).flatten()
}

fn numbers(value: &Value) -> Vec<f32> {
    match value {
        Value::F32(n) => vec![*n],
        // Ranges are declared in single precision too.
        Value::I32(n) => vec![*n as f32],
        Value::U32(n) => vec![*n as f32],
        Value::Vec2(v) => v.to_vec(),
        Value::Vec3(v) => v.to_vec(),
        Value::Vec4(v) => v.to_vec(),
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        _ => Vec::new(),
    }
}
