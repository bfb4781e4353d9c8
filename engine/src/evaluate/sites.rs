//! Programs of a whole graph at places that somebody else computes, many at a time.

use texgen::Program;

use crate::gpu_scene::images::GpuImages;
use crate::procedural::Procedural;
use crate::scene::Scene;
use device::{Device, Kernel};

use super::host::{self, Occlusion};
use super::{BATCH, EvaluateError, Layout, compiled, dispatch, resources};

/// The kernel of a graph, with its images.
#[derive(Debug)]
pub(crate) struct Sites<'a> {
    device: &'a Device,
    procedural: &'a Procedural,
    images: GpuImages,
    layout: Layout,
    kernel: Kernel,
}

impl<'a> Sites<'a> {
    /// Compiles the kernel, with room for programs of the graph's materials, and for others that need at most `slots`. `AO` of a
    /// place has a component for each table of ambient occlusion.
    ///
    /// # Errors
    /// The device refuses.
    pub(crate) fn new(
        device: &'a Device,
        scene: &Scene,
        procedural: &'a Procedural,
        slots: u32,
    ) -> Result<Self, EvaluateError> {
        let library = procedural.graph().library();
        let layout = Layout::new(library.custom_attributes());
        let source = host::source(
            &layout,
            Occlusion::Tables,
            &library.emit(procedural.stack_slots().max(slots)),
        );
        Ok(Self {
            device,
            procedural,
            images: GpuImages::new(device, scene, &procedural.reads())?,
            kernel: compiled(device, library, &layout, Occlusion::Tables, &source)?,
            layout,
        })
    }

    /// Where the values of a place lie.
    pub(crate) fn layout(&self) -> &Layout {
        &self.layout
    }

    /// For each place the results at `links`: `values` has [`Layout::stride`] of them for each.
    ///
    /// # Errors
    /// A loop doesn't end, or the device fails.
    pub(crate) fn run(
        &self,
        program: &Program,
        links: &[u32],
        values: &[[f32; 4]],
    ) -> Result<Vec<[f32; 4]>, EvaluateError> {
        let args = self.procedural.args();
        let mut resources = resources(self.device, &self.images, &program.words, args, links)?;
        let stride = self.layout.stride();
        let mut results = Vec::with_capacity(values.len() / stride * links.len());
        for batch in values.chunks(BATCH * stride) {
            let count = batch.len() / stride;
            let mut words = Vec::with_capacity(1 + batch.len());
            words.push([count as u32, self.images.user_base, links.len() as u32, 0]);
            words.extend(batch.iter().map(|value| value.map(f32::to_bits)));
            results.extend(dispatch(
                self.device,
                &self.kernel,
                self.procedural,
                &mut resources,
                &words,
                count,
            )?);
        }
        Ok(results)
    }
}
