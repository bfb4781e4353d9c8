//! What the tests share.

use naga::valid::{ValidationFlags, Validator};
use std::sync::Arc;

use texgen::{Diagnostics, HOST_STUB, Library, SourceFile, TextureType};

/// Parses and validates a whole WGSL module; the error is rendered with source and caret.
pub(crate) fn validate(text: &str) -> Result<naga::Module, String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
    Validator::new(ValidationFlags::all(), texgen::CAPABILITIES)
        .validate(&module)
        .map_err(|error| error.emit_to_string(text))?;
    Ok(module)
}

/// The textures in `user_textures/`, sorted by name.
pub(crate) fn shipped() -> Vec<SourceFile> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../user_textures");
    let mut files: Vec<SourceFile> = std::fs::read_dir(folder)
        .expect("the folder is part of the repository")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "wgsl")
        })
        .map(|path| {
            let name = path
                .file_stem()
                .expect("has a name")
                .to_string_lossy()
                .into_owned();
            let text = std::fs::read_to_string(&path).expect("readable");
            SourceFile::new(name.clone(), format!("user_textures/{name}.wgsl"), text)
        })
        .collect();
    files.sort_by(|a, b| a.name().cmp(b.name()));
    assert!(files.len() >= 7, "shipped textures are missing");
    files
}

/// Parses a texture called `name` whose path is `name.wgsl`.
pub(crate) fn parse(name: &str, text: &str) -> Result<TextureType, Diagnostics> {
    TextureType::parse(SourceFile::new(name, format!("{name}.wgsl"), text))
}

/// A library of valid textures.
pub(crate) fn library(textures: &[(&str, &str)]) -> Arc<Library> {
    let textures = textures
        .iter()
        .map(|(name, text)| parse(name, text).unwrap_or_else(|problems| panic!("{problems}")));
    Arc::new(Library::new(textures.collect()).expect("names differ"))
}

/// The kernel of a library, checked by naga together with the host's functions.
pub(crate) fn valid_kernel(library: &Library) -> String {
    let kernel = library.emit(8).wgsl;
    validate(&format!("{kernel}\n{HOST_STUB}")).unwrap_or_else(|problem| panic!("{problem}"));
    kernel
}

/// What the errors of a texture called `t` look like to a user.
pub(crate) fn errors(text: &str) -> String {
    errors_of("t", text)
}

/// What the errors of a texture look like to a user.
pub(crate) fn errors_of(name: &str, text: &str) -> String {
    match parse(name, text) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(problems) => problems.render(),
    }
}
