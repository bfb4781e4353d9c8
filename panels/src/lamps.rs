//! Lights with a place or a direction: those of the scene's files and the look's own, as rows of widgets.

use std::f32::consts::PI;

use egui::{CollapsingHeader, Ui};
use engine::scene::look::{Aim, LampKind, LightLook, Section, Value};
use engine::scene::{Camera, LightKind, PunctualLight};
use engine::session::{Document, Edit, written};
use glam::Vec3;
use texgen::Widget;

use crate::context::Context;
use crate::scene_view::{Placing, SceneView};
use crate::widgets::{Bounds, Spec, draft, edit_steady, menu, name, row};

/// With more lights than that each is folded at first.
const MAX_OPEN: usize = 3;
/// Metres to what a camera that isn't focused on anything looks at.
const DISTANCE: f32 = 2.0;

/// A light as it is shown: of the scene's files, of the look, or both.
struct Lamp<'a> {
    name: &'a str,
    given: Option<&'a PunctualLight>,
    look: Option<&'a LightLook>,
}

impl Lamp<'_> {
    fn section(&self) -> Section {
        Section::Light(self.name.to_owned())
    }

    fn kind(&self) -> LampKind {
        let own = self.look.and_then(|look| look.kind.as_ref());
        match (own, self.given.map(|light| light.kind)) {
            (Some(kind), _) => kind.value,
            (None, Some(LightKind::Spot { .. })) => LampKind::Spot,
            (None, Some(LightKind::Directional | LightKind::Disk { .. })) => LampKind::Directional,
            (None, Some(LightKind::Point) | None) => LampKind::Point,
        }
    }

    /// Whether it is the look that has it.
    fn is_own(&self) -> bool {
        self.look.is_some_and(|look| look.kind.is_some())
    }

    fn position(&self) -> Vec3 {
        let written = self.look.and_then(|look| look.position.as_ref());
        match (written, self.given) {
            (Some(position), _) => position.value,
            (None, Some(light)) => light.position,
            (None, None) => Vec3::ZERO,
        }
    }
}

/// All lights, and a menu to add one.
pub(crate) fn lights(ui: &mut Ui, cx: &mut Context<'_>) {
    let (document, scene) = (cx.document, cx.scene);
    let lamps = lamps(document, scene);
    let header = CollapsingHeader::new("Lights").id_salt("lights");
    header.show(ui, |ui| {
        for shown in &lamps {
            let title = format!("{} ({})", shown.name, shown.kind().word());
            let header = CollapsingHeader::new(title)
                .id_salt(("light", shown.name))
                .default_open(lamps.len() <= MAX_OPEN);
            header.show(ui, |ui| lamp(ui, cx, shown));
        }
        let add = menu(ui, "Add a light…", |ui| {
            for (kind, text) in [
                (LampKind::Area, "Area: a rectangle with soft shadows"),
                (LampKind::Spot, "Spot: a cone"),
                (LampKind::Point, "Point"),
                (LampKind::Directional, "Directional: as the sun"),
            ] {
                if ui.button(text).clicked() {
                    let (name, edits) = added(document, scene, kind);
                    cx.edit(&format!("add {name}"), edits, None);
                    ui.close();
                }
            }
        });
        name(&add.response, "Add a light");
    });
}

fn lamps<'a>(document: &'a Document, scene: SceneView<'a>) -> Vec<Lamp<'a>> {
    let looks = &document.look().lights;
    let mut lamps: Vec<Lamp<'_>> = Vec::new();
    let names = (scene.lights.iter().map(|light| light.name.as_str()))
        .chain(looks.iter().map(|light| light.name.value.as_str()));
    for name in names {
        if !lamps.iter().any(|lamp| lamp.name == name) {
            lamps.push(Lamp {
                name,
                given: scene.lights.iter().find(|light| light.name == name),
                look: looks.iter().find(|light| light.name.value == name),
            });
        }
    }
    lamps
}

