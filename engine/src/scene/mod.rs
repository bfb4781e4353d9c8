//! The scene as plain CPU data: what was read from glTF, the look and image files, before any GPU sees it.
//!
//! Nothing in this folder knows wgpu. Conventions: Y up, right-handed, metres, radians, linear Rec.709.

pub mod import;
pub mod look;

pub use import::default_camera;

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

/// A metallic-roughness material with the extensions that are supported. Textures multiply their factors.
#[derive(Debug, Clone)]
pub struct Material {
    /// Name in the file or the look; unique within the scene.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: Vec4,
    /// RGBA, sRGB-encoded colour.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric .. 1 metal.
    pub metallic: f32,
    /// Perceptual roughness; GGX alpha is its square.
    pub roughness: f32,
    /// Linear: G roughness, B metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map, linear.
    pub normal_texture: Option<TextureRef>,
    /// Factor on the normal map's x and y.
    pub normal_scale: f32,
    /// Radiance, W/m²/sr: emissive factor times emissive strength.
    pub emission: Vec3,
    /// RGB, sRGB-encoded colour.
    pub emission_texture: Option<TextureRef>,
    /// KHR_materials_specular: weight of the dielectric's specular lobe.
    pub specular: f32,
    /// Weight in the A channel, linear.
    pub specular_texture: Option<TextureRef>,
    /// KHR_materials_specular: tint of the dielectric's F0.
    pub specular_color: Vec3,
    /// RGB, sRGB-encoded colour.
    pub specular_color_texture: Option<TextureRef>,
    /// Index of refraction of the dielectric.
    pub ior: f32,
    /// KHR_materials_transmission: share of the light below the reflection that goes through.
    pub transmission: f32,
    /// Share in R, linear.
    pub transmission_texture: Option<TextureRef>,
    /// KHR_materials_volume: the surface bounds a body, which refracts and absorbs; otherwise it is a thin wall.
    pub is_solid: bool,
    /// Of the body, 1/metres: light that goes a metre is multiplied by exp(-absorption).
    pub absorption: Vec3,
    /// KHR_materials_diffuse_transmission: share of the diffuse light that comes out on the other side.
    pub diffuse_transmission: f32,
    /// Share in A, linear.
    pub diffuse_transmission_texture: Option<TextureRef>,
    /// Its linear colour.
    pub diffuse_transmission_color: Vec3,
    /// RGB, sRGB-encoded colour.
    pub diffuse_transmission_color_texture: Option<TextureRef>,
    /// KHR_materials_sheen, linear colour; black is none.
    pub sheen_color: Vec3,
    /// RGB, sRGB-encoded colour.
    pub sheen_color_texture: Option<TextureRef>,
    /// Perceptual roughness of the sheen.
    pub sheen_roughness: f32,
    /// Roughness in A, linear.
    pub sheen_roughness_texture: Option<TextureRef>,
    /// KHR_materials_clearcoat: weight of a coat with an index of 1.5.
    pub coat: f32,
    /// Weight in R, linear.
    pub coat_texture: Option<TextureRef>,
    /// Perceptual roughness of the coat.
    pub coat_roughness: f32,
    /// Roughness in G, linear.
    pub coat_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map of the coat, linear.
    pub coat_normal_texture: Option<TextureRef>,
    /// Factor on that map's x and y.
    pub coat_normal_scale: f32,
    /// KHR_materials_anisotropy: strength, 0 to 1.
    pub anisotropy: f32,
    /// Direction in which reflections are stretched, radians counter-clockwise from the tangent.
    pub anisotropy_rotation: f32,
    /// Direction in RG, strength in B, linear.
    pub anisotropy_texture: Option<TextureRef>,
    /// KHR_materials_iridescence: weight of a thin film.
    pub iridescence: f32,
    /// Weight in R, linear.
    pub iridescence_texture: Option<TextureRef>,
    /// Index of refraction of the film.
    pub iridescence_ior: f32,
    /// Thickness of the film where its texture is 0 and 1, nanometres; the latter without a texture.
    pub iridescence_thickness: [f32; 2],
    /// Thickness in G, linear.
    pub iridescence_thickness_texture: Option<TextureRef>,
    /// What the base colour's alpha means.
    pub alpha_mode: AlphaMode,
    /// Both sides reflect and emit; otherwise rays pass through the back as if nothing were there (glTF 2.0, section
    /// 3.9.6: back faces are culled).
    pub double_sided: bool,
    /// KHR_materials_unlit: the base colour is shown as it is.
    pub unlit: bool,
}

