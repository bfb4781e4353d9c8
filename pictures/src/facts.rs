//! What the header of a picture's file says, without its pixels.

use exr::meta::attribute::{AttributeValue, ChannelDescription, SampleType};
use exr::meta::header::Header;
use image::ImageDecoder;
use serde::Serialize;

use crate::error::PictureError;
use crate::exr::{decoded, text};
use crate::read::{Kind, decoder, hdr};

/// A file of a picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// Of the file, such as `OpenEXR`.
    pub format: String,
    /// Pictures that the file holds; all formats but OpenEXR hold one.
    pub parts: Vec<PartFacts>,
}

/// A part of a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartFacts {
    /// Where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Column and row of the upper left pixel, where that isn't 0, 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[i32; 2]>,
    /// How it is packed, where there is a choice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compression: Option<String>,
    /// In the order of the file.
    pub channels: Vec<ChannelFacts>,
    /// Names and values of all that is said besides, sorted by name.
    pub metadata: Vec<(String, String)>,
}

/// A number of each pixel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelFacts {
    /// With that of its layer: `ViewLayer.Depth.Z`.
    pub name: String,
    /// `half`, `float`, or the number of bits of a whole number.
    pub kind: &'static str,
}

/// Attributes that say how the file is laid out; what counts of them is told otherwise.
const LAYOUT: [&str; 11] = [
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "name",
    "preview",
    "tiles",
    "type",
    "version",
];

/// Longest value that is told.
const MAX_TEXT: usize = 4000;

impl Facts {
    /// Whether a file that begins so is a picture.
    pub fn is_picture(start: &[u8]) -> bool {
        Kind::of(start).is_some()
    }

    /// Reads the beginning of a file's contents.
    ///
    /// # Errors
    /// It is no picture, or a damaged one.
    pub fn read(bytes: &[u8]) -> Result<Self, PictureError> {
        let kind = Kind::of(bytes).ok_or(PictureError::Foreign)?;
        // The decoders are foreign code that is fed with foreign bytes.
        let read = texgen::guarded(|| match kind {
            Kind::Exr => of_exr(bytes),
            Kind::Hdr => Ok(of_other("Radiance HDR", &hdr(bytes)?)),
            Kind::Other(format) => {
                let name = format!("{format:?}").to_uppercase();
                Ok(of_other(&name, &decoder(bytes)?))
            }
        });
        read.unwrap_or_else(|_| Err(PictureError::damaged("the decoder gave up on it")))
    }
}

fn of_exr(bytes: &[u8]) -> Result<Facts, PictureError> {
    let headers = crate::exr::headers(bytes)?;
    Ok(Facts {
        format: "OpenEXR".to_owned(),
        parts: headers.iter().map(part).collect(),
    })
}

fn part(header: &Header) -> PartFacts {
    let channel = |channel: &ChannelDescription| ChannelFacts {
        name: text(&channel.name),
        kind: match channel.sample_type {
            SampleType::F16 => "half",
            SampleType::F32 => "float",
            SampleType::U32 => "32 bits",
        },
    };
    let mut metadata: Vec<(String, String)> = (header.all_named_attributes())
        .map(|(name, value)| (decoded(name), value))
        .filter(|(name, _): &(String, _)| !LAYOUT.contains(&name.as_str()))
        .filter_map(|(name, value)| Some((name, shown(&value)?)))
        .collect();
    metadata.sort();
    let compression = header.compression.to_string();
    let position = header.own_attributes.layer_position;
    PartFacts {
        name: (header.own_attributes.layer_name.as_ref()).map(text),
        width: header.layer_size.0,
        height: header.layer_size.1,
        position: ((position.0, position.1) != (0, 0)).then_some([position.0, position.1]),
        compression: Some(compression.trim_end_matches(" compression").to_owned()),
        channels: header.channels.list.iter().map(channel).collect(),
        metadata,
    }
}

