//! The BSDF on its own, evaluated and sampled by the kernels' own code: densities integrate to one and are what is
//! sampled (chi-square), no energy is made and none lost where it must be kept, and reflection is reciprocal.
//! Skipped with a notice where there is no adapter.

use ::device::Device;
use ::device::{DeviceError, Extent, Image, Kernel, Recording, Resources, Trust, Usage};
use bytemuck::{Pod, Zeroable};
use engine::gpu_scene::albedo;
use engine::passes::wgsl::ComposedWgsl;
use glam::Vec3;

use crate::support::device;

/// `Params` below: a material with the viewer's direction.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Params {
    base_color: [f32; 3],
    metallic: f32,
    f0: [f32; 3],
    specular: f32,
    roughness: f32,
    anisotropy: f32,
    transmission: f32,
    eta: f32,
    back_color: [f32; 3],
    back: f32,
    sheen_color: [f32; 3],
    sheen_roughness: f32,
    coat: f32,
    coat_roughness: f32,
    iridescence: f32,
    iridescent_f0: f32,
    wo: [f32; 3],
    seed: u32,
}

const HARNESS: &str = r"
struct Params {
    base_color: vec3f, metallic: f32,
    f0: vec3f, specular: f32,
    roughness: f32, anisotropy: f32, transmission: f32, eta: f32,
    back_color: vec3f, back: f32,
    sheen_color: vec3f, sheen_roughness: f32,
    coat: f32, coat_roughness: f32, iridescence: f32, iridescent_f0: f32,
    wo: vec3f, seed: u32,
}
@group(0) @binding(0) var<uniform> params: Params;
// Directions to evaluate, then f |cos| and pdf of each; or the samples: direction and pdf, then weight.
@group(0) @binding(1) var<storage, read_write> data: array<vec4f>;

fn material() -> Bsdf {
    var b = plain_bsdf(params.base_color, params.metallic, params.roughness, params.f0, params.specular);
    b.alpha = anisotropic_alpha(params.roughness, params.anisotropy);
    b.transmission = params.transmission;
    b.eta = params.eta;
    b.diffuse_transmission = params.back;
    b.diffuse_transmission_color = params.back_color;
    b.sheen_color = params.sheen_color;
    b.sheen_roughness = params.sheen_roughness;
    b.coat = params.coat;
    b.coat_alpha = max(params.coat_roughness * params.coat_roughness, MIN_ALPHA);
    b.iridescence = params.iridescence;
    b.iridescent_f0 = vec3f(params.iridescent_f0);
    return b;
}

fn mixed(x: u32) -> u32 {
    var v = x;
    v = (v ^ (v >> 16u)) * 0x7feb352du;
    v = (v ^ (v >> 15u)) * 0x846ca68bu;
    return v ^ (v >> 16u);
}

fn random(i: u32, k: u32) -> f32 {
    return f32(mixed(mixed(i * 4u + k) ^ params.seed) >> 8u) / 16777216.0;
}

@compute @workgroup_size(64)
fn evaluate(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if (i >= arrayLength(&data)) { return; }
    data[i] = bsdf_eval(material(), lobes(material(), params.wo), params.wo, data[i].xyz);
}

@compute @workgroup_size(64)
fn sample(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = id.y * groups.x * 64u + id.x;
    if (2u * i + 1u >= arrayLength(&data)) { return; }
    let s = bsdf_sample(material(), lobes(material(), params.wo), params.wo, vec3f(random(i, 0u), random(i, 1u), random(i, 2u)));
    data[2u * i] = vec4f(s.wi, s.pdf);
    data[2u * i + 1u] = vec4f(s.weight, 0.0);
}
";

struct Harness {
    device: Device,
    evaluate: Kernel,
    sample: Kernel,
    albedo_table: Image,
}

impl Harness {
    fn open(energy_compensation: bool) -> Option<Self> {
        let device = device::open()?;
        let mut source = ComposedWgsl::of("shared/bsdf.wgsl");
        source.text.push_str(HARNESS);
        let constants = [(
            "energy_compensation",
            f64::from(u8::from(energy_compensation)),
        )];
        let kernel = |entry| {
            source
                .compile(&device, entry, Trust::Nothing, &constants)
                .unwrap_or_else(|error| panic!("{error}"))
        };
        let (evaluate, sample) = (kernel("evaluate"), kernel("sample"));
        let albedo_table = albedo::upload(&device).unwrap_or_else(|error| panic!("{error}"));
        Some(Self {
            device,
            evaluate,
            sample,
            albedo_table,
        })
    }

