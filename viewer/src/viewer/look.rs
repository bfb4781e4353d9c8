//! The look that is edited: its document with the history, and the panel that shows it.

use std::path::Path;
use std::sync::Arc;

use egui::Ui;
use engine::scene::{Material, PunctualLight};
use engine::session::{Document, Edit, Merged, merge, summary};
use patina_panels::{FileDialogs, Form, ModelImage, Previews, SceneView, Textures, TexturesPanel};

use crate::link::{Command, Hit, Link, LookFacts};
use crate::navigate::Navigator;

use super::{Preferences, Viewer};

/// What edits the look. Its document is ahead of the render's by the changes that are on their way.
#[derive(Debug, Default)]
pub(super) struct Editor {
    document: Option<Document>,
    panel: TexturesPanel,
    textures: Arc<Textures>,
    materials: Arc<Vec<Material>>,
    own_materials: usize,
    has_stand_in_light: bool,
    images: Arc<[ModelImage]>,
    lights: Arc<[PunctualLight]>,
    /// Changes that have been sent.
    sent: u64,
    /// The file's text, as far as the document knows it.
    saved: Arc<str>,
    /// How often that came from another program.
    outside: u64,
    /// The files have been opened once more: what the look is now is a step of its history.
    is_reopened: bool,
    /// What was brought together last, and has not become the look.
    tried: Option<Tried>,
}

/// Two texts that were brought together.
#[derive(Debug)]
struct Tried {
    mine: String,
    theirs: Arc<str>,
}

/// What became of a text that another program has written to the look's file.
#[derive(Debug)]
pub(super) enum Outside {
    /// It is here, together with edits that are not saved.
    Together,
    /// Both sides have changed the same.
    Conflict(Merged),
    /// Nothing that wasn't said before: what is asked goes on being asked.
    AsBefore,
}

impl Editor {
    /// Takes over what the render has: its first text, and texts that files have brought.
    pub(super) fn read(&mut self, facts: &LookFacts, path: &Path) -> Option<Outside> {
        self.textures = Arc::clone(&facts.textures);
        self.materials = Arc::clone(&facts.materials);
        self.own_materials = facts.own_materials;
        self.has_stand_in_light = facts.has_stand_in_light;
        self.lights = Arc::clone(&facts.lights);
        self.images = Arc::clone(&facts.images);
        let Some(document) = &mut self.document else {
            self.document = Document::new(path, &facts.text).ok();
            self.take_saved(facts);
            return None;
        };
        if document.path() != path {
            if document.move_to(path) {
                // They name files from where the look was.
                self.panel.forget_snapshots();
            }
            // The render has moved its own text. What it is yet to hear of was said of the former place, and is said once more.
            if facts.heard == self.sent {
                document.take_changes();
            }
        }
        if std::mem::take(&mut self.is_reopened) {
            match document.replace("opened again", &facts.text) {
                // The render has it already.
                Ok(()) => drop(document.take_changes()),
                Err(_) => self.document = Document::new(path, &facts.text).ok(),
            }
            self.sent = facts.heard;
            self.take_saved(facts);
            return None;
        }
        if facts.outside != self.outside {
            return self.read_outside(facts);
        }
        let is_other = facts.heard == self.sent && *facts.text != *document.text();
        if is_other && document.replace("file", &facts.text).is_ok() {
            // The render has it already.
            document.take_changes();
        }
        self.take_saved(facts);
        None
    }

    /// How often the file's text came from another program, as far as the document knows it.
    pub(super) fn outside(&self) -> u64 {
        self.outside
    }

    fn take_saved(&mut self, facts: &LookFacts) {
        self.saved = Arc::clone(&facts.saved);
        self.outside = facts.outside;
        self.tried = None;
    }

    /// Another program has written to the file.
    fn read_outside(&mut self, facts: &LookFacts) -> Option<Outside> {
        let document = self.document.as_ref()?;
        // Until somebody has answered nothing becomes of it, frame by frame.
        let is_tried =
            |tried: &Tried| *tried.mine == *document.text() && *tried.theirs == *facts.saved;
        if self.tried.as_ref().is_some_and(is_tried) {
            return Some(Outside::AsBefore);
        }
        let was_saved = *document.text() == *self.saved;
        let mine = document.text().to_owned();
        self.tried = Some(Tried {
            mine: mine.clone(),
            theirs: Arc::clone(&facts.saved),
        });
        let merged = merge(document.path(), &self.saved, &mine, &facts.saved);
        match merged {
            Ok(merged) if merged.conflicts.is_empty() => {
                let taken = self.take_outside(facts, &merged.text);
                match taken {
                    Ok(()) => (!was_saved).then_some(Outside::Together),
                    // To save would take the other program's text away: that has to be asked about.
                    Err(why) => Some(Outside::Conflict(Merged {
                        text: mine,
                        theirs_first: merged.text,
                        conflicts: vec![why],
                    })),
                }
            }
            Ok(merged) => Some(Outside::Conflict(merged)),
            // What is no look has not become the saved text.
            Err(_) => None,
        }
    }

