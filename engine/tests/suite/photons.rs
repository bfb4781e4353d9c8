//! Photons bring what mirrors and bodies of glass throw on other surfaces: the light that paths find, and all of it once.

use std::sync::Arc;

use ::device::Device;
use engine::film::{Crop, Film};
use engine::procedural::TextureSources;
use engine::renderer::Renderer;
use engine::scene::{
    AlphaMode, Environment, FloatImage, LightKind, Material, Projection, PunctualLight, Scene,
};
use engine::settings::{Divided, Method, RenderSettings};
use glam::Vec3;

use crate::light_cache::{film, mean, room};
use crate::support::device;
use crate::support::scenes::{
    Shot, add, camera, faceted_sphere, lambert, lamp, no_textures, quad, render_with, scene,
    settings, textured, unlit,
};

/// So many paths go ahead of a cache where it doesn't matter how right its records are.
const FEW: u32 = 1 << 15;

/// A floor of 4 x 4 metres.
fn ground() -> (engine::scene::Mesh, Material) {
    let (x, z) = (Vec3::X * 4.0, Vec3::Z * 4.0);
    (
        quad(Vec3::new(-2.0, 0.0, -2.0), z, x),
        lambert(Vec3::new(0.8, 0.6, 0.5)),
    )
}

/// A floor with a mirror above its side, rough enough for light samples to find lamps in it.
fn beside_a_mirror(roughness: f32) -> Scene {
    let mirror = Material {
        base_color: Vec3::new(0.9, 0.8, 0.6).extend(1.0),
        metallic: 1.0,
        roughness,
        double_sided: true,
        ..Material::default()
    };
    let wall = quad(Vec3::new(-1.5, 0.4, -1.0), Vec3::Z * 2.0, Vec3::Y * 1.5);
    scene([ground(), (wall, mirror)], Vec3::ZERO)
}

/// A lamp of half a metre that lights the mirror and the floor.
fn with_lamp(mut scene: Scene) -> Scene {
    let panel = quad(Vec3::new(0.5, 2.0, -0.25), Vec3::X * 0.5, Vec3::Z * 0.5);
    add(&mut scene, panel, lamp(Vec3::splat(20.0)));
    scene
}

