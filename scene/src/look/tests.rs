//! Looks as users write them, right and wrong.

use super::*;
use crate::view::{ViewTransform, WhiteBalance};
use crate::{AlphaMode, Material, absorption};

fn parse(text: &str) -> Look {
    Look::parse(Path::new("looks/test.look.toml"), text).expect("this look is right")
}

/// Line, column and text of every mistake.
fn problems(text: &str) -> Vec<(usize, usize, String)> {
    let Err(diagnostics) = Look::parse(Path::new("test.look.toml"), text) else {
        return Vec::new();
    };
    diagnostics
        .iter()
        .map(|d| {
            let place = d.location().expect("every mistake has a place");
            (
                place.line,
                place.column,
                format!("{} | {}", d.message, d.notes.join(" | ")),
            )
        })
        .collect()
}

#[track_caller]
fn one_problem(text: &str, line: usize, column: usize, says: &str) {
    let found = problems(text);
    assert_eq!(found.len(), 1, "{found:?}");
    let (l, c, message) = &found[0];
    assert!(message.contains(says), "{message}");
    assert_eq!((*l, *c), (line, column), "{message}");
}

#[test]
fn a_whole_look_is_read() {
    let look = parse(
        r##"
environment = { image = "vestibule.hdr", rotation = 30.0, intensity = 2 }

[camera]
position = [1, 2, 3]
y_fov = 40

[ao.crevices]
distance = 0.15
direction = "both"
samples = 8

[node.rust_mask]
texture = "rust_mask"
scale = 4.0
occlusion = "crevices"

[node.rust]
texture = "rust_color"
ramp = [[0.0, "#20100a"], [1.0, "#c46a2a"]]
wear = "rust_mask.x"

[material.Helmet]
blend = { base = "Helmet", over = "RustyIron", mask = "rust_mask" }

[material.RustyIron]
base_color = "rust"
roughness = 0.9
emission = "#ff0000"

[[include]]
file = "helmet.glb"
translation = [0, 1, 0]
rotation = [0, 90, 0]
scale = 2
"##,
    );
    assert!(matches!(
        &look.environment.unwrap().value,
        EnvironmentLook::Image { image, rotation: 30.0, intensity: 2.0 } if image.value == "vestibule.hdr"
    ));
    assert_eq!(
        look.camera.position.unwrap().value,
        Vec3::new(1.0, 2.0, 3.0)
    );
    assert_eq!(look.ao[0].settings.direction, AoDirection::Both);
    assert_eq!(look.ao[0].settings.samples, 8);
    assert_eq!(look.nodes[0].params.len(), 1);
    assert_eq!(look.nodes[1].params[1].key.value, "wear");
    let helmet = &look.materials[0];
    let mask = &helmet.blend.as_ref().unwrap().value.mask.value;
    assert!(
        matches!(mask, Input::Link(link) if link.node == "rust_mask" && link.swizzle.is_none())
    );
    let iron = &look.materials[1];
    assert_eq!(
        iron.input("roughness").unwrap().value,
        Input::Constant(Vec3::splat(0.9))
    );
    assert_eq!(
        iron.input("emission").unwrap().value,
        Input::Constant(Vec3::X)
    );
    // +Z turned by 90 degrees about +Y is +X.
    let moved = look.includes[0].transform.transform_point3(Vec3::Z);
    assert!(moved.distance(Vec3::new(2.0, 1.0, 0.0)) < 1e-5, "{moved}");
}

#[test]
fn hex_colours_are_srgb_and_lists_are_linear() {
    let grey = color(&Value::Text("#808080".into())).unwrap();
    assert!((grey.x - 0.215_86).abs() < 1e-4, "{grey}");
    assert_eq!(color(&Value::Text("#fff".into())), Ok(Vec3::ONE));
    for wrong in ["#ffff", "808080", "#ggg", "#ééé", ""] {
        assert!(color(&Value::Text(wrong.into())).is_err(), "{wrong}");
    }
}

#[test]
fn rotations_turn_about_x_then_y_then_z() {
    let look = parse("[[include]]\nfile = 'a.glb'\nrotation = [90, 0, 90]");
    // +Y goes to +Z about X; Z leaves it alone. +X goes to +Y about Z.
    let transform = look.includes[0].transform;
    assert!(transform.transform_vector3(Vec3::Y).distance(Vec3::Z) < 1e-6);
    assert!(transform.transform_vector3(Vec3::X).distance(Vec3::Y) < 1e-6);
}

