//! Rows and menus of what nodes may drive: which node does, and which components of its result.

use egui::{Response, Ui};
use texgen::SwizzleError;

use crate::context::Context;
use crate::edits;
use crate::library::take_texture;
use crate::model::{Target, Wire};
use crate::widgets::{draft, menu, name, row, row_menu, scrolled};

/// A row of something that a node may drive: the link where one does, else a widget for the constant.
pub(crate) fn driven(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    target: &Target,
    label: &str,
    help: &str,
    is_set: bool,
    constant: impl FnOnce(&mut Ui, &mut Context<'_>) -> Response,
) {
    let wire = cx.model.source(target).cloned();
    let full = target_name(target, label);
    let (whole, _) = row(ui, label, help, is_set, |ui| match &wire {
        None => constant(ui, cx),
        Some(wire) => {
            let text = edits::link(&wire.source, wire.swizzle);
            let link = ui.link(text).on_hover_text("show this node");
            name(&link, &full);
            if link.clicked() {
                cx.show_node(&wire.source);
            }
            let button = ui.small_button("×").on_hover_text("disconnect");
            name(&button, &format!("Disconnect {full}"));
            if button.clicked() {
                let edits = edits::disconnect(cx.document, target);
                cx.edit(&format!("disconnect {full}"), edits, None);
            }
            link
        }
    });
    take_texture(ui, cx, &whole, target);
    row_menu(&whole, |ui| {
        link_menu(ui, cx, target, &full, is_set, "Reset")
    });
}

/// The menu by right click of something that a node may drive; `clear` is what taking away is called.
pub(crate) fn link_menu(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    target: &Target,
    full: &str,
    is_set: bool,
    clear: &str,
) {
    let taken = ui.add_enabled(is_set, egui::Button::new(clear));
    if taken.clicked() {
        let edits = edits::disconnect(cx.document, target);
        cx.edit(&format!("{} {full}", clear.to_lowercase()), edits, None);
        ui.close();
    }
    menu(ui, "Connect", |ui| connect_menu(ui, cx, target, full));
    if let Some(wire) = cx.model.source(target).cloned() {
        menu(ui, "Components", |ui| components_menu(ui, cx, &wire, full));
    }
}

/// Which components of a node's result a link takes: those that are usual, and a field for any others.
fn components_menu(ui: &mut Ui, cx: &mut Context<'_>, wire: &Wire, full: &str) {
    let mut wanted = None;
    for swizzle in cx.model.swizzles(&wire.source, &wire.target) {
        let text = swizzle.map_or("all".to_owned(), |swizzle| swizzle.to_string());
        if ui.selectable_label(swizzle == wire.swizzle, text).clicked() {
            wanted = Some(Ok(swizzle));
        }
    }
    let current = wire.swizzle.map_or(String::new(), |s| s.to_string());
    let label = format!("Components of {full}");
    let field = draft(
        ui,
        &label,
        "such as xyz",
        current.trim_start_matches('.'),
        80.0,
    );
    if let Some(text) = field.value {
        wanted = Some(match text.trim() {
            "" => Ok(None),
            text => text
                .parse()
                .map(Some)
                .map_err(|e: SwizzleError| e.to_string()),
        });
    }
    if let Some(swizzle) = wanted {
        let connected =
            swizzle.and_then(|s| edits::connect(cx.model, &wire.source, s, &wire.target));
        cx.edit_if(&format!("components of {full}"), connected);
        ui.close();
    }
}

fn connect_menu(ui: &mut Ui, cx: &mut Context<'_>, target: &Target, full: &str) {
    let fitting = cx.model.fitting(target);
    if fitting.is_empty() {
        ui.weak("no node fits");
    }
    scrolled(ui, |ui| {
        for (node, swizzle) in fitting {
            if ui.button(edits::link(&node, swizzle)).clicked() {
                let connected = edits::connect(cx.model, &node, swizzle, target);
                cx.edit_if(&format!("connect {full}"), connected);
                ui.close();
            }
        }
    });
}

/// By which a target is found.
pub(crate) fn target_name(target: &Target, label: &str) -> String {
    match target {
        Target::Parameter { node, parameter } => format!("{parameter} of {node}"),
        Target::Input { material, .. } | Target::Mask { material } => {
            format!("{label} of {material}")
        }
    }
}
