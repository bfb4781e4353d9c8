//! The JSON of a glTF file, read leniently and within memory.
//!
//! The typed reader is stricter than glTF is: it wants an array of nodes in every scene, refuses integers written as
//! `3.0`, and can't read `extras` inside of extensions. So the text is first written anew, value by value and without a
//! tree of it in between. What nothing reads is left out there, and what stays is weighed: a value of two bytes can take
//! hundreds in memory.

use gltf::json;
use serde::de::{
    DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor,
};
use serde_json::Value;
use std::fmt;
use std::io::Write as _;

/// What the values of a file may take however small it is.
const FREE: u64 = 512 << 20;
/// What a byte of JSON may become.
const FACTOR: u64 = 16;
/// About the largest that an object is in memory, and that a value is that no type describes.
const OBJECT: u64 = 512;
const UNTYPED: u64 = 160;
const OTHER: u64 = 16;
/// Longest name of anything; it is copied for every instance.
const MAX_NAME_CHARS: usize = 256;
/// Up to this length a text with mistakes is read once more, for the line of the mistake.
const MAX_READ_AGAIN: usize = 16 << 20;

/// Members of the file that are read by their types. Animations are kept as they are, and only where they are wanted: those of
/// a scene at rest need not be valid.
const ROOT: [&str; 16] = [
    "accessors",
    "asset",
    "bufferViews",
    "buffers",
    "cameras",
    "extensions",
    "extensionsRequired",
    "extensionsUsed",
    "images",
    "materials",
    "meshes",
    "nodes",
    "samplers",
    "scene",
    "scenes",
    "skins",
];

/// What is read of a morph target.
const MORPHED: [&str; 3] = ["POSITION", "NORMAL", "TANGENT"];

/// What was read.
pub(super) struct Parsed {
    pub(super) root: json::Root,
    /// `extras.environment` of each scene.
    pub(super) environments: Vec<Option<Value>>,
    /// `animations`, whatever that is; null where it isn't wanted.
    pub(super) animations: Value,
    /// It has some, wanted or not.
    pub(super) has_animations: bool,
    /// Morph targets have more than [`MORPHED`], which no type keeps.
    pub(super) morphs_others: bool,
}

/// Why JSON can't be read.
pub(super) enum JsonError {
    /// It is not JSON, or not glTF.
    Invalid(serde_json::Error),
    /// It would take too much memory.
    TooLarge,
}

/// Reads the JSON of a file; contents of extensions for which `is_read` doesn't hold are left out, and so are animations where
/// none are wanted.
pub(super) fn parse(
    text: &[u8],
    is_read: fn(&str) -> bool,
    with_animations: bool,
) -> Result<Parsed, JsonError> {
    let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text);
    let mut rewriter = Rewriter {
        text: Vec::new(),
        environments: Vec::new(),
        animations: Value::Null,
        has_animations: false,
        morphs_others: false,
        with_animations,
        left: FREE + FACTOR * text.len() as u64,
        is_read,
    };
    let mut source = serde_json::Deserializer::from_slice(text);
    let rewritten = Part::new(&mut rewriter, Place::Root)
        .deserialize(&mut source)
        .and_then(|()| source.end());
    if let Err(error) = rewritten {
        return Err(match rewriter.left {
            0 => JsonError::TooLarge,
            _ => JsonError::Invalid(error),
        });
    }
    match serde_json::from_slice(&rewriter.text) {
        Ok(root) => Ok(Parsed {
            root,
            environments: rewriter.environments,
            animations: rewriter.animations,
            has_animations: rewriter.has_animations,
            morphs_others: rewriter.morphs_others,
        }),
        // Reading the text itself gives the same error with its own line and column.
        Err(error) if text.len() <= MAX_READ_AGAIN => Err(JsonError::Invalid(
            serde_json::from_slice::<json::Root>(text)
                .err()
                .unwrap_or(error),
        )),
        Err(error) => Err(JsonError::Invalid(error)),
    }
}

struct Rewriter {
    text: Vec<u8>,
    environments: Vec<Option<Value>>,
    animations: Value,
    has_animations: bool,
    morphs_others: bool,
    with_animations: bool,
    /// Bytes that values may still take; 0 once one was refused.
    left: u64,
    is_read: fn(&str) -> bool,
}

/// Where a value stands.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Root,
    /// The list of scenes, one of them, and its extras.
    Scenes,
    Scene,
    SceneExtras,
    Animations,
    /// The morph targets of a primitive, and one of them.
    Targets,
    Target,
    /// Whatever has a type.
    Typed,
    Name,
    /// The members are extensions.
    Extensions,
    /// In an extension.
    Untyped,
    UntypedName,
}

/// One value that is to be written anew.
struct Part<'r> {
    to: &'r mut Rewriter,
    place: Place,
}