    fn run(
        &self,
        kernel: &Kernel,
        params: &Params,
        data: &[[f32; 4]],
        threads: u32,
    ) -> Vec<[f32; 4]> {
        let run = || -> Result<_, DeviceError> {
            let mut resources = Resources::default();
            let bytes = size_of_val(data) as u64;
            resources.set_image("albedo_table", self.albedo_table.clone());
            let data =
                self.device
                    .filled_buffer("data", Usage::Storage, bytemuck::cast_slice(data))?;
            resources.set_buffer("data", data);
            let params = bytemuck::bytes_of(params);
            let params = self
                .device
                .filled_buffer("params", Usage::Uniform, params)?;
            resources.set_buffer("params", params);
            let bound = kernel.bind(&self.device, &resources);
            let mut recording = Recording::new("test");
            recording.dispatch(&bound, Extent::Threads(threads));
            self.device.play(&recording)?;
            self.device.read(resources.buffer("data"), 0, bytes)
        };
        bytemuck::pod_collect_to_vec(&run().unwrap_or_else(|error| panic!("{error}")))
    }

    /// f |cos| and pdf of each direction.
    fn eval(&self, params: &Params, directions: &[Vec3]) -> Vec<[f32; 4]> {
        let data: Vec<[f32; 4]> = directions.iter().map(|d| [d.x, d.y, d.z, 0.0]).collect();
        self.run(&self.evaluate, params, &data, data.len() as u32)
    }

    /// Direction, pdf and weight of samples; the pdf is 0 where there is none.
    fn samples(&self, params: &Params, count: u32) -> Vec<(Vec3, f32, Vec3)> {
        let data = vec![[0.0; 4]; 2 * count as usize];
        let out = self.run(&self.sample, params, &data, count);
        let vector = |v: [f32; 4]| Vec3::new(v[0], v[1], v[2]);
        out.chunks_exact(2)
            .map(|pair| (vector(pair[0]), pair[0][3], vector(pair[1])))
            .collect()
    }
}

fn viewer(cosine: f32) -> [f32; 3] {
    let sine = (1.0 - cosine * cosine).sqrt();
    [sine * 0.8, sine * 0.6, cosine]
}

/// A white dielectric; the rest is for each test to say.
fn plain(roughness: f32, cosine: f32) -> Params {
    Params {
        base_color: [1.0; 3],
        f0: [0.04; 3],
        specular: 1.0,
        roughness,
        eta: 1.0,
        coat_roughness: 0.3,
        wo: viewer(cosine),
        seed: 17,
        ..Params::zeroed()
    }
}

/// The surface of a clear body; `eta` is the index below over that above.
fn glass(eta: f32, plain: Params) -> Params {
    Params {
        transmission: 1.0,
        eta,
        f0: [((eta - 1.0) / (eta + 1.0)).powi(2); 3],
        ..plain
    }
}

/// The skin of a body that scatters all light, half of what meets it to its other side.
fn body(eta: f32, plain: Params) -> Params {
    Params {
        transmission: 0.0,
        back: 0.5,
        back_color: [1.0; 3],
        ..glass(eta, plain)
    }
}

/// Materials with every lobe there is, alone and together.
fn materials(roughness: f32, cosine: f32) -> Vec<(&'static str, Params)> {
    let plain = plain(roughness, cosine);
    vec![
        ("dielectric", plain),
        (
            "metal",
            Params {
                metallic: 1.0,
                ..plain
            },
        ),
        (
            "mixture",
            Params {
                metallic: 0.5,
                base_color: [0.8, 0.4, 0.1],
                ..plain
            },
        ),
        (
            "anisotropic metal",
            Params {
                metallic: 1.0,
                anisotropy: 0.7,
                ..plain
            },
        ),
        (
            "coated",
            Params {
                coat: 1.0,
                base_color: [0.3, 0.1, 0.6],
                ..plain
            },
        ),
        (
            "sheen",
            Params {
                sheen_color: [0.9, 0.5, 0.3],
                sheen_roughness: roughness.max(0.2),
                ..plain
            },
        ),
        (
            "thin glass",
            Params {
                transmission: 1.0,
                ..plain
            },
        ),
        (
            "glass",
            Params {
                transmission: 1.0,
                eta: 1.5,
                ..plain
            },
        ),
        (
            "glass from inside",
            Params {
                transmission: 1.0,
                eta: 1.0 / 1.5,
                ..plain
            },
        ),
        (
            "leaf",
            Params {
                back: 0.6,
                back_color: [0.2, 0.9, 0.1],
                ..plain
            },
        ),
        (
            "everything",
            Params {
                metallic: 0.2,
                coat: 0.7,
                sheen_color: [0.3, 0.2, 0.1],
                sheen_roughness: 0.5,
                transmission: 0.4,
                eta: 1.3,
                back: 0.3,
                back_color: [0.5; 3],
                anisotropy: 0.4,
                ..plain
            },
        ),
    ]
}

