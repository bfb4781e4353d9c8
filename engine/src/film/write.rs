//! Films as files: PNG and JPEG to look at (8-bit sRGB, as a view shows them), EXR to work with (linear floats, as rendered, every
//! layer). Every picture of a film is written here, whoever asks for it.

mod bands;
mod exr;
mod form;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Seek, Write};
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use scene::view::View;

use super::{Crop, Film, Layers, Origin};
use crate::aside;
use crate::view::ViewEncoder;

pub use bands::{Banded, Extents, save_bands};
pub use form::{ALL_LAYERS, Compression, Form, FormError};

/// Of 100: artefacts are below the noise of a render.
const JPEG_QUALITY: u8 = 90;

/// Picture formats, chosen by a file's ending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB, as a view shows it.
    Png,
    /// The same, compressed with loss: a noisy picture takes a tenth of the room.
    Jpeg,
    /// Linear Rec.709 floats, as rendered.
    Exr,
}

impl Format {
    /// That of a file by its ending, in upper or lower case.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_ascii_lowercase();
        match ending.to_str()? {
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }
}

/// Layers that a film needs for [`Content::transparent`] files.
pub const TRANSPARENCY: [&str; 2] = ["environment", "alpha"];

/// What of a film goes to files. Of a film as it is: all of its layers.
#[derive(Debug, Clone, Copy)]
pub struct Content<'a> {
    /// What was gathered.
    pub film: &'a Film,
    /// Those of its layers that EXR files hold.
    pub layers: &'a Layers,
    /// The picture without its noise, pixel by pixel, where there is one: then it is the picture, and EXR files keep the noisy one
    /// as a layer of its own.
    pub denoised: Option<&'a [[f32; 3]]>,
    /// Whether the environment behind everything is left out, and files tell how much of each pixel is covered (but for JPEG, which
    /// can't). Of a film that has gathered [`TRANSPARENCY`].
    pub transparent: bool,
    /// How EXR files hold it.
    pub form: &'a Form,
}

/// How EXR files are written where nothing is said.
static USUAL: Form = Form::USUAL;

impl<'a> From<&'a Film> for Content<'a> {
    fn from(film: &'a Film) -> Self {
        Self {
            film,
            layers: film.layers(),
            denoised: None,
            transparent: false,
            form: &USUAL,
        }
    }
}

impl Content<'_> {
    /// What files without layers show; where it is transparent, as much of it as there is.
    pub(crate) fn picture(&self) -> Cow<'_, [[f32; 3]]> {
        match self.denoised {
            Some(denoised) => denoised.into(),
            None => self.rendered().into(),
        }
    }

    /// The same with its noise.
    fn rendered(&self) -> Vec<[f32; 3]> {
        let foreground = self.transparent.then(|| self.film.foreground());
        foreground.flatten().unwrap_or_else(|| self.film.mean())
    }

    /// How much of each pixel is covered, where that is wanted.
    pub(crate) fn alpha(&self) -> Option<Vec<f32>> {
        self.transparent.then(|| self.film.alpha()).flatten()
    }
}

/// Colours as they would be where a pixel is covered as a whole.
fn unassociated(picture: &[[f32; 3]], alpha: &[f32]) -> Vec<[f32; 3]> {
    let pixels = picture.iter().zip(alpha);
    pixels
        .map(|(rgb, &alpha)| match alpha > 0.0 {
            true => rgb.map(|x| x / alpha),
            false => [0.0; 3],
        })
        .collect()
}

/// How a picture came about, as named facts: they go into the headers of EXR files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Metadata {
    facts: Vec<(&'static str, Fact)>,
    /// Of what layers of ids show, by layer.
    names: BTreeMap<String, Vec<String>>,
    /// Where the film lies in a larger picture.
    crop: Option<Crop>,
}

/// Settings that headers have by the names of the command line, in the order in which they are looked at.
const TOLD: [(&str, &str); 12] = [
    ("size", "patina:size"),
    ("camera", "patina:camera"),
    ("filter", "patina:filter"),
    ("clamp", "patina:clamp"),
    ("method", "patina:method"),
    ("estimator", "patina:estimator"),
    ("roulette", "patina:roulette"),
    ("energy-compensation", "patina:energyCompensation"),
    ("sampler", "patina:sampler"),
    ("time", "patina:time"),
    ("frame", "patina:frame"),
    ("motion", "patina:motion"),
];

/// How the names of [`TOLD`] begin.
const OWN_PREFIX: &str = "patina:";

/// What else headers say by themselves, so that no attribute from elsewhere may be called so.
const OWN: [&str; 7] = [
    "samplesPerPixel",
    "maxDepth",
    "seed",
    "device",
    "scene",
    "look",
    "denoiser",
];

