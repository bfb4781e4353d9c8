//! A look that is to lie in another folder: what it names relative to its folder is named from there, so that it is the same file.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use crate::input::FileId;
use crate::scene::look::{Field, MODEL_IMAGE, Spanned, Value, find, parse_value, placed_fields};
use crate::system::{Disk, Files};

use super::Document;

/// Keys of nodes that name no file.
const NO_FILES: [&str; 3] = ["texture", "occlusion", "occlusion1"];
/// How names of images end.
const ENDINGS: [&str; 8] = ["png", "jpg", "jpeg", "hdr", "exr", "webp", "bmp", "tga"];
/// Bytes of text that steps back and forth are moved for, each with the whole look.
const MOST_MOVED: usize = 4 << 20;

impl Document {
    /// It lies elsewhere from now on: as [`Self::set_path`], but in another folder text and history name the same files from there, as
    /// [`Session::save_as`](super::Session::save_as) has it. Steps that are too many for that are forgotten, the farthest first. Whether
    /// anything is named in another way, so that what was kept of its texts is no longer right.
    pub fn move_to(&mut self, path: &Path) -> bool {
        let folder = |path: &Path| path.parent().map(Path::to_owned).unwrap_or_default();
        let folders = [folder(self.path()), folder(path)];
        if is_same([&folders[0], &folders[1]]) {
            self.set_path(path);
            return false;
        }
        let done = self.done();
        let there = self.in_folder(path, [&folders[0], &folders[1]]);
        let Some(mut moved) = there else {
            self.go_to(done);
            self.set_path(path);
            return false;
        };
        // Whoever made something of a revision is not to take this one for it.
        while moved.revision() <= self.revision() {
            moved.set_path(path);
        }
        *self = moved;
        true
    }

    /// What it is in another folder: none where all of its texts are the same there, or one is no look. Leaves this one at any step.
    fn in_folder(&mut self, path: &Path, folders: [&Path; 2]) -> Option<Self> {
        let labels: Vec<String> = self.steps().map(str::to_owned).collect();
        let done = self.done();
        let reach = (MOST_MOVED / self.text().len().max(1)).max(1);
        let last = labels.len().min(done + reach);
        self.go_to(done.saturating_sub(reach));
        let text = moved(&Disk, self.text(), folders);
        let mut is_other = text != self.text();
        let mut there = Self::new(path, &text).ok()?;
        let (mut done_there, mut others) = (0, self.others().clone());
        for (number, label) in (1..).zip(&labels).take(last).skip(self.done()) {
            self.go_to(number);
            let text = moved(&Disk, self.text(), folders);
            is_other |= text != self.text();
            there.replace_as_in(self, label, &text).ok()?;
            if number == done {
                (done_there, others) = (there.done(), self.others().clone());
            }
        }
        there.go_to(done_there);
        there.set_others(others);
        is_other.then_some(there)
    }
}

/// A look's text as it is to be written in the folder `to`, where it was in the folder `from`; "" is the one of now. Whatever isn't a path
/// relative to it stays to the byte, and so does all of it where both are the same folder.
pub(super) fn moved(files: &dyn Files, text: &str, [from, to]: [&Path; 2]) -> String {
    if is_same([from, to]) {
        return text.to_owned();
    }
    let mut moved = text.to_owned();
    let mut named = named(files, text, from);
    // From the end, so that places stay what they are.
    named.sort_by_key(|name| std::cmp::Reverse(name.span.start));
    named.dedup_by_key(|name| name.span.start);
    for Spanned { value: name, span } in named {
        let Some(former) = text.get(span.clone()) else {
            continue;
        };
        let is_it = parse_value(former)
            .is_some_and(|read| matches!(&read.value, Value::Text(read) if *read == name));
        let now = named_from(to, &from.join(&name));
        if let (true, Some(now)) = (is_it, now) {
            moved.replace_range(span, &literal(&now, former));
        }
    }
    moved
}

/// Whether both are one folder.
fn is_same([one, other]: [&Path; 2]) -> bool {
    one == other || FileId::of(&here(one)) == FileId::of(&here(other))
}

