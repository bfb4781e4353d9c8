//! The looks that ship with Patina, and those in its documentation, are right.

use std::path::{Path, PathBuf};

use engine::load::{Loaded, load};
use engine::scene::look::Look;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn documentation() -> String {
    std::fs::read_to_string(root().join("docs/look-file.md"))
        .expect("the documentation is part of the project")
}

#[track_caller]
fn loaded(scene: &Path, look: &str) -> Loaded {
    let look = root().join("examples").join(look);
    load(scene, Some(&look), &[root().join("user_textures")])
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_example_of_the_documentation_is_a_valid_look() {
    let text = documentation();
    let blocks: Vec<&str> = text
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap_or(rest))
        .collect();
    assert!(blocks.len() >= 10);
    for block in blocks {
        if let Err(problems) = Look::parse(Path::new("docs/look-file.md"), block) {
            panic!("{problems}\nin\n{block}");
        }
    }
}

#[test]
fn every_key_is_documented() {
    let text = documentation();
    let unknown = [
        "zzzzzzzzzz = 1",
        "environment = { zzzzzzzzzz = 1, color = [1, 1, 1] }",
        "[camera]\nzzzzzzzzzz = 1",
        "[ao.a]\ndistance = 1\nzzzzzzzzzz = 1",
        "[material.a]\nzzzzzzzzzz = 1",
        "[material.a]\nblend = { base = 'b', over = 'c', mask = 1, zzzzzzzzzz = 1 }",
        "[[include]]\nfile = 'a'\nzzzzzzzzzz = 1",
    ];
    for look in unknown {
        let problems = Look::parse(Path::new("test"), look).expect_err("the key is unknown");
        let note = &problems.as_slice()[0].notes[0];
        let keys = note
            .strip_prefix("it has: ")
            .expect("nothing is near this key");
        for key in keys.split(", ") {
            let is_there = [
                format!("`{key}`"),
                format!("[{key}.NAME]"),
                format!("[{key}]"),
                format!("{key} ="),
            ];
            assert!(
                is_there.iter().any(|form| text.contains(form)),
                "`{key}` is not documented"
            );
        }
    }
}

#[test]
fn the_demo_weathers_its_valve_and_scratches_its_tools() {
    let loaded = loaded(
        &root().join("examples/demo/demo.gltf"),
        "demo/demo.look.toml",
    );
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let triangles = loaded.scene.instanced_triangles();
    assert!((30_000..120_000).contains(&triangles), "{triangles}");
    for name in ["ValvePaint", "WheelPaint", "Copper", "Steel", "Floor"] {
        let index = loaded.scene.materials.iter().position(|m| m.name == name);
        let index = index.unwrap_or_else(|| panic!("no {name}")) as u32;
        assert!(loaded.procedural.is_procedural(index), "{name}");
    }
    assert_eq!(loaded.procedural.ao_count(), 1);
}

#[test]
fn the_sponza_looks_put_a_car_into_the_hall() {
    let sponza = root().join("../shared/scenes/Sponza/Sponza.gltf");
    if !sponza.exists() {
        eprintln!("skipped: {} is not here", sponza.display());
        return;
    }
    for look in ["sponza-rust.look.toml", "sponza-scratches.look.toml"] {
        let loaded = loaded(&sponza, look);
        let car = loaded
            .scene
            .materials
            .iter()
            .position(|m| m.name == "car/ToyCar");
        assert!(
            loaded
                .procedural
                .is_procedural(car.expect("the car is included") as u32)
        );
        let (low, high) = loaded.scene.bounds().expect("there are triangles");
        assert!(
            low.y > -2.0 && high.y < 13.0,
            "the car stands in the hall: {low} {high}"
        );
    }
}
