//! Paths that end in a cache of scattered light: what they find there is what paths find, nearly.

use ::device::Device;
use engine::film::{Film, Layers};
use engine::renderer::Renderer;
use engine::scene::{LightKind, Material, Mesh, Projection, PunctualLight, Scene};
use engine::settings::{Method, RenderSettings};
use glam::{Vec3, Vec4};

use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, lamp, no_textures, quad, render_with, scene,
    settings,
};

/// A room with walls of two colours, a ball of metal and a lamp below the ceiling that shines up: nearly all of its light is
/// scattered twice or more.
pub(crate) fn room() -> Scene {
    let wall = |color| Material {
        double_sided: true,
        ..lambert(color)
    };
    let (white, red) = (Vec3::splat(0.7), Vec3::new(0.7, 0.2, 0.1));
    let metal = Material {
        roughness: 0.1,
        ..Material::default()
    };
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 3.0, Vec3::Z * 4.0);
    let corner = Vec3::new(-2.0, 0.0, -2.0);
    scene(
        [
            (quad(corner, z, x), wall(white)),
            (quad(corner + y, x, z), wall(white)),
            (quad(corner, x, y), wall(white)),
            (quad(corner + z, y, x), wall(white)),
            (quad(corner, y, z), wall(red)),
            (quad(corner + x, z, y), wall(white)),
            (faceted_sphere(16), metal),
            (
                quad(Vec3::new(-0.4, 2.2, -0.4), Vec3::Z * 0.8, Vec3::X * 0.8),
                lamp(Vec3::splat(12.0)),
            ),
        ],
        Vec3::ZERO,
    )
}

pub(crate) fn seen(size: (u32, u32), seed: u32, method: Method) -> RenderSettings {
    let camera = camera(
        Vec3::new(1.4, 1.8, 1.8),
        Vec3::new(0.0, 1.0, 0.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 1.3 },
    );
    let shot = Shot {
        size,
        max_depth: 12,
        spp: 0,
    };
    let mut settings = settings(&camera, shot);
    (settings.seed, settings.method) = (seed, method);
    settings
}

pub(crate) fn film(device: &Device, mut scene: Scene, settings: &RenderSettings, spp: u32) -> Film {
    let procedural = no_textures(&mut scene);
    render_with(device, &scene, &procedural, settings, spp)
}

pub(crate) fn mean(film: &Film) -> Vec3 {
    let sum: Vec3 = film.mean().into_iter().map(Vec3::from).sum();
    sum / film.pixels() as f32
}

#[test]
fn a_furnace_stays_a_furnace() {
    let Some(device) = device::open() else { return };
    // Inside of a ball that emits e and reflects r of what meets it there is e / (1 - r) everywhere.
    let (emitted, reflected) = (0.4, 0.5);
    let wall = Material {
        double_sided: true,
        emission: Vec3::splat(emitted),
        ..lambert(Vec3::splat(reflected))
    };
    let ball = scene([(faceted_sphere(12), wall)], Vec3::ZERO);
    let camera = camera(
        Vec3::new(0.1, 0.2, 0.1),
        Vec3::Z,
        Vec3::Y,
        Projection::Perspective { y_fov: 1.0 },
    );
    let shot = Shot {
        size: (48, 32),
        max_depth: 24,
        spp: 0,
    };
    let mut settings = settings(&camera, shot);
    for method in [Method::Draft, Method::Cache] {
        settings.method = method;
        let film = film(&device, ball.clone(), &settings, 64);
        let found = mean(&film).x;
        let expected = emitted / (1.0 - reflected);
        println!("{}: {found} where {expected} is right", method.name());
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "{}: {found} is not {expected}",
            method.name()
        );
    }
}

#[test]
fn light_that_is_scattered_often_is_nearly_right_and_less_noisy() {
    let Some(device) = device::open() else { return };
    let size = (48, 36);
    let reference = device::open_for_reference();
    let right = film(&reference, room(), &seen(size, 7, Method::Path), 2048);
    let [path, draft] = [Method::Path, Method::Draft].map(|method| {
        let film = film(&device, room(), &seen(size, 1, method), 128);
        let (found, wanted) = (mean(&film), mean(&right));
        let off = (found / wanted - 1.0).abs().max_element();
        let right = right.mean();
        let apart = film.mean().into_iter().zip(right);
        let squares: f32 = apart
            .map(|(a, b)| (Vec3::from(a) - Vec3::from(b)).length_squared())
            .sum();
        println!(
            "{}: mean off by {off:.4}, squared error {squares:.4}",
            method.name()
        );
        (off, squares)
    });
    assert!(draft.0 < 0.02, "the mean is off by {}", draft.0);
    assert!(draft.1 < 0.8 * path.1, "{} and {}", draft.1, path.1);
}

