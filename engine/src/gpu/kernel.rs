//! A compute kernel whose bindings are found by name: naga tells which globals an entry point uses, and
//! [`Kernel::bind`] looks each up in a table of named resources. No list of binding numbers exists on the Rust side.

use std::{
    collections::HashMap,
    sync::{Arc, atomic::Ordering},
};

use naga::{
    AddressSpace, ImageClass, ImageDimension, ScalarKind, StorageAccess, StorageFormat, TypeInner,
};

use super::{Gpu, GpuError, wgsl::Source};

/// Whether the driver may trust a kernel's indices and loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trust {
    /// Our own code: no checks are inserted.
    Engine,
    /// Contains a user's code: indices are checked and loops bounded.
    User,
    /// Contains a user's code beside the engine's own: indices are checked. Loops are not bounded once more, because the
    /// engine's end and texgen bounds the users'.
    Mixed,
}

/// A compiled kernel.
#[derive(Debug)]
pub struct Kernel {
    label: String,
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    /// Binding number and name of each global that the entry point uses.
    bindings: Vec<(u32, String)>,
    private_bytes: u32,
}

/// Named resources that kernels bind. Clones share them.
#[derive(Debug, Clone, Default)]
pub struct Resources {
    buffers: HashMap<&'static str, wgpu::Buffer>,
    views: HashMap<&'static str, wgpu::TextureView>,
    structures: HashMap<&'static str, Arc<wgpu::Tlas>>,
}

impl Resources {
    /// Adds or replaces a buffer.
    pub fn set_buffer(&mut self, name: &'static str, buffer: wgpu::Buffer) {
        self.buffers.insert(name, buffer);
    }

    /// Adds or replaces a texture view.
    pub fn set_view(&mut self, name: &'static str, view: wgpu::TextureView) {
        self.views.insert(name, view);
    }

    /// Adds or replaces an acceleration structure, which has been built.
    pub fn set_structure(&mut self, name: &'static str, structure: Arc<wgpu::Tlas>) {
        self.structures.insert(name, structure);
    }

    /// A buffer by name.
    ///
    /// # Panics
    /// If there is none: names are fixed in the engine and every kernel is bound in tests.
    pub fn buffer(&self, name: &str) -> &wgpu::Buffer {
        self.buffers
            .get(name)
            .unwrap_or_else(|| panic!("no buffer is named `{name}`"))
    }

    /// Bytes of each buffer, by name.
    pub fn buffer_sizes(&self) -> impl Iterator<Item = (&'static str, u64)> {
        self.buffers
            .iter()
            .map(|(name, buffer)| (*name, buffer.size()))
    }

    fn get(&self, name: &str) -> wgpu::BindingResource<'_> {
        if let Some(buffer) = self.buffers.get(name) {
            return buffer.as_entire_binding();
        }
        if let Some(structure) = self.structures.get(name) {
            return structure.as_binding();
        }
        match self.views.get(name) {
            Some(view) => wgpu::BindingResource::TextureView(view),
            None => panic!("no resource is named `{name}`, which a kernel declares"),
        }
    }
}

