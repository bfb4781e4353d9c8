//! glTF's JSON: its text in a file of either kind, and lists of named things, which the draft wrote as arrays once and as objects now.

use std::path::Path;

use scene::input::{self, Files};
use serde_json::Value as Json;
use texgen::{Diagnostic, Diagnostics};

/// Longer JSON isn't read.
const MAX_BYTES: u64 = 64 << 20;
/// Header of a `.glb` file and of its first chunk.
const HEADER: u64 = 20;

/// The JSON of a `.gltf` or `.glb` file.
pub(super) fn text(files: &dyn Files, path: &Path) -> Result<String, Diagnostics> {
    let failed = |why: String| {
        let problem = Diagnostic::error(format!("cannot read {}: {why}", path.display()));
        Diagnostics::from(problem.with_note("check the path and the permissions"))
    };
    let start = files
        .read_start(path, HEADER)
        .map_err(|error| failed(error.to_string()))?;
    if !start.starts_with(b"glTF") {
        return input::read_text(files, path, MAX_BYTES).map_err(|error| failed(error.to_string()));
    }
    let Some(length) = start
        .get(12..16)
        .and_then(|bytes| bytes.try_into().ok())
        .map(u32::from_le_bytes)
    else {
        return Err(failed("the file ends too early".to_owned()));
    };
    let length = u64::from(length);
    if length > MAX_BYTES {
        return Err(failed(format!(
            "its JSON is larger than {} MiB",
            MAX_BYTES >> 20
        )));
    }
    let whole = files
        .read_start(path, HEADER + length)
        .map_err(|error| failed(error.to_string()))?;
    let json = whole.get(HEADER as usize..).unwrap_or(&[]);
    if (json.len() as u64) < length {
        return Err(failed("the file ends too early".to_owned()));
    }
    let json = &json[..length as usize];
    String::from_utf8(json.to_vec()).map_err(|_| failed("its JSON is no UTF-8".to_owned()))
}

/// A thing with its name.
#[derive(Clone, Copy)]
pub(super) struct Named<'j> {
    pub(super) name: &'j str,
    pub(super) json: &'j Json,
}

impl<'j> Named<'j> {
    pub(super) fn ty(&self) -> &'j str {
        self.json["type"].as_str().unwrap_or("")
    }
}

/// Members of an object by their keys, of an array by their `name`.
pub(super) fn named(list: &Json) -> Vec<Named<'_>> {
    match list {
        Json::Object(members) => members
            .iter()
            .map(|(name, json)| Named { name, json })
            .collect(),
        Json::Array(members) => {
            let named = |json| {
                Some(Named {
                    name: name_of(json)?,
                    json,
                })
            };
            members.iter().filter_map(named).collect()
        }
        _ => Vec::new(),
    }
}

fn name_of(json: &Json) -> Option<&str> {
    json["name"].as_str()
}

/// The name of a file from a URI, in which some characters are written as `%20`.
pub(super) fn file_name(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut out = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let code = uri
            .get(at + 1..at + 3)
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match (bytes[at], code) {
            (b'%', Some(code)) => {
                out.push(code);
                at += 3;
            }
            (byte, _) => {
                out.push(byte);
                at += 1;
            }
        }
    }
    String::from_utf8(out).unwrap_or_else(|_| uri.to_owned())
}
