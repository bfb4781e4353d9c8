//! Files that change below a render: saved, broken, mended, replaced, gone.

use std::fs;

use engine::scene::look::{Section, Value};
use engine::session::{Edit, Session, SessionError, merge};

use super::look::{LOOK, RINGS, SQUARES, TEXTURES, TINT};
use super::stage::{Stage, film, is_same, read, settle};
use crate::support::device;

#[test]
fn a_source_is_swapped_and_a_wrong_one_is_not() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let old = film(&mut session);
    let pipelines = session.device().counts().pipelines;

    stage.write("textures/rings.wgsl", &RINGS.replace("sin(", "sinn("));
    session.sources_changed();
    settle(&mut session);
    let shown = session.problems().to_string();
    for part in ["rings.wgsl:3:24", "sinn", "^"] {
        assert!(shown.contains(part), "{part} is missing:\n{shown}");
    }
    assert!(
        is_same(&old, &film(&mut session)),
        "the picture is not lost"
    );
    assert_eq!(session.device().counts().pipelines, pipelines);

    stage.replace("textures/rings.wgsl", SQUARES);
    session.sources_changed();
    assert!(session.is_building());
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert_eq!(session.device().counts().pipelines, pipelines + 1);
    let new = film(&mut session);
    assert!(!is_same(&old, &new) && is_same(&new, &stage.fresh(LOOK)));

    // Wrong again, then as it is in use: nothing is built, and the error is gone.
    stage.write("textures/rings.wgsl", "");
    session.sources_changed();
    settle(&mut session);
    assert!(!session.problems().is_empty());
    stage.write("textures/rings.wgsl", SQUARES);
    let generation = session.generation();
    session.sources_changed();
    assert!(!session.is_building() && session.problems().is_empty());
    assert_eq!(session.generation(), generation);
}

#[test]
fn what_the_look_gives_outlives_its_parameter() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let old = film(&mut session);
    // A mistake that is mended below isn't told beside what doesn't fit the look then.
    stage.write("textures/rings.wgsl", &RINGS.replace("sin(", "sinn("));
    session.sources_changed();
    settle(&mut session);
    assert!(session.problems().to_string().contains("sinn"));
    let mut save = |name: &str, text: &str| {
        stage.write(name, text);
        session.sources_changed();
        session.look_changed();
        settle(&mut session);
        // Nothing comes of a scene that is saved as it was.
        session.assets_changed();
        settle(&mut session);
        (session.problems().to_string(), film(&mut session))
    };
    // Renamed, removed, retyped; and as it was.
    for other in [
        RINGS.replace("count", "number"),
        "fn userProc() -> f32 { return 0.5; }".to_owned(),
        "fn userProc(count: ramp1D) -> f32 { return rampEval(count, 0.5).x; }".to_owned(),
    ] {
        let (told, shown) = save("textures/rings.wgsl", &other);
        assert!(
            told.contains("scene.look.toml:") && told.contains("count"),
            "{other}: {told}"
        );
        assert!(!told.contains("sinn"), "{other}: {told}");
        assert!(is_same(&old, &shown), "the picture is not lost: {other}");
        let (told, shown) = save("textures/rings.wgsl", RINGS);
        assert!(told.is_empty(), "{other}: {told}");
        assert!(is_same(&old, &shown), "{other}");
    }
    // The look follows, in either order.
    let squares = SQUARES.replace("count", "number");
    let look = LOOK.replace("count =", "number =");
    stage.write("textures/rings.wgsl", &squares);
    let expected = stage.fresh(&look);
    stage.write("textures/rings.wgsl", RINGS);
    for (file, text, other, last) in [
        ("textures/rings.wgsl", &*squares, "scene.look.toml", &*look),
        ("scene.look.toml", LOOK, "textures/rings.wgsl", RINGS),
        ("scene.look.toml", &*look, "textures/rings.wgsl", &*squares),
    ] {
        assert!(!save(file, text).0.is_empty(), "{file}");
        let (told, shown) = save(other, last);
        assert!(told.is_empty(), "{file}: {told}");
        let wanted = if last == RINGS { &old } else { &expected };
        assert!(is_same(wanted, &shown), "{file}");
    }
}

