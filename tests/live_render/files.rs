//! Files that change below a render: saved, broken, mended, replaced, gone.

use std::fs;

use engine::live::{Edit, LiveError};

use crate::look::{LOOK, RINGS, SQUARES, TEXTURES, TINT};
use crate::stage::{Stage, film, is_same, read, settle};
use crate::support::device;

#[test]
fn a_source_is_swapped_and_a_wrong_one_is_not() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut live = stage.open("scene.look.toml");
    let old = film(&mut live);
    let pipelines = live.renderer().gpu().counts().pipelines;

    stage.write("textures/rings.wgsl", &RINGS.replace("sin(", "sinn("));
    live.sources_changed();
    settle(&mut live);
    let shown = live.problems().to_string();
    for part in ["rings.wgsl:3:24", "sinn", "^"] {
        assert!(shown.contains(part), "{part} is missing:\n{shown}");
    }
    assert!(is_same(&old, &film(&mut live)), "the picture is not lost");
    assert_eq!(live.renderer().gpu().counts().pipelines, pipelines);

    stage.replace("textures/rings.wgsl", SQUARES);
    live.sources_changed();
    assert!(live.is_building());
    settle(&mut live);
    assert!(live.problems().is_empty(), "{}", live.problems());
    assert_eq!(live.renderer().gpu().counts().pipelines, pipelines + 1);
    let new = film(&mut live);
    assert!(!is_same(&old, &new) && is_same(&new, &stage.fresh(LOOK)));

    // Wrong again, then as it is in use: nothing is built, and the error is gone.
    stage.write("textures/rings.wgsl", "");
    live.sources_changed();
    settle(&mut live);
    assert!(!live.problems().is_empty());
    stage.write("textures/rings.wgsl", SQUARES);
    let generation = live.generation();
    live.sources_changed();
    assert!(!live.is_building() && live.problems().is_empty());
    assert_eq!(live.generation(), generation);
}

#[test]
fn a_look_is_followed_by_difference() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut live = stage.open("scene.look.toml");
    let old = film(&mut live);
    let pipelines = live.renderer().gpu().counts().pipelines;
    // Comments mean nothing.
    stage.write("scene.look.toml", &LOOK.replace("# of them", "# of rings"));
    let generation = live.generation();
    live.look_changed();
    assert_eq!(live.generation(), generation);
    // Several tables at once, with nodes that come, go, and are linked the other way round.
    let changed = LOOK
        .replace("count = 5.0", "count = 'other'")
        .replace("amount = \"rings\"", "amount = 'extra.x'")
        .replace("y_fov = 45", "y_fov = 50")
        .replace("coat = 0.5", "coat = 0.7")
        .replace("distance = 0.4", "distance = 0.8")
        + "\n[node.extra]\ntexture = 'tint'\n";
    stage.replace("scene.look.toml", &changed);
    live.look_changed();
    assert!(
        live.is_up_to_date() && live.problems().is_empty(),
        "{}",
        live.problems()
    );
    assert_eq!(live.renderer().gpu().counts().pipelines, pipelines);
    let new = film(&mut live);
    assert!(!is_same(&old, &new) && is_same(&new, &stage.fresh(&changed)));
    // And all the way back.
    stage.write("scene.look.toml", LOOK);
    live.look_changed();
    settle(&mut live);
    assert!(is_same(&old, &film(&mut live)));
    assert_eq!(live.renderer().gpu().counts().pipelines, pipelines);
}

#[test]
fn mistakes_in_a_look_are_told_and_forgotten() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut live = stage.open("scene.look.toml");
    let old = film(&mut live);
    let rebuilt = live.generation();
    for (from, to, says) in [
        ("[camera]", "[camera", "not valid TOML"),
        ("count = 5.0", "cuont = 5.0", "scene.look.toml:16:1"),
        ("count = 5.0", "count = [1, 2]", "scene.look.toml:16:9"),
        (
            "amount = \"rings\"",
            "amount = \"rigns\"",
            "did you mean `rings`?",
        ),
        ("\"tint\"", "\"tnt\"", "did you mean `tint`?"),
        ("over = \"Worn\"", "over = \"Wron\"", "did you mean `Worn`?"),
        ("roughness = 0.9", "roughness = 9", "0 to 1"),
        (
            "look_at = [0, 0.4, 0]",
            "look_at = [0.1, 0.9, 3.0]",
            "no direction",
        ),
        (
            "environment",
            "[[include]]\nfile = 'no.glb'\n[other]\nenvironment",
            "no key `other`",
        ),
    ] {
        stage.write("scene.look.toml", &LOOK.replacen(from, to, 1));
        live.look_changed();
        settle(&mut live);
        let shown = live.problems().to_string();
        assert!(shown.contains(says), "{to}: {shown}");
        assert!(
            is_same(&old, &film(&mut live)),
            "{to}: the picture is not lost"
        );
        stage.write("scene.look.toml", LOOK);
        live.look_changed();
        settle(&mut live);
        assert!(live.problems().is_empty(), "{to}: {}", live.problems());
        assert!(live.is_up_to_date());
    }
    assert_eq!(live.generation(), rebuilt, "nothing was built anew");
    assert!(is_same(&old, &film(&mut live)));
}

