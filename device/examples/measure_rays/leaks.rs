//! Rays that escape from closed bodies.

use std::{ops::ControlFlow, sync::Arc};

use device::native::accel::{Flags, Instance, Kernel, Mesh, Ray, Scene};
use glam::{Affine3A, DVec3, Quat, Vec3};

use crate::scenes::Random;

/// Prints the share of rays from inside a body to its corners and edges that hit nothing.
pub(crate) fn measure() {
    let mut random = Random(5);
    for kernel in [Kernel::best(), Kernel::portable()] {
        for divisions in [1, 8, 64] {
            let (positions, triangles) = sphere(divisions);
            let endless = |_| ControlFlow::Continue(());
            let mesh = Mesh::build(&positions, &triangles, |_| Flags::NONE, &endless)
                .expect("it isn't cancelled");
            let place = Affine3A::from_scale_rotation_translation(
                Vec3::splat(1.7),
                Quat::from_rotation_x(0.7),
                Vec3::new(3.0, 20.0, -1.0),
            );
            let mesh = Arc::new(mesh);
            for (name, place) in [("as it is", Affine3A::IDENTITY), ("moved", place)] {
                let scene = Scene::new(vec![mesh.clone()], vec![Instance::new(place, 0)], kernel);
                let mut leaks = [0usize; 2];
                let count = 200_000;
                for _ in 0..count {
                    let triangle = triangles[(random.next() * triangles.len() as f32) as usize];
                    let [a, b, _] = triangle.map(|i| positions[i as usize]);
                    let mut number = || random.next() * 2.0 - 1.0;
                    let from =
                        place.transform_point3(Vec3::new(number(), number(), number()) * 0.4);
                    for (leaks, target) in leaks.iter_mut().zip([a, a.lerp(b, random.next())]) {
                        let way = place.transform_point3(target) - from;
                        let ray = Ray {
                            origin: from.to_array(),
                            direction: way.normalize().to_array(),
                            t_min: 0.0,
                            t_max: f32::INFINITY,
                        };
                        *leaks += usize::from(scene.closest(&ray, |_| true).is_none());
                    }
                }
                let [corners, edges] = leaks.map(|leaks| 100.0 * leaks as f64 / count as f64);
                println!(
                    "{kernel}, {} triangles, {name}: {corners:.4} % at corners, {edges:.4} % at edges",
                    triangles.len()
                );
            }
        }
    }
}

/// A cube whose sides are divided, blown up to a sphere.
fn sphere(divisions: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (vec![], vec![]);
    for side in 0..6 {
        let axis = side / 2;
        let sign = if side % 2 == 0 { 1.0 } else { -1.0 };
        let first = positions.len() as u32;
        for y in 0..=divisions {
            for x in 0..=divisions {
                let at = |i: u32| f64::from(i) / f64::from(divisions) * 2.0 - 1.0;
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, at(x), at(y));
                // In double precision, so that sides that meet have the same corners.
                positions.push(DVec3::from(p).normalize().as_vec3());
            }
        }
        for y in 0..divisions {
            for x in 0..divisions {
                let a = first + y * (divisions + 1) + x;
                let (b, c, d) = (a + 1, a + divisions + 1, a + divisions + 2);
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
    (positions, triangles)
}
