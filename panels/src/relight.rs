//! A mix of lights written into the look: what its faders do to what is shown, its lights do to what is rendered.

use engine::scene::look::{EnvironmentLook, Field, LightLook, MaterialLook, Section, Value};
use engine::scene::{Material, UNGROUPED};
use engine::session::{Document, Edit};
use glam::Vec3;

use crate::scene_view::SceneView;

/// What a directional light is called that a sky brings with it.
const SUN: &str = "sun";
/// Of a light of the look that says nothing.
const INTENSITY: f32 = 10.0;
const DIRECTIONAL: f32 = 3.0;

/// Edits by which the lights, the materials that glow, and the environment are what they are times the factors of their groups, by
/// the groups' names; those of no group are called `rest`.
///
/// # Errors
/// Something of a group can't be as the mix has it: says what, and why. `is_lit_by_studio` where the light is no part of the look.
pub fn relight(
    document: &Document,
    scene: SceneView<'_>,
    factors: &[(String, [f32; 3])],
    is_lit_by_studio: bool,
) -> Result<Vec<Edit>, String> {
    let factor = |group: Option<&str>| {
        let group = group.unwrap_or(UNGROUPED);
        let found = factors.iter().find(|(name, _)| name == group);
        found.map_or(Vec3::ONE, |(_, factor)| Vec3::from(*factor))
    };
    if is_lit_by_studio && factor(None) != Vec3::ONE {
        return Err("the studio light is no part of the look".to_owned());
    }
    let look = document.look();
    let environment_group = look.environment_group.as_ref();
    let environment_group = environment_group.map(|group| group.value.as_str());
    let environment_factor = factor(environment_group);
    let mut edits = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    let given = scene.lights.iter().map(|light| light.name.as_str());
    for name in given.chain(look.lights.iter().map(|light| light.name.value.as_str())) {
        if names.contains(&name) {
            continue;
        }
        names.push(name);
        let table = look.lights.iter().find(|light| light.name.value == name);
        if table.is_some_and(|table| table.on == Some(false)) {
            continue;
        }
        let is_of_sky = is_of_sky(document, name, table);
        let group = table.and_then(|table| table.group.as_ref());
        let group = group.map(|group| group.value.as_str());
        let factor = factor(group.or(environment_group.filter(|_| is_of_sky)));
        // The sun is as bright as its sky, unless the look says otherwise.
        let is_carried = is_of_sky && table.is_none_or(|table| table.intensity.is_none());
        let by_sky = match is_carried {
            true => environment_factor,
            false => Vec3::ONE,
        };
        if factor == by_sky {
            continue;
        }
        if is_carried && sky_has_keys(document) {
            return Err("the sky has keys: its sun can't be mixed apart from it".to_owned());
        }
        edits.extend(light(document, scene, name, table, factor)?);
    }
    for material in scene.materials {
        let name = material.name.as_str();
        // Rectangles among the lights have materials, too.
        let is_lamp = name
            .strip_prefix("light ")
            .is_some_and(|light| look.lights.iter().any(|l| l.name.value == light));
        let table = (look.materials.iter()).find(|table| table.name.value == name);
        let group = table.and_then(|table| table.group.as_ref());
        let is_driven = table.is_some_and(|table| table.is_driven("emission"));
        let section = Section::Material(name.to_owned());
        // At another moment it may glow.
        let is_keyed = |key: &str| table.is_some() && has_keys(document, &section, key);
        let glows = is_driven
            || material.emission != Vec3::ZERO
            || is_keyed("emission")
            || is_keyed("emission_strength");
        let factor = factor(group.map(|group| group.value.as_str()));
        if is_lamp && table.is_none_or(|table| table.input("emission").is_none()) {
            continue;
        }
        if factor == Vec3::ONE || !glows {
            continue;
        }
        if is_lamp {
            return Err(format!("the look has a material for what {name} emits"));
        }
        edits.extend(emission(document, material, table, factor)?);
    }
    if let Some(environment) = &look.environment
        && environment_factor != Vec3::ONE
    {
        let is_dark = environment_factor.max_element() <= 0.0;
        if is_dark && needs_sun(document, &edits) {
            return Err(
                "a sky without light has no sun, and the look has a table of that: it can be dimmed but not turned off"
                    .to_owned(),
            );
        }
        let value = &environment.value;
        edits.extend(self::environment(document, value, environment_factor)?);
    }
    match edits.is_empty() {
        true => Err("nothing that shines is in a group that is mixed".to_owned()),
        false => Ok(edits),
    }
}

