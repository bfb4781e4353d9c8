//! Parts as files, and what they add up to.

use super::*;

fn part(samples: Range<u32>, seed: &str) -> Part {
    let mut film = Film::new(2, 1);
    for sample in samples.clone() {
        let value = 0.1 + (sample as f32).sin().abs();
        film.add_sample(0, [value, 1e-6 * value, 1e6 * value]);
        film.add_sample(1, [2.0 * value; 3]);
    }
    let origin = Origin {
        device: "device".to_owned(),
        scene: "scene.glb".to_owned(),
        look: None,
        names: BTreeMap::new(),
        settings: vec![("seed".to_owned(), seed.to_owned())],
    };
    Part::new(film, samples, origin)
}

/// The same samples with what they saw.
fn part_with_layers(samples: Range<u32>, names: &[&str]) -> Part {
    let part = part(samples.clone(), "0");
    let layers = Layers::named(names.iter().copied()).expect("known");
    let mut film = Film::with_layers(2, 1, layers);
    for plane in 0..PICTURE_PLANES.len() {
        film.planes[plane].clone_from(&part.film.planes[plane]);
    }
    for sample in samples {
        // The first sample misses.
        if sample > 0 {
            let value = sample as f32;
            film.add_surface(0, sample, |_| [value, -0.1 * value, 1e-7 * value]);
        }
    }
    Part { film, ..part }
}

fn bytes(part: &Part) -> Vec<u8> {
    let mut bytes = Vec::new();
    part.write(&mut bytes).expect("memory takes everything");
    bytes
}

fn read(bytes: &[u8]) -> Result<Part, PartError> {
    Part::read(&mut &bytes[..], bytes.len() as u64)
}

#[test]
fn a_part_is_read_as_it_was_written_or_not_at_all() {
    let part = part(3..10, "0");
    let whole = bytes(&part);
    assert_eq!(read(&whole).expect("whole"), part);
    assert!(whole.starts_with(MAGIC));
    assert!(!String::from_utf8_lossy(&whole).contains("layers"));
    for length in 0..whole.len() {
        assert!(read(&whole[..length]).is_err(), "{length} bytes");
    }
    assert!(read(&[&whole[..], b"x"].concat()).is_err());
    for at in 0..whole.len() {
        let mut changed = whole.clone();
        changed[at] ^= 4;
        assert!(read(&changed).is_err(), "byte {at}");
        // The checksum itself, and nothing else, can be mended.
        let mended = sealed(&changed).is_some_and(|sealed| sealed == whole);
        assert_eq!(mended, at >= whole.len() - 8, "byte {at}");
    }
    assert!(matches!(read(b"something else"), Err(PartError::Foreign)));
}

#[test]
fn files_of_former_versions_are_read() {
    for part in [
        part(3..10, "0"),
        part_with_layers(0..20, &["depth", "normal"]),
    ] {
        let file = unpacked(&bytes(&part)).expect("it was packed");
        assert_eq!(unpacked(&file), None);
        assert_eq!(read(&file).expect("whole"), part);
        for length in 0..file.len() {
            assert!(read(&file[..length]).is_err(), "{length} bytes");
        }
    }
}

#[test]
fn a_small_file_does_not_make_a_large_film() {
    let file = bytes(&part(0..1, "0"));
    let claimed = String::from_utf8_lossy(&file[12..]).into_owned();
    let claimed = claimed.split('}').next().unwrap_or_default().len();
    let header = String::from_utf8_lossy(&file[12..12 + claimed]).into_owned();
    let larger = header.replace("\"width\":2,", "\"width\":16384,");
    assert_ne!(header, larger);
    let length = u32::from_le_bytes([file[8], file[9], file[10], file[11]]);
    let length = length + (larger.len() - header.len()) as u32;
    let changed = [
        &file[..8],
        &length.to_le_bytes(),
        larger.as_bytes(),
        &file[12 + claimed..],
    ];
    let changed = sealed(&changed.concat()).expect("it has planes");
    let error = read(&changed).expect_err("too large").to_string();
    assert!(error.contains("wrong length"), "{error}");
}

