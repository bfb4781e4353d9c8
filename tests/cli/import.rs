//! `patina import` on the command line.

use super::*;

/// A surface whose emission is a checkerboard of two colours, and a coat that can't be had.
const DOCUMENT: &str = r#"<?xml version="1.0"?>
<materialx version="1.39">
  <nodegraph name="pattern">
    <position name="place" type="vector3"/>
    <convert name="uv" type="vector2"><input name="in" type="vector3" nodename="place"/></convert>
    <checkerboard name="squares" type="color3">
      <input name="color1" type="color3" value="4, 0, 0"/>
      <input name="color2" type="color3" value="0, 0, 4"/>
      <input name="uvtiling" type="vector2" value="2, 2"/>
      <input name="texcoord" type="vector2" nodename="uv"/>
    </checkerboard>
    <output name="out" type="color3" nodename="squares"/>
  </nodegraph>
  <standard_surface name="shader" type="surfaceshader">
    <input name="emission" type="float" value="1"/>
    <input name="emission_color" type="color3" nodegraph="pattern" output="out"/>
    <input name="coat" type="float" value="1"/>
    <input name="coat_IOR" type="float" value="1.7"/>
  </standard_surface>
  <surfacematerial name="Squares" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="shader"/>
  </surfacematerial>
</materialx>
"#;

#[test]
fn a_document_becomes_a_look() {
    let bench = Bench::new();
    fs::write(bench.path("a.mtlx"), DOCUMENT).expect("written");
    let run = bench.run("import a.mtlx --name Glow").expect_code(0);
    assert!(
        run.stderr.contains("`coat_IOR` has no counterpart"),
        "{}",
        run.stderr
    );
    assert!(run.stderr.contains("a.mtlx:18:5"), "{}", run.stderr);
    let look = fs::read_to_string(bench.path("a.look.toml")).expect("written");
    assert!(look.contains("[material.Glow]"), "{look}");
    assert!(look.contains("emission = \"pattern_squares\""), "{look}");
    // The nodes are textures like any other.
    let line = "texture eval pattern_squares --look a.look.toml --device native --at WorldPos=0.2,0.2 --at WorldPos=0.7,0.2";
    let values = bench.run(line).expect_code(0).stdout;
    assert_eq!(values, "0 0 4 1\n4 0 0 1\n", "{values}");
    // The scene's material looks like it, by this look and by one that names the document.
    let named = "[[materialx]]\nfile = \"a.mtlx\"\nname = \"Glow\"\n";
    fs::write(bench.path("named.look.toml"), named).expect("written");
    for (look, output) in [("a", "a.exr"), ("named", "b.exr")] {
        let line = format!(
            "render triangle.gltf --look {look}.look.toml --device native --size 32x32 --spp 4 -o {output}"
        );
        bench.run(&line).expect_code(0);
    }
    bench.run("compare a.exr b.exr --max-mse 0").expect_code(0);
    bench
        .run("render triangle.gltf --device native --size 32x32 --spp 4 -o plain.exr")
        .expect_code(0);
    bench
        .run("compare a.exr plain.exr --max-mse 0.1")
        .expect_code(1);
    // Nothing is overwritten.
    bench.run("import a.mtlx").expect_error(1, "exists already");
    bench
        .run("import a.mtlx --material Rounds -o b.toml")
        .expect_error(1, "called `Rounds`");
    bench
        .run("import none.mtlx -o b.toml")
        .expect_error(1, "cannot read");
    bench
        .run("import look.txt -o b.toml")
        .expect_error(1, "cannot read");
}

#[test]
fn what_an_import_cannot_do_is_said_at_once() {
    let bench = Bench::new();
    fs::write(bench.path("a.mtlx"), DOCUMENT).expect("written");
    bench
        .run("import a.mtlx -o no/such/a.look.toml")
        .expect_error(1, "the folder no/such does not exist");
    bench
        .run("import a.mtlx --name=")
        .expect_error(2, "--name: the name is empty");
    assert_eq!(bench.files(), ["a.mtlx", "triangle.gltf"]);
}

