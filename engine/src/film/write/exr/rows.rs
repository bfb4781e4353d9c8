//! The rows of a file, block by block as they come: only those are in memory of which a block is made.

use std::io::{self, Seek, SeekFrom, Write};

use exr::block::lines::LineRefMut;
use exr::block::writer::ChunksWriter;
use exr::block::{self, UncompressedBlock};
use exr::error::{Error, UnitResult};
use exr::image::FlatSamples;
use exr::meta::attribute;
use exr::meta::header::Header;
use exr::meta::{Headers, MetaData};

use super::Channels;

/// Longest name of a channel in files whose version doesn't tell of longer ones, bytes.
const SHORT_NAME: usize = 31;
/// Where the flags of a file's version begin, and that of long names among them (OpenEXR file layout, "version field").
const FLAGS: u64 = 5;
const LONG_NAMES: u8 = 0x04;

/// Writes a file of rows that come in bands, of which each has all channels of the header, in its order.
pub(super) fn write(
    mut file: impl Write + Seek,
    header: Header,
    bands: impl Iterator<Item = io::Result<Channels>>,
) -> io::Result<()> {
    let attributes = sorted_attributes(&header).map_err(refused)?;
    let mut channels = header.channels.list.iter();
    let has_long_names = channels.any(|channel| channel.name.as_slice().len() > SHORT_NAME);
    let headers = Headers::from_iter([header]);
    let written = block::write(&mut file, headers, true, |meta, chunks| {
        // There is no pool of threads where nothing is packed.
        if let Some(mut pool) = chunks.parallel_blocks_compressor(&meta) {
            return feed(&meta, bands, |number, block| {
                pool.add_block_to_compression_queue(number, block)
            });
        }
        let mut alone = chunks.sequential_blocks_compressor(&meta);
        feed(&meta, bands, |number, block| {
            alone.compress_block(number, block)
        })
    });
    written.map_err(refused)?;
    if has_long_names {
        // The crate knows of none. Other flags are those of tiles, deep data and several parts, which there aren't.
        file.seek(SeekFrom::Start(FLAGS))?;
        file.write_all(&[LONG_NAMES])?;
    }
    // They begin behind the magic number and the version. Their order doesn't change how long they are.
    file.seek(SeekFrom::Start(8))?;
    file.write_all(&attributes)
}

fn refused(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

/// The attributes of a header as they lie in a file, by name: the crate keeps ours in a hash map and writes them in another
/// order each time, but the same picture is to be the same file.
fn sorted_attributes(header: &Header) -> exr::error::Result<Vec<u8>> {
    let mut attributes: Vec<_> = header.all_named_attributes().collect();
    attributes.sort_by_key(|(name, _)| *name);
    let mut bytes = Vec::new();
    for (name, value) in &attributes {
        attribute::write(name, value, &mut bytes)?;
    }
    Ok(bytes)
}

/// Cuts bands into the blocks of the file, and passes them on in its order.
fn feed(
    meta: &MetaData,
    mut bands: impl Iterator<Item = io::Result<Channels>>,
    mut pass_on: impl FnMut(usize, UncompressedBlock) -> UnitResult,
) -> UnitResult {
    let header = &meta.headers[0];
    let mut window = Window {
        columns: header.layer_size.width(),
        first: 0,
        rows: 0,
        channels: Vec::new(),
    };
    for (number, index) in block::enumerate_ordered_header_block_indices(&meta.headers) {
        let (top, height) = (index.pixel_position.y(), index.pixel_size.height());
        while window.first + window.rows < top + height {
            let Some(band) = bands.next().transpose()? else {
                return Err(Error::Invalid("fewer rows than the picture has".into()));
            };
            window.drop_before(top);
            window.push(band)?;
        }
        let block =
            UncompressedBlock::from_lines(&header.channels, index, |line| window.fill(line));
        pass_on(number, block)?;
    }
    Ok(())
}

/// The rows of which blocks are being made.
struct Window {
    columns: usize,
    /// Row of the picture.
    first: usize,
    rows: usize,
    /// In the order of the header.
    channels: Vec<FlatSamples>,
}

impl Window {
    /// Forgets the rows above.
    fn drop_before(&mut self, row: usize) {
        let gone = row.saturating_sub(self.first).min(self.rows);
        let numbers = ..gone * self.columns;
        for channel in &mut self.channels {
            match channel {
                FlatSamples::F16(samples) => drop(samples.drain(numbers)),
                FlatSamples::F32(samples) => drop(samples.drain(numbers)),
                FlatSamples::U32(samples) => drop(samples.drain(numbers)),
            }
        }
        self.first += gone;
        self.rows -= gone;
    }

    /// Adds the rows below.
    fn push(&mut self, band: Channels) -> UnitResult {
        let count = band.first().map_or(0, |(_, samples)| samples.len());
        let band = band.into_iter().map(|(_, samples)| samples);
        let differs = || Error::Invalid("rows with other channels than those before".into());
        if self.rows == 0 {
            self.channels = band.collect();
        } else {
            if band.len() != self.channels.len() {
                return Err(differs());
            }
            for (channel, more) in self.channels.iter_mut().zip(band) {
                match (channel, more) {
                    (FlatSamples::F16(channel), FlatSamples::F16(more)) => channel.extend(more),
                    (FlatSamples::F32(channel), FlatSamples::F32(more)) => channel.extend(more),
                    (FlatSamples::U32(channel), FlatSamples::U32(more)) => channel.extend(more),
                    _ => return Err(differs()),
                }
            }
        }
        self.rows += count / self.columns;
        match count > 0 && count.is_multiple_of(self.columns) {
            true => Ok(()),
            false => Err(Error::Invalid("rows that aren't whole".into())),
        }
    }

    /// One row of one channel.
    fn fill(&self, line: LineRefMut<'_>) {
        let place = line.location;
        let start = (place.position.y() - self.first) * self.columns + place.position.x();
        let numbers = start..start + place.sample_count;
        let written = match &self.channels[place.channel] {
            FlatSamples::F16(samples) => line.write_samples_from_slice(&samples[numbers]),
            FlatSamples::F32(samples) => line.write_samples_from_slice(&samples[numbers]),
            FlatSamples::U32(samples) => line.write_samples_from_slice(&samples[numbers]),
        };
        written.expect("memory takes everything");
    }
}
