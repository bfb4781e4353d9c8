//! The pictures of a scene: decoded in parallel and within limits, each of them once whatever shows it.

use super::budget::Budget;
use super::error::{Fault, ImportError, Warnings};
use crate::Image;
use crate::input::{FileId, Files};
use image::error::{ImageError, LimitErrorKind};
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;

/// Longest side of a picture, texels.
const MAX_SIDE: u32 = 16384;
/// Bytes that all pictures of a scene may take decoded (4 GiB).
const MAX_DECODED: u64 = 4 << 30;
/// Bytes that a PNG file may take beside its pixels while it is read, such as for a colour profile; larger profiles are left out. Packed,
/// they have a thousandth of their size.
pub(super) const PNG_ASIDE: u64 = 64 << 20;
/// Largest picture file (1 GiB).
pub(super) const MAX_FILE: u64 = 1 << 30;

/// What tells a picture from all others, also from those of other files.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Key {
    /// A file of its own.
    File(FileId),
    /// Bytes of a buffer: scene file, buffer, offset and length.
    Bytes(FileId, usize, u64, u64),
    /// Whatever else: scene file and index in it.
    Entry(FileId, usize),
}

/// A file whose materials show pictures, by their numbers in it.
pub(super) trait Album: Sync {
    /// The file.
    fn path(&self) -> &Path;

    /// What tells a picture from all others.
    fn key(&self, index: usize) -> Key;

    /// What messages call it.
    fn name(&self, index: usize) -> String;

    /// Its file's bytes: PNG, JPEG or WebP.
    fn bytes(&self, index: usize) -> Result<Cow<'_, [u8]>, Fault>;
}

/// Where the pictures of a scene stand in `Scene::images`, and whether they are read as sRGB.
#[derive(Debug, Default)]
pub(super) struct Pictures(HashMap<(Key, bool), u32>);

impl Pictures {
    /// The requested pictures that the scene, which has those of `held`, doesn't have yet, and where each of the
    /// requested ones will stand. A request is a number in the album, and whether RGB is sRGB-encoded. Warns of those that
    /// lose depth.
    pub(super) fn load(
        &mut self,
        album: &impl Album,
        requests: &[(usize, bool)],
        held: &[Image],
        warnings: &mut Warnings,
    ) -> Result<(Vec<Image>, Vec<u32>), ImportError> {
        let (mut missing, mut added, mut slots) = (Vec::new(), Vec::new(), Vec::new());
        for &(index, srgb) in requests {
            let key = (album.key(index), srgb);
            let next = (held.len() + missing.len()) as u32;
            let slot = self.0.get(&key).copied().unwrap_or_else(|| {
                missing.push((index, srgb));
                added.push((key, next));
                next
            });
            slots.push(slot);
        }
        let images = load(album, &missing, held, warnings)?;
        self.0.extend(added);
        Ok((images, slots))
    }
}

/// Why a picture isn't read.
#[derive(Debug)]
enum Refusal {
    /// Another one is to be put in its place.
    Fault(Fault),
    /// A smaller one is.
    TooLarge(Fault),
}

impl Refusal {
    /// The error of a picture of a file, by its name there.
    fn of(self, path: &Path, image: &str) -> ImportError {
        let (path, image) = (path.to_owned(), image.to_owned());
        match self {
            Self::Fault(problem) => ImportError::Image {
                path,
                image,
                problem,
            },
            Self::TooLarge(problem) => ImportError::TooLarge {
                path,
                problem: format!("{image}: {problem}"),
            },
        }
    }

    /// Without the place.
    fn into_fault(self) -> Fault {
        match self {
            Self::Fault(problem) | Self::TooLarge(problem) => problem,
        }
    }
}

impl From<&str> for Refusal {
    fn from(problem: &str) -> Self {
        Self::Fault(problem.to_owned())
    }
}

impl From<ImageError> for Refusal {
    fn from(error: ImageError) -> Self {
        match &error {
            ImageError::Limits(limit) if limit.kind() == LimitErrorKind::DimensionError => {
                Self::TooLarge(format!(
                    "is larger than the {MAX_SIDE} texels a side that are read; make it smaller"
                ))
            }
            _ => Self::Fault(error.to_string()),
        }
    }
}

