//! What a command line says in place of the look's file, and mistakes in it told by the flags: the text that they make of the file is
//! nowhere to be seen.

use std::ops::Range;
use std::path::{Path, PathBuf};

use engine::scene::look::{Field, Look, LookDocument, Section, Value, find, parse_value};
use engine::session::Edit;
use engine::system::Disk;
use texgen::{Diagnostic, Diagnostics, Label, Severity, SourceFile, did_you_mean};

use crate::failure::Failure;
use crate::usage::UsageError;
use crate::words::parse_point;

/// Edits of the look, from the flags that are short for them, then as they were given.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Overrides {
    /// One after the other.
    pub(crate) edits: Vec<Edit>,
    /// The flag that each of them comes from, as it was typed.
    flags: Vec<String>,
}

impl Overrides {
    /// What flags say.
    ///
    /// # Errors
    /// One that can't be understood.
    pub(crate) fn parse(
        set: &[String],
        environment: Option<&Path>,
        position: Option<&str>,
        look_at: Option<&str>,
    ) -> Result<Self, UsageError> {
        let mut this = Self::default();
        if let Some(given) = environment {
            let flag = format!("--environment {}", given.display());
            // A look names files from where it lies.
            let path = std::path::absolute(given).unwrap_or_else(|_| PathBuf::from(given));
            let image = Value::Text(path.display().to_string());
            let section = Section::Environment;
            this.push(Edit::Remove { section }, flag.clone());
            this.push(Edit::environment("image", image), flag);
        }
        for (flag, key, given) in [
            ("--camera-at", "position", position),
            ("--look-at", "look_at", look_at),
        ] {
            if let Some(given) = given {
                let point = parse_point(flag, given)?;
                let edit = Edit::camera(key, Value::numbers(&point));
                this.push(edit, format!("{flag} {given}"));
            }
        }
        for given in set {
            let edit = Edit::parse(given).map_err(|form| UsageError::Set {
                given: given.clone(),
                form,
            })?;
            this.push(edit, format!("--set {given}"));
        }
        Ok(this)
    }

    fn push(&mut self, edit: Edit, flag: String) {
        self.edits.push(edit);
        self.flags.push(flag);
    }

    /// Refuses to make a node or an AO table of a name that was mistyped.
    ///
    /// # Errors
    /// The flags that set keys of what the look in this file doesn't have.
    pub(crate) fn check_names(&self, look: Option<&Path>) -> Result<(), Failure> {
        let text = match look {
            Some(path) => Look::read_text(&Disk, path).ok(),
            None => Some(String::new()),
        };
        let path = look.unwrap_or(Path::new(""));
        // What can't be read is told by those who need it.
        let Some(document) = text.and_then(|text| LookDocument::parse(path, &text).ok()) else {
            return Ok(());
        };
        let look = document.fields();
        let edits = self.edits.iter().zip(&self.flags);
        let unknown: Diagnostics = edits
            .filter_map(|(edit, flag)| self.unknown(edit.section(), flag, &look))
            .collect();
        match unknown.is_empty() {
            true => Ok(()),
            false => Err(unknown.into()),
        }
    }

    /// What is wrong with a flag that sets a key of a table which a look doesn't have.
    fn unknown(&self, section: &Section, flag: &str, look: &[Field]) -> Option<Diagnostic> {
        let (table, name) = section.place();
        let name = name?;
        let names: Vec<&str> = match find(look, table).map(|tables| &tables.value) {
            Some(Value::Table(tables)) => tables.iter().map(|t| t.key.value.as_str()).collect(),
            Some(_) => return None,
            None => Vec::new(),
        };
        let (what, remedy) = match section {
            // Documents have nodes whose names aren't known here.
            Section::Node(_) if find(look, "materialx").is_none() => (
                "node",
                format!("a new one needs a texture: --set {name}.texture=TEXTURE"),
            ),
            // The first one is read without being named.
            Section::Ao(_) if !names.is_empty() => (
                "AO table",
                format!("a new one needs a node that reads it: --set NODE.occlusion={name}"),
            ),
            _ => return None,
        };
        let mut edits = self.edits.iter();
        if names.contains(&name) || edits.any(|edit| brings(edit, section)) {
            return None;
        }
        let error = Diagnostic::error(format!("{flag}: there is no {what} called `{name}`"));
        Some(error.with_note(match did_you_mean(name, names) {
            Some(near) => format!("did you mean `{near}`?"),
            None if !is_name(name) => format!("names of {what}s are letters, digits, `_` and `-`"),
            None => remedy,
        }))
    }