/// What makes the triangle's emission a checkerboard, and a place that is no texture coordinate.
const PROCEDURALS: &str = r#"
  "extensionsUsed": ["KHR_texture_procedurals", "EXT_texture_procedurals_mx_1_39"],
  "extensions": { "KHR_texture_procedurals": { "procedurals": [ {
    "name": "pattern", "nodetype": "nodegraph", "type": "color3",
    "nodes": [
      { "name": "place", "nodetype": "position", "type": "vector3" },
      { "name": "uv", "nodetype": "convert", "type": "vector2",
        "inputs": { "in": { "nodetype": "input", "type": "vector3", "node": 0 } } },
      { "name": "squares", "nodetype": "checkerboard", "type": "color3", "inputs": {
        "color1": { "nodetype": "input", "type": "color3", "value": [4, 0, 0] },
        "color2": { "nodetype": "input", "type": "color3", "value": [0, 0, 4] },
        "uvtiling": { "nodetype": "input", "type": "vector2", "value": [2, 2] },
        "texcoord": { "nodetype": "input", "type": "vector2", "node": 1 } } } ],
    "outputs": { "out": { "nodetype": "output", "type": "color3", "node": 2 } } } ] } },
  "textures": [{ "source": 0 }],
  "images": [{ "uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR42mP4//8/AAX+Av4zEpUUAAAAAElFTkSuQmCC" }],
  "scene": 0,"#;
const BOUND: &str = r#""emissiveTexture": { "index": 0, "extensions": { "KHR_texture_procedurals": { "index": 0, "output": "out" } } },
    "emissiveFactor""#;

#[test]
fn drafts_of_gltf_become_a_look_where_they_are_wanted() {
    let bench = Bench::new();
    let text = TRIANGLE.replace("\n  \"scene\": 0,", PROCEDURALS);
    let text = text.replace("\"emissiveFactor\"", BOUND);
    fs::write(bench.path("drafts.gltf"), &text).expect("written");
    bench.run("import drafts.gltf").expect_error(1, "--drafts");
    bench.run("import drafts.gltf --drafts").expect_code(0);
    let line = "texture eval pattern_squares --look drafts.look.toml --device native --at WorldPos=0.2,0.2 --at WorldPos=0.7,0.2";
    let values = bench.run(line).expect_code(0).stdout;
    assert_eq!(values, "0 0 4 1\n4 0 0 1\n", "{values}");
    // The model is seen as with its own MaterialX, whichever way the graph is read.
    fs::write(bench.path("a.mtlx"), DOCUMENT).expect("written");
    let looks = [
        (
            "mtlx",
            "[[materialx]]\nfile = \"a.mtlx\"\nname = \"Glow\"\n[material.Glow]\nbase_color = [1.0, 1.0, 1.0]\ncoat = 0.0\nroughness = 1.0\n",
        ),
        (
            "own",
            "[[materialx]]\nfile = \"drafts.gltf\"\ndrafts = true\n",
        ),
    ];
    for (name, look) in looks {
        fs::write(bench.path(&format!("{name}.look.toml")), look).expect("written");
    }
    for look in ["drafts", "own", "mtlx"] {
        let line = format!(
            "render drafts.gltf --look {look}.look.toml --device native --size 32x32 --spp 4 -o {look}.exr"
        );
        bench.run(&line).expect_code(0);
    }
    bench
        .run("compare drafts.exr own.exr --max-mse 0")
        .expect_code(0);
    bench
        .run("compare drafts.exr mtlx.exr --max-mse 0.0001")
        .expect_code(0);
    let wrong = text.replace("\"node\": 1", "\"node\": 9");
    fs::write(bench.path("wrong.gltf"), wrong).expect("written");
    bench
        .run("import wrong.gltf --drafts")
        .expect_error(1, "the node `squares` is connected to node 9");
}
