//! What a device is busy with that may take minutes, for those who tell the people that wait.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What is under way now, if it is something that may take long. Clones share it.
#[derive(Debug, Clone, Default)]
pub struct Activity(Arc<Mutex<Option<(String, Instant)>>>);

/// Something is under way until this is dropped.
#[derive(Debug)]
pub struct Busy(Option<Activity>);

impl Activity {
    /// Says what begins now, as in `compiling the kernel brdf`. What is a part of something under way isn't told apart.
    pub fn begin(&self, what: impl FnOnce() -> String) -> Busy {
        let mut current = self.lock();
        if current.is_some() {
            return Busy(None);
        }
        *current = Some((what(), Instant::now()));
        Busy(Some(self.clone()))
    }

    /// What is under way, and for how long.
    pub fn current(&self) -> Option<(String, Duration)> {
        let current = self.lock();
        let (what, since) = current.as_ref()?;
        Some((what.clone(), since.elapsed()))
    }

    fn lock(&self) -> MutexGuard<'_, Option<(String, Instant)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Busy {
    /// Says more of what is under way, where this tells it.
    pub fn tell(&self, what: impl FnOnce() -> String) {
        if let Some(activity) = &self.0
            && let Some((told, _)) = &mut *activity.lock()
        {
            *told = what();
        }
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        if let Some(activity) = &self.0 {
            *activity.lock() = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_is_told_not_its_parts() {
        let activity = Activity::default();
        assert!(activity.current().is_none());
        let whole = activity.begin(|| "compiling the texture `rust`".to_owned());
        let part = activity.begin(|| "compiling a part".to_owned());
        drop(part);
        let (what, _) = activity.current().expect("it is under way");
        assert_eq!(what, "compiling the texture `rust`");
        whole.tell(|| "compiling the texture `rust`, half of it".to_owned());
        let (what, _) = activity.current().expect("it is under way");
        assert!(what.ends_with("half of it"));
        drop(whole);
        assert!(activity.current().is_none());
    }
}
