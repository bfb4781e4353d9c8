//! A texture on a sphere, a plane and a cube in a studio: the scene of a preview, built in memory.
//!
//! How long it is rendered, and where the picture goes, is the caller's business.

mod material;

use std::{
    f32::consts::{PI, TAU},
    sync::Arc,
};

use glam::{Affine3A, Mat3A, Quat, Vec2, Vec3, Vec4};
use texgen::{Diagnostic, Diagnostics, OutputType, Value};

use crate::isolated::{self, Isolated, Subject};
use crate::procedural::{CompileError, EditError, Output, TextureSources};
use crate::renderer::{RenderError, RenderSettings, Renderer};
use crate::scene::{Camera, Environment, FloatImage, Instance, Material, Mesh, Projection, Scene};
use device::Device;

pub use material::MaterialPreview;

/// Material of the objects.
const SHOWN: &str = "shown";
/// The node that turns any value into a colour, and its texture.
const DISPLAY: &str = "value_as_colour";

/// Why there is no preview.
#[derive(Debug, thiserror::Error)]
pub enum PreviewError {
    /// An argument doesn't fit, or an image is missing.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The device, or the driver's compiler.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// A texture or node in the studio.
#[derive(Debug, Clone)]
pub struct Preview {
    isolated: Isolated,
    /// The node that gives the colour.
    display: String,
}

impl Preview {
    /// Puts a subject into the studio. `f32` shows as grey, vectors as colours; values up to `range[0]` are black and
    /// from `range[1]` on white.
    ///
    /// # Errors
    /// There is no such texture or node; every mistake in the textures and nodes; a range that is not finite.
    pub fn new(
        subject: Subject<'_>,
        sources: &TextureSources,
        range: [f32; 2],
    ) -> Result<Self, Diagnostics> {
        let mut part = subject.part(sources)?;
        let mut sources = sources.clone();
        let mut display = DISPLAY.to_owned();
        while (part.look.nodes.iter()).any(|node| node.name.value == display)
            || sources.names().any(|name| name == display)
        {
            display.push('_');
        }
        sources.insert(&display, &display_of(part.output));
        part.look.nodes.push(isolated::node(&display, &display));
        let mut isolated = Isolated::build(studio(), part, &sources)?;
        let link = isolated.link();
        let procedural = &mut isolated.procedural;
        let prepared = procedural
            .set_link(&display, "value", &link)
            .and_then(|()| procedural.set_value(&display, "low", Value::F32(range[0])))
            .and_then(|()| procedural.set_value(&display, "high", Value::F32(range[1])));
        prepared.map_err(|error| Diagnostic::error(error.to_string()))?;
        Ok(Self { isolated, display })
    }

    /// Sets a parameter to what a text says; see [`Isolated::set`].
    ///
    /// # Errors
    /// Unknown names, a value of another type, an image that can't be read.
    pub fn set(&mut self, parameter: &str, text: &str) -> Result<(), EditError> {
        self.isolated.set(parameter, text)
    }

    /// What is odd in the texture or look, but not wrong.
    pub fn warnings(&self) -> &Diagnostics {
        self.isolated.procedural.warnings()
    }

