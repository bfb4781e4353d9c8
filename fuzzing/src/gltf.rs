//! glTF: import, and the hierarchy over what was imported.

use std::path::Path;

use engine::bvh::SceneBvh;
use engine::scene::import::{self, Importer};
use engine::scene::{Moment, Motion, Scene};

use crate::{check_message, file, memory};

/// Held beside what the file needs: a picture that turns out to be damaged only after it was decoded.
const SLACK: usize = 128 << 20;
/// Larger hierarchies take longer and show nothing new.
const MANY: usize = 200_000;

pub(crate) fn run(data: &[u8]) -> bool {
    let path = file("input.gltf", data);
    let imported = memory::within(data.len(), SLACK, || import::load(&path));
    import::referenced_files(&engine::input::Disk, &path);
    move_it(data.len(), &path);
    match imported {
        Ok(imported) => {
            check(&imported.scene);
            imported
                .warnings
                .iter()
                .for_each(|text| check_message(text));
            build(&imported.scene);
            true
        }
        Err(error) => {
            check_message(&error.to_string());
            false
        }
    }
}

/// Moments of the file, one after the other, by one importer.
fn move_it(size: usize, path: &Path) {
    let mut importer = Importer::new();
    for seconds in [0.5, f64::MAX, -1.0] {
        importer.begin(Moment {
            seconds,
            motion: Motion::Usual,
        });
        match memory::within(size, SLACK, || importer.load(path)) {
            Ok(imported) => check(&imported.scene),
            Err(error) => {
                check_message(&error.to_string());
                return;
            }
        }
    }
    match importer.animations(path) {
        Ok(animations) => animations
            .iter()
            .for_each(|a| assert!(a.start.is_finite() && a.end.is_finite(), "a time")),
        Err(error) => check_message(&error.to_string()),
    }
}

/// What a scene must be, whatever its file was.
pub(crate) fn check(scene: &Scene) {
    for mesh in &scene.meshes {
        let vertices = mesh.positions.len();
        assert!(mesh.positions.iter().all(|p| p.is_finite()), "a position");
        assert!(mesh.normals.iter().all(|n| n.is_finite()), "a normal");
        let mut corners = mesh.triangles.iter().flatten();
        assert!(corners.all(|&v| (v as usize) < vertices), "a corner");
        let mut materials = mesh.triangle_materials.iter();
        assert!(
            materials.all(|&m| (m as usize) < scene.materials.len()),
            "a material"
        );
    }
    for instance in &scene.instances {
        assert!((instance.mesh as usize) < scene.meshes.len(), "a mesh");
        assert!(instance.transform.is_finite(), "a transform");
    }
}

fn build(scene: &Scene) {
    if scene
        .meshes
        .iter()
        .map(|mesh| mesh.triangles.len())
        .sum::<usize>()
        > MANY
    {
        return;
    }
    let Ok(bvh) = SceneBvh::build(scene) else {
        return;
    };
    assert!(bvh.instance_order.len() <= scene.instances.len());
    for (mesh, order) in scene.meshes.iter().zip(&bvh.triangle_order) {
        let mut order = order.clone();
        order.sort_unstable();
        order.dedup();
        assert_eq!(order.len(), mesh.triangles.len(), "each triangle once");
    }
}
