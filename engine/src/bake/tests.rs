//! Pictures whose every texel is known.

use std::path::Path;
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec4};

use super::*;
use crate::procedural::TextureSources;
use crate::scene::look::Look;
use crate::scene::{
    AlphaMode, Camera, Image, Instance, Material, Projection, Sampler, TextureRef, default_camera,
};

const SETTINGS: BakeSettings = BakeSettings {
    size: 16,
    grid: 2,
    occlusion: None,
    keeps_flat: true,
};

/// A square of 2 x 2 metres in the plane z = 0 that faces +Z, whose picture lies on it as one sees it, a metre above the origin.
fn square(material: Material) -> Scene {
    let corners = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)];
    let mesh = Mesh {
        name: "square".to_owned(),
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).into(),
        normals: vec![Vec3::Z; 4],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4],
        uv0: corners
            .map(|(x, y)| Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y))
            .into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![0; 2],
        ..Mesh::default()
    };
    Scene {
        meshes: vec![mesh],
        instances: vec![Instance {
            name: "square".to_owned(),
            mesh: 0,
            transform: Affine3A::from_translation(Vec3::Y),
            asset: None,
        }],
        materials: vec![material],
        ..Scene::default()
    }
}

fn plain() -> Material {
    Material {
        name: "M".to_owned(),
        metallic: 0.0,
        roughness: 0.5,
        ..Material::default()
    }
}

fn baked(look: &str, textures: &[(&str, &str)], settings: &BakeSettings) -> BakedMaterial {
    baked_of(square(plain()), look, textures, settings)
}

fn baked_of(
    scene: Scene,
    look: &str,
    textures: &[(&str, &str)],
    settings: &BakeSettings,
) -> BakedMaterial {
    with_baker(scene, look, textures, |baker| {
        let target = Target {
            instance: 0,
            layout: &baker.scene.meshes[0],
            material: Some(0),
        };
        let go_on = &mut |_| ControlFlow::Continue(());
        baker
            .material(0, &target, settings, go_on)
            .expect("pictures")
    })
}

/// The scene as it is exported.
fn exported(scene: Scene, look: &str, textures: &[(&str, &str)], settings: &BakeSettings) -> Scene {
    with_baker(scene, look, textures, |baker| {
        let camera = default_camera(baker.scene);
        let go_on = &mut |_| ControlFlow::Continue(());
        let (scene, _) = baker.scene(&camera, settings, go_on).expect("a scene");
        scene
    })
}

fn with_baker<T>(
    mut scene: Scene,
    look: &str,
    textures: &[(&str, &str)],
    bake: impl FnOnce(&Baker<'_>) -> T,
) -> T {
    let mut sources = TextureSources::default();
    for (name, text) in textures {
        sources.insert(name, text);
    }
    let look = Look::parse(Path::new("l.toml"), look).unwrap_or_else(|e| panic!("{e}"));
    let procedural =
        Procedural::build(&look, &mut scene, &sources).unwrap_or_else(|e| panic!("{e}"));
    let device = Device::open(&device::DeviceChoice::Native(1)).expect("the processor");
    let baker = Baker::new(&device, &scene, &procedural, Moment::default()).expect("a kernel");
    bake(&baker)
}

fn texel(baked: &BakedMaterial, role: Role, x: usize, y: usize) -> [f32; 4] {
    let image = baked.images.iter().find(|image| image.role == role);
    image.expect("there is one").rgba[y * 16 + x]
}

#[track_caller]
fn near(given: [f32; 4], wanted: [f32; 4], tolerance: f32) {
    let is_near = (0..4).all(|i| (given[i] - wanted[i]).abs() <= tolerance);
    assert!(is_near, "{given:?} is not {wanted:?}");
}

const PLACE: &str = "fn userProc() -> vec3f {
    let p = readAttr(WorldPos).xyz;
    return vec3f(0.5 + 0.5 * readAttr(LocalPos).x, p.y - 1.0, readAttr(TexCoord0).x) * 0.5 + 0.25;
}";

