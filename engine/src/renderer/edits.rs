//! Live edits: what the user changes becomes a few words written to buffers. Pipelines are touched only when a
//! program outgrows the kernel's stack or a scene gets its first program.

use std::ops::Range;

use device::{Device, DeviceError, Resources, Usage};

use crate::{
    gpu_scene::materials,
    procedural::{EditError, Output, Procedural},
    scene::look::{AoDirection, AoSettings},
    schedule::Schedule,
    wave::GpuAoTable,
};

use super::{RenderError, Renderer};

/// Why an edit did not happen. The picture and the graph are as before.
#[derive(Debug, thiserror::Error)]
pub enum RenderEditError {
    /// The graph refused it.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Emission and opacity decide which triangles are lights and which let rays pass; those tables are made when the
    /// scene is loaded. So are kernels without transmission or layers where no material has any.
    #[error(
        "`{material}` can't begin or cease to be driven in this way while rendering; change the look and load it again"
    )]
    Light {
        /// The material.
        material: String,
    },
}

impl From<DeviceError> for RenderEditError {
    fn from(error: DeviceError) -> Self {
        Self::Render(error.into())
    }
}

/// Creates the buffers of programs, arguments and AO tables, with room to grow.
pub(super) fn allocate(
    gpu: &Device,
    procedural: &Procedural,
    schedule: &dyn Schedule,
    resources: &mut Resources,
) -> Result<(), RenderError> {
    for (name, words) in [
        ("programs", &*schedule.program_words(procedural)?),
        ("args", procedural.args()),
    ] {
        let bytes = (words.len() as u64 * 4 * 3 / 2).max(1024);
        let buffer = gpu.buffer(name, Usage::Storage, bytes)?;
        gpu.write(&buffer, 0, bytemuck::cast_slice(words));
        resources.set_buffer(name, buffer);
    }
    write_ao(gpu, procedural, resources);
    Ok(())
}

fn write_ao(gpu: &Device, procedural: &Procedural, resources: &Resources) {
    let mut tables = [GpuAoTable::default(); 4];
    // A look without tables still has its default one, which nodes that read AO use.
    let used = procedural.ao_count().max(1);
    for (table, settings) in tables.iter_mut().zip(procedural.ao()).take(used) {
        *table = ao_table(settings);
    }
    gpu.write(
        resources.buffer("ao_tables"),
        0,
        bytemuck::cast_slice(&tables),
    );
}

fn ao_table(settings: &AoSettings) -> GpuAoTable {
    GpuAoTable {
        distance: settings.distance,
        direction: match settings.direction {
            AoDirection::Outside => 0,
            AoDirection::Inside => 1,
            AoDirection::Both => 2,
        },
        samples: settings.samples.min(255),
        same_object: u32::from(settings.same_object),
    }
}

impl Renderer {
    /// Sets a parameter of a node to a constant. One small buffer write.
    ///
    /// # Errors
    /// Unknown names, a value of another type, or the device.
    pub fn set_argument(
        &mut self,
        node: &str,
        parameter: &str,
        value: texgen::Value,
    ) -> Result<(), RenderEditError> {
        self.edit(|p| p.set_value(node, parameter, value))
    }

    /// Links a parameter to another node's result, such as `"mask"` or `"mask.x"`. One small buffer write.
    ///
    /// # Errors
    /// Unknown names, a type that does not fit, a circle, or the device.
    pub fn set_link(
        &mut self,
        node: &str,
        parameter: &str,
        link: &str,
    ) -> Result<(), RenderEditError> {
        self.edit(|p| p.set_link(node, parameter, link))
    }

    /// Gives a linked parameter its constant back. One small buffer write.
    ///
    /// # Errors
    /// Unknown names, or the device.
    pub fn clear_link(&mut self, node: &str, parameter: &str) -> Result<(), RenderEditError> {
        self.edit(|p| p.clear_link(node, parameter))
    }

    /// Adds a node of one of the kernel's textures, with default values; nothing reads it yet. A small buffer write.
    ///
    /// # Errors
    /// Unknown texture, a name that is taken, or the device.
    pub fn add_node(&mut self, node: &str, texture: &str) -> Result<(), RenderEditError> {
        self.edit(|p| p.add_node(node, texture))
    }

    /// Changes an AO table. One small buffer write.
    ///
    /// # Errors
    /// Unknown name, settings out of range, or the device.
    pub fn set_ao(&mut self, name: &str, settings: AoSettings) -> Result<(), RenderEditError> {
        self.edit(|p| p.set_ao(name, settings))
    }

