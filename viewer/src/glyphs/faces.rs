//! Which of the fonts that there are has which characters, and which of them are read: the fewest, as plain ones as possible, and none
//! that is broken.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::epaint::text::VariationCoords;
use egui::{FontData, FontFamily, FontInsert, FontPriority, FontTweak, InsertFontFamily};
use fontdb::{Database, FaceInfo, ID, Source, Stretch, Style};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::DrawSettings;
use skrifa::outline::pen::ControlBoundsPen;
use skrifa::{FontRef, MetadataProvider};

use super::Font;

/// Larger files are left alone: the largest of Chinese, Japanese and Korean together have a third of that.
const MAX_FILE: u64 = 128 << 20;
/// Fonts that one search adds at most: each is kept in memory.
const MOST_FONTS: usize = 12;
/// Font units per em: the format's limits.
const UNITS: std::ops::RangeInclusive<u16> = 16..=16384;
/// Ems that a glyph may be large; what says more is broken, and would be drawn as a picture of that size.
const LARGEST: f32 = 16.0;
/// The weight of a plain face.
const REGULAR: u16 = 400;

/// The fonts of the system. Their files are looked into, not read.
pub(super) fn of_system() -> Database {
    let mut database = Database::new();
    database.load_system_fonts();
    for folder in more_folders() {
        database.load_fonts_dir(folder);
    }
    database
}

/// Where desktops on Linux have fonts beside the places that are the same everywhere.
fn more_folders() -> Vec<PathBuf> {
    if cfg!(any(windows, target_os = "macos")) {
        return Vec::new();
    }
    let of = |name: &str| std::env::var_os(name).unwrap_or_default();
    let own = of("XDG_DATA_HOME");
    let shared = of("XDG_DATA_DIRS");
    let folders = std::env::split_paths(&own).chain(std::env::split_paths(&shared));
    let usual = ["/usr/share", "/usr/local/share"];
    let is_other = |folder: &PathBuf| {
        folder.is_absolute() && !usual.iter().any(|usual| folder == Path::new(usual))
    };
    let own = std::env::home_dir().map(|home| home.join(".local/share"));
    folders
        .filter(|folder| is_other(folder) && Some(folder) != own.as_ref())
        .map(|folder| folder.join("fonts"))
        .collect()
}

/// The user's language, as the system tells it: `ja_JP.UTF-8`.
pub(super) fn locale() -> String {
    let names = ["LC_ALL", "LC_CTYPE", "LANG"];
    let mut said = names.iter().filter_map(|name| std::env::var(name).ok());
    said.find(|locale| !locale.is_empty()).unwrap_or_default()
}

/// Reads the fonts that have these characters, as far as there are any.
pub(super) fn find(database: &Database, mut wanted: BTreeSet<char>, locale: &str) -> Vec<Font> {
    let mut candidates = candidates(database, &wanted);
    let mut fonts = Vec::new();
    while fonts.len() < MOST_FONTS {
        let Some(best) = best(&candidates, &wanted, locale) else {
            break;
        };
        let Candidate { face, characters } = candidates.swap_remove(best);
        let characters = &characters & &wanted;
        if let Some(font) = read(face, &characters) {
            wanted = &wanted - &font.characters;
            fonts.push(font);
        }
    }
    fonts
}

struct Candidate<'a> {
    face: &'a FaceInfo,
    characters: BTreeSet<char>,
}

/// All faces that have any of these.
fn candidates<'a>(database: &'a Database, wanted: &BTreeSet<char>) -> Vec<Candidate<'a>> {
    let with = |face: &'a FaceInfo| {
        let characters = covered(database, face.id, wanted);
        (!characters.is_empty()).then_some(Candidate { face, characters })
    };
    database.faces().filter_map(with).collect()
}

fn covered(database: &Database, face: ID, wanted: &BTreeSet<char>) -> BTreeSet<char> {
    let covered = database.with_face_data(face, |data, index| {
        let font = FontRef::from_index(data, index).ok()?;
        let charmap = font.charmap();
        let has = |c: &char| charmap.map(*c).is_some_and(|glyph| glyph.to_u32() != 0);
        Some(wanted.iter().copied().filter(has).collect())
    });
    covered.flatten().unwrap_or_default()
}

