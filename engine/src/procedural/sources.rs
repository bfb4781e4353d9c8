//! Where textures come from: directories of `.wgsl` files, the program itself, or texts in memory. Nothing is parsed here.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use texgen::{SourceFile, used_libraries};

use super::standard;
use crate::input::{self, Disk, Files};

/// The folder beside textures that holds the files which they share.
pub const LIBRARIES: &str = "lib";

/// No more shared files than this are read for one texture.
const MAX_LIBRARIES: usize = 64;

/// A texture larger than this is not read.
const MAX_BYTES: u64 = 4 << 20;

/// User textures by name. Where two directories hold a texture of one name, the directory named first wins.
#[derive(Debug, Clone)]
pub struct TextureSources {
    /// Where the directories are, and the images that looks name.
    files: Arc<dyn Files>,
    by_name: BTreeMap<String, TextureOrigin>,
    directories: Vec<PathBuf>,
    /// The program's own textures are behind the directories.
    has_standard: bool,
}

impl Default for TextureSources {
    /// None; images are on the disk.
    fn default() -> Self {
        Self {
            files: Arc::new(Disk),
            by_name: BTreeMap::new(),
            directories: Vec::new(),
            has_standard: false,
        }
    }
}

#[derive(Debug, Clone)]
enum TextureOrigin {
    File(PathBuf),
    Text(SourceFile),
    BuiltIn(SourceFile),
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
    /// A shared file that no texture can name.
    #[error(
        "no texture can use a shared file of this name: {}; letters, digits, `_` and `-` are what it may have",
        path.display()
    )]
    SharedName {
        /// The file.
        path: PathBuf,
    },
}

impl TextureSources {
    /// Lists the `.wgsl` files of some directories on the disk, without those below them. No file is opened yet.
    ///
    /// # Errors
    /// A directory can't be listed.
    pub fn scan<P: AsRef<Path>>(directories: &[P]) -> Result<Self, SourcesError> {
        Self::scan_from(Arc::new(Disk), directories)
    }

    fn scan_from<P: AsRef<Path>>(
        files: Arc<dyn Files>,
        directories: &[P],
    ) -> Result<Self, SourcesError> {
        let mut sources = Self {
            files,
            ..Self::default()
        };
        for directory in directories.iter().map(AsRef::as_ref) {
            let error = |source| SourcesError::Directory {
                path: directory.to_owned(),
                source,
            };
            sources.directories.push(directory.to_owned());
            for path in sources.files.list(directory).map_err(error)? {
                let is_wgsl = path.extension().is_some_and(|e| e == "wgsl");
                if let (true, Some(name)) = (is_wgsl, path.file_stem().and_then(|s| s.to_str())) {
                    let known = sources.by_name.entry(name.to_owned());
                    known.or_insert(TextureOrigin::File(path));
                }
            }
        }
        Ok(sources)
    }

    /// As [`scan`](Self::scan), with the standard textures behind the directories: a file of the same name wins.
    ///
    /// # Errors
    /// As [`scan`](Self::scan).
    pub fn search<P: AsRef<Path>>(directories: &[P]) -> Result<Self, SourcesError> {
        Self::search_from(Arc::new(Disk), directories)
    }

    /// As [`search`](Self::search), in files of one's own. Images that looks name are read from them, too.
    ///
    /// # Errors
    /// As [`scan`](Self::scan).
    pub fn search_from<P: AsRef<Path>>(
        files: Arc<dyn Files>,
        directories: &[P],
    ) -> Result<Self, SourcesError> {
        let mut sources = Self::scan_from(files, directories)?;
        sources.has_standard = true;
        for file in standard::files() {
            let known = sources.by_name.entry(file.name().to_owned());
            known.or_insert(TextureOrigin::BuiltIn(file));
        }
        Ok(sources)
    }

    /// Adds a texture whose text is at hand, in place of a file of that name.
    pub fn insert(&mut self, name: &str, text: &str) {
        let file = SourceFile::new(name, format!("{name}.wgsl"), text);
        self.by_name
            .insert(name.to_owned(), TextureOrigin::Text(file));
    }

