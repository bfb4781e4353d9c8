//! What hostile inputs are tried on: each [`Target`] takes any bytes, hands them to one reader of the engine's as a
//! user's file would get there, and panics where a promise of `docs/reliability.md` is broken.
//!
//! The targets are run here by the thousand in every test (`tests/bounded.rs`), for any time by this crate's program,
//! and guided by coverage under libFuzzer (`engine/fuzz`). Nothing else may depend on this crate but tests.

mod film;
mod gltf;
mod look;
pub mod memory;
pub mod mutate;
mod panorama;
mod render;
pub mod run;
pub mod seeds;
mod wgsl;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use mutate::Random;
use texgen::Diagnostics;

/// One kind of input.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Of the target and of libFuzzer's program.
    pub name: &'static str,
    /// Tries an input: whether it was read, which is less than that nothing is wrong with what it names. Panics where something is wrong.
    pub run: fn(&[u8]) -> bool,
    /// Inputs to begin with, most of them valid.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Changes an input so that the result is often still read to its end.
    pub mutate: fn(&[u8], &mut Random) -> Vec<u8>,
}

/// glTF scenes, as text and as `.glb`.
pub const GLTF: Target = Target {
    name: "gltf",
    run: gltf::run,
    seeds: seeds::gltf,
    mutate: mutate::gltf,
};
/// Looks, over a small scene.
pub const LOOK: Target = Target {
    name: "look",
    run: look::run,
    seeds: seeds::looks,
    mutate: mutate::look,
};
/// Textures.
pub const WGSL: Target = Target {
    name: "wgsl",
    run: wgsl::run,
    seeds: seeds::textures,
    mutate: mutate::texture,
};
/// Partial renders.
pub const FILM: Target = Target {
    name: "film",
    run: film::run,
    seeds: seeds::films,
    mutate: mutate::bytes,
};
/// Environment pictures: HDR, EXR and the other formats.
pub const PANORAMA: Target = Target {
    name: "panorama",
    run: panorama::run,
    seeds: seeds::panoramas,
    mutate: mutate::bytes,
};
/// Scenes and looks as in [`GLTF`] and [`LOOK`], rendered.
pub const RENDER: Target = Target {
    name: "render",
    run: render::run,
    seeds: seeds::scenes,
    mutate: mutate::scene,
};

/// All of them.
pub const TARGETS: [Target; 6] = [GLTF, LOOK, WGSL, FILM, PANORAMA, RENDER];

impl Target {
    /// Changes the first `size` of the bytes in place; returns how many there are then, which are not more than there is
    /// room for. As libFuzzer asks for it; it begins with an empty input, which becomes one of the seeds.
    pub fn change_in_place(&self, data: &mut [u8], size: usize, seed: u32) -> usize {
        static SEEDS: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
        let mut random = Random(u64::from(seed) << 32);
        let changed = if size < 2 {
            let seeds = SEEDS.get_or_init(self.seeds);
            seeds[random.below(seeds.len())].clone()
        } else {
            (self.mutate)(&data[..size], &mut random)
        };
        let size = changed.len().min(data.len());
        data[..size].copy_from_slice(&changed[..size]);
        size
    }
}

/// Makes panics print as they do elsewhere: libFuzzer's hook would end the program at those that readers catch.
pub fn catch_panics() {
    drop(std::panic::take_hook());
}

/// The project's root, with its examples.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// While there is one, this process's folder for inputs that have to be files stays; the last one takes it away.
#[derive(Debug)]
pub struct Scratch(());

impl Scratch {
    /// One more.
    pub fn hold() -> Self {
        *Self::held() += 1;
        Self(())
    }

    /// How many there are.
    fn held() -> MutexGuard<'static, usize> {
        static HELD: Mutex<usize> = Mutex::new(0);
        HELD.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where the folder is, if it is there.
    pub fn folder() -> PathBuf {
        std::env::temp_dir().join(format!("patina-fuzzing-{}", std::process::id()))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let mut held = Self::held();
        *held -= 1;
        if *held == 0 {
            // It may never have been made.
            let _ = std::fs::remove_dir_all(Self::folder());
        }
    }
}

/// That folder, which is made where it isn't there.
fn scratch() -> PathBuf {
    let folder = Scratch::folder();
    std::fs::create_dir_all(&folder).expect("the temporary folder can be written to");
    folder
}

/// Writes an input as a file.
fn file(name: &str, data: &[u8]) -> PathBuf {
    let path = scratch().join(name);
    std::fs::write(&path, data).expect("the temporary folder can be written to");
    path
}

/// A message must say something.
fn check_message(message: &str) {
    assert!(!message.trim().is_empty(), "a message without text");
}

/// What is shown of mistakes must say something, and nothing that steers a terminal.
fn check_report(problems: &Diagnostics) {
    let message = problems.render();
    check_message(&message);
    let control = message
        .chars()
        .find(|c| c.is_control() && !"\n\t".contains(*c));
    assert!(control.is_none(), "{control:?} in {message:?}");
}
