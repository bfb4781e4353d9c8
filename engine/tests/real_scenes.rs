//! The importer on real files: every model of the shared test data that needs only supported extensions loads with
//! the number of triangles that the data's table states. Skipped with a notice where the data is absent.

use engine::scene::import::{ImportError, default_camera, load};
use engine::scene::{Environment, Scene};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")).join(folder);
    if !path.exists() {
        eprintln!("skipped: no {}", path.display());
        return None;
    }
    Some(path)
}

/// All `.gltf` and `.glb` files below a folder.
fn models(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let extension = path.extension().and_then(|e| e.to_str());
            match extension {
                _ if path.is_dir() => open.push(path),
                Some("gltf" | "glb") => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    found
}

/// What the rest of the program relies on.
fn check_contract(scene: &Scene) {
    for mesh in &scene.meshes {
        let count = mesh.positions.len();
        assert_eq!(mesh.normals.len(), count);
        for length in [
            mesh.tangents.len(),
            mesh.uv0.len(),
            mesh.uv1.len(),
            mesh.colors.len(),
        ] {
            assert!(length == 0 || length == count);
        }
        assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len());
        assert!(!mesh.triangles.is_empty());
        for &[a, b, c] in &mesh.triangles {
            assert!(a != b && b != c && c != a);
            assert!([a, b, c].iter().all(|&v| (v as usize) < count));
        }
        assert!(
            mesh.triangle_materials
                .iter()
                .all(|&m| (m as usize) < scene.materials.len())
        );
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
        for tangent in &mesh.tangents {
            assert!(tangent.truncate().is_normalized() && tangent.w.abs() == 1.0);
        }
    }
    for instance in &scene.instances {
        assert!((instance.mesh as usize) < scene.meshes.len());
        assert!(instance.transform.inverse().is_finite());
    }
    let names: std::collections::HashSet<_> = scene.materials.iter().map(|m| &m.name).collect();
    assert_eq!(
        names.len(),
        scene.materials.len(),
        "names of materials are unique"
    );
    for material in &scene.materials {
        let textures = [
            (material.base_color_texture, true),
            (material.metallic_roughness_texture, false),
            (material.normal_texture, false),
            (material.emission_texture, true),
            (material.specular_texture, false),
            (material.specular_color_texture, true),
        ];
        for (texture, srgb) in textures {
            if let Some(texture) = texture {
                assert_eq!(scene.images[texture.image as usize].srgb, srgb);
            }
        }
    }
    for image in &scene.images {
        assert_eq!(
            image.rgba8.len(),
            image.width as usize * image.height as usize * 4
        );
    }
}

/// (folder, triangles with instances counted) of each row of the table.
fn table(scenes: &Path) -> Vec<(String, u64)> {
    let text = std::fs::read_to_string(scenes.join("SOURCES.md")).unwrap();
    text.lines()
        .filter_map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let file = *cells.get(2)?;
            if !file.ends_with(".gltf") && !file.ends_with(".glb") {
                return None;
            }
            let triangles = cells.get(4)?.split_whitespace().next()?.replace(',', "");
            Some((format!("{}/{file}", cells[1]), triangles.parse().ok()?))
        })
        .collect()
}

