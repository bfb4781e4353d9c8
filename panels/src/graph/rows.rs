//! What stands on a card: its inputs and outputs, and where on the card they are.

use std::rc::Rc;

use egui::{Color32, Pos2, Rect, pos2, vec2};
use engine::procedural::{Kind, Output};
use engine::scene::look::Section;
use texgen::{Parameter, ParameterType, Swizzle, Value, Widget};

use super::{GraphItem, GraphView, OutputSocket, Sockets};
use crate::context::Context;
use crate::material::{InLook as _, PARAMETERS, Takes};
use crate::model::Target;
use crate::node;

pub(super) const WIDTH: f32 = 190.0;
pub(super) const TITLE: f32 = 24.0;
pub(super) const ROW: f32 = 18.0;
pub(super) const PREVIEW: f32 = 64.0;
/// From one output to the next.
const OUTPUT: f32 = 15.0;
pub(super) const MARGIN: f32 = 6.0;

/// Something that can be driven.
#[derive(Debug)]
pub(super) struct Input {
    pub(super) target: Rc<Target>,
    pub(super) label: String,
    pub(super) color: Color32,
    /// The constant that it has, where nothing drives it.
    pub(super) value: Option<Shown>,
}

/// A constant on a card.
#[derive(Debug, PartialEq)]
pub(super) enum Shown {
    Text(String),
    /// Linear.
    Color([f32; 3]),
}

impl Input {
    fn new(target: Target, label: String, components: usize, value: Option<Shown>) -> Self {
        Self {
            value,
            target: Rc::new(target),
            label,
            color: color_of(components),
        }
    }
}

/// A node's result, or one of its components.
#[derive(Debug)]
pub(super) struct Out {
    pub(super) source: Rc<OutputSocket>,
    pub(super) color: Color32,
}

/// What stands on a card; kept until the look changes.
#[derive(Debug)]
pub(super) struct Rows {
    pub(super) inputs: Vec<Input>,
    /// The whole result first; none where there is no texture.
    pub(super) outputs: Vec<Out>,
    /// Other materials that a blend is made of, and their rows.
    sides: Vec<(String, usize)>,
    /// Points from the top of the card to its first input.
    top: f32,
    /// Points that the card is high.
    pub(super) height: f32,
}

impl Rows {
    fn new(cx: &Context<'_>, subject: GraphItem<'_>) -> Self {
        let inputs = inputs(cx, subject);
        let mut sides = Vec::new();
        let (outputs, head) = match subject {
            GraphItem::Node(node) => {
                let outputs = outputs(cx, node);
                let beside = OUTPUT * outputs.len().saturating_sub(1) as f32;
                (outputs, beside.max(PREVIEW) + MARGIN)
            }
            GraphItem::Material(material) => {
                let names = cx.model.sides(material);
                let others = names.into_iter().flatten().enumerate();
                let others = others.filter(|(_, name)| *name != material);
                sides.extend(others.map(|(i, name)| (name.to_owned(), i)));
                (Vec::new(), names.map_or(0.0, |_| 2.0 * ROW))
            }
        };
        let top = TITLE + head;
        let height = top + inputs.len() as f32 * ROW + MARGIN;
        Self {
            inputs,
            outputs,
            sides,
            top,
            height,
        }
    }

    pub(super) fn input_place(&self, card: Rect, i: usize) -> Pos2 {
        pos2(card.left(), card.top() + self.top + (i as f32 + 0.5) * ROW)
    }

    pub(super) fn output_place(card: Rect, i: usize) -> Pos2 {
        let below = match i {
            0 => 0.5 * TITLE,
            _ => TITLE + (i as f32 - 0.5) * OUTPUT,
        };
        card.right_top() + vec2(0.0, below)
    }

    pub(super) fn side_place(card: Rect, i: usize) -> Pos2 {
        card.left_top() + vec2(0.0, TITLE + (i as f32 + 0.5) * ROW)
    }

    /// Notes where links begin and end on a card.
    pub(super) fn put_sockets(&self, card: Rect, subject: GraphItem<'_>, sockets: &mut Sockets) {
        for (i, input) in self.inputs.iter().enumerate() {
            let place = self.input_place(card, i);
            sockets.inputs.insert(Rc::clone(&input.target), place);
        }
        for (i, output) in self.outputs.iter().enumerate() {
            let place = Self::output_place(card, i);
            sockets.outputs.insert(Rc::clone(&output.source), place);
        }
        if let GraphItem::Material(material) = subject {
            let surface = card.right_top() + vec2(0.0, 0.5 * TITLE);
            sockets.surfaces.insert(material.to_owned(), surface);
        }
        for (name, i) in &self.sides {
            let place = Self::side_place(card, *i);
            sockets.sides.push((name.clone(), place));
        }
    }
}

impl GraphView {
    /// What stands on a card.
    pub(super) fn rows(&mut self, cx: &Context<'_>, subject: GraphItem<'_>) -> Rc<Rows> {
        if self.rows_of != cx.model.id() {
            self.rows.clear();
            self.rows_of = cx.model.id();
        }
        let rows = self.rows.entry(subject.id());
        Rc::clone(rows.or_insert_with(|| Rc::new(Rows::new(cx, subject))))
    }
}

