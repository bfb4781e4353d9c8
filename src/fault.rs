//! What is said when this program has a fault: that it is one, where, and that its authors want to know.

use std::panic::{self, PanicHookInfo};

use crate::{console, progress};

/// Panics are told in this program's words from now on.
pub(crate) fn install() {
    panic::set_hook(Box::new(|info| {
        progress::clear_line();
        console::error(&text(info));
    }));
}

fn text(info: &PanicHookInfo<'_>) -> String {
    let what = info.payload_as_str().unwrap_or("it panicked");
    let place = info.location().map_or_else(String::new, |place| {
        format!(" ({}, line {})", short(place.file()), place.line())
    });
    format!(
        "Patina has a fault: {what}{place}; please report this text with the command line, and with the files if you can"
    )
}

/// A source file without the folders of the machine that this program was built on.
fn short(file: &str) -> String {
    let parts: Vec<&str> = file.split(['/', '\\']).collect();
    // Of a library: `name-1.2.3/src/lib.rs`; of this workspace: as it is.
    let is_absolute = file.starts_with(['/', '\\']) || file.get(1..2) == Some(":");
    let start = match parts.iter().rposition(|part| *part == "src") {
        Some(src) if is_absolute => src.saturating_sub(1),
        None if is_absolute => parts.len().saturating_sub(1),
        _ => 0,
    };
    parts[start..].join("/")
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn a_place_has_no_folders_of_the_machine_it_was_built_on() {
        for (file, expected) in [
            ("src/main.rs", "src/main.rs"),
            ("engine/src/renderer.rs", "engine/src/renderer.rs"),
            (
                "/home/ann/.cargo/registry/src/index/naga-30.0.1/src/back/mod.rs",
                "naga-30.0.1/src/back/mod.rs",
            ),
            ("/build/x.rs", "x.rs"),
            ("C:\\work\\patina\\src\\main.rs", "patina/src/main.rs"),
        ] {
            assert_eq!(short(file), expected);
        }
    }
}