    /// Adds a texture whose text and shared files are at hand, in place of a file of its name.
    pub fn insert_file(&mut self, file: SourceFile) {
        let name = file.name().to_owned();
        self.by_name.insert(name, TextureOrigin::Text(file));
    }

    /// Adds a texture from a file anywhere on the disk, in place of one of that name, and returns its name. It is read now.
    ///
    /// # Errors
    /// The file can't be read, or is no text.
    pub fn add_file(&mut self, path: &Path) -> Result<String, SourcesError> {
        let file = Self::open(path)?;
        let name = file.name().to_owned();
        self.by_name.insert(name.clone(), TextureOrigin::Text(file));
        Ok(name)
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
        let Some(origin) = self.by_name.get(name) else {
            // Those that MaterialX's nodes become are found by their names, but listed nowhere.
            return self
                .has_standard
                .then(|| materialx::textures::find(name))
                .flatten()
                .map(Ok);
        };
        Some(match origin {
            TextureOrigin::Text(file) | TextureOrigin::BuiltIn(file) => Ok(file.clone()),
            TextureOrigin::File(path) => read_file(&*self.files, name, path)
                .and_then(|file| with_libraries(&*self.files, file, path)),
        })
    }

    /// The files that it reads from.
    pub(crate) fn files(&self) -> &Arc<dyn Files> {
        &self.files
    }

