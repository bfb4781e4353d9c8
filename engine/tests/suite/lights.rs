//! Light sampling on its own, by the kernels' own code: what is chosen and where on it has the density that is said, and
//! a scattered ray that hits the same point is told the same (chi-square and equality). Then many lights in a picture.
//! Skipped with a notice where there is no adapter.

use std::{f32::consts::PI, sync::Arc};

use ::device::Device;
use ::device::{Extent, Recording, Resources, Trust, Usage};
use bytemuck::{Pod, Zeroable};
use engine::film::Film;
use engine::frame::Frame;
use engine::gpu_scene::GpuScene;
use engine::passes::wgsl::ComposedWgsl;
use engine::renderer::RenderSettings;
use engine::scene::{
    Environment, FloatImage, Instance, LightKind, Material, Mesh, PunctualLight, Scene,
};
use engine::texturing::TextureReads;
use glam::{Affine3A, DVec3, Vec3};

use crate::support::device;
use crate::support::normal::Normal;
use crate::support::scenes::{
    Shot, add, floor, floor_point, from_above, lambert, lamp, quad, render, scene, unlit,
};

/// `Params` below.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct Params {
    pub(crate) position: Vec3,
    light: u32,
    normal: Vec3,
    all_around: u32,
    seed: u32,
    spare: [u32; 3],
}

const HARNESS: &str = r"
struct Params { position: vec3f, light: u32, normal: vec3f, all_around: u32, seed: u32, spare0: u32, spare1: u32, spare2: u32 }
@group(0) @binding(60) var<uniform> params: Params;
@group(0) @binding(61) var<storage, read_write> data: array<vec4f>;

fn uniform_number(i: u32, k: u32) -> f32 {
    return f32(hash(hash(i * 4u + k) ^ params.seed) >> 8u) / 16777216.0;
}

fn side() -> u32 {
    return select(octahedral_encode(params.normal), RECEIVER_ALL_AROUND, params.all_around != 0u);
}

// The probability of each light with a place.
@compute @workgroup_size(64)
fn probabilities(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&data)) { return; }
    let light = light_at(id.x);
    data[id.x].x = light_probability(light.leaf, params.position, receiver_normal(side())) * share_of_lamp(light);
}

// A lamp may be two triangles.
fn share_of_lamp(light: Light) -> f32 {
    return select(1.0, light.range, light.kind == LIGHT_TRIANGLE);
}

// One of them, and the probability that goes with it.
@compute @workgroup_size(64)
fn choices(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&data)) { return; }
    let choice = choose_light(params.position, receiver_normal(side()), uniform_number(id.x, 0u), hash(id.x));
    var index = choice.index;
    if (uniform_number(id.x, 1u) >= share_of_lamp(light_at(index))) {
        index = bitcast<u32>(light_at(index).spot_scale);
    }
    data[id.x] = vec4f(f32(index), choice.probability * share_of_lamp(light_at(index)), 0.0, 0.0);
}

@compute @workgroup_size(64)
fn corners(@builtin(global_invocation_id) id: vec3u) {
    if (id.x > 0u) { return; }
    let light = light_at(params.light);
    data[0] = vec4f(light.position, 0.0);
    data[1] = vec4f(light.position + light.direction, 0.0);
    data[2] = vec4f(light.position + light.intensity, 0.0);
}

// Points on one triangle; what a ray that hits them is told.
@compute @workgroup_size(64)
fn points(@builtin(global_invocation_id) id: vec3u) {
    if (2u * id.x + 1u >= arrayLength(&data)) { return; }
    let light = light_at(params.light);
    let probability = light_probability(light.leaf, params.position, receiver_normal(side())) * share_of_lamp(light)
        / f32(light_groups());
    let s = triangle_sample(light, probability, params.position, vec2f(uniform_number(id.x, 0u), uniform_number(id.x, 1u)));
    let normal = normalize(cross(light.direction, light.intensity));
    let hit = RayHit(params.position, 0.0, s.wi, s.distance, vec2f(0.0), light.triangle, light.instance);
    data[2u * id.x] = vec4f(s.wi, s.distance);
    data[2u * id.x + 1u] = vec4f(s.pdf, light_hit_pdf(hit, side(), abs(dot(normal, s.wi)), 1.0 / f32(light_groups())), probability, 0.0);
}