/// Cells over the sphere: the cosine from 1 to -1 in rows, the azimuth in columns.
const ROWS: usize = 24;
const COLUMNS: usize = 24;

fn cell_of(d: Vec3) -> usize {
    let row = ((1.0 - d.z) * 0.5 * ROWS as f32) as usize;
    let turn = d.y.atan2(d.x) / std::f32::consts::TAU + 0.5;
    row.min(ROWS - 1) * COLUMNS + ((turn * COLUMNS as f32) as usize).min(COLUMNS - 1)
}

/// Midpoints of a fine grid inside each cell; each stands for the same solid angle.
fn grid(fine: usize) -> Vec<Vec3> {
    let mut points = Vec::new();
    for cell in 0..ROWS * COLUMNS {
        let (row, column) = (cell / COLUMNS, cell % COLUMNS);
        for k in 0..fine * fine {
            let at = |i: usize| (i as f32 + 0.5) / fine as f32;
            let z = 1.0 - 2.0 * (row as f32 + at(k / fine)) / ROWS as f32;
            let turn = (column as f32 + at(k % fine)) / COLUMNS as f32 - 0.5;
            let (sin, cos) = (turn * std::f32::consts::TAU).sin_cos();
            let r = (1.0 - z * z).sqrt();
            points.push(Vec3::new(r * cos, r * sin, z));
        }
    }
    points
}

#[test]
fn what_is_sampled_is_what_the_density_says() {
    let Some(harness) = Harness::open(true) else {
        return;
    };
    const FINE: usize = 12;
    const SAMPLES: u32 = 200_000;
    let points = grid(FINE);
    let share = 4.0 * std::f64::consts::PI / points.len() as f64;
    let mut tests = 0;
    let mut worst: (f64, String) = (0.0, String::new());
    for roughness in [0.35, 0.6, 1.0] {
        for cosine in [0.95, 0.5, 0.15] {
            for (name, params) in materials(roughness, cosine) {
                let name = format!("{name}, roughness {roughness}, cosine {cosine}");
                let densities = harness.eval(&params, &points);
                let samples = harness.samples(&params, SAMPLES);
                // Expected and found numbers of samples in each cell.
                let expected: Vec<f64> = densities
                    .chunks_exact(FINE * FINE)
                    .map(|cell| {
                        cell.iter().map(|v| f64::from(v[3])).sum::<f64>()
                            * share
                            * f64::from(SAMPLES)
                    })
                    .collect();
                let mut found = vec![0.0; ROWS * COLUMNS];
                for (wi, pdf, _) in &samples {
                    if *pdf > 0.0 {
                        found[cell_of(*wi)] += 1.0;
                    }
                }
                let total: f64 = expected.iter().sum::<f64>() / f64::from(SAMPLES);
                assert!(total < 1.01, "{name}: the density integrates to {total}");
                // Samples below the surface are lost, and the density has no part there either.
                let kept = found.iter().sum::<f64>() / f64::from(SAMPLES);
                assert!(
                    (kept - total).abs() < 0.01,
                    "{name}: {kept} are sampled, {total} expected"
                );
                // Quadrature has an error of its own where the density is steep.
                let (mut chi2, mut freedom) = (0.0_f64, 0.0_f64);
                let (mut rest_expected, mut rest_found) = (0.0, 0.0);
                for (e, f) in expected.iter().zip(&found) {
                    if *e >= 20.0 {
                        let variance = e + (0.01 * e) * (0.01 * e);
                        chi2 += (f - e) * (f - e) / variance;
                        freedom += 1.0;
                    } else {
                        rest_expected += e;
                        rest_found += f;
                    }
                }
                if rest_expected > 5.0 {
                    chi2 +=
                        (rest_found - rest_expected) * (rest_found - rest_expected) / rest_expected;
                    freedom += 1.0;
                }
                // Wilson and Hilferty's normal deviate of a chi-square variable.
                let spread = (2.0 / (9.0 * freedom)).sqrt();
                let z = ((chi2 / freedom).cbrt() - (1.0 - spread * spread)) / spread;
                tests += 1;
                if z > worst.0 {
                    worst = (z, name);
                }
            }
        }
    }
    eprintln!(
        "{tests} tests, the worst at {:.2} sigma: {}",
        worst.0, worst.1
    );
    // With a hundred tests, one beyond 4.5 has a probability of 3 in 10,000.
    assert!(worst.0 < 4.5, "{}: {} sigma", worst.1, worst.0);
}

