//! Lights of the look, and its overrides of lights of the scene.

use std::collections::BTreeSet;
use std::f32::consts::FRAC_PI_4;

use glam::{Affine3A, Mat3A, Vec3, Vec3A};
use texgen::{Diagnostic, SourceFile, did_you_mean};

use crate::scene::look::{Aim, EnvironmentLook, LampKind, LightLook, Look, direction_of};
use crate::scene::{Instance, LightKind, Material, Mesh, PunctualLight, Scene};

/// Of a light whose look doesn't say it, W/sr; of directional lights W/m².
const INTENSITY: f32 = 10.0;
const IRRADIANCE: f32 = 3.0;
/// What the light is called that a sky brings with it.
const SUN: &str = "sun";
/// Metres, of a rectangle.
const SIZE: [f32; 2] = [0.5, 0.5];

/// What the light of a rectangle is called as a material.
pub(super) fn material_name(light: &str) -> String {
    format!("light {light}")
}

/// Adds a light of the look's own, or changes those of the scene that have its name. Those that are `gone` at this moment, and the sun
/// of a sky that shows none, are known, but there is nothing to change.
pub(super) fn apply(
    look: &Look,
    wanted: &LightLook,
    scene: &mut Scene,
    gone: &BTreeSet<String>,
) -> Result<(), Diagnostic> {
    let name = &wanted.name.value;
    let is_there = scene.lights.iter().any(|light| light.name == *name);
    let Some(kind) = &wanted.kind else {
        if !is_there {
            return match gone.contains(name) || is_sun(look, name) {
                true => Ok(()),
                false => Err(unknown(&look.file, wanted, scene, gone)),
            };
        }
        let mut lights = scene.lights.iter_mut().filter(|l| l.name == *name);
        return lights.try_for_each(|light| change(&look.file, wanted, light));
    };
    if is_there || gone.contains(name) {
        let problem = format!("the scene has a light called `{name}` already");
        return Err(Diagnostic::error(problem)
            .with_label(&look.file, kind.span.clone(), "")
            .with_note("leave `type` out to change that one, or give this one another name"));
    }
    if kind.value == LampKind::Area {
        return add_rectangle(&look.file, wanted, scene);
    }
    scene.lights.push(own(&look.file, wanted, kind.value)?);
    Ok(())
}

/// Whether a light is the sun of the look's sky, which is there only as long as it is up and shines.
fn is_sun(look: &Look, name: &str) -> bool {
    let environment = look.environment.as_ref().map(|e| &e.value);
    name == SUN && matches!(environment, Some(EnvironmentLook::Sky(_)))
}

/// A light of the look's own, but for rectangles.
pub(crate) fn own(
    file: &SourceFile,
    wanted: &LightLook,
    kind: LampKind,
) -> Result<PunctualLight, Diagnostic> {
    let (kind, intensity) = match kind {
        LampKind::Directional => (LightKind::Directional, IRRADIANCE),
        LampKind::Spot => {
            let cone = LightKind::Spot {
                inner_angle: 0.0,
                outer_angle: FRAC_PI_4,
            };
            (cone, INTENSITY)
        }
        LampKind::Point | LampKind::Area => (LightKind::Point, INTENSITY),
    };
    let mut light = PunctualLight {
        name: wanted.name.value.clone(),
        intensity: Vec3::splat(intensity),
        position: Vec3::ZERO,
        direction: Vec3::NEG_Y,
        range: f32::INFINITY,
        kind,
    };
    change(file, wanted, &mut light)?;
    Ok(light)
}

