//! Edits as JSON, for whoever talks to a session from another language or over a wire.
//!
//! An [`Edit`] is an object. `do` says what is done; `table` names the table of the look, as the list of its key and,
//! where the table has one, its name: `["camera"]`, `["environment"]`, `["view"]`, `["node", "rings"]`, `["material", "Red paint"]`,
//! `["ao", "near"]`, `["light", "Sun"]`, `["graph", "Frame"]`.
//!
//! | `do` | other members | what happens |
//! |---|---|---|
//! | `"set"` | `table`, `key`, `value` | the key of the table has this value; both are made where they are missing |
//! | `"clear"` | `table`, `key` | the key is taken away |
//! | `"remove"` | `table` | the table is taken away |
//!
//! `key` may lead to a key of a table below: `"blend.mask"`. `value` is what a look file would have there, as JSON: numbers,
//! texts, `true` and `false`, lists, and objects for tables, whose order of keys is kept. A number is whole where it is
//! written without a point or an exponent; any comes back to the last bit of single precision, in which looks are used.
//! `null`, and numbers that aren't finite, are no values.
//!
//! ```
//! use engine::session::Edit;
//!
//! let edit: Edit = serde_json::from_str(
//!     r#"{ "do": "set", "table": ["node", "rings"], "key": "count", "value": 7.5 }"#,
//! )?;
//! assert_eq!(edit, Edit::argument("rings", "count", &texgen::Value::F32(7.5)));
//! # Ok::<(), serde_json::Error>(())
//! ```

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::{self, Serialize, SerializeMap, SerializeSeq, Serializer};

use crate::scene::look::{Field, Section, Spanned, Value};

use super::edit::Edit;

/// [`Edit`], with what the scene's types look like in JSON.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
enum Written {
    Set {
        table: TableName,
        key: String,
        value: WrittenValue,
    },
    Clear {
        table: TableName,
        key: String,
    },
    Remove {
        table: TableName,
    },
}

impl Serialize for Edit {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let table = TableName(self.section().clone());
        let written = match self {
            Self::Set { key, value, .. } => Written::Set {
                table,
                key: key.clone(),
                value: WrittenValue(value.clone()),
            },
            Self::Clear { key, .. } => Written::Clear {
                table,
                key: key.clone(),
            },
            Self::Remove { .. } => Written::Remove { table },
        };
        written.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Edit {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match Written::deserialize(deserializer)? {
            Written::Set { table, key, value } => Self::Set {
                section: table.0,
                key,
                value: value.0,
            },
            Written::Clear { table, key } => Self::Clear {
                section: table.0,
                key,
            },
            Written::Remove { table } => Self::Remove { section: table.0 },
        })
    }
}

struct TableName(Section);

impl Serialize for TableName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (key, name) = self.0.place();
        serializer.collect_seq([Some(key), name].into_iter().flatten())
    }
}

impl<'de> Deserialize<'de> for TableName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let place = Vec::<String>::deserialize(deserializer)?;
        let place: Vec<&str> = place.iter().map(String::as_str).collect();
        let named = |section: fn(String) -> Section, name: &str| Self(section(name.to_owned()));
        Ok(match place[..] {
            ["environment"] => Self(Section::Environment),
            ["camera"] => Self(Section::Camera),
            ["view"] => Self(Section::View),
            ["light", name] => named(Section::Light, name),
            ["ao", name] => named(Section::Ao, name),
            ["node", name] => named(Section::Node, name),
            ["material", name] => named(Section::Material, name),
            ["graph", name] => named(Section::Frame, name),
            _ => {
                return Err(de::Error::custom(format!(
                    "{place:?} is no table: write [\"camera\"], [\"environment\"], [\"view\"], or [\"node\", NAME], and so for \
                     \"material\", \"ao\", \"light\" and \"graph\""
                )));
            }
        })
    }
}

struct WrittenValue(Value);