/// A ball of glass above the floor, below the lamp.
fn below_glass() -> Scene {
    let glass = Material {
        transmission: 1.0,
        is_solid: true,
        metallic: 0.0,
        roughness: 0.0,
        ..Material::default()
    };
    let mut ball = faceted_sphere(24);
    for position in &mut ball.positions {
        *position = *position * 0.5 + Vec3::Y * 0.8;
    }
    let mut scene = scene([ground(), (ball, glass)], Vec3::ZERO);
    let panel = quad(Vec3::new(-0.4, 3.0, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8);
    add(&mut scene, panel, lamp(Vec3::splat(20.0)));
    scene
}

fn sky_with_a_bright_place() -> Environment {
    let (width, height) = (64, 32);
    let radiance = |at: u32| match (at % width, at / width) {
        (28..30, 8..10) => [60.0, 50.0, 40.0],
        _ => [0.1, 0.14, 0.2],
    };
    let image = FloatImage {
        width,
        height,
        rgb: (0..width * height).map(radiance).collect(),
    };
    Environment::Image {
        image: Arc::new(image),
        rotation: 0.0,
        intensity: 1.0,
    }
}

fn seen(size: (u32, u32), seed: u32, method: Method) -> RenderSettings {
    let camera = camera(
        Vec3::new(0.3, 3.5, 2.5),
        Vec3::new(-0.2, 0.0, 0.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 0.9 },
    );
    let shot = Shot {
        size,
        max_depth: 8,
        spp: 0,
    };
    let mut settings = settings(&camera, shot);
    (settings.seed, settings.method) = (seed, method);
    settings
}

/// From below the ball, of which nothing is seen: what glass shows of lamps is noisy with either method.
fn seen_below(seed: u32, method: Method) -> RenderSettings {
    let mut settings = seen((48, 48), seed, method);
    settings.camera = camera(
        Vec3::new(0.0, 0.25, 1.2),
        Vec3::ZERO,
        Vec3::Y,
        Projection::Perspective { y_fov: 0.4 },
    );
    settings
}

/// Means of blocks of 8 x 8 pixels.
fn blocks(film: &Film, width: usize) -> Vec<Vec3> {
    let means = film.mean();
    let height = means.len() / width;
    let block = |at: usize| {
        let (column, row) = (at % (width / 8) * 8, at / (width / 8) * 8);
        let pixels = (0..64).map(|i| means[(row + i / 8) * width + column + i % 8]);
        pixels.map(Vec3::from).sum::<Vec3>() / 64.0
    };
    (0..width / 8 * (height / 8)).map(block).collect()
}

/// Compares photons with paths, block by block, relative to the mean of the picture.
fn agree(name: &str, device: &Device, of: impl Fn(&Device, Method) -> Film, most: f32) {
    let path = of(&device::open_for_reference(), Method::Path);
    let photons = of(device, Method::Photons);
    compare(name, &path, &photons, [0.01, most]);
}

/// How far the mean of a picture may be off, and a block of it.
fn compare(name: &str, path: &Film, photons: &Film, [most_off, most]: [f32; 2]) {
    let whole = mean(path);
    let off = (mean(photons) / whole - 1.0).abs().max_element();
    let apart = blocks(path, 48).into_iter().zip(blocks(photons, 48));
    let worst = apart
        .map(|(a, b)| ((a - b).abs() / whole).max_element())
        .fold(0.0, f32::max);
    let mean = mean(photons) / whole;
    println!("{name}: mean {mean} of paths', blocks off by {worst:.4} at most");
    assert!(off < most_off, "{name}: the mean is off by {off}");
    assert!(worst < most, "{name}: a block is off by {worst}");
}

#[test]
fn the_light_of_every_kind_of_lamp_counts_once() {
    let Some(device) = device::open() else { return };
    let lit = |kind, intensity: Vec3| {
        let mut scene = beside_a_mirror(0.3);
        scene.lights.push(PunctualLight {
            name: "light".to_owned(),
            kind,
            intensity,
            position: Vec3::new(0.8, 1.8, 0.1),
            direction: Vec3::new(-1.0, -0.5, 0.1).normalize(),
            range: f32::INFINITY,
        });
        scene
    };
    let spot = LightKind::Spot {
        inner_angle: 0.4,
        outer_angle: 0.8,
    };
    let disk = LightKind::Disk {
        angular_diameter: 0.2,
    };
    let scenes = [
        ("a panel", with_lamp(beside_a_mirror(0.3))),
        ("a point", lit(LightKind::Point, Vec3::splat(5.0))),
        ("a spot", lit(spot, Vec3::splat(5.0))),
        ("a direction", lit(LightKind::Directional, Vec3::splat(3.0))),
        ("a sun", lit(disk, Vec3::splat(3.0))),
        (
            "a sky with a bright place",
            Scene {
                environment: sky_with_a_bright_place(),
                ..beside_a_mirror(0.3)
            },
        ),
        // What falls off towards its range does so on the way to the mirror, not to the pane.
        ("a point with a range behind a pane", {
            let mut scene = lit(LightKind::Point, Vec3::splat(5.0));
            scene.lights[0].range = 3.0;
            let pane = Material {
                transmission: 1.0,
                metallic: 0.0,
                roughness: 0.0,
                ..Material::default()
            };
            let (y, z) = (Vec3::Y * 3.0, Vec3::Z * 4.0);
            add(&mut scene, quad(Vec3::new(0.5, 0.1, -2.0), z, y), pane);
            scene
        }),
        // Of which only the panel sends photons.
        (
            "an even sky and a panel",
            Scene {
                environment: Environment::Constant(Vec3::new(0.5, 0.7, 1.0)),
                ..with_lamp(beside_a_mirror(0.3))
            },
        ),
    ];
    for (name, scene) in &scenes {
        let of = |device: &Device, method| {
            let (seed, spp) = match method {
                Method::Photons => (1, 64),
                _ => (5, 1024),
            };
            film(device, scene.clone(), &seen((48, 48), seed, method), spp)
        };
        agree(name, &device, of, 0.05);
    }
}

/// As [`agree`], of a scene that is seen from below its glass, by so many samples.
fn agree_below(name: &str, device: &Device, scene: &Scene, spp: [u32; 2], most: [f32; 2]) {
    let of = |device: &Device, seed, method, spp| {
        film(device, scene.clone(), &seen_below(seed, method), spp)
    };
    let path = of(&device::open_for_reference(), 5, Method::Path, spp[0]);
    let photons = of(device, 1, Method::Photons, spp[1]);
    compare(name, &path, &photons, most);
}

#[test]
fn caustics_of_glass_are_those_of_paths() {
    let Some(device) = device::open() else { return };
    agree_below("glass", &device, &below_glass(), [4096, 64], [0.01, 0.05]);
}

/// As many photons come to a surface as it covers of them, and as many paths ask for them there: not once more.
#[test]
fn surfaces_that_cover_a_part_have_that_part_of_caustics() {
    let Some(device) = device::open() else { return };
    let mut scene = below_glass();
    scene.materials[0].alpha_mode = AlphaMode::Blend;
    scene.materials[0].base_color.w = 0.4;
    agree_below("half a floor", &device, &scene, [4096, 512], [0.01, 0.12]);
}

/// Rays leave the curved surface that the normals of a coarse mesh suggest, and photons lie there, too.
#[test]
fn caustics_lie_on_curved_surfaces() {
    let Some(device) = device::open() else { return };
    let mut scene = below_glass();
    let mut ball = faceted_sphere(7);
    ball.normals.clone_from(&ball.positions);
    for position in &mut ball.positions {
        *position = *position * 0.25 - Vec3::Y * 0.05;
    }
    add(&mut scene, ball, lambert(Vec3::new(0.7, 0.7, 0.6)));
    // Paths ask a centimetre above the triangles, where the light that the glass gathers is as much wider. A ball of sixteen
    // times the triangles is off by a sixth of that.
    agree_below("a coarse ball", &device, &scene, [4096, 256], [0.08, 0.5]);
}

/// No photons come from a lamp that light samples know nothing of: what glass throws of it is left to paths.
#[test]
fn unlit_surfaces_shine_through_glass() {
    let Some(device) = device::open() else { return };
    let mut scene = below_glass();
    scene.materials[2] = unlit(Vec3::splat(20.0).extend(1.0));
    // Without a lamp there would be no photons at all.
    let panel = quad(Vec3::new(1.2, 2.0, -0.25), Vec3::X * 0.5, Vec3::Z * 0.5);
    add(&mut scene, panel, lamp(Vec3::splat(2.0)));
    agree_below("an unlit lamp", &device, &scene, [4096, 1024], [0.01, 0.12]);
}

/// From the very middle of one body others are where they are.
#[test]
fn a_light_in_the_middle_of_a_body_lights_the_others_once() {
    let Some(device) = device::open() else { return };
    let mean_of = |aside: f32| {
        let mut scene = below_glass();
        scene.materials[2].emission = Vec3::ZERO;
        let mut globe = faceted_sphere(24);
        for position in &mut globe.positions {
            *position = *position * 0.3 + Vec3::new(0.0, 1.9, 0.0);
        }
        let glass = scene.materials[1].clone();
        add(&mut scene, globe, glass);
        let middle = Vec3::new(aside, 1.9, 0.0);
        scene.lights.push(PunctualLight {
            name: "bulb".to_owned(),
            intensity: Vec3::splat(10.0),
            position: middle,
            direction: Vec3::NEG_Y,
            range: f32::INFINITY,
            kind: LightKind::Point,
        });
        mean(&film(&device, scene, &seen_below(1, Method::Photons), 64))
    };
    let (there, beside) = (mean_of(0.0), mean_of(1e-3));
    let off = (there / beside - 1.0).abs().max_element();
    assert!(off < 0.03, "{there} and {beside}");
}

/// Radiance is denser in glass, and scattered as such; the flux of a photon that begins there is what it is.
#[test]
fn a_lamp_in_glass_is_as_bright_as_by_paths() {
    let Some(device) = device::open() else { return };
    let mut scene = below_glass();
    // The one above is seen through the new one's back, which hides nothing, but not past its front: no path is its own way back.
    scene.materials[2].emission = Vec3::ZERO;
    let panel = quad(Vec3::new(-0.15, 0.8, -0.15), Vec3::X * 0.3, Vec3::Z * 0.3);
    add(&mut scene, panel, lamp(Vec3::splat(100.0)));
    agree_below(
        "a lamp in glass",
        &device,
        &scene,
        [4096, 256],
        [0.01, 0.05],
    );
}

/// Photons begin in the bodies that their lamp is in, as paths come out of them one after the other.
#[test]
fn a_lamp_in_a_body_within_another_is_as_bright_as_by_paths() {
    let Some(device) = device::open() else { return };
    let mut scene = below_glass();
    scene.materials[2].emission = Vec3::ZERO;
    let glass = &mut scene.materials[1];
    glass.attenuate(Vec3::new(0.9, 0.7, 0.5), 0.3);
    let mut inner = faceted_sphere(24);
    for position in &mut inner.positions {
        *position = *position * 0.3 + Vec3::Y * 0.8;
    }
    let mut denser = Material {
        ior: 2.0,
        ..glass.clone()
    };
    denser.attenuate(Vec3::new(0.5, 0.8, 0.9), 0.3);
    add(&mut scene, inner, denser);
    // What goes up comes down again, through both bodies.
    let mirror = Material {
        metallic: 1.0,
        roughness: 0.0,
        double_sided: true,
        ..Material::default()
    };
    let plate = quad(Vec3::new(-0.1, 0.9, -0.1), Vec3::X * 0.2, Vec3::Z * 0.2);
    add(&mut scene, plate, mirror);
    let panel = quad(Vec3::new(-0.1, 0.8, -0.1), Vec3::X * 0.2, Vec3::Z * 0.2);
    add(&mut scene, panel, lamp(Vec3::splat(200.0)));
    scene.materials[5].double_sided = true;
    agree_below(
        "a lamp in two bodies",
        &device,
        &scene,
        [4096, 256],
        [0.01, 0.05],
    );
}

/// What is noise and what is bias: both fall, as the 2/3 power of the number of photons in the square.
#[test]
fn more_photons_come_nearer() {
    let Some(device) = device::open() else { return };
    let reference = device::open_for_reference();
    let right = film(
        &reference,
        below_glass(),
        &seen_below(5, Method::Path),
        4096,
    );
    let error = |spp: u32| {
        let settings = seen_below(1, Method::Photons);
        let film = film(&device, below_glass(), &settings, spp);
        let apart = film.mean().into_iter().zip(right.mean());
        let squares = apart.map(|(a, b)| (Vec3::from(a) - Vec3::from(b)).length_squared());
        (squares.sum::<f32>() / film.pixels() as f32).sqrt()
    };
    let errors = [2, 8, 32, 128].map(error);
    println!("{errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < pair[0], "{errors:?}");
    }
    assert!(errors[3] < 0.4 * errors[0], "{errors:?}");
}

#[test]
fn where_nothing_throws_caustics_nothing_changes() {
    let Some(device) = device::open() else { return };
    let mut scene = room();
    for material in &mut scene.materials {
        material.roughness = 1.0;
    }
    let of = |method| {
        let settings = RenderSettings {
            paths_ahead: FEW,
            ..crate::light_cache::seen((40, 24), 3, method)
        };
        film(&device, scene.clone(), &settings, 8)
    };
    assert!(of(Method::Path) == of(Method::Photons));
    assert!(of(Method::Cache) == of(Method::CachePhotons));
}

/// A spot shines on a mirror, which throws its light on the floor; all that the camera sees, a wall and the ceiling, is lit by that.
fn lit_by_a_caustic(roughness: f32) -> Scene {
    let mut scene = beside_a_mirror(roughness);
    let white = Material {
        double_sided: true,
        ..lambert(Vec3::splat(0.8))
    };
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 3.0, Vec3::Z * 4.0);
    let corner = Vec3::new(-2.0, 0.0, -2.0);
    add(&mut scene, quad(corner + x, z, y), white.clone());
    add(&mut scene, quad(corner + y, x, z), white.clone());
    add(&mut scene, quad(corner, x, y), white);
    scene.lights.push(PunctualLight {
        name: "spot".to_owned(),
        kind: LightKind::Spot {
            inner_angle: 0.15,
            outer_angle: 0.25,
        },
        intensity: Vec3::splat(60.0),
        position: Vec3::new(0.6, 2.2, 0.0),
        direction: Vec3::new(-2.1, -1.0, 0.0).normalize(),
        range: f32::INFINITY,
    });
    scene
}

