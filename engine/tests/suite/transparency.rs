//! Light through things: clear walls as filters for shadow rays, bodies inside bodies, dispersion; and light along coarse
//! meshes with smooth normals. Against closed forms, as statistics. Skipped with a notice where there is no adapter.

use std::f32::consts::PI;

use ::device::Device;
use engine::film::Film;
use engine::scene::{
    Camera, Instance, LightKind, Material, Mesh, Projection, PunctualLight, Scene,
};
use glam::{Affine3A, Vec3};

use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{
    Shot, add, camera, faceted_sphere, floor, from_above, lambert, lamp, quad, render, scene, unlit,
};
use crate::support::stats::ZTest;

/// Share of the pixels that must pass. Chance alone lets 99.86 % pass.
const PASSING: f64 = 0.995;
/// How far the mean of a channel may be off, relative.
const MEAN_ERROR: f64 = 0.005;

/// Direct light only.
const DIRECT: Shot = Shot {
    size: (16, 16),
    max_depth: 1,
    spp: 256,
};

/// All there is of what bodies reflect within themselves.
const DEEP: Shot = Shot {
    max_depth: 64,
    ..DIRECT
};

#[track_caller]
fn assert_uniform(name: &str, film: &Film, radiance: Vec3) {
    let exact = Estimate::exact((film.width, film.height), |_| radiance);
    // Some of these pictures have no noise at all.
    let test = ZTest {
        rounding: 1.0e-3,
        ..ZTest::default()
    };
    test.compare(Estimate::from_film(film), exact, |_, _| true)
        .assert_matches(name, PASSING, MEAN_ERROR);
}

#[track_caller]
fn assert_same(name: &str, tested: &Film, reference: &Film) {
    let (tested, reference) = (Estimate::from_film(tested), Estimate::from_film(reference));
    ZTest::default()
        .compare(tested, reference, |_, _| true)
        .assert_matches(name, PASSING, MEAN_ERROR);
}

/// A thin wall of smooth glass of this colour.
fn pane(color: Vec3) -> Material {
    Material {
        base_color: color.extend(1.0),
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        double_sided: true,
        ..Material::default()
    }
}

/// A clear body.
fn body(ior: f32) -> Material {
    Material {
        is_solid: true,
        ior,
        ..pane(Vec3::ONE)
    }
}

fn sun(direction: Vec3, irradiance: Vec3) -> PunctualLight {
    PunctualLight {
        name: "sun".to_owned(),
        intensity: irradiance,
        position: Vec3::ZERO,
        direction,
        range: f32::INFINITY,
        kind: LightKind::Directional,
    }
}

/// A white floor, seen along it from below a pane that covers everything above.
fn under_glass(pane: Material, environment: Vec3) -> (Scene, Camera) {
    let far = 1e4;
    let roof = quad(
        Vec3::new(-far, 1.0, far),
        Vec3::X * 2.0 * far,
        Vec3::NEG_Z * 2.0 * far,
    );
    let scene = scene(
        [(floor(1.0), lambert(Vec3::ONE)), (roof, pane)],
        environment,
    );
    (scene, from_above(0.5, 0.9))
}

/// Both sides of a wide plate between these heights.
fn plate(bottom: f32, top: f32) -> Mesh {
    let mut plate = floor(9.0);
    let mut below = plate.clone();
    for p in &mut plate.positions {
        p.y = top;
    }
    for p in &mut below.positions {
        p.y = bottom;
    }
    plate.positions.append(&mut below.positions);
    plate.normals.extend([Vec3::NEG_Y; 4]);
    plate.uv0.append(&mut below.uv0);
    plate.triangles.extend([[6, 5, 4], [7, 6, 4]]);
    let materials = plate.triangle_materials.clone();
    plate.triangle_materials.extend(materials);
    plate
}

#[track_caller]
fn assert_white(name: &str, film: &Film) {
    let mean = film.mean().into_iter().map(Vec3::from).sum::<Vec3>() / film.pixels() as f32;
    assert!(
        (mean - Vec3::ONE).abs().max_element() < 0.01,
        "{name}: {mean}"
    );
}

#[test]
fn rough_borders_between_equals_turn_nothing_aside() {
    let Some(device) = device::open() else { return };
    for roughness in [0.0, 0.3, 1.0] {
        let air = Material {
            roughness,
            ..body(1.0)
        };
        let objects = [(floor(1.0), lamp(Vec3::ONE)), (plate(0.5, 1.0), air)];
        let mut scene = scene(objects, Vec3::ZERO);
        let film = render(&device, &mut scene, &from_above(2.0, 0.5), DEEP);
        assert_white(&format!("roughness {roughness}"), &film);
    }
}