// Samples of all lights: direction and pdf, then distance and whether it is a delta light.
@compute @workgroup_size(64)
fn samples(@builtin(global_invocation_id) id: vec3u) {
    if (2u * id.x + 1u >= arrayLength(&data)) { return; }
    let u = vec2f(uniform_number(id.x, 1u), uniform_number(id.x, 2u));
    let shares = light_shares(params.position, side(), path_id(0u));
    let s = light_sample(params.position, params.position, side(), shares, uniform_number(id.x, 0u), u);
    data[2u * id.x] = vec4f(s.wi, s.pdf);
    data[2u * id.x + 1u] = vec4f(s.distance, f32(s.delta), max_component(s.radiance), 0.0);
}

// pdf of the environment and of directional lights in given directions.
@compute @workgroup_size(64)
fn distant(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&data)) { return; }
    let shares = light_shares(params.position, side(), path_id(0u));
    data[id.x].w = sky_pdf(params.position, data[id.x].xyz, side(), shares) / shares.environment;
}

// Samples of the sky by the first row of what is known of it: direction and density, then the density in that direction.
@compute @workgroup_size(64)
fn seen(@builtin(global_invocation_id) id: vec3u) {
    if (2u * id.x + 1u >= arrayLength(&data)) { return; }
    let s = seen_sample(vec2f(uniform_number(id.x, 0u), uniform_number(id.x, 1u)), 0u, params.position);
    data[2u * id.x] = vec4f(s.wi, s.pdf);
    data[2u * id.x + 1u] = vec4f(seen_pdf(params.position, s.wi, 0u), 0.0, 0.0, 0.0);
}
";

pub(crate) struct Harness {
    pub(crate) device: Device,
    source: ComposedWgsl,
    pub(crate) resources: Resources,
    scene: GpuScene,
}

impl Harness {
    pub(crate) fn new(scene: &Scene) -> Option<Self> {
        Self::with_sky(scene, false)
    }

    /// `knows_sky`: whether it is known where the sky is seen.
    pub(crate) fn with_sky(scene: &Scene, knows_sky: bool) -> Option<Self> {
        let device = device::open()?;
        let mut source = ComposedWgsl::of("brdf/entry.wgsl");
        source.text.push_str(HARNESS);
        let mut resources = Resources::default();
        let reads = TextureReads::default();
        let scene = GpuScene::new(
            &device,
            scene,
            &reads,
            |_| Default::default(),
            &mut resources,
        )
        .unwrap_or_else(|error| panic!("{error}"));
        let settings = RenderSettings::new(1, 1, &from_above(1.0, 1.0));
        let mut frame = Frame::new(&settings, 64, &scene);
        frame.set_known_sky(knows_sky);
        for (name, size) in [
            ("frame", size_of::<Frame>()),
            ("params", size_of::<Params>()),
        ] {
            let buffer = device.buffer(name, Usage::Uniform, size as u64);
            resources.set_buffer(name, buffer.unwrap_or_else(|error| panic!("{error}")));
        }
        device.write(resources.buffer("frame"), 0, bytemuck::bytes_of(&frame));
        Some(Self {
            device,
            source,
            resources,
            scene,
        })
    }

    pub(crate) fn run(
        &self,
        entry: &str,
        params: Params,
        data: &[[f32; 4]],
        threads: u32,
    ) -> Vec<[f32; 4]> {
        let run = || {
            let environment = f64::from(u8::from(self.scene.features.environment));
            let constants = [("has_environment", environment), ("leaves_diffuse", 1.0)];
            let kernel = self
                .source
                .compile(&self.device, entry, Trust::Nothing, &constants)?;
            let mut resources = self.resources.clone();
            let bytes = size_of_val(data) as u64;
            let data =
                self.device
                    .filled_buffer("data", Usage::Storage, bytemuck::cast_slice(data))?;
            resources.set_buffer("data", data);
            self.device
                .write(resources.buffer("params"), 0, bytemuck::bytes_of(&params));
            let bound = kernel.bind(&self.device, &resources);
            let mut recording = Recording::new("test");
            recording.dispatch(&bound, Extent::Threads(threads));
            self.device.play(&recording)?;
            self.device.read(resources.buffer("data"), 0, bytes)
        };
        bytemuck::pod_collect_to_vec(
            &run().unwrap_or_else(|error: ::device::DeviceError| panic!("{error}")),
        )
    }
}

