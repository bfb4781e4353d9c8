//! The metallic-roughness BSDF of glTF 2.0 against its directional albedo: the light that a surface returns towards one
//! direction under a white sky, integrated numerically in double precision from the specification's formulas
//! (appendix B; height-correlated Smith). Rough metal loses light, as any single-scattering model does; here is how much.

use std::f64::consts::{PI, TAU};

use engine::renderer::RenderSettings;
use engine::scene::{Material, Projection, Scene};
use glam::{DVec3, Vec3};

use super::{MEAN_ERROR, PASSING};
use crate::support::device;
use crate::support::estimate::Estimate;
use crate::support::scenes::{Shot, add, camera, no_textures, quad, render_with, settings};
use crate::support::stats::ZTest;

/// Points along each side of a quadrature.
const POINTS: u32 = 400;

/// Pixels of a strip along each side.
const STRIP: u32 = 8;

fn strips() -> Vec<Material> {
    let metal = |roughness: f32| Material {
        base_color: Vec3::ONE.extend(1.0),
        metallic: 1.0,
        roughness,
        ..Material::default()
    };
    let gold = Material {
        base_color: Vec3::new(0.9, 0.5, 0.1).extend(1.0),
        ..metal(0.4)
    };
    let varnish = Material {
        base_color: Vec3::new(0.8, 0.4, 0.1).extend(1.0),
        metallic: 0.0,
        ..metal(0.3)
    };
    let tinted = Material {
        specular: 0.7,
        specular_color: Vec3::new(1.0, 0.6, 0.2),
        ior: 1.8,
        roughness: 0.7,
        ..varnish.clone()
    };
    let half_metal = Material {
        metallic: 0.5,
        ..varnish.clone()
    };
    let mut all: Vec<Material> = [0.0, 0.2, 0.5, 0.8, 1.0].map(metal).into();
    all.extend([gold, varnish, tinted, half_metal]);
    all
}

#[test]
fn surfaces_return_their_directional_albedo() {
    let Some(device) = device::open() else { return };
    let strips = strips();
    let mut scene = Scene {
        environment: engine::scene::Environment::Constant(Vec3::ONE),
        ..Scene::default()
    };
    for (i, material) in strips.iter().enumerate() {
        // Long strips in one plane, side by side: at grazing angles much of their length is seen.
        let corner = Vec3::new(i as f32, 0.0, 20.0);
        add(
            &mut scene,
            quad(corner, Vec3::X, Vec3::NEG_Z * 40.0),
            material.clone(),
        );
    }
    let width = strips.len() as u32 * STRIP;
    for degrees in [0.0_f32, 45.0, 70.0, 85.0] {
        let angle = degrees.to_radians();
        let target = Vec3::X * 0.5 * strips.len() as f32;
        let camera = camera(
            target + 10.0 * Vec3::new(0.0, angle.cos(), angle.sin()),
            target,
            // Perpendicular to the way the camera looks.
            Vec3::new(0.0, angle.sin(), -angle.cos()),
            Projection::Orthographic { y_mag: 0.5 },
        );
        let shot = Shot {
            size: (width, STRIP),
            max_depth: 1,
            spp: 1024,
        };
        let procedural = no_textures(&mut scene);
        // The integral below is that of a single scattering between microfacets.
        let settings = RenderSettings {
            energy_compensation: false,
            ..settings(&camera, shot)
        };
        let film = render_with(&device, &scene, &procedural, &settings, shot.spp);
        let tested = Estimate::from_film(&film);
        for (i, material) in strips.iter().enumerate() {
            let albedo = directional_albedo(material, f64::from(angle));
            let mut expected = Estimate::exact(shot.size, |_| albedo.as_vec3());
            // Of a mirror one sample in ten thousand is lost below the horizon: the samples of most pixels are all
            // alike, and their spread says nothing about those.
            expected.error.fill([2.0e-4; 3]);
            let name = format!(
                "albedo of strip {i} (roughness {}) at {degrees} degrees, {albedo:.4}",
                material.roughness
            );
            let strip = ZTest::default().compare(tested.clone(), expected, |x, _| {
                x as u32 / STRIP == i as u32
            });
            strip.assert_matches(&name, PASSING, MEAN_ERROR);
        }
    }
}

fn schlick(f0: DVec3, cosine: f64) -> DVec3 {
    f0 + (DVec3::ONE - f0) * (1.0 - cosine).powi(5)
}

/// Smith's Lambda of GGX for a direction with this cosine.
fn lambda(alpha: f64, cosine: f64) -> f64 {
    let tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// The integral of f cos over all incident directions, for a viewer at `angle` from the normal.
fn directional_albedo(material: &Material, angle: f64) -> DVec3 {
    let wo = DVec3::new(angle.sin(), 0.0, angle.cos());
    let alpha = f64::from(material.roughness).powi(2).max(1.0e-3);
    let base = material.base_color.truncate().as_dvec3();
    let metallic = f64::from(material.metallic);
    let specular = f64::from(material.specular);
    let ior = f64::from(material.ior);
    let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2) * material.specular_color.as_dvec3();
    let f0 = f0.min(DVec3::ONE);
    // The glossy part over half vectors h, distributed as D(h) cos h: then tan^2 h = alpha^2 x / (1 - x), and
    // f cos dwi = F G2 (wo h) / (cos wo cos h).
    let glossy = square(|x, y| {
        let tan2 = alpha * alpha * x / (1.0 - x);
        let cos_h = 1.0 / (1.0 + tan2).sqrt();
        let sin_h = (1.0 - cos_h * cos_h).max(0.0).sqrt();
        let h = DVec3::new(sin_h * (TAU * y).cos(), sin_h * (TAU * y).sin(), cos_h);
        let cosine = wo.dot(h);
        let wi = 2.0 * cosine * h - wo;
        if cosine <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        let shadowing = 1.0 / (1.0 + lambda(alpha, wo.z) + lambda(alpha, wi.z));
        let fresnel = (specular * schlick(f0, cosine)).lerp(schlick(base, cosine), metallic);
        fresnel * shadowing * cosine / (wo.z * cos_h)
    });
    // The matt part over cosine-distributed directions.
    let matt = square(|x, y| {
        let (radius, phi) = (x.sqrt(), TAU * y);
        let wi = DVec3::new(radius * phi.cos(), radius * phi.sin(), (1.0 - x).sqrt());
        let reflected = schlick(f0, wo.dot((wo + wi).normalize())).max_element();
        (1.0 - metallic) * (1.0 - specular * reflected) * base
    });
    glossy + matt
}

/// The mean of `f` over the unit square, by the midpoint rule.
fn square(f: impl Fn(f64, f64) -> DVec3) -> DVec3 {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(POINTS);
    let sum: DVec3 = (0..POINTS * POINTS)
        .map(|k| f(at(k % POINTS), at(k / POINTS)))
        .sum();
    sum / f64::from(POINTS * POINTS)
}

#[test]
fn the_quadrature_knows_what_is_known() {
    // A mirror and a matt white surface return everything.
    let mirror = Material {
        roughness: 0.0,
        ..Material::default()
    };
    let matt = Material {
        metallic: 0.0,
        specular: 0.0,
        ..Material::default()
    };
    for surface in [mirror, matt] {
        let albedo = directional_albedo(&surface, PI / 3.0).x;
        assert!((albedo - 1.0).abs() < 1.0e-3, "{albedo}");
    }
}
