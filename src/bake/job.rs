//! A validated job of `patina bake`. Nothing is opened here.

use std::path::PathBuf;

use device::DeviceChoice;
use engine::bake::{BakeSettings, MAX_GRID, MAX_SIZE};

use crate::usage::UsageError;
use crate::words::{Output, parse_decimal, parse_device, parse_number, parse_output};

use super::args::{BakeArgs, FineArgs};

/// How finely, and by what.
#[derive(Debug, PartialEq)]
pub(crate) struct FineJob {
    /// Size and samples.
    pub(crate) settings: BakeSettings,
    /// Device to compute on.
    pub(crate) device: DeviceChoice,
    /// Folders the user named, searched first.
    pub(crate) texture_dirs: Vec<PathBuf>,
}

impl FineJob {
    pub(crate) fn from_args(args: FineArgs, keeps_flat: bool) -> Result<Self, UsageError> {
        let metres = |given: &String| {
            parse_decimal("--occlusion", given, "of metres, greater than 0", |x| {
                x > 0.0
            })
        };
        Ok(Self {
            settings: BakeSettings {
                size: parse_number("--size", &args.size, 1, MAX_SIZE)?,
                grid: parse_number("--samples", &args.samples, 1, MAX_GRID)?,
                occlusion: args.occlusion.as_ref().map(metres).transpose()?,
                keeps_flat,
            },
            device: parse_device(args.device.as_deref())?,
            texture_dirs: args.texture_dirs,
        })
    }
}

/// Pictures to be made.
#[derive(Debug, PartialEq)]
pub(crate) struct BakeJob {
    /// Of a material or a node.
    pub(crate) name: String,
    /// The scene.
    pub(crate) scene: PathBuf,
    /// The look.
    pub(crate) look: Option<PathBuf>,
    /// Mesh or instance.
    pub(crate) mesh: Option<String>,
    /// Where they go; of a material each has an addition to the name.
    pub(crate) output: Output,
    /// How finely.
    pub(crate) fine: FineJob,
}

impl BakeJob {
    pub(crate) fn from_args(args: BakeArgs) -> Result<Self, UsageError> {
        if args.output == args.scene || args.look.as_ref() == Some(&args.output) {
            return Err(UsageError::OverwritesInput { path: args.output });
        }
        Ok(Self {
            name: args.name,
            scene: args.scene,
            look: args.look,
            mesh: args.mesh,
            output: parse_output(args.output)?,
            fine: FineJob::from_args(args.fine, true)?,
        })
    }
}