#[test]
fn a_texture_whose_file_is_gone_is_told_of_until_it_is_back() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let old = film(&mut session);
    let other = TINT.replace("amount * amount", "amount");
    for text in [TINT, &other] {
        fs::remove_file(stage.path("textures/tint.wgsl")).expect("it is there");
        session.sources_changed();
        settle(&mut session);
        let told = session.problems().to_string();
        assert!(told.contains("texture `tint`: its file is gone"), "{told}");
        // Whoever reads all for a scene that is saved misses it, too.
        session.assets_changed();
        settle(&mut session);
        assert!(is_same(&old, &film(&mut session)));
        stage.write("textures/tint.wgsl", text);
        session.sources_changed();
        settle(&mut session);
        assert!(session.problems().is_empty(), "{}", session.problems());
        let shown = film(&mut session);
        assert_eq!(is_same(&old, &shown), text == TINT);
        assert!(is_same(&shown, &stage.fresh(LOOK)));
    }
}

#[test]
fn a_look_is_followed_by_difference() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let old = film(&mut session);
    let pipelines = session.device().counts().pipelines;
    // Comments mean nothing.
    stage.write("scene.look.toml", &LOOK.replace("# of them", "# of rings"));
    let generation = session.generation();
    session.look_changed();
    assert_eq!(session.generation(), generation);
    // Several tables at once, with nodes that come, go, and are linked the other way round.
    let changed = LOOK
        .replace("count = 5.0", "count = 'other'")
        .replace("amount = \"rings\"", "amount = 'extra.x'")
        .replace("y_fov = 45", "y_fov = 50")
        .replace("coat = 0.5", "coat = 0.7")
        .replace("distance = 0.4", "distance = 0.8")
        + "\n[node.extra]\ntexture = 'tint'\n";
    stage.replace("scene.look.toml", &changed);
    session.look_changed();
    assert!(
        session.is_up_to_date() && session.problems().is_empty(),
        "{}",
        session.problems()
    );
    assert_eq!(session.device().counts().pipelines, pipelines);
    let new = film(&mut session);
    assert!(!is_same(&old, &new) && is_same(&new, &stage.fresh(&changed)));
    // And all the way back.
    stage.write("scene.look.toml", LOOK);
    session.look_changed();
    settle(&mut session);
    assert!(is_same(&old, &film(&mut session)));
    assert_eq!(session.device().counts().pipelines, pipelines);
}

#[test]
fn mistakes_in_a_look_are_told_and_forgotten() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let old = film(&mut session);
    let rebuilt = session.generation();
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
        session.look_changed();
        settle(&mut session);
        let shown = session.problems().to_string();
        assert!(shown.contains(says), "{to}: {shown}");
        assert!(
            is_same(&old, &film(&mut session)),
            "{to}: the picture is not lost"
        );
        stage.write("scene.look.toml", LOOK);
        session.look_changed();
        settle(&mut session);
        assert!(
            session.problems().is_empty(),
            "{to}: {}",
            session.problems()
        );
        assert!(session.is_up_to_date());
    }
    assert_eq!(session.generation(), rebuilt, "nothing was built anew");
    assert!(is_same(&old, &film(&mut session)));
}

#[test]
fn a_mistake_that_comes_while_files_are_compared_is_told() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    session.assets_changed();
    stage.write(
        "scene.look.toml",
        &LOOK.replace("count = 5.0", "cuont = 5.0"),
    );
    session.look_changed();
    settle(&mut session);
    let shown = session.problems().to_string();
    assert!(shown.contains("scene.look.toml:16:1"), "{shown}");
}

#[test]
fn a_texture_that_is_new_to_the_look_costs_one_kernel() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let pipelines = session.device().counts().pipelines;
    let changed = LOOK.replace("base_color = \"worn\"", "base_color = \"spots\"")
        + "\n[node.spots]\ntexture = 'squares'\nedge = 0.4\n";
    // The look comes before its texture does.
    stage.write("scene.look.toml", &changed);
    session.look_changed();
    settle(&mut session);
    assert!(
        session
            .problems()
            .to_string()
            .contains("no texture called `squares`"),
        "{}",
        session.problems()
    );
    stage.write(
        "textures/squares.wgsl",
        &SQUARES.replace("select", "selekt"),
    );
    session.sources_changed();
    settle(&mut session);
    assert!(
        session.problems().to_string().contains("squares.wgsl:5"),
        "{}",
        session.problems()
    );
    stage.write("textures/squares.wgsl", SQUARES);
    session.sources_changed();
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert_eq!(session.device().counts().pipelines, pipelines + 1);
    assert!(is_same(&film(&mut session), &stage.fresh(&changed)));
}

