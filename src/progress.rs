//! How far a render or a measurement is: a bar on a terminal, a line every ten seconds elsewhere, nothing with `--quiet` or
//! JSON messages. Something that a driver compiles for longer than two seconds is named.

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use device::Activity;
use device::Device;
use engine::renderer::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::console;
use crate::usage::MAX_SPP;

/// How often the bar is drawn anew while nothing else happens.
const TICK: Duration = Duration::from_millis(200);
/// Before there is something to count.
const WAITING: &str = "{spinner} {msg}";
/// What takes longer is named.
const PATIENCE: Duration = Duration::from_secs(2);
/// Between lines for programs.
const TELLING: Duration = Duration::from_secs(1);
/// Between lines where there is no terminal.
const SILENCE: Duration = Duration::from_secs(10);

/// A bar is on the terminal.
static IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// A line on the terminal that follows one render.
pub(crate) struct Bar {
    shared: Arc<Shared>,
}

struct Shared {
    bar: ProgressBar,
    state: Mutex<State>,
    /// Notified when the bar is finished.
    finished: Condvar,
    form: Form,
}

/// What progress is written for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Reader {
    /// People: a bar on a terminal, a line now and then elsewhere.
    #[default]
    People,
    /// Programs: an object of JSON a line, on stdout.
    Json,
    /// Open Job Description: `openjd_progress` and `openjd_status` lines on stdout.
    Openjd,
}

/// How progress is shown.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Terminal,
    Lines,
    /// For programs.
    Told(Reader),
    Silent,
}

struct State {
    /// What is done before there is something to count; without it only what is compiled is told.
    stage: Option<String>,
    /// The stage began.
    since: Instant,
    /// When there was something to count for the first time, and how much of it there was already.
    counted: Option<(Instant, f64, Unit)>,
    /// Of the stage more than its beginning is told.
    goes_on: bool,
    activity: Option<Activity>,
    /// How much is done, and what that is of.
    done: Option<(f64, f64, Unit)>,
    /// Samples of each pixel, where something else than their number ends the render.
    samples: Option<f64>,
    /// The piece of the picture that is rendered, from 0 on, and how many there are.
    piece: Option<(u32, u32)>,
    /// Of the last line, where there is no terminal.
    said: Instant,
    /// The activity has been named in a line of its own.
    is_named: bool,
    is_finished: bool,
}

/// How far a render is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reached {
    /// Samples of each pixel.
    pub(crate) samples: f64,
    /// Of the way to its end.
    pub(crate) share: f64,
}

