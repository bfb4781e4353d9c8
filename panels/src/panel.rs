//! The textures panel: what belongs to one material, as a list or as a graph.
//!
//! What is shown is read from the [`Document`] and not changed meanwhile; edits are collected, and made when all has
//! been shown.

use std::rc::Rc;

use egui::{Color32, Key, Modifiers, Rect, Response, ScrollArea, Ui, pos2};
use engine::live::Edit;
use engine::scene::Material;
use engine::scene::look::Value;

use crate::graph::GraphView;
use crate::model::Model;
use crate::preview::Previews;
use crate::widgets::{self, ImageSlot};
use crate::{Document, Textures, edits, light, list};

/// What the panel needs to know about the scene that is shown.
#[derive(Debug, Clone, Copy)]
pub struct SceneView<'a> {
    /// Materials as they are shown, constants of the look included.
    pub materials: &'a [Material],
}

/// How a material is shown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Form {
    /// As rows of widgets.
    #[default]
    List,
    /// As a graph, with the widgets of the selected node below.
    Graph,
}

/// The textures panel.
#[derive(Debug, Default)]
pub struct TexturesPanel {
    material: Option<String>,
    form: Form,
    /// Why the last edit was refused.
    message: Option<String>,
    model: Option<Rc<Model>>,
    images: ImageSlot,
    previews: Option<Previews>,
    graph: GraphView,
    /// What is looked for among the textures.
    search: String,
    /// The name of a material to be made.
    new_material: String,
}

impl TexturesPanel {
    /// Shows a material, as when it was clicked in the picture.
    pub fn pick(&mut self, material: &str) {
        self.material = Some(material.to_owned());
    }

    /// The material that is shown.
    pub fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    /// Why the last edit was refused, if it was.
    pub fn message(&self) -> Option<&str> {
        self.message.as_deref()
    }

    /// Shows pictures of nodes from now on.
    pub fn set_previews(&mut self, previews: Previews) {
        self.previews = Some(previews);
    }

    /// The form in which the material is shown.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Shows the material in another form.
    pub fn set_form(&mut self, form: Form) {
        self.form = form;
    }

    /// Where the cards of the graph stand, by their ids: to be kept until the next start.
    pub fn places(&self) -> impl Iterator<Item = (&str, [f32; 2])> {
        self.graph.places()
    }

    /// Puts the cards of the graph where they were.
    pub fn set_places(&mut self, places: impl IntoIterator<Item = (String, [f32; 2])>) {
        self.graph.set_places(places);
    }

    /// Shows the panel. Edits are made in `document`; [`Document::take_changes`] tells the renderer.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        document: &mut Document,
        textures: &Textures,
        scene: SceneView<'_>,
    ) {
        shortcuts(ui, document);
        self.head(ui, document, scene);
        let model = self.model(document, textures);
        let mut cx = Context {
            document,
            model: &model,
            textures,
            scene,
            images: &mut self.images,
            previews: self.previews.as_mut(),
            actions: Vec::new(),
        };
        match self.form {
            Form::List => {
                let material = self.material.as_deref();
                let (search, new_material) = (&mut self.search, &mut self.new_material);
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    list_form(ui, &mut cx, material, search);
                    light::occlusion(ui, &mut cx);
                    light::environment(ui, &mut cx);
                    add_material(ui, &mut cx, new_material);
                });
            }
            Form::Graph => {
                let family = self.material.as_deref();
                let family = family.map_or(Vec::new(), |material| model.family(material));
                graph_form(ui, &mut cx, &family, &mut self.graph);
            }
        }
        for action in cx.actions {
            self.make(document, action);
        }
        // A drag ends where the button is let go.
        if ui.input(|input| input.pointer.any_released()) {
            document.end_group();
        }
    }

    fn model(&mut self, document: &Document, textures: &Textures) -> Rc<Model> {
        let known = self.model.take();
        let known = known.filter(|model| model.is_of(document, &textures.library));
        let model = known.unwrap_or_else(|| Rc::new(Model::new(document, &textures.library)));
        self.model = Some(Rc::clone(&model));
        model
    }

    fn make(&mut self, document: &mut Document, action: Action) {
        match action {
            Action::Edit {
                label,
                edits,
                group,
            } => self.message = document.apply(&label, &edits, group).err(),
            Action::Refused(why) => self.message = Some(why),
        }
    }

    /// Which material, in which form, and back and forth in the history.
    fn head(&mut self, ui: &mut Ui, document: &mut Document, scene: SceneView<'_>) {
        ui.horizontal_wrapped(|ui| {
            let names = material_names(document, scene);
            if self.material.is_none() {
                self.material = names.first().cloned();
            }
            let words: Vec<&str> = names.iter().map(String::as_str).collect();
            let shown = self.material.as_deref().unwrap_or("no material");
            if let Some(picked) = widgets::choice(ui, "Material", shown, &words).value {
                self.material = Some(picked);
            }
            for (form, text) in [(Form::List, "List"), (Form::Graph, "Graph")] {
                ui.selectable_value(&mut self.form, form, text);
            }
            ui.separator();
            let undo = history_button(ui, "Undo", document.undo_label());
            let redo = history_button(ui, "Redo", document.redo_label());
            if undo {
                document.undo();
            }
            if redo {
                document.redo();
            }
            if undo || redo {
                self.message = None;
            }
        });
        let mut is_read = false;
        if let Some(message) = &self.message {
            ui.horizontal_wrapped(|ui| {
                ui.colored_label(ui.visuals().error_fg_color, message);
                is_read = ui.small_button("×").clicked();
            });
        }
        if is_read {
            self.message = None;
        }
        ui.separator();
    }
}

