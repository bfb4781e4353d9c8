//! Rays against all triangles, one after the other, in double precision.

use std::sync::Arc;

use device::native::accel::{Flags, Instance, Kernel, Mesh, Ray, Scene};
use glam::{Affine3A, DAffine3, DVec3, Vec3};

use crate::scenes::endless;

/// Triangles and what is said of them.
pub(crate) struct Body {
    triangles: Vec<[Vec3; 3]>,
    flags: fn(usize) -> Flags,
}

impl Body {
    pub(crate) fn new(triangles: Vec<[Vec3; 3]>, flags: fn(usize) -> Flags) -> Self {
        Self { triangles, flags }
    }

    pub(crate) fn push(&mut self, triangle: [Vec3; 3]) {
        self.triangles.push(triangle);
    }

    pub(crate) fn mesh(&self) -> Mesh {
        let positions: Vec<Vec3> = self.triangles.concat();
        let indices: Vec<[u32; 3]> = (0..self.triangles.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        let mesh =
            Mesh::build(&positions, &indices, self.flags, &endless).expect("it isn't cancelled");
        assert!(mesh.depth() <= device::native::accel::MAX_DEPTH);
        mesh
    }

    pub(crate) fn scene(&self, places: &[Affine3A], kernel: Kernel) -> Scene {
        let instances = places
            .iter()
            .map(|&place| Instance::new(place, 0))
            .collect();
        Scene::new(vec![Arc::new(self.mesh())], instances, kernel)
    }
}

struct Found {
    t: f64,
    barycentrics: [f64; 2],
    triangle: u32,
    instance: u32,
}

fn closest(body: &Body, objects: &[DAffine3], ray: &Ray) -> Option<Found> {
    let mut best: Option<Found> = None;
    for (instance, object) in objects.iter().enumerate() {
        let origin = object.transform_point3(Vec3::from(ray.origin).as_dvec3());
        let direction = object.transform_vector3(Vec3::from(ray.direction).as_dvec3());
        for (i, corners) in body.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|p| p.as_dvec3());
            let (edge1, edge2): (DVec3, DVec3) = (b - a, c - a);
            let p = direction.cross(edge2);
            let determinant = edge1.dot(p);
            let is_culled = (body.flags)(i) == Flags::SINGLE_SIDED && determinant < 0.0;
            // Triangles without area: what their rounded corners leave is not a surface.
            if is_culled || edge1.cross(edge2).length() < 1e-9 {
                continue;
            }
            let s = origin - a;
            let q = s.cross(edge1);
            let (u, v, t) = (
                s.dot(p) / determinant,
                direction.dot(q) / determinant,
                edge2.dot(q) / determinant,
            );
            let t_max = best.as_ref().map_or(f64::from(ray.t_max), |best| best.t);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > f64::from(ray.t_min) && t < t_max {
                best = Some(Found {
                    t,
                    barycentrics: [u, v],
                    triangle: i as u32,
                    instance: instance as u32,
                });
            }
        }
    }
    best
}

/// Compares a kernel's hits; at edges, and where triangles lie in one place, rounding decides, so that some may be wrong.
pub(crate) fn check(
    body: &Body,
    places: &[Affine3A],
    kernel: Kernel,
    rays: &[Ray],
    most_wrong: usize,
) {
    let scene = body.scene(places, kernel);
    let objects: Vec<DAffine3> = places
        .iter()
        .map(|place| DAffine3::from_cols_array(&place.to_cols_array().map(f64::from)).inverse())
        .collect();
    let mut wrong = 0;
    for ray in rays {
        let hit = scene.closest(ray, |_| true);
        assert_eq!(hit.is_some(), scene.any(ray, |_| true).is_some());
        let is_right = match (hit, closest(body, &objects, ray)) {
            (None, None) => true,
            (Some(hit), Some(found)) => {
                let near = |a: f32, b: f64, tolerance: f64| (f64::from(a) - b).abs() <= tolerance;
                // Weights of small triangles seen at grazing angles are rounded most.
                (hit.triangle, hit.instance) == (found.triangle, found.instance)
                    && near(hit.t, found.t, 2e-5 * found.t.max(1.0))
                    && near(hit.u, found.barycentrics[0], 1e-2)
                    && near(hit.v, found.barycentrics[1], 1e-2)
            }
            _ => false,
        };
        wrong += usize::from(!is_right);
    }
    assert!(wrong <= most_wrong, "{kernel}: {wrong} of {}", rays.len());
}
