//! Small scenes built in code, and their pictures.

use std::path::Path;

use ::device::Device;
use engine::film::Film;
use engine::procedural::{Procedural, TextureSources};
use engine::renderer::{RenderSettings, Renderer};
use engine::scene::look::Look;
use engine::scene::{Camera, Environment, Instance, Material, Mesh, Projection, Scene};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec4};

/// A parallelogram with its front on the side of `u` x `v` and texture coordinates along them; uv (0, 0) is `corner`.
pub(crate) fn quad(corner: Vec3, u: Vec3, v: Vec3) -> Mesh {
    Mesh {
        name: "quad".to_owned(),
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        normals: vec![u.cross(v).normalize(); 4],
        uv0: vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        triangle_materials: vec![0; 2],
        ..Mesh::default()
    }
}

/// The horizontal square of half side `half` around the origin, front up.
pub(crate) fn floor(half: f32) -> Mesh {
    quad(
        Vec3::new(-half, 0.0, half),
        Vec3::X * 2.0 * half,
        Vec3::NEG_Z * 2.0 * half,
    )
}

/// A unit sphere of flat facets: the shading normal is the geometric one, so no light is lost between them.
pub(crate) fn faceted_sphere(rings: u32) -> Mesh {
    let point = |ring: u32, sector: u32| {
        let theta = std::f32::consts::PI * ring as f32 / rings as f32;
        let phi = std::f32::consts::PI * (sector % (2 * rings)) as f32 / rings as f32;
        Vec3::new(
            theta.sin() * phi.cos(),
            theta.cos(),
            theta.sin() * phi.sin(),
        )
    };
    let mut mesh = Mesh {
        name: "sphere".to_owned(),
        ..Mesh::default()
    };
    for ring in 0..rings {
        for sector in 0..2 * rings {
            let [a, b] = [point(ring, sector), point(ring, sector + 1)];
            let [c, d] = [point(ring + 1, sector), point(ring + 1, sector + 1)];
            for [p, q, r] in [[a, b, d], [a, d, c]] {
                let normal = (q - p).cross(r - p);
                if normal.length() < 1.0e-9 {
                    continue; // at the poles two corners are one
                }
                let first = mesh.positions.len() as u32;
                mesh.positions.extend([p, q, r]);
                mesh.normals.extend([normal.normalize(); 3]);
                mesh.triangles.push([first, first + 1, first + 2]);
                mesh.triangle_materials.push(0);
            }
        }
    }
    mesh
}

/// A surface that reflects `color` equally in all directions and has no gloss.
pub(crate) fn lambert(color: Vec3) -> Material {
    Material {
        base_color: color.extend(1.0),
        metallic: 0.0,
        specular: 0.0,
        ..Material::default()
    }
}

/// A black surface whose front shines.
pub(crate) fn lamp(radiance: Vec3) -> Material {
    Material {
        emission: radiance,
        ..lambert(Vec3::ZERO)
    }
}

/// A surface that shows its colour whatever light falls on it.
pub(crate) fn unlit(color: Vec4) -> Material {
    Material {
        base_color: color,
        unlit: true,
        ..Material::default()
    }
}

/// Puts a mesh with a material of its own into the scene.
pub(crate) fn add(scene: &mut Scene, mut mesh: Mesh, material: Material) {
    mesh.triangle_materials
        .fill(u32::try_from(scene.materials.len()).expect("tests have few materials"));
    scene.materials.push(Material {
        name: format!("material {}", scene.materials.len()),
        ..material
    });
    scene.instances.push(Instance {
        name: mesh.name.clone(),
        mesh: u32::try_from(scene.meshes.len()).expect("tests have few meshes"),
        transform: Affine3A::IDENTITY,
        asset: None,
    });
    scene.meshes.push(mesh);
}

