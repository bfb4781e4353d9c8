//! Environment and ambient occlusion, as rows of widgets.

use egui::{CollapsingHeader, Ui};
use engine::scene::look::{AoDirection, AoLook, AoSettings, MAX_AO, Section, Value, color};
use engine::session::{Edit, written};
use texgen::Widget;

use crate::context::Context;
use crate::environments::picker;
use crate::widgets::{
    Bounds, FileRequest, Purpose, Spec, choice, draft, edit_steady, name, named_from, row,
};

/// A number of the environment: key, label, slider, bounds, unit, and what it is without the key.
struct Number {
    key: &'static str,
    label: &'static str,
    range: (f32, f32),
    bounds: (f32, f32),
    unit: &'static str,
    otherwise: f32,
}

const INTENSITY: Number = Number {
    key: "intensity",
    label: "Intensity",
    range: (0.0, 10.0),
    bounds: (0.0, f32::MAX),
    unit: "",
    otherwise: 1.0,
};

const ROTATION: Number = Number {
    key: "rotation",
    label: "Rotation",
    range: (-180.0, 180.0),
    bounds: (f32::MIN, f32::MAX),
    unit: "°",
    otherwise: 0.0,
};

const SKY: [Number; 5] = [
    Number {
        key: "sky.sun_elevation",
        label: "Sun elevation",
        range: (-20.0, 90.0),
        bounds: (-90.0, 90.0),
        unit: "°",
        otherwise: 35.0,
    },
    Number {
        key: "sky.sun_azimuth",
        label: "Sun azimuth",
        range: (0.0, 360.0),
        bounds: (-360.0, 360.0),
        unit: "°",
        otherwise: 0.0,
    },
    Number {
        key: "sky.aerosol",
        label: "Aerosol",
        range: (0.0, 10.0),
        bounds: (0.0, 100.0),
        unit: "",
        otherwise: 1.0,
    },
    Number {
        key: "sky.altitude",
        label: "Altitude",
        range: (0.0, 5000.0),
        bounds: (0.0, 50_000.0),
        unit: "m",
        otherwise: 0.0,
    },
    Number {
        key: "sky.sun_size",
        label: "Sun size",
        range: (0.0, 10.0),
        bounds: (0.0, 90.0),
        unit: "°",
        otherwise: 0.545,
    },
];

/// Light from infinitely far away.
pub(crate) fn environment(ui: &mut Ui, cx: &mut Context<'_>) {
    let section = Section::Environment;
    CollapsingHeader::new("Environment").show(ui, |ui| {
        let has = |cx: &Context<'_>, key: &str| cx.document.value(&section, key).is_some();
        if has(cx, "color") {
            environment_color(ui, cx);
            environment_number(ui, cx, &INTENSITY);
        } else if has(cx, "image") {
            environment_image(ui, cx);
            environment_number(ui, cx, &ROTATION);
            environment_number(ui, cx, &INTENSITY);
        } else if has(cx, "sky") {
            for number in &SKY {
                environment_number(ui, cx, number);
            }
            environment_sun(ui, cx);
            environment_number(ui, cx, &INTENSITY);
        } else {
            ui.weak("that of the scene");
        }
        ui.horizontal_wrapped(|ui| environment_kinds(ui, cx));
    });
}

fn environment_color(ui: &mut Ui, cx: &mut Context<'_>) {
    let written_value = cx.document.value(&Section::Environment, "color");
    let shown = (written_value.as_ref()).and_then(|value| color(&value.at(0.0)).ok());
    let label = "Environment colour";
    let spec = Spec {
        name: label.to_owned(),
        range: None,
        bounds: Bounds {
            min: 0.0,
            ..Bounds::ANY
        },
        unit: "",
        widget: Widget::Color,
    };
    let value = texgen::Value::Vec3(shown.unwrap_or_default().to_array());
    let (_, edited) = row(
        ui,
        "Colour",
        "linear radiance from everywhere",
        true,
        |ui| edit_steady(ui, &spec, &value, written_value.as_ref()),
    );
    if let Some(value) = &edited.value {
        let edit = Edit::environment("color", written(value));
        cx.edit(label, vec![edit], Some(&edited.response));
    }
}

