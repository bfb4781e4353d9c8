//! Tries inputs on one target: given files, or changed seeds for some time.

use std::io;
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use fuzzing::memory::Counting;
use fuzzing::{Scratch, TARGETS, run};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const USAGE: &str = "\
Usage: fuzzing TARGET FILE...             Try files
       fuzzing TARGET --seconds N [FIRST] Try changed seeds, from the number FIRST on
       fuzzing TARGET --seeds FOLDER      Write the seeds into a folder

Targets: gltf, look, wgsl, film, panorama, render";

/// Why not everything was done.
enum Problem {
    /// The words make no sense.
    Usage,
    /// A file or a folder can't be used.
    File(String, io::Error),
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match follow(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Problem::Usage) => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
        Err(Problem::File(path, error)) => {
            eprintln!("error: {path}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn follow(arguments: &[&str]) -> Result<(), Problem> {
    let (name, rest) = arguments.split_first().ok_or(Problem::Usage)?;
    let target = TARGETS.iter().find(|target| target.name == *name);
    let target = target.ok_or(Problem::Usage)?;
    match rest {
        ["--seconds", seconds, first @ ..] => {
            let number = |word: &str| word.parse::<u64>().map_err(|_| Problem::Usage);
            let first = first.first().map_or(Ok(0), |first| number(first))?;
            let budget = Duration::from_secs(number(seconds)?);
            let tried = run::run(target, first, u64::MAX, budget);
            println!(
                "{name}: {} inputs, {} accepted, the slowest ({}) took {:?}",
                tried.inputs, tried.accepted, tried.slowest.1, tried.slowest.0
            );
        }
        ["--seeds", folder] => {
            let written = run::write_seeds(target, Path::new(folder));
            written.map_err(|error| Problem::File((*folder).to_owned(), error))?;
        }
        [] => return Err(Problem::Usage),
        files => {
            let _scratch = Scratch::hold();
            for file in files {
                let data = std::fs::read(file);
                let data = data.map_err(|error| Problem::File((*file).to_owned(), error))?;
                let verdict = match (target.run)(&data) {
                    true => "accepted",
                    false => "refused",
                };
                println!("{file}: {verdict}");
            }
        }
    }
    Ok(())
}
