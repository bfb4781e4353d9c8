use std::collections::BTreeMap;
use std::path::Path;

use super::*;
use crate::film::Origin;
use crate::film::write::{Compression, Form, TRANSPARENCY};

fn film(layers: Layers) -> Film {
    let mut film = Film::with_layers(3, 2, layers);
    for pixel in 0..6 {
        let value = 0.1 + pixel as f32;
        film.add_sample(pixel, [value, -1.0, 1e-3 * value]);
        if pixel != 2 {
            film.add_surface(pixel, 0, |_| [2.0 * value, 0.5, -value]);
        }
    }
    film
}

fn metadata() -> Metadata {
    let names = ["maxDepth", "seed", "scene", "look", "a", "b", "c", "d"];
    let text = |name: &str| Fact::Text(name.to_owned());
    let mut facts: Vec<_> = names.into_iter().map(|name| (name, text(name))).collect();
    facts.push(("samplesPerPixel", Fact::Count(64)));
    facts.push(("device", text("Gerät 世")));
    let names =
        ["crypto_object".to_owned()].map(|layer| (layer, vec!["Tür".to_owned(), "世".to_owned()]));
    let names = names.into();
    Metadata {
        facts,
        names,
        crop: None,
    }
}

fn written<'a>(content: impl Into<Content<'a>>) -> Vec<u8> {
    let mut file = io::Cursor::new(Vec::new());
    write(&mut file, &content.into(), &metadata()).expect("memory takes everything");
    file.into_inner()
}

/// Every bit.
fn float() -> Form {
    Form::new(Compression::Zip, &[""; 0], &["all"]).expect("a form")
}

fn in_floats(film: &Film) -> Vec<u8> {
    let content = Content {
        form: &float(),
        ..Content::from(film)
    };
    written(content)
}

/// The channels of a file by name, and its facts.
fn read(bytes: &[u8]) -> (BTreeMap<String, Vec<f32>>, LayerAttributes) {
    use exr::prelude::{ReadChannels, ReadLayers};
    let read = exr::prelude::read();
    let read = read.no_deep_data().largest_resolution_level();
    let read = read.all_channels().first_valid_layer().all_attributes();
    let image = read.from_buffered(io::Cursor::new(bytes)).expect("read");
    let layer = image.layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| {
        let values = channel.sample_data.values_as_f32().collect();
        (channel.name.to_string(), values)
    });
    (channels.collect(), layer.attributes)
}

#[test]
fn a_picture_keeps_every_bit_and_says_how_it_was_made() {
    let film = film(Layers::default());
    let (channels, attributes) = read(&in_floats(&film));
    let names: Vec<_> = channels.keys().map(String::as_str).collect();
    assert_eq!(names, ["B", "G", "R"]);
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let expected: Vec<_> = film.mean().iter().map(|rgb| rgb[channel]).collect();
        assert_eq!(channels[name], expected, "{name}");
    }
    let facts = attributes.other;
    assert_eq!(facts.len(), metadata().facts.len());
    let fact = |name| facts.get(&Text::from(name));
    assert_eq!(fact("samplesPerPixel"), Some(&AttributeValue::I32(64)));
    let device = AttributeValue::Text(utf8("Gerät 世"));
    assert_eq!(fact("device"), Some(&device));
}

