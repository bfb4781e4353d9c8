//! Makes the demo scene that ships with Patina: an old gate valve in the corner of an arcade.
//!
//! `cargo run --example make_demo_scene` writes `examples/demo/demo.gltf`, `examples/skylight.gltf` and the ball of
//! `examples/gallery` with their `.bin`, which are committed; run it again only to change them. It uses nothing of the renderer.

mod gallery;
mod gltf;
mod mesh;
mod shapes;
mod valve;

use std::f32::consts::{FRAC_PI_2, PI};
use std::path::Path;

use glam::{Affine3A, EulerRot, Quat, Vec2, Vec3};

use gltf::{Place, Writer};
use mesh::Shape;
use shapes::{
    arch_wall, block, circle, cuboid, gear, hexagon_head, lathe, rounded, tube, voussoirs,
};

/// Faces that meet at less than this look smooth.
pub(crate) const CREASE: f32 = 1.1;

fn main() -> std::io::Result<()> {
    let mut out = Writer::default();
    arcade(&mut out);
    valve::valve(
        &mut out,
        Place::at(0.0, 0.3, 0.0)
            .turned(Quat::from_rotation_y(0.42))
            .scaled(0.98),
    );
    still_life(&mut out);
    landscape(&mut out);

    let lamp = out.light("Window", [1.0, 0.84, 0.64], 60.0);
    let pane = out.mesh("Window", &pane(0.8, 0.8).finish(CREASE), lamp);
    let (from, to) = (Vec3::new(3.1, 3.6, 2.5), Vec3::new(0.0, 0.7, 0.0));
    let facing = Quat::from_rotation_arc(Vec3::NEG_Y, (to - from).normalize());
    out.node(
        "Window",
        Some(pane),
        Place::at(from.x, from.y, from.z).turned(facing),
        None,
    );

    out.camera(
        "Camera",
        Vec3::new(1.5, 1.46, 3.55),
        Vec3::new(-0.02, 0.82, 0.0),
        33.0,
    );

    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let size = out.write(&examples.join("demo"), "demo")?;
    println!("examples/demo/demo.gltf: {} kB", size / 1000);
    let size = skylight().write(&examples, "skylight")?;
    println!("examples/skylight.gltf: {size} bytes");
    let size = gallery::gallery().write(&examples.join("gallery"), "gallery")?;
    println!("examples/gallery/gallery.gltf: {} kB", size / 1000);
    Ok(())
}

/// Light for a hall whose roof is open: the sky as a lamp above the opening, which is found far more often than a sky
/// that only a few bounces reach, and the sun.
fn skylight() -> Writer {
    let mut out = Writer::default();
    let sky = out.light("Sky", [0.80, 0.91, 1.0], 26.0);
    // The sun shines through the gap between both panes.
    for (from, to) in [(-13.0, 3.6), (6.0, 13.0)] {
        let pane = out.mesh("Sky", &pane((to - from) / 2.0, 4.0).finish(CREASE), sky);
        out.node(
            "Sky",
            Some(pane),
            Place::at((from + to) / 2.0, 12.5, 0.0),
            None,
        );
    }
    out.sun("Sun", Vec3::new(-0.35, -1.0, 0.08), [1.0, 0.88, 0.70], 22.0);
    out
}

/// A rectangle that faces down.
fn pane(half_x: f32, half_z: f32) -> Shape {
    let mut shape = Shape::default();
    shape.flat_face(&[
        Vec3::new(-half_x, 0.0, -half_z),
        Vec3::new(half_x, 0.0, -half_z),
        Vec3::new(half_x, 0.0, half_z),
        Vec3::new(-half_x, 0.0, half_z),
    ]);
    shape
}

