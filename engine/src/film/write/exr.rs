//! OpenEXR: floats of 16 or 32 bits as the [`Form`](super::Form) says. A film of the picture alone has the channels R, G and B; one with
//! layers is one part whose channels have the names that Blender 5 gives them.

mod rows;

use std::borrow::Cow;
use std::io::{self, Seek, Write};

use exr::compression::Compression as Packing;
use exr::image::FlatSamples;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{
    AttributeValue, ChannelDescription, Chromaticities, IntegerBounds, LineOrder, SampleType, Text,
};
use exr::meta::header::{Header, LayerAttributes};

use super::form::largest;
use super::{Banded, Content, Fact, Metadata};
use crate::film::{self, Film, Layers, layers::Rule};

/// What red, green, blue and white are.
const REC709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// The channels of the picture as it was before it was denoised: Blender's "Noisy Image".
const NOISY: [&str; 3] = [
    "ViewLayer.Noisy Image.R",
    "ViewLayer.Noisy Image.G",
    "ViewLayer.Noisy Image.B",
];

/// Writes the picture, and what is kept beside it.
pub(super) fn write(
    file: impl Write + Seek,
    content: &Content<'_>,
    metadata: &Metadata,
) -> io::Result<()> {
    (content.form.check(content.layers)).map_err(io::Error::other)?;
    let channels = channels(content, metadata, |_, values| largest(values));
    let size = [content.film.width, content.film.height];
    let attributes = attributes(content, metadata);
    let encoding = content.form.compression.packing();
    let header = header(size, &channels, attributes, encoding, metadata);
    rows::write(file, header, std::iter::once(Ok(channels)))
}

/// As [`write()`] of a picture in bands.
pub(super) fn write_bands(
    file: impl Write + Seek,
    banded: &Banded<'_>,
    bands: impl Iterator<Item = io::Result<Film>>,
    metadata: &Metadata,
) -> io::Result<()> {
    (banded.form.check(banded.layers)).map_err(io::Error::other)?;
    let channels = |film: &Film| {
        let content = banded.content(film);
        channels(&content, metadata, |layer, _| banded.extents.of(layer))
    };
    let mut bands = bands.peekable();
    let Some(Ok(first)) = bands.peek() else {
        let nothing = || io::Error::other("a picture without rows");
        return Err(bands.next().and_then(Result::err).unwrap_or_else(nothing));
    };
    // What there is, and with how many bits, an empty film says as well.
    let empty = Film::with_layers(1, 1, first.layers().clone());
    let attributes = attributes(&banded.content(&empty), metadata);
    let encoding = banded.form.compression.packing();
    let header = header(
        banded.size,
        &channels(&empty),
        attributes,
        encoding,
        metadata,
    );
    let bands = bands.map(|film| film.map(|film| channels(&film)));
    rows::write(file, header, bands)
}

/// The largest numbers of a film's layers, as files would hold them.
pub(super) fn largest_numbers(content: &Content<'_>) -> Vec<(&'static str, f32)> {
    let mut found = Vec::new();
    described(content, &Metadata::default(), |layer, _, values| {
        found.push((layer.name, largest(&values)));
    });
    found
}

/// Rows of a block of B44.
const B44_ROWS: u32 = 32;
/// Fewest bytes that the crate has for such a block when it is packed.
const B44_ROOM: u64 = 2048;

/// Whether B44 has room for all blocks of a picture: it makes 14 bytes of 4 x 4 numbers of 16 bits, also where fewer are left at the
/// borders, so that blocks may grow, but the crate has no more room than for what isn't packed.
fn has_room(channels: &Channels, [width, height]: [u32; 2]) -> bool {
    let bytes = |rows: u32| {
        let in_halves =
            |(_, samples): &&(Text, FlatSamples)| matches!(samples, FlatSamples::F16(_));
        let numbers = u64::from(width) * u64::from(rows);
        let squares = u64::from(width.div_ceil(4)) * u64::from(rows.div_ceil(4));
        let halves = channels.iter().filter(in_halves).count() as u64;
        let others = 4 * numbers * (channels.len() as u64 - halves);
        let unpacked = others + 2 * numbers * halves;
        (others + 14 * squares * halves, unpacked.max(B44_ROOM))
    };
    let blocks = [height.min(B44_ROWS), height % B44_ROWS];
    blocks
        .into_iter()
        .map(bytes)
        .all(|(most, room)| most <= room)
}

