//! The documents, held to what is there.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use engine::film::{
    LAYERS,
    layers::{SHADOW_CATCHER, VECTOR, known},
};

/// README, changelog and everything in `docs/`.
fn documents() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = fs::read_dir(root.join("docs")).expect("the folder docs is part of the project");
    docs.map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .chain([root.join("README.md"), root.join("CHANGELOG.md")])
        .collect()
}

/// Targets of `[text](target)` and `![text](target)`.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split(')').next())
}

/// What headings of a page are called in addresses.
fn anchors(page: &Path) -> Vec<String> {
    let text = fs::read_to_string(page).unwrap_or_default();
    let headings = text.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| {
            let words = line.trim_start_matches('#').trim().to_lowercase();
            words
                .chars()
                .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
                .map(|c| if c == ' ' { '-' } else { c })
                .collect()
        })
        .collect()
}

#[test]
fn links_lead_to_headings_of_files_that_exist() {
    let mut broken = Vec::new();
    for document in documents() {
        let text = fs::read_to_string(&document).expect("a document is UTF-8");
        let folder = document.parent().expect("a file lies in a folder");
        for link in links(&text) {
            if link.contains("://") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match file.is_empty() {
                true => document.clone(),
                false => folder.join(file),
            };
            let is_there = match heading.is_empty() {
                true => target.exists(),
                false => anchors(&target).contains(&heading.to_owned()),
            };
            if !is_there {
                broken.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(broken.is_empty(), "broken links:\n{}", broken.join("\n"));
}

/// A promise is as good as its test: files and tests that the page names are there.
#[test]
fn the_tests_of_promises_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("docs/reliability.md")).expect("part of the project");
    let (mut missing, mut promises, mut tests) = (Vec::new(), 0, 0);
    let rows = text.lines().filter(|line| line.starts_with("| **"));
    for row in rows {
        promises += 1;
        let cell = row.trim_end_matches([' ', '|']).rsplit('|').next();
        let names = cell.unwrap_or_default().split('`').skip(1).step_by(2);
        let (mut file, mut source) = ("", String::new());
        for name in names {
            tests += 1;
            if name.contains('/') {
                let path = root.join(name);
                file = name;
                source = fs::read_to_string(&path).unwrap_or_default();
                if !path.is_dir() && !source.contains("#[test]") {
                    missing.push(name.to_owned());
                }
                continue;
            }
            let head = format!("fn {name}()");
            let before = source.split_once(&head).map(|(before, _)| before);
            // Attributes stand between, and nothing else.
            let is_test = before.is_some_and(|before| {
                let attributes = before.rsplit(['}', ';']).next();
                attributes.is_some_and(|attributes| attributes.contains("#[test]"))
            });
            if !is_test {
                missing.push(format!("{file}: {name}"));
            }
        }
    }
    assert!(missing.is_empty(), "no such tests:\n{}", missing.join("\n"));
    assert!(promises > 20 && tests > 60, "{promises} promises, {tests}");
}

/// Layers that are two.
const VECTOR_ROW: &str = "| `vector` | `Vector.X` `.Y` `.Z` `.W` | motion in the picture since the frame before, and until the frame after; 0 at rest |";
const CATCHER_ROW: &str = "| `shadow_catcher` | `Shadow Catcher.R` `.G` `.B` `.A` | what a shadow leaves of the light on a shadow catcher, 1 where there is none; and what it keeps |";

/// The page of the film's layers lists those that there are, as they are declared.
#[test]
fn the_page_of_layers_lists_them() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("docs/layers.md")).expect("part of the project");
    let rows = text.lines().filter(|line| line.starts_with("| `"));
    let known = known();
    let single = LAYERS.iter().filter(|layer| known.contains(&layer.name));
    let declared = single.map(|layer| {
        match layer.name {
            SHADOW_CATCHER => return CATCHER_ROW.to_owned(),
            VECTOR => return VECTOR_ROW.to_owned(),
            _ => {}
        }
        let first = layer.channel_names().next().expect("it has a channel");
        let first = first.trim_start_matches("ViewLayer.");
        let letters = layer.channels.chars().skip(1);
        let others: String = letters.map(|letter| format!(" `.{letter}`")).collect();
        let (name, help) = (layer.name, layer.help);
        format!("| `{name}` | `{first}`{others} | {help} |")
    });
    let groups = "| `light_groups` | `Combined_NAME.R` `.G` `.B` | light of each group, and of all other lamps as `rest` |";
    let nodes = "| `node:NAME` | `Node NAME.R` `.G` `.B` `.A` | value of a node of the look, where its material is seen |";
    let declared = declared.chain([groups.to_owned(), nodes.to_owned()]);
    assert_eq!(rows.collect::<Vec<_>>(), declared.collect::<Vec<_>>());
}

