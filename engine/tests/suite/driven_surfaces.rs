//! What textures drive beyond colour: opacity, emission, normals and bumps. A checkerboard of a texture is compared
//! with the same checkerboard made of geometry, and simple cases with closed forms; all as statistics.
//! Skipped with a notice where there is no adapter.

use std::f32::consts::PI;

use ::device::Device;
use engine::film::Film;
use engine::procedural::TextureSources;
use engine::scene::{Camera, LightKind, Material, Projection, PunctualLight, Scene};
use glam::{Affine3A, Vec2, Vec3, Vec4};

use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{
    Shot, add, camera, faceted_sphere, floor, floor_point, from_above, lambert, lamp, quad,
    render_textured, scene, textured, unlit,
};
use crate::support::stats::ZTest;

/// Share of the pixels that must pass. Chance alone lets 99.86 % pass.
const PASSING: f64 = 0.995;
/// How far the mean of a channel may be off, relative.
const MEAN_ERROR: f64 = 0.005;

const TEXTURES: &[(&str, &str)] = &[
    (
        "squares",
        "fn userProc(size: f32, high: f32, low: f32) -> f32 {
            let cell = vec2i(floor(readAttr(TexCoord0).xy * size));
            return select(low, high, ((cell.x + cell.y) & 1) == 0);
        }",
    ),
    (
        "colored",
        "fn userProc(size: f32, color: vec3f) -> vec3f {
            let cell = vec2i(floor(readAttr(TexCoord0).xy * size));
            return select(vec3f(0.0), color, ((cell.x + cell.y) & 1) == 0);
        }",
    ),
    (
        "three",
        "fn userProc(value: vec3f) -> vec3f { return value; }",
    ),
    ("value", "fn userProc(value: f32) -> f32 { return value; }"),
    (
        "shadow_only",
        "fn userProc() -> f32 { return select(0.0, 1.0, readAttr(RayKind).x == 2.0); }",
    ),
    (
        "tilted",
        "fn userProc(tilt: f32) -> vec3f {
            return readAttr(Normal).xyz * cos(tilt) + vec3f(sin(tilt), 0.0, 0.0);
        }",
    ),
    (
        "waves",
        "fn userProc(height: f32, length: f32) -> f32 {
            return height * sin(6.2831853 * readAttr(WorldPos).x / length);
        }",
    ),
    (
        "along",
        "fn userProc() -> vec3f { return 0.5 + 0.5 * readAttr(Tangent).xyz; }",
    ),
    (
        "across",
        "fn userProc() -> vec3f { return 0.5 + 0.5 * readAttr(Bitangent).xyz; }",
    ),
    (
        "leaning",
        "fn userProc(lean: vec3f) -> vec3f {
            return readAttr(Tangent).xyz * lean.x + readAttr(Bitangent).xyz * lean.y + readAttr(Normal).xyz * lean.z;
        }",
    ),
    (
        "bend",
        "fn userProc() -> vec3f { return vec3f(readAttr(Curvature).x); }",
    ),
    (
        "slope",
        "fn userProc(slope: vec2f) -> f32 { return dot(slope, readAttr(TexCoord0).xy); }",
    ),
];

fn sources() -> TextureSources {
    let mut sources = TextureSources::default();
    for (name, text) in TEXTURES {
        sources.insert(name, text);
    }
    sources
}

fn view(device: &Device, scene: &mut Scene, look: &str, camera: &Camera, shot: Shot) -> Film {
    let procedural = textured(scene, look, &sources());
    render_textured(device, scene, &procedural, camera, shot)
}

#[track_caller]
fn assert_same(name: &str, tested: &Film, reference: &Film, mean_error: f64) {
    let (tested, reference) = (Estimate::from_film(tested), Estimate::from_film(reference));
    ZTest::default()
        .compare(tested, reference, |_, _| true)
        .assert_matches(name, PASSING, mean_error);
}

