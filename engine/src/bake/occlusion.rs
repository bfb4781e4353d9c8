//! Ambient occlusion of places, by rays on the processor: what textures read as `AO`.

use std::ops::ControlFlow;
use std::sync::Arc;

use device::native::accel::{Flags, Instance, Kernel, Mesh, Ray, Scene as RayScene};
use glam::{Affine3A, Vec3};

use crate::scene::Scene;
use crate::scene::look::{AoDirection, AoSettings};

use super::BakeError;
use super::place::Place;

/// The scene's geometry. Whatever lets light pass occludes as the rest does.
pub(super) struct Occluders {
    scene: RayScene,
    /// Of its instances.
    transforms: Vec<Affine3A>,
}

impl Occluders {
    pub(super) fn new(scene: &Scene) -> Result<Self, BakeError> {
        let build = |mesh: &crate::scene::Mesh| {
            let flags = |triangle: usize| {
                let material = mesh.triangle_materials[triangle] as usize;
                match scene.materials[material].double_sided {
                    true => Flags::NONE,
                    false => Flags::SINGLE_SIDED,
                }
            };
            Mesh::build(&mesh.positions, &mesh.triangles, flags, &|_| {
                ControlFlow::Continue(())
            })
            .map(Arc::new)
            .map_err(|error| BakeError::Geometry(error.to_string()))
        };
        let meshes = scene.meshes.iter().map(build).collect::<Result<_, _>>()?;
        let instances = scene.instances.iter();
        let placed = instances.map(|instance| Instance::new(instance.transform, instance.mesh));
        let transforms = scene.instances.iter().map(|instance| instance.transform);
        Ok(Self {
            scene: RayScene::new(meshes, placed.collect(), Kernel::best()),
            transforms: transforms.collect(),
        })
    }

    /// 1 where nothing is near, 0 where everything is occluded. `seed` differs from sample to sample.
    pub(super) fn openness(
        &self,
        place: &Place,
        instance: u32,
        table: &AoSettings,
        seed: u32,
    ) -> f32 {
        let tangent = place.normal.any_orthonormal_vector();
        let across = place.normal.cross(tangent);
        let only = table.same_object.then_some(instance);
        let coarseness = coarseness(&self.transforms[instance as usize], place.position);
        let mut free = 0;
        for i in 0..table.samples {
            let u = point(i, table.samples, seed);
            let (radius, angle) = (u[0].sqrt(), std::f32::consts::TAU * u[1]);
            let mut direction = tangent * (radius * angle.cos())
                + across * (radius * angle.sin())
                + place.normal * (1.0 - u[0]).max(1e-12).sqrt();
            let mut side = place.geometric;
            let is_inside = match table.direction {
                AoDirection::Outside => false,
                AoDirection::Inside => true,
                AoDirection::Both => i & 1 == 1,
            };
            if is_inside {
                (direction, side) = (-direction, -side);
            }
            let ray = Ray {
                origin: (place.position + side * coarseness).to_array(),
                direction: direction.to_array(),
                t_min: 0.0,
                t_max: table.distance,
            };
            // What goes under the surface, because the shading normal leans, counts as free.
            let is_free =
                direction.dot(side) <= 0.0 || self.scene.trace(&ray, true, only).is_none();
            free += u32::from(is_free);
        }
        free as f32 / table.samples.max(1) as f32
    }
}

/// How far above the surface a ray has to start so that its own triangle isn't met: by how coarsely numbers of the position's size are
/// rounded, or those of its mesh, where the node takes them nearly away (as `Surface::coarseness` in `surface.wgsl`).
fn coarseness(transform: &Affine3A, position: Vec3) -> f32 {
    let [x, y, z] = transform.matrix3.to_cols_array_2d().map(Vec3::from);
    let own = transform.inverse().transform_point3(position).abs();
    let terms = x.abs() * own.x + y.abs() * own.y + z.abs() * own.z;
    let terms = terms + Vec3::from(transform.translation).abs();
    let usual = position.abs();
    let coarse = Vec3::select(terms.cmpgt(4.0 * usual + 1.0), terms, usual);
    coarse.max_element().max(1.0 / 32.0) * 2e-5
}

/// Point `i` of `count` in the unit square: Hammersley's, moved by the seed.
fn point(i: u32, count: u32, seed: u32) -> [f32; 2] {
    let scrambled = seed.wrapping_mul(0x9e37_79b9);
    let shift = [
        scrambled ^ (scrambled >> 15),
        scrambled.wrapping_mul(0x85eb_ca6b),
    ];
    let part = |word: u32| (word >> 8) as f32 / 16_777_216.0;
    let first = (i as f32 + 0.5) / count.max(1) as f32;
    [
        (first + part(shift[0])).fract(),
        part(i.reverse_bits().wrapping_add(shift[1])),
    ]
}