/// Whether a light is the sun that the look's sky brings with it.
fn is_of_sky(document: &Document, name: &str, table: Option<&LightLook>) -> bool {
    let environment = document.look().environment.as_ref();
    let brings_sun =
        environment.is_some_and(|e| matches!(&e.value, EnvironmentLook::Sky(sky) if sky.sun));
    brings_sun && name == SUN && table.is_none_or(|table| table.kind.is_none())
}

/// Whether the look says something of its sky's sun once some edits are made: it has to be there then.
fn needs_sun(document: &Document, edits: &[Edit]) -> bool {
    let sun = Section::Light(SUN.to_owned());
    let mut tables = document.look().lights.iter();
    let table = tables.find(|table| table.name.value == SUN);
    let is_said = table.is_some() || edits.iter().any(|edit| *edit.section() == sun);
    is_said && is_of_sky(document, SUN, table)
}

/// Whether a value changes with time: a constant would take its keys away.
fn has_keys(document: &Document, section: &Section, key: &str) -> bool {
    matches!(document.value(section, key), Some(Value::Table(_)))
}

/// Whether the sun of a sky may change with time.
fn sky_has_keys(document: &Document) -> bool {
    let section = Section::Environment;
    let is_table = |field: &Field| matches!(field.value.value, Value::Table(_));
    let sky = match document.value(&section, "sky") {
        Some(Value::Table(sky)) => sky.iter().any(is_table),
        _ => false,
    };
    sky || has_keys(document, &section, "intensity")
}

/// The strength of a factor, and its colour, if it has one.
fn parts(factor: Vec3) -> (f32, Option<Vec3>) {
    let most = factor.max_element();
    let is_gray = factor.min_element() == most;
    (most, (!is_gray).then(|| factor / most))
}

fn number(x: f32) -> Value {
    Value::number(short(x))
}

fn color(rgb: Vec3) -> Value {
    Value::numbers(&rgb.to_array().map(short))
}

/// With as many digits as anybody sees.
fn short(x: f32) -> f32 {
    format!("{x:.4e}").parse().unwrap_or(x)
}

fn light(
    document: &Document,
    scene: SceneView<'_>,
    name: &str,
    table: Option<&LightLook>,
    factor: Vec3,
) -> Result<Vec<Edit>, String> {
    let section = || Section::Light(name.to_owned());
    let given = scene.lights.iter().find(|light| light.name == name);
    let color_of = table.and_then(|table| table.color.as_ref());
    let shade = color_of.map_or(1.0, |color| color.value.max_element());
    let most = given.map(|light| light.intensity.max_element() / shade.max(f32::MIN_POSITIVE));
    let is_directional = table
        .and_then(|table| table.kind.as_ref())
        .is_some_and(|kind| kind.value == engine::scene::look::LampKind::Directional);
    let usual = match is_directional {
        true => DIRECTIONAL,
        false => INTENSITY,
    };
    let is_own = table.is_some_and(|table| table.kind.is_some());
    let written = table.and_then(|table| table.intensity.as_ref());
    let intensity = match (written, is_own) {
        (Some(written), _) => written.value,
        (None, true) => usual,
        (None, false) => most.unwrap_or(usual),
    };
    let (strength, tint) = parts(factor);
    // Where nothing else is written, how bright the light is follows from the colour, too.
    let needs_color = tint.is_some() || written.is_none() && !is_own;
    for (key, is_needed) in [("intensity", true), ("color", needs_color)] {
        if is_needed && has_keys(document, &section(), key) {
            return Err(format!("the `{key}` of the light {name} has keys"));
        }
    }
    let mut edits = vec![Edit::set(
        section(),
        "intensity",
        number(intensity * strength),
    )];
    if let Some(tint) = tint {
        let shown = given.map(|light| light.intensity);
        let shown = shown.map(|light| light / light.max_element().max(f32::MIN_POSITIVE));
        let former = color_of.map(|color| color.value).or(shown);
        let tinted = former.unwrap_or(Vec3::ONE) * tint;
        edits.push(Edit::set(section(), "color", color(tinted)));
    }
    Ok(edits)
}