#[track_caller]
fn assert_shows(name: &str, film: &Film, radiance: impl Fn(Vec2) -> Vec3) {
    let exact = Estimate::exact((film.width, film.height), radiance);
    // Heights are compared over a fraction of a pixel: what rounding does to their difference is no error.
    let test = ZTest {
        rounding: 1.0e-3,
        ..ZTest::default()
    };
    test.compare(Estimate::from_film(film), exact, |_, _| true)
        .assert_matches(name, PASSING, MEAN_ERROR);
}

/// The squares of a board of `size` x `size` whose sum of column and row is even, if `even`, else the others.
fn board(corner: Vec3, u: Vec3, v: Vec3, size: u32, even: bool) -> Vec<engine::scene::Mesh> {
    let (u, v) = (u / size as f32, v / size as f32);
    let cells = (0..size * size).map(|i| (i % size, i / size));
    cells
        .filter(|(x, y)| ((x + y) % 2 == 0) == even)
        .map(|(x, y)| quad(corner + u * x as f32 + v * y as f32, u, v))
        .collect()
}

/// The board of these tests: above the floor, its front up.
const CORNER: Vec3 = Vec3::new(-0.5, 0.45, 0.5);
const U: Vec3 = Vec3::new(1.0, 0.1, 0.0);
const V: Vec3 = Vec3::new(0.0, 0.0, -1.0);
const SIZE: u32 = 4;

