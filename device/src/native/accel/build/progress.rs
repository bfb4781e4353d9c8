//! How far a build is, and whether it is still wanted.

use std::{
    ops::ControlFlow,
    sync::atomic::{AtomicBool, AtomicU64, Ordering},
};

/// Why there is no hierarchy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// The progress callback asked for it.
    #[error("building the ray hierarchy was cancelled")]
    Cancelled,
    /// More triangles than their numbers can count.
    #[error(
        "a mesh has {count} triangles, more than the {most} that rays can be traced against; split it"
    )]
    TooMany {
        /// Triangles of the mesh.
        count: usize,
        /// Most that a mesh may have.
        most: usize,
    },
    /// The processor's memory is used up.
    #[error(
        "the memory has no room left for the hierarchy of the geometry, {bytes} bytes; end what else uses it, or take a smaller scene"
    )]
    NoRoom {
        /// Bytes of what doesn't fit, a part of the hierarchy or of what it is built from.
        bytes: usize,
    },
}

impl BuildError {
    /// There is no memory for so many values.
    pub(in super::super) fn no_room<T>(length: usize) -> Self {
        Self::NoRoom {
            bytes: length.saturating_mul(size_of::<T>()),
        }
    }
}

/// Counts steps of n log n, and hands their share of the whole to a callback.
pub(in super::super) struct Progress<'a> {
    report: &'a (dyn Fn(f32) -> ControlFlow<()> + Sync),
    done: AtomicU64,
    total: f64,
    is_cancelled: AtomicBool,
}

impl<'a> Progress<'a> {
    /// For a build of `count` references.
    pub(in super::super) fn new(
        count: usize,
        report: &'a (dyn Fn(f32) -> ControlFlow<()> + Sync),
    ) -> Self {
        Self {
            report,
            done: AtomicU64::new(0),
            total: steps(count).max(1) as f64,
            is_cancelled: AtomicBool::new(false),
        }
    }

    /// A subtree of `count` references is done, all of it.
    pub(super) fn finish(&self, count: usize) {
        self.advance(steps(count));
    }

    /// One of `left + right` references has been split.
    pub(super) fn split(&self, left: usize, right: usize) {
        let below = steps(left) + steps(right);
        self.advance(steps(left + right).saturating_sub(below));
    }

    fn advance(&self, by: u64) {
        let done = self.done.fetch_add(by, Ordering::Relaxed) + by;
        let share = (done as f64 / self.total).min(1.0) as f32;
        if (self.report)(share).is_break() {
            self.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

/// What a subtree of `count` references takes.
fn steps(count: usize) -> u64 {
    (count as f64 * (count as f64).log2().max(1.0)) as u64
}