#[test]
fn a_texture_that_is_new_to_the_look_costs_one_kernel() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut live = stage.open("scene.look.toml");
    let pipelines = live.renderer().gpu().counts().pipelines;
    let changed = LOOK.replace("base_color = \"worn\"", "base_color = \"spots\"")
        + "\n[node.spots]\ntexture = 'squares'\nedge = 0.4\n";
    // The look comes before its texture does.
    stage.write("scene.look.toml", &changed);
    live.look_changed();
    settle(&mut live);
    assert!(
        live.problems()
            .to_string()
            .contains("no texture called `squares`"),
        "{}",
        live.problems()
    );
    stage.write(
        "textures/squares.wgsl",
        &SQUARES.replace("select", "selekt"),
    );
    live.sources_changed();
    settle(&mut live);
    assert!(
        live.problems().to_string().contains("squares.wgsl:5"),
        "{}",
        live.problems()
    );
    stage.write("textures/squares.wgsl", SQUARES);
    live.sources_changed();
    settle(&mut live);
    assert!(live.problems().is_empty(), "{}", live.problems());
    assert_eq!(live.renderer().gpu().counts().pipelines, pipelines + 1);
    assert!(is_same(&film(&mut live), &stage.fresh(&changed)));
}

#[test]
fn ten_saves_in_a_row_end_with_the_last() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut live = stage.open("scene.look.toml");
    for i in 0..10 {
        let text = TINT.replace("amount * amount", &format!("amount * 0.{}", i + 1));
        match i % 3 {
            0 => stage.write("textures/tint.wgsl", &text),
            1 => stage.replace("textures/tint.wgsl", &text),
            // Half of a file, then all of it.
            _ => {
                stage.write("textures/tint.wgsl", &text[..text.len() / 2]);
                live.sources_changed();
                stage.write("textures/tint.wgsl", &text);
            }
        }
        live.sources_changed();
        live.step(2).unwrap_or_else(|error| panic!("{error}"));
    }
    settle(&mut live);
    assert!(live.problems().is_empty(), "{}", live.problems());
    assert!(is_same(&film(&mut live), &stage.fresh(LOOK)));
}

#[test]
fn files_that_vanish_take_nothing_with_them() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut live = stage.open("scene.look.toml");
    let old = film(&mut live);
    let files = live.files();
    for name in ["scene.gltf", "squares.bin", "scene.look.toml"] {
        assert!(
            files.contains(&stage.path(name)),
            "{name} is not among {files:?}"
        );
    }
    for name in [
        "scene.look.toml",
        "textures/rings.wgsl",
        "scene.gltf",
        "squares.bin",
    ] {
        let aside = stage.path("gone");
        fs::rename(stage.path(name), &aside).expect("it is there");
        live.look_changed();
        live.sources_changed();
        live.assets_changed();
        settle(&mut live);
        assert!(!live.problems().is_empty(), "{name} is missed");
        live.step(2)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(live.look_text(), LOOK, "{name}");
        assert!(
            is_same(&old, &film(&mut live)),
            "{name}: the picture is not lost"
        );
        fs::rename(&aside, stage.path(name)).expect("back");
        live.look_changed();
        live.sources_changed();
        live.assets_changed();
        settle(&mut live);
        assert!(live.problems().is_empty(), "{name}: {}", live.problems());
        assert!(is_same(&old, &film(&mut live)), "{name} is back");
    }
}

#[test]
fn what_others_wrote_is_not_saved_over_unasked() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut live = stage.open("scene.look.toml");
    let edit = Edit::argument("rings", "count", &texgen::Value::F32(7.0));
    live.edit(&edit).expect("edited");
    // Half of a file: nothing of it can be taken over.
    let half = format!("{}\nramp = [", &LOOK[..LOOK.len() / 2]);
    stage.write("scene.look.toml", &half);
    live.look_changed();
    assert!(!live.problems().is_empty());
    let refused = live.save(None);
    assert!(
        matches!(refused, Err(LiveError::Changed { .. })),
        "{refused:?}"
    );
    assert_eq!(read(&stage.path("scene.look.toml")), half);
    assert!(live.has_unsaved_edits());
    // Under a name, also its own, it is what is wanted.
    let path = stage.path("scene.look.toml");
    live.save(Some(&path)).expect("saved");
    let expected = LOOK.replace("count = 5.0", "count = 7.0");
    assert_eq!(read(&stage.path("scene.look.toml")), expected);
    assert!(!live.has_unsaved_edits());
    live.look_changed();
    assert!(live.problems().is_empty(), "{}", live.problems());
    // A file that has vanished is written anew.
    fs::remove_file(&path).expect("removed");
    live.save(None).expect("saved");
    assert_eq!(read(&stage.path("scene.look.toml")), expected);
}
