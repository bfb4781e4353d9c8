//! How EXR files are written, as `render` and `merge` take it from the command line.

use clap::ArgAction;
use clap::builder::PossibleValuesParser;
use engine::film::layers;
use engine::film::write::{ALL_LAYERS, Compression, Form, FormError};

use crate::flags::words;
use crate::usage::UsageError;
use crate::words::parse_word;

/// Flags of what EXR files hold numbers in.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct FormArgs {
    /// How EXR files are packed. none, rle, zips, zip and piz keep every bit; pxr24 rounds 32-bit floats, b44, b44a, dwaa and dwab
    /// lose something for small files that are read fast.
    #[arg(long, value_name = "NAME", default_value = "zip")]
    #[arg(value_parser = words(Compression::ALL.map(Compression::name)))]
    pub(crate) exr_compression: String,

    /// Layers that EXR files hold in 16-bit floats. Without it colours, where their range allows it. `all` is all but ids.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', action = ArgAction::Append)]
    #[arg(value_parser = named())]
    pub(crate) exr_half: Vec<String>,

    /// Layers that EXR files hold in 32-bit floats. Without it all that are no colours. `all` is all.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', action = ArgAction::Append)]
    #[arg(value_parser = named())]
    pub(crate) exr_float: Vec<String>,

    /// A text for the header of EXR files, as in shot=0420 or owner="Studio". May be given several times.
    #[arg(long, value_name = "NAME=VALUE", action = ArgAction::Append)]
    pub(crate) metadata: Vec<String>,
}

fn named() -> PossibleValuesParser {
    words(layers::known().into_iter().chain([ALL_LAYERS]))
}

/// What the flags say.
///
/// # Errors
/// Flags that contradict each other, or a fact without a name.
pub(crate) fn parse(args: &FormArgs) -> Result<Form, UsageError> {
    let compression = parse_word(
        "--exr-compression",
        &args.exr_compression,
        Compression::ALL,
        Compression::name,
    )?;
    let form = Form::new(compression, &args.exr_half, &args.exr_float);
    let mut form = form.map_err(|error| refused("--exr-half, --exr-float", &error))?;
    for given in &args.metadata {
        let Some((name, value)) = given.split_once('=') else {
            return Err(UsageError::Pair {
                flag: "--metadata",
                given: given.clone(),
                example: "--metadata shot=0420",
            });
        };
        form = form
            .with_fact(name.trim(), value)
            .map_err(|error| refused("--metadata", &error))?;
    }
    Ok(form)
}

/// What is said of files that can't be written so.
pub(crate) fn refused(flag: &'static str, error: &FormError) -> UsageError {
    UsageError::Form {
        flag,
        problem: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(half: &[&str], float: &[&str], metadata: &[&str]) -> FormArgs {
        let list = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
        FormArgs {
            exr_compression: "piz".to_owned(),
            exr_half: list(half),
            exr_float: list(float),
            metadata: list(metadata),
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_the_flag() {
        assert!(parse(&args(&["depth"], &["all"], &["shot=1=2", "owner="])).is_ok());
        for (args, because) in [
            (args(&["crypto_object"], &[], &[]), "--exr-half"),
            (args(&["all"], &["all"], &[]), "name it once"),
            (args(&[], &[], &["shot"]), "--metadata shot=0420"),
            (args(&[], &[], &["tiles=1"]), "--metadata"),
        ] {
            let error = parse(&args).expect_err("refused").to_string();
            assert!(error.contains(because), "{error}");
        }
    }
}
