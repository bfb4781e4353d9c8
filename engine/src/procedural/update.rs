//! One table of the look has changed: what follows from it for graph, wiring and material constants, so that all is as
//! if it had been built from the changed look.

use texgen::{Diagnostic, Diagnostics, NodeId, Parameter, SourceFile, did_you_mean};

use crate::scene::Scene;
use crate::scene::look::{AoSettings, Field, Input, MaterialLook, NodeLook, Span, Spanned, find};

use super::materials::{Resolver, copy_bases};
use super::values::{Argument, argument};
use super::wiring::Wiring;
use super::{EditError, Procedural};

/// Why a change of a table was not followed.
#[derive(Debug)]
pub(crate) enum UpdateError {
    /// It is wrong. Earlier parts of the same table may have been followed.
    Refused(Diagnostics),
    /// It reaches what is made once, from the whole look.
    Rebuild,
    /// The node's texture is not in the kernel.
    NewTexture,
}

impl From<EditError> for UpdateError {
    fn from(error: EditError) -> Self {
        Self::Refused(Diagnostic::error(error.to_string()).into())
    }
}

fn at(file: &SourceFile, span: &Span, error: impl ToString) -> UpdateError {
    let problem = Diagnostic::error(error.to_string());
    UpdateError::Refused(problem.with_label(file, span.clone(), "").into())
}

impl Procedural {
    /// Makes sure that a node is there, of the texture that its table names.
    pub(crate) fn ensure_node(&mut self, table: &NodeLook) -> Result<(), UpdateError> {
        let texture = &table.texture.value;
        match self.graph.node(&table.name.value) {
            Some(node) if self.graph.texture(node).name() == texture => Ok(()),
            Some(_) => Err(UpdateError::Rebuild),
            None if self.graph.library().get(texture).is_none() => Err(UpdateError::NewTexture),
            None => Ok(self.add_node(&table.name.value, texture)?),
        }
    }

    /// Brings a node from one version of its table to another.
    pub(crate) fn update_node(
        &mut self,
        file: &SourceFile,
        before: &[Field],
        table: &NodeLook,
    ) -> Result<(), UpdateError> {
        self.ensure_node(table)?;
        let name = &table.name.value;
        let node = self.node(name)?;
        let is_parameter = |key: &str| !["texture", "occlusion", "occlusion1"].contains(&key);
        for field in before.iter().filter(|f| is_parameter(&f.key.value)) {
            if find(&table.params, &field.key.value).is_none() {
                self.reset_parameter(node, &field.key.value)?;
            }
        }
        for field in &table.params {
            let key = &field.key.value;
            let Some((_, parameter)) = self.graph.texture(node).parameter(key) else {
                let names = self.graph.texture(node).parameters().iter();
                let near = did_you_mean(key, names.map(|p| p.name.as_str()));
                let hint = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                let texture = &table.texture.value;
                let message = format!("texture `{texture}` has no parameter `{key}`{hint}");
                return Err(at(file, &field.key.span, message));
            };
            let parameter = parameter.clone();
            let is_same = |old: &Spanned<_>| field.value.value.is_same(&old.value);
            if !find(before, key).is_some_and(is_same) {
                self.update_parameter(file, name, &parameter, field)?;
            }
        }
        let second = u32::from(self.ao_count() > 1);
        let mut slots = [0, second];
        for (slot, wanted) in slots.iter_mut().zip([&table.occlusion, &table.occlusion1]) {
            if let Some(wanted) = wanted {
                *slot = (self.ao_slot(&wanted.value)).map_err(|e| at(file, &wanted.span, e))?;
            }
        }
        self.set_occlusion_slots(node, slots)
            .map_err(|error| at(file, &table.name.span, error))
    }

    fn update_parameter(
        &mut self,
        file: &SourceFile,
        name: &str,
        parameter: &Parameter,
        field: &Field,
    ) -> Result<(), UpdateError> {
        let span = &field.value.span;
        let given = argument(&field.value, parameter.ty).map_err(|bad| {
            at(
                file,
                &bad.span,
                format!("`{}`: {}", parameter.name, bad.message),
            )
        })?;
        let done = match given {
            Argument::Constant(value) => self.set_value(name, &parameter.name, value),
            Argument::Link(link) => {
                let swizzle = link.swizzle.map_or(String::new(), |s| s.to_string());
                self.set_link(name, &parameter.name, &format!("{}{swizzle}", link.node))
            }
            Argument::Image(_) => return Err(UpdateError::Rebuild),
        };
        done.map_err(|error| at(file, span, error))
    }