    /// The look in this file with the edits, or what they are a look of.
    ///
    /// # Errors
    /// It can't be read, has mistakes, or can't have the edits.
    pub(crate) fn look(&self, path: Option<&Path>) -> Result<Option<Look>, Failure> {
        self.check_names(path)?;
        let written = match path {
            Some(path) => Look::read_text(&Disk, path)?,
            None => String::new(),
        };
        if path.is_none() && self.edits.is_empty() {
            return Ok(None);
        }
        let place = path.unwrap_or(Path::new(""));
        let mut document = LookDocument::parse(place, &written)?;
        for edit in &self.edits {
            edit.write(&mut document).map_err(Failure::Failed)?;
        }
        match Look::parse(place, &document.text()) {
            Ok(look) => Ok(Some(look)),
            Err(mistakes) => Err(self.told(path, &mistakes).into()),
        }
    }

    /// The same failure, told as [`Self::told`] tells it.
    pub(crate) fn told_failure(&self, look: Option<&Path>, failure: Failure) -> Failure {
        match failure {
            Failure::Mistakes(mistakes) => Failure::Mistakes(self.told(look, &mistakes)),
            other => other,
        }
    }

    /// Mistakes in the text that the edits make of the look's file, if there is one: those in what a flag has brought name the flag, all
    /// others have the places that the file has.
    pub(crate) fn told(&self, look: Option<&Path>, mistakes: &Diagnostics) -> Diagnostics {
        let Some(edited) = Edited::of(self, look) else {
            return mistakes.clone();
        };
        let mut told: Diagnostics = (mistakes.iter())
            .map(|mistake| edited.told(mistake))
            .collect();
        // Those beyond the ones that are kept are only counted.
        for severity in [Severity::Error, Severity::Warning] {
            for _ in told.count(severity)..mistakes.count(severity) {
                let bare = Diagnostic::error("");
                told.push(Diagnostic { severity, ..bare });
            }
        }
        told
    }
}

/// Whether a look takes this for the name of a node or an AO table.
fn is_name(text: &str) -> bool {
    let is_right = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    !text.is_empty() && text.chars().all(is_right)
}

/// Whether an edit shows that a new table is meant: a node gets its texture, an AO table is read by a node.
fn brings(edit: &Edit, new: &Section) -> bool {
    let Edit::Set {
        section,
        key,
        value,
    } = edit
    else {
        return false;
    };
    match (section, new, value) {
        (Section::Node(_), Section::Node(_), _) => section == new && key == "texture",
        (Section::Node(_), Section::Ao(name), Value::Text(read)) => {
            ["occlusion", "occlusion1"].contains(&key.as_str()) && read == name
        }
        _ => false,
    }
}

/// How a look's text has come about.
struct Edited<'a> {
    flags: &'a [String],
    /// What each flag's edit has changed.
    steps: Vec<Step>,
    /// The text before all of them, as messages show it.
    file: SourceFile,
    /// The text with all of them.
    text: String,
    has_file: bool,
}

impl<'a> Edited<'a> {
    /// `None` where nothing is edited, or the edits can't be made.
    fn of(overrides: &'a Overrides, look: Option<&Path>) -> Option<Self> {
        if overrides.edits.is_empty() {
            return None;
        }
        let path = look.unwrap_or(Path::new(""));
        let written = match look {
            Some(path) => Look::read_text(&Disk, path).ok()?,
            None => String::new(),
        };
        let mut document = LookDocument::parse(path, &written).ok()?;
        let original = document.text();
        let mut text = original.clone();
        let mut steps = Vec::new();
        for edit in &overrides.edits {
            edit.write(&mut document).ok()?;
            let next = document.text();
            steps.push(Step::between(&text, &next));
            text = next;
        }
        Some(Self {
            flags: &overrides.flags,
            steps,
            file: SourceFile::new("look", path.display().to_string(), original),
            text,
            has_file: look.is_some(),
        })
    }

