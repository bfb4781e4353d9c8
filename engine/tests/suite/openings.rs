//! Light samples of the sky through openings of the box around the scene: their density is what they, and rays that get there by chance,
//! are told, so that the sky is as bright as without them. Skipped with a notice where there is no adapter.

use std::sync::Arc;

use ::device::{Format, ImageUse};
use bytemuck::Zeroable;
use engine::scene::{Environment, FloatImage};
use glam::{DVec3, Vec3};

use crate::lights::{Harness, Params, solid_angle};
use crate::support::scenes::{lambert, quad, scene};

const SAMPLES: u32 = 1 << 17;

/// Parts of the sky, openings, squares along a side of the box: as in `shared/sky_parts.wgsl` and `shared/openings.wgsl`.
const PARTS: usize = 512;
const OPENINGS: usize = 64;
const SQUARES: usize = 128;
const COLUMNS: usize = SQUARES / 8;
const TEXELS: usize = (PARTS + OPENINGS) / 4 + 1 + COLUMNS;
const ROWS: usize = 6 * SQUARES + OPENINGS.div_ceil(COLUMNS);

/// Corners of the box.
const LOW: Vec3 = Vec3::new(-2.0, 0.0, -3.0);
const HIGH: Vec3 = Vec3::new(2.0, 3.0, 3.0);

/// A side of the box, first column and row and those behind the last, and how likely it is chosen.
type Opening = (usize, [usize; 4], f32);

/// In a wall, in the ceiling, and in the wall across.
const WINDOWS: [Opening; 3] = [
    (1, [40, 20, 90, 60], 0.5),
    (3, [10, 100, 30, 128], 0.2),
    (4, [0, 64, 64, 65], 0.3),
];

/// The point of a side at a place in [0, 1].
fn point([side, column, row]: [usize; 3]) -> Vec3 {
    let axis = side / 2;
    let mut point = if side % 2 == 1 { HIGH } else { LOW };
    let at = |axis: usize, square: usize| {
        LOW[axis] + (HIGH - LOW)[axis] * square as f32 / SQUARES as f32
    };
    let (across, along) = ((axis + 1) % 3, (axis + 2) % 3);
    (point[across], point[along]) = (at(across, column), at(along, row));
    point
}

fn corners((side, [left, top, right, bottom], _): &Opening) -> [Vec3; 4] {
    [
        [*left, *top],
        [*right, *top],
        [*right, *bottom],
        [*left, *bottom],
    ]
    .map(|[column, row]| point([*side, column, row]))
}

/// What is known of the sky: all parts are as likely, and so many of four samples go through the windows.
fn known(share: f32) -> Vec<f32> {
    let mut image = vec![0.0; 4 * TEXELS * ROWS];
    for (i, to) in image[..PARTS].iter_mut().enumerate() {
        *to = (i + 1) as f32 / PARTS as f32;
    }
    let mut sum = 0.0;
    for (i, to) in image[PARTS..][..OPENINGS].iter_mut().enumerate() {
        sum += WINDOWS.get(i).map_or(0.0, |window| window.2);
        *to = if i + 1 < WINDOWS.len() { sum } else { 1.0 };
    }
    image[PARTS + OPENINGS] = 1.0;
    image[PARTS + OPENINGS + 1] = share;
    let last = 4 * (TEXELS - COLUMNS);
    for (i, window) in WINDOWS.iter().enumerate() {
        let &(side, [left, top, right, bottom], _) = window;
        for row in top..bottom {
            for column in left..right {
                let at = 4 * TEXELS * (side * SQUARES + row) + last + column / 2;
                image[at] += [1.0, 256.0][column % 2] * (i + 1) as f32;
            }
        }
        let [a, b, _, d] = corners(window);
        let area = (b - a).cross(d - a).length();
        let at = 4 * TEXELS * (6 * SQUARES) + last + 4 * i;
        let corner = |column: usize, row: usize| (column + 256 * row) as f32;
        let record = [
            corner(left, top),
            corner(right, bottom),
            side as f32,
            1.0 / area,
        ];
        image[at..at + 4].copy_from_slice(&record);
    }
    image
}