#[test]
fn paths_are_relative_to_the_look() {
    assert_eq!(parse("").resolve("../a.hdr"), Path::new("looks/../a.hdr"));
}

#[test]
fn unknown_keys_suggest_the_near_one() {
    one_problem(
        "enviroment = { color = [1, 1, 1] }",
        1,
        1,
        "did you mean `environment`?",
    );
    one_problem(
        "[camera]\nposotion = [1, 2, 3]",
        2,
        1,
        "did you mean `position`?",
    );
    one_problem(
        "[ao.a]\ndistance = 1\nsample = 4",
        3,
        1,
        "did you mean `samples`?",
    );
    one_problem(
        "[material.A]\nrougness = 0.5",
        2,
        1,
        "did you mean `roughness`?",
    );
    one_problem("[material.A]\nwobble = 0.5", 2, 1, "it has: base_color");
    one_problem(
        "[[include]]\nfile = 'a.glb'\ntranslate = [1, 2, 3]",
        3,
        1,
        "did you mean",
    );
}

#[test]
fn unknown_names_suggest_the_near_one() {
    let nodes = "[node.rust_mask]\ntexture = 'rust_mask'\n";
    one_problem(
        &format!("{nodes}[material.A]\nroughness = 'rustmask.x'"),
        4,
        13,
        "did you mean `rust_mask`?",
    );
    one_problem(
        "[ao.deep]\ndistance = 1\n[node.a]\ntexture = 't'\nocclusion = 'dep'",
        5,
        13,
        "did you mean `deep`?",
    );
}

#[test]
fn every_mistake_is_reported_in_order() {
    let found = problems(
        "[camera]\ny_fov = 200\n[ao.a]\nsamples = 0\n[node.n]\nscale = 1\n[material.M]\nbase_color = 'x y'\nblend = {}",
    );
    let lines: Vec<_> = found.iter().map(|(line, _, _)| *line).collect();
    assert_eq!(lines, [2, 3, 4, 5, 8, 9, 9, 9], "{found:?}");
}

#[test]
fn mistakes_of_value_are_explained() {
    one_problem("environment = {}", 1, 15, "needs `image`, `color` or `sky`");
    one_problem(
        "environment = { sky = { sun_elevation = 100 } }",
        1,
        41,
        "degrees from -90 to 90",
    );
    one_problem(
        "environment = { sky = { ground_albedo = 1.5 } }",
        1,
        41,
        "from 0 to 1",
    );
    one_problem(
        "environment = { sky = { sun_elevaton = 10 } }",
        1,
        25,
        "did you mean `sun_elevation`?",
    );
    one_problem(
        "environment = { sky = {}, rotation = 10 }",
        1,
        38,
        "sun_azimuth",
    );
    one_problem(
        "environment = { color = [1e38, 1, 1], intensity = 1e38 }",
        1,
        15,
        "1e30 at most",
    );
    one_problem(
        "environment = { sky = { intensity = 1e20 }, intensity = 1e20 }",
        1,
        15,
        "1e30 at most",
    );
    one_problem(
        "[light.A]\ncolor = [1e30, 1, 1]\nintensity = 1e30",
        3,
        13,
        "too large a number",
    );
    one_problem("[material.A]\nnormal_scale = 1e38", 2, 16, "to 1e6");
    one_problem(
        "environment = { image = 'a', color = [1,1,1] }",
        1,
        15,
        "only one of",
    );
    one_problem(
        "environment = { color = [1, -1, 1] }",
        1,
        25,
        "can't be negative",
    );
    one_problem("[camera]\nposition = [1, 2]", 2, 12, "found 2 values");
    one_problem(
        "[light.Sun]\nangular_diameter = 100",
        2,
        20,
        "degrees from 0 to 90",
    );
    one_problem("[camera]\nposition = [1, 2, nan]", 2, 19, "finite number");
    one_problem("[camera]\nup = [0, 0, 0]", 2, 6, "no direction");
    one_problem("[material.A]\nroughness = 1.5", 2, 13, "from 0 to 1");
    one_problem("[material.A]\nroughness = 'a.x.y'", 2, 13, "swizzle");
    one_problem(
        "[material.A]\nblend = { base = 'B', over = 'C', mask = 0.5 }\nior = 1.4",
        3,
        7,
        "no surface of its own",
    );
    one_problem(
        "[[include]]\nfile = 'a.glb'\nscale = [1, 0, 1]",
        3,
        9,
        "flatten",
    );
    one_problem("[node]\ntexture = 'fbm'", 2, 1, "name is missing");
    one_problem("[node.'a.b']\ntexture = 'fbm'", 1, 7, "can't name a node");
    let [fits, long] = [200, 201].map(|length| "n".repeat(length));
    parse(&format!("[node.{fits}]\ntexture = 'fbm'"));
    parse(&format!("[light.sun]\ngroup = '{fits}'"));
    let node = format!("[node.{long}]\ntexture = 'fbm'");
    one_problem(&node, 1, 7, "choose a shorter one");
    let group = format!("[light.sun]\ngroup = '{long}'");
    one_problem(&group, 2, 9, "choose a shorter one");
    one_problem("a = ", 1, 5, "not valid TOML");
    one_problem("camera = 2020-01-01", 1, 10, "found a date");
}

