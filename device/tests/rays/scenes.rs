//! Geometry and rays.

use std::ops::ControlFlow;

use device::native::accel::Ray;
use glam::{DVec3, Vec3};

/// Progress that lets a build go on.
pub(crate) fn endless(_: f32) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [0, 1).
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    /// In a cube around the origin, `size` from it to a side.
    pub(crate) fn point(&mut self, size: f32) -> Vec3 {
        (Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0) * size
    }
}

/// Triangles of about `size` in the cube around the origin.
pub(crate) fn soup(random: &mut Random, count: usize, size: f32) -> Vec<[Vec3; 3]> {
    (0..count)
        .map(|_| {
            let a = random.point(1.0);
            [a, a + random.point(size), a + random.point(size)]
        })
        .collect()
}

pub(crate) fn rays(random: &mut Random, count: usize) -> Vec<Ray> {
    (0..count)
        .map(|_| Ray {
            origin: random.point(1.5).to_array(),
            direction: random.point(1.0).normalize().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        })
        .collect()
}

/// A cube whose sides are divided, blown up to a sphere: a closed surface.
pub(crate) fn sphere(divisions: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (vec![], vec![]);
    for side in 0..6 {
        let (axis, sign) = (side / 2, if side % 2 == 0 { 1.0 } else { -1.0 });
        let first = positions.len() as u32;
        for i in 0..(divisions + 1) * (divisions + 1) {
            let at = |i: u32| f64::from(i) / f64::from(divisions) * 2.0 - 1.0;
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) =
                (sign, at(i % (divisions + 1)), at(i / (divisions + 1)));
            // In double precision, so that sides that meet have the same corners.
            positions.push(DVec3::from(p).normalize().as_vec3());
        }
        for i in 0..divisions * divisions {
            let a = first + i / divisions * (divisions + 1) + i % divisions;
            let (b, c, d) = (a + 1, a + divisions + 1, a + divisions + 2);
            triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    (positions, triangles)
}