/// The commands that a document or a help text shows: lines of code that begin with the program's name, without what is
/// said of them behind `#` or behind a gap.
fn commands(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| {
        let code = line.strip_prefix("  ")?.trim_start();
        let code = code.strip_prefix("$ ").unwrap_or(code);
        let command = code.strip_prefix("patina ")?;
        let command = command.split(" #").next().unwrap_or_default();
        let command = command.split("  ").next().unwrap_or_default();
        Some(command.trim_end())
    })
}

/// Words as a shell makes them, with what is between double quotes as one.
fn words(command: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    for (index, part) in command.split('"').enumerate() {
        let mut pieces = part.split(if index % 2 == 0 { ' ' } else { '"' });
        let word = words.last_mut().expect("never empty");
        word.push_str(pieces.next().unwrap_or_default());
        words.extend(pieces.map(str::to_owned));
    }
    words.retain(|word| !word.is_empty());
    words
}

fn patina(words: &[String], folder: &Path) -> Result<String, String> {
    let output = Command::new(env!("CARGO_BIN_EXE_patina"))
        .args(words)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .expect("patina starts");
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
    }
}

#[test]
fn every_command_in_documents_and_help_is_understood() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let helps = [
        "", "bench", "compare", "farm", "info", "texture", "view", "watch",
    ]
    .map(|folder| root.join("src").join(folder).join("args.rs"));
    let mut understood = 0;
    for document in documents().into_iter().chain(helps) {
        let text = fs::read_to_string(&document).expect("a document is UTF-8");
        // As a program's source writes quotes.
        let text = text.replace("\\\"", "\"");
        for command in commands(&text) {
            // With `--help` at the end, but before words for another command, the flags before it are parsed and nothing is done.
            let mut words = words(command);
            let end = words.iter().position(|word| word == "--");
            words.insert(end.unwrap_or(words.len()), "--help".to_owned());
            if let Err(error) = patina(&words, root) {
                panic!("{}: patina {command}\n{error}", document.display());
            }
            understood += 1;
        }
    }
    assert!(understood > 40, "there are many commands: {understood}");
}

