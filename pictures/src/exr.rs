//! Layers of OpenEXR files, of one part or several.
//!
//! Names of channels are those of their layers, a dot, and their own: `ViewLayer.Depth.Z`. Where a file has several parts, the name of
//! the part may say the same once more, or be the beginning of the name.

use std::io::Cursor;

use exr::image::FlatSamples;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels as _, ReadLayers as _, Text};

use crate::error::{PictureError, check_size};
use crate::{Channel, Layer};

/// How such files begin.
pub(crate) const MAGIC: [u8; 4] = [0x76, 0x2F, 0x31, 0x01];

/// A text of a header.
pub(crate) fn text(text: &Text) -> String {
    decoded(text.as_slice())
}

/// Bytes of a text: UTF-8, as programs write it, else Latin-1.
pub(crate) fn decoded(bytes: &[u8]) -> String {
    let latin1 = || bytes.iter().map(|&byte| char::from(byte)).collect();
    String::from_utf8(bytes.to_vec()).unwrap_or_else(|_| latin1())
}

/// The headers of all parts, which claim nothing that the file can't hold.
pub(crate) fn headers(bytes: &[u8]) -> Result<Vec<Header>, PictureError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false);
    let headers = meta.map_err(PictureError::damaged)?.headers;
    for header in &headers {
        let Vec2(width, height) = header.layer_size;
        check_size([width, height], header.channels.list.len(), bytes.len())?;
        if header.chunk_count > bytes.len() / 8 {
            return Err(PictureError::damaged(
                "it claims more blocks than the file has bytes for",
            ));
        }
    }
    Ok(headers.into_iter().collect())
}

/// All layers, without deep data.
pub(crate) fn layers(bytes: &[u8]) -> Result<Vec<Layer>, PictureError> {
    for header in headers(bytes)? {
        let mut channels = header.channels.list.iter();
        if let Some(channel) = channels.find(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(PictureError::Unsupported(format!(
                "has a channel of less resolution, {}: save it with whole ones",
                channel.name
            )));
        }
    }
    // On this thread, where a panic of the decoder can be caught: on one of rayon's it would end the program.
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(PictureError::damaged)?;
    let mut layers: Vec<Layer> = Vec::new();
    for part in image.layer_data {
        let title = part.attributes.layer_name.as_ref();
        let title = title.map(text).unwrap_or_default();
        let size = [part.size.0, part.size.1];
        let mut groups: Vec<(String, Vec<Channel>)> = Vec::new();
        for channel in part.channel_data.list {
            let name = text(&channel.name);
            let (layer, name) = split(&title, &name);
            let values = match channel.sample_data {
                FlatSamples::F32(values) => values,
                other => other.values_as_f32().collect(),
            };
            let channel = Channel { name, values };
            match groups.iter_mut().find(|(known, _)| *known == layer) {
                Some((_, channels)) => channels.push(channel),
                None => groups.push((layer, vec![channel])),
            }
        }
        let made = groups.into_iter();
        layers.extend(made.map(|(name, channels)| Layer::new(name, size, channels)));
    }
    match layers.is_empty() {
        true => Err(PictureError::Unsupported(
            "has no layer that isn't deep data".to_owned(),
        )),
        false => Ok(layers),
    }
}

/// The names of a layer and of its channel.
pub(crate) fn split(part: &str, channel: &str) -> (String, String) {
    let (layer, name) = channel.rsplit_once('.').unwrap_or(("", channel));
    let layer = match (part, layer) {
        ("", layer) => layer.to_owned(),
        (part, "") => part.to_owned(),
        // The part says it already, whole or at its end.
        (part, layer) if part == layer || part.ends_with(&format!(".{layer}")) => part.to_owned(),
        (part, layer) if layer.starts_with(&format!("{part}.")) => layer.to_owned(),
        (part, layer) => format!("{part}.{layer}"),
    };
    (layer, name.to_owned())
}

#[cfg(test)]
pub(crate) mod tests {
    use exr::prelude::*;

    use super::*;

    /// A file of one part with these channels of 2 x 1 pixels.
    pub(crate) fn file(channels: &[(&str, [f32; 2])]) -> Vec<u8> {
        let channels = channels.iter().map(|(name, values)| {
            let values = FlatSamples::F32(values.to_vec());
            AnyChannel::new(Text::from(*name), values)
        });
        let channels = AnyChannels::sort(channels.collect());
        let mut attributes = LayerAttributes {
            software_name: Some(Text::from("a test")),
            ..LayerAttributes::default()
        };
        let samples = AttributeValue::I32(64);
        attributes.other.insert(Text::from("samples"), samples);
        let encoding = Encoding::SMALL_LOSSLESS;
        let layer = exr::image::Layer::new((2, 1), attributes, encoding, channels);
        let image = Image::from_layer(layer);
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).expect("written");
        bytes.into_inner()
    }

    #[test]
    fn channels_are_gathered_to_layers() {
        let bytes = file(&[
            ("ViewLayer.Combined.R", [1.0, 2.0]),
            ("ViewLayer.Combined.G", [3.0, 4.0]),
            ("ViewLayer.Combined.B", [5.0, 6.0]),
            ("ViewLayer.Depth.Z", [7.0, f32::INFINITY]),
        ]);
        let layers = layers(&bytes).expect("a picture");
        let names: Vec<_> = layers.iter().map(|layer| &*layer.name).collect();
        assert_eq!(names, ["ViewLayer.Combined", "ViewLayer.Depth"]);
        assert!(layers[0].is_color());
        assert_eq!(layers[0].channels[0].values, [1.0, 2.0]);
        assert_eq!(layers[1].channels[0].values, [7.0, f32::INFINITY]);
        assert_eq!(layers[1].size, [2, 1]);
    }

    #[test]
    fn names_of_parts_are_said_once() {
        let name = |part: &str, channel: &str| split(part, channel).0;
        assert_eq!(name("", "R"), "");
        assert_eq!(name("", "a.b.R"), "a.b");
        assert_eq!(name("a.b", "R"), "a.b");
        assert_eq!(name("a.b", "b.R"), "a.b");
        assert_eq!(name("a", "a.b.R"), "a.b");
        assert_eq!(name("left", "Depth.Z"), "left.Depth");
    }

    #[test]
    fn no_cut_or_changed_file_leads_to_a_panic() {
        let bytes = file(&[("R", [1.0, 2.0]), ("G", [3.0, 4.0]), ("B", [5.0, 6.0])]);
        for end in 0..bytes.len() {
            assert!(crate::Picture::read(&bytes[..end]).is_err(), "{end}");
        }
        for at in 0..bytes.len() {
            for value in [0, 1, 0x7F, 0xFF] {
                let mut changed = bytes.clone();
                changed[at] = value;
                let _ = crate::Picture::read(&changed);
                let _ = crate::Facts::read(&changed);
            }
        }
    }
}
