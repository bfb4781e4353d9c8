//! The render's thread: takes commands, follows files, renders wave by wave, and puts what there is to see on the board.

mod commands;
mod compare;
mod denoise;
mod failure;
mod mix;
mod opening;
mod picture;
mod publish;
mod size;

use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use device::Device;
use engine::display::{DeviceFilm, Display, DisplaySettings};
use engine::load::StandIn;
use engine::scene::{Camera, Moment};
use engine::session::{ChangeQueue, Recovery, Session, SessionError};

use crate::host::{Changes, Host};
use crate::link::{Board, Command, Files, Link, Reply, lock};
use crate::pace::{self, Pace};

use denoise::Denoising;
use mix::Mixing;

/// Parsing recurses along a texture's expressions.
const STACK_BYTES: usize = 8 << 20;
/// How often a render that has just had something to do looks for what follows from it.
const IDLE: Duration = Duration::from_millis(50);
/// So long after the last thing that was done nothing follows any more: it sleeps until it is woken, or files are to be looked at.
const SETTLED: Duration = Duration::from_secs(1);
/// The same while something is built.
const BUILDING: Duration = Duration::from_millis(10);

/// How it is rendered, whatever is.
#[derive(Debug, Clone)]
pub struct RenderOptions {
    /// Samples per pixel after which the picture is done.
    pub target_spp: u32,
    /// Most scattering vertices of a path.
    pub max_depth: u32,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Pixels of the first picture.
    pub size: [u32; 2],
}

/// A running thread. It ends when it is told to, or the last [`Link`] to it is gone.
#[derive(Debug)]
pub struct RenderThread {
    /// To it.
    pub link: Link,
    thread: JoinHandle<()>,
}

impl RenderThread {
    /// Starts rendering on a device. `wake` is called whenever there is something new to see.
    ///
    /// # Errors
    /// The system has no room for a thread.
    pub fn start(
        device: Device,
        files: Option<Files>,
        options: RenderOptions,
        host: Box<dyn Host>,
        wake: Box<dyn Fn() + Send>,
    ) -> std::io::Result<Self> {
        let (sender, commands) = channel();
        let board = Arc::new(Mutex::new(Board::default()));
        lock(&board).status.device = device.description().name.clone();
        let link = Link::new(sender, Arc::clone(&board));
        let mut host = host;
        host.wake_by(link.waker());
        let thread = std::thread::Builder::new()
            .name("render".to_owned())
            .stack_size(STACK_BYTES)
            .spawn(move || {
                let full = options.size;
                let size = Arc::new(Mutex::new(full));
                let denoising = Denoising::start(&device, host.denoiser());
                let pace = Pace::of(device.traits());
                let mut render = Render {
                    device,
                    options,
                    host,
                    wake,
                    board,
                    size,
                    session: None,
                    display: None,
                    settings: DisplaySettings::default(),
                    is_paused: false,
                    times_passes: false,
                    stand_in: StandIn::Studio,
                    pending: Pending::default(),
                    motion: None,
                    is_moving: false,
                    divisor: 1,
                    full,
                    region: None,
                    beside: None,
                    picked: None,
                    outlined: None,
                    before: None,
                    kept: 0,
                    denoising,
                    mixing: Mixing::default(),
                    pace,
                    run: Run::default(),
                    is_stale: false,
                    making: None,
                    waiting: None,
                    failures: 0,
                    worked: Instant::now(),
                    outside: 0,
                    end: None,
                    is_stuck: false,
                    is_unheard: false,
                    recovery: None,
                    published: publish::Published::default(),
                };
                lock(&render.board).recent = render.host.recent().into();
                render.run_guarded(&commands, files);
            })?;
        Ok(Self { link, thread })
    }

    /// Ends the thread and waits for that, so that the device is at rest.
    pub fn finish(self) {
        self.link.send(Command::Quit);
        // A panic is on the board.
        let _ = self.thread.join();
    }
}