#[test]
fn thin_panes_are_panes_far_from_the_origin() {
    let Some(device) = device::open() else { return };
    for height in [0.0, 300.0] {
        let mut scene = scene([(plate(0.0, 0.004), body(1.5))], Vec3::ONE);
        scene.instances[0].transform = Affine3A::from_translation(Vec3::Y * height);
        let film = render(&device, &mut scene, &from_above(height + 2.0, 0.5), DEEP);
        assert_white(&format!("{height} m up"), &film);
    }
}

#[test]
fn milk_in_glass_keeps_all_light() {
    let Some(device) = device::open() else { return };
    for (transmission, roughness) in [(0.0, 0.1), (0.0, 0.8), (0.5, 0.0), (0.5, 0.5)] {
        let milk = Material {
            transmission,
            roughness,
            diffuse_transmission: 0.5,
            ..body(1.5)
        };
        let mut scene = scene([(plate(0.0, 0.05), milk)], Vec3::ONE);
        let film = render(&device, &mut scene, &from_above(2.0, 0.5), DEEP);
        assert_white(
            &format!("{transmission} clear, roughness {roughness}"),
            &film,
        );
    }
}

const TINT: Vec3 = Vec3::new(0.9, 0.5, 0.2);

#[test]
fn the_sun_shines_through_a_pane_with_its_colour() {
    let Some(device) = device::open() else { return };
    let (mut scene, camera) = under_glass(pane(TINT), Vec3::ZERO);
    scene.lights.push(sun(Vec3::NEG_Y, Vec3::splat(PI)));
    let film = render(&device, &mut scene, &camera, DIRECT);
    // Straight on, a twenty-fifth is reflected.
    assert_uniform("sun", &film, TINT * 0.96);
}

#[test]
fn the_sky_shines_through_a_pane_whichever_way_it_is_sampled() {
    let Some(device) = device::open() else { return };
    let (mut scene, camera) = under_glass(pane(TINT), Vec3::ONE);
    let film = render(&device, &mut scene, &camera, DIRECT);
    // The cosine-weighted mean of 1 - F with Schlick's F.
    assert_uniform("sky", &film, TINT * (0.96 * 20.0 / 21.0));
}

#[test]
fn two_panes_are_darker_than_one_and_a_mask_has_holes() {
    let Some(device) = device::open() else { return };
    let (mut scene, camera) = under_glass(pane(TINT), Vec3::ZERO);
    scene.lights.push(sun(Vec3::NEG_Y, Vec3::splat(PI)));
    // Half of it is there.
    let holes = Material {
        alpha_mode: engine::scene::AlphaMode::Blend,
        base_color: TINT.extend(0.5),
        ..pane(TINT)
    };
    let second = quad(
        Vec3::new(-9.0, 2.0, 9.0),
        Vec3::X * 18.0,
        Vec3::NEG_Z * 18.0,
    );
    add(&mut scene, second, holes);
    let film = render(&device, &mut scene, &camera, DIRECT);
    let once = TINT * 0.96;
    assert_uniform("two panes", &film, once * (0.5 + 0.5 * once));
}

#[test]
fn a_lamp_behind_a_pane_is_seen_as_if_its_light_were_filtered() {
    let Some(device) = device::open() else { return };
    let lamp_at = |height: f32| {
        quad(
            Vec3::new(-0.5, height, -0.5),
            Vec3::X,
            Vec3::Z, // shines down
        )
    };
    let shot = Shot {
        max_depth: 1,
        spp: 512,
        ..DIRECT
    };
    let (mut glazed, camera) = under_glass(pane(TINT), Vec3::ZERO);
    add(&mut glazed, lamp_at(40.0), lamp(Vec3::splat(4000.0)));
    let glazed = render(&device, &mut glazed, &camera, shot);
    let mut open = scene([(floor(1.0), lambert(Vec3::ONE))], Vec3::ZERO);
    add(&mut open, lamp_at(40.0), lamp(TINT * 0.96 * 4000.0));
    let open = render(&device, &mut open, &camera, shot);
    assert_same("lamp", &glazed, &open);
}

