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
    <input name="coat_color" type="color3" value="1, 0, 0"/>
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
        run.stderr.contains("`coat_color` has no counterpart"),
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
        .run("import triangle.gltf -o b.toml")
        .expect_error(1, "not valid XML");
}
