//! Where Open Image Denoise lies on this machine, and what is told of its work. Opening and using it is the engine's business
//! ([`engine::denoise`]).

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

use engine::denoise::{DenoiseError, Denoiser, FILE};
use engine::film::write::Content;

use crate::console;
use crate::failure::Failure;
use crate::progress::Bar;
use crate::words::Outputs;

/// Folders of an installation that may hold the library.
const PLACES: [&str; 4] = ["lib", "lib64", "bin", ""];
/// Where the Python package keeps its installation, below the folder of packages.
const WHEEL: &str = "pyoidn/oidn";
/// What to do where there is none.
const REMEDY: &str = "`pip install pyoidn==2.5.1` installs it where it is found beside the `python3` of PATH; or unpack a release \
     of https://github.com/RenderKit/oidn/releases, and let OIDN_DIR name that folder";

/// A picture without its noise.
pub(crate) struct Denoised {
    /// Linear radiance, pixel by pixel.
    pub(crate) picture: Vec<[f32; 3]>,
    /// What has done it.
    pub(crate) by: String,
}

/// What a job is denoised by: nothing where it isn't wanted, or where no picture is written. Called before any work is done.
///
/// # Errors
/// The library isn't found, or can't be opened; the text says how to get it.
pub(crate) fn for_job(is_wanted: bool, outputs: &Outputs) -> Result<Option<Denoiser>, Failure> {
    match is_wanted && !outputs.pictures.is_empty() {
        true => match open() {
            Ok(denoiser) => Ok(Some(denoiser)),
            Err(why) => Err(Failure::Failed(format!("--denoise: {why}"))),
        },
        false => Ok(None),
    }
}

/// Denoises what files of a film show, and says how long that took.
///
/// # Errors
/// The library gives up.
pub(crate) fn film(denoiser: &Denoiser, content: &Content<'_>) -> Result<Denoised, DenoiseError> {
    if !Denoiser::has_guides(content.film) {
        console::warning(
            "the film has no layers albedo and normal, so that fine detail is blurred with the noise: render it with --denoise, or \
             with --layers albedo,normal",
        );
    }
    let bar = Bar::new("taking the noise out");
    let clock = Instant::now();
    let picture = denoiser.film(content);
    bar.finish();
    let by = denoiser.title();
    let picture = picture?;
    let seconds = clock.elapsed().as_secs_f64();
    console::note(&format!("denoised in {seconds:.1} s by {by}"));
    Ok(Denoised { picture, by })
}

/// Finds the library and opens it.
///
/// # Errors
/// It isn't found, or can't be opened; the text says how to get it.
pub(crate) fn open() -> Result<Denoiser, String> {
    let home = env::var_os("HOME").map(PathBuf::from);
    let python = env::var_os("PATH").and_then(|path| prefix_of_python(&path));
    let (places, is_named) = match env::var_os("OIDN_DIR").filter(|folder| !folder.is_empty()) {
        Some(folder) => (installed(Path::new(&folder)), true),
        None => (wheels(python.as_deref(), home.as_deref()), false),
    };
    let mut found: Vec<PathBuf> = places.into_iter().filter(|path| path.is_file()).collect();
    if is_named && found.is_empty() {
        let folder = env::var_os("OIDN_DIR").unwrap_or_default();
        return Err(format!(
            "OIDN_DIR={} has no {FILE}, nor has its folder lib; {REMEDY}",
            folder.display()
        ));
    }
    if !is_named {
        // The system knows where.
        found.push(PathBuf::from(FILE));
    }
    let mut refused = Vec::new();
    for path in &found {
        match Denoiser::open(path) {
            Ok(denoiser) => return Ok(denoiser),
            Err(error) => refused.push(error.to_string()),
        }
    }
    let refused = refused.join("\n");
    Err(format!(
        "Open Image Denoise 2 is needed: {refused}\n{REMEDY}"
    ))
}

/// Where an installation may have the library.
fn installed(folder: &Path) -> Vec<PathBuf> {
    let places = PLACES.iter();
    places.map(|place| folder.join(place).join(FILE)).collect()
}

/// Where the Python package may have it: among the packages of that Python, of all users, and of this one.
fn wheels(python: Option<&Path>, home: Option<&Path>) -> Vec<PathBuf> {
    let Some(python) = python else {
        return Vec::new();
    };
    let local = python.join("local");
    let own = home.map(|home| home.join(".local"));
    let prefixes = [Some(python), Some(&local), own.as_deref()];
    let packages = prefixes.into_iter().flatten().flat_map(packages_of);
    packages
        .flat_map(|packages| installed(&packages.join(WHEEL)))
        .collect()
}

/// The folders of packages below a prefix: `lib/python3.12/site-packages`, on Debian `dist-packages`, on Windows without the version.
fn packages_of(prefix: &Path) -> Vec<PathBuf> {
    let lib = prefix.join("lib");
    let entries = std::fs::read_dir(&lib).into_iter().flatten().flatten();
    let mut versions: Vec<PathBuf> = entries
        .filter(|entry| {
            let name = entry.file_name();
            name.to_string_lossy().starts_with("python3")
        })
        .map(|entry| entry.path())
        .collect();
    // The same ones each time.
    versions.sort();
    versions.push(lib);
    let kinds = ["site-packages", "dist-packages"];
    let folders = versions
        .iter()
        .flat_map(|version| kinds.map(|kind| version.join(kind)));
    folders.filter(|folder| folder.is_dir()).collect()
}

/// The folder in which the first Python of a search path is installed: for a virtual environment its own.
fn prefix_of_python(path: &OsStr) -> Option<PathBuf> {
    let program = match cfg!(windows) {
        true => "python.exe",
        false => "python3",
    };
    let mut folders = env::split_paths(path);
    let folder = folders.find(|folder| folder.join(program).is_file())?;
    let is_below = ["bin", "Scripts"].iter().any(|name| folder.ends_with(name));
    match is_below {
        true => folder.parent().map(Path::to_owned),
        false => Some(folder),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn the_package_is_found_beside_the_python_that_is_found_first() {
        let root = tempfile::tempdir().expect("a folder");
        let at = |place: &str| root.path().join(place);
        for folder in [
            "empty",
            "venv/bin",
            "venv/lib/python3.11/site-packages/pyoidn/oidn/lib",
            "usr/bin",
            "home/.local/lib/python3.9/site-packages/pyoidn/oidn/lib",
        ] {
            fs::create_dir_all(at(folder)).expect("a folder");
        }
        let program = match cfg!(windows) {
            true => "python.exe",
            false => "python3",
        };
        for folder in ["venv/bin", "usr/bin"] {
            fs::write(at(folder).join(program), "").expect("written");
        }
        let prefix = |folders: &[&str]| {
            let path = env::join_paths(folders.iter().map(|f| at(f))).expect("a path");
            prefix_of_python(&path)
        };
        assert_eq!(prefix(&["empty"]), None);
        assert_eq!(prefix(&["usr/bin", "venv/bin"]), Some(at("usr")));
        let venv = prefix(&["empty", "venv/bin", "usr/bin"]);
        assert_eq!(venv, Some(at("venv")));
        let package = "lib/python3.11/site-packages/pyoidn/oidn/lib";
        let library = at("venv").join(package).join(FILE);
        let own = at("home/.local/lib/python3.9/site-packages/pyoidn/oidn/lib").join(FILE);
        let places = wheels(venv.as_deref(), Some(&at("home")));
        let place = |path| places.iter().position(|place| place == path);
        assert!(place(&library).expect("there") < place(&own).expect("there"));
        assert!(wheels(None, Some(&at("home"))).is_empty());
    }
}
