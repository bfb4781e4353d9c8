//! What the tables and keys of a look mean: one function per table.
//!
//! Names of materials, textures, parameters and files are not checked here, nor is any file opened. Names that the
//! look itself declares (nodes, AO tables) are.

use std::collections::HashSet;
use std::path::Path;

use glam::{Affine3A, EulerRot, Quat, Vec3};
use texgen::{Diagnostics, SourceFile, did_you_mean};
use toml_edit::Document;

use crate::view::ViewChoice;

use super::document::Section;
use super::frame::{FrameLook, frame};
use super::keys;
use super::lamp::light;
use super::light::{environment, environment_group};
use super::material::{MaterialLook, material};
use super::reader::{LONGEST_NAME, Reader, choice, is_name, unquoted};
use super::value::{Field, Span, Spanned, Value, fields, find};
use super::view::view;
use super::{
    AoDirection, AoLook, AoSettings, CameraLook, EnvironmentLook, Include, Input, KEYS, LightLook,
    Look, MAX_AO, MaterialxLook, NodeLook,
};

/// A look larger than this is not one.
pub(super) const MAX_BYTES: usize = 16 << 20;

pub(super) fn parse(path: &Path, text: &str, seconds: f64) -> (Look, Reader) {
    let file = SourceFile::new("look", path.display().to_string(), text);
    let mut reader = Reader::new(file.clone());
    let mut look = Look::empty(path, file);
    if text.len() > MAX_BYTES {
        reader.problem(&(0..0), "a look file of more than 16 MiB is not read");
        return (look, reader);
    }
    match Document::parse(text) {
        Ok(document) => whole(
            &mut reader,
            &mut look,
            fields(document.as_table(), text.len()),
            seconds,
        ),
        Err(error) => {
            let span = error.span().unwrap_or(text.len()..text.len());
            reader.problem(
                &span,
                format!("not valid TOML: {}", error.message().trim_end()),
            );
        }
    }
    (look, reader)
}

/// Reads all tables as they are after so many seconds.
fn whole(reader: &mut Reader, look: &mut Look, written: Vec<Field>, seconds: f64) {
    let Some(times) = keys::find(&written, reader) else {
        return;
    };
    if times.is_empty() {
        root(reader, look, &written);
        return check_names(reader, look);
    }
    let mut now = written.clone();
    keys::resolve(&mut now, seconds);
    root(reader, look, &now);
    check_names(reader, look);
    match keys::parts(&written) {
        Ok(parts) => {
            for part in parts {
                for &seconds in &part.times {
                    if !reader.problems.is_empty() {
                        break;
                    }
                    let mut other = Look::empty(&look.path, look.file.clone());
                    root(reader, &mut other, &[part.at(seconds)]);
                }
            }
            keep_keys(look, &written);
        }
        Err((span, problem)) => reader.problem(&span, problem),
    }
    look.key_times = Some([
        times.iter().copied().fold(f64::INFINITY, f64::min),
        times.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    ]);
}

/// Gives nodes the values of their parameters at all keys, which are understood when textures are known.
fn keep_keys(look: &mut Look, written: &[Field]) {
    let Some(Value::Table(tables)) = find(written, "node").map(|nodes| &nodes.value) else {
        return;
    };
    // They are in the order of the tables.
    let mut nodes = look.nodes.iter_mut();
    for Field { key, value } in tables {
        let node = nodes.find(|node| node.name.value == key.value);
        if let (Some(node), Value::Table(parameters)) = (node, &value.value) {
            node.keyed.extend(parameters.iter().flat_map(keys::values));
        }
    }
}

