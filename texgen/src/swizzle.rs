//! Swizzles of links: `.x`, `.xy`, `.rgb`, `.wzyx`.

use std::fmt;
use std::str::FromStr;

/// Which components of a result a link takes: one to four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Swizzle {
    components: [u8; 4],
    len: u8,
}

impl Swizzle {
    /// The components taken, 0 for x to 3 for w.
    pub fn components(&self) -> &[u8] {
        &self.components[..self.len as usize]
    }

    /// Selectors for all four components of the link's value, as results of that many components are stored:
    /// one is repeated, missing ones are 0 (selector 4), a missing last one is 1 (selector 5).
    pub(crate) fn selectors(&self) -> [u8; 4] {
        let [x, y, z, w] = self.components;
        match self.len {
            1 => [x, x, x, x],
            2 => [x, y, 4, 5],
            3 => [x, y, z, 5],
            _ => [x, y, z, w],
        }
    }
}

/// Not a swizzle.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not a swizzle: write one to four of x, y, z, w or of r, g, b, a, like `.x` or `.rgb`"
)]
pub struct SwizzleError(pub String);

impl FromStr for Swizzle {
    type Err = SwizzleError;

    /// With or without the leading dot.
    fn from_str(text: &str) -> Result<Self, SwizzleError> {
        let letters = text.strip_prefix('.').unwrap_or(text);
        let error = || SwizzleError(text.to_owned());
        if letters.is_empty() || letters.len() > 4 {
            return Err(error());
        }
        let set = if letters.contains(['x', 'y', 'z', 'w']) {
            "xyzw"
        } else {
            "rgba"
        };
        let mut components = [0; 4];
        for (component, letter) in components.iter_mut().zip(letters.chars()) {
            *component = set.find(letter).ok_or_else(error)? as u8;
        }
        Ok(Self {
            components,
            len: letters.len() as u8,
        })
    }
}

impl fmt::Display for Swizzle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(".")?;
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
        assert_eq!(parse(".rgb").map(|s| s.to_string()), Ok(".xyz".into()));
        assert_eq!(
            parse("wzyx").map(|s| s.components().to_vec()),
            Ok(vec![3, 2, 1, 0])
        );
        for bad in ["", ".", "xg", "xyzwx", "q", "é", ".x.y"] {
            assert_eq!(parse(bad), Err(SwizzleError(bad.into())));
        }
    }
}