fn history_button(ui: &mut Ui, text: &str, label: Option<&str>) -> bool {
    let button = ui.add_enabled(label.is_some(), egui::Button::new(text));
    let clicked = button.clicked();
    if let Some(label) = label {
        button.on_hover_text(label);
    }
    clicked
}

/// Undo and redo by keys, unless a text is being written, which has an undo of its own.
fn shortcuts(ui: &mut Ui, document: &mut Document) {
    if ui.text_edit_focused() {
        return;
    }
    let again = Modifiers::COMMAND | Modifiers::SHIFT;
    let pressed = |modifiers, key| ui.input_mut(|input| input.consume_key(modifiers, key));
    if pressed(again, Key::Z) || pressed(Modifiers::COMMAND, Key::Y) {
        document.redo();
    } else if pressed(Modifiers::COMMAND, Key::Z) {
        document.undo();
    }
}

/// A material with all that it is made of, and what no material needs.
fn list_form(ui: &mut Ui, cx: &mut Context<'_>, material: Option<&str>, search: &mut String) {
    let model = cx.model;
    let family = material.map_or(Vec::new(), |material| model.family(material));
    for material in &family {
        list::material(ui, cx, material);
    }
    for node in model.nodes_of(&family) {
        list::node(ui, cx, &node);
    }
    let loose = model.loose_nodes(cx.document.look());
    if !loose.is_empty() {
        ui.weak("Nodes that no material needs");
        for node in loose {
            list::node(ui, cx, &node);
        }
    }
    let add = ui.menu_button("Add a node…", |ui| add_menu(ui, cx, search));
    widgets::name(&add.response, "Add a node");
}

/// The graph, and below it the widgets of the node that is selected.
fn graph_form(ui: &mut Ui, cx: &mut Context<'_>, family: &[&str], graph: &mut GraphView) {
    let height = ui.available_height();
    let share = match graph.selected() {
        Some(_) => 0.6,
        None => 1.0,
    };
    let size = egui::vec2(ui.available_width(), (share * height).max(100.0));
    let layout = *ui.layout();
    ui.allocate_ui_with_layout(size, layout, |ui| graph.show(ui, cx, family));
    if let Some(node) = graph.selected().map(str::to_owned) {
        ui.separator();
        ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| list::node(ui, cx, &node));
    }
}

/// The library, narrowed down by what is looked for. Gives the name of a node that was added.
pub(crate) fn add_menu(ui: &mut Ui, cx: &mut Context<'_>, search: &mut String) -> Option<String> {
    let field = egui::TextEdit::singleline(search).hint_text("search");
    let field = ui.add(field);
    widgets::name(&field, "Search textures");
    let wanted = search.to_lowercase();
    let textures = cx.textures.library.textures().iter();
    let mut found: Vec<_> = textures
        .filter(|texture| {
            texture.name().to_lowercase().contains(&wanted)
                || texture.docs().to_lowercase().contains(&wanted)
        })
        .collect();
    // What is called so comes before what only mentions it.
    found.sort_by_key(|texture| !texture.name().to_lowercase().contains(&wanted));
    let by_enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
    let mut added = None;
    for (i, texture) in found.iter().enumerate() {
        let entry = ui.button(texture.name());
        let is_chosen = entry.clicked() || (i == 0 && by_enter && !wanted.is_empty());
        entry.on_hover_text(texture.docs());
        if is_chosen && added.is_none() {
            let (name, edits) = edits::add_node(cx.document, texture.name());
            cx.edit(&format!("add {name}"), edits, None);
            added = Some(name);
            ui.close();
        }
    }
    if found.is_empty() {
        ui.weak("no texture is called so");
    }
    for (name, problems) in &cx.textures.broken {
        let entry = ui.add_enabled(false, egui::Button::new(name));
        entry.on_disabled_hover_text(crate::document::messages(problems));
    }
    if added.is_some() {
        search.clear();
    }
    added
}