#[test]
fn what_no_material_needs_begins_no_picture_anew() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let first = film(&mut session);
    let generation = session.generation();
    // A node of a texture in use, and its value.
    let spare = [
        Edit::add_node("spare", "rings"),
        Edit::argument("spare", "count", &texgen::Value::F32(9.0)),
    ];
    session.edit_all(&spare).expect("an edit");
    // One of a texture that has to be compiled.
    stage.write("textures/squares.wgsl", SQUARES);
    session
        .edit(&Edit::add_node("spots", "squares"))
        .expect("an edit");
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(session.is_up_to_date());
    assert_eq!(session.generation(), generation);
    assert!(is_same(&first, &film(&mut session)));
    // Linked, it is seen.
    let link = Edit::material("Floor", "base_color", Value::Text("spots".to_owned()));
    session.edit(&link).expect("an edit");
    settle(&mut session);
    assert!(session.generation() > generation);
    let fresh = stage.fresh(&session.look_text());
    assert!(is_same(&film(&mut session), &fresh));
}

#[test]
fn ten_saves_in_a_row_end_with_the_last() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    for i in 0..10 {
        let text = TINT.replace("amount * amount", &format!("amount * 0.{}", i + 1));
        match i % 3 {
            0 => stage.write("textures/tint.wgsl", &text),
            1 => stage.replace("textures/tint.wgsl", &text),
            // Half of a file, then all of it.
            _ => {
                stage.write("textures/tint.wgsl", &text[..text.len() / 2]);
                session.sources_changed();
                stage.write("textures/tint.wgsl", &text);
            }
        }
        session.sources_changed();
        session.step(2).unwrap_or_else(|error| panic!("{error}"));
    }
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(&film(&mut session), &stage.fresh(LOOK)));
}

#[test]
fn files_that_vanish_take_nothing_with_them() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let old = film(&mut session);
    let files = session.files();
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
        let generation = session.generation();
        fs::rename(stage.path(name), &aside).expect("it is there");
        session.look_changed();
        session.sources_changed();
        session.assets_changed();
        settle(&mut session);
        assert!(!session.problems().is_empty(), "{name} is missed");
        session
            .step(2)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(session.look_text(), LOOK, "{name}");
        assert!(
            is_same(&old, &film(&mut session)),
            "{name}: the picture is not lost"
        );
        fs::rename(&aside, stage.path(name)).expect("back");
        session.look_changed();
        session.sources_changed();
        session.assets_changed();
        settle(&mut session);
        assert!(
            session.problems().is_empty(),
            "{name}: {}",
            session.problems()
        );
        assert!(is_same(&old, &film(&mut session)), "{name} is back");
        assert_eq!(session.generation(), generation, "{name} is what it was");
    }
}

#[test]
fn what_others_wrote_is_not_saved_over_unasked() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let edit = Edit::argument("rings", "count", &texgen::Value::F32(7.0));
    session.edit(&edit).expect("edited");
    // Half of a file: nothing of it can be taken over.
    let half = format!("{}\nramp = [", &LOOK[..LOOK.len() / 2]);
    stage.write("scene.look.toml", &half);
    session.look_changed();
    assert!(!session.problems().is_empty());
    let refused = session.save(None);
    assert!(
        matches!(refused, Err(SessionError::Changed { .. })),
        "{refused:?}"
    );
    assert_eq!(read(&stage.path("scene.look.toml")), half);
    assert!(session.has_unsaved_edits());
    // Under a name, also its own, it is what is wanted.
    let path = stage.path("scene.look.toml");
    session.save(Some(&path)).expect("saved");
    let expected = LOOK.replace("count = 5.0", "count = 7.0");
    assert_eq!(read(&stage.path("scene.look.toml")), expected);
    assert!(!session.has_unsaved_edits());
    session.look_changed();
    assert!(session.problems().is_empty(), "{}", session.problems());
    // A file that has vanished is written anew.
    fs::remove_file(&path).expect("removed");
    session.save(None).expect("saved");
    assert_eq!(read(&stage.path("scene.look.toml")), expected);
}

