//! Part of a picture's samples as a file: the film's exact sums, which samples they are and what they were rendered
//! from. Parts of one picture add up to exactly the whole.
//!
//! # Format
//! Little-endian: the eight bytes `PATINAFM`, the length of the header (`u32`), the header (JSON: [`Origin`], size and
//! ranges), five planes of four `u32` per pixel (see [`Film`]), and a checksum (`u64`) of all of it.

use std::io::{self, Read, Write};
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::fingerprint::Hash;
use super::{Film, MAX_SAMPLES, PLANES};
use crate::renderer::MAX_SIDE;

/// What a file begins with; another layout gets another one.
const MAGIC: &[u8; 8] = b"PATINAFM";
/// Longest header that is believed.
const MAX_HEADER: u32 = 1 << 20;

/// Where samples come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The device; another one rounds differently, so the picture is the same but for the last bits.
    pub device: String,
    /// Name of the scene's file.
    pub scene: String,
    /// Name of the look's file.
    pub look: Option<String>,
    /// What must be the same in all parts of a picture: see [`super::fingerprint`].
    pub settings: Vec<(String, String)>,
}

/// Some samples of every pixel of a picture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The sums.
    pub film: Film,
    /// What was rendered.
    pub origin: Origin,
    /// Which samples, ascending and apart from each other.
    ranges: Vec<Range<u32>>,
    /// Most samples that a pixel lacks, because a render was ended within a sample.
    missing: u32,
}

/// Why a part can't be read or merged.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// The system refuses.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Some other file.
    #[error(
        "it is no film of Patina; merge the files that `patina render -o part.patina-film` writes"
    )]
    Foreign,
    /// Not as it was written.
    #[error("the file is damaged: {0}; render this part again")]
    Damaged(&'static str),
    /// Both have these samples.
    #[error("samples {}..{} are in two of the partial renders; each sample may be merged once", .0.start, .0.end)]
    Overlap(Range<u32>),
    /// Parts of different pictures.
    #[error("it is part of another picture: {what} is {here}, but in the parts before it {there}")]
    Foreigner {
        /// The setting.
        what: String,
        /// Of this part.
        here: String,
        /// Of the others.
        there: String,
    },
}

#[derive(Serialize, Deserialize)]
struct Header {
    width: u32,
    height: u32,
    ranges: Vec<(u32, u32)>,
    #[serde(default, skip_serializing_if = "is_zero")]
    missing: u32,
    origin: Origin,
}

fn is_zero(count: &u32) -> bool {
    *count == 0
}

impl Part {
    /// A film of the samples of one range. Pixels may lack some of them where a render was ended early: the picture is right,
    /// but the parts of a whole no longer add up to exactly that.
    pub fn new(film: Film, samples: Range<u32>, origin: Origin) -> Self {
        let (fewest, _) = film.sample_bounds();
        let count = samples.end.saturating_sub(samples.start);
        Self {
            film,
            origin,
            ranges: vec![samples],
            missing: count.saturating_sub(fewest),
        }
    }

    /// Which samples of each pixel it has: ascending, with gaps between.
    pub fn ranges(&self) -> &[Range<u32>] {
        &self.ranges
    }

    /// A setting of [`Origin::settings`] by name.
    pub fn setting(&self, name: &str) -> Option<&str> {
        let settings = self.origin.settings.iter();
        settings
            .into_iter()
            .find(|(n, _)| n == name)
            .map(|(_, value)| value.as_str())
    }

    /// Adds another part of the same picture.
    ///
    /// # Errors
    /// It has samples that are here already, or was rendered from something else; then nothing is added.
    pub fn merge(&mut self, other: &Self) -> Result<(), PartError> {
        let (here, there) = (&other.origin.settings, &self.origin.settings);
        if let Some(((what, here), (_, there))) =
            here.iter().zip(there).find(|(here, there)| here != there)
        {
            return Err(PartError::Foreigner {
                what: what.clone(),
                here: here.clone(),
                there: there.clone(),
            });
        }
        if here.len() != there.len() || !self.has_size_of(&other.film) {
            return Err(PartError::Damaged("its settings don't fit"));
        }
        self.ranges = joined(self.ranges.iter().chain(&other.ranges))?;
        self.film.add(&other.film);
        self.missing = self.missing.saturating_add(other.missing);
        Ok(())
    }

    fn has_size_of(&self, film: &Film) -> bool {
        (self.film.width, self.film.height) == (film.width, film.height)
    }

