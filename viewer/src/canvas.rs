//! Draws what egui has laid out, where a driver in software draws the window. egui's fragment shader filters textures by hand if it is
//! asked to, and such a driver runs that branch for each pixel whether it is asked to or not: text took 70 % of a frame's time.
//! A plugin takes the meshes out of egui's output, and puts a callback in their place that draws the same by a short shader.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use eframe::egui_wgpu::{
    Callback, CallbackResources, CallbackTrait, RenderState, ScreenDescriptor,
};
use egui::epaint::{ClippedPrimitive, ClippedShape, Mesh, Primitive};
use egui::{
    Context, FullOutput, PaintCallbackInfo, Plugin, Pos2, Rect, Shape, TextureId, TextureOptions,
    TexturesDelta,
};

/// Of a vertex: place, place in the texture, colour as four bytes.
const STRIDE: usize = 20;

/// Draws egui's meshes in its place.
pub(crate) struct Canvas {
    state: RenderState,
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    /// The textures that egui has made.
    textures: HashMap<TextureId, (wgpu::Texture, wgpu::BindGroup)>,
}

impl Canvas {
    /// `None` where the surface wants linear colours, which egui's are not.
    pub(crate) fn new(state: &RenderState) -> Option<Self> {
        if state.target_format.is_srgb() {
            return None;
        }
        let device = &state.device;
        let module = device.create_shader_module(wgpu::include_wgsl!("canvas.wgsl"));
        let over = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::OneMinusSrcAlpha,
            operation: wgpu::BlendOperation::Add,
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("canvas"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("place"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: STRIDE as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![
                        0 => Float32x2, 1 => Float32x2, 2 => Unorm8x4
                    ],
                })],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fill"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: state.target_format,
                    blend: Some(wgpu::BlendState {
                        color: over,
                        alpha: over,
                    }),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        Some(Self {
            state: state.clone(),
            pipeline,
            sampler,
            textures: HashMap::new(),
        })
    }

    /// Looks at the textures that egui has, but for those that it is about to make: these are left to egui for a frame.
    fn bind(&mut self, delta: &TexturesDelta, primitives: &[ClippedPrimitive]) {
        for id in &delta.free {
            self.textures.remove(id);
        }
        let is_new = |id: &TextureId| {
            let parts = delta.set.get(id);
            parts.is_some_and(|parts| parts.iter().any(|part| part.pos.is_none()))
        };
        let renderer = self.state.renderer.read();
        for primitive in primitives {
            let Primitive::Mesh(mesh) = &primitive.primitive else {
                continue;
            };
            let id = mesh.texture_id;
            let texture = renderer.texture(&id).and_then(|known| {
                // Those without a texture are the pictures, which others have made.
                let is_linear = known.options == Some(TextureOptions::LINEAR);
                known.texture.as_ref().filter(|_| is_linear && !is_new(&id))
            });
            match (texture, self.textures.entry(id)) {
                (None, Entry::Occupied(entry)) => {
                    entry.remove();
                }
                (Some(texture), Entry::Occupied(entry)) if entry.get().0 == *texture => {}
                (Some(texture), entry) => {
                    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                    let bound = bound(&self.state.device, &self.pipeline, &view, &self.sampler);
                    entry.insert_entry((texture.clone(), bound));
                }
                (None, Entry::Vacant(_)) => {}
            }
        }
    }

    /// The same, with callbacks in place of meshes as far as their textures are known.
    fn replaced(&self, primitives: Vec<ClippedPrimitive>, screen: Rect) -> Vec<ClippedShape> {
        let mut shapes = Vec::new();
        let mut layer = Layer::over(&self.pipeline);
        for ClippedPrimitive {
            clip_rect,
            primitive,
        } in primitives
        {
            let shape = match primitive {
                Primitive::Mesh(mesh) => match self.textures.get(&mesh.texture_id) {
                    Some((_, texture)) => {
                        layer.push(&mesh, clip_rect, texture);
                        continue;
                    }
                    None => Shape::mesh(mesh),
                },
                Primitive::Callback(callback) => Shape::Callback(callback),
            };
            shapes.extend(layer.take(screen));
            shapes.push(ClippedShape::new(clip_rect, shape));
        }
        shapes.extend(layer.take(screen));
        shapes
    }
}

impl Plugin for Canvas {
    fn debug_name(&self) -> &'static str {
        "canvas"
    }

    fn output_hook(&mut self, ctx: &Context, output: &mut FullOutput) {
        let shapes = std::mem::take(&mut output.shapes);
        let primitives = ctx.tessellate(shapes, output.pixels_per_point);
        self.bind(&output.textures_delta, &primitives);
        output.shapes = self.replaced(primitives, ctx.content_rect());
    }
}