impl<'r> Part<'r> {
    fn new(to: &'r mut Rewriter, place: Place) -> Self {
        Self { to, place }
    }

    /// Where a member stands; `None` where it is left out.
    fn place_of(&self, key: &str) -> Option<Place> {
        match (self.place, key) {
            (Place::Root, "scenes") => Some(Place::Scenes),
            (Place::Root, "textures") => Some(Place::Typed),
            (Place::Root, "animations") if self.to.with_animations => Some(Place::Animations),
            (Place::Root, key) if !ROOT.contains(&key) => None,
            (Place::Scene, "extras") => Some(Place::SceneExtras),
            (_, "extras") => None,
            (Place::SceneExtras | Place::Animations, _) => Some(Place::Untyped),
            (Place::Untyped | Place::UntypedName, "name") => Some(Place::UntypedName),
            (_, "name") => Some(Place::Name),
            (Place::Untyped | Place::UntypedName, _) => Some(Place::Untyped),
            (Place::Extensions, key) if !(self.to.is_read)(key) => None,
            (Place::Extensions, _) => Some(Place::Untyped),
            (_, "extensions") => Some(Place::Extensions),
            (Place::Typed, "targets") => Some(Place::Targets),
            _ => Some(Place::Typed),
        }
    }

    fn weigh<E: serde::de::Error>(&mut self, typed: u64) -> Result<(), E> {
        let weight = match self.place {
            Place::Untyped
            | Place::UntypedName
            | Place::Extensions
            | Place::SceneExtras
            | Place::Animations => typed.max(UNTYPED),
            _ => typed,
        };
        match self.to.left.checked_sub(weight) {
            Some(left @ 1..) => {
                self.to.left = left;
                Ok(())
            }
            _ => {
                self.to.left = 0;
                Err(E::custom("too many values"))
            }
        }
    }

    fn scalar<E: serde::de::Error>(mut self, value: impl serde::Serialize) -> Result<(), E> {
        self.weigh(OTHER)?;
        self.write(value)
    }

    fn write<E: serde::de::Error>(&mut self, value: impl serde::Serialize) -> Result<(), E> {
        serde_json::to_writer(&mut self.to.text, &value).map_err(E::custom)
    }

    /// A value that doesn't go into the text.
    fn aside<'de, A: MapAccess<'de>>(
        &mut self,
        place: Place,
        map: &mut A,
    ) -> Result<Value, A::Error> {
        let start = self.to.text.len();
        map.next_value_seed(Part::new(self.to, place))?;
        let value = serde_json::from_slice(&self.to.text[start..]).map_err(A::Error::custom)?;
        self.to.text.truncate(start);
        Ok(value)
    }

    fn member<'de, A: MapAccess<'de>>(
        &mut self,
        key: &str,
        place: Place,
        is_first: &mut bool,
        map: &mut A,
    ) -> Result<(), A::Error> {
        if !std::mem::take(is_first) {
            self.to.text.push(b',');
        }
        self.write(key)?;
        self.to.text.push(b':');
        map.next_value_seed(Part::new(self.to, place))
    }
}

impl<'de> DeserializeSeed<'de> for Part<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<(), D::Error> {
        source.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Part<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E: serde::de::Error>(self) -> Result<(), E> {
        self.scalar(())
    }

