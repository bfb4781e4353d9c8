//! What a look becomes on the way to the GPU, with textures small enough to be seen through.

use std::path::Path;

use texgen::Value;

use crate::scene::look::{AoDirection, Look};
use crate::scene::{Material, Scene};

use super::*;

const FLAT: &str = "/// One colour.\n/// @param tint colour [color] = (1, 1, 1)\n/// @param amount factor = 1.0\nfn userProc(tint: vec3f, amount: f32) -> vec3f { return tint * amount; }\n";
const RANGED: &str = "/// A wall.\n/// @param joint width [0.001 .. 10] = 0.02\n/// @param count bricks [0 .. 5] = 1\nfn userProc(joint: f32, count: i32) -> f32 { return joint * f32(count); }\n";
const VALUE: &str = "/// A number.\n/// @param level the number = 0.5\nfn userProc(level: f32) -> f32 { return level; }\n";
const ANGLE: &str = "/// Where to, in degrees.\nfn userProc() -> f32 { return 30.0; }\n";
const OPEN: &str =
    "/// Occlusion.\nfn userProc() -> f32 { return readAttr(AO).x * readAttr(AO1).x; }\n";
const PICTURE: &str = "/// A picture through a ramp.\nfn userProc(image: sam2D, ramp: ramp1D, steps: i32) -> vec4f { return rampEval(ramp, tex2D(image, readAttr(TexCoord0).xy).x) * f32(steps); }\n";

fn textures() -> TextureSources {
    let mut sources = TextureSources::default();
    for (name, text) in [
        ("flat", FLAT),
        ("value", VALUE),
        ("open", OPEN),
        ("picture", PICTURE),
        ("ranged", RANGED),
        ("angle", ANGLE),
    ] {
        sources.insert(name, text);
    }
    sources.insert(
        "broken",
        "fn userProc() -> f32 {\n    let a = nothing;\n    return 1.0;\n}\n",
    );
    sources
}

/// A scene with materials `A`, `B`, `C`.
fn scene() -> Scene {
    let material = |name: &str| Material {
        name: name.to_owned(),
        emission: glam::Vec3::ONE,
        ..Material::default()
    };
    Scene {
        materials: ["A", "B", "C"].map(material).to_vec(),
        ..Scene::default()
    }
}

fn try_build(text: &str) -> Result<(Procedural, Scene), Diagnostics> {
    let look = Look::parse(Path::new("test.look.toml"), text)?;
    let mut scene = scene();
    let procedural = Procedural::build(&look, &mut scene, &textures())?;
    Ok((procedural, scene))
}

#[track_caller]
fn build(text: &str) -> (Procedural, Scene) {
    try_build(text).unwrap_or_else(|problems| panic!("{problems}"))
}

#[track_caller]
fn refused(text: &str, place: &str, says: &str) {
    let problems = try_build(text).expect_err("this look is wrong");
    assert_eq!(problems.len(), 1, "{problems}");
    let shown = problems.to_string();
    assert!(shown.contains(place) && shown.contains(says), "{shown}");
}

/// The head words of a material.
fn head(procedural: &Procedural, material: u32) -> &[u32] {
    let at = (material * HEAD_WORDS) as usize;
    &procedural.programs()[at..at + HEAD_WORDS as usize]
}

const CHAIN: &str = "
[node.level]
texture = 'value'
[node.paint]
texture = 'flat'
amount = 'level'
[material.A]
base_color = 'paint'
roughness = 'paint.y'
";

#[test]
fn driven_outputs_have_links_and_the_rest_is_untouched() {
    let (procedural, scene) = build(CHAIN);
    assert!(
        procedural.is_procedural(0)
            && !procedural.is_procedural(1)
            && !procedural.is_procedural(99)
    );
    let head = head(&procedural, 0);
    assert!(head[HEAD_PROGRAM as usize] >= 3 * HEAD_WORDS);
    assert_eq!(
        head[HEAD_FLAGS as usize],
        1 << Output::BASE_COLOR.number() | 1 << Output::ROUGHNESS.number()
    );
    let links = &head[HEAD_LINKS as usize..];
    assert_ne!(links[0], links[2], "one is swizzled");
    let program = head[HEAD_PROGRAM as usize] as usize;
    assert_eq!(
        procedural.programs()[program],
        2,
        "both nodes are in the program, once each"
    );
    assert_eq!(scene.materials.len(), 3);
    assert_eq!(scene.materials[0].emission, glam::Vec3::ONE);
    assert!(procedural.kernel().wgsl.contains("level"));
    assert_eq!(procedural.stack_slots(), 8);
}

