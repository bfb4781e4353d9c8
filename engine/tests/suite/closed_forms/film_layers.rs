//! Layers of the film: each against what is known of its scene, and with the same exactness as the picture.

use std::sync::Arc;

use ::device::Device;
use engine::film::ids::{Coverage, IDS};
use engine::film::{Film, Layer, Layers};
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::Renderer;
use engine::scene::{AlphaMode, Camera, Material, Projection, Scene};
use engine::settings::{Beside, RenderSettings};
use glam::{Affine3A, Vec2, Vec3};

use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, floor_point, from_above, lambert, lamp, no_textures, quad,
    scene, settings, textured, unlit,
};

const SHOT: Shot = Shot {
    size: (24, 24),
    max_depth: 2,
    spp: 16,
};

/// Paths of a wave: less than a sample of each pixel.
const SMALL: u32 = 320;

fn with_layers(camera: &Camera, shot: Shot, layers: &Layers) -> RenderSettings {
    RenderSettings {
        layers: layers.clone(),
        ..settings(camera, shot)
    }
}

fn film(
    device: &Device,
    scene: &Scene,
    procedural: &Procedural,
    settings: &RenderSettings,
    (capacity, spp): (u32, u32),
) -> Film {
    let renderer = Renderer::with_capacity(device, scene, procedural, settings, capacity);
    let mut renderer = renderer.unwrap_or_else(|error| panic!("{error}"));
    let rendered = renderer.render(spp).and_then(|()| renderer.film());
    rendered.unwrap_or_else(|error| panic!("{error}"))
}

/// All layers of a scene without textures.
fn seen(device: &Device, scene: &mut Scene, camera: &Camera, shot: Shot) -> Film {
    let procedural = no_textures(scene);
    let settings = with_layers(camera, shot, &Layers::all());
    film(device, scene, &procedural, &settings, (1 << 14, shot.spp))
}

fn values(film: &Film, name: &str) -> Vec<Vec3> {
    let layer = Layer::named(name).expect("there is such a layer");
    let values = film.values(layer).expect("it was asked for");
    values.into_iter().map(Vec3::from).collect()
}

fn mean(values: &[Vec3]) -> Vec3 {
    values.iter().sum::<Vec3>() / values.len() as f32
}

/// The middle of a pixel, in 0 to 1 from the upper left corner.
fn middle(film: &Film, pixel: usize) -> Vec2 {
    let (x, y) = (pixel as u32 % film.width, pixel as u32 / film.width);
    Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / Vec2::new(film.width as f32, film.height as f32)
}

#[test]
fn a_floor_from_above_is_known_in_all_layers() {
    let Some(device) = device::open() else { return };
    let (color, emission) = (Vec3::new(0.2, 0.4, 0.8), Vec3::new(3.0, 2.0, 1.0));
    let surface = Material {
        emission,
        ..lambert(color)
    };
    let mut scene = scene([(floor(2.0), surface)], Vec3::ONE);
    let film = seen(&device, &mut scene, &from_above(3.0, 1.0), SHOT);
    let near = |a: Vec3, b: Vec3, what: &str| assert!((a - b).length() < 1e-4, "{what}: {a} {b}");
    // Half a pixel, and the corner of it.
    let pixel = 1.0 / 24.0 * std::f32::consts::SQRT_2 + 1e-5;
    let positions = values(&film, "position");
    for (at, &position) in positions.iter().enumerate() {
        let expected = floor_point(1.0, middle(&film, at));
        assert!(
            (position - expected).length() < pixel,
            "{position} {expected}"
        );
        assert!(position.y.abs() < 1e-5);
        // The floor is four metres wide; its first corner is at the left and near the viewer, that is below.
        let uv = Vec3::new(
            (position.x + 2.0) / 4.0,
            1.0 - (2.0 - position.z) / 4.0,
            1.0,
        );
        near(values(&film, "uv")[at], uv, "uv");
    }
    for at in 0..film.pixels() {
        near(values(&film, "depth")[at], Vec3::X * 3.0, "depth");
        near(values(&film, "denoising_depth")[at], Vec3::X * 3.0, "depth");
        near(values(&film, "normal")[at], Vec3::Y, "normal");
        // It faces the camera.
        let normal = values(&film, "denoising_normal")[at];
        near(normal, Vec3::Z, "normal as the camera sees it");
        near(values(&film, "albedo")[at], color, "albedo");
        near(values(&film, "emission")[at], emission, "emission");
        near(values(&film, "samples")[at], Vec3::X * 16.0, "samples");
        let variance = film.standard_error()[at].map(|error| error * error);
        near(values(&film, "variance")[at], variance.into(), "variance");
        near(
            values(&film, "combined")[at],
            film.mean()[at].into(),
            "combined",
        );
    }
}

