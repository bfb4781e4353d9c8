//! Where user textures come from: directories of `.wgsl` files, or texts in memory. Nothing is parsed here.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use texgen::SourceFile;

/// A texture larger than this is not read.
const MAX_BYTES: u64 = 4 << 20;

/// User textures by name. Where two directories hold a texture of one name, the directory named first wins.
#[derive(Debug, Clone, Default)]
pub struct TextureSources {
    by_name: BTreeMap<String, Source>,
    directories: Vec<PathBuf>,
}

#[derive(Debug, Clone)]
enum Source {
    File(PathBuf),
    Text(SourceFile),
}

/// Why user textures can't be read.
#[derive(Debug, thiserror::Error)]
pub enum SourcesError {
    /// A directory can't be listed.
    #[error("can't read the textures directory {}: {source}", path.display())]
    Directory {
        /// The directory.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A texture can't be read.
    #[error("can't read the texture {}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that can't be a texture.
    #[error("the texture {} is larger than 4 MiB: it can't be WGSL written by hand", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
}

impl TextureSources {
    /// Lists the `.wgsl` files of some directories, without those below them. No file is opened yet.
    ///
    /// # Errors
    /// A directory can't be listed.
    pub fn scan<P: AsRef<Path>>(directories: &[P]) -> Result<Self, SourcesError> {
        let mut sources = Self::default();
        for directory in directories.iter().map(AsRef::as_ref) {
            let error = |source| SourcesError::Directory {
                path: directory.to_owned(),
                source,
            };
            sources.directories.push(directory.to_owned());
            for entry in std::fs::read_dir(directory).map_err(error)? {
                let path = entry.map_err(error)?.path();
                let is_wgsl = path.extension().is_some_and(|e| e == "wgsl") && path.is_file();
                if let (true, Some(name)) = (is_wgsl, path.file_stem().and_then(|s| s.to_str())) {
                    let known = sources.by_name.entry(name.to_owned());
                    known.or_insert(Source::File(path));
                }
            }
        }
        Ok(sources)
    }

    /// Adds a texture whose text is at hand, in place of a file of that name.
    pub fn insert(&mut self, name: &str, text: &str) {
        let file = SourceFile::new(name, format!("{name}.wgsl"), text);
        self.by_name.insert(name.to_owned(), Source::Text(file));
    }

    /// All names, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// The directories that were listed, in their order.
    pub fn directories(&self) -> &[PathBuf] {
        &self.directories
    }

    /// The text of a texture; `None` where there is none of that name.
    ///
    /// # Errors
    /// The file can't be read, or is no text.
    pub fn read(&self, name: &str) -> Option<Result<SourceFile, SourcesError>> {
        Some(match self.by_name.get(name)? {
            Source::Text(file) => Ok(file.clone()),
            Source::File(path) => read_file(name, path),
        })
    }

    /// Reads a texture from a file anywhere; its name is that of the file without the ending.
    ///
    /// # Errors
    /// The file can't be read, or is no text.
    pub fn open(path: &Path) -> Result<SourceFile, SourcesError> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        read_file(&name, path)
    }

    /// The file of a texture, where it comes from one.
    pub fn path(&self, name: &str) -> Option<&Path> {
        match self.by_name.get(name)? {
            Source::File(path) => Some(path),
            Source::Text(_) => None,
        }
    }
}

fn read_file(name: &str, path: &Path) -> Result<SourceFile, SourcesError> {
    let error = |source| SourcesError::File {
        path: path.to_owned(),
        source,
    };
    if std::fs::metadata(path).map_err(error)?.len() > MAX_BYTES {
        return Err(SourcesError::TooLarge {
            path: path.to_owned(),
        });
    }
    let text = std::fs::read_to_string(path).map_err(error)?;
    Ok(SourceFile::new(name, path.display().to_string(), text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_directory_with_a_texture_of_that_name_wins() {
        let root = std::env::temp_dir().join(format!("patina-sources-{}", std::process::id()));
        let dirs = ["mine", "shipped"].map(|name| root.join(name));
        for (dir, names) in dirs.iter().zip([&["a"][..], &["a", "b"]]) {
            std::fs::create_dir_all(dir).expect("a folder");
            for name in names {
                std::fs::write(dir.join(format!("{name}.wgsl")), "").expect("a file");
            }
        }
        let sources = TextureSources::scan(&dirs).expect("both can be listed");
        assert_eq!(sources.path("a"), Some(&*dirs[0].join("a.wgsl")));
        assert_eq!(sources.path("b"), Some(&*dirs[1].join("b.wgsl")));
        let _ = std::fs::remove_dir_all(&root);
    }
}
