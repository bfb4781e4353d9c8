//! The traversal kernel against obvhs' traversal on the CPU, over the same triangles flattened into the world: a million
//! rays through Sponza, and a million through a mesh of awkward triangles placed by awkward transforms. Then scenes whose
//! hierarchies are hard to build: where everything is in the same place, and where numbers leave the range of single precision.

use std::time::Duration;

use ::device::Device;
use engine::bvh::SceneBvh;
use engine::passes::traverse::Rays;
use engine::scene::{Instance, Material, Mesh, Scene, default_camera, import};
use engine::wave::RayHit;
use glam::{Affine3A, DAffine3, DVec3, EulerRot, Quat, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;
use patina_bench::traverse::{Tracer, camera_rays};
use rayon::prelude::*;

use crate::support::normal::Normal;
use crate::support::{device, scenes, shared};

const RAYS: usize = 1_000_000;
/// Share of the rays that may disagree. The kernel works in object space and single precision: a ray within a few ulps
/// of an edge may pass on the other side of it, and then it hits something else or nothing.
const DISAGREEING: f64 = 1.0e-4;
/// Relative difference of two distances that agree.
const DISTANCE_ERROR: f64 = 1.0e-4;
/// How well a position in single precision is known, relative to the numbers that it was computed from: eight ulps.
const POSITION_ERROR: f32 = 1.0e-6;
/// Nothing is that far away, metres.
const FAR: f32 = 1.0e30;

/// A triangle in the world; counter-clockwise seen from its front.
struct Face {
    corners: [DVec3; 3],
    /// Rays pass through its back.
    single_sided: bool,
}

/// The scene flattened into the world, with obvhs' hierarchy over it. Triangles are tested in double precision.
struct Reference {
    triangles: Vec<Face>,
    hierarchy: CwBvh,
}

impl Reference {
    fn new(scene: &Scene) -> Self {
        let mut triangles = Vec::new();
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh as usize];
            let transform = DAffine3::from_cols(
                Vec3::from(instance.transform.matrix3.x_axis).as_dvec3(),
                Vec3::from(instance.transform.matrix3.y_axis).as_dvec3(),
                Vec3::from(instance.transform.matrix3.z_axis).as_dvec3(),
                Vec3::from(instance.transform.translation).as_dvec3(),
            );
            let mirrors = transform.matrix3.determinant() < 0.0;
            let faces = mesh.triangles.iter().zip(&mesh.triangle_materials);
            triangles.extend(faces.map(|(triangle, &material)| {
                let [a, b, c] = triangle
                    .map(|v| transform.transform_point3(mesh.positions[v as usize].as_dvec3()));
                Face {
                    // A mirror turns the winding over, and glTF then takes the other winding for the front.
                    corners: if mirrors { [a, c, b] } else { [a, b, c] },
                    single_sided: !scene.materials[material as usize].double_sided,
                }
            }));
        }
        let rounded: Vec<Triangle> = triangles
            .iter()
            .map(|triangle| {
                let [v0, v1, v2] = triangle.corners.map(|v| Vec3A::from(v.as_vec3()));
                Triangle { v0, v1, v2 }
            })
            .collect();
        let hierarchy = build_cwbvh(
            &rounded,
            BvhBuildParams::medium_build(),
            &mut Duration::default(),
        );
        Self {
            triangles,
            hierarchy,
        }
    }

    /// Distance to the closest triangle, infinite where there is none.
    fn closest(&self, ray: &RayHit) -> f64 {
        // obvhs misses boxes where a component is -0; adding 0 makes it +0.
        let traced = Ray::new(
            ray.origin.into(),
            (ray.direction + Vec3::ZERO).into(),
            ray.t_min,
            ray.t_max,
        );
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let mut closest = f64::INFINITY;
        let mut hit = obvhs::ray::RayHit::none();
        self.hierarchy.ray_traverse(traced, &mut hit, |_, place| {
            let triangle = self.hierarchy.primitive_indices[place] as usize;
            let t = distance(&self.triangles[triangle], origin, direction);
            closest = closest.min(t);
            t as f32
        });
        closest
    }
}

