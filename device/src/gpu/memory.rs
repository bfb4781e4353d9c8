//! Buffers of a driver's.

use std::sync::{Arc, OnceLock};

use crate::{DeviceError, Usage};

use super::Gpu;

impl Gpu {
    /// A zeroed buffer; the size has been checked.
    pub(crate) fn buffer(&self, label: &str, usage: Usage, size: u64) -> wgpu::Buffer {
        let storage = wgpu::BufferUsages::STORAGE;
        let usage = match usage {
            Usage::Storage => storage,
            Usage::Uniform => storage | wgpu::BufferUsages::UNIFORM,
            Usage::Indirect => storage | wgpu::BufferUsages::INDIRECT,
        };
        self.plain_buffer(label, usage, size)
    }

    pub(super) fn plain_buffer(
        &self,
        label: &str,
        usage: wgpu::BufferUsages,
        size: u64,
    ) -> wgpu::Buffer {
        self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size,
            usage: usage | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    pub(crate) fn write(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        self.queue().write_buffer(buffer, offset, bytes);
    }

    pub(crate) fn flush(&self) {
        self.queue().submit([]);
    }

    pub(crate) fn read(
        &self,
        buffer: &wgpu::Buffer,
        offset: u64,
        bytes: u64,
    ) -> Result<Vec<u8>, DeviceError> {
        let staging = self.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("read-back"),
            size: bytes,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.encoder("read-back");
        encoder.copy_buffer_to_buffer(buffer, offset, &staging, 0, bytes);
        self.queue().submit([encoder.finish()]);
        let outcome = Arc::new(OnceLock::new());
        let slot = Arc::clone(&outcome);
        staging.map_async(wgpu::MapMode::Read, .., move |result| {
            // Called once; a second value could only be the same.
            let _ = slot.set(result);
        });
        self.wait()?;
        match outcome.get() {
            Some(Ok(())) => {}
            Some(Err(e)) => return Err(DeviceError::Driver(e.to_string())),
            None => return Err(DeviceError::Driver("a read-back did not finish".to_owned())),
        }
        let view = staging
            .get_mapped_range(..)
            .map_err(|e| DeviceError::Driver(e.to_string()))?;
        let data = view.to_vec();
        drop(view);
        staging.unmap();
        Ok(data)
    }

    pub(super) fn encoder(&self, label: &str) -> wgpu::CommandEncoder {
        let descriptor = wgpu::CommandEncoderDescriptor { label: Some(label) };
        self.device().create_command_encoder(&descriptor)
    }
}
