//! A model put into a scene in order to be textured: whatever its size, it stands on the floor in front of the camera.

use std::path::Path;

use glam::{Affine3A, Mat3, Vec3};

use engine::scene::{
    Camera, Material, Projection, Scene,
    import::{self, ImportError},
};

use crate::scenes::{self, MODEL};

/// Diameter of the model over the height of the picture.
const FILL: f32 = 0.8;
/// Where the model is put on the way from the camera to what it looks at.
const PLACE: f32 = 0.5;

/// A scene with a model in it.
#[derive(Debug)]
pub struct Inserted {
    /// Name of the one material that the model is made of now.
    pub material: String,
    /// Turned to the model.
    pub camera: Camera,
    /// What is shown differently from what the model's file says.
    pub warnings: Vec<String>,
}

/// Puts a glTF file into the scene: half-way to what the camera looks at, on the floor below that if there is one, about
/// as large as the picture is high, and made of a single material. Without a camera, one is put into the middle of
/// the scene, as in a hall. Lights of the file are taken too.
///
/// # Errors
/// As [`import::load`]; a file without triangles inserts nothing.
pub fn model(
    scene: &mut Scene,
    camera: Option<Camera>,
    path: &Path,
) -> Result<Inserted, ImportError> {
    let first = scene.instances.len();
    let mut added = import::append(scene, path, Affine3A::IDENTITY)?;
    let camera = camera.unwrap_or_else(|| inside(scene, first));
    let material = use_one_material(scene, first);
    let camera = match bounds(scene, first..scene.instances.len()) {
        Some(bounds) => {
            let (placement, camera) = placement(scene, first, bounds, &camera);
            for instance in &mut scene.instances[first..] {
                instance.transform = placement * instance.transform;
            }
            camera
        }
        None => {
            let nothing = format!("{} has no triangles: nothing is inserted", path.display());
            added.warnings.push(nothing);
            camera
        }
    };
    Ok(Inserted {
        material,
        camera,
        warnings: added.warnings,
    })
}

/// Gives the instances from `first` on a plain material of their own; returns its name.
fn use_one_material(scene: &mut Scene, first: usize) -> String {
    let mut name = MODEL.to_owned();
    while scene.materials.iter().any(|material| material.name == name) {
        name.push('\'');
    }
    let material = scene.materials.len() as u32;
    scene.materials.push(Material {
        name: name.clone(),
        metallic: 0.0,
        ..Material::default()
    });
    let meshes: Vec<u32> = scene.instances[first..].iter().map(|i| i.mesh).collect();
    for mesh in meshes {
        scene.meshes[mesh as usize]
            .triangle_materials
            .fill(material);
    }
    name
}

/// Where a model with these corners goes, and the camera that looks at it there.
fn placement(
    scene: &Scene,
    first: usize,
    (low, high): (Vec3, Vec3),
    camera: &Camera,
) -> (Affine3A, Camera) {
    let eye = Vec3::from(camera.transform.translation);
    let ahead = Vec3::from(-camera.transform.matrix3.z_axis).normalize_or(Vec3::NEG_Z);
    let seen = distance(scene, first, eye, ahead).unwrap_or(camera.focus_distance);
    let away = PLACE * seen.max(1e-3);
    let half_height = match camera.projection {
        Projection::Perspective { y_fov } => away * (0.5 * y_fov).tan(),
        Projection::Orthographic { y_mag } => y_mag,
    };
    let radius = 0.5 * (high - low).length().max(1e-12);
    let scale = FILL * half_height / radius;
    let mut middle = eye + away * ahead;
    if let Some(down) = distance(scene, first, middle, Vec3::NEG_Y) {
        middle.y += 0.5 * (high.y - low.y) * scale - down;
    }
    let placement = Affine3A::from_translation(middle)
        * Affine3A::from_scale(Vec3::splat(scale))
        * Affine3A::from_translation(-0.5 * (low + high));
    let to_model = middle - eye;
    let is_steep = to_model.cross(Vec3::Y).length() < 1e-3 * to_model.length();
    let camera = match is_steep {
        true => camera.clone(),
        false => Camera {
            transform: scenes::looking(eye, middle, 1.0).transform,
            focus_distance: to_model.length(),
            ..camera.clone()
        },
    };
    (placement, camera)
}

