//! Hot reload: textures change while the renderer works. Afterwards the picture is, bit by bit, the one that the new
//! sources would have given from the start; until then, and after a failure, it is the old one.

use std::sync::Arc;

use ::device::Device;
use engine::film::Film;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::{ReloadError, Renderer};
use engine::scene::look::Value as Written;
use engine::scene::{Camera, Projection, Scene};
use engine::session::{Edit, Session};
use glam::Vec3;
use texgen::{SourceFile, Value};

use crate::support::device;
use crate::support::memory::{self, Held, InMemory, settle};
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, render_textured, scene, settings, textured,
};

const SHOT: Shot = Shot {
    size: (24, 16),
    max_depth: 3,
    spp: 4,
};

const LOOK: &str = r#"
    [node.rings]
    texture = "rings"
    count = 5.0

    [node.paint]
    texture = "tint"
    color = [0.8, 0.3, 0.1]
    amount = "rings"

    [material."material 0"]
    base_color = "paint"

    [material."material 1"]
    base_color = "paint"
    roughness = "rings"
"#;

const RINGS: &str = "/// @param count = 3
fn userProc(count: f32) -> f32 { return 0.5 + 0.5 * sin(count * length(readAttr(WorldPos).xz)); }";

const TINT: &str = "fn tone(x: f32) -> f32 { return x * x; }
fn userProc(color: vec3f, amount: f32) -> vec3f { return color * tone(amount); }";

/// Another shape of the rings, with a parameter more and a ramp.
const SQUARES: &str = "/// @param ramp = [(0, #000000), (0.4, #802010), (1, #ffffff)]
/// @param edge = 0.25
fn userProc(ramp: ramp1D, count: f32, edge: f32) -> f32 {
    let p = fract(readAttr(WorldPos).xz * count * 0.2);
    return rampEval(ramp, select(p.x, p.y, p.x > edge)).x;
}";

fn bare_scene() -> Scene {
    let objects = [floor(4.0), faceted_sphere(8)].map(|mesh| (mesh, lambert(Vec3::ONE)));
    scene(objects, Vec3::ONE)
}

fn view() -> Camera {
    camera(
        Vec3::new(0.5, 2.0, 4.0),
        Vec3::Y * 0.2,
        Vec3::Y,
        Projection::Perspective { y_fov: 0.8 },
    )
}

fn sources(textures: &[(&str, &str)]) -> TextureSources {
    let mut sources = TextureSources::default();
    for (name, text) in textures {
        sources.insert(name, text);
    }
    sources
}

fn built(look: &str, textures: &[(&str, &str)]) -> (Scene, Procedural) {
    let mut scene = bare_scene();
    let procedural = textured(&mut scene, look, &sources(textures));
    (scene, procedural)
}

/// The picture of a look and its textures by a renderer that knew no others.
fn fresh(device: &Device, look: &str, textures: &[(&str, &str)]) -> Film {
    let (scene, procedural) = built(look, textures);
    render_textured(device, &scene, &procedural, &view(), SHOT)
}

fn renderer(device: &Device) -> Renderer {
    let (scene, procedural) = built(LOOK, &[("rings", RINGS), ("tint", TINT)]);
    Renderer::new(device, &scene, &procedural, &settings(&view(), SHOT))
        .unwrap_or_else(|error| panic!("{error}"))
}

fn picture(renderer: &mut Renderer) -> Film {
    renderer
        .render(SHOT.spp)
        .unwrap_or_else(|error| panic!("{error}"));
    renderer.film().unwrap_or_else(|error| panic!("{error}"))
}

const TEXTURES: [(&str, &str); 2] = [("rings", RINGS), ("tint", TINT)];

fn in_memory(look: &str) -> Arc<InMemory> {
    InMemory::new(bare_scene(), view(), look, &sources(&TEXTURES))
}

fn shown(session: &mut Session) -> Film {
    memory::film(session, SHOT.spp)
}

#[track_caller]
fn edit(session: &mut Session, edit: &Edit) {
    session.edit(edit).unwrap_or_else(|error| panic!("{error}"));
}

fn is_same(a: &Film, b: &Film) -> bool {
    a == b
}

fn file(name: &str, text: &str) -> SourceFile {
    SourceFile::new(name, format!("{name}.wgsl"), text)
}

