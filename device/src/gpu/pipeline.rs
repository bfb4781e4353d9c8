//! Kernels as compute pipelines.

use std::sync::atomic::Ordering;

use naga::{
    AddressSpace, ImageClass, ImageDimension, ScalarKind, StorageAccess, StorageFormat, TypeInner,
};

use crate::{DeviceError, KernelSource, Trust, image::Texels, kernel::Parsed, resources::Resource};

use super::Gpu;

/// A kernel, compiled by the driver.
#[derive(Debug)]
pub(crate) struct Pipeline {
    label: String,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// A kernel with its resources.
#[derive(Debug, Clone)]
pub(crate) struct BoundPipeline {
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) group: wgpu::BindGroup,
}

impl Pipeline {
    pub(crate) fn new(
        gpu: &Gpu,
        source: &KernelSource<'_>,
        parsed: Parsed,
    ) -> Result<Self, DeviceError> {
        let label = source.entry;
        let mut entries = Vec::new();
        for (binding, global) in parsed.globals() {
            let inner = &parsed.module.types[global.ty].inner;
            let ty = binding_type(inner, global.space).ok_or_else(|| {
                let name = global.name.as_deref().unwrap_or_default();
                source.failed(format!("global `{name}` has a type that can't be bound"))
            })?;
            entries.push(wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty,
                count: None,
            });
        }
        let constants: Vec<(&'static str, f64)> = parsed.declared(source.constants).collect();

        let _busy = (gpu.activity()).begin(|| format!("compiling the kernel {label}"));
        // What compilers of drivers refuse, and what texts for them can't be written of, are internal errors; each error goes to a scope
        // of its own kind, or ends the render.
        let scopes = [
            wgpu::ErrorFilter::OutOfMemory,
            wgpu::ErrorFilter::Internal,
            wgpu::ErrorFilter::Validation,
        ]
        .map(|filter| gpu.device().push_error_scope(filter));
        let (pipeline, layout) = build(gpu, source, parsed.module, &entries, &constants);
        // The last one first, and all of them.
        let errors: Vec<wgpu::Error> = (scopes.into_iter().rev())
            .filter_map(|scope| pollster::block_on(scope.pop()))
            .collect();
        match errors.into_iter().next() {
            Some(wgpu::Error::OutOfMemory { .. }) => return Err(DeviceError::OutOfMemory),
            Some(error) => {
                return Err(DeviceError::Refused {
                    label: label.to_owned(),
                    message: error.to_string(),
                });
            }
            None => {}
        }
        Ok(Self {
            label: label.to_owned(),
            pipeline,
            layout,
        })
    }

    pub(crate) fn bind<'a>(
        &self,
        gpu: &Gpu,
        resources: impl Iterator<Item = (u32, Resource<'a>)>,
    ) -> BoundPipeline {
        let entries: Vec<_> = resources
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding,
                resource: match resource {
                    Resource::Buffer(buffer) => buffer.gpu().as_entire_binding(),
                    Resource::Structure(structure) => structure.as_binding(),
                    Resource::Function(_) => unreachable!("kernels on drivers declare none"),
                    Resource::Image(image) => match &image.texels {
                        Texels::Gpu { view, .. } => wgpu::BindingResource::TextureView(view),
                        Texels::Native(_) => {
                            unreachable!("an image is used with the device that made it")
                        }
                    },
                },
            })
            .collect();
        let group = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.label),
            layout: &self.layout,
            entries: &entries,
        });
        BoundPipeline {
            pipeline: self.pipeline.clone(),
            group,
        }
    }
}

/// What wgpu does to make a pipeline with its layout.
fn build(
    gpu: &Gpu,
    source: &KernelSource<'_>,
    module: naga::Module,
    entries: &[wgpu::BindGroupLayoutEntry],
    constants: &[(&str, f64)],
) -> (wgpu::ComputePipeline, wgpu::BindGroupLayout) {
    let label = source.entry;
    let device = gpu.device();
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some(label),
        entries,
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let shader = shader_module(device, label, source.trust, module);
    gpu.shared.shader_modules.fetch_add(1, Ordering::Relaxed);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(label),
        layout: Some(&pipeline_layout),
        module: &shader,
        entry_point: Some(label),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants,
            zero_initialize_workgroup_memory: false,
        },
        cache: gpu.shared.cache.as_ref().map(|disk| &disk.cache),
    });
    gpu.shared.pipelines.fetch_add(1, Ordering::Relaxed);
    (pipeline, layout)
}

fn shader_module(
    device: &wgpu::Device,
    label: &str,
    trust: Trust,
    module: naga::Module,
) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    };
    let checks = match trust {
        Trust::Nothing => return device.create_shader_module(descriptor),
        Trust::Loops => wgpu::ShaderRuntimeChecks {
            force_loop_bounding: false,
            ..wgpu::ShaderRuntimeChecks::checked()
        },
        Trust::All => wgpu::ShaderRuntimeChecks::unchecked(),
    };
    // SAFETY: who makes a kernel says by `Trust` that its loops end, and for `Trust::All` that it indexes only what is
    // there.
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}

fn binding_type(inner: &TypeInner, space: AddressSpace) -> Option<wgpu::BindingType> {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    match space {
        AddressSpace::Uniform => Some(buffer(wgpu::BufferBindingType::Uniform)),
        AddressSpace::Storage { access } => Some(buffer(wgpu::BufferBindingType::Storage {
            read_only: !access.contains(StorageAccess::STORE),
        })),
        AddressSpace::Handle => match inner {
            TypeInner::Image {
                dim: ImageDimension::D2,
                arrayed,
                class: ImageClass::Sampled { kind, multi: false },
            } => Some(wgpu::BindingType::Texture {
                sample_type: match kind {
                    ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                    ScalarKind::Sint => wgpu::TextureSampleType::Sint,
                    _ => wgpu::TextureSampleType::Float { filterable: false },
                },
                view_dimension: if *arrayed {
                    wgpu::TextureViewDimension::D2Array
                } else {
                    wgpu::TextureViewDimension::D2
                },
                multisampled: false,
            }),
            TypeInner::AccelerationStructure {
                vertex_return: false,
            } => Some(wgpu::BindingType::AccelerationStructure {
                vertex_return: false,
            }),
            // What a window shows; the one format that every device can write and sample.
            TypeInner::Image {
                dim: ImageDimension::D2,
                arrayed: false,
                class:
                    ImageClass::Storage {
                        format: StorageFormat::Rgba8Unorm,
                        ..
                    },
            } => Some(wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format: wgpu::TextureFormat::Rgba8Unorm,
                view_dimension: wgpu::TextureViewDimension::D2,
            }),
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn globals_are_bound_by_what_they_are() {
        let module = naga::front::wgsl::parse_str(
            "@group(0) @binding(7) var<storage, read> numbers: array<u32>;
             @group(0) @binding(2) var picture: texture_2d_array<f32>;",
        )
        .expect("valid WGSL");
        let types: Vec<_> = module
            .global_variables
            .iter()
            .map(|(_, g)| binding_type(&module.types[g.ty].inner, g.space).expect("bindable"))
            .collect();
        assert!(matches!(
            types[0],
            wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: true },
                ..
            }
        ));
        assert!(matches!(
            types[1],
            wgpu::BindingType::Texture {
                view_dimension: wgpu::TextureViewDimension::D2Array,
                ..
            }
        ));
    }
}
