//! What a command line says in place of the look, and how mistakes in it are told.

use super::*;

const LOOK: &str = "environment = { color = [1, 1, 1], intensity = 2 }\n\n[node.squares]\ntexture = \"checker\"\nscale = 4\n\n\
                    [material.Glow]\nbase_color = \"squares\"\n";

/// Words of which one may have blanks.
fn run(bench: &Bench, line: &str, flags: &[&str]) -> Outcome {
    let mut command = bench.command(line);
    Outcome::of(command.args(flags).output().expect("patina starts"), line)
}

#[test]
fn mistakes_in_flags_name_the_flag_and_no_line() {
    let bench = Bench::new();
    fs::write(bench.path("a.look.toml"), LOOK).expect("written");
    for (flags, said) in [
        (&["--environment", "no.hdr"][..], "--environment no.hdr: "),
        (
            &["--camera-at", "1,2,3", "--look-at", "1,2,3"],
            "--look-at 1,2,3: ",
        ),
        (
            &["--set", "material.Glow.roughness=hello"],
            "--set material.Glow.roughness=hello: ",
        ),
        (
            &["--set", "material.Glw.metallic=1"],
            "--set material.Glw.metallic=1: ",
        ),
        (&["--set", "x.scale=3"], "--set x.scale=3: "),
        (&["--set", "view.exposure=[1]"], "--set view.exposure=[1]: "),
    ] {
        for look in ["--look a.look.toml", ""] {
            let line = format!("render triangle.gltf {look} -o a.png");
            let told = run(&bench, &line, flags).expect_error(1, said);
            assert!(!told.stderr.contains("-->"), "{line}: {}", told.stderr);
            let line = format!("{line} --message-format json");
            let told = run(&bench, &line, flags).expect_code(1).stderr;
            for message in told.lines() {
                let message: serde_json::Value = serde_json::from_str(message).expect("JSON");
                assert!(message.get("file").is_none(), "{line}: {message}");
            }
        }
    }
    assert_eq!(bench.files(), ["a.look.toml", "triangle.gltf"]);
}

#[test]
fn mistakes_in_the_file_have_the_lines_of_the_file() {
    let bench = Bench::new();
    let wrong = LOOK.replace("base_color ", "base_colour ");
    fs::write(bench.path("a.look.toml"), wrong).expect("written");
    let line = "render triangle.gltf --look a.look.toml -o a.png";
    // One puts a line before it, the other one is wrong itself.
    let flags = [
        "--set",
        "squares.color_a=[1, 0, 0]",
        "--set",
        "view.exposure=[1]",
    ];
    let told = run(&bench, line, &flags).expect_error(1, "a.look.toml:8:1");
    for said in [
        "8 | base_colour = \"squares\"",
        "--set view.exposure=[1]: expected stops",
    ] {
        assert!(told.stderr.contains(said), "{said}: {}", told.stderr);
    }
}

#[test]
fn a_texture_that_is_not_there_is_said_where_to_put() {
    let bench = Bench::new();
    run(
        &bench,
        "render triangle.gltf -o a.png",
        &["--set", "x.texture=qqqqqqqq"],
    )
    .expect_error(1, "`user_textures`");
}