#[test]
fn weights_are_the_ratio_of_value_and_density() {
    let Some(harness) = Harness::open(true) else {
        return;
    };
    for cosine in [0.9, 0.3] {
        for (name, params) in materials(0.5, cosine) {
            let samples = harness.samples(&params, 2000);
            let valid: Vec<_> = samples.into_iter().filter(|s| s.1 > 0.0).collect();
            let directions: Vec<Vec3> = valid.iter().map(|s| s.0).collect();
            for ((_, pdf, weight), value) in valid.iter().zip(harness.eval(&params, &directions)) {
                for c in 0..3 {
                    let expected = value[c] / value[3];
                    assert!(
                        (weight[c] - expected).abs() <= 2e-3 * expected.abs().max(1e-2),
                        "{name}: {weight} but f |cos| / pdf is {expected}"
                    );
                }
                assert!((pdf / value[3] - 1.0).abs() < 2e-3, "{name}");
            }
        }
    }
}

#[test]
fn no_sample_of_rough_glass_counts_for_much_more_than_others() {
    let Some(harness) = Harness::open(true) else {
        return;
    };
    for eta in [1.5, 1.0 / 1.5, 2.4, 1.0 / 2.4] {
        for roughness in [0.0, 0.1, 0.2, 0.4, 0.6] {
            for cosine in [0.95, 0.76, 0.7, 0.4, 0.1] {
                let params = glass(eta, plain(roughness, cosine));
                // As power: radiance is denser inside.
                let largest = (harness.samples(&params, 1 << 14).iter())
                    .map(|s| s.2.x * if s.0.z < 0.0 { eta * eta } else { 1.0 })
                    .fold(0.0, f32::max);
                assert!(
                    largest < 1.6,
                    "index {eta}, roughness {roughness}, cosine {cosine}: {largest}"
                );
            }
        }
    }
}

/// Share of light that comes back from a furnace, per channel, by sampling. Weights carry radiance, which is denser inside
/// a body by the square of its index; what is counted here is power.
fn albedo_of(harness: &Harness, params: &Params) -> Vec3 {
    const SAMPLES: u32 = 1 << 18;
    let refracted = f64::from(params.eta).powi(2);
    let sum: glam::DVec3 = (harness.samples(params, SAMPLES).iter())
        .filter(|s| s.1 > 0.0)
        .map(|s| s.2.as_dvec3() * if s.0.z < 0.0 { refracted } else { 1.0 })
        .sum();
    (sum / f64::from(SAMPLES)).as_vec3()
}

