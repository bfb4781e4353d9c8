//! Materials as the kernels read them.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use crate::material_record::{self, PLACES, ROWS, flag, place_of};
use crate::scene::material_parameters::{Feature, Field, PARAMETERS};
use crate::scene::{AlphaMode, Filter, Material, Sampler, TEXTURES, TextureRef, Wrap, name_id};
use crate::texturing::ProgramTraits;

/// No texture.
const IMAGE_NONE: u32 = u32::MAX;

/// As `MIN_ALPHA` in `microfacet.wgsl`: surfaces below it are mirrors.
const SMOOTH_ALPHA: f32 = 0.001;
/// As `CASTER_ALPHA` and `CASTER_BODY` in `left.wgsl`: how rough a surface that throws caustics may be, as the width of its microfacets'
/// distribution, and how much of the light that enters it may be scattered diffusely.
const CASTER_ALPHA: f32 = 0.1;
const CASTER_BODY: f32 = 0.02;
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

/// `Material` in WGSL: [`MEMBERS`](material_record::MEMBERS), then the textures.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuMaterial {
    words: [[u32; 4]; ROWS],
    textures: [GpuTextureSlot; TEXTURES.len()],
}

impl GpuMaterial {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        let members = material_record::MEMBERS.iter();
        members
            .map(|member| (member.name, 4 * member.offset))
            .chain([("textures", std::mem::offset_of!(Self, textures))])
            .collect()
    }

    /// `group` is the number of the light group that its emission is in, `program` what is known of its texture program.
    pub fn new(material: &Material, group: u32, program: &ProgramTraits) -> Self {
        let textures = material.textures();
        let mut record = Self {
            words: [[0; 4]; ROWS],
            textures: textures.map(|texture| GpuTextureSlot::new(texture.as_ref())),
        };
        for (parameter, place) in PARAMETERS.iter().zip(PLACES) {
            match (place, parameter.field) {
                (Some(at), Field::Number(get, _)) => record.set(at, [get(material)]),
                (Some(at), Field::Color(get, _)) => record.set(at, get(material).to_array()),
                _ => {}
            }
        }
        let ratio = (material.ior - 1.0) / (material.ior + 1.0);
        let cutoff = match material.alpha_mode {
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Opaque | AlphaMode::Blend => 0.0,
        };
        record.set(
            const { place_of("base_color") },
            material.base_color.to_array(),
        );
        record.set(const { place_of("dielectric_f0") }, [ratio * ratio]);
        record.set(const { place_of("alpha_cutoff") }, [cutoff]);
        record.set(
            const { place_of("absorption") },
            material.absorption.to_array(),
        );
        record.set(
            const { place_of("coat_normal_scale") },
            [material.coat_normal_scale],
        );
        record.set(
            const { place_of("iridescence_thickness") },
            material.iridescence_thickness,
        );
        record.set_word(
            const { place_of("flags") },
            flags(material, program) | group << flag::LIGHT_GROUP_SHIFT,
        );
        record.set_word(const { place_of("id") }, name_id(material.matte_name()));
        let texture_mask = (0..textures.len())
            .filter(|&i| textures[i].is_some())
            .fold(0, |mask, i| mask | 1 << i);
        record.set_word(const { place_of("texture_mask") }, texture_mask);
        record
    }

    /// Mean radiance by which triangles are in the table of lights, W/(m² sr); 0 where they are not. The lights set it.
    pub fn light_radiance(&self) -> f32 {
        let at = const { place_of("light_radiance") };
        f32::from_bits(self.words[at / 4][at % 4])
    }

    /// See [`Self::light_radiance`].
    pub fn set_light_radiance(&mut self, radiance: f32) {
        self.set(const { place_of("light_radiance") }, [radiance]);
    }

    fn set<const N: usize>(&mut self, at: usize, values: [f32; N]) {
        for (at, value) in (at..).zip(values) {
            self.set_word(at, value.to_bits());
        }
    }

    fn set_word(&mut self, at: usize, word: u32) {
        self.words[at / 4][at % 4] = word;
    }
}

fn flags(material: &Material, program: &ProgramTraits) -> u32 {
    let set = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
    set(material.double_sided, flag::DOUBLE_SIDED)
        | set(material.unlit, flag::UNLIT)
        | set(material.shadow_catcher, flag::SHADOW_CATCHER)
        | set(
            matches!(material.alpha_mode, AlphaMode::Mask { .. }),
            flag::MASK,
        )
        | set(material.alpha_mode == AlphaMode::Blend, flag::BLEND)
        | set(is_body(material, program), flag::SOLID)
        | set(is_clear(material, program), flag::CLEAR)
        | set(casts_caustics(material, program), flag::CASTER)
        | program_flags(program)
}

/// Whether the surface bounds a body that light may go through.
pub fn is_body(material: &Material, program: &ProgramTraits) -> bool {
    material.is_solid && (transmits(material) || program.transmits)
}

/// Whether light may go through the surface.
pub fn transmits(material: &Material) -> bool {
    needs(material, Feature::Transmission)
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

/// Whether the surface may throw caustics. What a texture program does to it isn't known, but for one that lets light through.
pub fn casts_caustics(material: &Material, program: &ProgramTraits) -> bool {
    let is_smooth = material.roughness * material.roughness <= CASTER_ALPHA
        || material.metallic_roughness_texture.is_some();
    let body = (1.0 - material.metallic) * (1.0 - material.transmission);
    let is_bare = body <= CASTER_BODY && material.sheen_color == Vec3::ZERO;
    let by_constants = is_smooth && is_bare && !material.unlit && !is_clear(material, program);
    by_constants || program.transmits
}

/// Whether the surface has more than a metallic-roughness layer.
pub fn has_layers(material: &Material) -> bool {
    needs(material, Feature::Layers)
}

fn needs(material: &Material, feature: Feature) -> bool {
    let mut parameters = PARAMETERS.iter().filter(|p| p.needs == Some(feature));
    parameters.any(|parameter| parameter.is_there(material))
}

/// The flags of a material that follow from its texture program.
fn program_flags(program: &ProgramTraits) -> u32 {
    let set = |is_set: bool, flag: u32| if is_set { flag } else { 0 };
    let is_light = program.decides_light && program.brightness > 0.0;
    set(program.runs, flag::PROGRAM)
        | set(program.decides_light, flag::PROGRAM_LAST)
        | set(is_light, flag::PROGRAM_LIGHT)
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
