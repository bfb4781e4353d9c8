//! The importer on real files: every model of the shared test data that needs only supported extensions loads with
//! the number of triangles that the data's table states. Skipped with a notice where the data is absent.

use engine::scene::import::{ImportError, append, default_camera, load};
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
                    assert!(text.contains("meshopt") || text.contains("FAKE_"), "{text}");
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

/// The three squares of the test show the same mark: two by way of a texture transform, one by its coordinates.
#[test]
fn texture_transforms_lead_to_the_mark_of_the_sample_square() {
    let Some(scenes) = shared("scenes/khronos/TextureTransformMultiTest") else {
        return;
    };
    let scene = load(&scenes.join("TextureTransformMultiTest.glb"))
        .unwrap()
        .scene;
    // Mean texture coordinates over a square, which do not depend on the order of its corners.
    let center = |name: &str| {
        let mesh = scene.meshes.iter().find(|mesh| mesh.name == name).unwrap();
        let material = &scene.materials[mesh.triangle_materials[0] as usize];
        let texture = material.base_color_texture.unwrap();
        let uv = if texture.uv_set == 0 {
            &mesh.uv0
        } else {
            &mesh.uv1
        };
        let sum: glam::Vec2 = uv.iter().sum();
        let center = (sum / uv.len() as f32).extend(1.0);
        glam::Vec2::new(
            texture.transform[0].dot(center),
            texture.transform[1].dot(center),
        )
    };
    let sample = center("BaseColorSample");
    for name in ["BaseColorUV0", "BaseColorUV1"] {
        assert!(
            center(name).abs_diff_eq(sample, 0.01),
            "{name}: {} {sample}",
            center(name)
        );
    }
}

/// A file that brings tangents gets nearly the same ones computed when they are taken away.
#[test]
fn computed_tangents_agree_with_those_of_a_file() {
    let Some(folder) = shared("scenes/khronos/NormalTangentMirrorTest") else {
        return;
    };
    let path = folder.join("NormalTangentMirrorTest.glb");
    let given = load(&path).unwrap().scene;
    let text = std::fs::read(&path).unwrap();
    // The same number of bytes, so that the container stays valid: an attribute of that name is ignored.
    let mut changed = text.clone();
    let find = |bytes: &[u8]| bytes.windows(9).position(|window| window == b"\"TANGENT\"");
    while let Some(at) = find(&changed) {
        changed[at..at + 9].copy_from_slice(b"\"_ANGENT\"");
    }
    assert!(changed != text);
    let scratch = std::env::temp_dir().join(format!("patina-tangents-{}.glb", std::process::id()));
    std::fs::write(&scratch, changed).unwrap();
    let computed = load(&scratch).unwrap().scene;
    std::fs::remove_file(&scratch).unwrap();

    let (mut corners, mut alike) = (0, 0);
    for (a, b) in given.meshes.iter().zip(&computed.meshes) {
        assert_eq!(a.triangles.len(), b.triangles.len());
        if a.tangents.is_empty() || b.tangents.is_empty() {
            continue;
        }
        for (a_triangle, b_triangle) in a.triangles.iter().zip(&b.triangles) {
            for (&i, &j) in a_triangle.iter().zip(b_triangle) {
                let (s, t) = (a.tangents[i as usize], b.tangents[j as usize]);
                corners += 1;
                alike += usize::from(s.w == t.w && s.truncate().dot(t.truncate()) > 0.95);
            }
        }
    }
    eprintln!("{alike} of {corners} corners alike");
    assert!(corners > 1000 && alike * 100 >= corners * 98);
}

/// A scene in which nearly all triangles are from one file keeps its own view and gets unique names.
#[test]
fn a_model_can_be_put_into_sponza() {
    let Some(scenes) = shared("scenes") else {
        return;
    };
    let started = Instant::now();
    let mut scene = load(&scenes.join("Sponza/Sponza.gltf")).unwrap().scene;
    eprintln!("Sponza takes {:?}", started.elapsed());
    assert!(started.elapsed().as_secs() < 20);
    let before = (
        scene.materials.len(),
        scene.instances.len(),
        scene.cameras.len(),
    );
    let placement = glam::Affine3A::from_translation(glam::Vec3::new(0.0, 1.0, 0.0));
    let helmet = scenes.join("khronos/DamagedHelmet/DamagedHelmet.glb");
    for round in 0..2 {
        let added = append(&mut scene, &helmet, placement).unwrap();
        assert_eq!(added.instances.len(), 1);
        assert_eq!(
            added.renamed.len(),
            round,
            "the second helmet's material is renamed"
        );
    }
    assert_eq!(scene.materials.len(), before.0 + 2);
    assert_eq!(scene.instances.len(), before.1 + 2);
    assert_eq!(scene.cameras.len(), before.2);
    check_contract(&scene);
    let helmet = &scene.instances[before.1];
    let low = helmet.transform.translation.y;
    assert!((low - 1.0).abs() < 1e-5);
}
