//! What a window wants of a live render: views, sizes, regions, pictures on the device, and what lies below a pixel. None
//! of it changes the look or, once it is over, the film.

use std::collections::HashMap;

use engine::display::{Channel, DeviceFilm, Display, DisplaySettings};
use engine::film::Film;
use engine::scene::look::{Section, Spanned, Value};
use engine::scene::view::{View, ViewTransform, WhiteBalance};
use engine::session::{Edit, Session};
use engine::view::ViewEncoder;
use glam::{Vec2, Vec3};

use super::look::{LOOK, TEXTURES};
use super::stage::{SPP, Stage, film, is_same, read, settle};
use crate::support::device;

fn opened() -> Option<(Stage, Session, Film)> {
    device::open()?;
    let stage = Stage::new(LOOK, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let whole = film(&mut session);
    Some((stage, session, whole))
}

fn render(session: &mut Session) {
    while !session.step(SPP).expect("rendered").is_done() {}
}

#[test]
fn sizes_and_views_come_and_go() {
    let Some((stage, mut session, whole)) = opened() else {
        return;
    };
    let device = session.device().clone();
    let made = (device.counts().pipelines, device.counts().shader_modules);
    let generation = session.generation();
    session.resize(24, 16).expect("nothing to do");
    assert_eq!(session.generation(), generation);
    session.resize(11, 5).expect("a smaller size");
    assert!(session.generation() > generation);
    let small = film(&mut session);
    assert_eq!((small.width, small.height), (11, 5));
    let mut view = session.look_camera().clone();
    view.transform.translation.x += 0.3;
    session.set_view(Some(view.clone()));
    assert!(!is_same(&film(&mut session), &small));
    // Edits of the look's camera are not seen meanwhile, and stay.
    assert!(session.resize(0, 5).is_err());
    session.resize(24, 16).expect("the first size");
    session.set_view(None);
    assert!(is_same(&film(&mut session), &whole));
    assert_eq!(
        (device.counts().pipelines, device.counts().shader_modules),
        made
    );
    // What is built anew keeps the view.
    session.set_view(Some(view));
    let seen = film(&mut session);
    // Read as another file, it is the same scene.
    let scene = read(&stage.path("scene.gltf"));
    stage.write("scene.gltf", &format!("{scene}\n"));
    session.assets_changed();
    settle(&mut session);
    assert!(is_same(&film(&mut session), &seen));
    assert!(!session.has_unsaved_edits());
}

#[test]
fn a_region_gets_samples_alone() {
    let Some((_stage, mut session, whole)) = opened() else {
        return;
    };
    session.restart();
    session.set_region(Some([5, 2, 17, 99]));
    render(&mut session);
    let part = session.snapshot().expect("read").film;
    for y in 0..16 {
        for x in 0..24 {
            let pixel = (y * 24 + x) as usize;
            let is_inside = (5..17).contains(&x) && y >= 2;
            assert_eq!(
                part.samples(pixel),
                if is_inside { SPP } else { 0 },
                "{x} {y}"
            );
            if is_inside {
                assert_eq!(part.sum(pixel), whole.sum(pixel));
            }
        }
    }
    session.set_region(None);
    session.restart();
    assert!(is_same(&film(&mut session), &whole));
}

#[test]
fn the_display_shows_the_film() {
    let Some((_stage, mut session, whole)) = opened() else {
        return;
    };
    let mut display = Display::new(session.device()).expect("compiled");
    let settings = DisplaySettings {
        view: View::exposed(1.0),
        ..DisplaySettings::default()
    };
    let shown = session.device_film(true).expect("guides");
    display.show(&shown, &settings).expect("shown");
    let rgba = display.read().expect("read");
    let encode = |x: f32| match x.clamp(0.0, 1.0) {
        x if x <= 0.003_130_8 => 12.92 * x,
        x => 1.055 * x.powf(1.0 / 2.4) - 0.055,
    };
    for (pixel, mean) in rgba.chunks(4).zip(whole.mean()) {
        for (byte, value) in pixel.iter().zip(mean) {
            // Rounding, and the driver's `pow`.
            let expected = 255.0 * encode(2.0 * value);
            assert!(
                (f32::from(*byte) - expected).abs() < 1.0,
                "{pixel:?} {mean:?}"
            );
        }
    }
    // Guides leave the film alone.
    assert!(is_same(&session.snapshot().expect("read").film, &whole));

    let luminance = |c: [f32; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    let errors: f32 = whole.standard_error().into_iter().map(luminance).sum();
    let light: f32 = whole.mean().into_iter().map(luminance).sum();
    let error = display
        .relative_error()
        .expect("read")
        .expect("two samples");
    let expected = f64::from(errors / light);
    assert!(
        (error - expected).abs() < 1e-3 * expected,
        "{error} {expected}"
    );

    // A copy stays as it was.
    let kept = session.keep_film(false).expect("copied");
    session.restart();
    display.show(&kept, &settings).expect("shown");
    assert_eq!(display.read().expect("read"), rgba);
}

#[test]
fn a_window_shows_what_a_file_would() {
    let Some((_stage, mut session, whole)) = opened() else {
        return;
    };
    let mut display = Display::new(session.device()).expect("compiled");
    let shown = session.device_film(false).expect("a film");
    // Lights of such colours leave little but the opposite of them, and negative components.
    let whites = [None, Some([2000.0, -80.0]), Some([20_000.0, 90.0])];
    for transform in ViewTransform::ALL {
        for white in whites {
            for exposure in [-6.0, -1.0, 0.0, 2.5, 9.0] {
                let white = white.map(|[temperature, tint]| WhiteBalance { temperature, tint });
                let view = View {
                    exposure,
                    white_balance: white,
                    transform,
                };
                let settings = DisplaySettings {
                    view,
                    ..DisplaySettings::default()
                };
                display.show(&shown, &settings).expect("shown");
                let encoder = ViewEncoder::new(&view);
                let rgba = display.read().expect("read");
                for (pixel, mean) in rgba.chunks(4).zip(whole.mean()) {
                    for (byte, code) in pixel.iter().zip(encoder.encode(mean)) {
                        // Half of it is rounding.
                        let difference = f32::from(*byte) - 255.0 * code;
                        assert!(
                            difference.abs() <= 1.0,
                            "{view:?} {mean:?}: {pixel:?} {code}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_look_says_how_it_is_shown_without_a_new_picture() {
    let Some((stage, mut session, whole)) = opened() else {
        return;
    };
    let generation = session.generation();
    assert_eq!(session.look_view().view(), View::default());
    let agx = Value::Text("agx".to_owned());
    session.edit(&Edit::view("transform", agx)).expect("edited");
    let exposure = Edit::view("exposure", Value::number(-1.5));
    session.edit(&exposure).expect("edited");
    let view = session.look_view().view();
    assert_eq!((view.transform, view.exposure), (ViewTransform::Agx, -1.5));
    let bad = Edit::view("exposure", Value::number(99.0));
    assert!(session.edit(&bad).is_err());
    assert_eq!(session.look_view().view(), view);
    assert!(session.look_text().contains("[view]"));
    // As a whole text, too, together with nothing else.
    let text = session.look_text().replace("agx", "filmic");
    session.replace_look(&text).expect("a look");
    let transform = session.look_view().transform;
    assert_eq!(transform, Some(ViewTransform::Filmic));
    assert_eq!(session.generation(), generation);
    assert!(is_same(&session.snapshot().expect("read").film, &whole));
    // What is built anew has it from the look.
    // Read as another file, it is the same scene.
    let scene = read(&stage.path("scene.gltf"));
    stage.write("scene.gltf", &format!("{scene}\n"));
    session.assets_changed();
    settle(&mut session);
    assert_eq!(session.look_view().transform, transform);
}

#[test]
fn frames_of_the_graph_leave_the_picture_as_it_is() {
    let Some((_stage, mut session, whole)) = opened() else {
        return;
    };
    let generation = session.generation();
    let frame = || Section::Frame("Old paint".to_owned());
    let nodes = Value::List(vec![Spanned::new(Value::Text("gone".to_owned()), 0..0)]);
    let edit = Edit::set(frame(), "nodes", nodes);
    session.edit(&edit).expect("edited");
    assert!(session.look_text().contains("[graph.\"Old paint\"]"));
    let bad = Edit::set(frame(), "colour", Value::Text("red".to_owned()));
    assert!(session.edit(&bad).is_err());
    assert!(!session.look_text().contains("colour"));
    // As whole texts, too, to and fro.
    let with = session.look_text();
    session
        .edit(&Edit::Remove { section: frame() })
        .expect("edited");
    let without = session.look_text();
    for text in [&with, &without, &with] {
        session.replace_look(text).expect("a look");
        assert_eq!(session.look_text(), *text);
    }
    assert_eq!(session.generation(), generation);
    assert!(is_same(&session.snapshot().expect("read").film, &whole));
}

#[test]
fn what_is_picked_has_a_line_around_it() {
    let Some((_stage, mut session, _)) = opened() else {
        return;
    };
    let mut display = Display::new(session.device()).expect("compiled");
    let objects = DisplaySettings {
        channel: Channel::Object,
        ..DisplaySettings::default()
    };
    let film = session.device_film(true).expect("guides");
    display.show(&film, &objects).expect("shown");
    let plain = display.read().expect("read");
    let center = (8 * 24 + 12) * 4;
    let hit = session.pick(Vec2::new(12.5 / 24.0, 8.5 / 16.0));
    let with_line = DisplaySettings {
        outlined: hit.map(|hit| hit.material),
        ..objects
    };
    assert!(with_line.needs_guides());
    display.show(&film, &with_line).expect("shown");
    let rgba = display.read().expect("read");
    let is_own = |x: usize, y: usize| {
        let at = (y * 24 + x) * 4;
        plain[at..at + 4] == plain[center..center + 4]
    };
    let mut on_line = 0;
    for y in 0..16 {
        for x in 0..24 {
            let beside = [
                (x.max(1) - 1, y),
                ((x + 1).min(23), y),
                (x, y.max(1) - 1),
                (x, (y + 1).min(15)),
            ];
            let is_edge = beside
                .iter()
                .any(|&(x1, y1)| is_own(x1, y1) != is_own(x, y));
            let at = (y * 24 + x) * 4;
            let is_line = rgba[at..at + 4] == [255, 158, 26, 255];
            assert_eq!(is_line, is_edge, "{x} {y}");
            assert!(is_line || rgba[at..at + 4] == plain[at..at + 4]);
            on_line += u32::from(is_line);
        }
    }
    assert!(on_line > 0, "the picture shows more than one object");
    // Nothing is known of surfaces without guides, so no line can be drawn.
    let bare = DisplaySettings {
        channel: Channel::Radiance,
        ..with_line
    };
    let radiance = film.radiance(session.device()).expect("read");
    let film = DeviceFilm::of_radiance(session.device(), [24, 16], &radiance).expect("room");
    display.show(&film, &bare).expect("shown");
}

#[test]
fn materials_are_picked_where_they_are_shown() {
    let Some((_stage, mut session, _)) = opened() else {
        return;
    };
    let mut display = Display::new(session.device()).expect("compiled");
    let settings = DisplaySettings {
        channel: Channel::Material,
        ..DisplaySettings::default()
    };
    let shown = session.device_film(true).expect("guides");
    display.show(&shown, &settings).expect("shown");
    let rgba = display.read().expect("read");
    // Of each material, and of what is none, how often it has which colour.
    let mut colors = vec![HashMap::<&[u8], u32>::new(); session.scene().materials.len() + 1];
    for y in 0..16 {
        for x in 0..24 {
            let place = Vec2::new((x as f32 + 0.5) / 24.0, (y as f32 + 0.5) / 16.0);
            let hit = session.pick(place);
            let number = hit.map_or(colors.len() - 1, |hit| hit.material as usize);
            let at = (y * 24 + x) * 4;
            *colors[number].entry(&rgba[at..at + 4]).or_default() += 1;
        }
    }
    let usual = colors.iter().filter_map(|colors| colors.values().max());
    let (same, seen) = (usual.clone().sum::<u32>(), usual.count());
    // Guides are seen through one place of the pixel, picks through its centre: they differ at some edges.
    assert!(same >= 24 * 16 * 9 / 10, "{same}");
    assert!(seen >= 3, "floor, wall and nothing");

    let center = session
        .pick(Vec2::splat(0.5))
        .expect("something is in the middle");
    let eye = Vec3::from(session.shown_camera().transform.translation);
    assert!(((center.position - eye).length() - center.distance).abs() < 1e-4);
}

/// What is shown of a channel at the picture's lower edge, where the floor is, and in the middle, where the wall is.
fn looks(session: &mut Session, display: &mut Display, channel: Channel) -> [[u8; 3]; 2] {
    let settings = DisplaySettings {
        channel,
        view: View::exposed(1.0),
        ..DisplaySettings::default()
    };
    let shown = session.device_film(true).expect("guides");
    display.show(&shown, &settings).expect("shown");
    let rgba = display.read().expect("read");
    [(12, 14), (12, 5)].map(|(x, y)| {
        let at = (y * 24 + x) * 4;
        [rgba[at], rgba[at + 1], rgba[at + 2]]
    })
}

#[test]
fn channels_show_what_textures_give() {
    if device::open().is_none() {
        return;
    }
    let look = r#"
[node.paint]
texture = "tint"
color = [0.8, 0.4, 0.2]
amount = 1.0

[material.Floor]
base_color = "paint"
metallic = 0.6

[material.Wall]
base_color = [0.2, 0.4, 0.6]
roughness = 0.2
emission = [0.05, 0.1, 0.2]
"#;
    let stage = Stage::new(look, &TEXTURES);
    let mut session = stage.open("scene.look.toml");
    let mut display = Display::new(session.device()).expect("compiled");
    let mut check = |session: &mut Session, channel, expected: [[f32; 3]; 2]| {
        for (shown, expected) in looks(session, &mut display, channel).iter().zip(expected) {
            for (byte, expected) in shown.iter().zip(expected) {
                let difference = f32::from(*byte) - 255.0 * expected;
                assert!(
                    difference.abs() <= 1.0,
                    "{channel:?}: {shown:?}, not {expected:?}"
                );
            }
        }
    };
    let srgb = |c: [f32; 3]| {
        c.map(|x| match x {
            x if x <= 0.003_130_8 => 12.92 * x,
            x => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        })
    };
    let wall = srgb([0.2, 0.4, 0.6]);
    check(
        &mut session,
        Channel::BaseColor,
        [srgb([0.8, 0.4, 0.2]), wall],
    );
    check(&mut session, Channel::Roughness, [[0.7; 3], [0.2; 3]]);
    check(&mut session, Channel::Metallic, [[0.6; 3], [0.1; 3]]);
    let glow = srgb([0.1, 0.2, 0.4]);
    check(&mut session, Channel::Emission, [[0.0; 3], glow]);
    // An edit is seen here, too.
    let edit = Edit::argument("paint", "amount", &texgen::Value::F32(0.5));
    session.edit(&edit).expect("edited");
    check(
        &mut session,
        Channel::BaseColor,
        [srgb([0.2, 0.1, 0.05]), wall],
    );
}

#[test]
fn costs_are_measured_beside_the_picture() {
    let Some((_stage, mut session, whole)) = opened() else {
        return;
    };
    let device = session.device().clone();
    let made = (device.counts().pipelines, device.counts().shader_modules);
    session.restart();
    session.step(SPP).expect("rendered");
    let costs = loop {
        let costs = session.measure_costs().expect("measured").clone();
        if costs.is_done {
            break costs;
        }
    };
    render(&mut session);
    assert!(is_same(&session.snapshot().expect("read").film, &whole));
    assert_eq!(
        (device.counts().pipelines, device.counts().shader_modules),
        made
    );
    let find = |name: &str| costs.list.iter().find(|cost| cost.name == name);
    // The node that nothing reads isn't there; the AO table is.
    assert!(find("other").is_none() && find("crevices").is_some_and(|c| c.texture.is_none()));
    let runs = |name: &str| find(name).map_or(0.0, |cost| cost.runs_per_pixel);
    // Rings run on the floor, and on the wall as the mask of its blend; paint on the floor, worn on a part of the wall.
    assert!(runs("paint") > 0.05 && runs("worn") > 0.01, "{costs:?}");
    assert!(runs("rings") > runs("paint") + runs("worn"), "{costs:?}");
    assert!(
        runs("rings") <= 1.0 && runs("crevices") > runs("worn"),
        "{costs:?}"
    );
    assert_eq!(
        find("worn").and_then(|cost| cost.texture.as_deref()),
        Some("worn")
    );
    let each: Vec<_> = costs.list.iter().map(|cost| cost.per_sample()).collect();
    assert!(each.is_sorted_by(|a, b| a >= b) && each.iter().all(|ns| *ns >= 0.0 && ns.is_finite()));
    // An edit begins it anew.
    let edit = Edit::argument("rings", "count", &texgen::Value::F32(4.0));
    session.edit(&edit).expect("edited");
    assert!(!session.measure_costs().expect("measured").is_done);
}
