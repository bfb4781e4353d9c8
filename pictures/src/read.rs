//! Bytes of a file to a [`Picture`]: PNG, JPEG, WebP, BMP, TGA by the `image` crate, Radiance HDR, OpenEXR. The format is told by
//! the contents.

use std::io::{Cursor, Read as _};

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use crate::error::{MAX_SIDE, PNG_ASIDE, PictureError, check_size};
use crate::{Channel, Layer, Picture, exr};

/// Formats by how their files begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Exr,
    Hdr,
    Other(image::ImageFormat),
}

impl Kind {
    pub(crate) fn of(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(&exr::MAGIC) {
            return Some(Self::Exr);
        }
        if bytes.starts_with(b"#?") {
            return Some(Self::Hdr);
        }
        image::guess_format(bytes).ok().map(Self::Other)
    }
}

impl Picture {
    /// Reads a file's contents. 8 and 16 bits are taken for sRGB, whose colours aren't multiplied by alpha yet; floats for linear.
    ///
    /// # Errors
    /// It is no picture, a damaged one, or larger than is read.
    pub fn read(bytes: &[u8]) -> Result<Self, PictureError> {
        let kind = Kind::of(bytes).ok_or(PictureError::Foreign)?;
        // The decoders are foreign code that is fed with foreign bytes.
        let decoded = texgen::guarded(|| match kind {
            Kind::Exr => exr::layers(bytes).map(|layers| Self { layers }),
            Kind::Hdr => pixels(hdr(bytes)?, bytes.len()),
            Kind::Other(_) => pixels(decoder(bytes)?, bytes.len()),
        });
        decoded.unwrap_or_else(|_| Err(PictureError::damaged("the decoder gave up on it")))
    }
}

/// The decoder of a Radiance file, whatever program its first line names.
pub(crate) fn hdr(bytes: &[u8]) -> Result<impl ImageDecoder, PictureError> {
    let line = bytes.iter().position(|&b| b == b'\n');
    let rest = line.map_or(&[][..], |end| &bytes[end..]);
    let reader = (&b"#?RADIANCE"[..]).chain(rest);
    HdrDecoder::new(reader).map_err(|error| match error {
        ImageError::Unsupported(_) => PictureError::Unsupported(format!(
            "is a Radiance file of a kind that isn't read ({error}); those of RGBE are, with rows from the top (a line `-Y HEIGHT +X WIDTH`)"
        )),
        other => PictureError::damaged(other),
    })
}

/// The decoder of other files.
pub(crate) fn decoder(bytes: &[u8]) -> Result<impl ImageDecoder, PictureError> {
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(PictureError::damaged)?;
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_SIDE as u32);
    limits.max_image_height = Some(MAX_SIDE as u32);
    if reader.format() == Some(ImageFormat::Png) {
        limits.max_alloc = Some(PNG_ASIDE);
    }
    reader.limits(limits);
    reader.into_decoder().map_err(PictureError::damaged)
}

fn pixels(decoder: impl ImageDecoder, bytes: usize) -> Result<Picture, PictureError> {
    let (width, height) = decoder.dimensions();
    let size = [width as usize, height as usize];
    check_size(size, 4, bytes)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(PictureError::damaged)?;
    let is_float = matches!(
        picture,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    );
    let linear = match is_float {
        true => |value| value,
        false => srgb_to_linear,
    };
    if !picture.color().has_alpha() {
        let values = picture.into_rgb32f().into_raw();
        let (rgb, _) = values.as_chunks::<3>();
        let rgb: Vec<[f32; 3]> = rgb.iter().map(|rgb| rgb.map(linear)).collect();
        return Ok(Picture {
            layers: vec![Layer::rgb("", size, &rgb)],
        });
    }
    let values = picture.into_rgba32f().into_raw();
    let (rgba, _) = values.as_chunks::<4>();
    let channel = |(at, name): (usize, &str)| Channel {
        name: name.to_owned(),
        values: (rgba.iter())
            .map(|rgba| match at {
                3 => rgba[3],
                _ => linear(rgba[at]) * rgba[3],
            })
            .collect(),
    };
    let channels = ["R", "G", "B", "A"].into_iter().enumerate().map(channel);
    Ok(Picture {
        layers: vec![Layer::new(String::new(), size, channels.collect())],
    })
}

