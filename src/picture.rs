//! Files of pictures and films as layers of numbers, by the names under which `render` writes them.

use std::collections::BTreeMap;
use std::path::Path;

use engine::film::write::TRANSPARENCY;
use engine::film::{self, Film, LAYERS, Origin, Part, PartError, layers};
use engine::input;
use pictures::{Channel, Facts, Layer, Picture, PictureError};

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

/// A layer, and where it lies.
pub(crate) struct Placed {
    /// The layer.
    pub(crate) layer: Layer,
    /// Column and row of its upper left pixel ("data window") where the file says it, as EXR files and films do.
    pub(crate) place: Option<[i32; 2]>,
}

/// A layer of a picture or of a film; the picture itself where none is named.
///
/// # Errors
/// The file can't be read, or has no such layer.
pub(crate) fn layer(path: &Path, name: Option<&str>) -> Result<Layer, Failure> {
    placed(path, name).map(|placed| placed.layer)
}

/// As [`layer()`], with where it lies.
///
/// # Errors
/// As [`layer()`].
pub(crate) fn placed(path: &Path, name: Option<&str>) -> Result<Placed, Failure> {
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
        let layer = of_film(&part.film, &part.origin.names, name);
        return Ok(Placed {
            layer: layer.ok_or_else(|| absent(&known))?,
            place: place_of_film(&part.origin),
        });
    }
    let bytes = input::read(path, MAX_FILE).map_err(|error| unread(path, error))?;
    let picture = Picture::read(&bytes).map_err(|error| match error {
        PictureError::Foreign => refused(&format!("{error}, or a .patina-film")),
        error => refused(&error),
    })?;
    let place = place_in(&bytes);
    drop(bytes);
    let layer = of_picture(&picture, name);
    Ok(Placed {
        layer: layer.ok_or_else(|| absent(&picture.names()))?,
        place,
    })
}

/// Where an EXR file's parts lie, if all lie in one place. Other files don't say it.
fn place_in(bytes: &[u8]) -> Option<[i32; 2]> {
    let facts = Facts::read(bytes).ok()?;
    let first = facts.parts.first().filter(|_| facts.format == "OpenEXR")?;
    let are_alike = facts
        .parts
        .iter()
        .all(|part| part.position == first.position);
    are_alike.then_some(first.position.unwrap_or_default())
}

/// Where a film lies: crops lie within their whole picture.
fn place_of_film(origin: &Origin) -> Option<[i32; 2]> {
    let Some(crop) = origin.setting("crop") else {
        return Some([0; 2]);
    };
    let mut numbers = crop.split(',').map(|number| number.parse().ok());
    Some([numbers.next()??, numbers.next()??])
}

fn of_picture(picture: &Picture, name: Option<&str>) -> Option<Layer> {
    let Some(name) = name else {
        return picture.shown().cloned();
    };
    if let Some(layer) = by_name(picture, name) {
        return Some(layer.clone());
    }
    // As `--layers` calls it.
    if let Some(node) = name.strip_prefix(layers::NODE) {
        return by_name(picture, &layers::node_pass(node)).cloned();
    }
    let asked = name.strip_prefix(VIEW_LAYER).unwrap_or(name);
    if let Some((ids, pair)) = ids_in(LAYERS.iter(), asked) {
        return match pair {
            Some(pair) => by_name(picture, &format!("{}{pair}", ids.pass)).cloned(),
            None => all_ids(picture, ids.pass),
        };
    }
    let declared = LAYERS.iter().find(|layer| layer.name == name)?;
    let is_of_picture = declared.pass == LAYERS[0].pass;
    let whole =
        by_name(picture, declared.pass).or_else(|| picture.shown().filter(|_| is_of_picture))?;
    let first = LAYERS.iter().find(|layer| layer.pass == declared.pass);
    match first == Some(declared) {
        true => Some(whole.clone()),
        false => part_of(whole, declared.channels),
    }
}

/// A layer of a file by its name, or by the end of it: as it is spelled where there is one, else upper and lower case are alike.
fn by_name<'p>(picture: &'p Picture, name: &str) -> Option<&'p Layer> {
    let ends = |layer: &&Layer| {
        let rest = layer.name.strip_suffix(name);
        rest.is_some_and(|rest| rest.is_empty() || rest.ends_with('.'))
    };
    let spelled = picture.layers.iter().find(ends);
    spelled.or_else(|| picture.layer(name))
}

