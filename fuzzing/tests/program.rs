//! The crate's program: what it says of files that it can't read or write.

use std::process::Command;

fn fuzzing(words: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_fuzzing"))
        .args(words)
        .output()
        .expect("it starts");
    let told = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&told).into_owned(),
    )
}

#[test]
fn files_that_can_not_be_used_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (code, told) = fuzzing(&["look", &path("none.toml")]);
    assert!(code == Some(1) && told.contains("none.toml"), "{told}");
    // A file where a folder is wanted.
    std::fs::write(path("taken"), "").expect("written");
    let (code, told) = fuzzing(&["look", "--seeds", &path("taken")]);
    assert!(code == Some(1) && told.contains("taken"), "{told}");
    assert_eq!(fuzzing(&["look", "--seeds", &path("seeds")]).0, Some(0));
    let (code, told) = fuzzing(&["look", &path("seeds/seed-0")]);
    assert!(code == Some(0) && told.contains("seed-0: "), "{told}");
}

#[test]
fn what_makes_no_sense_shows_the_usage() {
    for words in [&["nothing"][..], &["look"], &["look", "--seconds", "x"]] {
        let (code, told) = fuzzing(words);
        assert!(code == Some(2) && told.starts_with("Usage: "), "{told}");
    }
}