impl Serialize for WrittenValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            Value::Bool(x) => serializer.serialize_bool(*x),
            Value::Integer(x) => serializer.serialize_i64(*x),
            Value::Float(x) if x.is_finite() => serializer.serialize_f64(*x),
            Value::Float(x) => Err(ser::Error::custom(format!("{x} is no value of a look"))),
            Value::Text(text) => serializer.serialize_str(text),
            Value::List(items) => {
                let mut list = serializer.serialize_seq(Some(items.len()))?;
                for item in items {
                    list.serialize_element(&Self(item.value.clone()))?;
                }
                list.end()
            }
            Value::Table(fields) => {
                let mut table = serializer.serialize_map(Some(fields.len()))?;
                for Field { key, value } in fields {
                    table.serialize_entry(&key.value, &Self(value.value.clone()))?;
                }
                table.end()
            }
            Value::Date => Err(ser::Error::custom("a date is no value of a look")),
        }
    }
}

impl<'de> Deserialize<'de> for WrittenValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue).map(Self)
    }
}

/// Takes whatever comes.
struct AnyValue;

fn unplaced<T>(value: T) -> Spanned<T> {
    Spanned::new(value, 0..0)
}

impl<'de> Visitor<'de> for AnyValue {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, a text, true or false, a list, or an object")
    }

    fn visit_bool<E>(self, x: bool) -> Result<Value, E> {
        Ok(Value::Bool(x))
    }

    fn visit_i64<E>(self, x: i64) -> Result<Value, E> {
        Ok(Value::Integer(x))
    }

    fn visit_u64<E: de::Error>(self, x: u64) -> Result<Value, E> {
        let whole = i64::try_from(x);
        whole
            .map(Value::Integer)
            .map_err(|_| E::custom(format!("{x} is too large")))
    }

    fn visit_f64<E>(self, x: f64) -> Result<Value, E> {
        Ok(Value::Float(x))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut items = Vec::new();
        while let Some(WrittenValue(item)) = list.next_element()? {
            items.push(unplaced(item));
        }
        Ok(Value::List(items))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Value, A::Error> {
        let mut fields: Vec<Field> = Vec::new();
        while let Some((key, WrittenValue(value))) = table.next_entry::<String, _>()? {
            if fields.iter().any(|field| field.key.value == key) {
                return Err(de::Error::custom(format!("`{key}` is there twice")));
            }
            fields.push(Field {
                key: unplaced(key),
                value: unplaced(value),
            });
        }
        Ok(Value::Table(fields))
    }
}

#[cfg(test)]
mod tests {
    use texgen::{Interpolation, Ramp};

    use super::*;
    use crate::scene::look::{AoSettings, parse_value};

    fn toml(text: &str) -> Value {
        let value = parse_value(text).expect("TOML").value;
        without_places(value)
    }

    /// Edits come from nowhere in a text.
    fn without_places(value: Value) -> Value {
        match value {
            Value::List(items) => Value::List(
                (items.into_iter())
                    .map(|item| unplaced(without_places(item.value)))
                    .collect(),
            ),
            Value::Table(fields) => Value::Table(
                (fields.into_iter())
                    .map(|Field { key, value }| Field {
                        key: unplaced(key.value),
                        value: unplaced(without_places(value.value)),
                    })
                    .collect(),
            ),
            other => other,
        }
    }

    fn sections() -> Vec<Section> {
        let name = || "Red paint.\"1\" é".to_owned();
        vec![
            Section::Environment,
            Section::Camera,
            Section::View,
            Section::Light(name()),
            Section::Ao(name()),
            Section::Node(name()),
            Section::Material(name()),
            Section::Frame(name()),
        ]
    }

