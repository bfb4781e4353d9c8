//! Runs small kernels on words: natively, and on a GPU device to compare with.

use std::sync::OnceLock;

use device::native::{
    buffer::Buffer,
    compile::{CompileError, Kernel, Options, Resource},
};
use wgpu::util::DeviceExt;

/// The module of a valid text.
pub(crate) fn parse(text: &str) -> (naga::Module, naga::valid::ModuleInfo) {
    try_parse(text).unwrap_or_else(|message| panic!("{message}"))
}

/// The module of a text, if it is valid.
pub(crate) fn try_parse(text: &str) -> Result<(naga::Module, naga::valid::ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
    let flags = naga::valid::ValidationFlags::all();
    let capabilities = naga::valid::Capabilities::SHADER_FLOAT16_IN_FLOAT32;
    let info = naga::valid::Validator::new(flags, capabilities)
        .validate(&module)
        .map_err(|error| error.emit_to_string(text))?;
    Ok((module, info))
}

/// Compiles the entry point `main`.
pub(crate) fn compile(text: &str, options: &Options<'_>) -> Result<Kernel, CompileError> {
    let (module, info) = parse(text);
    Kernel::new(&module, &info, "main", &[], options)
}

/// Runs `main` over the buffers `input` and `output`: what is in `output` then.
pub(crate) fn run(kernel: &Kernel, input: &[u32], outputs: usize, workgroups: u32) -> Vec<u32> {
    let input = Buffer::from_slice(input).expect("memory");
    let output = Buffer::new(4 * outputs as u64).expect("memory");
    let bound = kernel
        .bind(|binding| match binding.name.as_str() {
            "input" => Some(Resource::from(input.clone())),
            "output" => Some(Resource::from(output.clone())),
            _ => None,
        })
        .expect("both are buffers");
    bound.dispatch([workgroups, 1, 1]);
    output.read(0, outputs)
}

/// What tests of values begin with.
pub(crate) const HEAD: &str = "
@group(0) @binding(0) var<storage, read> input: array<u32>;
@group(0) @binding(1) var<storage, read_write> output: array<u32>;
";

/// The text of a kernel whose only invocation is `body`, behind `declarations`.
pub(crate) fn single(declarations: &str, body: &str) -> String {
    format!("{HEAD}{declarations}\n@compute @workgroup_size(1) fn main() {{ {body} }}\n")
}

/// A GPU device, hardware or software.
pub(crate) struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// The first device that there is; says so if there is none.
pub(crate) fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    GPU.get_or_init(|| {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&Default::default())).ok();
        let opened = adapter.and_then(|adapter| {
            pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default())).ok()
        });
        if opened.is_none() {
            assert!(
                std::env::var_os("PATINA_REQUIRE_DEVICE").is_none(),
                "no device"
            );
            eprintln!("skipped: no Vulkan device to compare with");
        }
        opened.map(|(device, queue)| Gpu { device, queue })
    })
    .as_ref()
}

impl Gpu {
    /// As [`run`], of the text's entry point `main`.
    pub(crate) fn run(
        &self,
        text: &str,
        input: &[u32],
        outputs: usize,
        workgroups: u32,
    ) -> Vec<u32> {
        let device = &self.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let storage = wgpu::BufferUsages::STORAGE;
        let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(input),
            usage: storage,
        });
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4 * outputs as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let output = buffer(storage | wgpu::BufferUsages::COPY_SRC);
        let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: input.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: output.as_entire_binding(),
                },
            ],
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(workgroups, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&output, 0, &read, 0, 4 * outputs as u64);
        self.queue.submit([encoder.finish()]);
        read.slice(..)
            .map_async(wgpu::MapMode::Read, |result| result.expect("mapped"));
        device
            .poll(wgpu::PollType::wait_indefinitely())
            .expect("the device works");
        let range = read.slice(..).get_mapped_range().expect("mapped");
        bytemuck::cast_slice(&range).to_vec()
    }
}