    /// A renderer of the picture; `width` in pixels, it is two fifths as high.
    ///
    /// # Errors
    /// An image parameter is not set, or the device refuses.
    pub fn renderer(&self, device: &Device, width: u32) -> Result<Renderer, PreviewError> {
        let mut procedural = self.isolated.procedural.clone();
        procedural.set_output_link(SHOWN, Output::BASE_COLOR, Some(&self.display))?;
        let settings = RenderSettings {
            // Light from one object to another would cost time and show nothing of the texture.
            max_depth: 1,
            ..RenderSettings::new(width, (width * 2 / 5).max(1), &camera())
        };
        Ok(Renderer::new(
            device,
            &self.isolated.scene,
            &procedural,
            &settings,
        )?)
    }
}

impl From<CompileError> for PreviewError {
    fn from(error: CompileError) -> Self {
        Self::Edit(error.into())
    }
}

/// The texture that shows values of this type.
fn display_of(output: OutputType) -> String {
    let color = match output {
        OutputType::F32 => "vec3f(value)",
        OutputType::Vec2 => "vec3f(value, low)",
        OutputType::Vec3 => "value",
        OutputType::Vec4 => "value.rgb",
    };
    format!(
        "fn userProc(value: {output}, low: f32, high: f32) -> vec3f {{\n    \
         return saturate(({color} - low) / (high - low));\n}}\n"
    )
}

/// The three objects in soft light from the upper left. They don't shade one another and the light is smooth, so a few
/// samples do.
fn studio() -> Scene {
    let mut scene = Scene {
        materials: vec![Material {
            name: SHOWN.to_owned(),
            metallic: 0.0,
            roughness: 0.6,
            ..Material::default()
        }],
        environment: sky(),
        ..Scene::default()
    };
    let turned = Quat::from_rotation_x(0.12) * Quat::from_rotation_y(0.62);
    for (mesh, transform) in [
        (sphere(0.5), Affine3A::from_translation(Vec3::X * -1.18)),
        (square(0.5), Affine3A::from_rotation_x(-0.1)),
        (
            cube(0.38),
            Affine3A::from_rotation_translation(turned, Vec3::X * 1.18),
        ),
    ] {
        add(&mut scene, mesh, transform);
    }
    scene
}

/// Grey all around, with a wide soft light on the upper left in front of the objects.
fn sky() -> Environment {
    const WIDTH: u32 = 128;
    const HEIGHT: u32 = 64;
    let light = Vec3::new(-0.55, 0.6, 0.6).normalize();
    let mut rgb = Vec::new();
    for row in 0..HEIGHT {
        for column in 0..WIDTH {
            let phi = TAU * (column as f32 + 0.5) / WIDTH as f32;
            let theta = PI * (row as f32 + 0.5) / HEIGHT as f32;
            let direction = Vec3::new(
                theta.sin() * phi.sin(),
                theta.cos(),
                -theta.sin() * phi.cos(),
            );
            let radiance = 0.2 + 2.8 * direction.dot(light).max(0.0).powi(4);
            rgb.push([radiance; 3]);
        }
    }
    Environment::Image {
        image: Arc::new(FloatImage {
            width: WIDTH,
            height: HEIGHT,
            rgb,
        }),
        rotation: 0.0,
        intensity: 1.0,
    }
}

fn camera() -> Camera {
    let eye = Vec3::new(0.0, 0.9, 5.6);
    // A camera looks along -Z.
    Camera {
        name: "preview".to_owned(),
        transform: facing(eye, 2.0 * eye),
        projection: Projection::Perspective { y_fov: 0.255 },
        aperture_radius: 0.0,
        aperture_blades: 0,
        aperture_rotation: 0.0,
        focus_distance: 1.0,
    }
}

/// A place whose +Z looks at a point, with +Y up.
fn facing(place: Vec3, at: Vec3) -> Affine3A {
    let forward = (at - place).normalize();
    let right = Vec3::Y.cross(forward).normalize();
    Affine3A {
        matrix3: Mat3A::from_cols(right.into(), forward.cross(right).into(), forward.into()),
        translation: place.into(),
    }
}

fn add(scene: &mut Scene, mut mesh: Mesh, transform: Affine3A) {
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    scene.instances.push(Instance {
        name: mesh.name.clone(),
        mesh: scene.meshes.len() as u32,
        transform,
        asset: None,
    });
    scene.meshes.push(mesh);
}

/// A sphere around the origin; u goes around it, v from the north pole to the south pole.
fn sphere(radius: f32) -> Mesh {
    const RINGS: u32 = 48;
    const SECTORS: u32 = 96;
    let mut mesh = Mesh {
        name: "sphere".to_owned(),
        ..Mesh::default()
    };
    for ring in 0..=RINGS {
        for sector in 0..=SECTORS {
            let uv = Vec2::new(sector as f32 / SECTORS as f32, ring as f32 / RINGS as f32);
            let (phi, theta) = (TAU * uv.x, PI * uv.y);
            let out = Vec3::new(
                theta.sin() * phi.sin(),
                theta.cos(),
                theta.sin() * phi.cos(),
            );
            mesh.positions.push(radius * out);
            mesh.normals.push(out);
            mesh.tangents
                .push(Vec4::new(phi.cos(), 0.0, -phi.sin(), -1.0));
            mesh.uv0.push(uv);
        }
    }
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let a = ring * (SECTORS + 1) + sector;
            let [b, c, d] = [a + 1, a + SECTORS + 1, a + SECTORS + 2];
            // At the poles one of the two has no area.
            if ring > 0 {
                mesh.triangles.push([a, c, b]);
            }
            if ring + 1 < RINGS {
                mesh.triangles.push([b, c, d]);
            }
        }
    }
    mesh
}

