//! The graph form: the nodes of a material as cards with sockets, and links between them.
//!
//! The look doesn't say where cards stand; that is a matter of the view.

mod card;
mod drop;
mod focus;
mod frames;
mod free;
mod layout;
mod place;
mod rows;
mod select;
mod wires;

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use egui::{DragPanButtons, Key, LayerId, Modifiers, Pos2, Rect, Response, Scene, Shape, Ui, vec2};
use texgen::Swizzle;

use crate::context::Context;
use crate::edits;
use crate::library::add_menu;
use crate::model::Target;
use crate::widgets::{context_menu, menu, name};

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