fn root(reader: &mut Reader, look: &mut Look, root: &[Field]) {
    for Field { key, value } in root {
        match key.value.as_str() {
            "environment" => {
                look.environment = environment(reader, value);
                look.environment_group = environment_group(reader, value);
            }
            "camera" => look.camera = camera(reader, value),
            "view" => look.view = view(reader, value),
            "light" => look.lights = named(reader, value, "[light.NAME]", light),
            "ao" => look.ao = named(reader, value, "[ao.NAME]", ao),
            "node" => look.nodes = named(reader, value, "[node.NAME]", node),
            "material" => look.materials = named(reader, value, "[material.NAME]", material),
            "graph" => look.frames = named(reader, value, "[graph.NAME]", frame),
            "materialx" => look.materialx = tables(reader, value, "[[materialx]]", materialx),
            "include" => look.includes = tables(reader, value, "[[include]]", include),
            _ => reader.unknown_key(key, "a look", &KEYS),
        }
    }
    if let Some(extra) = look.ao.get(MAX_AO) {
        reader.problem_with_note(
            &extra.name.span,
            format!("a look can have at most {MAX_AO} [ao.NAME] tables"),
            "let nodes share one: several may name the same table in `occlusion`",
        );
        look.ao.truncate(MAX_AO);
    }
}

/// All tables of a text with their places; none where it is no TOML.
pub fn placed_fields(text: &str) -> Vec<Field> {
    Document::parse(text).map_or(Vec::new(), |document| {
        fields(document.as_table(), text.len())
    })
}

/// One table of a look, read alone. Names of nodes and AO tables in it are not checked.
///
/// # Errors
/// All mistakes of the table.
pub fn table(
    file: &SourceFile,
    section: &Section,
    fields: &[Field],
    span: &Span,
) -> Result<Table, Diagnostics> {
    let mut reader = Reader::new(file.clone());
    // Where a look is edited, time stands still.
    let mut fields = fields.to_vec();
    keys::resolve(&mut fields, 0.0);
    let fields = &*fields;
    let whole = || Spanned::new(Value::Table(fields.to_vec()), span.clone());
    let named = |name: &str| Spanned::new(name.to_owned(), span.clone());
    let read = match section {
        Section::Environment => {
            environment(&mut reader, &whole()).map(|e| Table::Environment(e.value))
        }
        Section::Camera => Some(Table::Camera(camera(&mut reader, &whole()))),
        Section::View => Some(Table::View(view(&mut reader, &whole()))),
        Section::Light(name) => {
            light(&mut reader, &named(name), fields, span).map(|l| Table::Light(Box::new(l)))
        }
        Section::Ao(name) => {
            ao(&mut reader, &named(name), fields, span).map(|ao| Table::Ao(ao.settings))
        }
        Section::Node(name) => node(&mut reader, &named(name), fields, span).map(Table::Node),
        Section::Material(name) => {
            material(&mut reader, &named(name), fields, span).map(|m| Table::Material(Box::new(m)))
        }
        Section::Frame(name) => frame(&mut reader, &named(name), fields, span).map(Table::Frame),
    };
    match read {
        Some(table) if reader.problems.is_empty() => Ok(table),
        _ => Err(reader.problems.in_order()),
    }
}

/// What [`table`] read.
#[derive(Debug)]
pub enum Table {
    /// `environment`.
    Environment(EnvironmentLook),
    /// `[camera]`.
    Camera(CameraLook),
    /// `[view]`.
    View(ViewChoice),
    /// `[light.NAME]`.
    Light(Box<LightLook>),
    /// `[ao.NAME]`.
    Ao(AoSettings),
    /// `[node.NAME]`.
    Node(NodeLook),
    /// `[material.NAME]`.
    Material(Box<MaterialLook>),
    /// `[graph.NAME]`.
    Frame(FrameLook),
}

/// Reads a table of tables, as `[node.a]` and `[node.b]` make.
fn named<T>(
    reader: &mut Reader,
    value: &Spanned<Value>,
    header: &str,
    read: impl Fn(&mut Reader, &Spanned<String>, &[Field], &Span) -> Option<T>,
) -> Vec<T> {
    let Some(tables) = reader.table(value, &format!("tables headed {header}")) else {
        return Vec::new();
    };
    let mut out = Vec::new();
    for Field { key, value } in tables {
        let Value::Table(fields) = &value.value else {
            reader.problem_with_note(
                &key.span,
                format!(
                    "expected a table headed {header}, found {}",
                    value.value.kind()
                ),
                "a name is missing between the header and this key",
            );
            continue;
        };
        out.extend(read(reader, key, fields, &value.span));
    }
    out
}

