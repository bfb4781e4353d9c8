//! The session's files: the look is saved to its own, and all are followed when others change them.

use std::path::{Path, PathBuf};

use texgen::{Diagnostic, Diagnostics};

use crate::film::Origin;
use crate::fingerprint;
use crate::load;
use crate::procedural::{SourcesError, TextureSources};
use crate::scene::look::Look;

use super::{Inputs, Session, SessionError, parse_look};

impl Session {
    /// Whether there are edits that have not been saved.
    pub fn has_unsaved_edits(&self) -> bool {
        self.document.text() != self.saved
    }

    /// Saves the look to its file, or to `path`: comments, order and formatting of what was not edited are kept.
    ///
    /// # Errors
    /// There is no file, or the system refuses; the look's own file was changed by others and isn't the look as it is known.
    /// An old file is untouched then. With a `path`, whatever is there is replaced.
    pub fn save(&mut self, path: Option<&Path>) -> Result<(), SessionError> {
        let own = self.inputs.look.as_deref();
        if let (None, Some(own)) = (path, own)
            && Look::read_text(&*self.system.files, own).is_ok_and(|text| text != self.saved)
        {
            let path = own.to_owned();
            return Err(SessionError::Changed { path });
        }
        let path = path.or(own);
        let path = path.ok_or(SessionError::NoFile)?.to_owned();
        let text = self.document.text();
        match self.system.files.write(&path, text.as_bytes()) {
            Ok(()) => {
                self.saved = text;
                Ok(())
            }
            Err(source) => Err(SessionError::Save { path, source }),
        }
    }

    /// Saves the look to another file, which is its file from then on. In another folder the look is read anew, because
    /// what it names is searched from there.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub fn save_as(&mut self, path: &Path) -> Result<(), SessionError> {
        self.save(Some(path))?;
        let folder = |path: &Path| path.parent().map(Path::to_owned);
        let is_elsewhere = self.inputs.look.as_deref().map(folder) != Some(folder(path));
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
        let Inputs { scene, look, .. } = &self.inputs;
        let mut origin =
            fingerprint::origin(self.device(), self.settings(), scene, look.as_deref());
        origin.names = self.settings().layers.names(self.scene());
        origin
    }

    /// The look's file may have changed. Its text replaces that of the look, edits that were not saved included.
    pub fn look_changed(&mut self) {
        let Some(path) = self.inputs.look.clone() else {
            return;
        };
        let text = match Look::read_text(&*self.system.files, &path) {
            Ok(text) => text,
            Err(error) => {
                self.problems.file = Diagnostic::error(error.to_string()).into();
                return;
            }
        };
        if text == self.saved && self.shown.is_none() && !self.has_unsaved_edits() {
            self.problems.file = Diagnostics::new();
            return;
        }
        let checked = Look::parse(&path, &text);
        match (checked, parse_look(&self.inputs, &text)) {
            (Ok(_), Ok(document)) => {
                self.problems.file = Diagnostics::new();
                self.saved = text;
                self.want(document);
            }
            (Err(problems), _) | (_, Err(problems)) => self.problems.file = problems,
        }
    }

    /// Scene or images may have changed: all is read again in the background.
    pub fn assets_changed(&mut self) {
        self.rebuild();
    }
}