#[test]
fn edits_and_what_others_wrote_are_brought_together() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let mine = Edit::material("Wall", "roughness", Value::number(0.5));
    session.edit(&mine).expect("an edit");
    let (generation, base) = (session.generation(), session.saved_text().to_owned());
    let theirs = LOOK.replace("count = 5.0", "count = 6.0");
    stage.write("scene.look.toml", &theirs);
    session.look_changed_beside_edits();
    assert_eq!(session.generation(), generation, "nobody has decided yet");
    assert_eq!(session.saved_text(), theirs);
    let path = session.inputs().look.clone().expect("there is one");
    let both = merge(&path, &base, &session.look_text(), session.saved_text());
    let both = both.expect("looks");
    assert!(both.conflicts.is_empty());
    session.replace_look(&both.text).expect("a look");
    session.save(None).expect("nothing of it is lost");
    let expected = theirs.replace("roughness = 0.35", "roughness = 0.5");
    assert_eq!(read(&stage.path("scene.look.toml")), expected);
    // What is wrong is told, and doesn't count as saved.
    stage.write("scene.look.toml", "node = 3");
    session.look_changed_beside_edits();
    assert!(!session.problems().is_empty());
    assert_eq!(session.saved_text(), expected);
}

#[test]
fn documents_of_materials_stay_below_what_the_look_says() {
    if device::open().is_none() {
        return;
    }
    const DOCUMENT: &str = r#"<materialx version="1.39">
        <noise3d name="noise" type="float"><input name="amplitude" type="float" value="0.5"/></noise3d>
        <standard_surface name="s" type="surfaceshader">
          <input name="base_color" type="color3" value="0.1, 0.7, 0.2"/>
          <input name="specular_roughness" type="float" nodename="noise"/>
        </standard_surface>
        <surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>
        </materialx>"#;
    let look = |more: &str| {
        format!(
            "[environment]\ncolor = [1.0, 1.0, 1.0]\n[[materialx]]\nfile = 'a.mtlx'\nname = 'Floor'\n{more}"
        )
    };
    let stage = Stage::new("", &[]);
    stage.write("a.mtlx", DOCUMENT);
    stage.write("scene.look.toml", &look(""));
    let mut session = stage.open("scene.look.toml");
    let mut shown = film(&mut session);
    let mut follows = |session: &mut Session, text: &str| {
        stage.replace("scene.look.toml", text);
        session.look_changed();
        settle(session);
        assert!(session.problems().is_empty(), "{}", session.problems());
        let new = film(session);
        assert!(!is_same(&shown, &new), "{text}");
        assert!(is_same(&new, &stage.fresh(text)), "{text}");
        shown = new;
    };
    // Keys of a material come, change and go; what the document says stays.
    follows(&mut session, &look("[material.Floor]\nmetallic = 0.5\n"));
    follows(&mut session, &look("[material.Floor]\nmetallic = 0.9\n"));
    follows(&mut session, &look("[material.Wall]\nroughness = 0.1\n"));
    // So do nodes that stand for those of the document.
    let node = "[node.noise]\ntexture = 'mx_noise3d_float'\namplitude = 0.1\n";
    follows(&mut session, &look(node));
    follows(&mut session, &look(""));
    // And documents themselves.
    let other = look("").replace("'Floor'", "'Wall'");
    follows(&mut session, &other);
    // An edit of the panel's.
    let edit = Edit::Set {
        section: Section::Material("Wall".to_owned()),
        key: "metallic".to_owned(),
        value: Value::Float(0.75),
    };
    session
        .edit(&edit)
        .unwrap_or_else(|error| panic!("{error}"));
    settle(&mut session);
    let edited = film(&mut session);
    assert!(is_same(&edited, &stage.fresh(&session.look_text())));
    assert!(session.files().contains(&stage.path("a.mtlx")));
}