/// Changes a light.
pub(crate) fn change(
    file: &SourceFile,
    wanted: &LightLook,
    light: &mut PunctualLight,
) -> Result<(), Diagnostic> {
    light.intensity = intensity(wanted, light.intensity);
    if let Some(position) = &wanted.position {
        light.position = position.value;
    }
    let misfit = |key: &str, note: &str| {
        let problem = format!("the light `{}` has no `{key}`", wanted.name.value);
        let problem = Diagnostic::error(problem).with_note(note);
        Err(problem.with_label(file, wanted.name.span.clone(), ""))
    };
    if let Some(aim) = &wanted.aim {
        if light.kind == LightKind::Point {
            let key = match aim.value {
                Aim::Direction(_) => "direction",
                Aim::At(_) => "look_at",
            };
            return misfit(key, "a point shines in all directions");
        }
        light.direction = direction_of(Some(aim.value), light.position)
            .ok_or_else(|| aims_nowhere(file, wanted))?;
    }
    if let Some(range) = &wanted.range {
        if matches!(light.kind, LightKind::Directional | LightKind::Disk { .. }) {
            return misfit("range", "light from infinitely far away reaches everything");
        }
        light.range = range.value;
    }
    let cone = [&wanted.inner_cone_angle, &wanted.outer_cone_angle]
        .map(|angle| angle.as_ref().map(|angle| angle.value.to_radians()));
    let diameter = wanted.angular_diameter.as_ref();
    match &mut light.kind {
        LightKind::Spot {
            inner_angle,
            outer_angle,
        } => {
            if let (Some(inner), None) = (&wanted.inner_cone_angle, cone[1])
                && inner.value.to_radians() >= *outer_angle
            {
                let outer = (outer_angle.to_degrees() * 100.0).round() / 100.0;
                let problem = format!(
                    "`inner_cone_angle` has to be less than `outer_cone_angle`, which is {outer} here"
                );
                return Err(Diagnostic::error(problem).with_label(file, inner.span.clone(), ""));
            }
            *outer_angle = cone[1].unwrap_or(*outer_angle);
            // What is narrower than all of it was before has no edge.
            *inner_angle = cone[0].unwrap_or(*inner_angle).min(0.999 * *outer_angle);
        }
        _ if cone != [None, None] => {
            return misfit(
                "inner_cone_angle and outer_cone_angle",
                "only spots shine in a cone",
            );
        }
        _ => {}
    }
    match light.kind {
        LightKind::Directional | LightKind::Disk { .. } => {
            if let Some(diameter) = diameter {
                light.kind = match diameter.value > 0.0 {
                    true => LightKind::Disk {
                        angular_diameter: diameter.value.to_radians(),
                    },
                    false => LightKind::Directional,
                };
            }
        }
        LightKind::Point | LightKind::Spot { .. } if diameter.is_some() => {
            return misfit(
                "angular_diameter",
                "only directional lights have one; give a lamp its size by type = \"area\", or by a mesh with an emissive material",
            );
        }
        LightKind::Point | LightKind::Spot { .. } => {}
    }
    Ok(())
}

/// What an intensity becomes: its brightest channel is the intensity, the rest of it the colour.
fn intensity(wanted: &LightLook, former: Vec3) -> Vec3 {
    if wanted.on == Some(false) {
        return Vec3::ZERO;
    }
    let most = former.max_element();
    let strength = wanted.intensity.as_ref().map_or(most, |i| i.value);
    let color = match &wanted.color {
        Some(color) => color.value,
        None if most > 0.0 => former / most,
        None => Vec3::ONE,
    };
    color * strength
}

fn unknown(
    file: &SourceFile,
    wanted: &LightLook,
    scene: &Scene,
    gone: &BTreeSet<String>,
) -> Diagnostic {
    let name = &wanted.name.value;
    let names = || {
        let lights = scene.lights.iter().map(|light| &light.name);
        lights.chain(gone).map(String::as_str)
    };
    let note = match did_you_mean(name, names()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if names().next().is_none() => "the scene has no punctual lights".to_owned(),
        None => format!("it has {}", names().take(20).collect::<Vec<_>>().join(", ")),
    };
    Diagnostic::error(format!("the scene has no light called `{name}`"))
        .with_label(file, wanted.name.span.clone(), "")
        .with_note(note)
        .with_note("a light of the look's own says what it is, as in type = \"point\"")
}

fn aims_nowhere(file: &SourceFile, wanted: &LightLook) -> Diagnostic {
    let span = (wanted.aim.as_ref()).map_or(wanted.name.span.clone(), |aim| aim.span.clone());
    Diagnostic::error("the light stands where it looks at: `look_at` has no direction")
        .with_label(file, span, "")
        .with_note("set another `look_at`, or `direction`")
}

