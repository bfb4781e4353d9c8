//! Files that people save while they are rendered: which of them changed, once each burst of events is over.
//!
//! Folders are watched, not files: an editor that saves by renaming leaves a watched file behind. What an event means
//! is not asked either; whoever reads the file finds out whether its contents are others.
//!
//! Events are quick, but not all there is: a folder that is moved away or made anew takes its watch along, a link's target
//! lies elsewhere, and some file systems have no events. So all files are also looked at twice a second.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant, SystemTime};

use engine::aside;
use engine::procedural::LIBRARIES;
use notify::event::{AccessKind, AccessMode, ModifyKind, RenameMode};
use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher as _};

use crate::failure::Failure;

/// A burst is over when nothing has come for so long: an editor has written the rest of the file.
const QUIET: Duration = Duration::from_millis(40);
/// The same where all files are known to be whole, because they were closed or renamed last: other files that are saved
/// together with them have come by then.
const QUIET_WHEN_WHOLE: Duration = Duration::from_millis(5);
/// Nor does it last longer than this, however often is saved.
const LONGEST: Duration = Duration::from_millis(300);
/// How often files are looked at without an event.
const INTERVAL: Duration = Duration::from_millis(500);

/// How coarsely file systems tell times, and how far their clocks may be behind.
const CLOCKS: Duration = Duration::from_secs(2);

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
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Texture,
    Look,
    Asset,
}

/// Watches the files of a render.
pub(crate) struct Watcher {
    watcher: RecommendedWatcher,
    events: Receiver<notify::Result<notify::Event>>,
    /// By absolute paths in which the names are those that were given.
    files: HashMap<PathBuf, Kind>,
    texture_folders: Vec<PathBuf>,
    /// What events may call a file that is reached through links.
    aliases: HashMap<PathBuf, PathBuf>,
    /// Folders with events, and which folder each of them was when that began.
    watched: BTreeMap<PathBuf, Stamp>,
    /// Files that are younger may have been read before they were saved.
    since: SystemTime,
    /// What files were like when they were told of, or first met. Those of textures are in here too.
    stamps: HashMap<PathBuf, Stamp>,
    looked: Instant,
    burst: Option<Burst>,
}

/// What tells a file from its former self without being read; none where it isn't there.
type Stamp = Option<(u64, SystemTime, u64)>;

struct Burst {
    since: Instant,
    last: Instant,
    files: BTreeSet<(PathBuf, Kind)>,
    /// Those of them that somebody may still be writing.
    unfinished: BTreeSet<PathBuf>,
}

impl Burst {
    /// When it is over, should nothing come.
    fn end(&self) -> Instant {
        let quiet = match self.unfinished.is_empty() {
            true => QUIET_WHEN_WHOLE,
            false => QUIET,
        };
        (self.last + quiet).min(self.since + LONGEST)
    }
}

/// What an event says of whether a file is all there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Progress {
    Whole,
    Unfinished,
    /// Nothing.
    Same,
}

fn progress(kind: &EventKind) -> Progress {
    match kind {
        EventKind::Access(AccessKind::Close(AccessMode::Write))
        | EventKind::Modify(ModifyKind::Name(RenameMode::To | RenameMode::Both)) => Progress::Whole,
        EventKind::Modify(ModifyKind::Metadata(_)) => Progress::Same,
        _ => Progress::Unfinished,
    }
}

/// That a file was read says nothing of it.
fn says_something(kind: &EventKind) -> bool {
    !matches!(kind, EventKind::Access(_)) || progress(kind) == Progress::Whole
}

impl Watcher {
    /// Watches these files and the textures in these folders. What has been saved `since` it was read, or may have been, counts as
    /// changed: whoever follows compares contents.
    ///
    /// # Errors
    /// The system offers no way.
    pub(crate) fn new(
        files: &[PathBuf],
        look: Option<&Path>,
        textures: &[PathBuf],
        since: SystemTime,
    ) -> Result<Self, Failure> {
        Self::telling(files, look, textures, since, || {})
    }

