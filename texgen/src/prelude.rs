//! The published prelude, and the names that it declares.

use std::sync::LazyLock;

use crate::scope::Outline;

/// The published prelude: with it in front, a texture is a complete WGSL module.
pub const PRELUDE: &str = concat!(
    include_str!("prelude.wgsl"),
    include_str!("standard/hash.wgsl"),
    include_str!("standard/noise.wgsl"),
    include_str!("standard/fractal.wgsl"),
    include_str!("standard/cells.wgsl"),
    include_str!("standard/color.wgsl"),
    include_str!("standard/shape.wgsl"),
);

/// Its part that asks the renderer for things: names and functions that do nothing.
pub(crate) const STUBS: &str = include_str!("prelude.wgsl");

/// As the text declares them: nothing else lists them.
static NAMES: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let outline = Outline::new(PRELUDE);
    let names = outline.globals.iter().filter_map(|global| global.name);
    names.map(|at| outline.word(at)).collect()
});

/// All names that the prelude declares.
pub(crate) fn prelude_names() -> impl Iterator<Item = &'static str> {
    NAMES.iter().copied()
}

/// Whether the prelude declares this name.
pub(crate) fn is_prelude_name(name: &str) -> bool {
    NAMES.contains(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_functions_and_constants_are_names() {
        for name in ["sam2D", "rampEval", "WorldPos", "SceneMax"] {
            assert!(is_prelude_name(name), "{name}");
        }
        for name in ["name", "uv", "patina_image", "vec4f", ""] {
            assert!(!is_prelude_name(name), "{name}");
        }
    }
}
