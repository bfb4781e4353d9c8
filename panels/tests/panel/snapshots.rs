//! Snapshots of the panel: what assistive technology is told of it, and how it looks.
//!
//! `UPDATE_SNAPSHOTS=1 cargo test -p patina-panels` writes them anew, to be looked at before they are kept. The pictures
//! are drawn by the CPU, so that they are the same on all machines.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use egui::vec2;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use engine::procedural::TextureSources;
use engine::scene::look::{Section, Spanned, Value};
use engine::session::Edit;
use image::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use patina_panels::{Form, Textures};

use crate::support::{State, harness_of};

const LOOK: &str = "environment = { sky = { sun_elevation = 12.0 }, intensity = 1.5 }\n\
    [ao.crevices]\ndistance = 0.15\n\
    [node.rust_mask]\ntexture = 'rust_mask'\nscale = 5.0\nocclusion = 'crevices'\n\
    [node.rust]\ntexture = 'rust_color'\nscale = 16.0\n\
    [node.cells]\ntexture = 'voronoi'\n\
    [node.speckled]\ntexture = 'mix_color'\na = '#20100a'\nb = 'cells.zyx'\nfactor = 'cells.x'\n\
    [material.Paint]\nroughness = 0.3\nblend = { base = 'Paint', over = 'Rusty Iron', mask = 'rust_mask' }\n\
    [material.'Rusty Iron']\nbase_color = 'rust'\nroughness = 0.9\nspecular_color = 'speckled'\n\
    [light.Sun]\nangular_diameter = 0.53\n";

/// Share of pixels that may differ, since not all processors round alike.
const MAX_SHARE: f64 = 0.002;

fn panel(form: Form, size: [f32; 2]) -> Harness<'static, State> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../user_textures");
    let sources = TextureSources::scan(&[folder]).expect("the standard textures");
    let textures = Textures::load(&sources);
    assert!(textures.broken.is_empty(), "{:?}", textures.broken);
    let mut harness = harness_of(form, LOOK, textures, &["Paint", "Glass"]);
    harness.set_size(vec2(size[0], size[1]));
    harness.run();
    harness
}

fn click(harness: &mut Harness<'_, State>, label: &str) {
    harness.get_by_label(label).click();
    // Headers open and close in the course of some frames.
    harness.run_steps(8);
}

#[test]
fn a_list() {
    let mut harness = panel(Form::List, [440.0, 1130.0]);
    click(&mut harness, "Material Paint");
    check(&mut harness, "list");
}

#[test]
fn a_graph() {
    let mut harness = panel(Form::Graph, [760.0, 640.0]);
    click(&mut harness, "Fit");
    click(&mut harness, "node speckled");
    check(&mut harness, "graph");
}

#[test]
fn frames() {
    let mut harness = panel(Form::Graph, [760.0, 640.0]);
    let frame = |title: &str, nodes: [&str; 2], color: Option<&str>| {
        let text = |text: &str| Value::Text(text.to_owned());
        let nodes = nodes.map(|node| Spanned::new(text(node), 0..0));
        let set = |key, value| Edit::set(Section::Frame(title.to_owned()), key, value);
        let color = color.map(|color| set("color", text(color)));
        let nodes = set("nodes", Value::List(nodes.to_vec()));
        [nodes].into_iter().chain(color).collect::<Vec<_>>()
    };
    let mut edits = frame("Old paint", ["rust", "speckled"], Some("#d08a2e"));
    edits.extend(frame("Where it rusts", ["rust_mask", "gone"], None));
    // It finds a place outside both.
    edits.push(Edit::add_node("more", "fbm"));
    let document = &mut harness.state_mut().document;
    document.apply("frames", &edits, None).expect("a look");
    harness.run();
    click(&mut harness, "Fit");
    check(&mut harness, "frames");
}

#[test]
fn blends_and_light() {
    let mut harness = panel(Form::List, [440.0, 1130.0]);
    for closed in [
        "Material Rusty Iron",
        "Node rust_mask",
        "Node rust",
        "Node speckled",
        "Node cells",
        "Ambient occlusion",
        "Environment",
        "Lights",
    ] {
        click(&mut harness, closed);
    }
    check(&mut harness, "blend_and_light");
}

fn check(harness: &mut Harness<'_, State>, name: &str) {
    harness.remove_cursor();
    harness.run_steps(4);
    let mut words = String::new();
    outline(&harness.root(), 0, &mut words);
    let picture = harness.state().painter.paint(harness);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/panel/snapshots");
    let (text_file, picture_file) = (
        folder.join(format!("{name}.txt")),
        folder.join(format!("{name}.png")),
    );
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(&text_file, &words).expect("written");
        save(&picture, &picture_file);
        return;
    }
    let expected = std::fs::read_to_string(&text_file).unwrap_or_default();
    let differs = words
        .lines()
        .zip(expected.lines())
        .position(|(now, then)| now != then)
        .or_else(|| (words.lines().count() != expected.lines().count()).then_some(0));
    if let Some(line) = differs {
        panic!(
            "{} differs from line {} on; UPDATE_SNAPSHOTS=1 writes it anew. It is now:\n{words}",
            text_file.display(),
            line + 1
        );
    }
    let kept = image::open(&picture_file).expect("a picture").to_rgb8();
    let share = difference(&picture, &kept);
    if share > MAX_SHARE {
        let seen: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
        picture.save(&seen).expect("written");
        panic!(
            "{:.2} % of {} differ; UPDATE_SNAPSHOTS=1 writes it anew. It is now {}",
            100.0 * share,
            picture_file.display(),
            seen.display()
        );
    }
}

/// As small as can be.
fn save(picture: &RgbImage, path: &Path) {
    let file = std::fs::File::create(path).expect("a file");
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
    picture.write_with_encoder(encoder).expect("written");
}

/// Share of pixels that differ to the eye.
fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    if a.dimensions() != b.dimensions() {
        return 1.0;
    }
    let differ = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 24)
    };
    a.pixels().zip(b.pixels()).filter(differ).count() as f64 / a.pixels().len() as f64
}

/// What can be told of a widget and of those in it: role, label, value, state.
fn outline(node: &egui_kittest::Node<'_>, depth: usize, words: &mut String) {
    let told = node.accesskit_node();
    let (label, value) = (told.label(), told.value());
    let is_told = label.is_some() || value.is_some();
    if is_told {
        let _ = write!(words, "{:indent$}{:?}", "", told.role(), indent = 2 * depth);
        if let Some(label) = label {
            let _ = write!(words, " {label:?}");
        }
        if let Some(value) = value {
            let _ = write!(words, " = {value:?}");
        }
        if let Some(toggled) = told.toggled() {
            let _ = write!(words, " {toggled:?}");
        }
        if told.is_disabled() {
            words.push_str(" disabled");
        }
        words.push('\n');
    }
    for child in node.children() {
        outline(&child, depth + usize::from(is_told), words);
    }
}