/// The value of an attribute, for people; none of those that are only bytes.
fn shown(value: &AttributeValue) -> Option<String> {
    let mut text = match value {
        AttributeValue::Text(value) => text(value),
        AttributeValue::TextVector(texts) => {
            let texts: Vec<_> = texts.iter().map(text).collect();
            texts.join(", ")
        }
        AttributeValue::I32(number) => number.to_string(),
        AttributeValue::F32(number) => number.to_string(),
        AttributeValue::F64(number) => number.to_string(),
        AttributeValue::FloatVec2(v) => format!("{} {}", v.0, v.1),
        AttributeValue::IntVec2(v) => format!("{} {}", v.0, v.1),
        AttributeValue::FloatVec3(v) => format!("{} {} {}", v.0, v.1, v.2),
        AttributeValue::IntVec3(v) => format!("{} {} {}", v.0, v.1, v.2),
        AttributeValue::Rational((above, below)) => format!("{above}/{below}"),
        AttributeValue::Chromaticities(c) => {
            let corner = |v: exr::math::Vec2<f32>| format!("{} {}", v.0, v.1);
            let corners = [c.red, c.green, c.blue, c.white].map(corner);
            format!(
                "red {}, green {}, blue {}, white {}",
                corners[0], corners[1], corners[2], corners[3]
            )
        }
        AttributeValue::Matrix3x3(numbers) => words(numbers),
        AttributeValue::Matrix4x4(numbers) => words(numbers),
        _ => return None,
    };
    if let Some((end, _)) = text.char_indices().nth(MAX_TEXT) {
        text.truncate(end);
        text.push_str(" ...");
    }
    Some(text)
}

fn words(numbers: &[f32]) -> String {
    let words: Vec<_> = numbers.iter().map(ToString::to_string).collect();
    words.join(" ")
}

fn of_other(format: &str, decoder: &impl ImageDecoder) -> Facts {
    use image::ColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgb32F, Rgba8, Rgba16, Rgba32F};
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    let names: &[&str] = match color {
        L8 | L16 => &["Y"],
        La8 | La16 => &["Y", "A"],
        Rgb8 | Rgb16 | Rgb32F => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    let kind = match color {
        L8 | La8 | Rgb8 | Rgba8 => "8 bits",
        L16 | La16 | Rgb16 | Rgba16 => "16 bits",
        Rgb32F | Rgba32F => "float",
        _ => "other",
    };
    let channel = |name: &&str| ChannelFacts {
        name: (*name).to_owned(),
        kind,
    };
    Facts {
        format: format.to_owned(),
        parts: vec![PartFacts {
            name: None,
            width: width as usize,
            height: height as usize,
            position: None,
            compression: None,
            channels: names.iter().map(channel).collect(),
            metadata: Vec::new(),
        }],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exr_tells_its_channels_and_what_is_said_besides() {
        let bytes = crate::exr::tests::file(&[("R", [0.0; 2]), ("Depth.Z", [0.0; 2])]);
        let facts = Facts::read(&bytes).expect("a picture");
        assert_eq!(facts.format, "OpenEXR");
        let part = &facts.parts[0];
        assert_eq!((part.width, part.height, part.position), (2, 1, None));
        let channels: Vec<_> = part.channels.iter().map(|c| (&*c.name, c.kind)).collect();
        assert_eq!(channels, [("Depth.Z", "float"), ("R", "float")]);
        let said = |name: &str| {
            let mut metadata = part.metadata.iter();
            metadata
                .find(|(other, _)| other == name)
                .map(|(_, v)| v.as_str())
        };
        assert_eq!(said("samples"), Some("64"));
        assert_eq!(said("software"), Some("a test"));
        assert_eq!(said("compression"), None);
    }

    #[test]
    fn other_formats_tell_their_size() {
        let picture = image::DynamicImage::new_luma_a8(5, 4);
        let mut png = std::io::Cursor::new(Vec::new());
        let written = picture.write_to(&mut png, image::ImageFormat::Png);
        written.expect("memory takes everything");
        let facts = Facts::read(&png.into_inner()).expect("a picture");
        assert_eq!(facts.format, "PNG");
        let part = &facts.parts[0];
        assert_eq!((part.width, part.height), (5, 4));
        let channels: Vec<_> = part.channels.iter().map(|c| (&*c.name, c.kind)).collect();
        assert_eq!(channels, [("Y", "8 bits"), ("A", "8 bits")]);
        assert_eq!(Facts::read(b"nothing").unwrap_err(), PictureError::Foreign);
    }
}
