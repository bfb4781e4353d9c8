//! Where instances were and will be, as the camera sees it: for the film's layer of motion.
//!
//! Two records behind those of the instances are about each of them, for kernels have no room for another buffer. Their maps lead
//! from the object to the axes of the camera: of the first record a frame ago and now, of the second one in a frame.

use bytemuck::Zeroable as _;
use glam::{Affine3A, DAffine3, Mat3, Vec3};

use device::Device;

use crate::scene::{Camera, Scene};

use super::{GpuInstance, GpuScene, GpuSceneError, instances, moved::put, rows};
use device::Resources;

/// How a scene is seen a frame before, and a frame after.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Views<'a> {
    /// From where.
    pub(crate) cameras: [&'a Camera; 2],
    /// Where its instances are then.
    pub(crate) transforms: [&'a [Affine3A]; 2],
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
            records.push(GpuInstance {
                world_from_object: before,
                object_from_world: now,
                ..GpuInstance::zeroed()
            });
            records.push(GpuInstance {
                world_from_object: after,
                ..GpuInstance::zeroed()
            });
        }
        put(device, resources, "instances", &records)
    }
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
