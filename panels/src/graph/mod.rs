//! The graph form: the nodes of a material as cards with sockets, and links between them.
//!
//! The look doesn't say where cards stand; that is a matter of the view.

mod card;
mod drop;
mod focus;
mod frames;
mod layout;
mod place;
mod rows;
mod select;

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use egui::epaint::CubicBezierShape;
use egui::{
    Color32, DragPanButtons, Key, LayerId, Modifiers, Pos2, Rect, Response, Scene, Shape, Stroke,
    Ui, vec2,
};
use texgen::Swizzle;

use crate::context::Context;
use crate::edits;
use crate::library::add_menu;
use crate::model::{Model, Target};
use crate::widgets::{context_menu, menu, name};

/// Points around a socket in which a link can be dropped.
const REACH: f32 = 16.0;

/// How far a link goes on sideways before it bends, at most.
const BEND: f32 = 160.0;

/// What a link comes from.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct OutputSocket {
    node: String,
    swizzle: Option<Swizzle>,
}

/// A link that hangs on the pointer.
#[derive(Debug)]
struct Loose {
    source: OutputSocket,
    /// Where it was taken off.
    former: Option<Target>,
}

/// The view of a graph.
#[derive(Debug)]
pub(crate) struct GraphView {
    /// The part of the plane that is seen; empty until it is known.
    seen: Rect,
    /// Upper left corners of cards by their ids.
    places: HashMap<String, Pos2>,
    /// Nodes.
    selected: BTreeSet<String>,
    loose: Option<Loose>,
    /// What stands on the cards, by their ids, and the model whose look says so.
    rows: HashMap<String, Rc<rows::Rows>>,
    rows_of: u64,
    /// Where the menu for new nodes was opened.
    menu_at: Pos2,
    search: String,
    /// What is looked for among the nodes.
    wanted: String,
    /// Nodes whose cards are shown.
    nodes_shown: Vec<String>,
    /// Cards that are shown, by their ids, and the material that they are of.
    shown: BTreeSet<String>,
    shown_of: Option<String>,
    /// What is to be brought into sight.
    revealed: Option<Rect>,
    /// The plane's, by which its widgets are told from others.
    layer: Option<LayerId>,
    /// What the plane lies in.
    outer_layer: Option<LayerId>,
    /// Where the plane is in the window, points.
    area: Rect,
    /// Where a rectangle that selects begins, in the window.
    box_start: Option<Pos2>,
}

impl Default for GraphView {
    fn default() -> Self {
        Self {
            seen: Rect::ZERO,
            places: HashMap::new(),
            selected: BTreeSet::new(),
            loose: None,
            rows: HashMap::new(),
            rows_of: 0,
            menu_at: Pos2::ZERO,
            search: String::new(),
            wanted: String::new(),
            nodes_shown: Vec::new(),
            shown: BTreeSet::new(),
            shown_of: None,
            revealed: None,
            layer: None,
            outer_layer: None,
            area: Rect::ZERO,
            box_start: None,
        }
    }
}

/// What was drawn where in this frame.
#[derive(Debug, Default)]
struct Sockets {
    outputs: HashMap<Rc<OutputSocket>, Pos2>,
    inputs: HashMap<Rc<Target>, Pos2>,
    /// Right edges of materials, for the sides of blends, and where those go.
    surfaces: HashMap<String, Pos2>,
    sides: Vec<(String, Pos2)>,
    /// The link that hangs on the pointer was let go.
    is_dropped: bool,
}

impl Sockets {
    /// Where a link comes out. Several components at once come from the socket of the whole.
    fn output(&self, source: &OutputSocket) -> Option<&Pos2> {
        let whole = || OutputSocket {
            swizzle: None,
            ..source.clone()
        };
        let own = self.outputs.get(source);
        let output = OutputSocket {
            node: source.node.clone(),
            swizzle: source.swizzle.and_then(|take| take.whole()),
        };
        own.or_else(|| self.outputs.get(&output))
            .or_else(|| self.outputs.get(&whole()))
    }
}

