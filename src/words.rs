//! Words of the command line as numbers, names and files, and their limits: what all jobs are made with. Nothing is opened here.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Duration;

use device::DeviceChoice;
use engine::film::layers::{self, LayersError};
pub(crate) use engine::film::write::Format;
use engine::film::{Crop, Layers};
use engine::scene::view::{ViewChoice, ViewTransform, WhiteBalance};

use crate::flags::DisplayArgs;
use crate::usage::{MAX_EXPOSURE, UsageError};

/// The processor without a driver.
pub(crate) const NATIVE: &str = "native";
/// Every device that a picture is rendered faster with.
const ALL_DEVICES: &str = "all";

pub(crate) use crate::usage::MAX_SPP;

/// Longest side of a picture, pixels.
pub(crate) const MAX_SIDE: u32 = engine::film::MAX_SIDE;
/// Most pixels of a film, which keeps 80 bytes for each. Larger pictures are rendered in pieces.
pub(crate) const MAX_PIXELS: u64 = 1 << 26;
/// What the name of a film's file ends in.
pub(crate) const FILM_EXTENSION: &str = "patina-film";
/// Most scattering vertices of a path.
pub(crate) const MAX_DEPTH: u32 = 255;
/// Most threads that are asked for.
pub(crate) const MOST_THREADS: u32 = 1024;

/// Which devices render a picture; where none are named, the best one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Devices {
    /// Every one that a picture is rendered faster with.
    pub(crate) all: bool,
    /// And these.
    pub(crate) named: Vec<DeviceChoice>,
}

/// The files to write; at least one, no two alike.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Outputs {
    /// Pictures.
    pub(crate) pictures: Vec<Output>,
    /// Exact sums of samples.
    pub(crate) films: Vec<PathBuf>,
}

impl Outputs {
    /// By their endings. Where nothing is given, the usual picture of `scene`.
    pub(crate) fn from_paths(
        mut paths: Vec<PathBuf>,
        scene: Option<&Path>,
    ) -> Result<Self, UsageError> {
        if let (true, Some(scene)) = (paths.is_empty(), scene) {
            paths.push(default_output(scene));
        }
        let is_film = |path: &PathBuf| {
            let extension = path.extension();
            extension.is_some_and(|e| e.eq_ignore_ascii_case(FILM_EXTENSION))
        };
        let (films, pictures): (Vec<_>, Vec<_>) = paths.into_iter().partition(is_film);
        Ok(Self {
            pictures: pictures
                .into_iter()
                .map(|path| match Format::of(&path) {
                    Some(format) => Ok(Output { path, format }),
                    None => Err(UsageError::ExtensionOfFilm { path }),
                })
                .collect::<Result<_, _>>()?,
            films,
        })
    }

    /// Where a render under way is kept: in the film that is asked for, else beside the first picture, by its name.
    pub(crate) fn checkpoint(&self) -> PathBuf {
        // Of a film the ending may be written with other letters.
        if let Some(film) = self.films.first() {
            return film.clone();
        }
        let picture = self.pictures.first();
        picture
            .map(|output| output.path.with_extension(FILM_EXTENSION))
            .unwrap_or_default()
    }

    /// All files.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        let pictures = self.pictures.iter().map(|output| &output.path);
        pictures.chain(&self.films)
    }
}

/// A picture file to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Output {
    /// Where.
    pub(crate) path: PathBuf,
    /// What.
    pub(crate) format: Format,
}

/// The samples of a part of a whole, the parts numbered from 1: as even as they can be.
pub(crate) fn part_of(spp: u32, part: u32, parts: u32) -> Range<u32> {
    let end = |part: u32| (u64::from(spp) * u64::from(part) / u64::from(parts)) as u32;
    end(part - 1)..end(part)
}

/// The samples of `3/16`: the third of sixteen parts.
pub(crate) fn parse_part(given: &str, spp: u32) -> Result<Range<u32>, UsageError> {
    let numbers = given.split_once('/').and_then(|(part, parts)| {
        let (part, parts) = (part.trim().parse().ok()?, parts.trim().parse().ok()?);
        (1..=parts)
            .contains(&part)
            .then(|| part_of(spp, part, parts))
    });
    let samples = numbers.filter(|samples| samples.start < samples.end);
    samples.ok_or_else(|| UsageError::Part {
        given: given.to_owned(),
        spp,
    })
}