#[test]
fn white_surfaces_keep_all_light() {
    let Some(harness) = Harness::open(true) else {
        return;
    };
    let mut wrong = Vec::new();
    for roughness in [0.1, 0.3, 0.5, 0.7, 1.0] {
        for cosine in [1.0, 0.7, 0.4, 0.15] {
            let plain = plain(roughness, cosine);
            for (name, params) in [
                ("dielectric", plain),
                (
                    "metal",
                    Params {
                        metallic: 1.0,
                        ..plain
                    },
                ),
                (
                    "matt",
                    Params {
                        specular: 0.0,
                        ..plain
                    },
                ),
                (
                    "leaf",
                    Params {
                        back: 0.5,
                        back_color: [1.0; 3],
                        ..plain
                    },
                ),
                (
                    "thin glass",
                    Params {
                        transmission: 1.0,
                        ..plain
                    },
                ),
                ("glass", glass(1.5, plain)),
                ("glass from inside", glass(1.0 / 1.5, plain)),
                ("diamond", glass(2.42, plain)),
                ("diamond from inside", glass(1.0 / 2.42, plain)),
                (
                    "milky glass",
                    Params {
                        transmission: 0.5,
                        ..glass(1.3, plain)
                    },
                ),
                ("milk", body(1.5, plain)),
                ("milk from inside", body(1.0 / 1.5, plain)),
                (
                    "milk in glass from inside",
                    Params {
                        transmission: 0.5,
                        ..body(1.0 / 1.3, plain)
                    },
                ),
                (
                    "half a metal",
                    Params {
                        metallic: 0.5,
                        ..plain
                    },
                ),
                (
                    "soap",
                    Params {
                        iridescence: 1.0,
                        iridescent_f0: 0.4,
                        ..plain
                    },
                ),
                (
                    "thin soap",
                    Params {
                        iridescence: 1.0,
                        iridescent_f0: 0.4,
                        transmission: 1.0,
                        ..plain
                    },
                ),
                (
                    "varnish",
                    Params {
                        coat: 1.0,
                        coat_roughness: roughness,
                        ..plain
                    },
                ),
            ] {
                let albedo = albedo_of(&harness, &params);
                if (albedo - Vec3::ONE).abs().max_element() >= 0.01 {
                    wrong.push(format!(
                        "{name}, roughness {roughness}, cosine {cosine}: {albedo}"
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The albedo of what is stretched is that of isotropic surfaces which look like it from there: nearly.
#[test]
fn stretched_surfaces_keep_nearly_all_light() {
    let Some(harness) = Harness::open(true) else {
        return;
    };
    let mut wrong = Vec::new();
    for (roughness, anisotropy) in [(0.1, 0.5), (0.1, 1.0), (0.5, 1.0), (0.7, 0.5)] {
        for cosine in [1.0_f32, 0.7, 0.4, 0.15] {
            for turn in [0.0_f32, 0.8, 1.57] {
                let sine = (1.0 - cosine * cosine).sqrt();
                let plain = Params {
                    anisotropy,
                    wo: [sine * turn.cos(), sine * turn.sin(), cosine],
                    ..plain(roughness, cosine)
                };
                let metal = Params {
                    metallic: 1.0,
                    ..plain
                };
                for (name, params) in [("dielectric", plain), ("metal", metal)] {
                    let albedo = albedo_of(&harness, &params);
                    if (albedo - Vec3::ONE).abs().max_element() >= 0.1 {
                        wrong.push(format!(
                            "{name}, roughness {roughness}, anisotropy {anisotropy}, cosine {cosine}, turn {turn}: {albedo}"
                        ));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// How far apart the widths are says nothing of how rough glass is: hardly rough, it loses nothing, nor makes any.
#[test]
fn stretched_glass_that_is_hardly_rough_keeps_all_light() {
    let Some(harness) = Harness::open(true) else {
        return;
    };
    for eta in [1.5, 1.0 / 1.5] {
        for cosine in [1.0_f32, 0.75, 0.45] {
            for turn in [0.0_f32, 0.8, 1.57] {
                let sine = (1.0 - cosine * cosine).sqrt();
                let stretched = Params {
                    anisotropy: 0.3,
                    wo: [sine * turn.cos(), sine * turn.sin(), cosine],
                    ..plain(0.1, cosine)
                };
                // By integration of single scattering 0.993 to 1.006.
                let albedo = albedo_of(&harness, &glass(eta, stretched));
                assert!(
                    (albedo - Vec3::ONE).abs().max_element() < 0.012,
                    "index {eta}, cosine {cosine}, turn {turn}: {albedo}"
                );
            }
        }
    }
}

#[test]
fn no_material_makes_light() {
    // Without compensation the formula of glTF itself does: at grazing angles a white dielectric returns up to 1.4 times
    // what it receives, because its body takes the share that a microfacet leaves, not that of the whole surface.
    let Some(harness) = Harness::open(true) else {
        return;
    };
    for roughness in [0.1, 0.4, 1.0] {
        for cosine in [1.0, 0.5, 0.15] {
            for (name, params) in materials(roughness, cosine) {
                let albedo = albedo_of(&harness, &params);
                assert!(
                    albedo.max_element() < 1.015,
                    "{name}, roughness {roughness}, cosine {cosine}: {albedo}"
                );
            }
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    // Without compensation: that takes the viewer's side only, as the paper it follows does.
    let Some(harness) = Harness::open(false) else {
        return;
    };
    let directions: Vec<Vec3> = grid(1).into_iter().filter(|d| d.z > 0.1).collect();
    for roughness in [0.3, 0.7] {
        for (name, forth) in materials(roughness, 0.6) {
            // The coat and the body below light that scatters to the back take the viewer's angle only.
            if forth.coat > 0.0 || forth.transmission > 0.0 || forth.back > 0.0 {
                continue;
            }
            let there = harness.eval(&forth, &directions);
            for (d, value) in directions.iter().zip(there) {
                let back = Params {
                    wo: d.to_array(),
                    ..forth
                };
                let from = Vec3::from(forth.wo);
                let again = harness.eval(&back, &[from])[0];
                for c in 0..3 {
                    let (f, g) = (value[c] / d.z, again[c] / from.z);
                    assert!(
                        (f - g).abs() <= 1e-3 * f.max(1e-2),
                        "{name}: {f} there, {g} back"
                    );
                }
            }
        }
    }
}