#[test]
fn quotes_too_many_and_misplaced_keys_are_explained() {
    one_problem(
        "[material.A]\nroughness = '0.5'",
        2,
        13,
        "write 0.5 without quotes",
    );
    one_problem(
        "[material.A]\nroughness = '1'",
        2,
        13,
        "write 1 without quotes",
    );
    one_problem(
        "[camera]\ny_fov = '40'",
        2,
        9,
        "\"40\" is a string, not a number; write 40 without quotes",
    );
    one_problem(
        "[material.A]\nunlit = 'true'",
        2,
        9,
        "write true without quotes",
    );
    one_problem(
        "[material.A]\nroughness = 0.5\nenvironment = { color = [1, 1, 1] }",
        3,
        1,
        "move `environment` to the top of the file",
    );
    one_problem(
        "[camera]\ny_fov = 40\ncamera = {}",
        3,
        1,
        "before the first [table]",
    );
    one_problem("[material.A]\nroughness = 'a.5'", 2, 13, "swizzle");
}

#[test]
fn colours_beyond_one_are_warnings_where_light_would_come_from_nothing() {
    let look = parse(
        "[material.A]\nbase_color = [255, 120, 0]\nemission = [255, 120, 0]\nspecular_color = [2, 2, 2]\nsheen_color = [0.5, 1.5, 0]",
    );
    let shown = look.warnings.to_string();
    assert_eq!(look.warnings.len(), 2, "{shown}");
    for says in [":2:14", "\"#ff7800\"", "divide by 255", ":5:15", "linear"] {
        assert!(shown.contains(says), "{says}: {shown}");
    }
    assert!(
        parse("[material.A]\nbase_color = [1, 1, 0]")
            .warnings
            .is_empty()
    );
}

#[test]
fn emission_stays_a_number() {
    let mut material = Material::default();
    let look = parse("[material.A]\nemission = [1e30, 0, 1]\nemission_strength = 1e30");
    look.materials[0].apply(&mut material);
    assert_eq!(material.emission, Vec3::new(f32::MAX, 0.0, 1e30));
}

#[test]
fn what_is_absent_of_attenuation_is_that_of_the_file() {
    let mut glass = Material::default();
    glass.attenuate(Vec3::new(0.125, 0.75, 0.125), 0.5);
    let with = |text: &str, material: &Material| {
        let mut material = material.clone();
        parse(&format!("[material.A]\n{text}")).materials[0].apply(&mut material);
        material
    };
    let nearer = with("attenuation_distance = 0.25", &glass);
    assert_eq!(nearer.attenuation_color, glass.attenuation_color);
    assert_eq!(nearer.absorption, 2.0 * glass.absorption);
    let red = Vec3::new(1.0, 0.25, 0.25);
    let text = "attenuation_color = [1, 0.25, 0.25]";
    assert_eq!(with(text, &glass).absorption, absorption(red, 0.5));
    // After a metre where nobody says it.
    let plain = Material::default();
    assert_eq!(with(text, &plain).absorption, absorption(red, 1.0));
    let both = with(&format!("{text}\nattenuation_distance = 2"), &glass);
    assert_eq!(both.absorption, absorption(red, 2.0));
    assert_eq!(with("", &glass).absorption, glass.absorption);
}

