//! A node as rows of widgets: the parameters of its texture, its name, and what is done with it.

use egui::{CollapsingHeader, RichText, Ui};
use engine::scene::look::{Section, Value};
use engine::session::{Edit, written};
use texgen::{BuiltinAttribute, Parameter};

use crate::context::Context;
use crate::edits;
use crate::links::driven;
use crate::model::Target;
use crate::widgets::{Edited, Spec, choice, draft, edit_steady, image_slot, name, row};

/// A node: its texture's parameters.
pub(crate) fn node(ui: &mut Ui, cx: &mut Context<'_>, node: &str, is_open: bool) {
    let textures = cx.textures;
    let Some(table) = cx.model.table(cx.document.look(), node) else {
        return;
    };
    let texture_name = table.texture.value.clone();
    let is_wanted = cx.wanted.as_deref() == Some(node);
    let title = RichText::new(format!("Node {node}")).strong();
    let header = CollapsingHeader::new(title)
        .id_salt(("node", node))
        .default_open(is_open)
        .open(is_wanted.then_some(true));
    let shown = header.show(ui, |ui| {
        let Some(texture) = textures.library.get(&texture_name) else {
            let broken = textures
                .broken
                .iter()
                .any(|(name, _)| *name == texture_name);
            let text = match broken {
                true => format!("the texture `{texture_name}` has mistakes"),
                false => format!("there is no texture called `{texture_name}`"),
            };
            ui.colored_label(ui.visuals().error_fg_color, text);
            return;
        };
        ui.horizontal(|ui| {
            if cx.previews.is_some() {
                let size = egui::vec2(48.0, 48.0);
                let (place, _) = ui.allocate_exact_size(size, egui::Sense::hover());
                cx.paint_preview(ui, node, place);
            }
            let first = texture.docs().split(". ").next().unwrap_or_default();
            // A panel grows with what is in it: a long sentence would take half of the window.
            let docs = egui::RichText::new(format!("{texture_name}: {first}")).weak();
            let docs = ui.add(egui::Label::new(docs).truncate());
            docs.on_hover_text(texture.docs());
        });
        for parameter in texture.parameters() {
            node_parameter(ui, cx, node, parameter);
        }
        for (key, attribute, otherwise) in [
            ("occlusion", BuiltinAttribute::AO, 0),
            ("occlusion1", BuiltinAttribute::AO1, 1),
        ] {
            if texture.attributes().contains(&attribute.into()) {
                occlusion(ui, cx, node, key, otherwise);
            }
        }
        ui.horizontal(|ui| node_buttons(ui, cx, node));
    });
    if is_wanted {
        shown.header_response.scroll_to_me(Some(egui::Align::TOP));
    }
}

fn node_buttons(ui: &mut Ui, cx: &mut Context<'_>, node: &str) {
    ui.label("Name");
    rename_field(ui, cx, node);
    let nodes = [node.to_owned()];
    let duplicate = ui.button("Duplicate");
    name(&duplicate, &format!("Duplicate {node}"));
    if duplicate.clicked() {
        let (_, edits) = edits::duplicate(cx.document, cx.model, &nodes);
        cx.edit(&format!("duplicate {node}"), edits, None);
    }
    let delete = ui.button("Delete");
    name(&delete, &format!("Delete {node}"));
    if delete.clicked() {
        let edits = edits::remove_nodes(cx.document, cx.model, &nodes);
        cx.edit(&format!("delete {node}"), edits, None);
    }
}

/// A field with a node's name, for another one. Gives whether one was written.
pub(crate) fn rename_field(ui: &mut Ui, cx: &mut Context<'_>, node: &str) -> bool {
    let field = draft(ui, &format!("Name of {node}"), "name", node, 140.0);
    field.response.on_hover_text("what links call this node");
    let is_written = field.value.is_some();
    if let Some(name) = field.value {
        cx.rename_node(node, name.trim());
    }
    is_written
}