/// What pictures may still take in a scene that has some.
fn budget(held: &[Image]) -> Budget {
    let held = held.iter().map(|image| image.rgba8.len() as u64).sum();
    Budget::new(MAX_DECODED.saturating_sub(held))
}

/// Decodes the requested pictures for a scene that has those of `held`. One that is wanted both as colour and as data is
/// decoded once and copied.
fn load(
    album: &impl Album,
    requests: &[(usize, bool)],
    held: &[Image],
    warnings: &mut Warnings,
) -> Result<Vec<Image>, ImportError> {
    let mut wanted: Vec<usize> = requests.iter().map(|&(index, _)| index).collect();
    wanted.sort_unstable();
    wanted.dedup();
    let budget = budget(held);
    let read: Vec<(Image, Option<String>)> = wanted
        .par_iter()
        .map(|&index| load_one(album, index, &budget))
        .collect::<Result<_, _>>()?;
    let mut decoded: Vec<Option<Image>> = Vec::with_capacity(read.len());
    for (image, lost) in read {
        decoded.push(Some(image));
        if let Some(lost) = lost {
            warnings.push(lost);
        }
    }

    // A picture has at most two uses; the first one of two gets a copy.
    let mut uses_left = vec![0u32; wanted.len()];
    let slot = |index: usize| wanted.partition_point(|&w| w < index);
    requests
        .iter()
        .for_each(|&(index, _)| uses_left[slot(index)] += 1);
    let mut images = Vec::with_capacity(requests.len());
    for &(index, srgb) in requests {
        let slot = slot(index);
        uses_left[slot] -= 1;
        let image = match uses_left[slot] {
            0 => decoded[slot].take(),
            _ => {
                let again = decoded[slot].as_ref();
                if let Some(image) = again {
                    take(&budget, image.rgba8.len() as u64)
                        .map_err(|refusal| refusal.of(album.path(), &image.name))?;
                }
                again.cloned()
            }
        };
        let image = image.expect("a picture is taken only at its last use");
        images.push(Image { srgb, ..image });
    }
    Ok(images)
}

/// Reads one picture file by itself, for a scene that has those of `held`: PNG, JPEG or WebP. Returns it with a warning where
/// it loses depth: pictures are kept with eight bits a channel.
///
/// # Errors
/// One sentence without the path.
pub fn load_picture(
    files: &dyn Files,
    path: &Path,
    srgb: bool,
    held: &[Image],
) -> Result<(Image, Option<String>), String> {
    let bytes = files
        .read(path, MAX_FILE)
        .map_err(|error| format!("cannot read it: {error}"))?;
    let decoded = decode_guarded(&bytes, &budget(held)).map_err(Refusal::into_fault)?;
    Ok(kept(path.display().to_string(), decoded, srgb))
}

fn load_one(
    album: &impl Album,
    index: usize,
    budget: &Budget,
) -> Result<(Image, Option<String>), ImportError> {
    let name = album.name(index);
    let failed = |refusal: Refusal| refusal.of(album.path(), &name);
    let bytes = album.bytes(index).map_err(Refusal::Fault).map_err(failed)?;
    let decoded = decode_guarded(&bytes, budget).map_err(failed)?;
    Ok(kept(name, decoded, false))
}

/// A picture as scenes have it, and a warning where that is less than what its file has.
fn kept(name: String, decoded: DynamicImage, srgb: bool) -> (Image, Option<String>) {
    let color = decoded.color();
    // None of the formats has more than 16.
    let lost = (color.bytes_per_pixel() > color.channel_count())
        .then(|| format!("{name} has 16 bits a channel; 8 are kept: slopes from it are terraced"));
    let image = Image {
        name,
        width: decoded.width(),
        height: decoded.height(),
        rgba8: decoded.into_rgba8().into_raw().into(),
        srgb,
    };
    (image, lost)
}