#[test]
fn tangents_follow_texture_coordinates() {
    if device::open().is_none() {
        return;
    }
    let read = |attribute: &str| {
        format!("fn userProc() -> vec3f {{ return 0.5 + 0.5 * readAttr({attribute}).xyz; }}")
    };
    let constant = |color: [f32; 3]| {
        let [r, g, b] = color.map(|x| format!("{x:?}"));
        format!("fn userProc() -> vec3f {{ return vec3f({r}, {g}, {b}); }}")
    };
    let look = "[environment]\ncolor = [1.0, 1.0, 1.0]\n[node.along]\ntexture = 'along'\n[material.Floor]\nbase_color = 'along'\n";
    let shown = |text: &str, is_turned: bool| {
        let stage = Stage::new(look, &[("along", text)]);
        if is_turned {
            let mut bytes = fs::read(stage.path("squares.bin")).expect("it is there");
            // u towards the camera, and v to the left.
            let uvs: [[f32; 2]; 4] = [[1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]];
            bytes[48..80].copy_from_slice(bytemuck::cast_slice(&uvs));
            fs::write(stage.path("squares.bin"), bytes).expect("written");
        }
        film(&mut stage.open("scene.look.toml"))
    };
    let (plus, minus) = (1.0, 0.0);
    for (is_turned, attribute, color) in [
        (false, "Tangent", [plus, 0.5, 0.5]),
        (false, "Bitangent", [0.5, 0.5, minus]),
        (true, "Tangent", [0.5, 0.5, plus]),
        (true, "Bitangent", [plus, 0.5, 0.5]),
    ] {
        let (read, known) = (read(attribute), constant(color));
        assert!(
            is_same(&shown(&read, is_turned), &shown(&known, is_turned)),
            "{attribute}, turned: {is_turned}"
        );
    }
}

#[test]
fn what_lies_along_tangents_has_smooth_ones() {
    if device::open().is_none() {
        return;
    }
    const ALONG: &str = "fn userProc() -> vec3f { return 0.5 + 0.5 * readAttr(Tangent).xyz; }";
    const PLAIN: &str = "fn userProc() -> vec3f { return vec3f(0.5); }";
    let sky = "[environment]\ncolor = [1.0, 1.0, 1.0]\n";
    let look =
        format!("{sky}[node.along]\ntexture = 'along'\n[material.Floor]\nbase_color = 'along'\n");
    let stage = Stage::new(&look, &[("along", ALONG)]);
    let read = engine::scene::look::Look::load(&stage.path("scene.look.toml"));
    let textures = [stage.path("textures")];
    let loaded = engine::load::load_with(
        &stage.path("scene.gltf"),
        Some(read.expect("it is right")),
        &textures,
    );
    let meshes = loaded.expect("all is there").scene.meshes;
    let has = meshes.iter().map(|mesh| !mesh.tangents.is_empty());
    assert_eq!(has.collect::<Vec<_>>(), [true, false]);
    // Where something begins to lie along them, they come.
    let mut session = stage.open("scene.look.toml");
    let brushed = format!("{look}[material.Wall]\nmetallic = 1.0\nanisotropy = 0.8\n");
    for text in [&brushed, &look, sky, &look] {
        stage.replace("scene.look.toml", text);
        session.look_changed();
        settle(&mut session);
        assert!(session.problems().is_empty(), "{}", session.problems());
        assert!(is_same(&film(&mut session), &stage.fresh(text)), "{text}");
    }
    for text in [PLAIN, ALONG] {
        stage.write("textures/along.wgsl", text);
        session.sources_changed();
        settle(&mut session);
        assert!(is_same(&film(&mut session), &stage.fresh(&look)), "{text}");
    }
}

/// What is wrong with the scene's file stays so, whatever becomes of the look.
#[test]
fn a_broken_scene_is_told_of_until_it_is_mended() {
    if device::open().is_none() {
        return;
    }
    let sky = |color: &str| format!("[environment]\ncolor = {color}\n");
    let stage = Stage::new(&sky("[1.0, 1.0, 1.0]"), &[]);
    let whole = std::fs::read_to_string(stage.path("scene.gltf")).expect("it is there");
    let mut session = stage.open("scene.look.toml");
    stage.replace("scene.gltf", "{");
    session.assets_changed();
    settle(&mut session);
    assert!(!session.problems().is_empty());
    let other = sky("[0.5, 1.0, 1.0]");
    stage.replace("scene.look.toml", &other);
    session.look_changed();
    settle(&mut session);
    assert!(!session.problems().is_empty(), "the scene is as broken");
    stage.replace("scene.gltf", &whole);
    session.assets_changed();
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(&film(&mut session), &stage.fresh(&other)));
}

/// Where a look is undone while something is built for it, what was to come with that comes all the same.
#[test]
fn a_scene_that_changed_is_shown_though_a_look_is_undone() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let scene = read(&stage.path("scene.gltf"));
    stage.replace("textures/rings.wgsl", SQUARES);
    session.sources_changed();
    assert!(session.is_building());
    stage.replace("scene.gltf", &scene.replace("[0, 1, -1]", "[0, 1, -0.5]"));
    session.assets_changed();
    let lamp = "\n[light.Lamp]\ntype = 'point'\nposition = [0, 2, 0]\n";
    let lit = format!("{LOOK}{lamp}");
    session.replace_look(&lit).expect("a look");
    while !session.has_built() {
        std::thread::yield_now();
    }
    session.poll().unwrap_or_else(|error| panic!("{error}"));
    assert!(session.is_building(), "all is built for the lamp");
    session.replace_look(LOOK).expect("a look");
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(&film(&mut session), &stage.fresh(LOOK)));
}