/// A scene of these objects under the same light from everywhere.
pub(crate) fn scene(
    objects: impl IntoIterator<Item = (Mesh, Material)>,
    environment: Vec3,
) -> Scene {
    let mut scene = Scene {
        environment: Environment::Constant(environment),
        ..Scene::default()
    };
    for (mesh, material) in objects {
        add(&mut scene, mesh, material);
    }
    scene
}

/// A camera at `eye` that looks at `target`, with `up` up in the picture.
pub(crate) fn camera(eye: Vec3, target: Vec3, up: Vec3, projection: Projection) -> Camera {
    let back = (eye - target).normalize();
    let right = up.cross(back).normalize();
    Camera {
        name: String::new(),
        transform: Affine3A {
            matrix3: Mat3A::from_cols(right.into(), back.cross(right).into(), back.into()),
            translation: eye.into(),
        },
        projection,
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: 1.0,
    }
}

/// An orthographic camera above the origin, `height` metres high, that sees [-half, half] in x and z of a square
/// picture; -Z is up in it. [`floor_point`] says where.
pub(crate) fn from_above(height: f32, half: f32) -> Camera {
    camera(
        Vec3::Y * height,
        Vec3::ZERO,
        Vec3::NEG_Z,
        Projection::Orthographic { y_mag: half },
    )
}

/// Where the ray of [`from_above`] through a point of the picture, in 0 to 1 from its upper left corner, meets y = 0.
pub(crate) fn floor_point(half: f32, picture: Vec2) -> Vec3 {
    let p = (2.0 * picture - 1.0) * half;
    Vec3::new(p.x, 0.0, p.y)
}

/// How a picture is rendered.
#[derive(Clone, Copy)]
pub(crate) struct Shot {
    /// Pixels.
    pub(crate) size: (u32, u32),
    /// Vertices that scatter.
    pub(crate) max_depth: u32,
    /// Samples of each pixel.
    pub(crate) spp: u32,
}

/// Nothing procedural.
pub(crate) fn no_textures(scene: &mut Scene) -> Procedural {
    textured(scene, "", &TextureSources::default())
}

/// A look's textures.
///
/// # Panics
/// The look is wrong.
pub(crate) fn textured(scene: &mut Scene, look: &str, sources: &TextureSources) -> Procedural {
    let look = Look::parse(Path::new("look.toml"), look).unwrap_or_else(|e| panic!("{e}"));
    Procedural::build(&look, scene, sources).unwrap_or_else(|e| panic!("{e}"))
}

/// Settings with seed 0.
pub(crate) fn settings(camera: &Camera, shot: Shot) -> RenderSettings {
    RenderSettings {
        max_depth: shot.max_depth,
        ..RenderSettings::new(shot.size.0, shot.size.1, camera)
    }
}

/// The picture of a scene without textures.
///
/// # Panics
/// It can't be rendered, or a sample was no number.
pub(crate) fn render(device: &Device, scene: &mut Scene, camera: &Camera, shot: Shot) -> Film {
    let procedural = no_textures(scene);
    render_textured(device, scene, &procedural, camera, shot)
}

/// The picture of a scene with textures.
///
/// # Panics
/// It can't be rendered, or a sample was no number.
pub(crate) fn render_textured(
    device: &Device,
    scene: &Scene,
    procedural: &Procedural,
    camera: &Camera,
    shot: Shot,
) -> Film {
    render_with(device, scene, procedural, &settings(camera, shot), shot.spp)
}

/// The picture of a scene with textures, rendered in a way of one's own.
///
/// # Panics
/// It can't be rendered, or a sample was no number.
pub(crate) fn render_with(
    device: &Device,
    scene: &Scene,
    procedural: &Procedural,
    settings: &RenderSettings,
    spp: u32,
) -> Film {
    let mut renderer = Renderer::new(device, scene, procedural, settings)
        .unwrap_or_else(|error| panic!("{error}"));
    renderer
        .render(spp)
        .unwrap_or_else(|error| panic!("{error}"));
    let stats = renderer.stats().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(stats.invalid_samples, 0, "every sample is a number");
    renderer.film().unwrap_or_else(|error| panic!("{error}"))
}
