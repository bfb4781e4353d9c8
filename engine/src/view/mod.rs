//! From scene-linear radiance to what a display shows: exposure, white balance, view transform, sRGB. Files and windows show the
//! same, as `view.wgsl` computes on the device what [`ViewEncoder`] does here, with the same numbers; a test holds the two
//! together.
//!
//! Nothing is known here of films and files. Which transforms there are and how they are named is [`scene::view`]'s business;
//! `docs/view-transforms.md` says where each comes from.

mod aces2;
mod chromatic;
mod neutral;
mod table;

use glam::{Mat3, Vec3};
use rayon::prelude::*;
use scene::view::{View, ViewTransform};

use aces2::Aces2;
use table::Table;

/// A view that is ready for colours.
#[derive(Debug, Clone)]
pub struct ViewEncoder {
    gain: f32,
    balance: Option<Mat3>,
    transform: Transform,
}

/// A transform with what it needs.
#[derive(Debug, Clone, Copy)]
enum Transform {
    Standard,
    Neutral,
    Aces2(&'static Aces2),
    Table(&'static Table),
}

impl Transform {
    fn of(transform: ViewTransform) -> Self {
        match transform {
            ViewTransform::Standard => Self::Standard,
            ViewTransform::KhronosNeutral => Self::Neutral,
            ViewTransform::Aces2 => Self::Aces2(Aces2::get()),
            ViewTransform::Agx => Self::Table(table::agx()),
            ViewTransform::Filmic => Self::Table(table::filmic()),
        }
    }
}

/// Numbers that a transform needs on a device, beside those that are part of its code; an empty list for those that need none.
pub fn device_numbers(transform: ViewTransform) -> Vec<f32> {
    match Transform::of(transform) {
        Transform::Standard | Transform::Neutral => Vec::new(),
        Transform::Aces2(aces2) => aces2.numbers(),
        Transform::Table(table) => table.numbers(),
    }
}

impl ViewEncoder {
    /// Prepares a view. The first one with a transform makes its tables, which takes some milliseconds.
    pub fn new(view: &View) -> Self {
        let balance = view.white_balance.as_ref().map(chromatic::balance);
        Self {
            gain: view.exposure.exp2(),
            balance: balance.map(|matrix| matrix.as_mat3()),
            transform: Transform::of(view.transform),
        }
    }

    /// Factor on radiance.
    pub fn gain(&self) -> f32 {
        self.gain
    }

    /// Matrix of the white balance, where there is one.
    pub fn balance(&self) -> Option<Mat3> {
        self.balance
    }

    /// A linear Rec.709 colour as sRGB codes, 0 to 1.
    pub fn encode(&self, rgb: [f32; 3]) -> [f32; 3] {
        let exposed = Vec3::from(rgb) * self.gain;
        let linear = self.balance.map_or(exposed, |balance| balance * exposed);
        match self.transform {
            Transform::Standard => linear.to_array().map(srgb),
            Transform::Neutral => neutral::apply(linear).to_array().map(srgb),
            Transform::Aces2(aces2) => {
                let shown = aces2.apply(linear.as_dvec3());
                shown.as_vec3().to_array().map(srgb)
            }
            Transform::Table(table) => table.apply(linear),
        }
    }

    /// Linear Rec.709 colours as 8-bit sRGB, three bytes each; NaN is black.
    pub fn encode8(&self, rgb: &[[f32; 3]]) -> Vec<u8> {
        // `as` saturates and turns NaN into 0.
        let byte = |code: f32| (code * 255.0 + 0.5) as u8;
        let pixels = rgb.par_iter().map(|&pixel| self.encode(pixel).map(byte));
        pixels.collect::<Vec<[u8; 3]>>().into_flattened()
    }
}

/// A linear value as an sRGB code (IEC 61966-2-1); what lies outside of 0 to 1 is clamped, NaN stays.
fn srgb(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests;
