//! Files that people save while they are rendered: which of them changed, once each burst of events is over.
//!
//! Folders are watched, not files: an editor that saves by renaming leaves a watched file behind. What an event means
//! is not asked either; whoever reads the file finds out whether its contents are others.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher as _};

use crate::exit::Failure;

/// A burst is over when nothing has come for so long: an editor has written the rest of the file.
const QUIET: Duration = Duration::from_millis(40);
/// Nor does it last longer than this, however often is saved.
const LONGEST: Duration = Duration::from_millis(300);

/// What changed in a burst.
#[derive(Debug)]
pub(crate) struct Changes {
    /// A texture, or what may become one.
    pub(crate) textures: bool,
    /// The look.
    pub(crate) look: bool,
    /// The scene, what it is made of, or an image.
    pub(crate) assets: bool,
    /// Names of the files, without folders, sorted.
    pub(crate) names: Vec<String>,
    /// When the first of them was noticed.
    pub(crate) since: Instant,
}

/// What a file is, for a render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Texture,
    Look,
    Asset,
}

/// Watches the files of a render.
pub(crate) struct Watcher {
    watcher: RecommendedWatcher,
    events: Receiver<notify::Result<notify::Event>>,
    /// By where they really are.
    files: HashMap<PathBuf, Kind>,
    texture_folders: Vec<PathBuf>,
    watched: BTreeSet<PathBuf>,
    /// Size and time of assets: they are large, and being touched is not being changed.
    stamps: HashMap<PathBuf, Stamp>,
    burst: Option<Burst>,
}

type Stamp = Option<(u64, std::time::SystemTime)>;

struct Burst {
    since: Instant,
    last: Instant,
    files: BTreeSet<(PathBuf, u8)>,
}

impl Watcher {
    /// Watches these files and the textures in these folders.
    ///
    /// # Errors
    /// The system offers no way.
    pub(crate) fn new(
        files: &[PathBuf],
        look: Option<&Path>,
        textures: &[PathBuf],
    ) -> Result<Self, Failure> {
        let refused = |error| Failure::Failed(format!("can't watch files: {error}"));
        let (sender, events) = channel();
        let watcher = notify::recommended_watcher(sender).map_err(refused)?;
        let mut this = Self {
            watcher,
            events,
            files: HashMap::new(),
            texture_folders: textures.iter().map(|folder| real(folder)).collect(),
            watched: BTreeSet::new(),
            stamps: HashMap::new(),
            burst: None,
        };
        for folder in this.texture_folders.clone() {
            this.watch(folder);
        }
        this.set_files(files, look);
        Ok(this)
    }

    /// Watches these files from now on.
    pub(crate) fn set_files(&mut self, files: &[PathBuf], look: Option<&Path>) {
        let look = look.map(real);
        self.files.clear();
        for file in files {
            let path = real(file);
            let kind = match Some(&path) == look.as_ref() {
                true => Kind::Look,
                false => Kind::Asset,
            };
            if let Some(folder) = path.parent() {
                self.watch(folder.to_owned());
            }
            self.stamps
                .entry(path.clone())
                .or_insert_with(|| stamp(&path));
            self.files.insert(path, kind);
        }
    }

    fn watch(&mut self, folder: PathBuf) {
        // One that can't be watched, or isn't there, has no events.
        if !self.watched.contains(&folder)
            && (self.watcher)
                .watch(&folder, RecursiveMode::NonRecursive)
                .is_ok()
        {
            self.watched.insert(folder);
        }
    }

