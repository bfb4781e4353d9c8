//! The list form: all materials, and what belongs to one as rows of widgets.

use egui::{Button, CollapsingHeader, Response, RichText, ScrollArea, Sense, Ui};
use engine::scene::look::{Section, Value};
use engine::scene::material_parameters::{Unit, Valid};
use engine::session::{Edit, written};
use texgen::Widget;

use crate::context::Context;
use crate::edits;
use crate::links::driven;
use crate::maps::maps;
use crate::material::{InLook as _, Key, PARAMETERS, Takes};
use crate::model::Target;
use crate::pictures::{DraggedMaterial, take_material};
use crate::widgets::{Bounds, Edited, Spec, choice, draft, edit_steady, menu, name, row, scrolled};

/// Points that the list of all materials takes at most.
const ALL_MATERIALS: f32 = 160.0;

/// A material: what it is blended of, what drives it, its constants.
pub(crate) fn material(ui: &mut Ui, cx: &mut Context<'_>, material: &str) {
    let title = format!("Material {material}");
    let header = CollapsingHeader::new(RichText::new(&title).strong())
        .id_salt(&title)
        .default_open(true);
    let shown = header.show(ui, |ui| {
        handle(ui, cx, material);
        if !cx.is_own(material) {
            let label = format!("Name of {title}");
            let help = "what blends call this material";
            let (_, field) = row(ui, "Name", help, true, |ui| {
                draft(ui, &label, "name", material, 180.0)
            });
            if let Some(name) = field.value {
                cx.rename_material(material, name.trim());
            }
        }
        blend(ui, cx, material);
        if cx.model.is_pure_blend(material) {
            return;
        }
        let section = Section::Material(material.to_owned());
        let is_set = |cx: &Context<'_>, key: &Key| cx.document.value(&section, key.key).is_some();
        for key in PARAMETERS.iter().filter(|key| key.is_common) {
            material_key(ui, cx, material, key);
        }
        maps(ui, cx, material);
        // They stay there when they are set, so that a slider isn't lost while it is dragged.
        let is_any = PARAMETERS
            .iter()
            .any(|key| !key.is_common && is_set(cx, key));
        let more = CollapsingHeader::new("More")
            .id_salt((material, "more"))
            .default_open(is_any);
        more.show(ui, |ui| {
            for key in PARAMETERS.iter().filter(|key| !key.is_common) {
                material_key(ui, cx, material, key);
            }
        });
    });
    take_material(ui, cx, material, &shown.header_response);
}

/// All materials, to be shown by a click, and to be dragged onto each other and onto the model.
pub(crate) fn materials(ui: &mut Ui, cx: &mut Context<'_>, shown: Option<&str>) {
    let names = cx.names;
    if names.len() < 2 {
        return;
    }
    let header = CollapsingHeader::new("All materials").default_open(false);
    header.show(ui, |ui| {
        let area = ScrollArea::vertical().max_height(ALL_MATERIALS);
        area.show(ui, |ui| {
            for material in names {
                let is_shown = shown == Some(material);
                let row = Button::selectable(is_shown, material).sense(Sense::click_and_drag());
                let row = ui.add(row);
                name(&row, &format!("Show {material}"));
                row.dnd_set_drag_payload(DraggedMaterial(material.clone()));
                take_material(ui, cx, material, &row);
                if row.clicked() {
                    cx.show_material(material);
                }
                let help = "click to show it; drag it onto the model or another material, which looks like it then";
                row.on_hover_text(help);
            }
        });
    });
}

/// By which a material is dragged onto the model, where there is another one to be had by it.
fn handle(ui: &mut Ui, cx: &Context<'_>, material: &str) {
    if cx.names.len() < 2 {
        return;
    }
    let id = ui.scope_id().with(("drag", material));
    let payload = DraggedMaterial(material.to_owned());
    let dragged = ui.dnd_drag_source(id, payload, |ui| ui.weak("drag onto the model"));
    let help = "what it is dropped on looks like this material, by a blend";
    dragged.response.on_hover_text(help);
}