/// Decodes, and turns a panic of the decoder into an error: the decoders are foreign code fed with foreign bytes, and
/// a picture must not end the program.
fn decode_guarded(bytes: &[u8], budget: &Budget) -> Result<DynamicImage, Refusal> {
    texgen::guarded(|| decode(bytes, budget))
        .unwrap_or_else(|_| Err("the decoder gave up on it".into()))
}

fn decode(bytes: &[u8], budget: &Budget) -> Result<DynamicImage, Refusal> {
    // By content, because names and MIME types are often wrong.
    let format = image::guess_format(bytes).ok();
    let format = match format {
        Some(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) => format,
        _ => return Err("is not a PNG, JPEG or WebP picture".into()),
    };
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(match format {
        ImageFormat::Png => PNG_ASIDE,
        _ => MAX_DECODED,
    });
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder()?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err("has no texels".into());
    }
    take(budget, u64::from(width) * u64::from(height) * 4)?;
    Ok(DynamicImage::from_decoder(decoder)?)
}

fn take(budget: &Budget, bytes: u64) -> Result<(), Refusal> {
    let taken = budget.take(bytes, 1);
    taken.map_err(|_| {
        let problem = "all pictures of the scene together take more than 4 GiB; make them smaller";
        Refusal::TooLarge(problem.to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(image: DynamicImage) -> Vec<u8> {
        let mut bytes = Vec::new();
        image
            .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
            .unwrap();
        bytes
    }

    #[test]
    fn sixteen_bits_and_grey_become_eight_bit_rgba() {
        let grey = image::ImageBuffer::from_pixel(2, 1, image::Luma([0x8080u16]));
        let decoded = decode(&png(DynamicImage::ImageLuma16(grey)), &Budget::new(100)).unwrap();
        let (image, lost) = kept("h.png".to_owned(), decoded, false);
        assert_eq!(*image.rgba8, [128, 128, 128, 255].repeat(2));
        let lost = lost.expect("eight bits of sixteen are a loss");
        assert!(lost.starts_with("h.png has 16 bits a channel"), "{lost}");
    }

    #[test]
    fn eight_bits_lose_nothing() {
        for image in [
            DynamicImage::new_luma8(2, 1),
            DynamicImage::new_luma_a8(2, 1),
            DynamicImage::new_rgb8(2, 1),
            DynamicImage::new_rgba8(2, 1),
        ] {
            let decoded = decode(&png(image), &Budget::new(100)).unwrap();
            assert_eq!(kept(String::new(), decoded, true).1, None);
        }
    }

    #[test]
    fn the_budget_and_damage_are_errors() {
        let bytes = png(DynamicImage::new_rgb8(8, 8));
        let refusal = decode(&bytes, &Budget::new(255)).unwrap_err();
        let message = refusal.into_fault();
        assert!(message.contains("4 GiB"), "{message}");
        for end in [0, 4, 8, 20, 40, bytes.len() - 20] {
            decode(&bytes[..end], &Budget::new(1 << 20)).unwrap_err();
        }
    }

    #[test]
    fn a_picture_that_is_too_large_is_no_damaged_one() {
        let wide = png(DynamicImage::new_luma8(MAX_SIDE + 1, 1));
        let refusal = decode(&wide, &Budget::new(u64::MAX)).unwrap_err();
        let said = refusal.of(Path::new("a.glb"), "wide.png").to_string();
        assert_eq!(
            said,
            "a.glb: wide.png: is larger than the 16384 texels a side that are read; make it smaller"
        );
        let refusal = decode(&[0; 40], &Budget::new(u64::MAX)).unwrap_err();
        let said = refusal.of(Path::new("a.glb"), "b.png").to_string();
        assert!(said.ends_with("saved as PNG, JPEG or WebP"), "{said}");
    }

    #[test]
    fn a_bomb_is_refused_by_its_header() {
        // A PNG header that claims 60000 x 60000 texels.
        let mut bytes = png(DynamicImage::new_rgb8(1, 1));
        bytes[16..20].copy_from_slice(&60_000u32.to_be_bytes());
        bytes[20..24].copy_from_slice(&60_000u32.to_be_bytes());
        decode(&bytes, &Budget::new(u64::MAX)).unwrap_err();
    }
}