/// Its picture may have any alpha, which glTF ignores.
#[test]
fn an_opaque_material_stays_so_at_full_opacity() {
    let blended = |text: &str, before: AlphaMode| {
        let mut material = Material {
            alpha_mode: before,
            ..Material::default()
        };
        parse(text).materials[0].apply(&mut material);
        (material.alpha_mode, material.base_color.w)
    };
    let (full, half) = ("[material.A]\nopacity = 1.0", "[material.A]\nopacity = 0.5");
    let opaque = AlphaMode::Opaque;
    assert_eq!(blended(full, opaque), (opaque, 1.0));
    assert_eq!(blended(half, opaque), (AlphaMode::Blend, 0.5));
    for see_through in [AlphaMode::Blend, AlphaMode::Mask { cutoff: 0.5 }] {
        assert_eq!(blended(full, see_through), (AlphaMode::Blend, 1.0));
    }
}

#[test]
fn a_fifth_ao_table_is_refused() {
    let text: String = (0..5)
        .map(|i| format!("[ao.t{i}]\ndistance = 1\n"))
        .collect();
    one_problem(&text, 9, 5, "at most 4");
}

#[test]
fn mistakes_are_shown_with_line_and_caret() {
    let error = Look::parse(
        Path::new("a.look.toml"),
        "# é\n[camera]\nposotion = [1, 2, 3]",
    )
    .unwrap_err();
    let shown = error.to_string();
    for part in [
        "--> a.look.toml:3:1",
        "3 | posotion = ",
        "  | ^^^^^^^^",
        "did you mean `position`?",
    ] {
        assert!(shown.contains(part), "{shown}");
    }
}

#[test]
fn no_text_panics() {
    let whole = include_str!("tests.rs");
    let seeds = [
        "[material.\"é\"]\nbase_color = \"é.x\"",
        "[[include]]\nfile=1",
        "a.b.c.d = {x=[[[1]]]}",
        whole,
    ];
    for seed in seeds {
        for end in (0..=seed.len().min(400)).filter(|&i| seed.is_char_boundary(i)) {
            if let Err(error) = Look::parse(Path::new("x"), &seed[..end]) {
                assert!(!error.to_string().is_empty());
            }
        }
    }
    let deep = format!("a = {}", "[".repeat(100_000));
    assert!(Look::parse(Path::new("x"), &deep).is_err());
}

#[test]
fn a_view_is_read() {
    let view =
        parse("[view]\ntransform = 'khronos-neutral'\nexposure = -2\nwhite_balance = 3200").view;
    assert_eq!(view.transform, Some(ViewTransform::KhronosNeutral));
    assert_eq!(view.exposure, Some(-2.0));
    assert_eq!(view.white_balance, WhiteBalance::new(3200.0, None));
    let view = parse("view = { white_balance = [5600, -12.5] }").view;
    assert_eq!(view.white_balance, WhiteBalance::new(5600.0, Some(-12.5)));
    assert_eq!((view.transform, view.exposure), (None, None));
    assert_eq!(parse("").view, ViewChoice::default());
}

#[test]
fn mistakes_of_a_view_have_their_places() {
    one_problem("[view]\ntransform = 'AgX'", 2, 13, "\"agx\"");
    one_problem("[view]\ntransform = 1", 2, 13, "expected a string");
    one_problem("[view]\nexposure = 33", 2, 12, "from -32 to 32");
    one_problem("[view]\nwhite_balance = 100", 2, 17, "from 1800 to 25000");
    one_problem(
        "[view]\nwhite_balance = [5000, 200]",
        2,
        17,
        "from -100 to 100",
    );
    one_problem("[view]\nwhite_balance = [5000]", 2, 17, "found 1 values");
    one_problem("[view]\nwhite_balance = 'warm'", 2, 17, "kelvins");
    one_problem(
        "[view]\ntransfrom = 'agx'",
        2,
        1,
        "did you mean `transform`?",
    );
    one_problem("view = 'agx'", 1, 8, "a table headed [view]");
}
