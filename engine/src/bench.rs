//! Traversal on its own: traces given rays through the renderer's kernel, for tests of agreement and for
//! `patina bench traverse`.

use std::time::Instant;

use glam::{Vec2, Vec3};
use serde::Serialize;

use crate::{
    frame::Frame,
    gpu::{
        Gpu,
        kernel::{BoundKernel, Extent, Resources},
    },
    gpu_scene::GpuScene,
    passes::traverse::{self, Rays},
    renderer::RenderError,
    scene::{Camera, Projection, Scene},
    wave::{self, RayHit},
};

/// Rays traced at once.
const BATCH: u32 = 1 << 16;
/// Side of the picture whose rays are traced in the benchmark.
const SIDE: u32 = 1024;

/// Traces rays through the kernels of a device.
#[derive(Debug)]
pub struct Tracer {
    gpu: Gpu,
    resources: Resources,
    closest: BoundKernel,
    occlusion: BoundKernel,
}

impl Tracer {
    /// Uploads the scene.
    ///
    /// # Errors
    /// If it is empty or does not fit the device.
    pub fn new(gpu: &Gpu, scene: &Scene) -> Result<Self, RenderError> {
        let mut resources = Resources::default();
        let gpu_scene = GpuScene::new(gpu, scene, &[], |_| 0, &mut resources)?;
        wave::allocate(gpu, BATCH, &mut resources)?;
        let camera = crate::scene::default_camera(scene);
        let frame = Frame::new((1, 1), &camera, 1, 0, BATCH, &gpu_scene);
        resources.set_buffer("frame", gpu.empty_buffer("frame", size_of::<Frame>() as u64, wgpu::BufferUsages::UNIFORM)?);
        gpu.queue().write_buffer(resources.buffer("frame"), 0, bytemuck::bytes_of(&frame));
        let closest = traverse::kernel(gpu, Rays::Closest)?.bind(gpu, &resources);
        let occlusion = traverse::kernel(gpu, Rays::Occlusion)?.bind(gpu, &resources);
        Ok(Self { gpu: gpu.clone(), resources, closest, occlusion })
    }

    /// Traces all rays in batches; returns them with their hits and the seconds spent in the kernel.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn trace(&self, rays: &[RayHit], kind: Rays) -> Result<(Vec<RayHit>, f64), RenderError> {
        let mut traced = Vec::with_capacity(rays.len());
        let mut seconds = 0.0;
        for batch in rays.chunks(BATCH as usize) {
            let (hits, took) = self.trace_batch(batch, kind)?;
            traced.extend(hits);
            seconds += took;
        }
        Ok((traced, seconds))
    }

    fn trace_batch(&self, batch: &[RayHit], kind: Rays) -> Result<(Vec<RayHit>, f64), RenderError> {
        let count = batch.len() as u32;
        // The kernel reads a queue: all slots in order. Shadow rays lie behind the paths' own.
        let (list, first_slot, kernel) = match kind {
            Rays::Closest => (0, 0, &self.closest),
            Rays::Occlusion => (2, u64::from(BATCH), &self.occlusion),
        };
        let mut words = vec![0u32; wave::QUEUE_HEADER as usize];
        words[1] = count;
        words[3] = count;
        let slots: Vec<u32> = (0..count).collect();
        let queue = self.gpu.queue();
        queue.write_buffer(self.resources.buffer("queues"), 0, bytemuck::cast_slice(&words));
        let at = (wave::QUEUE_HEADER + list * u64::from(BATCH)) * 4;
        queue.write_buffer(self.resources.buffer("queues"), at, bytemuck::cast_slice(&slots));
        let offset = first_slot * size_of::<RayHit>() as u64;
        queue.write_buffer(self.resources.buffer("rays"), offset, bytemuck::cast_slice(batch));
        queue.submit([]);
        self.gpu.wait()?;

        let start = Instant::now();
        let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("trace") });
        kernel.record(&mut encoder, Extent::Threads(count), None);
        queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        let seconds = start.elapsed().as_secs_f64();
        let bytes = self.gpu.read_buffer(self.resources.buffer("rays"), offset, u64::from(count) * size_of::<RayHit>() as u64)?;
        Ok((bytemuck::pod_collect_to_vec(&bytes), seconds))
    }
}
