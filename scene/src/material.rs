//! Materials as plain data: metallic-roughness with glTF's extensions, and the images they use.

use glam::{Vec3, Vec4};

/// A metallic-roughness material with the extensions that are supported. Textures multiply their factors.
#[derive(Debug, Clone)]
pub struct Material {
    /// Name in the file or the look; unique within the scene.
    pub name: String,
    /// Name by which mattes have it, where that is another one: of the surface of a material that a look blends with itself, the
    /// material's.
    pub matte: Option<String>,
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
    /// KHR_materials_dispersion: 20 divided by the Abbe number of the body; 0 is none.
    pub dispersion: f32,
    /// Of a body among others that it overlaps: light travels in the one with the highest, among equals in the one that it
    /// entered last.
    pub priority: i32,
    /// Of the body, 1/metres: light that goes a metre is multiplied by exp(-absorption).
    pub absorption: Vec3,
    /// KHR_materials_volume: the linear colour that white light has after the attenuation distance. Kernels know what
    /// [`Self::attenuate`] makes of both.
    pub attenuation_color: Vec3,
    /// KHR_materials_volume, metres; infinite where nothing is absorbed.
    pub attenuation_distance: f32,
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
    /// Pictures without environment show the shadows on it, and nothing else of it.
    pub shadow_catcher: bool,
    /// KHR_materials_unlit: the base colour is shown as it is.
    pub unlit: bool,
}

/// What the textures of a material are called, in the order in which the kernels number them.
pub const TEXTURES: [&str; 17] = [
    "base_color",
    "metallic_roughness",
    "normal",
    "emission",
    "specular",
    "specular_color",
    "transmission",
    "diffuse_transmission",
    "diffuse_transmission_color",
    "sheen_color",
    "sheen_roughness",
    "coat",
    "coat_roughness",
    "coat_normal",
    "anisotropy",
    "iridescence",
    "iridescence_thickness",
];

/// So many of them, the first ones, are those of a metallic-roughness surface; the others belong to layers.
pub const SURFACE_TEXTURES: usize = 6;

impl Material {
    /// The name by which mattes have it.
    pub fn matte_name(&self) -> &str {
        self.matte.as_deref().unwrap_or(&self.name)
    }

    /// Gives the body what it absorbs: white light has this linear colour after so many metres.
    pub fn attenuate(&mut self, color: Vec3, distance: f32) {
        self.attenuation_color = color;
        self.attenuation_distance = distance;
        self.absorption = absorption(color, distance);
    }

    /// All textures, in the order of [`TEXTURES`].
    pub fn textures(&self) -> [&Option<TextureRef>; TEXTURES.len()] {
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
    pub fn textures_mut(&mut self) -> [&mut Option<TextureRef>; TEXTURES.len()] {
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
            matte: None,
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
            dispersion: 0.0,
            priority: 0,
            absorption: Vec3::ZERO,
            attenuation_color: Vec3::ONE,
            attenuation_distance: f32::INFINITY,
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
            shadow_catcher: false,
            unlit: false,
        }
    }
}

/// Absorption in 1/metres of a body in which white light has this linear colour after so many metres (KHR_materials_volume).
pub fn absorption(color: Vec3, distance: f32) -> Vec3 {
    // Black over any distance is as good as opaque, and so is any colour over next to none.
    let depth = -color.clamp(Vec3::splat(1e-6), Vec3::ONE).map(f32::ln);
    (depth / distance).min(Vec3::MAX)
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
    /// Index into [`Scene::images`](super::Scene::images).
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