/// Fails unless counts follow probabilities, whose rest is the probability of nothing.
#[track_caller]
fn assert_follows(name: &str, probabilities: &[f64], counts: &[u32], samples: u32) {
    let rest = (1.0 - probabilities.iter().sum::<f64>()).max(0.0);
    let missing = samples - counts.iter().sum::<u32>();
    let (mut chi2, mut freedom, mut few, mut found_few) = (0.0_f64, -1.0_f64, 0.0_f64, 0.0);
    for (p, &count) in probabilities.iter().zip(counts).chain([(&rest, &missing)]) {
        let expected = p * f64::from(samples);
        if expected >= 10.0 {
            chi2 += (f64::from(count) - expected).powi(2) / expected;
            freedom += 1.0;
        } else {
            few += expected;
            found_few += f64::from(count);
        }
    }
    // Rare ones together: at least so many expected that a normal deviate tells something.
    if few >= 10.0 {
        chi2 += (found_few - few) * (found_few - few) / few;
        freedom += 1.0;
    } else {
        assert!(
            found_few < few + 6.0 * few.sqrt() + 6.0,
            "{name}: {found_few} rare ones, {few:.2} expected"
        );
    }
    if freedom < 1.0 {
        return;
    }
    // Wilson and Hilferty's normal deviate of a chi-square variable.
    let spread = (2.0 / (9.0 * freedom)).sqrt();
    let z = ((chi2 / freedom).cbrt() - (1.0 - spread * spread)) / spread;
    // Beyond 4.5 with a probability of 3 in a million for each of some fifty tests.
    assert!(
        z < 4.5,
        "{name}: {z:.2} sigma, {freedom} degrees of freedom"
    );
}

fn light(kind: LightKind, position: Vec3, direction: Vec3, intensity: f32) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        intensity: Vec3::splat(intensity),
        position,
        direction: direction.normalize(),
        range: f32::INFINITY,
        kind,
    }
}

/// Of the disk in the sky, radians.
const DISK_RADIUS: f32 = 0.25;