fn camera(reader: &mut Reader, value: &Spanned<Value>) -> CameraLook {
    const KEYS: [&str; 11] = [
        "name",
        "position",
        "look_at",
        "up",
        "y_fov",
        "aperture_radius",
        "f_number",
        "sensor_height",
        "blades",
        "blade_rotation",
        "focus_distance",
    ];
    let mut camera = CameraLook::default();
    let mut has_f_number = None;
    let Some(table) = reader.table(value, "a table headed [camera]") else {
        return camera;
    };
    for Field { key, value } in table {
        match key.value.as_str() {
            "name" => camera.name = reader.text(value),
            "position" => camera.position = reader.vec3(value),
            "look_at" => camera.look_at = reader.vec3(value),
            "up" => camera.up = reader.vec3(value),
            "y_fov" => {
                camera.y_fov =
                    reader.number(value, "degrees greater than 0 and less than 180", |x| {
                        x > 0.0 && x < 180.0
                    });
            }
            "aperture_radius" => {
                camera.aperture_radius = reader.number(value, "metres, not negative", |x| x >= 0.0);
            }
            "f_number" => {
                camera.f_number = reader.number(value, "greater than 0", |x| x > 0.0);
                has_f_number = Some(&value.span);
            }
            "sensor_height" => {
                camera.sensor_height = reader.number(value, "metres greater than 0", |x| x > 0.0);
            }
            "blades" => match value.value {
                Value::Integer(n @ (0 | 3..=32)) => camera.blades = Some(n as u32),
                _ => reader.problem(
                    &value.span,
                    "expected a whole number from 3 to 32, or 0 for a disk",
                ),
            },
            "blade_rotation" => camera.blade_rotation = reader.number(value, "degrees", |_| true),
            "focus_distance" => {
                camera.focus_distance = reader.number(value, "metres greater than 0", |x| x > 0.0);
            }
            _ => reader.unknown_key(key, "[camera]", &KEYS),
        }
    }
    if let (Some(span), true) = (has_f_number, camera.aperture_radius.is_some()) {
        reader.problem(
            span,
            "`f_number` and `aperture_radius` both give the size of the aperture: leave out one of them",
        );
    }
    if let Some(up) = &camera.up
        && up.value.length_squared() < 1e-12
    {
        reader.problem(
            &up.span,
            "`up` has no direction: at least one number must not be 0",
        );
    }
    camera
}

fn ao(reader: &mut Reader, name: &Spanned<String>, table: &[Field], span: &Span) -> Option<AoLook> {
    const KEYS: [&str; 4] = ["distance", "direction", "samples", "same_object"];
    check_name(reader, name, "an AO table");
    let mut settings = AoSettings::default();
    let mut has_distance = false;
    for Field { key, value } in table {
        match key.value.as_str() {
            "distance" => {
                has_distance = true;
                let distance = reader.number(value, "metres greater than 0", |x| x > 0.0);
                settings.distance = distance.map_or(settings.distance, |d| d.value);
            }
            "direction" => {
                const DIRECTIONS: [(&str, AoDirection); 3] = [
                    ("outside", AoDirection::Outside),
                    ("inside", AoDirection::Inside),
                    ("both", AoDirection::Both),
                ];
                let direction = choice(reader, value, &DIRECTIONS);
                settings.direction = direction.map_or(settings.direction, |d| d.value);
            }
            "samples" => match value.value {
                Value::Integer(n @ 1..=255) => settings.samples = n as u32,
                _ => reader.problem(&value.span, "expected a whole number from 1 to 255"),
            },
            "same_object" => settings.same_object = reader.bool(value).is_some_and(|b| b.value),
            _ => reader.unknown_key(key, "[ao.NAME]", &KEYS),
        }
    }
    if !has_distance {
        reader.problem_with_note(
            span,
            format!("[ao.{}] needs `distance`", name.value),
            "how far occlusion reaches, in metres, as in distance = 0.1",
        );
    }
    Some(AoLook {
        name: name.clone(),
        settings,
    })
}

