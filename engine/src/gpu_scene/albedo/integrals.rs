//! How the table came about: its integrals.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{GLASS_BLOCKS, SIDE};

/// (index - 1) / (index + 1) at the end of the last one, as `GLASS_MOST`.
const GLASS_MOST: f32 = 0.5;
/// Points of each integral.
const POINTS: u32 = 4096;
/// As `MIN_ALPHA` in `microfacet.wgsl`.
const MIN_ALPHA: f32 = 0.001;

/// The numbers of the file: of each cell of the block of surfaces three, then of each cell of the slices of glass, two.
pub(super) fn numbers() -> Vec<f32> {
    fn block<const N: usize>(of: impl Fn(f32, f32) -> [f32; N] + Sync) -> Vec<f32> {
        let cell = |i: u32| {
            let at = |k: u32| k as f32 / (SIDE - 1) as f32;
            of(at(i % SIDE).max(1e-3), at(i / SIDE))
        };
        let cells: Vec<[f32; N]> = (0..SIDE * SIDE).into_par_iter().map(cell).collect();
        cells.concat()
    }
    let mut numbers = block(|cosine, roughness| {
        let [f0, f90] = ggx(cosine, roughness);
        [f0, f90, charlie(cosine, roughness)]
    });
    for slice in 0..=GLASS_BLOCKS {
        let ratio = slice as f32 / GLASS_BLOCKS as f32 * GLASS_MOST;
        let index = (1.0 + ratio) / (1.0 - ratio);
        numbers.extend(block(|cosine, roughness| {
            [index, 1.0 / index].map(|eta| glass(cosine, roughness, eta))
        }));
    }
    numbers
}

/// Directional albedo of GGX with Smith's height-correlated masking for F = f0 * x + f90 * y (Karis, "Real Shading in
/// Unreal Engine 4", 2013).
fn ggx(cosine: f32, roughness: f32) -> [f32; 2] {
    let alpha = (roughness * roughness).max(MIN_ALPHA);
    let wo = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let root = |v: Vec3| (1.0 + alpha * alpha * (v.x * v.x + v.y * v.y) / (v.z * v.z)).sqrt();
    let mut sums = [0.0; 2];
    for i in 0..POINTS {
        let h = visible_normal(wo, alpha, point(i));
        let wi = h * (2.0 * wo.dot(h)) - wo;
        if wi.z <= 0.0 {
            continue;
        }
        // G2 / G1: the weight of a direction that is reflected at a visible normal.
        let weight = (1.0 + root(wo)) / (root(wo) + root(wi));
        let fresnel = (1.0 - wo.dot(h)).clamp(0.0, 1.0).powi(5);
        sums[0] += weight * (1.0 - fresnel);
        sums[1] += weight * fresnel;
    }
    sums.map(|sum| sum / POINTS as f32)
}

/// Share of light that single scattering at the surface of a clear body reflects or refracts, with Schlick's reflection as
/// in `bsdf.wgsl`. Not the density of radiance, which changes with the index.
fn glass(cosine: f32, roughness: f32, eta: f32) -> f32 {
    let alpha = (roughness * roughness).max(MIN_ALPHA);
    let wo = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let root = |v: Vec3| (1.0 + alpha * alpha * (v.x * v.x + v.y * v.y) / (v.z * v.z)).sqrt();
    let f0 = ((eta - 1.0) / (eta + 1.0)).powi(2);
    let alike = (7.07 * (eta - 1.0).abs() / (eta + 1.0)).min(1.0);
    let sum: f32 = (0..POINTS)
        .map(|i| {
            let h = visible_normal(wo, alpha, point(i));
            let o = wo.dot(h);
            let refracted2 = 1.0 - (1.0 - o * o) / (eta * eta);
            let inside = refracted2.max(0.0).sqrt();
            let outside = if eta < 1.0 { inside } else { o };
            let reflected = match refracted2 > 0.0 {
                true => f0 + (1.0 - f0) * alike * (1.0 - outside).clamp(0.0, 1.0).powi(5),
                false => 1.0,
            };
            // G2 / G1: the weight of a direction that comes of a visible normal.
            let weight = |wi: Vec3, is_there: bool| match is_there {
                true => (1.0 + root(wo)) / (root(wo) + root(wi)),
                false => 0.0,
            };
            let up = h * (2.0 * o) - wo;
            let down = h * (o / eta - inside) - wo / eta;
            reflected * weight(up, up.z > 0.0) + (1.0 - reflected) * weight(down, down.z < 0.0)
        })
        .sum();
    sum / POINTS as f32
}