    /// Writes the file.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, file: &mut impl Write) -> io::Result<()> {
        let header = Header {
            width: self.film.width,
            height: self.film.height,
            ranges: self.ranges.iter().map(|r| (r.start, r.end)).collect(),
            missing: self.missing,
            origin: self.origin.clone(),
        };
        let header = serde_json::to_vec(&header)?;
        let mut hash = Hash::new();
        file.write_all(MAGIC)?;
        file.write_all(&(header.len() as u32).to_le_bytes())?;
        file.write_all(&header)?;
        hash.bytes(&header);
        for plane in self.film.planes() {
            let plane = little_endian(bytemuck::cast_slice(plane));
            file.write_all(bytemuck::cast_slice(&plane))?;
            hash.bytes(bytemuck::cast_slice(&plane));
        }
        file.write_all(&hash.value().to_le_bytes())
    }

    /// Reads a file of `length` bytes. The length is compared with what the header promises before memory is taken.
    ///
    /// # Errors
    /// It is no such file, or not whole.
    pub fn read(file: &mut impl Read, length: u64) -> Result<Self, PartError> {
        let mut start = [0; 12];
        if length < start.len() as u64 {
            return Err(PartError::Foreign);
        }
        file.read_exact(&mut start)?;
        let (magic, header_length) = start.split_at(8);
        if magic != MAGIC {
            return Err(PartError::Foreign);
        }
        let header_length = header_length
            .iter()
            .rev()
            .fold(0, |n, &b| n << 8 | u32::from(b));
        let rest = length - start.len() as u64;
        if header_length > MAX_HEADER || u64::from(header_length) > rest {
            return Err(PartError::Damaged("it is too short"));
        }
        let mut header = vec![0; header_length as usize];
        file.read_exact(&mut header)?;
        let mut hash = Hash::new();
        hash.bytes(&header);
        let header: Header = serde_json::from_slice(&header)
            .map_err(|_| PartError::Damaged("its header makes no sense"))?;
        let (width, height) = (header.width, header.height);
        if width.clamp(1, MAX_SIDE) != width || height.clamp(1, MAX_SIDE) != height {
            return Err(PartError::Damaged("its size makes no sense"));
        }
        let pixels = u64::from(width) * u64::from(height);
        if rest - u64::from(header_length) != pixels * 16 * PLANES.len() as u64 + 8 {
            return Err(PartError::Damaged("it has the wrong length"));
        }
        let mut film = Film::new(width, height);
        for plane in &mut film.planes {
            let words: &mut [u32] = bytemuck::cast_slice_mut(plane);
            file.read_exact(bytemuck::cast_slice_mut(words))?;
            hash.bytes(bytemuck::cast_slice(words));
            words
                .iter_mut()
                .for_each(|word| *word = u32::from_le(*word));
        }
        let mut checksum = [0; 8];
        file.read_exact(&mut checksum)?;
        if u64::from_le_bytes(checksum) != hash.value() {
            return Err(PartError::Damaged("its checksum is wrong"));
        }
        let ranges: Vec<_> = header.ranges.iter().map(|&(a, b)| a..b).collect();
        let ranges = joined(ranges.iter())?;
        let count: u32 = ranges.iter().map(|r| r.end - r.start).sum();
        let (fewest, most) = film.sample_bounds();
        let missing = header.missing.min(count);
        if ranges.is_empty() || most > count || most == 0 || fewest < count - missing {
            return Err(PartError::Damaged("its samples are not those it claims"));
        }
        Ok(Self {
            film,
            origin: header.origin,
            ranges,
            missing,
        })
    }
}

/// A file with the checksum that its bytes have: so that what a changed file is refused for otherwise can be tried.
/// `None` where it is too short or has no planes of one size.
pub fn sealed(file: &[u8]) -> Option<Vec<u8>> {
    let (rest, _) = file.split_last_chunk::<8>()?;
    let (length, data) = rest.get(MAGIC.len()..)?.split_first_chunk()?;
    let (header, planes) = data.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    if planes.is_empty() || !planes.len().is_multiple_of(PLANES.len()) {
        return None;
    }
    let mut hash = Hash::new();
    hash.bytes(header);
    let planes = planes.chunks_exact(planes.len() / PLANES.len());
    planes.for_each(|plane| hash.bytes(plane));
    Some([rest, &hash.value().to_le_bytes()].concat())
}