/// What a card is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum GraphItem<'a> {
    Node(&'a str),
    Material(&'a str),
}

impl GraphItem<'_> {
    fn id(self) -> String {
        match self {
            Self::Node(name) => format!("node {name}"),
            Self::Material(name) => format!("material {name}"),
        }
    }
}

impl GraphView {
    /// The one node that is selected.
    pub(crate) fn selected(&self) -> Option<&str> {
        match self.selected.iter().next() {
            Some(node) if self.selected.len() == 1 => Some(node),
            _ => None,
        }
    }

    /// Selects a node, and nothing else.
    pub(crate) fn select(&mut self, node: &str) {
        self.selected = BTreeSet::from([node.to_owned()]);
    }

    /// A card goes by another name. The place of the former one is kept, for when that is undone.
    pub(crate) fn rename(&mut self, old: GraphItem<'_>, new: GraphItem<'_>) {
        if let Some(&place) = self.places.get(&old.id()) {
            self.places.insert(new.id(), place);
            // It is the same card, wherever it stands.
            self.shown.insert(new.id());
        }
        if let (GraphItem::Node(old), GraphItem::Node(new)) = (old, new)
            && self.selected.remove(old)
        {
            self.selected.insert(new.to_owned());
        }
    }

    /// Where cards stand, by their ids.
    pub(crate) fn places(&self) -> impl Iterator<Item = (&str, [f32; 2])> {
        let places = self.places.iter();
        places.map(|(id, place)| (id.as_str(), [place.x, place.y]))
    }

    /// Puts cards where they were.
    pub(crate) fn set_places(&mut self, places: impl IntoIterator<Item = (String, [f32; 2])>) {
        let places = places.into_iter();
        self.places = places.map(|(id, [x, y])| (id, Pos2::new(x, y))).collect();
    }

    /// Shows all of the graph again.
    pub(crate) fn fit(&mut self) {
        self.seen = Rect::ZERO;
    }

    /// Shows the graph of some materials and what no material needs.
    pub(crate) fn show(&mut self, ui: &mut Ui, cx: &mut Context<'_>, materials: &[&str]) {
        let model = cx.model;
        let mut nodes = model.nodes_of(materials);
        nodes.extend(model.loose_nodes(cx.document.look()));
        self.selected.retain(|node| nodes.contains(node));
        self.nodes_shown.clone_from(&nodes);
        ui.horizontal(|ui| self.tools(ui, cx));
        let mut subjects: Vec<GraphItem<'_>> = materials
            .iter()
            .map(|name| GraphItem::Material(name))
            .collect();
        subjects.extend(nodes.iter().map(|name| GraphItem::Node(name)));
        self.place(cx, &subjects);

        let area = ui.available_rect_before_wrap();
        self.area = area;
        self.outer_layer = Some(ui.layer_id());
        // With Shift or Command held a drag selects.
        let selects = ui.input(|i| i.modifiers.shift || i.modifiers.command);
        let pans = match selects || self.box_start.is_some() {
            true => DragPanButtons::all() - DragPanButtons::PRIMARY,
            false => DragPanButtons::all(),
        };
        let mut seen = self.seen;
        let shown = Scene::new()
            .drag_pan_buttons(pans)
            .zoom_range(0.1..=2.0)
            .max_inner_size(vec2(f32::INFINITY, f32::INFINITY))
            .show(ui, &mut seen, |ui| {
                let mut sockets = Sockets::default();
                self.layer = Some(ui.layer_id());
                self.frames(ui, cx);
                // Links lie below the cards, but are known after them.
                let below = ui.painter().add(Shape::Noop);
                for &subject in &subjects {
                    self.card(ui, cx, subject, &mut sockets);
                }
                self.drop_loose(ui, cx, &sockets);
                self.drop_texture(ui, cx, &subjects);
                let links = self.links(ui, model, &sockets);
                ui.painter().set(below, Shape::Vec(links));
            });
        self.seen = seen;
        self.reveal(ui);
        self.background(cx, &shown.response);
        self.select_in_box(ui, cx, &shown.response);
        if self.has_keyboard(ui) {
            self.keys(ui, cx);
            self.take_clipboard(ui, cx);
        }
    }