pub(crate) fn parse_sample_range(
    flag: &'static str,
    given: &str,
) -> Result<Range<u32>, UsageError> {
    let range = given.split_once("..").and_then(|(first, end)| {
        let range = first.trim().parse().ok()?..end.trim().parse().ok()?;
        (range.start < range.end && range.end <= MAX_SPP).then_some(range)
    });
    range.ok_or_else(|| UsageError::SampleRange {
        flag,
        given: given.to_owned(),
    })
}

/// The value of that name.
pub(crate) fn parse_word<T: Copy>(
    flag: &'static str,
    given: &str,
    all: impl IntoIterator<Item = T>,
    name: impl Fn(T) -> &'static str,
) -> Result<T, UsageError> {
    let all: Vec<T> = all.into_iter().collect();
    let found = all.iter().copied().find(|&value| name(value) == given);
    found.ok_or_else(|| UsageError::Word {
        flag,
        given: given.to_owned(),
        known: all.into_iter().map(name).collect(),
    })
}

/// A finite number that is accepted.
pub(crate) fn parse_decimal(
    flag: &'static str,
    given: &str,
    range: &'static str,
    accept: impl Fn(f32) -> bool,
) -> Result<f32, UsageError> {
    let number = given.parse().ok();
    number
        .filter(|&x: &f32| x.is_finite() && accept(x))
        .ok_or_else(|| UsageError::Decimal {
            flag,
            given: given.to_owned(),
            range,
        })
}

/// So many bytes: a number with K, M, G or T for the powers of 1024.
pub(crate) fn parse_memory(given: &str) -> Result<u64, UsageError> {
    let text = given
        .trim()
        .trim_end_matches(['B', 'b'])
        .trim_end_matches('i');
    let unit = text.chars().last().map(|c| c.to_ascii_uppercase());
    let factor = match unit {
        Some('K') => 1 << 10,
        Some('M') => 1 << 20,
        Some('G') => 1 << 30,
        Some('T') => 1_u64 << 40,
        _ => 0,
    };
    let number: Option<f64> = text
        .get(..text.len().saturating_sub(1))
        .and_then(|n| n.trim().parse().ok());
    let bytes = number.map_or(0.0, |number| number * factor as f64);
    // A number that isn't one is in no range.
    match (1.0..1e18).contains(&bytes) {
        true => Ok(bytes as u64),
        false => Err(UsageError::Memory {
            given: given.to_owned(),
        }),
    }
}

/// A time: numbers with units, as in `90s`, `10m`, `1h30m`; a number alone is seconds.
pub(crate) fn parse_duration(flag: &'static str, given: &str) -> Result<Duration, UsageError> {
    let refused = || UsageError::Time {
        flag,
        given: given.to_owned(),
    };
    let text = given.trim();
    if let Ok(seconds) = text.parse::<f64>() {
        let time = Duration::try_from_secs_f64(seconds).ok();
        return time.filter(|time| !time.is_zero()).ok_or_else(refused);
    }
    let mut seconds = 0.0;
    for part in text.split_inclusive(|c: char| c.is_ascii_alphabetic()) {
        let unit = match part.chars().last() {
            Some('h') => 3600.0,
            Some('m') => 60.0,
            Some('s') => 1.0,
            _ => return Err(refused()),
        };
        let number: f64 = part[..part.len() - 1].parse().map_err(|_| refused())?;
        if number.is_nan() || number < 0.0 {
            return Err(refused());
        }
        seconds += number * unit;
    }
    let time = Duration::try_from_secs_f64(seconds).ok();
    time.filter(|time| !time.is_zero()).ok_or_else(refused)
}

/// A point: three finite numbers with commas between.
pub(crate) fn parse_point(flag: &'static str, given: &str) -> Result<[f32; 3], UsageError> {
    let numbers: Result<Vec<f32>, _> = given.split(',').map(|x| x.trim().parse()).collect();
    let point = numbers
        .ok()
        .and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    let point = point.filter(|point| point.iter().all(|x| x.is_finite()));
    point.ok_or_else(|| UsageError::Point {
        flag,
        given: given.to_owned(),
    })
}

/// A share of a size, such as `50%` or `0.5`.
pub(crate) fn parse_scale(given: &str) -> Result<f64, UsageError> {
    let (number, unit) = match given.trim().strip_suffix('%') {
        Some(percent) => (percent, 0.01),
        None => (given, 1.0),
    };
    let scale = number
        .trim()
        .parse::<f64>()
        .map(|number| number * unit)
        .ok();
    // A larger one without its sign is more likely to be meant as percent.
    let most = if unit < 1.0 { 100.0 } else { 10.0 };
    scale
        .filter(|scale| (0.001..=most).contains(scale))
        .ok_or_else(|| UsageError::Decimal {
            flag: "--scale",
            given: given.to_owned(),
            range: "from 0.1% to 10000%, as in --scale 50%",
        })
}

