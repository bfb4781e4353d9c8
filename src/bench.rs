//! `patina bench`: how fast parts of the renderer are on this machine.

pub(crate) mod kernel;

use std::f32::consts::TAU;

use engine::gpu::Gpu;
use engine::scene::{self, Camera, Instance, Material, Mesh, Projection, Scene};
use engine::{bench, load};
use glam::{Affine3A, Vec2, Vec3};

use crate::exit::Failure;
use crate::job::BenchTraverseJob;
use crate::progress::Bar;
use crate::{console, devices};

/// Measures the traversal kernel and prints millions of rays per second.
///
/// # Errors
/// The scene cannot be loaded or there is no device.
pub(crate) fn traverse(job: &BenchTraverseJob) -> Result<(), Failure> {
    let bar = Bar::new("loading the scene");
    let (name, scene) = match &job.scene {
        Some(path) => {
            let loaded = load::load(path, None, &[]).map_err(Failure::because)?;
            (path.display().to_string(), with_camera(loaded.scene))
        }
        None => ("built-in scene".to_owned(), built_in()),
    };
    bar.stage("measuring");
    let gpu = Gpu::new(&job.device).map_err(Failure::because)?;
    let report = bench::traverse(&gpu, &scene).map_err(Failure::because)?;
    bar.finish();

    console::print(&format!(
        "{name}: {} triangles\n{}\n\n\
         primary rays   {:8.2} Mrays/s\n\
         bounce rays    {:8.2} Mrays/s\n\
         shadow rays    {:8.2} Mrays/s",
        console::grouped(scene.instanced_triangles()),
        devices::title(gpu.description()),
        report.primary,
        report.bounce,
        report.shadow
    ));
    Ok(())
}

fn with_camera(mut scene: Scene) -> Scene {
    if scene.cameras.is_empty() {
        scene.cameras = vec![scene::default_camera(&scene)];
    }
    scene
}

/// The inside of a ring-shaped tunnel with bumpy walls: every ray hits something, as in a room, and the triangles
/// are small and all over the place. No file is needed, so that figures of two machines can be compared.
fn built_in() -> Scene {
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
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    let camera = Camera {
        name: "inside".to_owned(),
        transform: Affine3A::from_translation(Vec3::new(RING, 0.0, 0.0)),
        projection: Projection::Perspective { y_fov: 1.2 },
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: 1.0,
    };
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance {
            name: "tunnel".to_owned(),
            mesh: 0,
            transform: Affine3A::IDENTITY,
        }],
        materials: vec![Material {
            name: "wall".to_owned(),
            metallic: 0.0,
            ..Material::default()
        }],
        cameras: vec![camera],
        ..Scene::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_scene_is_what_the_help_says() {
        let scene = built_in();
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
}
