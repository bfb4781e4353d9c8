//! Timestamp queries around dispatches.

use crate::DeviceError;

use super::Gpu;

/// Room for the timestamps of one recording.
#[derive(Debug)]
pub(crate) struct Timestamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Timestamps {
    /// Dispatches of one recording that can be timed.
    pub(crate) const CAPACITY: u32 = 1024;

    pub(crate) fn new(gpu: &Gpu) -> Result<Self, DeviceError> {
        let label = "timestamps";
        let queries = gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
            label: Some(label),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * Self::CAPACITY,
        });
        let bytes = u64::from(2 * Self::CAPACITY) * 8;
        let resolved = gpu.plain_buffer(label, wgpu::BufferUsages::QUERY_RESOLVE, bytes);
        gpu.check()?;
        Ok(Self { queries, resolved })
    }

    /// The queries before and behind a dispatch.
    pub(super) fn around(&self, dispatch: u32) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(2 * dispatch),
            end_of_pass_write_index: Some(2 * dispatch + 1),
        }
    }

    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder, dispatches: u32) {
        encoder.resolve_query_set(&self.queries, 0..2 * dispatches, &self.resolved, 0);
    }

    /// Of each dispatch of the recording that was played last. Waits for it.
    pub(crate) fn milliseconds(&self, gpu: &Gpu, dispatches: u32) -> Result<Vec<f64>, DeviceError> {
        let bytes = gpu.read(&self.resolved, 0, u64::from(dispatches) * 16)?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        let period = f64::from(gpu.queue().get_timestamp_period()) * 1e-6;
        let pairs = ticks.chunks_exact(2);
        Ok(pairs
            .map(|pair| pair[1].saturating_sub(pair[0]) as f64 * period)
            .collect())
    }
}
