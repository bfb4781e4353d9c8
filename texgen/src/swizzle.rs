//! What a link takes of a result: an output by its name, components of it (`.x`, `.xy`, `.rgb`, `.wzyx`), or both (`.color.r`).

use std::fmt;
use std::str::FromStr;

/// Names of outputs have at most so many letters: a link is a small value that is copied.
const MAX_OUTPUT_NAME: usize = 31;

/// The name of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct OutputName {
    bytes: [u8; MAX_OUTPUT_NAME],
    len: u8,
}

impl OutputName {
    fn new(name: &str) -> Option<Self> {
        let is_name = fault_of_output(name).is_none();
        let mut bytes = [0; MAX_OUTPUT_NAME];
        bytes
            .get_mut(..name.len())
            .filter(|_| is_name)?
            .copy_from_slice(name.as_bytes());
        Some(Self {
            bytes,
            len: name.len() as u8,
        })
    }

    fn as_str(&self) -> &str {
        // Nothing but ASCII goes in.
        std::str::from_utf8(&self.bytes[..usize::from(self.len)]).unwrap_or_default()
    }
}

/// Why links can't take an output by this name, if they can't.
pub(crate) fn fault_of_output(name: &str) -> Option<String> {
    let is_inside = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if components(name).is_some() {
        return Some("links would take it for components".to_owned());
    }
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
        return Some("it is no name".to_owned());
    }
    if !name.chars().all(is_inside) {
        return Some("links write names with ASCII letters, digits and `_` only".to_owned());
    }
    (name.len() > MAX_OUTPUT_NAME).then(|| format!("it is longer than {MAX_OUTPUT_NAME} letters"))
}

/// Which output of a node a link takes, and which components of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Swizzle {
    output: Option<OutputName>,
    components: [u8; 4],
    /// None of them: the output as a whole.
    len: u8,
}

impl Swizzle {
    /// An output as a whole. `None` for what can't be the name of an output: those are words of WGSL of at most 31 letters that
    /// aren't components themselves.
    pub fn of_output(name: &str) -> Option<Self> {
        Some(Self {
            output: Some(OutputName::new(name)?),
            components: [0; 4],
            len: 0,
        })
    }

    /// The output taken, where it isn't the first one of its texture.
    pub fn output(&self) -> Option<&str> {
        self.output.as_ref().map(OutputName::as_str)
    }

    /// The components taken, 0 for x to 3 for w; empty where all of them are.
    pub fn components(&self) -> &[u8] {
        &self.components[..self.len as usize]
    }

    /// The same output as a whole; `None` for the first one.
    pub fn whole(&self) -> Option<Self> {
        self.output.map(|output| Self {
            output: Some(output),
            components: [0; 4],
            len: 0,
        })
    }

    /// Selectors for all four components of the link's value, as results of that many components are stored:
    /// one is repeated, missing ones are 0 (selector 4), a missing last one is 1 (selector 5).
    pub(crate) fn selectors(&self) -> [u8; 4] {
        let [x, y, z, w] = self.components;
        match self.len {
            0 => [0, 1, 2, 3],
            1 => [x, x, x, x],
            2 => [x, y, 4, 5],
            3 => [x, y, z, 5],
            _ => [x, y, z, w],
        }
    }
}

/// Neither components nor the name of an output.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not a swizzle: write one to four of x, y, z, w or of r, g, b, a, like `.x` or `.rgb`, or the name of an output"
)]
pub struct SwizzleError(pub String);

impl FromStr for Swizzle {
    type Err = SwizzleError;

    /// With or without the leading dot.
    fn from_str(text: &str) -> Result<Self, SwizzleError> {
        let error = || SwizzleError(text.to_owned());
        let inner = text.strip_prefix('.').unwrap_or(text);
        let (first, rest) = match inner.split_once('.') {
            Some((first, rest)) => (first, Some(rest)),
            None => (inner, None),
        };
        let (output, letters) = match (components(first), rest) {
            (Some(_), None) => (None, Some(first)),
            (Some(_), Some(_)) => return Err(error()),
            (None, rest) => (Some(OutputName::new(first).ok_or_else(error)?), rest),
        };
        let (components, len) = match letters {
            Some(letters) => components(letters).ok_or_else(error)?,
            None => ([0; 4], 0),
        };
        Ok(Self {
            output,
            components,
            len,
        })
    }
}

/// One to four letters of one of the two sets, as numbers.
fn components(letters: &str) -> Option<([u8; 4], u8)> {
    if letters.is_empty() || letters.len() > 4 {
        return None;
    }
    let set = if letters.contains(['x', 'y', 'z', 'w']) {
        "xyzw"
    } else {
        "rgba"
    };
    let mut components = [0; 4];
    for (component, letter) in components.iter_mut().zip(letters.chars()) {
        *component = set.find(letter)? as u8;
    }
    Some((components, letters.len() as u8))
}

impl fmt::Display for Swizzle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(output) = self.output() {
            write!(f, ".{output}")?;
        }
        if self.len > 0 {
            f.write_str(".")?;
        }
        self.components()
            .iter()
            .try_for_each(|&c| f.write_str(["x", "y", "z", "w"][usize::from(c)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn swizzles_parse_and_print() {
        let parse = |text: &str| text.parse::<Swizzle>();
        let long = "o".repeat(MAX_OUTPUT_NAME + 1);
        for (text, printed) in [
            (".rgb", ".xyz"),
            ("x", ".x"),
            ("cell", ".cell"),
            (".cell.rg", ".cell.xy"),
        ] {
            assert_eq!(
                parse(text).map(|s| s.to_string()).as_deref(),
                Ok(printed),
                "{text}"
            );
        }
        assert_eq!(
            parse("wzyx").map(|s| s.components().to_vec()),
            Ok(vec![3, 2, 1, 0])
        );
        let color = parse("color.g").expect("both");
        assert_eq!(
            (color.output(), color.components()),
            (Some("color"), &[1][..])
        );
        assert_eq!(color.whole(), Swizzle::of_output("color"));
        assert_eq!(Swizzle::of_output("xy"), None, "they are components");
        for (name, fault) in [
            ("rg", "components"),
            ("größe", "ASCII"),
            ("a-b", "ASCII"),
            (long.as_str(), "longer than 31"),
            ("5", "no name"),
            ("", "no name"),
        ] {
            let said = fault_of_output(name);
            assert!(said.is_some_and(|said| said.contains(fault)), "{name}");
        }
        for bad in [
            "", ".", "5", "x.y", "a b", "é", "cell.", "cell.q", "cell.x.y", &long,
        ] {
            assert_eq!(parse(bad), Err(SwizzleError(bad.into())));
        }
    }
}