fn bound(
    device: &wgpu::Device,
    pipeline: &wgpu::RenderPipeline,
    view: &wgpu::TextureView,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("canvas"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(view),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::Sampler(sampler),
            },
        ],
    })
}

/// Meshes that are drawn one after the other.
struct Layer {
    pipeline: wgpu::RenderPipeline,
    parts: Vec<Part>,
    /// Places are points of the window.
    vertices: Vec<u8>,
    indices: Vec<u8>,
    /// On the device, once a frame is about to be drawn.
    buffers: OnceLock<[wgpu::Buffer; 2]>,
}

struct Part {
    clip: Rect,
    texture: wgpu::BindGroup,
    indices: Range<u32>,
}

impl Layer {
    fn over(pipeline: &wgpu::RenderPipeline) -> Self {
        Self {
            pipeline: pipeline.clone(),
            parts: Vec::new(),
            vertices: Vec::new(),
            indices: Vec::new(),
            buffers: OnceLock::new(),
        }
    }

    fn push(&mut self, mesh: &Mesh, clip: Rect, texture: &wgpu::BindGroup) {
        let first_vertex = (self.vertices.len() / STRIDE) as u32;
        for vertex in &mesh.vertices {
            for x in [vertex.pos.x, vertex.pos.y, vertex.uv.x, vertex.uv.y] {
                self.vertices.extend(x.to_ne_bytes());
            }
            self.vertices.extend(vertex.color.to_array());
        }
        let first = (self.indices.len() / 4) as u32;
        for index in &mesh.indices {
            self.indices.extend((first_vertex + index).to_ne_bytes());
        }
        self.parts.push(Part {
            clip,
            texture: texture.clone(),
            indices: first..first + mesh.indices.len() as u32,
        });
    }

    /// What there is, as a shape; the next mesh begins another one.
    fn take(&mut self, screen: Rect) -> Option<ClippedShape> {
        let next = Self::over(&self.pipeline);
        let layer = std::mem::replace(self, next);
        (!layer.indices.is_empty()).then(|| {
            let callback = Callback::new_paint_callback(screen, Drawn(Arc::new(layer)));
            ClippedShape::new(screen, callback)
        })
    }

    /// The vertices in clip space.
    fn placed(&self, [width, height]: [f32; 2]) -> Vec<u8> {
        let mut vertices = self.vertices.clone();
        for vertex in vertices.chunks_exact_mut(STRIDE) {
            let (x, rest) = vertex.split_at_mut(4);
            let number = |bytes: &[u8]| f32::from_ne_bytes(bytes.try_into().unwrap_or_default());
            let right = 2.0 * number(x) / width - 1.0;
            let up = 1.0 - 2.0 * number(&rest[..4]) / height;
            x.copy_from_slice(&right.to_ne_bytes());
            rest[..4].copy_from_slice(&up.to_ne_bytes());
        }
        vertices
    }
}

/// A layer, ready to be drawn.
struct Drawn(Arc<Layer>);

impl CallbackTrait for Drawn {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        _: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let points = screen
            .size_in_pixels
            .map(|side| side as f32 / screen.pixels_per_point);
        let made = |bytes: &[u8], usage| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("canvas"),
                size: bytes.len() as u64,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        self.0.buffers.get_or_init(|| {
            [
                made(&self.0.placed(points), wgpu::BufferUsages::VERTEX),
                made(&self.0.indices, wgpu::BufferUsages::INDEX),
            ]
        });
        Vec::new()
    }

    fn paint(
        &self,
        info: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _: &CallbackResources,
    ) {
        let layer = &*self.0;
        let Some([vertices, indices]) = layer.buffers.get() else {
            return;
        };
        let [width, height] = info.screen_size_px;
        pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
        pass.set_pipeline(&layer.pipeline);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
        for part in &layer.parts {
            let [x, y, w, h] = pixels(part.clip, info.pixels_per_point, info.screen_size_px);
            if w == 0 || h == 0 {
                continue;
            }
            pass.set_scissor_rect(x, y, w, h);
            pass.set_bind_group(0, &part.texture, &[]);
            pass.draw_indexed(part.indices.clone(), 0, 0..1);
        }
    }
}

/// Left, top, width and height of a rectangle of points, as far as it lies on the screen.
fn pixels(rect: Rect, per_point: f32, [width, height]: [u32; 2]) -> [u32; 4] {
    // `as` saturates.
    let at = |Pos2 { x, y }: Pos2| {
        [
            ((x * per_point).round() as u32).min(width),
            ((y * per_point).round() as u32).min(height),
        ]
    };
    let ([left, top], [right, bottom]) = (at(rect.min), at(rect.max));
    [
        left,
        top,
        right.saturating_sub(left),
        bottom.saturating_sub(top),
    ]
}

#[cfg(test)]
mod tests {
    use device::{Device, DeviceChoice};
    use eframe::egui_wgpu::{Renderer, RendererOptions};