    /// Drives an output of a material by a node's result, or gives it its constant back. Small buffer writes.
    ///
    /// # Errors
    /// Unknown names, a type that does not fit, an emission or opacity that would begin or cease to be driven, or the
    /// device.
    pub fn set_output_link(
        &mut self,
        material: &str,
        output: Output,
        link: Option<&str>,
    ) -> Result<(), RenderEditError> {
        let before = self.procedural.clone();
        self.procedural.set_output_link(material, output, link)?;
        let count = self.material_count();
        // What the light table, the triangles and the kernels were made for.
        let light = |p: &Procedural, m| {
            let traits = p.traits(m);
            (
                traits.transmits && !self.scene.features.transmission,
                traits.has_layers && !self.scene.features.layers,
                traits.decides_light,
                traits.decides_opacity,
                traits.brightness > 0.0,
            )
        };
        if (0..count).any(|m| light(&before, m) != light(&self.procedural, m)) {
            self.procedural = before;
            return Err(RenderEditError::Light {
                material: material.to_owned(),
            });
        }
        for m in 0..count {
            let flags = |p: &Procedural| materials::program_flags(&p.traits(m));
            if flags(&before) != flags(&self.procedural) {
                let buffer = self.resources.buffer("materials");
                let offset = u64::from(m) * size_of::<materials::GpuMaterial>() as u64
                    + materials::FLAGS_OFFSET;
                let former = self.gpu.read(buffer, offset, 4)?;
                let mut word: u32 = bytemuck::pod_read_unaligned(&former);
                word = word & !materials::PROGRAM_FLAGS | flags(&self.procedural);
                self.gpu.write(buffer, offset, bytemuck::bytes_of(&word));
            }
        }
        self.write_changes()
    }

    /// The texture graph as it is now.
    pub fn procedural(&self) -> &Procedural {
        &self.procedural
    }

    fn material_count(&self) -> u32 {
        (self.resources.buffer("materials").size() / size_of::<materials::GpuMaterial>() as u64)
            as u32
    }

    fn edit(
        &mut self,
        change: impl FnOnce(&mut Procedural) -> Result<(), EditError>,
    ) -> Result<(), RenderEditError> {
        change(&mut self.procedural)?;
        self.write_changes()
    }

    /// Writes what changed and starts the picture anew.
    pub(super) fn write_changes(&mut self) -> Result<(), RenderEditError> {
        let changes = self.procedural.take_changes();
        if changes.is_empty() {
            return Ok(());
        }
        let needs_kernels = !self.kernels.has_texture() && !self.procedural.is_empty();
        let are_code = self.schedule.edits_are_code();
        let needs_kernels = needs_kernels || changes.kernel || are_code;
        if needs_kernels {
            self.scene.features.programs = true;
            self.kernels.rebuild_texture(
                &self.gpu,
                &self.scene.features,
                &self.procedural,
                &*self.schedule,
            )?;
        }
        let grown = self.schedule.grow_results(
            &self.gpu,
            self.capacity,
            self.procedural.result_words(),
            &mut self.resources,
        )?;
        let fits = |name: &str, words: &[u32]| {
            self.resources.buffer(name).size() >= words.len() as u64 * 4
        };
        if grown
            || are_code
            || !fits("programs", self.procedural.programs())
            || !fits("args", self.procedural.args())
        {
            allocate(
                &self.gpu,
                &self.procedural,
                &*self.schedule,
                &mut self.resources,
            )?;
            self.bound = self.kernels.bind(&self.gpu, &self.resources);
        } else {
            self.write_ranges("programs", self.procedural.programs(), &changes.programs);
            self.write_ranges("args", self.procedural.args(), &changes.args);
            if needs_kernels {
                self.bound = self.kernels.bind(&self.gpu, &self.resources);
            }
        }
        if changes.ao {
            write_ao(&self.gpu, &self.procedural, &self.resources);
        }
        self.restart();
        Ok(())
    }

    fn write_ranges(&self, name: &str, words: &[u32], ranges: &[Range<u32>]) {
        for range in ranges {
            let words = &words[range.start as usize..range.end as usize];
            self.gpu.write(
                self.resources.buffer(name),
                u64::from(range.start) * 4,
                bytemuck::cast_slice(words),
            );
        }
    }
}