/// Lights of every kind: lamps with one and two sides, one of them mirrored, points, spots, directions, a sky.
fn zoo() -> Scene {
    let two_sided = |radiance| Material {
        double_sided: true,
        ..lamp(Vec3::splat(radiance))
    };
    let down = |corner| quad(corner, Vec3::X, Vec3::Z);
    let mut scene = scene(
        [
            (floor(5.0), lambert(Vec3::ONE)),
            (down(Vec3::new(-0.5, 2.0, -0.5)), lamp(Vec3::splat(3.0))),
            (down(Vec3::new(3.0, 1.0, -2.5)), lamp(Vec3::splat(9.0))),
            (
                quad(Vec3::new(-3.0, 0.2, 0.0), Vec3::Y, Vec3::new(0.3, 0.0, 1.0)),
                two_sided(1.0),
            ),
            (
                quad(Vec3::new(0.3, 0.1, 0.5), Vec3::X * 0.1, Vec3::Y * 0.2),
                two_sided(20.0),
            ),
        ],
        Vec3::ZERO,
    );
    scene.instances.push(Instance {
        name: "mirrored".to_owned(),
        mesh: 1,
        transform: Affine3A::from_translation(Vec3::new(-4.0, 1.0, 2.0))
            * Affine3A::from_scale(Vec3::new(-0.5, 1.0, 2.0)),
        asset: None,
    });
    let mut numbers = Normal::new(3);
    for _ in 0..20 {
        let mut place = || numbers.uniform() as f32;
        let corner = Vec3::new(
            8.0 * place() - 4.0,
            0.5 + 2.0 * place(),
            8.0 * place() - 4.0,
        );
        let u = Vec3::new(place() - 0.5, place() - 0.5, 0.3);
        let v = Vec3::new(0.2, place() - 0.5, place() - 0.5);
        let lamp = lamp(Vec3::splat(5.0));
        add(&mut scene, quad(corner, u * 0.3, v * 0.3), lamp);
    }
    let spot = LightKind::Spot {
        inner_angle: 0.3,
        outer_angle: 0.7,
    };
    let from = Vec3::new(1.0, 3.0, -1.0);
    scene.lights = vec![
        light(LightKind::Point, Vec3::new(2.0, 0.5, 2.0), Vec3::Y, 1.0),
        light(LightKind::Point, Vec3::new(-1.0, 1.5, -2.0), Vec3::Y, 4.0),
        light(spot, from, Vec3::NEG_Y, 3.0),
        light(
            spot,
            Vec3::new(-2.0, 1.0, 3.0),
            Vec3::new(1.0, -0.5, 0.0),
            2.0,
        ),
        light(
            LightKind::Disk {
                angular_diameter: 2.0 * DISK_RADIUS,
            },
            Vec3::ZERO,
            Vec3::new(0.2, -1.0, 0.1),
            2.0,
        ),
        light(
            LightKind::Directional,
            Vec3::ZERO,
            Vec3::new(1.0, -1.0, 0.0),
            0.5,
        ),
        light(
            LightKind::Directional,
            Vec3::ZERO,
            Vec3::new(0.0, -1.0, 1.0),
            0.1,
        ),
    ];
    let (width, height) = (16, 8);
    scene.environment = Environment::Image {
        image: Arc::new(FloatImage {
            width,
            height,
            rgb: (0..width * height)
                .map(|_| [numbers.uniform().powi(4) as f32; 3])
                .collect(),
        }),
        rotation: 40.0,
        intensity: 1.0,
    };
    scene
}

/// Places and sides from which the lights are looked at.
fn viewpoints() -> Vec<Params> {
    let at = |x, y, z, normal: Vec3, all_around| Params {
        position: Vec3::new(x, y, z),
        light: 0,
        normal: normal.normalize(),
        all_around,
        seed: 99,
        spare: [0; 3],
    };
    vec![
        at(0.0, 0.0, 0.0, Vec3::Y, 0),
        at(0.0, 0.0, 0.0, Vec3::Y, 1),
        at(0.33, 0.15, 0.51, Vec3::Z, 0),
        at(2.0, 2.5, -2.0, Vec3::new(1.0, -1.0, 0.3), 0),
        at(-3.0, 0.5, 0.5, Vec3::new(-1.0, 0.2, 0.0), 0),
        at(40.0, 30.0, 0.0, Vec3::new(-1.0, -1.0, 0.0), 0),
    ]
}

const SAMPLES: u32 = 1 << 17;

#[test]
fn lights_are_chosen_with_the_probability_that_a_hit_is_told() {
    let Some(harness) = Harness::new(&zoo()) else {
        return;
    };
    let count = harness.scene.light_count;
    assert_eq!(count, 2 * 25 + 4, "every lamp and every light with a place");
    let mut is_reached = vec![false; count as usize];
    for (i, params) in viewpoints().into_iter().enumerate() {
        let expected = harness.run(
            "probabilities",
            params,
            &vec![[0.0; 4]; count as usize],
            count,
        );
        let expected: Vec<f64> = expected.iter().map(|e| f64::from(e[0])).collect();
        let total: f64 = expected.iter().sum();
        assert!((0.0..1.0 + 1e-5).contains(&total), "view {i}: {total}");
        let choices = harness.run(
            "choices",
            params,
            &vec![[0.0; 4]; SAMPLES as usize],
            SAMPLES,
        );
        let mut counts = vec![0; count as usize];
        for [index, probability, ..] in choices {
            if probability > 0.0 {
                let index = index as usize;
                counts[index] += 1;
                is_reached[index] = true;
                let told = expected[index];
                assert!(
                    (f64::from(probability) / told - 1.0).abs() < 1e-4,
                    "view {i}, light {index}: {probability}, {told}"
                );
            }
        }
        assert_follows(&format!("view {i}"), &expected, &counts, SAMPLES);
        // What no light reaches is little: nodes that may contribute mostly do.
        assert!(total > 0.8, "view {i}: {total} of the samples find a light");
    }
    assert!(is_reached.iter().filter(|&&r| r).count() > 40);
}

