//! Tries inputs on one target: given files, or changed seeds for some time.

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use fuzzing::memory::Counting;
use fuzzing::{TARGETS, run};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const USAGE: &str = "\
Usage: fuzzing TARGET FILE...             Try files
       fuzzing TARGET --seconds N [FIRST] Try changed seeds, from the number FIRST on
       fuzzing TARGET --seeds FOLDER      Write the seeds into a folder

Targets: gltf, look, wgsl, film, panorama, render";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = arguments.split_first().and_then(|(name, rest)| {
        let target = TARGETS.iter().find(|target| target.name == *name)?;
        match rest {
            ["--seconds", seconds, first @ ..] => {
                let first = first.first().map_or(Some(0), |first| first.parse().ok())?;
                let budget = Duration::from_secs(seconds.parse().ok()?);
                let tried = run::run(target, first, u64::MAX, budget);
                println!(
                    "{name}: {} inputs, {} accepted, the slowest ({}) took {:?}",
                    tried.inputs, tried.accepted, tried.slowest.1, tried.slowest.0
                );
            }
            ["--seeds", folder] => run::write_seeds(target, Path::new(folder)).ok()?,
            [] => return None,
            files => {
                for file in files {
                    let is_accepted = (target.run)(&std::fs::read(file).ok()?);
                    let verdict = if is_accepted { "accepted" } else { "refused" };
                    println!("{file}: {verdict}");
                }
            }
        }
        Some(())
    });
    if done.is_none() {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    }
    ExitCode::SUCCESS
}
