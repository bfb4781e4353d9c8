//! The look file as a text that is edited: what is changed is written anew, everything else keeps its bytes, comments
//! and order.
//!
//! What keys mean is not known here; see [`super::Look`].

use std::io::{self, Write};
use std::path::Path;

use texgen::{Diagnostic, Diagnostics, SourceFile};
use toml_edit::{Decor, DocumentMut, Item, Table, TableLike};

use crate::aside;

use super::line_ends::{BYTE_ORDER_MARK, LineEnds};
use super::rewrite::to_toml_like;
use super::value::{Field, Value, fields, to_toml};

/// One table of a look.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Section {
    /// `environment = { ... }`.
    Environment,
    /// `[camera]`.
    Camera,
    /// `[view]`.
    View,
    /// `[light.NAME]`.
    Light(String),
    /// `[ao.NAME]`.
    Ao(String),
    /// `[node.NAME]`.
    Node(String),
    /// `[material.NAME]`.
    Material(String),
    /// `[graph.NAME]`.
    Frame(String),
}

impl Section {
    /// Its key in the file, and its name below that key where it has one.
    pub fn place(&self) -> (&'static str, Option<&str>) {
        match self {
            Self::Environment => ("environment", None),
            Self::Camera => ("camera", None),
            Self::View => ("view", None),
            Self::Light(name) => ("light", Some(name)),
            Self::Ao(name) => ("ao", Some(name)),
            Self::Node(name) => ("node", Some(name)),
            Self::Material(name) => ("material", Some(name)),
            Self::Frame(name) => ("graph", Some(name)),
        }
    }
}

impl std::fmt::Display for Section {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.place() {
            (key, None) => write!(f, "[{key}]"),
            (key, Some(name)) => write!(f, "[{key}.{name}]"),
        }
    }
}

/// The text of a look, as something to edit.
#[derive(Debug, Clone)]
pub struct LookDocument {
    document: DocumentMut,
    line_ends: LineEnds,
    has_byte_order_mark: bool,
    /// The last line has no end.
    ends_open: bool,
}

/// A table put aside.
#[derive(Debug)]
pub struct Kept {
    item: Option<Item>,
    /// What stands around the key of a value outside of all tables.
    around_key: Option<Decor>,
    /// Comments at the top of the text that belong to nothing that follows.
    head: String,
}