/// Two rows of arches that meet in a corner, on a floor of stone slabs.
fn arcade(out: &mut Writer) {
    const BAY: f32 = 1.66;
    const RADIUS: f32 = 0.66;
    const SPRING: f32 = 1.62;
    let stone = out.material("Stone", [0.52, 0.46, 0.38], 0.0, 0.75);
    let plaster = out.material("Plaster", [0.66, 0.55, 0.41], 0.0, 0.9);
    let floor = out.material("Floor", [0.34, 0.29, 0.24], 0.0, 0.55);

    let slabs = out.mesh("Floor slabs", &slabs().finish(CREASE), floor);
    out.node("Floor slabs", Some(slabs), Place::at(0.0, 0.0, 0.0), None);

    let column = out.mesh("Column", &column(SPRING).finish(CREASE), stone);
    let ring = out.mesh(
        "Arch stones",
        &voussoirs(RADIUS, RADIUS + 0.16, 0.4, 15).finish(CREASE),
        stone,
    );
    let wall = out.mesh(
        "Wall",
        &arch_wall(BAY, 1.25, RADIUS + 0.12, 0.34).finish(0.5),
        plaster,
    );
    let cornice = cuboid(
        Vec3::new(-BAY / 2.0, 0.0, -0.26),
        Vec3::new(BAY / 2.0, 0.12, 0.26),
        0.02,
    );
    let cornice = out.mesh("Cornice", &cornice.finish(CREASE), stone);

    let corner = Vec3::new(-2.15, 0.0, -1.75);
    let along_x = (Vec3::X, Quat::IDENTITY, 3);
    let along_z = (Vec3::Z, Quat::from_rotation_y(FRAC_PI_2), 2);
    out.node(
        "Column",
        Some(column),
        Place::at(corner.x, 0.0, corner.z),
        None,
    );
    for (direction, turn, bays) in [along_x, along_z] {
        for bay in 0..bays {
            let middle = corner + direction * BAY * (bay as f32 + 0.5) + Vec3::Y * SPRING;
            let end = corner + direction * BAY * (bay + 1) as f32;
            let place = |p: Vec3| Place::at(p.x, p.y, p.z).turned(turn);
            out.node("Column", Some(column), place(end), None);
            out.node("Arch stones", Some(ring), place(middle), None);
            out.node("Wall", Some(wall), place(middle), None);
            out.node(
                "Cornice",
                Some(cornice),
                place(middle + Vec3::Y * 1.25),
                None,
            );
        }
    }

    // A low wall closes the left arcade, so that the sky stands only in the far one.
    let mut parapet = Shape::default();
    for i in 0..6 {
        let x = -1.66 + i as f32 * 0.5533;
        let shade = Vec3::new(0.0, 0.012 * ((i * 7 % 5) as f32 - 2.0), 0.0);
        let stone = cuboid(
            Vec3::new(x + 0.004, 0.0, -0.14),
            Vec3::new(x + 0.549, 0.62, 0.14) + shade,
            0.014,
        );
        parapet.add(&stone, Affine3A::IDENTITY);
    }
    let parapet = out.mesh("Parapet", &parapet.finish(CREASE), stone);
    let at = corner + Vec3::Z * BAY;
    out.node(
        "Parapet",
        Some(parapet),
        Place::at(at.x, 0.0, at.z).turned(Quat::from_rotation_y(FRAC_PI_2)),
        None,
    );
}

/// Slabs in two rows' bond, each a little lower or higher than its neighbours.
fn slabs() -> Shape {
    let mut shape = Shape::default();
    let (w, d, gap) = (0.62, 0.46, 0.009);
    for row in -5i32..9 {
        for column in -5i32..7 {
            let shift = if row.rem_euclid(2) == 0 { 0.0 } else { w / 2.0 };
            let (x, z) = (column as f32 * w + shift, row as f32 * d);
            let noise = |k: i32| {
                (((column * 53 + row * 91 + k * 37).rem_euclid(17)) as f32 / 8.0 - 1.0) * 0.003
            };
            let corner = |i: usize| {
                Vec3::new(
                    if i & 1 == 0 { x + gap } else { x + w - gap },
                    if i & 2 == 0 {
                        -0.05
                    } else {
                        noise(0) + noise(i as i32) * 0.4
                    },
                    if i & 4 == 0 { z + gap } else { z + d - gap },
                )
            };
            shape.add(
                &block(&std::array::from_fn(corner), 0.006),
                Affine3A::IDENTITY,
            );
        }
    }
    let ground = -0.018;
    let (a, b) = (-5.0 * w, 7.5 * w);
    let (c, e) = (-5.0 * d, 9.0 * d);
    shape.flat_face(&[
        Vec3::new(a, ground, e),
        Vec3::new(b, ground, e),
        Vec3::new(b, ground, c),
        Vec3::new(a, ground, c),
    ]);
    shape
}