#[test]
fn the_new_kernel_gives_the_picture_of_the_new_source() {
    let Some(device) = device::open() else { return };
    let (files, threads) = (in_memory(LOOK), Arc::new(Held::default()));
    let mut session = files.open_with(&device, SHOT, threads.clone());
    let old = shown(&mut session);
    let before = (device.counts().pipelines, device.counts().shader_modules);

    files.save_texture("rings", SQUARES);
    session.sources_changed();
    // The old one renders until the new one is there.
    session.restart();
    assert!(session.is_building());
    assert!(is_same(&old, &shown(&mut session)));
    threads.release();
    let new = shown(&mut session);
    assert!(!session.is_building());
    assert!(session.warnings().is_empty(), "{}", session.warnings());
    assert_eq!(
        (device.counts().pipelines, device.counts().shader_modules),
        (before.0 + 1, before.1 + 1),
        "one pipeline, one shader module"
    );
    assert!(!is_same(&old, &new));
    let textures = [("rings", SQUARES), ("tint", TINT)];
    assert!(is_same(&new, &fresh(&device, LOOK, &textures)));

    // Edits reach the parameters of the new version.
    let edge = Edit::argument("rings", "edge", &Value::F32(0.75));
    edit(&mut session, &edge);
    let look = LOOK.replace("count = 5.0", "count = 5.0\nedge = 0.75");
    assert!(is_same(
        &shown(&mut session),
        &fresh(&device, &look, &textures)
    ));
}

#[test]
fn a_wrong_texture_is_reported_and_changes_nothing() {
    let Some(device) = device::open() else { return };
    let mut renderer = renderer(&device);
    let old = picture(&mut renderer);
    let before = device.counts().pipelines;
    for (name, text, parts) in [
        (
            "rings",
            "fn userProc(count: f32) -> f32 {\n    return cuont;\n}",
            ["rings.wgsl:2:12", "did you mean `count`?"],
        ),
        (
            "rings",
            "fn userProc(count: f32) -> vec2f { return vec2f(count); }",
            ["rings.wgsl:1:1", "`rings` gives vec2f"],
        ),
        (
            "tint",
            "// no colour any more\nfn userProc(amount: f32) -> vec2f { return vec2f(amount); }",
            ["tint.wgsl:2:1", "a colour is needed"],
        ),
        (
            "rings",
            "fn userProc(count: f32) -> f32 { return count * readAttr(_WETNESS).x; }",
            ["rings.wgsl:1:1", "the mesh attribute `_WETNESS`"],
        ),
    ] {
        let reload = renderer.begin_reload(vec![file(name, text)]);
        let error = renderer.finish_reload(reload).expect_err("wrong");
        assert!(matches!(error, ReloadError::Textures(_)), "{error:?}");
        for part in parts {
            assert!(error.to_string().contains(part), "{part:?}: {error}");
        }
    }
    assert_eq!(device.counts().pipelines, before);
    assert!(
        is_same(&old, &picture(&mut renderer)),
        "not even started anew"
    );
    renderer.restart();
    assert!(is_same(&old, &picture(&mut renderer)));
}

#[test]
fn parameters_that_changed_their_type_have_their_defaults() {
    let Some(device) = device::open() else { return };
    let mut renderer = renderer(&device);
    let tint = "/// @param color = 0.25\nfn userProc(color: f32, other: mat3x3f) -> vec3f { return other * vec3f(color); }";
    let reload = renderer.begin_reload(vec![file("tint", tint)]);
    let warnings = renderer
        .finish_reload(reload)
        .unwrap_or_else(|error| panic!("{error}"))
        .to_string();
    assert!(
        warnings.contains("`color` of `paint` is of type f32 now"),
        "{warnings}"
    );
    let look = LOOK
        .replace("color = [0.8, 0.3, 0.1]", "")
        .replace("amount = \"rings\"", "");
    let textures = [("rings", RINGS), ("tint", tint)];
    assert!(is_same(
        &picture(&mut renderer),
        &fresh(&device, &look, &textures)
    ));
}