/// The README is followed from top to bottom in a folder with the example scenes and the library: blocks of code are saved under the name
/// that was said last, commands are run, at a small size and with few samples.
#[test]
fn the_readme_works_in_its_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let desk = tempfile::tempdir().expect("a temporary folder");
    for folder in ["examples/demo", "examples/gallery", "user_textures"] {
        let copy = desk.path().join(folder);
        fs::create_dir_all(&copy).expect("a folder");
        for file in fs::read_dir(root.join(folder)).expect("part of the project") {
            let file = file.expect("an entry");
            fs::copy(file.path(), copy.join(file.file_name())).expect("a copy");
        }
    }
    let renders = device();
    let text = fs::read_to_string(root.join("README.md")).expect("the README is UTF-8");
    let (mut saved, mut run, mut block) = (0, 0, None);
    let mut name = "";
    for line in text.lines() {
        if let Some(mut lines) = block.take() {
            if line == "```" {
                fs::write(desk.path().join(name), lines).expect("the folder has been made");
                saved += 1;
            } else {
                lines += line;
                lines += "\n";
                block = Some(lines);
            }
        } else if line.starts_with("```") {
            block = Some(String::new());
        } else if let Some(command) = commands(line).next() {
            let mut words = words(command);
            // Some of them read what the others have written.
            let rendering = ["render", "watch", "view", "merge", "devices", "compare"];
            let renders_now = rendering.contains(&words[0].as_str()) || {
                ["eval", "preview"].contains(&words[1].as_str())
            };
            match words[0].as_str() {
                "render" => shrink(&mut words),
                // They don't end by themselves, or need a display.
                "watch" | "view" => words.push("--help".to_owned()),
                _ => {}
            }
            if renders || !renders_now {
                if let Err(error) = patina(&words, desk.path()) {
                    panic!("README.md: patina {command}\n{error}");
                }
                run += 1;
            }
        } else {
            let file = |word: &&str| word.ends_with(".wgsl") || word.ends_with(".toml");
            name = line.split('`').rfind(file).unwrap_or(name);
        }
    }
    assert!(saved == 2 && run > 1, "{saved} files, {run} commands");
    if renders {
        for picture in [
            "valve.png",
            "valve.exr",
            "whole.exr",
            "bands.png",
            "banded.png",
        ] {
            assert!(desk.path().join(picture).is_file(), "{picture}");
        }
        let shown = |name: &str| fs::read(desk.path().join(name)).expect("a picture");
        assert!(
            shown("valve.png") != shown("banded.png"),
            "the look is seen"
        );
    }
}

/// Makes a render small.
fn shrink(words: &mut Vec<String>) {
    for (flag, value) in [("--size", "48x27"), ("--spp", "1")] {
        if let Some(at) = words.iter().position(|word| word == flag) {
            words[at + 1] = value.to_owned();
        } else if flag == "--size" || !words.iter().any(|word| word == "--sample-range") {
            words.extend([flag.to_owned(), value.to_owned()]);
        }
    }
}

/// Whether this machine can render; says so where it can't.
fn device() -> bool {
    let found = patina(&["devices".to_owned()], Path::new("."));
    if let Err(why) = &found {
        assert!(std::env::var_os("PATINA_REQUIRE_DEVICE").is_none(), "{why}");
        eprintln!("no device can render: only the commands that need none are run");
    }
    found.is_ok()
}

#[test]
fn the_page_of_textures_is_what_the_command_prints() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let command = ["texture", "doc"].map(str::to_owned);
    let printed = patina(&command, folder.path()).expect("the command works");
    let page = include_str!("../docs/textures.md");
    let same = page.lines().zip(printed.lines()).find(|(a, b)| a != b);
    assert_eq!(
        same, None,
        "`patina texture doc -o docs/textures.md` writes the page anew"
    );
    assert_eq!(page.lines().count(), printed.lines().count());
}

/// The looks of the gallery need nothing but standard textures, and nothing in them is odd.
#[test]
fn the_materials_of_the_gallery_are_finished() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/gallery");
    let scene = folder.join("gallery.gltf");
    let entries = fs::read_dir(&folder).expect("the gallery is part of the project");
    let mut looks: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    looks.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    assert_eq!(looks.len(), 26);
    for look in looks {
        let loaded = engine::load::load(&scene, Some(&look), &[]);
        let loaded = loaded.unwrap_or_else(|error| panic!("{}: {error}", look.display()));
        let ball = loaded
            .procedural
            .materials()
            .find(|(name, _)| *name == "Ball");
        let (_, ball) = ball.expect("the ball has a material");
        assert!(loaded.procedural.is_procedural(ball), "{}", look.display());
        assert!(
            loaded.warnings.is_empty(),
            "{}: {}",
            look.display(),
            loaded.warnings
        );
        let text = fs::read_to_string(&look).expect("a look is UTF-8");
        let name = look
            .file_name()
            .expect("a file has a name")
            .to_string_lossy();
        assert!(
            text.contains(&*name),
            "the command in {name} names another look"
        );
    }
    let picture = folder.join("../../docs/images/gallery.jpg");
    let bytes = fs::metadata(picture).expect("the README shows it").len();
    assert!(bytes <= 300_000, "{bytes}");
}
