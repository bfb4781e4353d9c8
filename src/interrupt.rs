//! Ctrl-C, SIGTERM, SIGHUP, and SIGXCPU, by which a limit of processor time tells that it is reached. Where there are results, the
//! first signal asks for them to be written; where there are none yet, at the second signal (unless it is an echo of the first), and
//! where a driver doesn't come back, the program ends at once. Either way nothing that is half done stays behind, and the exit code says
//! which signal it was: 128 and its number.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use crate::failure::Failure;
use crate::{console, probe, progress};

/// So long a driver may take to come back, so that results can be written.
const PATIENCE: Duration = Duration::from_secs(4);

/// A second signal within this time comes with the first: `timeout` sends one to the program and one to its group, and so do others that
/// start programs.
const ECHO: Duration = Duration::from_millis(500);

/// What the exit code of a signal adds to its number, as shells do.
const CODE: i32 = 128;

/// What is said where there are no results yet.
pub(crate) const NOTHING: &str = "interrupted before there was anything to write";

/// The first signal; 0 before it.
static SIGNAL: AtomicI32 = AtomicI32::new(0);
/// When it came, if there were results.
static CAME: OnceLock<Instant> = OnceLock::new();
/// There is something to be written before the end.
static HAS_RESULTS: AtomicBool = AtomicBool::new(false);

/// The results are being written.
static IS_WRITING: AtomicBool = AtomicBool::new(false);

/// Wakes whoever writes the results, where he waits for something else.
static WAKE: Mutex<Option<Box<dyn Fn() + Send>>> = Mutex::new(None);

/// Starts listening.
///
/// # Errors
/// The system starts no thread.
pub(crate) fn listen() -> Result<(), Failure> {
    system::listen().map_err(|error| {
        Failure::Failed(format!(
            "cannot start a thread: {error}; end other programs, or raise what is limited (`ulimit -u`, or `-v`, their memory)"
        ))
    })
}

/// Says that there are results from now on: the first signal no longer ends the program, [`requested`] tells of it.
pub(crate) fn has_results() {
    HAS_RESULTS.store(true, Ordering::SeqCst);
}

/// Has this called when a signal comes that [`requested`] tells of. It is called on another thread.
pub(crate) fn wake_by(wake: impl Fn() + Send + 'static) {
    *WAKE.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(wake));
}

/// Says that the results are written, and that the program is about to end by itself: after so long it does in any case.
pub(crate) fn leave_within(patience: Duration) {
    // Without it a second signal is needed where a window doesn't close.
    let _ = std::thread::Builder::new().spawn(move || leave_after(patience));
}

fn leave_after(patience: Duration) {
    std::thread::sleep(patience);
    leave()
}

/// Says that the results are about to be written: however long that takes, it is waited for.
pub(crate) fn writes_results() {
    has_results();
    IS_WRITING.store(true, Ordering::SeqCst);
}

/// Says that they are written, and that another picture is begun: a driver that hangs is not waited for any more.
pub(crate) fn goes_on() {
    IS_WRITING.store(false, Ordering::SeqCst);
}

/// Whether the end has been asked for.
pub(crate) fn requested() -> bool {
    SIGNAL.load(Ordering::SeqCst) != 0
}

/// Whether a process ended by a signal that asks for the end, or with the exit code of one.
pub(crate) fn is_cause_of(status: std::process::ExitStatus) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        if status
            .signal()
            .is_some_and(|signal| system::ALL.contains(&signal))
        {
            return true;
        }
    }
    let of_signal = |signal: &i32| status.code() == Some(CODE + signal);
    system::ALL.iter().any(of_signal)
}

/// A signal has come.
fn arrived(signal: i32) {
    let first = SIGNAL.compare_exchange(0, signal, Ordering::SeqCst, Ordering::SeqCst);
    match first {
        Ok(_) if HAS_RESULTS.load(Ordering::SeqCst) => {
            CAME.get_or_init(Instant::now);
            // Without it a second signal is needed where a driver hangs.
            let _ = std::thread::Builder::new().spawn(end_if_stuck);
            let wake = WAKE.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(wake) = &*wake {
                wake();
            }
        }
        Ok(_) => {
            progress::clear_line();
            console::warning(NOTHING);
            leave();
        }
        // Once the time is over, this comes again with every second more on a processor: nobody has lost patience.
        Err(_) if system::comes_by_itself(signal) => {}
        Err(_) if CAME.get().is_some_and(|came| came.elapsed() < ECHO) => {}
        Err(_) => leave(),
    }
}

/// Ends the program where it is still waiting for a driver, as while that compiles.
fn end_if_stuck() {
    std::thread::sleep(PATIENCE);
    if !IS_WRITING.load(Ordering::SeqCst) {
        progress::clear_line();
        console::warning("interrupted: the device is busy, so nothing more could be written");
        leave();
    }
}

/// Ends the program with the code of the signal that came. Threads that are in a driver are not waited for.
pub(crate) fn leave() -> ! {
    probe::end();
    engine::aside::discard_all();
    let _ = io::stdout().flush();
    system::exit(CODE + SIGNAL.load(Ordering::SeqCst))
}

#[cfg(unix)]
mod system {
    use std::io;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXCPU};
    use signal_hook::iterator::Signals;

    pub(super) const ALL: [i32; 4] = [SIGINT, SIGTERM, SIGHUP, SIGXCPU];

    /// Whether the system sends a signal, again and again, and no person.
    pub(super) fn comes_by_itself(signal: i32) -> bool {
        signal == SIGXCPU
    }

    pub(super) fn listen() -> io::Result<()> {
        bear_limits_of_files();
        // `nohup` has SIGHUP ignored, and that is meant for its children too; so it is where others have the end of the time ignored.
        let may_be_ignored = |s| matches!(s, SIGHUP | SIGXCPU);
        let wanted = (ALL.into_iter()).filter(|&s| !may_be_ignored(s) || !is_ignored(s));
        let mut signals = Signals::new(wanted)?;
        std::thread::Builder::new()
            .name("signals".to_owned())
            .spawn(move || signals.forever().for_each(super::arrived))?;
        Ok(())
    }

    /// Where a file grows beyond what is allowed (`ulimit -f`, the limits of batch systems), writing to it fails from now on, and all
    /// else is kept as on a full disk. By default the signal of that ends the program at once.
    fn bear_limits_of_files() {
        // SAFETY: the call has no function of ours called; nothing else here sets or reads what this signal does.
        unsafe {
            libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
        }
    }

    fn is_ignored(signal: i32) -> bool {
        let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: without a new action the call only writes the present one to the place it is given; all zeros are a
        // valid one should it fail.
        let action = unsafe {
            libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr());
            action.assume_init()
        };
        action.sa_sigaction == libc::SIG_IGN
    }

    /// Without the C library's clean-up, which other threads may not survive.
    pub(super) fn exit(code: i32) -> ! {
        signal_hook::low_level::exit(code)
    }
}

#[cfg(not(unix))]
mod system {
    use std::io;

    /// Ctrl-C and the closing of the console count as SIGINT.
    const INTERRUPT: i32 = 2;
    pub(super) const ALL: [i32; 1] = [INTERRUPT];

    /// Whether the system sends a signal, again and again, and no person.
    pub(super) fn comes_by_itself(_signal: i32) -> bool {
        false
    }

    pub(super) fn listen() -> io::Result<()> {
        ctrlc::set_handler(|| super::arrived(INTERRUPT)).map_err(io::Error::other)
    }

    pub(super) fn exit(code: i32) -> ! {
        std::process::exit(code)
    }
}