/// A value of an EXR header.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Fact {
    /// A whole number; what exceeds the format's 31 bits is clamped.
    Count(u64),
    /// A text; what the format can't hold (beyond Latin-1) becomes `?`.
    Text(String),
}

impl Metadata {
    /// Of a film and where it came from.
    pub fn new(film: &Film, origin: &Origin) -> Self {
        let (lowest, _) = film.sample_bounds();
        Self::of([film.width, film.height], lowest, origin)
    }

    /// Of a picture of so many columns and rows, the fewest samples of its pixels, and where it came from.
    pub fn of([width, height]: [u32; 2], samples: u32, origin: &Origin) -> Self {
        let setting = |name| origin.setting(name).unwrap_or_default();
        let mut facts = vec![
            ("samplesPerPixel", Fact::Count(u64::from(samples))),
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
        let told = TOLD.into_iter().filter_map(|(setting, name)| {
            let value = origin.setting(setting)?;
            Some((name, Fact::Text(value.to_owned())))
        });
        facts.extend(told);
        let crop = origin
            .setting("crop")
            .and_then(|crop| Crop::read(crop, setting("size"), width, height));
        Self {
            facts,
            names: origin.names.clone(),
            crop,
        }
    }

    /// With the name of what has taken the noise out of it.
    #[must_use]
    pub fn denoised_by(mut self, denoiser: &str) -> Self {
        let denoiser = Fact::Text(denoiser.to_owned());
        self.facts.push(("denoiser", denoiser));
        self
    }
}

/// Writes a film: the picture as `view` shows it as PNG or JPEG, or its layers and how it came about as EXR, as rendered.
///
/// # Errors
/// What the system says, or a picture that is too large for the format.
pub fn write<'a>(
    file: impl Write + Seek,
    format: Format,
    content: impl Into<Content<'a>>,
    metadata: &Metadata,
    view: &View,
) -> io::Result<()> {
    let content = content.into();
    match format {
        Format::Exr => exr::write(file, &content, metadata),
        Format::Png | Format::Jpeg => {
            let with_alpha = content.transparent && format == Format::Png;
            let shown = shown(&content, &ViewEncoder::new(view), with_alpha);
            let size = [content.film.width, content.film.height];
            encode(file, format, size, &shown)
        }
    }
}

/// Bytes of the picture as it is shown: red, green and blue, and how much of a pixel is covered where that is wanted and known.
struct Shown {
    bytes: Vec<u8>,
    has_alpha: bool,
}

fn shown(content: &Content<'_>, encoder: &ViewEncoder, with_alpha: bool) -> Shown {
    let picture = content.picture();
    let Some(alpha) = content.alpha().filter(|_| with_alpha) else {
        return Shown {
            bytes: encoder.encode8(&picture),
            has_alpha: false,
        };
    };
    let shown = encoder.encode8(&unassociated(&picture, &alpha));
    let covered = |alpha: &f32| (alpha * 255.0 + 0.5) as u8;
    let pixels = shown.chunks_exact(3).zip(alpha.iter().map(covered));
    let bytes = pixels.flat_map(|(rgb, alpha)| [rgb[0], rgb[1], rgb[2], alpha]);
    Shown {
        bytes: bytes.collect(),
        has_alpha: true,
    }
}

/// As [`write()`] to a file that is the old one or the new one, never half of either: see [`aside`].
///
/// # Errors
/// As [`write()`]; an older file is then untouched.
pub fn save<'a>(
    path: &Path,
    format: Format,
    content: impl Into<Content<'a>>,
    metadata: &Metadata,
    view: &View,
) -> io::Result<()> {
    aside::replace(path, |file| write(file, format, content, metadata, view))
}

/// Saves 8-bit RGBA that is encoded as it is to be shown, row 0 on top, without its alpha. EXR files hold radiance: none is
/// written.
///
/// # Errors
/// As [`save`].
pub fn save_shown(path: &Path, format: Format, size: [u32; 2], rgba: &[u8]) -> io::Result<()> {
    let pixels = rgba.chunks_exact(4);
    let rgb = Shown {
        bytes: pixels.flat_map(|pixel| &pixel[..3]).copied().collect(),
        has_alpha: false,
    };
    aside::replace(path, |file| encode(file, format, size, &rgb))
}

