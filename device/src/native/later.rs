//! Code that may come later: threads that compile it once a kernel has been of use for a while.

use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

/// How long a kernel has to live before better code is made of it: pictures that are done sooner, and texts that are about to
/// change again, are not kept waiting.
const AFTER: Duration = Duration::from_millis(250);

/// What is under way. Clones share it.
#[derive(Debug, Clone, Default)]
pub(super) struct Later {
    shared: Arc<(Mutex<State>, Condvar)>,
}

#[derive(Debug, Default)]
struct State {
    under_way: u32,
    /// Callers that wait for all of it.
    waiting: u32,
}

/// Code is written by recursion along what it is made of.
const STACK_BYTES: usize = 8 << 20;

/// Something that is not done yet.
struct UnderWay(Later);

impl Drop for UnderWay {
    fn drop(&mut self) {
        self.0.state().under_way -= 1;
        self.0.shared.1.notify_all();
    }
}

impl Later {
    /// Does something in a while, on a thread of its own. Not at all where there is none to be had.
    pub(super) fn run(&self, work: impl FnOnce() + Send + 'static) {
        let own = self.clone();
        own.state().under_way += 1;
        let after = move || {
            // Whatever becomes of it, nobody waits for it any more.
            let under_way = UnderWay(own);
            let changed = &under_way.0.shared.1;
            let calm = |state: &mut State| state.waiting == 0;
            drop(changed.wait_timeout_while(under_way.0.state(), AFTER, calm));
            work();
        };
        let named = std::thread::Builder::new()
            .name("better code".to_owned())
            .stack_size(STACK_BYTES);
        if named.spawn(after).is_err() {
            self.state().under_way -= 1;
        }
    }

    /// Waits until all of it is done, which now begins at once.
    pub(super) fn finish(&self) {
        let changed = &self.shared.1;
        let mut state = self.state();
        state.waiting += 1;
        changed.notify_all();
        let busy = |state: &mut State| state.under_way > 0;
        let done = changed.wait_while(state, busy);
        done.unwrap_or_else(PoisonError::into_inner).waiting -= 1;
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.shared.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    #[test]
    fn whoever_waits_needn_t_wait_long() {
        let later = Later::default();
        let count = Arc::new(AtomicU32::new(0));
        for _ in 0..3 {
            let count = Arc::clone(&count);
            later.run(move || {
                count.fetch_add(1, Ordering::Relaxed);
            });
        }
        later.finish();
        assert_eq!(count.load(Ordering::Relaxed), 3);
        later.finish();
    }
}
