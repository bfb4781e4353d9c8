//! Picture files: PNG and JPEG to look at (8-bit sRGB, exposed) and EXR to work with (linear floats, as rendered).
//!
//! A file is written aside and renamed when it is complete, so that neither a full disk nor Ctrl-C leaves half a
//! picture or destroys an older one. Whether that will be possible is tried before rendering.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use engine::film::Part;
use exr::image::{Encoding, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::WritableImage;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use tempfile::NamedTempFile;
use thiserror::Error;

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

/// Finds out, before any work is done, whether `path` can be written later.
///
/// # Errors
/// Its folder is missing or takes no new files, or `path` is a folder.
pub(crate) fn check(path: &Path) -> Result<(), OutputError> {
    if path.is_dir() {
        return Err(OutputError::IsFolder {
            path: path.to_owned(),
        });
    }
    // The file made here is removed at once; what counts is that it could be made.
    aside(path).map(drop)
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

/// Writes the files of a render or a merge: its pictures, and its sums.
///
/// # Errors
/// What could not be written. The other files are written all the same: one full disk must not cost all.
pub(crate) fn write_all(outputs: &Outputs, part: &Part, exposure: f32) -> Result<(), Failure> {
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
            Ok(()) => console::print(&format!("wrote {}", path.display())),
            Err(error) => failed.push(error.to_string()),
        }
    }
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::Failed(failed.join("\n"))),
    }
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
    let refused = |reason| OutputError::Io {
        path: path.to_owned(),
        reason,
    };
    let file = aside(path)?;
    let mut writer = BufWriter::new(file.as_file());
    fill(&mut writer)
        .and_then(|()| writer.flush())
        .map_err(refused)?;
    drop(writer);
    file.persist(path).map_err(|error| refused(error.error))?;
    Ok(())
}

/// An empty file in the folder of `path`, gone when dropped. It must be the same folder: a rename does not cross
/// file systems.
fn aside(path: &Path) -> Result<NamedTempFile, OutputError> {
    let dir = match path.parent() {
        Some(dir) if dir != Path::new("") => dir,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".patina-");
    #[cfg(unix)]
    {
        // Temporary files are private by default; a result should be as readable as any other new file.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(dir).map_err(|reason| {
        if fs::metadata(dir).is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
            OutputError::NoFolder {
                path: path.to_owned(),
                dir: dir.to_owned(),
            }
        } else {
            OutputError::Io {
                path: path.to_owned(),
                reason,
            }
        }
    })
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

fn write_exr(writer: impl Write + io::Seek, picture: &Picture) -> io::Result<()> {
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
    image
        .write()
        .to_buffered(writer)
        .map_err(|error| match error {
            exr::error::Error::Io(error) => error,
            other => io::Error::other(other.to_string()),
        })
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
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = dir.path().join("x.png");
        fs::write(&path, "old").unwrap();
        let failed = write_aside(&path, |file| {
            file.write_all(b"half of it")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
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

    #[cfg(unix)]
    #[test]
    fn results_are_as_readable_as_other_new_files() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().expect("a temporary folder");
        let (ours, plain) = (dir.path().join("ours"), dir.path().join("plain"));
        write_aside(&ours, |_| Ok(())).unwrap();
        fs::write(&plain, "").unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
