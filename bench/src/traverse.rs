//! Traversal on its own: traces given rays through the renderer's kernel, for tests of agreement and for
//! `patina bench traverse`.

use std::{ops::RangeInclusive, time::Instant};

use glam::{Mat3, Vec3};
use serde::Serialize;

use device::{BoundKernel, Device, Extent, Recording, Resources, Usage};

use engine::{
    frame::Frame,
    gpu_scene::GpuScene,
    passes::traverse::{self, Rays},
    renderer::RenderError,
    scene::{Camera, Projection, Scene},
    settings::RenderSettings,
    texturing::TextureReads,
    wave::{self, RayHit},
};

/// Rays traced at once: as many as in a wave of the device's, within these.
const BATCH: RangeInclusive<u32> = 1 << 16..=1 << 20;
/// Side of the picture whose rays are traced in the benchmark.
const SIDE: u32 = 1024;

/// Traces rays through the kernels of a device.
#[derive(Debug)]
pub struct Tracer {
    device: Device,
    scene: GpuScene,
    resources: Resources,
    batch: u32,
    closest: BoundKernel,
    occlusion: BoundKernel,
}

impl Tracer {
    /// Uploads the scene.
    ///
    /// # Errors
    /// If it is empty or does not fit the device.
    pub fn new(device: &Device, scene: &Scene) -> Result<Self, RenderError> {
        let mut resources = Resources::default();
        let gpu_scene = GpuScene::new(
            device,
            scene,
            &TextureReads::default(),
            |_| Default::default(),
            &mut resources,
        )?;
        let most = device.traits().waves.most;
        let batch = most.clamp(*BATCH.start(), *BATCH.end());
        wave::allocate(device, batch, 0, &mut resources)?;
        let camera = engine::scene::default_camera(scene);
        let frame = Frame::new(&RenderSettings::new(1, 1, &camera), batch, &gpu_scene);
        resources.set_buffer(
            "frame",
            device.buffer("frame", Usage::Uniform, size_of::<Frame>() as u64)?,
        );
        device.write(resources.buffer("frame"), 0, bytemuck::bytes_of(&frame));
        let closest = traverse::CLOSEST
            .kernel(device, &gpu_scene.features)?
            .bind(device, &resources);
        let occlusion = traverse::OCCLUSION
            .kernel(device, &gpu_scene.features)?
            .bind(device, &resources);
        Ok(Self {
            device: device.clone(),
            scene: gpu_scene,
            resources,
            batch,
            closest,
            occlusion,
        })
    }

    /// World positions of the triangle of `scene`, which was uploaded, that was hit.
    pub fn world_triangle(&self, scene: &Scene, hit: &RayHit) -> [Vec3; 3] {
        let order = self.scene.hierarchy();
        let instance = &scene.instances[order.instance_order[hit.instance as usize] as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        let first = order.mesh_first_triangle[instance.mesh as usize];
        let source = order.triangle_order[instance.mesh as usize][(hit.triangle - first) as usize];
        mesh.triangles[source as usize].map(|v| {
            instance
                .transform
                .transform_point3(mesh.positions[v as usize])
        })
    }

    /// Traces all rays in batches; returns them with their hits and the seconds spent in the kernel.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn trace(&self, rays: &[RayHit], kind: Rays) -> Result<(Vec<RayHit>, f64), RenderError> {
        let mut traced = Vec::with_capacity(rays.len());
        let mut seconds = 0.0;
        for batch in rays.chunks(self.batch as usize) {
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
            Rays::Occlusion => (2, u64::from(self.batch), &self.occlusion),
        };
        let mut words = vec![0u32; wave::QUEUE_HEADER as usize];
        words[1] = count;
        words[3] = count;
        let slots: Vec<u32> = (0..count).collect();
        let write = |name: &str, at: u64, bytes: &[u8]| {
            self.device.write(self.resources.buffer(name), at, bytes);
        };
        write("queues", 0, bytemuck::cast_slice(&words));
        let at = (wave::QUEUE_HEADER + list * u64::from(self.batch)) * 4;
        write("queues", at, bytemuck::cast_slice(&slots));
        let offset = first_slot * size_of::<RayHit>() as u64;
        write("rays", offset, bytemuck::cast_slice(batch));
        self.device.flush();
        self.device.wait()?;

        let start = Instant::now();
        let mut recording = Recording::new("trace");
        recording.dispatch(kernel, Extent::Threads(count));
        self.device.play(&recording)?;
        let seconds = start.elapsed().as_secs_f64();
        let rays = self.resources.buffer("rays");
        let bytes = u64::from(count) * size_of::<RayHit>() as u64;
        let bytes = self.device.read(rays, offset, bytes)?;
        Ok((bytemuck::pod_collect_to_vec(&bytes), seconds))
    }
}