    fn told(&self, mistake: &Diagnostic) -> Diagnostic {
        let mut told = Diagnostic {
            labels: Vec::new(),
            ..mistake.clone()
        };
        let mut named = None;
        for label in &mistake.labels {
            let is_edited = label.file.path() == self.file.path() && label.file.text() == self.text;
            if !is_edited {
                told.labels.push(label.clone());
                continue;
            }
            match self.origin(label.span.clone()) {
                Ok(span) if self.has_file => told.labels.push(Label {
                    file: self.file.clone(),
                    span,
                    ..label.clone()
                }),
                Ok(_) => {}
                Err(flag) => {
                    if label.primary {
                        named = named.or(Some(flag));
                    }
                    if !label.text.is_empty() {
                        told.notes.insert(0, label.text.clone());
                    }
                }
            }
        }
        if let Some(flag) = named {
            told.message = format!("{flag}: {}", mistake.message);
            if told.severity == Severity::Error && is_like_a_number(flag) {
                told.notes.push("numbers are written as in 0.2".to_owned());
            }
        }
        told
    }

    /// Where something lies in the text before all edits.
    ///
    /// # Errors
    /// It was not there: the flag that has brought it.
    fn origin(&self, mut span: Range<usize>) -> Result<Range<usize>, &'a str> {
        for (step, flag) in self.steps.iter().zip(self.flags).rev() {
            span = step.before(&span).ok_or(flag.as_str())?;
        }
        Ok(span)
    }
}

/// Whether `--set` was given what begins like a number and is none: `20%`, `0,2` (which is a list, where one is wanted).
fn is_like_a_number(flag: &str) -> bool {
    let Some((_, value)) = flag
        .strip_prefix("--set ")
        .and_then(|set| set.split_once('='))
    else {
        return false;
    };
    let digits = value.trim().trim_start_matches(['+', '-']);
    let digits = digits.strip_prefix('.').unwrap_or(digits);
    let is_number = value.trim().parse::<f64>().is_ok();
    // Names of files, too, begin with digits.
    let is_name = value.contains(|c: char| c.is_alphabetic() || c == '/');
    let is_list = value.matches(',').count() > 1;
    digits.starts_with(|c: char| c.is_ascii_digit())
        && !is_number
        && !is_name
        && !is_list
        && parse_value(value.trim()).is_none()
}

/// What an edit has changed of a text.
#[derive(Debug, PartialEq)]
struct Step {
    /// Bytes of the former text.
    old: Range<usize>,
    /// What stands there now.
    new: Range<usize>,
    /// Part of one line: else whole lines.
    is_within_a_line: bool,
}

impl Step {
    fn between(old: &str, new: &str) -> Self {
        let old: Vec<&str> = old.split_inclusive('\n').collect();
        let new: Vec<&str> = new.split_inclusive('\n').collect();
        let first = old.iter().zip(&new).take_while(is_same).count();
        let rest = old[first..].iter().rev().zip(new[first..].iter().rev());
        let last = rest.take_while(is_same).count();
        let lines = |text: &[&str]| {
            let length = |lines: &[&str]| lines.iter().map(|line| line.len()).sum::<usize>();
            length(&text[..first])..length(&text[..text.len() - last])
        };
        let whole = Self {
            old: lines(&old),
            new: lines(&new),
            is_within_a_line: false,
        };
        let changed = [&old, &new].map(|text| &text[first..text.len() - last]);
        match changed {
            [[old], [new]] => whole.within(old, new),
            _ => whole,
        }
    }

    /// The part of the one line in which they differ.
    fn within(self, old: &str, new: &str) -> Self {
        let is_same = |(a, b): &(u8, u8)| a == b;
        let first = old.bytes().zip(new.bytes()).take_while(is_same).count();
        let rest = (old.bytes().rev()).zip(new.bytes().rev());
        let most = old.len().min(new.len()) - first;
        let last = rest.take(most).take_while(is_same).count();
        Self {
            old: self.old.start + first..self.old.end - last,
            new: self.new.start + first..self.new.end - last,
            is_within_a_line: true,
        }
    }