/// Möller and Trumbore's test (1997); infinite for a miss. A triangle without area is never hit.
fn distance(triangle: &Face, origin: DVec3, direction: DVec3) -> f64 {
    let [a, b, c] = triangle.corners;
    let (edge1, edge2) = (b - a, c - a);
    let p = direction.cross(edge2);
    let determinant = edge1.dot(p);
    if triangle.single_sided && determinant < 0.0 {
        return f64::INFINITY;
    }
    let inverse = 1.0 / determinant;
    let s = origin - a;
    let u = s.dot(p) * inverse;
    let q = s.cross(edge1);
    let v = direction.dot(q) * inverse;
    let t = edge2.dot(q) * inverse;
    // False for NaN, too.
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 {
        t
    } else {
        f64::INFINITY
    }
}

/// A quarter of them through the pixels of a camera, the others from anywhere in the scene's bounds to anywhere; some
/// of these along an axis, where a reciprocal is infinite.
fn rays(scene: &Scene) -> Vec<RayHit> {
    let camera = scene.cameras.first().cloned();
    let camera = camera.unwrap_or_else(|| default_camera(scene));
    let mut rays = camera_rays(&camera, 512);
    let (low, high) = scene.bounds().expect("the scene is not empty");
    let mut random = Normal::new(1);
    while rays.len() < RAYS {
        let mut uniform = || random.uniform() as f32;
        let place = Vec3::new(uniform(), uniform(), uniform());
        let origin = low + (high - low) * place;
        let mut direction = Vec3::from_array(std::array::from_fn(|_| random.sample() as f32));
        if rays.len().is_multiple_of(16) {
            direction = Vec3::AXES[rays.len() / 16 % 3] * direction.x.signum();
        }
        if let Some(direction) = direction.try_normalize() {
            rays.push(RayHit::new(origin, direction, FAR));
        }
    }
    rays
}

/// Whether the kernel's answer for a ray is that of the reference.
fn is_right(tracer: &Tracer, scene: &Scene, hit: &RayHit, expected: f64) -> bool {
    if hit.triangle == RayHit::MISS || !expected.is_finite() {
        return hit.triangle == RayHit::MISS && !expected.is_finite();
    }
    let [a, b, c] = tracer.world_triangle(scene, hit);
    // Positions are known to a few ulps; a ray that grazes a surface turns those into more of its own length.
    let position_error = POSITION_ERROR * (hit.origin.length() + hit.t_max);
    let cosine = (b - a).cross(c - a).normalize_or_zero().dot(hit.direction);
    let difference = (f64::from(hit.t_max) - expected).abs();
    if difference > DISTANCE_ERROR * expected
        && difference * f64::from(cosine.abs()) > f64::from(position_error)
    {
        return false;
    }
    // Where the triangle says that it was hit must be where the ray is: triangle and instance are right as well.
    let weights = hit.barycentrics;
    let on_triangle = a * (1.0 - weights.x - weights.y) + b * weights.x + c * weights.y;
    let on_ray = hit.origin + hit.direction * hit.t_max;
    on_triangle.distance(on_ray) * cosine.abs() <= 4.0 * position_error
}

/// Compares both kinds of rays with the reference.
fn compare(scene: &Scene) {
    let Some(device) = device::open() else { return };
    let tracer = Tracer::new(&device, scene).unwrap_or_else(|error| panic!("{error}"));
    let reference = Reference::new(scene);
    let rays = rays(scene);
    let expected: Vec<f64> = rays.par_iter().map(|ray| reference.closest(ray)).collect();
    let hits = expected.iter().filter(|t| t.is_finite()).count();
    assert!(hits > RAYS / 20, "only {hits} rays hit anything");

    let trace = |rays: &[RayHit], kind| {
        let traced = tracer.trace(rays, kind);
        traced.unwrap_or_else(|error| panic!("{error}")).0
    };
    let closest = trace(&rays, Rays::Closest);
    let wrong = closest
        .par_iter()
        .zip(&expected)
        .filter(|(hit, expected)| !is_right(&tracer, scene, hit, **expected));
    assert_few("closest hits", wrong.count());

    // Shadow rays that end before or behind what the reference found, clear of it.
    let mut random = Normal::new(2);
    let shadow: Vec<RayHit> = rays
        .iter()
        .zip(&expected)
        .map(|(ray, &t)| {
            let factor =
                0.2 + 0.75 * random.uniform() + if random.uniform() < 0.5 { 0.85 } else { 0.0 };
            let t_max = if t.is_finite() { t * factor } else { 1.0e4 };
            RayHit::new(ray.origin, ray.direction, t_max as f32)
        })
        .collect();
    let occluded = trace(&shadow, Rays::Occlusion);
    let wrong = occluded.iter().zip(&shadow).zip(&expected);
    let wrong = wrong.filter(|((traced, ray), t)| {
        (traced.triangle != RayHit::MISS) != (**t < f64::from(ray.t_max))
    });
    assert_few("shadow rays", wrong.count());
}