#[test]
fn depth_is_measured_from_the_plane_of_the_camera() {
    let Some(device) = device::open() else { return };
    let mut scene = scene([(floor(50.0), lambert(Vec3::ONE))], Vec3::ONE);
    let perspective = Projection::Perspective { y_fov: 1.0 };
    // Straight down, all of a floor is as far away.
    let down = camera(Vec3::Y * 4.0, Vec3::ZERO, Vec3::NEG_Z, perspective);
    let film = seen(&device, &mut scene, &down, SHOT);
    for depth in values(&film, "depth") {
        assert!((depth.x - 4.0).abs() < 1e-4, "{depth}");
    }
    // Seen along it, it is as far as the place of the same sample says; the sky is beyond everything.
    let eye = Vec3::new(0.0, 1.0, 8.0);
    let along = camera(eye, Vec3::new(0.0, 1.0, 0.0), Vec3::Y, perspective);
    let film = seen(&device, &mut scene, &along, SHOT);
    let (depths, positions) = (values(&film, "depth"), values(&film, "position"));
    for (at, (depth, position)) in depths.iter().zip(positions).enumerate() {
        match middle(&film, at).y < 0.45 {
            true => assert_eq!((depth.x, position), (1e10, Vec3::ZERO)),
            false if middle(&film, at).y > 0.55 => {
                let expected = eye.z - position.z;
                assert!(
                    (depth.x - expected).abs() < 1e-3 * expected,
                    "{depth} {expected}"
                );
            }
            false => {}
        }
    }
    let normals = values(&film, "normal");
    assert_eq!(normals[0], Vec3::ZERO, "the sky has none");
    assert!((normals[film.pixels() - 1] - Vec3::Y).length() < 1e-4);
}

#[test]
fn what_a_path_passes_is_not_its_first_surface() {
    let Some(device) = device::open() else { return };
    let shot = Shot { spp: 256, ..SHOT };
    let (above, below) = (Vec3::new(0.9, 0.1, 0.5), Vec3::new(0.1, 0.8, 0.2));
    let roof = || quad(Vec3::new(-2.0, 1.0, 2.0), Vec3::X * 4.0, Vec3::NEG_Z * 4.0);
    let veil = Material {
        alpha_mode: AlphaMode::Blend,
        ..unlit(above.extend(0.3))
    };
    let pane = Material {
        base_color: Vec3::ONE.extend(1.0),
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        double_sided: true,
        ..Material::default()
    };
    // A pane of glass reflects a twenty-fifth straight on, and lets the rest pass.
    for (what, material, own, share) in
        [("veil", veil, above, 0.3), ("pane", pane, Vec3::ONE, 0.04)]
    {
        let objects = [(floor(2.0), lambert(below)), (roof(), material)];
        let mut scene = scene(objects, Vec3::ONE);
        let film = seen(&device, &mut scene, &from_above(3.0, 1.0), shot);
        let expected = own * share + below * (1.0 - share);
        let albedo = mean(&values(&film, "albedo"));
        // Of 576 pixels with 256 samples each, six deviations of whether a path passes.
        assert!(
            (albedo - expected).length() < 0.012,
            "{what}: {albedo} {expected}"
        );
        let depths = values(&film, "depth");
        let of_floor = depths.iter().filter(|d| (d.x - 3.0).abs() < 1e-4).count();
        let of_roof = depths.iter().filter(|d| (d.x - 2.0).abs() < 1e-4).count();
        assert_eq!(of_floor + of_roof, depths.len(), "{what}: one or the other");
        let part = of_roof as f32 / depths.len() as f32;
        // One sample of each pixel, four deviations.
        assert!(
            (part - share).abs() < 4.0 * (share / 576.0).sqrt(),
            "{what}: {part}"
        );
    }
}

