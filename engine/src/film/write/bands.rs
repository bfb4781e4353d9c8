//! Pictures that are never in memory as a whole: their rows come in bands, from the top on, of which each is a film. The files are those
//! that one film of all of it would give.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use png::{BitDepth, ColorType, Compression, Encoder, Filter};
use scene::view::View;

use super::{Content, Form, Format, Metadata, exr, shown};
use crate::aside;
use crate::film::{Film, Layer, Layers};
use crate::view::ViewEncoder;

/// Bytes of a PNG's blocks.
const PNG_BLOCK: usize = 1 << 20;

/// What of a picture in bands goes to files: as [`Content`] has it, which see.
#[derive(Debug, Clone, Copy)]
pub struct Banded<'a> {
    /// Columns and rows of all bands together.
    pub size: [u32; 2],
    /// Those layers that EXR files hold.
    pub layers: &'a Layers,
    /// Whether the environment behind everything is left out.
    pub transparent: bool,
    /// How EXR files hold it.
    pub form: &'a Form,
    /// Of all bands.
    pub extents: &'a Extents,
}

impl<'a> Banded<'a> {
    /// What of one band goes to files.
    pub(super) fn content<'b>(&self, film: &'b Film) -> Content<'b>
    where
        'a: 'b,
    {
        content(film, self.layers, self.transparent, self.form)
    }
}

fn content<'a>(
    film: &'a Film,
    layers: &'a Layers,
    transparent: bool,
    form: &'a Form,
) -> Content<'a> {
    Content {
        film,
        layers,
        denoised: None,
        transparent,
        form,
    }
}

/// The largest number of each layer, which decides with how many bits an EXR file holds it: to be known before its first row is written.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Extents(BTreeMap<&'static str, f32>);

impl Extents {
    /// Adds what a band holds of these layers.
    pub fn add(&mut self, film: &Film, layers: &Layers, transparent: bool, form: &Form) {
        for (layer, largest) in exr::largest_numbers(&content(film, layers, transparent, form)) {
            let all = self.0.entry(layer).or_default();
            *all = all.max(largest);
        }
    }

    pub(super) fn of(&self, layer: &Layer) -> f32 {
        self.0.get(layer.name).copied().unwrap_or_default()
    }
}

/// As [`super::save`] of a picture whose bands come one after the other.
///
/// # Errors
/// What the system says; those of `bands`; fewer rows than there should be; a format that has to see the whole picture (JPEG). An older
/// file is then untouched.
pub fn save_bands(
    path: &Path,
    format: Format,
    banded: &Banded<'_>,
    bands: impl Iterator<Item = io::Result<Film>>,
    metadata: &Metadata,
    view: &View,
) -> io::Result<()> {
    aside::replace(path, |file| match format {
        Format::Exr => exr::write_bands(file, banded, bands, metadata),
        Format::Png => write_png(file, banded, bands, view),
        Format::Jpeg => Err(io::Error::other("a JPEG file is written as a whole")),
    })
}