fn blend(ui: &mut Ui, cx: &mut Context<'_>, material: &str) {
    let section = || Section::Material(material.to_owned());
    let Some([base, over]) = cx.model.sides(material) else {
        let label = format!("Blend {material} with another material");
        let button = menu(ui, "Blend with…", |ui| {
            scrolled(ui, |ui| {
                for other in cx.names {
                    // A material of which this one is a part would close a circle.
                    if cx.model.is_made_of(other, material) {
                        continue;
                    }
                    if ui.button(other).clicked() {
                        let edits = edits::make_blend(material, other);
                        cx.edit("blend", edits, None);
                        ui.close();
                    }
                }
            });
            ui.separator();
            new_material(ui, cx, material);
        });
        name(&button.response, &label);
        return;
    };
    let (base, over) = (base.to_owned(), over.to_owned());
    for (side, key, chosen) in [("Base", "blend.base", &base), ("Over", "blend.over", &over)] {
        let names = cx.names;
        let fits = |other: &&String| {
            let is_itself = key == "blend.base" && other.as_str() == material;
            is_itself || !cx.model.is_made_of(other, material)
        };
        let words: Vec<&str> = names.iter().filter(fits).map(String::as_str).collect();
        let label = format!("{side} of {material}");
        let help = "a material that this one is blended of";
        let (whole, picked) = row(ui, side, help, true, |ui| {
            choice(ui, &label, chosen, &words)
        });
        let dropped = whole.dnd_release_payload::<DraggedMaterial>();
        let dropped = dropped.map(|dragged| dragged.0.clone());
        let fits = |other: &String| words.contains(&other.as_str()) && other != chosen;
        if let Some(other) = picked.value.or(dropped.filter(fits)) {
            let sides = match key {
                "blend.base" => [other.as_str(), &over],
                _ => [&base, other.as_str()],
            };
            let mut edits = cx.remove_unused(material, &sides);
            edits.insert(0, Edit::set(section(), key, Value::Text(other)));
            cx.edit(&label, edits, None);
        }
    }
    let target = Target::Mask {
        material: material.to_owned(),
    };
    let label = format!("Mask of {material}");
    let help = "where it is 1, the upper material is shown, where it is 0 the base";
    let written_value = cx.document.value(&section(), "blend.mask");
    let constant = (written_value.as_ref()).and_then(|value| value.at(0.0).as_number());
    let spec = share(&label);
    driven(ui, cx, &target, "Mask", help, true, |ui, cx| {
        let shown = texgen::Value::F32(constant.unwrap_or(0.0) as f32);
        let edited = edit_steady(ui, &spec, &shown, written_value.as_ref());
        if let Some(value) = &edited.value {
            let edit = Edit::set(section(), "blend.mask", written(value));
            cx.edit(&label, vec![edit], Some(&edited.response));
        }
        edited.response
    });
    let button = ui.button("Take blend away");
    name(&button, &format!("Take blend of {material} away"));
    if button.clicked() {
        let mut edits = cx.remove_unused(material, &[]);
        edits.insert(0, Edit::reset_material(material, "blend"));
        cx.edit("take blend away", edits, None);
    }
}

/// A field for the name of a material that is made to be blended with: without a blend of it, it would be none.
fn new_material(ui: &mut Ui, cx: &mut Context<'_>, material: &str) {
    let label = format!("New material to blend with {material}");
    let field = draft(ui, &label, "name of a new material", "", 180.0);
    let Some(new) = field.value else {
        return;
    };
    let new = new.trim();
    if new.is_empty() || cx.names.iter().any(|other| other == new) {
        let why = format!("there is a material called `{new}` already");
        cx.edit_if("blend", Err(why));
    } else {
        // As it would be without the key, so that there is a table.
        let roughness = Edit::material(new, "roughness", Value::number(0.5));
        let mut edits = edits::make_blend(material, new);
        edits.push(roughness);
        cx.edit(&format!("blend with {new}"), edits, None);
    }
    ui.close();
}