#[test]
fn layers_have_the_names_of_blender() {
    let film = film(Layers::all());
    let (channels, attributes) = read(&in_floats(&film));
    let layers_of_ids = 3;
    // One of them has a manifest.
    let facts = metadata().facts.len() + 3 * layers_of_ids + 1;
    assert_eq!(attributes.other.len(), facts);
    let count: usize = film
        .layers()
        .iter()
        .filter(|layer| !layer.is_kept_back())
        .map(|layer| layer.channel_count())
        .sum();
    assert_eq!(channels.len(), count);
    for (layer, names) in [
        ("combined", &["Combined.R", "Combined.G", "Combined.B"][..]),
        ("depth", &["Depth.Z"]),
        ("position", &["Position.X", "Position.Y", "Position.Z"]),
        ("normal", &["Normal.X", "Normal.Y", "Normal.Z"]),
        ("uv", &["UV.U", "UV.V", "UV.A"]),
        ("samples", &["Debug Sample Count.X"]),
    ] {
        let layer = crate::film::Layer::named(layer).expect("known");
        let values = film.values(layer).expect("gathered");
        for (channel, name) in names.iter().enumerate() {
            let expected: Vec<_> = values.iter().map(|v| v[channel]).collect();
            assert_eq!(channels[&format!("ViewLayer.{name}")], expected, "{name}");
        }
    }
    let mut texts = attributes
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) if name.to_string().ends_with("/manifest") => Some(text),
            _ => None,
        });
    let manifest = texts.next().expect("a manifest").to_string();
    assert!(manifest.contains("T\\u00fcr"), "{manifest}");
    let read: BTreeMap<String, String> = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(read["世"], format!("{:08x}", scene::name_id("世")));
    assert_eq!(channels["ViewLayer.Depth.Z"][2], 1e10, "nothing was hit");
}

#[test]
fn ids_have_the_names_of_cryptomatte() {
    let mut film = film(Layers::named(["crypto_object"]).expect("known"));
    let [often, seldom] = ["often", "seldom"].map(scene::name_id);
    for (sample, id) in [seldom, often, often].into_iter().enumerate() {
        film.add_sample(2, [0.0; 3]);
        film.add_surface(2, sample as u32, |_| [f32::from_bits(id), 0.0, 0.0]);
    }
    let (channels, attributes) = read(&written(&film));
    let at = |channel: &str| channels[&format!("ViewLayer.CryptoObject{channel}")][2];
    assert_eq!((at("00.r").to_bits(), at("00.g")), (often, 0.5));
    assert_eq!((at("00.b").to_bits(), at("00.a")), (seldom, 0.25));
    assert_eq!((at("03.b"), at("03.a")), (0.0, 0.0));
    let key = format!("{:08x}", scene::murmur3(b"ViewLayer.CryptoObject"));
    let name = Text::from(&*format!("cryptomatte/{}/name", &key[..7]));
    let expected = AttributeValue::Text(Text::from("ViewLayer.CryptoObject"));
    assert_eq!(attributes.other.get(&name), Some(&expected));
}

#[test]
fn a_denoised_picture_keeps_the_noisy_one_and_leaves_other_layers_alone() {
    let film = film(Layers::named(["depth", "normal"]).expect("known"));
    let denoised = [[0.5, 0.25, 0.125]; 6];
    let depth = Layers::named(["depth"]).expect("known");
    for layers in [&Layers::default(), &depth] {
        let content = Content {
            film: &film,
            layers,
            denoised: Some(&denoised),
            transparent: false,
            form: &float(),
        };
        let (channels, _) = read(&written(content));
        for (channel, letter) in ["R", "G", "B"].into_iter().enumerate() {
            let noisy: Vec<_> = film.mean().iter().map(|rgb| rgb[channel]).collect();
            assert_eq!(channels[&format!("ViewLayer.Noisy Image.{letter}")], noisy);
            let combined = &channels[&format!("ViewLayer.Combined.{letter}")];
            assert_eq!(*combined, [denoised[0][channel]; 6]);
        }
        let others = usize::from(!layers.is_picture_alone());
        assert_eq!(channels.len(), 6 + others, "what was gathered to denoise");
        let (noisy, _) = read(&written(&film));
        if let Some(depth) = channels.get("ViewLayer.Depth.Z") {
            assert_eq!(*depth, noisy["ViewLayer.Depth.Z"]);
        }
    }
}