#[test]
fn the_same_look_gives_the_same_words() {
    let (a, _) = build(CHAIN);
    let (b, _) = build(CHAIN);
    assert_eq!(a.programs(), b.programs());
    assert_eq!(a.args(), b.args());
    assert_eq!(a.kernel().wgsl, b.kernel().wgsl);
}

#[test]
fn a_driven_emission_replaces_the_constant() {
    let (procedural, scene) = build("[node.n]\ntexture='flat'\n[material.B]\nemission='n'");
    assert_eq!(scene.materials[1].emission, glam::Vec3::ZERO);
    assert!(procedural.traits(1).decides_light && !procedural.traits(0).decides_light);
}

#[test]
fn what_decides_about_light_is_known_beforehand() {
    let (procedural, scene) = build(
        "[node.n]\ntexture='flat'\n[node.v]\ntexture='value'\n\
         [material.A]\nemission='n'\nemission_strength=4.0\n\
         [material.B]\nemission=[0,0,0]\nopacity='v'\n\
         [material.C]\nblend={base='A', over='B', mask='v'}\n",
    );
    let [a, b, c] = [0, 1, 2].map(|m| procedural.traits(m));
    assert!(a.runs && a.decides_light && a.glows && !a.decides_opacity);
    assert!(
        (a.brightness - 4.0).abs() < 1e-5,
        "the strength is the guess"
    );
    assert!(b.decides_opacity && b.decides_light && !b.glows);
    assert!(c.decides_opacity && c.glows && c.brightness == a.brightness);
    assert_eq!(
        scene.materials[1].alpha_mode,
        crate::scene::AlphaMode::Opaque
    );
    assert_eq!(procedural.traits(3), ProgramTraits::default());
}

#[test]
fn a_bump_has_a_program_of_its_own() {
    let (mut procedural, _) = build(
        "[node.n]\ntexture='flat'\n[node.v]\ntexture='value'\n\
         [material.A]\nbase_color='n'\nbump='v'\nbump_scale=0.25\n",
    );
    let of_a = head(&procedural, 0);
    let program = |word: u32| &procedural.programs()[of_a[word as usize] as usize..];
    assert_eq!(program(HEAD_PROGRAM)[0], 1, "the colour alone");
    assert_eq!(program(HEAD_BUMP_PROGRAM)[0], 1, "the height alone");
    assert_eq!(f32::from_bits(of_a[HEAD_BUMP_SCALE as usize]), 0.25);
    assert_eq!(procedural.result_words(), 6);
    procedural.set_output_link("A", Output::BUMP, None).unwrap();
    assert_eq!(head(&procedural, 0)[HEAD_BUMP_PROGRAM as usize], 0);
    assert_eq!(procedural.result_words(), 3);
}

#[test]
fn contradicting_or_useless_keys_are_pointed_out() {
    refused("[material.A]\nopacity=0.5\nalpha=0.5", ":2:", "one of them");
    refused("[material.A]\nbump_scale=0.5", ":2:", "without `bump`");
    refused("[material.A]\nbump=0.5", ":2:", "the name of a node");
    let text = "[node.v]\ntexture='value'\n[material.A]\nnormal='v'";
    refused(text, ":4:", "a direction is needed");
}

