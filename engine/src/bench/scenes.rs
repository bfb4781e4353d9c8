//! Scenes of the benchmarks, built in code: no file is needed, so that figures of two machines can be compared.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::scene::{Camera, Environment, Instance, Material, Mesh, Projection, Scene};

/// The inside of a ring-shaped tunnel with bumpy walls, 262,144 triangles: every ray hits something, as in a room, and
/// the triangles are small and all over the place. The sky around it lights nothing, but shadow rays look for it.
pub fn tunnel() -> Scene {
    const AROUND: u32 = 512;
    const ACROSS: u32 = 256;
    const RING: f32 = 3.0;

    let wall = |u: f32, v: f32| {
        let bumps = 0.08 * (TAU * 40.0 * u).sin() * (TAU * 12.0 * v).sin()
            + 0.02 * (TAU * 131.0 * u + 3.0 * (TAU * 29.0 * v).sin()).sin();
        let (out, up) = ((TAU * v).cos(), (TAU * v).sin());
        let inward = -Vec3::new(out * (TAU * u).cos(), up, out * (TAU * u).sin());
        let axis = RING * Vec3::new((TAU * u).cos(), 0.0, (TAU * u).sin());
        (axis - (1.0 + bumps) * inward, inward)
    };
    let mut mesh = Mesh {
        name: "tunnel".to_owned(),
        ..Mesh::default()
    };
    for j in 0..ACROSS {
        for i in 0..AROUND {
            let (u, v) = (i as f32 / AROUND as f32, j as f32 / ACROSS as f32);
            let (position, normal) = wall(u, v);
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.uv0.push(Vec2::new(u, v));
            let next = |i: u32, j: u32| (j % ACROSS) * AROUND + i % AROUND;
            let (a, b, c, d) = (
                next(i, j),
                next(i + 1, j),
                next(i + 1, j + 1),
                next(i, j + 1),
            );
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let mut scene = Scene {
        environment: Environment::Constant(Vec3::ONE),
        cameras: vec![Camera {
            name: "inside".to_owned(),
            transform: Affine3A::from_translation(Vec3::new(RING, 0.0, 0.0)),
            projection: Projection::Perspective { y_fov: 1.2 },
            aperture_radius: 0.0,
            aperture_blades: 0,
            aperture_rotation: 0.0,
            focus_distance: 1.0,
        }],
        ..Scene::default()
    };
    let wall = Material {
        name: "wall".to_owned(),
        metallic: 0.0,
        ..Material::default()
    };
    add(&mut scene, mesh, wall);
    scene
}

/// A diffuse room of 55 cm with a red and a green wall, two blocks and a lamp in the ceiling: few triangles, long
/// paths.
pub fn cornell_box() -> Scene {
    const SIDE: f32 = 0.55;
    let x = Vec3::X * SIDE;
    let y = Vec3::Y * SIDE;
    let z = Vec3::Z * SIDE;
    let white = Vec3::splat(0.73);
    let mut scene = Scene {
        cameras: vec![Camera {
            name: "front".to_owned(),
            transform: Affine3A::from_translation(Vec3::new(0.5 * SIDE, 0.5 * SIDE, 2.5 * SIDE)),
            projection: Projection::Perspective { y_fov: 0.68 },
            aperture_radius: 0.0,
            aperture_blades: 0,
            aperture_rotation: 0.0,
            focus_distance: 1.0,
        }],
        ..Scene::default()
    };
    // Corner and two sides; the front is on the side of their cross product, inside the room.
    for (name, corner, u, v, color) in [
        ("floor", z, x, -z, white),
        ("ceiling", y, x, z, white),
        ("back", Vec3::ZERO, x, y, white),
        ("left", z, -z, y, Vec3::new(0.63, 0.06, 0.05)),
        ("right", x, z, y, Vec3::new(0.14, 0.45, 0.09)),
    ] {
        let mut wall = Mesh::named(name);
        wall.add_quad(corner, u, v);
        add(&mut scene, wall, lambert(name, color));
    }
    for (name, place, height, turn) in [
        ("tall block", Vec3::new(0.185, 0.0, 0.19), 0.33, 0.29),
        ("short block", Vec3::new(0.37, 0.0, 0.38), 0.165, -0.31),
    ] {
        let block = block(name, place, Vec3::new(0.165, height, 0.165), turn);
        add(&mut scene, block, lambert(name, white));
    }
    let mut lamp = Mesh::named("lamp");
    let size = 0.24 * SIDE;
    let corner = Vec3::new(0.5 * (SIDE - size), 0.999 * SIDE, 0.5 * (SIDE - size));
    lamp.add_quad(corner, Vec3::X * size, Vec3::Z * size);
    let shining = Material {
        emission: Vec3::new(17.0, 12.0, 5.0),
        ..lambert("lamp", Vec3::ZERO)
    };
    add(&mut scene, lamp, shining);
    scene
}

/// A box on the floor without its bottom, turned about the vertical by `turn` radians.
fn block(name: &str, place: Vec3, size: Vec3, turn: f32) -> Mesh {
    let mut mesh = Mesh::named(name);
    let [w, h, d] = [size.x, size.y, size.z];
    let turn = Quat::from_rotation_y(turn);
    for quarter in 0..4 {
        let turn = turn * Quat::from_rotation_y(0.5 * PI * quarter as f32);
        let corner = place + turn * Vec3::new(-0.5 * w, 0.0, 0.5 * d);
        mesh.add_quad(corner, turn * (Vec3::X * w), Vec3::Y * h);
    }
    let corner = place + turn * Vec3::new(-0.5 * w, h, 0.5 * d);
    mesh.add_quad(corner, turn * (Vec3::X * w), turn * (Vec3::NEG_Z * d));
    mesh
}

impl Mesh {
    fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..Self::default()
        }
    }

    /// A parallelogram with its front on the side of `u` x `v`.
    fn add_quad(&mut self, corner: Vec3, u: Vec3, v: Vec3) {
        let first = self.positions.len() as u32;
        self.positions
            .extend([corner, corner + u, corner + u + v, corner + v]);
        self.normals.extend([u.cross(v).normalize_or_zero(); 4]);
        self.uv0.extend([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
        self.triangles.push([first, first + 1, first + 2]);
        self.triangles.push([first, first + 2, first + 3]);
    }
}

/// A surface that reflects `color` equally in all directions and has no gloss.
fn lambert(name: &str, color: Vec3) -> Material {
    Material {
        name: name.to_owned(),
        base_color: color.extend(1.0),
        metallic: 0.0,
        specular: 0.0,
        ..Material::default()
    }
}

/// Puts a mesh with a material of its own into the scene.
fn add(scene: &mut Scene, mut mesh: Mesh, material: Material) {
    mesh.triangle_materials = vec![scene.materials.len() as u32; mesh.triangles.len()];
    scene.materials.push(material);
    scene.instances.push(Instance {
        name: mesh.name.clone(),
        mesh: scene.meshes.len() as u32,
        transform: Affine3A::IDENTITY,
    });
    scene.meshes.push(mesh);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tunnel_is_what_the_help_says() {
        let scene = tunnel();
        assert_eq!(scene.instanced_triangles(), 262_144);
        let mesh = &scene.meshes[0];
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        let count = mesh.positions.len() as u32;
        assert!(mesh.triangles.iter().flatten().all(|&i| i < count));
        for &[a, b, c] in &mesh.triangles {
            let [a, b, c] = [a, b, c].map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).length() > 0.0);
        }
    }

    #[test]
    fn fronts_of_the_cornell_box_face_its_air() {
        let scene = cornell_box();
        assert_eq!(scene.instanced_triangles(), 32);
        // A point of the air in front of each wall, and of none of the blocks.
        let inside = Vec3::new(0.275, 0.5, 0.5);
        for mesh in &scene.meshes {
            let center: Vec3 = mesh.positions.iter().sum::<Vec3>() / mesh.positions.len() as f32;
            for (&[a, b, c], normals) in mesh.triangles.iter().zip(mesh.triangles.iter()) {
                let [p, q, r] = [a, b, c].map(|i| mesh.positions[i as usize]);
                let normal = (q - p).cross(r - p).normalize();
                let stored = mesh.normals[normals[0] as usize];
                assert!(normal.dot(stored) > 0.999, "{}", mesh.name);
                let towards = match mesh.name.contains("block") {
                    true => p + q + r - 3.0 * center,
                    false => inside - p,
                };
                assert!(normal.dot(towards) > 0.0, "{}: {normal}", mesh.name);
            }
        }
    }
}