/// A camera in the middle of the scene's first instances that looks along its longer side, a quarter of its height above
/// the ground.
fn inside(scene: &Scene, instances: usize) -> Camera {
    let (low, high) = bounds(scene, 0..instances).unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
    let size = high - low;
    let along = match size.x >= size.z {
        true => Vec3::X * size.x,
        false => Vec3::Z * size.z,
    };
    let middle = (low + high) * 0.5;
    let target = Vec3::new(middle.x, low.y + 0.25 * size.y, middle.z);
    scenes::looking(target + 0.25 * along, target, 0.8)
}

/// Corners of the box around some instances.
fn bounds(scene: &Scene, instances: std::ops::Range<usize>) -> Option<(Vec3, Vec3)> {
    let corners = scene.instances[instances].iter().flat_map(|instance| {
        let positions = &scene.meshes[instance.mesh as usize].positions;
        positions
            .iter()
            .map(|&p| instance.transform.transform_point3(p))
    });
    corners.fold(None, |bounds, p| {
        let (low, high) = bounds.unwrap_or((p, p));
        Some((low.min(p), high.max(p)))
    })
}

/// How far a ray gets to the first triangle of the first instances, from either side (Möller and Trumbore 1997). All
/// triangles are tried: there are two rays.
fn distance(scene: &Scene, instances: usize, origin: Vec3, direction: Vec3) -> Option<f32> {
    let mut nearest: Option<f32> = None;
    for instance in &scene.instances[..instances] {
        let mesh = &scene.meshes[instance.mesh as usize];
        // The parameter along a ray stays the same in object space.
        let inverse = instance.transform.inverse();
        let origin = inverse.transform_point3(origin);
        let direction = Mat3::from(inverse.matrix3) * direction;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
            let (ab, ac, ao) = (b - a, c - a, origin - a);
            let p = direction.cross(ac);
            let q = ao.cross(ab);
            let scale = ab.dot(p).recip();
            let (u, v, t) = (
                ao.dot(p) * scale,
                direction.dot(q) * scale,
                ac.dot(q) * scale,
            );
            let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4;
            if is_hit && nearest.is_none_or(|nearest| t < nearest) {
                nearest = Some(t);
            }
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coverage;

    /// One triangle in the plane of x and y, far from the origin and large.
    const MODEL_FILE: &str = r#"{
      "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
      "nodes": [{ "mesh": 0, "translation": [100, 50, 0], "scale": [30, 30, 30] }],
      "materials": [{ "name": "a" }],
      "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
      "accessors": [{
        "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]
      }],
      "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
      "buffers": [{
        "byteLength": 36,
        "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"
      }]
    }"#;

    #[test]
    fn a_model_stands_on_the_floor_before_the_camera() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("model.gltf");
        std::fs::write(&file, MODEL_FILE).expect("the model is written");
        for has_camera in [true, false] {
            let mut scene = scenes::cornell_box();
            // The scene's own camera stands outside, where there is no floor.
            let camera = has_camera.then(|| Camera {
                transform: Affine3A::from_translation(Vec3::new(0.275, 0.275, 0.5)),
                ..scene.cameras[0].clone()
            });
            let inserted = model(&mut scene, camera, &file).expect("the model is inserted");
            let (low, high) = coverage::bounds(&scene, &inserted.material).expect("it is there");
            // The short block is 16.5 cm high: the model may stand on it.
            assert!((0.0..0.17).contains(&(low.y + 1e-4)), "{low}");
            assert!(high.max_element() < 0.55, "{high}: it is in the box");
            let middle = (low + high) * 0.5;
            let camera = inserted.camera;
            let ahead = -Vec3::from(camera.transform.matrix3.z_axis);
            let to_model = middle - Vec3::from(camera.transform.translation);
            assert!(ahead.dot(to_model.normalize()) > 0.999, "{ahead}");
        }
    }

    #[test]
    fn rays_end_at_the_nearest_triangle() {
        let scene = scenes::cornell_box();
        let all = scene.instances.len();
        let at = Vec3::new(0.1, 0.5, 0.5);
        let down = distance(&scene, all, at, Vec3::NEG_Y).expect("the floor");
        assert!((down - 0.5).abs() < 1e-5);
        let back = distance(&scene, all, at, Vec3::NEG_Z).expect("the back wall");
        assert!((back - 0.5).abs() < 1e-5);
        assert_eq!(distance(&scene, all, at, Vec3::Z), None);
    }
}