/// A Tuscan column of `height`, with square plinth and abacus.
fn column(height: f32) -> Shape {
    let mut profile = rounded(
        &[
            (0.0, 0.1),
            (0.2, 0.1),
            (0.215, 0.13),
            (0.2, 0.17),
            (0.165, 0.175),
            (0.16, 0.2),
            (0.145, 0.23),
        ],
        0.02,
        3,
    );
    let top = height - 0.22;
    for i in 1..=8 {
        // Entasis: the shaft narrows towards the top, and not in a straight line.
        let t = i as f32 / 9.0;
        profile.push(Vec2::new(
            0.145 - 0.025 * t.powf(1.8),
            0.23 + (top - 0.23) * t,
        ));
    }
    profile.extend(rounded(
        &[
            (0.12, top),
            (0.14, top + 0.012),
            (0.14, top + 0.035),
            (0.122, top + 0.045),
            (0.122, top + 0.08),
            (0.19, top + 0.13),
            (0.19, top + 0.14),
            (0.0, top + 0.14),
        ],
        0.012,
        3,
    ));
    let mut shape = lathe(&profile, 40);
    let square = |half: f32, from: f32, to: f32| {
        cuboid(
            Vec3::new(-half, from, -half),
            Vec3::new(half, to, half),
            0.01,
        )
    };
    shape.add(&square(0.225, 0.0, 0.1), Affine3A::IDENTITY);
    shape.add(&square(0.215, top + 0.13, height), Affine3A::IDENTITY);
    shape
}

/// What lies around the valve: its plinth, an oil can, gears, nuts.
fn still_life(out: &mut Writer) {
    let block_stone = out.material("Plinth", [0.45, 0.42, 0.38], 0.0, 0.8);
    let plinth = cuboid(
        Vec3::new(-0.46, 0.0, -0.36),
        Vec3::new(0.46, 0.3, 0.36),
        0.022,
    );
    let plinth = out.mesh("Plinth", &plinth.finish(CREASE), block_stone);
    out.node(
        "Plinth",
        Some(plinth),
        Place::at(0.0, 0.0, 0.0).turned(Quat::from_rotation_y(0.36)),
        None,
    );

    let copper = out.material("Copper", [0.93, 0.55, 0.40], 1.0, 0.22);
    let can = out.mesh("Oil can", &oil_can().finish(CREASE), copper);
    out.node(
        "Oil can",
        Some(can),
        Place::at(0.6, 0.003, 0.56).turned(Quat::from_rotation_y(-0.5)),
        None,
    );

    let steel = out.material("Steel", [0.60, 0.59, 0.57], 1.0, 0.28);
    let large = out.mesh("Gear", &gear(0.27, 28, 0.085).finish(CREASE), steel);
    let lean = Quat::from_euler(EulerRot::YXZ, 0.25, FRAC_PI_2 - 0.3, 0.0);
    out.node(
        "Gear",
        Some(large),
        Place::at(-0.52, 0.258, 0.52).turned(lean),
        None,
    );
    let small = out.mesh("Pinion", &gear(0.12, 15, 0.07).finish(CREASE), steel);
    out.node(
        "Pinion",
        Some(small),
        Place::at(0.12, 0.003, 0.66).turned(Quat::from_rotation_y(0.3)),
        None,
    );

    let nut = out.mesh("Nut", &nut().finish(0.9), steel);
    for (x, z, turn) in [(-0.1, 0.78, 0.2), (0.0, 0.9, 0.9), (0.86, 0.2, 0.5)] {
        out.node(
            "Nut",
            Some(nut),
            Place::at(x, 0.003, z).turned(Quat::from_rotation_y(turn)),
            None,
        );
    }
}

fn nut() -> Shape {
    let ring =
        |r: f32, y: f32| -> Vec<Vec3> { circle(r, 6).iter().map(|&p| p + Vec3::Y * y).collect() };
    let rings = [
        ring(0.021, 0.0),
        ring(0.042, 0.0),
        ring(0.042, 0.034),
        ring(0.021, 0.034),
    ];
    let mut shape = Shape::default();
    for i in 0..4 {
        let (a, b) = (&rings[i], &rings[(i + 1) % 4]);
        for s in 0..6 {
            let next = (s + 1) % 6;
            shape.flat_face(&[a[s], a[next], b[next], b[s]]);
        }
    }
    shape
}

