//! Material constants that change while rendering: the records, and the lights that follow from them, are written
//! anew. What kernels and geometry were made for stays, or the scene has to be uploaded again.

use std::sync::Arc;

use glam::Vec3;

use device::{Device, Resources, Usage};

use crate::{
    bvh::{MeshBvh, SceneBvh},
    scene::{LightSource, Material, Scene},
    texturing::ProgramTraits,
};

use super::{
    GpuScene, GpuSceneError, Shadows,
    bodies::{Bodies, Lamps},
    casters,
    geometry::{self, Geometry},
    host_traversal::HostTraversal,
    lights::LightTable,
    materials,
    materials::GpuMaterial,
};

/// What is remembered of the upload.
#[derive(Debug)]
pub(super) struct Uploaded {
    pub(super) materials: Vec<GpuMaterial>,
    /// What the triangles say of their materials.
    pub(super) flags: Vec<[u32; 2]>,
    pub(super) emission: Vec<Emission>,
    /// Without its nodes.
    pub(super) bvh: SceneBvh,
    /// Where the meshes lie.
    pub(super) geometry: Geometry,
    /// The hierarchy of a device that has its own.
    pub(super) traversal: Option<Arc<HostTraversal>>,
    /// Those of meshes, once the scene has moved.
    pub(super) meshes: Option<Vec<MeshBvh>>,
}

/// What the table of lights follows from, of one material.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Emission {
    constant: Vec3,
    image: Option<u32>,
    unlit: bool,
    double_sided: bool,
    by_program: Option<f32>,
}

impl Uploaded {
    pub(super) fn new(
        scene: &Scene,
        program: impl Fn(u32) -> ProgramTraits,
        materials: Vec<GpuMaterial>,
        bvh: SceneBvh,
    ) -> Self {
        Self {
            materials,
            flags: geometry::material_flags(scene, &program),
            emission: emission(scene, program),
            bvh,
            geometry: Geometry::default(),
            traversal: None,
            meshes: None,
        }
    }

    pub(super) fn flags(&self) -> &[[u32; 2]] {
        &self.flags
    }

    /// Whether a surface may emit that isn't in the table of lights.
    pub(super) fn glows(&self) -> bool {
        let glows = |material: &Emission| material.unlit || material.by_program.is_some();
        self.emission.iter().any(glows)
    }

    pub(super) fn hierarchy(&self) -> &SceneBvh {
        &self.bvh
    }
}

pub(super) fn emission(scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> Vec<Emission> {
    let of = |(index, material): (u32, &Material)| {
        let program = program(index);
        Emission {
            constant: material.emission,
            image: material.emission_texture.map(|texture| texture.image),
            unlit: material.unlit,
            double_sided: material.double_sided,
            by_program: program.decides_light.then_some(program.brightness),
        }
    };
    (0..).zip(&scene.materials).map(of).collect()
}

/// What became of changed materials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Update {
    /// They are on the GPU.
    Written {
        /// A buffer is another one now: kernels are to be bound again.
        is_moved: bool,
    },
    /// They reach what is made once; nothing has been written.
    Rebuild,
}

impl GpuScene {
    /// Writes what has changed of the materials and the lights made of them.
    ///
    /// # Errors
    /// The device has no room for the lights.
    pub(crate) fn update_materials(
        &mut self,
        device: &Device,
        scene: &Scene,
        program: impl Fn(u32) -> ProgramTraits,
        resources: &mut Resources,
    ) -> Result<Update, GpuSceneError> {
        let count = scene.materials.len();
        if count != self.uploaded.materials.len()
            || geometry::material_flags(scene, &program) != self.uploaded.flags
            || !self.can_show(scene, &program)
        {
            return Ok(Update::Rebuild);
        }
        let mut records: Vec<GpuMaterial> = (0..)
            .zip(&scene.materials)
            .map(|(i, m)| {
                GpuMaterial::new(
                    m,
                    scene.light_groups.of(LightSource::Material(&m.name)),
                    &program(i),
                )
            })
            .collect();
        let mut is_moved = false;
        let emission = emission(scene, &program);
        if emission == self.uploaded.emission {
            for (record, former) in records.iter_mut().zip(&self.uploaded.materials) {
                record.set_light_radiance(former.light_radiance());
            }
        } else {
            let lights = LightTable::gather(scene, &self.uploaded.bvh, &program, &mut records);
            // Whether there are lights at all is decided once.
            if lights.placed.is_empty() != (self.light_count == 0) {
                return Ok(Update::Rebuild);
            }
            is_moved = write_lights(device, &lights, resources)?;
            self.light_count = lights.placed.len() as u32;
            self.lamps = Lamps::new(lights.lamps);
            self.uploaded.emission = emission;
        }
        let size = size_of::<GpuMaterial>();
        for (i, (record, former)) in records.iter().zip(&self.uploaded.materials).enumerate() {
            if bytemuck::bytes_of(record) != bytemuck::bytes_of(former) {
                let buffer = resources.buffer("materials");
                let bytes = bytemuck::bytes_of(record);
                device.write(buffer, (i * size) as u64, bytes);
            }
        }
        self.uploaded.materials = records;
        self.casters = casters::targets(scene, &program);
        if !self.bodies.have_bounds_of(scene, &program) {
            self.bodies = Bodies::of(scene, &program);
            self.lamps.forget_bodies();
        }
        Ok(Update::Written { is_moved })
    }

    /// Writes the lights anew after punctual ones have changed.
    ///
    /// # Errors
    /// The device has no room for them.
    pub(crate) fn update_lights(
        &mut self,
        device: &Device,
        scene: &Scene,
        resources: &mut Resources,
    ) -> Result<Update, GpuSceneError> {
        let lights = LightTable::of(scene, &self.uploaded.bvh, &self.uploaded.materials);
        // Whether there are lights of either kind at all is decided once.
        let had = [self.light_count, self.directional_count].map(|count| count > 0);
        if had != [&lights.placed, &lights.directional].map(|lights| !lights.is_empty()) {
            return Ok(Update::Rebuild);
        }
        let is_moved = write_lights(device, &lights, resources)?;
        self.light_count = lights.placed.len() as u32;
        self.lamps = Lamps::new(lights.lamps);
        self.directional_count = lights.directional.len() as u32;
        Ok(Update::Written { is_moved })
    }

    /// Whether the kernels can do all that the materials need.
    fn can_show(&self, scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> bool {
        let indexed = || (0..).zip(&scene.materials);
        let transmits = indexed().any(|(i, m)| materials::transmits(m) || program(i).transmits);
        let has_layers = indexed().any(|(i, m)| materials::has_layers(m) || program(i).has_layers);
        let former = Shadows {
            by_program: self.features.program_shadows,
            clear: self.features.clear,
            passages: self.features.passages,
        };
        (self.features.transmission || !transmits)
            && (self.features.layers || !has_layers)
            && Shadows::of(scene, program) == former
    }
}

/// Writes a table of lights; whether its buffer is another one now.
fn write_lights(
    device: &Device,
    lights: &LightTable,
    resources: &mut Resources,
) -> Result<bool, GpuSceneError> {
    let bytes = &lights.bytes()[..];
    let is_moved = resources.buffer("lights").size() < bytes.len() as u64;
    match is_moved {
        true => {
            let buffer = device.filled_buffer("lights", Usage::Storage, bytes)?;
            resources.set_buffer("lights", buffer);
        }
        false => device.write(resources.buffer("lights"), 0, bytes),
    }
    Ok(is_moved)
}