    /// As [`Self::new`], and calls `wake` on a thread of its own when there is something to [wait](Self::wait) for.
    ///
    /// # Errors
    /// As there.
    pub(crate) fn telling(
        files: &[PathBuf],
        look: Option<&Path>,
        textures: &[PathBuf],
        since: SystemTime,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, Failure> {
        let refused = |error| Failure::Failed(format!("can't watch files: {error}"));
        let (sender, events) = channel();
        let hear = move |event: notify::Result<notify::Event>| {
            let is_news = match &event {
                Ok(event) => says_something(&event.kind),
                Err(_) => true,
            };
            // Where nobody listens, nobody is to be woken.
            if is_news && sender.send(event).is_ok() {
                wake();
            }
        };
        let watcher = notify::recommended_watcher(hear).map_err(refused)?;
        let mut this = Self {
            watcher,
            events,
            files: HashMap::new(),
            // What textures share lies in a folder of its own.
            texture_folders: (textures.iter().map(|folder| absolute(folder)))
                .flat_map(|folder| [folder.join(LIBRARIES), folder])
                .collect(),
            aliases: HashMap::new(),
            watched: BTreeMap::new(),
            since: since - CLOCKS,
            stamps: HashMap::new(),
            looked: Instant::now(),
            burst: None,
        };
        for folder in this.texture_folders.clone() {
            this.watch(folder);
        }
        for texture in this.textures() {
            let first = this.first_stamp(&texture);
            this.stamps.insert(texture, first);
        }
        this.set_files(files, look);
        Ok(this)
    }

    /// Watches these files from now on.
    pub(crate) fn set_files(&mut self, files: &[PathBuf], look: Option<&Path>) {
        let look = look.map(absolute);
        self.files.clear();
        for file in files {
            let path = absolute(file);
            let kind = match Some(&path) == look.as_ref() {
                true => Kind::Look,
                false => Kind::Asset,
            };
            if !self.stamps.contains_key(&path) {
                self.stamps.insert(path.clone(), self.first_stamp(&path));
            }
            self.watch(aside::folder_of(&path).to_owned());
            self.follow(&path);
            self.files.insert(path, kind);
        }
    }

    /// That of a file when it is first met: none, so that it is looked at once more, if it may have been read before it was saved.
    fn first_stamp(&self, path: &Path) -> Stamp {
        stamp(path).filter(|(_, changed, _)| *changed <= self.since)
    }

    /// Events call a file by where it really is.
    fn follow(&mut self, path: &Path) {
        if let Ok(target) = path.canonicalize()
            && target != path
        {
            self.watch(aside::folder_of(&target).to_owned());
            self.aliases.insert(target, path.to_owned());
        }
    }

    fn watch(&mut self, folder: PathBuf) {
        let now = identity(&folder);
        // One that can't be watched, or isn't there, has no events.
        if now.is_some()
            && self.watched.get(&folder) != Some(&now)
            && (self.watcher)
                .watch(&folder, RecursiveMode::NonRecursive)
                .is_ok()
        {
            self.watched.insert(folder, now);
        }
    }

    /// How long nothing is to be expected of [`Self::wait`], unless an event comes.
    pub(crate) fn patience(&self) -> Duration {
        let burst = self.burst.as_ref();
        burst.map_or(Duration::MAX, |burst| {
            burst.end().saturating_duration_since(Instant::now())
        })
    }

    /// What changed, as soon as a burst is over; waits at most so long for that.
    pub(crate) fn wait(&mut self, longest: Duration) -> Option<Changes> {
        let end = Instant::now() + longest;
        loop {
            let over = self.burst.as_ref().map_or(end, Burst::end);
            let left = end.min(over).saturating_duration_since(Instant::now());
            match self.events.recv_timeout(left) {
                Ok(Ok(event)) => self.note(event),
                // Events were lost: anything may have changed.
                Ok(Err(_)) => self.note_all(),
                Err(RecvTimeoutError::Timeout) => break,
                // There is nobody to send any: the files are looked at all the same.
                Err(RecvTimeoutError::Disconnected) => {
                    std::thread::sleep(left);
                    break;
                }
            }
        }
        if self.looked.elapsed() >= INTERVAL {
            self.look_at_all();
            self.looked = Instant::now();
        }
        let burst = self.burst.as_ref()?;
        let is_over = Instant::now() >= burst.end();
        is_over.then(|| self.take()).flatten()
    }

    fn note(&mut self, event: notify::Event) {
        let progress = progress(&event.kind);
        if event.need_rescan() {
            return self.note_all();
        }
        for path in event.paths {
            if let Some(path) = self.aliases.get(&path).cloned() {
                // The link or its target may be another one now.
                self.follow(&path);
                self.add_known(path, progress);
                continue;
            }
            // A folder that was moved or removed: its watch is gone, or looks elsewhere.
            if matches!(event.kind, EventKind::Remove(_) | EventKind::Modify(_))
                && self.watched.remove(&path).is_some()
            {
                // It may not have been watched any more.
                let _ = self.watcher.unwatch(&path);
                continue;
            }
            self.add_known(path, progress);
        }
    }

    fn add_known(&mut self, path: PathBuf, progress: Progress) {
        if let Some(kind) = self.kind(&path) {
            self.add(path, kind, progress);
        }
    }

    fn note_all(&mut self) {
        let files: Vec<_> = self.files.iter().map(|(p, k)| (p.clone(), *k)).collect();
        for (path, kind) in files {
            self.add(path, kind, Progress::Unfinished);
        }
        let all = PathBuf::from("textures");
        self.add(all, Kind::Texture, Progress::Unfinished);
    }

    /// Notes what has another stamp than it had, and has folders watched that are others than they were.
    fn look_at_all(&mut self) {
        let folders: BTreeSet<PathBuf> = (self.files.keys())
            .map(|path| aside::folder_of(path).to_owned())
            .chain(self.texture_folders.iter().cloned())
            .collect();
        for folder in folders {
            self.watch(folder);
        }
        let known_textures = self.stamps.keys().filter(|path| self.is_texture(path));
        let textures: BTreeSet<PathBuf> = known_textures.cloned().chain(self.textures()).collect();
        let files = self.files.iter().map(|(path, kind)| (path.clone(), *kind));
        let all: Vec<(PathBuf, Kind)> = files
            .chain(textures.into_iter().map(|path| (path, Kind::Texture)))
            .collect();
        for (path, kind) in all {
            let is_waiting = |burst: &Burst| burst.files.contains(&(path.clone(), kind));
            if stamp(&path) != self.stamps.get(&path).copied().flatten()
                && !self.burst.as_ref().is_some_and(is_waiting)
            {
                self.follow(&path);
                self.add(path, kind, Progress::Unfinished);
            }
        }
    }

    /// Textures that there are now.
    fn textures(&self) -> Vec<PathBuf> {
        let listed = self.texture_folders.iter().flat_map(std::fs::read_dir);
        let entries = listed.flatten().flatten().map(|entry| entry.path());
        entries.filter(|path| is_wgsl(path)).collect()
    }

    fn add(&mut self, path: PathBuf, kind: Kind, progress: Progress) {
        let now = Instant::now();
        let burst = self.burst.get_or_insert_with(|| Burst {
            since: now,
            last: now,
            files: BTreeSet::new(),
            unfinished: BTreeSet::new(),
        });
        burst.last = now;
        match progress {
            Progress::Whole => burst.unfinished.remove(&path),
            Progress::Unfinished => burst.unfinished.insert(path.clone()),
            Progress::Same => false,
        };
        burst.files.insert((path, kind));
    }

    fn kind(&self, path: &Path) -> Option<Kind> {
        let known = self.files.get(path).copied();
        known.or_else(|| self.is_texture(path).then_some(Kind::Texture))
    }

    fn is_texture(&self, path: &Path) -> bool {
        let folder = path.parent();
        is_wgsl(path)
            && self
                .texture_folders
                .iter()
                .any(|f| Some(f.as_path()) == folder)
    }

    fn take(&mut self) -> Option<Changes> {
        let mut burst = self.burst.take()?;
        if burst.files.iter().any(|(_, kind)| *kind == Kind::Texture) {
            // All textures are read for one of them: what else has changed belongs to it, whatever events say.
            let changed = self.stamps.iter().filter(|&(path, known)| {
                known.is_some() && self.is_texture(path) && stamp(path) != *known
            });
            let changed = changed.map(|(path, _)| (path.clone(), Kind::Texture));
            burst.files.extend(changed);
        }
        let mut changes = Changes {
            textures: false,
            look: false,
            assets: false,
            names: Vec::new(),
            since: burst.since,
        };
        for (path, kind) in burst.files {
            // A link may point to another file by now.
            self.follow(&path);
            let now = stamp(&path);
            let before = self.stamps.insert(path.clone(), now);
            if kind == Kind::Asset {
                // They are large, and being touched is not being changed.
                if before == Some(now) {
                    continue;
                }
                changes.assets = true;
            }
            changes.textures |= kind == Kind::Texture;
            changes.look |= kind == Kind::Look;
            let name = path.file_name().unwrap_or_default();
            changes.names.push(name.to_string_lossy().into_owned());
        }
        (!changes.names.is_empty()).then_some(changes)
    }
}

fn is_wgsl(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "wgsl")
}

