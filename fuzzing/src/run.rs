//! Runs targets on changed seeds, each input by a number of its own, so that one that fails can be made again.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use crate::mutate::Random;
use crate::{Scratch, Target};

/// No input may take longer; the slowest take a second, but a machine may be busy.
const TIME_LIMIT: Duration = Duration::from_secs(60);

/// What was tried.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tried {
    /// Inputs.
    pub inputs: u64,
    /// Of these, those that were accepted.
    pub accepted: u64,
    /// What the slowest took, and its number.
    pub slowest: (Duration, u64),
}

/// The input of a number: the seeds themselves come first.
pub fn input(target: &Target, seeds: &[Vec<u8>], number: u64) -> Vec<u8> {
    if let Some(seed) = usize::try_from(number).ok().and_then(|n| seeds.get(n)) {
        return seed.clone();
    }
    // The first numbers of near seeds would be alike.
    let mut random = Random(number.wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(32));
    let mut data = seeds[random.below(seeds.len())].clone();
    // Few at once, so that some get past the first look at them.
    for _ in 0..1 + random.below(2) * random.below(3) {
        data = (target.mutate)(&data, &mut random);
    }
    data
}

/// Tries the inputs of the numbers from `first` on until there are enough of them or the time is over. Files that targets write are
/// gone then.
///
/// # Panics
/// One of them fails or takes too long: it is written to the temporary folder, and the panic names the file.
pub fn run(target: &Target, first: u64, most: u64, budget: Duration) -> Tried {
    let (sender, receiver) = mpsc::channel();
    let target = *target;
    let _scratch = Scratch::hold();
    // A thread of its own, since one that hangs can't be ended.
    let worker = thread::spawn(move || {
        let _scratch = Scratch::hold();
        let seeds = (target.seeds)();
        let start = Instant::now();
        for number in first..first.saturating_add(most) {
            let began = Instant::now();
            if began - start > budget {
                break;
            }
            let data = input(&target, &seeds, number);
            // The receiver is gone only after a failure.
            let _ = sender.send(Event::Begins(number, data.clone()));
            let outcome = catch_unwind(AssertUnwindSafe(|| (target.run)(&data)));
            let Ok(accepted) = outcome else {
                let _ = sender.send(Event::Fails);
                break;
            };
            let _ = sender.send(Event::Done(accepted, began.elapsed()));
        }
    });
    let mut tried = Tried::default();
    let mut current = (first, Vec::new());
    let fail = |what: &str, (number, data): &(u64, Vec<u8>)| -> ! {
        let path = kept(&target, &format!("{number}"), data);
        panic!(
            "{}: input {number} {what}; it is kept in {}; repeat it by `cargo run -p fuzzing -- {0} {}`",
            target.name,
            path.display(),
            path.display()
        );
    };
    loop {
        match receiver.recv_timeout(TIME_LIMIT) {
            Ok(Event::Begins(number, data)) => current = (number, data),
            Ok(Event::Done(accepted, took)) => {
                tried.inputs += 1;
                tried.accepted += u64::from(accepted);
                tried.slowest = tried.slowest.max((took, current.0));
            }
            Ok(Event::Fails) => fail("fails", &current),
            Err(RecvTimeoutError::Timeout) => fail("takes too long", &current),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    if worker.join().is_err() {
        fail("fails", &current);
    }
    tried
}

enum Event {
    Begins(u64, Vec<u8>),
    Done(bool, Duration),
    Fails,
}

/// Writes an input that fails to where it can be found.
fn kept(target: &Target, name: &str, data: &[u8]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("patina-fuzzing-{}-{name}", target.name));
    if let Err(error) = std::fs::write(&path, data) {
        eprintln!("{}: {error}", path.display());
    }
    path
}

/// Writes the seeds of a target into a folder, as libFuzzer wants them.
///
/// # Errors
/// What the system says.
pub fn write_seeds(target: &Target, folder: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for (number, seed) in (target.seeds)().iter().enumerate() {
        std::fs::write(folder.join(format!("seed-{number}")), seed)?;
    }
    Ok(())
}
