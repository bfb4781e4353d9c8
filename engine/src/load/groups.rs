//! Which groups a look puts lights into.

use texgen::Diagnostic;

use crate::scene::look::{LampKind, Look, Spanned};
use crate::scene::{LightSource, MAX_LIGHT_GROUPS, Scene};

use super::light;

/// Puts everything that gives light into the group that the look names.
pub(super) fn apply(look: &Look, scene: &mut Scene) -> Result<(), Diagnostic> {
    let environment =
        (look.environment_group.iter()).map(|group| (LightSource::Environment, group));
    let lights = look.lights.iter().filter_map(|light| {
        let group = light.group.as_ref()?;
        Some((LightSource::Light(&light.name.value), group))
    });
    let materials = look.materials.iter().filter_map(|material| {
        let group = material.group.as_ref()?;
        Some((LightSource::Material(&material.name.value), group))
    });
    for light in &look.lights {
        let is_area = (light.kind.as_ref()).is_some_and(|kind| kind.value == LampKind::Area);
        if let Some(group) = light.group.as_ref().filter(|_| is_area) {
            let material = light::material_name(&light.name.value);
            assign(look, scene, LightSource::Material(&material), group)?;
        }
    }
    for (source, group) in environment.chain(lights).chain(materials) {
        assign(look, scene, source, group)?;
    }
    Ok(())
}

/// Puts a light into a group.
pub(super) fn assign(
    look: &Look,
    scene: &mut Scene,
    source: LightSource<'_>,
    group: &Spanned<String>,
) -> Result<(), Diagnostic> {
    let assigned = scene.light_groups.assign(source, &group.value);
    assigned.map_err(|error| {
        let problem = Diagnostic::error(error.to_string());
        problem
            .with_label(&look.file, group.span.clone(), "")
            .with_note(format!(
                "put lights that go together into one of {MAX_LIGHT_GROUPS}"
            ))
    })
}
