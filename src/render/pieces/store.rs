//! The pieces of a picture that are done, as films in a folder beside it. The folder is gone once the picture is written; where a render
//! ends before, it stays if the render is to be gone on with.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use engine::aside::Leftover;
use engine::film::{Film, Origin, Part, PartError};

use crate::failure::Failure;
use crate::job::RenderJob;
use crate::output;
use crate::picture;
use crate::words::FILM_EXTENSION;

use crate::render::checkpoint;

use super::division::{Division, Piece};

/// What the folder of `room.exr` is called: `room.patina-pieces`.
const EXTENSION: &str = "patina-pieces";

/// The file in it that a run holds locked, and that is gone with it.
const LOCK: &str = "lock";

/// The pieces of one picture.
#[derive(Debug)]
pub(super) struct Store {
    folder: PathBuf,
    /// Pieces of a former run are taken up.
    resumes: bool,
    /// Whether they outlive a run that doesn't write the picture.
    stays: bool,
    /// The folder is gone with a program that is ended from outside: as long as no piece is in it that is to stay.
    leftover: Mutex<Option<Leftover>>,
    /// So is the file that is locked.
    _leftover_lock: Leftover,
    /// Open, and so locked, as long as this is there: the pieces of two runs would mix.
    _lock: File,
}

impl Store {
    /// How a former run has divided the picture, by its first piece; `None` where there is none.
    ///
    /// # Errors
    /// It can't be read.
    pub(super) fn division(job: &RenderJob) -> Result<Option<Division>, Failure> {
        let path = file(&folder(job), 0);
        if !path.exists() {
            return Ok(None);
        }
        let part = picture::film(&path).map_err(|error| refused(&path, &error))?;
        let size = [job.width, job.height];
        Ok(Some(Division::new(size, part.film.height)))
    }

    /// Makes the folder. What a former run has left there is removed, unless it is gone on with.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn open(job: &RenderJob) -> Result<Self, Failure> {
        let folder = folder(job);
        let refused = |error: io::Error| {
            let text = format!("cannot keep pieces in {}: {error}", folder.display());
            Failure::Failed(text)
        };
        let resumes = (job.checkpoints.as_ref()).is_some_and(|checkpoints| checkpoints.resumes);
        let stays = job.checkpoints.is_some();
        let mut leftover = None;
        match fs::create_dir(&folder) {
            Ok(()) => leftover = Some(Leftover::new(folder.clone())),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && folder.is_dir() => {}
            Err(error) => return Err(refused(error)),
        }
        let folder_lock = folder.join(LOCK);
        let lock = File::create(&folder_lock).map_err(refused)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Failure::Failed(format!(
                    "another render keeps its pieces in {}; wait for its end, or write to a file of another name",
                    folder.display()
                )));
            }
            // Some file systems know no locks.
            Err(TryLockError::Error(_)) => {}
        }
        if !resumes {
            clear(&folder).map_err(refused)?;
        }
        Ok(Self {
            folder,
            resumes,
            stays,
            leftover: Mutex::new(leftover),
            _leftover_lock: Leftover::new(folder_lock),
            _lock: lock,
        })
    }

    /// A piece of a former run that is gone on with, where it is there.
    ///
    /// # Errors
    /// It can't be read, or is one of something else.
    pub(super) fn former(&self, piece: &Piece, origin: &Origin) -> Result<Option<Film>, Failure> {
        let path = file(&self.folder, piece.number);
        if !self.resumes || !path.exists() {
            return Ok(None);
        }
        let part = picture::film(&path).map_err(|error| refused(&path, &error))?;
        (origin.fits(&part.origin))
            .map_err(|error| refused(&path, &checkpoint::differing(error)))?;
        Ok(Some(part.film))
    }

    /// How often the picture had begun anew with finer records, as the first piece of a former run that is gone on with says.
    ///
    /// # Errors
    /// It can't be read.
    pub(super) fn refined(&self, division: &Division) -> Result<u32, Failure> {
        let paths = division
            .pieces()
            .map(|piece| file(&self.folder, piece.number));
        let Some(path) = paths.filter(|_| self.resumes).find(|path| path.exists()) else {
            return Ok(0);
        };
        let part = picture::film(&path).map_err(|error| refused(&path, &error))?;
        Ok(checkpoint::told_refined(&part.origin))
    }

    /// Removes all pieces.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn clear(&self) -> Result<(), Failure> {
        clear(&self.folder).map_err(|error| {
            let text = format!("cannot remove pieces in {}: {error}", self.folder.display());
            Failure::Failed(text)
        })
    }

    /// A piece of this run, or of a former one that was read by it; `None` where there is none.
    ///
    /// # Errors
    /// It can't be read any more.
    pub(super) fn film(&self, piece: &Piece) -> io::Result<Option<Film>> {
        let path = file(&self.folder, piece.number);
        match picture::film(&path) {
            Ok(part) => Ok(Some(part.film)),
            Err(PartError::Io(error)) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => {
                let text = format!("the piece {}: {error}", path.display());
                Err(io::Error::other(text))
            }
        }
    }

    /// Keeps a piece that is done.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn write(&self, piece: &Piece, part: &Part) -> Result<(), Failure> {
        if self.stays {
            self.let_folder_stay();
        }
        let path = file(&self.folder, piece.number);
        output::write_aside(&path, |file| part.write(file)).map_err(Failure::because)
    }

    /// Lets the pieces outlive the run, whatever was said.
    pub(super) fn keep(&mut self) {
        self.stays = true;
        self.let_folder_stay();
    }

    /// Has the folder outlive a program that is ended from outside.
    fn let_folder_stay(&self) {
        let mut leftover = self.leftover.lock().unwrap_or_else(PoisonError::into_inner);
        *leftover = None;
    }

    /// The picture is written: the pieces aren't needed any more.
    pub(super) fn remove(mut self) {
        self.stays = false;
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        // What can't be removed is in nobody's way.
        let _ = fs::remove_file(self.folder.join(LOCK));
        if !self.stays {
            let _ = clear(&self.folder);
        }
        // Where pieces stay it isn't empty, and so it stays with them.
        let _ = fs::remove_dir(&self.folder);
    }
}

fn folder(job: &RenderJob) -> PathBuf {
    job.outputs.checkpoint().with_extension(EXTENSION)
}

fn file(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("{number:05}.{FILM_EXTENSION}"))
}

/// Removes pieces, and nothing else.
fn clear(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let is_number = stem.len() == 5 && stem.bytes().all(|b| b.is_ascii_digit());
        if is_number && path.extension().is_some_and(|e| e == FILM_EXTENSION) {
            fs::remove_file(path)?;
        }
    }
    Ok(())
}

fn refused(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    let remedy = "render with the same settings, or without --resume to begin anew";
    Failure::Failed(format!(
        "cannot resume {}: {error}; {remedy}",
        path.display()
    ))
}
