//! Textures: what texgen accepts is valid in the kernel, what it refuses is refused at a place.

use std::str;

use naga::valid::{ValidationFlags, Validator};
use texgen::{HOST_STUB, Library, SourceFile, TextureType};

use crate::{check_report, memory, seeds};

/// Held beside what the text needs: naga's modules of the prelude and of the kernel.
const SLACK: usize = 64 << 20;
/// A byte of a text is a few nodes of trees.
const PER_BYTE: usize = 256;

pub(crate) fn run(data: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(data) else {
        return false;
    };
    memory::within(text.len() * PER_BYTE, SLACK, || check(text))
}

fn check(text: &str) -> bool {
    match parse("input", text) {
        Ok(texture) => {
            // It shares the kernel with others, as in a scene.
            let other = parse("other", seeds::RICH).unwrap_or_else(|error| panic!("{error}"));
            let library = Library::new(vec![texture, other]).expect("names differ");
            validate(&library.emit(8).wgsl);
            true
        }
        Err(problems) => {
            assert!(!problems.is_empty(), "refused without a reason");
            check_report(&problems);
            for problem in &problems {
                assert!(problem.location().is_some(), "without a place: {problem}");
                let blames_us = |note: &String| note.contains("please report");
                assert!(
                    !problem.notes.iter().any(blames_us),
                    "valid as a texture, but not in the kernel: {problem}"
                );
            }
            false
        }
    }
}

fn parse(name: &str, text: &str) -> Result<TextureType, texgen::Diagnostics> {
    TextureType::parse(SourceFile::new(name, format!("{name}.wgsl"), text))
}

/// The generated kernel by itself, with stand-ins for what the engine offers.
fn validate(kernel: &str) {
    let text = format!("{kernel}\n{HOST_STUB}");
    let module = naga::front::wgsl::parse_str(&text)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    Validator::new(ValidationFlags::all(), texgen::CAPABILITIES)
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
}