#[test]
fn what_nothing_covers_is_transparent() {
    let layers = Layers::named(TRANSPARENCY).expect("known");
    let mut film = Film::with_layers(2, 1, layers);
    // The sky alone, and half a surface of 0.5 in front of it.
    for pixel in 0..2 {
        film.add_sample(pixel, [0.25, 0.5, 0.1]);
        film.add_surface(pixel, 0, |layer| match layer.name {
            "environment" => [0.25, 0.5, 0.1],
            _ => [0.0; 3],
        });
        film.add_sample(pixel, [0.5 * pixel as f32; 3]);
        film.add_surface(pixel, 1, |layer| match layer.name {
            "alpha" => [pixel as f32, 0.0, 0.0],
            _ => [0.0; 3],
        });
    }
    let alone = Layers::default();
    let depth = Layers::named(["depth"]).expect("known");
    for (layers, prefix) in [(&alone, ""), (&depth, "ViewLayer.Combined.")] {
        let content = Content {
            layers,
            transparent: true,
            ..Content::from(&film)
        };
        let (channels, _) = read(&written(content));
        for letter in ["R", "G", "B"] {
            assert_eq!(channels[&format!("{prefix}{letter}")], [0.0, 0.25]);
        }
        assert_eq!(channels[&format!("{prefix}A")], [0.0, 0.5]);
    }
}

#[test]
fn alpha_has_its_range_with_layers_and_without() {
    let layers = Layers::named(TRANSPARENCY).expect("known");
    let mut film = Film::with_layers(2, 1, layers);
    // As filters with negative weights leave it.
    for (pixel, alpha) in [(0, 1.25), (1, -0.25)] {
        film.add_sample(pixel, [0.5; 3]);
        film.add_surface(pixel, 0, |layer| match layer.name {
            "alpha" => [alpha, 0.0, 0.0],
            _ => [0.0; 3],
        });
    }
    let alone = Layers::default();
    let depth = Layers::named(["depth"]).expect("known");
    for (layers, name) in [(&alone, "A"), (&depth, "ViewLayer.Combined.A")] {
        let content = Content {
            layers,
            transparent: true,
            ..Content::from(&film)
        };
        let (channels, _) = read(&written(content));
        assert_eq!(channels[name], [1.0, 0.0], "{name}");
    }
}

#[test]
fn bright_colours_of_layers_are_kept_by_b44() {
    let layers = Layers::named(["albedo"]).expect("known");
    let mut film = Film::with_layers(4, 4, layers);
    for pixel in 0..16 {
        film.add_sample(pixel, [400.0; 3]);
        film.add_surface(pixel, 0, |_| [0.5; 3]);
    }
    for compression in [Compression::B44, Compression::B44a] {
        let form = Form::new(compression, &["all"], &[""; 0]).expect("a form");
        let content = Content {
            form: &form,
            ..Content::from(&film)
        };
        let (channels, _) = read(&written(content));
        for letter in ["R", "G", "B"] {
            let values = &channels[&format!("ViewLayer.Combined.{letter}")];
            let is_kept = values.iter().all(|value| (value - 400.0).abs() < 4.0);
            assert!(is_kept, "{compression:?} {letter}: {values:?}");
        }
    }
}

#[test]
fn files_say_that_names_of_channels_are_long() {
    let flags = |layers: Layers| written(&film(layers))[4..8].to_vec();
    assert_eq!(flags(Layers::default()), [2, 0, 0, 0]);
    let node = format!("node:{}", "n".repeat(32));
    let long = Layers::named([node.as_str()]).expect("a node");
    assert_eq!(flags(long.clone()), [2, 4, 0, 0]);
    let (channels, _) = read(&written(&film(long)));
    let name = format!("ViewLayer.Node {}.R", "n".repeat(32));
    assert!(channels.contains_key(&name));
}

#[test]
fn a_part_lies_in_its_place_in_the_whole() {
    let film = film(Layers::default());
    let setting = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    let settings = vec![setting("size", "40x20"), setting("crop", "10,4,3,2")];
    let origin = Origin::new("", Path::new(""), None, settings);
    let mut file = io::Cursor::new(Vec::new());
    let metadata = Metadata::new(&film, &origin);
    write(&mut file, &Content::from(&film), &metadata).expect("written");
    let meta = exr::meta::MetaData::read_from_buffered(&file.into_inner()[..], true);
    let header = meta.expect("read").headers.remove(0);
    let window = header.shared_attributes.display_window;
    assert_eq!((window.position, window.size), (Vec2(0, 0), Vec2(40, 20)));
    assert_eq!(header.own_attributes.layer_position, Vec2(10, 4));
    assert_eq!(header.layer_size, Vec2(3, 2));
}