fn share(label: &str) -> Spec<'static> {
    Spec {
        name: label.to_owned(),
        range: Some((0.0, 1.0)),
        bounds: Bounds { min: 0.0, max: 1.0 },
        unit: "",
        widget: Widget::Plain,
    }
}

fn material_key(ui: &mut Ui, cx: &mut Context<'_>, material: &str, key: &Key) {
    let section = Section::Material(material.to_owned());
    let written_value = cx.document.value(&section, key.key);
    let is_set = written_value.is_some();
    let label = format!("{} of {material}", key.label);
    let constant = match &written_value {
        Some(value) if !matches!(value, Value::Text(text) if !text.starts_with('#') && key.output().is_some()) => {
            Some(value.at(0.0))
        }
        _ => key.written(cx.scene_material(material)),
    };
    let widget = |ui: &mut Ui, cx: &mut Context<'_>| {
        let set = |cx: &mut Context<'_>, value: Value, response: Option<&Response>| {
            let edit = Edit::material(material, key.key, value);
            cx.edit(&label, vec![edit], response);
        };
        if let (Takes::Choice(words), Some(Value::Text(word))) = (key.takes, &constant) {
            let Edited { response, value } = choice(ui, &label, word, words);
            if let Some(word) = value {
                set(cx, Value::Text(word), None);
            }
            return response;
        }
        let Some(shown) = constant.as_ref().and_then(|value| key.shown(value)) else {
            let text = match key.takes {
                Takes::Link => "not driven",
                _ => "",
            };
            let response = ui.weak(text);
            name(&response, &label);
            return response;
        };
        let (spec, written_value) = (spec_of(key, &label), written_value.as_ref());
        let Edited { response, value } = edit_steady(ui, &spec, &shown, written_value);
        if let Some(value) = value {
            set(cx, written(&value), Some(&response));
        }
        response
    };
    match key.output() {
        Some(output) => {
            let target = Target::Input {
                material: material.to_owned(),
                output,
            };
            driven(ui, cx, &target, key.label, key.help, is_set, widget);
        }
        None => {
            let (whole, _) = row(ui, key.label, key.help, is_set, |ui| widget(ui, cx));
            let clear = Edit::reset_material(material, key.key);
            cx.reset_menu(&whole, is_set, &label, vec![clear]);
        }
    }
}

fn spec_of(key: &Key, label: &str) -> Spec<'static> {
    let (range, bounds, widget, unit) = match key.takes {
        Takes::Number(number) => {
            let (low, high) = number.slider;
            let widget = match number.is_log {
                true => Widget::Log,
                false => Widget::Plain,
            };
            let bounds = match number.unit {
                Unit::Degrees => Bounds::ANY,
                _ => Bounds {
                    min: low.into(),
                    // Shares end at 1, everything else goes on.
                    max: match number.valid {
                        Valid::Share => 1.0,
                        _ => Bounds::ANY.max,
                    },
                },
            };
            (Some((low, high)), bounds, widget, number.unit.symbol())
        }
        Takes::Whole {
            most,
            slider: (low, high),
        } => {
            let bounds = Bounds {
                min: -f64::from(most),
                max: most.into(),
            };
            (Some((low as f32, high as f32)), bounds, Widget::Plain, "")
        }
        Takes::Color { .. } => {
            let bounds = Bounds {
                min: 0.0,
                ..Bounds::ANY
            };
            (None, bounds, Widget::Color, "")
        }
        Takes::Flag | Takes::Choice(_) | Takes::Link => (None, Bounds::ANY, Widget::Plain, ""),
    };
    Spec {
        name: label.to_owned(),
        range,
        bounds,
        unit,
        widget,
    }
}