#[test]
fn points_on_lamps_are_even_and_have_the_density_that_a_hit_is_told() {
    const FEW: u32 = 1 << 13;
    let Some(harness) = Harness::new(&zoo()) else {
        return;
    };
    for (i, params) in viewpoints().into_iter().enumerate() {
        for light in [0, 1, 3, 5, 7, 9, 20] {
            let params = Params { light, ..params };
            let out = harness.run("points", params, &vec![[0.0; 4]; 2 * FEW as usize], FEW);
            let found: Vec<_> = out.chunks_exact(2).filter(|s| s[1][0] > 0.0).collect();
            for s in &found {
                let [pdf, told, ..] = s[1];
                assert!(
                    (pdf / told - 1.0).abs() < 1e-3,
                    "view {i}, light {light}: {pdf}, {told}"
                );
            }
            if found.len() < FEW as usize / 2 {
                continue; // seen from behind
            }
            // Mean of 1 / pdf is the solid angle; by the choice's share.
            let shares: Vec<f64> = (found.iter())
                .map(|s| f64::from(s[1][2]) / f64::from(s[1][0]))
                .collect();
            let n = f64::from(FEW);
            let mean = shares.iter().sum::<f64>() / n;
            let square = shares.iter().map(|s| s * s).sum::<f64>() / n;
            let error = ((square - mean * mean).max(0.0) / n).sqrt();
            let corners = harness.run("corners", params, &[[0.0; 4]; 3], 1);
            let exact = solid_angle(std::array::from_fn(|c| {
                let [x, y, z, _] = corners[c];
                (Vec3::new(x, y, z) - params.position)
                    .as_dvec3()
                    .normalize()
            }));
            assert!(
                (mean - exact).abs() < 5.0 * error + 0.01 * exact,
                "view {i}, light {light}: solid angle {mean} +- {error}, {exact} by its outline"
            );
        }
    }
}

/// Van Oosterom and Strackee, 1983, for unit vectors.
pub(crate) fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let numerator = a.dot(b.cross(c)).abs();
    let denominator = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
    2.0 * numerator.atan2(denominator)
}

