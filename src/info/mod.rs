//! `patina info`: what a file holds, for people and as JSON. One file per kind of file; what kind one is, is decided here, by its
//! contents where they say it.

mod animation;
pub(crate) mod args;
mod film;
pub(crate) mod job;
mod look;
mod picture;
mod scene;
mod table;

use std::path::Path;

use engine::scene::import;
use serde::Serialize;

use crate::failure::Failure;
use crate::{console, library};

use film::FilmInfo;
use job::InfoJob;
use look::LookInfo;
use picture::PictureInfo;
use scene::SceneInfo;

/// What is told of a file. Its JSON form is read by other programs: fields are added, never renamed.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Info {
    Scene(Box<SceneInfo>),
    Look(LookInfo),
    Film(FilmInfo),
    Picture(PictureInfo),
}

/// Tells what a file holds.
///
/// # Errors
/// It can't be read, is of no kind that is known, or is damaged.
pub(crate) fn run(job: &InfoJob) -> Result<(), Failure> {
    let info = of(job)?;
    let text = match (&info, job.json) {
        (info, true) => serde_json::to_string_pretty(info).map_err(Failure::because)?,
        (Info::Scene(info), _) => info.text(),
        (Info::Look(info), _) => info.text(),
        (Info::Film(info), _) => info.text(),
        (Info::Picture(info), _) => info.text(),
    };
    console::print(&text);
    Ok(())
}

fn of(job: &InfoJob) -> Result<Info, Failure> {
    let file = job.file.as_path();
    let other = match is_look(file) {
        true => Info::Look(LookInfo::read(file)?),
        false if crate::picture::is_film(file)? => Info::Film(FilmInfo::read(file)?),
        false if picture::is_picture(file)? => Info::Picture(PictureInfo::read(file)?),
        false => {
            let look = job.look.as_deref();
            let textures = library::texture_dirs(&job.texture_dirs, look)?;
            let info = SceneInfo::read(file, look, &textures);
            let info = info.map_err(|failure| of_no_kind(file, failure))?;
            return Ok(Info::Scene(Box::new(info)));
        }
    };
    match &job.look {
        None => Ok(other),
        Some(look) => Err(Failure::Failed(format!(
            "--look {}: {} is no scene; leave the flag out",
            look.display(),
            file.display()
        ))),
    }
}

/// Why a file isn't read as a scene, with what it might be where its name doesn't say that it is one.
fn of_no_kind(file: &Path, failure: Failure) -> Failure {
    match failure {
        Failure::Failed(why) if !import::is_scene(file) => Failure::Failed(format!(
            "{} is none of what `patina info` reads: {}, a look (.toml), a partial render (.patina-film) or a picture (.exr, .png, .jpg, \
             .hdr); read as a scene: {why}",
            file.display(),
            import::known_formats()
        )),
        other => other,
    }
}

fn is_look(file: &Path) -> bool {
    let ending = file.extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}
