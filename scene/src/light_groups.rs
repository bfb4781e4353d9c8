//! Groups of lights, which a film can keep apart.

use std::collections::BTreeMap;

/// Most groups of a scene.
pub const MAX_LIGHT_GROUPS: usize = 15;

/// What the lights of no group are called, where groups have names.
pub const UNGROUPED: &str = "rest";

/// What gives light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LightSource<'a> {
    /// The environment.
    Environment,
    /// Punctual lights of that name.
    Light(&'a str),
    /// What a material of that name emits.
    Material(&'a str),
}

/// Which light belongs to which group. Groups are numbered from 1 on in the order in which they are first named; 0 is what
/// belongs to none.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LightGroups {
    names: Vec<String>,
    environment: u32,
    lights: BTreeMap<String, u32>,
    materials: BTreeMap<String, u32>,
}

/// There are more groups than a film keeps apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("there are more than {MAX_LIGHT_GROUPS} groups of lights")]
pub struct TooManyLightGroups;

impl LightGroups {
    /// Puts a light into the group of that name.
    ///
    /// # Errors
    /// It would be one group too many.
    pub fn assign(
        &mut self,
        light: LightSource<'_>,
        group: &str,
    ) -> Result<(), TooManyLightGroups> {
        let place = self.names.iter().position(|name| name == group);
        let place = place.unwrap_or(self.names.len());
        if place == MAX_LIGHT_GROUPS {
            return Err(TooManyLightGroups);
        }
        if place == self.names.len() {
            self.names.push(group.to_owned());
        }
        let number = place as u32 + 1;
        match light {
            LightSource::Environment => self.environment = number,
            LightSource::Light(name) => {
                self.lights.insert(name.to_owned(), number);
            }
            LightSource::Material(name) => {
                self.materials.insert(name.to_owned(), number);
            }
        }
        Ok(())
    }

    /// The number of a light's group; 0 where it belongs to none.
    pub fn of(&self, light: LightSource<'_>) -> u32 {
        match light {
            LightSource::Environment => self.environment,
            LightSource::Light(name) => self.lights.get(name).copied().unwrap_or(0),
            LightSource::Material(name) => self.materials.get(name).copied().unwrap_or(0),
        }
    }

    /// Names of the groups, that of group 1 first.
    pub fn names(&self) -> &[String] {
        &self.names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_of_one_name_are_in_one_group() {
        let mut groups = LightGroups::default();
        groups.assign(LightSource::Light("a"), "key").expect("room");
        groups
            .assign(LightSource::Material("a"), "fill")
            .expect("room");
        groups
            .assign(LightSource::Environment, "key")
            .expect("room");
        assert_eq!(groups.names(), ["key", "fill"]);
        assert_eq!(groups.of(LightSource::Light("a")), 1);
        assert_eq!(groups.of(LightSource::Material("a")), 2);
        assert_eq!(groups.of(LightSource::Environment), 1);
        assert_eq!(groups.of(LightSource::Light("b")), 0);
    }

    #[test]
    fn groups_are_counted() {
        let mut groups = LightGroups::default();
        for number in 0..MAX_LIGHT_GROUPS {
            let name = number.to_string();
            groups
                .assign(LightSource::Light(&name), &name)
                .expect("room");
        }
        assert!(groups.assign(LightSource::Light("z"), "3").is_ok());
        let more = groups.assign(LightSource::Light("z"), "one more");
        assert_eq!(more, Err(TooManyLightGroups));
    }
}