const ALONG: &str = "fn userProc() -> f32 { return readAttr(TexCoord0).x; }";

#[test]
fn textures_read_the_place_of_each_texel() {
    let look = "[node.place]\ntexture = \"place\"\n[material.M]\nbase_color = \"place\"\n";
    let baked = baked(look, &[("place", PLACE)], &SETTINGS);
    for (x, y) in [(0, 0), (15, 0), (7, 11)] {
        let (u, v) = ((x as f32 + 0.5) / 16.0, (y as f32 + 0.5) / 16.0);
        let wanted = [
            0.25 + 0.5 * u,
            0.25 + 0.5 * (1.0 - 2.0 * v),
            0.25 + 0.5 * u,
            1.0,
        ];
        // Four samples of something linear have its value in the middle.
        near(texel(&baked, Role::BaseColor, x, y), wanted, 1e-5);
    }
    near(
        texel(&baked, Role::MetallicRoughness, 3, 3),
        [1.0, 0.5, 0.0, 1.0],
        1e-6,
    );
    near(
        texel(&baked, Role::Normal, 3, 3),
        [0.0, 0.0, 1.0, 1.0],
        1e-6,
    );
    assert_eq!(baked.overlap, 0.0);
    assert_eq!(baked.material.alpha_mode, AlphaMode::Opaque);
}

#[test]
fn what_is_the_same_everywhere_is_a_constant() {
    let flat = BakeSettings {
        keeps_flat: false,
        ..SETTINGS
    };
    let textures = [
        ("half", "fn userProc() -> f32 { return 0.25; }"),
        ("place", PLACE),
    ];
    let look = "[node.half]\ntexture = \"half\"\n[node.place]\ntexture = \"place\"\n\
                [material.M]\nroughness = \"half\"\nbase_color = \"place\"\nmetallic = 1.0\n";
    let baked = baked(look, &textures, &flat);
    let roles: Vec<Role> = baked.images.iter().map(|image| image.role).collect();
    assert_eq!(roles, [Role::BaseColor]);
    assert_eq!(
        (baked.material.roughness, baked.material.metallic),
        (0.25, 1.0)
    );
    assert_eq!(baked.material.base_color, Vec4::ONE);
}

/// glTF has one index of refraction, which is driven evenly here and then not.
#[test]
fn the_index_is_the_mean_of_what_drives_it() {
    let of = |index: &str| {
        let text = format!("fn userProc() -> f32 {{ return {index}; }}");
        let look = "[node.index]\ntexture = \"index\"\n[material.M]\nior = \"index\"\n";
        baked(look, &[("index", &text)], &SETTINGS)
    };
    let even = of("2.25");
    assert_eq!((even.material.ior, &even.lost[..]), (2.25, &[][..]));
    let uneven = of("1.5 + readAttr(TexCoord0).x");
    assert!((uneven.material.ior - 2.0).abs() < 1e-3);
    assert_eq!(uneven.lost, ["ior"]);
}

#[test]
fn what_no_picture_holds_is_that_of_the_surface_that_is_seen() {
    let of = |mask: &str| {
        let look = format!(
            "[material.M]\nblend = {{ base = \"M\", over = \"Film\", mask = {mask} }}\n\
             [material.Film]\niridescence = 1.0\niridescence_ior = 2.0\nunlit = true\n"
        );
        baked(&look, &[], &SETTINGS)
    };
    let whole = of("1.0");
    assert!(whole.material.unlit && whole.lost.is_empty());
    assert_eq!(whole.material.iridescence_ior, 2.0);
    let none = of("0.0");
    assert!(!none.material.unlit && none.lost.is_empty());
    // The other surface has no film.
    let half = of("0.5");
    assert_eq!(half.material.iridescence_ior, 2.0);
    assert_eq!(half.lost, ["unlit"]);
}

