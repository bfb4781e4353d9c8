//! The textures that ship with Patina, and the standard functions: finite, within what they say, and without patterns that random
//! numbers must not have.

use std::path::Path;

use device::{Device, DeviceChoice};
use engine::evaluate::{Evaluator, Point};
use engine::isolated::{Isolated, Subject};
use engine::procedural::TextureSources;
use texgen::{OutputType, ParameterType, TextureType, Value};

use crate::support::device::open_driver;

fn native() -> Device {
    let name = DeviceChoice::Name("native".to_owned());
    Device::open(&name).unwrap_or_else(|error| panic!("{error}"))
}

fn standard() -> TextureSources {
    let nowhere: [&Path; 0] = [];
    TextureSources::search(&nowhere).expect("nothing to list")
}

fn evaluator(device: &Device, sources: &TextureSources, name: &str) -> Evaluator {
    let isolated = Isolated::new(Subject::Texture(name), sources);
    Evaluator::new(
        device,
        isolated.unwrap_or_else(|problems| panic!("{problems}")),
    )
}

/// Numbers in [0, 1) without a pattern.
fn random(n: u32) -> f32 {
    let state = n.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    ((word >> 22) ^ word) as f32 / 4_294_967_296.0
}

/// Surfaces of all kinds, near and far.
fn places(count: u32) -> Vec<Point> {
    (0..count)
        .map(|i| {
            let r = |k: u32| random(16 * i + k);
            let [x, y, z] = [r(0), r(1), r(2)].map(|v| 4.0 * v - 2.0);
            let [a, b, c] = [r(3), r(4), r(5)].map(|v| 2.0 * v - 1.0);
            let length = (a * a + b * b + c * c).sqrt().max(1e-3);
            let pixel = 10.0f32.powf(-4.0 + 5.0 * r(6));
            Point::new()
                .with("WorldPos", &[x, y, z])
                .with("Normal", &[a / length, b / length, c / length])
                .with("ViewDir", &[0.0, 0.0, 1.0])
                .with("TexCoord0", &[3.0 * r(7) - 1.0, 3.0 * r(8) - 1.0])
                .with("Footprint", &[pixel; 4])
                .with("AO", &[r(9); 4])
                .with("Curvature", &[100.0 * (r(10) - 0.5); 4])
                .with("ObjectRandom", &[r(11), r(12), r(13), r(14)])
                .with("InstanceId", &[i as f32; 4])
                .with("Time", &[10.0 * r(15); 4])
        })
        .collect()
}

/// Those whose first component isn't a share, a colour or a height between 0 and 1.
const UNBOUNDED: &[&str] = &["worley", "time", "flakes", "normal_map", "water"];

