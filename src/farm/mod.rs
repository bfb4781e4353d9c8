//! `patina farm`: files for schedulers that exist. A part is some of the samples of all pixels, rendered into a film of its own; a
//! machine that is lost costs its part, which the scheduler gives to another one. The films add up to the bits of the whole.

pub(crate) mod args;
mod flamenco;
pub(crate) mod job;
mod opencue;
mod openjd;
mod shell;
mod slurm;

use std::io::{BufReader, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};

use engine::film::Part;
use engine::scene::look::{EnvironmentLook, Look};
use engine::{input, load};

use crate::failure::Failure;
use crate::words::{FILM_EXTENSION, part_of};
use crate::{console, library, output, picture};

use args::Scheduler;
use job::ExportJob;

/// Samples as ranges, ascending and apart from each other.
type Samples = Vec<Range<u32>>;

/// Samples of a part, and where its film goes.
#[derive(Debug, Clone, PartialEq)]
struct FarmPart {
    samples: Range<u32>,
    film: PathBuf,
}

/// What the files of a job are written from.
#[derive(Debug)]
struct Plan {
    name: String,
    /// Where the command was given: its words mean what they meant there, wherever a scheduler runs them.
    here: PathBuf,
    /// Absolute, and so all films and results.
    folder: PathBuf,
    scene: PathBuf,
    /// Of `patina render`.
    flags: Vec<String>,
    /// Of `patina merge`: those of them that say what is made of the samples.
    merge_flags: Vec<String>,
    /// To be rendered.
    parts: Vec<FarmPart>,
    /// All that are merged, those that are there already too.
    films: Vec<PathBuf>,
    spp: u32,
    results: Vec<PathBuf>,
}

impl Plan {
    /// The words that render a part.
    fn render(&self, samples: &str, film: &str) -> Vec<String> {
        let scene = self.scene.display().to_string();
        let words = job::part_words(&scene, &self.flags, samples, film);
        let start = ["patina", "render"].map(str::to_owned).into_iter();
        start.chain(words).collect()
    }

    /// The words that make the picture of some films.
    fn merge(&self, films: &[PathBuf]) -> Vec<String> {
        let text = |path: &PathBuf| path.display().to_string();
        let expected = format!("0..{}", self.spp);
        let start = ["patina", "merge", "--expect", &expected]
            .map(str::to_owned)
            .into_iter();
        let results = self
            .results
            .iter()
            .flat_map(|path| ["-o".to_owned(), text(path)]);
        start
            .chain(self.merge_flags.iter().cloned())
            .chain(results)
            .chain(films.iter().map(text))
            .collect()
    }
}

/// Writes the files, and says what to do with them.
///
/// # Errors
/// They can't be written, nor can the results; a film in the folder can't be read, nor can what the parts are rendered from.
pub(crate) fn export(job: &ExportJob) -> Result<(), Failure> {
    let mut read = inputs(job)?;
    let is_new = !job.folder.exists();
    std::fs::create_dir_all(&job.folder).map_err(|error| {
        Failure::Failed(format!("cannot create {}: {error}", job.folder.display()))
    })?;
    let plan = plan(job)?;
    // What the merge would find out when all is rendered. Results may lie in the folder, which is there for that.
    read.extend(plan.films.iter().cloned());
    if let Err(refused) = output::check_all(&job.results, &read) {
        if is_new {
            let _ = std::fs::remove_dir(&job.folder);
        }
        return Err(refused);
    }
    if plan.parts.is_empty() {
        console::print(&format!(
            "no samples are missing; the picture is made by: {}",
            shell::line(&plan.merge(&plan.films))
        ));
        return Ok(());
    }
    let (files, next) = match job.scheduler {
        Scheduler::Slurm => slurm::files(&plan),
        Scheduler::Openjd => openjd::files(&plan),
        Scheduler::Opencue => opencue::files(&plan),
        Scheduler::Flamenco => flamenco::files(&plan),
    };
    for (name, text) in files {
        let path = plan.folder.join(name);
        let written = output::write_aside(&path, |file| file.write_all(text.as_bytes()));
        written.map_err(Failure::because)?;
        console::note(&format!("wrote {}", path.display()));
    }
    console::print(&format!("{} parts; {next}", plan.parts.len()));
    Ok(())
}

/// What the parts will be rendered from, as far as the scene needn't be loaded for it.
fn inputs(job: &ExportJob) -> Result<Vec<PathBuf>, Failure> {
    let given = &job.inputs;
    let path = given.look.as_deref();
    let look = given.overrides.look(path)?;
    let environment = look.as_ref().and_then(environment);
    for file in [&job.scene].into_iter().chain(&environment) {
        input::open(file).map_err(|error| picture::unread(file, error))?;
    }
    let mut found = load::files(&job.scene, look.as_ref());
    found.extend(path.map(Path::to_owned));
    let folders = library::texture_dirs(&given.texture_dirs, path)?;
    found.extend(library::files(&folders));
    Ok(found)
}

