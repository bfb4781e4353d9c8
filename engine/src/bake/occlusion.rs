//! Ambient occlusion of places, by rays on the processor: what textures read as `AO`.

use std::ops::ControlFlow;
use std::sync::Arc;

use device::native::accel::{Flags, Instance, Kernel, Mesh, Ray, Scene as RayScene};
use glam::Vec3;

use crate::scene::Scene;
use crate::scene::look::{AoDirection, AoSettings};

use super::BakeError;
use super::place::Place;

/// The scene's geometry. Whatever lets light pass occludes as the rest does.
pub(super) struct Occluders(RayScene);

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
        Ok(Self(RayScene::new(
            meshes,
            placed.collect(),
            Kernel::best(),
        )))
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
                origin: lifted(place.position, side).to_array(),
                direction: direction.to_array(),
                t_min: 0.0,
                t_max: table.distance,
            };
            // What goes under the surface, because the shading normal leans, counts as free.
            let is_free = direction.dot(side) <= 0.0 || self.0.trace(&ray, true, only).is_none();
            free += u32::from(is_free);
        }
        free as f32 / table.samples.max(1) as f32
    }
}

/// A point above the surface, so far that its own triangle isn't met.
fn lifted(position: Vec3, side: Vec3) -> Vec3 {
    let coarse = position.abs().max_element().max(1.0 / 32.0);
    position + side * (coarse * 2e-5)
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
