//! The scene as plain CPU data: what was read from glTF, the look and image files, before any GPU sees it.
//!
//! Nothing in this folder knows wgpu. Conventions: Y up, right-handed, metres, radians, linear Rec.709.

mod atmosphere;
pub mod import;
pub mod look;
mod material;
pub mod sky;

pub use import::default_camera;
pub use material::{AlphaMode, Filter, Material, Sampler, TextureRef, Wrap, absorption};

use glam::{Affine3A, Vec2, Vec3, Vec4};

/// Everything that is rendered.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Geometry in object space; instances refer to it by index.
    pub meshes: Vec<Mesh>,
    /// Meshes placed in the world.
    pub instances: Vec<Instance>,
    /// Surface descriptions; triangles refer to them by index. Never empty once a mesh is present.
    pub materials: Vec<Material>,
    /// Decoded pictures; [`TextureRef`] refers to them by index.
    pub images: Vec<Image>,
    /// Punctual lights (KHR_lights_punctual), in the world.
    pub lights: Vec<PunctualLight>,
    /// Cameras of the file, in its order.
    pub cameras: Vec<Camera>,
    /// Light from infinitely far away.
    pub environment: Environment,
}

/// An indexed triangle mesh in object space. All attribute vectors are as long as `positions`, or empty where
/// the mesh has no such attribute (`normals` is never empty).
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Name in the file, or a made-up one.
    pub name: String,
    /// Metres, object space; finite.
    pub positions: Vec<Vec3>,
    /// Unit length, object space.
    pub normals: Vec<Vec3>,
    /// Unit tangent and handedness (+1 or -1) as glTF defines; present where a material has a normal map or the file had tangents.
    pub tangents: Vec<Vec4>,
    /// TEXCOORD_0.
    pub uv0: Vec<Vec2>,
    /// TEXCOORD_1.
    pub uv1: Vec<Vec2>,
    /// COLOR_0, linear RGBA.
    pub colors: Vec<Vec4>,
    /// Attributes whose names begin with an underscore, sorted by name; none of them is empty.
    pub custom: Vec<CustomAttribute>,
    /// Vertex indices of each triangle; all in range, no two equal.
    pub triangles: Vec<[u32; 3]>,
    /// Index into [`Scene::materials`] of each triangle; as long as `triangles`.
    pub triangle_materials: Vec<u32>,
}

/// A custom attribute of a mesh (glTF 2.0, section 3.7.2.1), read by textures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CustomAttribute {
    /// As glTF and textures call it, underscore included: `_WETNESS`.
    pub name: String,
    /// One per vertex, finite. Components that the file doesn't have are those of (0, 0, 0, 1).
    pub values: Vec<Vec4>,
}

/// A mesh placed in the world.
#[derive(Debug, Clone)]
pub struct Instance {
    /// Name of the node in the file.
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Object to world; invertible. May mirror and scale non-uniformly.
    pub transform: Affine3A,
}

/// A decoded picture, row 0 on top.
#[derive(Debug, Clone)]
pub struct Image {
    /// Where it came from, for messages.
    pub name: String,
    /// Texels along u.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    /// 8-bit RGBA, `width * height * 4` bytes, as stored in the file.
    pub rgba8: Vec<u8>,
    /// RGB is sRGB-encoded (colour), not linear (data). An image used as both appears twice.
    pub srgb: bool,
}

/// A light of KHR_lights_punctual, in world space. Numbers are radiometric one to one: candela is W/sr, lux is W/m².
#[derive(Debug, Clone)]
pub struct PunctualLight {
    /// Name in the file.
    pub name: String,
    /// Linear colour times intensity.
    pub intensity: Vec3,
    /// World position, metres (not used by a directional light).
    pub position: Vec3,
    /// Unit direction in which the light shines (not used by a point light).
    pub direction: Vec3,
    /// Distance at which glTF's range window reaches zero; infinite where the file gives none.
    pub range: f32,
    /// Its shape.
    pub kind: LightKind,
}

/// Largest angular diameter of a light, radians.
pub const MAX_ANGULAR_DIAMETER: f32 = std::f32::consts::FRAC_PI_2;

/// Shape of a punctual light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightKind {
    /// Intensity W/sr in all directions.
    Point,
    /// Intensity W/sr inside a cone; angles in radians from the axis.
    Spot {
        /// Full intensity inside.
        inner_angle: f32,
        /// Zero outside.
        outer_angle: f32,
    },
    /// Irradiance W/m² on a perpendicular surface.
    Directional,
    /// The same from an evenly bright disk in the sky, such as the sun: shadows get soft edges, mirrors and the camera see
    /// it. The disk's size leaves the irradiance as it is.
    Disk {
        /// Radians, greater than 0 and at most [`MAX_ANGULAR_DIAMETER`].
        angular_diameter: f32,
    },
}