    fn visit_bool<E: serde::de::Error>(self, value: bool) -> Result<(), E> {
        self.scalar(value)
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<(), E> {
        self.scalar(value)
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<(), E> {
        self.scalar(value)
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<(), E> {
        if value.fract() == 0.0 && (0.0..9e15).contains(&value) {
            self.scalar(value as u64)
        } else {
            self.scalar(value)
        }
    }

    fn visit_str<E: serde::de::Error>(mut self, value: &str) -> Result<(), E> {
        let end = value.char_indices().nth(MAX_NAME_CHARS).map(|(at, _)| at);
        let value = match (self.place, end) {
            (Place::Name | Place::UntypedName, Some(end)) => &value[..end],
            _ => value,
        };
        self.weigh(OTHER + value.len() as u64)?;
        self.write(value)
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
        self.weigh(2 * OTHER)?;
        let place = match self.place {
            Place::Scenes => Place::Scene,
            Place::Targets => Place::Target,
            Place::Untyped | Place::UntypedName | Place::SceneExtras | Place::Animations => {
                Place::Untyped
            }
            _ => Place::Typed,
        };
        self.to.text.push(b'[');
        let mut count = 0;
        loop {
            // Where there is no further item, nothing follows this comma but the bracket, which takes its place.
            if count > 0 {
                self.to.text.push(b',');
            }
            if list.next_element_seed(Part::new(self.to, place))?.is_none() {
                break;
            }
            count += 1;
            if place == Place::Scene && self.to.environments.len() < count {
                self.to.environments.push(None);
            }
        }
        if count > 0 {
            self.to.text.pop();
        }
        self.to.text.push(b']');
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<(), A::Error> {
        self.weigh(OBJECT)?;
        let (mut is_first, mut has_nodes, mut environment) = (true, false, None);
        self.to.text.push(b'{');
        while let Some(key) = map.next_key::<String>()? {
            self.to.has_animations |= self.place == Place::Root && key == "animations";
            match self.place_of(&key) {
                Some(Place::SceneExtras) => {
                    let extras = self.aside(Place::SceneExtras, &mut map)?;
                    environment = extras.get("environment").cloned();
                }
                Some(Place::Animations) => {
                    self.to.animations = self.aside(Place::Animations, &mut map)?;
                }
                Some(place) => {
                    has_nodes |= key == "nodes";
                    self.to.morphs_others |= self.place == Place::Target
                        && place == Place::Typed
                        && !MORPHED.contains(&key.as_str());
                    self.member(&key, place, &mut is_first, &mut map)?;
                }
                None => {
                    map.next_value::<IgnoredAny>()?;
                    if self.place == Place::Extensions {
                        // That it is there matters: it may be required, and else there is a warning.
                        if !std::mem::take(&mut is_first) {
                            self.to.text.push(b',');
                        }
                        self.write(&key)?;
                        let _ = self.to.text.write_all(b":{}");
                    }
                }
            }
        }
        if self.place == Place::Scene {
            if !has_nodes {
                let comma = if is_first { "" } else { "," };
                let _ = write!(self.to.text, "{comma}\"nodes\":[]");
            }
            self.to.environments.push(environment);
        }
        self.to.text.push(b'}');
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Parsed, JsonError> {
        parse(text.as_bytes(), |name| name == "KNOWN", true)
    }

    fn parsed(text: &str) -> Parsed {
        match read(text) {
            Ok(parsed) => parsed,
            Err(JsonError::Invalid(error)) => panic!("{error}"),
            Err(JsonError::TooLarge) => panic!("too large"),
        }
    }

    #[test]
    fn what_exporters_write_is_read() {
        let Parsed {
            root,
            environments,
            animations,
            ..
        } = parsed(
            r#"{"asset": {"version": "2.0", "extras": {"x": [1]}}, "unknown": [[[]]], "animations": 7, "scene": 1.0,
                "scenes": [{"extras": {"environment": {"constant": [1, 0.5, -2.0]}}}, {"name": "b", "nodes": [0]}, {}],
                "nodes": [{"translation": [1.0, -1.0, 0.1], "name": "a\u00e9\"", "extensions": {"OTHER": [1], "KNOWN": {"a": [2.0]}}}]}"#,
        );
        assert_eq!(root.scene.map(|scene| scene.value()), Some(1));
        assert_eq!(root.scenes.len(), 3);
        assert_eq!(root.nodes[0].translation, Some([1.0, -1.0, 0.1]));
        assert_eq!(root.nodes[0].name.as_deref(), Some("aé\""));
        let others = &root.nodes[0].extensions.as_ref().expect("two").others;
        assert_eq!(
            serde_json::to_string(others).unwrap(),
            r#"{"KNOWN":{"a":[2]},"OTHER":{}}"#
        );
        let environment = environments[0].as_ref().map(Value::to_string);
        assert_eq!(environment.as_deref(), Some(r#"{"constant":[1,0.5,-2.0]}"#));
        assert_eq!(environments[1..], [None, None]);
        assert_eq!(animations, 7);
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        let Err(JsonError::Invalid(error)) = read("{\n\"asset\": {\"version\": 2}}") else {
            panic!("it is no version");
        };
        assert_eq!(error.line(), 2, "{error}");
        for text in ["", "{", "[]", "{} x", "{\"nodes\": [}", "nul"] {
            assert!(matches!(read(text), Err(JsonError::Invalid(_))), "{text}");
        }
    }

    #[test]
    fn many_small_values_are_refused_where_they_would_be_kept() {
        let many = "{},".repeat(4 << 20);
        let kept = format!(r#"{{"asset":{{"version":"2.0"}},"nodes":[{many}{{}}]}}"#);
        assert!(matches!(read(&kept), Err(JsonError::TooLarge)));
        let extension = kept
            .replace("\"nodes\":", "\"extensions\":{\"KNOWN\":")
            .replace("}]}", "}]}}");
        assert!(matches!(read(&extension), Err(JsonError::TooLarge)));
        let moving = kept.replace("\"nodes\"", "\"animations\"");
        assert!(matches!(read(&moving), Err(JsonError::TooLarge)));
        let resting = parse(moving.as_bytes(), |_| true, false);
        assert!(resting.is_ok_and(|parsed| parsed.animations.is_null() && parsed.has_animations));
        let ignored = kept.replace("\"nodes\"", "\"x\"");
        let ignored = parsed(&ignored);
        assert!(ignored.root.nodes.is_empty() && !ignored.has_animations);
    }
}
