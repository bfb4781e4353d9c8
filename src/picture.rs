//! Files of pictures and films as layers of numbers, by the names under which `render` writes them.

use std::path::Path;

use engine::film::{self, Film, LAYERS, Part, PartError, layers};
use engine::input;
use pictures::{Channel, Layer, Picture, PictureError};

use crate::failure::Failure;

/// Largest file of a picture, bytes.
pub(crate) const MAX_FILE: u64 = 4 << 30;

/// How the names of channels of several layers begin.
const VIEW_LAYER: &str = "ViewLayer.";

/// Reads a partial render.
///
/// # Errors
/// It is none, damaged, or can't be read.
pub(crate) fn film(path: &Path) -> Result<Part, PartError> {
    let (file, length) = input::open(path)?;
    Part::read(&mut std::io::BufReader::new(file), length)
}

/// Whether a file is a partial render, by how it begins.
///
/// # Errors
/// It can't be read.
pub(crate) fn is_film(path: &Path) -> Result<bool, Failure> {
    let start = input::read_start(path, film::MAGIC_BYTES).map_err(|error| unread(path, error))?;
    Ok(film::is_film(&start))
}

/// What is said of a file that can't be read.
pub(crate) fn unread(path: &Path, error: impl std::fmt::Display) -> Failure {
    Failure::Failed(format!("cannot read {}: {error}", path.display()))
}

/// A layer of a picture or of a film; the picture itself where none is named.
///
/// # Errors
/// The file can't be read, or has no such layer.
pub(crate) fn layer(path: &Path, name: Option<&str>) -> Result<Layer, Failure> {
    let refused =
        |error: &dyn std::fmt::Display| Failure::Failed(format!("{}: {error}", path.display()));
    let absent = |names: &[&str]| {
        let name = name.unwrap_or_default();
        refused(&match names {
            [] => format!("it has no layer `{name}`: it holds one picture without a name"),
            names => format!("it has no layer `{name}`; it has {}", names.join(", ")),
        })
    };
    if is_film(path)? {
        let part = self::film(path).map_err(|error| refused(&error))?;
        let known = part.film.layers().asked();
        let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
        return of_film(&part.film, name).ok_or_else(|| absent(&known));
    }
    let bytes = input::read(path, MAX_FILE).map_err(|error| unread(path, error))?;
    let picture = Picture::read(&bytes).map_err(|error| match error {
        PictureError::Foreign => refused(&format!("{error}, or a .patina-film")),
        error => refused(&error),
    })?;
    drop(bytes);
    of_picture(&picture, name)
        .cloned()
        .ok_or_else(|| absent(&picture.names()))
}

fn of_picture<'p>(picture: &'p Picture, name: Option<&str>) -> Option<&'p Layer> {
    let Some(name) = name else {
        return picture.shown();
    };
    let by_file = || picture.layer(name);
    // As `--layers` calls it.
    let declared = LAYERS.iter().find(|layer| layer.name == name);
    let of_node = name.strip_prefix(layers::NODE).map(layers::node_pass);
    let by_pass = || match &of_node {
        Some(pass) => picture.layer(pass),
        None => picture.layer(declared?.pass),
    };
    let itself = || (name == LAYERS[0].name).then(|| picture.shown())?;
    by_file().or_else(by_pass).or_else(itself)
}

fn of_film(film: &Film, name: Option<&str>) -> Option<Layer> {
    let name = name.unwrap_or(LAYERS[0].name);
    let layers = film.layers();
    let layer = layers.iter().find(|layer| {
        let pass = name.strip_prefix(VIEW_LAYER).unwrap_or(name);
        [layers.name_of(layer), layers.pass_of(layer)]
            .iter()
            .any(|known| known.eq_ignore_ascii_case(pass))
    })?;
    let named = layer.channel_names().zip(film.channels(layer)?);
    let channels = named.map(|(name, values)| {
        // Ids are several layers to a file, and one here.
        let whole = name.trim_start_matches(VIEW_LAYER);
        let own = whole.strip_prefix(layer.pass).unwrap_or(whole);
        Channel {
            name: own.trim_start_matches('.').to_owned(),
            values,
        }
    });
    let size = [film.width as usize, film.height as usize];
    let name = format!("{VIEW_LAYER}{}", layers.pass_of(layer));
    Some(Layer::new(name, size, channels.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::film::Layers;

    #[test]
    fn layers_of_films_are_named_as_in_files() {
        let layers = Layers::named(["depth", "albedo"]).expect("known");
        let mut film = Film::with_layers(2, 1, layers);
        film.add_sample(0, [0.25, 0.5, 1.0]);
        film.add_surface(0, 0, |_| [3.0, 0.0, 0.0]);
        let combined = of_film(&film, None).expect("always there");
        assert!(combined.is_color());
        assert_eq!(combined.channels[0].values, [0.25, 0.0]);
        for name in ["depth", "Depth", "ViewLayer.Depth"] {
            let depth = of_film(&film, Some(name)).expect(name);
            assert_eq!(depth.name, "ViewLayer.Depth");
            assert_eq!(depth.channels[0].name, "Z");
            assert_eq!(depth.channels[0].values, [3.0, 1e10]);
        }
        assert!(of_film(&film, Some("albedo")).expect("gathered").is_color());
        assert_eq!(of_film(&film, Some("normal")), None);
    }

    #[test]
    fn layers_of_pictures_are_named_as_the_flag_has_them() {
        let named = |name: &str| Layer::rgb(name, [1, 1], &[[0.0; 3]]);
        let picture = |names: &[&str]| Picture {
            layers: names.iter().map(|name| named(name)).collect(),
        };
        let found = |picture: &Picture, name: Option<&str>| {
            of_picture(picture, name).map(|layer| layer.name.clone())
        };
        let whole = picture(&["ViewLayer.Denoising Albedo", "ViewLayer.Combined"]);
        let combined = Some("ViewLayer.Combined".to_owned());
        assert_eq!(found(&whole, None), combined);
        assert_eq!(found(&whole, Some("combined")), combined);
        let albedo = Some("ViewLayer.Denoising Albedo".to_owned());
        assert_eq!(found(&whole, Some("albedo")), albedo);
        assert_eq!(found(&whole, Some("depth")), None);
        assert_eq!(
            found(&picture(&[""]), Some("combined")),
            Some(String::new())
        );
    }
}
