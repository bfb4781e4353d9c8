//! Functions that compiled kernels call. Those of numbers are `libm`'s: the same on every platform, so that pictures are.
//!
//! Public for code that is compiled ahead of time ([`Ahead`](super::Ahead)); whoever writes it keeps their contracts.

pub(super) mod lanes;

use std::sync::Arc;

use super::{ImageHeader, ir::Runtime};
use crate::HostFunction;
use crate::native::image::{Format, SRGB, srgb8, unorm8};
use kernel_ir::texel_place;

/// The type of a parameter or result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    F32,
    I32,
    Pointer,
}

/// How a function is called.
pub(super) struct Signature {
    pub(super) address: *const u8,
    pub(super) parameters: &'static [Kind],
    pub(super) result: Option<Kind>,
}

macro_rules! functions {
    ($($name:ident($($parameter:ident),+) = $function:path;)+) => {
        $(#[doc = concat!("`", stringify!($name), "` of WGSL.")]
        pub extern "C" fn $name($($parameter: f32),+) -> f32 {
            $function($($parameter),+)
        })+
    };
}

functions! {
    sin(x) = libm::sinf;
    cos(x) = libm::cosf;
    tan(x) = libm::tanf;
    asin(x) = libm::asinf;
    acos(x) = libm::acosf;
    sinh(x) = libm::sinhf;
    cosh(x) = libm::coshf;
    tanh(x) = libm::tanhf;
    asinh(x) = libm::asinhf;
    acosh(x) = libm::acoshf;
    atanh(x) = libm::atanhf;
    exp(x) = libm::expf;
    exp2(x) = libm::exp2f;
    log(x) = libm::logf;
    log2(x) = libm::log2f;
    pow(x, y) = libm::powf;
    floor(x) = libm::floorf;
    ceil(x) = libm::ceilf;
    truncate(x) = libm::truncf;
    nearest(x) = libm::rintf;
}

/// `ldexp` of WGSL.
pub extern "C" fn ldexp(x: f32, exponent: i32) -> f32 {
    libm::ldexpf(x, exponent)
}

/// The fraction of `frexp` of WGSL.
pub extern "C" fn frexp_fraction(x: f32) -> f32 {
    libm::frexpf(x).0
}

/// The exponent of `frexp` of WGSL.
pub extern "C" fn frexp_exponent(x: f32) -> i32 {
    libm::frexpf(x).1
}

/// The bits of a half.
pub extern "C" fn float_to_half(x: f32) -> u32 {
    u32::from(half::f16::from_f32(x).to_bits())
}

/// A float, from the bits of a half.
pub extern "C" fn half_to_float(bits: u32) -> f32 {
    half::f16::from_bits(bits as u16).to_f32()
}

/// Fills with zeros.
///
/// # Safety
/// `target` points to so many bytes that nothing else uses.
pub unsafe extern "C" fn zero(target: *mut u8, bytes: u32) {
    // SAFETY: the caller's.
    unsafe { target.write_bytes(0, bytes as usize) };
}

/// Copies.
///
/// # Safety
/// Both point to so many bytes, apart from each other, that nothing else writes.
pub unsafe extern "C" fn copy(target: *mut u8, source: *const u8, bytes: u32) {
    // SAFETY: the caller's.
    unsafe { target.copy_from_nonoverlapping(source, bytes as usize) };
}

/// A texel as four words.
///
/// # Safety
/// `header` is that of an image whose texels live, `texel` is one of them, and `target` has room for four words.
pub unsafe extern "C" fn load_texel(header: *const ImageHeader, texel: u32, target: *mut [u32; 4]) {
    // SAFETY: the caller's.
    let header = unsafe { &*header };
    let words = match header.format {
        Format::Rgba32Float | Format::Rgba32Uint => {
            // SAFETY: the texel is within the image.
            unsafe { header.texels.cast::<[u32; 4]>().add(texel as usize).read() }
        }
        Format::Rgba8Unorm | Format::Rgba8UnormSrgb => {
            // SAFETY: as above.
            let word = unsafe { header.texels.add(texel as usize).read() };
            let bytes = word.to_le_bytes();
            let mut values = bytes.map(|byte| f32::from(byte) * (1.0 / 255.0));
            if header.format == Format::Rgba8UnormSrgb {
                for (value, byte) in values.iter_mut().zip(bytes).take(3) {
                    *value = SRGB[usize::from(byte)];
                }
            }
            values.map(f32::to_bits)
        }
    };
    // SAFETY: the caller's.
    unsafe { target.write(words) };
}

/// Light of each byte that is encoded as sRGB, as [`load_texel`] gives it.
pub fn srgb() -> &'static [f32; 256] {
    &SRGB
}

