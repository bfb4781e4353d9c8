//! Pictures that are written: finished first, by a renderer and a thread of their own, whatever the window does meanwhile.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use engine::denoise::GUIDES;
use engine::film::layers::LIGHT_GROUPS;
use engine::film::{Film, GroupFactors, Layers, MAX_SIDE, Origin};
use engine::renderer::{RenderSettings, Renderer};

use crate::host::{Finished, OpenDenoiser};
use crate::link::{PictureOrder, Reply, Saving, lock};

use super::{Render, publish};

/// Longest waves: the window's frames wait for them.
const WAVE: Duration = Duration::from_millis(40);

/// A picture in the making.
pub(super) struct Making {
    order: PictureOrder,
    origin: Origin,
    /// What of it is written.
    layers: Layers,
    paths: Arc<AtomicU64>,
    is_cancelled: Arc<AtomicBool>,
    film: Receiver<Result<Made, String>>,
    thread: Option<JoinHandle<()>>,
}

/// A picture that has been finished.
struct Made {
    /// With its lights mixed.
    film: Film,
    /// Its radiance without the noise, and what has taken it out.
    denoised: Option<(Vec<[f32; 3]>, String)>,
}

/// What becomes of a film once it has its samples.
struct Finishing {
    /// How its lights are mixed.
    factors: Option<GroupFactors>,
    /// What takes its noise out.
    denoiser: Option<OpenDenoiser>,
}

impl Drop for Making {
    /// The device is at rest afterwards.
    fn drop(&mut self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // What it has to say is no longer wanted.
            let _ = thread.join();
        }
    }
}

impl Render {
    /// Begins to finish a picture, or writes the one that is there if it will do.
    pub(super) fn save_picture(&mut self, order: PictureOrder) {
        match self.begin_picture(order) {
            Ok(making) => self.making = making,
            Err(why) => self.reply(Reply::NotWritten(why)),
        }
        self.publish_making();
    }

    pub(super) fn cancel_picture(&mut self) {
        self.making = None;
        self.publish_making();
    }

    fn begin_picture(&mut self, mut order: PictureOrder) -> Result<Option<Making>, String> {
        if self.making.is_some() {
            return Err(
                "a picture is being finished already: wait for it, or cancel it".to_owned(),
            );
        }
        self.host.check_picture(&order.path)?;
        // Edits that wait are part of the picture.
        self.apply_all();
        // Of what has begun anew there is no picture yet.
        self.notice_generation();
        order.size = order.size.map(|side| side.clamp(1, MAX_SIDE));
        order.spp = order.spp.max(1);
        let is_whole = self.is_whole();
        let session = self.session.as_mut().ok_or("there is no picture yet")?;
        let [width, height] = order.size;
        let scene = session.scene();
        // Radiance is what is rendered: whoever wants it mixes its layers.
        let factors = self.mixing.factors(scene).filter(|_| !order.is_radiance());
        let layers = match (order.layers, &factors) {
            (true, _) => Layers::all().of_scene(scene),
            (false, Some(_)) => {
                let groups = Layers::named([LIGHT_GROUPS]);
                groups.unwrap_or_default().of_scene(scene)
            }
            (false, None) => Layers::default(),
        };
        // As `render --denoise` gathers what tells noise from texture, whatever is written of it.
        let gathered = match order.denoised {
            true => layers.with(GUIDES).map_err(|error| error.to_string())?,
            false => layers.clone(),
        };
        let settings = RenderSettings {
            width,
            height,
            layers: gathered.clone(),
            ..session.settings().clone()
        };
        let origin = session.origin_of(&settings);
        let now = session.settings();
        // What else the window has is left out.
        let has_layers = now.layers == gathered || gathered.is_picture_alone();
        let is_same =
            is_whole && !order.denoised && [now.width, now.height] == order.size && has_layers;
        let wanted = u64::from(width) * u64::from(height) * u64::from(order.spp);
        if is_same && self.run.samples_done >= wanted {
            let film = session
                .snapshot()
                .map_err(|error| publish::message(&error))?
                .film;
            let film = match layers.is_picture_alone() {
                true => film.picture(),
                false => film,
            };
            let finishing = Finishing {
                factors,
                denoiser: None,
            };
            let made = finishing.finish(film)?;
            self.write_picture(&order, &made, &origin, &layers);
            return Ok(None);
        }
        let renderer = session.renderer_of(&settings);
        let renderer = renderer.map_err(|error| publish::message(&error))?;
        let finishing = Finishing {
            factors,
            denoiser: order.denoised.then(|| self.host.denoiser()),
        };
        start(order, origin, layers, finishing, renderer).map(Some)
    }