/// The relative paths in a text, each with its place.
fn named(files: &dyn Files, text: &str, folder: &Path) -> Vec<Spanned<String>> {
    let fields = placed_fields(text);
    let mut named = Vec::new();
    let image = table(&fields, "environment").and_then(|fields| find(fields, "image"));
    image.into_iter().for_each(|image| add(image, &mut named));
    for key in ["include", "materialx"] {
        let list = match find(&fields, key).map(|value| &value.value) {
            Some(Value::List(list)) => list.as_slice(),
            _ => &[],
        };
        for item in list {
            if let Value::Table(fields) = &item.value
                && let Some(file) = find(fields, "file")
            {
                add(file, &mut named);
            }
        }
    }
    let nodes = table(&fields, "node").unwrap_or_default();
    let names: HashSet<&str> = nodes.iter().map(|node| node.key.value.as_str()).collect();
    let mut values = Vec::new();
    for Field { value, .. } in nodes {
        if let Value::Table(fields) = &value.value {
            let parameters = fields
                .iter()
                .filter(|field| !NO_FILES.contains(&field.key.value.as_str()));
            parameters.for_each(|field| add(&field.value, &mut values));
        }
    }
    // Which parameters are images is not known here. What ends as an image does names no output of a node.
    named.extend(values.into_iter().filter(|text| {
        let node = text.value.split('.').next().unwrap_or_default();
        let ending = Path::new(&text.value).extension().and_then(|e| e.to_str());
        let is_image = ending.is_some_and(|e| ENDINGS.contains(&e.to_ascii_lowercase().as_str()));
        is_image || !names.contains(node) && files.has(&folder.join(&text.value))
    }));
    named.retain(|name| {
        let path = Path::new(&name.value);
        let is_relative = !path.has_root() && path.is_relative() && !name.value.is_empty();
        is_relative && !name.value.starts_with(MODEL_IMAGE)
    });
    named
}

/// The keys of a table outside of all others.
fn table<'f>(fields: &'f [Field], key: &str) -> Option<&'f [Field]> {
    match &find(fields, key)?.value {
        Value::Table(fields) => Some(fields),
        _ => None,
    }
}

/// All texts in a value: an image may be a table, and have keys.
fn add(value: &Spanned<Value>, texts: &mut Vec<Spanned<String>>) {
    match &value.value {
        Value::Text(text) => texts.push(value.with(text.clone())),
        Value::List(items) => items.iter().for_each(|item| add(item, texts)),
        Value::Table(fields) => fields.iter().for_each(|field| add(&field.value, texts)),
        _ => {}
    }
}

/// A file as a look in a folder names it: from there, with slashes on every system; by its whole path where both have no more than the
/// root in common. None where that is no text.
fn named_from(folder: &Path, file: &Path) -> Option<String> {
    let target = real(folder)?;
    // A link is named, and not what it leads to.
    let lies_in = real(file.parent().unwrap_or(Path::new("")))?;
    let place = lies_in.join(file.file_name()?);
    let shared = target.components().zip(place.components());
    let shared: Vec<Component<'_>> = shared.take_while(|(a, b)| a == b).map(|(a, _)| a).collect();
    let has_name = |part: &Component<'_>| matches!(part, Component::Normal(_));
    if !shared.iter().any(has_name) {
        let whole = std::path::absolute(file).ok()?;
        return whole.to_str().map(str::to_owned);
    }
    let up = target.components().count() - shared.len();
    let mut parts = vec![".."; up];
    for part in place.components().skip(shared.len()) {
        parts.push(part.as_os_str().to_str()?);
    }
    Some(parts.join("/"))
}

/// The folder of now, where none is named.
fn here(folder: &Path) -> PathBuf {
    match folder.as_os_str().is_empty() {
        true => PathBuf::from("."),
        false => folder.to_owned(),
    }
}

/// A folder from the root, without links and steps back as far as the system knows it.
fn real(folder: &Path) -> Option<PathBuf> {
    let folder = here(folder);
    if let Ok(real) = folder.canonicalize() {
        return Some(real);
    }
    let mut plain = PathBuf::new();
    for part in std::path::absolute(folder).ok()?.components() {
        match part {
            Component::ParentDir => {
                plain.pop();
            }
            part => plain.push(part),
        }
    }
    Some(plain)
}