/// Saves 8-bit RGBA of a texture, row 0 on top, as it is: with its alpha where it has one and the format does, too, which is told.
///
/// # Errors
/// As [`save_shown`].
pub fn save_texture(path: &Path, format: Format, size: [u32; 2], rgba: &[u8]) -> io::Result<bool> {
    let is_opaque = rgba.chunks_exact(4).all(|texel| texel[3] == u8::MAX);
    if is_opaque || format != Format::Png {
        return save_shown(path, format, size, rgba).map(|()| is_opaque);
    }
    let shown = Shown {
        bytes: rgba.to_vec(),
        has_alpha: true,
    };
    aside::replace(path, |file| encode(file, format, size, &shown))?;
    Ok(true)
}

/// Linear Rec.709 radiance, row 0 on top, as a JPEG file in memory, as `view` shows it.
///
/// # Errors
/// It is too large for the format.
pub fn jpeg(size: [u32; 2], rgb: &[[f32; 3]], view: &View) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let shown = Shown {
        bytes: ViewEncoder::new(view).encode8(rgb),
        has_alpha: false,
    };
    encode(&mut bytes, Format::Jpeg, size, &shown)?;
    Ok(bytes)
}

fn encode(
    file: impl Write,
    format: Format,
    [width, height]: [u32; 2],
    shown: &Shown,
) -> io::Result<()> {
    let color = match shown.has_alpha {
        true => ExtendedColorType::Rgba8,
        false => ExtendedColorType::Rgb8,
    };
    let bytes = &shown.bytes;
    let encoded = match format {
        Format::Png => PngEncoder::new(file).write_image(bytes, width, height, color),
        Format::Jpeg => JpegEncoder::new_with_quality(file, JPEG_QUALITY)
            .write_image(bytes, width, height, color),
        Format::Exr => {
            let what = "what is shown on a screen is no radiance";
            return Err(io::Error::other(what));
        }
    };
    encoded.map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_png_is_srgb_with_exposure() {
        let mut film = Film::new(3, 2);
        let samples = [
            [0.0, 0.5, 1.0],
            [2.0, -1.0, 0.0],
            [0.25; 3],
            [1.0e-3, 0.0, 0.0],
            [1.0e30, 0.0, 0.0],
            [0.215_86, 0.0, 100.0],
        ];
        for (pixel, sample) in samples.into_iter().enumerate() {
            film.add_sample(pixel, sample);
        }
        let read = |exposure| {
            let mut file = io::Cursor::new(Vec::new());
            let metadata = Metadata::default();
            write(
                &mut file,
                Format::Png,
                &film,
                &metadata,
                &View::exposed(exposure),
            )
            .expect("written");
            let picture = image::load_from_memory(&file.into_inner()).expect("a picture");
            picture.to_rgb8()
        };
        let picture = read(0.0);
        assert_eq!(picture.dimensions(), (3, 2));
        assert_eq!(picture.get_pixel(0, 0).0, [0, 188, 255]);
        assert_eq!(picture.get_pixel(1, 0).0, [255, 0, 0]);
        assert_eq!(picture.get_pixel(2, 1).0, [128, 0, 255]);
        assert_eq!(read(1.0).get_pixel(2, 0).0, [188; 3]);
    }

    #[test]
    fn what_headers_say_by_themselves_has_names_of_their_own() {
        let settings = TOLD.map(|(setting, _)| (setting.to_owned(), "1".to_owned()));
        let look = Some(Path::new("a.look.toml"));
        let origin = Origin::new("", Path::new(""), look, settings.into());
        let metadata = Metadata::of([1, 1], 1, &origin).denoised_by("x");
        assert_eq!(metadata.facts.len(), OWN.len() + TOLD.len());
        for (name, _) in &metadata.facts {
            assert!(OWN.contains(name) || name.starts_with(OWN_PREFIX), "{name}");
            assert!(Form::USUAL.with_fact(name, "y").is_err(), "{name}");
        }
    }

    #[test]
    fn headers_say_how_light_was_found() {
        let names = ["method", "roulette", "energy-compensation"];
        let settings = names.map(|name| (name.to_owned(), "x".to_owned()));
        let origin = Origin::new("", Path::new(""), None, settings.into());
        let metadata = Metadata::of([1, 1], 1, &origin);
        for name in ["method", "roulette", "energyCompensation"] {
            let name = format!("{OWN_PREFIX}{name}");
            let said = metadata.facts.iter().find(|(fact, _)| *fact == name);
            assert!(said.is_some(), "{name}");
        }
    }

    #[test]
    fn formats_follow_the_ending_in_any_case() {
        for (name, format) in [
            ("x.PNG", Some(Format::Png)),
            ("a/y.jpeg", Some(Format::Jpeg)),
            ("y.exr", Some(Format::Exr)),
            ("x.gif", None),
            (".png", None),
        ] {
            assert_eq!(Format::of(Path::new(name)), format, "{name}");
        }
    }
}
