//! Scenes of the benchmarks, built in code: no file is needed, so that figures of two machines can be compared.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Mat3A, Quat, Vec2, Vec3};

use engine::scene::{
    Camera, Environment, Instance, LightKind, Material, Mesh, Projection, PunctualLight, Scene,
};

/// Name of the material that is textured in the [`arcade`].
pub const MODEL: &str = "model";

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
        let mut wall = named(name);
        add_quad(&mut wall, corner, u, v);
        add(&mut scene, wall, lambert(name, color));
    }
    for (name, place, height, turn) in [
        ("tall block", Vec3::new(0.185, 0.0, 0.19), 0.33, 0.29),
        ("short block", Vec3::new(0.37, 0.0, 0.38), 0.165, -0.31),
    ] {
        let block = block(name, place, Vec3::new(0.165, height, 0.165), turn);
        add(&mut scene, block, lambert(name, white));
    }
    let mut lamp = named("lamp");
    let size = 0.24 * SIDE;
    let corner = Vec3::new(0.5 * (SIDE - size), 0.999 * SIDE, 0.5 * (SIDE - size));
    add_quad(&mut lamp, corner, Vec3::X * size, Vec3::Z * size);
    let shining = Material {
        emission: Vec3::new(17.0, 12.0, 5.0),
        ..lambert("lamp", Vec3::ZERO)
    };
    add(&mut scene, lamp, shining);
    scene
}

/// An arcade under an open sky: two rows of columns with arches, a wall of niches behind them, and in the middle a knot,
/// the model that is textured. About 150,000 triangles, light from the sky and the sun.
pub fn arcade() -> Scene {
    const COLUMNS: u32 = 7;
    const SPACING: f32 = 2.2;
    let stone = Vec3::new(0.62, 0.58, 0.52);
    let mut scene = Scene {
        environment: Environment::Constant(Vec3::new(0.55, 0.7, 1.0)),
        lights: vec![PunctualLight {
            name: "sun".to_owned(),
            intensity: Vec3::new(3.0, 2.8, 2.4),
            position: Vec3::ZERO,
            direction: Vec3::new(-0.45, -1.0, -0.35).normalize(),
            range: f32::INFINITY,
            kind: LightKind::Directional,
        }],
        cameras: vec![looking(
            Vec3::new(0.0, 1.7, 4.6),
            Vec3::new(0.0, 1.35, 0.0),
            0.75,
        )],
        ..Scene::default()
    };
    let width = SPACING * COLUMNS as f32;
    let mut floor = named("floor");
    add_quad(
        &mut floor,
        Vec3::new(-width, 0.0, 8.0),
        Vec3::X * 2.0 * width,
        Vec3::NEG_Z * 16.0,
    );
    add(&mut scene, floor, lambert("floor", stone * 0.8));
    let mut wall = named("wall");
    // Niches are bumps of the wall.
    let niche = |u: f32, v: f32| {
        let depth = 0.35
            * (PI * COLUMNS as f32 * u).sin().powi(4)
            * (1.0 - (2.0 * v - 0.9).powi(4)).max(0.0);
        Vec3::new((u - 0.5) * width, v * 5.0, -4.0 - depth)
    };
    add_surface(&mut wall, [256, 96], niche);
    add(&mut scene, wall, lambert("wall", stone));
    for (row, z) in [-2.2, -3.2].into_iter().enumerate() {
        for i in 0..COLUMNS {
            let x = (i as f32 - 0.5 * (COLUMNS - 1) as f32) * SPACING;
            let mut column = named(&format!("column {row} {i}"));
            // A shaft with a base and a capital, by its radius over the height.
            let shaft = |u: f32, v: f32| {
                let swelling = 0.02 * (PI * v).sin()
                    + 0.09 * (-60.0 * v).exp()
                    + 0.12 * (60.0 * (v - 1.0)).exp();
                let radius = 0.17 + swelling + 0.006 * (TAU * 12.0 * u).cos();
                let angle = -TAU * u;
                Vec3::new(x + radius * angle.cos(), 2.6 * v, z + radius * angle.sin())
            };
            add_surface(&mut column, [96, 24], shaft);
            add(
                &mut scene,
                column,
                lambert(&format!("column {row} {i}"), stone),
            );
            let mut arch = named(&format!("arch {row} {i}"));
            let half = 0.5 * SPACING;
            let bow = |u: f32, v: f32| {
                let (along, around) = (PI * u, -TAU * v);
                let radius = half + 0.16 * around.cos();
                Vec3::new(
                    x + half - radius * along.cos(),
                    2.6 + radius * along.sin(),
                    z + 0.16 * around.sin(),
                )
            };
            add_surface(&mut arch, [48, 16], bow);
            add(&mut scene, arch, lambert(&format!("arch {row} {i}"), stone));
        }
    }
    let mut knot = named("knot");
    let axis = |u: f32| {
        let a = TAU * u;
        let radius = 0.62 + 0.25 * (3.0 * a).cos();
        Vec3::new(
            radius * (2.0 * a).cos(),
            radius * (2.0 * a).sin(),
            0.3 * (3.0 * a).sin(),
        )
    };
    add_surface(&mut knot, [640, 64], |u, v| {
        let along = (axis(u + 1e-3) - axis(u - 1e-3)).normalize();
        let side = along.cross(Vec3::Z).normalize();
        let (sin, cos) = (-TAU * v).sin_cos();
        Vec3::Y * 1.35 + axis(u) + 0.24 * (side * cos + along.cross(side) * sin)
    });
    add(&mut scene, knot, lambert(MODEL, Vec3::splat(0.5)));
    scene
}