/// A camera in the world. It looks along its local -Z, +Y is up.
#[derive(Debug, Clone)]
pub struct Camera {
    /// Name of the camera or of its node.
    pub name: String,
    /// Camera to world, rigid (scale removed).
    pub transform: Affine3A,
    /// What it sees.
    pub projection: Projection,
    /// Radius of the lens, metres; 0 is a pinhole.
    pub aperture_radius: f32,
    /// Sides of the aperture: a regular polygon with its corners on the circle of that radius. Below 3 it is the disk.
    pub aperture_blades: u32,
    /// Turn of the polygon, radians, counter-clockwise as the camera sees the picture; at 0 a corner points to the right.
    pub aperture_rotation: f32,
    /// Distance of the plane in focus, metres.
    pub focus_distance: f32,
}

/// Projection of a camera. The picture's own aspect ratio is used; the vertical extent is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Vertical field of view, radians.
    Perspective {
        /// Radians.
        y_fov: f32,
    },
    /// Half of the height of the view, metres.
    Orthographic {
        /// Metres.
        y_mag: f32,
    },
}

/// Light from infinitely far away, seen by the camera too.
#[derive(Debug, Clone)]
pub enum Environment {
    /// The same radiance from everywhere; black is none.
    Constant(Vec3),
    /// An equirectangular picture.
    Image {
        /// Linear radiance.
        image: FloatImage,
        /// Degrees about +Y, counter-clockwise seen from above: direction (x, y, z) reads
        /// u = frac(atan2(x, -z) / 2π + rotation / 360), v = acos(y) / π.
        rotation: f32,
        /// Factor on the radiance.
        intensity: f32,
    },
}

impl Default for Environment {
    fn default() -> Self {
        Self::Constant(Vec3::ZERO)
    }
}

/// A linear floating-point picture, row 0 on top.
#[derive(Debug, Clone)]
pub struct FloatImage {
    /// Texels along u.
    pub width: u32,
    /// Texels along v.
    pub height: u32,
    /// Linear Rec.709 per texel, `width * height` of them; finite and not negative.
    pub rgb: Vec<[f32; 3]>,
}

impl Mesh {
    /// The custom attribute of that name.
    pub fn custom(&self, name: &str) -> Option<&CustomAttribute> {
        self.custom.iter().find(|attribute| attribute.name == name)
    }
}

impl Scene {
    /// Number of triangles with instances counted.
    pub fn instanced_triangles(&self) -> u64 {
        self.instances
            .iter()
            .map(|i| self.meshes[i.mesh as usize].triangles.len() as u64)
            .sum()
    }

    /// World-space bounds of all instances as (min, max); `None` for an empty scene. Tight, except for scenes with so
    /// many instances of large meshes that the transformed boxes of the meshes have to do.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        const MAX_VERTICES: usize = 1 << 27;
        let grow = |bounds: Option<(Vec3, Vec3)>, p: Vec3| match bounds {
            None => Some((p, p)),
            Some((low, high)) => Some((low.min(p), high.max(p))),
        };
        let vertices = |i: &Instance| self.meshes[i.mesh as usize].positions.len();
        let total = self
            .instances
            .iter()
            .map(vertices)
            .fold(0, usize::saturating_add);
        let corners: Vec<Vec<Vec3>> = match total {
            0..=MAX_VERTICES => Vec::new(),
            _ => (self.meshes.iter())
                .map(|mesh| mesh.positions.iter().copied().fold(None, grow))
                .map(|bounds| bounds.map_or(Vec::new(), |(low, high)| box_corners(low, high)))
                .collect(),
        };
        let mut bounds = None;
        for instance in &self.instances {
            let mesh = instance.mesh as usize;
            let points = corners.get(mesh).unwrap_or(&self.meshes[mesh].positions);
            for &p in points {
                // What a transform moves out of the range of numbers stays at its end.
                let p = instance.transform.transform_point3(p);
                bounds = grow(bounds, p.clamp(Vec3::MIN, Vec3::MAX));
            }
        }
        bounds
    }
}

fn box_corners(low: Vec3, high: Vec3) -> Vec<Vec3> {
    (0..8)
        .map(|i| {
            Vec3::select(
                glam::BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0),
                low,
                high,
            )
        })
        .collect()
}
