//! The looks that ship with Patina, and those in its documentation, are right; mutations of them are survived.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use engine::load::{Loaded, load};
use engine::procedural::{Procedural, TextureSources};
use engine::scene::look::Look;
use engine::scene::{Material, Scene};

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

/// Numbers without a pattern.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit.max(1)
    }
}

/// Pieces that matter in a look.
const PIECES: &[&str] = &[
    "[node.a]",
    "[[include]]",
    "[material.",
    "]",
    "[",
    "\"",
    "\"\"\"",
    "=",
    "{",
    "}",
    ",",
    "1e999",
    "-1",
    "nan",
    "0x10",
    "#ff8000",
    "\"a.xyzw\"",
    "blend = { base = \"A\", over = \"B\", mask = \"mask\" }",
    "texture",
    "ramp",
    "occlusion",
    "environment",
    "camera",
    ".",
    "true",
    "\n",
    "é",
    "\u{0}",
    "99999999999999999999",
    "[[0.0, \"#000\"]]",
    "alpha_mode",
    "bump",
    "opacity",
    "normal",
    "'",
    "interpolation",
    "stops",
];

/// Changes a few pieces of a text; words change places with others of the text.
fn mutated(text: &str, random: &mut Random) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for _ in 0..1 + random.below(4) {
        let at = random.below(chars.len() + 1);
        let end = (at + random.below(16)).min(chars.len());
        let piece = PIECES[random.below(PIECES.len())].chars();
        match random.below(4) {
            0 => drop(chars.drain(at..end)),
            1 => drop(chars.splice(at..at, piece)),
            2 => drop(chars.splice(at..end, piece)),
            _ => {
                let text: String = chars.iter().collect();
                let words: Vec<&str> = text.split_whitespace().collect();
                let [a, b] = [0, 1].map(|_| words.get(random.below(words.len())).copied());
                let (a, b) = (a.unwrap_or_default(), b.unwrap_or_default());
                chars = text.replacen(a, b, 1 + random.below(3)).chars().collect();
            }
        }
    }
    chars.into_iter().collect()
}

#[test]
fn mutated_looks_are_survived() {
    let (budget, most) = match std::env::var_os("PATINA_FULL").is_some() {
        true => (Duration::from_secs(300), 200_000),
        false => (Duration::from_secs(10), 5_000),
    };
    let sources = TextureSources::scan(&[root().join("user_textures")]).expect("they are there");
    let mut texts: Vec<String> = documentation()
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap_or(rest).to_owned())
        .collect();
    let demo = root().join("examples/demo/demo.look.toml");
    texts.push(std::fs::read_to_string(demo).expect("a part of the project"));
    let names = [
        "A",
        "B",
        "Helmet",
        "ValvePaint",
        "WheelPaint",
        "Copper",
        "Steel",
        "Floor",
    ];
    let bare = Scene {
        materials: names
            .map(|name| Material {
                name: name.to_owned(),
                ..Material::default()
            })
            .to_vec(),
        ..Scene::default()
    };
    let mut random = Random(5);
    let start = Instant::now();
    let (mut tried, mut parsed, mut built) = (0, 0, 0);
    let mut slowest = Duration::ZERO;
    while start.elapsed() < budget && tried < most {
        tried += 1;
        let text = mutated(&texts[random.below(texts.len())], &mut random);
        let began = Instant::now();
        let problems = match Look::parse(Path::new("mutated.look.toml"), &text) {
            Ok(look) => {
                parsed += 1;
                Procedural::build(&look, &mut bare.clone(), &sources).err()
            }
            Err(problems) => Some(problems),
        };
        slowest = slowest.max(began.elapsed());
        match problems {
            Some(problems) => {
                assert!(!problems.is_empty(), "refused without a reason:\n{text}");
                for problem in &problems {
                    assert!(!problem.message.is_empty(), "{text}");
                }
            }
            None => built += 1,
        }
    }
    eprintln!(
        "{tried} mutated looks, {parsed} parsed, {built} built, the slowest took {slowest:?}"
    );
    assert!(parsed * 20 > tried, "most mutations must be subtle");
    // Far more than any took; a machine may be busy.
    assert!(slowest < Duration::from_secs(10), "{slowest:?}");
}
