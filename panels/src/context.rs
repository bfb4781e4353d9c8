//! What the parts of the panel see while they are shown, and what they want done.

use std::collections::HashSet;
use std::sync::LazyLock;

use egui::{Color32, Rect, Response, Ui, pos2};
use engine::scene::Material;
use engine::session::{Document, Edit};

use crate::Textures;
use crate::edits;
use crate::model::{Model, Target};
use crate::preview::Previews;
use crate::rename::Renaming;
use crate::scene_view::{Placing, SceneView};
use crate::widgets::{Browser, ImageSlot, row_menu};

/// Those of the scene, then those that only the look has.
pub(crate) fn material_names(document: &Document, scene: SceneView<'_>) -> Vec<String> {
    let own: HashSet<&str> = own_names(scene).collect();
    let tables = document.look().materials.iter();
    let of_look = tables.map(|material| material.name.value.as_str());
    let added = of_look.filter(|name| !own.contains(name));
    own_names(scene).chain(added).map(str::to_owned).collect()
}

/// Materials of the scene's files.
pub(crate) fn own_names<'a>(scene: SceneView<'a>) -> impl Iterator<Item = &'a str> + use<'a> {
    let own = scene.materials.iter().take(scene.own);
    own.map(|material| material.name.as_str())
}

/// Something to be done once all has been shown.
#[derive(Debug)]
pub(crate) enum Action {
    Edit {
        label: String,
        edits: Vec<Edit>,
        group: Option<u64>,
    },
    Rename(Renaming),
    /// A node is to be seen.
    Show(String),
    /// A material is to be shown.
    ShowMaterial(String),
    /// The next click into the picture is for a light.
    PlaceLight(String, Placing),
    Refused(String),
}

/// What the parts of the panel show, and what they want done.
pub(crate) struct Context<'a> {
    pub(crate) document: &'a Document,
    pub(crate) model: &'a Model,
    pub(crate) textures: &'a Textures,
    pub(crate) scene: SceneView<'a>,
    /// Materials of the scene, then those that only the look has.
    pub(crate) names: &'a [String],
    pub(crate) images: &'a mut ImageSlot,
    pub(crate) browser: &'a mut Browser,
    pub(crate) previews: Option<&'a mut Previews>,
    /// A node that is to be scrolled to.
    pub(crate) wanted: Option<String>,
    pub(crate) actions: Vec<Action>,
}

impl<'a> Context<'a> {
    /// Makes some edits as one step. Those of one widget that follow each other while a button or a key is held, as in a drag, are one step
    /// too.
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

    /// A material and all that it is blended of; nothing of none.
    pub(crate) fn family<'m>(&self, material: Option<&'m str>) -> Vec<&'m str>
    where
        'a: 'm,
    {
        material.map_or(Vec::new(), |material| self.model.family(material))
    }

    /// Gives a node another name, and all links with it.
    pub(crate) fn rename_node(&mut self, node: &str, name: &str) {
        let renaming = Renaming::of_node(self.document, self.model, node, name);
        self.actions
            .push(renaming.map_or_else(Action::Refused, Action::Rename));
    }

    /// Gives a material that only the look has another name, and all blends of it.
    pub(crate) fn rename_material(&mut self, material: &str, name: &str) {
        let own = own_names(self.scene);
        let renaming = Renaming::of_material(self.document, self.model, material, name, own);
        self.actions
            .push(renaming.map_or_else(Action::Refused, Action::Rename));
    }

    /// Gives a frame of the graph another title.
    pub(crate) fn rename_frame(&mut self, frame: &str, name: &str) {
        let renaming = Renaming::of_frame(self.document, frame, name);
        self.actions
            .push(renaming.map_or_else(Action::Refused, Action::Rename));
    }

    /// A new node of a texture drives something, or it is said why it can't. Gives its name.
    pub(crate) fn add_linked(&mut self, texture: &str, target: &Target) -> Option<String> {
        match edits::add_linked(self.document, self.textures, texture, target) {
            Ok((node, edits)) => {
                self.edit(&format!("add {node}"), edits, None);
                Some(node)
            }
            Err(why) => {
                self.actions.push(Action::Refused(why));
                None
            }
        }
    }

    /// Shows a material.
    pub(crate) fn show_material(&mut self, material: &str) {
        self.actions.push(Action::ShowMaterial(material.to_owned()));
    }

    /// Brings a node into view.
    pub(crate) fn show_node(&mut self, node: &str) {
        self.actions.push(Action::Show(node.to_owned()));
    }

    /// Whether a material is one of the scene's files.
    pub(crate) fn is_own(&self, material: &str) -> bool {
        own_names(self.scene).any(|own| own == material)
    }

    /// Has a light placed by the next click into the picture.
    pub(crate) fn place_light(&mut self, light: &str, placing: Placing) {
        let action = Action::PlaceLight(light.to_owned(), placing);
        self.actions.push(action);
    }

    /// Takes away the materials that nothing uses any more once `material` is a blend of `sides`.
    pub(crate) fn remove_unused(&self, material: &str, sides: &[&str]) -> Vec<Edit> {
        let is_own = |name: &str| self.is_own(name);
        edits::remove_unused(self.document, self.model, is_own, material, sides)
    }

    /// A menu by right click on a row that takes back what was set.
    pub(crate) fn reset_menu(
        &mut self,
        row: &Response,
        is_set: bool,
        label: &str,
        edits: Vec<Edit>,
    ) {
        row_menu(row, |ui| {
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
        let images = self.scene.images;
        let (texture, error) = previews.picture(ui.ctx(), document, textures, images, model, node);
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

    /// A material as it is shown. One that has only just been added is not known to the scene yet.
    pub(crate) fn scene_material(&self, name: &str) -> &'a Material {
        static ADDED: LazyLock<Material> = LazyLock::new(|| Material {
            metallic: 0.0,
            roughness: 0.5,
            ..Material::default()
        });
        let mut materials = self.scene.materials.iter();
        let known = materials.find(|material| material.name == name);
        known.unwrap_or_else(|| &ADDED)
    }
}
