//! Pictures of a few texels in every format and compression that is read.

use std::io::Cursor;

use ::exr::prelude as exr;
use ::exr::prelude::WritableImage as _;
use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage};

use super::files;
use crate::root;

/// The largest file that is taken from elsewhere.
const LARGEST: u64 = 8 << 10;

/// All seeds of pictures.
pub fn panoramas() -> Vec<Vec<u8>> {
    let texel = |x: u32, y: u32| Rgb([x as f32 * 0.5, y as f32 * 3.0, 1e4 / (1 + x + y) as f32]);
    let picture = |width, height| DynamicImage::from(Rgb32FImage::from_fn(width, height, texel));
    let encoded = |picture: DynamicImage, format| {
        let mut bytes = Cursor::new(Vec::new());
        picture
            .write_to(&mut bytes, format)
            .expect("memory takes everything");
        bytes.into_inner()
    };
    let mut pictures = vec![
        // Runs of equal bytes are used from eight columns on.
        encoded(picture(4, 2), ImageFormat::Hdr),
        encoded(picture(24, 3), ImageFormat::Hdr),
        encoded(picture(3, 2).to_rgb8().into(), ImageFormat::Png),
        encoded(picture(3, 2).to_rgb8().into(), ImageFormat::Jpeg),
        encoded(picture(3, 2).to_rgb8().into(), ImageFormat::Bmp),
        encoded(picture(3, 2).to_rgb8().into(), ImageFormat::WebP),
    ];
    for compression in [
        exr::Compression::Uncompressed,
        exr::Compression::RLE,
        exr::Compression::ZIP1,
        exr::Compression::ZIP16,
        exr::Compression::PIZ,
        exr::Compression::PXR24,
        exr::Compression::B44,
    ] {
        let lines = exr::Blocks::ScanLines;
        let tiles = exr::Blocks::Tiles(exr::Vec2(4, 4));
        pictures.push(open_exr(&["B", "G", "R"], compression, lines));
        pictures.push(open_exr(&["Y"], compression, tiles));
    }
    pictures.push(open_exr(
        &["Z", "beauty.B", "beauty.G", "beauty.R"],
        exr::Compression::ZIP16,
        exr::Blocks::ScanLines,
    ));
    let damaged = root().join("../shared/scenes/malformed/exr-damaged");
    pictures.extend(files(&damaged, &["exr"], LARGEST));
    pictures
}

/// Six columns and five rows, of floats and of halfs.
fn open_exr(names: &[&str], compression: exr::Compression, blocks: exr::Blocks) -> Vec<u8> {
    let size = (6, 5);
    let channels = names.iter().enumerate().map(|(number, &name)| {
        let value = |at: usize| (10 * number + at % 4) as f32 * 0.25;
        let samples = 0..size.0 * size.1;
        let samples = match number % 2 {
            0 => exr::FlatSamples::F32(samples.map(value).collect()),
            _ => exr::FlatSamples::F16(samples.map(|at| exr::f16::from_f32(value(at))).collect()),
        };
        exr::AnyChannel::new(name, samples)
    });
    let encoding = exr::Encoding {
        compression,
        blocks,
        line_order: exr::LineOrder::Increasing,
    };
    let channels = exr::AnyChannels::sort(channels.collect());
    let layer = exr::Layer::new(size, exr::LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    let written = exr::Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes);
    written.expect("memory takes everything");
    bytes.into_inner()
}
