//! Picture files: PNG and JPEG to look at (8-bit sRGB, exposed) and EXR to work with (linear floats, as rendered).
//!
//! A file is written aside and renamed when it is complete ([`engine::aside`]), so that neither a full disk nor Ctrl-C leaves
//! half a picture or destroys an older one. Whether that will be possible is tried before rendering.

mod identity;
mod salvage;

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use engine::aside::{self, Aside};
use engine::film::Part;
use exr::image::{Encoding, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{self, AttributeValue, Chromaticities, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::WritableImage;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use thiserror::Error;

pub(crate) use self::identity::refuse_overwriting;
use crate::console;
use crate::exit::Failure;
use crate::job::{Format, Output, Outputs};

/// A picture of linear Rec.709 radiance and how it came about.
#[derive(Debug)]
pub(crate) struct Picture {
    /// Pixels.
    pub(crate) width: u32,
    /// Pixels.
    pub(crate) height: u32,
    /// Row 0 on top; `width * height` pixels.
    pub(crate) rgb: Vec<[f32; 3]>,
    /// Named facts, written into EXR headers.
    pub(crate) facts: Vec<(&'static str, Fact)>,
}

/// A value of an EXR header.
#[derive(Debug, Clone)]
pub(crate) enum Fact {
    /// A whole number; what exceeds the format's 31 bits is clamped.
    Count(u64),
    /// A text; what the format can't hold (beyond Latin-1) becomes `?`.
    Text(String),
}

/// A file that cannot be written.
#[derive(Debug, Error)]
pub(crate) enum OutputError {
    /// The folder does not exist.
    #[error("cannot write {}: the folder {} does not exist; create it first", path.display(), dir.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// The folder it was to lie in.
        dir: PathBuf,
    },
    /// The name is taken by a folder.
    #[error("cannot write {}: it is a folder", path.display())]
    IsFolder {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("cannot write {}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system or the encoder said.
        reason: io::Error,
    },
}

impl OutputError {
    fn new(path: &Path, reason: io::Error) -> Self {
        let path = path.to_owned();
        let dir = aside::folder_of(&path);
        match reason.kind() == io::ErrorKind::NotFound && !dir.exists() {
            true => Self::NoFolder {
                dir: dir.to_owned(),
                path,
            },
            false => Self::Io { path, reason },
        }
    }
}

/// Finds out, before any work is done, whether `path` can be written later.
///
/// # Errors
/// Its folder is missing or takes no new files, its name is too long, or `path` is a folder.
pub(crate) fn check(path: &Path) -> Result<(), OutputError> {
    if path.is_dir() {
        return Err(OutputError::IsFolder {
            path: path.to_owned(),
        });
    }
    // The file made here is removed at once; what counts is that it could be made.
    let begun = Aside::begin(path).map(drop);
    begun.map_err(|reason| OutputError::new(path, reason))
}

/// As [`check`], for all results, and that none of them would replace a file that is read, or one of the others.
///
/// # Errors
/// The first that can't be written, or must not be.
pub(crate) fn check_all<'a>(
    written: impl IntoIterator<Item = &'a PathBuf> + Clone,
    read: &[PathBuf],
) -> Result<(), Failure> {
    refuse_overwriting(written.clone(), read)?;
    for path in written {
        check(path).map_err(Failure::because)?;
    }
    Ok(())
}

/// Writes `picture` to `output`; `exposure` in stops applies to PNG and JPEG.
///
/// # Errors
/// The file cannot be written; an older one is then untouched.
pub(crate) fn write(output: &Output, picture: &Picture, exposure: f32) -> Result<(), OutputError> {
    write_aside(&output.path, |file| match output.format {
        Format::Png => write_srgb(PngEncoder::new(file), picture, exposure),
        Format::Jpeg => {
            let encoder = JpegEncoder::new_with_quality(file, JPEG_QUALITY);
            write_srgb(encoder, picture, exposure)
        }
        Format::Exr => write_exr(file, picture),
    })
}

/// Writes 8-bit RGBA that is encoded as it is to be shown, row 0 on top, without its alpha. EXR files hold radiance: none is
/// written.
///
/// # Errors
/// As [`write()`].
pub(crate) fn write_shown(
    output: &Output,
    [width, height]: [u32; 2],
    rgba: &[u8],
) -> Result<(), OutputError> {
    let rgb: Vec<u8> = rgba
        .chunks_exact(4)
        .flat_map(|pixel| &pixel[..3])
        .copied()
        .collect();
    write_aside(&output.path, |file| match output.format {
        Format::Png => encode(PngEncoder::new(file), [width, height], &rgb),
        Format::Jpeg => {
            let encoder = JpegEncoder::new_with_quality(file, JPEG_QUALITY);
            encode(encoder, [width, height], &rgb)
        }
        Format::Exr => Err(io::Error::other("what is shown on a screen is no radiance")),
    })
}

/// Writes the files of a merge: its pictures, and its sums.
///
/// # Errors
/// What could not be written. The other files are written all the same: one full disk must not cost all.
pub(crate) fn write_all(outputs: &Outputs, part: &Part, exposure: f32) -> Result<(), Failure> {
    let failed = try_all(outputs, part, exposure);
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::Failed(text(&failed))),
    }
}

