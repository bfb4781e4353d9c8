//! How EXR files are written, as `render` and `merge` take it from the command line.

use clap::ArgAction;
use clap::builder::PossibleValuesParser;
use engine::film::write::{ALL_LAYERS, Compression, Form, FormError};
use engine::film::{Layer, Layers, layers};

use crate::flags::words;
use crate::usage::UsageError;
use crate::words::{Format, Outputs, parse_word};

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

/// Makes sure that what the flags say makes a difference to the files of a render, whose pictures show these layers: that one of them is an EXR
/// file, or a film that becomes one, and that it has each layer that is named.
///
/// # Errors
/// The first flag that says something for nothing.
pub(crate) fn check(args: &FormArgs, outputs: &Outputs, shown: &Layers) -> Result<(), UsageError> {
    let mut pictures = outputs.pictures.iter();
    let is_film = !outputs.films.is_empty();
    let is_there = is_film || pictures.any(|output| output.format == Format::Exr);
    let is_usual = args.exr_compression == Compression::default().name();
    let given = [
        ("--exr-compression", !is_usual),
        ("--exr-half", !args.exr_half.is_empty()),
        ("--exr-float", !args.exr_float.is_empty()),
        ("--metadata", !args.metadata.is_empty()),
    ];
    if let (false, Some((flag, _))) = (is_there, given.into_iter().find(|(_, is_given)| *is_given))
    {
        return Err(UsageError::NoFileOfForm { flag });
    }
    let shows = |name: &str| {
        let mut layers = shown.iter();
        let is_meant = |layer: &Layer| match name {
            layers::LIGHT_GROUPS => layer.light_group().is_some(),
            name => layer.name == name,
        };
        name == ALL_LAYERS || layers.any(is_meant)
    };
    let named = [
        ("--exr-half", &args.exr_half),
        ("--exr-float", &args.exr_float),
    ];
    let named = named
        .into_iter()
        .flat_map(|(flag, names)| names.iter().map(move |name| (flag, name)));
    // Films have layers that pictures of the render itself don't show.
    match named.filter(|_| !is_film).find(|(_, name)| !shows(name)) {
        None => Ok(()),
        Some((flag, name)) => Err(UsageError::Form {
            flag,
            problem: format!("no file has the layer `{name}`; ask for it, as in --layers {name}"),
        }),
    }
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

    #[test]
    fn what_makes_no_difference_is_refused() {
        let outputs = |paths: &[&str]| {
            let paths = paths.iter().map(std::path::PathBuf::from).collect();
            Outputs::from_paths(paths, None).expect("known endings")
        };
        let shown = Layers::named(["depth", "light_groups"]).expect("known");
        let found = |args: &FormArgs, paths: &[&str]| check(args, &outputs(paths), &shown);
        let usual = FormArgs {
            exr_compression: "zip".to_owned(),
            ..args(&[], &[], &[])
        };
        assert!(found(&usual, &["a.png"]).is_ok());
        for (said, flag) in [
            (args(&[], &[], &[]), "--exr-compression"),
            (args(&["all"], &[], &[]), "--exr-"),
            (args(&[], &[], &["shot=1"]), "--"),
        ] {
            let error = found(&said, &["a.png", "b.jpg"]).expect_err("refused");
            let error = error.to_string();
            assert!(error.starts_with(flag) && error.contains(".exr"), "{error}");
            assert!(found(&said, &["a.png", "a.exr"]).is_ok());
            assert!(found(&said, &["a.patina-film"]).is_ok());
        }
        let said = args(&["depth", "light_groups"], &["all"], &[]);
        assert!(found(&said, &["a.exr"]).is_ok());
        let said = args(&["depth"], &["combined", "albedo"], &[]);
        let error = found(&said, &["a.exr"]).expect_err("refused");
        assert!(error.to_string().contains("--layers albedo"), "{error}");
        assert!(found(&said, &["a.patina-film", "a.exr"]).is_ok());
    }
}
