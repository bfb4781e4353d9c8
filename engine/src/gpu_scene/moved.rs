//! The scene at another moment: what has become of it is written over what was, and what stands still stays where it is.
//!
//! Where two surfaces lie in one place, the order of a hierarchy decides which is hit, and the picture must not depend on what was
//! shown before. So the hierarchy over a mesh that bends follows from that mesh and from what it was before it was bent, never from
//! another moment: on the processor that of the unbent mesh is fitted to it, on other devices one is built anew.

use std::sync::Arc;

use bytemuck::NoUninit;

use device::{Buffer, Device, Resources, Usage, native::accel::BuildError};

use crate::{
    bvh::{BvhError, MeshBvh, SceneBvh},
    scene::{Environment, LightSource, Mesh, Scene},
    texturing::{ProgramTraits, TextureReads},
};

use super::{
    GpuScene, GpuSceneError, MAX_MATERIALS, SceneFeatures,
    bodies::{Bodies, Lamps},
    casters,
    environment::GpuEnvironment,
    geometry::{self, Geometry},
    host_traversal::{Former, HostTraversal},
    images::GpuImages,
    instances,
    lights::LightTable,
    materials::GpuMaterial,
    ray_rules, sphere, update,
};

/// What of each mesh is the same as before, by its number.
struct Same<'a>(&'a [Sameness]);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sameness {
    All,
    Triangles,
    Nothing,
}

impl Same<'_> {
    fn is(&self, mesh: usize) -> bool {
        self.0.get(mesh) == Some(&Sameness::All)
    }

    /// Whether it has the same triangles and materials, maybe in other places.
    fn has_triangles_of(&self, mesh: usize) -> bool {
        let sameness = self.0.get(mesh);
        sameness.is_some_and(|&sameness| sameness != Sameness::Nothing)
    }
}

