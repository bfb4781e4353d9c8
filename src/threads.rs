//! Whether the system starts as many threads as a render needs. Libraries take that for granted, and panic where it
//! doesn't; so it is tried first.

use std::sync::mpsc::channel;
use std::thread::{self, JoinHandle};

use crate::console;
use crate::failure::Failure;

/// Beside those that compute: signals, progress, files that are watched, kernels that are built, and what drivers start.
const OTHERS: usize = 8;

/// Starts the threads that compute: so many, or one for each processor, or fewer where the system has a limit.
///
/// # Errors
/// It doesn't start even the fewest.
pub(crate) fn start(wanted: Option<usize>) -> Result<(), Failure> {
    let all = || thread::available_parallelism().map_or(1, usize::from);
    let wanted = wanted.unwrap_or_else(all);
    let mut count = wanted;
    while let Err(error) = try_out(count + OTHERS) {
        if count == 1 {
            return Err(Failure::Failed(format!(
                "cannot start threads: {error}; end other programs, or raise what is limited (`ulimit -u`, or `-v`, their memory)"
            )));
        }
        count = count.div_ceil(2);
    }
    if count < wanted {
        console::warning(&format!(
            "only {count} of {wanted} threads can be started, so this takes longer; a higher limit helps (`ulimit -u`, or `-v`, their memory)"
        ));
    }
    let started = rayon::ThreadPoolBuilder::new()
        .num_threads(count)
        .build_global();
    started.map_err(|error| Failure::Failed(format!("cannot start threads: {error}")))
}

/// Starts so many threads at once, and ends them.
fn try_out(count: usize) -> std::io::Result<()> {
    let mut ends = Vec::new();
    let mut threads: Vec<JoinHandle<()>> = Vec::new();
    let mut outcome = Ok(());
    for _ in 0..count {
        let (end, is_over) = channel::<()>();
        let wait = move || is_over.recv().unwrap_or_default();
        match thread::Builder::new().spawn(wait) {
            Ok(thread) => threads.push(thread),
            Err(error) => {
                outcome = Err(error);
                break;
            }
        }
        ends.push(end);
    }
    drop(ends);
    for thread in threads {
        let _ = thread.join();
    }
    outcome
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_few_threads_can_be_started() {
        super::try_out(3).expect("this machine has room for three");
    }
}