#[test]
fn a_picture_under_way_knows_its_paths() {
    let whole = part(0..3, "0").under_way(192);
    assert_eq!(whole, part(0..3, "0"));
    assert_eq!(whole.paths(64), Some(192));
    let mut film = whole.film.clone();
    film.add_sample(0, [0.5; 3]);
    let begun = Part::new(film, 0..4, whole.origin.clone());
    assert_eq!(begun.paths(64), None);
    let begun = begun.under_way(256);
    assert_eq!(read(&bytes(&begun)).expect("whole").paths(64), Some(256));
    assert_eq!(begun.paths(8), None, "these would be more samples");
    assert_eq!(begun.under_way(200).paths(64), None, "no block ends there");
    let mut gap = part(0..1, "0");
    gap.merge(&part(5..6, "0")).expect("they fit");
    assert_eq!(gap.paths(64), None);
}

#[test]
fn a_render_that_was_ended_within_a_sample_can_be_kept_and_continued() {
    let whole = part(0..6, "0");
    let mut ended = part(0..3, "0");
    ended.film.add_sample(0, [0.5; 3]);
    let mut ended = Part::new(ended.film, 0..4, ended.origin);
    assert_eq!(read(&bytes(&ended)).expect("whole"), ended);
    ended.merge(&part(4..6, "0")).expect("they fit");
    assert_eq!(ended.ranges(), whole.ranges());
    assert_eq!(read(&bytes(&ended)).expect("whole"), ended);
    // What doesn't say so has all samples.
    let lying = Part {
        missing: 0,
        ..ended
    };
    assert!(read(&bytes(&lying)).is_err());
}

#[test]
fn parts_add_up_to_the_whole_in_any_order() {
    let whole = part(0..20, "0");
    for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
        let parts = [part(0..3, "0"), part(3..16, "0"), part(16..20, "0")];
        let mut merged = parts[order[0]].clone();
        merged.merge(&parts[order[1]]).expect("they fit");
        let gaps = merged.ranges().len();
        assert_eq!(gaps, if order[0] == 2 { 2 } else { 1 });
        merged.merge(&parts[order[2]]).expect("they fit");
        assert_eq!(merged, whole);
        assert_eq!(bytes(&merged), bytes(&whole));
    }
}

#[test]
fn layers_are_written_and_add_up_as_the_picture_does() {
    let names = ["depth", "position", "normal", "variance"];
    let part = |samples| part_with_layers(samples, &names);
    let whole = part(0..20);
    let file = bytes(&whole);
    assert_eq!(read(&file).expect("whole"), whole);
    for length in 0..file.len() {
        assert!(read(&file[..length]).is_err(), "{length} bytes");
    }
    assert_eq!(sealed(&file).expect("it has planes"), file);
    // Sums of floats would depend on the order.
    for order in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
        let parts = [part(0..3), part(3..16), part(16..20)];
        let mut merged = parts[order[0]].clone();
        merged.merge(&parts[order[1]]).expect("they fit");
        merged.merge(&parts[order[2]]).expect("they fit");
        assert_eq!(bytes(&merged), file);
    }
    let values = |name| {
        let layer = crate::film::Layer::named(name).expect("known");
        whole.film.values(layer)
    };
    // Sample 1 is the first that meets something; the other pixel sees nothing.
    assert_eq!(values("depth").expect("gathered")[0][0], 1.0);
    assert_eq!(values("depth").expect("gathered")[1][0], 1e10);
    assert_eq!(values("position").expect("gathered")[0], [1.0, -0.1, 1e-7]);
    assert_eq!(values("normal").expect("gathered")[0][0], 190.0 / 20.0);
    assert_eq!(values("uv"), None);
    assert_eq!(values("combined").expect("always"), whole.film.mean());
    let mut others = part_with_layers(20..21, &["depth"]);
    let error = others.merge(&whole).expect_err("other layers").to_string();
    assert!(
        error.contains("layers is combined,depth,position"),
        "{error}"
    );
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let mut merged = part(0..10, "0");
    let before = merged.clone();
    match merged.merge(&part(8..12, "0")) {
        Err(PartError::Overlap(samples)) => assert_eq!(samples, 8..10),
        other => panic!("{other:?}"),
    }
    let error = merged.merge(&part(10..12, "1")).expect_err("another seed");
    assert!(error.to_string().contains("seed is 1"), "{error}");
    assert_eq!(merged, before);
}