#[test]
fn a_cache_learns_what_caustics_light() {
    let Some(device) = device::open() else { return };
    let reference = device::open_for_reference();
    let of = |roughness, method, seed, spp| {
        let mut settings = seen((48, 48), seed, method);
        settings.camera = camera(
            Vec3::new(-1.2, 1.0, 1.2),
            Vec3::new(2.0, 2.4, -0.8),
            Vec3::Y,
            Projection::Perspective { y_fov: 1.0 },
        );
        settings.paths_ahead = 8 * FEW;
        let device = match method {
            Method::Path => &reference,
            _ => &device,
        };
        film(device, lit_by_a_caustic(roughness), &settings, spp)
    };
    // Light samples find the spot by way of a mirror that is rough enough, so paths have all of its light, with much noise.
    let path = mean(&of(0.3, Method::Path, 5, 2048));
    let photons = of(0.3, Method::Photons, 1, 256);
    let both = of(0.3, Method::CachePhotons, 1, 16);
    let off = (mean(&both) / path - 1.0).abs().max_element();
    println!("off from paths by {off}");
    assert!(off < 0.04, "{off}");
    compare("by a rough mirror", &photons, &both, [0.025, 0.1]);
    // Of a smooth one they have next to none.
    let [path, photons, both] = [Method::Path, Method::Photons, Method::CachePhotons]
        .map(|method| mean(&of(0.0, method, 1, 32)));
    println!("by a smooth mirror: {path}, {photons}, {both}");
    assert!(path.max_element() < 0.1 * photons.max_element());
    assert!((both / photons - 1.0).abs().max_element() < 0.04);
}

