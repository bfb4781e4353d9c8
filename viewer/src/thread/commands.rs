//! What each command does.

use std::path::{Path, PathBuf};
use std::time::Instant;

use engine::input::FileId;
use engine::load::StandIn;
use engine::procedural::{LIBRARIES, TextureSources};
use engine::scene::{Instance, Moment, Motion, Scene};
use engine::session::{Session, SessionError};

use crate::link::{Command, Extent, Hit, PickPurpose, Reply};

use super::{Render, lock_size, publish};

/// Whether a command is meant for the files that are shown, and would do something else to others.
fn is_of_files(command: &Command) -> bool {
    matches!(
        command,
        Command::Change(..)
            | Command::View(_)
            | Command::Moment(_)
            | Command::Region(_)
            | Command::Pick(..)
            | Command::Outline(_)
            | Command::KeepBefore(_)
            | Command::MixLights(_)
            | Command::Save(..)
            | Command::SavePicture(_)
    )
}

/// Where an instance is that had this place and name when it was picked.
fn place_of(scene: &Scene, (place, name): &(usize, String)) -> Option<usize> {
    let is_it = |instance: &Instance| instance.name == *name;
    let is_there = scene.instances.get(*place).is_some_and(is_it);
    let place = is_there.then_some(*place);
    place.or_else(|| scene.instances.iter().position(is_it))
}

impl Render {
    pub(super) fn take(&mut self, command: Command) {
        self.worked = Instant::now();
        self.is_stuck &= matches!(command, Command::LookForChanges);
        if self.is_unheard && is_of_files(&command) {
            return;
        }
        match command {
            Command::HasOpened => self.is_unheard = false,
            Command::Change(change, _) if self.recovery.is_some() => {
                self.recover(change.text());
            }
            Command::Change(change, number) => {
                self.pending.changes.push(change);
                self.pending.number = number;
                self.pending.since.get_or_insert_with(Instant::now);
            }
            Command::View(view) => {
                self.pending.view = Some(view);
                self.pending.since.get_or_insert_with(Instant::now);
            }
            Command::Moment(seconds) => {
                self.pending.moment =
                    Some(seconds.map_or_else(Moment::default, |seconds| Moment {
                        seconds,
                        motion: Motion::Usual,
                    }));
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
            Command::Abandon(why) => {
                self.apply_all();
                self.stop(why);
            }
            Command::Region(region) => {
                let former = std::mem::replace(&mut self.region, region);
                self.run.is_done = false;
                // What lies beside the former one isn't what the look says now, or lacks the samples that the region has got.
                let is_behind = former.is_some() && former != region;
                let is_old = self.beside.take().is_some() || is_behind;
                if let (true, Some(session)) = (is_old, &mut self.session) {
                    session.restart();
                    self.begin_small();
                }
            }
            Command::Pick(place, purpose) => {
                let seen = self
                    .session
                    .as_ref()
                    .and_then(|session| session.pick(place));
                let hit = seen.zip(self.session.as_ref()).and_then(|(hit, session)| {
                    let material = session.scene().materials.get(hit.material as usize)?;
                    Some(Hit {
                        material: material.name.clone(),
                        depth: hit.depth,
                        position: hit.position,
                        normal: hit.normal,
                    })
                });
                if purpose == PickPurpose::Material {
                    self.picked = seen.zip(self.session.as_ref()).and_then(|(hit, session)| {
                        let place = hit.instance as usize;
                        let instance = session.scene().instances.get(place)?;
                        Some((place, instance.name.clone()))
                    });
                    self.outlined = hit.as_ref().map(|hit| hit.material.clone());
                }
                self.reply(Reply::Picked { purpose, hit });
                if purpose == PickPurpose::Material {
                    self.show_again();
                }
            }
            Command::Unpick => {
                self.picked = None;
                if self.outlined.take().is_some() {
                    self.show_again();
                }
            }
            Command::Outline(name) => {
                self.outlined = Some(name);
                self.show_again();
            }
            Command::Ground(from) => {
                let scene = self.session.as_ref().map(Session::scene);
                let below = scene.and_then(|scene| engine::pick::below(scene, from));
                self.reply(Reply::Ground { from, below });
            }
            Command::KeepBefore(is_kept) => {
                self.before = None;
                if is_kept && let Err(error) = self.keep_before() {
                    self.reply(Reply::Failed(publish::message(&error)));
                }
                self.show_again();
            }
            Command::Bounds(extent) => {
                let picked = (self.picked.as_ref()).filter(|_| extent == Extent::Picked);
                let scene = self.session.as_ref().map(Session::scene);
                let bounds = scene.and_then(|scene| {
                    let own = picked.and_then(|picked| scene.bounds_of(place_of(scene, picked)?));
                    own.or_else(|| scene.bounds())
                });
                if let Some((low, high)) = bounds {
                    self.reply(Reply::Bounds([low, high]));
                }
            }
            Command::Pause(is_paused) => {
                self.is_paused = is_paused;
                self.publish_status(true);
            }
            Command::Denoise(wanted) => {
                self.denoising.wanted = wanted;
                self.show_again();
            }
            Command::MixLights(mix) => self.mix_lights(mix),
            Command::StudioLight(is_on) => {
                self.stand_in = match is_on {
                    true => StandIn::Studio,
                    false => StandIn::Dark,
                };
                if let Some(session) = &mut self.session {
                    session.set_stand_in(self.stand_in);
                }
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
            Command::Save(path, outside) => self.save(path, outside),
            Command::SavePicture(order) => self.save_picture(order),
            Command::CancelPicture => self.cancel_picture(),
            Command::Open(files) => self.open(files),
            Command::TextureFolder(folder) => {
                if let Some(session) = &mut self.session {
                    session.add_textures(folder);
                    self.published.forget_textures();
                    self.publish_look();
                    self.watch();
                }
            }
            // The loop does so, and hears that.
            Command::LookForChanges | Command::Quit => {}
        }
    }

    /// What a look that was saved elsewhere will lack when it is opened there: textures beside its former file.
    fn without_textures(&self) -> Option<String> {
        let session = self.session.as_ref()?;
        let look = session.inputs().look.as_deref();
        let sources = TextureSources::search(&self.host.texture_folders(look).ok()?).ok()?;
        let textures = session.procedural().graph().library().textures();
        let lost = textures
            .iter()
            .find(|texture| sources.read(texture.name()).is_none())?;
        let (name, path) = (lost.name(), lost.file().path());
        Some(format!(
            "its texture `{name}` isn't found from there: copy {path}"
        ))
    }

    fn save(&mut self, path: Option<PathBuf>, outside: u64) {
        self.apply_all();
        if let Err(why) = self.may_save(path.as_deref(), outside) {
            return self.reply(Reply::NotWritten(why));
        }
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
                let mut text = format!("saved {}", name.display());
                if path.is_some()
                    && let Some(lost) = self.without_textures()
                {
                    text += &format!("; {lost}");
                }
                self.reply(Reply::Done(text));
                match path.is_some() {
                    true => {
                        self.publish_scene();
                        self.watch();
                    }
                    false => self.publish_look(),
                }
            }
            Err(error) => self.reply(Reply::NotWritten(publish::message(&error))),
        }
        self.publish_status(true);
    }

