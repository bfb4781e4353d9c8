//! Who is to blame when a driver refuses the kernel of all textures: each is built alone. Knows no device.

use texgen::Library;

use device::DeviceError;

/// A texture that can't be built even alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Culprit {
    /// The texture.
    pub name: String,
    /// Its file.
    pub path: String,
    /// What was said about it.
    pub message: String,
}

/// The textures for which `build` fails when the library holds nothing else.
pub fn culprits<E: std::fmt::Display>(
    library: &Library,
    mut build: impl FnMut(&Library) -> Result<(), E>,
) -> Vec<Culprit> {
    let alone = |texture: &texgen::TextureType| {
        let library = Library::new(vec![texture.clone()]).ok()?;
        let error = build(&library).err()?;
        Some(Culprit {
            name: texture.name().to_owned(),
            path: texture.file().path().to_owned(),
            message: error.to_string(),
        })
    };
    library.textures().iter().filter_map(alone).collect()
}

/// The error with the culprits' names, if a driver gave it: other errors show their place already.
pub(crate) fn named<E: std::fmt::Display>(
    error: DeviceError,
    library: &Library,
    build: impl FnMut(&Library) -> Result<(), E>,
) -> DeviceError {
    let DeviceError::Refused { label, mut message } = error else {
        return error;
    };
    let found = culprits(library, build);
    if found.is_empty() && library.textures().len() > 1 {
        message.push_str(
            "\neach of the textures is accepted alone: together they are too much for this driver; use fewer of them",
        );
    }
    for culprit in found {
        message.push_str(&format!(
            "\n{}: the driver refuses texture `{}` even alone: {}",
            culprit.path, culprit.name, culprit.message
        ));
    }
    DeviceError::Refused { label, message }
}

#[cfg(test)]
mod tests {
    use super::*;
    use texgen::{SourceFile, TextureType};

    fn library(names: &[&str]) -> Library {
        let text = "fn userProc() -> f32 { return 1.0; }";
        let texture = |name: &&str| {
            let file = SourceFile::new(*name, format!("textures/{name}.wgsl"), text);
            TextureType::parse(file).unwrap_or_else(|problems| panic!("{problems}"))
        };
        Library::new(names.iter().map(texture).collect()).unwrap_or_else(|e| panic!("{e}"))
    }

    /// A driver that doesn't like some names.
    fn driver(bad: &'static [&'static str]) -> impl Fn(&Library) -> Result<(), String> {
        move |library| {
            let names = library.textures().iter().map(TextureType::name);
            match names.into_iter().find(|name| bad.contains(name)) {
                Some(name) => Err(format!("too wild: {name}")),
                None => Ok(()),
            }
        }
    }

    fn refused() -> DeviceError {
        DeviceError::Refused {
            label: "proctex".to_owned(),
            message: "internal error".to_owned(),
        }
    }

    #[test]
    fn the_textures_that_fail_alone_are_named_with_their_files() {
        let library = library(&["a", "b", "c", "d"]);
        let error = named(refused(), &library, driver(&["b", "d"])).to_string();
        for part in [
            "internal error",
            "textures/b.wgsl: the driver refuses texture `b` even alone: too wild: b",
            "textures/d.wgsl",
        ] {
            assert!(error.contains(part), "{error}");
        }
        assert!(!error.contains("textures/a.wgsl"), "{error}");
    }

    #[test]
    fn where_none_fails_alone_that_is_said() {
        let error = named(refused(), &library(&["a", "b"]), driver(&[])).to_string();
        assert!(error.contains("together they are too much"), "{error}");
    }

    #[test]
    fn errors_with_a_place_stay_as_they_are() {
        let error = DeviceError::Kernel {
            label: "proctex".to_owned(),
            message: "a.wgsl:3:4".to_owned(),
        };
        let text = error.to_string();
        let after = named(error, &library(&["a"]), driver(&["a"])).to_string();
        assert_eq!(text, after);
    }
}
