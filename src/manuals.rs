//! `patina manuals`: the manual's pages and completions for shells, as packages of the program hold them. They say what
//! `--help` says.

use std::fs;
use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::args::Args;
use crate::failure::Failure;

const SHELLS: [Shell; 3] = [Shell::Bash, Shell::Fish, Shell::Zsh];

/// Writes `man/man1/*.1` and `completions/*` into the folder.
///
/// # Errors
/// Something can't be written.
pub(crate) fn write(dir: &Path) -> Result<(), Failure> {
    let refused = |error| Failure::Failed(format!("cannot write to {}: {error}", dir.display()));
    let (man, completions) = (dir.join("man/man1"), dir.join("completions"));
    for folder in [&man, &completions] {
        fs::create_dir_all(folder).map_err(refused)?;
    }
    clap_mangen::generate_to(Args::command(), &man).map_err(refused)?;
    for shell in SHELLS {
        clap_complete::generate_to(shell, &mut Args::command(), "patina", &completions)
            .map_err(refused)?;
    }
    Ok(())
}
