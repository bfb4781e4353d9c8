//! Renaming a table of a look's text: the table keeps its place, its comments and its keys as they are written.
//!
//! Whoever refers to it is not changed here; what a value refers to only its reader knows.

use toml_edit::{InlineTable, Item, Key, Table};

use super::document::{LookDocument, Section};

impl LookDocument {
    /// Gives the table of a section another name. Whether that name may be used is not checked, except that no other
    /// table is lost by it.
    ///
    /// # Errors
    /// There is no such table, it has no name, or something is called so already.
    pub fn rename(&mut self, section: &Section, name: &str) -> Result<(), String> {
        let (parent, Some(old)) = section.place() else {
            return Err(format!("{section} has no name"));
        };
        let missing = || format!("there is no {section}");
        let parent = self.root_mut().get_mut(parent).ok_or_else(missing)?;
        let tables = parent.as_table_like().ok_or_else(missing)?;
        if !tables.contains_key(old) {
            return Err(missing());
        }
        if tables.contains_key(name) {
            return Err(format!("there is something called `{name}` already"));
        }
        match parent {
            Item::Table(table) => rename_in_table(table, old, name),
            Item::Value(toml_edit::Value::InlineTable(table)) => rename_inline(table, old, name),
            _ => return Err(missing()),
        }
        Ok(())
    }
}

/// The entries are put in again one after the other, since their order is what is written.
fn rename_in_table(table: &mut Table, old: &str, name: &str) {
    let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    for key in keys {
        if let Some((key, item)) = table.remove_entry(&key) {
            table.insert_formatted(&renamed(key, old, name), item);
        }
    }
}

fn rename_inline(table: &mut InlineTable, old: &str, name: &str) {
    let keys: Vec<String> = table.iter().map(|(key, _)| key.to_owned()).collect();
    for key in keys {
        if let Some((key, value)) = table.remove_entry(&key) {
            table.insert_formatted(&renamed(key, old, name), value);
        }
    }
}

/// The key, or the new one with the spaces and comments around it.
fn renamed(key: Key, old: &str, name: &str) -> Key {
    if key.get() != old {
        return key;
    }
    Key::new(name)
        .with_leaf_decor(key.leaf_decor().clone())
        .with_dotted_decor(key.dotted_decor().clone())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::look::Value;

    fn renamed_text(text: &str) -> String {
        let path = Path::new("a.look.toml");
        let mut document = LookDocument::parse(path, text).unwrap_or_else(|e| panic!("{e}"));
        let section = Section::Node("rust".to_owned());
        assert_eq!(document.text(), text);
        document.rename(&section, "moss").expect("renamed");
        let mut again =
            LookDocument::parse(path, &document.text()).unwrap_or_else(|e| panic!("{e}"));
        assert!(again.table(&section).is_none());
        // What is edited after it finds the table.
        let moss = Section::Node("moss".to_owned());
        again.set(&moss, "new", &Value::Bool(true)).expect("there");
        document.text()
    }

    #[test]
    fn only_the_name_changes_in_tables_of_any_shape() {
        for text in [
            "# Head.\n[node.rust] # it rusts\n  texture = 't' # mine\n\n[node.b]\ntexture = 't'\n[node.rust.ramp] # below\nstops = []\n[material.M]\n",
            "[node.b]\n# before\n[material.M]\n[node.rust]\nx = 1\n# The end.",
            "node = { b = {}, rust = { texture = 't' } , c = {} } # all",
            "node.rust.texture = 't' # one\nnode.rust.scale = 1\nnode.b.texture = 't'\n",
            "[node]\nb = { x = 1 }\nrust.texture = 't'\nrust.scale = 2 # two\nc = {}\n",
            "[node]\r\n'rust' = { texture = 't' }\r\n",
        ] {
            let expected = text.replace("'rust'", "rust").replace("rust", "moss");
            let expected = expected.replace("it mosss", "it rusts");
            assert_eq!(renamed_text(text), expected);
        }
    }

    #[test]
    fn names_that_need_quotes_get_them() {
        let text = "[material.Iron] # hard\nroughness = 0.5\n";
        let mut document = LookDocument::parse(Path::new("a"), text).expect("a look");
        let iron = Section::Material("Iron".to_owned());
        document.rename(&iron, "Old \"iron\"").expect("renamed");
        let text = document.text();
        let again = LookDocument::parse(Path::new("a"), &text).expect("a look");
        let old = Section::Material("Old \"iron\"".to_owned());
        assert!(again.table(&old).is_some(), "{text}");
        assert!(text.contains("# hard"));
    }

    #[test]
    fn nothing_is_lost() {
        let text = "[node.a]\n[node.b]\n";
        let mut document = LookDocument::parse(Path::new("a"), text).expect("a look");
        let node = |name: &str| Section::Node(name.to_owned());
        assert!(document.rename(&node("a"), "b").is_err());
        assert!(document.rename(&node("a"), "a").is_err());
        assert!(document.rename(&node("c"), "d").is_err());
        assert!(document.rename(&Section::Camera, "d").is_err());
        let ao = Section::Ao("a".to_owned());
        assert!(document.rename(&ao, "d").is_err());
        assert_eq!(document.text(), text);
    }
}