#[test]
fn bodies_of_blends_absorb_what_those_do_that_let_light_through() {
    let of = |base: &str| {
        let look = format!(
            "[material.M]\n{base}blend = {{ base = \"M\", over = \"Glass\", mask = 0.5 }}\n\
             [material.Glass]\ntransmission = 1.0\nsolid = true\nattenuation_color = [0.5, 0.25, 1.0]\n\
             attenuation_distance = 0.5\n"
        );
        baked(&look, &[], &SETTINGS)
    };
    let paint = of("");
    assert!(paint.material.is_solid && paint.lost.is_empty());
    let mut glass = plain();
    glass.attenuate(Vec3::new(0.5, 0.25, 1.0), 0.5);
    assert_eq!(paint.material.absorption, glass.absorption);
    assert_eq!(of("transmission = 0.5\n").lost, ["solid"]);
    let tinted = of("transmission = 0.5\nsolid = true\ndispersion = 1.0\n");
    assert_eq!(tinted.lost, ["dispersion", "attenuation_color"]);
}

/// Followed side by side these would be more than any computer can.
#[test]
fn blends_that_share_what_they_blend_are_followed_once() {
    let mut look = "[material.B0]\nunlit = true\n".to_owned();
    for i in 1..=60 {
        let below = i - 1;
        let name = match i {
            60 => "M".to_owned(),
            _ => format!("B{i}"),
        };
        look += &format!(
            "[material.{name}]\nblend = {{ base = \"B{below}\", over = \"B{below}\", mask = 0.5 }}\n"
        );
    }
    let baked = baked(&look, &[], &SETTINGS);
    assert!(baked.material.unlit && baked.lost.is_empty());
}

/// Renderers take such colours as 1 at most, and so do pictures.
#[test]
fn colours_of_sheen_end_at_one() {
    let textures = [(
        "sheen",
        "fn userProc() -> vec3f { return vec3f(4.0 * readAttr(TexCoord0).x, 0.5, 0.25); }",
    )];
    let look = "[node.sheen]\ntexture = \"sheen\"\n[material.M]\nsheen_color = \"sheen\"\n";
    let baked = baked(look, &textures, &SETTINGS);
    let image = (baked.images.iter()).find(|image| image.role == Role::SheenColor);
    let bytes = image.expect("there is one").eight_bits();
    // 0.5 as sRGB has it.
    assert_eq!(bytes[15 * 4..][..2], [255, 188]);
    assert_eq!(baked.material.sheen_color, Vec3::ONE);
}

#[test]
fn blends_are_mixed_by_their_share() {
    let look = "[material.N]\nbase_color = [1.0, 0.0, 0.0]\nroughness = 1.0\nemission = [2.0, 0.0, 0.0]\n\
                [material.M]\nblend = { base = \"M\", over = \"N\", mask = 0.25 }\n";
    let baked = baked(look, &[], &SETTINGS);
    near(
        texel(&baked, Role::BaseColor, 5, 5),
        [1.0, 0.75, 0.75, 1.0],
        1e-6,
    );
    near(
        texel(&baked, Role::MetallicRoughness, 5, 5),
        [1.0, 0.625, 0.0, 1.0],
        1e-6,
    );
    assert_eq!(baked.material.emission, Vec3::new(0.5, 0.0, 0.0));
}

