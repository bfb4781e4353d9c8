//! The `patina` command: renders scenes, opens a window on them, merges films, compares pictures, tells what files hold, reads MaterialX, writes jobs
//! for farms, works on textures, lists devices, measures itself.
//!
//! This file only walks the path every invocation takes: raw flags ([`args`]) become a validated [`job`], the job
//! is run by the file named after it, and what came of it becomes an exit code ([`exit`]). Nothing is decided here.

mod accuracy;
mod args;
mod bake;
mod bench;
mod cache;
mod compare;
mod console;
mod crash;
mod denoise;
mod devices;
mod exit;
mod export;
mod failure;
mod farm;
mod fault;
mod flags;
mod form;
mod import;
mod info;
mod interrupt;
mod job;
mod left;
mod library;
mod manuals;
mod memory;
mod merge;
mod motion;
mod output;
mod overrides;
mod picture;
mod probe;
mod progress;
mod recent;
mod render;
mod report;
mod texture;
mod threads;
mod usage;
mod view;
mod watch;
mod words;

use std::process::ExitCode;
use std::thread;

use clap::Parser;

use args::Args;
use failure::Failure;
use job::Job;

/// Bytes of the stack that all but a window has. The first thread's grows, and where the memory that it would grow into is taken or may not
/// be had, the system ends the program without a word.
const STACK: usize = 8 << 20;

/// The exit code of a fault, which has been told.
const FAULT: u8 = 101;

/// What is left to the first thread.
enum Left {
    /// It is done.
    Nothing(ExitCode),
    /// A window, which no other thread may have.
    Window(Box<Job>),
}

fn main() -> ExitCode {
    // Mesa's device-selection layer complains on machines without a display; the device is chosen by `--device`.
    // SAFETY: nothing else runs yet that could read the environment.
    unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    fault::install();
    match thread::Builder::new().stack_size(STACK).spawn(begin) {
        Ok(begun) => match begun.join() {
            Ok(Left::Nothing(code)) => code,
            Ok(Left::Window(job)) => exit::with(run(*job)),
            Err(_) => ExitCode::from(FAULT),
        },
        Err(error) => {
            console::set_format(args::message_format(std::env::args_os()));
            exit::with(Err(Failure::Failed(format!(
                "cannot start a thread: {error}; end other programs, or raise what is limited (`ulimit -u`, or `-v`, their memory)"
            ))))
        }
    }
}

/// All but a window.
fn begin() -> Left {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(answer) => {
            console::set_format(args::message_format(std::env::args_os()));
            return Left::Nothing(exit::with_clap(&answer));
        }
    };
    console::set_format(args.message_format);
    if args.quiet {
        console::set_quiet();
    }
    let job = Job::from_args(args).map_err(Failure::from);
    let ready = |job: Job| {
        interrupt::listen()
            .and_then(|()| threads::start(job.threads()))
            .map(|()| job)
    };
    match job.and_then(ready) {
        Ok(job @ Job::View(_)) => Left::Window(Box::new(job)),
        job => Left::Nothing(exit::with(job.and_then(run))),
    }
}

fn run(job: Job) -> Result<(), Failure> {
    match job {
        Job::Render(job) => render::run(&job),
        Job::Watch(job) => watch::run(&job),
        Job::View(job) => view::run(&job),
        Job::Merge(job) => merge::run(&job),
        Job::Farm(job) => farm::export(&job),
        Job::Compare(job) => compare::run(&job),
        Job::Info(job) => info::run(&job),
        Job::Import(job) => import::run(&job),
        Job::Bake(job) => bake::run(&job),
        Job::Export(job) => export::run(&job),
        Job::Texture(job) => texture::run(job),
        Job::Devices => {
            devices::run();
            Ok(())
        }
        Job::Manuals(dir) => manuals::write(&dir),
        Job::ProbeTexture { file, device } => crash::probe(&file, &device),
        Job::Bench(job) => bench::run(&job),
    }
}