#[test]
fn caustics_on_the_first_surface_stay_sharp_with_a_cache() {
    let Some(device) = device::open() else { return };
    let reference = device::open_for_reference();
    let path = film(
        &reference,
        below_glass(),
        &seen_below(5, Method::Path),
        4096,
    );
    let mut settings = seen_below(1, Method::CachePhotons);
    settings.paths_ahead = 8 * FEW;
    let both = film(&device, below_glass(), &settings, 64);
    compare("glass", &path, &both, [0.015, 0.05]);
    let path = film(
        &reference,
        room(),
        &crate::light_cache::seen((48, 48), 5, Method::Path),
        2048,
    );
    let mut settings = crate::light_cache::seen((48, 48), 1, Method::CachePhotons);
    settings.paths_ahead = 8 * FEW;
    let both = film(&device, room(), &settings, 32);
    compare("a ball of metal in a room", &path, &both, [0.03, 0.1]);
}

#[test]
fn the_picture_depends_neither_on_waves_nor_on_parts() {
    let Some(device) = device::open() else { return };
    let settings = seen((40, 24), 3, Method::Photons);
    let mut scene = with_lamp(beside_a_mirror(0.1));
    let procedural = no_textures(&mut scene);
    let whole = film(&device, scene.clone(), &settings, 6);
    let renderer = Renderer::with_capacity(&device, &scene, &procedural, &settings, 640);
    let mut renderer = renderer.expect("the scene renders");
    renderer.render(6).expect("the device renders");
    assert!(renderer.film().expect("the device reads") == whole);
    let part = |first, count| {
        let mut settings = settings.clone();
        settings.first_sample = first;
        film(&device, scene.clone(), &settings, count)
    };
    let mut sum = part(0, 2);
    sum.add(&part(2, 4));
    assert!(sum == whole);
    // Nor with a cache beside.
    let mut settings = settings;
    settings.paths_ahead = FEW;
    settings.method = Method::CachePhotons;
    let whole = film(&device, scene.clone(), &settings, 3);
    let renderer = Renderer::with_capacity(&device, &scene, &procedural, &settings, 640);
    let mut renderer = renderer.expect("the scene renders");
    renderer.render(3).expect("the device renders");
    assert!(renderer.film().expect("the device reads") == whole);
}