    /// What a node without its table is: one with default values that nothing reads.
    pub(crate) fn release_node(&mut self, name: &str) -> Result<(), UpdateError> {
        let Some(node) = self.graph.node(name) else {
            return Ok(());
        };
        if self.is_read(node) {
            let message = format!("node `{name}` is in use: something links to it");
            return Err(UpdateError::Refused(Diagnostic::error(message).into()));
        }
        let parameters = self.graph.texture(node).parameters();
        let names: Vec<String> = parameters.iter().map(|p| p.name.clone()).collect();
        for parameter in &names {
            self.reset_parameter(node, parameter)?;
        }
        Ok(())
    }

    pub(super) fn is_read(&self, node: NodeId) -> bool {
        let drives = |wiring: &Wiring| wiring.nodes.contains(&node);
        let links = |reader: NodeId| {
            let parameters = self.graph.texture(reader).parameters().iter();
            let mut links = parameters.filter_map(|p| self.graph.link(reader, &p.name));
            links.any(|link| link.source == node)
        };
        self.wiring.iter().any(drives) || self.graph.ids().any(links)
    }

    fn reset_parameter(&mut self, node: NodeId, parameter: &str) -> Result<(), UpdateError> {
        let Some((_, declared)) = self.graph.texture(node).parameter(parameter) else {
            return Ok(()); // a parameter of a former version of the texture
        };
        if declared.default.is_none() {
            return Err(UpdateError::Rebuild);
        }
        let edit = self.graph.reset(node, parameter).map_err(EditError::from)?;
        Ok(self.finish(node, &edit).map_err(EditError::from)?)
    }

    /// Brings a material to its table. `table` is empty where the look no longer has one.
    pub(crate) fn update_material(
        &mut self,
        scene: &mut Scene,
        file: &SourceFile,
        table: &MaterialLook,
    ) -> Result<(), UpdateError> {
        let name = &table.name.value;
        let Some(&index) = self.material_names.get(name) else {
            return Err(UpdateError::Rebuild);
        };
        let surface = self.surface_names.get(name).copied();
        let wanted = table.blend.as_ref().map(|blend| {
            let blend = &blend.value;
            let of = |name: &String| self.material_names.get(name).copied();
            let base = match blend.base.value == *name {
                true => surface,
                false => of(&blend.base.value),
            };
            (base, of(&blend.over.value))
        });
        let wired = self.wiring[index as usize].blend.as_ref();
        let wired = wired.map(|blend| (Some(blend.base), Some(blend.over)));
        // Which materials there are, and which lie below which, is decided once.
        let is_added = index as usize >= self.scene_materials;
        if wanted != wired || is_added && table.inputs().next().is_none() && wanted.is_none() {
            return Err(UpdateError::Rebuild);
        }
        self.check_links(file, table)?;

        let own = surface.unwrap_or(index);
        let former = (
            scene.materials[own as usize].clone(),
            self.wiring[own as usize].clone(),
            self.wiring[index as usize].clone(),
        );
        scene.materials[own as usize] = self.originals[own as usize].clone();
        let problems = Resolver::update(self, scene, file, table, own);
        let outcome = if problems.has_errors() {
            Err(UpdateError::Refused(problems))
        } else {
            let both = [own, index];
            let compiled = both.map(|material| self.compile(material));
            match compiled {
                [Ok(a), Ok(b)] => {
                    self.store_all([a, b]);
                    Ok(())
                }
                [Err(error), _] | [_, Err(error)] => Err(at(file, &table.name.span, error)),
            }
        };
        if outcome.is_err() {
            scene.materials[own as usize] = former.0;
            self.wiring[own as usize] = former.1;
            self.wiring[index as usize] = former.2;
        }
        copy_bases(scene, &self.wiring, &self.order);
        outcome
    }

    fn check_links(&self, file: &SourceFile, table: &MaterialLook) -> Result<(), UpdateError> {
        let mask = table.blend.as_ref().map(|blend| &blend.value.mask);
        for input in table.inputs().chain(mask) {
            if let Input::Link(link) = &input.value
                && let Err(error) = self.node(&link.node)
            {
                return Err(at(file, &input.span, error));
            }
        }
        Ok(())
    }

    /// Changes how an AO table is traced.
    pub(crate) fn update_ao(
        &mut self,
        name: &str,
        settings: AoSettings,
    ) -> Result<(), UpdateError> {
        // A look without tables has one that it doesn't name.
        match self.ao_slot(name) {
            Ok(_) => Ok(self.set_ao(name, settings)?),
            Err(_) => Err(UpdateError::Rebuild),
        }
    }
}
