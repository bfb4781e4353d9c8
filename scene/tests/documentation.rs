//! The page on the look file is right: its examples are looks, and it has every key.

use std::path::{Path, PathBuf};

use scene::import::FORMATS;
use scene::look::Look;
use scene::material_parameters::PARAMETERS;

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/look-file.md")
}

fn documentation() -> String {
    std::fs::read_to_string(page()).expect("the documentation is part of the project")
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
        "[view]\nzzzzzzzzzz = 1",
        "[ao.a]\ndistance = 1\nzzzzzzzzzz = 1",
        "[material.a]\nzzzzzzzzzz = 1",
        "[material.a]\nblend = { base = 'b', over = 'c', mask = 1, zzzzzzzzzz = 1 }",
        "[graph.a]\nzzzzzzzzzz = 1",
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

/// The rows of `[material.NAME]`, as the table of parameters has them.
fn parameters() -> String {
    let rows = PARAMETERS.iter().map(|parameter| {
        let (key, takes, help) = (parameter.key, parameter.takes_text(), parameter.help);
        format!("| `{key}` | {takes} | {help} |\n")
    });
    let others = [
        "| `blend` | table | see below |\n",
        "| `group` | `\"NAME\"` | the [group of lights](layers.md#parts-of-the-light) that what it emits belongs to |\n",
    ];
    rows.chain(others.map(str::to_owned)).collect()
}

/// `UPDATE_SNAPSHOTS=1` writes what is wrong.
#[test]
fn the_table_of_materials_is_that_of_the_reader() {
    let text = documentation();
    let start = text.find("| `base_color` |").expect("its first row");
    let length = text[start..].find("\n\n").expect("its end") + 1;
    let table = &text[start..start + length];
    let expected = parameters();
    if table != expected && std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(page(), text.replacen(table, &expected, 1)).expect("written");
        return;
    }
    assert_eq!(table, expected, "UPDATE_SNAPSHOTS=1 writes the table anew");
}

#[test]
fn the_page_of_formats_lists_them() {
    let page = page().with_file_name("formats.md");
    let text = std::fs::read_to_string(page).expect("the documentation is part of the project");
    let rows = text.lines().filter(|line| line.starts_with("| "));
    let known = FORMATS.iter().map(|format| {
        let endings: Vec<_> = format.endings.iter().map(|e| format!("`.{e}`")).collect();
        format!(
            "| {} | {} | {} |",
            format.name,
            endings.join(" "),
            format.help
        )
    });
    assert_eq!(rows.skip(1).collect::<Vec<_>>(), known.collect::<Vec<_>>());
}