/// The size of a picture that is one film.
pub(crate) fn parse_size(given: &str) -> Result<(u32, u32), UsageError> {
    let (width, height) = parse_sides(given)?;
    let pixels = u64::from(width) * u64::from(height);
    match pixels > MAX_PIXELS {
        true => Err(UsageError::Size {
            given: given.to_owned(),
            problem: format!("{pixels} pixels are more than the {MAX_PIXELS} supported"),
        }),
        false => Ok((width, height)),
    }
}

/// The size of a picture, of as many pixels as its sides allow.
pub(crate) fn parse_sides(given: &str) -> Result<(u32, u32), UsageError> {
    let refuse = |problem: String| UsageError::Size {
        given: given.to_owned(),
        problem,
    };
    let side = |text: &str, name: &str| match text.parse::<u64>() {
        Ok(0) => Err(refuse(format!("the {name} is zero"))),
        Ok(n) if n > u64::from(MAX_SIDE) => Err(refuse(format!("the {name} exceeds {MAX_SIDE}"))),
        Ok(n) => Ok(n as u32),
        Err(_) if text.is_empty() => Err(refuse(format!("the {name} is missing"))),
        // Digits that do not fit 64 bits are still a number to the user.
        Err(_) if text.bytes().all(|b| b.is_ascii_digit()) => {
            Err(refuse(format!("the {name} exceeds {MAX_SIDE}")))
        }
        Err(_) => Err(refuse(format!("the {name} is not a whole number"))),
    };
    let Some((width, height)) = given.split_once(['x', 'X']) else {
        return Err(refuse("there is no 'x' between two numbers".to_owned()));
    };
    Ok((side(width, "width")?, side(height, "height")?))
}

pub(crate) fn parse_number(
    flag: &'static str,
    given: &str,
    low: u32,
    high: u32,
) -> Result<u32, UsageError> {
    given
        .parse::<u32>()
        .ok()
        .filter(|n| (low..=high).contains(n))
        .ok_or_else(|| UsageError::Number {
            flag,
            given: given.to_owned(),
            low,
            high,
        })
}

/// How a picture is shown, as far as the command line says it.
pub(crate) fn parse_display(args: &DisplayArgs) -> Result<ViewChoice, UsageError> {
    let exposure = args.exposure.as_deref().map(parse_exposure);
    let white_balance = args.white_balance.as_deref().map(parse_white_balance);
    let transform = args.view.as_deref().map(|name| {
        let all = ViewTransform::ALL;
        parse_word("--view", name, all, ViewTransform::name)
    });
    Ok(ViewChoice {
        exposure: exposure.transpose()?,
        white_balance: white_balance.transpose()?,
        transform: transform.transpose()?,
    })
}

fn parse_white_balance(given: &str) -> Result<WhiteBalance, UsageError> {
    let (temperature, tint) = match given.split_once(',') {
        Some((temperature, tint)) => (temperature, Some(tint)),
        None => (given, None),
    };
    let number = |text: &str| text.trim().parse::<f32>().ok();
    let balance = number(temperature).and_then(|temperature| match tint {
        Some(tint) => WhiteBalance::new(temperature, Some(number(tint)?)),
        None => WhiteBalance::new(temperature, None),
    });
    balance.ok_or_else(|| UsageError::WhiteBalance {
        given: given.to_owned(),
    })
}

pub(crate) fn parse_exposure(given: &str) -> Result<f32, UsageError> {
    given
        .parse::<f32>()
        .ok()
        // NaN is in no range.
        .filter(|stops| (-MAX_EXPOSURE..=MAX_EXPOSURE).contains(stops))
        .ok_or_else(|| UsageError::Exposure {
            given: given.to_owned(),
        })
}

pub(crate) fn parse_device(given: Option<&str>) -> Result<DeviceChoice, UsageError> {
    match given.map(str::trim) {
        None => Ok(DeviceChoice::Best),
        Some("") => Err(UsageError::EmptyDevice),
        Some(text) if words_of(text).len() > 1 || is_all(text) => {
            let given = text.to_owned();
            Err(UsageError::SeveralDevices { given })
        }
        Some(text) => Ok(match (text.parse(), text.split_once(':')) {
            (Ok(index), _) => DeviceChoice::Index(index),
            (_, Some((name, threads))) if name.eq_ignore_ascii_case(NATIVE) => {
                let refused = |_| UsageError::Word {
                    flag: "--device",
                    given: text.to_owned(),
                    known: vec!["native:N with a whole number of threads from 1 to 1024"],
                };
                let threads = parse_number("--device", threads, 1, MOST_THREADS);
                DeviceChoice::Native(threads.map_err(refused)?)
            }
            _ => DeviceChoice::Name(text.to_owned()),
        }),
    }
}