#[test]
fn every_model_loads_with_the_triangles_of_the_table() {
    let Some(scenes) = shared("scenes") else {
        return;
    };
    let rows = table(&scenes);
    assert!(rows.len() > 55, "the table has changed its form");
    let mut failures = Vec::new();
    let mut loaded = 0;
    for (file, expected) in rows {
        let started = Instant::now();
        match load(&scenes.join(&file)) {
            Ok(imported) => {
                check_contract(&imported.scene);
                loaded += 1;
                // The table counts triangles without area too; the importer says how many it left out.
                let dropped: u64 = imported
                    .warnings
                    .iter()
                    .filter(|warning| warning.contains("without area"))
                    .filter_map(|warning| warning.split(' ').next()?.parse::<u64>().ok())
                    .sum();
                let triangles = imported.scene.instanced_triangles();
                let exact = triangles == expected;
                let explained = triangles < expected && dropped > 0;
                if !exact && !explained {
                    failures.push(format!(
                        "{file}: {triangles} triangles, {expected} expected"
                    ));
                }
                eprintln!(
                    "{file}: {triangles}/{expected} {:?} {:#?}",
                    started.elapsed(),
                    imported.warnings
                );
            }
            Err(ImportError::Extension { extension, .. }) => {
                let text = std::fs::read(scenes.join(&file)).unwrap();
                let text = String::from_utf8_lossy(&text);
                assert!(
                    text.contains(&extension),
                    "{file} does not need {extension}"
                );
                eprintln!("{file}: needs {extension}");
            }
            Err(error) => failures.push(error.to_string()),
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
    assert!(loaded >= 55, "only {loaded} loaded");
}

#[test]
fn small_generated_and_extension_files_load_or_name_what_they_need() {
    let Some(scenes) = shared("scenes") else {
        return;
    };
    for folder in ["asset-generator", "small-ext"] {
        for file in models(&scenes.join(folder)) {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            match load(&file) {
                Ok(imported) => {
                    check_contract(&imported.scene);
                    eprintln!(
                        "{name}: {} {:?}",
                        imported.scene.instanced_triangles(),
                        imported.warnings
                    );
                    assert!(
                        !name.contains("Compatibility_04") && !name.contains("Compatibility_05")
                    );
                }
                Err(error @ ImportError::Extension { .. }) => {
                    let text = error.to_string();
                    assert!(
                        text.contains("draco")
                            || text.contains("meshopt")
                            || text.contains("FAKE_"),
                        "{text}"
                    );
                }
                Err(error) => {
                    let text = error.to_string();
                    assert!(name.contains("Compatibility_04"), "{text}");
                    assert!(text.contains("2.1"), "{text}");
                }
            }
        }
    }
}

#[test]
fn references_load_with_camera_lights_and_environment() {
    let Some(reference) = shared("reference") else {
        return;
    };
    for file in models(&reference) {
        let imported = load(&file).unwrap_or_else(|error| panic!("{error}"));
        let scene = imported.scene;
        check_contract(&scene);
        assert_eq!(scene.cameras.len(), 1, "{}", file.display());
        assert!(default_camera(&scene).transform.is_finite());
        let folder = file
            .parent()
            .unwrap()
            .file_name()
            .unwrap()
            .to_string_lossy()
            .into_owned();
        eprintln!(
            "{folder}: {} {:?}",
            scene.instanced_triangles(),
            imported.warnings
        );
        match (folder.as_str(), &scene.environment) {
            (
                "envlit",
                Environment::Image {
                    image,
                    rotation,
                    intensity,
                },
            ) => {
                assert_eq!((image.width, image.height), (1024, 512));
                assert_eq!((*rotation, *intensity), (110.0, 1.0));
            }
            ("glass", Environment::Constant(color)) => {
                assert_eq!(color.to_array(), [0.25, 0.3, 0.36])
            }
            ("instances", Environment::Constant(color)) => {
                assert_eq!(color.to_array(), [0.35, 0.42, 0.5])
            }
            (_, Environment::Constant(color)) => assert_eq!(color.to_array(), [0.0; 3]),
            (name, environment) => panic!("{name}: {environment:?}"),
        }
        if folder == "punctual" {
            assert_eq!(scene.lights.len(), 3);
        }
        if folder == "instances" {
            assert!(scene.meshes.len() < scene.instances.len());
        }
    }
}

#[test]
fn the_living_room_has_its_sky_turned_by_its_matrix() {
    let Some(scenes) = shared("scenes") else {
        return;
    };
    let imported = load(&scenes.join("interior-living-room/living-room.gltf")).unwrap();
    let Environment::Image { rotation, .. } = imported.scene.environment else {
        panic!("has a picture");
    };
    assert!((rotation - 90.0).abs() < 1e-3, "{rotation}");
}
