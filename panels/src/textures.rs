//! The user textures that nodes can be made of.

use std::collections::BTreeMap;
use std::num::NonZero;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

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
    /// Reads and parses all textures, on several threads; those of the program itself once only. It takes some milliseconds for each: not to be
    /// called for each frame.
    pub fn load(sources: &TextureSources) -> Self {
        let names: Vec<&str> = sources.names().collect();
        let threads = thread::available_parallelism().map_or(1, NonZero::get);
        let share = names.len().div_ceil(threads).max(1);
        let parts = names.chunks(share);
        let parsed: Vec<(String, Result<TextureType, Diagnostics>)> = thread::scope(|scope| {
            let workers: Vec<_> = parts
                .map(|part| {
                    scope.spawn(move || {
                        let parsed = part
                            .iter()
                            .map(|name| ((*name).to_owned(), parse(sources, name)));
                        parsed.collect::<Vec<_>>()
                    })
                })
                .collect();
            let finished = workers.into_iter().map(|worker| worker.join());
            finished.filter_map(Result::ok).flatten().collect()
        });
        let mut good = Vec::new();
        let mut broken = Vec::new();
        for (name, parsed) in parsed {
            match parsed {
                Ok(texture) => good.push(texture),
                Err(problems) => broken.push((name, problems)),
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

/// What the program's own textures are: their text never changes.
static BUILT_IN: Mutex<BTreeMap<String, TextureType>> = Mutex::new(BTreeMap::new());

fn parse(sources: &TextureSources, name: &str) -> Result<TextureType, Diagnostics> {
    let known = || BUILT_IN.lock().unwrap_or_else(PoisonError::into_inner);
    let is_built_in = sources.is_built_in(name);
    if let Some(texture) = known().get(name).filter(|_| is_built_in) {
        return Ok(texture.clone());
    }
    let file = match sources.read(name) {
        Some(file) => file.map_err(|error| Diagnostic::error(error.to_string()))?,
        None => return Err(Diagnostic::error("it is gone").into()),
    };
    let texture = TextureType::parse(file)?;
    if is_built_in {
        known().insert(name.to_owned(), texture.clone());
    }
    Ok(texture)
}