    fn tools(&mut self, ui: &mut Ui, cx: &mut Context<'_>) {
        let center = match self.seen.is_positive() {
            true => self.seen.center(),
            false => Pos2::ZERO,
        };
        let add = menu(ui, "Add…", |ui| self.add(ui, cx, center));
        name(&add.response, "Add a node");
        if ui.button("Arrange").clicked() {
            self.places.clear();
            self.fit();
        }
        if ui.button("Fit").clicked() {
            self.fit();
        }
        self.find(ui, cx);
        if !self.selected.is_empty() {
            if ui.button("Duplicate").clicked() {
                self.duplicate(cx);
            }
            if ui.button("Frame").on_hover_text("Ctrl G").clicked() {
                self.frame_selected(cx);
            }
            if ui.button("Delete").clicked() {
                self.delete(cx);
            }
        }
    }

    fn add(&mut self, ui: &mut Ui, cx: &mut Context<'_>, at: Pos2) {
        if let Some(name) = add_menu(ui, cx, &mut self.search) {
            self.places.insert(GraphItem::Node(&name).id(), at);
            self.selected = BTreeSet::from([name]);
        }
    }

    /// The links that there are, and the one on the pointer.
    fn links(&self, ui: &Ui, model: &Model, sockets: &Sockets) -> Vec<Shape> {
        let color = ui.visuals().widgets.inactive.fg_stroke.color;
        let mut shapes = Vec::new();
        for (material, end) in &sockets.sides {
            if let Some(&start) = sockets.surfaces.get(material) {
                shapes.push(curve(
                    start,
                    *end,
                    Stroke::new(1.0, color.gamma_multiply(0.5)),
                ));
            }
        }
        for wire in &model.wires {
            let source = OutputSocket {
                node: wire.source.clone(),
                swizzle: wire.swizzle,
            };
            let start = sockets.output(&source);
            let end = sockets.inputs.get(&wire.target);
            let is_off = (self.loose.as_ref())
                .is_some_and(|loose| loose.former.as_ref() == Some(&wire.target));
            if let (Some(&start), Some(&end), false) = (start, end, is_off)
                && ui.is_rect_visible(Rect::from_two_pos(start, end).expand2(vec2(BEND, 0.0)))
            {
                shapes.push(curve(start, end, Stroke::new(2.0, color)));
                let is_several = !sockets.outputs.contains_key(&source);
                if let (Some(swizzle), true) = (wire.swizzle, is_several) {
                    shapes.push(note(ui, start.lerp(end, 0.5), &swizzle.to_string()));
                }
            }
        }
        if let Some(loose) = &self.loose
            && let Some(&start) = sockets.output(&loose.source)
            && let Some(end) = pointer(ui)
        {
            let color = ui.visuals().selection.bg_fill;
            shapes.push(curve(start, end, Stroke::new(2.0, color)));
        }
        shapes
    }