fn environment_image(ui: &mut Ui, cx: &mut Context<'_>) {
    let image = cx.document.value(&Section::Environment, "image");
    let Some(Value::Text(path)) = image else {
        return;
    };
    let help = "an equirectangular picture";
    let (_, field) = row(ui, "Image", help, true, |ui| {
        let field = draft(ui, "Environment image", "path of a picture", &path, 160.0);
        picker(ui, cx, "Choose…");
        field
    });
    if let Some(path) = field.value {
        let edit = Edit::environment("image", Value::Text(path));
        cx.edit("Environment image", vec![edit], None);
    }
}

fn environment_number(ui: &mut Ui, cx: &mut Context<'_>, number: &Number) {
    let written_value = cx.document.value(&Section::Environment, number.key);
    let shown = (written_value.as_ref()).and_then(|value| value.at(0.0).as_number());
    let label = format!("{} of the environment", number.label);
    let spec = Spec {
        name: label.clone(),
        range: Some(number.range),
        bounds: Bounds {
            min: number.bounds.0.into(),
            max: number.bounds.1.into(),
        },
        unit: number.unit,
        widget: Widget::Plain,
    };
    let value = texgen::Value::F32(shown.map_or(number.otherwise, |x| x as f32));
    let is_set = written_value.is_some();
    let (whole, edited) = row(ui, number.label, "", is_set, |ui| {
        edit_steady(ui, &spec, &value, written_value.as_ref())
    });
    if let Some(value) = &edited.value {
        let edit = Edit::environment(number.key, written(value));
        cx.edit(&label, vec![edit], Some(&edited.response));
    }
    let clear = Edit::Clear {
        section: Section::Environment,
        key: number.key.to_owned(),
    };
    cx.reset_menu(&whole, is_set, &label, vec![clear]);
}

fn environment_sun(ui: &mut Ui, cx: &mut Context<'_>) {
    let shown = cx.document.value(&Section::Environment, "sky.sun");
    let mut is_there = shown != Some(Value::Bool(false));
    let help = "without it: the sky alone, as in the shadow of a house";
    let (_, switch) = row(ui, "Sun", help, shown.is_some(), |ui| {
        ui.checkbox(&mut is_there, "")
    });
    name(&switch, "Sun of the environment");
    if switch.changed() {
        let edit = Edit::environment("sky.sun", Value::Bool(is_there));
        cx.edit("sun", vec![edit], None);
    }
}

/// What there could be instead.
fn environment_kinds(ui: &mut Ui, cx: &mut Context<'_>) {
    let section = Section::Environment;
    let all = ["color", "image", "sky", "rotation", "intensity"];
    let clear = all
        .into_iter()
        .filter(|key| cx.document.value(&section, key).is_some());
    let clear = clear.map(|key| Edit::Clear {
        section: Section::Environment,
        key: key.to_owned(),
    });
    let clear: Vec<Edit> = clear.collect();
    let other = |key: &str, value| {
        let set = Edit::environment(key, value);
        clear.iter().cloned().chain([set]).collect::<Vec<_>>()
    };
    for (label, key, value) in [
        ("A colour", "color", Value::numbers(&[1.0; 3])),
        ("A sky", "sky", Value::Table(Vec::new())),
    ] {
        let is_chosen = cx.document.value(&section, key).is_some();
        if !is_chosen && ui.button(label).clicked() {
            cx.edit(&format!("environment: {label}"), other(key, value), None);
        }
    }
    if cx.document.value(&section, "image").is_none() {
        picker(ui, cx, "A picture…");
    }
    if let Some(path) = browse_environment(ui, cx) {
        let set = Edit::environment("image", Value::Text(path));
        let is_there = cx.document.value(&section, "image").is_some();
        let edits = match is_there {
            true => vec![set],
            false => clear.iter().cloned().chain([set]).collect(),
        };
        cx.edit("environment: a picture", edits, None);
    }
    let has_any = !cx.document.table(&section).is_empty();
    if has_any && ui.button("That of the scene").clicked() {
        let remove = Edit::Remove { section };
        cx.edit("environment: that of the scene", vec![remove], None);
    }
}

/// A picture of the surroundings, as the look names it, once one has been chosen.
fn browse_environment(ui: &mut Ui, cx: &mut Context<'_>) -> Option<String> {
    let (document, folder) = (cx.document, cx.document.look().resolve(""));
    let request = || FileRequest {
        title: "Picture of the surroundings".to_owned(),
        purpose: Purpose::Open,
        kind: "Pictures of surroundings",
        endings: vec!["hdr", "exr"],
        start: match document.value(&Section::Environment, "image") {
            Some(Value::Text(path)) => folder.join(path),
            _ => folder.join(""),
        },
    };
    let what = "a picture of the surroundings";
    let chosen = cx.browser.button(ui, "Browse ...", what, request)?;
    Some(named_from(&folder, &chosen))
}