/// A camera at `eye` that looks at `target`.
pub(crate) fn looking(eye: Vec3, target: Vec3, y_fov: f32) -> Camera {
    let back = (eye - target).normalize();
    let right = Vec3::Y.cross(back).normalize();
    Camera {
        name: "front".to_owned(),
        transform: Affine3A {
            matrix3: Mat3A::from_cols(right.into(), back.cross(right).into(), back.into()),
            translation: eye.into(),
        },
        projection: Projection::Perspective { y_fov },
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: 1.0,
    }
}

/// A box on the floor without its bottom, turned about the vertical by `turn` radians.
fn block(name: &str, place: Vec3, size: Vec3, turn: f32) -> Mesh {
    let mut mesh = named(name);
    let [w, h, d] = [size.x, size.y, size.z];
    let turn = Quat::from_rotation_y(turn);
    for quarter in 0..4 {
        let turn = turn * Quat::from_rotation_y(0.5 * PI * quarter as f32);
        let corner = place + turn * Vec3::new(-0.5 * w, 0.0, 0.5 * d);
        add_quad(&mut mesh, corner, turn * (Vec3::X * w), Vec3::Y * h);
    }
    let corner = place + turn * Vec3::new(-0.5 * w, h, 0.5 * d);
    add_quad(
        &mut mesh,
        corner,
        turn * (Vec3::X * w),
        turn * (Vec3::NEG_Z * d),
    );
    mesh
}

fn named(name: &str) -> Mesh {
    Mesh {
        name: name.to_owned(),
        ..Mesh::default()
    }
}

/// Adds a surface by its points over u and v from 0 to 1, in so many cells; its front is on the side of du x dv.
fn add_surface(mesh: &mut Mesh, [across, up]: [u32; 2], point: impl Fn(f32, f32) -> Vec3) {
    let first = mesh.positions.len() as u32;
    let step = 1e-3;
    for j in 0..=up {
        for i in 0..=across {
            let (u, v) = (i as f32 / across as f32, j as f32 / up as f32);
            let du = point(u + step, v) - point(u - step, v);
            let dv = point(u, v + step) - point(u, v - step);
            mesh.positions.push(point(u, v));
            mesh.normals.push(du.cross(dv).normalize_or(Vec3::Y));
            mesh.uv0.push(Vec2::new(u, v));
        }
    }
    let at = |i: u32, j: u32| first + j * (across + 1) + i;
    for j in 0..up {
        for i in 0..across {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

/// Adds a parallelogram with its front on the side of `u` x `v`.
fn add_quad(mesh: &mut Mesh, corner: Vec3, u: Vec3, v: Vec3) {
    let first = mesh.positions.len() as u32;
    mesh.positions
        .extend([corner, corner + u, corner + u + v, corner + v]);
    mesh.normals.extend([u.cross(v).normalize_or_zero(); 4]);
    mesh.uv0.extend([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    mesh.triangles.push([first, first + 1, first + 2]);
    mesh.triangles.push([first, first + 2, first + 3]);
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
        asset: None,
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
    fn fronts_of_the_arcade_face_outwards() {
        let scene = arcade();
        let mut models = 0;
        for mesh in &scene.meshes {
            let Some(&first) = mesh.triangles.first() else {
                continue;
            };
            if mesh.name == "floor" || mesh.name == "wall" {
                let [a, b, c] = first.map(|i| mesh.positions[i as usize]);
                let toward = scene.cameras[0].transform.translation - glam::Vec3A::from(a);
                assert!(
                    (b - a).cross(c - a).dot(toward.into()) > 0.0,
                    "{}",
                    mesh.name
                );
                continue;
            }
            // Tubes: their volume is positive if their fronts are outside.
            let center: Vec3 = mesh.positions.iter().sum::<Vec3>() / mesh.positions.len() as f32;
            let volume: f32 = (mesh.triangles.iter())
                .map(|t| t.map(|i| mesh.positions[i as usize] - center))
                .map(|[a, b, c]| a.dot(b.cross(c)))
                .sum();
            assert!(volume > 0.0, "{}: {volume}", mesh.name);
            models += 1;
        }
        assert_eq!(models, 2 * 2 * 7 + 1);
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