/// A conical can with a long spout and a handle.
fn oil_can() -> Shape {
    let profile = rounded(
        &[
            (0.0, 0.0),
            (0.125, 0.0),
            (0.13, 0.015),
            (0.13, 0.085),
            (0.122, 0.095),
            (0.05, 0.19),
            (0.045, 0.2),
            (0.045, 0.215),
            (0.032, 0.222),
            (0.026, 0.25),
            (0.0, 0.255),
        ],
        0.012,
        4,
    );
    let mut shape = lathe(&profile, 48);
    let spout: Vec<Vec3> = (0..=20)
        .map(|i| i as f32 / 20.0)
        .map(|t| Vec3::new(0.36 * t * t, 0.24 + 0.22 * t - 0.045 * t * t, 0.0))
        .collect();
    shape.add(
        &tube(&spout, |t| 0.021 - 0.015 * t, 16, false),
        Affine3A::IDENTITY,
    );
    let handle: Vec<Vec3> = (0..=24)
        .map(|i| PI * (0.42 + 1.06 * i as f32 / 24.0))
        .map(|a| Vec3::new(-0.085 + 0.1 * a.cos(), 0.13 + 0.085 * a.sin(), 0.0))
        .collect();
    shape.add(&tube(&handle, |_| 0.009, 12, false), Affine3A::IDENTITY);
    shape
}

/// What is seen through the arches: a meadow and three rows of hills.
fn landscape(out: &mut Writer) {
    let meadow = out.material("Meadow", [0.16, 0.19, 0.07], 0.0, 1.0);
    let mut ground = Shape::default();
    let size = 160.0;
    ground.flat_face(&[
        Vec3::new(-size, -0.12, size),
        Vec3::new(size, -0.12, size),
        Vec3::new(size, -0.12, -size),
        Vec3::new(-size, -0.12, -size),
    ]);
    let ground = out.mesh("Meadow", &ground.finish(CREASE), meadow);
    out.node("Meadow", Some(ground), Place::at(0.0, 0.0, 0.0), None);

    let rows = [
        ("Near hills", 24.0, 1.7, [0.10, 0.14, 0.06]),
        ("Middle hills", 52.0, 5.0, [0.15, 0.20, 0.17]),
        ("Far hills", 110.0, 13.0, [0.25, 0.33, 0.40]),
    ];
    for (seed, (name, distance, height, color)) in (1u16..).zip(rows) {
        let material = out.material(name, color, 0.0, 1.0);
        let mut shape = Shape::default();
        let crest = |i: usize| {
            let angle = PI * (0.02 + 0.96 * i as f32 / 96.0);
            let t = angle * 7.0 + f32::from(seed) * 2.1;
            let wave =
                0.55 + 0.28 * t.sin() + 0.17 * (2.3 * t + 1.0).sin() + 0.06 * (6.1 * t).sin();
            (
                Vec3::new(
                    angle.cos() * distance,
                    0.0,
                    -angle.sin().max(0.2) * distance,
                ),
                wave * height,
            )
        };
        for i in 0..96 {
            let ((right, right_top), (left, left_top)) = (crest(i), crest(i + 1));
            let back = |p: Vec3, top: f32| p * 1.12 + Vec3::Y * top;
            shape.flat_face(&[
                left - Vec3::Y,
                right - Vec3::Y,
                back(right, right_top),
                back(left, left_top),
            ]);
        }
        let mesh = out.mesh(name, &shape.finish(1.2), material);
        out.node(name, Some(mesh), Place::at(0.0, 0.0, 0.0), None);
    }
}

/// Used by the valve too: a bolt's head with a washer.
pub(crate) fn bolt_head(width: f32, height: f32) -> Shape {
    let washer = rounded(
        &[
            (width * 0.62, 0.0),
            (width * 0.62, height * 0.2),
            (0.0, height * 0.2),
        ],
        0.002,
        2,
    );
    let mut shape = lathe(&washer, 20);
    shape.add(
        &hexagon_head(width, height),
        Affine3A::from_translation(Vec3::Y * height * 0.2),
    );
    shape
}
