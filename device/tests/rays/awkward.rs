//! Geometry and rays that break careless hierarchies: none may panic, hang, or become deeper than the stack.

use std::sync::Arc;

use device::native::accel::{Flags, Instance, Kernel, Mesh, Ray, Scene};
use glam::{Affine3A, Vec3};

use crate::{
    KERNELS,
    brute_force::{Body, check},
    scenes::{Random, rays},
};

fn plain(triangles: Vec<[Vec3; 3]>) -> Body {
    Body::new(triangles, |_| Flags::NONE)
}

/// Builds it, and traces rays at it by all kernels.
fn survives(triangles: Vec<[Vec3; 3]>) {
    let body = plain(triangles);
    for kernel in KERNELS {
        let scene = body.scene(
            &[Affine3A::IDENTITY, Affine3A::from_scale(Vec3::splat(2.0))],
            kernel(),
        );
        for ray in rays(&mut Random(4), 200) {
            scene.closest(&ray, |_| true);
            scene.any(&ray, |_| true);
        }
    }
}

const TRIANGLE: [Vec3; 3] = [
    Vec3::new(-1.0, -1.0, 0.0),
    Vec3::new(1.0, -1.0, 0.0),
    Vec3::new(0.0, 1.0, 0.0),
];

#[test]
fn nothing_is_hit_where_nothing_is() {
    survives(vec![]);
    survives(vec![[Vec3::ONE; 3]]);
    survives(vec![
        [Vec3::NAN; 3],
        [Vec3::INFINITY; 3],
        [Vec3::ZERO, Vec3::ONE, Vec3::NAN],
    ]);
    let corners = [Vec3::ZERO, Vec3::X];
    let mesh = Mesh::build(
        &corners,
        &[[0, 1, 2], [7, 8, u32::MAX]],
        |_| Flags::NONE,
        &crate::endless,
    );
    assert!(mesh.expect("it isn't cancelled").bounds().is_none());
}

