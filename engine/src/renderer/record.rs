//! Recording of a wave's passes: each is dispatched over its work.

use device::{BoundKernel, Buffer, Extent, Recording};

use crate::{
    passes::pass::{Pass, Work},
    schedule::Run,
};

use super::pipeline::Bound;

/// Records passes into one list.
pub(super) struct Recorder<'a> {
    bound: &'a Bound,
    sizes: &'a Buffer,
    paths: u32,
    recording: Recording,
}

impl<'a> Recorder<'a> {
    /// For waves of so many paths; the sizes of queues are written by the kernels.
    pub(super) fn new(bound: &'a Bound, sizes: &'a Buffer, paths: u32) -> Self {
        Self {
            bound,
            sizes,
            paths,
            recording: Recording::new("wave"),
        }
    }

    /// Runs a kernel that is not among the renderer's own, over the work of a pass.
    pub(super) fn run_kernel(&mut self, kernel: &BoundKernel, work: Work) {
        let extent = match work {
            Work::Paths => Extent::Threads(self.paths),
            Work::Queue(queue) => Extent::Indirect(self.sizes.clone(), queue.dispatch_offset()),
            Work::Single => Extent::One,
        };
        self.recording.dispatch(kernel, extent);
    }

    pub(super) fn finish(self) -> Recording {
        self.recording
    }
}

impl Run for Recorder<'_> {
    fn run(&mut self, pass: &'static Pass) {
        for kernel in self.bound.get(pass) {
            self.run_kernel(kernel, pass.work);
        }
    }
}