    /// Takes over a picture that has been finished.
    pub(super) fn finish_picture(&mut self) {
        let Some(making) = &self.making else {
            return;
        };
        let finished = match making.film.try_recv() {
            Ok(film) => film,
            Err(TryRecvError::Empty) => return self.publish_making(),
            Err(TryRecvError::Disconnected) => Err("the picture was not finished".to_owned()),
        };
        if let Some(making) = self.making.take() {
            match finished {
                Ok(made) => {
                    self.write_picture(&making.order, &made, &making.origin, &making.layers);
                }
                Err(why) => self.reply(Reply::NotWritten(why)),
            }
        }
        self.publish_making();
    }

    fn write_picture(&self, order: &PictureOrder, made: &Made, origin: &Origin, layers: &Layers) {
        let PictureOrder { path, view, .. } = order;
        let denoised = made.denoised.as_ref();
        let picture = Finished {
            film: &made.film,
            // Of lights that are mixed there is the picture alone.
            layers: match made.film.layers().is_picture_alone() {
                true => made.film.layers(),
                false => layers,
            },
            denoised: denoised.map(|(radiance, by)| (radiance.as_slice(), by.as_str())),
            origin,
            view,
        };
        self.reply(match self.host.write_picture(path, &picture) {
            Ok(()) => Reply::Done(format!("wrote {}", path.display())),
            Err(why) => Reply::NotWritten(why),
        });
    }

    fn publish_making(&self) {
        let saving = self.making.as_ref().map(|making| {
            let [width, height] = making.order.size.map(f64::from);
            Saving {
                path: making.order.path.clone(),
                spp: making.paths.load(Ordering::Relaxed) as f64 / (width * height),
                target: making.order.spp,
            }
        });
        let status = &mut lock(&self.board).status;
        if status.saving != saving {
            status.saving = saving;
            (self.wake)();
        }
    }
}

impl Finishing {
    fn finish(self, film: Film) -> Result<Made, String> {
        let mixed = self.factors.map(|factors| film.mixed(&factors));
        let denoised = match self.denoiser {
            Some(open) => {
                let denoiser = open()?;
                let radiance = mixed.as_ref().unwrap_or(&film).mean();
                let clean = denoiser.guided_by(&film, &radiance);
                let clean = clean.map_err(|error| error.to_string())?;
                Some((clean, denoiser.title()))
            }
            None => None,
        };
        Ok(Made {
            film: mixed.unwrap_or(film),
            denoised,
        })
    }
}

fn start(
    order: PictureOrder,
    origin: Origin,
    layers: Layers,
    finishing: Finishing,
    mut renderer: Renderer,
) -> Result<Making, String> {
    let (sender, film) = channel();
    let (paths, is_cancelled) = (
        Arc::new(AtomicU64::new(0)),
        Arc::new(AtomicBool::new(false)),
    );
    let (done, stop) = (Arc::clone(&paths), Arc::clone(&is_cancelled));
    let spp = order.spp;
    let work = move || {
        renderer.set_longest_wave(WAVE);
        let finished = loop {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            match renderer.step(spp) {
                Ok(progress) => {
                    done.store(progress.samples_done, Ordering::Relaxed);
                    if progress.is_done() {
                        break renderer.film();
                    }
                }
                Err(error) => break Err(error),
            }
        };
        let finished = finished.map_err(|error| error.to_string());
        // Nobody may want it any more.
        let _ = sender.send(finished.and_then(|film| finishing.finish(film)));
    };
    let thread = std::thread::Builder::new()
        .name("picture".to_owned())
        .spawn(work)
        .map_err(|error| format!("the picture can't be finished: {error}"))?;
    Ok(Making {
        order,
        origin,
        layers,
        paths,
        is_cancelled,
        film,
        thread: Some(thread),
    })
}