/// A rectangle that shines to one side: its material has the radiance that gives the intensity along its axis.
fn add_rectangle(
    file: &SourceFile,
    wanted: &LightLook,
    scene: &mut Scene,
) -> Result<(), Diagnostic> {
    let [width, height] = wanted.size.as_ref().map_or(SIZE, |size| size.value);
    let position = wanted.position.as_ref().map_or(Vec3::ZERO, |p| p.value);
    let aim = wanted.aim.as_ref().map(|aim| aim.value);
    let direction = direction_of(aim, position).ok_or_else(|| aims_nowhere(file, wanted))?;
    let name = &wanted.name.value;
    let material = scene.materials.len() as u32;
    scene.materials.push(Material {
        name: material_name(name),
        base_color: Vec3::ZERO.extend(1.0),
        metallic: 0.0,
        roughness: 1.0,
        emission: intensity(wanted, Vec3::splat(INTENSITY)) / (width * height),
        ..Material::default()
    });
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let mesh = scene.meshes.len() as u32;
    scene.meshes.push(Mesh {
        name: material_name(name),
        positions: vec![
            corner(-0.5, -0.5),
            corner(0.5, -0.5),
            corner(0.5, 0.5),
            corner(-0.5, 0.5),
        ],
        normals: vec![Vec3::Z; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![material; 2],
        ..Mesh::default()
    });
    scene.instances.push(Instance {
        name: material_name(name),
        mesh,
        transform: standing(position, direction, width, height),
        asset: None,
    });
    Ok(())
}

/// From a square of one metre in the plane of X and Y that shines along Z.
fn standing(position: Vec3, direction: Vec3, width: f32, height: f32) -> Affine3A {
    // Level, as far as that is possible.
    let side = match Vec3::Y.cross(direction).try_normalize() {
        Some(side) => side,
        None => Vec3::X,
    };
    let up = direction.cross(side);
    Affine3A {
        matrix3: Mat3A::from_cols(
            (side * width).into(),
            (up * height).into(),
            direction.into(),
        ),
        translation: Vec3A::from(position),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scene(kind: LightKind) -> Scene {
        Scene {
            lights: vec![PunctualLight {
                name: "Sun".to_owned(),
                intensity: Vec3::new(1.0, 0.5, 0.0),
                position: Vec3::ZERO,
                direction: Vec3::NEG_Y,
                range: f32::INFINITY,
                kind,
            }],
            ..Scene::default()
        }
    }

    fn changed(text: &str, kind: LightKind) -> Result<Scene, String> {
        let look = Look::parse(Path::new("test.look.toml"), text).map_err(|e| e.to_string())?;
        let mut scene = scene(kind);
        for light in &look.lights {
            let gone = BTreeSet::from(["Gone".to_owned()]);
            apply(&look, light, &mut scene, &gone).map_err(|problem| problem.render())?;
        }
        Ok(scene)
    }

    fn change(text: &str, kind: LightKind) -> Result<LightKind, String> {
        Ok(changed(text, kind)?.lights[0].kind)
    }

    #[test]
    fn directional_lights_get_and_lose_a_size() {
        let half = "[light.Sun]\nangular_diameter = 0.5";
        let disk = LightKind::Disk {
            angular_diameter: 0.5f32.to_radians(),
        };
        assert_eq!(change(half, LightKind::Directional), Ok(disk));
        let none = "[light.Sun]\nangular_diameter = 0";
        assert_eq!(change(none, disk), Ok(LightKind::Directional));
        assert_eq!(change("[light.Sun]", disk), Ok(disk));
    }

    #[test]
    fn lights_of_the_scene_are_changed() {
        let light = |text: &str| changed(text, LightKind::Point).expect(text).lights[0].clone();
        let strong = light("[light.Sun]\nintensity = 4");
        assert_eq!(strong.intensity, Vec3::new(4.0, 2.0, 0.0));
        let blue = light("[light.Sun]\ncolor = [0, 0, 1]");
        assert_eq!(blue.intensity, Vec3::Z);
        assert_eq!(light("[light.Sun]\non = false").intensity, Vec3::ZERO);
        let there = light("[light.Sun]\nposition = [1, 2, 3]");
        assert_eq!(there.position, Vec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn a_look_has_lights_of_its_own() {
        let text = "[light.key]\ntype = \"spot\"\nposition = [0, 2, 0]\nlook_at = [2, 2, 0]\nouter_cone_angle = 30";
        let lights = changed(text, LightKind::Point).expect("it is right").lights;
        assert_eq!(lights.len(), 2);
        assert_eq!(lights[1].direction, Vec3::X);
        assert_eq!(lights[1].intensity, Vec3::splat(INTENSITY));
        let cone = LightKind::Spot {
            inner_angle: 0.0,
            outer_angle: 30f32.to_radians(),
        };
        assert_eq!(lights[1].kind, cone);
    }

    #[test]
    fn a_rectangle_shines_as_its_intensity_says() {
        let text =
            "[light.box]\ntype = \"area\"\nposition = [0, 2, 0]\nsize = [2, 0.5]\nintensity = 6";
        let scene = changed(text, LightKind::Point).expect("it is right");
        assert_eq!(scene.lights.len(), 1);
        let material = &scene.materials[0];
        assert_eq!(material.name, "light box");
        assert_eq!(material.emission, Vec3::splat(6.0));
        let (low, high) = scene.bounds().expect("it has a place");
        let (low, high) = (low - Vec3::Y * 2.0, high - Vec3::Y * 2.0);
        assert!(low.distance(Vec3::new(-1.0, 0.0, -0.25)) < 1e-6, "{low}");
        assert!(high.distance(Vec3::new(1.0, 0.0, 0.25)) < 1e-6, "{high}");
        // Down, as nothing else is said.
        let to = scene.instances[0].transform.transform_vector3(Vec3::Z);
        assert!(to.distance(Vec3::NEG_Y) < 1e-6, "{to}");
        // Its triangles are seen from where they shine to.
        let m = scene.instances[0].transform.matrix3;
        assert!(m.determinant() > 0.0);
    }

    #[test]
    fn what_is_not_there_at_the_moment_is_left_alone() {
        let sky = "environment = { sky = { sun_elevation = -5 } }\n[light.sun]\nintensity = 2";
        for text in ["[light.Gone]\non = false", sky] {
            let scene = changed(text, LightKind::Point).expect(text);
            assert_eq!(scene.lights.len(), 1, "{text}");
            assert_eq!(scene.lights[0].intensity.x, 1.0, "{text}");
        }
        let other = "environment = { color = [1, 1, 1] }\n[light.sun]\nintensity = 2";
        let error = changed(other, LightKind::Point).expect_err("it has no sun");
        assert!(error.contains("no light called `sun`"), "{error}");
        let own = "[light.Gone]\ntype = \"point\"\nposition = [0, 0, 0]";
        let error = changed(own, LightKind::Point).expect_err("there are two of them");
        assert!(error.contains("already"), "{error}");
    }

    #[test]
    fn a_cone_is_never_cut_unasked() {
        let spot = LightKind::Spot {
            inner_angle: 0.1,
            outer_angle: 0.5,
        };
        let error = change("[light.Sun]\ninner_cone_angle = 29", spot).expect_err("too wide");
        assert!(error.contains("which is 28.65 here"), "{error}");
        assert!(change("[light.Sun]\ninner_cone_angle = 28", spot).is_ok());
        assert!(
            change(
                "[light.Sun]\ninner_cone_angle = 29\nouter_cone_angle = 30",
                spot
            )
            .is_ok()
        );
    }

    #[test]
    fn other_names_and_kinds_are_mistakes() {
        for (text, kind) in [
            ("[light.Sun]\nrange = 3", LightKind::Directional),
            ("[light.Sun]\ndirection = [1, 0, 0]", LightKind::Point),
            (
                "[light.Sun]\nposition = [1, 1, 1]\nlook_at = [1, 0, 0]",
                LightKind::Point,
            ),
        ] {
            let error = change(text, kind).expect_err(text);
            assert!(
                error.contains("the light `Sun` has no `"),
                "{text}: {error}"
            );
        }
        let error = change("[light.Sum]", LightKind::Directional).unwrap_err();
        assert!(error.contains("did you mean `Sun`?"), "{error}");
        for (text, why) in [
            (
                "[light.Sun]\nangular_diameter = 1",
                "has no `angular_diameter`",
            ),
            (
                "[light.Sun]\nouter_cone_angle = 10",
                "only spots shine in a cone",
            ),
            (
                "[light.Sun]\ntype = \"point\"\nposition = [0, 0, 0]",
                "already",
            ),
            ("[light.a]\ntype = \"point\"", "needs a `position`"),
            ("[light.a]\ntype = \"lamp\"", "expected \"point\""),
            (
                "[light.a]\ntype = \"point\"\nposition = [0, 0, 0]\nlook_at = [1, 0, 0]",
                "all directions",
            ),
            (
                "[light.a]\ntype = \"area\"\nposition = [0, 0, 0]\nrange = 1",
                "has no `range`",
            ),
            (
                "[light.a]\ntype = \"spot\"\nposition = [0, 0, 0]\ninner_cone_angle = 45",
                "`outer_cone_angle`, which is 45 here",
            ),
            (
                "[light.a]\ntype = \"spot\"\nposition = [1, 0, 0]\nlook_at = [1, 0, 0]",
                "stands where it looks at",
            ),
            (
                "[light.a]\ntype = \"directional\"\nlook_at = [1, 0, 0]",
                "needs a `position`",
            ),
            ("[light.Sun]\nsize = [1, 1]", "say what it is"),
            (
                "[light.a]\ntype = \"area\"\nposition = [0, 0, 0]\nsize = [1, 0]",
                "width and height",
            ),
            (
                "[light.a]\ntype = \"directional\"\ndirection = [0, 0, 0]",
                "length 0",
            ),
            (
                "[light.a]\ntype = \"spot\"\nposition = [0, 0, 0]\ninner_cone_angle = 40\nouter_cone_angle = 30",
                "has to be less",
            ),
        ] {
            let error = change(text, LightKind::Point).expect_err(text);
            assert!(error.contains(why), "{text}: {error}");
        }
    }
}