#[test]
fn a_scene_that_changed_under_a_wrong_look_is_shown_once_that_is_mended() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let scene = read(&stage.path("scene.gltf"));
    let wrong = format!("{LOOK}\n[[include]]\nfile = 'none.gltf'\n");
    session.replace_look(&wrong).expect("a look");
    settle(&mut session);
    assert!(!session.problems().is_empty());
    stage.replace("scene.gltf", &scene.replace("[0, 1, -1]", "[0, 1, -0.5]"));
    session.assets_changed();
    settle(&mut session);
    session.replace_look(LOOK).expect("a look");
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(&film(&mut session), &stage.fresh(LOOK)));
}

#[test]
fn a_look_that_is_no_text_any_more_is_not_saved_over() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let path = stage.path("scene.look.toml");
    let latin = b"# caf\xe9\n";
    fs::write(&path, latin).expect("written");
    session.look_changed();
    let problems = session.problems().to_string();
    assert!(problems.contains("UTF-8"), "{problems}");
    assert!(!problems.contains("permissions"), "{problems}");
    let refused = session.save(None);
    assert!(
        matches!(refused, Err(SessionError::Changed { .. })),
        "{refused:?}"
    );
    assert_eq!(fs::read(&path).expect("it is there"), latin);
}

#[test]
fn a_look_whose_file_is_gone_is_not_saved() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let path = stage.path("scene.look.toml");
    fs::remove_file(&path).expect("removed");
    session.look_changed();
    assert!(session.has_unsaved_edits(), "nobody else has it");
    // It comes back as it was.
    stage.write("scene.look.toml", LOOK);
    session.look_changed();
    assert!(!session.has_unsaved_edits());
    fs::remove_file(&path).expect("removed");
    session.look_changed_beside_edits();
    assert!(session.has_unsaved_edits());
    session.save(None).expect("saved");
    assert!(!session.has_unsaved_edits());
    assert_eq!(read(&path), LOOK);
}

#[test]
fn a_look_that_may_only_be_read_is_not_replaced_unasked() {
    if device::open().is_none() {
        return;
    }
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let path = stage.path("scene.look.toml");
    let mut permissions = fs::metadata(&path).expect("it is there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&path, permissions).expect("set");
    let edit = Edit::argument("rings", "count", &texgen::Value::F32(7.0));
    session.edit(&edit).expect("edited");
    let refused = session.save(None);
    let Err(SessionError::ReadOnly { .. }) = &refused else {
        panic!("{refused:?}");
    };
    assert_eq!(read(&path), LOOK);
    assert!(session.has_unsaved_edits());
    // Under a name it is what is wanted.
    let other = stage.path("other.look.toml");
    session.save_as(&other).expect("saved");
    let expected = LOOK.replace("count = 5.0", "count = 7.0");
    assert_eq!(read(&other), expected);
    session.save(None).expect("that one may be written");
}

#[test]
fn a_look_saved_in_another_folder_names_the_same_files() {
    if device::open().is_none() {
        return;
    }
    let twin = "\n[[include]]\nfile = 'scene.gltf' # once more\nname = 'Twin'\ntranslation = [0.3, 0, 0.2]\n";
    let look = format!("{LOOK}{twin}");
    let stage = Stage::new(&look, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let first = film(&mut session);
    let nowhere = session.save_as(&stage.path("no/such.look.toml"));
    assert!(nowhere.is_err());
    assert_eq!(session.look_text(), look, "nothing has happened");
    fs::create_dir(stage.path("looks")).expect("a folder");
    let path = stage.path("looks/room.look.toml");
    session.save_as(&path).expect("saved");
    let expected = look.replace("'scene.gltf'", "'../scene.gltf'");
    assert_eq!(read(&path), expected);
    assert_eq!(session.look_text(), expected);
    assert!(!session.has_unsaved_edits());
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    assert!(is_same(&first, &film(&mut session)));
    assert_eq!(read(&stage.path("scene.look.toml")), look);
}