/// A box with its faces outwards.
fn cuboid(lo: Vec3, hi: Vec3) -> Mesh {
    let size = hi - lo;
    let (x, y, z) = (Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z);
    let faces = [
        quad(lo, z, y),
        quad(lo, x, z),
        quad(lo, y, x),
        quad(hi, -y, -z),
        quad(hi, -z, -x),
        quad(hi, -x, -y),
    ];
    let mut all = Mesh {
        name: "box".to_owned(),
        ..Mesh::default()
    };
    for face in faces {
        let first = all.positions.len() as u32;
        all.positions.extend(face.positions);
        all.normals.extend(face.normals);
        let moved = face.triangles.iter().map(|t| t.map(|v| v + first));
        all.triangles.extend(moved);
        all.triangle_materials.extend([0, 0]);
    }
    all
}

/// What is left of light that goes straight down through a box of 1 m with another one of 0.5 m in it.
fn through_nested(outer: Material, inner: Material) -> Option<Film> {
    let device = device::open()?;
    let mut scene = scene(
        [
            (cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)), outer),
            (cuboid(Vec3::splat(-0.25), Vec3::splat(0.25)), inner),
            (
                cuboid(Vec3::new(-9.0, -2.0, -9.0), Vec3::new(9.0, -1.0, 9.0)),
                unlit(Vec3::ONE.extend(1.0)),
            ),
        ],
        Vec3::ZERO,
    );
    let shot = Shot {
        max_depth: 8,
        ..DIRECT
    };
    Some(render(&device, &mut scene, &from_above(3.0, 0.2), shot))
}

fn absorbing(ior: f32, absorption: Vec3, priority: i32) -> Material {
    Material {
        absorption,
        priority,
        ..body(ior)
    }
}

#[test]
fn inside_another_body_the_one_entered_last_or_the_higher_priority_counts() {
    let (outer, inner) = (Vec3::new(1.0, 0.2, 0.5), Vec3::new(0.1, 2.0, 0.5));
    let expected = |d: Vec3| (-d).exp();
    for (name, priorities, depth) in [
        ("equals", [0, 0], outer * 0.5 + inner * 0.5),
        ("inner first", [0, 1], outer * 0.5 + inner * 0.5),
        ("outer first", [1, 0], outer),
    ] {
        // Without refraction everything but the absorption cancels.
        let outer = absorbing(1.0, outer, priorities[0]);
        let inner = absorbing(1.0, inner, priorities[1]);
        let Some(film) = through_nested(outer, inner) else {
            return;
        };
        assert_uniform(name, &film, expected(depth));
    }
}

#[test]
fn a_camera_in_a_body_sees_what_is_in_there_with_it_through_the_body() {
    let Some(device) = device::open() else { return };
    let (water, ice) = (Vec3::new(1.0, 0.2, 0.5), Vec3::new(0.1, 2.0, 0.5));
    let card = quad(Vec3::new(-0.2, -0.4, -0.2), Vec3::Z * 0.4, Vec3::X * 0.4);
    // From 0.7 m above the card in water, or 0.3 m above it in ice that stands in the water.
    for (name, height, expected) in [("water", 0.3, water * 0.7), ("ice", -0.1, ice * 0.3)] {
        let parts = [
            (
                cuboid(Vec3::splat(-1.0), Vec3::splat(1.0)),
                absorbing(1.33, water, 0),
            ),
            (
                cuboid(Vec3::splat(-0.5), Vec3::new(0.5, 0.0, 0.5)),
                absorbing(1.31, ice, 1),
            ),
            (card.clone(), unlit(Vec3::ONE.extend(1.0))),
        ];
        let has_ice = height < 0.0;
        let parts = parts
            .into_iter()
            .enumerate()
            .filter(|&(number, _)| has_ice || number != 1);
        let mut scene = scene(parts.map(|(_, part)| part), Vec3::ZERO);
        let view = camera(
            Vec3::new(0.013, height, 0.017),
            Vec3::new(0.013, -1.0, 0.017),
            Vec3::X,
            Projection::Perspective { y_fov: 0.02 },
        );
        let film = render(&device, &mut scene, &view, DIRECT);
        assert_uniform(name, &film, (-expected).exp());
    }
}

#[test]
fn what_is_reflected_inside_another_body_follows_the_ratio_of_their_indices() {
    // Straight on: two borders of air and water, two of water and glass; light goes to and fro between them.
    let Some(film) = through_nested(body(1.33), body(1.5)) else {
        return;
    };
    let lost = |n: f64| ((n - 1.0) / (n + 1.0)).powi(2);
    // Every ray that is reflected ends in the dark above or on the white ground below: incoherent slabs, one after the
    // other, whose reflections R and transmissions T = 1 - R add up as R / (1 - R).
    let series: f64 = [1.33, 1.5 / 1.33, 1.5 / 1.33, 1.33]
        .map(|n| lost(n) / (1.0 - lost(n)))
        .iter()
        .sum();
    let passing = 1.0 / (1.0 + series);
    let exact = Vec3::splat(passing as f32);
    assert_uniform("water and glass", &film, exact);
}