fn lamp(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>) {
    let kind = lamp.kind();
    switch(ui, cx, lamp);
    let shown = |read: fn(&LightLook) -> Option<f32>| lamp.look.and_then(read);
    let most = lamp.given.map(|light| light.intensity.max_element());
    let intensity = shown(|look| look.intensity.as_ref().map(|x| x.value));
    let unit = match kind {
        LampKind::Directional => "W/m²",
        _ => "W/sr",
    };
    let number = Number {
        key: "intensity",
        label: "Intensity",
        help: "of the brightest channel; of a rectangle along its axis",
        slider: (0.01, 10_000.0),
        bounds: (0.0, f32::MAX),
        unit,
        widget: Widget::Log,
    };
    self::number(ui, cx, lamp, &number, intensity.or(most).unwrap_or(10.0));
    color(ui, cx, lamp);
    if kind != LampKind::Directional {
        let value = lamp.position();
        vector(ui, cx, lamp, "position", "Position", value);
    }
    let aim = lamp.look.and_then(|look| look.aim.as_ref());
    match (kind, aim.map(|aim| aim.value)) {
        (LampKind::Point, _) => {}
        (_, Some(Aim::At(point))) => vector(ui, cx, lamp, "look_at", "Shines at", point),
        (_, Some(Aim::Direction(to))) => vector(ui, cx, lamp, "direction", "Direction", to),
        (_, None) => {
            let to = lamp.given.map_or(Vec3::NEG_Y, |light| light.direction);
            vector(ui, cx, lamp, "direction", "Direction", to);
        }
    }
    if kind == LampKind::Area {
        let value = lamp.look.and_then(|look| look.size.as_ref());
        size(ui, cx, lamp, value.map_or([0.5, 0.5], |size| size.value));
    }
    if let LampKind::Spot = kind {
        let given = match lamp.given.map(|light| light.kind) {
            Some(LightKind::Spot {
                inner_angle,
                outer_angle,
            }) => [inner_angle.to_degrees(), outer_angle.to_degrees()],
            _ => [0.0, 45.0],
        };
        let inner = shown(|look| look.inner_cone_angle.as_ref().map(|x| x.value));
        let outer = shown(|look| look.outer_cone_angle.as_ref().map(|x| x.value));
        for (key, label, help, value, least) in [
            (
                "inner_cone_angle",
                "Inner angle",
                "from the axis: within it all of the intensity",
                inner.unwrap_or(given[0]),
                0.0,
            ),
            (
                "outer_cone_angle",
                "Outer angle",
                "from the axis: beyond it nothing",
                outer.unwrap_or(given[1]),
                0.1,
            ),
        ] {
            let number = Number {
                key,
                label,
                help,
                slider: (least, 90.0),
                bounds: (least, 90.0),
                unit: "°",
                widget: Widget::Plain,
            };
            self::number(ui, cx, lamp, &number, value);
        }
    }
    if kind == LampKind::Directional {
        let number = Number {
            key: "angular_diameter",
            label: "Size",
            help: "how large the light is in the sky; the sun is 0.53°",
            slider: (0.0, 10.0),
            bounds: (0.0, 90.0),
            unit: "°",
            widget: Widget::Plain,
        };
        let written = shown(|look| look.angular_diameter.as_ref().map(|x| x.value));
        let given = match lamp.given.map(|light| light.kind) {
            Some(LightKind::Disk { angular_diameter }) => angular_diameter.to_degrees(),
            _ => 0.0,
        };
        self::number(ui, cx, lamp, &number, written.unwrap_or(given));
    }
    group(ui, cx, lamp);
    buttons(ui, cx, lamp);
}

fn switch(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>) {
    let written = lamp.look.and_then(|look| look.on);
    let mut is_on = written.unwrap_or(true);
    let (whole, switch) = row(ui, "On", "", written.is_some(), |ui| {
        ui.checkbox(&mut is_on, "")
    });
    name(&switch, &format!("{} is on", lamp.name));
    let label = format!("turn {} {}", lamp.name, if is_on { "on" } else { "off" });
    if switch.changed() {
        // As it would be without the key.
        let edit = match is_on && lamp.look.is_some_and(|look| look.on == Some(false)) {
            true => clear(cx, lamp, "on"),
            false => Edit::set(lamp.section(), "on", Value::Bool(is_on)),
        };
        cx.edit(&label, vec![edit], None);
    }
    let reset = clear(cx, lamp, "on");
    cx.reset_menu(&whole, written.is_some(), &label, vec![reset]);
}

struct Number {
    key: &'static str,
    label: &'static str,
    help: &'static str,
    slider: (f32, f32),
    bounds: (f32, f32),
    unit: &'static str,
    widget: Widget,
}

fn number(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>, number: &Number, shown: f32) {
    let spec = Spec {
        name: format!("{} of {}", number.label, lamp.name),
        range: Some(number.slider),
        bounds: Bounds {
            min: number.bounds.0.into(),
            max: number.bounds.1.into(),
        },
        unit: number.unit,
        widget: number.widget,
    };
    let value = texgen::Value::F32(shown);
    value_row(
        ui,
        cx,
        lamp,
        [number.key, number.label, number.help],
        &spec,
        &value,
    );
}