#[test]
fn textures_are_part_of_what_is_seen() {
    let Some(device) = device::open() else { return };
    let mut scene = scene([(floor(2.0), lambert(Vec3::ONE))], Vec3::ONE);
    let mut sources = TextureSources::default();
    let text = "fn userProc(value: vec3f) -> vec3f { return value; }";
    sources.insert("three", text);
    let name = scene.materials[0].name.clone();
    let look = format!(
        "[node.color]\ntexture = \"three\"\nvalue = [0.25, 0.5, 0.75]\n\
         [node.light]\ntexture = \"three\"\nvalue = [4.0, 5.0, 6.0]\n\
         [material.\"{name}\"]\nbase_color = \"color\"\nemission = \"light\"\n"
    );
    let procedural = textured(&mut scene, &look, &sources);
    let settings = with_layers(&from_above(3.0, 1.0), SHOT, &Layers::all());
    let film = film(&device, &scene, &procedural, &settings, (1 << 14, 4));
    for (name, expected) in [
        ("albedo", Vec3::new(0.25, 0.5, 0.75)),
        ("emission", Vec3::new(4.0, 5.0, 6.0)),
    ] {
        let values = values(&film, name);
        let is_right = |value: &Vec3| (*value - expected).length() < 1e-5;
        assert!(values.iter().all(is_right), "{name}: {}", values[0]);
    }
}

#[test]
fn motion_is_counted_in_pixels_of_the_picture() {
    let Some(device) = device::open() else { return };
    let mut scene = scene([(floor(3.0), lambert(Vec3::ONE))], Vec3::ONE);
    let procedural = no_textures(&mut scene);
    // At the floor it sees as much as from_above(3.0, 1.0).
    let y_fov = 2.0 * (1.0_f32 / 3.0).atan();
    let camera = camera(
        Vec3::Y * 3.0,
        Vec3::ZERO,
        Vec3::NEG_Z,
        Projection::Perspective { y_fov },
    );
    let layers = Layers::named(["vector"]).expect("known");
    let of = |beside: Option<Beside>| {
        let settings = RenderSettings {
            beside: beside.map(Arc::new),
            ..with_layers(&camera, SHOT, &layers)
        };
        let film = film(&device, &scene, &procedural, &settings, (1 << 14, 4));
        let [since, until] = ["vector", "vector_next"].map(|name| values(&film, name));
        let pairs = since.into_iter().zip(until);
        pairs
            .map(|(since, until)| [since.truncate(), until.truncate()])
            .collect::<Vec<_>>()
    };
    let moved = |camera: &Camera, by: Vec3| Camera {
        transform: Affine3A::from_translation(by) * camera.transform,
        ..camera.clone()
    };
    let at = |by: Vec3| vec![Affine3A::from_translation(by)];
    // Two metres are 24 pixels wide; the picture's upper edge lies towards -z.
    let metre = 12.0;
    let (left, up) = (Vec3::new(-0.25, 0.0, 0.0), Vec3::new(0.0, 0.0, -0.5));
    let both = |by: Vec3| [moved(&camera, Vec3::ZERO), moved(&camera, by)];
    let near = |found: Vec2, expected: Vec2| {
        assert!((found - expected).length() < 1e-3, "{found} {expected}")
    };
    for [since, until] in of(Some(Beside {
        cameras: both(Vec3::ZERO),
        transforms: [at(left), at(up)],
        positions: Default::default(),
    })) {
        near(since, Vec2::new(-0.25, 0.0) * metre);
        near(until, Vec2::new(0.0, -0.5) * metre);
    }
    // What the camera follows stands still.
    for [since, until] in of(Some(Beside {
        cameras: both(up),
        transforms: [at(Vec3::ZERO), at(up)],
        positions: Default::default(),
    })) {
        assert_eq!((since, until.length() < 1e-3), (Vec2::ZERO, true));
    }
    // Of what turns about the middle each point has its own way; what comes nearer, moves away from it.
    let turned = vec![Affine3A::from_rotation_y(0.1)];
    let nearer = at(Vec3::Y * 1.0);
    let found = of(Some(Beside {
        cameras: both(Vec3::ZERO),
        transforms: [turned, nearer],
        positions: Default::default(),
    }));
    let positions = {
        let settings = with_layers(&camera, SHOT, &Layers::named(["position"]).expect("known"));
        values(
            &film(&device, &scene, &procedural, &settings, (1 << 14, 4)),
            "position",
        )
    };
    for ([since, until], &p) in found.into_iter().zip(&positions) {
        let place = |p: Vec3| Vec2::new(p.x, -p.z) * metre;
        let was = glam::Quat::from_rotation_y(0.1) * p;
        near(since, place(was) - place(p));
        near(until, place(p) - place(p) * 1.5);
    }
    // A mesh that bends: each point has been elsewhere on the floor, and will be farther out.
    let bent = |to: &dyn Fn(Vec3) -> Vec3| {
        let mesh = scene.meshes[0].positions.iter();
        vec![mesh.map(|&p| to(p)).collect::<Vec<_>>()]
    };
    let sheared = |p: Vec3| p + Vec3::X * (0.1 * p.z);
    let found = of(Some(Beside {
        cameras: both(Vec3::ZERO),
        transforms: [at(Vec3::ZERO), at(up)],
        positions: [bent(&sheared), bent(&|p| 1.25 * p)],
    }));
    for ([since, until], p) in found.into_iter().zip(&positions) {
        let place = |p: Vec3| Vec2::new(p.x, -p.z) * metre;
        near(since, place(sheared(*p)) - place(*p));
        near(until, place(*p) - place(1.25 * *p + up));
    }
    for still in [
        None,
        Some(Beside {
            cameras: both(Vec3::ZERO),
            transforms: [at(Vec3::ZERO), at(Vec3::ZERO)],
            positions: Default::default(),
        }),
    ] {
        assert!(of(still).iter().all(|motion| *motion == [Vec2::ZERO; 2]));
    }
}

