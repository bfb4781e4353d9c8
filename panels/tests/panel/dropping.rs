//! Materials, textures, files and images of the model that are dropped on the panel.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use engine::scene::look::Value;
use engine::scene::{Image, Sampler, TextureRef};
use engine::session::Edit;
use glam::Vec3;
use patina_panels::{Form, ModelImage};

use crate::support::{LOOK, State, assert_kept, center, drag, harness, text};

#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        Err("nobody asks".to_owned())
    }
}

/// Takes a texture out of the list of them, and lets it go elsewhere.
fn drop_texture(
    harness: &mut Harness<'_, State>,
    texture: &str,
    at: impl Fn(&Harness<'_, State>) -> Pos2,
) {
    harness.get_by_label("Add a node").click();
    harness.run();
    let start = center(harness, Role::Button, texture);
    harness.hover_at(start);
    harness.run();
    harness.drag_at(start);
    harness.run();
    harness.hover_at(start + vec2(10.0, 10.0));
    harness.run();
    let end = at(harness);
    harness.hover_at(end);
    harness.run();
    harness.run();
    harness.drop_at(end);
    harness.run();
}

#[test]
fn a_texture_dropped_on_a_value_drives_it() {
    let mut harness = harness(Form::List);
    drop_texture(&mut harness, "mask", |harness| {
        center(harness, Role::Slider, "Roughness of Iron")
    });
    let now = text(&harness);
    assert!(now.contains("[node.mask]\ntexture = \"mask\""), "{now}");
    assert!(now.contains("roughness = \"mask\""), "{now}");
    harness.state_mut().document.undo();
    assert_eq!(text(&harness), LOOK, "it was one step");
    harness.run();
    // A colour for a number: its first component.
    drop_texture(&mut harness, "tint", |harness| {
        center(harness, Role::Slider, "Roughness of Iron")
    });
    let now = text(&harness);
    assert!(now.contains("roughness = \"tint.x\""), "{now}");
}

#[test]
fn a_texture_dropped_on_the_graph_is_linked_or_added() {
    let mut harness = harness(Form::Graph);
    drop_texture(&mut harness, "mask", |harness| {
        center(harness, Role::Button, "Input factor of paint") + vec2(20.0, 0.0)
    });
    let now = text(&harness);
    assert!(now.contains("factor = \"mask\""), "{now}");
    assert_kept(&harness, "no line");
    harness.state_mut().document.undo();
    harness.run();
    drop_texture(&mut harness, "mask", |harness| {
        let fit = harness.get_by_label("Fit").rect();
        fit.center() + vec2(0.0, 60.0)
    });
    let now = text(&harness);
    assert!(now.contains("[node.mask]"), "{now}");
    assert!(
        !now.contains("= \"mask.") && !now.contains("factor"),
        "{now}"
    );
}

#[test]
fn a_material_is_dropped_on_another_one() {
    let mut harness = harness(Form::List);
    harness.get_by_label("All materials").click();
    harness.run_steps(12);
    let start = center(&harness, Role::Button, "Show Paint");
    let header = harness.get_by_label("Material Iron").rect().center();
    drag(&mut harness, start, header - start);
    let blend = "blend = { base = \"Iron\", over = \"Paint\", mask = 1.0 }";
    assert!(text(&harness).contains(blend), "{}", text(&harness));
    harness.state_mut().document.undo();
    harness.run();
    // Within the list, and not on itself.
    let start = center(&harness, Role::Button, "Show Iron");
    let end = center(&harness, Role::Button, "Show Paint");
    drag(&mut harness, start, vec2(12.0, 0.0));
    assert_eq!(text(&harness), LOOK);
    drag(&mut harness, start, end - start);
    let blend = "blend = { base = \"Paint\", over = \"Iron\", mask = 1.0 }";
    assert!(text(&harness).contains(blend), "{}", text(&harness));
    // The other way round would be a circle.
    drag(&mut harness, end, start - end);
    assert!(harness.state().panel.message().is_some());
    harness
        .get_by_role_and_label(Role::Button, "Show Paint")
        .click();
    harness.run();
    assert_eq!(harness.state().panel.material(), Some("Paint"));
}

#[test]
fn a_map_of_the_model_dropped_on_a_slot_is_read_there() {
    let mut harness = harness(Form::List);
    let image = Image {
        name: "image \"wood.png\"".to_owned(),
        width: 2,
        height: 2,
        rgba8: vec![200; 16].into(),
        srgb: true,
    };
    let map = TextureRef {
        image: 0,
        uv_set: 0,
        sampler: Sampler::default(),
        transform: [Vec3::X, Vec3::Y],
    };
    let state = harness.state_mut();
    state.images = vec![ModelImage::new(&image)];
    state.materials[0].normal_texture = Some(map);
    state.materials[0].emission_texture = Some(map);
    let slot = [
        Edit::add_node("plank", "picture"),
        Edit::material("Iron", "opacity", Value::Text("plank.x".to_owned())),
    ];
    let document = &mut state.document;
    document.apply("slot", &slot, None).expect("it fits");
    let before = document.text().to_owned();
    harness.run();
    let path = center(&harness, Role::TextInput, "image of plank");
    let onto_slot = |harness: &mut Harness<'_, State>, map: &str| {
        let start = harness.get_by_label(map).rect().center();
        let path = center(harness, Role::TextInput, "image of plank");
        drag(harness, start, path - start);
        text(harness)
    };
    let now = onto_slot(&mut harness, "Emission map");
    assert!(now.contains("image = \"model:wood.png\""), "{now}");
    // Numbers are not taken for colours.
    let now = onto_slot(&mut harness, "Normal map");
    let written = "image = { file = \"model:wood.png\", color_space = \"linear\" }";
    assert!(now.contains(written), "{now}");
    harness.state_mut().document.undo();
    harness.state_mut().document.undo();
    assert_eq!(text(&harness), before, "each was one step");
    // A texture is no image.
    harness.run();
    drop_texture(&mut harness, "mask", |_| path);
    assert_eq!(text(&harness), before);
}

#[test]
fn a_slot_takes_images_alone() {
    let mut harness = harness(Form::List);
    let slot = [
        Edit::add_node("plank", "picture"),
        Edit::material("Iron", "opacity", Value::Text("plank.x".to_owned())),
    ];
    let document = &mut harness.state_mut().document;
    document.apply("slot", &slot, None).expect("it fits");
    let before = document.text().to_owned();
    harness.run();
    let place = center(&harness, Role::TextInput, "image of plank");
    let drop = |harness: &mut Harness<'_, State>, files: &[&str]| {
        harness.hover_at(place);
        harness.run();
        let files = files.iter().map(|file| {
            let file = Dropped(PathBuf::from(file));
            Arc::new(file) as egui::DroppedFileHandle
        });
        harness.input_mut().dropped_files = files.collect();
        harness.step();
        harness.run();
        let has_taken = harness.state_mut().panel.take_dropped();
        (has_taken, text(harness))
    };
    // The window opens the one, and has the other around the scene.
    let dropped = drop(&mut harness, &["scene.glb", "sky.hdr"]);
    assert_eq!(dropped, (false, before));
    let (has_taken, now) = drop(&mut harness, &["sky.hdr", "wood.png", "more.png"]);
    assert!(has_taken && now.contains("image = \"wood.png\""), "{now}");
}