/// The devices that render together: those of each list, whose words have commas between.
pub(crate) fn parse_devices(given: &[String]) -> Result<Devices, UsageError> {
    let mut devices = Devices::default();
    for word in given.iter().flat_map(|list| words_of(list)) {
        if is_all(word) {
            devices.all = true;
            continue;
        }
        let device = parse_device(Some(word))?;
        // Of the processor there may be several, each with its own threads.
        let is_one = !matches!(device, DeviceChoice::Native(_));
        if is_one && devices.named.contains(&device) {
            let given = word.trim().to_owned();
            return Err(UsageError::DeviceTwice { given });
        }
        devices.named.push(device);
    }
    Ok(devices)
}

/// Whether every device is meant.
fn is_all(word: &str) -> bool {
    word.trim().eq_ignore_ascii_case(ALL_DEVICES)
}

/// The words of a list. Names of devices may have commas in parentheses.
fn words_of(list: &str) -> Vec<&str> {
    let mut depth = 0_i32;
    let is_between = |c: char| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        c == ',' && depth <= 0
    };
    list.split(is_between).collect()
}

pub(crate) fn parse_output(path: PathBuf) -> Result<Output, UsageError> {
    match Format::of(&path) {
        Some(format) => Ok(Output { path, format }),
        None => Err(UsageError::Extension { path }),
    }
}

/// A part of a picture of so many columns and rows: where it lies, and its own size.
pub(crate) fn parse_crop(
    given: &str,
    [width, height]: [u32; 2],
) -> Result<(Crop, (u32, u32)), UsageError> {
    let numbers: Result<Vec<u32>, _> = given.split(',').map(|n| n.trim().parse()).collect();
    let part = match numbers.as_deref() {
        Ok(&[left, top, columns, rows]) if columns > 0 && rows > 0 => {
            let whole = [width, height];
            Some((Crop { left, top, whole }, (columns, rows)))
        }
        _ => None,
    };
    let part = part.filter(|(crop, (columns, rows))| crop.holds(*columns, *rows));
    part.ok_or_else(|| UsageError::Crop {
        given: given.to_owned(),
        width,
        height,
    })
}

/// Layers by name, for which there must be a file that can hold them.
pub(crate) fn parse_layers(names: &[String], outputs: &Outputs) -> Result<Layers, UsageError> {
    let refused = |error| match error {
        LayersError::Unknown(error) => UsageError::Word {
            flag: "--layers",
            given: error.name,
            known: layers::known(),
        },
        LayersError::Nodes { .. } => UsageError::Layers(error.to_string()),
    };
    let layers = Layers::named(names.iter().map(String::as_str)).map_err(refused)?;
    let mut pictures = outputs.pictures.iter();
    let is_kept = !outputs.films.is_empty() || pictures.any(|output| output.format == Format::Exr);
    match layers.is_picture_alone() || is_kept {
        true => Ok(layers),
        false => Err(UsageError::NoFileOfLayers),
    }
}

/// `SCENE-render.png`: not `SCENE.png`, which may well be a texture of the scene.
fn default_output(scene: &Path) -> PathBuf {
    let mut name = scene
        .file_stem()
        .map_or_else(|| "scene".into(), ToOwned::to_owned);
    name.push("-render.png");
    name.into()
}

pub(crate) fn refuse_overwriting<'a>(
    written: impl Iterator<Item = &'a PathBuf>,
    read: impl Iterator<Item = &'a PathBuf>,
) -> Result<(), UsageError> {
    let inputs: Vec<_> = read.collect();
    let mut seen: Vec<&PathBuf> = Vec::new();
    for path in written {
        if seen.contains(&path) {
            return Err(UsageError::Twice { path: path.clone() });
        }
        if inputs.contains(&path) {
            return Err(UsageError::OverwritesInput { path: path.clone() });
        }
        seen.push(path);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_that_can_not_be_are_told_as_they_were_typed() {
        for given in ["native:0", "native:many"] {
            let error = parse_device(Some(given)).expect_err(given).to_string();
            let expected = format!(
                "--device {given}: must be native:N with a whole number of threads from 1 to {MOST_THREADS}"
            );
            assert_eq!(error, expected);
        }
    }
}
