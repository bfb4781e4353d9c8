//! The look file as a tree of values that remember where they were written.
//!
//! toml_edit knows several shapes for one thing (tables, inline tables, arrays of tables); everything after this
//! file sees one. Nothing here knows what a key means.

use std::ops::Range;

use toml_edit::{Item, TableLike};

/// Byte range in the text of the look file.
pub type Span = Range<usize>;

/// A value and where it was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Its place in the text.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// A value with its place.
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }

    /// Another value at the same place.
    pub fn with<U>(&self, value: U) -> Spanned<U> {
        Spanned::new(value, self.span.clone())
    }
}

/// Anything that can stand on the right of a `=`, without meaning yet.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// A number without a fraction.
    Integer(i64),
    /// A number with a fraction.
    Float(f64),
    /// A string.
    Text(String),
    /// `[a, b, ...]`, or tables headed `[[name]]`.
    List(Vec<Spanned<Value>>),
    /// `{ key = value, ... }`, or a table headed `[name]`, in the order of the file.
    Table(Vec<Field>),
    /// A date or time, which no key accepts.
    Date,
}

/// One `key = value` of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// The key, without quotes.
    pub key: Spanned<String>,
    /// What it is set to.
    pub value: Spanned<Value>,
}

impl Value {
    /// What it is, for messages: "a number", "a string", ...
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Bool(_) => "true or false",
            Self::Integer(_) | Self::Float(_) => "a number",
            Self::Text(_) => "a string",
            Self::List(_) => "a list",
            Self::Table(_) => "a table",
            Self::Date => "a date",
        }
    }

    /// Whether two values mean the same, wherever they were written. The order of a table's keys means nothing.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::List(a), Self::List(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.value.is_same(&b.value))
            }
            (Self::Table(a), Self::Table(b)) => {
                let same = |field: &Field| {
                    find(b, &field.key.value)
                        .is_some_and(|value| value.value.is_same(&field.value.value))
                };
                a.len() == b.len() && a.iter().all(same)
            }
            (Self::Date, _) | (_, Self::Date) => false,
            _ => self == other,
        }
    }

    /// A list of numbers, written nowhere.
    pub fn numbers(numbers: &[f32]) -> Self {
        let number = |&n: &f32| Spanned::new(Self::number(n), 0..0);
        Self::List(numbers.iter().map(number).collect())
    }

    /// A number with the fewest digits that give this one back.
    pub fn number(number: f32) -> Self {
        let short = number.to_string().parse::<f64>();
        // Reading goes through double precision, and rounding twice may end elsewhere.
        let exact = short.ok().filter(|&short| short as f32 == number);
        Self::Float(exact.unwrap_or(f64::from(number)))
    }

    /// The number it is, if it is one.
    pub fn as_number(&self) -> Option<f64> {
        match *self {
            // Exact up to 2^53, far above anything that is then stored in an f32 without rounding.
            Self::Integer(i) => Some(i as f64),
            Self::Float(f) => Some(f),
            _ => None,
        }
    }
}

/// The value of a key.
pub fn find<'f>(fields: &'f [Field], key: &str) -> Option<&'f Spanned<Value>> {
    let field = fields.iter().find(|field| field.key.value == key);
    field.map(|field| &field.value)
}

/// As toml_edit writes it.
pub(super) fn to_toml(value: &Value) -> toml_edit::Value {
    match value {
        Value::Bool(b) => (*b).into(),
        Value::Integer(i) => (*i).into(),
        Value::Float(f) => (*f).into(),
        Value::Text(text) => text.as_str().into(),
        Value::List(items) => {
            let items = items.iter().map(|item| to_toml(&item.value));
            toml_edit::Value::Array(items.collect())
        }
        Value::Table(fields) => {
            let mut table = toml_edit::InlineTable::new();
            for Field { key, value } in fields {
                table.insert(&key.value, to_toml(&value.value));
            }
            table.into()
        }
        // No key takes one, so none is ever written.
        Value::Date => "".into(),
    }
}

/// One value as it stands on the right of a `=`; `None` where it isn't TOML.
pub fn parse_value(text: &str) -> Option<Spanned<Value>> {
    let value: toml_edit::Value = text.parse().ok()?;
    Some(from_value(&value, 0))
}

/// Converts a parsed table; `end` stands in where toml_edit has no span (it has one for everything that was written).
pub(super) fn fields(table: &dyn TableLike, end: usize) -> Vec<Field> {
    table
        .iter()
        .filter_map(|(name, item)| {
            let value = from_item(item, end)?;
            let span = table
                .key(name)
                .and_then(toml_edit::Key::span)
                .unwrap_or(value.span.clone());
            Some(Field {
                key: Spanned::new(name.to_owned(), span),
                value,
            })
        })
        .collect()
}

pub(super) fn from_item(item: &Item, end: usize) -> Option<Spanned<Value>> {
    let span = item.span().unwrap_or(end..end);
    let value = match item {
        Item::None => return None,
        Item::Value(value) => return Some(from_value(value, end)),
        Item::Table(table) => Value::Table(fields(table, end)),
        Item::ArrayOfTables(tables) => Value::List(
            tables
                .iter()
                .map(|t| Spanned::new(Value::Table(fields(t, end)), t.span().unwrap_or(end..end)))
                .collect(),
        ),
    };
    Some(Spanned::new(value, span))
}

pub(super) fn from_value(value: &toml_edit::Value, end: usize) -> Spanned<Value> {
    let span = value.span().unwrap_or(end..end);
    let value = match value {
        toml_edit::Value::String(s) => Value::Text(s.value().clone()),
        toml_edit::Value::Integer(i) => Value::Integer(*i.value()),
        toml_edit::Value::Float(f) => Value::Float(*f.value()),
        toml_edit::Value::Boolean(b) => Value::Bool(*b.value()),
        toml_edit::Value::Datetime(_) => Value::Date,
        toml_edit::Value::Array(a) => Value::List(a.iter().map(|v| from_value(v, end)).collect()),
        toml_edit::Value::InlineTable(t) => Value::Table(fields(t, end)),
    };
    Spanned::new(value, span)
}