/// Million rays per second by kind.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct TraverseReport {
    /// Camera rays in the order in which the renderer traces them, to their closest hit.
    pub primary: f64,
    /// Cosine-distributed rays from where the camera rays hit, to their closest hit.
    pub bounce: f64,
    /// From where the camera rays hit to where others hit, to any hit.
    pub shadow: f64,
}

/// Measures traversal with rays of the scene's first camera: medians of five runs of about a million rays each.
///
/// # Errors
/// If the scene is empty or does not fit the device.
pub fn traverse(device: &Device, scene: &Scene) -> Result<TraverseReport, RenderError> {
    let tracer = Tracer::new(device, scene)?;
    let camera = scene
        .cameras
        .first()
        .cloned()
        .unwrap_or_else(|| engine::scene::default_camera(scene));
    let primary = camera_rays(&camera, SIDE);
    // The first run also compiles the kernel.
    let (hits, _) = tracer.trace(&primary, Rays::Closest)?;
    let bounce = bounce_rays(&tracer, scene, &hits);
    let shadow = shadow_rays(&hits, &bounce);
    let rate = |rays: &[RayHit], kind| -> Result<f64, RenderError> {
        if rays.is_empty() {
            return Ok(0.0);
        }
        tracer.trace(&rays[..rays.len().min(tracer.batch as usize)], kind)?;
        let mut seconds = (0..5)
            .map(|_| Ok(tracer.trace(rays, kind)?.1))
            .collect::<Result<Vec<f64>, RenderError>>()?;
        seconds.sort_by(f64::total_cmp);
        Ok(rays.len() as f64 / seconds[2] * 1e-6)
    };
    Ok(TraverseReport {
        primary: rate(&primary, Rays::Closest)?,
        bounce: rate(&bounce, Rays::Closest)?,
        shadow: rate(&shadow, Rays::Occlusion)?,
    })
}

/// Rays through the pixels of a square picture in Morton order.
pub fn camera_rays(camera: &Camera, side: u32) -> Vec<RayHit> {
    let axes = Mat3::from(camera.transform.matrix3);
    let position = Vec3::from(camera.transform.translation);
    let compact = |mut v: u32| {
        v &= 0x5555_5555;
        v = (v | (v >> 1)) & 0x3333_3333;
        v = (v | (v >> 2)) & 0x0f0f_0f0f;
        v = (v | (v >> 4)) & 0x00ff_00ff;
        (v | (v >> 8)) & 0x0000_ffff
    };
    (0..side * side)
        .map(|i| {
            let at = |v: u32| (2.0 * (v as f32 + 0.5) / side as f32) - 1.0;
            let (x, y) = (at(compact(i)), -at(compact(i >> 1)));
            match camera.projection {
                Projection::Perspective { y_fov } => {
                    let half = (0.5 * y_fov).tan();
                    RayHit::new(
                        position,
                        (axes * Vec3::new(x * half, y * half, -1.0)).normalize(),
                        1e30,
                    )
                }
                Projection::Orthographic { y_mag } => RayHit::new(
                    position + axes * Vec3::new(x * y_mag, y * y_mag, 0.0),
                    axes * Vec3::NEG_Z,
                    1e30,
                ),
            }
        })
        .collect()
}

/// One cosine-distributed ray from each hit, on the side from which it was hit.
fn bounce_rays(tracer: &Tracer, scene: &Scene, hits: &[RayHit]) -> Vec<RayHit> {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move || {
        // SplitMix64 (Steele et al. 2014).
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    };
    hits.iter()
        .filter(|hit| hit.triangle != RayHit::MISS)
        .map(|hit| {
            let [a, b, c] = tracer.world_triangle(scene, hit);
            let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
            let normal = if normal.dot(hit.direction) > 0.0 {
                -normal
            } else {
                normal
            };
            let origin = hit.origin + hit.direction * hit.t_max + normal * 1e-4 * (1.0 + hit.t_max);
            let (z, phi) = (1.0 - 2.0 * random(), std::f32::consts::TAU * random());
            let r = (1.0 - z * z).max(0.0).sqrt();
            // A point on the sphere that touches the surface: cosine-distributed.
            let direction =
                (normal * 1.0001 + Vec3::new(r * phi.cos(), r * phi.sin(), z)).normalize_or(normal);
            RayHit::new(origin, direction, 1e30)
        })
        .collect()
}

/// From each bounce ray's origin to the origin of another one.
pub fn shadow_rays(hits: &[RayHit], bounce: &[RayHit]) -> Vec<RayHit> {
    let count = bounce.len();
    let stride = hits.len() / 3 + 1;
    bounce
        .iter()
        .enumerate()
        .filter_map(|(i, ray)| {
            let to = bounce[(i + stride) % count].origin - ray.origin;
            let distance = to.length();
            (distance > 0.0).then(|| RayHit::new(ray.origin, to / distance, distance * 0.999))
        })
        .collect()
}
