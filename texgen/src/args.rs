//! The fake stack: the layout of a node's constants, and their words.
//!
//! A node has one block with its parameters in order, each on the next free word. A ramp takes one word there, the
//! offset of its stops, which lie in a piece of the stack of their own with room to grow:
//! the number of stops in bits 0..30 and the interpolation in bits 30..32, then position, r, g, b, a of each stop.

use std::ops::Range;

use crate::interface::Parameter;
use crate::value::{Interpolation, ParameterType, Ramp, Value};

/// Words that a parameter takes in its node's block.
pub(crate) fn words_of(ty: ParameterType) -> u32 {
    match ty {
        ParameterType::F32 | ParameterType::I32 | ParameterType::U32 | ParameterType::Bool => 1,
        ParameterType::Image | ParameterType::Ramp => 1,
        ParameterType::Vec2 => 2,
        ParameterType::Vec3 => 3,
        ParameterType::Vec4 => 4,
        ParameterType::Mat3 => 9,
        ParameterType::Mat4 => 16,
        ParameterType::Array(element, count) => words_of(element.parameter_type()) * count,
    }
}

/// Word offset of each parameter in its node's block.
pub(crate) fn offsets(parameters: &[Parameter]) -> Vec<u32> {
    let mut next = 0;
    parameters
        .iter()
        .map(|parameter| {
            let offset = next;
            next += words_of(parameter.ty);
            offset
        })
        .collect()
}

/// Words of a node's whole block.
pub(crate) fn block_words(parameters: &[Parameter]) -> u32 {
    parameters
        .iter()
        .map(|parameter| words_of(parameter.ty))
        .sum()
}

/// Handle in the words of an image parameter without an image.
pub(crate) const NO_IMAGE: u32 = u32::MAX;

/// Appends the words of a value in a node's block; not of ramps.
pub(crate) fn encode(value: &Value, words: &mut Vec<u32>) {
    let mut floats = |values: &[f32]| words.extend(values.iter().map(|value| value.to_bits()));
    match value {
        Value::F32(value) => floats(&[*value]),
        Value::Vec2(value) => floats(value),
        Value::Vec3(value) => floats(value),
        Value::Vec4(value) => floats(value),
        Value::Mat3(columns) => columns.iter().for_each(|column| floats(column)),
        Value::Mat4(columns) => columns.iter().for_each(|column| floats(column)),
        Value::I32(value) => words.push(*value as u32),
        Value::U32(value) | Value::Image(value) => words.push(*value),
        Value::Bool(value) => words.push(u32::from(*value)),
        Value::Array(values) => values.iter().for_each(|value| encode(value, words)),
        Value::Ramp(_) => {}
    }
}

/// Words of a ramp's stops with their header, sorted by position.
pub(crate) fn encode_ramp(ramp: &Ramp) -> Vec<u32> {
    let mut stops = ramp.stops.clone();
    stops.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable: equal positions keep their order, a hard step
    let interpolation = match ramp.interpolation {
        Interpolation::Linear => 0,
        Interpolation::Smooth => 1,
        Interpolation::Constant => 2,
    };
    let mut words = vec![stops.len() as u32 | interpolation << 30];
    for (position, color) in stops {
        words.push(position.to_bits());
        words.extend(color.iter().map(|component| component.to_bits()));
    }
    words
}

/// Words that a new ramp of so many stops takes.
pub(crate) fn ramp_words(stops: usize) -> usize {
    with_room(1 + 5 * stops)
}

/// A ramp's words with room to grow.
fn with_room(words: usize) -> usize {
    (2 * words).max(1 + 5 * 4)
}

/// What is wrong with a value, as the end of a sentence; `None` if nothing is.
pub(crate) fn problem(value: &Value) -> Option<String> {
    let finite = match value {
        Value::F32(value) => value.is_finite(),
        Value::Vec2(value) => value.iter().all(|v| v.is_finite()),
        Value::Vec3(value) => value.iter().all(|v| v.is_finite()),
        Value::Vec4(value) => value.iter().all(|v| v.is_finite()),
        Value::Mat3(columns) => columns.iter().flatten().all(|v| v.is_finite()),
        Value::Mat4(columns) => columns.iter().flatten().all(|v| v.is_finite()),
        Value::I32(_) | Value::U32(_) | Value::Bool(_) | Value::Image(_) => true,
        Value::Array(values) => return values.iter().find_map(problem),
        Value::Ramp(ramp) => {
            if ramp.stops.is_empty() {
                return Some("has no stops: give at least one, like [0.0, \"#ffffff\"]".into());
            }
            if ramp.stops.len() > MAX_STOPS {
                return Some(format!(
                    "has {} stops: at most {MAX_STOPS} are possible",
                    ramp.stops.len()
                ));
            }
            ramp.stops.iter().all(|(position, color)| {
                position.is_finite() && color.iter().all(|v| v.is_finite())
            })
        }
    };
    (!finite).then(|| "is not finite: write ordinary numbers".into())
}

/// Most stops of one ramp.
const MAX_STOPS: usize = 65_536;

/// All words, with the pieces that ramps live in.
#[derive(Clone, Debug, Default)]
pub(crate) struct FakeStack {
    words: Vec<u32>,
    /// Pieces given up by ramps that grew.
    free: Vec<Range<usize>>,
}

impl FakeStack {
    pub(crate) fn words(&self) -> &[u32] {
        &self.words
    }

    /// Appends a block of `count` words and returns its offset.
    pub(crate) fn push_block(&mut self, count: u32) -> u32 {
        let offset = self.words.len();
        self.words.resize(offset + count as usize, 0);
        offset as u32
    }

    /// Writes words and returns the range that actually changed, if any.
    pub(crate) fn write(&mut self, offset: u32, words: &[u32]) -> Option<Range<usize>> {
        let offset = offset as usize;
        let old = &mut self.words[offset..offset + words.len()];
        let first = old.iter().zip(words).position(|(a, b)| a != b)?;
        let last = old.iter().zip(words).rposition(|(a, b)| a != b)?;
        old[first..=last].copy_from_slice(&words[first..=last]);
        Some(offset + first..offset + last + 1)
    }

    /// A piece of at least `count` words: a free one, or a new one at the end with room for as much again.
    pub(crate) fn allocate(&mut self, count: usize) -> Range<usize> {
        if let Some(at) = self.free.iter().position(|piece| piece.len() >= count) {
            return self.free.swap_remove(at);
        }
        let start = self.words.len();
        self.words.resize(start + with_room(count), 0);
        start..self.words.len()
    }

    /// Gives a piece back.
    pub(crate) fn release(&mut self, piece: Range<usize>) {
        if !piece.is_empty() {
            self.free.push(piece);
        }
    }
}