/// A floor, half of it of a material whose blend and bump have nodes, and a lamp that has none of them.
fn with_nodes() -> (Scene, Procedural) {
    let half = |at: f32| quad(Vec3::new(at, 0.0, 2.0), Vec3::X * 2.0, Vec3::NEG_Z * 4.0);
    let objects = [
        (half(-2.0), lambert(Vec3::ONE)),
        (half(0.0), lambert(Vec3::ONE)),
    ];
    let mut scene = scene(objects, Vec3::ONE);
    scene.materials[0].name = "Left".to_owned();
    scene.materials[1].name = "Right".to_owned();
    let mut sources = TextureSources::default();
    sources.insert("one", "fn userProc(value: f32) -> f32 { return value; }");
    sources.insert(
        "place",
        "fn userProc(scale: f32) -> vec3f { return readAttr(WorldPos).xyz * scale; }",
    );
    sources.insert(
        "four",
        "fn userProc(at: vec3f) -> vec4f { return vec4f(at.zyx, 0.5); }",
    );
    let look = "
        [node.mask]
        texture = \"one\"
        value = 0.25
        [node.place]
        texture = \"place\"
        scale = 2.0
        [node.turned]
        texture = \"four\"
        at = \"place\"
        [node.height]
        texture = \"one\"
        value = 0.125
        [node.idle]
        texture = \"one\"
        value = 9.0
        [material.Over]
        roughness = \"turned.w\"
        bump = \"height\"
        [material.Left]
        blend = { base = \"Left\", over = \"Over\", mask = \"mask\" }";
    let procedural = textured(&mut scene, look, &sources);
    (scene, procedural)
}

#[test]
fn values_of_nodes_are_layers_where_their_material_is_seen() {
    let Some(device) = device::open() else { return };
    let (scene, procedural) = with_nodes();
    let nodes = ["turned", "place", "mask", "height", "idle"].map(|node| format!("node:{node}"));
    let layers = Layers::named(nodes.iter().map(String::as_str)).expect("known");
    let shot = Shot { spp: 256, ..SHOT };
    let settings = with_layers(&from_above(3.0, 1.0), shot, &layers);
    let shown = film(&device, &scene, &procedural, &settings, (1 << 14, shot.spp));
    let of = |node: &str| {
        let own = shown
            .layers()
            .iter()
            .filter(|layer| shown.layers().name_of(layer) == format!("node:{node}"));
        let values: Vec<_> = own
            .map(|layer| shown.values(layer).expect("gathered"))
            .collect();
        let [rgb, alpha] = &values[..] else {
            panic!("two layers")
        };
        let rgba = rgb
            .iter()
            .zip(alpha)
            .map(|(rgb, a)| Vec3::from(*rgb).extend(a[0]));
        rgba.collect::<Vec<_>>()
    };
    for pixel in 0..shown.pixels() {
        let at = middle(&shown, pixel);
        let point = floor_point(1.0, at) * 2.0;
        // Samples are anywhere in the pixel, evenly; and a fourth of them meets what lies over the other.
        let near = |node: &str, expected: glam::Vec4, error: f32| {
            let found = of(node)[pixel];
            assert!(
                (found - expected).length() < error,
                "{node} {at}: {found} {expected}"
            );
        };
        let (share, noise) = (0.25, 6.0 * (0.25_f32 * 0.75 / 256.0).sqrt());
        let seen = if at.x < 0.5 { 1.0 } else { 0.0 };
        near("mask", glam::Vec4::splat(0.25) * seen, 1e-4);
        near(
            "height",
            glam::Vec4::splat(0.125 * share) * seen,
            0.125 * 2.0 * noise * seen + 1e-6,
        );
        let largest = point.length() + 1.0;
        near(
            "place",
            point.extend(1.0) * share * seen,
            noise * largest * seen + 1e-6,
        );
        let turned = Vec3::new(point.z, point.y, point.x).extend(0.5);
        near(
            "turned",
            turned * share * seen,
            noise * largest * seen + 1e-6,
        );
        near("idle", glam::Vec4::ZERO, 1e-6);
    }
    // The picture is what it is without them, and parts are as exact.
    let alone = RenderSettings {
        layers: Layers::default(),
        ..settings.clone()
    };
    let alone = film(&device, &scene, &procedural, &alone, (1 << 14, shot.spp));
    assert_eq!(alone.mean(), shown.mean());
    let mut merged = Film::with_layers(shown.width, shown.height, layers);
    for (first_sample, cut) in [(56, (SMALL, 200)), (0, (1 << 14, 56))] {
        let settings = RenderSettings {
            first_sample,
            ..settings.clone()
        };
        merged.add(&film(&device, &scene, &procedural, &settings, cut));
    }
    assert!(merged == shown, "merged");
}

#[test]
fn a_node_that_is_not_there_is_named_with_its_neighbour() {
    let Some(device) = device::open() else { return };
    let (scene, procedural) = with_nodes();
    let layers = Layers::named(["node:turn"]).expect("any name");
    let settings = with_layers(&from_above(3.0, 1.0), SHOT, &layers);
    let error = Renderer::new(&device, &scene, &procedural, &settings).expect_err("no such node");
    let error = error.to_string();
    assert!(
        error.contains("`turn`") && error.contains("did you mean"),
        "{error}"
    );
}

/// Something in front of a sky, with edges, light and a veil.
fn varied() -> (Scene, Camera) {
    let veil = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: Vec3::new(0.9, 0.3, 0.1).extend(0.5),
        ..lambert(Vec3::ONE)
    };
    let objects = [
        (floor(3.0), lambert(Vec3::splat(0.7))),
        (faceted_sphere(8), lambert(Vec3::new(0.3, 0.6, 0.9))),
        (
            quad(Vec3::new(-0.5, 3.0, -0.5), Vec3::X, Vec3::Z),
            lamp(Vec3::splat(6.0)),
        ),
        (
            quad(Vec3::new(-2.0, 0.0, 1.5), Vec3::X * 2.0, Vec3::Y),
            veil,
        ),
    ];
    let perspective = Projection::Perspective { y_fov: 0.9 };
    let eye = Vec3::new(0.5, 2.0, 5.0);
    (
        scene(objects, Vec3::new(0.1, 0.2, 0.3)),
        camera(eye, Vec3::Y * 0.3, Vec3::Y, perspective),
    )
}

