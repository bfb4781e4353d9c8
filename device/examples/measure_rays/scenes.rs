//! Geometry and rays to measure with.

use std::path::Path;

use device::native::accel::{Hit, Ray};
use glam::{Mat4, Vec3};

/// Triangles in the world.
#[derive(Default)]
pub(crate) struct Geometry {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// All meshes of a glTF file, placed.
pub(crate) fn load(file: &str) -> Geometry {
    let mut document = gltf::Gltf::open(file).expect("a glTF file");
    let blob = document.blob.take();
    let folder = Path::new(file).parent().expect("a file lies in a folder");
    let buffers: Vec<Vec<u8>> = document
        .buffers()
        .map(|buffer| match buffer.source() {
            gltf::buffer::Source::Bin => blob.clone().expect("a binary part"),
            gltf::buffer::Source::Uri(name) => {
                std::fs::read(folder.join(name)).expect("its buffer")
            }
        })
        .collect();
    let mut geometry = Geometry::default();
    let scene = document
        .default_scene()
        .or(document.scenes().next())
        .expect("a scene");
    let mut waiting: Vec<(gltf::Node<'_>, Mat4)> =
        scene.nodes().map(|node| (node, Mat4::IDENTITY)).collect();
    while let Some((node, above)) = waiting.pop() {
        let place = above * Mat4::from_cols_array_2d(&node.transform().matrix());
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
            let first = geometry.positions.len() as u32;
            let positions = reader.read_positions().expect("positions");
            geometry
                .positions
                .extend(positions.map(|p| place.transform_point3(p.into())));
            let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
            let triangles = indices
                .chunks_exact(3)
                .map(|t| [first + t[0], first + t[1], first + t[2]]);
            geometry.triangles.extend(triangles);
        }
        waiting.extend(node.children().map(|child| (child, place)));
    }
    geometry
}

/// A rough surface of about so many triangles, in no useful order.
pub(crate) fn terrain(triangles: usize) -> Geometry {
    let side = ((triangles / 2) as f64).sqrt() as u32;
    let mut random = Random(3);
    let mut geometry = Geometry::default();
    for z in 0..=side {
        for x in 0..=side {
            let (x, z) = (x as f32 / side as f32, z as f32 / side as f32);
            let height = (x * 31.0).sin() * (z * 23.0).cos() * 0.05 + random.next() / side as f32;
            geometry.positions.push(Vec3::new(x, height, z));
        }
    }
    for z in 0..side {
        for x in 0..side {
            let a = z * (side + 1) + x;
            let (b, c, d) = (a + 1, a + side + 1, a + side + 2);
            geometry.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    let count = geometry.triangles.len();
    for i in 0..count {
        geometry
            .triangles
            .swap(i, (random.next() as f64 * count as f64) as usize % count);
    }
    geometry
}

/// The generator PCG32.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [0, 1).
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        let x = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (x.rotate_right((self.0 >> 59) as u32) >> 8) as f32 / (1 << 24) as f32
    }
}

/// One ray through each pixel, along a Morton curve.
pub(crate) fn camera(from: Vec3, to: Vec3, degrees: f32, size: u32) -> Vec<Ray> {
    let forward = (to - from).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let half = (degrees.to_radians() * 0.5).tan();
    let mut random = Random(1);
    (0..size * size)
        .map(|i| {
            let mut offset =
                |pixel: u32| ((pixel as f32 + random.next()) / size as f32 * 2.0 - 1.0) * half;
            let (x, y) = (offset(every_other_bit(i)), offset(every_other_bit(i >> 1)));
            ray(
                from,
                (forward + right * x - up * y).normalize(),
                f32::INFINITY,
            )
        })
        .collect()
}

fn every_other_bit(x: u32) -> u32 {
    (0..16).map(|bit| (x >> (2 * bit) & 1) << bit).sum()
}

fn ray(origin: Vec3, direction: Vec3, t_max: f32) -> Ray {
    Ray {
        origin: origin.to_array(),
        direction: direction.to_array(),
        t_min: 0.0,
        t_max,
    }
}

/// Where rays hit, a little above the surface, and the normal there; a miss repeats the hit before.
pub(crate) fn points(geometry: &Geometry, rays: &[Ray], hits: &[Option<Hit>]) -> Vec<(Vec3, Vec3)> {
    let mut last = (Vec3::ZERO, Vec3::Y);
    rays.iter()
        .zip(hits)
        .map(|(ray, hit)| {
            if let Some(hit) = hit {
                let corners = geometry.triangles[hit.triangle as usize];
                let [a, b, c] = corners.map(|i| geometry.positions[i as usize]);
                let direction = Vec3::from(ray.direction);
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let normal = if normal.dot(direction) > 0.0 {
                    -normal
                } else {
                    normal
                };
                let p = Vec3::from(ray.origin) + direction * hit.t;
                last = (p + normal * 1e-4 * p.abs().max_element().max(1.0), normal);
            }
            last
        })
        .collect()
}

/// By the cosine around the normals.
pub(crate) fn bounce(points: &[(Vec3, Vec3)]) -> Vec<Ray> {
    let mut random = Random(7);
    points
        .iter()
        .map(|&(p, normal)| {
            let (u, phi) = (random.next(), random.next() * std::f32::consts::TAU);
            let (x, y) = normal.any_orthonormal_pair();
            let direction = (x * phi.cos() + y * phi.sin()) * u.sqrt() + normal * (1.0 - u).sqrt();
            ray(p, direction.normalize(), f32::INFINITY)
        })
        .collect()
}

/// To random points of a parallelogram, given by a corner and two sides.
pub(crate) fn shadow(points: &[(Vec3, Vec3)], [corner, a, b]: [Vec3; 3]) -> Vec<Ray> {
    let mut random = Random(9);
    points
        .iter()
        .map(|&(p, _)| {
            let way = corner + a * random.next() + b * random.next() - p;
            let length = way.length();
            ray(p, way / length, length * 0.999)
        })
        .collect()
}
