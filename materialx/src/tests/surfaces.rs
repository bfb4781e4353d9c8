//! What surfaces become, by what MaterialX's own graphs and translations of the models say.

use super::{Memory, imported, imported_as, warnings};
use crate::{Document, Wanted, convert, look_text};
use std::path::Path;

const OPEN_PBR: &str = "open_pbr_surface";

fn number(name: &str, value: &str) -> String {
    format!(r#"<input name="{name}" type="float" value="{value}"/>"#)
}

fn color(name: &str, value: &str) -> String {
    format!(r#"<input name="{name}" type="color3" value="{value}"/>"#)
}

/// The look of a surface of a model, and what is said of it.
fn look(model: &str, inputs: &[String]) -> (String, String) {
    let converted = imported_as(model, &Memory::default(), "", &inputs.concat());
    (look_text(&converted), warnings(&converted).join("\n"))
}

fn assert_has(text: &str, lines: &[&str]) {
    for line in lines {
        assert!(text.contains(&format!("\n{line}\n")), "{line}:\n{text}");
    }
}

#[test]
fn standard_surface_turns_clockwise() {
    let anisotropy = number("specular_anisotropy", "0.5");
    let (text, _) = look(
        "standard_surface",
        &[anisotropy.clone(), number("specular_rotation", "0.25")],
    );
    assert_has(&text, &["anisotropy_rotation = -90.0"]);
    let (text, _) = look("standard_surface", &[anisotropy]);
    assert_has(&text, &["anisotropy_rotation = 0.0"]);
    // glTF's own is counter-clockwise already.
    let turn = number("anisotropy_rotation", "1");
    let (text, _) = look("gltf_pbr", &[number("anisotropy_strength", "1"), turn]);
    assert!(text.contains("anisotropy_rotation = 57.29"), "{text}");
}

#[test]
fn nothing_of_the_scenes_own_material_is_seen() {
    for model in [
        "standard_surface",
        OPEN_PBR,
        "gltf_pbr",
        "UsdPreviewSurface",
    ] {
        let (text, _) = look(model, &[]);
        assert_has(
            &text,
            &[
                "emission = [0.0, 0.0, 0.0]",
                "opacity = 1.0",
                "specular = 1.0",
                "specular_color = [1.0, 1.0, 1.0]",
                "transmission = 0.0",
                "dispersion = 0.0",
                "diffuse_transmission = 0.0",
                "coat = 0.0",
                "sheen_color = [0.0, 0.0, 0.0]",
                "anisotropy = 0.0",
                "anisotropy_rotation = 0.0",
                "iridescence = 0.0",
                "unlit = false",
            ],
        );
        assert!(!text.contains("attenuation"), "{text}");
    }
    let (text, _) = look("standard_surface", &[number("transmission", "0.5")]);
    assert_has(
        &text,
        &["transmission = 0.5", "attenuation_color = [1.0, 1.0, 1.0]"],
    );
    assert!(!text.contains("\ntransmission = 0.0"), "{text}");
    // OpenPBR has no turn, also where its reflections stretch.
    let anisotropy = number("specular_roughness_anisotropy", "0.5");
    let (text, _) = look(OPEN_PBR, &[anisotropy]);
    assert_has(&text, &["anisotropy_rotation = 0.0"]);
}

#[test]
fn thin_walls_bound_no_body() {
    for (model, wall, weight) in [
        ("standard_surface", "thin_walled", "transmission"),
        (OPEN_PBR, "geometry_thin_walled", "transmission_weight"),
    ] {
        let wall = format!(r#"<input name="{wall}" type="boolean" value="true"/>"#);
        for weight_given in ["0", "0.5"] {
            let (text, _) = look(model, &[wall.clone(), number(weight, weight_given)]);
            assert_has(&text, &["double_sided = true", "solid = false"]);
            assert_eq!(text.matches("solid").count(), 1, "{text}");
        }
        let (text, _) = look(model, &[]);
        assert!(!text.contains("solid"), "{text}");
    }
}

#[test]
fn thin_walls_mix_once() {
    let thin = |name: &str| format!(r#"<input name="{name}" type="boolean" value="true"/>"#);
    let inputs = [
        thin("thin_walled"),
        color("base_color", "1, 0, 0"),
        number("subsurface", "0.5"),
        color("subsurface_color", "0, 1, 0"),
    ];
    let (text, said) = look("standard_surface", &inputs);
    assert_has(
        &text,
        &[
            "base_color = [1.0, 0.0, 0.0]",
            "diffuse_transmission = 0.5",
            "diffuse_transmission_color = [0.0, 1.0, 0.0]",
        ],
    );
    assert_eq!(said, "");
    // Half of OpenPBR's scattered light comes back, more or less of it by the anisotropy.
    let of = |anisotropy: &str| {
        let inputs = [
            thin("geometry_thin_walled"),
            color("base_color", "1, 0, 0"),
            number("subsurface_weight", "0.5"),
            color("subsurface_color", "0, 1, 0"),
            number("subsurface_scatter_anisotropy", anisotropy),
        ];
        look(OPEN_PBR, &inputs).0
    };
    // 0.5 of base, 0.25 that comes back of 0.75 that doesn't go through.
    let text = of("0");
    assert_has(&text, &["diffuse_transmission = 0.25"]);
    assert!(text.contains("base_color = [0.6666"), "{text}");
    assert_has(
        &of("1"),
        &["base_color = [1.0, 0.0, 0.0]", "diffuse_transmission = 0.5"],
    );
    assert_has(
        &of("-1"),
        &["base_color = [0.5, 0.5, 0.0]", "diffuse_transmission = 0.0"],
    );
}

#[test]
fn specular_colours_of_usd_are_reflected_at_normal_incidence() {
    let flow = r#"<input name="useSpecularWorkflow" type="integer" value="1"/>"#.to_owned();
    let reflected = color("specularColor", "0.5, 0.25, 1");
    let inputs = [flow.clone(), reflected.clone()];
    let (text, said) = look("UsdPreviewSurface", &inputs);
    assert_has(
        &text,
        &[
            "specular_color = [12.5, 6.25, 25.0]",
            "ior = 1.5",
            "metallic = 0.0",
        ],
    );
    assert_eq!(said, "");
    let (text, _) = look(
        "UsdPreviewSurface",
        &[flow.clone(), reflected.clone(), number("ior", "3")],
    );
    assert_has(&text, &["specular_color = [2.0, 1.0, 4.0]", "ior = 3.0"]);
    // An index that reflects nothing, or anything.
    let (text, _) = look("UsdPreviewSurface", &[flow, reflected, number("ior", "1")]);
    assert_has(&text, &["specular_color = [12.5, 6.25, 25.0]", "ior = 1.5"]);
}

#[test]
fn the_first_version_of_standard_surface_has_other_defaults() {
    let of = |version: &str| {
        let text = format!(
            r#"<materialx version="1.39"><standard_surface name="S" type="surfaceshader" {version}>
            <input name="base_color" type="color3" value="1, 1, 1"/></standard_surface></materialx>"#
        );
        let files = Memory::default();
        let document = Document::parse(&files, Path::new("a.mtlx"), &text).expect("a document");
        look_text(&convert(&document, &files, &Wanted::default()).expect("a look"))
    };
    for version in [r#"version="1.0.0""#, r#"version="1.0""#] {
        assert_has(&of(version), &["base_color = [0.8, 0.8, 0.8]"]);
    }
    for version in ["", r#"version="1.0.1""#] {
        assert_has(&of(version), &["base_color = [1.0, 1.0, 1.0]"]);
    }
}

#[test]
fn bumps_lie_on_the_normal_that_they_are_given() {
    let rest = r#"<noise3d name="h" type="float"/><noise3d name="n" type="vector3"/>
        <bump name="b" type="vector3"><input name="height" type="float" nodename="h"/>
        <input name="normal" type="vector3" nodename="n"/></bump>"#;
    let inputs = r#"<input name="normal" type="vector3" nodename="b"/>"#;
    let text = look_text(&imported(&Memory::default(), rest, inputs));
    assert_has(&text, &["bump = \"h\""]);
    assert!(text.contains("\nnormal = \"n"), "{text}");
    // Of bumps on bumps the last one, on the normal below all; also where they lie on themselves.
    let upper = r#"<noise3d name="g" type="float"/><bump name="c" type="vector3"><input name="height" type="float" nodename="g"/>
        <input name="normal" type="vector3" nodename="b"/></bump>"#;
    let inputs = inputs.replace("\"b\"", "\"c\"");
    let converted = imported(&Memory::default(), &format!("{rest}{upper}"), &inputs);
    let text = look_text(&converted);
    assert_has(&text, &["bump = \"g\""]);
    assert!(text.contains("\nnormal = \"n"), "{text}");
    assert_eq!(
        warnings(&converted),
        ["of bumps on bumps the last one is shown"]
    );
    let circle = format!("{rest}{upper}").replace("nodename=\"n\"", "nodename=\"c\"");
    let converted = imported(&Memory::default(), &circle, &inputs);
    assert_has(&look_text(&converted), &["bump = \"g\""]);
    let constant =
        |name: &str| format!(r#"<input name="{name}" type="vector3" value="0.3, 0, 0.9"/>"#);
    let inputs = [
        constant("normal"),
        constant("coat_normal"),
        number("coat", "1"),
    ];
    let (_, said) = look("standard_surface", &inputs);
    assert!(
        said.contains("`normal` has no counterpart where it is a constant"),
        "{said}"
    );
    assert!(said.contains("`coat_normal` has no counterpart"), "{said}");
}

#[test]
fn the_height_of_a_displacement_by_vectors_is_the_last_number() {
    let text = r#"<materialx version="1.39"><noise3d name="h" type="vector3"/>
        <displacement name="D" type="displacementshader">
        <input name="displacement" type="vector3" nodename="h"/></displacement>
        <standard_surface name="S" type="surfaceshader"/>
        <surfacematerial name="M" type="material">
        <input name="surfaceshader" type="surfaceshader" nodename="S"/>
        <input name="displacementshader" type="displacementshader" nodename="D"/></surfacematerial></materialx>"#;
    let files = Memory::default();
    let document = Document::parse(&files, Path::new("a.mtlx"), text).expect("a document");
    let converted = convert(&document, &files, &Wanted::default()).expect("a look");
    assert_has(&look_text(&converted), &["bump = \"h.z\""]);
    assert!(warnings(&converted).join("\n").contains("sideways"));
}

#[test]
fn surfaces_materials_and_graphs_inherit() {
    let text = r#"<materialx version="1.39">
        <nodegraph name="A"><constant name="k" type="float"><input name="value" type="float" value="0.25"/></constant>
        <output name="out" type="float" nodename="k"/></nodegraph>
        <nodegraph name="B" inherit="A"/>
        <noise3d name="c" type="float"><input name="amplitude" type="float" value="0.125"/></noise3d>
        <noise3d name="d" type="float" inherit="c"/>
        <standard_surface name="S" type="surfaceshader"><input name="metalness" type="float" value="0.75"/></standard_surface>
        <standard_surface name="T" type="surfaceshader" inherit="S">
        <input name="specular_roughness" type="float" nodegraph="B" output="out"/>
        <input name="coat" type="float" nodename="d"/></standard_surface>
        <surfacematerial name="M" type="material"><input name="surfaceshader" type="surfaceshader" nodename="T"/></surfacematerial>
        <surfacematerial name="N" type="material" inherit="M"/>
        <surfacematerial name="O" type="material" inherit="O"/></materialx>"#;
    let files = Memory::default();
    let document = Document::parse(&files, Path::new("a.mtlx"), text).expect("a document");
    let wanted = Wanted {
        material: Some("N".to_owned()),
        ..Wanted::default()
    };
    let converted = convert(&document, &files, &wanted).expect("a look");
    assert_has(
        &look_text(&converted),
        &["metallic = 0.75", "roughness = 0.25", "amplitude = 0.125"],
    );
    assert_eq!(warnings(&converted), [""; 0]);
    // Surfaces that are only inherited from are no materials.
    let all = convert(&document, &files, &Wanted::default()).expect("a look");
    let names: Vec<&str> = all.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["M", "N"]);
}

#[test]
fn surfaces_that_are_only_inherited_from_are_no_materials() {
    let shader = |name: &str, base: &str| {
        let inherit = match base {
            "" => String::new(),
            base => format!(r#"inherit="{base}""#),
        };
        format!(r#"<standard_surface name="{name}" type="surfaceshader" {inherit}/>"#)
    };
    let names = |shaders: &[String]| -> Vec<String> {
        let shaders = shaders.concat();
        let text = format!(r#"<materialx version="1.39">{shaders}</materialx>"#);
        let files = Memory::default();
        let document = Document::parse(&files, Path::new("a.mtlx"), &text).expect("a document");
        let converted = convert(&document, &files, &Wanted::default()).expect("a look");
        converted.materials.into_iter().map(|m| m.name).collect()
    };
    let chain = [shader("A", ""), shader("B", "A"), shader("C", "B")];
    assert_eq!(names(&chain), ["C"]);
    // What inherits in a circle isn't lost.
    assert_eq!(names(&[shader("A", "A")]), ["A"]);
    assert_eq!(names(&[shader("A", "B"), shader("B", "A")]), ["A", "B"]);
}

/// Whatever a thickness or an angle is written in.
#[test]
fn units_are_those_of_the_input() {
    let with_unit = |name: &str, value: &str, unit: &str| {
        format!(r#"<input name="{name}" type="float" value="{value}" unit="{unit}"/>"#)
    };
    let film = "iridescence_thickness";
    for (model, weight, input, value, unit, line) in [
        (
            "standard_surface",
            "base",
            "thin_film_thickness",
            "550",
            "nanometer",
            format!("{film} = 550.0"),
        ),
        (
            "standard_surface",
            "base",
            "thin_film_thickness",
            "0.5",
            "micron",
            format!("{film} = 500."),
        ),
        (
            OPEN_PBR,
            "thin_film_weight",
            "thin_film_thickness",
            "0.25",
            "micron",
            format!("{film} = 250.0"),
        ),
        (
            "gltf_pbr",
            "iridescence",
            film,
            "400",
            "nanometer",
            format!("{film} = 400.0"),
        ),
        (
            "gltf_pbr",
            "anisotropy_strength",
            "anisotropy_rotation",
            "0.5",
            "radian",
            "anisotropy_rotation = 28.6".to_owned(),
        ),
        (
            "gltf_pbr",
            "anisotropy_strength",
            "anisotropy_rotation",
            "45",
            "degree",
            "anisotropy_rotation = 45.".to_owned(),
        ),
    ] {
        let (text, said) = look(model, &[number(weight, "1"), with_unit(input, value, unit)]);
        assert!(
            text.contains(&format!("\n{line}")),
            "{model}, {line}:\n{text}\n{said}"
        );
    }
}

#[test]
fn a_rough_coat_roughens_what_is_below_it() {
    let inputs = [
        number("coat_weight", "0.5"),
        number("coat_roughness", "0.5"),
        number("specular_roughness", "0.1"),
    ];
    let (text, _) = look(OPEN_PBR, &inputs);
    // (0.1^4 + 2 0.5^4)^(1/4) is 0.5947.
    assert!(text.contains("\nroughness = 0.347"), "{text}");
    let (text, _) = look(OPEN_PBR, &inputs[1..]);
    assert_has(&text, &["roughness = 0.1"]);
}
