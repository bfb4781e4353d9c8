//! The session's files: the look is saved to its own, and all are followed when others change them.

use std::io;
use std::path::{Path, PathBuf};

use texgen::{Diagnostic, Diagnostics};

use crate::film::Origin;
use crate::fingerprint;
use crate::load;
use crate::procedural::{SourcesError, TextureSources};
use crate::renderer::RenderSettings;
use crate::scene::look::{Look, LookDocument, LookError};

use super::edit::summary;
use super::moved::moved;
use super::{Inputs, Session, SessionError, parse_look};

impl Session {
    /// Whether there are edits that have not been saved, or there is no file any more that has the look.
    pub fn has_unsaved_edits(&self) -> bool {
        self.is_gone || self.document.text() != self.saved
    }

    /// The look's text as its file had it when that was read or written last.
    pub fn saved_text(&self) -> &str {
        &self.saved
    }

    /// Saves the look to its file, or to `path`: comments, order and formatting of what was not edited are kept.
    ///
    /// # Errors
    /// There is no file, or the system refuses; the look's own file was changed by others and isn't the look as it is known, or may only
    /// be read. An old file is untouched then. With a `path`, whatever is there is replaced.
    pub fn save(&mut self, path: Option<&Path>) -> Result<(), SessionError> {
        let own = self.inputs.look.as_deref();
        if let (None, Some(own)) = (path, own) {
            let files = &*self.system.files;
            // What can't be read isn't what is known, either.
            let is_known = || Look::read_text(files, own).is_ok_and(|text| text == self.saved);
            let path = own.to_owned();
            if files.has(own) && !is_known() {
                return Err(SessionError::Changed { path });
            }
            if files.is_read_only(own) {
                return Err(SessionError::ReadOnly { path });
            }
        }
        let path = path.or(own);
        let path = path.ok_or(SessionError::NoFile)?.to_owned();
        let text = self.document.text();
        match self.system.files.write(&path, text.as_bytes()) {
            Ok(()) => {
                self.saved = text;
                self.is_gone = false;
                Ok(())
            }
            Err(source) => Err(SessionError::Save { path, source }),
        }
    }

    /// Saves the look to another file, which is its file from then on. In another folder the look names images, documents and what it
    /// includes from there, so that they are the same files; it is read anew, since textures are searched from there, too.
    ///
    /// # Errors
    /// As [`Self::save`]; the look is as before then.
    pub fn save_as(&mut self, path: &Path) -> Result<(), SessionError> {
        let folder = |path: &Path| path.parent().map(Path::to_owned);
        let former = self.inputs.look.as_deref().map(folder);
        let is_elsewhere = former != Some(folder(path));
        // A look without a file lies where the program was started.
        let [from, to] = [former.flatten(), folder(path)].map(Option::unwrap_or_default);
        let text = self.document.text();
        let moved = moved(&*self.system.files, &text, [&from, &to]);
        let kept = match moved == text {
            true => None,
            false => {
                let document = parse_look(&self.inputs, &moved);
                let document = document.map_err(|p| SessionError::Refused(summary(&p)))?;
                Some(std::mem::replace(&mut self.document, document))
            }
        };
        if let Err(error) = self.save(Some(path)) {
            if let Some(kept) = kept {
                self.document = kept;
            }
            return Err(error);
        }
        self.inputs.look = Some(path.to_owned());
        if is_elsewhere {
            self.rebuild();
        }
        Ok(())
    }

    /// Searches textures in this folder, too, before the others.
    pub fn add_textures(&mut self, folder: PathBuf) {
        if !self.inputs.textures.contains(&folder) {
            self.inputs.textures.insert(0, folder);
            self.sources_changed();
        }
    }

    /// The textures that the look may use, as there are now.
    ///
    /// # Errors
    /// A folder can't be listed.
    pub fn textures(&self) -> Result<TextureSources, SourcesError> {
        let files = self.system.files.clone();
        TextureSources::search_from(files, &self.inputs.textures)
    }

    /// The files to be watched: scene, look, images. Those of textures lie in [`Inputs::textures`].
    pub fn files(&self) -> Vec<PathBuf> {
        let path = self.look_path();
        let look = Look::parse(&path, &self.document.text()).ok();
        let mut files = load::files_from(&*self.system.files, &self.inputs.scene, look.as_ref());
        files.extend(self.inputs.look.clone());
        files
    }

    /// What is rendered.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Where the picture comes from, for the headers of its files.
    pub fn origin(&self) -> Origin {
        self.origin_of(self.settings())
    }

    /// The same of a picture that [`Session::renderer_of`] renders.
    pub fn origin_of(&self, settings: &RenderSettings) -> Origin {
        let Inputs { scene, look, .. } = &self.inputs;
        let mut origin = fingerprint::origin(self.device(), settings, scene, look.as_deref());
        origin.names = settings.layers.names(self.scene());
        origin
    }

    /// The look's file may have changed. Its text replaces that of the look, edits that were not saved included.
    pub fn look_changed(&mut self) {
        let Some((text, document)) = self.read_look() else {
            return;
        };
        if text == self.saved && self.shown.is_none() && !self.has_unsaved_edits() {
            return;
        }
        self.saved = text;
        self.want(document);
    }

    /// The look's file may have changed while there are edits that are not saved: they stay, and so does the picture. Its text, where
    /// it is a look, counts as [saved](Self::saved_text) from now on: whoever has the edits brings both together ([`super::merge`]).
    pub fn look_changed_beside_edits(&mut self) {
        if let Some((text, _)) = self.read_look() {
            self.saved = text;
        }
    }

    /// The look's file as it is now; what is wrong with it is one of the problems.
    fn read_look(&mut self) -> Option<(String, LookDocument)> {
        let path = self.inputs.look.clone()?;
        let read = Look::read_text(&*self.system.files, &path);
        self.is_gone = read.as_ref().is_err_and(is_not_there);
        let read = read.map_err(|error| Diagnostic::error(error.to_string()).into());
        let parsed = read.and_then(|text| {
            Look::parse(&path, &text)?;
            let document = parse_look(&self.inputs, &text)?;
            Ok((text, document))
        });
        match parsed {
            Ok(parsed) => {
                self.problems.file = Diagnostics::new();
                Some(parsed)
            }
            Err(problems) => {
                self.problems.file = problems;
                None
            }
        }
    }
}

/// Whether there is no file.
fn is_not_there(error: &LookError) -> bool {
    match error {
        LookError::Read { source, .. } => source.kind() == io::ErrorKind::NotFound,
        LookError::Invalid(_) => false,
    }
}