/// A place seen at an angle to the vertical, in radians.
fn aslant(angle: f32, seen: Vec3) -> Camera {
    camera(
        seen + 5.0 * Vec3::new(angle.sin(), angle.cos(), 0.0),
        seen,
        Vec3::Z,
        Projection::Perspective { y_fov: 0.002 },
    )
}

/// What a wide sheet of something black reflects of a white sky, seen at so many degrees: the mean of a channel.
fn reflected_aslant(device: &Device, material: Material, degrees: f32) -> f32 {
    let black = Material {
        base_color: Vec3::ZERO.extend(1.0),
        metallic: 0.0,
        double_sided: true,
        ..material
    };
    let mut scene = scene([(floor(9.0), black)], Vec3::ONE);
    let view = aslant(degrees.to_radians(), Vec3::ZERO);
    let film = render(device, &mut scene, &view, DIRECT);
    film.mean().iter().map(|pixel| pixel[1]).sum::<f32>() / film.pixels() as f32
}

#[test]
fn thin_panes_reflect_at_grazing_angles_whether_clear_or_not() {
    let Some(device) = device::open() else { return };
    let clear = reflected_aslant(&device, pane(Vec3::ZERO), 80.0);
    // Schlick's reflection.
    let right = 0.04 + 0.96 * (1.0 - 80f32.to_radians().cos()).powi(5);
    assert!((clear - right).abs() < 0.01, "clear: {clear}, {right}");
    let rough = Material {
        roughness: 0.1,
        ..pane(Vec3::ZERO)
    };
    let glowing = Material {
        emission: Vec3::splat(1e-4),
        ..pane(Vec3::ZERO)
    };
    let coated = Material {
        coat: 0.001,
        ..pane(Vec3::ZERO)
    };
    for (name, material) in [("rough", rough), ("glowing", glowing), ("coated", coated)] {
        let found = reflected_aslant(&device, material, 80.0);
        assert!((found - clear).abs() < 0.04, "{name}: {found}, {clear}");
    }
}

#[test]
fn films_of_nearly_nothing_are_nearly_none() {
    let Some(device) = device::open() else { return };
    let black = Material {
        roughness: 0.0,
        ..Material::default()
    };
    for degrees in [0.0, 60.0, 80.0] {
        let bare = reflected_aslant(&device, black.clone(), degrees);
        // Index, thickness in nanometres, and how much a film may change: by the formula 0.017 and 0.04 at 80 degrees.
        for (ior, thickness, most) in [
            (1.3, 0.0, 0.005),
            (1.0, 400.0, 0.005),
            (1.3, 0.001, 0.03),
            (1.02, 1.0, 0.06),
        ] {
            let film = Material {
                iridescence: 1.0,
                iridescence_ior: ior,
                iridescence_thickness: [thickness; 2],
                ..black.clone()
            };
            let found = reflected_aslant(&device, film, degrees);
            assert!(
                (found - bare).abs() < most,
                "{thickness} nm of index {ior}, {degrees} degrees: {found}, without {bare}"
            );
        }
    }
}

#[test]
fn what_is_nearly_alike_hardly_reflects_at_grazing_angles_either() {
    let Some(device) = device::open() else { return };
    let index = 1.01;
    let objects = [
        (floor(9.0), lamp(Vec3::ONE)),
        (plate(0.02, 0.04), body(index)),
    ];
    let mut scene = scene(objects, Vec3::ZERO);
    let slant = 80f32.to_radians();
    let view = aslant(slant, Vec3::Y * 0.04);
    let film = render(&device, &mut scene, &view, DEEP);
    // Fresnel's reflection of unpolarised light, of two borders between which light goes to and fro.
    let (outside, inside) = (slant.cos(), (1.0 - (slant.sin() / index).powi(2)).sqrt());
    let of = |a: f32, b: f32| ((a - b) / (a + b)).powi(2);
    let reflected = 0.5 * (of(outside, index * inside) + of(index * outside, inside));
    let passing = (1.0 - reflected) / (1.0 + reflected);
    let mean = film.mean().into_iter().map(Vec3::from).sum::<Vec3>() / film.pixels() as f32;
    assert!((mean.y - passing).abs() < 0.01, "{mean}, {passing}");
}