#[test]
fn every_standard_texture_gives_finite_values_in_its_range() {
    let (device, sources) = (native(), standard());
    let places = places(300);
    let names: Vec<&str> = sources.names().collect();
    assert!(names.len() >= 70, "{} textures", names.len());
    let mut wrong = Vec::new();
    for name in names {
        let file = sources.read(name).expect("is there").expect("is text");
        let texture = TextureType::parse(file).unwrap_or_else(|problems| panic!("{problems}"));
        let group = texture
            .group()
            .unwrap_or_else(|| panic!("{name} is in no group"));
        let mut evaluator = evaluator(&device, &sources, name);
        for parameter in texture.parameters() {
            if parameter.ty == ParameterType::Image {
                let image = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/images/demo.jpg");
                evaluator.set(&parameter.name, image).expect("an image");
            }
        }
        let values = evaluator
            .evaluate(&places)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let components = texture.output().components();
        let all = || values.iter().flat_map(|value| &value[..components]);
        let (low, high) = all().fold((f32::MAX, f32::MIN), |(low, high), &v| {
            (low.min(v), high.max(v))
        });
        let is_free =
            ["images", "colour", "coordinates"].contains(&group) || UNBOUNDED.contains(&name);
        // Colours may be brighter than white; noises with an amplitude of 0.5 reach a little beyond 0 and 1.
        let [least, most] = match texture.output() {
            OutputType::F32 => [-0.15, 1.15],
            _ => [-0.05, 2.1],
        };
        let is_within = low >= least && high <= most;
        if !all().all(|v| v.is_finite()) || !(is_free || is_within) {
            wrong.push(format!("{name}: {low} to {high}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Places all over space, seen by pixels so wide.
fn seen_by(pixel: f32, normal: [f32; 3]) -> Vec<Point> {
    let place = |i: u32| {
        let r = |k: u32| random(16 * i + k);
        Point::new()
            .with("WorldPos", &[0, 1, 2].map(|k| 8.0 * r(k) - 4.0))
            .with("TexCoord0", &[8.0 * r(3), 8.0 * r(4)])
            .with("Normal", &normal)
            .with("Footprint", &[pixel; 4])
    };
    (0..3000).map(place).collect()
}

/// Mean and standard deviation of what it is at the places, by component.
fn statistics(evaluator: &mut Evaluator, places: &[Point]) -> [[f32; 2]; 4] {
    let values = evaluator
        .evaluate(places)
        .unwrap_or_else(|error| panic!("{error}"));
    let count = values.len() as f64;
    std::array::from_fn(|c| {
        let all = || values.iter().map(|value| f64::from(value[c]));
        let mean = all().sum::<f64>() / count;
        let variance = all().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        [mean as f32, variance.sqrt() as f32]
    })
}

/// What is wrong with a texture from afar, if something is.
fn unlike_its_mean(
    evaluator: &mut Evaluator,
    [near, far]: [&[Point]; 2],
    components: usize,
) -> Vec<String> {
    let count = near.len() as f32;
    let (near, far) = (statistics(evaluator, near), statistics(evaluator, far));
    let mut wrong = Vec::new();
    for (c, ([near, spread], [far, deviation])) in
        near.into_iter().zip(far).take(components).enumerate()
    {
        // Four deviations of the mean of so many values.
        if (near - far).abs() > 0.04 + 4.0 * spread / count.sqrt() {
            wrong.push(format!("component {c}: {near} near, {far} far"));
        }
        if deviation > 0.01 {
            wrong.push(format!("component {c}: varies by {deviation} far away"));
        }
    }
    wrong
}

#[test]
fn from_afar_a_texture_is_its_mean() {
    let (device, sources) = (native(), standard());
    let up = [0.0, 0.0, 1.0];
    let (near, far) = (seen_by(1e-5, up), seen_by(60.0, up));
    let mut wrong = Vec::new();
    for name in sources.names() {
        let file = sources.read(name).expect("is there").expect("is text");
        let texture = TextureType::parse(file).unwrap_or_else(|problems| panic!("{problems}"));
        let group = texture.group().unwrap_or_default();
        // What covers the whole of space, and doesn't hang on things that the places lack.
        let covers = ["noise", "patterns", "materials"].contains(&group)
            && !["gradient", "white_noise"].contains(&name);
        if !covers && !["moss", "flakes"].contains(&name) {
            continue;
        }
        let mut evaluator = evaluator(&device, &sources, name);
        let components = texture.output().components();
        let found = unlike_its_mean(&mut evaluator, [&near, &far], components);
        wrong.extend(found.iter().map(|what| format!("{name}, {what}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Arguments that change a texture's mean.
const ARGUMENTS: &[(&str, &[(&str, &str)])] = &[
    ("brick", &[("mortar_size", "0.2")]),
    ("brick", &[("squash", "0.2")]),
    ("dirt", &[("amount", "0.8"), ("contrast", "1")]),
    ("dots", &[("radius", "0.1")]),
    ("dots", &[("randomness", "1")]),
    ("magic", &[("depth", "0")]),
    ("magic", &[("depth", "1")]),
    ("magic", &[("depth", "5")]),
    ("magic", &[("distortion", "0.5")]),
    ("magic", &[("distortion", "3")]),
    ("magic", &[("depth", "6"), ("distortion", "3")]),
    ("marble", &[("width", "1")]),
    ("marble", &[("width", "0.05")]),
    ("peeling_paint", &[("amount", "0.7")]),
    ("planks", &[("gap", "0.3"), ("length", "1")]),
    ("ridged", &[("offset", "0.5")]),
    ("ridged", &[("offset", "1.5")]),
    ("rust_mask", &[("amount", "0.1"), ("contrast", "1")]),
    ("snow", &[("amount", "0.2")]),
    ("streaks", &[("amount", "0.2")]),
    ("tiles", &[("corner", "0.45")]),
    ("tiles", &[("bevel", "0.5")]),
    ("voronoi_edges", &[("softness", "0.3")]),
    ("voronoi_smooth", &[("smoothness", "1")]),
    ("weave", &[("over", "3"), ("under", "1")]),
    ("worley", &[("metric", "1")]),
    ("worley", &[("metric", "2")]),
];

#[test]
fn from_afar_it_is_its_mean_for_other_arguments_too() {
    let (device, sources) = (native(), standard());
    // A slope, on which snow lies here and there.
    let slope = [0.0, 0.62, 0.784_602];
    let (near, far) = (seen_by(1e-5, slope), seen_by(60.0, slope));
    let mut wrong = Vec::new();
    for (name, arguments) in ARGUMENTS {
        let file = sources.read(name).expect("is there").expect("is text");
        let texture = TextureType::parse(file).unwrap_or_else(|problems| panic!("{problems}"));
        let mut evaluator = evaluator(&device, &sources, name);
        for (parameter, text) in *arguments {
            (evaluator.set(parameter, text)).unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        let components = texture.output().components();
        let found = unlike_its_mean(&mut evaluator, [&near, &far], components);
        wrong.extend(
            found
                .iter()
                .map(|what| format!("{name} {arguments:?}, {what}")),
        );
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn crests_of_any_breadth_are_neither_cut_off_nor_faint() {
    let (device, sources) = (native(), standard());
    let places = seen_by(1e-5, [0.0, 0.0, 1.0]);
    let mut ridged = evaluator(&device, &sources, "ridged");
    for offset in ["0.5", "1", "1.5"] {
        ridged.set("offset", offset).expect("a number");
        let values = ridged
            .evaluate(&places)
            .unwrap_or_else(|error| panic!("{error}"));
        let highest = values.iter().fold(0.0f32, |most, v| most.max(v[0]));
        let cut = values.iter().filter(|v| v[0] >= 1.0).count();
        assert!(highest > 0.5, "offset {offset}: reaches {highest}");
        assert!(cut < places.len() / 10, "offset {offset}: {cut} cut off");
    }
}

#[test]
fn cells_that_run_into_each_other_have_no_jumps() {
    let text = "fn userProc() -> vec4f {
        return vec4f(voronoiSmooth3D(readAttr(WorldPos).xyz, 1.0, 1.0));
    }";
    let mut sources = TextureSources::default();
    sources.insert("cells", text);
    let mut cells = evaluator(&native(), &sources, "cells");
    // On both sides of the faces of the cubes in which the centres lie.
    let mut beside = |by: f32| {
        let point = |p: [f32; 4]| Point::new().with("WorldPos", &[p[0].round() + by, p[1], p[2]]);
        let points: Vec<Point> = anywhere(3000, 40.0).into_iter().map(point).collect();
        cells
            .evaluate(&points)
            .unwrap_or_else(|error| panic!("{error}"))
    };
    let (below, above) = (beside(-1e-4), beside(1e-4));
    let jumps = below.iter().zip(&above).map(|(a, b)| (a[0] - b[0]).abs());
    let most = jumps.fold(0.0f32, f32::max);
    assert!(most < 0.01, "jumps by {most}");
}

#[test]
fn a_flip_book_shows_nothing_of_the_neighbouring_picture() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let path = dir.path().join("book.png");
    // A black picture beside a white one, four pixels wide each.
    let book = image::GrayImage::from_fn(8, 4, |x, _| image::Luma([if x < 4 { 0 } else { 255 }]));
    book.save(&path).expect("a file");
    let (device, sources) = (native(), standard());
    let mut texture = evaluator(&device, &sources, "flip_book");
    let path = path.to_str().expect("a name in Unicode");
    for (parameter, text) in [
        ("file", path),
        ("columns", "2"),
        ("rows", "1"),
        ("rate", "0"),
    ] {
        (texture.set(parameter, text)).unwrap_or_else(|error| panic!("{parameter}: {error}"));
    }
    let mut points = Vec::new();
    // At both borders and in the middle; by the image itself, and by a copy of half its size.
    for pixel in [1e-5, 0.5] {
        for x in [0.001, 0.5, 0.999] {
            let point = Point::new().with("TexCoord0", &[x, 0.5]);
            points.push(point.with("Footprint", &[pixel; 4]));
        }
    }
    for (start, shade) in [("0", 0.0), ("1", 1.0)] {
        texture.set("start", start).expect("a number");
        let values = texture
            .evaluate(&points)
            .unwrap_or_else(|error| panic!("{error}"));
        for (point, value) in points.iter().zip(&values) {
            assert!(
                (value[0] - shade).abs() < 1e-3,
                "picture {start}: {} at {point:?}",
                value[0]
            );
        }
    }
}

/// All functions of noise by number; those with derivatives give them.
const NOISES: &str = "fn userProc(which: u32) -> vec4f {
    let p = readAttr(WorldPos);
    switch which {
        case 0u: { return vec4f(valueNoise2DGrad(p.xy), 0.0); }
        case 1u: { return valueNoise3DGrad(p.xyz); }
        case 2u: { let n = valueNoise4DGrad(p); return vec4f(n.value, n.gradient.xyz); }
        case 3u: { return vec4f(perlin2DGrad(p.xy), 0.0); }
        case 4u: { return perlin3DGrad(p.xyz); }
        case 5u: { let n = perlin4DGrad(p); return vec4f(n.value, n.gradient.xyz); }
        case 6u: { return vec4f(simplex2DGrad(p.xy), 0.0); }
        case 7u: { return simplex3DGrad(p.xyz); }
        case 8u: { let n = simplex4DGrad(p); return vec4f(n.value, n.gradient.xyz); }
        case 9u: { return vec4f(perlin3D(p.xyz)); }
        case 10u: { return vec4f(valueNoise2D(p.xy)); }
        case 11u: { return vec4f(gabor2D(p.xy, 1.5, 0.5, 1.0)); }
        case 12u: { return vec4f(gabor3D(p.xyz, 1.5, vec3f(1.0, 0.0, 0.0), 1.0)); }
        case 13u: { return vec4f(fbm3D(p.xyz, 4.0, 2.0, 0.5, 0.0)); }
        case 14u: { return vec4f(fbm2D(p.xy, 4.0, 2.0, 0.5, 0.0)); }
        case 15u: { return vec4f(fbm4D(p, 4.0, 2.0, 0.5, 0.0)); }
        case 16u: { return vec4f(2.0 * random3to1(vec3u(vec3i(floor(p.xyz)))) - 1.0); }
        default: { return vec4f(2.0 * random2to1(vec2u(vec2i(floor(p.xy)))) - 1.0); }
    }
}";
/// How many there are.
const COUNT: u32 = 18;
/// The first so many give derivatives.
const WITH_SLOPES: u32 = 9;

fn noises(device: &Device) -> Evaluator {
    let mut sources = TextureSources::default();
    sources.insert("noises", NOISES);
    evaluator(device, &sources, "noises")
}

fn run(noises: &mut Evaluator, which: u32, places: &[[f32; 4]]) -> Vec<[f32; 4]> {
    noises
        .set_value("which", Value::U32(which))
        .expect("a number");
    let points: Vec<Point> = places
        .iter()
        .map(|p| Point::new().with("WorldPos", p))
        .collect();
    noises
        .evaluate(&points)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn anywhere(count: u32, size: f32) -> Vec<[f32; 4]> {
    let r = |i: u32, k: u32| size * (random(4 * i + k) - 0.5);
    (0..count)
        .map(|i| [r(i, 0), r(i, 1), r(i, 2), r(i, 3)])
        .collect()
}

#[test]
fn noises_have_mean_0_and_stay_within_their_range() {
    let mut noises = noises(&native());
    let places = anywhere(20_000, 2000.0);
    for which in 0..COUNT {
        let values = run(&mut noises, which, &places);
        let values: Vec<f64> = values.iter().map(|v| f64::from(v[0])).collect();
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count;
        let most = values.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        // Six deviations of the mean of so many independent values.
        assert!(
            mean.abs() < 6.0 * (variance / count).sqrt(),
            "noise {which}: mean {mean}"
        );
        let limit = if (11..=12).contains(&which) {
            2.0
        } else {
            1.25
        };
        assert!(most <= limit, "noise {which}: reaches {most}");
        assert!(
            (0.015..0.4).contains(&variance),
            "noise {which}: variance {variance}"
        );
    }
}

#[test]
fn derivatives_are_those_of_the_noise() {
    let mut noises = noises(&native());
    let places = anywhere(300, 20.0);
    // Large enough for rounding, small enough for curvature.
    let step = 0.004f32;
    for which in 0..WITH_SLOPES {
        let found = run(&mut noises, which, &places);
        let axes = if which % 3 == 0 { 2 } else { 3 };
        for axis in 0..axes {
            let moved = |by: f32| -> Vec<[f32; 4]> {
                let shift = |p: &[f32; 4]| {
                    let mut p = *p;
                    p[axis] += by;
                    p
                };
                places.iter().map(shift).collect()
            };
            let (above, below) = (moved(step), moved(-step));
            let (high, low) = (
                run(&mut noises, which, &above),
                run(&mut noises, which, &below),
            );
            for i in 0..places.len() {
                let width = above[i][axis] - below[i][axis];
                let slope = (high[i][0] - low[i][0]) / width;
                let given = found[i][1 + axis];
                assert!(
                    (slope - given).abs() < 0.03,
                    "noise {which}, axis {axis}, at {:?}: {given} instead of {slope}",
                    places[i]
                );
            }
        }
    }
}

#[test]
fn noises_do_not_repeat_before_65536() {
    let mut noises = noises(&native());
    let places = anywhere(200, 20.0);
    for which in 0..COUNT {
        let here = run(&mut noises, which, &places);
        for axis in 0..2 {
            for power in 0..=16 {
                let moved: Vec<[f32; 4]> = (places.iter())
                    .map(|p| {
                        let mut p = *p;
                        p[axis] += (1u32 << power) as f32;
                        p
                    })
                    .collect();
                let there = run(&mut noises, which, &moved);
                let pairs = here.iter().zip(&there);
                let differ = pairs.filter(|(a, b)| (a[0] - b[0]).abs() > 0.02).count();
                assert!(
                    differ > 100,
                    "noise {which} repeats after 2^{power} along {axis}"
                );
            }
        }
    }
}

/// Power at some cycles per cell, as the mean over lines of cells.
fn power(lines: &[Vec<f64>], per_cell: usize, frequency: f64) -> f64 {
    let of = |line: &Vec<f64>| {
        let (mut re, mut im) = (0.0, 0.0);
        for (i, v) in line.iter().enumerate() {
            // A window, or the ends would spread over all frequencies.
            let window =
                0.5 - 0.5 * (std::f64::consts::TAU * (i as f64 + 0.5) / line.len() as f64).cos();
            let phase = std::f64::consts::TAU * frequency * i as f64 / per_cell as f64;
            re += window * v * phase.cos();
            im += window * v * phase.sin();
        }
        re * re + im * im
    };
    lines.iter().map(of).sum::<f64>() / lines.len() as f64
}

#[test]
fn no_noise_has_a_peak_at_its_lattice() {
    const CELLS: usize = 64;
    const PER_CELL: usize = 8;
    const LINES: usize = 48;
    let mut noises = noises(&native());
    let mut places = Vec::new();
    for line in 0..LINES as u32 {
        let r = |k: u32| 500.0 * random(7 * line + k);
        let start = [r(0).floor(), r(1), r(2), r(3)];
        for i in 0..CELLS * PER_CELL {
            let [x, y, z, w] = start;
            places.push([x + i as f32 / PER_CELL as f32, y, z, w]);
        }
    }
    for which in 0..16 {
        let values = run(&mut noises, which, &places);
        let values: Vec<f64> = values.iter().map(|v| f64::from(v[0])).collect();
        let lines: Vec<Vec<f64>> = values
            .chunks(CELLS * PER_CELL)
            .map(<[f64]>::to_vec)
            .collect();
        for lattice in [1.0, 2.0] {
            let at = power(&lines, PER_CELL, lattice);
            let beside = [-0.16, -0.11, 0.11, 0.16].map(|d| power(&lines, PER_CELL, lattice + d));
            let beside = beside.iter().sum::<f64>() / 4.0;
            // Of 48 exponential numbers the mean is off by 15 %; four deviations and the slope of the spectrum.
            assert!(
                at < 2.2 * beside + 1e-6,
                "noise {which}: {at} at {lattice} cycles per cell, {beside} beside it"
            );
        }
    }
}

/// What a noise may differ by. Of those by Gabor some waves are added at each place, and of a wave's cosine WGSL says no more than that it is right
/// to 2^-11 (in its section on the accuracy of floating point); the driver of a processor is right to the last bits, SwiftShader isn't.
fn most_apart(which: u32) -> f32 {
    match (11..=12).contains(&which) {
        true => 4.0 * 2.0_f32.powi(-11),
        false => 1e-4,
    }
}

#[test]
fn noises_are_equal_on_all_devices() {
    let Some(driver) = open_driver() else {
        return;
    };
    let (mut here, mut there) = (noises(&native()), noises(&driver));
    let places = anywhere(500, 200.0);
    for which in 0..COUNT {
        let (a, b) = (
            run(&mut here, which, &places),
            run(&mut there, which, &places),
        );
        for (i, (a, b)) in a.iter().zip(&b).enumerate() {
            let place = places[i];
            assert!(
                (a[0] - b[0]).abs() < most_apart(which),
                "noise {which} at {place:?}: {} and {}",
                a[0],
                b[0]
            );
        }
    }
}

#[test]
fn colours_survive_conversions() {
    let text = "fn userProc(which: u32) -> vec3f {
        let c = abs(readAttr(WorldPos).xyz);
        switch which {
            case 0u: { return hsvToRgb(rgbToHsv(c)) - c; }
            case 1u: { return hslToRgb(rgbToHsl(c)) - c; }
            case 2u: { return oklabToRgb(rgbToOklab(c)) - c; }
            case 3u: { return srgbToLinear(linearToSrgb(c)) - c; }
            case 4u: { return rgbToOklab(vec3f(1.0)) - vec3f(1.0, 0.0, 0.0); }
            case 5u: { return hslToRgb(rgbToHsl(3.0 * c)) - 3.0 * c; }
            default: { return blackbody(6500.0) - vec3f(1.0); }
        }
    }";
    let mut sources = TextureSources::default();
    sources.insert("noises", text);
    let mut colours = evaluator(&native(), &sources, "noises");
    let places = anywhere(200, 1.9);
    for which in 0..7 {
        // A black body of 6500 K is not quite D65.
        let limit = if which == 6 { 0.06 } else { 2e-4 };
        for value in run(&mut colours, which, &places) {
            let most = value[..3].iter().fold(0.0f32, |most, v| most.max(v.abs()));
            assert!(most < limit, "conversion {which} is off by {most}");
        }
    }
}