/// Everything that the thread works on.
struct Render {
    device: Device,
    options: RenderOptions,
    host: Box<dyn Host>,
    wake: Box<dyn Fn() + Send>,
    board: Arc<Mutex<Board>>,
    /// Pixels of the picture while nothing moves; what is built anew asks for it.
    size: Arc<Mutex<[u32; 2]>>,
    session: Option<Session>,
    display: Option<Displays>,
    settings: DisplaySettings,
    is_paused: bool,
    times_passes: bool,
    /// What a scene without light is seen by.
    stand_in: StandIn,
    pending: Pending,
    /// When something moved last.
    motion: Option<Instant>,
    /// Something moves, so that the picture is a small one.
    is_moving: bool,
    /// Pixels of the whole picture along a side per pixel of this one.
    divisor: u32,
    /// Pixels of the picture while nothing moves, as the last turn had them.
    full: [u32; 2],
    region: Option<[f32; 4]>,
    /// What lies beside the region, from before changes that only the region shows.
    beside: Option<DeviceFilm>,
    /// The instance that was picked last, and its name: once the scene's file has changed it may be another one's place.
    picked: Option<(usize, String)>,
    /// Name of the material that has a line around it.
    outlined: Option<String>,
    before: Option<compare::Before>,
    /// Pictures that have been kept to compare with.
    kept: u64,
    denoising: Denoising,
    mixing: Mixing,
    pace: Pace,
    run: Run,
    /// The scene, or its files, may be others than those on the board.
    is_stale: bool,
    /// A picture that is being finished to be written.
    making: Option<picture::Making>,
    /// Files that could not be opened, until they can.
    waiting: Option<Files>,
    /// Failures in a row.
    failures: u32,
    /// When something was done last, or waited for.
    worked: Instant,
    /// Texts of the look that other programs have written.
    outside: u64,
    /// When the scene's last animation ends, seconds.
    end: Option<f64>,
    /// There were so many that nothing is tried until something changes.
    is_stuck: bool,
    /// Other files were opened than those that the window knows of.
    is_unheard: bool,
    /// Where the look was kept when the render ended.
    recovery: Option<Recovery>,
    published: publish::Published,
}

/// What shows the picture, and what it is compared with.
struct Displays {
    now: Display,
    /// Without noise, or with its lights mixed; made once there is such a picture.
    other: Option<Display>,
    before: Display,
    beside: Display,
}

/// Changes that wait until the picture of those before them has been seen: without that, a steady stream of them would
/// leave nothing to see.
#[derive(Default)]
struct Pending {
    changes: ChangeQueue,
    /// Of the last change that has come.
    number: u64,
    /// Of the last one that was made.
    made: u64,
    view: Option<Option<Camera>>,
    moment: Option<Moment>,
    /// The last one that was asked for.
    asked: Moment,
    since: Option<Instant>,
}

/// The picture that is being rendered.
struct Run {
    generation: u64,
    start: Instant,
    /// When the change came that began it.
    cause: Option<Instant>,
    samples_done: u64,
    /// Each pixel has a sample, and they have been shown.
    is_seen: bool,
    last_shown: Instant,
    is_done: bool,
}

impl Default for Run {
    fn default() -> Self {
        let now = Instant::now();
        Self {
            generation: u64::MAX,
            start: now,
            cause: None,
            samples_done: 0,
            is_seen: false,
            last_shown: now,
            is_done: false,
        }
    }
}

impl Render {
    fn run(&mut self, commands: &Receiver<Command>, files: Option<Files>) {
        if let Some(files) = files {
            self.open(files);
        }
        loop {
            let wait = self.patience();
            if !self.take_commands(commands, wait) {
                return;
            }
            if self.host.is_ending() {
                self.end();
            }
            self.finish_picture();
            match self.turn() {
                Ok(()) => self.go_on(),
                Err(error) => self.fail(&error),
            }
        }
    }

    /// How long it may wait for a command.
    fn patience(&mut self) -> Duration {
        let is_building = (self.session.as_ref()).is_some_and(Session::is_building);
        let now = match (self.has_work(), is_building && !self.is_stuck) {
            (true, _) => Duration::ZERO,
            (false, true) => BUILDING,
            (false, false) if self.is_unsettled() => IDLE,
            (false, false) => {
                let rest = self.host.patience();
                return match self.worked.elapsed() < SETTLED {
                    true => rest.min(IDLE),
                    false => rest,
                };
            }
        };
        self.worked = Instant::now();
        now
    }

    /// Something comes by itself: the whole picture after a motion, or what other threads are about to finish.
    fn is_unsettled(&self) -> bool {
        let comes = self.is_moving || self.making.is_some() || self.mixing.is_moving();
        comes || self.denoising.is_at_work() || self.measures_costs()
    }

