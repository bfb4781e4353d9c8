//! Part of a picture's samples as a file: the film's exact sums, which samples they are and what they were rendered
//! from. Parts of one picture add up to exactly the whole.
//!
//! # Format
//! Little-endian: the eight bytes `PATINAFZ`, the length of the header (`u32`), the header (JSON: [`Origin`], size, ranges and names
//! of layers), the planes of four `u32` per pixel (see [`Film`]: five of the picture, then those of the layers) as one stream
//! of zlib (RFC 1950), and a checksum (`u64`) of header and stream.
//!
//! Version 0.1 wrote planes as they are, into files that begin with `PATINAFM`, or `PATINAFL` where there are layers beside the
//! picture. They are read as well.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::ops::Range;
use std::path::Path;

use flate2::{Compression, read::ZlibDecoder, write::ZlibEncoder};
use serde::{Deserialize, Serialize};

use super::hash::{Hashed, Run};
use super::{Film, Hash, Layers, MAX_SAMPLES, MAX_SIDE, PICTURE_PLANES};

/// The setting that is said of pictures whose samples come in two halves.
pub(crate) const HALVES: &str = "halves";
/// What a file begins with; another layout gets another one.
const MAGIC: &[u8; 8] = b"PATINAFZ";
/// As it was without compression, of the picture alone.
const MAGIC_PLAIN: &[u8; 8] = b"PATINAFM";
/// As above, with further layers.
const MAGIC_PLAIN_LAYERS: &[u8; 8] = b"PATINAFL";
/// Nothing that zlib writes unpacks to more times its length.
const MOST_INFLATED: u64 = 1032;
/// So many bytes at the beginning of a file say whether it is a film.
pub const MAGIC_BYTES: u64 = MAGIC.len() as u64;
/// Paths come in blocks of so many.
const BLOCK: u64 = 64;
/// Longest header that is believed.
const MAX_HEADER: u32 = 1 << 24;

/// Whether a file that begins so is a film.
pub fn is_film(start: &[u8]) -> bool {
    let known = [MAGIC, MAGIC_PLAIN, MAGIC_PLAIN_LAYERS];
    known.into_iter().any(|magic| start.starts_with(magic))
}

/// Where samples come from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The device; another one rounds differently, so the picture is the same but for the last bits.
    pub device: String,
    /// Name of the scene's file.
    pub scene: String,
    /// Name of the look's file.
    pub look: Option<String>,
    /// What must be the same in all parts of a picture, by name.
    pub settings: Vec<(String, String)>,
    /// Names of what layers of ids may show, by layer ([`Layers::names`]): files list them beside their numbers.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub names: BTreeMap<String, Vec<String>>,
}

impl Origin {
    /// Of a scene and a look by their files, whose names are kept without their folders.
    pub fn new(
        device: &str,
        scene: &Path,
        look: Option<&Path>,
        settings: Vec<(String, String)>,
    ) -> Self {
        let name = |path: &Path| {
            let name = path.file_name().unwrap_or_default();
            name.to_string_lossy().into_owned()
        };
        Self {
            device: device.to_owned(),
            scene: name(scene),
            look: look.map(name),
            settings,
            names: BTreeMap::new(),
        }
    }

    /// Whether what has another origin belongs to the same picture.
    ///
    /// # Errors
    /// The first setting that differs. The device may be another one.
    pub fn fits(&self, other: &Self) -> Result<(), PartError> {
        let names = self.settings.iter().chain(&other.settings);
        for (what, _) in names {
            let [here, there] = [other, self].map(|origin| origin.setting(what));
            if here != there && what == HALVES {
                let is_in_halves = here.is_some();
                return Err(PartError::Halves { is_in_halves });
            }
            if here != there {
                let said = |value: Option<&str>| value.unwrap_or("not said").to_owned();
                return Err(PartError::Foreigner {
                    what: what.clone(),
                    here: said(here),
                    there: said(there),
                });
            }
        }
        Ok(())
    }

    /// A setting by name.
    pub fn setting(&self, name: &str) -> Option<&str> {
        let mut settings = self.settings.iter();
        let found = settings.find(|(other, _)| other == name);
        found.map(|(_, value)| value.as_str())
    }
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
    /// Where it is the beginning of a picture that is still under way: how many of its paths it has.
    paths: Option<u64>,
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
    /// Only one of both counts samples in two halves.
    #[error(
        "its samples are counted {}, the others {}: a picture is counted in two halves with --adaptive or --flip, and, unless its \
         shutter is open, by any method but path from 32 samples per pixel on",
        counted(*.is_in_halves), counted(!.is_in_halves)
    )]
    Halves {
        /// Whether it is this part.
        is_in_halves: bool,
    },
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

fn counted(is_in_halves: bool) -> &'static str {
    match is_in_halves {
        true => "in two halves",
        false => "as one",
    }
}