/// As [`write_all`], for what would have to be rendered again: where a file could not be written, the sums are kept elsewhere.
///
/// # Errors
/// As [`write_all`], with the place of the sums.
pub(crate) fn write_or_keep(outputs: &Outputs, part: &Part, exposure: f32) -> Result<(), Failure> {
    let failed = try_all(outputs, part, exposure);
    let lost: Vec<&Path> = failed.iter().map(|(path, _)| path.as_path()).collect();
    let Some(first) = lost.first() else {
        return Ok(());
    };
    let written = outputs
        .films
        .iter()
        .find(|film| !lost.contains(&film.as_path()));
    let kept = match written {
        Some(film) => Some(film.clone()),
        None => salvage::keep(part, first),
    };
    let hint = match &kept {
        Some(film) => format!(
            "the samples are in {}; what is missing is written by: {}",
            film.display(),
            salvage::command(film, &lost)
        ),
        None => "nor could the samples be kept anywhere else".to_owned(),
    };
    Err(Failure::Failed(format!("{}\n{hint}", text(&failed))))
}

/// Writes what can be written; what can't, with the reason.
fn try_all(outputs: &Outputs, part: &Part, exposure: f32) -> Vec<(PathBuf, OutputError)> {
    let picture = Picture {
        width: part.film.width,
        height: part.film.height,
        rgb: part.film.mean(),
        facts: facts(part),
    };
    let pictures = outputs
        .pictures
        .iter()
        .map(|output| (&output.path, write(output, &picture, exposure)));
    let films = outputs.films.iter().map(|path| {
        let written = write_aside(path, |file| part.write(file));
        (path, written)
    });
    let mut failed = Vec::new();
    for (path, outcome) in pictures.chain(films) {
        match outcome {
            Ok(()) => console::note(&format!("wrote {}", path.display())),
            Err(error) => failed.push((path.clone(), error)),
        }
    }
    failed
}

fn text(failed: &[(PathBuf, OutputError)]) -> String {
    let lines = failed.iter().map(|(_, error)| error.to_string());
    lines.collect::<Vec<_>>().join("\n")
}

/// How a picture came about.
fn facts(part: &Part) -> Vec<(&'static str, Fact)> {
    let origin = &part.origin;
    let setting = |name| part.setting(name).unwrap_or_default();
    let (lowest, _) = part.film.sample_bounds();
    let mut facts = vec![
        ("samplesPerPixel", Fact::Count(u64::from(lowest))),
        (
            "maxDepth",
            Fact::Count(setting("max-depth").parse().unwrap_or_default()),
        ),
        // Text, as a seed may exceed the format's signed integers.
        ("seed", Fact::Text(setting("seed").to_owned())),
        ("device", Fact::Text(origin.device.clone())),
        ("scene", Fact::Text(origin.scene.clone())),
    ];
    facts.extend(origin.look.clone().map(|look| ("look", Fact::Text(look))));
    facts
}