#[test]
fn files_are_packed_in_every_way() {
    let layers = Layers::named(["depth", "normal", "variance"]).expect("known");
    // No multiple of the blocks of any of them.
    let (width, height) = (37, 41);
    let mut film = Film::with_layers(width, height, layers);
    for pixel in 0..film.pixels() {
        let value = 0.5 + 0.4 * (0.1 * pixel as f32).sin();
        film.add_sample(pixel, [value, 0.5 * value, 0.25]);
        film.add_surface(pixel, 0, |_| [value, 0.0, 1.0]);
        film.add_sample(pixel, [value, 0.25, 0.25]);
    }
    for compression in Compression::ALL {
        let form = Form::new(compression, &[""; 0], &[""; 0]).expect("a form");
        let form = form.with_fact("owner", "Studio").expect("free");
        let form = form.with_fact("shot", "0420").expect("free");
        let content = Content {
            form: &form,
            ..Content::from(&film)
        };
        let (channels, attributes) = read(&written(content));
        assert_eq!(attributes.owner, Some(Text::from("Studio")));
        let shot = attributes.other.get(&Text::from("shot"));
        assert_eq!(shot, Some(&AttributeValue::Text(Text::from("0420"))));
        // Halves are as near as they can be; what loses more is near enough to be looked at.
        let is_lossy = ["b44", "b44a", "dwaa", "dwab"].contains(&compression.name());
        let tolerance = if is_lossy { 0.05 } else { 1e-3 };
        for name in ["combined", "depth", "normal", "variance"] {
            let layer = crate::film::Layer::named(name).expect("known");
            let expected = film.channels(layer).expect("gathered");
            for (channel, expected) in layer.channel_names().zip(expected) {
                let is_near = |(a, b): (&f32, &f32)| a == b || (a - b).abs() <= tolerance;
                let mut pairs = channels[&channel].iter().zip(&expected);
                assert!(pairs.all(is_near), "{compression:?} {channel}");
            }
        }
    }
}

#[test]
fn bright_colours_stay_finite_where_blocks_are_transformed() {
    let layers = Layers::named(["depth", "emission"]).expect("known");
    let mut film = Film::with_layers(24, 24, layers);
    for pixel in 0..film.pixels() {
        let value = if pixel % 7 == 0 { 65504.0 } else { 0.25 };
        film.add_sample(pixel, [value; 3]);
        film.add_surface(pixel, 0, |layer| match layer.name {
            "depth" => [1e7, 0.0, 0.0],
            _ => [3.0 * value; 3],
        });
    }
    for compression in [Compression::Dwaa, Compression::Dwab] {
        for float in [&[][..], &["all"]] {
            let form = Form::new(compression, &[""; 0], float).expect("a form");
            let content = Content {
                form: &form,
                ..Content::from(&film)
            };
            let (channels, _) = read(&written(content));
            for name in ["Combined.R", "Combined.B", "Emission.G"] {
                let values = &channels[&format!("ViewLayer.{name}")];
                assert!(
                    values.iter().all(|v| v.is_finite()),
                    "{compression:?} {name}"
                );
                let most = values.iter().copied().fold(0.0, f32::max);
                assert!(most > 40_000.0, "{compression:?} {name}: {most}");
            }
            assert_eq!(channels["ViewLayer.Depth.Z"], [1e7; 24 * 24]);
        }
    }
}