    /// What changed, once a burst is over; waits at most so long for events.
    pub(crate) fn wait(&mut self, longest: Duration) -> Option<Changes> {
        let end = Instant::now() + longest;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            match self.events.recv_timeout(left) {
                Ok(Ok(event)) => self.note(event),
                // Events were lost: anything may have changed.
                Ok(Err(_)) => self.note_all(),
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => break,
            }
        }
        let burst = self.burst.as_ref()?;
        let is_over = burst.last.elapsed() >= QUIET || burst.since.elapsed() >= LONGEST;
        is_over.then(|| self.take()).flatten()
    }

    fn note(&mut self, event: notify::Event) {
        if matches!(event.kind, EventKind::Access(_)) {
            return;
        }
        if event.need_rescan() {
            return self.note_all();
        }
        for path in event.paths {
            if let Some(kind) = self.kind(&path) {
                self.add(path, kind);
            }
        }
    }

    fn note_all(&mut self) {
        let files: Vec<_> = self.files.iter().map(|(p, k)| (p.clone(), *k)).collect();
        for (path, kind) in files {
            self.add(path, kind);
        }
        self.add(PathBuf::from("textures"), Kind::Texture);
    }

    fn add(&mut self, path: PathBuf, kind: Kind) {
        let now = Instant::now();
        let burst = self.burst.get_or_insert_with(|| Burst {
            since: now,
            last: now,
            files: BTreeSet::new(),
        });
        burst.last = now;
        burst.files.insert((path, kind as u8));
    }

    fn kind(&self, path: &Path) -> Option<Kind> {
        if let Some(kind) = self.files.get(path) {
            return Some(*kind);
        }
        let is_wgsl = path.extension().is_some_and(|ending| ending == "wgsl");
        let folder = path.parent()?;
        (is_wgsl && self.texture_folders.iter().any(|f| f == folder)).then_some(Kind::Texture)
    }

    fn take(&mut self) -> Option<Changes> {
        let burst = self.burst.take()?;
        let mut changes = Changes {
            textures: false,
            look: false,
            assets: false,
            names: Vec::new(),
            since: burst.since,
        };
        for (path, kind) in burst.files {
            if kind == Kind::Asset as u8 {
                let now = stamp(&path);
                if self.stamps.insert(path.clone(), now) == Some(now) {
                    continue;
                }
                changes.assets = true;
            }
            changes.textures |= kind == Kind::Texture as u8;
            changes.look |= kind == Kind::Look as u8;
            let name = path.file_name().unwrap_or_default();
            changes.names.push(name.to_string_lossy().into_owned());
        }
        (!changes.names.is_empty()).then_some(changes)
    }
}

fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.len(), meta.modified().ok()?))
}

/// Where a file or folder really is, as events name it, also where the file itself is missing.
fn real(path: &Path) -> PathBuf {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.canonicalize().unwrap_or_else(|_| path.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// What comes within some seconds.
    fn next(watcher: &mut Watcher) -> Option<Changes> {
        let end = Instant::now() + Duration::from_secs(10);
        while Instant::now() < end {
            if let Some(changes) = watcher.wait(Duration::from_millis(10)) {
                return Some(changes);
            }
        }
        None
    }

    #[test]
    fn bursts_of_saves_are_one_change() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("textures")).expect("a folder");
        for name in ["a.look.toml", "a.gltf", "other.txt", "textures/t.wgsl"] {
            fs::write(path(name), "old").expect("written");
        }
        let files = [path("a.gltf"), path("a.look.toml")];
        let look = path("a.look.toml");
        let mut watcher = Watcher::new(&files, Some(&look), &[path("textures")]).expect("watched");
        // An editor that writes aside and renames, several times, and files that nobody watches.
        for i in 0..5 {
            fs::write(path("textures/t.tmp"), format!("{i}")).expect("written");
            fs::rename(path("textures/t.tmp"), path("textures/t.wgsl")).expect("renamed");
            fs::write(path("other.txt"), "new").expect("written");
        }
        let changes = next(&mut watcher).expect("noticed");
        assert!(
            changes.textures && !changes.look && !changes.assets,
            "{changes:?}"
        );
        assert_eq!(changes.names, ["t.wgsl"]);

        fs::write(&look, "new").expect("written");
        fs::remove_file(path("a.gltf")).expect("removed");
        let changes = next(&mut watcher).expect("noticed");
        assert!(
            changes.look && changes.assets && !changes.textures,
            "{changes:?}"
        );
        fs::write(path("a.gltf"), "another").expect("written");
        let changes = next(&mut watcher).expect("noticed");
        assert_eq!(changes.names, ["a.gltf"]);
        // A folder that is removed, and a file that is only looked at.
        let _ = fs::read(path("a.gltf"));
        assert!(watcher.wait(Duration::from_millis(200)).is_none());
    }
}