/// Creates or replaces the file at `path` with what `fill` writes, all of it or nothing.
///
/// # Errors
/// The system refuses, or `fill` fails.
pub(crate) fn write_aside(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), OutputError> {
    aside::replace(path, fill).map_err(|reason| OutputError::new(path, reason))
}

/// Of 100: artefacts are below the noise of a render.
const JPEG_QUALITY: u8 = 90;

/// A picture as a JPEG file in memory, brighter by `exposure` stops.
///
/// # Errors
/// It is too large for the format.
pub(crate) fn jpeg(picture: &Picture, exposure: f32) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY);
    write_srgb(encoder, picture, exposure)?;
    Ok(bytes)
}

fn write_srgb(encoder: impl ImageEncoder, picture: &Picture, exposure: f32) -> io::Result<()> {
    let gain = exposure.exp2();
    let bytes: Vec<u8> = picture
        .rgb
        .iter()
        .flatten()
        .map(|&value| srgb8(value * gain))
        .collect();
    encode(encoder, [picture.width, picture.height], &bytes)
}

fn encode(encoder: impl ImageEncoder, [width, height]: [u32; 2], rgb: &[u8]) -> io::Result<()> {
    encoder
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(io::Error::other)
}

/// A linear value in [0, 1] as an 8-bit sRGB code (IEC 61966-2-1); what lies outside is clamped, NaN is black.
fn srgb8(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    // `as` saturates and turns NaN into 0.
    (encoded * 255.0 + 0.5) as u8
}

fn write_exr(mut writer: impl Write + io::Seek, picture: &Picture) -> io::Result<()> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let mut attributes = LayerAttributes {
        software_name: Some(latin1(concat!("patina ", env!("CARGO_PKG_VERSION")))),
        ..LayerAttributes::default()
    };
    for (name, fact) in &picture.facts {
        let value = match fact {
            Fact::Count(count) => AttributeValue::I32(i32::try_from(*count).unwrap_or(i32::MAX)),
            Fact::Text(text) => AttributeValue::Text(latin1(text)),
        };
        attributes.other.insert(latin1(name), value);
    }
    let pixel = |Vec2(x, y): Vec2<usize>| {
        let [r, g, b] = picture.rgb[y * width + x];
        (r, g, b)
    };
    let mut image = Image::from_layer(Layer::new(
        (width, height),
        attributes,
        Encoding::SMALL_LOSSLESS,
        SpecificChannels::rgb(pixel),
    ));
    image.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    let refused = |error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    };
    image.write().to_buffered(&mut writer).map_err(refused)?;
    let headers = image.write().infer_meta_data();
    let attributes = sorted_attributes(&headers[0]).map_err(refused)?;
    // They begin behind the magic number and the version. Their order doesn't change how long they are.
    writer.seek(io::SeekFrom::Start(8))?;
    writer.write_all(&attributes)
}

/// The attributes of a header as they lie in a file, by name: the crate keeps ours in a hash map and writes them in another
/// order each time, but the same picture is to be the same file.
fn sorted_attributes(header: &Header) -> exr::error::Result<Vec<u8>> {
    let mut attributes: Vec<_> = header.all_named_attributes().collect();
    attributes.sort_by_key(|(name, _)| *name);
    let mut bytes = Vec::new();
    for (name, value) in &attributes {
        attribute::write(name, value, &mut bytes)?;
    }
    Ok(bytes)
}