fn node(
    reader: &mut Reader,
    name: &Spanned<String>,
    table: &[Field],
    span: &Span,
) -> Option<NodeLook> {
    check_name(reader, name, "a node");
    let (mut texture, mut occlusion, mut occlusion1) = (None, None, None);
    let mut params = Vec::new();
    for field in table {
        match field.key.value.as_str() {
            "texture" => texture = reader.text(&field.value),
            "occlusion" => occlusion = reader.text(&field.value),
            "occlusion1" => occlusion1 = reader.text(&field.value),
            _ => params.push(field.clone()),
        }
    }
    if texture.is_none() && !table.iter().any(|f| f.key.value == "texture") {
        reader.problem_with_note(
            span,
            format!("[node.{}] needs `texture`", name.value),
            "the name of a .wgsl file of the textures directory, as in texture = \"fbm\"",
        );
    }
    Some(NodeLook {
        name: name.clone(),
        texture: texture?,
        occlusion,
        occlusion1,
        params,
        keyed: Vec::new(),
    })
}

/// Reads a list of tables under such a header.
fn tables<T>(
    reader: &mut Reader,
    value: &Spanned<Value>,
    header: &str,
    read: impl Fn(&mut Reader, &Spanned<Value>) -> Option<T>,
) -> Vec<T> {
    let Value::List(tables) = &value.value else {
        reader.problem_with_note(
            &value.span,
            format!("expected tables headed {header}"),
            "two brackets: there can be several",
        );
        return Vec::new();
    };
    tables
        .iter()
        .filter_map(|table| read(reader, table))
        .collect()
}

fn materialx(reader: &mut Reader, value: &Spanned<Value>) -> Option<MaterialxLook> {
    const KEYS: [&str; 4] = ["file", "material", "name", "drafts"];
    let table = reader.table(value, "a table headed [[materialx]]")?;
    let (mut file, mut material, mut name, mut drafts) = (None, None, None, None);
    for Field { key, value } in table {
        match key.value.as_str() {
            "file" => file = reader.text(value),
            "material" => material = reader.text(value),
            "name" => name = reader.text(value),
            "drafts" => drafts = reader.bool(value),
            _ => reader.unknown_key(key, "[[materialx]]", &KEYS),
        }
    }
    if !table.iter().any(|field| field.key.value == "file") {
        reader.problem_with_note(
            &value.span,
            "[[materialx]] needs `file`",
            "the path of a document, as in file = \"brass.mtlx\"",
        );
    }
    Some(MaterialxLook {
        file: file?,
        material,
        name,
        drafts: drafts.is_some_and(|drafts| drafts.value),
    })
}

fn include(reader: &mut Reader, value: &Spanned<Value>) -> Option<Include> {
    const KEYS: [&str; 6] = ["file", "name", "only", "translation", "rotation", "scale"];
    let table = reader.table(value, "a table headed [[include]]")?;
    let (mut file, mut name, mut only) = (None, None, None);
    let (mut translation, mut rotation, mut scale) = (Vec3::ZERO, Quat::IDENTITY, Vec3::ONE);
    for Field { key, value } in table {
        match key.value.as_str() {
            "file" => file = reader.text(value),
            "name" => name = reader.text(value),
            "only" => match &value.value {
                Value::List(names) => {
                    only = Some(names.iter().filter_map(|n| reader.text(n)).collect())
                }
                other => {
                    let found = other.kind();
                    reader.problem(
                        &value.span,
                        format!("expected a list of node names, found {found}"),
                    );
                }
            },
            "translation" => translation = reader.vec3(value).map_or(translation, |t| t.value),
            "rotation" => rotation = self::rotation(reader, value).unwrap_or(rotation),
            "scale" => scale = self::scale(reader, value).unwrap_or(scale),
            _ => reader.unknown_key(key, "[[include]]", &KEYS),
        }
    }
    if !table.iter().any(|f| f.key.value == "file") {
        reader.problem(
            &value.span,
            "[[include]] needs `file`, the path of a .gltf or .glb file",
        );
    }
    Some(Include {
        file: file?,
        name,
        only,
        transform: Affine3A::from_scale_rotation_translation(scale, rotation, translation),
    })
}

