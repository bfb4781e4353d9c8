//! Time of each pass on the device, by timestamp queries.

use std::collections::BTreeMap;

use super::{Gpu, GpuError};

/// Passes that one command buffer may time.
const CAPACITY: u32 = 1024;

/// Collects the time of passes by label. Without timestamp queries it only counts dispatches.
#[derive(Debug)]
pub struct Timer {
    queries: Option<(wgpu::QuerySet, wgpu::Buffer)>,
    labels: Vec<String>,
    totals: BTreeMap<String, (f64, u64)>,
}

impl Timer {
    /// Without `enabled`, or where the adapter has no timestamps, nothing is timed.
    ///
    /// # Errors
    /// If the device is out of memory.
    pub fn new(gpu: &Gpu, enabled: bool) -> Result<Self, GpuError> {
        let queries = if enabled && gpu.description().timestamps {
            let set = gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * CAPACITY,
            });
            let buffer = gpu.empty_buffer(
                "pass timestamps",
                u64::from(2 * CAPACITY) * 8,
                wgpu::BufferUsages::QUERY_RESOLVE,
            )?;
            Some((set, buffer))
        } else {
            None
        };
        Ok(Self {
            queries,
            labels: Vec::new(),
            totals: BTreeMap::new(),
        })
    }

    /// Whether times are measured.
    pub fn is_timing(&self) -> bool {
        self.queries.is_some()
    }

    /// The queries for the next pass, which is labelled `label`.
    pub fn pass(&mut self, label: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.totals.entry(label.to_owned()).or_default().1 += 1;
        let (set, _) = self.queries.as_ref()?;
        let index = self.labels.len() as u32;
        if index >= CAPACITY {
            return None;
        }
        self.labels.push(label.to_owned());
        Some(wgpu::ComputePassTimestampWrites {
            query_set: set,
            beginning_of_pass_write_index: Some(2 * index),
            end_of_pass_write_index: Some(2 * index + 1),
        })
    }

    /// Ends a command buffer: its queries are resolved.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some((set, buffer)) = &self.queries
            && !self.labels.is_empty()
        {
            encoder.resolve_query_set(set, 0..2 * self.labels.len() as u32, buffer, 0);
        }
    }

    /// Reads the times of the command buffer that was submitted last; waits for it.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn collect(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let Some((_, buffer)) = &self.queries else {
            return Ok(());
        };
        if self.labels.is_empty() {
            return Ok(());
        }
        let bytes = gpu.read_buffer(buffer, 0, self.labels.len() as u64 * 16)?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        let milliseconds = f64::from(gpu.queue().get_timestamp_period()) * 1e-6;
        for (label, pair) in self.labels.drain(..).zip(ticks.chunks_exact(2)) {
            self.totals.entry(label).or_default().0 +=
                pair[1].saturating_sub(pair[0]) as f64 * milliseconds;
        }
        Ok(())
    }

    /// Milliseconds and dispatches so far, by label.
    pub fn totals(&self) -> &BTreeMap<String, (f64, u64)> {
        &self.totals
    }
}
