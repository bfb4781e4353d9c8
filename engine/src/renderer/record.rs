//! Recording of a wave's passes: what a round is.

use crate::{
    gpu::{
        Gpu,
        kernel::{BoundKernel, Extent},
        timing::Timer,
    },
    passes::{advance::After, traverse::Rays},
    wave::Queue,
};

use super::pipeline::Bound;

/// Records passes into one submission.
pub(super) struct Recorder<'a> {
    pub(super) bound: &'a Bound,
    sizes: &'a wgpu::Buffer,
    timer: &'a mut Timer,
    encoder: wgpu::CommandEncoder,
}

impl<'a> Recorder<'a> {
    pub(super) fn new(
        gpu: &Gpu,
        bound: &'a Bound,
        sizes: &'a wgpu::Buffer,
        timer: &'a mut Timer,
    ) -> Self {
        let descriptor = wgpu::CommandEncoderDescriptor {
            label: Some("wave"),
        };
        Self {
            bound,
            sizes,
            timer,
            encoder: gpu.device().create_command_encoder(&descriptor),
        }
    }

    pub(super) fn run(&mut self, kernel: &BoundKernel, extent: Extent<'_>) {
        let timestamps = self.timer.pass(kernel.label());
        kernel.record(&mut self.encoder, extent, timestamps);
    }

    /// Runs as many threads as the queue has entries.
    pub(super) fn run_queue(&mut self, kernel: &BoundKernel, queue: Queue) {
        self.run(
            kernel,
            Extent::Indirect(self.sizes, queue.dispatch_offset()),
        );
    }

    pub(super) fn after(&self, pass: After) -> &'a BoundKernel {
        &self.bound.advance[pass as usize]
    }

    /// Takes each path that is under way to its next surface.
    pub(super) fn round(&mut self) {
        self.find_hits();
        let bound = self.bound;
        self.run_queue(&bound.brdf, Queue::Active);
        self.run(self.after(After::Brdf), Extent::One);
        self.run_queue(&bound.traverse[Rays::Occlusion as usize], Queue::Shadow);
    }

    /// The first half of a round: what rays meet, and what the texture programs say about it.
    pub(super) fn find_hits(&mut self) {
        let bound = self.bound;
        self.run_queue(&bound.traverse[Rays::Closest as usize], Queue::Active);
        if let Some(texture) = &bound.texture {
            self.run_queue(&texture.classify, Queue::Active);
            self.run(self.after(After::Classify), Extent::One);
            self.run_queue(&texture.ao, Queue::Ao);
            self.run_queue(&texture.proctex, Queue::Proctex);
        }
    }

    pub(super) fn finish(mut self) -> wgpu::CommandBuffer {
        self.timer.resolve(&mut self.encoder);
        self.encoder.finish()
    }
}