/// Those channels of a layer that make up one of `--layers`, by their letters, such as `A` of `Combined`.
fn part_of(layer: &Layer, letters: &str) -> Option<Layer> {
    let is_asked_for = |channel: &&Channel| {
        let mut own = channel.name.chars();
        matches!((own.next(), own.next()), (Some(letter), None) if letters.contains(letter))
    };
    let channels: Vec<Channel> = (layer.channels.iter())
        .filter(is_asked_for)
        .cloned()
        .collect();
    let is_whole = channels.len() == letters.len();
    is_whole.then(|| Layer::new(layer.name.clone(), layer.size, channels))
}

/// The layer of ids that is meant, and which pair of ranks where one is: all of `crypto_object` and `CryptoObject`, one of `CryptoObject00`.
fn ids_in(
    mut layers: impl Iterator<Item = &'static film::Layer>,
    asked: &str,
) -> Option<(&'static film::Layer, Option<&str>)> {
    let cut = asked.len().checked_sub(2);
    let cut = cut.and_then(|at| asked.split_at_checked(at));
    let (pass, pair) = match cut {
        Some((pass, pair)) if pair.bytes().all(|byte| byte.is_ascii_digit()) => (pass, Some(pair)),
        _ => (asked, None),
    };
    let is_meant = |layer: &&'static film::Layer| {
        let names = [layer.name, layer.pass];
        layer.is_of_ids() && names.iter().any(|known| known.eq_ignore_ascii_case(pass))
    };
    layers.find(is_meant).map(|layer| (layer, pair))
}

/// The pairs of ranks of a layer of ids, which are one each in files, as one.
fn all_ids(picture: &Picture, pass: &str) -> Option<Layer> {
    let first = by_name(picture, &format!("{pass}00"))?;
    let pairs = (0..100).map_while(|pair| {
        let pair = format!("{pair:02}");
        let layer = by_name(picture, &format!("{pass}{pair}"))?;
        (layer.size == first.size).then_some((pair, layer))
    });
    let mut channels = Vec::new();
    for (pair, layer) in pairs {
        channels.extend(layer.channels.iter().map(|channel| Channel {
            name: format!("{pair}.{}", channel.name),
            values: channel.values.clone(),
        }));
    }
    let name = first.name.strip_suffix("00").unwrap_or(&first.name);
    Some(Layer::new(name.to_owned(), first.size, channels))
}

/// `names` are those of its groups of lights, by layer: files have them.
fn of_film(
    film: &Film,
    names: &BTreeMap<String, Vec<String>>,
    name: Option<&str>,
) -> Option<Layer> {
    let name = name.unwrap_or(LAYERS[0].name);
    let asked = name.strip_prefix(VIEW_LAYER).unwrap_or(name);
    let layers = film.layers();
    let pass_of = |layer: &film::Layer| -> String {
        let group = layer.light_group().and(names.get(layer.name));
        match group.map(Vec::as_slice) {
            Some([group]) => format!("Combined_{group}"),
            _ => layers.pass_of(layer).into_owned(),
        }
    };
    let is_called = |layer: &film::Layer, alike: fn(&str, &str) -> bool| {
        alike(&layers.name_of(layer), asked) || alike(&pass_of(layer), asked)
    };
    // Nodes `a` and `A` are two.
    let spelled = (layers.iter()).find(|layer| is_called(layer, |known, asked| known == asked));
    let found = spelled.or_else(|| {
        let mut all = layers.iter();
        all.find(|layer| is_called(layer, str::eq_ignore_ascii_case))
    });
    let (layer, pair) = match found {
        Some(layer) => (layer, None),
        None => ids_in(layers.iter(), asked)?,
    };
    let pass = pass_of(layer);
    let of_pass: Vec<_> = layers
        .iter()
        .filter(|other| pass_of(other) == pass)
        .collect();
    // Several layers make up one of files, which is called as the first of them is. The others are what they alone are, such as `alpha`.
    let members = match of_pass.first() == Some(&layer) {
        true => of_pass,
        false => vec![layer],
    };
    // Files of films that know what lies in front of the environment hold that: `--transparent` gathers both layers.
    let is_transparent = TRANSPARENCY.iter().all(|name| gathers(film, name));
    let split = |pixels: Vec<[f32; 3]>| -> Vec<Vec<f32>> {
        let channel = |at: usize| pixels.iter().map(|rgb| rgb[at]).collect();
        (0..3).map(channel).collect()
    };
    let mut channels = Vec::new();
    for member in members {
        let in_front = match member.name {
            _ if !is_transparent => None,
            name if name == LAYERS[0].name => film.foreground().map(split),
            "alpha" => film.alpha().map(|alpha| vec![alpha]),
            _ if member.is_of_environment(names) => film.group_in_front(member).map(split),
            _ => None,
        };
        let numbers = match in_front {
            Some(numbers) => numbers,
            None => film.channels(member)?,
        };
        for (name, values) in member.channel_names().zip(numbers) {
            // Ids are several layers to a file, and one here.
            let whole = name.trim_start_matches(VIEW_LAYER);
            let own = whole.strip_prefix(member.pass).unwrap_or(whole);
            let own = own.trim_start_matches('.');
            let own = match pair {
                None => Some(own),
                Some(pair) => (own.strip_prefix(pair)).and_then(|own| own.strip_prefix('.')),
            };
            channels.extend(own.map(|own| Channel {
                name: own.to_owned(),
                values,
            }));
        }
    }
    // As files have them.
    channels.sort_by(|a, b| a.name.cmp(&b.name));
    let size = [film.width as usize, film.height as usize];
    let name = format!("{VIEW_LAYER}{pass}{}", pair.unwrap_or_default());
    (!channels.is_empty()).then(|| Layer::new(name, size, channels))
}