/// A dark room, and beyond a small door in its wall, which has no thickness, one with a lamp; floors and ceilings run on below and above the
/// wall. The camera is in the dark one.
fn two_rooms() -> Scene {
    let wall = |color| Material {
        double_sided: true,
        ..lambert(color)
    };
    let white = || wall(Vec3::splat(0.8));
    let red = || wall(Vec3::new(0.8, 0.2, 0.2));
    let (x, y, z) = (Vec3::X * 4.0, Vec3::Y * 2.0, Vec3::Z * 2.0);
    let corner = Vec3::new(-2.0, 0.0, -1.0);
    let beside = Vec3::Z * 0.85;
    scene(
        [
            (quad(corner, z, x), white()),
            (quad(corner + y, x, z), white()),
            (quad(corner, x, y), white()),
            (quad(corner + z, y, x), white()),
            (quad(corner, y, z), white()),
            (quad(corner + x, z, y), white()),
            (quad(-Vec3::Z, beside, y), red()),
            (quad(Vec3::Z * 0.15, beside, y), red()),
            (
                quad(Vec3::new(0.0, 0.7, -0.15), Vec3::Z * 0.3, Vec3::Y * 1.3),
                red(),
            ),
            (
                quad(Vec3::new(0.9, 1.9, -0.3), Vec3::X * 0.6, Vec3::Z * 0.6),
                lamp(Vec3::splat(50.0)),
            ),
        ],
        Vec3::ZERO,
    )
}

#[test]
fn a_lit_room_beyond_the_door_of_a_dark_one_keeps_its_light() {
    let Some(device) = device::open() else { return };
    let camera = camera(
        Vec3::new(-1.9, 1.1, 0.6),
        Vec3::new(0.0, 0.8, 0.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 1.22 },
    );
    let shot = Shot {
        size: (48, 32),
        max_depth: 9,
        spp: 0,
    };
    let of = |method, spp| {
        let mut settings = settings(&camera, shot);
        settings.method = method;
        mean(&film(&device, two_rooms(), &settings, spp)).y
    };
    let expected = of(Method::Path, 1024);
    // Few of the paths that teach come to the lit room, and cells that are wide enough to be known by them reach into the dark one, which most
    // come to: it lost a twentieth.
    for (method, most) in [(Method::Draft, 0.03), (Method::Cache, 0.02)] {
        let found = of(method, 64);
        println!("{}: {found} where paths find {expected}", method.name());
        let share = found / expected - 1.0;
        assert!(share.abs() < most, "{}: {share}", method.name());
    }
}

/// A path that comes by a pure red wall knows nothing of green and blue: cells that counted it as black had a tenth less of both.
#[test]
fn walls_of_one_pure_colour_take_nothing_from_the_others() {
    let Some(device) = device::open() else { return };
    let of = |device: &_, method, spp| {
        let mut scene = room();
        scene.materials[4].base_color = Vec3::new(0.8, 0.0, 0.0).extend(1.0);
        scene.materials[5].base_color = Vec3::new(0.0, 0.8, 0.0).extend(1.0);
        mean(&film(device, scene, &seen((48, 32), 1, method), spp))
    };
    let expected = of(&device::open_for_reference(), Method::Path, 1024);
    for method in [Method::Draft, Method::Cache] {
        let found = of(&device, method, 128);
        println!("{}: {found} where paths find {expected}", method.name());
        let off = (found / expected - 1.0).abs().max_element();
        assert!(off < 0.03, "{}: {off}", method.name());
    }
}

#[test]
fn the_picture_does_not_depend_on_how_waves_are_cut() {
    let Some(device) = device::open() else { return };
    let films = [512, 1 << 13].map(|capacity| {
        let mut scene = room();
        let procedural = no_textures(&mut scene);
        let mut settings = seen((40, 24), 3, Method::Draft);
        settings.layers = Layers::named(["albedo"]).expect("known");
        let renderer = Renderer::with_capacity(&device, &scene, &procedural, &settings, capacity);
        let mut renderer = renderer.expect("the scene renders");
        renderer.render(8).expect("the device renders");
        // An edit of the camera forgets what was learned.
        renderer.set_camera(&settings.camera);
        renderer.render(24).expect("the device renders");
        renderer.film().expect("the device reads")
    });
    assert!(films[0] == films[1]);
}

