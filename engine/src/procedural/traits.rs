//! What of a material's texture program other kernels must know before it has run.

use glam::Vec3;

use crate::scene::material_parameters::Feature;
use crate::texturing::ProgramTraits;

use super::{Output, Outputs, Procedural};

/// An image that glows no brighter than white paper is a sign or a display: most models that have one are to be seen in some light, and
/// would be black.
pub(crate) const BRIGHTEST_DISPLAY: f32 = 1.0;

/// Of a surface that is no blend: what its program needs to know about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    /// The emission, or the factor on a driven one.
    pub(super) emission: Vec3,
    /// The emission is multiplied by an image, which a light sample can't see.
    pub(super) has_emission_image: bool,
    /// Opacity where it isn't driven.
    pub(super) opacity: f32,
    /// Metres per unit of the bump height.
    pub(super) bump_scale: f32,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            emission: Vec3::ZERO,
            has_emission_image: false,
            opacity: 1.0,
            bump_scale: 1.0,
        }
    }
}

impl Procedural {
    /// What is known of a material's program.
    pub fn traits(&self, material: u32) -> ProgramTraits {
        self.traits
            .get(material as usize)
            .copied()
            .unwrap_or_default()
    }

    /// Brings the traits of all materials up to date; a blend after what lies below it.
    pub(super) fn refresh_traits(&mut self) {
        self.traits
            .resize(self.wiring.len(), ProgramTraits::default());
        for &material in &self.order {
            let wiring = &self.wiring[material as usize];
            self.traits[material as usize] = match &wiring.blend {
                Some(blend) => {
                    let of = |m: u32| self.traits[m as usize];
                    of_blend(of(blend.base), of(blend.over))
                }
                None => of_surface(self.outputs(material), &wiring.surface),
            };
        }
    }
}

fn of_surface(outputs: Outputs, surface: &Surface) -> ProgramTraits {
    let drives = |output: Output| outputs.contains(output);
    let is_constant = !drives(Output::EMISSION);
    let glows = surface.emission.max_element() > 0.0;
    let glows_by_image = is_constant && surface.has_emission_image;
    let is_sampled = glows && !glows_by_image;
    let is_display = glows_by_image && surface.emission.max_element() <= BRIGHTEST_DISPLAY;
    ProgramTraits {
        runs: !outputs.is_empty(),
        decides_light: drives(Output::EMISSION)
            || drives(Output::EMISSION_STRENGTH)
            || drives(Output::OPACITY),
        decides_opacity: drives(Output::OPACITY),
        transmits: outputs.need(Feature::Transmission),
        has_layers: outputs.need(Feature::Layers),
        glows,
        is_lamp: glows && !is_display,
        brightness: if is_sampled {
            luminance(surface.emission)
        } else {
            0.0
        },
    }
}

fn of_blend(base: ProgramTraits, over: ProgramTraits) -> ProgramTraits {
    let glows = base.glows || over.glows;
    let decides_opacity = base.decides_opacity || over.decides_opacity;
    // One side that can't be evaluated spoils the whole.
    let is_sampled = [base, over]
        .iter()
        .all(|side| !side.glows || side.brightness > 0.0);
    ProgramTraits {
        runs: true,
        decides_light: glows || decides_opacity,
        decides_opacity,
        transmits: base.transmits || over.transmits,
        has_layers: base.has_layers || over.has_layers,
        glows,
        is_lamp: base.is_lamp || over.is_lamp,
        brightness: if is_sampled {
            base.brightness.max(over.brightness)
        } else {
            0.0
        },
    }
}

fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
        .max(c.max_element() * 1e-3)
}