/// Three angles in degrees about the fixed X, then Y, then Z axis, or a quaternion x, y, z, w as in glTF.
fn rotation(reader: &mut Reader, value: &Spanned<Value>) -> Option<Quat> {
    if matches!(&value.value, Value::List(list) if list.len() == 4) {
        let q = reader.numbers::<4>(value, "a quaternion")?;
        let q = Quat::from_array(q.value);
        if q.length() < 1e-6 {
            reader.problem(&value.span, "a quaternion of length 0 is not a rotation");
            return None;
        }
        return Some(q.normalize());
    }
    let wanted = "three angles in degrees about X, Y and Z, or a quaternion [x, y, z, w]";
    let [x, y, z] = reader
        .numbers::<3>(value, wanted)?
        .value
        .map(f32::to_radians);
    Some(Quat::from_euler(EulerRot::ZYX, z, y, x))
}

/// One factor for all axes, or one for each.
fn scale(reader: &mut Reader, value: &Spanned<Value>) -> Option<Vec3> {
    let scale = match value.value {
        Value::List(_) => reader.vec3(value)?.value,
        _ => Vec3::splat(
            reader
                .number(value, "a number or three numbers", |_| true)?
                .value,
        ),
    };
    // A smaller scale can't be inverted in single precision.
    if scale.abs().min_element() < 1e-9 {
        reader.problem(&value.span, "a scale of 0 would flatten what is included");
        return None;
    }
    Some(scale)
}

fn check_name(reader: &mut Reader, name: &Spanned<String>, what: &str) {
    if name.value.len() > LONGEST_NAME {
        reader.problem_with_note(
            &name.span,
            format!("the name of {what} is too long: {LONGEST_NAME} bytes at most"),
            "it may become part of the names of channels, and OpenEXR files hold no longer ones; choose a shorter one",
        );
        return;
    }
    if !is_name(&name.value) {
        reader.problem(
            &name.span,
            format!(
                "`{}` can't name {what}: use letters, digits, `_` and `-`",
                name.value
            ),
        );
    }
}

/// Links and `occlusion` must refer to what the look declares.
fn check_names(reader: &mut Reader, look: &Look) {
    let names = Names::of(look.ao.iter().map(|a| a.name.value.as_str()));
    for node in &look.nodes {
        for wanted in [&node.occlusion, &node.occlusion1].into_iter().flatten() {
            unknown_name(reader, wanted, "AO table", "[ao.NAME]", &names);
        }
    }
    // Names of nodes that come from documents are known when these are read.
    if !look.materialx.is_empty() {
        return;
    }
    let names = Names::of(look.nodes.iter().map(|n| n.name.value.as_str()));
    for material in &look.materials {
        let mask = material.blend.as_ref().map(|b| &b.value.mask);
        for input in material.inputs().chain(mask) {
            if let Input::Link(link) = &input.value {
                let wanted = input.with(link.node.clone());
                unknown_name(reader, &wanted, "node", "[node.NAME]", &names);
            }
        }
    }
}

/// Names that a look declares, in its order and by themselves.
struct Names<'n> {
    in_order: Vec<&'n str>,
    known: HashSet<&'n str>,
}

impl<'n> Names<'n> {
    fn of(names: impl Iterator<Item = &'n str>) -> Self {
        let in_order: Vec<_> = names.collect();
        let known = in_order.iter().copied().collect();
        Self { in_order, known }
    }
}

fn unknown_name(
    reader: &mut Reader,
    wanted: &Spanned<String>,
    what: &str,
    header: &str,
    names: &Names<'_>,
) {
    if names.known.contains(wanted.value.as_str()) {
        return;
    }
    let message = format!("there is no {what} called `{}`", wanted.value);
    let near = || did_you_mean(&wanted.value, names.in_order.iter().copied());
    let near = reader.suggests().then(near).flatten();
    let note = match (unquoted(&wanted.value), near) {
        (Some(remedy), _) => remedy,
        (None, Some(near)) => format!("did you mean `{near}`?"),
        (None, None) => format!("declare it with {header}"),
    };
    reader.problem_with_note(&wanted.span, message, note);
}