#[test]
fn heights_and_normals_of_the_world_become_normal_maps() {
    let textures = [(
        "slope",
        "fn userProc() -> f32 { let p = readAttr(WorldPos); return 0.5 * p.x - 0.25 * p.y; }",
    )];
    let look = "[node.slope]\ntexture = \"slope\"\n[material.M]\nbump = \"slope\"\n";
    let bumped = baked(look, &textures, &SETTINGS);
    let wanted = Vec3::new(-0.5, 0.25, 1.0).normalize().extend(1.0);
    near(texel(&bumped, Role::Normal, 9, 4), wanted.to_array(), 1e-3);
    let image = bumped
        .images
        .iter()
        .find(|image| image.role == Role::Normal);
    let bytes = image.expect("there is one").eight_bits();
    assert_eq!(
        bytes[..3],
        [72, 155, 239].map(|b: u8| b),
        "{:?}",
        &bytes[..3]
    );
    let textures = [(
        "tilted",
        "fn userProc() -> vec3f { return vec3f(0.6, 0.0, 0.8); }",
    )];
    let look = "[node.tilted]\ntexture = \"tilted\"\n[material.M]\nnormal = \"tilted\"\n";
    let tilted = baked(look, &textures, &SETTINGS);
    near(
        texel(&tilted, Role::Normal, 0, 0),
        [0.6, 0.0, 0.8, 1.0],
        1e-5,
    );
}

#[test]
fn the_coat_keeps_a_normal_of_its_own() {
    let mut scene = square(Material {
        coat: 1.0,
        coat_normal_scale: 0.5,
        coat_normal_texture: Some(TextureRef {
            image: 0,
            uv_set: 0,
            sampler: Sampler::default(),
            transform: [Vec3::X, Vec3::Y],
        }),
        ..plain()
    });
    scene.images.push(Image {
        name: "coat".to_owned(),
        width: 1,
        height: 1,
        rgba8: Arc::new(vec![230, 128, 230, 255]),
        srgb: false,
    });
    let textures = [(
        "tilt",
        "fn userProc() -> vec3f { return vec3f(0.6, 0.0, 0.8); }",
    )];
    let look = "[node.t]\ntexture = \"tilt\"\n[material.M]\nnormal = \"t\"\n";
    let coated = baked_of(scene, look, &textures, &SETTINGS);
    near(
        texel(&coated, Role::Normal, 3, 3),
        [0.6, 0.0, 0.8, 1.0],
        1e-3,
    );
    // The map leans by half as much as it is up, and as much along.
    let texel_z = 2.0 * 230.0 / 255.0 - 1.0;
    let wanted = Vec3::new(0.5 * texel_z, 0.5 / 255.0, texel_z).normalize();
    near(
        texel(&coated, Role::CoatNormal, 3, 3),
        wanted.extend(1.0).to_array(),
        1e-3,
    );
    assert_eq!(coated.material.coat_normal_scale, 1.0);
}

#[test]
fn opacity_is_alpha_and_strong_emission_keeps_its_strength() {
    let textures = [
        (
            "cut",
            "fn userProc() -> f32 { return step(0.0, readAttr(LocalPos).x); }",
        ),
        (
            "glow",
            "fn userProc() -> vec3f { return vec3f(6.0, 3.0, 0.0) * readAttr(TexCoord0).x; }",
        ),
    ];
    let look = "[node.cut]\ntexture = \"cut\"\n[node.glow]\ntexture = \"glow\"\n\
                [material.M]\nopacity = \"cut\"\nemission = \"glow\"\n";
    let baked = baked(look, &textures, &SETTINGS);
    assert_eq!(texel(&baked, Role::BaseColor, 2, 2)[3], 0.0);
    assert_eq!(texel(&baked, Role::BaseColor, 12, 2)[3], 1.0);
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    assert_eq!(baked.material.alpha_mode, mask);
    let most = 6.0 * 15.5 / 16.0;
    assert!((baked.material.emission - most).abs().max_element() < 1e-4);
    let image = baked
        .images
        .iter()
        .find(|image| image.role == Role::Emission);
    assert_eq!(image.expect("there is one").eight_bits()[15 * 4], 255);
}

