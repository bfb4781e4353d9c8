//! How much of the picture a material covers, and cameras from which it covers more or less: what a texture costs is in
//! proportion to the hits that it is evaluated at.

use std::path::Path;

use glam::Vec3;

use device::Device;

use engine::{
    procedural::{Procedural, TextureSources},
    renderer::{RenderSettings, Renderer},
    scene::{
        Camera, Environment, Material, Projection, Scene,
        look::{Look, LookError},
    },
};

use crate::{error::TextureBenchError, scenes};

/// Camera paths of a pixel by which the share is measured.
const SPP: u32 = 4;

/// Share of the camera's rays, 0 to 1, that meet the material first. It is measured by the renderer itself: the material
/// is shown in even white, everything else in black, with the lens and the filter of the settings.
///
/// # Errors
/// The device.
pub fn measure(
    device: &Device,
    scene: &Scene,
    material: &str,
    settings: &RenderSettings,
) -> Result<f64, TextureBenchError> {
    let mut scene = Scene {
        lights: Vec::new(),
        environment: Environment::default(),
        ..scene.clone()
    };
    for known in &mut scene.materials {
        *known = match known.name == material {
            true => Material {
                name: material.to_owned(),
                unlit: true,
                ..Material::default()
            },
            // What is cut out or blended in stays so, black as it is.
            false => Material {
                unlit: true,
                emission: Vec3::ZERO,
                base_color: Vec3::ZERO.extend(known.base_color.w),
                ..known.clone()
            },
        };
    }
    let look = Look::parse(Path::new("bench.look.toml"), "")?;
    let nothing = TextureSources::default();
    let procedural = Procedural::build(&look, &mut scene, &nothing).map_err(LookError::from)?;
    let settings = RenderSettings {
        max_depth: 1,
        ..settings.clone()
    };
    let mut renderer = Renderer::new(device, &scene, &procedural, &settings)?;
    renderer.render(SPP)?;
    let film = renderer.film()?;
    let sum: f64 = film.mean().iter().map(|rgb| f64::from(rgb[0])).sum();
    Ok(sum / film.pixels().max(1) as f64)
}

/// The camera turned towards the middle of what a material covers, with such an angle of view that the sphere around it is
/// `fill` times as high as the picture. `None` if nothing is made of the material, or the camera stands in its middle.
pub fn framing(scene: &Scene, material: &str, camera: &Camera, fill: f32) -> Option<Camera> {
    let (low, high) = bounds(scene, material)?;
    let (center, radius) = ((low + high) * 0.5, (high - low).length() * 0.5);
    let eye = Vec3::from(camera.transform.translation);
    let distance = (center - eye).length();
    let half = radius / (distance * fill);
    // Straight up or down there is no upright picture.
    let is_steep = (center - eye).cross(Vec3::Y).length() < 1e-4 * distance;
    if !half.is_finite() || half <= 0.0 || is_steep {
        return None;
    }
    let y_fov = (2.0 * half.atan()).min(2.8);
    let turned = scenes::looking(eye, center, y_fov);
    Some(Camera {
        transform: turned.transform,
        projection: match camera.projection {
            Projection::Perspective { .. } => turned.projection,
            Projection::Orthographic { .. } => Projection::Orthographic {
                y_mag: radius / fill,
            },
        },
        focus_distance: distance,
        ..camera.clone()
    })
}

/// Corners of the box around all triangles of a material, in the world.
pub fn bounds(scene: &Scene, material: &str) -> Option<(Vec3, Vec3)> {
    let is_it = |m: &u32| scene.materials[*m as usize].name == material;
    let mut bounds: Option<(Vec3, Vec3)> = None;
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let triangles = mesh.triangles.iter().zip(&mesh.triangle_materials);
        for (triangle, _) in triangles.filter(|(_, m)| is_it(m)) {
            for &vertex in triangle {
                let at = instance
                    .transform
                    .transform_point3(mesh.positions[vertex as usize]);
                let (low, high) = bounds.unwrap_or((at, at));
                bounds = Some((low.min(at), high.max(at)));
            }
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::MODEL;

    #[test]
    fn the_model_is_framed_as_large_as_wanted() {
        let scene = scenes::arcade();
        let camera = &scene.cameras[0];
        let (low, high) = bounds(&scene, MODEL).expect("it has triangles");
        assert!(low.y > 0.0 && high.y < 3.0, "{low} {high}");
        let angle = |fill| {
            let framed = framing(&scene, MODEL, camera, fill).expect("it can be seen");
            let ahead = -Vec3::from(framed.transform.matrix3.z_axis);
            let towards = (low + high) * 0.5 - Vec3::from(framed.transform.translation);
            assert!(ahead.dot(towards.normalize()) > 0.9999);
            match framed.projection {
                Projection::Perspective { y_fov } => (0.5 * y_fov).tan(),
                Projection::Orthographic { .. } => panic!("the camera has a perspective"),
            }
        };
        assert!((angle(0.5) / angle(2.0) - 4.0).abs() < 1e-3);
        assert!(framing(&scene, "nothing", camera, 1.0).is_none());
    }
}