#[test]
fn layers_are_as_exact_as_the_picture_and_do_not_change_it() {
    let Some(device) = device::open() else { return };
    let (mut scene, camera) = varied();
    let procedural = no_textures(&mut scene);
    let shot = Shot {
        size: (37, 21),
        ..SHOT
    };
    for filter in [
        engine::filter::PixelFilter::Box,
        engine::filter::PixelFilter::Mitchell,
    ] {
        let of = |layers: &Layers, first_sample, cut| {
            let settings = RenderSettings {
                first_sample,
                filter,
                filter_width: filter.default_width(),
                ..with_layers(&camera, shot, layers)
            };
            film(&device, &scene, &procedural, &settings, cut)
        };
        let whole = of(&Layers::all(), 0, (1 << 16, 12));
        assert!(whole == of(&Layers::all(), 0, (SMALL, 12)), "smaller waves");
        let alone = of(&Layers::default(), 0, (1 << 16, 12));
        assert_eq!(alone.mean(), whole.mean());
        assert_eq!(alone.standard_error(), whole.standard_error());
        // A layer is what it is with all others.
        let few = of(
            &Layers::named(["normal", "uv"]).expect("known"),
            0,
            (1 << 14, 12),
        );
        for layer in few.layers().iter() {
            assert_eq!(few.values(layer), whole.values(layer), "{}", layer.name);
        }
        // Parts in any order.
        let mut merged = Film::with_layers(whole.width, whole.height, Layers::all());
        for (first, cut) in [(7, (640, 5)), (0, (1 << 14, 1)), (1, (SMALL, 6))] {
            assert!(merged != whole);
            merged.add(&of(&Layers::all(), first, cut));
        }
        assert!(merged == whole, "merged");
    }
}