/// The header of a file of these channels.
fn header(
    [width, height]: [u32; 2],
    channels: &Channels,
    attributes: LayerAttributes,
    packing: Packing,
    metadata: &Metadata,
) -> Header {
    let packing = match packing {
        Packing::B44 | Packing::B44A if !has_room(channels, [width, height]) => Packing::ZIP16,
        packing => packing,
    };
    let list = channels.iter().map(|(name, samples)| {
        let kind = match samples {
            FlatSamples::F16(_) => SampleType::F16,
            FlatSamples::F32(_) => SampleType::F32,
            FlatSamples::U32(_) => SampleType::U32,
        };
        // Its own guess goes by names such as `R` alone: of `ViewLayer.Combined.R` B44 would keep logarithms, which end at 88.75.
        ChannelDescription::new(name.clone(), kind, false)
    });
    let size = Vec2(width as usize, height as usize);
    let mut header = Header::new(Text::default(), size, list.collect()).with_encoding(
        packing,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    );
    header.own_attributes = attributes;
    header.shared_attributes.chromaticities = Some(REC709);
    if let Some(crop) = metadata.crop {
        let at = |place: u32| i32::try_from(place).unwrap_or_default();
        let [columns, rows] = crop.whole;
        // Sides are bounded, as the film's are.
        header.own_attributes.layer_position = Vec2(at(crop.left), at(crop.top));
        header.shared_attributes.display_window =
            IntegerBounds::from_dimensions(Vec2(columns as usize, rows as usize));
    }
    header
}

/// Channels in the order of their names, as the format wants them.
type Channels = Vec<(Text, FlatSamples)>;

/// The channels of a film with as many bits as they are to have, where `largest` says the largest number of a layer, of which these are
/// the numbers.
fn channels(
    content: &Content<'_>,
    metadata: &Metadata,
    largest: impl Fn(&film::Layer, &[Vec<f32>]) -> f32,
) -> Channels {
    let mut channels = Channels::new();
    described(content, metadata, |layer, names, values| {
        let most = largest(layer, &values);
        let samples = content.form.samples(layer, values, most);
        let names = names.iter().map(|name| utf8(name));
        channels.extend(names.zip(samples));
    });
    channels.sort_unstable_by(|(a, _), (b, _)| a.cmp(b));
    channels
}

/// Tells of each layer that a file holds: the names of its channels, and their numbers.
fn described(
    content: &Content<'_>,
    metadata: &Metadata,
    mut tell: impl FnMut(&'static film::Layer, Vec<String>, Vec<Vec<f32>>),
) {
    if is_alone(content) {
        return picture_alone(content, tell);
    }
    let layers = &*layers(content);
    for layer in layers.iter().filter(|layer| !layer.is_kept_back()) {
        let mut channels = content.film.channels(layer).unwrap_or_default();
        let is_picture = *layer == film::LAYERS[0];
        if is_picture && content.transparent {
            channels = split(&content.rendered());
        }
        if content.transparent && layer.is_of_environment(&metadata.names) {
            // So that groups add up to the picture.
            let in_front = content.film.group_in_front(layer);
            channels = in_front.map_or(channels, |pixels| split(&pixels));
        }
        if layer.name == "alpha" && content.transparent {
            channels = content.alpha().into_iter().collect();
        }
        if let (Some(denoised), true) = (content.denoised, is_picture) {
            let noisy = std::mem::replace(&mut channels, split(denoised));
            tell(layer, NOISY.map(str::to_owned).into(), noisy);
        }
        let names = layer.channel_names();
        let names = names.map(|name| {
            let name = with_group(name, layer, metadata);
            name.replacen(layer.pass, &layers.pass_of(layer), 1)
        });
        tell(layer, names.collect(), channels);
    }
}

/// Whether a file holds the picture alone.
fn is_alone(content: &Content<'_>) -> bool {
    content.layers.is_picture_alone() && content.denoised.is_none()
}

/// What a file with layers holds.
fn layers<'a>(content: &Content<'a>) -> Cow<'a, Layers> {
    let with_alpha = content.layers.with(["alpha"]);
    match (content.transparent, with_alpha) {
        (true, Ok(layers)) => Cow::Owned(layers),
        _ => Cow::Borrowed(content.layers),
    }
}