    use super::*;

    const SIZE: [u32; 2] = [256, 128];
    const PER_POINT: f32 = 1.25;

    /// What a window with text, buttons and an image is drawn as in its second frame, row by row.
    fn drawn(driver: &device::gpu::Gpu, with_canvas: bool) -> (Vec<u8>, usize) {
        let format = wgpu::TextureFormat::Rgba8Unorm;
        let options = RendererOptions::default();
        let renderer = Renderer::new(driver.device(), format, options);
        let state = RenderState {
            instance: driver.instance().clone(),
            adapter: driver.adapter().clone(),
            available_adapters: Vec::new(),
            device: driver.device().clone(),
            queue: driver.queue().clone(),
            target_format: format,
            renderer: Arc::new(egui::mutex::RwLock::new(renderer)),
        };
        let ctx = Context::default();
        if with_canvas {
            ctx.add_plugin(Canvas::new(&state).expect("no linear colours"));
        }
        let image = egui::ColorImage::example();
        let image = ctx.load_texture("example", image, TextureOptions::LINEAR);
        let texture = driver.device().create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width: SIZE[0],
                height: SIZE[1],
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&Default::default());
        let mut callbacks = 0;
        // Textures that are new are left to egui: so the second frame is the one that counts.
        for _ in 0..2 {
            let mut input = egui::RawInput {
                screen_rect: Some(Rect::from_min_size(
                    Pos2::ZERO,
                    egui::vec2(SIZE[0] as f32, SIZE[1] as f32) / PER_POINT,
                )),
                ..Default::default()
            };
            let viewport = input.viewports.entry(egui::ViewportId::ROOT).or_default();
            viewport.native_pixels_per_point = Some(PER_POINT);
            let mut output = ctx.run_ui(input, |ui| {
                ui.heading("Roughness");
                let _ = ui.button("A button");
                ui.add(egui::Image::new((image.id(), egui::vec2(60.0, 30.0))));
                ui.painter().circle_filled(
                    egui::pos2(150.0, 50.0),
                    30.0,
                    egui::Color32::from_rgba_unmultiplied(200, 80, 10, 120),
                );
            });
            let mut delta = std::mem::take(&mut output.textures_delta);
            let jobs = ctx.tessellate(output.shapes, output.pixels_per_point);
            callbacks = jobs
                .iter()
                .filter(|job| matches!(job.primitive, Primitive::Callback(_)))
                .count();
            let screen = ScreenDescriptor {
                size_in_pixels: SIZE,
                pixels_per_point: output.pixels_per_point,
            };
            let mut encoder = driver.device().create_command_encoder(&Default::default());
            let mut renderer = state.renderer.write();
            for (id, parts) in delta.set.drain() {
                for part in parts {
                    renderer.update_texture(driver.device(), driver.queue(), id, &part);
                }
            }
            let (device, queue) = (driver.device(), driver.queue());
            renderer.update_buffers(device, queue, &mut encoder, &jobs, &screen);
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                    depth_slice: None,
                })],
                ..Default::default()
            });
            renderer.render(&mut pass.forget_lifetime(), &jobs, &screen);
            queue.submit([encoder.finish()]);
        }
        (crate::upload::held(driver, &view), callbacks)
    }

    #[test]
    fn the_canvas_draws_what_egui_would_have_drawn() {
        let device = match Device::open(&DeviceChoice::Driver) {
            Ok(device) => device,
            Err(error) => {
                let is_needed = std::env::var_os("PATINA_REQUIRE_DEVICE").is_some();
                assert!(!is_needed, "{error}");
                return eprintln!("skipped: {error}");
            }
        };
        let driver = device.gpu().expect("a driver");
        let (theirs, none) = drawn(driver, false);
        let (ours, layers) = drawn(driver, true);
        assert_eq!((none, layers), (0, 1), "all in one layer");
        assert!(theirs.iter().filter(|byte| **byte > 30).count() > 10_000);
        let most = theirs.iter().zip(&ours).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(most <= Some(1), "{most:?}");
        device.check().expect("nothing was refused");
    }

    #[test]
    fn clips_are_whole_pixels_of_the_screen() {
        let rect = |a: [f32; 2], b: [f32; 2]| Rect::from_min_max(a.into(), b.into());
        let screen = [100, 50];
        assert_eq!(
            pixels(rect([1.0, 2.0], [3.0, 5.0]), 2.0, screen),
            [2, 4, 4, 6]
        );
        assert_eq!(pixels(Rect::EVERYTHING, 1.0, screen), [0, 0, 100, 50]);
        assert_eq!(pixels(Rect::NOTHING, 1.0, screen)[2..], [0, 0]);
        assert_eq!(
            pixels(rect([f32::NAN; 2], [5.0, 5.0]), 1.0, screen)[..2],
            [0, 0]
        );
    }
}
