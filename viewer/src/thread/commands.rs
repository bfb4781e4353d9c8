//! What each command does.

use std::path::{Path, PathBuf};
use std::time::Instant;

use engine::display::DeviceFilm;
use engine::session::SessionError;

use crate::link::{Command, Reply};

use super::{Render, lock_size, publish};

impl Render {
    pub(super) fn take(&mut self, command: Command) {
        match command {
            Command::Change(change, number) => {
                self.pending.changes.push(change);
                self.pending.number = number;
                self.pending.since.get_or_insert_with(Instant::now);
            }
            Command::View(view) => {
                self.pending.view = Some(view);
                self.pending.since.get_or_insert_with(Instant::now);
            }
            Command::Size(size) => {
                *lock_size(&self.size) = size.map(|side| side.clamp(1, engine::film::MAX_SIDE));
                // Until there is one of its shape, the former picture is stretched.
                self.motion = Some(Instant::now());
            }
            Command::Display(settings) => {
                if settings != self.settings {
                    self.settings = settings;
                    self.show_again();
                }
            }
            Command::Region(region) => {
                self.region = region;
                self.run.is_done = false;
            }
            Command::Pick(place, purpose) => {
                let hit = self.session.as_ref().and_then(|session| {
                    let hit = session.pick(place)?;
                    let material = session.scene().materials.get(hit.material as usize)?;
                    Some((material.name.clone(), hit.depth))
                });
                self.reply(Reply::Picked { purpose, hit });
            }
            Command::KeepBefore(is_kept) => {
                self.before = None;
                if is_kept {
                    match self.shown_film() {
                        Some(Ok(film)) => self.before = Some(film),
                        Some(Err(error)) => self.reply(Reply::Failed(publish::message(&error))),
                        None => {}
                    }
                }
                self.show_again();
            }
            Command::Bounds => {
                let bounds = self
                    .session
                    .as_ref()
                    .and_then(|session| session.scene().bounds());
                if let Some((low, high)) = bounds {
                    self.reply(Reply::Bounds([low, high]));
                }
            }
            Command::Pause(is_paused) => {
                self.is_paused = is_paused;
                self.publish_status(true);
            }
            Command::TimePasses(is_timed) => {
                self.times_passes = is_timed;
                let session = self
                    .session
                    .as_mut()
                    .filter(|session| is_timed && !session.is_timing());
                if let Some(Err(error)) = session.map(|session| session.time_passes()) {
                    self.reply(Reply::Failed(publish::message(&error)));
                }
            }
            Command::Target(target) => {
                self.options.target_spp = target.max(1);
                self.run.is_done = false;
            }
            Command::Save(path) => self.save(path),
            Command::SavePicture(path) => {
                let written = self.save_picture(&path);
                self.reply(match written {
                    Ok(()) => Reply::Done(format!("wrote {}", path.display())),
                    Err(why) => Reply::Failed(why),
                });
            }
            Command::Open(files) => self.open(files),
            Command::TextureFolder(folder) => {
                if let Some(session) = &mut self.session {
                    session.add_textures(folder);
                    self.published.forget_textures();
                    self.publish_look();
                    self.watch();
                }
            }
            // Heard by the loop.
            Command::Quit => {}
        }
    }

    /// A copy of the film that is shown.
    fn shown_film(&mut self) -> Option<Result<DeviceFilm, SessionError>> {
        let session = self.session.as_mut()?;
        match &self.whole {
            Some(film) if !self.run.is_seen => Some(Ok(film.clone())),
            _ => Some(session.keep_film(self.settings.channel.needs_guides())),
        }
    }

    fn save(&mut self, path: Option<PathBuf>) {
        self.apply_all();
        let Some(session) = &mut self.session else {
            return;
        };
        let saved = match &path {
            Some(path) => session.save_as(path),
            None => session.save(None),
        };
        let name = session.inputs().look.clone().unwrap_or_default();
        match saved {
            Ok(()) => {
                self.reply(Reply::Done(format!("saved {}", name.display())));
                if path.is_some() {
                    self.publish_scene();
                    self.watch();
                }
            }
            Err(error) => self.reply(Reply::Failed(publish::message(&error))),
        }
        self.publish_status(true);
    }

    /// Edits that wait are part of the look that is saved.
    fn apply_all(&mut self) {
        self.is_moving = false;
        if let Err(error) = self.apply_pending() {
            self.fail(&error);
        }
    }

    fn save_picture(&mut self, path: &Path) -> Result<(), String> {
        let session = self.session.as_mut().ok_or("there is no picture yet")?;
        let is_exr = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("exr"));
        if is_exr {
            let film = session
                .snapshot()
                .map_err(|error| publish::message(&error))?
                .film;
            return self.host.write_film(path, &film, &session.origin());
        }
        self.show().map_err(|error| publish::message(&error))?;
        let displays = self.display.as_ref().ok_or("there is no picture yet")?;
        let rgba = displays.now.read().map_err(|error| error.to_string())?;
        self.host.write_shown(path, self.picture_size(), &rgba)
    }

    /// Shows the picture in another way.
    fn show_again(&mut self) {
        // A picture whose first samples are coming is shown with them.
        if self.session.is_some() && self.run.is_seen {
            let shown: Result<(), SessionError> = self.show();
            if let Err(error) = shown {
                return self.fail(&error);
            }
        }
        (self.wake)();
    }
}
