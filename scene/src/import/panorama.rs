//! Decodes environment pictures to linear floats: OpenEXR, Radiance HDR, and what the `image` crate reads otherwise.
//!
//! Sizes are checked before a texel is allocated: headers may claim anything.

use super::error::Fault;
use super::pictures::PNG_ASIDE;
use crate::FloatImage;
use ::exr::meta::header::Header;
use exr::prelude as exr;
use exr::{ReadChannels as _, ReadLayers as _, ReadSpecificChannel as _};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

/// What OpenEXR files begin with.
const EXR: [u8; 4] = [0x76, 0x2F, 0x31, 0x01];
/// Longest side, texels.
const MAX_SIDE: usize = 32768;
/// Texels of an environment; 16384 x 8192, 1.5 GiB in memory.
const MAX_TEXELS: u64 = 1 << 27;
/// No file that is whole has more texels a byte: a PNG of one bit a texel comes nearest, with half as many. WebP may, but only of
/// one colour throughout.
const TEXELS_PER_BYTE: u64 = 1 << 14;
/// A display window may have this many texels, or some times as many as the data window.
const FREE_TEXELS: u64 = 1 << 24;
const MARGIN: u64 = 16;

/// Decodes a picture; also what the user should know about it.
pub(super) fn decode(bytes: Vec<u8>) -> Result<(FloatImage, Vec<String>), Fault> {
    if bytes.starts_with(&EXR) {
        return decode_exr(&bytes);
    }
    let picture = if bytes.starts_with(b"#?") {
        picture(radiance(&bytes)?)?
    } else {
        let mut reader = ImageReader::new(Cursor::new(&bytes))
            .with_guessed_format()
            .map_err(|error| error.to_string())?;
        if reader.format().is_none() {
            return Err("is not a picture that can be read".into());
        }
        let mut limits = Limits::no_limits();
        limits.max_image_width = Some(MAX_SIDE as u32);
        limits.max_image_height = Some(MAX_SIDE as u32);
        if reader.format() == Some(ImageFormat::Png) {
            limits.max_alloc = Some(PNG_ASIDE);
        }
        reader.limits(limits);
        let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
        let (width, height) = decoder.dimensions();
        let texels = u64::from(width) * u64::from(height);
        if texels > FREE_TEXELS + TEXELS_PER_BYTE * bytes.len() as u64 {
            return Err(format!(
                "claims {width} x {height} texels, which so small a file can't hold"
            ));
        }
        picture(decoder)?
    };
    drop(bytes);
    let is_float = matches!(
        picture,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    );
    let (width, height) = (picture.width(), picture.height());
    let mut rgb: Vec<[f32; 3]> = bytemuck::cast_vec(picture.into_rgb32f().into_raw());
    if !is_float {
        rgb.iter_mut()
            .flatten()
            .for_each(|value| *value = srgb_to_linear(*value));
    }
    Ok((FloatImage { width, height, rgb }, Vec::new()))
}

fn radiance(bytes: &[u8]) -> Result<HdrDecoder<impl Read>, Fault> {
    // The program's name in the first line may be any; older files have "RGBE", the decoder knows one.
    let line = bytes.iter().position(|&b| b == b'\n');
    let rest = line.map_or(&[][..], |end| &bytes[end..]);
    let reader = (&b"#?RADIANCE"[..]).chain(rest);
    HdrDecoder::new(reader).map_err(|error| error.to_string())
}

/// The columns and rows of a picture, by the first bytes of its file; `None` where these don't tell, or tell of none that is read.
pub(super) fn size(start: &[u8]) -> Option<[u32; 2]> {
    let (width, height) = if start.starts_with(&EXR) {
        let meta = exr::MetaData::read_from_buffered(Cursor::new(start), false).ok()?;
        let mut headers = (0..).zip(&meta.headers).filter(|(_, header)| !header.deep);
        let shown = headers.find(|(number, header)| !layers(*number, header).is_empty());
        let size = Frame::of(shown?.1).ok()?.size;
        (size.0 as u32, size.1 as u32)
    } else if start.starts_with(b"#?") {
        radiance(start).ok()?.dimensions()
    } else {
        let reader = ImageReader::new(Cursor::new(start)).with_guessed_format();
        reader.ok()?.into_dimensions().ok()?
    };
    check_size(width as usize, height as usize).ok()?;
    Some([width, height])
}

fn picture(decoder: impl ImageDecoder) -> Result<DynamicImage, Fault> {
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize)?;
    DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())
}

/// The channels of a layer that are shown.
enum Shown {
    Color([exr::Text; 3]),
    Grey(exr::Text),
}

/// One layer in the file.
struct Layer {
    /// For people: its name; empty where it has none.
    name: String,
    header: usize,
    shown: Shown,
}

