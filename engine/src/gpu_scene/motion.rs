//! Where instances were and will be, as the camera sees it: for the film's layer of motion.
//!
//! Two records behind those of the instances are about each of them, for kernels have no room for another buffer. Their maps lead
//! from the object to the axes of the camera: of the first record a frame ago and now, of the second one in a frame. Where the vertices of
//! meshes that bend are then stands behind the vertices of all meshes, and where it does in the first record.

use std::collections::BTreeMap;

use bytemuck::Zeroable as _;
use glam::{Affine3A, DAffine3, Mat3, Vec3};

use device::{Device, Resources, Usage};

use crate::scene::{Camera, Scene};

use super::{
    GpuInstance, GpuScene, GpuSceneError, instances,
    moved::{put, write_at},
    rows,
};

/// How a scene is seen a frame before, and a frame after.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Views<'a> {
    /// From where.
    pub(crate) cameras: [&'a Camera; 2],
    /// Where its instances are then.
    pub(crate) transforms: [&'a [Affine3A]; 2],
    /// Where the vertices of meshes that bend are then; nothing of others.
    pub(crate) positions: [&'a [Vec<Vec3>]; 2],
}

impl GpuScene {
    /// Tells kernels what moves, where that is known of all instances.
    ///
    /// # Errors
    /// The device has no room.
    pub(crate) fn show_motion(
        &self,
        device: &Device,
        scene: &Scene,
        camera: &Camera,
        beside: Views<'_>,
        resources: &mut Resources,
    ) -> Result<(), GpuSceneError> {
        let count = scene.instances.len();
        if beside.transforms.iter().any(|list| list.len() != count) {
            return Ok(());
        }
        let meshes = scene.meshes.len();
        let bent = match beside.positions.iter().all(|list| list.len() == meshes) {
            true => self.show_bent(device, beside.positions, resources)?,
            false => BTreeMap::new(),
        };
        let mut records = instances(scene, &self.uploaded.bvh);
        let first = records.len() as u32;
        for at in 0..records.len() {
            let source = records[at].source as usize;
            records[at].motion = first + 2 * at as u32;
            let [before, after] = beside.transforms.map(|list| &list[source]);
            let seen = [
                (beside.cameras[0], before),
                (camera, &scene.instances[source].transform),
                (beside.cameras[1], after),
            ];
            let [before, now, after] =
                seen.map(|(camera, transform)| rows(&in_view(camera, transform)));
            let mesh = scene.instances[source].mesh as usize;
            let bent = bent.get(&mesh).copied().unwrap_or_default();
            records.push(GpuInstance {
                world_from_object: before,
                object_from_world: now,
                root: bent.before,
                source: bent.after,
                id: bent.own,
                asset: bent.stride,
                ..GpuInstance::zeroed()
            });
            records.push(GpuInstance {
                world_from_object: after,
                ..GpuInstance::zeroed()
            });
        }
        put(device, resources, "instances", &records)
    }

    /// Puts the places of the vertices of meshes that bend behind the vertices; where they lie, by the number of the mesh.
    fn show_bent(
        &self,
        device: &Device,
        [before, after]: [&[Vec<Vec3>]; 2],
        resources: &mut Resources,
    ) -> Result<BTreeMap<usize, Bent>, GpuSceneError> {
        let geometry = &self.uploaded.geometry;
        let first = geometry.records();
        let mut heap: Vec<[u32; 4]> = Vec::new();
        let mut bent = BTreeMap::new();
        for (mesh, positions) in before.iter().zip(after).enumerate() {
            let positions: [&Vec<Vec3>; 2] = positions.into();
            let place = geometry.place(mesh);
            let is_bent = |list: &&Vec<Vec3>| !list.is_empty() && list.len() == place.vertices();
            if !positions.iter().all(is_bent) {
                continue;
            }
            let [before, after] = positions.map(|positions| {
                let begin = first + heap.len() as u32;
                heap.extend(
                    positions
                        .iter()
                        .map(|p| p.extend(0.0).to_array().map(f32::to_bits)),
                );
                begin
            });
            let (own, stride) = (place.first_record(), place.stride());
            bent.insert(
                mesh,
                Bent {
                    before,
                    after,
                    own,
                    stride,
                },
            );
        }
        append(device, resources, "vertices", first, &heap)?;
        Ok(bent)
    }
}

/// Where the vertices of a mesh that bends are found, in records of the heap of vertices; all 0 for one that doesn't.
#[derive(Debug, Clone, Copy, Default)]
struct Bent {
    before: u32,
    after: u32,
    /// Those that are seen.
    own: u32,
    stride: u32,
}

/// Writes records behind the first ones of a buffer, which may have to grow for it.
fn append(
    device: &Device,
    resources: &mut Resources,
    name: &'static str,
    first: u32,
    records: &[[u32; 4]],
) -> Result<(), GpuSceneError> {
    if records.is_empty() {
        return Ok(());
    }
    let former = u64::from(first) * size_of::<[u32; 4]>() as u64;
    let bytes: &[u8] = bytemuck::cast_slice(records);
    if resources.buffer(name).size() < former + bytes.len() as u64 {
        let mut all = device.read(resources.buffer(name), 0, former)?;
        all.extend_from_slice(bytes);
        resources.set_buffer(name, device.filled_buffer(name, Usage::Storage, &all)?);
        return Ok(());
    }
    write_at(device, resources.buffer(name), first, records);
    Ok(())
}

/// From an object to the axes of a camera, in double precision: both may be far from the origin.
fn in_view(camera: &Camera, transform: &Affine3A) -> Affine3A {
    let view = wide(&camera.transform).inverse() * wide(transform);
    Affine3A::from_mat3_translation(view.matrix3.as_mat3(), view.translation.as_vec3())
}

fn wide(transform: &Affine3A) -> DAffine3 {
    let axes = Mat3::from(transform.matrix3).as_dmat3();
    DAffine3::from_mat3_translation(axes, Vec3::from(transform.translation).as_dvec3())
}