impl LookDocument {
    /// Parses a text that lies at `path`. Only its TOML is checked.
    ///
    /// # Errors
    /// The text is no TOML.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Diagnostics> {
        let document = text.parse().map_err(|error: toml_edit::TomlError| {
            let file = SourceFile::new("look", path.display().to_string(), text);
            let span = error.span().unwrap_or(text.len()..text.len());
            let message = format!("not valid TOML: {}", error.message().trim_end());
            Diagnostics::from(Diagnostic::error(message).with_label(&file, span, ""))
        })?;
        Ok(Self {
            document,
            line_ends: LineEnds::of(text),
            has_byte_order_mark: text.starts_with(BYTE_ORDER_MARK),
            ends_open: !text.is_empty() && !text.ends_with('\n'),
        })
    }

    /// A look that says nothing.
    pub fn empty() -> Self {
        Self {
            document: DocumentMut::new(),
            line_ends: LineEnds::Lf,
            has_byte_order_mark: false,
            ends_open: false,
        }
    }

    /// The whole text, edits included.
    pub fn text(&self) -> String {
        let mut text = self.document.to_string();
        if self.ends_open && text.ends_with('\n') {
            text.pop();
        }
        text = self.line_ends.restored(text);
        if self.has_byte_order_mark && !text.starts_with(BYTE_ORDER_MARK) {
            text.insert_str(0, BYTE_ORDER_MARK);
        }
        text
    }

    /// Writes the text to `path`: the file is the old one or the new one, never half of either. A link stays one.
    ///
    /// # Errors
    /// The system refuses; the old file is untouched then.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        aside::replace(path, |file| file.write_all(self.text().as_bytes()))
    }

    /// Everything in it, without places.
    pub fn fields(&self) -> Vec<Field> {
        fields(self.document.as_table(), 0)
    }

    /// Whether something of that name stands outside of all tables, or is a table itself.
    pub fn has(&self, key: &str) -> bool {
        self.document.contains_key(key)
    }

    /// The keys of a table, without places; `None` where there is no such table.
    pub fn table(&self, section: &Section) -> Option<Vec<Field>> {
        let (key, name) = section.place();
        let mut item = self.document.get(key)?;
        if let Some(name) = name {
            item = item.as_table_like()?.get(name)?;
        }
        Some(fields(item.as_table_like()?, 0))
    }

    /// Sets a key of a table, which is made where it is missing. `blend.mask` names a key of a table below. A comment
    /// behind the old value stays.
    ///
    /// # Errors
    /// Something that is no table is in the way: says what.
    pub fn set(&mut self, section: &Section, key: &str, value: &Value) -> Result<(), String> {
        let mut table = self.section(section)?;
        let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
        for step in path.split('.').filter(|step| !step.is_empty()) {
            let item = table
                .entry(step)
                .or_insert_with(|| toml_edit::value(toml_edit::InlineTable::new()));
            table = item
                .as_table_like_mut()
                .ok_or_else(|| format!("`{step}` of {section} is no table"))?;
        }
        match table.get_mut(last) {
            Some(Item::Value(old)) => {
                let mut value = to_toml_like(value, old);
                *value.decor_mut() = old.decor().clone();
                *old = value;
            }
            Some(item) => *item = Item::Value(to_toml(value)),
            None => {
                table.insert(last, Item::Value(to_toml(value)));
            }
        }
        Ok(())
    }

    /// Takes a key away, if it is there.
    pub fn remove(&mut self, section: &Section, key: &str) {
        let Some(mut table) = self.existing(section) else {
            return;
        };
        let (path, last) = key.rsplit_once('.').unwrap_or(("", key));
        for step in path.split('.').filter(|step| !step.is_empty()) {
            match table.get_mut(step).and_then(Item::as_table_like_mut) {
                Some(below) => table = below,
                None => return,
            }
        }
        table.remove(last);
    }

    /// Takes a whole table away, if it is there. Comments at the top of the text are of the whole look, and stay.
    pub fn remove_table(&mut self, section: &Section) {
        let head = self.head_of(section);
        match section.place() {
            (key, None) => {
                self.document.remove(key);
            }
            (key, Some(name)) => {
                if let Some(parent) = self.document.get_mut(key).and_then(Item::as_table_like_mut) {
                    parent.remove(name);
                }
            }
        }
        if let Some(mut head) = head {
            let former = self.head();
            let rest = self.document.to_string();
            let rest = rest.strip_prefix(&former).unwrap_or(&rest);
            // No more lines stay empty than there were.
            if head.ends_with("\n\n") && (rest.is_empty() || rest.starts_with('\n')) {
                head.pop();
            }
            self.set_head(former + &head);
        }
    }

    /// A copy of a table as it is written, to be [put back](Self::put_back).
    pub fn keep(&self, section: &Section) -> Kept {
        let (key, name) = section.place();
        let item = self.document.get(key);
        let around_key = self.document.as_table().key(key);
        Kept {
            item: match name {
                Some(name) => item
                    .and_then(|item| item.as_table_like()?.get(name))
                    .cloned(),
                None => item.cloned(),
            },
            around_key: around_key
                .filter(|_| name.is_none())
                .map(|key| key.leaf_decor().clone()),
            head: self.head(),
        }
    }

    /// Makes a table what it was, to the byte.
    pub fn put_back(&mut self, section: &Section, kept: Kept) {
        let Kept {
            item,
            around_key,
            head,
        } = kept;
        let Some(item) = item else {
            return self.remove_table(section);
        };
        self.set_head(head);
        let (key, name) = section.place();
        let parent: Option<&mut dyn TableLike> = match name {
            None => Some(self.document.as_table_mut()),
            Some(_) => self.document.get_mut(key).and_then(Item::as_table_like_mut),
        };
        let name = name.unwrap_or(key);
        let Some(parent) = parent else {
            return;
        };
        // In its place, where comments before its key are kept.
        match parent.get_mut(name) {
            Some(now) => *now = item,
            None => {
                parent.insert(name, item);
                if let Some(decor) = around_key
                    && let Some(mut key) = self.document.as_table_mut().key_mut(name)
                {
                    *key.leaf_decor_mut() = decor;
                }
            }
        }
    }

    /// What stands at the top of the text, and belongs to nothing that follows.
    fn head(&self) -> String {
        let prefix = self.document.as_table().decor().prefix();
        let prefix = prefix.and_then(|prefix| prefix.as_str());
        prefix.unwrap_or_default().to_owned()
    }

    fn set_head(&mut self, head: String) {
        if head != self.head() {
            self.document.as_table_mut().decor_mut().set_prefix(head);
        }
    }

    /// The comments above a table with which the text begins, as far as they are of the whole look: those right above the name of a
    /// table in brackets are its own.
    fn head_of(&self, section: &Section) -> Option<String> {
        let root = self.document.as_table();
        let (key, name) = section.place();
        let mut item = root.get(key)?;
        if let Some(name) = name {
            item = item.as_table()?.get(name)?;
        }
        let above = |decor: &Decor| -> Option<String> {
            let above = decor.prefix()?.as_str()?.replace('\r', "");
            above.contains('#').then_some(above)
        };
        // Values stand above all tables.
        let mut values = root.iter().filter(|(_, item)| {
            let is_dotted = item.as_table().is_some_and(Table::is_dotted);
            item.is_value() || is_dotted
        });
        match (item, values.next()) {
            (Item::Value(_), Some((first, _))) if name.is_none() && first == key => {
                above(root.key(key)?.leaf_decor())
            }
            (Item::Table(table), None) => {
                let mut above = above(table.decor())?;
                above.truncate(above.rfind("\n\n")? + 2);
                let at = table.position();
                let is_first = at.is_some() && at == first_position(root);
                (is_first && above.contains('#')).then_some(above)
            }
            _ => None,
        }
    }

    pub(super) fn root_mut(&mut self) -> &mut Table {
        self.document.as_table_mut()
    }

    fn existing(&mut self, section: &Section) -> Option<&mut dyn TableLike> {
        let (key, name) = section.place();
        let mut item = self.document.get_mut(key)?;
        if let Some(name) = name {
            item = item.as_table_like_mut()?.get_mut(name)?;
        }
        item.as_table_like_mut()
    }

    fn section(&mut self, section: &Section) -> Result<&mut dyn TableLike, String> {
        let (key, name) = section.place();
        let in_the_way = || format!("the look has something else called {section}");
        let is_new = self.document.is_empty();
        let new_table = || {
            let mut table = Table::new();
            if !is_new {
                table.decor_mut().set_prefix("\n");
            }
            Item::Table(table)
        };
        let item = match name {
            // A line of its own before all tables.
            None if *section == Section::Environment => self
                .document
                .entry(key)
                .or_insert_with(|| toml_edit::value(toml_edit::InlineTable::new())),
            None => self.document.entry(key).or_insert_with(new_table),
            Some(name) => {
                let parent = self.document.entry(key).or_insert_with(|| {
                    let mut table = Table::new();
                    table.set_implicit(true);
                    Item::Table(table)
                });
                let is_inline = parent.is_value();
                let new_item = || match is_inline {
                    true => toml_edit::value(toml_edit::InlineTable::new()),
                    false => new_table(),
                };
                let parent = parent.as_table_like_mut().ok_or_else(in_the_way)?;
                parent.entry(name).or_insert_with(new_item)
            }
        };
        item.as_table_like_mut().ok_or_else(in_the_way)
    }
}