fn color(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>) {
    let written = lamp.look.and_then(|look| look.color.as_ref());
    let given = lamp.given.map(|light| light.intensity);
    let given = given.map(|light| light / light.max_element().max(f32::MIN_POSITIVE));
    let shown = written.map(|color| color.value).or(given);
    let spec = Spec {
        name: format!("Colour of {}", lamp.name),
        range: None,
        bounds: Bounds {
            min: 0.0,
            ..Bounds::ANY
        },
        unit: "",
        widget: Widget::Color,
    };
    let value = texgen::Value::Vec3(shown.unwrap_or(Vec3::ONE).to_array());
    value_row(ui, cx, lamp, ["color", "Colour", "linear"], &spec, &value);
}

fn vector(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>, key: &str, label: &str, v: Vec3) {
    let (unit, help) = match key {
        "direction" => ("", "where it shines to"),
        _ => ("m", "in the world"),
    };
    let spec = Spec {
        name: format!("{label} of {}", lamp.name),
        range: None,
        bounds: Bounds::ANY,
        unit,
        widget: Widget::Plain,
    };
    let value = texgen::Value::Vec3(v.to_array());
    value_row(ui, cx, lamp, [key, label, help], &spec, &value);
}

fn size(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>, size: [f32; 2]) {
    let spec = Spec {
        name: format!("Size of {}", lamp.name),
        range: None,
        bounds: Bounds {
            min: 1e-3,
            max: 1e6,
        },
        unit: "m",
        widget: Widget::Plain,
    };
    let help = "width and height; its intensity stays what it is";
    let value = texgen::Value::Vec2(size);
    value_row(ui, cx, lamp, ["size", "Size", help], &spec, &value);
}

/// A value of a light: what is changed is written into its table.
fn value_row(
    ui: &mut Ui,
    cx: &mut Context<'_>,
    lamp: &Lamp<'_>,
    [key, label, help]: [&str; 3],
    spec: &Spec<'_>,
    value: &texgen::Value,
) {
    let written_value = cx.document.value(&lamp.section(), key);
    let is_set = written_value.is_some();
    let (whole, edited) = row(ui, label, help, is_set, |ui| {
        edit_steady(ui, spec, value, written_value.as_ref())
    });
    if let Some(value) = &edited.value {
        let edit = Edit::set(lamp.section(), key, written(value));
        cx.edit(&spec.name, vec![edit], Some(&edited.response));
    }
    // A light of the look's own has to stand somewhere.
    let is_needed = key == "position" && lamp.is_own();
    let reset = clear(cx, lamp, key);
    cx.reset_menu(&whole, is_set && !is_needed, &spec.name, vec![reset]);
}

/// Takes a key away, and the table with it where that was its only one: a table without keys says nothing.
fn clear(cx: &Context<'_>, lamp: &Lamp<'_>, key: &str) -> Edit {
    let section = lamp.section();
    match cx.document.table(&section).len() <= 1 {
        true => Edit::Remove { section },
        false => Edit::Clear {
            section,
            key: key.to_owned(),
        },
    }
}

fn group(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>) {
    let written = lamp.look.and_then(|look| look.group.as_ref());
    let shown = written.map_or("", |group| group.value.as_str());
    let label = format!("Group of {}", lamp.name);
    let help = "lights that a film keeps apart, and a mix dims together";
    let (_, field) = row(ui, "Group", help, written.is_some(), |ui| {
        draft(ui, &label, "none", shown, 140.0)
    });
    if let Some(text) = field.value {
        let text = text.trim();
        let edit = match text.is_empty() {
            true => clear(cx, lamp, "group"),
            false => Edit::set(lamp.section(), "group", Value::Text(text.to_owned())),
        };
        cx.edit(&label, vec![edit], None);
    }
}