    /// One of every kind, of every table, with every kind of value.
    fn all() -> Vec<Edit> {
        let ramp = Ramp {
            stops: vec![(0.1, [0.9, 0.1, 0.2, 1.0]), (0.7, [0.1, 0.3, 0.7, 1.0])],
            interpolation: Interpolation::Smooth,
        };
        let mut edits = vec![
            Edit::argument("a", "x", &texgen::Value::Ramp(ramp)),
            Edit::argument("a", "m", &texgen::Value::Mat3([[0.1, 2.0, -3.5]; 3])),
            Edit::link("a", "x", "b.xyz"),
            Edit::reset("a", "x"),
            Edit::add_node("a", "fbm"),
            Edit::remove_node("a"),
            Edit::reset_material("Floor", "roughness"),
        ];
        edits.extend(Edit::ao("near", &AoSettings::default()));
        let values = [
            "true",
            "-3",
            "9223372036854775807",
            "4.0",
            "0.1",
            "1e-3",
            "'a \"text\"\\n\u{e9}'",
            "[]",
            "[1, 2.0, [3, 'x']]",
            "{ base = 'Z', over = 'A', mask = { b = [false], a = 1 } }",
        ];
        for section in sections() {
            for value in values {
                edits.push(Edit::set(section.clone(), "blend.mask", toml(value)));
            }
            edits.push(Edit::Clear {
                section: section.clone(),
                key: "a.b".to_owned(),
            });
            edits.push(Edit::Remove { section });
        }
        edits
    }

    #[test]
    fn every_edit_comes_back() {
        for edit in all() {
            let text = serde_json::to_string(&edit).unwrap_or_else(|e| panic!("{edit:?}: {e}"));
            let back = serde_json::from_str::<Edit>(&text);
            assert_eq!(
                back.unwrap_or_else(|e| panic!("{text}: {e}")),
                edit,
                "{text}"
            );
        }
    }

    #[test]
    fn every_number_comes_back_to_the_bit() {
        let mut state = 0x2545_f491_u32;
        for _ in 0..20_000 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let number = f32::from_bits(state);
            if number.is_finite() {
                let edit = Edit::camera("y_fov", Value::number(number));
                let text = serde_json::to_string(&edit).expect("finite");
                let back: Edit = serde_json::from_str(&text).expect("what was written");
                let Edit::Set { value, .. } = back else {
                    panic!("{text}");
                };
                let read = value.as_number().expect("a number") as f32;
                assert_eq!(read.to_bits(), state, "{text}");
            }
        }
    }

    #[test]
    fn the_json_is_what_is_documented() {
        for (edit, json) in [
            (
                Edit::camera("position", Value::numbers(&[1.0, 0.5, 2.0])),
                r#"{"do":"set","table":["camera"],"key":"position","value":[1.0,0.5,2.0]}"#,
            ),
            (
                Edit::material("Red paint", "blend", toml("{ over = 'B', base = 'A' }")),
                r#"{"do":"set","table":["material","Red paint"],"key":"blend","value":{"over":"B","base":"A"}}"#,
            ),
            (
                Edit::reset("rings", "count"),
                r#"{"do":"clear","table":["node","rings"],"key":"count"}"#,
            ),
            (
                Edit::remove_node("rings"),
                r#"{"do":"remove","table":["node","rings"]}"#,
            ),
        ] {
            assert_eq!(serde_json::to_string(&edit).expect("it is JSON"), json);
        }
    }

    #[test]
    fn what_is_no_edit_is_refused() {
        for (json, says) in [
            (
                r#"{"do":"set","table":["node"],"key":"x","value":1}"#,
                "is no table",
            ),
            (
                r#"{"do":"set","table":["nodes","a"],"key":"x","value":1}"#,
                "is no table",
            ),
            (
                r#"{"do":"set","table":["camera"],"key":"x","value":null}"#,
                "a number, a text",
            ),
            (r#"{"do":"set","table":["camera"],"key":"x"}"#, "value"),
            (r#"{"do":"sit","table":["camera"]}"#, "sit"),
            (r#"{"do":"remove","table":["camera"],"key":"x"}"#, "key"),
            (
                r#"{"do":"set","table":["camera"],"key":"x","value":18446744073709551615}"#,
                "too large",
            ),
            (
                r#"{"do":"set","table":["camera"],"key":"x","value":{"a":1,"a":2}}"#,
                "twice",
            ),
        ] {
            let error = serde_json::from_str::<Edit>(json)
                .expect_err(json)
                .to_string();
            assert!(error.contains(says), "{json}: {error}");
        }
        for value in [
            Value::Float(f64::NAN),
            Value::Float(f64::INFINITY),
            Value::Date,
        ] {
            assert!(serde_json::to_string(&Edit::camera("x", value)).is_err());
        }
    }
}