/// Stores four words as a texel. What lies outside of the image is lost.
///
/// # Safety
/// `header` is that of an image whose texels live, and `source` points to four words.
pub unsafe extern "C" fn store_texel(
    header: *const ImageHeader,
    x: u32,
    y: u32,
    layer: u32,
    source: *const [u32; 4],
) {
    // SAFETY: the caller's.
    let (header, words) = unsafe { (&*header, source.read()) };
    if x >= header.width || y >= header.height || layer >= header.layers {
        return;
    }
    let texel = texel_place([header.width, header.height], [x, y, layer]) as usize;
    let values = words.map(f32::from_bits);
    let encode = |color: fn(f32) -> u32| {
        let [r, g, b] = [values[0], values[1], values[2]].map(color);
        r | g << 8 | b << 16 | unorm8(values[3]) << 24
    };
    // SAFETY: the texel is within the image.
    unsafe {
        match header.format {
            Format::Rgba32Float | Format::Rgba32Uint => {
                header.texels.cast::<[u32; 4]>().add(texel).write(words);
            }
            Format::Rgba8Unorm => header.texels.add(texel).write(encode(unorm8)),
            Format::Rgba8UnormSrgb => header.texels.add(texel).write(encode(srgb8)),
        }
    }
}

/// Calls a function that was bound.
///
/// # Safety
/// `function` is bound; `arguments` and `result` point to so many words, that nothing else uses.
pub unsafe extern "C" fn host(
    function: *const Arc<dyn HostFunction>,
    arguments: *const u32,
    argument_words: u32,
    result: *mut u32,
    result_words: u32,
) {
    // SAFETY: the caller's.
    let (function, arguments, result) = unsafe {
        (
            &*function,
            std::slice::from_raw_parts(arguments, argument_words as usize),
            std::slice::from_raw_parts_mut(result, result_words as usize),
        )
    };
    function.call(arguments, result);
}

/// Where a function is, and what it takes and gives.
pub(super) fn signature(function: Runtime) -> Signature {
    use Kind::{F32, I32, Pointer};
    let (address, parameters, result): (*const u8, &'static [Kind], _) = match function {
        Runtime::Sin => (sin as *const u8, &[F32], Some(F32)),
        Runtime::Cos => (cos as *const u8, &[F32], Some(F32)),
        Runtime::Tan => (tan as *const u8, &[F32], Some(F32)),
        Runtime::Asin => (asin as *const u8, &[F32], Some(F32)),
        Runtime::Acos => (acos as *const u8, &[F32], Some(F32)),
        Runtime::Sinh => (sinh as *const u8, &[F32], Some(F32)),
        Runtime::Cosh => (cosh as *const u8, &[F32], Some(F32)),
        Runtime::Tanh => (tanh as *const u8, &[F32], Some(F32)),
        Runtime::Asinh => (asinh as *const u8, &[F32], Some(F32)),
        Runtime::Acosh => (acosh as *const u8, &[F32], Some(F32)),
        Runtime::Atanh => (atanh as *const u8, &[F32], Some(F32)),
        Runtime::Exp => (exp as *const u8, &[F32], Some(F32)),
        Runtime::Exp2 => (exp2 as *const u8, &[F32], Some(F32)),
        Runtime::Log => (log as *const u8, &[F32], Some(F32)),
        Runtime::Log2 => (log2 as *const u8, &[F32], Some(F32)),
        Runtime::Pow => (pow as *const u8, &[F32, F32], Some(F32)),
        Runtime::FrexpFraction => (frexp_fraction as *const u8, &[F32], Some(F32)),
        Runtime::FrexpExponent => (frexp_exponent as *const u8, &[F32], Some(I32)),
        Runtime::Ldexp => (ldexp as *const u8, &[F32, I32], Some(F32)),
        Runtime::FloatToHalf => (float_to_half as *const u8, &[F32], Some(I32)),
        Runtime::HalfToFloat => (half_to_float as *const u8, &[I32], Some(F32)),
        Runtime::Zero => (zero as *const u8, &[Pointer, I32], None),
        Runtime::Copy => (copy as *const u8, &[Pointer, Pointer, I32], None),
        Runtime::LoadTexel => (load_texel as *const u8, &[Pointer, I32, Pointer], None),
        Runtime::StoreTexel => (
            store_texel as *const u8,
            &[Pointer, I32, I32, I32, Pointer],
            None,
        ),
        Runtime::Host => (
            host as *const u8,
            &[Pointer, Pointer, I32, Pointer, I32],
            None,
        ),
    };
    Signature {
        address,
        parameters,
        result,
    }
}

/// What Cranelift calls where a processor has no instruction for it, by the names that it uses.
#[cfg_attr(
    target_family = "wasm",
    expect(dead_code, reason = "no machine code is linked there")
)]
pub(super) fn library() -> [(&'static str, *const u8); 4] {
    [
        ("floorf", floor as *const u8),
        ("ceilf", ceil as *const u8),
        ("truncf", truncate as *const u8),
        ("nearbyintf", nearest as *const u8),
    ]
}