/// Whether a ray leaves the box by a window.
fn leaves_by((side, [left, top, right, bottom], _): &Opening, from: Vec3, to: Vec3) -> bool {
    let axis = side / 2;
    let plane = if side % 2 == 1 { HIGH } else { LOW }[axis];
    let distance = (plane - from[axis]) / to[axis];
    let place = (from + to * distance - LOW) / (HIGH - LOW) * SQUARES as f32;
    let within = |axis: usize, low: usize, high: usize| {
        place[axis] >= low as f32 && place[axis] <= high as f32
    };
    distance > 0.0 && within((axis + 1) % 3, *left, *right) && within((axis + 2) % 3, *top, *bottom)
}

#[test]
fn samples_have_the_density_that_they_are_told() {
    let z = Vec3::Z * 6.0;
    let mut scene = scene(
        [
            (quad(LOW, z, Vec3::X * 4.0), lambert(Vec3::ONE)),
            (quad(HIGH, -z, Vec3::X * -4.0), lambert(Vec3::ONE)),
        ],
        Vec3::ZERO,
    );
    let (width, height) = (64, 32);
    scene.environment = Environment::Image {
        image: Arc::new(FloatImage {
            width,
            height,
            rgb: (0..width * height)
                .map(|i| [1.0 + (i % 7) as f32; 3])
                .collect(),
        }),
        rotation: 50.0,
        intensity: 1.0,
    };
    let Some(mut harness) = Harness::with_sky(&scene, true) else {
        return;
    };
    let size = [TEXELS as u32, ROWS as u32];
    let [columns, rows] = size;
    let image = harness
        .device
        .image(
            "known sky",
            ImageUse::Read,
            [columns, rows, 1],
            Format::Rgba32Float,
        )
        .expect("there is room");
    harness.resources.set_image("known_sky", image.clone());
    for share in [0.0, 0.75] {
        let texels = known(share);
        image.write(&harness.device, [0; 3], size, bytemuck::cast_slice(&texels));
        // Inside, near a window, and where a window is seen along its wall.
        for from in [
            Vec3::new(0.3, 1.0, -0.4),
            Vec3::new(1.9, 1.4, -1.5),
            Vec3::new(-1.2, 2.0, -2.99),
        ] {
            let mut params = Params::zeroed();
            params.position = from;
            let empty = vec![[0.0; 4]; 2 * SAMPLES as usize];
            let out = harness.run("seen", params, &empty, SAMPLES);
            let differ = (out.chunks_exact(2))
                .filter(|s| (s[0][3] / s[1][0] - 1.0).abs() > 1e-2)
                .count();
            // At borders of windows and of parts, a direction may be found on the other side.
            assert!(differ < SAMPLES as usize / 200, "{from}: {differ}");
            let angle = |name: &str, exact: f64, counts: &dyn Fn(Vec3) -> bool| {
                let value = |s: &[[f32; 4]]| match counts(Vec3::new(s[0][0], s[0][1], s[0][2])) {
                    true => 1.0 / f64::from(s[0][3]),
                    false => 0.0,
                };
                let n = f64::from(SAMPLES);
                let mean = out.chunks_exact(2).map(value).sum::<f64>() / n;
                let square = out.chunks_exact(2).map(|s| value(s).powi(2)).sum::<f64>() / n;
                let error = ((square - mean * mean).max(0.0) / n).sqrt();
                assert!(
                    (mean - exact).abs() < 5.0 * error + 0.003 * exact,
                    "{from}, {share}: {name} is {mean} +- {error}, not {exact}"
                );
                error / exact
            };
            angle("all around", 4.0 * std::f64::consts::PI, &|_| true);
            for (i, window) in WINDOWS.iter().enumerate() {
                let [a, b, c, d] =
                    corners(window).map(|corner| DVec3::from(corner - from).normalize());
                let exact = solid_angle([a, b, c]) + solid_angle([a, c, d]);
                let error = angle(&format!("window {i}"), exact, &|to| {
                    leaves_by(window, from, to)
                });
                println!("{from}, {share}: window {i} {exact:.4}, {error:.4} of it uncertain");
            }
        }
    }
}