    fn has_work(&self) -> bool {
        let has_more = self.is_rendering() || self.pending.since.is_some() || self.refines_before();
        !self.is_stuck && self.session.is_some() && has_more && !self.makes_way()
    }

    /// What is seen waits for what is built, where one would take the other's time: that is a matter of moments. Not so with
    /// drivers that compile for seconds.
    fn makes_way(&self) -> bool {
        let device = self.device.traits();
        let is_building = self.session.as_ref().is_some_and(Session::is_building);
        let shares = device.shares_the_processor && !device.compiles_slowly;
        shares && is_building && self.run.is_seen
    }

    /// Paused, too, what has changed is seen once.
    fn is_rendering(&self) -> bool {
        !self.run.is_done && (!self.is_paused || !self.run.is_seen)
    }

    /// Takes all commands that have come; waits at most so long for the first. False when there will be no more.
    fn take_commands(&mut self, commands: &Receiver<Command>, wait: Duration) -> bool {
        match commands.recv_timeout(wait) {
            Ok(Command::Quit) => return false,
            Ok(command) => self.take(command),
            Err(RecvTimeoutError::Timeout) => return true,
            Err(RecvTimeoutError::Disconnected) => return false,
        }
        loop {
            match commands.try_recv() {
                Ok(Command::Quit) => return false,
                Ok(command) => self.take(command),
                Err(TryRecvError::Empty) => return true,
                Err(TryRecvError::Disconnected) => return false,
            }
        }
    }

    /// One turn of the loop: files, changes, a wave, what there is to see.
    fn turn(&mut self) -> Result<(), SessionError> {
        if let Some(files) = self.waiting.clone() {
            if self.host.changes() != Changes::default() {
                self.open(files);
            }
            return Ok(());
        }
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let changes = self.host.changes();
        let is_new = changes != Changes::default();
        self.is_stuck &= !is_new;
        if self.is_stuck {
            return Ok(());
        }
        let (generation, layers) = (session.generation(), session.settings().layers.clone());
        let kept = match is_new || session.has_built() {
            true => self.copy_beside()?,
            false => None,
        };
        if is_new {
            self.worked = Instant::now();
        }
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        if changes.look {
            let saved = session.saved_text().to_owned();
            match session.has_unsaved_edits() || !self.pending.changes.is_empty() {
                true => session.look_changed_beside_edits(),
                false => session.look_changed(),
            }
            self.outside += u64::from(session.saved_text() != saved);
        }
        if changes.textures {
            session.sources_changed();
            self.published.forget_textures();
        }
        if changes.assets {
            session.assets_changed();
            // Of a file that can't be read nothing is known: what is shown goes on.
            if let Ok(end) = opening::end(session) {
                self.end = end;
            }
        }
        let polled = session.poll();
        if session.generation() != generation {
            self.beside = match session.settings().layers == layers {
                true => self.beside.take().or(kept),
                false => None,
            };
            self.begin_small();
        }
        polled?;
        if changes.look || changes.textures {
            self.publish_look();
        }
        self.apply_pending()?;
        self.fit_size()?;
        self.notice_generation();
        self.notice_moment();
        if self.is_stale && !self.is_moving {
            self.is_stale = false;
            self.publish_scene();
            self.watch();
        }
        if self.is_rendering() && !self.makes_way() {
            self.render()?;
        }
        self.refine_before()?;
        self.denoise()?;
        self.measure_costs()?;
        self.publish_status(false);
        Ok(())
    }

    /// What files have changed is seen as soon as what the user does: in fewer pixels first.
    fn begin_small(&mut self) {
        let now = Instant::now();
        self.run.cause.get_or_insert(now);
        // Of a region there is not much to wait for.
        if self.beside.is_none() {
            self.motion = Some(now);
        }
    }

    /// Makes the changes that have been waiting, unless a picture that began with the last ones is still to be seen.
    fn apply_pending(&mut self) -> Result<(), SessionError> {
        let Some(since) = self.pending.since else {
            return Ok(());
        };
        let is_awaited = self.is_moving && !self.run.is_seen;
        if is_awaited && !self.run.is_done {
            return Ok(());
        }
        self.keep_beside()?;
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        if self.beside.is_none() {
            self.motion = Some(Instant::now());
        }
        self.run.cause = Some(since);
        self.pending.since = None;
        if let Some(view) = self.pending.view.take() {
            session.set_view(view);
        }
        let moment = self.pending.moment.take();
        let moved = moment.map_or(Ok(()), |moment| {
            let moved = session.set_moment(&moment);
            self.pending.asked = moment;
            moved
        });
        let changes = self.pending.changes.take();
        let sent = changes.iter().try_for_each(|change| session.apply(change));
        self.pending.made = self.pending.number;
        if !changes.is_empty() {
            self.publish_look();
        }
        if let Err(why) = moved {
            self.reply(Reply::Failed(publish::message(&why)));
        }
        sent
    }

