//! `patina view` on a screen: what a user does with a window that tests without one can't see. It takes a minute and programs that
//! not every machine has: with `PATINA_FULL` set, and where Xvfb, openbox and xdotool are (`cargo xtask test --full` installs them).

#![cfg(target_os = "linux")]

mod desktop;
mod window;

use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use desktop::Desktop;
use window::Window;

/// Short, so that the button that adds a node is where it is looked for; it says how it is shown, so that keys edit it.
const LOOK: &str = "environment = { color = [0.5, 0.6, 0.9] }\n\n[view]\nexposure = 0.0\n";

/// Of the button "Add a node…" below the first material, pixels from the window's right and upper edge at [`SIZE`].
const ADD: [i32; 2] = [272, 363];
const SIZE: [i32; 2] = [1280, 800];

/// The example scene with a look of its own, in a folder that can be written.
fn stage(folder: &Path) {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/demo");
    for (from, to) in [
        ("demo.gltf", "demo.gltf"),
        ("demo.bin", "demo.bin"),
        ("demo.gltf", "other.gltf"),
    ] {
        std::fs::copy(demo.join(from), folder.join(to)).expect("a copy");
    }
    std::fs::write(folder.join("demo.look.toml"), LOOK).expect("a look");
}

/// A file dialog of the system that writes down what it is asked, and waits for an answer.
fn answer_dialogs(folder: &Path) {
    let text = format!(
        "#!/bin/sh\ncd '{}'\necho \"$@\" > asked\nuntil [ -e chosen ]; do sleep 0.1; done\ncat chosen\n",
        folder.display()
    );
    let program = folder.join("zenity");
    std::fs::write(&program, text).expect("a program");
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(&program, mode).expect("it may be run");
}

#[test]
fn a_window_lives_through_what_is_done_to_it() {
    if std::env::var_os("PATINA_FULL").is_none() {
        eprintln!("skipped: a window on a screen takes a minute; set PATINA_FULL");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let desktop = match Desktop::start(folder.path()) {
        Ok(desktop) => desktop,
        Err(why) => {
            eprintln!("skipped: {why}");
            return;
        }
    };
    stage(folder.path());
    answer_dialogs(folder.path());
    let mut window = Window::open(&desktop, folder.path());
    window.shows_a_picture("after the start");

    for [width, height] in [
        [900, 500],
        [1500, 900],
        [300, 250],
        [1280, 720],
        [1000, 950],
    ] {
        window.resize([width, height]);
        window.keys(&["super+m", "super+m"]);
    }
    window.shows_a_picture("after it was resized and maximised");
    window.keys(&["super+m"]);
    window.shows_a_picture("while it is maximised");
    window.keys(&["super+m"]);
    window.resize(SIZE);
    window.has_size(SIZE);
    window.shows_a_picture("in its size");

    window.drag([400, 400], [600, 450]);
    window.shows_a_picture("after it was dragged");

    // Keys that edit, and take it back.
    window.keys(&["bracketright"]);
    window.is_titled("an edit", |title| title.contains('*'));
    window.keys(&["ctrl+z"]);
    window.is_titled("no edit", |title| !title.contains('*'));

    // What is typed there is no shortcut: `p` would pause, `r` choose a region.
    window.opens_a_menu([SIZE[0] - ADD[0], ADD[1]]);
    window.types("perlin");
    window.keys(&["Return"]);
    window.is_titled("a node that was added", |title| title.contains('*'));
    window.shows_a_picture("with another node");
    window.keys(&["ctrl+z"]);
    window.is_titled("no node", |title| !title.contains('*'));

    // Closed with an edit that isn't saved: it asks, and stays.
    window.keys(&["bracketright"]);
    window.is_titled("an edit", |title| title.contains('*'));
    window.asks(&["super+q"]);
    window.keys(&["Escape"]);
    window.shows_a_picture("after it has asked");
    window.keys(&["ctrl+s"]);
    window.is_titled("what is saved", |title| !title.contains('*'));
    let look = std::fs::read_to_string(folder.path().join("demo.look.toml")).expect("a look");
    assert_eq!(look, LOOK.replace("0.0", "0.25"));

    // The scene that the system's dialog gives is opened.
    window.asks(&["ctrl+o"]);
    let fields = window.fields();
    window.keys(&["Tab"]);
    window.fills_in("a field whose text isn't chosen any more", &fields);
    let fields = window.fields();
    window.keys(&["space"]);
    let asked = desktop.until("the system's dialog", || {
        let asked = std::fs::read_to_string(folder.path().join("asked")).ok()?;
        (!asked.is_empty()).then_some(asked)
    });
    assert!(asked.contains("*.gltf *.glb"), "{asked}");
    let other = folder.path().join("other.gltf").display().to_string();
    let written = folder.path().join("written");
    std::fs::write(&written, other).expect("a file");
    std::fs::rename(&written, folder.path().join("chosen")).expect("all of it at once");
    window.fills_in("the file that was chosen", &fields);
    window.keys(&["Return"]);
    window.is_titled("the other scene", |title| {
        title.starts_with("other.gltf - ")
    });
    window.shows_a_picture("of the other scene");
    window.closes();

    // Ended from outside with an edit that isn't saved: that is kept.
    let mut window = Window::open(&desktop, folder.path());
    window.shows_a_picture("when it is opened again");
    window.keys(&["bracketright"]);
    window.is_titled("an edit", |title| title.contains('*'));
    let said = window.ended();
    assert!(said.contains("demo.look.toml.recovered"), "{said}");
    let kept = folder.path().join("demo.look.toml.recovered");
    let kept = std::fs::read_to_string(kept).expect("it is there");
    assert_eq!(kept, LOOK.replace("0.0", "0.5"));
}