/// How ambient occlusion is traced, table by table.
pub(crate) fn occlusion(ui: &mut Ui, cx: &mut Context<'_>) {
    let document = cx.document;
    let tables = &document.look().ao;
    CollapsingHeader::new("Ambient occlusion").show(ui, |ui| {
        for table in tables {
            occlusion_table(ui, cx, table);
        }
        let add = egui::Button::new("Add a table");
        if ui.add_enabled(tables.len() < MAX_AO, add).clicked() {
            let is_taken = |name: &String| tables.iter().any(|table| table.name.value == *name);
            let mut names = (1..).map(|number| format!("ao_{number}"));
            if let Some(free) = names.find(|name| !is_taken(name)) {
                let edits = Edit::ao(&free, &AoSettings::default()).to_vec();
                cx.edit("add AO table", edits, None);
            }
        }
    });
}

fn occlusion_table(ui: &mut Ui, cx: &mut Context<'_>, table: &AoLook) {
    let table_name = &table.name.value;
    let section = || Section::Ao(table_name.clone());
    let settings = &table.settings;
    ui.strong(table_name);
    let numbers = [
        (
            "distance",
            "Distance",
            "how far occlusion reaches",
            texgen::Value::F32(settings.distance),
            (0.001, 10.0),
            // As small as it can be drawn, but not nothing.
            (1e-6, f64::from(f32::MAX)),
            "m",
            Widget::Log,
        ),
        (
            "samples",
            "Samples",
            "rays per hit",
            texgen::Value::U32(settings.samples),
            (1.0, 64.0),
            (1.0, 255.0),
            "",
            Widget::Plain,
        ),
    ];
    for (key, label, help, value, range, (min, max), unit, widget) in numbers {
        let full = format!("{label} of {table_name}");
        let spec = Spec {
            name: full.clone(),
            range: Some(range),
            bounds: Bounds { min, max },
            unit,
            widget,
        };
        let written_value = cx.document.value(&section(), key);
        let is_set = written_value.is_some();
        let (whole, edited) = row(ui, label, help, is_set, |ui| {
            edit_steady(ui, &spec, &value, written_value.as_ref())
        });
        if let Some(value) = &edited.value {
            let edit = Edit::set(section(), key, written(value));
            cx.edit(&full, vec![edit], Some(&edited.response));
        }
        // A table has to say how far it reaches.
        let otherwise = match key {
            "distance" => {
                let distance = AoSettings::default().distance;
                Edit::set(section(), key, Value::number(distance))
            }
            _ => Edit::Clear {
                section: section(),
                key: key.to_owned(),
            },
        };
        cx.reset_menu(&whole, is_set, &full, vec![otherwise]);
    }
    let words = ["outside", "inside", "both"];
    let shown = match settings.direction {
        AoDirection::Outside => words[0],
        AoDirection::Inside => words[1],
        AoDirection::Both => words[2],
    };
    let full = format!("Direction of {table_name}");
    let help = "which side of the surface the rays are sent to";
    let (_, picked) = row(ui, "Direction", help, true, |ui| {
        choice(ui, &full, shown, &words)
    });
    if let Some(word) = picked.value {
        let edit = Edit::set(section(), "direction", Value::Text(word));
        cx.edit(&full, vec![edit], None);
    }
    let full = format!("Same object of {table_name}");
    let mut same = settings.same_object;
    let help = "only the object itself occludes";
    let (_, switch) = row(ui, "Same object", help, true, |ui| {
        ui.checkbox(&mut same, "")
    });
    name(&switch, &full);
    if switch.changed() {
        let edit = Edit::set(section(), "same_object", Value::Bool(same));
        cx.edit(&full, vec![edit], None);
    }
    let button = ui.button("Take table away");
    name(&button, &format!("Take AO table {table_name} away"));
    if button.clicked() {
        let mut edits = vec![Edit::Remove { section: section() }];
        // Nodes that read it read the first one that is left.
        for node in &cx.document.look().nodes {
            for (key, table) in [
                ("occlusion", &node.occlusion),
                ("occlusion1", &node.occlusion1),
            ] {
                if table
                    .as_ref()
                    .is_some_and(|table| table.value == *table_name)
                {
                    edits.push(Edit::reset(&node.name.value, key));
                }
            }
        }
        cx.edit(&format!("take AO table {table_name} away"), edits, None);
    }
}