impl Reached {
    /// Of a render that ends after so many samples of each pixel.
    pub(crate) fn of(progress: &Progress, spp: u32) -> Self {
        let share = progress.samples_done as f64 / progress.samples_total.max(1) as f64;
        Self {
            samples: share * f64::from(spp),
            share,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Unit {
    SamplesPerPixel,
    Steps,
}

impl Bar {
    /// A bar that shows `stage` until the first samples arrive.
    pub(crate) fn new(stage: &str) -> Self {
        Self::read_by(Reader::People, stage)
    }

    /// As [`Self::new`], for whoever reads it.
    pub(crate) fn read_by(reader: Reader, stage: &str) -> Self {
        let form = match (reader, io::stderr().is_terminal()) {
            (Reader::People, true) => Form::Terminal,
            (Reader::People, false) => Form::Lines,
            (Reader::Json | Reader::Openjd, _) => Form::Told(reader),
        };
        Self::with(form, Some(stage))
    }

    /// Only tells what is compiled for long, in lines.
    pub(crate) fn of_compiling() -> Self {
        Self::with(Form::Lines, None)
    }

    fn with(form: Form, stage: Option<&str>) -> Self {
        let is_told = matches!(form, Form::Told(_));
        let form = match (console::is_json() || console::is_quiet()) && !is_told {
            true => Form::Silent,
            false => form,
        };
        let target = match form {
            // Ten times a second is smooth enough and costs a render on the CPU nothing.
            Form::Terminal => ProgressDrawTarget::stderr_with_hz(10),
            _ => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(1), target);
        bar.set_style(style(WAITING));
        IS_SHOWN.store(form == Form::Terminal, Ordering::Relaxed);
        let now = Instant::now();
        let shared = Arc::new(Shared {
            bar,
            form,
            finished: Condvar::new(),
            state: Mutex::new(State {
                stage: stage.map(str::to_owned),
                since: now,
                counted: None,
                activity: None,
                goes_on: false,
                done: None,
                samples: None,
                piece: None,
                said: now,
                is_named: false,
                is_finished: false,
            }),
        });
        if form != Form::Silent {
            let ticker = Arc::clone(&shared);
            // Without it the bar moves only when there is something new.
            let _ = std::thread::Builder::new()
                .name("progress".to_owned())
                .spawn(move || ticker.tick());
        }
        Self { shared }
    }

    /// Shows another stage of the work before rendering.
    pub(crate) fn stage(&self, stage: &str) {
        let mut state = self.shared.lock();
        state.stage = Some(stage.to_owned());
        if state.done.is_none() {
            state.since = Instant::now();
        }
        self.shared.show(&mut state);
    }

    /// Shows a stage that is told of again and again, before there is something to count, or after.
    pub(crate) fn go_on(&self, stage: String) {
        let mut state = self.shared.lock();
        if state.done.take().is_some() || !state.goes_on {
            state.since = Instant::now();
            self.shared.bar.set_style(style(WAITING));
        }
        state.goes_on = true;
        state.stage = Some(stage);
        self.shared.show(&mut state);
    }

    /// Names from now on what the device compiles.
    pub(crate) fn follow(&self, device: &Device) {
        self.shared.lock().activity = Some(device.activity().clone());
    }

    /// Runs `print` with the bar out of the way of other lines.
    pub(crate) fn suspend(&self, print: impl FnOnce()) {
        self.shared.bar.suspend(print);
    }

    /// Says from now on how far a piece of the picture is: this one, from 0 on, of so many that are alike.
    pub(crate) fn piece(&self, number: u32, count: u32) {
        self.shared.lock().piece = Some((number, count));
    }

    /// Shows how far a render of at most so many samples per pixel is.
    pub(crate) fn update(&self, reached: &Reached, spp: u32) {
        let has_end = spp < MAX_SPP;
        let spp = f64::from(spp);
        let mut state = self.shared.lock();
        let is_of_samples = reached.share * spp <= reached.samples + 0.05;
        state.samples = (!is_of_samples || !has_end).then_some(reached.samples);
        // Of what else will end it nothing is known yet: nobody asked for that many samples.
        let own = match is_of_samples && !has_end {
            true => 0.0,
            false => reached.share,
        };
        let share = match state.piece {
            Some((number, count)) => (f64::from(number) + own) / f64::from(count),
            None => own,
        };
        drop(state);
        self.advance(share * spp, spp, Unit::SamplesPerPixel);
    }

    /// Shows from now on how many of `total` steps are done, and about how long the rest will take.
    pub(crate) fn count(&self, total: u64) {
        self.advance(0.0, total as f64, Unit::Steps);
    }

    /// One step of [`Self::count`] is done.
    pub(crate) fn step(&self) {
        let (done, total) = (self.shared.lock().done).map_or((0.0, 1.0), |(d, t, _)| (d, t));
        self.advance(done + 1.0, total, Unit::Steps);
    }

    fn advance(&self, done: f64, total: f64, unit: Unit) {
        let mut state = self.shared.lock();
        if state.done.is_none() {
            let shown = style("{bar:12} {msg}").progress_chars("=> ");
            self.shared.bar.set_style(shown);
        }
        if state.counted.is_none_or(|(_, _, former)| former != unit) {
            state.counted = Some((Instant::now(), done, unit));
        }
        state.goes_on = false;
        state.done = Some((done, total, unit));
        self.shared.show(&mut state);
    }

    /// Removes the bar so that other lines can be printed.
    pub(crate) fn finish(&self) {
        {
            let mut state = self.shared.lock();
            if let (Form::Told(reader), false) = (self.shared.form, state.is_finished) {
                console::print(&state.told(reader));
            }
            state.is_finished = true;
        }
        self.shared.finished.notify_all();
        self.shared.bar.finish_and_clear();
        IS_SHOWN.store(false, Ordering::Relaxed);
    }
}

impl Drop for Bar {
    /// An error message must not share the bar's line.
    fn drop(&mut self) {
        self.finish();
    }
}

/// Makes room for a last message, where a bar is on the terminal.
pub(crate) fn clear_line() {
    if IS_SHOWN.swap(false, Ordering::Relaxed) {
        // Nothing can be done about a terminal that is gone.
        let _ = io::stderr().write_all(b"\r\x1b[2K");
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows the time that passes, until the bar is finished.
    fn tick(&self) {
        let mut state = self.lock();
        while !state.is_finished {
            self.show(&mut state);
            let waited = self.finished.wait_timeout(state, TICK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn show(&self, state: &mut State) {
        if state.is_finished {
            return;
        }
        match self.form {
            Form::Silent => {}
            Form::Told(reader) => {
                if state.said.elapsed() >= TELLING {
                    state.said = Instant::now();
                    console::print(&state.told(reader));
                }
            }
            Form::Terminal => {
                if let Some((done, total, _)) = state.done {
                    self.bar.set_length(total.max(1.0) as u64);
                    self.bar.set_position(done as u64);
                }
                let text = console::printable(&state.text()).replace('\n', " ");
                self.bar.set_message(text);
                self.bar.tick();
            }
            Form::Lines => {
                let is_named = state.compiled().is_some();
                // What is compiled is named at once, and then as often as everything else.
                let is_news = is_named && !state.is_named;
                state.is_named &= is_named;
                let is_due = state.said.elapsed() >= SILENCE;
                if is_news || (is_due && (is_named || state.stage.is_some())) {
                    state.is_named = is_named;
                    state.said = Instant::now();
                    console::progress(&state.text());
                }
            }
        }
    }
}

impl State {
    /// What is being compiled, and has been for longer than a moment.
    fn compiled(&self) -> Option<(String, Duration)> {
        let current = self.activity.as_ref()?.current()?;
        (current.1 >= PATIENCE).then_some(current)
    }

    /// A line for a program.
    fn told(&self, reader: Reader) -> String {
        let share = self
            .done
            .map_or(0.0, |(done, total, _)| done / total.max(1e-9));
        let text = self.text();
        match reader {
            Reader::Openjd => format!(
                "openjd_progress: {:.1}\nopenjd_status: {text}",
                100.0 * share
            ),
            _ => serde_json::json!({ "progress": share, "status": text }).to_string(),
        }
    }

    fn text(&self) -> String {
        if let Some((what, took)) = self.compiled() {
            return format!("{what}, {} so far", clock(took));
        }
        let stage = self.stage.as_deref().unwrap_or_default();
        let (Some((done, total, unit)), Some((start, before, _))) = (self.done, self.counted)
        else {
            return format!("{stage}, {} so far", clock(self.since.elapsed()));
        };
        let elapsed = start.elapsed();
        let mut text = match (unit, self.samples) {
            (Unit::SamplesPerPixel, None) => format!("{done:.1} of {total} samples per pixel"),
            (Unit::SamplesPerPixel, Some(samples)) => format!("{samples:.1} samples per pixel"),
            (Unit::Steps, _) => format!("{stage}: {done} of {total} steps"),
        };
        if let Some((number, count)) = self.piece {
            text += &format!(", piece {} of {count}", number + 1);
        }
        text += &format!(", {}", clock(elapsed));
        if let Some(left) = remaining(elapsed, done - before, total - before) {
            text += &format!(", {} left", clock(left));
        }
        text
    }
}

/// The time for what is left at the pace so far.
fn remaining(elapsed: Duration, done: f64, total: f64) -> Option<Duration> {
    let left = elapsed.as_secs_f64() * (total - done).max(0.0) / done;
    Duration::try_from_secs_f64(left).ok()
}

/// A time of waiting: `7 s`, `3:05 min`, `2:03:05 h`.
fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    match (hours, minutes) {
        (0, 0) => format!("{seconds} s"),
        (0, _) => format!("{minutes}:{:02} min", seconds % 60),
        _ => format!("{hours}:{minutes:02}:{:02} h", seconds % 60),
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates in this file are well-formed")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_shown_as_people_say_them() {
        for (seconds, expected) in [(7, "7 s"), (185, "3:05 min"), (7_385, "2:03:05 h")] {
            assert_eq!(clock(Duration::from_secs(seconds)), expected);
        }
        let left = |done| remaining(Duration::from_secs(10), done, 40.0);
        assert_eq!(left(10.0), Some(Duration::from_secs(30)));
        assert_eq!(left(0.0), None, "nobody knows");
        assert_eq!(left(40.0), Some(Duration::ZERO));
    }

    /// As an hour after there was so much of `total` samples per pixel, of which there is so much by now.
    fn after_an_hour(before: f64, done: f64, total: f64) -> Option<String> {
        let Some(start) = Instant::now().checked_sub(Duration::from_secs(3600)) else {
            eprintln!("skipped: this machine has just been started");
            return None;
        };
        let unit = Unit::SamplesPerPixel;
        let state = State {
            stage: None,
            since: start,
            counted: Some((start, before, unit)),
            activity: None,
            goes_on: false,
            done: Some((done, total, unit)),
            samples: None,
            piece: None,
            said: start,
            is_named: false,
            is_finished: false,
        };
        Some(state.text())
    }

    #[test]
    fn the_longest_line_fits_a_narrow_terminal() {
        let total = f64::from(crate::words::MAX_SPP);
        let Some(text) = after_an_hour(0.0, 90_000.0, total) else {
            return;
        };
        assert!(text.starts_with("90000.0 of 1048576 samples per pixel, 1:00:00 h, "));
        assert!("============ ".len() + text.len() < 80, "{text}");
    }

    #[test]
    fn what_was_there_before_took_no_time() {
        let Some(text) = after_an_hour(300.0, 400.0, 600.0) else {
            return;
        };
        assert_eq!(
            text,
            "400.0 of 600 samples per pixel, 1:00:00 h, 2:00:00 h left"
        );
    }

    #[test]
    fn where_time_ends_a_render_its_samples_are_those_that_it_has() {
        let bar = Bar::read_by(Reader::People, "loading");
        let text = |samples, share, spp| {
            bar.update(&Reached { samples, share }, spp);
            bar.shared.lock().text()
        };
        assert!(text(16.0, 0.25, 64).starts_with("16.0 of 64 samples per pixel, "));
        assert!(text(17.0, 0.75, 64).starts_with("17.0 samples per pixel, "));
        // Where nobody said how many there are to be, they say nothing of the end.
        let share = 16.0 / f64::from(MAX_SPP);
        assert_eq!(text(16.0, share, MAX_SPP), "16.0 samples per pixel, 0 s");
    }
}