/// Where the first one of the tables below stands among all.
fn first_position(table: &Table) -> Option<isize> {
    let of = |table: &Table| {
        let own = table.position().filter(|_| !table.is_implicit());
        own.into_iter().chain(first_position(table)).min()
    };
    let below = table.iter().filter_map(|(_, item)| match item {
        Item::Table(table) => of(table),
        Item::ArrayOfTables(tables) => tables.iter().filter_map(of).min(),
        _ => None,
    });
    below.min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::look::{Look, find};

    const TEXT: &str = "# Head.\nenvironment = { color = [1, 1, 1] } # white\n\n[node.a] # first\ntexture = 't'   # of mine\nscale   = 4     # odd spacing\n\n# Second.\n[node.b]\ntexture = 't'\n[material.\"A b\"]\n  roughness = 0.5 # rough\n# The end.\n";

    fn parsed(text: &str) -> LookDocument {
        LookDocument::parse(Path::new("a.look.toml"), text).unwrap_or_else(|e| panic!("{e}"))
    }

    fn node(name: &str) -> Section {
        Section::Node(name.to_owned())
    }

    #[test]
    fn an_edit_changes_its_line_alone() {
        let mut document = parsed(TEXT);
        assert_eq!(document.text(), TEXT);
        document
            .set(&node("a"), "scale", &Value::number(0.1))
            .unwrap();
        let section = Section::Material("A b".to_owned());
        document
            .set(&section, "roughness", &Value::Text("a".to_owned()))
            .unwrap();
        document
            .set(&Section::Environment, "intensity", &Value::number(2.0))
            .unwrap();
        let expected = TEXT
            .replace("= 4  ", "= 0.1  ")
            .replace("= 0.5 #", "= \"a\" #")
            .replace("[1, 1, 1] }", "[1, 1, 1] , intensity = 2.0}");
        let (text, same) = (document.text(), |a: &str, b: &str| {
            let bare = |t: &str| t.replace(' ', "");
            bare(a) == bare(b)
        });
        assert!(same(&text, &expected), "{text}");
        let changed = |a: &str, b: &str| a.lines().zip(b.lines()).filter(|(a, b)| a != b).count();
        assert_eq!(changed(TEXT, &text), 3, "{text}");
    }

    #[test]
    fn tables_come_and_go_and_comments_stay() {
        let mut document = parsed(TEXT);
        document
            .set(&node("c"), "texture", &Value::Text("t".to_owned()))
            .unwrap();
        document
            .set(&node("c"), "amount", &Value::Bool(true))
            .unwrap();
        document
            .set(&Section::Camera, "y_fov", &Value::Integer(40))
            .unwrap();
        document
            .set(
                &Section::Ao("near".to_owned()),
                "distance",
                &Value::number(0.5),
            )
            .unwrap();
        let text = document.text();
        let again = parsed(&text);
        assert_eq!(again.text(), text);
        let c = again.table(&node("c")).expect("added");
        assert!(find(&c, "amount").is_some_and(|v| v.value == Value::Bool(true)));
        assert!(again.table(&Section::Ao("near".to_owned())).is_some());
        for line in TEXT.lines() {
            assert!(
                text.lines().any(|l| l == line),
                "{line} is missing:\n{text}"
            );
        }
        document.remove_table(&node("c"));
        document.remove_table(&Section::Camera);
        document.remove_table(&Section::Ao("near".to_owned()));
        assert_eq!(document.text(), TEXT);
        document.remove(&node("a"), "scale");
        assert_eq!(
            document.text(),
            TEXT.replace("scale   = 4     # odd spacing\n", "")
        );
    }

    #[test]
    fn comments_at_the_top_stay_there() {
        let environment = "# A room.\n# By me.\nenvironment = { color = [1, 1, 1] } # white\n";
        let table = "\n[node.a]\ntexture = 't'\n";
        let nodes = "# A valve.\n\n# The first.\n[node.a]\ntexture = 't'\n\n# The second.\n[node.b]\ntexture = 't'\n";
        for (text, section, left) in [
            (
                format!("{environment}{table}"),
                Section::Environment,
                format!("# A room.\n# By me.\n{table}"),
            ),
            (
                environment.to_owned(),
                Section::Environment,
                "# A room.\n# By me.\n".to_owned(),
            ),
            (
                nodes.to_owned(),
                node("a"),
                "# A valve.\n\n# The second.\n[node.b]\ntexture = 't'\n".to_owned(),
            ),
            (
                nodes.to_owned(),
                node("b"),
                "# A valve.\n\n# The first.\n[node.a]\ntexture = 't'\n".to_owned(),
            ),
            (
                "# A view.\n\n[view]\nexposure = 1\n".to_owned(),
                Section::View,
                "# A view.\n".to_owned(),
            ),
            (
                "# Bright.\n[view]\nexposure = 1\n".to_owned(),
                Section::View,
                String::new(),
            ),
        ] {
            let mut document = parsed(&text);
            let kept = document.keep(&section);
            document.remove_table(&section);
            assert_eq!(document.text(), left);
            document.put_back(&section, kept);
            assert_eq!(document.text(), text);
        }
        // Whatever goes after that.
        let mut document = parsed(&nodes.replace('\n', "\r\n"));
        for name in ["a", "b"] {
            document.remove_table(&node(name));
        }
        assert_eq!(document.text(), "# A valve.\r\n");
    }

    #[test]
    fn what_is_kept_is_put_back_to_the_byte() {
        for section in [
            node("a"),
            node("b"),
            node("new"),
            Section::Environment,
            Section::Camera,
        ] {
            let mut document = parsed(TEXT);
            let kept = document.keep(&section);
            document
                .set(&section, "scale", &Value::number(3.0))
                .unwrap();
            assert_ne!(document.text(), TEXT);
            document.put_back(&section, kept);
            assert_eq!(document.text(), TEXT, "{section}");
        }
    }

    #[test]
    fn tables_of_any_shape_can_be_edited() {
        for text in [
            "node = { a = { texture = 't', scale = 1 } }",
            "node.a.texture = 't'\nnode.a.scale = 1",
            "[node]\na.texture = 't'\na.scale = 1",
            "[node]\na = { texture = 't', scale = 1 }",
            "",
        ] {
            let mut document = parsed(text);
            for name in ["a", "b"] {
                document
                    .set(&node(name), "texture", &Value::Text("t".to_owned()))
                    .unwrap();
                document
                    .set(&node(name), "scale", &Value::number(2.5))
                    .unwrap();
                document
                    .set(&node(name), "deep.er", &Value::number(1.0))
                    .unwrap();
            }
            let again = parsed(&document.text());
            for name in ["a", "b"] {
                let table = again
                    .table(&node(name))
                    .unwrap_or_else(|| panic!("{}", document.text()));
                assert!(find(&table, "scale").is_some_and(|v| v.value == Value::Float(2.5)));
                assert!(find(&table, "deep").is_some());
            }
        }
        let mut document = parsed("node = 3");
        assert!(document.set(&node("a"), "x", &Value::Integer(1)).is_err());
        assert_eq!(document.text(), "node = 3");
    }

    #[test]
    fn line_ends_and_byte_order_marks_stay() {
        let text = format!("{BYTE_ORDER_MARK}{}", TEXT.replace('\n', "\r\n"));
        let mut document = parsed(&text);
        document
            .set(&node("a"), "scale", &Value::Integer(5))
            .unwrap();
        assert_eq!(document.text(), text.replace("= 4 ", "= 5 "));
        assert!(Look::parse(Path::new("a"), &document.text()).is_ok());
    }

    #[test]
    fn lines_that_end_differently_stay_so() {
        // One of many, and all but a few.
        let one = TEXT.replacen("first\n", "first\r\n", 1);
        let most = one.replace('\n', "\r\n").replace("\r\r", "\r");
        let most = most.replacen("# Second.\r", "# Second.", 1);
        for (text, usual) in [(one, "\n"), (most, "\r\n")] {
            let mut document = parsed(&text);
            assert_eq!(document.text(), text);
            document
                .set(&node("a"), "scale", &Value::Integer(5))
                .unwrap();
            document
                .set(&node("b"), "amount", &Value::Integer(1))
                .unwrap();
            let edited = text.replace("= 4 ", "= 5 ");
            let edited = edited.replace("[material", &format!("amount = 1{usual}[material"));
            assert_eq!(document.text(), edited);
        }
    }

    #[test]
    fn numbers_come_back_to_the_bit() {
        let mut bits = 0x1234_5678_u32;
        for _ in 0..20_000 {
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let number = f32::from_bits(bits);
            if !number.is_finite() {
                continue;
            }
            let mut document = LookDocument::empty();
            document
                .set(&Section::Camera, "y_fov", &Value::number(number))
                .unwrap();
            let table = parsed(&document.text()).table(&Section::Camera).unwrap();
            let read = find(&table, "y_fov")
                .and_then(|v| v.value.as_number())
                .unwrap() as f32;
            assert_eq!(read.to_bits(), number.to_bits(), "{}", document.text());
        }
    }

    #[test]
    fn saving_replaces_a_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.look.toml");
        std::fs::write(&path, "old").expect("written");
        let document = parsed(TEXT);
        document.save(&path).expect("saved");
        assert_eq!(std::fs::read_to_string(&path).expect("there"), TEXT);
        assert!(
            document
                .save(&folder.path().join("no/a.look.toml"))
                .is_err()
        );
        assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 1);
    }
}