#[test]
fn a_small_pane_stays_translucent_and_borders_of_holes_are_cut() {
    let mode = |opacity: &str| {
        let scene = square(Material {
            alpha_mode: AlphaMode::Blend,
            ..plain()
        });
        let text =
            format!("fn userProc() -> f32 {{ let p = readAttr(TexCoord0).xy; return {opacity}; }}");
        let look = "[node.o]\ntexture = \"o\"\n[material.M]\nopacity = \"o\"\n";
        let baked = baked_of(scene, look, &[("o", text.as_str())], &SETTINGS);
        baked.material.alpha_mode
    };
    // A sixteenth of the surface.
    let pane = "select(1.0f, 0.3f, max(p.x, p.y) < 0.25)";
    assert_eq!(mode(pane), AlphaMode::Blend);
    let mask = AlphaMode::Mask { cutoff: 0.5 };
    assert_eq!(mode("step(0.3, length(p - 0.5))"), mask);
    // As wide as textures smooth their edges.
    let soft = "saturate(16.0 * (length(p - 0.5) - 0.3))";
    assert_eq!(mode(soft), mask);
    assert_eq!(mode("0.3 + 0.0 * p.x"), AlphaMode::Blend);
}

#[test]
fn a_translucent_surface_stays_so_however_few_of_it_are_between() {
    // Nothing drives the opacity; that of the vertices looks like the border of a mask.
    let mut scene = square(Material {
        alpha_mode: AlphaMode::Blend,
        ..plain()
    });
    scene.meshes[0].colors = [-8.0, -8.0, 8.0, 8.0]
        .map(|alpha| Vec4::new(1.0, 1.0, 1.0, alpha + 0.5))
        .into();
    let textures = [("u", ALONG)];
    let look = "[node.u]\ntexture = \"u\"\n[material.M]\nroughness = \"u\"\n";
    let baked = baked_of(scene, look, &textures, &SETTINGS);
    assert_eq!(baked.material.alpha_mode, AlphaMode::Blend);
    assert_eq!(texel(&baked, Role::BaseColor, 2, 5)[3], 0.0);
    assert_eq!(texel(&baked, Role::BaseColor, 12, 5)[3], 1.0);
}

#[test]
fn colours_of_vertices_are_in_the_base_colour() {
    let mut scene = square(plain());
    scene.meshes[0].colors = [0.0, 0.0, 1.0, 1.0]
        .map(|blue| Vec4::new(1.0, 0.1, blue, 1.0))
        .into();
    let textures = [("u", ALONG)];
    let look = "[node.u]\ntexture = \"u\"\n[material.M]\nroughness = \"u\"\n";
    let flat = BakeSettings {
        keeps_flat: false,
        ..SETTINGS
    };
    let baked = baked_of(scene.clone(), look, &textures, &flat);
    let wanted = [1.0, 0.1, 3.5 / 16.0, 1.0];
    near(texel(&baked, Role::BaseColor, 3, 9), wanted, 1e-5);
    assert_eq!(baked.material.alpha_mode, AlphaMode::Opaque);

    // A colour that all have is a number, in exports as well, whose meshes are white where pictures lie on them.
    scene.meshes[0].colors = vec![Vec4::new(1.0, 0.1, 0.2, 1.0); 4];
    let scene = exported(scene, look, &textures, &flat);
    let mesh = &scene.meshes[scene.instances[0].mesh as usize];
    assert!(mesh.colors.iter().all(|&color| color == Vec4::ONE));
    let material = &scene.materials[mesh.triangle_materials[0] as usize];
    let color = material.base_color.to_array();
    near(color, [1.0, 0.1, 0.2, 1.0], 1e-5);
    assert!(material.base_color_texture.is_none());
    assert!(material.metallic_roughness_texture.is_some());
}

#[test]
fn dark_colours_that_differ_as_they_are_stored_have_a_picture() {
    let flat = BakeSettings {
        keeps_flat: false,
        ..SETTINGS
    };
    let roles = |color: &str| {
        let text = format!(
            "fn userProc() -> vec3f {{ return vec3f({color} * step(0.5, readAttr(TexCoord0).x)); }}"
        );
        let look = "[node.dark]\ntexture = \"dark\"\n[material.M]\nbase_color = \"dark\"\n";
        let baked = baked(look, &[("dark", text.as_str())], &flat);
        let images = baked.images.iter();
        images
            .map(|image| (image.role, image.eight_bits()))
            .collect::<Vec<_>>()
    };
    let dark = roles("0.0019");
    let [(Role::BaseColor, bytes)] = &dark[..] else {
        panic!("the base colour has a picture, and nothing else");
    };
    assert_eq!((bytes[0], bytes[15 * 4]), (0, 6));
    assert!(roles("0.0001").is_empty());
}