fn buttons(ui: &mut Ui, cx: &mut Context<'_>, lamp: &Lamp<'_>) {
    ui.horizontal_wrapped(|ui| {
        let has_place = lamp.kind() != LampKind::Directional;
        let clicks = [
            (
                "Aim by a click",
                Placing::Aim,
                has_place && lamp.kind() != LampKind::Point,
            ),
            ("Light by a click", Placing::InFront, true),
        ];
        for (text, placing, is_there) in clicks {
            if !is_there {
                continue;
            }
            let help = match placing {
                Placing::Aim => "it shines at what is clicked in the picture",
                Placing::InFront => {
                    "it stands in front of what is clicked in the picture, and shines on it"
                }
            };
            let button = ui.button(text).on_hover_text(help);
            name(&button, &format!("{text}: {}", lamp.name));
            if button.clicked() {
                cx.place_light(lamp.name, placing);
            }
        }
        if lamp.is_own() {
            let button = ui.button("Delete");
            name(&button, &format!("Delete light {}", lamp.name));
            if button.clicked() {
                let remove = Edit::Remove {
                    section: lamp.section(),
                };
                cx.edit(&format!("delete light {}", lamp.name), vec![remove], None);
            }
        }
    });
}

/// A new light: beside and above the camera, at what that looks at, as bright as a white surface there wants it.
fn added(document: &Document, scene: SceneView<'_>, kind: LampKind) -> (String, Vec<Edit>) {
    let is_taken = |name: &String| {
        let is_given = scene.lights.iter().any(|light| light.name == *name);
        is_given || document.look().lights.iter().any(|l| l.name.value == *name)
    };
    let mut names = (1..).map(|number| format!("light_{number}"));
    let name = names.find(|name| !is_taken(name)).unwrap_or_default();
    let (eye, at, side, up) = match scene.camera {
        Some(camera) => seen(camera),
        None => (Vec3::Z * DISTANCE, Vec3::ZERO, Vec3::X, Vec3::Y),
    };
    let far = eye.distance(at);
    let position = eye + (up - side) * (0.5 * far);
    let reach = position.distance(at);
    let section = || Section::Light(name.clone());
    let mut edits = vec![Edit::set(
        section(),
        "type",
        Value::Text(kind.word().to_owned()),
    )];
    let mut set = |key: &str, value| edits.push(Edit::set(section(), key, value));
    let place = |v: Vec3| Value::numbers(&v.to_array().map(|x| near(x, far)));
    match kind {
        LampKind::Directional => {
            let to = (at - position).normalize_or(Vec3::NEG_Y);
            set("direction", Value::numbers(&to.to_array().map(short)));
            set("intensity", Value::number(short(PI)));
        }
        _ => {
            set("position", place(position));
            set("intensity", Value::number(short(PI * reach * reach)));
        }
    }
    if matches!(kind, LampKind::Spot | LampKind::Area) {
        set("look_at", place(at));
    }
    if kind == LampKind::Area {
        set("size", Value::numbers(&[short(0.4 * far); 2]));
    }
    (name, edits)
}

/// Where a camera stands, the point that it is focused on, and what is right and up in its picture.
fn seen(camera: &Camera) -> (Vec3, Vec3, Vec3, Vec3) {
    let axes = camera.transform.matrix3;
    let eye = Vec3::from(camera.transform.translation);
    let far = match camera.focus_distance {
        far if far.is_finite() && far > 0.0 => far,
        _ => DISTANCE,
    };
    let at = eye - Vec3::from(axes.z_axis) * far;
    (eye, at, axes.x_axis.into(), axes.y_axis.into())
}

/// With three digits: nobody reads more. Not for places, which may lie far from the origin: see [`near`].
fn short(x: f32) -> f32 {
    match x == 0.0 || !x.is_finite() {
        true => 0.0,
        false => {
            let scale = 10f32.powf(2.0 - x.abs().log10().floor());
            (x * scale).round() / scale
        }
    }
}

/// A coordinate of a place with the digits that matter to what is `far` away from there: metres, both of them. It is off by less than a
/// thousandth of that, wherever the origin is.
fn near(x: f32, far: f32) -> f32 {
    let share = f64::from(far.clamp(1e-6, 1e30)) * 1e-3;
    let step = 10f64.powf(share.log10().floor());
    match x.is_finite() && step.is_finite() {
        // A zero without a sign.
        true => ((f64::from(x) / step).round() * step) as f32 + 0.0,
        false => 0.0,
    }
}