fn latin1(text: &str) -> Text {
    let representable: String = text
        .chars()
        .map(|c| {
            if u8::try_from(u32::from(c)).is_ok() {
                c
            } else {
                '?'
            }
        })
        .collect();
    Text::new_or_none(representable).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn picture() -> Picture {
        Picture {
            width: 3,
            height: 2,
            rgb: vec![
                [0.0, 0.5, 1.0],
                [2.0, -1.0, f32::NAN],
                [0.25, 0.25, 0.25],
                [1.0e-3, 0.0, 0.0],
                [f32::INFINITY, 0.0, 0.0],
                [0.215_86, 0.0, 100.0],
            ],
            facts: vec![
                ("samplesPerPixel", Fact::Count(64)),
                ("device", Fact::Text("Gerät 世".into())),
            ],
        }
    }

    fn output(dir: &Path, name: &str, format: Format) -> Output {
        Output {
            path: dir.join(name),
            format,
        }
    }

    #[test]
    fn a_png_is_srgb_with_exposure() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let output = output(dir.path(), "x.png", Format::Png);
        write(&output, &picture(), 0.0).unwrap();
        let read = image::open(&output.path).unwrap().to_rgb8();
        assert_eq!(read.dimensions(), (3, 2));
        assert_eq!(read.get_pixel(0, 0).0, [0, 188, 255]);
        assert_eq!(read.get_pixel(1, 0).0, [255, 0, 0]);
        assert_eq!(read.get_pixel(2, 1).0, [128, 0, 255]);
        write(&output, &picture(), 1.0).unwrap();
        let brighter = image::open(&output.path).unwrap().to_rgb8();
        assert_eq!(brighter.get_pixel(2, 0).0, [188; 3]);
    }

    #[test]
    fn an_exr_keeps_every_bit_and_says_how_it_was_made() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let output = output(dir.path(), "x.exr", Format::Exr);
        write(&output, &picture(), 5.0).unwrap();
        let read = exr::prelude::read_first_flat_layer_from_file(&output.path).unwrap();
        let channels = &read.layer_data.channel_data.list;
        for (channel, name) in ["B", "G", "R"].into_iter().enumerate() {
            assert_eq!(channels[channel].name.to_string(), name);
            let values: Vec<f32> = channels[channel].sample_data.values_as_f32().collect();
            let expected = picture().rgb.into_iter().map(|rgb| rgb[2 - channel]);
            for (value, expected) in values.into_iter().zip(expected) {
                assert_eq!(value.to_bits(), expected.to_bits());
            }
        }
        let facts = &read.layer_data.attributes.other;
        assert_eq!(
            facts.get(&Text::from("samplesPerPixel")),
            Some(&AttributeValue::I32(64))
        );
        assert_eq!(
            facts.get(&Text::from("device")),
            Some(&AttributeValue::Text(latin1("Gerät ?")))
        );
    }

    #[test]
    fn the_same_picture_is_the_same_file() {
        let mut picture = picture();
        // Hash maps of a few entries come in the same order by chance.
        for name in ["maxDepth", "seed", "scene", "look", "a", "b", "c", "d"] {
            picture.facts.push((name, Fact::Text(name.to_owned())));
        }
        let bytes = || {
            let mut file = io::Cursor::new(Vec::new());
            write_exr(&mut file, &picture).expect("memory takes everything");
            file.into_inner()
        };
        let first = bytes();
        assert!((0..4).all(|_| bytes() == first));
        let read = exr::prelude::read_first_flat_layer_from_file;
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = dir.path().join("x.exr");
        fs::write(&path, first).unwrap();
        let attributes = read(&path).unwrap().layer_data.attributes;
        assert_eq!(attributes.other.len(), picture.facts.len());
    }

    #[test]
    fn trouble_is_found_before_rendering() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let missing = check(&dir.path().join("no/x.png")).unwrap_err();
        assert!(matches!(missing, OutputError::NoFolder { .. }), "{missing}");
        let folder = check(dir.path()).unwrap_err();
        assert!(matches!(folder, OutputError::IsFolder { .. }), "{folder}");
        assert!(check(&dir.path().join("x.png")).is_ok());
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