#[test]
fn ambient_occlusion_is_that_of_the_place() {
    let settings = BakeSettings {
        occlusion: Some(1.0),
        ..SETTINGS
    };
    let textures = [("open", "fn userProc() -> f32 { return readAttr(AO).x; }")];
    let look = "[node.open]\ntexture = \"open\"\n[material.M]\nroughness = \"open\"\n";
    // Nothing is near a square alone.
    let baked = baked(look, &textures, &settings);
    near(
        texel(&baked, Role::MetallicRoughness, 8, 8),
        [1.0, 1.0, 0.0, 1.0],
        0.0,
    );
    assert!(baked.has_occlusion);
}

/// The square, and another one beside it that has none of the picture, as the sides of a box from above.
fn beside_a_crushed_one() -> Scene {
    let mut scene = square(plain());
    let mesh = &mut scene.meshes[0];
    let more: Vec<Vec3> = mesh.positions.iter().map(|p| *p + 3.0 * Vec3::X).collect();
    mesh.positions.extend(more);
    mesh.normals.extend([Vec3::Z; 4]);
    mesh.tangents.extend_from_within(..);
    mesh.uv0.extend([Vec2::new(1.0, 0.3); 4]);
    mesh.triangles.extend([[4, 5, 6], [4, 6, 7]]);
    mesh.triangle_materials.extend([0; 2]);
    scene
}

#[test]
fn what_has_no_texel_is_told_and_unwrapped() {
    let textures = [("place", PLACE)];
    let look = "[node.place]\ntexture = \"place\"\n[material.M]\nbase_color = \"place\"\n";
    assert_eq!(baked(look, &textures, &SETTINGS).missed, 0.0);
    let missed = baked_of(beside_a_crushed_one(), look, &textures, &SETTINGS).missed;
    assert!((missed - 0.5).abs() < 1e-6, "{missed}");

    let scene = exported(beside_a_crushed_one(), look, &textures, &SETTINGS);
    let mesh = &scene.meshes[scene.instances[0].mesh as usize];
    assert_eq!(mesh.triangles.len(), 4);
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|i| mesh.uv0[i as usize]);
        let area = (b - a).perp_dot(c - a).abs();
        assert!(area > 0.01, "{a} {b} {c}");
    }
}

/// A part of a cylinder of radius 1 along z, of so many rows each way, with the picture of the square.
fn bent(columns: u32, rows: u32) -> Mesh {
    let points = || (0..=rows).flat_map(move |row| (0..=columns).map(move |column| (column, row)));
    let uv = |(column, row): (u32, u32)| {
        Vec2::new(column as f32 / columns as f32, row as f32 / rows as f32)
    };
    let normal = |at: (u32, u32)| {
        let (sin, cos) = (1.5 * uv(at).x - 0.75).sin_cos();
        Vec3::new(sin, cos, 0.0)
    };
    let corner = |column: u32, row: u32| row * (columns + 1) + column;
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(x, y)| {
            let [a, b] = [corner(x, y), corner(x + 1, y)];
            let [c, d] = [corner(x + 1, y + 1), corner(x, y + 1)];
            [[a, d, c], [a, c, b]]
        })
        .collect();
    Mesh {
        name: "bent".to_owned(),
        positions: points().map(|at| normal(at) + uv(at).y * Vec3::Z).collect(),
        normals: points().map(normal).collect(),
        uv0: points().map(uv).collect(),
        triangle_materials: vec![0; triangles.len()],
        triangles,
        ..Mesh::default()
    }
}

