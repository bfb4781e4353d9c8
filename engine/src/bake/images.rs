//! Pictures of the scene read at a place, as `passes/shared/images.wgsl` does it.

use glam::{Vec2, Vec4};

use crate::scene::{Filter, Image, Scene, TextureRef, Wrap};

/// What a material's picture has there, linear; white where the material has none.
pub(super) fn sample(
    scene: &Scene,
    texture: Option<&TextureRef>,
    uv: impl Fn(u32) -> Vec2,
) -> Vec4 {
    let Some(texture) = texture else {
        return Vec4::ONE;
    };
    let image = &scene.images[texture.image as usize];
    let at = uv(texture.uv_set).extend(1.0);
    let uv = Vec2::new(texture.transform[0].dot(at), texture.transform[1].dot(at));
    let size = Vec2::new(image.width as f32, image.height as f32);
    let texel = (uv * size).clamp(Vec2::splat(-1e9), Vec2::splat(1e9));
    let wraps = (texture.sampler.wrap_u, texture.sampler.wrap_v);
    let load = |x: f32, y: f32| {
        let x = wrapped(x as i64, i64::from(image.width), wraps.0);
        let y = wrapped(y as i64, i64::from(image.height), wraps.1);
        load(image, x, y)
    };
    if texture.sampler.filter == Filter::Nearest {
        return load(texel.x.floor(), texel.y.floor());
    }
    let base = (texel - 0.5).floor();
    let share = texel - 0.5 - base;
    let row = |y: f32| load(base.x, y).lerp(load(base.x + 1.0, y), share.x);
    row(base.y).lerp(row(base.y + 1.0), share.y)
}

fn wrapped(i: i64, size: i64, wrap: Wrap) -> usize {
    let place = match wrap {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::Mirror => {
            let there = i.rem_euclid(2 * size);
            there.min(2 * size - 1 - there)
        }
        Wrap::Clamp => i.clamp(0, size - 1),
    };
    place as usize
}

fn load(image: &Image, x: usize, y: usize) -> Vec4 {
    let at = 4 * (y * image.width as usize + x);
    let texel = |i: usize| f32::from(image.rgba8[at + i]) / 255.0;
    let color = |i: usize| match image.srgb {
        true => to_linear(texel(i)),
        false => texel(i),
    };
    Vec4::new(color(0), color(1), color(2), texel(3))
}

/// From sRGB's encoding (IEC 61966-2-1).
fn to_linear(x: f32) -> f32 {
    match x <= 0.04045 {
        true => x / 12.92,
        false => ((x + 0.055) / 1.055).powf(2.4),
    }
}

/// To sRGB's encoding.
pub(super) fn encoded(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    match x <= 0.003_130_8 {
        true => 12.92 * x,
        false => 1.055 * x.powf(1.0 / 2.4) - 0.055,
    }
}

/// To sRGB's encoding, eight bits.
pub(super) fn srgb8(x: f32) -> u8 {
    linear8(encoded(x))
}

/// A number from 0 to 1 in eight bits.
pub(super) fn linear8(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_repeat_are_mirrored_or_go_on() {
        let wrapped = |wrap| [-1, 0, 3, 4, 7, 8].map(|i| wrapped(i, 4, wrap));
        assert_eq!(wrapped(Wrap::Repeat), [3, 0, 3, 0, 3, 0]);
        assert_eq!(wrapped(Wrap::Mirror), [0, 0, 3, 3, 0, 0]);
        assert_eq!(wrapped(Wrap::Clamp), [0, 0, 3, 3, 3, 3]);
    }

    #[test]
    fn eight_bits_of_srgb_come_back() {
        for byte in 0..=255 {
            assert_eq!(srgb8(to_linear(f32::from(byte) / 255.0)), byte);
        }
    }
}
