//! The looks that ship with Patina are right.

use std::path::{Path, PathBuf};

use engine::load::{Loaded, load};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

#[track_caller]
fn loaded(scene: &Path, look: &str) -> Loaded {
    let look = root().join("examples").join(look);
    load(scene, Some(&look), &[root().join("user_textures")])
        .unwrap_or_else(|error| panic!("{error}"))
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
