//! Lights that are edited while the picture refines.

use texgen::SourceFile;

use crate::load::{change_light, own_light};
use crate::procedural::UpdateError;
use crate::scene::PunctualLight;
use crate::scene::look::{Field, LampKind, LightLook, Spanned, Table, table};

use super::Session;
use super::difference::TableChange;

impl Session {
    /// Changes lights of the scene as their table says. Lights that come or go, that are rectangles, or that are in another group, need
    /// the scene to be brought to the device again.
    pub(super) fn follow_light(
        &mut self,
        file: &SourceFile,
        name: &str,
        change: &TableChange,
    ) -> Result<(), UpdateError> {
        let section = &change.section;
        let read = |fields: Option<&[Field]>| match fields {
            Some(fields) => match table(file, section, fields, &change.span) {
                Ok(Table::Light(light)) => Ok(*light),
                Ok(_) => Err(UpdateError::Rebuild),
                Err(problems) => Err(UpdateError::Refused(problems)),
            },
            None => {
                let name = Spanned::new(name.to_owned(), change.span.clone());
                Ok(LightLook::named(name))
            }
        };
        let after = read(change.after.as_deref())?;
        let before = read(change.before.as_deref())?;
        let kind = |light: &LightLook| light.kind.as_ref().map(|kind| kind.value);
        let group = |light: &LightLook| light.group.as_ref().map(|group| group.value.clone());
        let is_area = kind(&after) == Some(LampKind::Area);
        if kind(&before) != kind(&after) || group(&before) != group(&after) || is_area {
            return Err(UpdateError::Rebuild);
        }
        let changed = self.changed_lights(file, name, &after)?;
        let places = self.scene.lights.iter_mut().filter(|l| l.name == name);
        let mut places: Vec<&mut PunctualLight> = places.collect();
        if changed.is_empty() || places.len() != changed.len() {
            return Err(UpdateError::Rebuild);
        }
        for (place, light) in places.iter_mut().zip(changed) {
            **place = light;
        }
        Ok(())
    }

    /// The lights of a name as a table makes them.
    fn changed_lights(
        &self,
        file: &SourceFile,
        name: &str,
        wanted: &LightLook,
    ) -> Result<Vec<PunctualLight>, UpdateError> {
        let made: Result<Vec<_>, _> = match &wanted.kind {
            Some(kind) => own_light(file, wanted, kind.value).map(|light| vec![light]),
            None => {
                let given = self.given_lights.iter().filter(|light| light.name == name);
                let change = |light: &PunctualLight| {
                    let mut light = light.clone();
                    change_light(file, wanted, &mut light).map(|()| light)
                };
                given.map(change).collect()
            }
        };
        made.map_err(|problem| UpdateError::Refused(problem.into()))
    }
}