#[test]
fn overlapping_bodies_of_one_glass_are_one_body() {
    let Some(device) = device::open() else { return };
    let view = |boxes: &[(f32, f32)]| {
        let glass = absorbing(1.5, Vec3::new(0.2, 1.0, 3.0), 0);
        let parts = boxes.iter().map(|&(from, to)| {
            let (lo, hi) = (Vec3::new(from, -0.3, -0.3), Vec3::new(to, 0.3, 0.3));
            (cuboid(lo, hi), glass.clone())
        });
        let mut scene = scene(parts, Vec3::splat(0.1));
        scene
            .lights
            .push(sun(Vec3::new(0.3, -1.0, 0.2).normalize(), Vec3::ONE));
        add(
            &mut scene,
            floor(5.0),
            unlit(Vec3::new(0.3, 0.5, 0.7).extend(1.0)),
        );
        let camera = camera(
            Vec3::new(0.8, 2.0, 2.0),
            Vec3::ZERO,
            Vec3::Y,
            Projection::Orthographic { y_mag: 0.4 },
        );
        let shot = Shot {
            size: (16, 16),
            max_depth: 24,
            spp: 1024,
        };
        render(&device, &mut scene, &camera, shot)
    };
    // Two materials of the same kind: the scene gives each mesh its own.
    assert_same(
        "one body",
        &view(&[(-0.6, 0.1), (-0.1, 0.6)]),
        &view(&[(-0.6, 0.6)]),
    );
}

/// Borders inside bodies take rounds in which nothing scatters, also where all bodies are shells of one mesh.
#[test]
fn overlapping_shells_of_one_mesh_are_seen_through() {
    let Some(device) = device::open() else { return };
    let absorption = Vec3::new(1.0, 0.2, 0.5);
    let mut shells = Mesh::default();
    for i in 0..8 {
        let top = 0.7 - 0.1 * i as f32;
        let shell = cuboid(Vec3::new(-1.0, top - 0.15, -1.0), Vec3::new(1.0, top, 1.0));
        let first = shells.positions.len() as u32;
        shells.positions.extend(shell.positions);
        shells.normals.extend(shell.normals);
        let moved = shell.triangles.iter().map(|t| t.map(|v| v + first));
        shells.triangles.extend(moved);
        shells.triangle_materials.extend(shell.triangle_materials);
    }
    let ground = cuboid(Vec3::new(-9.0, -2.0, -9.0), Vec3::new(9.0, -1.0, 9.0));
    let objects = [
        (shells, absorbing(1.0, absorption, 0)),
        (ground, unlit(Vec3::ONE.extend(1.0))),
    ];
    let mut scene = scene(objects, Vec3::ZERO);
    let shot = Shot {
        max_depth: 4,
        ..DIRECT
    };
    let film = render(&device, &mut scene, &from_above(3.0, 0.2), shot);
    assert_uniform("shells", &film, (-absorption * 0.85).exp());
}

#[test]
fn dispersion_keeps_white_light_white() {
    let Some(device) = device::open() else { return };
    let glass = Material {
        dispersion: 5.0,
        ..body(1.6)
    };
    let mut scene = scene([(faceted_sphere(12), glass)], Vec3::ONE);
    let camera = camera(
        Vec3::Z * 4.0,
        Vec3::ZERO,
        Vec3::Y,
        Projection::Orthographic { y_mag: 0.5 },
    );
    let shot = Shot {
        size: (12, 12),
        max_depth: 40,
        spp: 1024,
    };
    let film = render(&device, &mut scene, &camera, shot);
    assert_uniform("furnace", &film, Vec3::ONE);
}