/// The picture of all directions that a look names.
fn environment(look: &Look) -> Option<PathBuf> {
    match &look.environment.as_ref()?.value {
        EnvironmentLook::Image { image, .. } => Some(look.resolve(&image.value)),
        EnvironmentLook::Constant(_) | EnvironmentLook::Sky(_) => None,
    }
}

fn plan(job: &ExportJob) -> Result<Plan, Failure> {
    let absolute = |path: &Path| std::path::absolute(path).map_err(Failure::because);
    let folder = absolute(&job.folder)?;
    let film = |samples: &Range<u32>| {
        // Zeros in front, so that a listing is in order.
        let digits = job.spp.to_string().len();
        let named = |again: &str| {
            folder.join(format!(
                "{:0digits$}-{:0digits$}{again}.{FILM_EXTENSION}",
                samples.start, samples.end
            ))
        };
        let mut film = named("");
        // A file that is there has none of what is missing: it is damaged, or was ended early. A part of this name would be taken for done.
        let mut number = 1;
        while job.missing_only && film.exists() {
            film = match number {
                1 => named("-again"),
                _ => named(&format!("-again{number}")),
            };
            number += 1;
        }
        film
    };
    let mut films = Vec::new();
    let mut wanted = Samples::from([Range {
        start: 0,
        end: job.spp,
    }]);
    if job.missing_only {
        for (path, ranges) in films_in(&folder)? {
            let is_wanted = |range: &Range<u32>| {
                let is_in = |free: &Range<u32>| free.start <= range.start && range.end <= free.end;
                wanted.iter().any(is_in)
            };
            if !ranges.iter().all(is_wanted) {
                let text = format!(
                    "{} is left out: other films have samples of it",
                    path.display()
                );
                console::warning(&text);
                continue;
            }
            wanted = ranges
                .iter()
                .fold(wanted, |wanted, range| without(&wanted, range));
            films.push(path);
        }
    }
    let count = u32::try_from(wanted.len()).unwrap_or(u32::MAX);
    let each = (job.parts / count.max(1)).max(1);
    let ranges = wanted.iter().flat_map(|range| {
        let pieces = each.min(range.end - range.start);
        (1..=pieces).map(move |part| {
            let piece = part_of(range.end - range.start, part, pieces);
            range.start + piece.start..range.start + piece.end
        })
    });
    let part = |samples: Range<u32>| FarmPart {
        film: film(&samples),
        samples,
    };
    let parts: Vec<FarmPart> = ranges.map(part).collect();
    films.extend(parts.iter().map(|part| part.film.clone()));
    Ok(Plan {
        name: job
            .scene
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        scene: job.scene.clone(),
        here: std::env::current_dir().map_err(Failure::because)?,
        merge_flags: output::picture_flags(&job.flags),
        flags: job.flags.clone(),
        results: job
            .results
            .iter()
            .map(|path| absolute(path))
            .collect::<Result<_, _>>()?,
        folder,
        parts,
        films,
        spp: job.spp,
    })
}

/// The films in a folder, with the samples that they have. Those that were ended early are left out: their samples are rendered
/// again, unless other films have them.
fn films_in(folder: &Path) -> Result<Vec<(PathBuf, Samples)>, Failure> {
    let refused = |error: &dyn std::fmt::Display| {
        Failure::Failed(format!("cannot read {}: {error}", folder.display()))
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|error| refused(&error))? {
        let path = entry.map_err(|error| refused(&error))?.path();
        if path
            .extension()
            .is_none_or(|extension| extension != FILM_EXTENSION)
        {
            continue;
        }
        let read = || {
            let (file, length) = input::open(&path)?;
            Part::read(&mut BufReader::new(file), length)
        };
        match read() {
            Ok(part) if part.is_even() => found.push((path, part.ranges().to_vec())),
            Ok(_) => console::warning(&format!(
                "{} was ended early; it is left out",
                path.display()
            )),
            Err(error) => console::warning(&format!("{}: {error}; it is left out", path.display())),
        }
    }
    found.sort_by(|(a, _), (b, _)| a.cmp(b));
    Ok(found)
}

/// Ranges without what another one has.
fn without(ranges: &[Range<u32>], taken: &Range<u32>) -> Samples {
    let left = |range: &Range<u32>| {
        let before = range.start..range.end.min(taken.start);
        let behind = range.start.max(taken.end)..range.end;
        [before, behind]
    };
    let all = ranges.iter().flat_map(left);
    all.filter(|range| range.start < range.end).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(end: u32) -> Samples {
        Samples::from([Range { start: 0, end }])
    }

    #[test]
    fn what_is_taken_leaves_the_rest() {
        let cases: [(Samples, Range<u32>, Samples); 5] = [
            (whole(10), 3..5, vec![0..3, 5..10]),
            (vec![0..3, 5..10], 2..7, vec![0..2, 7..10]),
            (whole(3), 0..3, Vec::new()),
            (whole(3), 7..9, whole(3)),
            (
                vec![0..1, 4..10],
                0..4,
                Samples::from([Range { start: 4, end: 10 }]),
            ),
        ];
        for (ranges, taken, left) in cases {
            assert_eq!(
                without(&ranges, &taken),
                left,
                "{ranges:?} without {taken:?}"
            );
        }
    }
}