#[test]
fn an_added_texture_can_be_wired_while_rendering() {
    let Some(device) = device::open() else { return };
    let files = in_memory(LOOK);
    let mut session = files.open(&device, SHOT);
    shown(&mut session);
    let extra =
        "/// @param level = 0.3\nfn userProc(level: f32) -> f32 { return level * readAttr(AO).x; }";
    files.save_texture("extra", extra);
    edit(&mut session, &Edit::add_node("new", "extra"));
    settle(&mut session);
    assert!(session.problems().is_empty(), "{}", session.problems());
    let before = device.counts().pipelines;
    let wire = Edit::material("material 1", "metallic", Written::Text("new".to_owned()));
    edit(&mut session, &wire);
    assert_eq!(device.counts().pipelines, before);
    let look = LOOK.replace(
        "roughness = \"rings\"",
        "roughness = \"rings\"\nmetallic = \"new\"\n[node.new]\ntexture = \"extra\"",
    );
    let textures = [("rings", RINGS), ("tint", TINT), ("extra", extra)];
    assert!(is_same(
        &shown(&mut session),
        &fresh(&device, &look, &textures)
    ));
}

#[test]
fn edits_made_while_the_kernel_is_built_are_kept() {
    let Some(device) = device::open() else { return };
    let (files, threads) = (in_memory(LOOK), Arc::new(Held::default()));
    let mut session = files.open_with(&device, SHOT, threads.clone());
    files.save_texture("rings", SQUARES);
    session.sources_changed();
    let color = Edit::argument("paint", "color", &Value::Vec3([0.1, 0.2, 0.9]));
    edit(&mut session, &color);
    threads.release();
    let look = LOOK.replace("[0.8, 0.3, 0.1]", "[0.1, 0.2, 0.9]");
    let textures = [("rings", SQUARES), ("tint", TINT)];
    assert!(is_same(
        &shown(&mut session),
        &fresh(&device, &look, &textures)
    ));
}

#[test]
fn a_kernel_for_textures_that_are_no_longer_there_is_refused() {
    let Some(device) = device::open() else { return };
    let mut renderer = renderer(&device);
    let reload = renderer.begin_reload(vec![file("rings", SQUARES)]);
    let other = renderer.begin_reload(vec![file("tint", "fn userProc() -> f32 { return 0.5; }")]);
    renderer
        .finish_reload(reload)
        .unwrap_or_else(|error| panic!("{error}"));
    let expected = fresh(&device, LOOK, &[("rings", SQUARES), ("tint", TINT)]);
    assert!(is_same(&picture(&mut renderer), &expected));
    let error = renderer.finish_reload(other).expect_err("stale");
    assert!(matches!(error, ReloadError::Stale), "{error}");
    assert!(is_same(&picture(&mut renderer), &expected));
}

#[test]
fn a_renderer_without_programs_takes_new_textures_too() {
    let Some(device) = device::open() else { return };
    let look = "[node.rings]\ntexture = \"rings\"";
    let files = in_memory(look);
    let mut session = files.open(&device, SHOT);
    let before = device.counts().pipelines;
    files.save_texture("rings", SQUARES);
    session.sources_changed();
    settle(&mut session);
    assert_eq!(
        device.counts().pipelines,
        before,
        "there is nothing to build"
    );
    let wire = Edit::material("material 0", "roughness", Written::Text("rings".to_owned()));
    edit(&mut session, &wire);
    settle(&mut session);
    let look = format!("{look}\n[material.\"material 0\"]\nroughness = \"rings\"");
    let expected = fresh(&device, &look, &[("rings", SQUARES)]);
    assert!(is_same(&shown(&mut session), &expected));
}

#[test]
fn the_probe_of_a_texture_runs_it_alone() {
    let Some(device) = device::open() else { return };
    for text in [
        SQUARES,
        "fn userProc(image: sam2D, n: i32) -> vec4f { return tex2D(image, readAttr(TexCoord0).xy) + texSize(image).x; }",
        "fn userProc() -> vec2f { return readAttr(AO).xy + readAttr(_WET).xy; }",
    ] {
        let (scene, procedural) =
            Procedural::probe(&file("any name \" at all", text)).unwrap_or_else(|e| panic!("{e}"));
        assert!(procedural.is_procedural(0));
        let camera = engine::scene::default_camera(&scene);
        render_textured(&device, &scene, &procedural, &camera, SHOT);
    }
    let error = Procedural::probe(&file("wrong", "fn userProc() -> f32 {")).expect_err("wrong");
    assert!(error.to_string().contains("not closed"), "{error}");
}