#[test]
fn distant_lights_are_sampled_as_their_density_says() {
    let Some(harness) = Harness::new(&zoo()) else {
        return;
    };
    let params = viewpoints()[0];
    let out = harness.run(
        "samples",
        params,
        &vec![[0.0; 4]; 2 * SAMPLES as usize],
        SAMPLES,
    );
    let is_far = |s: &&[[f32; 4]]| s[1][0] > 1e29 && s[0][3] > 0.0;
    let far: Vec<_> = out.chunks_exact(2).filter(is_far).collect();

    // Directional lights: a third of the samples, by irradiance.
    let scene = zoo();
    let suns: Vec<_> = (scene.lights.iter())
        .filter(|l| matches!(l.kind, LightKind::Directional | LightKind::Disk { .. }))
        .collect();
    let total: f32 = suns.iter().map(|l| l.intensity.x).sum();
    let expected: Vec<f64> = (suns.iter())
        .map(|l| f64::from(l.intensity.x / total / 3.0))
        .collect();
    let mut counts = vec![0; suns.len()];
    // Brighter than any texel of the sky: the disk.
    let is_disk = |s: &[[f32; 4]]| s[1][1] == 0.0 && s[1][2] > 2.0;
    for s in far.iter().filter(|s| s[1][1] == 1.0 || is_disk(s)) {
        let wi = Vec3::new(s[0][0], s[0][1], s[0][2]);
        let is_near = |l: &&PunctualLight| match l.kind {
            LightKind::Disk { .. } => l.direction.angle_between(-wi) < DISK_RADIUS + 1e-3,
            _ => l.direction.dot(-wi) > 0.9999,
        };
        let which = (suns.iter()).position(is_near).expect("one of them");
        counts[which] += 1;
        let density = match suns[which].kind {
            LightKind::Disk { .. } => 1.0 / (2.0 * PI * (1.0 - DISK_RADIUS.cos())),
            _ => 1.0,
        };
        let told = f64::from(s[0][3] / density);
        assert!((told / expected[which] - 1.0).abs() < 1e-4);
    }
    assert_follows("directional lights", &expected, &counts, SAMPLES);

    // The disk: evenly over its solid angle, in rings and sectors of equal size.
    const RINGS: usize = 6;
    const SECTORS: usize = 8;
    let axis = -suns[0].direction;
    let (across, along) = axis.any_orthonormal_pair();
    let mut counts = vec![0; RINGS * SECTORS];
    for s in far.iter().filter(|s| is_disk(s)) {
        let wi = Vec3::new(s[0][0], s[0][1], s[0][2]);
        let ring = (1.0 - wi.dot(axis)) / (1.0 - DISK_RADIUS.cos()) * RINGS as f32;
        let turn = wi.dot(along).atan2(wi.dot(across)) / (2.0 * PI) + 0.5;
        let sector = (turn * SECTORS as f32) as usize % SECTORS;
        counts[(ring as usize).min(RINGS - 1) * SECTORS + sector] += 1;
    }
    let even = expected[0] / counts.len() as f64;
    assert_follows("the disk", &vec![even; counts.len()], &counts, SAMPLES);

    // The sky: a third too, and its density is even in each texel.
    let is_sky = |s: &&&[[f32; 4]]| s[1][1] == 0.0 && !is_disk(s);
    let sky: Vec<_> = far.iter().filter(is_sky).collect();
    let directions: Vec<[f32; 4]> = sky.iter().map(|s| s[0]).collect();
    let told = harness.run("distant", params, &directions, directions.len() as u32);
    let (width, height) = (16, 8);
    let mut counts = vec![0; width * height];
    let mut expected = vec![0.0; width * height];
    let mut differ = 0;
    for (s, told) in directions.iter().zip(told) {
        let turn = s[0].atan2(-s[2]) / (2.0 * PI) + 40.0 / 360.0;
        let polar = s[1].clamp(-1.0, 1.0).acos();
        let column = (turn.rem_euclid(1.0) * width as f32) as usize % width;
        let row = ((polar / PI * height as f32) as usize).min(height - 1);
        counts[row * width + column] += 1;
        let square =
            f64::from(told[3]) * 2.0 * std::f64::consts::PI.powi(2) * f64::from(polar.sin());
        expected[row * width + column] = square / (width * height) as f64 / 3.0;
        // At the seam between texels the direction may be found in the other one.
        differ += u32::from((s[3] * 3.0 / told[3] - 1.0).abs() > 1e-3);
    }
    assert!(
        differ < directions.len() as u32 / 300,
        "{differ} directions are told another density"
    );
    assert_follows("the sky", &expected, &counts, SAMPLES);
}

/// What samples of a sky give that surfaces of some facings scatter: of each its radiance times the cosine over its density.
fn sky_samples(environment: Environment) -> Option<Vec<Vec<f64>>> {
    let mut scene = scene([(floor(5.0), lambert(Vec3::ONE))], Vec3::ZERO);
    scene.environment = environment;
    let harness = Harness::new(&scene)?;
    let samples = |params: &Params| {
        let empty = vec![[0.0; 4]; 2 * SAMPLES as usize];
        let out = harness.run("samples", *params, &empty, SAMPLES);
        out.chunks_exact(2)
            .map(|s| {
                let cosine = Vec3::new(s[0][0], s[0][1], s[0][2]).dot(params.normal);
                f64::from(s[1][2] * cosine.max(0.0) / s[0][3])
            })
            .collect()
    };
    let one_sided = |params: &&Params| params.all_around == 0;
    Some(viewpoints().iter().filter(one_sided).map(samples).collect())
}