/// A lamp of stripes, and a floor of which a program lets a part of the rays through: what photons meet is what paths meet.
#[test]
fn lamps_and_surfaces_of_programs_count_as_they_should() {
    let Some(device) = device::open() else { return };
    let mut sources = TextureSources::default();
    sources.insert(
        "stripes",
        "fn userProc(color: vec3f) -> vec3f {
            return select(vec3f(0.0), color, fract(4.0 * readAttr(TexCoord0).x) < 0.5);
        }",
    );
    sources.insert(
        "holes",
        "fn userProc() -> f32 {
            return select(1.0, 0.4, fract(6.0 * readAttr(TexCoord0).y) < 0.5);
        }",
    );
    let look = "[node.light]\ntexture='stripes'\ncolor=[40.0, 30.0, 20.0]\n\
        [material.'material 2']\nemission='light'\n\
        [node.holes]\ntexture='holes'\n\
        [material.'material 0']\nopacity='holes'\n";
    let mut scene = with_lamp(beside_a_mirror(0.3));
    let procedural = textured(&mut scene, look, &sources);
    let of = |device: &Device, method| {
        let (seed, spp) = match method {
            Method::Photons => (1, 128),
            _ => (5, 1024),
        };
        let settings = seen((48, 48), seed, method);
        render_with(device, &scene, &procedural, &settings, spp)
    };
    agree("programs", &device, of, 0.05);
}