    /// Connects the link on the pointer where it was let go, or says why not.
    fn drop_loose(&mut self, ui: &Ui, cx: &mut Context<'_>, sockets: &Sockets) {
        let Some(loose) = &self.loose else {
            return;
        };
        let near = pointer(ui).and_then(|pointer| {
            let distance = |place: &Pos2| place.distance(pointer);
            let inputs = sockets.inputs.iter();
            let near = inputs.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)))?;
            (distance(near.1) < REACH).then(|| near.0.as_ref().clone())
        });
        let OutputSocket { node, swizzle } = &loose.source;
        // The socket that it hangs on may be out of sight by now, and not tell that it was let go.
        let is_dropped = sockets.is_dropped || ui.input(|input| !input.pointer.any_down());
        if !is_dropped {
            if let Some(target) = &near
                && let Err(why) = cx.model.check(node, *swizzle, target)
            {
                let error = egui::RichText::new(why).color(ui.visuals().error_fg_color);
                egui::Tooltip::always_open(
                    ui.ctx().clone(),
                    ui.layer_id(),
                    ui.scope_id().with("refused"),
                    egui::PopupAnchor::Pointer,
                )
                .show(|ui| ui.label(error));
            }
            return;
        }
        let taken_off = |target: &Target| edits::disconnect(cx.document, target);
        match (near, &loose.former) {
            (Some(target), former) if former.as_ref() != Some(&target) => {
                let connected = edits::connect(cx.model, node, *swizzle, &target).map(|edits| {
                    let off = former.as_ref().map(taken_off).unwrap_or_default();
                    off.into_iter().chain(edits).collect()
                });
                cx.edit_if(&format!("connect {node}"), connected);
            }
            (None, Some(former)) => {
                let edits = taken_off(former);
                cx.edit(&format!("disconnect {node}"), edits, None);
            }
            _ => {}
        }
        self.loose = None;
    }

    /// Clicks beside all cards.
    fn background(&mut self, cx: &mut Context<'_>, plane: &Response) {
        if plane.secondary_clicked()
            && let Some(at) = plane.interact_pointer_pos()
        {
            self.menu_at = at;
        }
        let at = self.menu_at;
        context_menu(plane, |ui| self.add(ui, cx, at));
        if plane.clicked() {
            self.selected.clear();
        }
    }

    fn keys(&mut self, ui: &Ui, cx: &mut Context<'_>) {
        let pressed = |modifiers, key| ui.input_mut(|input| input.consume_key(modifiers, key));
        if pressed(Modifiers::NONE, Key::Delete) || pressed(Modifiers::NONE, Key::Backspace) {
            self.delete(cx);
        }
        if pressed(Modifiers::COMMAND, Key::D) {
            self.duplicate(cx);
        }
        if pressed(Modifiers::COMMAND, Key::G) {
            self.frame_selected(cx);
        }
    }

    fn delete(&mut self, cx: &mut Context<'_>) {
        let nodes: Vec<String> = std::mem::take(&mut self.selected).into_iter().collect();
        if !nodes.is_empty() {
            let edits = edits::remove_nodes(cx.document, cx.model, &nodes);
            cx.edit(&format!("delete {}", nodes.join(", ")), edits, None);
        }
    }

    fn duplicate(&mut self, cx: &mut Context<'_>) {
        let nodes: Vec<String> = self.selected.iter().cloned().collect();
        if nodes.is_empty() {
            return;
        }
        let (copies, edits) = edits::duplicate(cx.document, cx.model, &nodes);
        for (node, copy) in nodes.iter().zip(&copies) {
            if let Some(&place) = self.places.get(&GraphItem::Node(node).id()) {
                let place = place + vec2(30.0, 30.0);
                self.places.insert(GraphItem::Node(copy).id(), place);
            }
        }
        self.selected = copies.into_iter().collect();
        cx.edit(&format!("duplicate {}", nodes.join(", ")), edits, None);
    }
}

/// Where the pointer is on the plane.
fn pointer(ui: &Ui) -> Option<Pos2> {
    let at = ui.input(|input| input.pointer.latest_pos())?;
    let to_plane = ui.ctx().layer_transform_from_global(ui.layer_id());
    Some(to_plane.map_or(at, |to_plane| to_plane * at))
}

fn curve(start: Pos2, end: Pos2, stroke: Stroke) -> Shape {
    let reach = vec2((0.5 * (end.x - start.x).abs()).clamp(24.0, BEND), 0.0);
    let points = [start, start + reach, end - reach, end];
    CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke).into()
}

/// A few letters at the middle of a link.
fn note(ui: &Ui, at: Pos2, text: &str) -> Shape {
    let font = egui::FontId::proportional(11.0);
    let color = ui.visuals().strong_text_color();
    let line = (ui.painter()).layout_no_wrap(text.to_owned(), font, color);
    let place = egui::Align2::CENTER_CENTER.anchor_size(at, line.size());
    let back = Shape::rect_filled(place.expand(2.0), 2.0, ui.visuals().extreme_bg_color);
    Shape::Vec(vec![back, Shape::galley(place.min, line, color)])
}
