//! URIs of a glTF file: bytes of `data:` URIs and of files beside it.
//!
//! Nothing is opened here: see [`crate::input`], whose files are asked what there is.

use crate::import::error::Fault;
use crate::input::Files;
use base64::Engine as _;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// What a URI stands for.
#[derive(Debug)]
pub(super) enum UriTarget {
    /// The bytes of a `data:` URI.
    Data(Vec<u8>),
    /// A file.
    File(PathBuf),
}

/// Resolves `uri`, written in a glTF file in `folder`. Does not look whether a file exists, except to choose between
/// the percent-decoded and the literal spelling.
pub(super) fn resolve(files: &dyn Files, folder: &Path, uri: &str) -> Result<UriTarget, Fault> {
    if let Some(data) = uri.strip_prefix("data:") {
        return decode_data_uri(data).map(UriTarget::Data);
    }
    if let Some(scheme) = scheme(uri) {
        return Err(format!(
            "the URI scheme \"{scheme}:\" is not supported; put the file beside the glTF file and refer to it by name"
        ));
    }
    if uri.is_empty() {
        return Err("the URI is empty".into());
    }
    let decoded = match String::from_utf8(percent_decode(uri).into_owned()) {
        Ok(text) if !text.contains('\0') => text,
        _ => return Err("the URI is not valid text".into()),
    };
    let path = folder.join(&decoded);
    // Some exporters write names with a '%' as they are.
    let literal = folder.join(uri);
    if decoded != uri && !files.has(&path) && files.has(&literal) {
        return Ok(UriTarget::File(literal));
    }
    Ok(UriTarget::File(path))
}

fn decode_data_uri(rest: &str) -> Result<Vec<u8>, Fault> {
    let (header, payload) = rest
        .split_once(',')
        .ok_or("the data URI has no comma before its data")?;
    let payload = percent_decode(payload);
    if !header.trim_end().ends_with(";base64") {
        return Ok(payload.into_owned());
    }
    // Padding is often left out, and is no reason to refuse a file.
    let engine = GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        GeneralPurposeConfig::new()
            .with_decode_padding_mode(DecodePaddingMode::Indifferent)
            .with_decode_allow_trailing_bits(true),
    );
    engine
        .decode(payload.as_ref())
        .map_err(|error| format!("the data URI is not valid base64 ({error})"))
}

/// The scheme of an absolute URI. A single letter is the drive of a Windows path.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let valid = scheme.len() > 1
        && scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme
            .bytes()
            .all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    valid.then_some(scheme)
}

/// Replaces each valid `%XX`; everything else stays.
fn percent_decode(text: &str) -> Cow<'_, [u8]> {
    if !text.contains('%') {
        return Cow::Borrowed(text.as_bytes());
    }
    let bytes = text.as_bytes();
    let hex = |at: usize| bytes.get(at).and_then(|&b| (b as char).to_digit(16));
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        match (bytes[at], hex(at + 1), hex(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                decoded.push((high * 16 + low) as u8);
                at += 3;
            }
            (byte, ..) => {
                decoded.push(byte);
                at += 1;
            }
        }
    }
    Cow::Owned(decoded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Disk;

    fn data(uri: &str) -> Result<Vec<u8>, Fault> {
        match resolve(&Disk, Path::new("."), uri)? {
            UriTarget::Data(bytes) => Ok(bytes),
            UriTarget::File(path) => panic!("{} is not data", path.display()),
        }
    }

    #[test]
    fn data_uris_decode_with_and_without_base64_and_padding() {
        assert_eq!(
            data("data:application/octet-stream;base64,AQID").unwrap(),
            [1, 2, 3]
        );
        assert_eq!(data("data:;base64,AQ").unwrap(), [1]);
        assert_eq!(data("data:text/plain,a%20b").unwrap(), b"a b");
        data("data:nothing").unwrap_err();
        data("data:;base64,###").unwrap_err();
    }

    #[test]
    fn names_with_spaces_and_unicode_become_paths() {
        for uri in ["a%20b%E2%9D%A4.bin", "a b❤.bin"] {
            match resolve(&Disk, Path::new("dir"), uri).unwrap() {
                UriTarget::File(path) => assert_eq!(path, Path::new("dir/a b❤.bin")),
                UriTarget::Data(_) => panic!("{uri} is not data"),
            }
        }
    }

    #[test]
    fn the_network_is_not_touched() {
        let message = resolve(&Disk, Path::new("."), "https://example.com/a.bin").unwrap_err();
        assert!(message.contains("https:"), "{message}");
    }
}