fn outputs(cx: &Context<'_>, node: &str) -> Vec<Out> {
    let Some(texture) = cx.model.texture(node) else {
        return Vec::new();
    };
    let count = texture.output().components();
    let whole = [(None, count)];
    if !texture.outputs().is_empty() {
        // The first is what a link takes that names none.
        let further = texture.outputs().iter().skip(1);
        let further = further.map(|output| {
            let take = Swizzle::of_output(&output.name);
            (take, output.ty.components())
        });
        let all = whole.into_iter().chain(further);
        return all.map(|(take, count)| out(node, take, count)).collect();
    }
    // A number has no parts.
    let parts = if count > 1 { count } else { 0 };
    let parts = ["x", "y", "z", "w"].into_iter().take(parts);
    let parts = parts.map(|part| (part.parse().ok(), 1));
    let all = whole.into_iter().chain(parts);
    all.map(|(take, count)| out(node, take, count)).collect()
}

fn out(node: &str, swizzle: Option<Swizzle>, components: usize) -> Out {
    Out {
        source: Rc::new(OutputSocket {
            node: node.to_owned(),
            swizzle,
        }),
        color: color_of(components),
    }
}

/// What of a node or material can be driven, with its label and colour.
fn inputs(cx: &Context<'_>, subject: GraphItem<'_>) -> Vec<Input> {
    match subject {
        GraphItem::Node(node) => {
            let parameters = cx.model.texture(node).map_or(&[][..], |t| t.parameters());
            let linkable = parameters.iter().filter(|p| p.ty.is_linkable());
            let input = linkable.map(|parameter| {
                let target = Target::Parameter {
                    node: node.to_owned(),
                    parameter: parameter.name.clone(),
                };
                let label = node::short_label(parameter).to_owned();
                let shown = node_value(cx, node, parameter).filter(|_| is_free(cx, &target));
                Input::new(target, label, components(parameter.ty), shown)
            });
            input.collect()
        }
        GraphItem::Material(material) => {
            let mask = cx.model.sides(material).map(|_| {
                let target = Target::Mask {
                    material: material.to_owned(),
                };
                Input::new(target, "Mask".to_owned(), 1, None)
            });
            let keys = PARAMETERS.iter().filter_map(|key| {
                let output = key.output()?;
                let target = Target::Input {
                    material: material.to_owned(),
                    output,
                };
                let is_driven = cx.model.source(&target).is_some();
                let is_usual = key.is_common && output != Output::EMISSION_STRENGTH;
                let is_shown = is_driven || (is_usual && !cx.model.is_pure_blend(material));
                let count = match output.kind() {
                    Kind::Scalar => 1,
                    Kind::Color | Kind::Vector => 3,
                };
                let section = Section::Material(material.to_owned());
                let constant = || {
                    let written = cx.document.value(&section, key.key);
                    let written = written.map(|value| value.at(0.0));
                    let constant = written.or_else(|| key.written(cx.scene_material(material)));
                    shown(
                        &key.shown(&constant?)?,
                        matches!(key.takes, Takes::Color { .. }),
                    )
                };
                let value = (!is_driven).then(constant).flatten();
                is_shown.then(|| Input::new(target, key.label.to_owned(), count, value))
            });
            mask.into_iter().chain(keys).collect()
        }
    }
}

/// Whether nothing drives it.
fn is_free(cx: &Context<'_>, target: &Target) -> bool {
    cx.model.source(target).is_none()
}

/// What a parameter of a node is: the name of an attribute, or a constant.
fn node_value(cx: &Context<'_>, node: &str, parameter: &Parameter) -> Option<Shown> {
    let id = cx.model.graph.node(node)?;
    if let Some(attribute) = cx.model.graph.attribute(id, &parameter.name) {
        return Some(Shown::Text(attribute.name().to_owned()));
    }
    let value = cx.model.graph.value(id, &parameter.name)?;
    shown(value, parameter.widget == Widget::Color)
}

fn shown(value: &Value, is_color: bool) -> Option<Shown> {
    let list = |list: &[f32]| {
        let words: Vec<String> = list.iter().map(|&x| number(x)).collect();
        Some(Shown::Text(words.join(" ")))
    };
    match value {
        Value::Vec3(rgb) if is_color => Some(Shown::Color(*rgb)),
        Value::Vec4([r, g, b, _]) if is_color => Some(Shown::Color([*r, *g, *b])),
        Value::F32(x) => list(&[*x]),
        Value::Vec2(v) => list(v),
        Value::Vec3(v) => list(v),
        Value::Vec4(v) => list(v),
        Value::I32(x) => Some(Shown::Text(x.to_string())),
        Value::U32(x) => Some(Shown::Text(x.to_string())),
        Value::Bool(x) => Some(Shown::Text(if *x { "yes" } else { "no" }.to_owned())),
        _ => None,
    }
}

/// With three digits, as a card has little room.
fn number(x: f32) -> String {
    if x == 0.0 || !x.is_finite() || !(1e-3..1e5).contains(&x.abs()) {
        return format!("{x:.2e}").replace("0.00e0", "0");
    }
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 5) as usize;
    let text = format!("{x:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn components(ty: ParameterType) -> usize {
    match ty {
        ParameterType::Vec2 => 2,
        ParameterType::Vec3 => 3,
        ParameterType::Vec4 => 4,
        _ => 1,
    }
}

/// Of a socket that takes or gives so many numbers.
fn color_of(components: usize) -> Color32 {
    match components {
        1 => Color32::from_rgb(160, 160, 160),
        2 => Color32::from_rgb(90, 170, 120),
        3 => Color32::from_rgb(210, 180, 80),
        _ => Color32::from_rgb(170, 110, 200),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.25, "0.25"),
            (123.456, "123"),
            (-0.012345, "-0.0123"),
            (1e6, "1.00e6"),
        ] {
            assert_eq!(number(x), text);
        }
    }
}
