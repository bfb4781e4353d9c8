//! Recordings as command buffers.

use crate::{Command, Extent, Recording, Timer, kernel::Bound};

use super::{Gpu, timestamps::Timestamps};

impl Gpu {
    /// Submits a recording. Each dispatch is a pass of its own: what it writes, the next one sees.
    pub(crate) fn play(
        &self,
        recording: &Recording,
        mut timer: Option<&mut Timer>,
    ) -> wgpu::SubmissionIndex {
        let mut encoder = self.encoder(recording.label());
        for command in recording.commands() {
            match command {
                Command::Dispatch(kernel, extent) => {
                    let Bound::Gpu(bound) = &kernel.bound else {
                        unreachable!("kernels are bound to the device that plays them");
                    };
                    let timed = timer.as_mut().and_then(|timer| timer.next(kernel.label()));
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                        label: Some(kernel.label()),
                        timestamp_writes: timed.map(|(timestamps, n)| timestamps.around(n)),
                    });
                    pass.set_pipeline(&bound.pipeline);
                    pass.set_bind_group(0, &bound.group, &[]);
                    match extent {
                        Extent::Threads(threads) => {
                            let [x, y] = Extent::groups(*threads);
                            pass.dispatch_workgroups(x, y, 1);
                        }
                        Extent::One => pass.dispatch_workgroups(1, 1, 1),
                        Extent::Indirect(sizes, offset) => {
                            pass.dispatch_workgroups_indirect(sizes.gpu(), *offset);
                        }
                    }
                }
                Command::Clear(buffer) => encoder.clear_buffer(buffer.gpu(), 0, None),
                Command::Copy { from, to, bytes } => {
                    encoder.copy_buffer_to_buffer(from.gpu(), 0, to.gpu(), 0, *bytes);
                }
            }
        }
        if let Some((timestamps, count)) = timer.as_ref().and_then(|timer| timer.end()) {
            Timestamps::resolve(timestamps, &mut encoder, count);
        }
        self.queue().submit([encoder.finish()])
    }
}