impl GpuScene {
    /// Brings the device from one scene, which it has, to another one. Kernels are to be bound again, and compiled again where
    /// [`Self::features`] have changed. `program` and `reads` are as for [`Self::new`], those of before as well.
    ///
    /// # Errors
    /// As [`Self::new`]. What is on the device then is of no use.
    pub(crate) fn show(
        &mut self,
        device: &Device,
        [before, scene]: [&Scene; 2],
        [reads_before, reads]: [&TextureReads<'_>; 2],
        program: impl Fn(u32) -> ProgramTraits,
        resources: &mut Resources,
    ) -> Result<(), GpuSceneError> {
        if scene.materials.len() > MAX_MATERIALS {
            return Err(GpuSceneError::TooManyMaterials(scene.materials.len()));
        }
        let (lo, hi) = scene.bounds().ok_or(BvhError::Empty)?;
        (self.bounds, (self.center, self.radius)) = ([lo, hi], sphere(lo, hi));
        let flags = geometry::material_flags(scene, &program);
        let same = match flags == self.uploaded.flags && reads.attributes == reads_before.attributes
        {
            true => (before.meshes.iter().zip(&scene.meshes))
                .map(|(before, mesh)| sameness(before, mesh))
                .collect(),
            false => Vec::new(),
        };
        let same = Same(&same);
        self.show_geometry(device, scene, &program, reads.attributes, &same, resources)?;
        self.show_lights(device, scene, &program, resources)?;
        let has_same_images = has_same_images(before, scene)
            && (reads_before.images, reads_before.with_levels) == (reads.images, reads.with_levels);
        if !has_same_images {
            let images = GpuImages::new(device, scene, reads)?;
            images.name(resources);
            self.user_image_base = images.user_base;
            self.image_bytes = images.bytes;
        }
        let is_adapted = is_same_picture(&before.environment, &scene.environment)
            && self.environment.update(device, &scene.environment);
        if !is_adapted {
            self.environment = GpuEnvironment::new(device, &scene.environment)?;
            self.environment.name(resources);
        }
        self.features = SceneFeatures {
            energy_compensation: self.features.energy_compensation,
            film_layers: self.features.film_layers,
            light_cache: self.features.light_cache,
            irradiance_cache: self.features.irradiance_cache,
            photons: self.features.photons,
            splits_light: self.features.splits_light,
            catches_shadows: self.features.catches_shadows,
            node_layers: self.features.node_layers,
            ..SceneFeatures::of(scene, &program, &flags, self.environment.emits)
        };
        self.environment_group = scene.light_groups.of(LightSource::Environment);
        self.casters = casters::targets(scene, &program);
        self.bodies = Bodies::of(scene, &program);
        self.lamps.forget_bodies();
        self.uploaded.flags = flags;
        Ok(())
    }

    fn show_geometry(
        &mut self,
        device: &Device,
        scene: &Scene,
        program: &dyn Fn(u32) -> ProgramTraits,
        attributes: &[String],
        same: &Same<'_>,
        resources: &mut Resources,
    ) -> Result<(), GpuSceneError> {
        let mut bvh = match device.traits().calls_functions {
            true => self.show_to_host(device, scene, program, same)?,
            false => {
                let former = self.uploaded.meshes.take().unwrap_or_default();
                let keep = |mesh: usize| former.get(mesh).filter(|_| same.is(mesh)).cloned();
                let meshes = MeshBvh::build_all(scene, keep);
                let bvh = SceneBvh::join(scene, &meshes)?;
                self.uploaded.meshes = Some(meshes);
                bvh
            }
        };
        put(device, resources, "nodes", &bvh.nodes)?;
        bvh.nodes = Vec::new();
        put(device, resources, "instances", &instances(scene, &bvh))?;
        let is_in_place = self.uploaded.geometry.has_place_for(scene, attributes)
            && bvh.mesh_first_triangle == self.uploaded.bvh.mesh_first_triangle;
        if !is_in_place {
            let (triangles, vertices, geometry) =
                Geometry::lay_out(scene, &bvh, program, attributes);
            put(device, resources, "triangles", &triangles)?;
            put(device, resources, "vertices", &vertices)?;
            self.uploaded.geometry = geometry;
        } else {
            let flags = geometry::material_flags(scene, program);
            for (number, mesh) in scene.meshes.iter().enumerate() {
                let place = self.uploaded.geometry.place(number);
                if same.is(number) {
                    continue;
                }
                let (mut triangles, mut vertices) = (Vec::new(), Vec::new());
                place.append_vertices(mesh, attributes, &mut vertices);
                place.append_triangles(mesh, &bvh.triangle_order[number], &flags, &mut triangles);
                let first = bvh.mesh_first_triangle[number];
                write_at(device, resources.buffer("triangles"), first, &triangles);
                write_at(
                    device,
                    resources.buffer("vertices"),
                    place.first_record(),
                    &vertices,
                );
            }
        }
        self.uploaded.bvh = bvh;
        if let Some(traversal) = &self.uploaded.traversal {
            traversal.set(resources);
        }
        Ok(())
    }

    fn show_to_host(
        &mut self,
        device: &Device,
        scene: &Scene,
        program: &dyn Fn(u32) -> ProgramTraits,
        same: &Same<'_>,
    ) -> Result<SceneBvh, GpuSceneError> {
        let bvh = SceneBvh::in_scene_order(scene)?;
        let rules = ray_rules(scene, program);
        let former = self.uploaded.traversal.take();
        let is_same = |mesh| same.is(mesh as usize);
        let has_same_triangles = |mesh| same.has_triangles_of(mesh as usize);
        let former = former.as_deref();
        let former = former.map(|traversal| Former::new(traversal, &is_same, &has_same_triangles));
        let traversal: Result<_, BuildError> =
            HostTraversal::with(scene, &bvh, &rules, device.activity(), former.as_ref());
        self.uploaded.traversal = Some(Arc::new(traversal?));
        Ok(bvh)
    }

    fn show_lights(
        &mut self,
        device: &Device,
        scene: &Scene,
        program: &dyn Fn(u32) -> ProgramTraits,
        resources: &mut Resources,
    ) -> Result<(), GpuSceneError> {
        let mut records: Vec<GpuMaterial> = (0..)
            .zip(&scene.materials)
            .map(|(i, m)| {
                let group = scene.light_groups.of(LightSource::Material(&m.name));
                GpuMaterial::new(m, group, &program(i))
            })
            .collect();
        let emission = update::emission(scene, program);
        let lights = match emission == self.uploaded.emission {
            // How bright pictures are is known.
            true => {
                for (record, former) in records.iter_mut().zip(&self.uploaded.materials) {
                    record.set_light_radiance(former.light_radiance());
                }
                LightTable::of(scene, &self.uploaded.bvh, &records)
            }
            false => LightTable::gather(scene, &self.uploaded.bvh, program, &mut records),
        };
        put(device, resources, "lights", &lights.bytes())?;
        put(device, resources, "materials", &records)?;
        self.light_count = lights.placed.len() as u32;
        self.lamps = Lamps::new(lights.lamps);
        self.directional_count = lights.directional.len() as u32;
        self.uploaded.emission = emission;
        self.uploaded.materials = records;
        Ok(())
    }
}

/// Writes what a buffer holds, into a new one where the old one is too small.
pub(super) fn put<T: NoUninit>(
    device: &Device,
    resources: &mut Resources,
    name: &'static str,
    contents: &[T],
) -> Result<(), GpuSceneError> {
    let bytes = bytemuck::cast_slice(contents);
    if resources.buffer(name).size() >= bytes.len() as u64 {
        if !bytes.is_empty() {
            device.write(resources.buffer(name), 0, bytes);
        }
        return Ok(());
    }
    resources.set_buffer(name, device.filled_buffer(name, Usage::Storage, bytes)?);
    Ok(())
}

/// Writes items of a buffer from the one of this number on.
pub(super) fn write_at<T: NoUninit>(device: &Device, buffer: &Buffer, first: u32, items: &[T]) {
    if !items.is_empty() {
        let offset = u64::from(first) * size_of::<T>() as u64;
        device.write(buffer, offset, bytemuck::cast_slice(items));
    }
}

/// What of two meshes is the same to the bit.
fn sameness(a: &Mesh, b: &Mesh) -> Sameness {
    fn bytes<T: NoUninit>(list: &[T]) -> &[u8] {
        bytemuck::cast_slice(list)
    }
    let custom = |mesh: &Mesh| mesh.custom.len();
    let mut customs = a.custom.iter().zip(&b.custom);
    let is_unbent = |a: &Option<Arc<_>>, b: &Option<Arc<_>>| match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => Arc::ptr_eq(a, b) || a == b,
        _ => false,
    };
    let has_same_triangles = bytes(&a.triangles) == bytes(&b.triangles)
        && a.triangle_materials == b.triangle_materials
        && a.colors.is_empty() == b.colors.is_empty();
    let is_all_same = has_same_triangles
        && is_unbent(&a.unbent, &b.unbent)
        && bytes(&a.positions) == bytes(&b.positions)
        && bytes(&a.normals) == bytes(&b.normals)
        && bytes(&a.tangents) == bytes(&b.tangents)
        && bytes(&a.uv0) == bytes(&b.uv0)
        && bytes(&a.uv1) == bytes(&b.uv1)
        && bytes(&a.colors) == bytes(&b.colors)
        && custom(a) == custom(b)
        && customs.all(|(a, b)| a.name == b.name && bytes(&a.values) == bytes(&b.values));
    match (is_all_same, has_same_triangles) {
        (true, _) => Sameness::All,
        (false, true) => Sameness::Triangles,
        (false, false) => Sameness::Nothing,
    }
}

fn has_same_images(a: &Scene, b: &Scene) -> bool {
    let mut images = a.images.iter().zip(&b.images);
    a.images.len() == b.images.len()
        && images.all(|(a, b)| {
            let is_shared = Arc::ptr_eq(&a.rgba8, &b.rgba8);
            (a.width, a.height, a.srgb) == (b.width, b.height, b.srgb)
                && (is_shared || a.rgba8 == b.rgba8)
        })
}

/// Whether environments differ at most in their factors.
fn is_same_picture(a: &Environment, b: &Environment) -> bool {
    match (a, b) {
        (Environment::Constant(_), Environment::Constant(_)) => true,
        (Environment::Image { image: a, .. }, Environment::Image { image: b, .. }) => {
            Arc::ptr_eq(a, b) || (a.width, a.height) == (b.width, b.height) && a.rgb == b.rgb
        }
        _ => false,
    }
}