/// A square around the origin that faces +Z; uv (0, 0) is its upper left corner.
fn square(half: f32) -> Mesh {
    let mut mesh = Mesh {
        name: "plane".to_owned(),
        ..Mesh::default()
    };
    add_square(&mut mesh, half, Vec3::X, Vec3::Y);
    mesh
}

/// A cube around the origin, each side with uv of its own.
fn cube(half: f32) -> Mesh {
    let mut mesh = Mesh {
        name: "cube".to_owned(),
        ..Mesh::default()
    };
    for (right, up) in [
        (Vec3::X, Vec3::Y),
        (Vec3::NEG_Z, Vec3::Y),
        (Vec3::NEG_X, Vec3::Y),
        (Vec3::Z, Vec3::Y),
        (Vec3::X, Vec3::NEG_Z),
        (Vec3::X, Vec3::Z),
    ] {
        add_square(&mut mesh, half, right, up);
    }
    for (i, position) in mesh.positions.iter_mut().enumerate() {
        *position += half * mesh.normals[i];
    }
    mesh
}

fn add_square(mesh: &mut Mesh, half: f32, right: Vec3, up: Vec3) {
    let first = mesh.positions.len() as u32;
    for (x, y) in [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)] {
        mesh.positions.push(half * (x * right + y * up));
        mesh.uv0.push(Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y));
    }
    mesh.normals.extend([right.cross(up); 4]);
    mesh.tangents.extend([right.extend(-1.0); 4]);
    mesh.triangles.push([first, first + 1, first + 2]);
    mesh.triangles.push([first, first + 2, first + 3]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_look_outwards() {
        for mesh in [sphere(0.5), cube(0.5), square(0.5)] {
            for &[a, b, c] in &mesh.triangles {
                let [p, q, r] = [a, b, c].map(|i| mesh.positions[i as usize]);
                let normal = (q - p).cross(r - p);
                assert!(normal.length() > 0.0, "{} has empty triangles", mesh.name);
                let outside = mesh.normals[a as usize];
                assert!(normal.dot(outside) > 0.0, "{} is inside out", mesh.name);
            }
        }
    }

    #[test]
    fn every_type_can_be_shown() {
        for (ty, value) in [
            ("f32", "1.0"),
            ("vec2f", "vec2f(1.0)"),
            ("vec3f", "vec3f(1.0)"),
            ("vec4f", "vec4f(1.0)"),
        ] {
            let mut sources = TextureSources::default();
            sources.insert("t", &format!("fn userProc() -> {ty} {{ return {value}; }}"));
            Preview::new(Subject::Texture("t"), &sources, [0.0, 1.0])
                .unwrap_or_else(|problems| panic!("{problems}"));
        }
    }
}
