//! The GLB container (glTF 2.0, section 4.4): finds the JSON and the binary chunk in the bytes of a file.
//!
//! Lengths are checked against the bytes that are there before anything is sliced; nothing is copied.

use crate::import::error::Fault;
use std::ops::Range;

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// Bytes of the header of a `.glb`.
pub(super) const HEADER: u64 = 12;

/// The length that a `.glb` says it has, from its header; `None` where the file is none.
pub(super) fn length(header: &[u8]) -> Option<u64> {
    let is_glb = header.starts_with(MAGIC);
    // One that ends in its header is read to its end.
    is_glb.then(|| word(header, 8).map_or(HEADER, u64::from).max(HEADER))
}

/// Where the parts of a file lie in its bytes.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Parts {
    pub(super) json: Range<usize>,
    /// The binary chunk of a GLB.
    pub(super) bin: Option<Range<usize>>,
}

/// Splits a `.glb`; anything that does not start with its magic is taken as the JSON of a `.gltf`.
pub(super) fn split(bytes: &[u8]) -> Result<Parts, Fault> {
    if !bytes.starts_with(MAGIC) {
        return Ok(Parts {
            json: 0..bytes.len(),
            bin: None,
        });
    }
    let version = word(bytes, 4)?;
    if version != 2 {
        return Err(format!("is GLB version {version}, only 2 is supported"));
    }
    let length = word(bytes, 8)? as usize;
    if length < 12 || length > bytes.len() {
        return Err(format!(
            "the header says {length} bytes, the file has {}",
            bytes.len()
        ));
    }
    // What follows the stated length is not part of the file.
    let bytes = &bytes[..length];

    let mut json = None;
    let mut bin = None;
    let mut at = 12;
    while at < bytes.len() {
        let (kind, data) = chunk(bytes, at)?;
        at = data.end;
        match (kind, &json, &bin) {
            (JSON, None, _) => json = Some(data),
            (_, None, _) => return Err("the first chunk is not JSON".into()),
            (JSON, Some(_), _) => return Err("has two JSON chunks".into()),
            (BIN, _, None) => bin = Some(data),
            (BIN, _, Some(_)) => return Err("has two binary chunks".into()),
            // The specification wants unknown chunks to be ignored.
            _ => {}
        }
    }
    Ok(Parts {
        json: json.ok_or("has no JSON chunk")?,
        bin,
    })
}

/// Type and extent of the data of the chunk whose header is at `at`.
fn chunk(bytes: &[u8], at: usize) -> Result<(u32, Range<usize>), Fault> {
    let length = word(bytes, at)? as usize;
    let kind = word(bytes, at + 4)?;
    let left = bytes.len() - (at + 8);
    if length > left {
        return Err(format!(
            "the chunk at byte {at} says {length} bytes, {left} are left"
        ));
    }
    Ok((kind, at + 8..at + 8 + length))
}

fn word(bytes: &[u8], at: usize) -> Result<u32, Fault> {
    match bytes.get(at..at + 4) {
        Some(&[a, b, c, d]) => Ok(u32::from_le_bytes([a, b, c, d])),
        _ => Err(format!("ends in the middle of a header at byte {at}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(chunks: &[(u32, &[u8])]) -> Vec<u8> {
        let mut body = Vec::new();
        for (kind, data) in chunks {
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(kind.to_le_bytes());
            body.extend(*data);
        }
        let mut file = MAGIC.to_vec();
        file.extend(2u32.to_le_bytes());
        file.extend((12 + body.len() as u32).to_le_bytes());
        file.extend(body);
        file
    }

    #[test]
    fn both_chunks_are_found_and_unknown_ones_ignored() {
        let file = glb(&[(JSON, b"{}  "), (7, b"????"), (BIN, b"data")]);
        let parts = split(&file).unwrap();
        assert_eq!(&file[parts.json], b"{}  ");
        assert_eq!(&file[parts.bin.unwrap()], b"data");
    }

    #[test]
    fn every_truncation_is_an_error_or_plain_text() {
        let file = glb(&[(JSON, b"{}  "), (BIN, b"data")]);
        for end in 4..file.len() {
            split(&file[..end]).unwrap_err();
        }
    }

    #[test]
    fn a_chunk_longer_than_the_file_is_refused() {
        let mut file = glb(&[(JSON, b"{}  ")]);
        file[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(split(&file).unwrap_err().contains("4 are left"));
    }
}
