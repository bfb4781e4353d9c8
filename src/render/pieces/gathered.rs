//! What there is of a picture in pieces: on the disk their samples, in memory what these say of the whole. It is put together from there.

use std::ops::Range;

use engine::film::write::{self, Banded, Extents, Format, Metadata};
use engine::film::{Film, Origin, Part, Tally};
use engine::scene::view::View;

use crate::console;
use crate::failure::Failure;
use crate::job::RenderJob;
use crate::output::OutputError;
use crate::words::Output;

use super::division::{Division, Piece};
use super::store::Store;

/// A picture in pieces.
pub(in crate::render) struct Pieces {
    division: Division,
    tally: Tally,
    extents: Extents,
    /// Pieces that aren't there.
    missing: u32,
    store: Store,
}

impl Pieces {
    /// None yet.
    pub(super) fn new(division: Division, store: Store) -> Self {
        Self {
            division,
            tally: Tally::default(),
            extents: Extents::default(),
            missing: 0,
            store,
        }
    }

    /// How the picture is divided.
    pub(super) fn division(&self) -> Division {
        self.division
    }

    /// Forgets all that are there, to begin anew.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn begin_anew(&mut self) -> Result<(), Failure> {
        self.store.clear()?;
        (self.tally, self.extents) = (Tally::default(), Extents::default());
        Ok(())
    }

    /// Where they lie.
    pub(super) fn store(&self) -> &Store {
        &self.store
    }

    /// What the samples of all pieces say.
    pub(in crate::render) fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Counts a piece in.
    pub(super) fn add(&mut self, job: &RenderJob, film: &Film) {
        self.tally.add(&Tally::of(film));
        let is_exr = |output: &Output| output.format == Format::Exr;
        if job.outputs.pictures.iter().any(is_exr) {
            let (layers, form) = (&job.shown_layers, &job.form);
            self.extents.add(film, layers, job.transparent, form);
        }
    }

    /// Counts in a piece that won't be there.
    pub(super) fn misses(&mut self, piece: &Piece) {
        self.missing += 1;
        self.tally
            .add(&Tally::of(&Film::new(piece.width, piece.rows)));
    }

    /// Puts a piece on the disk.
    pub(super) fn keep(
        &self,
        piece: &Piece,
        film: Film,
        samples: Range<u32>,
        origin: Origin,
    ) -> Result<(), Failure> {
        self.store.write(piece, &Part::new(film, samples, origin))
    }

    /// Writes the files. Pieces that aren't there are black.
    ///
    /// # Errors
    /// What could not be written; the pieces stay then.
    pub(in crate::render) fn write(
        mut self,
        job: &RenderJob,
        origin: &Origin,
        view: &View,
    ) -> Result<(), Failure> {
        let count = self.division.count();
        if self.missing > 0 {
            let text = format!(
                "{} of {count} pieces are missing: they are black",
                self.missing
            );
            console::warning(&text);
        }
        let size = [job.width, job.height];
        let (fewest, _) = self.tally.sample_bounds();
        let metadata = Metadata::of(size, fewest, origin);
        let banded = Banded {
            size,
            layers: &job.shown_layers,
            transparent: job.transparent,
            form: &job.form,
            extents: &self.extents,
        };
        let mut failed = Vec::new();
        for output in &job.outputs.pictures {
            let bands = self.division.pieces().map(|piece| {
                let film = self.store.film(&piece)?;
                let black = || Film::with_layers(piece.width, piece.rows, job.layers.clone());
                Ok(film.unwrap_or_else(black))
            });
            let (path, format) = (&output.path, output.format);
            match write::save_bands(path, format, &banded, bands, &metadata, view) {
                Ok(()) => console::note(&format!("wrote {}", path.display())),
                Err(error) => failed.push(OutputError::new(path, error).to_string()),
            }
        }
        if failed.is_empty() {
            if self.missing == 0 {
                self.store.remove();
            }
            return Ok(());
        }
        self.store.keep();
        Err(Failure::Failed(format!(
            "{}\nthe {count} pieces are kept; the same command with --resume writes what is missing",
            failed.join("\n")
        )))
    }
}