/// The plainest of those that have most.
fn best(candidates: &[Candidate<'_>], wanted: &BTreeSet<char>, locale: &str) -> Option<usize> {
    let rank = |i: usize| {
        let Candidate { face, characters } = &candidates[i];
        let count = characters.intersection(wanted).count();
        let (is_plain, is_sans, is_own) = (
            is_plain(face),
            is_sans(name(face)),
            is_of(locale, name(face)),
        );
        let is_narrow = face.monospaced || face.stretch != Stretch::Normal;
        let weight = Reverse(face.weight.0.abs_diff(REGULAR));
        // In the order of the system where all else is equal.
        let order = Reverse(i);
        (count > 0).then_some((is_plain, count, is_own, is_sans, !is_narrow, weight, order))
    };
    let ranked = (0..candidates.len()).filter_map(|i| Some((rank(i)?, i)));
    ranked.max_by(|a, b| a.0.cmp(&b.0)).map(|(_, i)| i)
}

fn name(face: &FaceInfo) -> &str {
    face.families.first().map_or("", |(name, _)| name)
}

/// Upright, and drawn for its characters: some fonts have boxes or coarse pixels for all there are.
fn is_plain(face: &FaceInfo) -> bool {
    let name = name(face).to_lowercase();
    let is_resort = ["last resort", "lastresort", "unifont", "blank", "notdef"]
        .iter()
        .any(|word| name.contains(word));
    face.style == Style::Normal && !is_resort
}

/// Whether it looks like the window's own font, by its name; nothing else in a font says it reliably.
fn is_sans(name: &str) -> bool {
    let name = name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let other = ["serif", "mincho", "ming", "song", "batang", "times", "mono"];
    // A sans is also a sans serif.
    has(&["sans", "gothic", "hei", "dotum", "gulim"]) || !has(&other)
}

/// Whether it is the variant for that language: one ideogram is written differently from country to country.
fn is_of(locale: &str, name: &str) -> bool {
    let region = match locale.get(..5).unwrap_or(locale) {
        "zh_TW" => ["TC", "TW"],
        "zh_HK" | "zh_MO" => ["HK", "TC"],
        other => match other.get(..2).unwrap_or_default() {
            "zh" => ["SC", "CN"],
            "ja" => ["JP", "J"],
            "ko" => ["KR", "K"],
            _ => return false,
        },
    };
    let mut words = name.split_whitespace();
    words.any(|word| region.contains(&word))
}

/// Reads a face; nothing where it is broken, or can't be read. It has those of the characters that can be drawn.
fn read(face: &FaceInfo, characters: &BTreeSet<char>) -> Option<Font> {
    let (data, origin): (Arc<dyn AsRef<[u8]> + Send + Sync>, String) = match &face.source {
        Source::Binary(data) => {
            let data = (**data).as_ref().to_vec();
            (Arc::new(data), face.post_script_name.clone())
        }
        Source::File(path) | Source::SharedFile(path, _) => {
            let data = engine::input::read(path, MAX_FILE).ok()?;
            (Arc::new(data), path.display().to_string())
        }
    };
    let (characters, tweak) = sound(data.as_ref().as_ref(), face.index, characters)?;
    let families = [FontFamily::Proportional, FontFamily::Monospace];
    let families = families.map(|family| InsertFontFamily {
        family,
        priority: FontPriority::Lowest,
    });
    let data = FontData::from_blob(data, face.index).tweak(tweak);
    let insert = FontInsert::new(&format!("{origin} {}", face.index), data, families.to_vec());
    Some(Font { insert, characters })
}

/// Which of the characters can be drawn without harm, and how; nothing where none can.
fn sound(
    data: &[u8],
    index: u32,
    characters: &BTreeSet<char>,
) -> Option<(BTreeSet<char>, FontTweak)> {
    let font = FontRef::from_index(data, index).ok()?;
    let metrics = font.metrics(Size::unscaled(), LocationRef::default());
    let em = f32::from(metrics.units_per_em);
    // Not so where it isn't a number, either.
    let is_sane = |x: f32| x.abs() <= LARGEST * em;
    let bounds = metrics.bounds?;
    let extents = [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max];
    let lines = [metrics.ascent, metrics.descent, metrics.leading];
    if !UNITS.contains(&metrics.units_per_em) || !extents.into_iter().chain(lines).all(is_sane) {
        return None;
    }
    let mut tweak = FontTweak::default();
    let mut axes = font.axes().iter();
    if axes.any(|axis| axis.tag() == skrifa::Tag::new(b"wght")) {
        // What they are at first may be the thinnest there is.
        tweak.coords = VariationCoords::new([(b"wght", f32::from(REGULAR))]);
    }
    let (charmap, outlines) = (font.charmap(), font.outline_glyphs());
    let can_draw = |c: &char| {
        let Some(outline) = charmap.map(*c).and_then(|glyph| outlines.get(glyph)) else {
            return false;
        };
        let mut pen = ControlBoundsPen::new();
        let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
        let is_drawn = outline.draw(settings, &mut pen).is_ok();
        // One without an outline would be seen as nothing at all: pictures of emoji are such.
        is_drawn
            && pen.bounding_box().is_some_and(|seen| {
                let extents = [seen.x_min, seen.y_min, seen.x_max, seen.y_max];
                extents.into_iter().all(is_sane)
            })
    };
    let characters: BTreeSet<char> = characters.iter().copied().filter(can_draw).collect();
    (!characters.is_empty()).then_some((characters, tweak))
}

#[cfg(test)]
mod tests {
    use egui::FontDefinitions;

    use super::*;

    /// In the font for code alone, in that of texts alone, in both, and in none.
    const HACK: char = '⊢';
    const UBUNTU: char = 'Ə';
    const BOTH: char = 'ж';
    const NONE: char = '한';

    fn bytes(name: &str) -> Vec<u8> {
        FontDefinitions::default().font_data[name].bytes().to_vec()
    }

    fn database(fonts: &[Vec<u8>]) -> Database {
        let mut database = Database::new();
        for font in fonts {
            database.load_font_data(font.clone());
        }
        database
    }

    fn found(database: &Database, wanted: &[char]) -> Vec<BTreeSet<char>> {
        let fonts = find(database, wanted.iter().copied().collect(), "");
        fonts.into_iter().map(|font| font.characters).collect()
    }

    #[test]
    fn as_few_fonts_as_have_all() {
        let both = database(&[bytes("Hack"), bytes("Ubuntu-Light")]);
        assert!(found(&both, &[NONE]).is_empty());
        assert_eq!(found(&both, &[BOTH, NONE]), [BTreeSet::from([BOTH])]);
        let one = BTreeSet::from([BOTH, UBUNTU]);
        assert_eq!(found(&both, &[BOTH, UBUNTU]), [one]);
        let two = found(&both, &[BOTH, UBUNTU, HACK, NONE]);
        assert_eq!(two.len(), 2);
        let all: BTreeSet<char> = two.into_iter().flatten().collect();
        assert_eq!(all, BTreeSet::from([BOTH, UBUNTU, HACK]));
        assert!(found(&Database::new(), &[BOTH]).is_empty());
    }

    #[test]
    fn broken_fonts_are_left_alone() {
        let whole = bytes("Hack");
        let mut random = 1u64;
        let mut next = || {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) as usize
        };
        for round in 0..200 {
            let mut font = whole.clone();
            // In the tables' list as well as in what they say.
            for _ in 0..=round % 40 {
                let at = match round % 3 {
                    0 => next() % 400,
                    _ => next() % font.len(),
                };
                font[at] = next() as u8;
            }
            if round % 4 == 0 {
                font.truncate(next() % whole.len());
            }
            let broken = database(&[font]);
            let fonts = find(&broken, BTreeSet::from([BOTH, HACK]), "");
            for font in fonts {
                let ctx = egui::Context::default();
                ctx.set_font_providers(vec![Arc::new(move |_: &egui::FallbackRequest<'_>| {
                    Some(font.insert.clone())
                })]);
                let mut shown = ctx.run_ui(egui::RawInput::default(), |ui| {
                    ui.label(format!("{BOTH}{HACK}"));
                });
                shown.textures_delta.clear();
            }
        }
        let mut huge = whole;
        let head = huge
            .windows(4)
            .position(|tag| tag == b"head")
            .expect("a table");
        let at = u32::from_be_bytes(huge[head + 8..head + 12].try_into().expect("four"));
        // Bounds of all glyphs: `xMax` of the table.
        let at = at as usize + 40;
        huge[at..at + 2].copy_from_slice(&i16::MAX.to_be_bytes());
        // Units per em.
        huge[at - 22..at - 20].copy_from_slice(&16u16.to_be_bytes());
        assert!(found(&database(&[huge]), &[HACK]).is_empty());
    }

    #[test]
    fn names_tell_what_a_font_looks_like() {
        for sans in [
            "Noto Sans CJK JP",
            "WenQuanYi Zen Hei",
            "MS Gothic",
            "Dotum",
        ] {
            assert!(is_sans(sans), "{sans}");
        }
        for other in ["Noto Serif CJK JP", "MS Mincho", "Batang", "Ubuntu Mono"] {
            assert!(!is_sans(other), "{other}");
        }
        assert!(is_of("ja_JP.UTF-8", "Noto Sans CJK JP"));
        assert!(is_of("zh_TW", "Noto Sans CJK TC"));
        assert!(is_of("zh_CN.UTF-8", "Noto Sans SC"));
        assert!(!is_of("zh_CN.UTF-8", "Noto Sans CJK JP"));
        assert!(!is_of("", "Noto Sans CJK JP") && !is_of("de_DE", "Noto Sans"));
    }
}