/// Whether a film keeps a layer.
fn gathers(film: &Film, name: &str) -> bool {
    film.layers().iter().any(|layer| layer.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::film::Layers;

    fn film_layer(film: &Film, name: Option<&str>) -> Option<Layer> {
        of_film(film, &BTreeMap::new(), name)
    }

    /// An EXR file of all layers of a film.
    fn file_of(film: &Film, origin: &Origin) -> Vec<u8> {
        file_with(film, origin, false)
    }

    fn file_with(film: &Film, origin: &Origin, transparent: bool) -> Vec<u8> {
        let metadata = film::write::Metadata::new(film, origin);
        let mut file = std::io::Cursor::new(Vec::new());
        let form = film::write::Form::new(film::write::Compression::Zip, &[""; 0], &["all"]);
        let form = form.expect("a form");
        let content = film::write::Content {
            form: &form,
            transparent,
            ..film::write::Content::from(film)
        };
        film::write::write(
            &mut file,
            film::write::Format::Exr,
            content,
            &metadata,
            &engine::scene::view::View::default(),
        )
        .expect("written");
        file.into_inner()
    }

    #[test]
    fn parts_of_pictures_have_their_places() {
        let film = Film::new(3, 2);
        let setting = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        let crop = vec![setting("size", "40x20"), setting("crop", "10,4,3,2")];
        for (settings, place) in [(Vec::new(), [0, 0]), (crop, [10, 4])] {
            let origin = Origin::new("", Path::new(""), None, settings);
            assert_eq!(place_of_film(&origin), Some(place));
            assert_eq!(place_in(&file_of(&film, &origin)), Some(place));
        }
        assert_eq!(place_in(b"no picture"), None);
    }

    #[test]
    fn layers_of_films_are_those_of_their_files() {
        let wanted = [
            "uv",
            "vector",
            "alpha",
            "depth",
            "shadow_catcher",
            "crypto_object",
            "light_groups",
            "node:A",
            "node:a",
        ];
        let mut film = Film::with_layers(2, 1, Layers::named(wanted).expect("known"));
        for pixel in 0..2 {
            film.add_sample(pixel, [0.25, 0.5, 1.0]);
            film.add_surface(pixel, 0, |layer| {
                // Each layer has other numbers.
                let at = LAYERS.iter().position(|other| other == layer);
                let at = 1.0 + at.unwrap_or_default() as f32;
                [1.0, 2.0, 3.0].map(|channel| channel / 64.0 + at)
            });
        }
        let groups = [("light_group_0", "rest"), ("light_group_1", "key")];
        let names: BTreeMap<String, Vec<String>> = groups
            .map(|(layer, name)| (layer.to_owned(), vec![name.to_owned()]))
            .into();
        let mut origin = Origin::new("", Path::new(""), None, Vec::new());
        origin.names = names.clone();
        let picture = Picture::read(&file_of(&film, &origin)).expect("a picture");
        for (name, channels) in [
            (None, "RGBA"),
            (Some("combined"), "RGBA"),
            (Some("alpha"), "A"),
            (Some("uv"), "AUV"),
            (Some("vector"), "WXYZ"),
            (Some("Vector"), "WXYZ"),
            (Some("depth"), "Z"),
            (Some("shadow_catcher"), "RGBA"),
            (Some("node:a"), "RGBA"),
            (Some("node:A"), "RGBA"),
            (Some("Node a"), "RGBA"),
            (Some("Combined_key"), "RGB"),
            (Some("ViewLayer.Combined_rest"), "RGB"),
            (Some("CryptoObject00"), "abgr"),
            (Some("crypto_object01"), "abgr"),
        ] {
            let here = of_film(&film, &names, name).expect("in the film");
            let there = of_picture(&picture, name).expect("in the file");
            let own: Vec<_> = here.channels.iter().map(|c| c.name.as_str()).collect();
            assert_eq!(own.concat(), channels, "{name:?}");
            assert_eq!(here, there, "{name:?}");
        }
        let ids = of_film(&film, &names, Some("crypto_object")).expect("in the film");
        assert_eq!(ids.channels.len(), 16);
        assert_eq!(ids.channels[3].name, "00.r");
        let there = of_picture(&picture, Some("crypto_object"));
        assert_eq!(there, Some(ids));
        let node = |name| of_film(&film, &names, Some(name)).expect("in the film");
        assert_ne!(node("node:a").channels, node("node:A").channels);
        assert_eq!(of_film(&film, &names, Some("crypto_object09")), None);
    }

    #[test]
    fn the_picture_of_a_transparent_film_is_that_of_its_file() {
        let layers = Layers::named(TRANSPARENCY).expect("known");
        let mut film = Film::with_layers(2, 1, layers);
        for (pixel, behind, alpha) in [(0, 1.0, 0.0), (1, 0.25, 0.5)] {
            film.add_sample(pixel, [1.0; 3]);
            film.add_surface(pixel, 0, |layer| match layer.name {
                "alpha" => [alpha, 0.0, 0.0],
                _ => [behind; 3],
            });
        }
        let origin = Origin::new("", Path::new(""), None, Vec::new());
        let file = Picture::read(&file_with(&film, &origin, true)).expect("a picture");
        for name in [None, Some("combined"), Some("environment"), Some("alpha")] {
            let here = film_layer(&film, name).expect("in the film");
            assert_eq!(Some(here), of_picture(&file, name), "{name:?}");
        }
        let picture = film_layer(&film, None).expect("always there");
        assert_eq!(picture.channels[0].values, [0.0, 0.75]);
    }

    #[test]
    fn layers_of_films_are_named_as_in_files() {
        let layers = Layers::named(["depth", "albedo"]).expect("known");
        let mut film = Film::with_layers(2, 1, layers);
        film.add_sample(0, [0.25, 0.5, 1.0]);
        film.add_surface(0, 0, |_| [3.0, 0.0, 0.0]);
        let combined = film_layer(&film, None).expect("always there");
        assert!(combined.is_color());
        assert_eq!(combined.channels[0].values, [0.25, 0.0]);
        for name in ["depth", "Depth", "ViewLayer.Depth"] {
            let depth = film_layer(&film, Some(name)).expect(name);
            assert_eq!(depth.name, "ViewLayer.Depth");
            assert_eq!(depth.channels[0].name, "Z");
            assert_eq!(depth.channels[0].values, [3.0, 1e10]);
        }
        assert!(
            film_layer(&film, Some("albedo"))
                .expect("gathered")
                .is_color()
        );
        assert_eq!(film_layer(&film, Some("normal")), None);
    }

    #[test]
    fn layers_of_pictures_are_named_as_the_flag_has_them() {
        let named = |name: &str| Layer::rgb(name, [1, 1], &[[0.0; 3]]);
        let picture = |names: &[&str]| Picture {
            layers: names.iter().map(|name| named(name)).collect(),
        };
        let found = |picture: &Picture, name: Option<&str>| {
            of_picture(picture, name).map(|layer| layer.name)
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
