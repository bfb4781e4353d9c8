//! Validated jobs of `patina texture`: names, numbers and pairs are understood here, and nothing is opened.

use std::path::{Path, PathBuf};

use device::DeviceChoice;
use engine::aside;

use crate::usage::UsageError;
use crate::words::{Output, parse_device, parse_number, parse_output};

use super::args::{EvalArgs, Folders, InspectArgs, Part, PreviewArgs, Target, TextureCommand};

/// Narrowest preview, pixels.
const MIN_SIZE: u32 = 32;
/// Widest preview, pixels.
const MAX_SIZE: u32 = 4096;
/// Longest name of a new texture, in letters.
const MAX_NAME: usize = 64;

/// What is to be done with textures.
#[derive(Debug, PartialEq)]
pub(crate) enum TextureJob {
    /// Print a table of all.
    List(Vec<PathBuf>),
    /// Write the page about all.
    Doc(DocJob),
    /// Print the prelude.
    Prelude,
    /// Show mistakes.
    Check(CheckJob),
    /// Show what becomes of a texture or a look.
    Inspect(InspectJob),
    /// Print values.
    Eval(EvalJob),
    /// Render a picture.
    Preview(PreviewJob),
    /// Write a template.
    New(NewJob),
}

/// A page to be written.
#[derive(Debug, PartialEq)]
pub(crate) struct DocJob {
    /// Where it goes; without it, it is printed.
    pub(crate) output: Option<PathBuf>,
    /// The folder of the sheets.
    pub(crate) sheets: Option<PathBuf>,
    /// Device that makes the swatches.
    pub(crate) device: DeviceChoice,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// Textures to be checked.
#[derive(Debug, PartialEq)]
pub(crate) struct CheckJob {
    /// Files, folders or names; all textures where there is none.
    pub(crate) files: Vec<PathBuf>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// Something to be inspected.
#[derive(Debug, PartialEq)]
pub(crate) struct InspectJob {
    /// What.
    pub(crate) subject: Inspected,
    /// Only this part of it.
    pub(crate) part: Option<Part>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
}

/// What is inspected.
#[derive(Debug, PartialEq)]
pub(crate) enum Inspected {
    /// A texture by name.
    Texture(String),
    /// A look file.
    Look(PathBuf),
}

/// A texture or node with its arguments, and the device it is evaluated on.
#[derive(Debug, PartialEq)]
pub(crate) struct TargetJob {
    /// Of the texture, or of the node where there is a look.
    pub(crate) name: String,
    /// The look file.
    pub(crate) look: Option<PathBuf>,
    /// Arguments by parameter, as typed.
    pub(crate) sets: Vec<(String, String)>,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
    /// Device to compute on.
    pub(crate) device: DeviceChoice,
}

/// Values to be printed.
#[derive(Debug, PartialEq)]
pub(crate) struct EvalJob {
    /// Of what.
    pub(crate) target: TargetJob,
    /// Where: at least one point. Each is a list of names with one to four numbers.
    pub(crate) points: Vec<Vec<(String, Vec<f32>)>>,
}

/// A preview to be rendered.
#[derive(Debug, PartialEq)]
pub(crate) struct PreviewJob {
    /// Of what.
    pub(crate) target: TargetJob,
    /// Where it goes.
    pub(crate) output: Output,
    /// Width in pixels.
    pub(crate) size: u32,
    /// Values shown black and white.
    pub(crate) range: [f32; 2],
    /// The target is a material.
    pub(crate) is_material: bool,
}

/// A texture to begin.
#[derive(Debug, PartialEq)]
pub(crate) struct NewJob {
    /// Its name.
    pub(crate) name: String,
    /// The texture that is copied; without it the template is written.
    pub(crate) from: Option<String>,
    /// Where the file goes.
    pub(crate) dir: PathBuf,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
}

impl TextureJob {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(crate) fn from_args(command: TextureCommand) -> Result<Self, UsageError> {
        Ok(match command {
            TextureCommand::List {
                folders: Folders { texture_dirs },
            } => Self::List(texture_dirs),
            TextureCommand::Doc {
                output,
                sheets,
                device,
                folders,
            } => Self::Doc(DocJob {
                output,
                sheets,
                device: parse_device(device.as_deref())?,
                texture_dirs: folders.texture_dirs,
            }),
            TextureCommand::Prelude => Self::Prelude,
            TextureCommand::Check { files, folders } => Self::Check(CheckJob {
                files,
                texture_dirs: folders.texture_dirs,
            }),
            TextureCommand::Inspect(args) => Self::Inspect(InspectJob::from_args(args)?),
            TextureCommand::Eval(args) => Self::Eval(EvalJob::from_args(args)?),
            TextureCommand::Preview(args) => Self::Preview(PreviewJob::from_args(args)?),
            TextureCommand::New {
                name,
                from,
                dir,
                folders,
            } => {
                check_name(&name)?;
                Self::New(NewJob {
                    name,
                    from,
                    dir,
                    texture_dirs: folders.texture_dirs,
                })
            }
        })
    }
}

impl InspectJob {
    fn from_args(args: InspectArgs) -> Result<Self, UsageError> {
        if let Some(name) = &args.name {
            refuse_file(name)?;
        }
        Ok(Self {
            subject: match (args.name, args.look) {
                (_, Some(look)) => Inspected::Look(look),
                // clap demands one of the two.
                (name, None) => Inspected::Texture(name.unwrap_or_default()),
            },
            part: args.part,
            texture_dirs: args.folders.texture_dirs,
        })
    }
}

impl TargetJob {
    fn from_args(args: Target) -> Result<Self, UsageError> {
        let pair = |given: String| match given.split_once('=') {
            Some((name, value)) if !name.trim().is_empty() => {
                Ok((name.trim().to_owned(), value.trim().to_owned()))
            }
            _ => Err(UsageError::Pair {
                flag: "--set",
                given,
                example: "--set scale=3",
            }),
        };
        // Nodes of a look may be called as they like.
        if args.look.is_none() {
            refuse_file(&args.name)?;
        }
        Ok(Self {
            name: args.name,
            look: args.look,
            sets: args.sets.into_iter().map(pair).collect::<Result<_, _>>()?,
            texture_dirs: args.folders.texture_dirs,
            device: parse_device(args.device.as_deref())?,
        })
    }
}

impl EvalJob {
    fn from_args(args: EvalArgs) -> Result<Self, UsageError> {
        let mut points = args
            .points
            .iter()
            .map(|point| parse_point(point))
            .collect::<Result<Vec<_>, _>>()?;
        if points.is_empty() {
            points.push(Vec::new());
        }
        Ok(Self {
            target: TargetJob::from_args(args.target)?,
            points,
        })
    }
}

impl PreviewJob {
    fn from_args(args: PreviewArgs) -> Result<Self, UsageError> {
        let is_material = args.material.is_some();
        let target = TargetJob::from_args(Target {
            // clap demands one of the two.
            name: args.material.or(args.name).unwrap_or_default(),
            look: args.look,
            sets: args.sets,
            folders: args.folders,
            device: args.device,
        })?;
        let output = match args.output {
            Some(path) => path,
            None => format!("{}-preview.png", target.name).into(),
        };
        if target.look.as_ref() == Some(&output) {
            return Err(UsageError::OverwritesInput { path: output });
        }
        Ok(Self {
            output: parse_output(output)?,
            size: parse_number("--size", &args.size, MIN_SIZE, MAX_SIZE)?,
            range: args
                .range
                .map_or(Ok([0.0, 1.0]), |range| parse_range(&range))?,
            is_material,
            target,
        })
    }
}

/// A file is no name: what it uses is found only where its folder is searched.
fn refuse_file(name: &str) -> Result<(), UsageError> {
    let path = Path::new(name);
    match (path.extension(), path.file_stem()) {
        (Some(ending), Some(stem)) if ending == "wgsl" => Err(UsageError::TextureFile {
            given: path.to_owned(),
            name: stem.to_string_lossy().into_owned(),
            folder: aside::folder_of(path).to_owned(),
        }),
        _ => Ok(()),
    }
}

/// `NAME=X,Y,...;NAME=...`.
fn parse_point(given: &str) -> Result<Vec<(String, Vec<f32>)>, UsageError> {
    let parts = given.split(';').filter(|part| !part.trim().is_empty());
    parts
        .map(|part| {
            let Some((name, numbers)) = part.split_once('=') else {
                return Err(UsageError::Pair {
                    flag: "--at",
                    given: given.to_owned(),
                    example: "--at \"TexCoord0=0.5,0.5;WorldPos=1,2,3\"",
                });
            };
            let name = name.trim().to_owned();
            let numbers: Option<Vec<f32>> = numbers
                .split(',')
                .map(|number| number.trim().parse().ok())
                .collect();
            match numbers.filter(|numbers| numbers.len() <= 4) {
                Some(numbers) => Ok((name, numbers)),
                None => Err(UsageError::Numbers {
                    given: given.to_owned(),
                    name,
                }),
            }
        })
        .collect()
}

/// `LOW..HIGH`.
fn parse_range(given: &str) -> Result<[f32; 2], UsageError> {
    let number = |text: &str| text.trim().parse::<f32>().ok().filter(|n| n.is_finite());
    given
        .split_once("..")
        .and_then(|(low, high)| Some([number(low)?, number(high)?]))
        .filter(|[low, high]| low < high && (high - low).is_finite())
        .ok_or_else(|| UsageError::Range {
            given: given.to_owned(),
        })
}

/// A texture's name is a file name, stands in look files, and is a part of names in the kernel.
fn check_name(name: &str) -> Result<(), UsageError> {
    let refuse = |problem: &str| {
        Err(UsageError::TextureName {
            given: name.to_owned(),
            problem: problem.to_owned(),
        })
    };
    if name.ends_with(".wgsl") {
        return refuse("leave the ending .wgsl out");
    }
    if !name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        return refuse("it has to begin with a letter, as in `old_paint`");
    }
    if !name
        .bytes()
        .all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-')
    {
        return refuse("use letters, digits, `_` and `-`, as in `old_paint`");
    }
    if name.len() > MAX_NAME {
        return refuse("it is longer than 64 letters");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_names_with_numbers() {
        let point = parse_point(" TexCoord0=0.5, -1e3;Time=2 ;").unwrap();
        let expected = [
            ("TexCoord0".to_owned(), vec![0.5, -1.0e3]),
            ("Time".to_owned(), vec![2.0]),
        ];
        assert_eq!(point, expected);
        for bad in ["Time", "Time=", "Time=x", "Time=1,2,3,4,5"] {
            let error = parse_point(bad).unwrap_err().to_string();
            assert!(error.contains(bad), "{bad}: {error}");
        }
    }

    #[test]
    fn ranges_ascend() {
        assert_eq!(parse_range("-1..1"), Ok([-1.0, 1.0]));
        assert_eq!(parse_range(".5 .. 2."), Ok([0.5, 2.0]));
        for bad in ["", "1", "1..", "1..1", "2..1", "nan..1", "0..inf"] {
            assert!(parse_range(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_file_is_no_name_of_a_texture() {
        let said = |name| refuse_file(name).expect_err(name).to_string();
        assert!(said("a.wgsl").ends_with("write `a --textures .`"));
        assert!(said("/b c/a.wgsl").ends_with("write `a --textures /b c`"));
        for name in ["a", "a.color", "wgsl"] {
            assert_eq!(refuse_file(name), Ok(()), "{name}");
        }
    }

    #[test]
    fn names_of_new_textures_are_plain() {
        for good in ["a", "old_paint", "Wood-2"] {
            assert_eq!(check_name(good), Ok(()), "{good}");
        }
        for bad in ["", "2d", "a/b", "../a", "a.wgsl", "a b", "é", "_a"] {
            assert!(check_name(bad).is_err(), "{bad}");
        }
        assert!(check_name(&"a".repeat(65)).is_err());
    }
}