/// The words as they lie in a file.
fn little_endian(words: &[u32]) -> std::borrow::Cow<'_, [u32]> {
    if cfg!(target_endian = "little") {
        words.into()
    } else {
        words.iter().map(|word| word.to_le()).collect()
    }
}

/// Ranges in ascending order; those that touch are one.
fn joined<'a>(ranges: impl Iterator<Item = &'a Range<u32>>) -> Result<Vec<Range<u32>>, PartError> {
    let mut ranges: Vec<Range<u32>> = ranges.cloned().collect();
    ranges.sort_by_key(|range| range.start);
    let mut joined: Vec<Range<u32>> = Vec::new();
    for range in ranges {
        if range.start >= range.end || range.end > MAX_SAMPLES {
            return Err(PartError::Damaged("its samples make no sense"));
        }
        match joined.last_mut() {
            Some(last) if range.start < last.end => {
                return Err(PartError::Overlap(range.start..range.end.min(last.end)));
            }
            Some(last) if range.start == last.end => last.end = range.end,
            _ => joined.push(range),
        }
    }
    Ok(joined)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(samples: Range<u32>, seed: &str) -> Part {
        let mut film = Film::new(2, 1);
        for sample in samples.clone() {
            let value = 0.1 + (sample as f32).sin().abs();
            film.add_sample(0, [value, 1e-6 * value, 1e6 * value]);
            film.add_sample(1, [2.0 * value; 3]);
        }
        let origin = Origin {
            device: "device".to_owned(),
            scene: "scene.glb".to_owned(),
            look: None,
            settings: vec![("seed".to_owned(), seed.to_owned())],
        };
        Part::new(film, samples, origin)
    }

    fn bytes(part: &Part) -> Vec<u8> {
        let mut bytes = Vec::new();
        part.write(&mut bytes).expect("memory takes everything");
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Part, PartError> {
        Part::read(&mut &bytes[..], bytes.len() as u64)
    }

    #[test]
    fn a_part_is_read_as_it_was_written_or_not_at_all() {
        let part = part(3..10, "0");
        let whole = bytes(&part);
        assert_eq!(read(&whole).expect("whole"), part);
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length} bytes");
        }
        assert!(read(&[&whole[..], b"x"].concat()).is_err());
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 4;
            assert!(read(&changed).is_err(), "byte {at}");
            // The checksum itself, and nothing else, can be mended.
            let mended = sealed(&changed).is_some_and(|sealed| sealed == whole);
            assert_eq!(mended, at >= whole.len() - 8, "byte {at}");
        }
        assert!(matches!(read(b"something else"), Err(PartError::Foreign)));
    }

    #[test]
    fn a_render_that_was_ended_within_a_sample_can_be_kept_and_continued() {
        let whole = part(0..6, "0");
        let mut ended = part(0..3, "0");
        ended.film.add_sample(0, [0.5; 3]);
        let mut ended = Part::new(ended.film, 0..4, ended.origin);
        assert_eq!(read(&bytes(&ended)).expect("whole"), ended);
        ended.merge(&part(4..6, "0")).expect("they fit");
        assert_eq!(ended.ranges(), whole.ranges());
        assert_eq!(read(&bytes(&ended)).expect("whole"), ended);
        // What doesn't say so has all samples.
        let lying = Part {
            missing: 0,
            ..ended
        };
        assert!(read(&bytes(&lying)).is_err());
    }

    #[test]
    fn parts_add_up_to_the_whole_in_any_order() {
        let whole = part(0..20, "0");
        for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
            let parts = [part(0..3, "0"), part(3..16, "0"), part(16..20, "0")];
            let mut merged = parts[order[0]].clone();
            merged.merge(&parts[order[1]]).expect("they fit");
            let gaps = merged.ranges().len();
            assert_eq!(gaps, if order[0] == 2 { 2 } else { 1 });
            merged.merge(&parts[order[2]]).expect("they fit");
            assert_eq!(merged, whole);
            assert_eq!(bytes(&merged), bytes(&whole));
        }
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let mut merged = part(0..10, "0");
        let before = merged.clone();
        match merged.merge(&part(8..12, "0")) {
            Err(PartError::Overlap(samples)) => assert_eq!(samples, 8..10),
            other => panic!("{other:?}"),
        }
        let error = merged.merge(&part(10..12, "1")).expect_err("another seed");
        assert!(error.to_string().contains("seed is 1"), "{error}");
        assert_eq!(merged, before);
    }
}
