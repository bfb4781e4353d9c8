//! Files that others save while the window is open, and files with mistakes.

use super::*;

/// What two write at the same time.
fn theirs() -> String {
    LOOK.replace("# Light", "# More light")
        .replace("intensity = 1.0", "intensity = 2.0")
}

#[test]
fn edits_and_what_others_have_saved_are_kept_both() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let change = Changes {
        look: true,
        ..Changes::default()
    };
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    fs::write(stage.path("scene.look.toml"), theirs()).expect("written");
    stage.changes.send(change.clone()).expect("heard");
    let both = theirs().replace("0.5 ", "0.25 ");
    let text = |stage: &mut Stage| {
        let document = stage.harness.state_mut().document_mut().expect("read");
        document.text().to_owned()
    };
    stage.wait("both", |stage| {
        let board = stage.thread.link.board();
        board.look.as_ref().is_some_and(|look| *look.text == *both)
    });
    assert_eq!(text(&mut stage), both);
    assert_eq!(
        stage.read("scene.look.toml"),
        theirs(),
        "nothing is written unasked"
    );
    stage
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::S);
    stage.wait("saved look", |stage| stage.read("scene.look.toml") == both);

    // Undone, what they have saved is taken out of the file by nobody who wasn't asked.
    stage
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::Z);
    stage.harness.run_steps(2);
    assert_eq!(text(&mut stage), LOOK.replace("0.5 ", "0.25 "));
    stage
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::S);
    stage.harness.run_steps(3);
    assert_eq!(stage.read("scene.look.toml"), both);
    stage.harness.get_by_label("Save over it").click();
    let mine = LOOK.replace("0.5 ", "0.25 ");
    stage.wait("saved look", |stage| stage.read("scene.look.toml") == mine);

    // Where both have changed the same, somebody is asked.
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.75)));
    fs::write(stage.path("scene.look.toml"), LOOK).expect("written");
    stage.changes.send(change).expect("heard");
    stage.wait("question", |stage| {
        stage.harness.query_by_label("Keep mine there").is_some()
    });
    assert!(
        stage
            .harness
            .query_by_label("[material.Brass] roughness")
            .is_some()
    );
    stage.harness.get_by_label("Take the file's there").click();
    stage.wait("answer", |stage| {
        stage.harness.query_by_label("Keep mine there").is_none()
    });
    assert_eq!(text(&mut stage), LOOK);
    stage
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::Z);
    stage.harness.run_steps(2);
    assert_eq!(text(&mut stage), LOOK.replace("0.5 ", "0.75 "));
    stage.thread.finish();
}

#[test]
fn files_that_are_wrong_at_the_start_are_taken_up_once_they_are_mended() {
    let wrong = LOOK.replace("roughness = 0.5", "rouhgness = 0.5\nmetallc = 1");
    let Some(mut stage) = Stage::beginning(&wrong) else {
        return;
    };
    stage.wait("reason", |stage| {
        stage.harness.state().status().refused.is_some()
    });
    stage.harness.run_steps(2);
    for mistake in ["rouhgness", "metallc", "scene.look.toml:5:"] {
        let shown = stage.harness.query_all_by_label_contains(mistake);
        assert!(shown.count() > 0, "{mistake}");
    }
    fs::write(stage.path("scene.look.toml"), LOOK).expect("written");
    let change = Changes {
        look: true,
        ..Changes::default()
    };
    stage.changes.send(change).expect("heard");
    stage.wait("a picture", |stage| {
        let status = stage.harness.state().status();
        status.spp >= 4.0 && status.refused.is_none()
    });
    stage.thread.finish();
}