#[derive(Serialize, Deserialize)]
struct Header {
    width: u32,
    height: u32,
    ranges: Vec<(u32, u32)>,
    #[serde(default, skip_serializing_if = "is_zero")]
    missing: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    paths: Option<u64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    layers: Vec<String>,
    origin: Origin,
}

impl Header {
    /// What the film has gathered; the names are as [`Part::write`] lists them, or the planes' order is unknown.
    fn layers(&self) -> Result<Layers, PartError> {
        let refused = PartError::Damaged("it has layers that this version of Patina doesn't know");
        match Layers::named(self.layers.iter().map(String::as_str)) {
            Ok(layers) if listed(&layers) == self.layers => Ok(layers),
            _ => Err(refused),
        }
    }
}

/// The names of a film's layers as its header has them: none where there is the picture alone.
fn listed(layers: &Layers) -> Vec<String> {
    match layers.is_picture_alone() {
        true => Vec::new(),
        false => layers.asked().into_iter().map(Cow::into_owned).collect(),
    }
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
            paths: None,
        }
    }

    /// As the beginning of a picture that can be gone on with: so many of its paths, in the order in which a renderer takes them
    /// ([`crate::renderer::Renderer::paths_done`]).
    #[must_use]
    pub fn under_way(self, paths: u64) -> Self {
        // Whole samples say it themselves.
        let paths = (self.missing > 0).then_some(paths);
        Self { paths, ..self }
    }

    /// How many paths of its picture it has, where these are the first ones and a sample takes so many: see [`Self::under_way`].
    pub fn paths(&self, per_sample: u64) -> Option<u64> {
        let [samples] = &self.ranges[..] else {
            return None;
        };
        let count = u64::from(samples.end - samples.start);
        match self.missing {
            0 => Some(count * per_sample),
            missing => {
                // Some pixels have all, others lack so many.
                let everywhere = count.saturating_sub(u64::from(missing)) * per_sample;
                let range = everywhere + 1..=count * per_sample;
                self.paths
                    .filter(|paths| range.contains(paths) && paths % BLOCK == 0)
            }
        }
    }

    /// Which samples of each pixel it has: ascending, with gaps between.
    pub fn ranges(&self) -> &[Range<u32>] {
        &self.ranges
    }

    /// Whether every pixel has all of these samples.
    pub fn is_even(&self) -> bool {
        self.missing == 0
    }

    /// Adds another part of the same picture.
    ///
    /// # Errors
    /// It has samples that are here already, or was rendered from something else; then nothing is added.
    pub fn merge(&mut self, other: &Self) -> Result<(), PartError> {
        let [here, there] = [other, self].map(|part| listed(part.film.layers()).join(","));
        if here != there {
            let named = |list: String| match list.is_empty() {
                true => "the picture alone".to_owned(),
                false => list,
            };
            return Err(PartError::Foreigner {
                what: "the list of layers".to_owned(),
                here: named(here),
                there: named(there),
            });
        }
        self.origin.fits(&other.origin)?;
        if !self.has_size_of(&other.film) {
            return Err(PartError::Damaged("its settings don't fit"));
        }
        self.ranges = joined(self.ranges.iter().chain(&other.ranges))?;
        self.film.add(&other.film);
        self.missing = self.missing.saturating_add(other.missing);
        self.paths = None;
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
            paths: self.paths,
            layers: listed(self.film.layers()),
            origin: self.origin.clone(),
        };
        let header = serde_json::to_vec(&header)?;
        let mut hash = Hash::new();
        hash.bytes(&header);
        file.write_all(MAGIC)?;
        file.write_all(&(header.len() as u32).to_le_bytes())?;
        file.write_all(&header)?;
        // Fast, for a render may wait for it: the best is a seventh smaller in ten times the time.
        let run = Run::after(hash);
        let hashed = Hashed {
            file: &mut *file,
            run,
        };
        let mut packed = ZlibEncoder::new(hashed, Compression::fast());
        for plane in self.film.planes() {
            let plane = little_endian(bytemuck::cast_slice(plane));
            packed.write_all(bytemuck::cast_slice(&plane))?;
        }
        let Hashed { run, .. } = packed.finish()?;
        file.write_all(&run.finish().value().to_le_bytes())
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
        let is_packed = magic == MAGIC;
        if !is_packed && magic != MAGIC_PLAIN && magic != MAGIC_PLAIN_LAYERS {
            return Err(PartError::Foreign);
        }
        let header_length = header_length
            .iter()
            .rev()
            .fold(0, |n, &b| n << 8 | u32::from(b));
        let rest = length - start.len() as u64;
        if header_length > MAX_HEADER || u64::from(header_length) + 8 > rest {
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
        let layers = header.layers()?;
        if !is_packed && layers.is_picture_alone() != (magic == MAGIC_PLAIN) {
            return Err(PartError::Damaged("its header makes no sense"));
        }
        let stream = rest - u64::from(header_length) - 8;
        let pixels = u64::from(width) * u64::from(height);
        let bytes = pixels * 16 * layers.plane_count() as u64;
        let is_possible = match is_packed {
            true => bytes <= stream.saturating_mul(MOST_INFLATED),
            false => bytes == stream,
        };
        if !is_possible {
            return Err(PartError::Damaged("it has the wrong length"));
        }
        let mut film = Film::with_layers(width, height, layers);
        if is_packed {
            let run = Run::after(hash);
            let mut packed = Hashed {
                file: file.take(stream),
                run,
            };
            let unpacked = film.unpack(&mut packed, stream);
            // Of a changed file the checksum tells more than what became of it.
            io::copy(&mut packed, &mut io::sink())?;
            let Hashed { run, .. } = packed;
            check(file, &run.finish())?;
            unpacked?;
        } else {
            film.read_planes(file, |plane| hash.bytes(plane))?;
            check(file, &hash)?;
        }
        if !film.has_numbers() {
            return Err(PartError::Damaged("its layers hold no numbers"));
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
            paths: header.paths,
        })
    }
}