impl Kernel {
    /// Compiles one entry point. `constants` are values of `override` constants by name; those that the text doesn't
    /// declare are left out.
    ///
    /// # Errors
    /// With file and line, if the text is not valid or the driver refuses it.
    pub fn new(
        gpu: &Gpu,
        source: &Source,
        entry: &str,
        trust: Trust,
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let failed = |message: String| GpuError::Kernel {
            label: entry.to_owned(),
            message,
        };
        let capabilities = match gpu.has_ray_queries() {
            true => naga::valid::Capabilities::RAY_QUERY,
            false => naga::valid::Capabilities::empty(),
        };
        let (module, info) = parse(source, capabilities).map_err(failed)?;
        let index = module
            .entry_points
            .iter()
            .position(|e| e.name == entry)
            .ok_or_else(|| failed(format!("it has no entry point `{entry}`")))?;
        let uses = info.get_entry_point(index);
        let private_bytes =
            texgen::kernel_private_bytes(&module, uses, &module.entry_points[index]);

        let constants: Vec<(&str, f64)> = constants
            .iter()
            .filter(|(name, _)| {
                module
                    .overrides
                    .iter()
                    .any(|(_, o)| o.name.as_deref() == Some(name))
            })
            .copied()
            .collect();
        let mut entries = Vec::new();
        let mut bindings = Vec::new();
        for (handle, global) in module.global_variables.iter() {
            let Some(binding) = &global.binding else {
                continue;
            };
            if uses[handle].is_empty() {
                continue;
            }
            let ty =
                binding_type(&module.types[global.ty].inner, global.space).ok_or_else(|| {
                    failed(format!(
                        "global `{:?}` has a type that can't be bound",
                        global.name
                    ))
                })?;
            entries.push(wgpu::BindGroupLayoutEntry {
                binding: binding.binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty,
                count: None,
            });
            bindings.push((binding.binding, global.name.clone().unwrap_or_default()));
        }

        let device = gpu.device();
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(entry),
            entries: &entries,
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some(entry),
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
        };
        let shader = match trust {
            Trust::User => device.create_shader_module(descriptor),
            // SAFETY: all loops end: the engine's own do, and texgen counts the steps of users'.
            Trust::Mixed => unsafe {
                device.create_shader_module_trusted(
                    descriptor,
                    wgpu::ShaderRuntimeChecks {
                        force_loop_bounding: false,
                        ..wgpu::ShaderRuntimeChecks::checked()
                    },
                )
            },
            // SAFETY: the engine's kernels index only what their queues and tables hold, and their loops end.
            Trust::Engine => unsafe {
                device.create_shader_module_trusted(
                    descriptor,
                    wgpu::ShaderRuntimeChecks::unchecked(),
                )
            },
        };
        gpu.shared
            .shader_modules_created
            .fetch_add(1, Ordering::Relaxed);
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&pipeline_layout),
            module: &shader,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                zero_initialize_workgroup_memory: false,
            },
            cache: gpu.shared.cache.as_ref().map(|disk| &disk.cache),
        });
        gpu.shared.pipelines_created.fetch_add(1, Ordering::Relaxed);
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(GpuError::Refused {
                label: entry.to_owned(),
                message: error.to_string(),
            });
        }
        Ok(Self {
            label: entry.to_owned(),
            pipeline,
            layout,
            bindings,
            private_bytes,
        })
    }

    /// Bytes of private memory that a thread asks for: see [`texgen::kernel_private_bytes`].
    pub fn private_bytes(&self) -> u32 {
        self.private_bytes
    }

    /// The entry point's name.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Names of the resources that it uses.
    pub fn resource_names(&self) -> impl Iterator<Item = &str> {
        self.bindings.iter().map(|(_, name)| name.as_str())
    }

    /// Looks up its resources.
    pub fn bind(&self, gpu: &Gpu, resources: &Resources) -> BoundKernel {
        let entries: Vec<_> = self
            .bindings
            .iter()
            .map(|(binding, name)| wgpu::BindGroupEntry {
                binding: *binding,
                resource: resources.get(name),
            })
            .collect();
        let group = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.label),
            layout: &self.layout,
            entries: &entries,
        });
        BoundKernel {
            label: self.label.clone(),
            pipeline: self.pipeline.clone(),
            group,
        }
    }
}

/// A kernel with its resources: ready to be dispatched.
#[derive(Debug, Clone)]
pub struct BoundKernel {
    label: String,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

/// How many workgroups run.
#[derive(Debug, Clone, Copy)]
pub enum Extent<'a> {
    /// Enough workgroups of 64 for this many threads.
    Threads(u32),
    /// One workgroup.
    One,
    /// Three words of a buffer, written by another kernel.
    Indirect(&'a wgpu::Buffer, u64),
}

impl BoundKernel {
    /// The kernel's name.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Records one dispatch as a pass of its own.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        extent: Extent<'_>,
        timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(&self.label),
            timestamp_writes: timestamps,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        match extent {
            Extent::Threads(threads) => {
                // As `advance.wgsl` spreads its dispatches.
                let groups = threads.div_ceil(64);
                pass.dispatch_workgroups(groups.min(32768), groups.div_ceil(32768), 1);
            }
            Extent::One => pass.dispatch_workgroups(1, 1, 1),
            Extent::Indirect(buffer, offset) => pass.dispatch_workgroups_indirect(buffer, offset),
        }
    }
}

/// The kernel's text as naga knows it, valid; else what is wrong with it, with file and line.
pub(super) fn parse(
    source: &Source,
    capabilities: naga::valid::Capabilities,
) -> Result<(naga::Module, naga::valid::ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(&source.text)
        .map_err(|e| located(source, e.labels().next().map(|(span, _)| span), e.message()))?;
    let info = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|e| {
            located(
                source,
                e.spans().last().map(|(span, _)| *span),
                &error_chain(e.as_inner()),
            )
        })?;
    Ok((module, info))
}

fn located(source: &Source, span: Option<naga::Span>, message: &str) -> String {
    span.and_then(|s| s.to_range())
        .and_then(|range| source.locate(range, message))
        .unwrap_or_else(|| message.to_owned())
}

/// An error with its causes, one after the other.
fn error_chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        text.push_str(": ");
        text.push_str(&inner.to_string());
        cause = inner.source();
    }
    text
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
    fn resources_are_found_by_the_names_in_the_text() {
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