fn add_material(ui: &mut Ui, cx: &mut Context<'_>, name: &mut String) {
    ui.horizontal(|ui| {
        let field = egui::TextEdit::singleline(name).hint_text("name of a new material");
        let field = ui.add(field.desired_width(160.0));
        widgets::name(&field, "Name of a new material");
        let is_new = !name.is_empty() && !cx.material_names().contains(name);
        let button = ui.add_enabled(is_new, egui::Button::new("Add material"));
        if button.clicked() {
            // As it would be without the key, so that there is a table.
            let roughness = Edit::material(name, "roughness", Value::number(0.5));
            cx.edit(&format!("add material {name}"), vec![roughness], None);
            name.clear();
        }
    });
}

/// Those of the scene, then those that only the look has.
fn material_names(document: &Document, scene: SceneView<'_>) -> Vec<String> {
    let mut names: Vec<String> = scene.materials.iter().map(|m| m.name.clone()).collect();
    for material in &document.look().materials {
        if !names.contains(&material.name.value) {
            names.push(material.name.value.clone());
        }
    }
    names
}

/// Something to be done once all has been shown.
#[derive(Debug)]
pub(crate) enum Action {
    Edit {
        label: String,
        edits: Vec<Edit>,
        group: Option<u64>,
    },
    Refused(String),
}

/// What the parts of the panel show, and what they want done.
pub(crate) struct Context<'a> {
    pub(crate) document: &'a Document,
    pub(crate) model: &'a Model,
    pub(crate) textures: &'a Textures,
    pub(crate) scene: SceneView<'a>,
    pub(crate) images: &'a mut ImageSlot,
    pub(crate) previews: Option<&'a mut Previews>,
    pub(crate) actions: Vec<Action>,
}

impl<'a> Context<'a> {
    /// Makes some edits as one step. Those of one widget that follow each other, as in a drag, are one step too.
    pub(crate) fn edit(&mut self, label: &str, edits: Vec<Edit>, widget: Option<&Response>) {
        self.actions.push(Action::Edit {
            label: label.to_owned(),
            edits,
            group: widget.map(|response| response.id.value()),
        });
    }

    /// Makes some edits, or says why not.
    pub(crate) fn edit_if(&mut self, label: &str, edits: Result<Vec<Edit>, String>) {
        match edits {
            Ok(edits) => self.edit(label, edits, None),
            Err(why) => self.actions.push(Action::Refused(why)),
        }
    }

    /// A menu by right click on a row that takes back what was set.
    pub(crate) fn reset_menu(
        &mut self,
        row: &Response,
        is_set: bool,
        label: &str,
        edits: Vec<Edit>,
    ) {
        row.container_context_menu(|ui| {
            let reset = ui.add_enabled(is_set, egui::Button::new("Reset"));
            if reset.clicked() {
                self.edit(&format!("reset {label}"), edits, None);
                ui.close();
            }
        });
    }

    /// Paints the picture of a node, where there is one; says why where there is none.
    pub(crate) fn paint_preview(&mut self, ui: &mut Ui, node: &str, place: Rect) {
        let Some(previews) = &mut self.previews else {
            return;
        };
        if !ui.is_rect_visible(place) {
            return;
        }
        let (document, textures, model) = (self.document, self.textures, self.model);
        let (texture, error) = previews.picture(ui.ctx(), document, textures, model, node);
        if let Some(texture) = texture {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter()
                .image(texture.id(), place, whole, Color32::WHITE);
        }
        if let Some(error) = error {
            let color = ui.visuals().error_fg_color;
            let stroke = egui::Stroke::new(1.0, color);
            ui.painter()
                .rect_stroke(place, 2.0, stroke, egui::StrokeKind::Inside);
            let id = ui.scope_id().with(("preview", node));
            ui.interact(place, id, egui::Sense::hover())
                .on_hover_text(error);
        }
    }

    /// Those of the scene, then those that only the look has.
    pub(crate) fn material_names(&self) -> Vec<String> {
        material_names(self.document, self.scene)
    }

    /// A material as it is shown.
    pub(crate) fn scene_material(&self, name: &str) -> Option<&'a Material> {
        let mut materials = self.scene.materials.iter();
        materials.find(|material| material.name == name)
    }
}