fn emission(
    document: &Document,
    material: &Material,
    table: Option<&MaterialLook>,
    factor: Vec3,
) -> Result<Vec<Edit>, String> {
    let name = material.name.as_str();
    let is_driven = |key: &str| table.is_some_and(|table| table.is_driven(key));
    if is_driven("emission_strength") {
        return Err(format!(
            "a texture says how strongly {name} glows: `emission_strength` is linked"
        ));
    }
    let constant = |key: &str| table.and_then(|table| table.constant(key));
    let strength = constant("emission_strength").map_or(1.0, |strength| strength.x);
    let (most, tint) = parts(factor);
    let section = Section::Material(name.to_owned());
    let is_tinted = tint.is_some();
    for (key, is_needed) in [("emission_strength", true), ("emission", is_tinted)] {
        if is_needed && has_keys(document, &section, key) {
            return Err(format!("the `{key}` of the material {name} has keys"));
        }
    }
    let mut edits = vec![Edit::material(
        name,
        "emission_strength",
        number(strength * most),
    )];
    if let Some(tint) = tint {
        if is_driven("emission") || material.emission_texture.is_some() {
            return Err(format!(
                "{name} glows by a texture or an image, which can be dimmed but not tinted"
            ));
        }
        let former = match constant("emission") {
            Some(emission) => emission,
            None if strength > 0.0 => material.emission / strength,
            None => Vec3::ZERO,
        };
        edits.push(Edit::material(name, "emission", color(former * tint)));
    }
    Ok(edits)
}