#[test]
fn a_blend_with_itself_keeps_the_gltf_surface() {
    let text = format!(
        "{CHAIN}[material.B]\nblend = {{ base='B', over='Rust', mask='level' }}\nior = 1.7\n[material.Rust]\nbase_color='paint'\n"
    );
    let (procedural, scene) = build(&text);
    let names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["A", "B", "C", "B (surface)", "Rust"]);
    let mattes: Vec<_> = scene.materials.iter().map(Material::matte_name).collect();
    assert_eq!(mattes, ["A", "B", "C", "B", "Rust"]);
    let layers = crate::film::Layers::named(["crypto_material"]).expect("known");
    assert_eq!(
        layers.names(&scene)["crypto_material"],
        ["A", "B", "C", "Rust"]
    );
    let blend = head(&procedural, 1);
    assert_eq!(blend[HEAD_FLAGS as usize], FLAG_BLEND);
    assert_eq!(
        (blend[HEAD_BASE as usize], blend[HEAD_OVER as usize]),
        (3, 4)
    );
    assert_ne!(blend[HEAD_PROGRAM as usize], 0);
    assert_eq!(scene.materials[3].emission, glam::Vec3::ONE);
    assert_eq!(
        (scene.materials[1].emission, scene.materials[1].ior),
        (glam::Vec3::ZERO, 1.7)
    );
    assert_eq!(scene.materials[4].metallic, 0.0);
}

#[test]
fn constant_masks_need_no_program() {
    let (procedural, _) = build("[material.A]\nblend = { base='B', over='C', mask=0.25 }");
    let head = head(&procedural, 0);
    assert_eq!(head[HEAD_FLAGS as usize], FLAG_BLEND | FLAG_CONSTANT_MASK);
    assert_eq!(f32::from_bits(head[HEAD_MASK_VALUE as usize]), 0.25);
    assert_eq!(head[HEAD_PROGRAM as usize], 0);
}

#[test]
fn a_blend_needs_the_occlusion_of_what_lies_below_it() {
    let text = "
[ao.near]
distance = 0.1
[ao.far]
distance = 2
[ao.inner]
distance = 0.5
direction = 'inside'
[node.a]
texture = 'open'
occlusion = 'inner'
[node.b]
texture = 'open'
occlusion1 = 'inner'
[material.A]
blend = { base='B', over='C', mask=0.5 }
[material.B]
roughness = 'a'
[material.C]
blend = { base='C', over='B', mask='b' }
";
    let (mut procedural, _) = build(text);
    assert_eq!(procedural.ao_count(), 3);
    assert_eq!(procedural.ao()[2].direction, AoDirection::Inside);
    let ao = |p: &Procedural, m| head(p, m)[HEAD_AO as usize];
    assert_eq!(
        ao(&procedural, 1),
        0b110,
        "inner, and the second table for AO1"
    );
    assert_eq!(ao(&procedural, 2), 0b111);
    assert_eq!(ao(&procedural, 0), 0b111);

    let (node, far) = (procedural.node("a"), procedural.ao_slot("far"));
    let far = far.unwrap();
    procedural
        .set_occlusion_slots(node.unwrap(), [far; 2])
        .unwrap();
    assert_eq!(ao(&procedural, 1), 0b010);
    assert_eq!(ao(&procedural, 0), 0b111);
    procedural.take_changes();
    let near = AoSettings {
        distance: 0.3,
        ..procedural.ao()[0]
    };
    procedural.set_ao("near", near).unwrap();
    let changes = procedural.take_changes();
    assert_eq!(
        changes,
        Changes {
            ao: true,
            ..Changes::default()
        }
    );
    assert!(
        procedural
            .set_ao("near", AoSettings { samples: 0, ..near })
            .is_err()
    );
    assert!(
        procedural
            .set_ao("neat", near)
            .unwrap_err()
            .to_string()
            .contains("did you mean `near`?")
    );
}

#[test]
fn occlusion_without_a_table_uses_the_built_in_one() {
    let (procedural, _) = build("[node.a]\ntexture='open'\n[material.A]\nroughness='a'");
    assert_eq!(procedural.ao_count(), 1);
    assert_eq!(procedural.ao()[0], AoSettings::default());
    assert_eq!(head(&procedural, 0)[HEAD_AO as usize], 1);
    let (procedural, _) = build(CHAIN);
    assert_eq!(procedural.ao_count(), 0);
}