/// What a click on a surface does to a light: `point` and unit `normal` are in the world, the normal on the side that is seen.
pub fn place_light(
    document: &Document,
    scene: SceneView<'_>,
    light: &str,
    placing: Placing,
    [point, normal]: [Vec3; 2],
) -> Vec<Edit> {
    let lamps = lamps(document, scene);
    let Some(lamp) = lamps.iter().find(|lamp| lamp.name == light) else {
        return Vec::new();
    };
    if lamp.kind() == LampKind::Directional {
        let to = Value::numbers(&(-normal).to_array().map(short));
        let edit = Edit::set(lamp.section(), "direction", to);
        return turned(lamp, "direction", edit);
    }
    let far = lamp.position().distance(point).max(0.01);
    let set = |key: &str, v: Vec3| {
        let value = Value::numbers(&v.to_array().map(|x| near(x, far)));
        Edit::set(lamp.section(), key, value)
    };
    let position = point + normal * far;
    let mut edits = Vec::new();
    // A light that looks from somewhere says where that is.
    if placing == Placing::InFront || lamp.look.is_none_or(|look| look.position.is_none()) {
        let there = match placing {
            Placing::InFront => position,
            Placing::Aim => lamp.position(),
        };
        edits.push(set("position", there));
    }
    if lamp.kind() != LampKind::Point {
        edits.extend(turned(lamp, "look_at", set("look_at", point)));
    }
    edits
}

/// An edit of where a light shines to, and the other key of that taken away.
fn turned(lamp: &Lamp<'_>, key: &str, edit: Edit) -> Vec<Edit> {
    let aim = lamp.look.and_then(|look| look.aim.as_ref());
    let other = match aim.map(|aim| aim.value) {
        Some(Aim::At(_)) if key == "direction" => "look_at",
        Some(Aim::Direction(_)) if key == "look_at" => "direction",
        _ => return vec![edit],
    };
    let clear = Edit::Clear {
        section: lamp.section(),
        key: other.to_owned(),
    };
    vec![clear, edit]
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use engine::scene::Projection;

    use super::*;

    const SCENE: SceneView<'static> = SceneView {
        materials: &[],
        own: 0,
        images: &[],
        lights: &[],
        camera: None,
    };

    #[test]
    fn a_place_has_the_digits_that_its_distance_asks_for() {
        assert_eq!(near(1234.5, 2.0), 1234.5);
        assert_eq!(near(1234.567, 20.0), 1234.57);
        assert_eq!(near(0.012_345, 0.5), 0.0123);
        assert_eq!(near(-0.000_04, 2.0).to_bits(), 0);
        assert_eq!(near(f32::NAN, 1.0), 0.0);
        assert_eq!(near(1.0, f32::NAN), 0.0);
    }

    #[test]
    fn clicks_far_from_the_origin_place_a_light_exactly() {
        let text = "[light.lamp]\ntype = 'spot'\nintensity = 10.0\nposition = [1230.0, 2.0, 0.0]\n\
                    look_at = [0.0, 0.0, 0.0]\n";
        let placed = |placing| {
            let mut document = Document::new(Path::new("a"), text).expect("a look");
            let place = [Vec3::new(1234.5, 2.0, 0.0), Vec3::NEG_X];
            let edits = place_light(&document, SCENE, "lamp", placing, place);
            document.apply("place", &edits, None).expect("it fits");
            let light = &document.look().lights[0];
            let position = light.position.as_ref().map(|position| position.value);
            (position, light.aim.as_ref().map(|aim| aim.value))
        };
        let at = Some(Aim::At(Vec3::new(1234.5, 2.0, 0.0)));
        assert_eq!(
            placed(Placing::InFront),
            (Some(Vec3::new(1230.0, 2.0, 0.0)), at)
        );
        assert_eq!(
            placed(Placing::Aim),
            (Some(Vec3::new(1230.0, 2.0, 0.0)), at)
        );
    }

    #[test]
    fn a_light_that_is_added_far_from_the_origin_stands_beside_the_camera() {
        let mut document = Document::new(Path::new("a"), "").expect("a look");
        let eye = Vec3::new(1234.5, 0.25, 7000.5);
        let camera = Camera {
            name: String::new(),
            transform: glam::Affine3A::from_translation(eye),
            projection: Projection::Perspective { y_fov: 1.0 },
            aperture_radius: 0.0,
            aperture_blades: 0,
            aperture_rotation: 0.0,
            focus_distance: 1.0,
        };
        let scene = SceneView {
            camera: Some(&camera),
            ..SCENE
        };
        let (_, edits) = added(&document, scene, LampKind::Area);
        document.apply("add", &edits, None).expect("it fits");
        let light = &document.look().lights[0];
        let position = light.position.as_ref().map(|position| position.value);
        assert_eq!(position, Some(eye + Vec3::new(-0.5, 0.5, 0.0)));
        let aim = light.aim.as_ref().map(|aim| aim.value);
        assert_eq!(aim, Some(Aim::At(eye - Vec3::Z)));
    }
}
