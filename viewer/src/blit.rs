//! Draws the picture. egui could, but its fragment shader has branches for all that it may be asked for, and a software
//! driver runs every one of them for each pixel: the picture would take most of a frame.

use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait};
use egui::{PaintCallbackInfo, Rect, Shape};

/// A pipeline for the window's surface.
#[derive(Debug)]
pub(crate) struct Blit {
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
}

/// The picture, ready to be drawn.
#[derive(Debug, Clone)]
pub struct Drawn {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroup,
}

impl Blit {
    /// `None` where the surface wants linear colours, which the picture has not.
    pub(crate) fn new(device: &wgpu::Device, target: wgpu::TextureFormat) -> Option<Self> {
        if target.is_srgb() {
            return None;
        }
        let module = device.create_shader_module(wgpu::include_wgsl!("blit.wgsl"));
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("picture"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("cover"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("copy"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(target.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        Some(Self { pipeline, sampler })
    }

    /// For each texture that the picture lies in.
    pub(crate) fn bind(&self, device: &wgpu::Device, picture: &wgpu::TextureView) -> Drawn {
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(picture),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: wgpu::BindingResource::Sampler(&self.sampler),
                },
            ],
        });
        Drawn {
            pipeline: self.pipeline.clone(),
            bindings,
        }
    }
}

impl Drawn {
    /// The picture over a rectangle.
    pub(crate) fn shape(&self, rect: Rect) -> Shape {
        Shape::Callback(Callback::new_paint_callback(rect, self.clone()))
    }
}

impl CallbackTrait for Drawn {
    fn paint(
        &self,
        _: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _: &CallbackResources,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        pass.draw(0..3, 0..1);
    }
}
