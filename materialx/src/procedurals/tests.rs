use std::path::Path;

use crate::{Converted, Document, Wanted, convert, look_text};
use scene::input::Disk;

/// Graph inputs and nodes as the draft has them now; the checker of two colours, times a factor, and a number of each channel.
const CHECKER: &str = r#"{
  "asset": { "version": "2.0" },
  "extensionsUsed": ["KHR_texture_procedurals", "EXT_texture_procedurals_mx_1_39"],
  "extensions": { "KHR_texture_procedurals": { "procedurals": [ {
    "name": "squares", "nodetype": "nodegraph", "type": "multioutput",
    "inputs": { "dark": { "nodetype": "input", "type": "color3", "value": [0.1, 0.2, 0.3] } },
    "nodes": [
      { "name": "place", "nodetype": "texcoord", "type": "vector2",
        "inputs": { "index": { "nodetype": "input", "type": "integer", "value": [0] } } },
      { "name": "pattern", "nodetype": "checkerboard", "type": "color3", "inputs": {
        "color1": { "nodetype": "input", "type": "color3", "input": "dark" },
        "color2": { "nodetype": "input", "type": "color3", "value": [0.9, 0.8, 0.7] },
        "uvtiling": { "nodetype": "input", "type": "vector2", "value": [4, 4] },
        "texcoord": { "nodetype": "input", "type": "vector2", "node": 0, "output": "out" } } } ],
    "outputs": { "color": { "nodetype": "output", "type": "color3", "node": 1, "output": "out" } } } ] } },
  "materials": [
    { "name": "Plain" },
    { "name": "Floor", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0.25,
      "baseColorTexture": { "index": 0, "extensions": { "KHR_texture_procedurals": { "index": 0, "output": "color" } } },
      "metallicRoughnessTexture": { "index": 0, "extensions": { "KHR_texture_procedurals": { "index": 0, "output": "color" } } } } } ]
}"#;

fn read(text: &str) -> Result<Converted, String> {
    let rendered = |problems: texgen::Diagnostics| problems.render();
    let document =
        Document::of_gltf(Path::new("floor.gltf"), text).map_err(|problem| problem.render())?;
    convert(&document, &Disk, &Wanted::default()).map_err(rendered)
}

#[test]
fn a_graph_drives_what_its_material_binds() {
    let converted = read(CHECKER).unwrap_or_else(|problem| panic!("{problem}"));
    assert!(
        converted.warnings.iter().next().is_none(),
        "{}",
        converted.warnings.render()
    );
    let text = look_text(&converted);
    assert_eq!(converted.materials.len(), 1, "{text}");
    for line in [
        "texture = \"mx_checkerboard\"",
        "color1 = [0.1, 0.2, 0.3, 1.0]",
        "[material.Floor]",
        "base_color = \"Floor_base_color_factor\"",
        "roughness = \"squares_pattern.y\"",
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
}

#[test]
fn lists_may_be_arrays_as_in_older_drafts() {
    let old = CHECKER
        .replace(
            r#"{ "dark": { "nodetype""#,
            r#"[ { "name": "dark", "nodetype""#,
        )
        .replace("[0.1, 0.2, 0.3] } }", "[0.1, 0.2, 0.3] } ]")
        .replace(r#""input": "dark""#, r#""input": 0"#);
    assert_ne!(old, CHECKER);
    let look = |text: &str| look_text(&read(text).unwrap_or_else(|problem| panic!("{problem}")));
    assert_eq!(look(&old), look(CHECKER));
}

#[test]
fn mistakes_name_the_node() {
    let wrong = |from: &str, to: &str| {
        let text = CHECKER.replace(from, to);
        assert_ne!(text, CHECKER, "{from}");
        read(&text).expect_err("a mistake")
    };
    for (from, to, says) in [
        (
            "\"node\": 0",
            "\"node\": 7",
            "the input `texcoord` of the node `pattern` is connected to node 7, but the graph has 2",
        ),
        (
            "\"input\": \"dark\"",
            "\"input\": \"drak\"",
            "inputs of the graph: dark",
        ),
        (
            "\"nodetype\": \"checkerboard\",",
            "",
            "the node `pattern` has no `nodetype`",
        ),
        (
            "\"output\": \"color\" } } },\n      \"metal",
            "\"output\": \"colour\" } } },\n      \"metal",
            "did you mean `color`?",
        ),
        (
            "[4, 4]",
            "[[4], 4]",
            "the value of the input `uvtiling` of `pattern`",
        ),
        (
            "\"EXT_texture_procedurals_mx_1_39\"",
            "\"EXT_texture_procedurals_mx_1_40\"",
            "the nodes of `EXT_texture_procedurals_mx_1_40` are not known",
        ),
        (
            "[0.9, 0.8, 0.7]",
            "{ \"texture\": 3 }",
            "the value of the input `color2`",
        ),
        ("\"asset\"", "asset", "not valid JSON"),
    ] {
        let text = wrong(from, to);
        assert!(text.contains(says), "{says} is not in\n{text}");
    }
}

#[test]
fn drafts_have_to_be_wanted() {
    let error = Document::open(&Disk, Path::new("nothing.glb"), false).expect_err("a draft");
    assert!(error.render().contains("--drafts"), "{}", error.render());
}