#[track_caller]
fn assert_few(what: &str, wrong: usize) {
    eprintln!("{what}: {wrong} of {RAYS} rays disagree");
    assert!(
        wrong as f64 <= DISAGREEING * RAYS as f64,
        "{what}: {wrong} of {RAYS} rays disagree with the CPU"
    );
}

#[test]
fn a_million_rays_of_sponza_agree_with_the_cpu() {
    let Some(path) = shared::find("scenes/Sponza/Sponza.gltf") else {
        return;
    };
    let imported = import::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let mut scene = imported.scene;
    // Only geometry: leaves are not cut out, back faces are hit, and no image is uploaded.
    scene.images.clear();
    for material in &mut scene.materials {
        *material = Material {
            name: material.name.clone(),
            double_sided: true,
            ..Material::default()
        };
    }
    compare(&scene);
}

#[test]
fn a_million_rays_of_awkward_triangles_agree_with_the_cpu() {
    compare(&awkward_scene());
}

/// A square of two metres about the origin, seen along -z, and instances of it.
fn squares(transforms: impl IntoIterator<Item = Affine3A>) -> Scene {
    let mut scene = Scene::default();
    let square = scenes::quad(Vec3::new(-1.0, -1.0, 0.0), 2.0 * Vec3::X, 2.0 * Vec3::Y);
    scenes::add(&mut scene, square, Material::default());
    scene.instances = (transforms.into_iter().enumerate())
        .map(|(i, transform)| Instance {
            name: format!("instance {i}"),
            mesh: 0,
            transform,
            asset: None,
        })
        .collect();
    scene
}

/// Distances along rays from z = 5 towards points of the square; infinite where nothing was hit.
fn distances_to_square(device: &Device, scene: &Scene) -> Vec<f32> {
    let tracer = Tracer::new(device, scene).unwrap_or_else(|error| panic!("{error}"));
    let mut random = Normal::new(4);
    let rays: Vec<RayHit> = (0..1000)
        .map(|_| {
            let mut place = || 1.8 * random.uniform() as f32 - 0.9;
            let target = Vec3::new(place(), place(), 0.0);
            let origin = Vec3::new(place(), place(), 5.0);
            RayHit::new(origin, (target - origin).normalize(), FAR)
        })
        .collect();
    let traced = tracer.trace(&rays, Rays::Closest);
    let (traced, _) = traced.unwrap_or_else(|error| panic!("{error}"));
    (traced.iter())
        .map(|hit| match hit.triangle {
            RayHit::MISS => f32::INFINITY,
            _ => -hit.t_max * hit.direction.z,
        })
        .collect()
}

/// Were the time quadratic, these would take minutes.
#[test]
fn instances_in_the_same_place_are_hit() {
    let Some(device) = device::open() else { return };
    let same = squares(vec![Affine3A::IDENTITY; 20_000]);
    let bvh = SceneBvh::build(&same).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(bvh.instance_order.len(), 20_000);
    let coincident = squares(vec![Affine3A::IDENTITY; 300]);
    let concentric = squares((0..1000).map(|i| Affine3A::from_scale(Vec3::splat(1.0 + i as f32))));
    for scene in [coincident, concentric] {
        for distance in distances_to_square(&device, &scene) {
            assert!((distance - 5.0).abs() < 1e-4, "{distance}");
        }
    }
}

#[test]
fn what_is_far_away_hides_nothing_that_is_near() {
    let Some(device) = device::open() else { return };
    for far in [1e10, 3.7e19, 1.7e38, -3.4e38, f32::MAX] {
        for axis in Vec3::AXES {
            // Behind the square, or beside it.
            let place = Affine3A::from_translation(far * (axis - 2.0 * axis * Vec3::Z));
            let mut scene = squares([Affine3A::IDENTITY, place]);
            let mesh = &mut scene.meshes[0];
            // A triangle above the square that reaches far away behind it.
            let first = mesh.positions.len() as u32;
            let reaching = [Vec3::X, Vec3::X * far, Vec3::NEG_Z * far.abs()];
            mesh.positions.extend(reaching.map(|p| p + 2.0 * Vec3::Y));
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.normals.resize(mesh.positions.len(), Vec3::Z);
            mesh.triangle_materials.push(0);
            for distance in distances_to_square(&device, &scene) {
                assert!((distance - 5.0).abs() < 1e-4, "{far} {axis}: {distance}");
            }
        }
    }
}

