//! A validated job of `patina compare`. Nothing is opened here.

use std::path::PathBuf;

use crate::usage::UsageError;
use crate::words::{Format, Output, parse_decimal, parse_exposure, refuse_overwriting};

use super::args::CompareArgs;

/// Two pictures to be compared.
#[derive(Debug, PartialEq)]
pub(crate) struct CompareJob {
    /// What is judged.
    pub(crate) picture: PathBuf,
    /// By what.
    pub(crate) reference: PathBuf,
    /// Of files of several layers; without it the picture itself.
    pub(crate) layer: Option<String>,
    /// Stops.
    pub(crate) exposure: f32,
    /// Where the differences are shown.
    pub(crate) diff: Option<Output>,
    /// What may not be exceeded.
    pub(crate) most: Most,
    /// Print JSON.
    pub(crate) json: bool,
}

/// The largest distances that are no failure.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Most {
    /// Of what people see, 0 to 1.
    pub(crate) flip: Option<f32>,
    /// Mean squared error.
    pub(crate) mse: Option<f32>,
    /// Relative to the reference.
    pub(crate) relative_mse: Option<f32>,
}

impl CompareJob {
    /// Validates a command line.
    ///
    /// # Errors
    /// The first flag that makes no sense.
    pub(crate) fn from_args(args: CompareArgs) -> Result<Self, UsageError> {
        let diff = args.diff.map(parse_diff).transpose()?;
        refuse_overwriting(
            diff.iter().map(|output| &output.path),
            [&args.picture, &args.reference].into_iter(),
        )?;
        let most = |flag, given: &Option<String>| {
            let given = given.as_deref();
            given
                .map(|given| parse_decimal(flag, given, "that isn't negative", |x| x >= 0.0))
                .transpose()
        };
        Ok(Self {
            most: Most {
                flip: most("--max-flip", &args.max_flip)?,
                mse: most("--max-mse", &args.max_mse)?,
                relative_mse: most("--max-relative-mse", &args.max_relative_mse)?,
            },
            exposure: parse_exposure(&args.exposure)?,
            picture: args.picture,
            reference: args.reference,
            layer: args.layer,
            diff,
            json: args.json,
        })
    }
}

/// Differences are shown on a screen.
fn parse_diff(path: PathBuf) -> Result<Output, UsageError> {
    match Format::of(&path) {
        Some(format @ (Format::Png | Format::Jpeg)) => Ok(Output { path, format }),
        _ => Err(UsageError::Difference { path }),
    }
}