    /// Whether saving the look takes nothing away that it isn't meant to.
    fn may_save(&self, path: Option<&Path>, outside: u64) -> Result<(), String> {
        const NOTHING: &str = "there is no look to save: open a scene first; after a failure the edits are in the file that was named";
        let session = self.session.as_ref().ok_or(NOTHING)?;
        let own = session.inputs().look.as_deref();
        let Some(path) = path else {
            let own = own.unwrap_or(Path::new("")).display();
            let is_known = outside == self.outside;
            return is_known.then_some(()).ok_or_else(|| {
                format!("another program has just changed {own}: see what has become of both, then save once more")
            });
        };
        // However they are named, hard links included. What isn't there yet is nothing of them.
        let found = |path: &Path| path.exists().then(|| FileId::of(path));
        let own = own.and_then(found);
        let Some(wanted) = found(path).filter(|file| own.as_ref() != Some(file)) else {
            return Ok(());
        };
        let textures = &session.inputs().textures;
        // Of one that nothing uses only its folder is known, and of what those share: of the link's, and of the file's behind it.
        let place = path.canonicalize().unwrap_or_default();
        let is_texture = [path, place.as_path()].into_iter().any(|file| {
            let folder = Path::new(".").join(file.parent().unwrap_or(Path::new("")));
            let folder = found(&folder);
            let holds = |dir: &PathBuf| [found(dir), found(&dir.join(LIBRARIES))].contains(&folder);
            let is_wgsl = file.extension().is_some_and(|ending| ending == "wgsl");
            is_wgsl && folder.is_some() && textures.iter().any(holds)
        });
        let mut files = session.files().into_iter();
        match is_texture || files.any(|file| found(&file).as_ref() == Some(&wanted)) {
            true => Err(format!(
                "{} is part of what is shown: name another file",
                path.display()
            )),
            false => Ok(()),
        }
    }

    /// Makes edits that wait: they are part of what is saved.
    pub(super) fn apply_all(&mut self) {
        self.is_moving = false;
        if let Err(error) = self.apply_pending() {
            self.fail(&error);
        }
    }

    /// Shows the picture in another way.
    pub(super) fn show_again(&mut self) {
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