#[test]
fn coincident_and_concentric_triangles_are_traced() {
    let coincident = vec![TRIANGLE; 5000];
    let concentric = |count: i32, factor: f32| -> Vec<[Vec3; 3]> {
        (0..count)
            .map(|i| TRIANGLE.map(|p| p * factor.powi(i - count / 2)))
            .collect()
    };
    let down = Ray {
        origin: [0.01, 0.02, 3.0],
        direction: [0.0, 0.0, -1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    for triangles in [
        coincident,
        concentric(230, 1.3),
        concentric(400, 1.05),
        concentric(2000, 1.0001),
    ] {
        let body = plain(triangles.clone());
        for kernel in KERNELS {
            let hit = body
                .scene(&[Affine3A::IDENTITY], kernel())
                .closest(&down, |_| true);
            let hit = hit.expect("it points at all of them");
            assert!((hit.t - 3.0).abs() < 1e-6);
        }
        survives(triangles);
    }
}

#[test]
fn coincident_and_concentric_instances_are_traced() {
    let mesh = Arc::new(plain(vec![TRIANGLE]).mesh());
    let down = Ray {
        origin: [0.01, 0.02, 3.0],
        direction: [0.0, 0.0, -1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    for factor in [1.0, 1.0001, 1.3, 0.0] {
        let instances: Vec<Instance> = (0..3000)
            .map(|i| {
                Instance::new(
                    Affine3A::from_scale(Vec3::splat(f32::powi(factor, i % 211))),
                    0,
                )
            })
            .collect();
        for kernel in KERNELS {
            let scene = Scene::new(vec![mesh.clone()], instances.clone(), kernel());
            let hit = scene
                .closest(&down, |_| true)
                .expect("it points at all of them");
            assert!((hit.t - 3.0).abs() < 1e-6);
        }
    }
}

#[test]
fn deep_geometry_is_traced() {
    // Each triangle a fraction of the one before, towards a corner: a chain, if one lets it.
    let mut random = Random(8);
    for factor in [0.5, 0.7, 0.9, 0.99] {
        let chain: Vec<[Vec3; 3]> = (0..3000)
            .map(|i| {
                let size = f32::powi(factor, i);
                TRIANGLE.map(|p| (p + Vec3::ONE * 3.0) * size)
            })
            .collect();
        check(
            &plain(chain[..100].to_vec()),
            &[Affine3A::IDENTITY],
            Kernel::best(),
            &rays(&mut random, 300),
            2,
        );
        survives(chain);
    }
    // Slivers from one point, and a fan in one plane.
    survives(
        (0..3000)
            .map(|i| {
                [
                    Vec3::ZERO,
                    Vec3::new(1.0, i as f32, 0.0),
                    Vec3::new(1.0, i as f32 + 1.0, 0.0),
                ]
            })
            .collect(),
    );
    survives(
        (0..3000)
            .map(|i| [Vec3::ZERO, Vec3::X * i as f32, Vec3::X * (i + 1) as f32])
            .collect(),
    );
}

#[test]
fn far_and_tiny_geometry_is_built() {
    let mut random = Random(6);
    for size in [f32::MAX, 1e38, 1e30, 1e19, 1e-19, 1e-30, 1e-38, 1e-45] {
        survives(
            (0..1000)
                .map(|_| [0; 3].map(|_| random.point(1.0) * size))
                .collect(),
        );
    }
    // All exponents together, and whatever finite bits there are.
    survives(
        (0..5000)
            .map(|_| [0; 3].map(|_| Vec3::from([0; 3].map(|_| any_finite(&mut random)))))
            .collect(),
    );
    // An ordinary triangle among them is found, and beside one that reaches to the end of the numbers.
    let mut triangles = vec![TRIANGLE];
    triangles.extend(
        (0..300).map(|i| TRIANGLE.map(|p| p * 1e3 + Vec3::new(1e38, 1e36 * i as f32, -1e38))),
    );
    triangles
        .push([Vec3::X, Vec3::X * f32::MAX, Vec3::NEG_Z * f32::MAX].map(|p| p + 2.0 * Vec3::Y));
    let down = Ray {
        origin: [0.01, 0.02, 3.0],
        direction: [0.0, 0.0, -1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    for kernel in KERNELS {
        let scene = plain(triangles.clone()).scene(&[Affine3A::IDENTITY], kernel());
        assert_eq!(
            scene
                .closest(&down, |_| true)
                .map(|hit| (hit.triangle, hit.t)),
            Some((0, 3.0))
        );
    }
}

fn any_finite(random: &mut Random) -> f32 {
    let bits = ((random.next() * 65536.0) as u32) << 16 | (random.next() * 65536.0) as u32;
    let value = f32::from_bits(bits);
    if value.is_finite() { value } else { 0.0 }
}

#[test]
fn strange_rays_hit_nothing() {
    let body = plain(vec![TRIANGLE; 50]);
    let ray = Ray {
        origin: [0.01, 0.02, 3.0],
        direction: [0.0, 0.0, -1.0],
        t_min: 0.0,
        t_max: 10.0,
    };
    let strange = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for kernel in KERNELS {
        let scene = body.scene(
            &[Affine3A::IDENTITY, Affine3A::from_translation(Vec3::X)],
            kernel(),
        );
        assert!(scene.closest(&ray, |_| true).is_some());
        let misses = |ray: Ray| {
            assert_eq!(scene.closest(&ray, |_| true), None, "{ray:?}");
            assert_eq!(scene.any(&ray, |_| true), None, "{ray:?}");
            assert_eq!(scene.any_of_instance(&ray, 0, |_| true), None, "{ray:?}");
        };
        for value in strange {
            for axis in 0..3 {
                let mut moved = ray;
                moved.origin[axis] = value;
                misses(moved);
                let mut turned = ray;
                turned.direction[axis] = value;
                misses(turned);
            }
        }
        misses(Ray {
            t_min: f32::NAN,
            ..ray
        });
        misses(Ray {
            t_max: f32::NAN,
            ..ray
        });
        misses(Ray { t_max: -1.0, ..ray });
        misses(Ray { t_min: 3.0, ..ray }); // exclusive
        misses(Ray { t_max: 3.0, ..ray });
        misses(Ray {
            direction: [0.0; 3],
            ..ray
        });
        // Extreme, but rays.
        for value in [1e-38, 1e-20, 1e20, 1e38] {
            let far = Ray {
                direction: [value, -value, value],
                t_max: f32::INFINITY,
                ..ray
            };
            scene.closest(&far, |_| true);
            let from = Ray {
                origin: [value, value, -value],
                t_max: f32::INFINITY,
                ..ray
            };
            scene.closest(&from, |_| true);
        }
    }
}

#[test]
fn places_that_cannot_be_inverted_are_survived() {
    let mesh = Arc::new(plain(vec![TRIANGLE; 9]).mesh());
    let flat = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
    let lost = Affine3A::from_translation(Vec3::splat(f32::NAN));
    let far =
        Affine3A::from_translation(Vec3::splat(3e38)) * Affine3A::from_scale(Vec3::splat(3e38));
    let ordinary = Affine3A::from_translation(Vec3::Z);
    let instances: Vec<Instance> = [flat, lost, far, Affine3A::from_scale(Vec3::ZERO), ordinary]
        .map(|place| Instance::new(place, 0))
        .into();
    let down = Ray {
        origin: [0.01, 0.02, 3.0],
        direction: [0.0, 0.0, -1.0],
        t_min: 0.0,
        t_max: f32::INFINITY,
    };
    for kernel in KERNELS {
        let scene = Scene::new(vec![mesh.clone()], instances.clone(), kernel());
        let hit = scene
            .closest(&down, |_| true)
            .map(|hit| (hit.instance, hit.t));
        assert_eq!(hit, Some((4, 2.0)));
        for i in 0..5 {
            scene.any_of_instance(&down, i, |_| true);
        }
    }
}