/// Dupuy and Benyoub 2023, as in `microfacet.wgsl`.
fn visible_normal(wo: Vec3, alpha: f32, u: Vec2) -> Vec3 {
    let v = Vec3::new(wo.x * alpha, wo.y * alpha, wo.z).normalize();
    let (sin, cos) = (2.0 * PI * u.x).sin_cos();
    let z = (1.0 - u.y) * (1.0 + v.z) - v.z;
    let s = (1.0 - z * z).max(0.0).sqrt();
    let h = Vec3::new(s * cos, s * sin, z) + v;
    Vec3::new(h.x * alpha, h.y * alpha, h.z.max(1e-7)).normalize()
}

/// Directional albedo of Charlie's sheen.
fn charlie(cosine: f32, roughness: f32) -> f32 {
    let alpha = (roughness * roughness).max(0.0025);
    let wo = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let sum: f32 = (0..POINTS)
        .map(|i| {
            let u = point(i);
            let (z, phi) = (u.x.max(1e-4), 2.0 * PI * u.y);
            let r = (1.0 - z * z).max(0.0).sqrt();
            let wi = Vec3::new(r * phi.cos(), r * phi.sin(), z);
            let h = (wo + wi).normalize();
            let sine2 = (1.0 - h.z * h.z).max(0.0078125 * 0.0078125);
            let d = (2.0 + 1.0 / alpha) * sine2.powf(0.5 / alpha) / (2.0 * PI);
            let masking = 1.0 + charlie_lambda(wo.z, alpha) + charlie_lambda(z, alpha);
            2.0 * PI * d / (4.0 * wo.z * masking)
        })
        .sum();
    (sum / POINTS as f32).min(1.0)
}

fn charlie_lambda(cosine: f32, alpha: f32) -> f32 {
    if cosine < 0.5 {
        charlie_fit(cosine, alpha).exp()
    } else {
        (2.0 * charlie_fit(0.5, alpha) - charlie_fit(1.0 - cosine, alpha)).exp()
    }
}

/// Fit of Estevez and Kulla 2017.
fn charlie_fit(x: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let mix = |rough: f32, smooth: f32| rough + (smooth - rough) * t;
    let (a, b, c) = (
        mix(21.5473, 25.3245),
        mix(3.82987, 3.32435),
        mix(0.19823, 0.16801),
    );
    let (d, e) = (mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    a / (1.0 + b * x.max(1e-6).powf(c)) + d * x + e
}

/// Point `i` of an evenly spread sequence (M. Roberts' R2, 2018).
fn point(i: u32) -> Vec2 {
    let at = |step: f64| ((0.5 + step * f64::from(i + 1)).fract()) as f32;
    Vec2::new(at(0.754_877_666_246_692_8), at(0.569_840_290_998_053_3))
}

mod tests {
    use super::*;

    #[test]
    fn a_mirror_reflects_all_and_a_rough_surface_loses_some() {
        let albedo = |cosine, roughness| ggx(cosine, roughness).iter().sum::<f32>();
        assert!((albedo(0.5, 0.0) - 1.0).abs() < 1e-3);
        // With a width of 1 and straight on, the integral is that of c / (1 + c) over c from 0 to 1.
        let expected = 1.0 - 2.0_f32.ln();
        assert!((albedo(1.0, 1.0) - expected).abs() < 5e-4);
        assert!(ggx(1.0, 0.3)[1] < 0.01, "no grazing reflection straight on");
    }

    #[test]
    fn smooth_glass_loses_nothing_and_rough_glass_some() {
        for eta in [1.5, 1.0 / 1.5] {
            for cosine in [0.2, 0.7, 1.0] {
                assert!((glass(cosine, 0.0, eta) - 1.0).abs() < 2e-3);
                let rough = glass(cosine, 1.0, eta);
                assert!((0.3..0.97).contains(&rough), "{eta}, {cosine}: {rough}");
            }
        }
    }

    #[test]
    fn sheen_is_strongest_at_grazing_angles() {
        for roughness in [0.3, 0.6, 1.0] {
            assert!(charlie(0.05, roughness) > charlie(0.9, roughness));
        }
    }
}