#[test]
fn a_prism_bends_blue_more_than_red() {
    let Some(device) = device::open() else { return };
    // A wedge, thicker towards +x, above a ground that is white only on the side of +x.
    let mut wedge = cuboid(Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, 1.2, 1.0));
    for p in &mut wedge.positions {
        if p.y > 1.1 {
            p.y += 0.5 * (p.x + 1.0);
        }
    }
    for triangle in &wedge.triangles {
        let [a, b, c] = triangle.map(|v| wedge.positions[v as usize]);
        for v in triangle {
            wedge.normals[*v as usize] = (b - a).cross(c - a).normalize();
        }
    }
    let glass = Material {
        dispersion: 10.0,
        ..body(1.5)
    };
    let white = quad(Vec3::new(0.0, 0.0, 5.0), Vec3::X * 5.0, Vec3::NEG_Z * 10.0);
    let mut scene = scene(
        [(wedge, glass), (white, unlit(Vec3::ONE.extend(1.0)))],
        Vec3::ZERO,
    );
    let shot = Shot {
        size: (32, 32),
        max_depth: 6,
        spp: 256,
    };
    let film = render(&device, &mut scene, &from_above(4.0, 0.8), shot);
    let light = |c: usize| film.mean().iter().map(|p| f64::from(p[c])).sum::<f64>();
    let (red, green, blue) = (light(0), light(1), light(2));
    // Light bends towards the thick end, so more of the picture sees the white side: the more, the higher the index.
    assert!(red * 1.01 < green, "red {red}, green {green}");
    assert!(green * 1.01 < blue, "green {green}, blue {blue}");
}

/// A unit sphere whose normals say that it is round.
fn smooth_sphere(rings: u32) -> Mesh {
    let mut mesh = faceted_sphere(rings);
    mesh.normals.clone_from(&mesh.positions);
    mesh
}

#[test]
fn coarse_meshes_with_smooth_normals_have_no_dark_facets() {
    let Some(device) = device::open() else { return };
    let view = |rings: u32| {
        let mut scene = scene([(smooth_sphere(rings), lambert(Vec3::ONE))], Vec3::ZERO);
        // Ten degrees to the front of the right: the facets left of the middle face 11.25 degrees to the left, away from it.
        let angle = 10.0_f32.to_radians();
        let sun = sun(-Vec3::new(angle.cos(), 0.0, angle.sin()), Vec3::splat(PI));
        scene.lights.push(sun);
        let camera = camera(
            Vec3::new(0.0, 0.0, 4.0),
            Vec3::ZERO,
            Vec3::Y,
            Projection::Orthographic { y_mag: 0.6 },
        );
        render(&device, &mut scene, &camera, DIRECT)
    };
    let (coarse, fine) = (view(8), view(128));
    // Those facets, which are grazed by the sun where their normals are asked.
    let grazed = |film: &Film| {
        let pixels = film.mean();
        let rows = 4..12;
        rows.map(|y| {
            (6..8)
                .map(|x| f64::from(pixels[y * 16 + x][1]))
                .sum::<f64>()
        })
        .sum::<f64>()
    };
    let ratio = grazed(&coarse) / grazed(&fine);
    assert!((0.9..1.1).contains(&ratio), "grazed facets: {ratio}");
}

#[test]
fn coarse_meshes_with_smooth_normals_have_no_dark_rim() {
    let Some(device) = device::open() else { return };
    for rings in [6, 8, 16] {
        let mut scene = scene([(smooth_sphere(rings), lambert(Vec3::ONE))], Vec3::ONE);
        let camera = camera(
            Vec3::new(0.0, 1.0, 4.0),
            Vec3::ZERO,
            Vec3::Y,
            Projection::Orthographic { y_mag: 1.1 },
        );
        let shot = Shot {
            size: (48, 48),
            max_depth: 4,
            spp: 64,
        };
        // Where its triangles are seen the normals of their corners face away, where all is white.
        let film = render(&device, &mut scene, &camera, shot);
        let darkest = film.mean().iter().map(|pixel| pixel[1]).reduce(f32::min);
        let darkest = darkest.expect("there are pixels");
        assert!(darkest > 0.93, "{rings} rings: {darkest}");
    }
}

#[test]
fn nothing_leaks_into_a_coarse_sphere() {
    let Some(device) = device::open() else { return };
    let shell = Material {
        double_sided: true,
        ..lambert(Vec3::ONE)
    };
    let mut scene = scene([(smooth_sphere(6), shell)], Vec3::ONE);
    scene.lights.push(sun(Vec3::NEG_X, Vec3::splat(PI)));
    scene.instances.push(Instance {
        name: "again".to_owned(),
        mesh: 0,
        transform: Affine3A::from_translation(Vec3::X * 1.7),
        asset: None,
    });
    let camera = camera(
        Vec3::ZERO,
        Vec3::X,
        Vec3::Y,
        Projection::Perspective { y_fov: 2.0 },
    );
    let shot = Shot {
        max_depth: 6,
        ..DIRECT
    };
    let film = render(&device, &mut scene, &camera, shot);
    assert!(film.mean().iter().all(|pixel| *pixel == [0.0; 3]));
}