    /// Where something was that the edit hasn't changed.
    fn before(&self, span: &Range<usize>) -> Option<Range<usize>> {
        let new = &self.new;
        let is_changed = match self.is_within_a_line {
            // What has become longer or shorter is another one, too.
            true => span.start <= new.end && span.end >= new.start,
            false if span.is_empty() => new.contains(&span.start),
            false => span.start < new.end && span.end > new.start,
        };
        let moved = |at: usize| at - new.end + self.old.end;
        match (is_changed, span.start >= new.end) {
            (true, _) => None,
            (false, true) => Some(moved(span.start)..moved(span.end)),
            (false, false) => Some(span.clone()),
        }
    }
}

/// Whether two lines are the same but for their ends.
fn is_same((old, new): &(&&str, &&str)) -> bool {
    old.trim_end() == new.trim_end()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOK: &str = "# A look.\nenvironment = { color = [1, 1, 1], intensity = 2 }\n\n[node.a]\ntexture = \"fbm\"\nscale = 0.9\n\n\
                        [material.Glow]\nbase_color = \"a\" # red\nroughness = 0.5";

    fn set(given: &[&str]) -> Overrides {
        let given: Vec<String> = given.iter().map(|&text| text.to_owned()).collect();
        Overrides::parse(&given, None, None, None).expect("well-formed")
    }

    #[test]
    fn flags_are_edits_in_their_order() {
        let set = ["rust.scale=2".to_owned()];
        let parsed = Overrides::parse(&set, Some(Path::new("/a/sky.hdr")), Some("1,2,3"), None);
        let edits = parsed.expect("well-formed").edits;
        let sections: Vec<_> = edits
            .iter()
            .map(|edit| edit.section().to_string())
            .collect();
        let expected = ["[environment]", "[environment]", "[camera]", "[node.rust]"];
        assert_eq!(sections, expected);
        assert!(Overrides::parse(&["rust".to_owned()], None, None, None).is_err());
        assert!(Overrides::parse(&[], None, Some("1,2"), None).is_err());
        assert!(Overrides::parse(&[], None, None, Some("1,2,inf")).is_err());
    }

    /// What is told of a mistake at a word of the edited text.
    fn told(overrides: &Overrides, look: Option<&Path>, word: &str) -> Diagnostic {
        let text = Edited::of(overrides, look).expect("it is edited").text;
        let start = text
            .find(word)
            .unwrap_or_else(|| panic!("no {word}:\n{text}"));
        let path = look.unwrap_or(Path::new("")).display().to_string();
        let file = SourceFile::new("look", path, text);
        let span = start..start + word.len();
        let mistake = Diagnostic::error("wrong").with_label(&file, span, "this");
        let told = overrides.told(look, &Diagnostics::from(mistake));
        told.as_slice()[0].clone()
    }

    #[test]
    fn mistakes_are_where_they_come_from() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.look.toml");
        std::fs::write(&path, LOOK).expect("written");
        let look = Some(path.as_path());
        let edits = [
            "a.scale=0.95",
            "a.octaves=9",
            "environment.intensity=3",
            "view.exposure=4",
            "b.texture=checker",
        ];
        let overrides = set(&edits);
        for (word, flag) in [
            ("0.95", "--set a.scale=0.95"),
            ("octaves", "--set a.octaves=9"),
            ("3 }", "--set environment.intensity=3"),
            ("[view]", "--set view.exposure=4"),
            ("exposure", "--set view.exposure=4"),
            ("[node.b]", "--set b.texture=checker"),
            ("\"checker\"", "--set b.texture=checker"),
        ] {
            let told = told(&overrides, look, word);
            assert_eq!(told.message, format!("{flag}: wrong"), "{word}");
            assert!(told.labels.is_empty(), "{word}: {told}");
            assert_eq!(told.notes, ["this"]);
        }
        for (word, line, column) in [
            ("color", 2, 17),
            ("[node.a]", 4, 1),
            ("scale", 6, 1),
            ("Glow", 8, 11),
            ("base_color", 9, 1),
            ("roughness", 10, 1),
        ] {
            let told = told(&overrides, look, word);
            assert_eq!(told.message, "wrong");
            let place = told.location().expect("it has a place");
            assert_eq!((place.line, place.column), (line, column), "{word}");
            assert_eq!(told.labels[0].file.text(), LOOK);
        }
    }

    #[test]
    fn names_that_the_look_does_not_have_are_refused_with_those_near() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.look.toml");
        let node = "[node.valve_rust]\ntexture = \"fbm\"\n";
        let ao = "[ao.crevices]\ndistance = 1\n";
        let of_documents = "[[materialx]]\nfile = \"a.mtlx\"\n";
        for (text, edits, told) in [
            (
                node,
                &["valve_rus.scale=2"][..],
                "did you mean `valve_rust`?",
            ),
            (node, &["valve_rust.scale=2"], ""),
            (node, &["a.scale=2"], "--set a.texture=TEXTURE"),
            (node, &["a.scale=2", "a.texture=fbm"], ""),
            // A remedy that would be refused, too, is none.
            (node, &["graph.x.y=1"], "names of nodes are letters"),
            (ao, &["ao.far.off.y=1"], "names of AO tables are letters"),
            (of_documents, &["brass.scale=2"], ""),
            (ao, &["ao.crevises.distance=2"], "did you mean `crevices`?"),
            (ao, &["ao.crevices.distance=2"], ""),
            (ao, &["ao.edges.distance=2"], "--set NODE.occlusion=edges"),
            (
                ao,
                &["ao.edges.distance=2", "a.texture=fbm", "a.occlusion1=edges"],
                "",
            ),
            (node, &["ao.edges.distance=2"], ""),
        ] {
            std::fs::write(&path, text).expect("written");
            let refused = set(edits).check_names(Some(&path)).err();
            let Some(Failure::Mistakes(mistakes)) = refused else {
                assert_eq!(told, "", "{edits:?}");
                continue;
            };
            let [mistake] = mistakes.as_slice() else {
                panic!("{mistakes}");
            };
            let flag = format!("--set {}: there is no ", edits[0]);
            assert!(mistake.message.starts_with(&flag), "{mistake}");
            assert!(
                !told.is_empty() && mistake.notes[0].contains(told),
                "{mistake}"
            );
        }
        let mistyped = set(&["valve_rus.scale=2"]);
        assert!(mistyped.look(None).is_err());
    }

    #[test]
    fn what_has_no_file_has_no_place() {
        let sky = Some(Path::new("sky.hdr"));
        let overrides = Overrides::parse(&["x.y=3".to_owned()], sky, None, Some("0,0,0"));
        let overrides = overrides.expect("well-formed");
        for (word, flag) in [
            ("sky.hdr", "--environment sky.hdr"),
            ("look_at", "--look-at 0,0,0"),
            ("[node.x]", "--set x.y=3"),
        ] {
            let told = told(&overrides, None, word);
            assert_eq!(told.message, format!("{flag}: wrong"));
            assert!(!told.to_json().contains("\"file\""), "{}", told.to_json());
        }
    }

    #[test]
    fn what_begins_like_a_number_is_told_how_numbers_are_written() {
        for (value, is_told) in [
            ("20%", true),
            ("0,2", true),
            ("-1.5.2", true),
            ("1,0,0", false),
            ("mask", false),
            (".mask", false),
            ("2", false),
            (".2", false),
            ("0x10", false),
            ("2k_sky.exr", false),
            ("0001.png", false),
            ("12/34", false),
        ] {
            let given = format!("material.M.roughness={value}");
            let told = told(&set(&[given.as_str()]), None, "roughness");
            let note = "numbers are written as in 0.2".to_owned();
            assert_eq!(told.notes.contains(&note), is_told, "{value}");
        }
        // What is only a warning isn't wrong in its form.
        let overrides = set(&["material.M.roughness=20%"]);
        let text = Edited::of(&overrides, None).expect("it is edited").text;
        let start = text.find("roughness").expect("it was set");
        let file = SourceFile::new("look", String::new(), text);
        let warning = Diagnostic::warning("odd").with_label(&file, start..start + 9, "");
        let told = overrides.told(None, &Diagnostics::from(warning));
        assert_eq!(told.as_slice()[0].notes, [""; 0]);
    }

    #[test]
    fn what_is_only_counted_stays_counted() {
        let mistakes: Diagnostics = (0..70).map(|_| Diagnostic::error("wrong")).collect();
        let told = set(&["x.y=3"]).told(None, &mistakes);
        assert_eq!(told.count(Severity::Error), 70);
        assert!(set(&[]).told(None, &mistakes) == mistakes);
    }
}
