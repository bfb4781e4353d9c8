//! Everything that is rendered, and how large it is.

use glam::Vec3;

use crate::{Camera, Environment, Image, Instance, LightGroups, Material, Mesh, PunctualLight};

/// Everything that is rendered.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Geometry in object space; instances refer to it by index.
    pub meshes: Vec<Mesh>,
    /// Meshes placed in the world.
    pub instances: Vec<Instance>,
    /// Surface descriptions; triangles refer to them by index. Never empty once a mesh is present.
    pub materials: Vec<Material>,
    /// Decoded pictures; [`TextureRef`](crate::TextureRef) refers to them by index.
    pub images: Vec<Image>,
    /// Punctual lights (KHR_lights_punctual), in the world.
    pub lights: Vec<PunctualLight>,
    /// Cameras of the file, in its order.
    pub cameras: Vec<Camera>,
    /// Light from infinitely far away.
    pub environment: Environment,
    /// Which of all these lights a film keeps apart.
    pub light_groups: LightGroups,
}

impl Scene {
    /// Number of triangles with instances counted.
    pub fn instanced_triangles(&self) -> u64 {
        self.instances
            .iter()
            .map(|i| self.meshes[i.mesh as usize].triangles.len() as u64)
            .sum()
    }

    /// Corners of a box around one of the instances; none where there is no such instance, or nothing of it.
    pub fn bounds_of(&self, instance: usize) -> Option<(Vec3, Vec3)> {
        let instance = self.instances.get(instance)?;
        let points = self.meshes[instance.mesh as usize].positions.iter();
        let points = points.map(|&p| {
            let p = instance.transform.transform_point3(p);
            p.clamp(Vec3::MIN, Vec3::MAX)
        });
        points.fold(None, |bounds, p| match bounds {
            None => Some((p, p)),
            Some((low, high)) => Some((low.min(p), high.max(p))),
        })
    }

    /// World-space bounds of all instances as (min, max); `None` for an empty scene. Tight, except for scenes with so
    /// many instances of large meshes that the transformed boxes of the meshes have to do.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        const MAX_VERTICES: usize = 1 << 27;
        let grow = |bounds: Option<(Vec3, Vec3)>, p: Vec3| match bounds {
            None => Some((p, p)),
            Some((low, high)) => Some((low.min(p), high.max(p))),
        };
        let vertices = |i: &Instance| self.meshes[i.mesh as usize].positions.len();
        let total = self
            .instances
            .iter()
            .map(vertices)
            .fold(0, usize::saturating_add);
        let corners: Vec<Vec<Vec3>> = match total {
            0..=MAX_VERTICES => Vec::new(),
            _ => (self.meshes.iter())
                .map(|mesh| mesh.positions.iter().copied().fold(None, grow))
                .map(|bounds| bounds.map_or(Vec::new(), |(low, high)| box_corners(low, high)))
                .collect(),
        };
        let mut bounds = None;
        for instance in &self.instances {
            let mesh = instance.mesh as usize;
            let points = corners.get(mesh).unwrap_or(&self.meshes[mesh].positions);
            for &p in points {
                // What a transform moves out of the range of numbers stays at its end.
                let p = instance.transform.transform_point3(p);
                bounds = grow(bounds, p.clamp(Vec3::MIN, Vec3::MAX));
            }
        }
        bounds
    }
}

fn box_corners(low: Vec3, high: Vec3) -> Vec<Vec3> {
    (0..8)
        .map(|i| {
            Vec3::select(
                glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0),
                low,
                high,
            )
        })
        .collect()
}