/// A text as TOML has it, in quotes of the former one's kind where it can be.
fn literal(text: &str, former: &str) -> String {
    let is_plain = !text.contains(|c: char| c == '\'' || c.is_control());
    if is_plain && former.starts_with('\'') {
        return format!("'{text}'");
    }
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted += &format!("\\u{:04X}", u32::from(c)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::Disk;

    /// A folder with these files.
    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        for file in files {
            let path = folder.path().join(file);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("folders");
            std::fs::write(path, "").expect("a file");
        }
        folder
    }

    const LOOK: &str = "# Head.
environment = { image = 'tex/sky.hdr' } # sky

[node.oak]
texture = 'picture' # tex/oak.png
image = \"tex/oak.png\"
amount = 'rust.x'
bare = \"tex/bare\"
model = 'model:a.png'
whole = '/none/such.png'

[node.rust]
texture = 'picture'
image = { file = \"assets/rust.jpg\", wrap = 'clamp' }
keyed = { keys = [[0, 'tex/oak.png'], [1, 'tex/gone.png']] }
color = '#fff'

[material.Wood]
base_color = 'oak'

[[materialx]]
file = 'tex/a.mtlx'

[[include]]
file = 'tex/car.glb'
";

    #[test]
    fn what_is_named_is_the_same_file() {
        let folder = folder(&[
            "tex/sky.hdr",
            "tex/oak.png",
            "tex/bare",
            "assets/rust.jpg",
            "tex/a.mtlx",
            "tex/car.glb",
        ]);
        let (from, to) = (folder.path().to_owned(), folder.path().join("assets"));
        let text = moved(&Disk, LOOK, [&from, &to]);
        let expected = LOOK
            .replace("'tex/", "'../tex/")
            .replace("\"tex/", "\"../tex/")
            .replace("\"assets/", "\"");
        assert_eq!(text, expected);
        // And back, by another spelling of the folder.
        let from = folder.path().join("tex/..");
        assert_eq!(moved(&Disk, &text, [&to, &from]), LOOK);
        assert_eq!(moved(&Disk, LOOK, [&from, folder.path()]), LOOK);
        let lines = LOOK.replace('\n', "\r\n");
        let moved = moved(&Disk, &lines, [folder.path(), &to]);
        assert_eq!(moved, expected.replace('\n', "\r\n"));
    }

    #[test]
    fn what_was_done_names_the_same_files_too() {
        let folder = folder(&["tex/sky.hdr", "looks/a"]);
        let there = folder.path().join("looks/a.look.toml");
        let look = |image: &str, exposure: f32| {
            format!("environment = {{ image = '{image}' }}\n[view]\nexposure = {exposure:?}\n")
        };
        let path = folder.path().join("a.look.toml");
        let mut document = Document::new(&path, &look("tex/sky.hdr", 0.0)).expect("a look");
        let steps = [
            ("brighter", look("tex/sky.hdr", 1.0)),
            // The same file, so that it is no step there.
            ("renamed", look("./tex/sky.hdr", 1.0)),
            ("dark", "# Nothing.\n".to_owned()),
            ("lit", look("tex/sky.hdr", 2.0)),
        ];
        for (label, text) in &steps {
            document.replace(label, text).expect("a look");
        }
        document.go_to(3);
        let revision = document.revision();
        assert!(document.move_to(&there));
        assert!(document.revision() > revision);
        assert_eq!(document.path(), there);
        assert_eq!(document.text(), steps[2].1);
        assert!(document.steps().eq(["brighter", "dark", "lit"]));
        assert_eq!(document.done(), 2);
        assert!(document.redo());
        assert_eq!(document.text(), look("../tex/sky.hdr", 2.0));
        assert!(document.go_to(1));
        assert_eq!(document.text(), look("../tex/sky.hdr", 1.0));
        assert!(document.undo() && !document.undo());
        assert_eq!(document.text(), look("../tex/sky.hdr", 0.0));
        // Where nothing is named, nothing happens to it.
        let mut plain = Document::new(&path, "[view]\nexposure = 0.0\n").expect("a look");
        for exposure in [1.0, 2.0] {
            let text = format!("[view]\nexposure = {exposure:?}\n");
            plain.replace("view", &text).expect("a look");
        }
        plain.undo();
        assert!(!plain.move_to(&there));
        assert_eq!((plain.path(), plain.done()), (&*there, 1));
        assert_eq!(plain.text(), "[view]\nexposure = 1.0\n");
        assert_eq!(plain.steps().count(), 2);
    }

    #[test]
    fn what_others_have_written_is_known_in_another_folder() {
        let folder = folder(&["tex/sky.hdr", "looks/a"]);
        let look = |exposure: f32| {
            format!("environment = {{ image = 'tex/sky.hdr' }}\n[view]\nexposure = {exposure:?}\n")
        };
        let path = folder.path().join("a.look.toml");
        let mut document = Document::new(&path, &look(0.0)).expect("a look");
        document.replace("mine", &look(1.0)).expect("a look");
        document
            .replace_by_others("theirs", &look(2.0))
            .expect("a look");
        document.replace("mine", &look(3.0)).expect("a look");
        document.undo();
        let others = document.others().clone();
        assert_eq!(others.len(), 1);
        assert!(document.move_to(&folder.path().join("looks/a.look.toml")));
        assert!(document.text().contains("../tex/sky.hdr"));
        assert_eq!(document.others(), &others);
        assert!(!document.leaves_out_others());
        // The file there has it, so that it may be lost without it.
        assert!(document.undo() && document.leaves_out_others());
        assert!(document.redo() && !document.leaves_out_others());
        assert!(document.redo() && !document.leaves_out_others());
    }

    #[test]
    fn what_lies_apart_has_its_whole_path() {
        let apart = Path::new("/nowhere/at/all");
        if cfg!(unix) {
            let named = named_from(apart, Path::new("/elsewhere/a.png"));
            assert_eq!(named.as_deref(), Some("/elsewhere/a.png"));
        }
        let near = named_from(apart, Path::new("/nowhere/in/../b/c d.png"));
        assert_eq!(near.as_deref(), Some("../../b/c d.png"));
        assert_eq!(
            named_from(Path::new(""), Path::new("a.png")).as_deref(),
            Some("a.png")
        );
        assert_eq!(literal("it's", "'a'"), "\"it's\"");
        assert_eq!(literal("a\\\"b", "\"a\""), "\"a\\\\\\\"b\"");
    }
}