#[test]
fn layers_follow_a_render_that_begins_anew() {
    let Some(device) = device::open() else { return };
    let (mut scene, camera) = varied();
    let procedural = no_textures(&mut scene);
    let settings = with_layers(&camera, SHOT, &Layers::all());
    let mut renderer =
        Renderer::new(&device, &scene, &procedural, &settings).unwrap_or_else(|e| panic!("{e}"));
    let mut film = || {
        let rendered = renderer.render(3).and_then(|()| renderer.film());
        let film = rendered.unwrap_or_else(|error| panic!("{error}"));
        renderer.restart();
        let empty = renderer.film().unwrap_or_else(|error| panic!("{error}"));
        let fresh = Film::with_layers(film.width, film.height, Layers::all());
        assert!(empty == fresh, "nothing is left");
        film
    };
    assert!(film() == film());
}

/// Stripes side by side, each with a name of its own, and nothing to their right.
fn stripes(names: &[String], width: f32) -> Scene {
    let stripe = |at: usize| {
        let left = Vec3::new(-1.0 + width * at as f32, 0.0, 1.0);
        let stripe = quad(left, Vec3::X * width, Vec3::NEG_Z * 2.0);
        (stripe, lambert(Vec3::splat(0.5)))
    };
    let mut scene = scene((0..names.len()).map(stripe), Vec3::ONE);
    for (instance, name) in scene.instances.iter_mut().zip(names) {
        instance.name.clone_from(name);
    }
    // But for the first two they hang in pairs below nodes.
    for (at, instance) in scene.instances.iter_mut().enumerate().skip(2) {
        instance.asset = Some(format!("pair {}", at / 2).into());
    }
    // Two stripes are of one material each.
    for (at, material) in scene.materials.iter_mut().enumerate() {
        material.name = format!("of {}", at / 2);
    }
    scene
}

fn covered(film: &Film, layer: &str) -> Vec<[Coverage; IDS]> {
    let layer = Layer::named(layer).expect("there is such a layer");
    film.coverage(layer).expect("it was asked for")
}