fn mean_and_spread(values: &[f64]) -> [f64; 2] {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    [mean, variance.sqrt() / mean]
}

#[test]
fn every_sample_of_a_constant_sky_gives_the_same() {
    let Some(facings) = sky_samples(Environment::Constant(Vec3::splat(0.5))) else {
        return;
    };
    for samples in facings {
        let [mean, spread] = mean_and_spread(&samples);
        assert!(
            (mean / (0.5 * std::f64::consts::PI) - 1.0).abs() < 1e-4,
            "{mean}"
        );
        assert!(spread < 0.01, "{spread}");
    }
}

#[test]
fn samples_of_a_sky_go_by_what_a_surface_receives() {
    // Brighter towards one side, and turned.
    let (width, height) = (64, 32);
    let brightness = |x: u32, y: u32| 1.0 + 0.5 * (x as f32 * 0.1).sin() + y as f32 * 0.02;
    let image = FloatImage {
        width,
        height,
        rgb: (0..width * height)
            .map(|i| [brightness(i % width, i / width); 3])
            .collect(),
    };
    let Some(facings) = sky_samples(Environment::Image {
        image: Arc::new(image),
        rotation: 70.0,
        intensity: 1.0,
    }) else {
        return;
    };
    for samples in facings {
        // By its radiance alone, a sample in two would give nothing, and the spread be more than 1.
        let [_, spread] = mean_and_spread(&samples);
        assert!(spread < 0.45, "{spread}");
    }
}

/// Lamps in a square grid, looking down.
const SIDE: u32 = 100;
const SPACING: f32 = 0.5;
const HEIGHT: f32 = 0.8;
const LAMP: f32 = 0.03;
const ALBEDO: f32 = 0.7;
const RADIANCE: f32 = 50.0;

fn lamp_center(i: u32) -> Vec3 {
    let at = |k: u32| (k as f32 + 0.5 - SIDE as f32 / 2.0) * SPACING;
    Vec3::new(at(i % SIDE), HEIGHT, at(i / SIDE))
}

