//! The user textures that nodes can be made of.

use std::sync::Arc;

use engine::procedural::TextureSources;
use texgen::{Diagnostic, Diagnostics, Library, TextureType};

/// All textures there are, parsed.
#[derive(Debug, Clone, Default)]
pub struct Textures {
    /// Those without mistakes.
    pub library: Arc<Library>,
    /// The others, by name.
    pub broken: Vec<(String, Diagnostics)>,
    /// Where all of them come from.
    pub sources: TextureSources,
}

impl Textures {
    /// Reads and parses all textures. It takes some milliseconds for each: not to be called for each frame.
    pub fn load(sources: &TextureSources) -> Self {
        let mut good = Vec::new();
        let mut broken = Vec::new();
        for name in sources.names() {
            let parsed = match sources.read(name) {
                Some(Ok(file)) => TextureType::parse(file),
                Some(Err(error)) => Err(Diagnostic::error(error.to_string()).into()),
                None => continue,
            };
            match parsed {
                Ok(texture) => good.push(texture),
                Err(problems) => broken.push((name.to_owned(), problems)),
            }
        }
        let library = Library::new(good).unwrap_or_else(|problem| {
            broken.push((String::new(), problem.into()));
            Library::default()
        });
        Self {
            library: Arc::new(library),
            broken,
            sources: sources.clone(),
        }
    }
}
