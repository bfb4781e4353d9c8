//! What lies below a pixel, found on the CPU: the scene is there anyway, and one ray needs no hierarchy.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::scene::{AlphaMode, Camera, Instance, Mesh, Projection, Scene, TextureRef, Wrap};

/// The surface that is seen at a place of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pick {
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// In the world, metres.
    pub position: Vec3,
    /// Of the triangle, unit length, on the side that is seen.
    pub normal: Vec3,
    /// From the camera along the ray, metres.
    pub distance: f32,
    /// From the camera's plane: what focuses on the point.
    pub depth: f32,
}

/// What is seen at a place of a picture, (0, 0) its upper left corner and (1, 1) its lower right one; `aspect` is width
/// by height. Backs of single-sided materials and points that the material's own alpha cuts out are looked through;
/// what texture programs decide about opacity is not known here.
pub fn pick(scene: &Scene, camera: &Camera, aspect: f32, place: Vec2) -> Option<Pick> {
    let ray = camera_ray(camera, aspect, place);
    let hits = scene.instances.par_iter().enumerate();
    let nearest = hits
        .filter_map(|(number, instance)| {
            let mesh = &scene.meshes[instance.mesh as usize];
            let (distance, triangle) = nearest(scene, mesh, instance, &ray)?;
            Some((distance, number as u32, triangle))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(distance, number, triangle)| {
        let instance = &scene.instances[number as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let corners = mesh.triangles[triangle].map(|i| mesh.positions[i as usize]);
        let [a, b, c] = corners.map(|corner| instance.transform.transform_point3(corner));
        let normal = (b - a).cross(c - a).normalize_or(-ray.direction);
        let position = ray.origin + ray.direction * distance;
        let seen = camera.transform.inverse().transform_point3(position);
        Pick {
            material: mesh.triangle_materials[triangle],
            instance: number,
            position,
            normal: normal
                * if normal.dot(ray.direction) > 0.0 {
                    -1.0
                } else {
                    1.0
                },
            distance,
            depth: -seen.z,
        }
    })
}

/// How far below a point something lies to stand on, metres.
pub fn below(scene: &Scene, point: Vec3) -> Option<f32> {
    let ray = Ray {
        origin: point,
        direction: Vec3::NEG_Y,
    };
    let hits = scene.instances.par_iter().filter_map(|instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        nearest(scene, mesh, instance, &ray)
    });
    hits.map(|(distance, _)| distance).min_by(f32::total_cmp)
}

pub(crate) struct Ray {
    pub(crate) origin: Vec3,
    /// Distances are in its lengths.
    pub(crate) direction: Vec3,
}

/// As `raygen.wgsl` without a lens.
fn camera_ray(camera: &Camera, aspect: f32, place: Vec2) -> Ray {
    let ndc = Vec2::new((2.0 * place.x - 1.0) * aspect, 1.0 - 2.0 * place.y);
    let (origin, direction) = match camera.projection {
        Projection::Perspective { y_fov } => (Vec3::ZERO, (ndc * (0.5 * y_fov).tan()).extend(-1.0)),
        Projection::Orthographic { y_mag } => ((ndc * y_mag).extend(0.0), Vec3::NEG_Z),
    };
    Ray {
        origin: camera.transform.transform_point3(origin),
        direction: camera.transform.transform_vector3(direction).normalize(),
    }
}

/// Distance and number of an instance's nearest triangle that is no hole.
fn nearest(scene: &Scene, mesh: &Mesh, instance: &Instance, ray: &Ray) -> Option<(f32, usize)> {
    let to_object = instance.transform.inverse();
    // Not normalised: distances stay those of the world.
    let local = Ray {
        origin: to_object.transform_point3(ray.origin),
        direction: to_object.transform_vector3(ray.direction),
    };
    (0..mesh.triangles.len())
        .into_par_iter()
        .filter_map(|triangle| {
            let corners = mesh.triangles[triangle].map(|i| mesh.positions[i as usize]);
            let (distance, weights, is_front) = intersect(&local, corners)?;
            let material = &scene.materials[mesh.triangle_materials[triangle] as usize];
            // In object space fronts are counter-clockwise, whatever the instance does to them.
            if !material.double_sided && !is_front {
                return None;
            }
            (opacity(scene, mesh, triangle, weights) > 0.0).then_some((distance, triangle))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Distance, weights of the corners, and whether the ray comes from where they are counter-clockwise (Möller and
/// Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997).
pub(crate) fn intersect(ray: &Ray, [a, b, c]: [Vec3; 3]) -> Option<(f32, Vec3, bool)> {
    let (edge1, edge2) = (b - a, c - a);
    let p = ray.direction.cross(edge2);
    let determinant = edge1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let scale = 1.0 / determinant;
    let from_a = ray.origin - a;
    let v = from_a.dot(p) * scale;
    let q = from_a.cross(edge1);
    let w = ray.direction.dot(q) * scale;
    let distance = edge2.dot(q) * scale;
    let is_inside = v >= 0.0 && w >= 0.0 && v + w <= 1.0;
    (is_inside && distance > 0.0 && distance.is_finite())
        .then(|| (distance, Vec3::new(1.0 - v - w, v, w), determinant > 0.0))
}

/// Alpha of the material at a point, 0 where it is cut out.
fn opacity(scene: &Scene, mesh: &Mesh, triangle: usize, weights: Vec3) -> f32 {
    let material = &scene.materials[mesh.triangle_materials[triangle] as usize];
    let corners = mesh.triangles[triangle].map(|i| i as usize);
    if material.alpha_mode == AlphaMode::Opaque {
        return 1.0;
    }
    let mut alpha = material.base_color.w;
    if !mesh.colors.is_empty() {
        let colors = Vec3::from_array(corners.map(|i| mesh.colors[i].w));
        alpha *= colors.dot(weights);
    }
    if let Some(texture) = &material.base_color_texture {
        alpha *= texture_alpha(scene, mesh, texture, corners, weights);
    }
    match material.alpha_mode {
        AlphaMode::Mask { cutoff } if alpha < cutoff => 0.0,
        AlphaMode::Mask { .. } => 1.0,
        _ => alpha,
    }
}

/// The nearest texel's alpha: enough to know what somebody points at.
fn texture_alpha(
    scene: &Scene,
    mesh: &Mesh,
    texture: &TextureRef,
    corners: [usize; 3],
    weights: Vec3,
) -> f32 {
    let image = &scene.images[texture.image as usize];
    let coordinates = match texture.uv_set {
        1 if !mesh.uv1.is_empty() => &mesh.uv1,
        _ => &mesh.uv0,
    };
    let uv = match coordinates.is_empty() {
        true => Vec2::ZERO,
        false => (0..3).map(|i| coordinates[corners[i]] * weights[i]).sum(),
    };
    let at = uv.extend(1.0);
    let [row_u, row_v] = texture.transform;
    let column = texel(row_u.dot(at), image.width, texture.sampler.wrap_u);
    let row = texel(row_v.dot(at), image.height, texture.sampler.wrap_v);
    let place = (row as usize * image.width as usize + column as usize) * 4 + 3;
    f32::from(image.rgba8[place]) / 255.0
}

/// The texel of a coordinate.
fn texel(coordinate: f32, size: u32, wrap: Wrap) -> u32 {
    let wrapped = match wrap {
        Wrap::Repeat => coordinate.rem_euclid(1.0),
        Wrap::Mirror => 1.0 - (coordinate.rem_euclid(2.0) - 1.0).abs(),
        Wrap::Clamp => coordinate.clamp(0.0, 1.0),
    };
    // `as` saturates and turns NaN into 0.
    ((wrapped * size as f32) as u32).min(size - 1)
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec4};

    use super::*;
    use crate::scene::{Image, Material, Sampler, default_camera};

    /// Two squares of 2 x 2 m across the view of a camera at (0, 0, 5): one at z = 1 of material 0, one at z = 0 of
    /// material 1.
    fn squares() -> (Scene, Camera) {
        let mesh = |material| Mesh {
            positions: vec![
                Vec3::new(-1.0, -1.0, 0.0),
                Vec3::new(1.0, -1.0, 0.0),
                Vec3::new(1.0, 1.0, 0.0),
                Vec3::new(-1.0, 1.0, 0.0),
            ],
            uv0: vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            triangle_materials: vec![material; 2],
            ..Mesh::default()
        };
        let instance = |mesh, z| Instance {
            name: String::new(),
            mesh,
            transform: Affine3A::from_translation(Vec3::new(0.0, 0.0, z)),
            asset: None,
        };
        let scene = Scene {
            meshes: vec![mesh(0), mesh(1)],
            instances: vec![instance(0, 1.0), instance(1, 0.0)],
            materials: vec![Material::default(), Material::default()],
            ..Scene::default()
        };
        let camera = Camera {
            transform: Affine3A::from_translation(Vec3::new(0.0, 0.0, 5.0)),
            projection: Projection::Perspective {
                y_fov: std::f32::consts::FRAC_PI_2,
            },
            ..default_camera(&scene)
        };
        (scene, camera)
    }

    #[test]
    fn the_nearest_surface_is_picked() {
        let (scene, camera) = squares();
        let hit = pick(&scene, &camera, 2.0, Vec2::splat(0.5)).expect("hit");
        assert_eq!((hit.material, hit.instance), (0, 0));
        assert!((hit.distance - 4.0).abs() < 1e-5 && (hit.depth - 4.0).abs() < 1e-5);
        // At the same height, half a metre from the middle at a distance of 4 m.
        let aside = pick(&scene, &camera, 2.0, Vec2::new(0.5 + 0.5 / 16.0, 0.5)).expect("hit");
        assert!((aside.position - Vec3::new(0.5, 0.0, 1.0)).length() < 1e-5);
        assert!(aside.distance > aside.depth && (aside.depth - 4.0).abs() < 1e-5);
        assert_eq!(pick(&scene, &camera, 2.0, Vec2::ZERO), None);
    }

    #[test]
    fn backs_and_holes_are_looked_through() {
        let (mut scene, camera) = squares();
        // Mirrored, it turns its back to where its front was.
        scene.instances[0].transform.matrix3 *= -1.0;
        let center = Vec2::new(0.52, 0.49);
        let material = |scene: &Scene| pick(scene, &camera, 2.0, center).map(|hit| hit.material);
        assert_eq!(material(&scene), Some(1));
        scene.materials[0].double_sided = true;
        assert_eq!(material(&scene), Some(0));

        let (mut scene, _) = squares();
        scene.images.push(Image {
            name: String::new(),
            width: 2,
            height: 1,
            rgba8: [[0, 0, 0, 255], [0, 0, 0, 10]].concat().into(),
            srgb: true,
        });
        scene.materials[0].base_color = Vec4::ONE;
        scene.materials[0].base_color_texture = Some(TextureRef {
            image: 0,
            uv_set: 0,
            sampler: Sampler::default(),
            transform: [Vec3::X, Vec3::Y],
        });
        scene.materials[0].alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
        // The right half is cut out.
        assert_eq!(material(&scene), Some(1));
        let left = pick(&scene, &camera, 2.0, Vec2::new(0.48, 0.5));
        assert_eq!(left.map(|hit| hit.material), Some(0));
        scene.materials[0].alpha_mode = AlphaMode::Blend;
        assert_eq!(material(&scene), Some(0));
        scene.materials[0].base_color.w = 0.0;
        assert_eq!(material(&scene), Some(1));
    }
}