    /// Reads a texture from a file anywhere on the disk; its name is that of the file without the ending. A standard texture's
    /// path, as messages have it, gives that texture.
    ///
    /// # Errors
    /// The file can't be read, or is no text.
    pub fn open(path: &Path) -> Result<SourceFile, SourcesError> {
        if let Some(file) = standard::at(path).or_else(|| materialx::textures::at(path)) {
            return Ok(file);
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        read_file(&Disk, &name, path).and_then(|file| with_libraries(&Disk, file, path))
    }

    /// Whether there is no texture of that name.
    pub(crate) fn is_missing(&self, name: &str) -> bool {
        !self.by_name.contains_key(name) && !self.is_built_in(name)
    }

    /// A texture that does nothing but use a shared file, by which that can be checked; `None` where there are no shared files in the
    /// folder of the path.
    ///
    /// # Errors
    /// The file, or one that it uses, can't be read; no texture can use a file of its name.
    pub fn user_of(path: &Path) -> Option<Result<SourceFile, SourcesError>> {
        let folder = path.parent()?;
        let textures = (folder.file_name()? == LIBRARIES).then(|| folder.parent())??;
        let name = path.file_stem()?.to_string_lossy();
        if !is_shared_name(&name) {
            let path = path.to_owned();
            return Some(Err(SourcesError::SharedName { path }));
        }
        let text = format!("/// @use {name}\nfn userProc() -> f32 {{ return 0.0; }}\n");
        let file = SourceFile::new(&*name, path.display().to_string(), text);
        Some(with_libraries(&Disk, file, &textures.join(&*name)))
    }

    /// The file of a texture, where it comes from one.
    pub fn path(&self, name: &str) -> Option<&Path> {
        match self.by_name.get(name)? {
            TextureOrigin::File(path) => Some(path),
            TextureOrigin::Text(_) | TextureOrigin::BuiltIn(_) => None,
        }
    }

    /// Whether a texture is the program's own, of the standard ones.
    pub fn is_built_in(&self, name: &str) -> bool {
        match self.by_name.get(name) {
            Some(origin) => matches!(origin, TextureOrigin::BuiltIn(_)),
            None => self.has_standard && materialx::textures::names().any(|known| known == name),
        }
    }
}

fn read_file(files: &dyn Files, name: &str, path: &Path) -> Result<SourceFile, SourcesError> {
    let error = |source| SourcesError::File {
        path: path.to_owned(),
        source,
    };
    let text = input::read_text(files, path, MAX_BYTES).map_err(|source| match source.kind() {
        ErrorKind::FileTooLarge => SourcesError::TooLarge {
            path: path.to_owned(),
        },
        _ => error(source),
    })?;
    Ok(SourceFile::new(name, path.display().to_string(), text))
}

/// The file with the shared files beside it that it uses, in `lib`. Those that aren't there are left out: the texture's errors
/// say so.
fn with_libraries(
    files: &dyn Files,
    file: SourceFile,
    path: &Path,
) -> Result<SourceFile, SourcesError> {
    let folder = path.parent().unwrap_or(Path::new("")).join(LIBRARIES);
    let mut wanted = used_libraries(file.text());
    let mut found: Vec<SourceFile> = Vec::new();
    let mut missing: BTreeSet<String> = BTreeSet::new();
    while let Some(name) = wanted.pop() {
        let known = missing.contains(&name) || found.iter().any(|one| one.name() == name);
        if !is_shared_name(&name) || known || found.len() >= MAX_LIBRARIES {
            continue;
        }
        match read_file(files, &name, &folder.join(format!("{name}.wgsl"))) {
            Ok(library) => {
                wanted.extend(used_libraries(library.text()));
                found.push(library);
            }
            Err(SourcesError::File { source, .. }) if source.kind() == ErrorKind::NotFound => {
                missing.insert(name);
            }
            Err(error) => return Err(error),
        }
    }
    Ok(match found.is_empty() {
        true => file,
        false => file.with_libraries(found),
    })
}

/// Whether a texture can use a shared file of this name. A name is no path: what is used lies in one folder.
fn is_shared_name(name: &str) -> bool {
    name.chars()
        .all(|c| c.is_alphanumeric() || "_-".contains(c))
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

    #[test]
    fn shared_files_come_with_the_textures_that_use_them() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("a file");
        };
        std::fs::create_dir(folder.path().join(LIBRARIES)).expect("a folder");
        write(
            "t.wgsl",
            "/// @use a, missing, ../t\nfn userProc() -> f32 { return f(); }",
        );
        write("lib/a.wgsl", "/// @use b\nfn f() -> f32 { return g(); }");
        write("lib/b.wgsl", "/// @use a\nfn g() -> f32 { return 1.0; }");
        let sources = TextureSources::scan(&[folder.path()]).expect("can be listed");
        assert_eq!(sources.names().collect::<Vec<_>>(), ["t"]);
        let file = sources.read("t").expect("is there").expect("is text");
        let names: Vec<&str> = file.libraries().iter().map(SourceFile::name).collect();
        assert_eq!(names, ["a", "b"]);
        let opened = TextureSources::open(&folder.path().join("t.wgsl")).expect("is text");
        assert_eq!(opened.libraries(), file.libraries());
        let user = |name: &str| {
            let path = folder.path().join(LIBRARIES).join(name);
            TextureSources::user_of(&path).expect("lies among shared files")
        };
        assert_eq!(user("b.wgsl").expect("is text").libraries().len(), 2);
        let refused = user("my.noise.wgsl").expect_err("no texture can name it");
        assert!(refused.to_string().contains("my.noise.wgsl"), "{refused}");
        // An edit of a shared file makes the texture another one.
        write("lib/b.wgsl", "fn g() -> f32 { return 2.0; }");
        let again = sources.read("t").expect("is there").expect("is text");
        assert!(again.text() == file.text() && again.libraries() != file.libraries());
    }

    #[test]
    fn the_standard_textures_need_no_folder_and_give_way_to_files() {
        let nowhere: [&Path; 0] = [];
        let sources = TextureSources::search(&nowhere).expect("nothing to list");
        assert!(sources.is_built_in("fbm") && sources.path("fbm").is_none());
        let file = sources.read("fbm").expect("is there").expect("is text");
        assert_eq!(file.path(), "<built-in>/fbm.wgsl");
        let again = TextureSources::open(Path::new(file.path())).expect("the name leads back");
        assert_eq!(again.text(), file.text());

        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("fbm.wgsl"), "mine").expect("a file");
        let sources = TextureSources::search(&[folder.path()]).expect("can be listed");
        assert!(!sources.is_built_in("fbm") && sources.is_built_in("voronoi"));
        let file = sources.read("fbm").expect("is there").expect("is text");
        assert_eq!(file.text(), "mine");
    }
}