fn lamp_field() -> Scene {
    let mut lamps = Mesh {
        name: "lamps".to_owned(),
        ..Mesh::default()
    };
    for i in 0..SIDE * SIDE {
        let corner = lamp_center(i) - Vec3::new(LAMP / 2.0, 0.0, LAMP / 2.0);
        let one = quad(corner, Vec3::X * LAMP, Vec3::Z * LAMP);
        let first = lamps.positions.len() as u32;
        lamps.positions.extend(one.positions);
        lamps.normals.extend(one.normals);
        lamps
            .triangles
            .extend(one.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    lamps.triangle_materials = vec![0; lamps.triangles.len()];
    scene(
        [
            (floor(40.0), lambert(Vec3::splat(ALBEDO))),
            (lamps, lamp(Vec3::splat(RADIANCE))),
        ],
        Vec3::ZERO,
    )
}

/// What each lamp adds to the radiance of the floor at a point; its size is small beside its distance.
fn contributions(point: Vec3) -> impl Iterator<Item = f64> {
    (0..SIDE * SIDE).map(move |i| {
        let to = lamp_center(i) - point;
        let cosine = to.y / to.length();
        f64::from(ALBEDO / PI * RADIANCE * LAMP * LAMP * cosine * cosine / to.length_squared())
    })
}

const FIELD_SHOT: Shot = Shot {
    size: (24, 24),
    max_depth: 1,
    spp: 16,
};

fn mean_and_variance(film: &Film, spp: u32) -> (f64, f64) {
    let pixels = f64::from(film.width * film.height);
    let mean = film.mean().iter().map(|m| f64::from(m[0])).sum::<f64>() / pixels;
    let errors = film.standard_error();
    let variance = errors.iter().map(|e| f64::from(e[0]).powi(2)).sum::<f64>() / pixels;
    (mean, variance * f64::from(spp))
}

#[test]
fn ten_thousand_lamps_are_sampled_by_their_effect() {
    let Some(device) = device::open() else { return };
    const HALF: f32 = 1.0;
    let view = from_above(0.5, HALF);
    let film = render(&device, &mut lamp_field(), &view, FIELD_SHOT);
    let (mean, variance) = mean_and_variance(&film, FIELD_SHOT.spp);

    let mut exact = 0.0;
    let mut by_power = 0.0;
    const POINTS: u32 = 12;
    for i in 0..POINTS * POINTS {
        let picture =
            glam::Vec2::new((i % POINTS) as f32 + 0.5, (i / POINTS) as f32 + 0.5) / POINTS as f32;
        let point = floor_point(HALF, picture);
        let sum: f64 = contributions(point).sum();
        let squares: f64 = contributions(point).map(|c| c * c).sum();
        exact += sum / f64::from(POINTS * POINTS);
        // One of N equal lamps, chosen evenly, counts N times.
        by_power += (f64::from(SIDE * SIDE) * squares - sum * sum) / f64::from(POINTS * POINTS);
    }
    let pixels = f64::from(film.width * film.height);
    let error = (variance / f64::from(FIELD_SHOT.spp) / pixels).sqrt();
    eprintln!(
        "mean {mean:.5} +- {error:.5}, exact {exact:.5}; variance {variance:.4}, by power {by_power:.2}"
    );
    // Half a percent for the lamps' size and the points of the quadrature.
    assert!(
        (mean - exact).abs() < 4.5 * error + 0.005 * exact,
        "mean {mean} +- {error}, exact {exact}"
    );
    // Seen: about a fortieth or less.
    assert!(
        variance < by_power / 20.0,
        "variance {variance}, by power {by_power}"
    );
}

#[test]
fn scattered_rays_and_light_samples_share_many_lamps() {
    let Some(device) = device::open() else { return };
    // Unlit lamps are in no table of lights: only scattered rays find them, and they show the same radiance.
    let room = |surface: &Material, is_sampled: bool| {
        let radiance = Vec3::new(4.0, 2.0, 1.0);
        let shining = match is_sampled {
            true => lamp(radiance),
            false => unlit(radiance.extend(1.0)),
        };
        let mut numbers = Normal::new(5);
        let mut scene = scene([(floor(5.0), surface.clone())], Vec3::ZERO);
        for i in 0..100 {
            let mut wobble = || numbers.uniform() as f32 * 0.3;
            let height = if i % 3 == 0 { -1.0 } else { 0.8 } + wobble();
            let corner = Vec3::new(
                (i % 10) as f32 * 0.5 - 2.5,
                height,
                (i / 10) as f32 * 0.5 - 2.5,
            );
            let mut edges = [Vec3::new(0.3, wobble(), 0.0), Vec3::new(0.0, wobble(), 0.3)];
            if i % 3 == 0 {
                edges.swap(0, 1); // below the floor, looking up
            }
            add(
                &mut scene,
                quad(corner, edges[0], edges[1]),
                shining.clone(),
            );
        }
        scene
    };
    let metal = Material {
        roughness: 0.4,
        ..Material::default()
    };
    let glass = Material {
        metallic: 0.0,
        roughness: 0.5,
        transmission: 1.0,
        double_sided: true,
        ..Material::default()
    };
    for (name, surface) in [("metal", metal), ("glass", glass)] {
        let shot = |spp| Shot {
            size: (16, 16),
            max_depth: 1,
            spp,
        };
        let view = from_above(0.5, 1.0);
        let both = render(&device, &mut room(&surface, true), &view, shot(256));
        let scattered = render(&device, &mut room(&surface, false), &view, shot(2048));
        let (mean, variance) = mean_and_variance(&both, 256);
        let (expected, noise) = mean_and_variance(&scattered, 2048);
        let error = ((variance / 256.0 + noise / 2048.0) / 256.0).sqrt();
        let z = (mean - expected) / error;
        eprintln!("{name}: mean {mean:.5}, {expected:.5} by scattering alone, {z:.2} sigma");
        // With two of them, one beyond 4 has a probability of 1 in 8000.
        assert!(
            z.abs() < 4.0,
            "{name}: {mean}, {expected} expected, {z} sigma"
        );
    }
}