    /// Goes on with what has become of the own text and of another program's.
    ///
    /// # Errors
    /// It can't: says why. What the other program has written counts as unknown then.
    pub(super) fn take_outside(&mut self, facts: &LookFacts, text: &str) -> Result<(), String> {
        if let Some(document) = &mut self.document {
            let replaced = document.replace_by_others("change of the file", text);
            replaced.map_err(|problems| summary(&problems))?;
            if *facts.text == *text {
                // The render has it already.
                document.take_changes();
            }
        }
        self.take_saved(facts);
        Ok(())
    }

    /// The scene as it is known without its camera.
    fn scene(&self) -> SceneView<'_> {
        SceneView {
            materials: &self.materials,
            own: self.own_materials,
            images: &self.images,
            lights: &self.lights,
            camera: None,
        }
    }

    /// Whether the picture is seen in a light that nobody asked for.
    pub(super) fn has_stand_in_light(&self) -> bool {
        let look = self.document.as_ref().map(Document::look);
        self.has_stand_in_light && look.is_some_and(|look| look.environment.is_none())
    }

    /// Whether the materials are shown as a graph.
    pub(super) fn shows_graph(&self) -> bool {
        self.panel.form() == Form::Graph
    }

    /// Whether the graph has a panel of its own.
    pub(super) fn graph_is_below(&self) -> bool {
        self.panel.form() == Form::Both && self.document.is_some()
    }

    /// Whether the file lacks an edit.
    pub(super) fn has_unsaved_edits(&self) -> bool {
        let document = self.document.as_ref();
        document.is_some_and(|document| *document.text() != *self.saved)
    }

    /// Has fields of files ask that system from now on.
    pub(super) fn set_file_dialogs(&mut self, system: Arc<dyn FileDialogs>) {
        self.panel.set_file_dialogs(system);
    }

    /// Forgets the look. The panel stays, with its previews.
    pub(super) fn forget(&mut self) {
        self.document = None;
        self.sent = 0;
        self.tried = None;
    }

    /// The same files are shown from now on, as they have been read once more. Edits are kept to be undone and done again.
    pub(super) fn reopen(&mut self) {
        self.is_reopened = true;
    }

    /// Tells the render what has changed.
    fn flush(&mut self, link: &Link) {
        let Some(document) = &mut self.document else {
            return;
        };
        for change in document.take_changes() {
            self.sent += 1;
            link.send(Command::Change(change, self.sent));
        }
    }
}

impl Viewer {
    /// The look with its history, once it has been read.
    pub fn document_mut(&mut self) -> Option<&mut Document> {
        self.editor.document.as_mut()
    }

    /// Makes edits as one step that can be undone; whether the look took them. Why it didn't is told.
    pub(super) fn edit(&mut self, label: &str, edits: &[Edit], now: f64) -> bool {
        let outcome = match self.document_mut() {
            Some(document) => document.apply(label, edits, None),
            None => Err("there is no look yet".to_owned()),
        };
        let is_made = outcome.is_ok();
        if let Err(why) = outcome {
            self.tell(why, true, now);
        }
        is_made
    }

    pub(super) fn undo(&mut self) {
        if let Some(document) = self.document_mut() {
            document.undo();
        }
    }

    pub(super) fn redo(&mut self) {
        if let Some(document) = self.document_mut() {
            document.redo();
        }
    }

    pub(super) fn flush_edits(&mut self) {
        self.editor.flush(&self.link);
    }