#[test]
fn mistakes_leave_the_picture_as_it_is() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.thread.link.send(Command::Target(1 << 20));
    stage.wait("more samples", |stage| {
        let status = stage.harness.state().status();
        status.is_whole && status.spp >= 8.0
    });
    let change = Changes {
        look: true,
        ..Changes::default()
    };
    let (size, mut spp) = {
        let status = stage.harness.state().status();
        (status.size, status.spp)
    };
    let wrong_look = LOOK.replace("roughness", "rouhgness");
    // As written by a program that isn't done yet, for example.
    let wrong_scene = SCENE.get(..SCENE.len() / 2).expect("a place");
    let bytes = fs::read(stage.path("triangle.bin")).expect("there");
    let assets = Changes {
        assets: true,
        ..Changes::default()
    };
    for (name, bytes, change, is_wrong) in [
        ("scene.look.toml", wrong_look.as_bytes(), &change, true),
        ("scene.look.toml", LOOK.as_bytes(), &change, false),
        ("scene.gltf", wrong_scene.as_bytes(), &assets, true),
        ("scene.gltf", SCENE.as_bytes(), &assets, false),
        ("triangle.bin", &bytes[..bytes.len() / 2], &assets, true),
        ("triangle.bin", &bytes[..], &assets, false),
        // Saved as it was.
        ("scene.gltf", SCENE.as_bytes(), &assets, false),
    ] {
        fs::write(stage.path(name), bytes).expect("written");
        stage.changes.send(change.clone()).expect("heard");
        stage.wait("news", |stage| {
            stage.harness.state().status().problems.is_empty() != is_wrong
        });
        for _ in 0..20 {
            stage.harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(10));
            let status = stage.harness.state().status();
            assert!(status.spp >= spp, "it has begun anew");
            assert_eq!(status.size, size);
            spp = status.spp;
        }
    }
    stage.thread.finish();
}

#[test]
fn mistakes_in_files_are_shown_until_they_are_mended() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    let change = Changes {
        look: true,
        ..Changes::default()
    };
    let wrong = LOOK.replace("roughness", "rouhgness");
    fs::write(stage.path("scene.look.toml"), wrong).expect("written");
    stage.changes.send(change.clone()).expect("heard");
    stage.wait("problem", |stage| {
        !stage.harness.state().status().problems.is_empty()
    });
    let problems = stage.harness.state().status().problems.clone();
    assert!(problems.contains("scene.look.toml:5:"), "{problems}");
    stage.harness.run_steps(3);
    assert!(stage.harness.query_by_label(problems.trim_end()).is_some());
    fs::write(stage.path("scene.look.toml"), LOOK).expect("written");
    stage.changes.send(change).expect("heard");
    stage.wait("mended look", |stage| {
        stage.harness.state().status().problems.is_empty()
    });

    // Saving under another name leaves the first file alone.
    stage.edit(Edit::material("Brass", "metallic", Value::number(0.0)));
    let other = stage.path("other.look.toml");
    stage.thread.link.send(Command::Save(Some(other), 0));
    stage.wait("other look", |stage| {
        stage.read("other.look.toml").contains("metallic")
    });
    assert_eq!(stage.read("scene.look.toml"), LOOK);
    stage.thread.finish();
}

/// A look isn't saved over what is shown with it, over what another program has just written, nor without a word where there is none.
#[test]
fn looks_that_can_not_be_saved_are_told() {
    let texture = "fn userProc() -> f32 { return 0.5; }\n";
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.edit(Edit::material("Brass", "roughness", Value::number(0.25)));
    fs::write(stage.path("half.wgsl"), texture).expect("written");
    // Named in another way, they are the same.
    let folder = stage.folder.path().join(".");
    fs::create_dir(stage.path("lib")).expect("a folder");
    fs::write(stage.path("lib/shared.wgsl"), "const HALF = 0.5;\n").expect("written");
    let mut names = vec!["scene.gltf", "triangle.bin", "half.wgsl", "lib/shared.wgsl"];
    if cfg!(unix) {
        fs::hard_link(stage.path("scene.gltf"), stage.path("hard.look.toml")).expect("a link");
        names.push("hard.look.toml");
    }
    #[cfg(unix)]
    {
        fs::create_dir(stage.path("elsewhere")).expect("a folder");
        fs::write(stage.path("elsewhere/far.wgsl"), texture).expect("written");
        std::os::unix::fs::symlink("elsewhere/far.wgsl", stage.path("near.wgsl")).expect("a link");
        names.push("near.wgsl");
    }
    for name in names {
        let before = fs::read(stage.path(name)).expect("there");
        let save = Command::Save(Some(folder.join(name)), 0);
        stage.thread.link.send(save);
        let told = format!("{name} is part of what is shown: name another file");
        stage.wait("message", |stage| {
            let told = stage.harness.query_all_by_label_contains(&told);
            told.count() > 0
        });
        assert_eq!(fs::read(stage.path(name)).expect("there"), before, "{name}");
    }
    // The window hasn't heard of what the render knows.
    stage.thread.link.send(Command::Save(None, 7));
    stage.wait("message", |stage| {
        let told = stage
            .harness
            .query_all_by_label_contains("another program has just changed");
        told.count() > 0
    });
    assert_eq!(stage.read("scene.look.toml"), LOOK);
    // Its own file can be named.
    let own = folder.join("scene.look.toml");
    stage.thread.link.send(Command::Save(Some(own), 0));
    let mine = LOOK.replace("0.5 ", "0.25 ");
    stage.wait("saved look", |stage| stage.read("scene.look.toml") == mine);
    stage.thread.finish();

    let Some(mut stage) = Stage::beginning("rouhgness = 1\n") else {
        return;
    };
    let other = stage.path("other.look.toml");
    stage.thread.link.send(Command::Save(Some(other), 0));
    stage.wait("message", |stage| {
        let told = stage
            .harness
            .query_all_by_label_contains("there is no look to save");
        told.count() > 0
    });
    assert!(!stage.path("other.look.toml").exists());
    stage.thread.finish();
}