impl Film {
    /// Fills the planes with what is unpacked from a stream of so many bytes.
    fn unpack(&mut self, packed: &mut impl Read, length: u64) -> Result<(), PartError> {
        let mut planes = ZlibDecoder::new(packed);
        self.read_planes(&mut planes, |_| {})
            .map_err(not_unpacked)?;
        let is_at_its_end = planes.read(&mut [0]).map_err(not_unpacked)? == 0;
        match is_at_its_end && planes.total_in() == length {
            true => Ok(()),
            false => Err(PartError::Damaged("its planes are longer than its size")),
        }
    }

    /// Fills the planes, and tells of each as it lies in the file.
    fn read_planes(&mut self, from: &mut impl Read, mut tell: impl FnMut(&[u8])) -> io::Result<()> {
        for plane in &mut self.planes {
            let words: &mut [u32] = bytemuck::cast_slice_mut(plane);
            from.read_exact(bytemuck::cast_slice_mut(words))?;
            tell(bytemuck::cast_slice(words));
            words
                .iter_mut()
                .for_each(|word| *word = u32::from_le(*word));
        }
        Ok(())
    }
}

/// Compares the checksum that follows.
fn check(file: &mut impl Read, hash: &Hash) -> Result<(), PartError> {
    let mut checksum = [0; 8];
    file.read_exact(&mut checksum)?;
    match u64::from_le_bytes(checksum) == hash.value() {
        true => Ok(()),
        false => Err(PartError::Damaged("its checksum is wrong")),
    }
}

/// What is wrong with a stream that can't be unpacked.
fn not_unpacked(_: io::Error) -> PartError {
    PartError::Damaged("its planes can't be unpacked")
}

/// A file with the checksum that its bytes have: so that what a changed file is refused for otherwise can be tried.
/// `None` where it is too short or has no planes of one size.
pub fn sealed(file: &[u8]) -> Option<Vec<u8>> {
    let (rest, _) = file.split_last_chunk::<8>()?;
    let (length, data) = rest.get(MAGIC.len()..)?.split_first_chunk()?;
    let (header, planes) = data.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    let count = match file.first_chunk()? {
        MAGIC => 1,
        MAGIC_PLAIN_LAYERS => {
            let header: Header = serde_json::from_slice(header).ok()?;
            header.layers().ok()?.plane_count()
        }
        _ => PICTURE_PLANES.len(),
    };
    if planes.is_empty() || !planes.len().is_multiple_of(count) {
        return None;
    }
    let mut hash = Hash::new();
    hash.bytes(header);
    let planes = planes.chunks_exact(planes.len() / count);
    planes.for_each(|plane| hash.bytes(plane));
    Some([rest, &hash.value().to_le_bytes()].concat())
}

/// The file of a film as version 0.1 wrote it, with its planes as they are: so that changes of numbers can be tried, rather than of
/// what zlib makes of them. `None` where it is no film, or one of that form.
pub fn unpacked(file: &[u8]) -> Option<Vec<u8>> {
    let (rest, _) = file.split_last_chunk::<8>()?;
    let (length, data) = rest.strip_prefix(MAGIC)?.split_first_chunk::<4>()?;
    let (header, packed) = data.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    let layers = serde_json::from_slice::<Header>(header)
        .ok()?
        .layers()
        .ok()?;
    let magic = match layers.is_picture_alone() {
        true => MAGIC_PLAIN,
        false => MAGIC_PLAIN_LAYERS,
    };
    let mut planes = Vec::new();
    ZlibDecoder::new(packed).read_to_end(&mut planes).ok()?;
    sealed(&[magic, &length[..], header, &planes, &[0; 8]].concat())
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
mod tests;