#[test]
fn hostile_scenes_have_hierarchies() {
    let Some(folder) = shared::find("trials/reliability") else {
        return;
    };
    let Some(device) = device::open() else { return };
    for name in [
        "dup300",
        "nested1000",
        "far-instance",
        "far-vertex-1.7e38",
        "far-vertex-3.7e19",
        "gpu-201-1379-panic",
        "gpu-201-3008-panic",
    ] {
        let imported = import::load(&folder.join(name).with_added_extension("glb"));
        let scene = imported.unwrap_or_else(|error| panic!("{error}")).scene;
        let tracer = Tracer::new(&device, &scene).unwrap_or_else(|error| panic!("{name}: {error}"));
        let camera = scene.cameras.first().cloned();
        let camera = camera.unwrap_or_else(|| default_camera(&scene));
        let traced = tracer.trace(&camera_rays(&camera, 16), Rays::Closest);
        let (traced, _) = traced.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(traced.len(), 256);
    }
}

/// Hills with triangles that are there twice, that have no area, that are needles, or that have one side only; placed
/// turned, stretched and mirrored, some within each other.
fn awkward_scene() -> Scene {
    let mut random = Normal::new(3);
    let mut scene = Scene {
        meshes: vec![awkward_mesh(&mut random)],
        materials: [true, false]
            .map(|double_sided| Material {
                double_sided,
                ..Material::default()
            })
            .into(),
        ..Scene::default()
    };
    for i in 0..32 {
        let mut number = || random.sample() as f32;
        let turn = Quat::from_euler(EulerRot::XYZ, number(), number(), number());
        let sign = |bit: u32| if i >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let stretch = Vec3::new(0.5, 1.0, 2.0) * (0.3 * number()).exp();
        let stretch = stretch * Vec3::new(sign(0), sign(1), sign(2));
        let place = 0.7 * Vec3::new(number(), number(), number());
        scene.instances.push(Instance {
            name: format!("instance {i}"),
            mesh: 0,
            transform: Affine3A::from_scale_rotation_translation(stretch, turn, place),
            asset: None,
        });
    }
    scene
}

fn awkward_mesh(random: &mut Normal) -> Mesh {
    const SIDE: u32 = 60;
    let mut mesh = Mesh {
        name: "awkward".to_owned(),
        ..Mesh::default()
    };
    for i in 0..(SIDE + 1) * (SIDE + 1) {
        let (x, z) = ((i % (SIDE + 1)) as f32, (i / (SIDE + 1)) as f32);
        let height = 0.1 * random.sample() as f32;
        let flat = Vec3::new(x, 0.0, z) / SIDE as f32 * 2.0 - Vec3::new(1.0, 0.0, 1.0);
        mesh.positions.push(flat + height * Vec3::Y);
    }
    for i in 0..SIDE * SIDE {
        let corner = i / SIDE * (SIDE + 1) + i % SIDE;
        let opposite = corner + SIDE + 2;
        for triangle in [
            [corner, corner + SIDE + 1, opposite],
            [corner, opposite, corner + 1],
        ] {
            mesh.triangles.push(triangle);
            if i % 7 == 0 {
                mesh.triangles.push(triangle);
            }
        }
    }
    let mut add = |corners: [Vec3; 3]| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.push([first, first + 1, first + 2]);
    };
    for i in 0..300 {
        let mut point = || Vec3::from_array(std::array::from_fn(|_| random.uniform() as f32 - 0.5));
        let (a, b) = (point(), point());
        add(match i % 3 {
            // A point, a line, a needle a thousandth of a millimetre wide.
            0 => [a; 3],
            1 => [a, a + b, a + 2.0 * b],
            _ => [a, a + b, a + b + 1.0e-6 * point()],
        });
    }
    mesh.normals = vec![Vec3::Y; mesh.positions.len()];
    mesh.triangle_materials = (0..mesh.triangles.len() as u32)
        .map(|i| u32::from(i % 3 == 0))
        .collect();
    mesh
}