/// What was picked stays picked where the scene's file changes, whatever comes before it there.
#[test]
fn what_was_picked_is_found_again_in_another_file() {
    let Some(mut stage) = Stage::new() else {
        return;
    };
    stage.harness.get_by_label("Viewport").click();
    stage.wait("material", |stage| {
        stage.harness.state().material() == Some("Brass")
    });
    // What the render says, which the window would take.
    let answer = |stage: &Stage, extent: Extent| {
        stage.thread.link.send(Command::Bounds(extent));
        let end = Instant::now() + Duration::from_secs(60);
        loop {
            let replies = std::mem::take(&mut stage.thread.link.board().replies);
            let bounds = replies.into_iter().find_map(|reply| match reply {
                Reply::Bounds(bounds) => Some(bounds),
                _ => None,
            });
            if let Some(bounds) = bounds {
                return bounds;
            }
            assert!(Instant::now() < end, "no answer");
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let picked = answer(&stage, Extent::Picked);
    assert_eq!(picked.map(|corner| corner.z), [0.0, 0.0]);
    // Another object of another material comes first, behind the camera.
    let mut scene = SCENE.to_owned();
    for (part, other) in [
        (r#""nodes": [0, 1]"#, r#""nodes": [2, 0, 1]"#),
        (
            r#""translation": [0, 0, 3] }]"#,
            r#""translation": [0, 0, 3] }, { "name": "Far", "mesh": 1, "translation": [0, 0, 9] }]"#,
        ),
        (
            r#"[{ "name": "Brass" }]"#,
            r#"[{ "name": "Other" }, { "name": "Brass" }]"#,
        ),
        (
            r#""material": 0 }] }]"#,
            r#""material": 1 }] }, { "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }]"#,
        ),
    ] {
        assert!(scene.contains(part), "{part}");
        scene = scene.replace(part, other);
    }
    fs::write(stage.path("scene.gltf"), scene).expect("written");
    let assets = Changes {
        assets: true,
        ..Changes::default()
    };
    stage.changes.send(assets).expect("heard");
    let end = Instant::now() + Duration::from_secs(60);
    let is_whole = |stage: &Stage| {
        let status = &stage.thread.link.board().status;
        status.is_whole && status.spp >= 4.0
    };
    let mut steady = 0;
    while steady < 50 {
        let is_followed = answer(&stage, Extent::Scene)[1].z > 5.0;
        steady = match is_followed && is_whole(&stage) {
            true => steady + 1,
            false => 0,
        };
        assert!(Instant::now() < end, "the file is not followed");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(answer(&stage, Extent::Picked), picked);

    // So is the line around its material. Where pictures are pixels, that is seen.
    let shown_after = |command: Command| {
        stage.thread.link.send(command);
        answer(&stage, Extent::Scene);
        let shown = stage.thread.link.board().shown.clone();
        match shown.map(|shown| shown.pictures) {
            Some([Some(Picture::Pixels(pixels)), _, _]) => Some(pixels.rgba.clone()),
            _ => None,
        }
    };
    let with_line = shown_after(Command::Denoise(Denoise::Never));
    let without = shown_after(Command::Unpick);
    assert!(with_line.is_none() || with_line != without);
    stage.thread.finish();
}
