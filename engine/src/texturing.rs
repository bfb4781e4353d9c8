//! What has to be known of texture programs when a scene is uploaded, before any of them has run: plain data between
//! [`crate::procedural`], which finds it out, and [`crate::gpu_scene`], which knows nothing else of textures.

use crate::scene::TextureRef;

/// What is known of a material's texture program without running it. The material may be a blend; then this holds for
/// whatever it may turn out to be.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ProgramTraits {
    /// There is a program, or a blend: the kernel runs at a hit.
    pub runs: bool,
    /// It decides how much light comes out of the surface, by emission or by opacity.
    pub decides_light: bool,
    /// It decides whether the surface is there.
    pub decides_opacity: bool,
    /// It decides whether light goes through.
    pub transmits: bool,
    /// It decides about a coat, sheen, a thin film or anisotropy.
    pub has_layers: bool,
    /// The surface may emit light at all.
    pub glows: bool,
    /// It is there to give light: it glows, and not by an image as dim as that of a display.
    pub is_lamp: bool,
    /// Luminance by which the surface is chosen as a light, W/m²/sr: a guess, since nobody knows what a program gives.
    /// 0 where light samples can't evaluate it: then scattered rays alone find it.
    pub brightness: f32,
}

/// What has to be on the GPU for the textures.
#[derive(Debug, Clone, Copy, Default)]
pub struct TextureReads<'a> {
    /// The images of `sam2D` parameters; a texture's image handle is an index into this list.
    pub images: &'a [TextureRef],
    /// Of [`crate::scene::Scene::images`], ascending: those whose mip levels some texture reads.
    pub with_levels: &'a [u32],
    /// Names of the custom mesh attributes; the kernel asks for them by their index in this list.
    pub attributes: &'a [String],
}