impl Material {
    /// All textures, in the order in which the kernels number them.
    pub fn textures(&self) -> [&Option<TextureRef>; 17] {
        [
            &self.base_color_texture,
            &self.metallic_roughness_texture,
            &self.normal_texture,
            &self.emission_texture,
            &self.specular_texture,
            &self.specular_color_texture,
            &self.transmission_texture,
            &self.diffuse_transmission_texture,
            &self.diffuse_transmission_color_texture,
            &self.sheen_color_texture,
            &self.sheen_roughness_texture,
            &self.coat_texture,
            &self.coat_roughness_texture,
            &self.coat_normal_texture,
            &self.anisotropy_texture,
            &self.iridescence_texture,
            &self.iridescence_thickness_texture,
        ]
    }

    /// The same, to be changed.
    pub fn textures_mut(&mut self) -> [&mut Option<TextureRef>; 17] {
        [
            &mut self.base_color_texture,
            &mut self.metallic_roughness_texture,
            &mut self.normal_texture,
            &mut self.emission_texture,
            &mut self.specular_texture,
            &mut self.specular_color_texture,
            &mut self.transmission_texture,
            &mut self.diffuse_transmission_texture,
            &mut self.diffuse_transmission_color_texture,
            &mut self.sheen_color_texture,
            &mut self.sheen_roughness_texture,
            &mut self.coat_texture,
            &mut self.coat_roughness_texture,
            &mut self.coat_normal_texture,
            &mut self.anisotropy_texture,
            &mut self.iridescence_texture,
            &mut self.iridescence_thickness_texture,
        ]
    }
}

impl Default for Material {
    /// glTF's default material.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Vec3::ZERO,
            emission_texture: None,
            specular: 1.0,
            specular_texture: None,
            specular_color: Vec3::ONE,
            specular_color_texture: None,
            ior: 1.5,
            transmission: 0.0,
            transmission_texture: None,
            is_solid: false,
            absorption: Vec3::ZERO,
            diffuse_transmission: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color: Vec3::ONE,
            diffuse_transmission_color_texture: None,
            sheen_color: Vec3::ZERO,
            sheen_color_texture: None,
            sheen_roughness: 0.0,
            sheen_roughness_texture: None,
            coat: 0.0,
            coat_texture: None,
            coat_roughness: 0.0,
            coat_roughness_texture: None,
            coat_normal_texture: None,
            coat_normal_scale: 1.0,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_texture: None,
            iridescence: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness: [100.0, 400.0],
            iridescence_thickness_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

/// Absorption in 1/metres of a body in which white light has this linear colour after so many metres (KHR_materials_volume).
pub fn absorption(color: Vec3, distance: f32) -> Vec3 {
    // Black over any distance is as good as opaque.
    -color.clamp(Vec3::splat(1e-6), Vec3::ONE).map(f32::ln) / distance
}

/// What the alpha of a material's base colour means (glTF 2.0, section 3.9.4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Present where alpha is at least `cutoff`.
    Mask {
        /// The threshold.
        cutoff: f32,
    },
    /// Alpha is coverage.
    Blend,
}

/// Use of an image by a material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureRef {
    /// Index into [`Scene::images`].
    pub image: u32,
    /// 0 for TEXCOORD_0, 1 for TEXCOORD_1.
    pub uv_set: u32,
    /// How the image repeats and is filtered.
    pub sampler: Sampler,
    /// KHR_texture_transform: `uv' = transform * (u, v, 1)`, the two rows of the affine map.
    pub transform: [Vec3; 2],
}

/// glTF sampler: how an image is read outside [0, 1] and between texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// glTF's magnification filter.
    pub filter: Filter,
}

/// glTF wrap mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Wrap {
    /// Tiles.
    #[default]
    Repeat,
    /// Tiles, every other one mirrored.
    Mirror,
    /// The edge texel goes on.
    Clamp,
}

/// Texel filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Filter {
    /// Bilinear.
    #[default]
    Linear,
    /// Nearest texel.
    Nearest,
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
                bounds = grow(bounds, instance.transform.transform_point3(p));
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