/// A grey room without walls: a floor, a lamp above it that shines down, and a little light from everywhere.
fn room() -> Scene {
    let lamp_quad = quad(Vec3::new(-0.4, 1.6, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8);
    scene(
        [
            (floor(3.0), lambert(Vec3::new(0.7, 0.6, 0.5))),
            (lamp_quad, lamp(Vec3::new(6.0, 5.0, 4.0))),
        ],
        Vec3::splat(0.2),
    )
}

fn oblique() -> Camera {
    camera(
        Vec3::new(0.3, 1.2, 2.2),
        Vec3::new(0.0, 0.25, 0.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 0.9 },
    )
}

const SHOT: Shot = Shot {
    size: (48, 48),
    max_depth: 4,
    spp: 256,
};

/// A ray that passes one surface tosses another coin at the next one.
#[test]
fn blends_behind_each_other_are_chosen_apart() {
    let Some(device) = device::open() else { return };
    let shot = Shot {
        size: (32, 32),
        max_depth: 2,
        spp: 2048,
    };
    for count in [1, 3] {
        let card = |i: i32| {
            let corner = Vec3::new(-1.0, 0.1 * i as f32, 1.0);
            let mesh = quad(corner, Vec3::X * 2.0, Vec3::NEG_Z * 2.0);
            (mesh, lambert(Vec3::ZERO))
        };
        let mut scene = scene((0..count).map(card), Vec3::ONE);
        scene.materials.push(Material {
            name: "hole".to_owned(),
            ..lambert(Vec3::ZERO)
        });
        let mut look = "[node.none]\ntexture='value'\nvalue=0.0\n[node.half]\ntexture='value'\nvalue=0.5\n[material.hole]\nopacity='none'\n".to_owned();
        for i in 0..count {
            look += &format!(
                "[material.'material {i}']\nblend={{ base='material {i}', over='hole', mask='half' }}\n"
            );
        }
        let film = view(&device, &mut scene, &look, &from_above(2.0, 0.5), shot);
        let expected = Vec3::splat(0.5_f32.powi(count));
        assert_shows(&format!("{count} cards"), &film, |_| expected);
    }
}

#[test]
fn every_input_can_be_driven() {
    let Some(device) = device::open() else { return };
    // Other keys that the input needs to be seen, the input, its value for the file, and for the node.
    let cases = [
        ("", "base_color", "[0.3, 0.6, 0.9]", "[0.3, 0.6, 0.9]"),
        ("", "metallic", "0.7", "[0.7, 0.7, 0.7]"),
        ("metallic=1.0", "roughness", "0.4", "[0.4, 0.4, 0.4]"),
        ("", "emission", "[1.0, 0.5, 0.2]", "[1.0, 0.5, 0.2]"),
        (
            "emission=[1.0, 0.5, 0.2]",
            "emission_strength",
            "3.0",
            "[3.0, 3.0, 3.0]",
        ),
        ("", "opacity", "0.6", "[0.6, 0.6, 0.6]"),
        ("roughness=0.2", "specular", "0.3", "[0.3, 0.3, 0.3]"),
        (
            "roughness=0.2",
            "specular_color",
            "[0.2, 0.5, 1.0]",
            "[0.2, 0.5, 1.0]",
        ),
        ("roughness=0.2", "ior", "2.2", "[2.2, 2.2, 2.2]"),
        ("roughness=0.3", "transmission", "0.8", "[0.8, 0.8, 0.8]"),
        (
            "roughness=0.3\ntransmission=1.0\nsolid=true",
            "ior",
            "1.3",
            "[1.3, 1.3, 1.3]",
        ),
        ("", "diffuse_transmission", "0.5", "[0.5, 0.5, 0.5]"),
        (
            "diffuse_transmission=0.5",
            "diffuse_transmission_color",
            "[0.1, 0.8, 0.3]",
            "[0.1, 0.8, 0.3]",
        ),
        ("", "coat", "0.8", "[0.8, 0.8, 0.8]"),
        ("coat=1.0", "coat_roughness", "0.5", "[0.5, 0.5, 0.5]"),
        (
            "sheen_roughness=0.5",
            "sheen_color",
            "[0.8, 0.3, 0.1]",
            "[0.8, 0.3, 0.1]",
        ),
        (
            "sheen_color=[0.8, 0.3, 0.1]",
            "sheen_roughness",
            "0.7",
            "[0.7, 0.7, 0.7]",
        ),
        (
            "metallic=1.0\nroughness=0.3",
            "anisotropy",
            "0.8",
            "[0.8, 0.8, 0.8]",
        ),
        (
            "metallic=1.0\nroughness=0.3\nanisotropy=0.8",
            "anisotropy_rotation",
            "30.0",
            "[30.0, 0.0, 0.0]",
        ),
        (
            "metallic=1.0\nroughness=0.3",
            "iridescence",
            "0.8",
            "[0.8, 0.8, 0.8]",
        ),
        (
            "metallic=1.0\niridescence=1.0",
            "iridescence_thickness",
            "350.0",
            "[350.0, 350.0, 350.0]",
        ),
    ];
    let camera = camera(
        Vec3::new(0.5, 1.5, 3.0),
        Vec3::ZERO,
        Vec3::Y,
        Projection::Perspective { y_fov: 0.8 },
    );
    let shot = Shot {
        size: (20, 20),
        max_depth: 4,
        spp: 64,
    };
    let room = || {
        let ball = Material {
            metallic: 0.0,
            base_color: Vec3::splat(0.6).extend(1.0),
            ..Material::default()
        };
        let lamp_quad = quad(Vec3::new(-1.0, 2.5, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0);
        scene(
            [
                (faceted_sphere(16), ball),
                (lamp_quad, lamp(Vec3::splat(4.0))),
            ],
            Vec3::new(0.2, 0.3, 0.5),
        )
    };
    for (others, key, constant, driven) in cases {
        let picture = |value: &str| {
            let look = format!(
                "[node.n]\ntexture='three'\nvalue={driven}\n[material.'material 0']\n{others}\n{key}={value}\n"
            );
            view(&device, &mut room(), &look, &camera, shot)
        };
        let is_color = ["color", "emission"].iter().any(|end| key.ends_with(end));
        let link = if is_color { "'n'" } else { "'n.x'" };
        let (tested, reference) = (picture(link), picture(constant));
        // The key matters at all: without it the picture is another one.
        let plain = view(
            &device,
            &mut room(),
            &format!("[material.'material 0']\n{others}\n"),
            &camera,
            shot,
        );
        let difference = |a: &Film, b: &Film| -> f32 {
            let pairs = a.mean().into_iter().zip(b.mean());
            pairs
                .map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f32>())
                .sum()
        };
        let (same, other) = (
            difference(&tested, &reference),
            difference(&plain, &reference),
        );
        assert!(
            same < 0.5 * other,
            "{key}: {same} from the constant, {other} from nothing"
        );
        assert_same(key, &tested, &reference, 0.01);
    }
}

#[test]
fn an_opacity_of_squares_is_squares() {
    let Some(device) = device::open() else { return };
    let surface = Material {
        double_sided: true,
        roughness: 0.4,
        ..lambert(Vec3::new(0.2, 0.5, 0.8))
    };
    let mut textured_room = room();
    add(&mut textured_room, quad(CORNER, U, V), surface.clone());
    let look = format!(
        "[node.squares]\ntexture='squares'\nsize={SIZE}.0\nhigh=1.0\nlow=0.0\n[material.'material 2']\nopacity='squares'\n"
    );
    let tested = view(&device, &mut textured_room, &look, &oblique(), SHOT);

    let mut built_room = room();
    for square in board(CORNER, U, V, SIZE, true) {
        add(&mut built_room, square, surface.clone());
    }
    let reference = view(&device, &mut built_room, "", &oblique(), SHOT);
    assert_same("opacity of squares", &tested, &reference, MEAN_ERROR);
}

#[test]
fn an_unlit_surface_shows_no_less_than_nothing() {
    let Some(device) = device::open() else { return };
    let mut scene = scene([(floor(9.0), unlit(Vec4::ONE))], Vec3::ZERO);
    let look = "[node.n]\ntexture='three'\nvalue=[0.5, -0.001, 0.25]\n[material.'material 0']\nbase_color='n'\n";
    let film = view(&device, &mut scene, look, &from_above(1.0, 0.5), SHOT);
    for pixel in film.mean() {
        let off = (Vec3::from(pixel) - Vec3::new(0.5, 0.0, 0.25)).abs();
        assert!(off.max_element() < 1e-3, "{pixel:?}");
    }
}

#[test]
fn an_emission_of_squares_is_lamps() {
    let Some(device) = device::open() else { return };
    let dark = || {
        scene(
            [(floor(3.0), lambert(Vec3::new(0.7, 0.6, 0.5)))],
            Vec3::splat(0.05),
        )
    };
    let black = Material {
        double_sided: true,
        ..lambert(Vec3::ZERO)
    };
    let glow = Vec3::new(4.0, 2.0, 1.0);
    let shot = Shot { spp: 512, ..SHOT };
    let mut textured_room = dark();
    add(&mut textured_room, quad(CORNER, U, V), black.clone());
    let look = format!(
        "[node.squares]\ntexture='colored'\nsize={SIZE}.0\ncolor=[2.0, 1.0, 0.5]\n[material.'material 1']\nemission='squares'\nemission_strength=2.0\n"
    );
    let tested = view(&device, &mut textured_room, &look, &oblique(), shot);

    let mut built_room = dark();
    for square in board(CORNER, U, V, SIZE, true) {
        let material = Material {
            emission: glow,
            ..black.clone()
        };
        add(&mut built_room, square, material);
    }
    for square in board(CORNER, U, V, SIZE, false) {
        add(&mut built_room, square, black.clone());
    }
    let reference = view(&device, &mut built_room, "", &oblique(), shot);
    assert_same("emission of squares", &tested, &reference, MEAN_ERROR);

    // Light samples evaluate the program: scattered rays alone would leave several times the noise.
    let noise = |film: &Film| -> f64 {
        let errors = film.standard_error();
        errors.iter().map(|e| f64::from(e[0])).sum::<f64>() / errors.len() as f64
    };
    let ratio = noise(&tested) / noise(&reference);
    assert!(ratio < 2.0, "{ratio} times the noise of sampled lamps");
}

#[test]
fn a_lamp_behind_its_own_and_others_opacity() {
    let Some(device) = device::open() else { return };
    // A lamp of half-there squares behind two screens of which each lets 40 % pass.
    let screen = |y: f32| quad(Vec3::new(-1.0, y, 1.0), Vec3::X * 2.0, Vec3::NEG_Z * 2.0);
    let glow = Material {
        double_sided: true,
        ..lamp(Vec3::new(3.0, 4.0, 5.0))
    };
    let black = Material {
        double_sided: true,
        ..lambert(Vec3::ZERO)
    };
    let shot = Shot {
        max_depth: 2,
        spp: 1024,
        ..SHOT
    };
    let room = |lamp: &Material, screen_material: &Material| {
        scene(
            [
                (floor(3.0), lambert(Vec3::new(0.7, 0.6, 0.5))),
                (screen(0.5), screen_material.clone()),
                (screen(0.6), screen_material.clone()),
                (quad(CORNER + Vec3::Y * 0.6, U, V), lamp.clone()),
            ],
            Vec3::splat(0.1),
        )
    };
    let look = "[node.half]\ntexture='value'\nvalue=0.5\n[node.most]\ntexture='value'\nvalue=0.6\n\
        [node.light]\ntexture='colored'\nsize=1.0\ncolor=[3.0, 4.0, 5.0]\n\
        [material.'material 1']\nopacity='most'\n[material.'material 2']\nopacity='most'\n\
        [material.'material 3']\nopacity='half'\nemission='light'\n";
    let tested = view(&device, &mut room(&glow, &black), look, &oblique(), shot);
    // The same by glTF's alpha, which needs no program.
    let alpha = |material: &Material, alpha: f32| Material {
        base_color: material.base_color.truncate().extend(alpha),
        alpha_mode: engine::scene::AlphaMode::Blend,
        ..material.clone()
    };
    let mut reference = room(&alpha(&glow, 0.5), &alpha(&black, 0.6));
    let reference = view(&device, &mut reference, "", &oblique(), shot);
    // Little light comes through: the means themselves have a standard error of 0.3 %.
    assert_same("opacity of lamp and screens", &tested, &reference, 0.012);
}

/// Its back doesn't say that a path was in it, either.
#[test]
fn a_body_whose_surface_is_not_there_absorbs_nothing() {
    let Some(device) = device::open() else { return };
    let mut glass = Material {
        transmission: 1.0,
        is_solid: true,
        metallic: 0.0,
        roughness: 0.0,
        ..Material::default()
    };
    glass.attenuate(Vec3::new(0.5, 0.25, 0.1), 0.5);
    let mut scene = scene([(faceted_sphere(12), glass)], Vec3::ONE);
    let look = "[node.none]\ntexture='value'\nvalue=0.0\n[material.'material 0']\nopacity='none'\n";
    let film = view(&device, &mut scene, look, &from_above(0.5, 2.0), SHOT);
    assert_shows("a body that isn't there", &film, |_| Vec3::ONE);
}

#[test]
fn nested_blends_mix_opacity_and_emission() {
    let Some(device) = device::open() else { return };
    // 0.5 A + 0.5 (0.75 B + 0.25 C): A is a screen that is 0.2 there, B glows, C is black and there.
    let mut scene = scene(
        [(floor(1.0), lambert(Vec3::ZERO))],
        Vec3::new(1.0, 2.0, 3.0),
    );
    let look = "[node.some]\ntexture='value'\nvalue=0.2\n[node.quarter]\ntexture='value'\nvalue=0.25\n\
        [node.light]\ntexture='colored'\nsize=1.0\ncolor=[8.0, 4.0, 2.0]\n\
        [material.'material 0']\nblend={base='A', over='BC', mask=0.5}\n\
        [material.BC]\nblend={base='B', over='C', mask='quarter'}\n\
        [material.A]\nbase_color=[0,0,0]\nspecular=0.0\nopacity='some'\n\
        [material.B]\nbase_color=[0,0,0]\nspecular=0.0\nemission='light'\n\
        [material.C]\nbase_color=[0,0,0]\nspecular=0.0\n";
    let film = view(&device, &mut scene, look, &from_above(0.5, 0.5), SHOT);
    let expected = 0.5 * 0.8 * Vec3::new(1.0, 2.0, 3.0) + 0.5 * 0.75 * Vec3::new(8.0, 4.0, 2.0);
    assert_shows("nested blends", &film, |_| expected);
}

#[test]
fn opacity_may_depend_on_the_kind_of_ray() {
    let Some(device) = device::open() else { return };
    // Invisible to the camera, but it keeps the lamp's light from the floor.
    let mut room = scene([(floor(3.0), lambert(Vec3::ONE))], Vec3::ZERO);
    room.lights.push(sun(Vec3::NEG_Y));
    add(
        &mut room,
        quad(Vec3::new(0.0, 0.2, 1.0), Vec3::X, Vec3::NEG_Z * 2.0),
        Material {
            double_sided: true,
            ..lambert(Vec3::ONE)
        },
    );
    let look = "[node.kind]\ntexture='shadow_only'\n[material.'material 1']\nopacity='kind'\n";
    let shot = Shot {
        max_depth: 1,
        ..SHOT
    };
    let film = view(&device, &mut room, look, &from_above(0.5, 1.0), shot);
    assert_shows("a screen for shadow rays", &film, |picture| {
        let lit = floor_point(1.0, picture).x < 0.0;
        Vec3::splat(if lit { 1.0 / PI } else { 0.0 })
    });
}

/// Light of 1 W/m² from infinitely far away.
fn sun(direction: Vec3) -> PunctualLight {
    PunctualLight {
        name: "sun".to_owned(),
        intensity: Vec3::ONE,
        position: Vec3::ZERO,
        direction: direction.normalize(),
        range: f32::INFINITY,
        kind: LightKind::Directional,
    }
}

/// A white floor under a sun, seen from above; direct light only.
fn sunlit(device: &Device, direction: Vec3, look: &str) -> Film {
    let mut room = scene([(floor(2.0), lambert(Vec3::ONE))], Vec3::ZERO);
    room.lights.push(sun(direction));
    let shot = Shot {
        size: (32, 32),
        max_depth: 1,
        spp: 64,
    };
    view(device, &mut room, look, &from_above(1.0, 1.0), shot)
}

#[test]
fn a_driven_normal_shades_as_it_says() {
    let Some(device) = device::open() else { return };
    let look = |tilt: f32| {
        format!("[node.n]\ntexture='tilted'\ntilt={tilt:?}\n[material.'material 0']\nnormal='n'\n")
    };
    let from = Vec3::new(1.0, 1.0, 0.0);
    for tilt in [0.0_f32, 0.3, -0.5] {
        let film = sunlit(&device, -from, &look(tilt));
        let normal = Vec3::new(tilt.sin(), tilt.cos(), 0.0);
        let expected = normal.dot(from.normalize()) / PI;
        assert_shows("tilted normal", &film, |_| Vec3::splat(expected));
    }
}

#[test]
fn a_bump_leans_the_normal_against_its_slope() {
    let Some(device) = device::open() else { return };
    let from = Vec3::new(1.0, 1.5, 0.5);
    // A ramp over the floor's 4 metres of uv: v runs along -z.
    let (along_u, along_v) = (2.0, -1.0);
    let look = format!(
        "[node.h]\ntexture='slope'\nslope=[{along_u:?}, {along_v:?}]\n[material.'material 0']\nbump='h'\nbump_scale=0.5\n"
    );
    let film = sunlit(&device, -from, &look);
    let normal = Vec3::new(-0.5 * along_u / 4.0, 1.0, 0.5 * along_v / 4.0).normalize();
    let expected = normal.dot(from.normalize()) / PI;
    assert_shows("constant slope", &film, |_| Vec3::splat(expected));

    // Waves: the slope at a point is the height's derivative.
    let (height, length) = (0.05, 0.8);
    let look = format!(
        "[node.h]\ntexture='waves'\nheight={height:?}\nlength={length:?}\n[material.'material 0']\nbump='h'\n"
    );
    let film = sunlit(&device, -from, &look);
    assert_shows("waves", &film, |picture| {
        let phase = 2.0 * PI / length;
        let slope = height * phase * (phase * floor_point(1.0, picture).x).cos();
        let normal = Vec3::new(-slope, 1.0, 0.0).normalize();
        Vec3::splat(normal.dot(from.normalize()).max(0.0) / PI)
    });
}

#[test]
fn bumps_are_as_high_far_from_the_origin() {
    let Some(device) = device::open() else { return };
    let look =
        "[node.h]\ntexture='waves'\nheight=0.002\nlength=0.05\n[material.'material 0']\nbump='h'\n";
    let seen = |away: Vec3| {
        let mut room = scene([(floor(2.0), lambert(Vec3::ONE))], Vec3::ZERO);
        room.instances[0].transform = Affine3A::from_translation(away);
        room.lights.push(sun(-Vec3::new(1.0, 1.5, 0.5)));
        let mut camera = from_above(1.0, 0.05);
        camera.transform = Affine3A::from_translation(away) * camera.transform;
        let shot = Shot {
            size: (32, 32),
            max_depth: 1,
            spp: 16,
        };
        view(&device, &mut room, look, &camera, shot).mean()
    };
    let (near, far) = (seen(Vec3::ZERO), seen(Vec3::X * 100.0));
    let middle = near.iter().map(|p| p[1]).sum::<f32>() / near.len() as f32;
    let relief: f32 = near.iter().map(|p| (p[1] - middle).abs()).sum();
    let off: f32 = (near.iter().zip(&far))
        .map(|(a, b)| (a[1] - b[1]).abs())
        .sum();
    assert!(relief > 0.02 * near.len() as f32, "{relief}");
    assert!(off < 0.05 * relief, "{off} of {relief}");
}

/// A white floor whose front faces down, so that a camera above it sees the back.
fn from_behind() -> Scene {
    let mut room = scene([], Vec3::ZERO);
    let mut sheet = floor(2.0);
    sheet.triangles = vec![[0, 2, 1], [0, 3, 2]];
    sheet.normals = vec![Vec3::NEG_Y; 4];
    add(
        &mut room,
        sheet,
        Material {
            double_sided: true,
            ..lambert(Vec3::ONE)
        },
    );
    room
}

#[test]
fn a_bump_seen_from_the_back_is_a_dent() {
    let Some(device) = device::open() else { return };
    // Hills of the front are valleys here.
    let mut room = from_behind();
    let from = Vec3::new(1.0, 1.5, 0.0);
    room.lights.push(sun(-from));
    let look = "[node.h]\ntexture='slope'\nslope=[1.0, 0.0]\n[material.'material 0']\nbump='h'\n";
    let shot = Shot {
        size: (16, 16),
        max_depth: 1,
        spp: 64,
    };
    let film = view(&device, &mut room, look, &from_above(1.0, 1.0), shot);
    let normal = Vec3::new(0.25, 1.0, 0.0).normalize();
    let expected = normal.dot(from.normalize()) / PI;
    assert_shows("bump from behind", &film, |_| Vec3::splat(expected));
}

#[test]
fn a_normal_map_seen_from_the_back_leans_the_other_way() {
    let Some(device) = device::open() else { return };
    let from = Vec3::new(1.0, 1.5, 0.5);
    let look =
        "[node.n]\ntexture='leaning'\nlean=[0.5, 0.25, 1.0]\n[material.'material 0']\nnormal='n'\n";
    let shot = Shot {
        size: (16, 16),
        max_depth: 1,
        spp: 64,
    };
    // u runs along x, and up in the picture is along z. What leans there on the front is, from behind, the opposite of it.
    let front = Vec3::new(0.5, 1.0, 0.25).normalize();
    let back = Vec3::new(-0.5, 1.0, -0.25).normalize();
    let over = scene([(floor(2.0), lambert(Vec3::ONE))], Vec3::ZERO);
    for (mut room, normal) in [(over, front), (from_behind(), back)] {
        room.lights.push(sun(-from));
        let film = view(&device, &mut room, look, &from_above(1.0, 1.0), shot);
        let expected = normal.dot(from.normalize()) / PI;
        assert_shows("leaning normal", &film, |_| Vec3::splat(expected));
    }
}

#[test]
fn curvature_does_not_depend_on_the_triangles() {
    let Some(device) = device::open() else { return };
    let look = "[node.n]\ntexture='bend'\n[material.'material 0']\nemission='n'\n";
    let shot = Shot {
        size: (16, 16),
        max_depth: 1,
        spp: 16,
    };
    // Strips across a cylinder of radius 2 along z, wide and narrow.
    for (columns, rows) in [(4, 1), (4, 32), (10, 2)] {
        let point = |x: u32, y: u32| {
            let angle = 1.4 * (x as f32 / columns as f32 - 0.5);
            let normal = Vec3::new(angle.sin(), angle.cos(), 0.0);
            let along = Vec3::Z * (2.0 - 4.0 * y as f32 / rows as f32);
            (2.0 * (normal - Vec3::Y) + along, normal)
        };
        let mut hill = floor(1.0);
        (hill.positions, hill.normals) = (0..=rows)
            .flat_map(|y| (0..=columns).map(move |x| (x, y)))
            .map(|(x, y)| point(x, y))
            .unzip();
        hill.uv0 = Vec::new();
        hill.triangles = (0..rows)
            .flat_map(|y| (0..columns).map(move |x| y * (columns + 1) + x))
            .flat_map(|a| {
                let c = a + columns + 2;
                [[a, a + 1, c], [a, c, c - 1]]
            })
            .collect();
        hill.triangle_materials = vec![0; hill.triangles.len()];
        let mut room = scene([(hill, lambert(Vec3::ZERO))], Vec3::ZERO);
        let film = view(&device, &mut room, look, &from_above(1.0, 1.0), shot);
        assert_shows("curvature", &film, |_| Vec3::splat(0.25));
    }
}

/// Files' meshes are given tangents where something reads them; a kernel does without.
#[test]
fn a_triangle_knows_tangents_by_its_texture_coordinates() {
    let Some(device) = device::open() else {
        return;
    };
    let shot = Shot {
        size: (16, 12),
        max_depth: 2,
        spp: 4,
    };
    // v grows to the back, so that up in a picture is to the front.
    for (texture, color) in [("along", "[1.0, 0.5, 0.5]"), ("across", "[0.5, 0.5, 1.0]")] {
        let seen = |node: &str| {
            let look = format!("[node.n]\n{node}\n[material.'material 0']\nbase_color = 'n'\n");
            let mut scene = scene([(floor(1.0), lambert(Vec3::ONE))], Vec3::ONE);
            view(&device, &mut scene, &look, &oblique(), shot)
        };
        let read = seen(&format!("texture = '{texture}'"));
        let known = seen(&format!("texture = 'three'\nvalue = {color}"));
        assert!(read == known, "{texture}");
    }
}
