//! The look file as a text that is edited: what is changed is written anew, everything else keeps its bytes, comments
//! and order.
//!
//! What keys mean is not known here; see [`super::Look`].

use std::io::{self, Write};
use std::path::Path;

use texgen::{Diagnostic, Diagnostics, SourceFile};
use toml_edit::{DocumentMut, Item, Table, TableLike};

use super::value::{Field, Value, fields, to_toml};

/// One table of a look.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Section {
    /// `environment = { ... }`.
    Environment,
    /// `[camera]`.
    Camera,
    /// `[ao.NAME]`.
    Ao(String),
    /// `[node.NAME]`.
    Node(String),
    /// `[material.NAME]`.
    Material(String),
}

impl Section {
    /// Its key in the file, and its name below that key where it has one.
    pub fn place(&self) -> (&'static str, Option<&str>) {
        match self {
            Self::Environment => ("environment", None),
            Self::Camera => ("camera", None),
            Self::Ao(name) => ("ao", Some(name)),
            Self::Node(name) => ("node", Some(name)),
            Self::Material(name) => ("material", Some(name)),
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
    /// Lines end with CR LF.
    has_crlf: bool,
    has_byte_order_mark: bool,
}

/// A table put aside.
#[derive(Debug)]
pub(crate) struct Kept(Option<Item>);

const BYTE_ORDER_MARK: &str = "\u{feff}";

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
            has_crlf: text.contains("\r\n"),
            has_byte_order_mark: text.starts_with(BYTE_ORDER_MARK),
        })
    }

    /// A look that says nothing.
    pub fn empty() -> Self {
        Self {
            document: DocumentMut::new(),
            has_crlf: false,
            has_byte_order_mark: false,
        }
    }

    /// The whole text, edits included.
    pub fn text(&self) -> String {
        let mut text = self.document.to_string();
        if self.has_crlf {
            text = text.replace("\r\n", "\n").replace('\n', "\r\n");
        }
        if self.has_byte_order_mark && !text.starts_with(BYTE_ORDER_MARK) {
            text.insert_str(0, BYTE_ORDER_MARK);
        }
        text
    }

    /// Writes the text aside, then renames it to `path`: the file is the old one or the new one, never half of either.
    ///
    /// # Errors
    /// The system refuses; the old file is untouched then.
    pub fn save(&self, path: &Path) -> io::Result<()> {
        // A link stays one: what it points to is replaced.
        let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let mut aside = tempfile::Builder::new()
            .prefix(".patina-")
            .tempfile_in(folder)?;
        aside.write_all(self.text().as_bytes())?;
        aside.as_file().sync_all()?;
        if let Ok(old) = std::fs::metadata(&path) {
            aside.as_file().set_permissions(old.permissions())?;
        }
        aside.persist(path).map_err(|error| error.error)?;
        Ok(())
    }

    /// Everything in it, without places.
    pub fn fields(&self) -> Vec<Field> {
        fields(self.document.as_table(), 0)
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
        let mut value = to_toml(value);
        match table.get_mut(last) {
            Some(Item::Value(old)) => {
                *value.decor_mut() = old.decor().clone();
                *old = value;
            }
            Some(item) => *item = Item::Value(value),
            None => {
                table.insert(last, Item::Value(value));
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

    /// Takes a whole table away, if it is there.
    pub fn remove_table(&mut self, section: &Section) {
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
    }

    /// A copy of a table as it is written, to be [put back](Self::put_back).
    pub(crate) fn keep(&self, section: &Section) -> Kept {
        let (key, name) = section.place();
        let item = self.document.get(key);
        Kept(match name {
            Some(name) => item.and_then(|item| item.as_table_like()?.get(name)).cloned(),
            None => item.cloned(),
        })
    }

    /// Makes a table what it was, to the byte.
    pub(crate) fn put_back(&mut self, section: &Section, kept: Kept) {
        let Some(item) = kept.0 else {
            return self.remove_table(section);
        };
        let (key, name) = section.place();
        match (name, self.document.get_mut(key)) {
            (Some(name), Some(parent)) => {
                if let Some(parent) = parent.as_table_like_mut() {
                    parent.insert(name, item);
                }
            }
            _ => {
                self.document.insert(key, item);
            }
        }
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