    /// Notices that the moment that was asked for can't be shown: the bar of time goes back, too.
    fn notice_moment(&mut self) {
        let Some(session) = &self.session else {
            return;
        };
        let moment = session.moment();
        if *moment != self.pending.asked && self.pending.moment.is_none() {
            self.pending.asked = moment.clone();
            self.reply(Reply::Moment(publish::seconds(moment)));
        }
    }

    /// Notices that the picture has begun anew.
    fn notice_generation(&mut self) {
        let Some(session) = &mut self.session else {
            return;
        };
        let generation = session.generation();
        if generation == self.run.generation {
            return;
        }
        self.run = Run {
            generation,
            cause: self.run.cause,
            ..Run::default()
        };
        if self.times_passes && !session.is_timing() {
            // Without it, figures are missing: no reason to stop.
            let _ = session.time_passes();
        }
        self.is_stale = true;
    }

    fn render(&mut self) -> Result<(), SessionError> {
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let clock = Instant::now();
        let progress = session.advance(self.options.target_spp)?;
        if session.generation() != self.run.generation {
            // Another device: its samples are counted from the next turn on.
            self.begin_small();
            self.notice_generation();
            return Ok(());
        }
        let paths = progress.samples_done.saturating_sub(self.run.samples_done);
        self.pace.note(paths, clock.elapsed(), self.is_moving);
        self.run.samples_done = progress.samples_done;
        self.run.is_done = progress.is_done();
        let [width, height] = self.picture_size();
        let is_whole = progress.samples_done >= u64::from(width) * u64::from(height);
        let is_due = !self.run.is_seen
            || self.run.is_done
            || self.run.last_shown.elapsed() >= pace::interval(self.run.start.elapsed());
        if is_whole && is_due {
            self.show()?;
            if !self.run.is_seen {
                self.run.is_seen = true;
                let cause = self.run.cause.take();
                if let Some(cause) = cause {
                    let latency = cause.elapsed();
                    let status = &mut lock(&self.board).status;
                    status.latency = Some(latency.as_secs_f64());
                    status.answered += 1;
                    if self.is_moving {
                        self.pace.note_latency(latency);
                    }
                }
            }
            (self.wake)();
        }
        Ok(())
    }

    /// Whether there is to be measured what one more texture costs, as soon as nobody waits for anything else.
    fn measures_costs(&self) -> bool {
        let is_at_rest = self.run.is_seen && self.divisor == 1 && !self.is_paused;
        self.times_passes && is_at_rest && !lock(&self.board).status.textures.is_done
    }

    /// Measures what one more texture costs, where that is asked for and nobody waits for anything else.
    fn measure_costs(&mut self) -> Result<(), SessionError> {
        let is_at_rest = self.run.is_seen && self.divisor == 1 && !self.is_paused;
        if !self.times_passes || !is_at_rest || self.is_moving || self.is_touched() {
            return Ok(());
        }
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        let costs = session.measure_costs()?;
        let shown = &mut lock(&self.board).status.textures;
        // Former figures stay until there are all of the new ones.
        if (costs.is_done || !shown.is_done) && costs != shown {
            shown.clone_from(costs);
        }
        Ok(())
    }

    /// The picture has the size that it is to have, and all of it has been seen.
    fn is_whole(&self) -> bool {
        self.run.is_seen && self.region.is_none() && self.picture_size() == *lock_size(&self.size)
    }

    fn picture_size(&self) -> [u32; 2] {
        let settings = self.session.as_ref().map(|session| session.settings());
        settings.map_or([1, 1], |s| [s.width, s.height])
    }

    fn reply(&self, reply: Reply) {
        lock(&self.board).replies.push(reply);
        (self.wake)();
    }
}

fn lock_size(size: &Mutex<[u32; 2]>) -> std::sync::MutexGuard<'_, [u32; 2]> {
    size.lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}