#[test]
fn ids_cover_what_they_are_known_to_cover() {
    let Some(device) = device::open() else { return };
    // Five stripes across the left eight tenths of four pixels: their edges lie within pixels.
    let names: Vec<String> = (0..5).map(|i| format!("stripe {i}")).collect();
    let width = 1.6 / 5.0;
    let mut scene = stripes(&names, width);
    let shot = Shot {
        size: (4, 4),
        max_depth: 1,
        spp: 1024,
    };
    let film = seen(&device, &mut scene, &from_above(3.0, 1.0), shot);
    let share = |stripe: usize, column: usize| {
        let (left, right) = (0.5 * column as f32, 0.5 * (column + 1) as f32);
        let (from, to) = (width * stripe as f32, width * (stripe + 1) as f32);
        ((to.min(right) - from.max(left)) / 0.5).max(0.0)
    };
    for (pixel, found) in covered(&film, "crypto_object").iter().enumerate() {
        assert!(found.is_sorted_by(|a, b| a.share >= b.share), "by rank");
        for (stripe, name) in names.iter().enumerate() {
            let id = engine::scene::name_id(name);
            let found: f32 = (found.iter().filter(|c| c.id == id).map(|c| c.share)).sum();
            let expected = share(stripe, pixel % 4);
            // Sobol points: an edge that runs through the pixel from top to bottom is met to about one in so many.
            assert!(
                (found - expected).abs() <= 4.0 / 1024.0,
                "{name}, pixel {pixel}: {found} {expected}"
            );
        }
    }
    let pairs = |layer: &str, word: &str, pairs: std::ops::Range<usize>| {
        for (pixel, found) in covered(&film, layer).iter().enumerate() {
            for pair in pairs.clone() {
                let id = engine::scene::name_id(&format!("{word} {pair}"));
                let found: f32 = (found.iter().filter(|c| c.id == id).map(|c| c.share)).sum();
                let stripes = (2 * pair..5).take(2);
                let expected: f32 = stripes.map(|stripe| share(stripe, pixel % 4)).sum();
                assert!((found - expected).abs() <= 4.0 / 1024.0, "{word} {pair}");
            }
        }
    };
    pairs("crypto_material", "of", 0..3);
    pairs("crypto_asset", "pair", 1..3);
}

#[test]
fn what_a_pixel_shows_too_much_of_is_dropped_the_same_way_however_it_is_cut() {
    let Some(device) = device::open() else { return };
    let names: Vec<String> = (0..40).map(|i| format!("blade {i}")).collect();
    let mut scene = stripes(&names, 2.0 / 40.0);
    let procedural = no_textures(&mut scene);
    let layers = Layers::named(["crypto_object"]).expect("known");
    let shot = Shot {
        size: (2, 2),
        max_depth: 1,
        spp: 96,
    };
    let of = |first_sample, cut| {
        let settings = RenderSettings {
            first_sample,
            ..with_layers(&from_above(3.0, 1.0), shot, &layers)
        };
        film(&device, &scene, &procedural, &settings, cut)
    };
    let whole = of(0, (1 << 14, 96));
    assert!(whole == of(0, (64, 96)), "smaller waves");
    // Each pixel sees twenty of them, and keeps those with the lowest ids.
    for (pixel, found) in covered(&whole, "crypto_object").iter().enumerate() {
        let seen = &names[20 * (pixel % 2)..][..20];
        let mut ids: Vec<u32> = seen.iter().map(|n| engine::scene::name_id(n)).collect();
        ids.sort_unstable();
        let mut found: Vec<u32> = found.iter().map(|coverage| coverage.id).collect();
        found.sort_unstable();
        assert_eq!(found, ids[..IDS]);
    }
    let mut merged = Film::with_layers(2, 2, layers.clone());
    for (first, cut) in [(60, (128, 36)), (0, (1 << 14, 1)), (1, (64, 59))] {
        assert!(merged != whole);
        merged.add(&of(first, cut));
    }
    assert!(merged == whole, "merged");
}
