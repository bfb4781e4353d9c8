//! How the look has its picture shown, as rows of widgets.

use egui::{CollapsingHeader, Ui};
use engine::scene::look::{Section, Value};
use engine::scene::view::{MAX_EXPOSURE, ViewTransform, WhiteBalance};
use engine::session::{Edit, written};
use texgen::Widget;

use crate::context::Context;
use crate::widgets::{Bounds, Spec, choice, edit_steady, row};

/// Exposure, white balance and view transform.
pub(crate) fn view(ui: &mut Ui, cx: &mut Context<'_>) {
    CollapsingHeader::new("View").show(ui, |ui| {
        transform(ui, cx);
        exposure(ui, cx);
        white_balance(ui, cx);
    });
}

fn transform(ui: &mut Ui, cx: &mut Context<'_>) {
    let shown = cx.document.look().view.transform;
    let words = ViewTransform::ALL.map(ViewTransform::label);
    let label = "View transform of the look";
    let text = shown.map_or("as chosen above", ViewTransform::label);
    let help = "how radiance becomes what a screen shows";
    let (whole, picked) = row(ui, "Transform", help, shown.is_some(), |ui| {
        choice(ui, label, text, &words)
    });
    let mut all = ViewTransform::ALL.into_iter();
    if let Some(view) = picked
        .value
        .and_then(|word| all.find(|view| view.label() == word))
    {
        let value = Value::Text(view.name().to_owned());
        cx.edit(label, vec![Edit::view("transform", value)], None);
    }
    reset(cx, &whole, shown.is_some(), label, "transform");
}

fn exposure(ui: &mut Ui, cx: &mut Context<'_>) {
    let shown = cx.document.look().view.exposure;
    let label = "Exposure of the look";
    let spec = Spec {
        name: label.to_owned(),
        range: Some((-10.0, 10.0)),
        bounds: Bounds {
            min: (-MAX_EXPOSURE).into(),
            max: MAX_EXPOSURE.into(),
        },
        unit: "EV",
        widget: Widget::Plain,
    };
    let value = texgen::Value::F32(shown.unwrap_or(0.0));
    let help = "brightness in stops";
    let written_value = cx.document.value(&Section::View, "exposure");
    let (whole, edited) = row(ui, "Exposure", help, shown.is_some(), |ui| {
        edit_steady(ui, &spec, &value, written_value.as_ref())
    });
    if let Some(value) = &edited.value {
        let edit = Edit::view("exposure", written(value));
        cx.edit(label, vec![edit], Some(&edited.response));
    }
    reset(cx, &whole, shown.is_some(), label, "exposure");
}

fn white_balance(ui: &mut Ui, cx: &mut Context<'_>) {
    let shown = cx.document.look().view.white_balance;
    let is_set = shown.is_some();
    let written_value = cx.document.value(&Section::View, "white_balance");
    let WhiteBalance { temperature, tint } = shown.unwrap_or_default();
    for (label, help, number, range, unit) in [
        (
            "Temperature",
            "of the light that is to look white",
            temperature,
            WhiteBalance::TEMPERATURES,
            "K",
        ),
        (
            "Tint",
            "how far that light is off towards green; daylight is 10",
            tint,
            WhiteBalance::TINTS,
            "",
        ),
    ] {
        let (low, high) = range.into_inner();
        let full = format!("{label} of white");
        let spec = Spec {
            name: full.clone(),
            range: Some((low, high.min(12_000.0))),
            bounds: Bounds {
                min: low.into(),
                max: high.into(),
            },
            unit,
            widget: Widget::Plain,
        };
        let value = texgen::Value::F32(number);
        let (whole, edited) = row(ui, label, help, is_set, |ui| {
            edit_steady(ui, &spec, &value, written_value.as_ref())
        });
        if let Some(texgen::Value::F32(number)) = edited.value {
            let pair = match label {
                "Tint" => [temperature, number],
                _ => [number, tint],
            };
            let edit = Edit::view("white_balance", Value::numbers(&pair));
            cx.edit(&full, vec![edit], Some(&edited.response));
        }
        reset(cx, &whole, is_set, &full, "white_balance");
    }
}

/// A menu that takes a key away, and with the last one the table.
fn reset(cx: &mut Context<'_>, row: &egui::Response, is_set: bool, label: &str, key: &str) {
    let section = Section::View;
    let clear = match cx.document.table(&section).len() <= 1 {
        true => Edit::Remove { section },
        false => Edit::Clear {
            section,
            key: key.to_owned(),
        },
    };
    cx.reset_menu(row, is_set, label, vec![clear]);
}