#[test]
fn b44_packs_what_it_has_room_for() {
    // The last row of the first two is too little for whole squares of 4 x 4 numbers, two rows are just enough.
    for (width, height, has_room) in [
        (256, 33, false),
        (1100, 1, false),
        (300, 34, true),
        (2, 17, true),
        (1, 65, true),
        (40, 1, true),
        (256, 36, true),
        (100, 64, true),
    ] {
        let mut film = Film::new(width, height);
        for pixel in 0..film.pixels() {
            let value = 0.5 + 0.4 * (0.1 * pixel as f32).sin();
            film.add_sample(pixel, [value, 0.5 * value, 0.25]);
        }
        for compression in [Compression::B44, Compression::B44a] {
            let form = Form::new(compression, &["all"], &[""; 0]).expect("a form");
            let content = Content {
                form: &form,
                ..Content::from(&film)
            };
            let bytes = written(content);
            let meta = exr::meta::MetaData::read_from_buffered(&bytes[..], true);
            let packing = meta.expect("read").headers.remove(0).compression;
            let expected = match has_room {
                true => compression.packing(),
                false => Packing::ZIP16,
            };
            let what = format!("{width}x{height}, {compression:?}");
            assert_eq!(packing, expected, "{what}");
            let (channels, _) = read(&bytes);
            for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
                let means = film.mean();
                let mut pairs = channels[name].iter().zip(&means);
                let is_near = pairs.all(|(a, rgb)| (a - rgb[channel]).abs() < 0.05);
                assert!(is_near && channels[name].len() == means.len(), "{what}");
            }
        }
    }
}

#[test]
fn groups_of_lights_have_their_names() {
    let film = Film::with_layers(2, 1, Layers::named(["light_groups"]).expect("known"));
    let mut origin = Origin::new("", Path::new(""), None, Vec::new());
    let groups = [("light_group_0", "rest"), ("light_group_1", "key")];
    for (layer, name) in groups {
        origin.names.insert(layer.to_owned(), vec![name.to_owned()]);
    }
    let mut file = io::Cursor::new(Vec::new());
    write(
        &mut file,
        &Content::from(&film),
        &Metadata::new(&film, &origin),
    )
    .expect("written");
    let (channels, _) = read(&file.into_inner());
    assert!(channels.contains_key("ViewLayer.Combined_rest.G"));
    assert!(channels.contains_key("ViewLayer.Combined_key.B"));
    assert!(!channels.contains_key("ViewLayer.Combined_1.B"));
}

#[test]
fn groups_of_lights_add_up_to_what_lies_in_front() {
    let names = ["light_group_0", "light_group_1"];
    let layers = Layers::named(TRANSPARENCY.into_iter().chain(["light_groups"])).expect("known");
    let mut film = Film::with_layers(2, 1, layers);
    // The sky alone, and half of it behind a surface that it and a lamp light.
    for (pixel, [sky, lit, lamp]) in [(0, [0.5, 0.0, 0.0]), (1, [0.25, 0.125, 0.5])] {
        film.add_sample(pixel, [sky + lit + lamp; 3]);
        film.add_surface(pixel, 0, |layer| match layer.name {
            "environment" => [sky; 3],
            "alpha" => [0.5 * pixel as f32, 0.0, 0.0],
            "light_group_0" => [lamp; 3],
            "light_group_1" => [sky + lit; 3],
            _ => [0.0; 3],
        });
    }
    let mut origin = Origin::new("", Path::new(""), None, Vec::new());
    for (layer, name) in names.into_iter().zip(["rest", "day"]) {
        origin.names.insert(layer.to_owned(), vec![name.to_owned()]);
    }
    let of_environment = vec![names[1].to_owned()];
    (origin.names).insert("environment".to_owned(), of_environment);
    for (transparent, day) in [(true, [0.0_f32, 0.125]), (false, [0.5, 0.375])] {
        let content = Content {
            transparent,
            ..Content::from(&film)
        };
        let mut file = io::Cursor::new(Vec::new());
        write(&mut file, &content, &Metadata::new(&film, &origin)).expect("written");
        let (channels, _) = read(&file.into_inner());
        assert_eq!(channels["ViewLayer.Combined_day.G"], day);
        let sum = |pixel: usize| {
            let of = |name: &str| channels[&format!("ViewLayer.{name}.G")][pixel];
            assert_eq!(of("Combined_day") + of("Combined_rest"), of("Combined"));
        };
        (0..2).for_each(sum);
    }
}

#[test]
fn the_same_picture_is_the_same_file() {
    for layers in [Layers::default(), Layers::all()] {
        let film = film(layers);
        let first = written(&film);
        assert!((0..4).all(|_| written(&film) == first));
    }
}
