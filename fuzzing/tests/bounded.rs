//! Every target on some thousands of inputs, always the same ones; with `PATINA_FULL` set, on many more.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use fuzzing::memory::Counting;
use fuzzing::{FILM, GLTF, LOOK, PANORAMA, RENDER, Scratch, Target, WGSL, run};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// One after the other, because memory is counted, and files are taken away, for the whole process.
static ALONE: Mutex<()> = Mutex::new(());

/// Tries up to `most` inputs; fewer where a machine needs more than some seconds for them.
fn bounded(target: Target, most: u64, seconds: u64) {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let (budget, most) = match std::env::var_os("PATINA_FULL").is_some() {
        true => (Duration::from_secs(15 * seconds), 100 * most),
        false => (Duration::from_secs(seconds), most),
    };
    let tried = run::run(&target, 0, most, budget);
    eprintln!("{}: {tried:?}", target.name);
    let folder = Scratch::folder();
    assert!(!folder.exists(), "{} is left behind", folder.display());
    let is_skipped = target.name == RENDER.name && tried.accepted == 0;
    assert!(
        is_skipped || tried.accepted * 20 > tried.inputs,
        "most changes must be subtle"
    );
}

#[test]
fn changed_scenes_are_imported_or_refused() {
    bounded(GLTF, 6000, 8);
}

#[test]
fn changed_looks_are_applied_or_refused() {
    bounded(LOOK, 5000, 8);
}

#[test]
fn changed_textures_are_valid_in_the_kernel_or_refused() {
    bounded(WGSL, 8000, 8);
}

#[test]
fn changed_films_are_read_as_they_are_written_or_refused() {
    bounded(FILM, 20_000, 8);
}

#[test]
fn changed_pictures_are_finite_or_refused() {
    bounded(PANORAMA, 10_000, 8);
}

#[test]
fn changed_scenes_are_rendered_or_refused() {
    // A device compiles its kernels for each of them.
    bounded(RENDER, 300, 20);
}

/// Were failures overlooked or lost, all of the above would be worth nothing.
#[test]
fn an_input_that_fails_is_kept() {
    let target = Target {
        name: "kept",
        run: |data| {
            assert!(data != b"bad");
            true
        },
        seeds: || vec![b"good".to_vec(), b"bad".to_vec()],
        mutate: |data, _| data.to_vec(),
    };
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let failed = std::panic::catch_unwind(|| run::run(&target, 0, 10, Duration::from_secs(60)));
    let panic = failed.expect_err("the second input fails");
    let message = panic.downcast_ref::<String>().expect("a message");
    let path = message.trim_end_matches('`').rsplit(' ').next();
    let path = path.expect("a file");
    assert!(message.contains("kept: input 1 fails"), "{message}");
    assert_eq!(std::fs::read(path).expect("the message names it"), b"bad");
    std::fs::remove_file(path).expect("it was there");
}