/// Row by row; packed and filtered as the other PNG files are.
fn write_png(
    file: &mut BufWriter<&std::fs::File>,
    banded: &Banded<'_>,
    bands: impl Iterator<Item = io::Result<Film>>,
    view: &View,
) -> io::Result<()> {
    let [width, height] = banded.size;
    let view = ViewEncoder::new(view);
    let mut encoder = Encoder::new(file, width, height);
    encoder.set_color(match banded.transparent {
        true => ColorType::Rgba,
        false => ColorType::Rgb,
    });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    let mut stream = writer
        .stream_writer_with_size(PNG_BLOCK)
        .map_err(io::Error::other)?;
    for film in bands {
        let shown = shown(&banded.content(&film?), &view, banded.transparent);
        stream.write_all(&shown.bytes)?;
    }
    stream.finish().map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::write::{self, Compression as Packing, TRANSPARENCY};

    /// A film of rows of a picture whose numbers depend on their place in it.
    fn band(layers: &Layers, rows: std::ops::Range<u32>) -> Film {
        const WIDTH: u32 = 21;
        let mut film = Film::with_layers(WIDTH, rows.len() as u32, layers.clone());
        for pixel in 0..film.pixels() {
            let at = pixel + (rows.start * WIDTH) as usize;
            let value = 0.5 + 0.4 * (0.1 * at as f32).sin();
            film.add_sample(pixel, [value, 1e-3 * value, 0.25]);
            film.add_surface(pixel, 0, |layer| match layer.name {
                // Bright in the last rows alone, so that all need 32 bits.
                "emission" => [if at > 900 { 1e6 } else { 0.0 }; 3],
                "alpha" => [(at % 3) as f32 * 0.5, 0.0, 0.0],
                _ => [value, 0.0, 1.0],
            });
        }
        film
    }

    #[test]
    fn bands_give_the_files_of_the_whole() {
        let named = |names: &[&str]| Layers::named(names.iter().copied()).expect("known");
        let all = named(&["depth", "emission", "crypto_object"]);
        let transparent = named(&[&TRANSPARENCY[..], &["depth"]].concat());
        let dir = tempfile::tempdir().expect("a temporary folder");
        let files = ["whole", "bands"].map(|name| dir.path().join(name));
        let metadata = Metadata::default();
        let view = View::exposed(0.0);
        for (gathered, shown) in [
            (&Layers::default(), &Layers::default()),
            (&all, &all),
            (&transparent, &Layers::default()),
            (&transparent, &transparent),
        ] {
            let is_transparent = gathered == &transparent;
            for compression in [Packing::Zip, Packing::None, Packing::Piz, Packing::Zips] {
                let form = Form::new(compression, &[""; 0], &[""; 0]).expect("a form");
                let whole = band(gathered, 0..75);
                // Shorter and longer than the blocks of the file, and across their borders.
                let bands = [0..8, 8..24, 24..25, 25..72, 72..75].map(|rows| band(gathered, rows));
                let mut extents = Extents::default();
                for film in &bands {
                    extents.add(film, shown, is_transparent, &form);
                }
                let banded = Banded {
                    size: [whole.width, whole.height],
                    layers: shown,
                    transparent: is_transparent,
                    form: &form,
                    extents: &extents,
                };
                let content = content(&whole, shown, is_transparent, &form);
                for format in [Format::Exr, Format::Png] {
                    write::save(&files[0], format, content, &metadata, &view).expect("written");
                    let bands = bands.iter().cloned().map(Ok);
                    save_bands(&files[1], format, &banded, bands, &metadata, &view)
                        .expect("written");
                    if format == Format::Exr {
                        let [a, b] = files
                            .each_ref()
                            .map(|file| std::fs::read(file).expect("read"));
                        assert!(a == b, "{compression:?} of {shown:?}");
                        continue;
                    }
                    let [a, b] = files.each_ref().map(|file| {
                        image::load_from_memory(&std::fs::read(file).expect("read")).expect("PNG")
                    });
                    assert_eq!(a, b);
                }
            }
        }
    }

    #[test]
    fn what_breaks_off_is_no_file() {
        let layers = Layers::default();
        let dir = tempfile::tempdir().expect("a temporary folder");
        let path = dir.path().join("picture");
        let mut extents = Extents::default();
        let first = band(&layers, 0..8);
        extents.add(&first, &layers, false, &Form::USUAL);
        let banded = Banded {
            size: [first.width, 16],
            layers: &layers,
            transparent: false,
            form: &Form::USUAL,
            extents: &extents,
        };
        let view = View::exposed(0.0);
        for format in [Format::Exr, Format::Png] {
            for rest in [None, Some(Err(io::Error::other("gone")))] {
                let bands = [Some(Ok(first.clone())), rest].into_iter().flatten();
                let written =
                    save_bands(&path, format, &banded, bands, &Metadata::default(), &view);
                assert!(written.is_err(), "{format:?}");
            }
        }
        assert_eq!(dir.path().read_dir().expect("a folder").count(), 0);
    }
}