#[test]
fn images_are_loaded_once_for_each_use() {
    let folder = std::env::temp_dir().join(format!("patina-images-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("a.png");
    image::RgbaImage::from_pixel(2, 1, image::Rgba([255, 0, 0, 255]))
        .save(&path)
        .unwrap();
    let node = |name: &str, image: &str| {
        format!(
            "[node.{name}]\ntexture='picture'\nimage={image}\nramp=[[0,'#000'],[1,[1,1,1]]]\nsteps=2\n"
        )
    };
    let path = path.display().to_string();
    let text = [
        node("a", &format!("{path:?}")),
        node("b", &format!("{{ file = {path:?}, wrap = 'clamp' }}")),
        node(
            "c",
            &format!("{{ file = {path:?}, color_space = 'linear' }}"),
        ),
        node("d", &format!("{path:?}")),
        "[material.A]\nbase_color='a'\nemission='d'".to_owned(),
    ];
    let built = try_build(&text.concat());
    std::fs::remove_dir_all(&folder).unwrap();
    let (procedural, scene) = built.unwrap_or_else(|p| panic!("{p}"));
    assert_eq!(procedural.textures().len(), 3);
    assert_eq!(scene.images.len(), 2);
    assert!(scene.images[0].srgb && !scene.images[1].srgb);
}

#[test]
fn an_image_of_sixteen_bits_is_cut_with_a_warning() {
    let folder = std::env::temp_dir().join(format!("patina-depth-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("h.png");
    let grey = image::ImageBuffer::from_pixel(2, 1, image::Luma([0x8080u16]));
    image::DynamicImage::ImageLuma16(grey).save(&path).unwrap();
    let path = path.display().to_string();
    let node = |name: &str| {
        format!(
            "[node.{name}]\ntexture='picture'\nimage={path:?}\nramp=[[0,'#000'],[1,[1,1,1]]]\nsteps=2\n"
        )
    };
    let text = [&*node("a"), &*node("b"), "[material.A]\nbase_color='a'\n"].concat();
    let built = try_build(&text);
    std::fs::remove_dir_all(&folder).unwrap();
    let (procedural, _) = built.unwrap_or_else(|p| panic!("{p}"));
    let said = procedural.warnings().render();
    assert_eq!(said.matches("16 bits a channel").count(), 1, "{said}");
    assert!(said.contains("test.look.toml:3:7"), "{said}");
}

#[test]
fn mistakes_name_their_place_and_remedy() {
    refused(
        "[node.n]\ntexture='flta'",
        "test.look.toml:2:9",
        "did you mean `flat`?",
    );
    refused(
        "[node.n]\ntexture='flat'\namuont=2",
        "test.look.toml:3:1",
        "did you mean `amount`?",
    );
    refused(
        "[node.n]\ntexture='flat'\namount='m'",
        "test.look.toml:3:8",
        "no node called `m`",
    );
    refused(
        "[node.n]\ntexture='flat'\namount=[1, 2]",
        "test.look.toml:3:8",
        "expected a number",
    );
    refused(
        "[node.n]\ntexture='flat'\ntint='#12'",
        "test.look.toml:3:6",
        "not a colour",
    );
    refused(
        "[node.n]\ntexture='flat'\ntint=[1, 2]",
        "test.look.toml:3:6",
        "found 2 values",
    );
    refused(
        "[node.n]\ntexture='picture'\nsteps=1.5",
        "test.look.toml:3:7",
        "whole number",
    );
    refused(
        "[node.n]\ntexture='picture'\nramp=[]",
        "test.look.toml:3:6",
        "at least one stop",
    );
    refused(
        "[node.n]\ntexture='picture'\nramp='n'",
        "test.look.toml:3:6",
        "can't be driven",
    );
    refused(
        "[node.n]\ntexture='picture'\nimage='missing.png'",
        "test.look.toml:3:7",
        "missing.png",
    );
    refused(
        "[node.n]\ntexture='picture'\n[material.A]\nbase_color='n'",
        "test.look.toml:1:7",
        "image",
    );
    refused(
        "[node.n]\ntexture='flat'\n[material.A]\nroughness='n'",
        "test.look.toml:4:11",
        "write \"n.x\"",
    );
    refused(
        "[node.n]\ntexture='value'\n[material.A]\nroughness='n.y'",
        "test.look.toml:4:11",
        "no `.y`",
    );
    refused(
        "[material.AA]\nroughness=1",
        "test.look.toml:1:11",
        "there are `A`",
    );
    refused(
        "[node.a]\ntexture='value'\nlevel='b'\n[node.b]\ntexture='value'\nlevel='a'",
        "test.look.toml:6:7",
        "cyclic link",
    );
}

#[test]
fn quotes_too_many_and_misplaced_keys_are_explained() {
    refused(
        "[node.n]\ntexture='flat'\namount='0.02'",
        "test.look.toml:3:8",
        "write 0.02 without quotes",
    );
    refused(
        "[node.n]\ntexture='flat'\namount='5'",
        "test.look.toml:3:8",
        "write 5 without quotes",
    );
    refused(
        "[node.n]\ntexture='flat'\ntint='[1, 2, 3]'",
        "test.look.toml:3:6",
        "\"[1, 2, 3]\" is a string, not a list",
    );
    refused(
        "[node.n]\ntexture='flat'\nenvironment={color=[1, 1, 1]}",
        "test.look.toml:3:1",
        "before the first [table]",
    );
    // A node may be called like a number.
    build("[node.5]\ntexture='value'\n[node.n]\ntexture='flat'\namount='5'");
}

#[test]
fn arguments_that_make_no_sense_are_warnings_with_their_place() {
    let warned = |text: &str, place: &str, says: &[&str]| {
        let (procedural, _) = build(text);
        let shown = procedural.warnings().to_string();
        assert!(shown.contains(place), "{shown}");
        for says in says {
            assert!(shown.contains(says), "{says}: {shown}");
        }
    };
    warned(
        "[node.n]\ntexture='flat'\ntint=[255, 120, 0]",
        "test.look.toml:3:6",
        &[
            "`tint` is a colour beyond 1",
            "\"#ff7800\"",
            "divide by 255",
        ],
    );
    warned(
        "[node.n]\ntexture='ranged'\njoint=50",
        "test.look.toml:3:7",
        &["`joint` is 50", "0.001 to 10"],
    );
    warned(
        "[node.n]\ntexture='ranged'\ncount=-1",
        "test.look.toml:3:7",
        &["`count` is -1", "0 to 5"],
    );
    let fine = "[node.n]\ntexture='ranged'\njoint=10\ncount=5\n[node.m]\ntexture='flat'\ntint='#ff7800'\namount=9";
    assert!(build(fine).0.warnings().is_empty());
}

#[test]
fn mistakes_of_a_texture_are_shown_in_its_own_file() {
    let problems = try_build(
        "[node.n]\ntexture='broken'\n[node.m]\ntexture='broken'\n[material.A]\nroughness='n'",
    )
    .unwrap_err();
    let shown = problems.to_string();
    assert_eq!(shown.matches("broken.wgsl:2:13").count(), 1, "{shown}");
    assert!(!shown.contains("look.toml"), "{shown}");
}

#[test]
fn an_occlusion_that_nothing_reads_is_a_warning() {
    let (procedural, _) = build("[ao.a]\ndistance=1\n[node.n]\ntexture='value'\nocclusion='a'");
    let shown = procedural.warnings().to_string();
    assert!(
        shown.contains("test.look.toml:5:11") && shown.contains("no effect"),
        "{shown}"
    );
}

#[test]
fn a_link_to_an_angle_is_a_warning_unless_the_texture_names_degrees() {
    let linked = |texture: &str| {
        let look = format!("[node.n]\ntexture='{texture}'\n[material.A]\nanisotropy_rotation='n'");
        let (procedural, _) = build(&look);
        procedural.warnings().to_string()
    };
    let shown = linked("value");
    assert!(
        shown.contains("test.look.toml:4:21") && shown.contains("`degrees(...)`"),
        "{shown}"
    );
    assert_eq!(linked("angle"), "");
    let (procedural, _) = build("[material.A]\nanisotropy_rotation=30");
    assert!(procedural.warnings().is_empty());
}

#[test]
fn an_edited_value_changes_its_words_only() {
    let (mut procedural, _) = build(CHAIN);
    assert!(procedural.take_changes().is_empty());
    let programs = procedural.programs().to_vec();
    procedural
        .set_value("level", "level", Value::F32(0.75))
        .unwrap();
    let changes = procedural.take_changes();
    assert!(
        changes.programs.is_empty() && !changes.kernel && !changes.ao,
        "{changes:?}"
    );
    assert_eq!(changes.args.len(), 1);
    let range = changes.args[0].clone();
    let words = &procedural.args()[range.start as usize..range.end as usize];
    assert_eq!(words, [0.75f32.to_bits()]);
    assert_eq!(procedural.programs(), programs);
}

#[test]
fn a_thousand_edits_keep_kernel_and_memory() {
    let (mut procedural, _) = build(CHAIN);
    let (words, args) = (procedural.programs().len(), procedural.args().len());
    for i in 0..1000u32 {
        procedural
            .set_value("paint", "tint", Value::Vec3([i as f32 / 1000.0; 3]))
            .unwrap();
        if i % 2 == 0 {
            procedural.clear_link("paint", "amount").unwrap();
        } else {
            procedural.set_link("paint", "amount", "level").unwrap();
        }
        let output = Output::ALL[i as usize % 4];
        let link = match output.kind() {
            Kind::Scalar => "level",
            Kind::Color | Kind::Vector => "paint",
        };
        procedural
            .set_output_link("B", output, (i % 8 < 4).then_some(link))
            .unwrap();
    }
    assert!(!procedural.take_changes().kernel);
    assert_eq!(procedural.args().len(), args);
    assert!(
        procedural.programs().len() <= words + 64,
        "one more program"
    );
    let (fresh, _) = build(CHAIN);
    assert_eq!(head(&procedural, 0), head(&fresh, 0));
}

#[test]
fn rewiring_touches_only_the_materials_concerned() {
    let text = format!("{CHAIN}[node.other]\ntexture='value'\n[material.B]\nmetallic='other'");
    let (mut procedural, _) = build(&text);
    procedural.set_link("paint", "amount", "other.x").unwrap();
    let changes = procedural.take_changes();
    let of_b = head(&procedural, 1)[HEAD_PROGRAM as usize];
    assert!(!changes.programs.is_empty());
    assert!(
        changes
            .programs
            .iter()
            .all(|r| r.end <= of_b && !r.contains(&HEAD_WORDS)),
        "{changes:?}"
    );
}

#[test]
fn a_refused_edit_changes_nothing() {
    let text = format!(
        "{CHAIN}[node.empty]\ntexture='picture'\n[material.B]\nblend={{base='B',over='C',mask='level'}}"
    );
    let (mut procedural, _) = build(&text);
    let before = procedural.programs().to_vec();
    let message = |result: Result<(), EditError>| result.unwrap_err().to_string();
    assert!(message(procedural.set_value("nod", "a", Value::F32(1.0))).contains("no node"));
    assert!(
        message(procedural.set_value("paint", "amont", Value::F32(1.0)))
            .contains("did you mean `amount`?")
    );
    procedural
        .set_value(
            "level",
            "level",
            Value::Ramp(texgen::Ramp::black_to_white()),
        )
        .unwrap_err();
    procedural.set_link("level", "level", "level").unwrap_err();
    procedural
        .set_link("level", "level", "paint.x")
        .unwrap_err();
    procedural
        .set_link("paint", "amount", "empty.x")
        .unwrap_err();
    assert!(
        message(procedural.set_output_link("A", Output::ROUGHNESS, Some("paint"))).contains(".x")
    );
    assert!(
        message(procedural.set_output_link("D", Output::ROUGHNESS, None)).contains("no material")
    );
    procedural
        .set_output_link("B", Output::METALLIC, Some("level"))
        .unwrap();
    procedural
        .set_output_link("B", Output::METALLIC, None)
        .unwrap();
    let heads = 4 * HEAD_WORDS as usize;
    assert_eq!(procedural.programs()[..heads], before[..heads]);
    procedural
        .set_value("paint", "amount", Value::F32(0.5))
        .unwrap();
}

#[test]
fn a_program_that_needs_more_slots_asks_for_a_kernel() {
    // A balanced tree of depth 9 needs 10 slots at once.
    let mut text = String::from("[node.leaf]\ntexture='value'\n");
    let (mut sources, mut scene) = (textures(), scene());
    sources.insert(
        "sum",
        "fn userProc(a: f32, b: f32) -> f32 { return a + b; }\n",
    );
    let mut level: Vec<String> = Vec::new();
    for i in 0..512 {
        text += &format!("[node.l0_{i}]\ntexture='value'\n");
        level.push(format!("l0_{i}"));
    }
    for depth in 1..=9 {
        let pairs: Vec<_> = level.chunks(2).map(<[String]>::to_vec).collect();
        level.clear();
        for (i, pair) in pairs.iter().enumerate() {
            text += &format!(
                "[node.l{depth}_{i}]\ntexture='sum'\na='{}'\nb='{}'\n",
                pair[0], pair[1]
            );
            level.push(format!("l{depth}_{i}"));
        }
    }
    text += "[material.A]\nroughness='leaf'\n";
    let look = Look::parse(Path::new("x"), &text).unwrap_or_else(|p| panic!("{p}"));
    let mut procedural =
        Procedural::build(&look, &mut scene, &sources).unwrap_or_else(|p| panic!("{p}"));
    assert_eq!(procedural.stack_slots(), 8);
    procedural
        .set_output_link("A", Output::ROUGHNESS, Some("l9_0"))
        .unwrap();
    assert!(procedural.take_changes().kernel);
    assert!(
        (10..=12).contains(&procedural.stack_slots()),
        "{}",
        procedural.stack_slots()
    );
    procedural
        .set_output_link("A", Output::ROUGHNESS, Some("leaf"))
        .unwrap();
    procedural
        .set_output_link("A", Output::ROUGHNESS, Some("l9_0"))
        .unwrap();
    assert!(!procedural.take_changes().kernel);
}

#[test]
fn hits_count_the_nodes_that_they_run() {
    let (procedural, _) = build(
        "[node.level]\ntexture='value'\n\
         [node.paint]\ntexture='flat'\namount='level'\n\
         [node.spare]\ntexture='value'\n\
         [material.A]\nbase_color='paint'\n\
         [material.B]\nbump='level'\n\
         [material.C]\nblend={base='A', over='B', mask='level'}\n",
    );
    let hits = |material, resolved, count| Hits {
        material,
        resolved,
        count,
    };
    let count = |hits: &[Hits]| {
        let runs = procedural.count_runs(hits).into_iter();
        runs.map(|(node, n)| (procedural.graph().name(node), n))
            .collect::<Vec<_>>()
    };
    assert_eq!(count(&[hits(0, 0, 5)]), [("level", 5), ("paint", 5)]);
    assert_eq!(count(&[hits(1, 1, 5)]), [("level", 15)]);
    // The mask, and the side that was chosen.
    let both = [hits(2, 0, 2), hits(2, 1, 7)];
    assert_eq!(count(&both), [("level", 4 + 7 + 21), ("paint", 2)]);
    assert!(count(&[]).is_empty());

    let paint = procedural.graph().node("paint").unwrap();
    let words = procedural.programs_of(paint).unwrap();
    let begins = |m: u32| words[(m * HEAD_WORDS + HEAD_PROGRAM) as usize];
    let heads = 3 * HEAD_WORDS;
    assert_eq!([begins(0), begins(1), begins(2)], [heads; 3]);
    assert_eq!(words[heads as usize], 1, "one node: its link is cut");
    assert!(
        procedural
            .idle_programs()
            .iter()
            .all(|&word| word == 0 || word == 1f32.to_bits())
    );
}