fn decode_exr(bytes: &[u8]) -> Result<(FloatImage, Vec<String>), Fault> {
    let message = |error: exr::Error| error.to_string();
    let meta = exr::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(message)?;
    // Before any texel is allocated: all sizes the headers claim, against limits and against the bytes of the file.
    for header in &meta.headers {
        check_size(header.layer_size.0, header.layer_size.1)?;
        if header.chunk_count > bytes.len() / 8 {
            return Err("claims more blocks than the file has bytes for".into());
        }
    }
    let layers: Vec<Layer> = (meta.headers.iter().enumerate())
        .filter(|(_, header)| !header.deep)
        .flat_map(|(number, header)| layers(number, header))
        .collect();
    let Some(layer) = layers.first() else {
        return Err(
            "has no layer with the channels R, G and B, or Y, and more than one channel".into(),
        );
    };
    let mut notes = Vec::new();
    if layers.len() > 1 {
        let names: Vec<String> = (layers.iter().take(8))
            .map(|layer| match layer.name.as_str() {
                "" => "one without a name".to_owned(),
                name => format!("\"{name}\""),
            })
            .collect();
        notes.push(format!(
            "it has {} layers ({}); the first one is shown",
            layers.len(),
            names.join(", ")
        ));
    }
    let frame = Frame::of(&meta.headers[layer.header])?;
    // On this thread, where a panic of the decoder can be caught: on one of rayon's it would end the program.
    let picture = match &layer.shown {
        Shown::Color([r, g, b]) => {
            exr::read()
                .no_deep_data()
                .largest_resolution_level()
                .specific_channels()
                .required(r.clone())
                .required(g.clone())
                .required(b.clone())
                .collect_pixels(
                    move |_, _| frame.blank(),
                    move |image: &mut FloatImage, at, (r, g, b): (f32, f32, f32)| {
                        frame.set(image, at, [r, g, b]);
                    },
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .map_err(message)?
                .layer_data
                .channel_data
                .pixels
        }
        Shown::Grey(y) => {
            exr::read()
                .no_deep_data()
                .largest_resolution_level()
                .specific_channels()
                .required(y.clone())
                .collect_pixels(
                    move |_, _| frame.blank(),
                    move |image: &mut FloatImage, at, (y,): (f32,)| frame.set(image, at, [y; 3]),
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(Cursor::new(bytes))
                .map_err(message)?
                .layer_data
                .channel_data
                .pixels
        }
    };
    Ok((picture, notes))
}

/// The layers of a part that can be shown: channels without a prefix first, then each `PREFIX.` in alphabetical
/// order, which is that of the file. A part with a single channel is grey, whatever that is called.
fn layers(number: usize, header: &Header) -> Vec<Layer> {
    let part = header.own_attributes.layer_name.as_ref();
    let part = part.map(ToString::to_string).unwrap_or_default();
    let channels = &header.channels.list;
    if let [only] = channels.as_slice() {
        return vec![Layer {
            name: part,
            header: number,
            shown: Shown::Grey(only.name.clone()),
        }];
    }
    // R, G, B and Y of each prefix; the empty one sorts first.
    let mut groups: BTreeMap<String, [Option<exr::Text>; 4]> = BTreeMap::new();
    for channel in channels {
        let name = channel.name.to_string();
        let (prefix, last) = name.rsplit_once('.').unwrap_or(("", &name));
        let place = match last.to_ascii_lowercase().as_str() {
            "r" | "red" => 0,
            "g" | "green" => 1,
            "b" | "blue" => 2,
            "y" => 3,
            _ => continue,
        };
        groups.entry(prefix.to_owned()).or_default()[place] = Some(channel.name.clone());
    }
    let layer = |(prefix, group): (String, [Option<exr::Text>; 4])| {
        let shown = match group {
            [Some(r), Some(g), Some(b), _] => Shown::Color([r, g, b]),
            [.., Some(y)] => Shown::Grey(y),
            _ => return None,
        };
        let name = match (part.as_str(), prefix) {
            ("", prefix) => prefix,
            (part, prefix) if prefix.is_empty() => part.to_owned(),
            (part, prefix) => format!("{part}, {prefix}"),
        };
        Some(Layer {
            name,
            header: number,
            shown,
        })
    };
    groups.into_iter().filter_map(layer).collect()
}

/// Where a part's data lies in the picture that is displayed: what is outside of the data is black, and what is
/// outside of the display is not shown (OpenEXR, "Display window and data window").
#[derive(Clone, Copy)]
struct Frame {
    size: exr::Vec2<usize>,
    /// Of the first texel of the data.
    start: (i64, i64),
}

impl Frame {
    fn of(header: &Header) -> Result<Self, Fault> {
        let display = header.shared_attributes.display_window;
        let data = header.own_attributes.layer_position;
        let size = display.size;
        check_size(size.0, size.1)?;
        let texels = |size: exr::Vec2<usize>| size.0 as u64 * size.1 as u64;
        if texels(size) > FREE_TEXELS.max(MARGIN * texels(header.layer_size)) {
            return Err(format!(
                "has a display window of {} x {} texels, of which only {} x {} are there",
                size.0, size.1, header.layer_size.0, header.layer_size.1
            ));
        }
        let start = (
            i64::from(data.0) - i64::from(display.position.0),
            i64::from(data.1) - i64::from(display.position.1),
        );
        let meets =
            |start: i64, data: usize, size: usize| start < size as i64 && start + data as i64 > 0;
        if !meets(start.0, header.layer_size.0, size.0)
            || !meets(start.1, header.layer_size.1, size.1)
        {
            return Err("has its data window outside of its display window: all is black".into());
        }
        Ok(Self { size, start })
    }

    fn blank(&self) -> FloatImage {
        FloatImage {
            width: self.size.0 as u32,
            height: self.size.1 as u32,
            rgb: vec![[0.0; 3]; self.size.0 * self.size.1],
        }
    }

    fn set(&self, image: &mut FloatImage, at: exr::Vec2<usize>, rgb: [f32; 3]) {
        let (x, y) = (at.0 as i64 + self.start.0, at.1 as i64 + self.start.1);
        if (0..self.size.0 as i64).contains(&x) && (0..self.size.1 as i64).contains(&y) {
            image.rgb[y as usize * self.size.0 + x as usize] = rgb;
        }
    }
}

/// What helps where a picture is too large, whatever its format.
pub(super) const SCALE_IT_DOWN: &str = "scale it down";

fn check_size(width: usize, height: usize) -> Result<(), Fault> {
    let texels = (width as u64).saturating_mul(height as u64);
    if width == 0 || height == 0 {
        return Err("has no texels".into());
    }
    if width > MAX_SIDE || height > MAX_SIDE || texels > MAX_TEXELS {
        return Err(format!(
            "claims {width} x {height} texels; at most 2^27 are read, as 16384 x 8192 has, and no side longer than {MAX_SIDE}; {SCALE_IT_DOWN}"
        ));
    }
    Ok(())
}

fn srgb_to_linear(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::prelude::WritableImage as _;

    /// A file of one part, whose channel number `c` has `10 c + x` in column x.
    fn file(
        names: &[&str],
        size: (usize, usize),
        place: (i32, i32),
        display: Option<(usize, usize)>,
    ) -> Vec<u8> {
        let channels = names.iter().enumerate().map(|(number, &name)| {
            let value = |at| (10 * number + at % size.0) as f32;
            let samples = (0..size.0 * size.1).map(value).collect();
            exr::AnyChannel::new(name, exr::FlatSamples::F32(samples))
        });
        let mut layer = exr::Layer::new(
            size,
            exr::LayerAttributes::default(),
            exr::Encoding::UNCOMPRESSED,
            exr::AnyChannels::sort(channels.collect()),
        );
        layer.attributes.layer_position = place.into();
        let mut image = exr::Image::from_layer(layer);
        if let Some(size) = display {
            image.attributes.display_window = exr::IntegerBounds::from_dimensions(size);
        }
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn first(names: &[&str]) -> Result<[f32; 3], Fault> {
        decode(file(names, (2, 2), (0, 0), None)).map(|(image, _)| image.rgb[0])
    }

    #[test]
    fn layers_and_grey_pictures_are_found_by_their_channels() {
        // Alphabetical as the format wants it; the values tell which channels were taken.
        assert_eq!(first(&["B", "G", "R"]).unwrap(), [20.0, 10.0, 0.0]);
        assert_eq!(first(&["A", "Y"]).unwrap(), [10.0; 3]);
        assert_eq!(first(&["height"]).unwrap(), [0.0; 3]);
        assert_eq!(
            first(&["Z", "beauty.B", "beauty.G", "beauty.R"]).unwrap(),
            [30.0, 20.0, 10.0]
        );
        // Channels without a prefix come first wherever they stand.
        assert_eq!(
            first(&["B", "G", "R", "a.B", "a.G", "a.R"]).unwrap(),
            [20.0, 10.0, 0.0]
        );
        assert_eq!(
            first(&["a.blue", "a.green", "a.red"]).unwrap(),
            [20.0, 10.0, 0.0]
        );
        let message = first(&["depth.Z", "normal.X"]).unwrap_err();
        assert!(message.contains("R, G and B"), "{message}");
        let two = file(&["a.B", "a.G", "a.R", "b.Y"], (2, 2), (0, 0), None);
        let (_, notes) = decode(two).unwrap();
        assert!(notes[0].contains("\"a\", \"b\""), "{notes:?}");
    }

    #[test]
    fn the_size_is_known_by_the_first_bytes() {
        let exr = file(&["Y"], (40, 30), (0, 0), Some((60, 50)));
        assert_eq!(size(&exr[..exr.len() / 4]), Some([60, 50]));
        let head = |size: &str| format!("#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n");
        let of_hdr = |text: &str| size(head(text).as_bytes());
        assert_eq!(of_hdr("-Y 8192 +X 16384"), Some([16384, 8192]));
        // None that is read: what is wrong with it is told where it would be.
        assert_eq!(of_hdr("-Y 40000 +X 2"), None);
        let mut png = Cursor::new(Vec::new());
        let grey = DynamicImage::new_luma8(300, 200);
        grey.write_to(&mut png, ImageFormat::Png).unwrap();
        assert_eq!(size(&png.into_inner()[..64]), Some([300, 200]));
        for nothing in [&b""[..], b"#?", &exr[..20]] {
            assert_eq!(size(nothing), None);
        }
    }

    #[test]
    fn the_display_window_is_the_picture() {
        let columns = |place, display| {
            let (image, _) = decode(file(&["Y"], (2, 1), place, Some(display))).unwrap();
            assert_eq!((image.width as usize, image.height as usize), display);
            image.rgb.iter().map(|rgb| rgb[0]).collect::<Vec<f32>>()
        };
        // Data 0, 1 in the second row of a larger picture, then of a smaller one, of which it leaves the left edge.
        let larger = columns((1, 1), (4, 2));
        assert_eq!(larger, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!(columns((-1, 0), (1, 1)), [1.0]);
        let outside = file(&["Y"], (2, 1), (5, 0), Some((4, 2)));
        assert!(decode(outside).unwrap_err().contains("outside"));
        let empty = file(&["Y"], (2, 1), (0, 0), Some((16384, 8192)));
        assert!(decode(empty).unwrap_err().contains("only 2 x 1 are there"));
    }

    #[test]
    fn radiance_files_of_any_program_are_read() {
        for name in ["RADIANCE", "RGBE", "OTHER"] {
            let text = format!("#?{name}\n# a comment\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n");
            let bytes = [text.as_bytes(), &[128, 64, 0, 129, 128, 128, 128, 129]].concat();
            let (image, _) = decode(bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!((image.width, image.height), (2, 1));
            assert_eq!(image.rgb, [[1.0, 0.5, 0.0], [1.0; 3]]);
        }
        for bytes in ["#?", "#?RGBE", "#?RGBE\n", "#?RGBE\n\n-Y 99999 +X 99999\n"] {
            decode(bytes.as_bytes().to_vec()).unwrap_err();
        }
    }

    #[test]
    fn sizes_are_checked_before_texels_exist() {
        check_size(0, 4).unwrap_err();
        let message = check_size(usize::MAX, usize::MAX).unwrap_err();
        assert!(message.ends_with(SCALE_IT_DOWN), "{message}");
        check_size(16384, 8192).unwrap();
        // A lossless WebP of 14337 x 8322 texels in 33 bytes.
        let header = 14336u32 | 8321 << 14;
        let picture = [
            b"WEBPVP8L\x0d\0\0\0\x2f".as_slice(),
            &header.to_le_bytes(),
            &[0; 8],
        ]
        .concat();
        let size = (picture.len() as u32).to_le_bytes();
        let message = decode([b"RIFF".as_slice(), &size, &picture].concat()).unwrap_err();
        assert!(message.contains("14337 x 8322"), "{message}");
    }

    #[test]
    fn damaged_blocks_do_not_end_the_program() {
        let texel = |at: exr::Vec2<usize>| {
            let value = |factor: usize| exr::f16::from_f32((at.0 * factor + at.1) as f32);
            (value(1), value(3), value(7))
        };
        let mut whole = Vec::new();
        let channels = exr::SpecificChannels::rgb(texel);
        let encoding = exr::Encoding {
            compression: exr::Compression::B44,
            ..exr::Encoding::UNCOMPRESSED
        };
        let attributes = exr::LayerAttributes::default();
        exr::Image::from_layer(exr::Layer::new((16, 16), attributes, encoding, channels))
            .write()
            .to_buffered(Cursor::new(&mut whole))
            .expect("memory takes everything");
        assert!(decode_exr(&whole).is_ok());
        for at in (whole.len() / 3..whole.len()).step_by(3) {
            let mut changed = whole.clone();
            changed[at] ^= 0xff;
            // What the decoder panics on, the caller catches.
            let _ = texgen::guarded(|| decode_exr(&changed).is_ok());
        }
    }
}
