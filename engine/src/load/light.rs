//! The look's overrides of lights of the scene.

use texgen::{Diagnostic, did_you_mean};

use crate::scene::look::{LightLook, Look};
use crate::scene::{LightKind, Scene};

/// Changes the lights of that name.
pub(super) fn apply(look: &Look, wanted: &LightLook, scene: &mut Scene) -> Result<(), Diagnostic> {
    let name = &wanted.name.value;
    let problem = |message: String| {
        Diagnostic::error(message).with_label(&look.file, wanted.name.span.clone(), "")
    };
    if !scene.lights.iter().any(|light| light.name == *name) {
        let names = || scene.lights.iter().map(|light| light.name.as_str());
        let note = match did_you_mean(name, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if scene.lights.is_empty() => "the scene has no punctual lights".to_owned(),
            None => format!("it has {}", names().take(20).collect::<Vec<_>>().join(", ")),
        };
        return Err(problem(format!("the scene has no light called `{name}`")).with_note(note));
    }
    let Some(diameter) = &wanted.angular_diameter else {
        return Ok(());
    };
    for light in scene.lights.iter_mut().filter(|l| l.name == *name) {
        light.kind = match light.kind {
            LightKind::Directional | LightKind::Disk { .. } if diameter.value > 0.0 => {
                LightKind::Disk {
                    angular_diameter: diameter.value.to_radians(),
                }
            }
            LightKind::Directional | LightKind::Disk { .. } => LightKind::Directional,
            LightKind::Point | LightKind::Spot { .. } => {
                return Err(problem(format!(
                    "`{name}` is not a directional light: only those can have an `angular_diameter`"
                ))
                .with_note("give a lamp its size by a mesh with an emissive material"));
            }
        };
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::Vec3;

    use super::*;
    use crate::scene::PunctualLight;

    fn change(text: &str, kind: LightKind) -> Result<LightKind, String> {
        let look = Look::parse(Path::new("test.look.toml"), text).unwrap();
        let mut scene = Scene {
            lights: vec![PunctualLight {
                name: "Sun".to_owned(),
                intensity: Vec3::ONE,
                position: Vec3::ZERO,
                direction: Vec3::NEG_Y,
                range: f32::INFINITY,
                kind,
            }],
            ..Scene::default()
        };
        for light in &look.lights {
            apply(&look, light, &mut scene).map_err(|problem| problem.render())?;
        }
        Ok(scene.lights[0].kind)
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
    fn other_names_and_kinds_are_mistakes() {
        let error = change("[light.Sum]", LightKind::Directional).unwrap_err();
        assert!(error.contains("did you mean `Sun`?"), "{error}");
        let error = change("[light.Sun]\nangular_diameter = 1", LightKind::Point).unwrap_err();
        assert!(error.contains("not a directional light"), "{error}");
    }
}
