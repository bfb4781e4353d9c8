//! The progress bar of a render: samples, samples per second, remaining time; of a measurement: steps and remaining
//! time. Silent where stderr isn't a terminal.

use std::fmt::Write;
use std::io::{self, IsTerminal};
use std::time::Duration;

use engine::renderer::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::console;

/// A line on the terminal that follows one render.
pub(crate) struct Bar {
    bar: ProgressBar,
    started: bool,
}

impl Bar {
    /// A bar that shows `stage` until the first samples arrive.
    pub(crate) fn new(stage: &'static str) -> Self {
        let target = if io::stderr().is_terminal() && !console::is_json() {
            // Ten times a second is smooth enough and costs a render on the CPU nothing.
            ProgressDrawTarget::stderr_with_hz(10)
        } else {
            ProgressDrawTarget::hidden()
        };
        let bar = ProgressBar::with_draw_target(None, target);
        bar.set_style(style("{spinner} {msg} {elapsed}"));
        bar.set_message(stage);
        bar.enable_steady_tick(Duration::from_millis(200));
        Self {
            bar,
            started: false,
        }
    }

    /// Shows another stage of the work before rendering.
    pub(crate) fn stage(&self, stage: &'static str) {
        self.bar.set_message(stage);
    }

    /// Runs `print` with the bar out of the way of other lines.
    pub(crate) fn suspend(&self, print: impl FnOnce()) {
        self.bar.suspend(print);
    }

    /// Shows how far the render is.
    pub(crate) fn update(&mut self, progress: &Progress) {
        if !self.started {
            self.started = true;
            self.bar.disable_steady_tick();
            self.bar.set_style(
                style("{bar:32} {human_pos}/{human_len} samples  {rate}  {eta} left")
                    .with_key("rate", |state: &ProgressState, text: &mut dyn Write| {
                        let _ = write!(text, "{} samples/s", console::short(state.per_sec()));
                    })
                    .progress_chars("=> "),
            );
            self.bar.set_length(progress.samples_total);
            self.bar.reset_elapsed();
            self.bar.reset_eta();
        }
        self.bar.set_length(progress.samples_total);
        self.bar.set_position(progress.samples_done);
    }

    /// Shows from now on how many of `total` steps are done, and about how long the rest will take.
    pub(crate) fn count(&self, total: u64) {
        self.bar.set_style(
            style("{msg} {bar:32} {pos}/{len}  {elapsed}, about {eta} left").progress_chars("=> "),
        );
        self.bar.set_length(total);
        self.bar.reset_elapsed();
        self.bar.reset_eta();
    }

    /// One step of [`Self::count`] is done.
    pub(crate) fn step(&self) {
        self.bar.inc(1);
    }

    /// Removes the bar so that other lines can be printed.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Bar {
    /// An error message must not share the bar's line.
    fn drop(&mut self) {
        self.finish();
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the templates in this file are well-formed")
}
