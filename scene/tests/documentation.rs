//! The page on the look file is right: its examples are looks, and it has every key.

use std::path::Path;

use scene::look::Look;

fn documentation() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/look-file.md"))
        .expect("the documentation is part of the project")
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
