//! What the engine wants of the system that it runs in: files, the time, and threads.
//!
//! They are handed in, so that a program whose files come over a wire, or which has no threads, can hand in its own; the
//! [default](System::default) is what the operating system has.

use std::any::Any;
use std::fmt::Debug;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use crate::scene::import::{ImportError, Imported, Importer};

pub use crate::input::{Disk, Files};

/// Parsing, by naga too, recurses along a texture's expressions.
const STACK_BYTES: usize = 8 << 20;

/// What a picture is made of: files, and scenes that may be none.
pub trait Assets: Files {
    /// The scene at a path: the file there, unless one has it otherwise.
    ///
    /// # Errors
    /// It can't be read, or is wrong.
    fn scene(&self, importer: &mut Importer, path: &Path) -> Result<Imported, ImportError> {
        importer.load(path)
    }
}

impl Assets for Disk {}

/// The time since some moment.
pub trait Clock: Debug + Send + Sync {
    /// It never goes back.
    fn now(&self) -> Duration;
}

/// Where work is done aside.
pub trait Threads: Debug + Send + Sync {
    /// Begins work that is called `name`. Without threads it may be done before this returns.
    ///
    /// # Errors
    /// The system refuses.
    fn spawn(&self, name: &str, work: Box<dyn FnOnce() + Send>) -> io::Result<()>;
}

/// All of them.
#[derive(Debug, Clone)]
pub struct System {
    /// Files.
    pub files: Arc<dyn Assets>,
    /// The time.
    pub clock: Arc<dyn Clock>,
    /// Threads.
    pub threads: Arc<dyn Threads>,
}

impl Default for System {
    /// The operating system's.
    fn default() -> Self {
        Self {
            files: Arc::new(Disk),
            clock: Arc::new(SystemClock),
            threads: Arc::new(SystemThreads),
        }
    }
}

/// The operating system's clock.
#[derive(Debug, Clone, Copy, Default)]
pub struct SystemClock;

impl Clock for SystemClock {
    fn now(&self) -> Duration {
        static START: LazyLock<Instant> = LazyLock::new(Instant::now);
        START.elapsed()
    }
}

/// The operating system's threads.
#[derive(Debug, Clone, Copy, Default)]
pub struct SystemThreads;

impl Threads for SystemThreads {
    fn spawn(&self, name: &str, work: Box<dyn FnOnce() + Send>) -> io::Result<()> {
        let thread = std::thread::Builder::new()
            .name(name.to_owned())
            .stack_size(STACK_BYTES);
        // Who began the work learns of its end by its result.
        thread.spawn(work).map(drop)
    }
}

/// Work that is done aside. Dropped, it is done for nothing.
#[derive(Debug)]
pub(crate) struct Task<T> {
    result: Receiver<Result<T, String>>,
    is_finished: Arc<AtomicBool>,
}

impl<T: Send + 'static> Task<T> {
    pub(crate) fn start(
        threads: &dyn Threads,
        name: &str,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> io::Result<Self> {
        let (sender, result) = channel();
        let is_finished = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&is_finished);
        let work = move || {
            // What is left half done is dropped with the work.
            let outcome = catch_unwind(AssertUnwindSafe(work)).map_err(|panic| said(&*panic));
            // Nobody may want it any more.
            let _ = sender.send(outcome);
            flag.store(true, Ordering::Release);
        };
        threads.spawn(name, Box::new(work))?;
        Ok(Self {
            result,
            is_finished,
        })
    }

    /// Whether [`Self::wait`] doesn't wait.
    pub(crate) fn is_finished(&self) -> bool {
        self.is_finished.load(Ordering::Acquire)
    }

    /// The result.
    ///
    /// # Errors
    /// It ended without one: says why.
    pub(crate) fn wait(self) -> Result<T, String> {
        let lost = |_| Err("it was never done".to_owned());
        self.result.recv().unwrap_or_else(lost)
    }
}

/// What a panic said.
pub(crate) fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
    text.unwrap_or("it panicked").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work is done at once.
    #[derive(Debug)]
    struct NoThreads;

    impl Threads for NoThreads {
        fn spawn(&self, _: &str, work: Box<dyn FnOnce() + Send>) -> io::Result<()> {
            work();
            Ok(())
        }
    }

    #[test]
    fn a_task_gives_its_result_or_says_why_there_is_none() {
        for threads in [&SystemThreads as &dyn Threads, &NoThreads] {
            let sum = Task::start(threads, "a sum", || 1 + 1).expect("there is room");
            assert_eq!(sum.wait(), Ok(2));
            let panics = Task::start(threads, "a panic", || -> u32 { panic!("odd: {}", 3) });
            let panics = panics.expect("there is room");
            while !panics.is_finished() {
                std::thread::yield_now();
            }
            assert_eq!(panics.wait(), Err("odd: 3".to_owned()));
        }
    }
}