#[test]
fn curvature_does_not_depend_on_the_triangles() {
    let textures = [(
        "bend",
        "fn userProc() -> f32 { return readAttr(Curvature).x; }",
    )];
    let look = "[node.bend]\ntexture = \"bend\"\n[material.M]\nroughness = \"bend\"\n";
    for (columns, rows, scale) in [(8, 1, 1.0), (8, 16, 1.0), (2, 30, 1.0), (12, 3, 2.0)] {
        let mut scene = square(plain());
        scene.meshes[0] = bent(columns, rows);
        scene.instances[0].transform = Affine3A::from_scale(Vec3::splat(scale));
        let rgba = with_baker(scene, look, &textures, |baker| {
            let target = Target {
                instance: 0,
                layout: &baker.scene.meshes[0],
                material: None,
            };
            let node = baker.procedural.graph().node("bend").expect("it is there");
            let go_on = &mut |_| ControlFlow::Continue(());
            let maps = baker.node(node, &target, &SETTINGS, go_on);
            maps.expect("pictures").rgba()
        });
        for texel in rgba {
            let wanted = 0.5 / scale;
            assert!(
                (texel[0] - wanted).abs() < 1e-3,
                "{columns} x {rows}: {texel:?}"
            );
        }
    }
}

#[test]
fn the_first_camera_is_the_one_that_the_look_says() {
    let given = default_camera(&Scene::default());
    let first = |camera: &Camera| {
        let mut cameras = vec![given.clone()];
        super::scene::put_first(&mut cameras, camera);
        assert_eq!(cameras[0], *camera);
        cameras.len()
    };
    assert_eq!(first(&given), 1);
    let narrow = Camera {
        projection: Projection::Perspective { y_fov: 0.2 },
        aperture_radius: 0.01,
        ..given.clone()
    };
    assert_eq!(first(&narrow), 1);
    let mut moved = narrow;
    moved.transform.translation.x += 1.0;
    assert_eq!(first(&moved), 2);
}

#[test]
fn results_that_are_not_finite_are_counted() {
    // Infinite on the left half of the square, of 1024 samples.
    let textures = [
        (
            "half",
            "fn userProc() -> f32 { return 1.0 / max(readAttr(TexCoord0).x - 0.5, 0.0); }",
        ),
        ("along", ALONG),
    ];
    let look = |driven: &str| {
        format!(
            "[node.half]\ntexture = \"half\"\n[node.along]\ntexture = \"along\"\n[material.M]\n{driven}\n"
        )
    };
    let count = |driven: &str| baked(&look(driven), &textures, &SETTINGS).non_finite;
    assert_eq!(count("roughness = \"along\""), 0);
    for driven in [
        "roughness = \"half\"",
        "roughness = \"along\"\nmetallic = \"half\"",
    ] {
        let found = count(driven);
        assert!((400..600).contains(&found), "{driven}: {found}");
    }
    let of_node = with_baker(square(plain()), &look(""), &textures, |baker| {
        let target = Target {
            instance: 0,
            layout: &baker.scene.meshes[0],
            material: None,
        };
        let node = baker.procedural.graph().node("half").expect("it is there");
        let go_on = &mut |_| ControlFlow::Continue(());
        let maps = baker.node(node, &target, &SETTINGS, go_on);
        maps.expect("pictures").non_finite
    });
    assert!((400..600).contains(&of_node), "{of_node}");
    assert_eq!(non_finite_warning(0), None);
    let words = with_baker(
        square(plain()),
        &look("roughness = \"half\""),
        &textures,
        |baker| {
            let camera = default_camera(baker.scene);
            let go_on = &mut |_| ControlFlow::Continue(());
            let (_, warnings) = baker.scene(&camera, &SETTINGS, go_on).expect("a scene");
            warnings.to_string()
        },
    );
    assert!(words.contains("not finite"), "{words}");
}
