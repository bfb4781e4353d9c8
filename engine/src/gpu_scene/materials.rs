//! Materials as the kernels read them.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::procedural::ProgramTraits;
use crate::scene::{AlphaMode, Filter, Material, Sampler, TextureRef, Wrap};

/// No texture.
const IMAGE_NONE: u32 = u32::MAX;

const DOUBLE_SIDED: u32 = 1;
const UNLIT: u32 = 2;
const MASK: u32 = 4;
const BLEND: u32 = 8;
const PROGRAM: u32 = 16;
const PROGRAM_LAST: u32 = 32;
const PROGRAM_LIGHT: u32 = 64;
const SOLID: u32 = 128;
const CLEAR: u32 = 256;
/// As `MIN_ALPHA` in `microfacet.wgsl`: surfaces below it are mirrors.
const SMOOTH_ALPHA: f32 = 0.001;
/// Textures of a material.
const TEXTURES: usize = 17;

/// `TextureSlot` in `materials.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuTextureSlot {
    row_u: Vec3,
    image: u32,
    row_v: Vec3,
    sampler: u32,
}

impl GpuTextureSlot {
    fn new(texture: Option<&TextureRef>) -> Self {
        match texture {
            None => Self {
                row_u: Vec3::X,
                image: IMAGE_NONE,
                row_v: Vec3::Y,
                sampler: 0,
            },
            Some(t) => Self {
                row_u: t.transform[0],
                image: t.image,
                row_v: t.transform[1],
                sampler: sampler_bits(&t.sampler) | if t.uv_set == 1 { 32 } else { 0 },
            },
        }
    }
}

/// `Material` in `materials.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuMaterial {
    base_color: [f32; 4],
    emission: Vec3,
    /// Set by the lights: mean radiance by which triangles are in their table, W/(m² sr); 0 where they are not.
    pub light_radiance: f32,
    specular_color: Vec3,
    specular: f32,
    metallic: f32,
    roughness: f32,
    dielectric_f0: f32,
    alpha_cutoff: f32,
    normal_scale: f32,
    flags: u32,
    texture_mask: u32,
    ior: f32,
    absorption: Vec3,
    transmission: f32,
    diffuse_transmission_color: Vec3,
    diffuse_transmission: f32,
    sheen_color: Vec3,
    sheen_roughness: f32,
    coat: f32,
    coat_roughness: f32,
    coat_normal_scale: f32,
    iridescence: f32,
    anisotropy: f32,
    anisotropy_rotation: f32,
    iridescence_ior: f32,
    dispersion: f32,
    iridescence_thickness: [f32; 2],
    priority: f32,
    spare: f32,
    textures: [GpuTextureSlot; TEXTURES],
}

impl GpuMaterial {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(GpuMaterial, $member))),*] };
        }
        offsets![
            base_color,
            emission,
            light_radiance,
            specular_color,
            specular,
            metallic,
            roughness,
            dielectric_f0,
            alpha_cutoff,
            normal_scale,
            flags,
            ior,
            absorption,
            transmission,
            diffuse_transmission_color,
            sheen_color,
            coat,
            anisotropy,
            dispersion,
            iridescence_thickness,
            priority,
            textures
        ]
    }
}

impl GpuMaterial {
    /// `program` is what is known of its texture program.
    pub fn new(material: &Material, program: &ProgramTraits) -> Self {
        let ratio = (material.ior - 1.0) / (material.ior + 1.0);
        let mut flags = 0;
        if material.double_sided {
            flags |= DOUBLE_SIDED;
        }
        if material.unlit {
            flags |= UNLIT;
        }
        let alpha_cutoff = match material.alpha_mode {
            AlphaMode::Opaque => 0.0,
            AlphaMode::Mask { cutoff } => {
                flags |= MASK;
                cutoff
            }
            AlphaMode::Blend => {
                flags |= BLEND;
                0.0
            }
        };
        if material.is_solid && (transmits(material) || program.transmits) {
            flags |= SOLID;
        }
        if is_clear(material, program) {
            flags |= CLEAR;
        }
        flags |= program_flags(program);
        let textures = material.textures();
        let texture_mask = (0..textures.len())
            .filter(|&i| textures[i].is_some())
            .fold(0, |mask, i| mask | 1 << i);
        Self {
            base_color: material.base_color.to_array(),
            emission: material.emission,
            light_radiance: 0.0,
            specular_color: material.specular_color,
            specular: material.specular,
            metallic: material.metallic,
            roughness: material.roughness,
            dielectric_f0: ratio * ratio,
            alpha_cutoff,
            normal_scale: material.normal_scale,
            flags,
            texture_mask,
            ior: material.ior,
            absorption: material.absorption,
            transmission: material.transmission,
            diffuse_transmission_color: material.diffuse_transmission_color,
            diffuse_transmission: material.diffuse_transmission,
            sheen_color: material.sheen_color,
            sheen_roughness: material.sheen_roughness,
            coat: material.coat,
            coat_roughness: material.coat_roughness,
            coat_normal_scale: material.coat_normal_scale,
            iridescence: material.iridescence,
            anisotropy: material.anisotropy,
            anisotropy_rotation: material.anisotropy_rotation,
            iridescence_ior: material.iridescence_ior,
            dispersion: material.dispersion,
            iridescence_thickness: material.iridescence_thickness,
            priority: material.priority as f32,
            spare: 0.0,
            textures: textures.map(|texture| GpuTextureSlot::new(texture.as_ref())),
        }
    }
}

/// Whether light may go through the surface.
pub fn transmits(material: &Material) -> bool {
    material.transmission > 0.0 || material.diffuse_transmission > 0.0
}

/// Whether the surface is a thin wall that light goes through straight on, and nothing else happens to it that a shadow ray
/// couldn't tell.
pub fn is_clear(material: &Material, program: &ProgramTraits) -> bool {
    material.transmission > 0.0
        && !material.is_solid
        && material.roughness * material.roughness <= SMOOTH_ALPHA
        && material.metallic == 0.0
        && material.specular_texture.is_none()
        && material.specular_color_texture.is_none()
        && material.emission == Vec3::ZERO
        && !material.unlit
        && !has_layers(material)
        && !program.runs
}

/// Whether the surface has more than a metallic-roughness layer.
pub fn has_layers(material: &Material) -> bool {
    material.coat > 0.0
        || material.sheen_color.max_element() > 0.0
        || material.iridescence > 0.0
        || material.anisotropy > 0.0
}

/// The flags of a material that follow from its texture program.
fn program_flags(program: &ProgramTraits) -> u32 {
    let flag = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
    flag(program.runs, PROGRAM)
        | flag(program.decides_light, PROGRAM_LAST)
        | flag(
            program.decides_light && program.brightness > 0.0,
            PROGRAM_LIGHT,
        )
}

/// Whether a hit may be transparent, so that its alpha must be looked up during traversal.
pub fn needs_alpha(material: &Material, has_vertex_colors: bool) -> bool {
    let varies = material.base_color_texture.is_some() || has_vertex_colors;
    match material.alpha_mode {
        AlphaMode::Opaque => false,
        AlphaMode::Mask { cutoff } => varies || material.base_color.w < cutoff,
        AlphaMode::Blend => varies || material.base_color.w < 1.0,
    }
}

/// Sampler bits of `images.wgsl`.
pub fn sampler_bits(sampler: &Sampler) -> u32 {
    let wrap = |w: Wrap| match w {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let filter = match sampler.filter {
        Filter::Linear => 0,
        Filter::Nearest => 16,
    };
    wrap(sampler.wrap_u) | wrap(sampler.wrap_v) << 2 | filter
}
