//! Named resources, which kernels find by the names in their texts.

use std::{collections::BTreeMap, sync::Arc};

use crate::{Buffer, HostFunction, Image, gpu::Structure};

/// Named resources that kernels bind. Clones share them.
#[derive(Debug, Clone, Default)]
pub struct Resources {
    buffers: BTreeMap<&'static str, Buffer>,
    images: BTreeMap<&'static str, Image>,
    structures: BTreeMap<&'static str, Structure>,
    functions: BTreeMap<&'static str, Arc<dyn HostFunction>>,
}

/// What a kernel binds.
#[derive(Debug)]
pub(crate) enum Resource<'a> {
    Buffer(&'a Buffer),
    Image(&'a Image),
    Structure(&'a Structure),
    Function(&'a Arc<dyn HostFunction>),
}

impl Resources {
    /// Adds or replaces a buffer.
    pub fn set_buffer(&mut self, name: &'static str, buffer: Buffer) {
        self.buffers.insert(name, buffer);
    }

    /// Adds or replaces an image.
    pub fn set_image(&mut self, name: &'static str, image: Image) {
        self.images.insert(name, image);
    }

    /// Adds or replaces an acceleration structure.
    pub fn set_structure(&mut self, name: &'static str, structure: Structure) {
        self.structures.insert(name, structure);
    }

    /// Adds or replaces a function that stands for one of the kernels' texts.
    pub fn set_function(&mut self, name: &'static str, function: Arc<dyn HostFunction>) {
        self.functions.insert(name, function);
    }

    /// Those of these names alone.
    #[must_use]
    pub fn only(mut self, names: &[&str]) -> Self {
        self.buffers.retain(|name, _| names.contains(name));
        self.images.retain(|name, _| names.contains(name));
        self.structures.retain(|name, _| names.contains(name));
        self.functions.retain(|name, _| names.contains(name));
        self
    }

    /// With others in the place of those of their names, or beside them.
    #[must_use]
    pub fn overlaid(mut self, others: &Self) -> Self {
        let Self {
            buffers,
            images,
            structures,
            functions,
        } = others.clone();
        self.buffers.extend(buffers);
        self.images.extend(images);
        self.structures.extend(structures);
        self.functions.extend(functions);
        self
    }

    /// A buffer by name.
    ///
    /// # Panics
    /// If there is none: names are fixed in the program and every kernel is bound in tests.
    pub fn buffer(&self, name: &str) -> &Buffer {
        self.buffers
            .get(name)
            .unwrap_or_else(|| panic!("no buffer is named `{name}`"))
    }

    /// Bytes of each buffer, by name.
    pub fn buffer_sizes(&self) -> impl Iterator<Item = (&'static str, u64)> {
        self.buffers
            .iter()
            .map(|(name, buffer)| (*name, buffer.size()))
    }

    pub(crate) fn get(&self, name: &str) -> Resource<'_> {
        if let Some(buffer) = self.buffers.get(name) {
            return Resource::Buffer(buffer);
        }
        if let Some(structure) = self.structures.get(name) {
            return Resource::Structure(structure);
        }
        if let Some(function) = self.functions.get(name) {
            return Resource::Function(function);
        }
        match self.images.get(name) {
            Some(image) => Resource::Image(image),
            None => panic!("no resource is named `{name}`, which a kernel declares"),
        }
    }
}
