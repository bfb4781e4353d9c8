//! `docs/texture-language.md` tells the truth: its examples are compiled, its tables compared with the code.

use crate::common::{errors_of, parse, shipped, validate};
use texgen::{BUILTIN_ATTRIBUTES, GLOBALS, HOST_STUB, Library, PRELUDE, TextureType};

fn page() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/texture-language.md");
    std::fs::read_to_string(path).expect("the page is part of the repository")
}

/// The code blocks whose fence line is exactly "```" and `kind`.
fn blocks(kind: &str) -> Vec<String> {
    let page = page();
    let mut blocks = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(found) = line.strip_prefix("```").filter(|found| !found.is_empty()) {
            let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            if found == kind {
                blocks.push(block.join("\n") + "\n");
            }
        }
    }
    blocks
}

#[test]
fn examples_are_valid_textures() {
    let blocks = blocks("wgsl");
    assert!(blocks.len() >= 5, "the page has lost its examples");
    for text in blocks {
        let texture = parse("example", &text).unwrap_or_else(|problems| panic!("{problems}"));
        assert!(texture.warnings().is_empty(), "{}", texture.warnings());
        if !text.contains("readAttr(_") {
            validate(&format!("{PRELUDE}{text}")).unwrap_or_else(|problem| panic!("{problem}"));
        }
    }
}

#[test]
fn wrong_examples_give_the_errors_shown() {
    let wrong = blocks("wgsl,error");
    let reports = blocks("text");
    assert!(!wrong.is_empty() && wrong.len() == reports.len());
    for (text, report) in wrong.iter().zip(&reports) {
        let found = errors_of("example", text);
        assert!(
            found.starts_with(report.trim_end()),
            "the page shows\n{report}\nbut the error is\n{found}"
        );
    }
}

#[test]
fn tables_of_names_are_complete() {
    let page = page();
    let rows = BUILTIN_ATTRIBUTES
        .iter()
        .map(|a| (a.name(), a.description()));
    for (name, description) in rows.chain(GLOBALS.iter().map(|g| (g.name(), g.description()))) {
        let row = format!("| `{name}` | {description} |\n");
        assert!(page.contains(&row), "the page lacks the row\n{row}");
    }
    let listed = page
        .lines()
        .filter(|line| line.starts_with("| `") && line.matches('|').count() == 3);
    let names: Vec<&str> = listed.filter_map(|line| line.split('`').nth(1)).collect();
    for name in names
        .iter()
        .filter(|name| name.starts_with(char::is_uppercase))
    {
        let known = BUILTIN_ATTRIBUTES.iter().any(|a| a.name() == *name)
            || GLOBALS.iter().any(|g| g.name() == *name);
        assert!(known, "the page lists `{name}`, which does not exist");
    }
}

#[test]
fn the_prelude_has_the_names_and_sentences_of_the_code() {
    let rows = BUILTIN_ATTRIBUTES
        .iter()
        .map(|a| (a.name(), a.description()));
    for (name, description) in rows.chain(GLOBALS.iter().map(|g| (g.name(), g.description()))) {
        let found = PRELUDE.lines().any(|line| {
            line.starts_with(&format!("const {name} = "))
                && line.ends_with(&format!("// {description}"))
        });
        assert!(found, "the prelude lacks `{name}`: {description}");
    }
}

/// Heads of the prelude's functions, as `tex2D(image: sam2D, uv: vec2f) -> vec4f`.
fn functions() -> impl Iterator<Item = &'static str> {
    let functions = PRELUDE.lines().filter_map(|line| line.strip_prefix("fn "));
    functions.filter_map(|function| Some(function.split_once(" {")?.0))
}

/// Those that every host has to bring, whose bodies do nothing in the prelude.
fn stubs() -> impl Iterator<Item = &'static str> {
    let end = PRELUDE
        .find("// Standard functions")
        .unwrap_or(PRELUDE.len());
    let before = move |function: &&str| PRELUDE.find(*function).is_some_and(|at| at < end);
    functions().filter(before).filter(|f| !reads_by_name(f))
}

/// What reads by name has sections of its own, and becomes a call of the host's functions.
fn reads_by_name(function: &str) -> bool {
    ["readAttr(", "readGlobal("]
        .iter()
        .any(|reader| function.starts_with(reader))
}

#[test]
fn the_table_of_functions_is_that_of_the_prelude() {
    let page = page();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let listed = rows.filter_map(|row| Some(row.split_once("` |")?.0));
    let listed: Vec<&str> = listed.filter(|name| name.contains(") -> ")).collect();
    let declared: Vec<&str> = functions().filter(|f| !reads_by_name(f)).collect();
    for function in &listed {
        assert!(declared.contains(function), "the page lists `{function}`");
    }
    // Helpers of standard functions are not listed.
    for function in stubs() {
        assert!(listed.contains(&function), "the page lacks `{function}`");
    }
}

#[test]
fn the_runtime_has_every_function_of_the_prelude() {
    let kernel = Library::default().emit(1).wgsl;
    for function in stubs() {
        assert!(kernel.contains(&format!("fn {function} {{")), "{function}");
    }
}

#[test]
fn the_host_stub_has_a_function_for_every_name() {
    let host = validate(HOST_STUB).unwrap_or_else(|problem| panic!("{problem}"));
    let functions = host.functions.iter();
    let found: Vec<&str> = functions.filter_map(|(_, f)| f.name.as_deref()).collect();
    let attributes = BUILTIN_ATTRIBUTES.iter().map(|a| a.name());
    // `AO1` is another slot of `AO`.
    for name in attributes.filter(|&name| name != "AO1") {
        assert!(found.contains(&format!("patina_attr_{name}").as_str()));
    }
    for global in GLOBALS {
        assert!(found.contains(&format!("patina_global_{}", global.name()).as_str()));
    }
}

#[test]
fn every_shipped_texture_has_a_section_of_the_library_page() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/textures.md");
    let page = std::fs::read_to_string(path).expect("the page is part of the repository");
    for file in shipped() {
        let texture = TextureType::parse(file).unwrap_or_else(|problems| panic!("{problems}"));
        let section = format!("\n### {}\n\n{} ", texture.name(), texture.docs());
        assert!(page.contains(&section), "the page lacks\n{section}");
    }
}