#[test]
fn where_paths_cannot_end_in_a_cache_nothing_changes() {
    let Some(device) = device::open() else { return };
    // A floor under a sky: light is scattered once.
    let of = |method| {
        let open = scene([(floor(3.0), lambert(Vec3::splat(0.5)))], Vec3::splat(0.6));
        film(&device, open, &seen((24, 16), 0, method), 32)
    };
    // Of what comes from the sky caches know nothing; light samples go by where it is seen.
    let path = mean(&of(Method::Path));
    for method in [Method::Draft, Method::Cache] {
        let found = mean(&of(method));
        let off = (found / path - 1.0).abs().max_element();
        assert!(off < 1e-3, "{}: {found} is not {path}", method.name());
    }
}

/// A board above a floor of a material on which the sun shines: how bright each column of the picture is where the board is seen.
fn board_above(
    device: &Device,
    (floor, material): (Mesh, &Material),
    (width, height): (u32, u32),
    method: Method,
    spp: u32,
) -> Vec<f64> {
    // It leans towards the camera, its back to the sun.
    let leaning = Vec3::new(0.0, 2.0, -2.0);
    let board = quad(Vec3::new(-2.0, 1.0, 3.0), leaning, Vec3::X * 4.0);
    let mut scene = scene(
        [
            (floor, material.clone()),
            (board, lambert(Vec3::splat(0.7))),
        ],
        Vec3::ZERO,
    );
    scene.lights.push(PunctualLight {
        name: "sun".to_owned(),
        kind: LightKind::Directional,
        intensity: Vec3::splat(10.0),
        position: Vec3::ZERO,
        direction: Vec3::new(0.0, -1.0, 0.8).normalize(),
        range: f32::INFINITY,
    });
    let camera = camera(
        Vec3::new(0.0, 1.0, -4.0),
        Vec3::new(0.0, 1.2, 2.0),
        Vec3::Y,
        Projection::Perspective { y_fov: 0.6 },
    );
    let shot = Shot {
        size: (width, height),
        max_depth: 2,
        spp: 0,
    };
    let mut settings = settings(&camera, shot);
    (settings.method, settings.seed) = (method, spp);
    let pixels = film(device, scene, &settings, spp).mean();
    let seen = &pixels[..(width * height / 3) as usize];
    let columns =
        (0..width as usize).map(|column| seen.iter().skip(column).step_by(width as usize));
    columns
        .map(|column| column.map(|pixel| f64::from(pixel[1])).sum())
        .collect()
}

/// It gets what the floor reflects, which is more than the floor sends to the camera, and so more than the mean over all directions.
#[test]
fn what_a_floor_reflects_of_the_sun_lights_what_is_above_it() {
    let Some(device) = device::open() else { return };
    let metal = Material {
        base_color: Vec4::new(0.9, 0.9, 0.9, 1.0),
        metallic: 1.0,
        roughness: 0.5,
        ..Material::default()
    };
    let of = |method, spp| {
        board_above(&device, (floor(3.0), &metal), (48, 36), method, spp)
            .iter()
            .sum::<f64>()
    };
    let right = of(Method::Path, 1024);
    for method in [Method::Draft, Method::Cache] {
        let off = of(method, 128) / right - 1.0;
        assert!(off.abs() < 0.04, "{}: off by {off}", method.name());
    }
}

/// And it gets it where a table reflects it to, although paths end on the table, whose cells know some directions alone.
#[test]
fn what_a_polished_table_reflects_of_the_sun_goes_where_it_does() {
    let Some(device) = device::open() else { return };
    let polished = Material {
        base_color: Vec4::new(0.02, 0.02, 0.02, 1.0),
        metallic: 0.0,
        roughness: 0.45,
        ..Material::default()
    };
    let of = |method, spp| -> Vec<f64> {
        let table = floor(0.4);
        let columns = board_above(&device, (table, &polished), (192, 144), method, spp);
        (columns.chunks(24).map(|columns| columns.iter().sum())).collect()
    };
    let right = of(Method::Path, 256);
    for method in [Method::Draft, Method::Cache] {
        let found = of(method, 32);
        let brightest = right.iter().copied().fold(0.0, f64::max);
        let most = (found.iter().zip(&right))
            .map(|(found, right)| (found - right).abs() / brightest)
            .fold(0.0, f64::max);
        assert!(most < 0.11, "{}: off by {most}", method.name());
    }
}