fn environment(
    document: &Document,
    environment: &EnvironmentLook,
    factor: Vec3,
) -> Result<Vec<Edit>, String> {
    let written = document.value(&Section::Environment, "intensity");
    let former = match written {
        Some(Value::Float(x)) => x as f32,
        Some(Value::Integer(x)) => x as f32,
        None => 1.0,
        Some(_) => return Err("the environment's `intensity` has keys".to_owned()),
    };
    let (most, tint) = parts(factor);
    let mut edits = vec![Edit::environment("intensity", number(former * most))];
    if let Some(tint) = tint {
        if has_keys(document, &Section::Environment, "color") {
            return Err("the environment's `color` has keys".to_owned());
        }
        let EnvironmentLook::Constant(shown) = environment else {
            return Err(
                "the environment is a panorama or a sky, which can be dimmed but not tinted"
                    .to_owned(),
            );
        };
        let plain = match former > 0.0 {
            true => *shown / former,
            false => Vec3::ZERO,
        };
        edits.push(Edit::environment("color", color(plain * tint)));
    }
    Ok(edits)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use engine::scene::{LightKind, PunctualLight};

    use super::*;

    const LOOK: &str = "environment = { color = [0.2, 0.4, 0.8], intensity = 2.0, group = \"day\" }\n\n\
        [light.Lamp]\ngroup = \"key\"\n\n[light.own]\ntype = \"point\"\nposition = [0, 1, 0]\ngroup = \"key\"\n\n\
        [material.Screen]\nemission = [1, 1, 0]\nemission_strength = 3\ngroup = \"screen\"\n\n\
        [material.Leds]\nemission = \"dots\"\ngroup = \"leds\"\n\n[node.dots]\ntexture = \"dots\"\n";

    const SKY: &str = "environment = { sky = { sun_elevation = 30 }, intensity = 2.0, group = \"day\" }\n\n\
        [light.sun]\ngroup = \"sunlight\"\n";

    fn relit(factors: &[(&str, [f32; 3])]) -> Result<Document, String> {
        relit_in(LOOK, factors)
    }

    fn relit_in(look: &str, factors: &[(&str, [f32; 3])]) -> Result<Document, String> {
        let mut document = Document::new(Path::new("a.look.toml"), look).expect("a look");
        let light = |name: &str, intensity: [f32; 3]| PunctualLight {
            name: name.to_owned(),
            kind: LightKind::Point,
            intensity: intensity.into(),
            position: Vec3::ZERO,
            direction: Vec3::NEG_Y,
            range: f32::INFINITY,
        };
        let lights = [
            light("Lamp", [4.0, 2.0, 0.0]),
            light("own", [INTENSITY; 3]),
            light("Window", [1.0; 3]),
            light(SUN, [6.0, 4.5, 3.0]),
        ];
        let material = |name: &str, emission: [f32; 3]| Material {
            name: name.to_owned(),
            emission: emission.into(),
            ..Material::default()
        };
        let materials = [
            material("Screen", [3.0, 3.0, 0.0]),
            material("Leds", [0.0; 3]),
            material("Wall", [0.0; 3]),
        ];
        let scene = SceneView {
            materials: &materials,
            own: materials.len(),
            images: &[],
            lights: &lights,
            camera: None,
        };
        let factors: Vec<_> = (factors.iter())
            .map(|(name, factor)| ((*name).to_owned(), *factor))
            .collect();
        let edits = relight(&document, scene, &factors, false)?;
        document.apply("light mix", &edits, None)?;
        Ok(document)
    }

    fn numbers(document: &Document, section: &Section, key: &str) -> Vec<f32> {
        let number = |value: &Value| match value {
            Value::Float(x) => *x as f32,
            Value::Integer(x) => *x as f32,
            other => panic!("{other:?}"),
        };
        match document.value(section, key) {
            None => Vec::new(),
            Some(Value::List(list)) => list.iter().map(|item| number(&item.value)).collect(),
            Some(value) => vec![number(&value)],
        }
    }

    #[test]
    fn each_light_gives_what_its_group_is_mixed_to() {
        let document = relit(&[("key", [0.5; 3])]).expect("written");
        let lamp = |name: &str| Section::Light(name.to_owned());
        assert_eq!(numbers(&document, &lamp("Lamp"), "intensity"), [2.0]);
        assert_eq!(numbers(&document, &lamp("own"), "intensity"), [5.0]);
        assert!(numbers(&document, &lamp("Lamp"), "color").is_empty());
        assert!(document.value(&lamp("Window"), "intensity").is_none());
        let document = relit(&[("key", [2.0, 1.0, 1.0])]).expect("written");
        assert_eq!(numbers(&document, &lamp("Lamp"), "intensity"), [8.0]);
        let color = numbers(&document, &lamp("Lamp"), "color");
        assert_eq!(color, [1.0, 0.25, 0.0]);
        let document = relit(&[("rest", [0.0; 3])]).expect("written");
        assert_eq!(numbers(&document, &lamp("Window"), "intensity"), [0.0]);
        assert!(document.value(&lamp("Lamp"), "intensity").is_none());

        let screen = Section::Material("Screen".to_owned());
        let document = relit(&[("screen", [0.5, 1.0, 1.0])]).expect("written");
        assert_eq!(numbers(&document, &screen, "emission_strength"), [3.0]);
        assert_eq!(numbers(&document, &screen, "emission"), [0.5, 1.0, 0.0]);

        let document = relit(&[("day", [2.0, 2.0, 1.0])]).expect("written");
        let day = Section::Environment;
        assert_eq!(numbers(&document, &day, "intensity"), [4.0]);
        assert_eq!(numbers(&document, &day, "color"), [0.2, 0.4, 0.4]);
    }

    #[test]
    fn what_cannot_be_tinted_is_said() {
        let leds = Section::Material("Leds".to_owned());
        let document = relit(&[("leds", [0.25; 3])]).expect("dimmed");
        assert_eq!(numbers(&document, &leds, "emission_strength"), [0.25]);
        let why = relit(&[("leds", [1.0, 0.5, 0.5])]).expect_err("a texture");
        assert!(why.contains("Leds"), "{why}");
    }

    #[test]
    fn the_sun_of_a_sky_is_mixed_apart_from_it() {
        let (day, sun) = (Section::Environment, Section::Light(SUN.to_owned()));
        let sky_and_sun = |look: &str, factors: &[(&str, [f32; 3])]| {
            let document = relit_in(look, factors).expect("written");
            [&day, &sun].map(|section| numbers(&document, section, "intensity"))
        };
        let half = [0.5; 3];
        let mixed = |factors: &[(&str, [f32; 3])]| sky_and_sun(SKY, factors);
        // Dimmed with its sky the sun is as bright as it was only if that is written.
        assert_eq!(mixed(&[("day", half)]), [vec![1.0], vec![6.0]]);
        assert_eq!(mixed(&[("sunlight", half)]), [vec![2.0], vec![3.0]]);
        assert_eq!(mixed(&[("sunlight", [0.0; 3])]), [vec![2.0], vec![0.0]]);
        let both = mixed(&[("day", half), ("sunlight", half)]);
        assert_eq!(both, [vec![1.0], vec![]], "it follows its sky");
        let warm = relit_in(SKY, &[("sunlight", [1.0, 1.0, 0.5])]).expect("written");
        assert_eq!(numbers(&warm, &sun, "intensity"), [6.0]);
        assert_eq!(numbers(&warm, &sun, "color"), [1.0, 0.75, 0.25]);
        // It is in the group of its sky unless it has another one.
        let alone = SKY.split("[light").next().expect("a head");
        assert_eq!(
            sky_and_sun(alone, &[("day", half)]),
            [vec![1.0], vec![]],
            "it follows its sky"
        );
        let written = format!("{alone}[light.sun]\nintensity = 8.0\n");
        assert_eq!(
            sky_and_sun(&written, &[("day", half)]),
            [vec![1.0], vec![4.0]]
        );
        // Without its sky there is no sun of which a table could be.
        let dark = [("day", [0.0; 3])];
        assert_eq!(sky_and_sun(alone, &dark), [vec![0.0], vec![]]);
        for look in [SKY, written.as_str()] {
            let why = relit_in(look, &dark).expect_err("no sun");
            assert!(why.contains("no sun"), "{why}");
        }
    }

    #[test]
    fn what_has_keys_is_left_alone() {
        let strengths = "{ keys = [[0, 1.0], [1, 2.0]] }";
        let colors = "{ keys = [[0, [1, 1, 0]], [1, [0, 1, 0]]] }";
        let (gray, warm) = ([0.5; 3], [1.0, 0.5, 0.5]);
        let lamp = "[light.Lamp]\ngroup = \"a\"\n";
        let leds = "[material.Leds]\ngroup = \"a\"\n";
        let sun = "[light.sun]\ngroup = \"a\"\n";
        for (look, factor, says) in [
            (format!("{lamp}intensity = {strengths}"), gray, "Lamp"),
            (format!("{lamp}color = {colors}"), warm, "Lamp"),
            (
                format!("{leds}emission_strength = {strengths}"),
                gray,
                "Leds",
            ),
            (format!("{leds}emission = {colors}"), warm, "Leds"),
            (
                format!("environment = {{ color = {colors}, group = \"a\" }}"),
                warm,
                "environment",
            ),
            (
                format!("environment = {{ sky = {{ sun_elevation = {strengths} }} }}\n{sun}"),
                gray,
                "sky",
            ),
        ] {
            let why = relit_in(&look, &[("a", factor)]).expect_err(&look);
            assert!(why.contains(says) && why.contains("keys"), "{look}: {why}");
        }
        // What isn't written keeps its keys.
        let look = format!("{leds}emission = {colors}");
        let document = relit_in(&look, &[("a", gray)]).expect("dimmed");
        assert!(document.text().contains(colors), "{}", document.text());
        let leds = Section::Material("Leds".to_owned());
        assert_eq!(numbers(&document, &leds, "emission_strength"), [0.5]);
    }
}