/// Of what a path leads to, through links.
fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.len(), meta.modified().ok()?, number(&meta)))
}

/// Which folder it is: its contents don't matter.
fn identity(folder: &Path) -> Stamp {
    let meta = std::fs::metadata(folder).ok()?;
    Some((0, SystemTime::UNIX_EPOCH, number(&meta)))
}

/// What tells a file from another one that came to its place.
fn number(meta: &Metadata) -> u64 {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        meta.ino() ^ meta.dev().rotate_left(32)
    }
    #[cfg(not(unix))]
    {
        let created = meta.created().unwrap_or(SystemTime::UNIX_EPOCH);
        let since = created.duration_since(SystemTime::UNIX_EPOCH);
        since.map_or(0, |since| since.as_nanos() as u64)
    }
}

/// Where a file or folder is said to be: its folder as events name it, also where the file itself is missing. A link is not
/// followed, since another file may come to its place.
fn absolute(path: &Path) -> PathBuf {
    match (aside::folder_of(path).canonicalize(), path.file_name()) {
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

    /// All that comes until nothing more does: on a busy machine one burst may look like two.
    fn all(watcher: &mut Watcher) -> Changes {
        let mut all = next(watcher).expect("noticed");
        let mut waited = Instant::now();
        while waited.elapsed() < 3 * QUIET {
            if let Some(more) = watcher.wait(Duration::from_millis(10)) {
                all.textures |= more.textures;
                all.look |= more.look;
                all.assets |= more.assets;
                all.names.extend(more.names);
                waited = Instant::now();
            }
        }
        all.names.sort();
        all.names.dedup();
        all
    }

    #[test]
    fn what_is_closed_is_not_waited_for() {
        let kind = EventKind::Access(AccessKind::Close(AccessMode::Write));
        assert_eq!(progress(&kind), Progress::Whole);
        let now = Instant::now();
        let mut burst = Burst {
            since: now,
            last: now,
            files: BTreeSet::new(),
            unfinished: BTreeSet::new(),
        };
        assert_eq!(burst.end(), now + QUIET_WHEN_WHOLE);
        burst.unfinished.insert(PathBuf::from("t.wgsl"));
        assert_eq!(burst.end(), now + QUIET);
        burst.last = now + LONGEST;
        assert_eq!(burst.end(), now + LONGEST);
    }

    /// Later than whatever the tests have written by now, clocks included.
    fn known() -> SystemTime {
        SystemTime::now() + CLOCKS
    }

    #[test]
    fn what_is_saved_before_watching_begins_has_changed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [scene, look] = ["a.gltf", "a.look.toml"].map(|name| folder.path().join(name));
        fs::write(&scene, "old").expect("written");
        fs::write(&look, "old").expect("written");
        let old = SystemTime::now() - Duration::from_secs(3600);
        let file = fs::File::options().append(true).open(&scene);
        let aged = file.and_then(|file| file.set_modified(old));
        aged.expect("it can be made older");
        let files = [scene, look.clone()];
        let begun = SystemTime::now();
        let mut watcher = Watcher::new(&files, Some(&look), &[], begun).expect("watched");
        let changes = all(&mut watcher);
        assert!(changes.look && !changes.assets, "{changes:?}");
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
        let mut watcher =
            Watcher::new(&files, Some(&look), &[path("textures")], known()).expect("watched");
        // An editor that writes aside and renames, several times, and files that nobody watches.
        for i in 0..5 {
            fs::write(path("textures/t.tmp"), format!("{i}")).expect("written");
            fs::rename(path("textures/t.tmp"), path("textures/t.wgsl")).expect("renamed");
            fs::write(path("other.txt"), "new").expect("written");
        }
        let changes = all(&mut watcher);
        assert!(
            changes.textures && !changes.look && !changes.assets,
            "{changes:?}"
        );
        assert_eq!(changes.names, ["t.wgsl"]);

        fs::write(&look, "new").expect("written");
        fs::remove_file(path("a.gltf")).expect("removed");
        let changes = all(&mut watcher);
        assert!(
            changes.look && changes.assets && !changes.textures,
            "{changes:?}"
        );
        fs::write(path("a.gltf"), "another").expect("written");
        let changes = all(&mut watcher);
        assert_eq!(changes.names, ["a.gltf"]);
        // A folder that is removed, and a file that is only looked at.
        let _ = fs::read(path("a.gltf"));
        assert!(watcher.wait(Duration::from_millis(200)).is_none());
    }

    #[test]
    fn folders_that_go_and_come_back_are_not_forgotten() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("textures")).expect("a folder");
        fs::write(path("textures/t.wgsl"), "old").expect("written");
        let mut watcher = Watcher::new(&[], None, &[path("textures")], known()).expect("watched");
        let mut expect = |what: &str| {
            let changes = next(&mut watcher).unwrap_or_else(|| panic!("{what} is noticed"));
            assert!(changes.textures, "{what}: {changes:?}");
            // What belongs to the same change.
            while watcher.wait(INTERVAL + QUIET + QUIET).is_some() {}
        };
        fs::rename(path("textures"), path("away")).expect("moved");
        expect("that it has gone");
        fs::rename(path("away"), path("textures")).expect("moved");
        expect("that it is back");
        fs::write(path("textures/t.wgsl"), "newer").expect("written");
        expect("an edit after that");
        fs::remove_dir_all(path("textures")).expect("removed");
        expect("that it was deleted");
        fs::create_dir(path("textures")).expect("a folder");
        fs::write(path("textures/t.wgsl"), "another").expect("written");
        expect("that there is another one");
        fs::write(path("textures/t.wgsl"), "the last").expect("written");
        expect("an edit of that");
    }

    #[test]
    fn what_is_read_with_a_texture_is_named_with_it() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("textures")).expect("a folder");
        for name in ["textures/a.wgsl", "textures/b.wgsl", "textures/c.wgsl"] {
            fs::write(path(name), "old").expect("written");
        }
        let mut watcher = Watcher::new(&[], None, &[path("textures")], known()).expect("watched");
        fs::write(path("textures/b.wgsl"), "another").expect("written");
        // As if there had been no event of that.
        let noticed = path("textures/a.wgsl");
        watcher.add(noticed, Kind::Texture, Progress::Whole);
        let changes = watcher.take().expect("a burst");
        assert_eq!(changes.names, ["a.wgsl", "b.wgsl"]);
    }

    #[test]
    fn shared_files_beside_textures_are_followed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("lib")).expect("a folder");
        fs::write(path("lib/waves.wgsl"), "old").expect("written");
        let mut watcher =
            Watcher::new(&[], None, &[folder.path().to_owned()], known()).expect("watched");
        fs::write(path("lib/waves.wgsl"), "newer").expect("written");
        let changes = next(&mut watcher).expect("noticed");
        assert!(changes.textures, "{changes:?}");
        assert_eq!(changes.names, ["waves.wgsl"]);
    }

    #[cfg(unix)]
    #[test]
    fn edits_behind_a_link_are_seen_and_so_is_another_target() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("below")).expect("a folder");
        for name in ["one", "two"] {
            fs::write(path("below").join(name), name).expect("written");
        }
        let look = path("a.look.toml");
        symlink("below/one", &look).expect("a link");
        let mut watcher =
            Watcher::new(std::slice::from_ref(&look), Some(&look), &[], known()).expect("watched");
        fs::write(path("below/one"), "edited").expect("written");
        let changes = next(&mut watcher).expect("noticed");
        assert!(changes.look, "{changes:?}");
        assert_eq!(changes.names, ["a.look.toml"]);
        fs::remove_file(&look).expect("removed");
        symlink("below/two", &look).expect("a link");
        assert!(next(&mut watcher).expect("noticed").look);
        while watcher.wait(INTERVAL + QUIET + QUIET).is_some() {}
        fs::write(path("below/two"), "edited, too").expect("written");
        assert!(next(&mut watcher).expect("noticed").look);
    }
}