/// One parameter of a node.
pub(crate) fn node_parameter(ui: &mut Ui, cx: &mut Context<'_>, node: &str, parameter: &Parameter) {
    let section = Section::Node(node.to_owned());
    let written_value = cx.document.value(&section, &parameter.name);
    let is_set = written_value.is_some();
    let full = format!("{} of {node}", parameter.name);
    let target = Target::Parameter {
        node: node.to_owned(),
        parameter: parameter.name.clone(),
    };
    let Some(id) = cx.model.graph.node(node) else {
        return;
    };
    let value = cx.model.graph.value(id, &parameter.name).cloned();
    let attribute = cx.model.graph.attribute(id, &parameter.name);
    let attribute = attribute.map(|attribute| attribute.name().to_owned());
    let widget = |ui: &mut Ui, cx: &mut Context<'_>| {
        let Edited { response, value } = match &value {
            Some(value) if attribute.is_some() => {
                let name = attribute.as_deref().unwrap_or_default();
                let response = ui.button(format!("attribute {name}"));
                let response = response.on_hover_text("a click gives it a constant of its own");
                let value = response.clicked().then(|| written(value));
                Edited { response, value }
            }
            Some(value) => {
                let spec = Spec::of(parameter, full.clone());
                let written_value = written_value.as_ref();
                let Edited { response, value } = edit_steady(ui, &spec, value, written_value);
                let value = value.as_ref().map(written);
                Edited { response, value }
            }
            None => {
                let folder = cx.document.look().resolve("");
                let written = written_value.as_ref();
                let (slots, browser) = (&mut *cx.images, &mut *cx.browser);
                let model = cx.scene.images;
                image_slot(ui, slots, browser, &full, &folder, model, written)
            }
        };
        if let Some(value) = value {
            let edit = Edit::set(section.clone(), &parameter.name, value);
            cx.edit(&full, vec![edit], Some(&response));
        }
        response
    };
    let help = help_of(parameter);
    if parameter.ty.is_linkable() {
        return driven(
            ui,
            cx,
            &target,
            short_label(parameter),
            &help,
            is_set,
            widget,
        );
    }
    let (whole, _) = row(ui, short_label(parameter), &help, is_set, |ui| {
        widget(ui, cx)
    });
    let clear = Edit::reset(node, &parameter.name);
    cx.reset_menu(&whole, is_set, &full, vec![clear]);
}

/// What a parameter is called in the panel: as its texture calls it, unless that is a whole sentence.
pub(crate) fn short_label(parameter: &Parameter) -> &str {
    match parameter.label.chars().count() {
        0..=24 => &parameter.label,
        _ => &parameter.name,
    }
}

/// What a tooltip says about a parameter.
fn help_of(parameter: &Parameter) -> String {
    let mut help = format!("{}\n{}", parameter.label, parameter.ty);
    if let Some((low, high)) = parameter.range {
        help += &format!(", {low} to {high}");
    }
    if let Some(unit) = &parameter.unit {
        help += &format!(" {unit}");
    }
    if let Some(attribute) = &parameter.attribute {
        return help + &format!("\nwithout a link: attribute {attribute}");
    }
    match &parameter.default {
        Some(texgen::Value::Ramp(_) | texgen::Value::Array(_)) | None => {}
        Some(default) => help += &format!("\ndefault: {}", value_text(default)),
    }
    help
}

fn value_text(value: &texgen::Value) -> String {
    use texgen::Value as V;
    match value {
        V::F32(x) => x.to_string(),
        V::I32(x) => x.to_string(),
        V::U32(x) | V::Image(x) => x.to_string(),
        V::Bool(x) => x.to_string(),
        V::Vec2(x) => format!("{x:?}"),
        V::Vec3(x) => format!("{x:?}"),
        V::Vec4(x) => format!("{x:?}"),
        V::Mat3(_) | V::Mat4(_) | V::Ramp(_) | V::Array(_) => String::new(),
    }
}

/// Which AO table a node reads.
fn occlusion(ui: &mut Ui, cx: &mut Context<'_>, node: &str, key: &str, otherwise: usize) {
    let tables = &cx.document.look().ao;
    if tables.is_empty() {
        return;
    }
    let words: Vec<&str> = tables
        .iter()
        .map(|table| table.name.value.as_str())
        .collect();
    let section = Section::Node(node.to_owned());
    let written_value = cx.document.value(&section, key);
    let is_set = written_value.is_some();
    let shown = match &written_value {
        Some(Value::Text(table)) => table.as_str(),
        _ => words[otherwise.min(words.len() - 1)],
    };
    let full = format!("{key} of {node}");
    let help = "which of the tables of ambient occlusion the texture reads";
    let (whole, picked) = row(ui, key, help, is_set, |ui| choice(ui, &full, shown, &words));
    if let Some(table) = picked.value {
        let edit = Edit::set(section, key, Value::Text(table));
        cx.edit(&full, vec![edit], None);
    }
    cx.reset_menu(&whole, is_set, &full, vec![Edit::reset(node, key)]);
}