/// As many as of the whole, the same ones: no border is seen where pieces meet.
#[test]
fn pieces_have_the_photons_of_the_whole() {
    let Some(device) = device::open() else { return };
    const SPP: u32 = 2;
    // More photons than a small piece would have by itself.
    let (width, height) = (256, 132);
    let mut scene = below_glass();
    let procedural = no_textures(&mut scene);
    for method in [Method::Photons, Method::CachePhotons] {
        let settings = RenderSettings {
            paths_ahead: FEW,
            ..seen((width, height), 1, method)
        };
        let whole = film(&device, scene.clone(), &settings, SPP);
        let piece = |top: u32, rows: u32| RenderSettings {
            height: rows,
            crop: Some(Crop {
                left: 0,
                top,
                whole: [width, height],
            }),
            piece_of: Some(Divided {
                size: [width, height],
                crop: None,
            }),
            ..settings.clone()
        };
        let mut renderer = Renderer::new(&device, &scene, &procedural, &piece(0, 50))
            .unwrap_or_else(|error| panic!("{error}"));
        while renderer
            .learn_of_whole(SPP)
            .unwrap_or_else(|error| panic!("{error}"))
        {}
        for (top, rows) in [(0, 50), (50, 50), (100, 32)] {
            let went = renderer.set_part([width, rows], piece(top, rows).crop);
            went.and_then(|()| renderer.render(SPP))
                .unwrap_or_else(|error| panic!("{error}"));
            let film = renderer.film().unwrap_or_else(|error| panic!("{error}"));
            let first = (top * width) as usize;
            let is_same = (0..film.pixels()).all(|at| film.sum(at) == whole.sum(first + at));
            assert!(is_same, "{method:?}, from row {top} on");
        }
    }
}