/// The picture, and its coverage where that is wanted.
fn picture_alone(
    content: &Content<'_>,
    mut tell: impl FnMut(&'static film::Layer, Vec<String>, Vec<Vec<f32>>),
) {
    let names = ["R", "G", "B"].map(str::to_owned).into();
    tell(&film::LAYERS[0], names, split(&content.picture()));
    if let (Some(alpha), Some(layer)) = (content.alpha(), film::Layer::named("alpha")) {
        tell(layer, vec!["A".to_owned()], vec![alpha]);
    }
}

/// A channel's name with that of the group of lights that its layer is of.
fn with_group(channel: String, layer: &film::Layer, metadata: &Metadata) -> String {
    let groups = layer.light_group().and(metadata.names.get(layer.name));
    match groups.map(Vec::as_slice) {
        Some([group]) => channel.replace(layer.pass, &format!("Combined_{group}")),
        _ => channel,
    }
}

/// Pixels channel by channel.
fn split(pixels: &[[f32; 3]]) -> Vec<Vec<f32>> {
    let channel = |at: usize| pixels.iter().map(|rgb| rgb[at]).collect();
    (0..3).map(channel).collect()
}

/// What the specification of Cryptomatte asks for in a header, for layers of ids.
fn cryptomatte(layer: &film::Layer, metadata: &Metadata) -> Vec<(Text, AttributeValue)> {
    let Rule::Ids { .. } = layer.rule else {
        return Vec::new();
    };
    let name = format!("ViewLayer.{}", layer.pass);
    let key = format!("{:08x}", scene::murmur3(name.as_bytes()));
    let mut facts = vec![
        ("name", name.clone()),
        ("hash", "MurmurHash3_32".to_owned()),
        ("conversion", "uint32_to_float32".to_owned()),
    ];
    facts.extend((metadata.names.get(layer.name)).map(|names| ("manifest", manifest(names))));
    let facts = facts.into_iter().map(|(fact, value)| {
        let name = utf8(&format!("cryptomatte/{}/{fact}", &key[..7]));
        (name, AttributeValue::Text(utf8(&value)))
    });
    facts.collect()
}

/// Names with their numbers as JSON. The format of the file has no UTF-8, so other characters than ASCII are escaped.
fn manifest(names: &[String]) -> String {
    let numbers = names.iter().map(|name| {
        let id = format!("{:08x}", scene::name_id(name));
        (name.clone(), serde_json::Value::String(id))
    });
    let text = serde_json::Value::Object(numbers.collect()).to_string();
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c.is_ascii() {
            true => escaped.push(c),
            false => {
                let mut units = [0; 2];
                let units = c.encode_utf16(&mut units);
                escaped.extend(units.iter().map(|unit| format!("\\u{unit:04x}")));
            }
        }
    }
    escaped
}

fn attributes(content: &Content<'_>, metadata: &Metadata) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        software_name: Some(utf8(concat!("patina ", env!("CARGO_PKG_VERSION")))),
        ..LayerAttributes::default()
    };
    for (name, fact) in &metadata.facts {
        let value = match fact {
            Fact::Count(count) => AttributeValue::I32(i32::try_from(*count).unwrap_or(i32::MAX)),
            Fact::Text(text) => AttributeValue::Text(utf8(text)),
        };
        attributes.other.insert(utf8(name), value);
    }
    for (name, value) in &content.form.facts {
        let value = utf8(value);
        match name.as_str() {
            "owner" => attributes.owner = Some(value),
            "comments" => attributes.comments = Some(value),
            "capDate" => attributes.capture_date = Some(value),
            _ => {
                let value = AttributeValue::Text(value);
                attributes.other.insert(utf8(name), value);
            }
        }
    }
    if !is_alone(content) {
        let layers = layers(content);
        let matte = layers.iter().flat_map(|layer| cryptomatte(layer, metadata));
        attributes.other.extend(matte);
    }
    attributes
}

/// A text as OpenEXR has it: the bytes of UTF-8, each of which the library takes for a character.
fn utf8(text: &str) -> Text {
    let bytes: String = text.bytes().map(char::from).collect();
    Text::new_or_none(bytes).unwrap_or_default()
}

#[cfg(test)]
mod tests;