/// IEC 61966-2-1.
pub(crate) fn srgb_to_linear(encoded: f32) -> f32 {
    match encoded <= 0.04045 {
        true => encoded / 12.92,
        false => ((encoded + 0.055) / 1.055).powf(2.4),
    }
}

/// The same backwards.
pub(crate) fn linear_to_srgb(linear: f32) -> f32 {
    match linear <= 0.003_130_8 {
        true => linear * 12.92,
        false => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).expect("written");
        bytes.into_inner()
    }

    #[test]
    fn eight_bits_are_srgb_and_floats_are_linear() {
        let grey = image::RgbImage::from_pixel(3, 2, image::Rgb([0, 188, 255]));
        let png = encoded(&DynamicImage::ImageRgb8(grey), ImageFormat::Png);
        let picture = Picture::read(&png).expect("a picture");
        let layer = picture.shown().expect("one");
        assert_eq!(layer.size, [3, 2]);
        let pixel: Vec<_> = layer.channels.iter().map(|c| c.values[5]).collect();
        assert_eq!((pixel[0], pixel[2]), (0.0, 1.0));
        assert!((pixel[1] - 0.502_886).abs() < 1e-5, "{}", pixel[1]);
        assert_eq!((linear_to_srgb(pixel[1]) * 255.0).round(), 188.0);
        let float = image::Rgb32FImage::from_pixel(2, 2, image::Rgb([4.0, 0.5, 0.0]));
        let hdr = encoded(&DynamicImage::ImageRgb32F(float), ImageFormat::Hdr);
        let picture = Picture::read(&hdr).expect("a picture");
        let layer = picture.shown().expect("one");
        let pixel: Vec<_> = layer.channels.iter().map(|c| c.values[0]).collect();
        assert_eq!(pixel, [4.0, 0.5, 0.0]);
        let other_name = [&b"#?RGBE"[..], &hdr[b"#?RADIANCE".len()..]].concat();
        assert_eq!(Picture::read(&other_name).expect("the same"), picture);
    }

    #[test]
    fn colours_are_multiplied_by_alpha() {
        let half = image::RgbaImage::from_pixel(2, 2, image::Rgba([188, 0, 255, 51]));
        let png = encoded(&DynamicImage::ImageRgba8(half), ImageFormat::Png);
        let picture = Picture::read(&png).expect("a picture");
        let layer = picture.shown().expect("one");
        let pixel: Vec<_> = layer.channels.iter().map(|c| c.values[0]).collect();
        for (found, wanted) in pixel.iter().zip([0.502_886 * 0.2, 0.0, 0.2, 0.2]) {
            assert!((found - wanted).abs() < 1e-5, "{pixel:?}");
        }
        assert_eq!(layer.alpha(), Some(&[0.2; 4][..]));
    }

    #[test]
    fn a_colour_profile_as_large_as_a_house_is_left_out() {
        let mut file = Vec::new();
        let mut encoder = image::codecs::png::PngEncoder::new(&mut file);
        let profile = vec![0; PNG_ASIDE as usize + (1 << 20)];
        image::ImageEncoder::set_icc_profile(&mut encoder, profile).expect("a profile");
        let pixel = DynamicImage::new_rgb8(1, 1);
        pixel.write_with_encoder(encoder).expect("written");
        let mut decoder = decoder(&file).expect("a picture");
        assert!(decoder.icc_profile().is_ok_and(|icc| icc.is_none()));
        assert_eq!(Picture::read(&file).expect("a picture").layers.len(), 1);
    }

    #[test]
    fn what_is_cut_or_foreign_is_an_error() {
        assert_eq!(Picture::read(b"").unwrap_err(), PictureError::Foreign);
        assert_eq!(Picture::read(b"hello").unwrap_err(), PictureError::Foreign);
        let noise = image::RgbImage::from_fn(40, 30, |x, y| {
            image::Rgb([(x * y * 7) as u8, (x * 31 + y) as u8, (x ^ y) as u8])
        });
        let noise = DynamicImage::ImageRgb8(noise);
        for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Bmp] {
            let bytes = encoded(&noise, format);
            for end in [2, 10, 30, 60, bytes.len() / 4] {
                // A JPEG that ends early shows what there is of it.
                let cut = Picture::read(&bytes[..end]);
                assert!(cut.is_err(), "{format:?} {end}");
            }
        }
    }
}