    pub(super) fn look_panel(&mut self, ui: &mut Ui) {
        // What is edited now would be gone with the files that are shown.
        if self.status.is_loading {
            ui.disable();
        }
        let Editor {
            document: Some(document),
            panel,
            textures,
            materials,
            own_materials,
            lights,
            images,
            ..
        } = &mut self.editor
        else {
            return;
        };
        let navigator = self.viewport.now();
        let scene = SceneView {
            materials,
            own: *own_materials,
            images,
            lights,
            camera: navigator.as_ref().map(Navigator::camera),
        };
        let chosen = panel.material().map(str::to_owned);
        panel.show(ui, document, textures, scene);
        let now = panel.material();
        if chosen.is_some() && now != chosen.as_deref() {
            self.material = now.map(str::to_owned);
            let outline = now.map(|name| Command::Outline(name.to_owned()));
            self.link.send(outline.unwrap_or(Command::Unpick));
        }
        if let Some(placing) = panel.take_placing() {
            self.viewport.placing = Some(placing);
        }
        // The picture is kept before it hears of the edit.
        if panel.take_comparison() {
            self.compare();
        }
    }

    /// The graph in a panel of its own.
    pub(super) fn graph_panel(&mut self, ui: &mut Ui) {
        if self.status.is_loading {
            ui.disable();
        }
        let Editor {
            document: Some(document),
            panel,
            textures,
            materials,
            own_materials,
            lights,
            images,
            ..
        } = &mut self.editor
        else {
            return;
        };
        let scene = SceneView {
            materials,
            own: *own_materials,
            images,
            lights,
            camera: None,
        };
        panel.show_graph(ui, document, textures, scene);
    }

    /// Places a light at a surface that was clicked.
    pub(super) fn place_light(&mut self, hit: Option<&Hit>, now: f64) {
        let (Some((light, placing)), Some(hit)) = (self.viewport.placing.take(), hit) else {
            return;
        };
        let Some(document) = &self.editor.document else {
            return;
        };
        let scene = self.editor.scene();
        let place = [hit.position, hit.normal];
        let edits = patina_panels::place_light(document, scene, &light, placing, place);
        self.edit(&format!("place {light}"), &edits, now);
    }

    /// Edits by which the lights are what a mix makes of them, by the factors of its groups.
    pub(super) fn relit(&self, factors: &[(String, [f32; 3])]) -> Result<Vec<Edit>, String> {
        let Some(document) = &self.editor.document else {
            return Err("there is no look yet".to_owned());
        };
        let scene = self.editor.scene();
        let is_lit_by_studio = self.editor.has_stand_in_light();
        patina_panels::relight(document, scene, factors, is_lit_by_studio)
    }

    /// Gives a surface the material that was dropped there.
    pub(super) fn drop_material(&mut self, hit: Option<Hit>, now: f64) {
        let (Some(material), Some(hit)) = (self.viewport.dropped.take(), hit) else {
            return;
        };
        let Some(document) = &self.editor.document else {
            return self.tell("there is no look yet".to_owned(), true, now);
        };
        if material != hit.material {
            let scene = self.editor.scene();
            let textures = &self.editor.textures;
            let given =
                patina_panels::give_material(document, textures, scene, &hit.material, &material);
            match given {
                Ok(edits) => {
                    self.edit(&format!("{material} on {}", hit.material), &edits, now);
                }
                Err(why) => self.tell(why, true, now),
            }
        }
    }

    /// Whether a slot of the panel has taken what was dropped; asked for once.
    pub(super) fn slot_took_picture(&mut self) -> bool {
        self.editor.panel.take_dropped()
    }

    /// The material in the panel.
    pub(super) fn shown_material(&self) -> Option<&str> {
        self.editor.panel.material()
    }

    /// Shows pictures of nodes from now on.
    pub fn set_previews(&mut self, previews: Previews) {
        self.editor.panel.set_previews(previews);
    }

    /// What is to be the same at the next start, as it is now.
    pub fn kept(&mut self) -> &Preferences {
        self.preferences.shows_graph = self.editor.shows_graph();
        self.preferences.graph_is_below = self.editor.panel.form() == Form::Both;
        let places = self.editor.panel.places();
        self.preferences.places = places.map(|(id, at)| (id.to_owned(), at)).collect();
        &self.preferences
    }

    /// Begins with another look; in the form, and if it is the one of last time, with the places, that were kept.
    pub(super) fn begin_look(&mut self, is_last: bool) {
        let Editor { panel, .. } = &mut self.editor;
        panel.forget_snapshots();
        let form = match self.preferences {
            Preferences { graph_is_below, .. } if graph_is_below => Form::Both,
            Preferences { shows_graph, .. } if shows_graph => Form::Graph,
            _ => Form::List,
        };
        panel.set_form(form);
        if is_last {
            panel.set_places(self.preferences.places.clone());
        }
    }

    /// Shows the material that was clicked.
    pub(super) fn show_material(&mut self, material: &str) {
        self.editor.panel.pick(material);
    }
}
