//! The scene's geometry in acceleration structures of the driver's: a bottom level per mesh, a top level of the instances,
//! with triangles and instances in the order in which they lie on the GPU anyway.

use std::sync::Arc;

use crate::{
    gpu::{Gpu, GpuError, kernel::Resources},
    gpu_scene::{
        GpuScene, TRIANGLE_ALPHA, TRIANGLE_PROGRAM_ALPHA, TRIANGLE_SINGLE_SIDED, material_flags,
        rows,
    },
    procedural::ProgramTraits,
    scene::{Mesh, Scene},
};

/// Builds the structures and names them: `scene_structure`, and in `first_triangles` where each instance's triangles begin
/// in the buffer of all triangles. Returns whether every triangle of the scene is single-sided, so that the hardware may
/// leave out all backs.
///
/// # Errors
/// More geometry than the driver's structures hold; what the driver reports.
pub(super) fn build(
    gpu: &Gpu,
    scene: &Scene,
    program: impl Fn(u32) -> ProgramTraits,
    gpu_scene: &GpuScene,
    resources: &mut Resources,
) -> Result<bool, GpuError> {
    let hierarchy = gpu_scene.hierarchy();
    let flags = material_flags(scene, program);
    let is_single_sided = scene
        .meshes
        .iter()
        .all(|mesh| flags_of(mesh, &flags).all(|flags| flags & TRIANGLE_SINGLE_SIDED != 0));
    // A triangle that may let a ray pass has to be judged by the kernel.
    let judged = match is_single_sided {
        true => TRIANGLE_ALPHA | TRIANGLE_PROGRAM_ALPHA,
        false => TRIANGLE_ALPHA | TRIANGLE_PROGRAM_ALPHA | TRIANGLE_SINGLE_SIDED,
    };
    let limits = gpu.device().limits();
    let too_large = |what: &str, needed: usize, limit: u32| GpuError::TooLarge {
        what: what.to_owned(),
        needed: needed as u64,
        limit: u64::from(limit),
        remedy: "this driver's acceleration structures hold no more",
    };
    let scope = gpu.device().push_error_scope(wgpu::ErrorFilter::Validation);
    let mut levels: Vec<Option<BottomLevel>> = Vec::new();
    for (mesh, order) in scene.meshes.iter().zip(&hierarchy.triangle_order) {
        if order.len() > limits.max_blas_primitive_count as usize {
            let limit = limits.max_blas_primitive_count;
            return Err(too_large("a mesh's triangles", order.len(), limit));
        }
        let is_opaque = flags_of(mesh, &flags).all(|flags| flags & judged == 0);
        levels.push(match order.is_empty() {
            true => None,
            false => Some(BottomLevel::new(gpu, mesh, order, is_opaque)?),
        });
    }

    let instances = &hierarchy.instance_order;
    if instances.len() > limits.max_tlas_instance_count as usize {
        let limit = limits.max_tlas_instance_count;
        return Err(too_large("the instances", instances.len(), limit));
    }
    let mut top = gpu.device().create_tlas(&wgpu::CreateTlasDescriptor {
        label: Some("instances"),
        max_instances: instances.len() as u32,
        flags: wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE,
        update_mode: wgpu::AccelerationStructureUpdateMode::Build,
    });
    let mut first_triangles = Vec::with_capacity(instances.len());
    for (place, &source) in instances.iter().enumerate() {
        let instance = &scene.instances[source as usize];
        let mesh = instance.mesh as usize;
        first_triangles.push(hierarchy.mesh_first_triangle[mesh]);
        top[place] = levels[mesh].as_ref().map(|level| {
            let mut transform = [0.0; 12];
            transform.copy_from_slice(rows(&instance.transform).as_flattened());
            wgpu::TlasInstance::new(&level.structure, transform, 0, 0xff)
        });
    }

    let geometries: Vec<_> = levels.iter().flatten().map(BottomLevel::entry).collect();
    let descriptor = wgpu::CommandEncoderDescriptor {
        label: Some("acceleration structures"),
    };
    let mut encoder = gpu.device().create_command_encoder(&descriptor);
    encoder.build_acceleration_structures(&geometries, [&top]);
    gpu.queue().submit([encoder.finish()]);
    if let Some(error) = pollster::block_on(scope.pop()) {
        return Err(GpuError::Driver(error.to_string()));
    }
    gpu.wait()?;
    resources.set_structure("scene_structure", Arc::new(top));
    let words = bytemuck::cast_slice(&first_triangles);
    let buffer = gpu.storage_buffer("first triangles", words)?;
    resources.set_buffer("first_triangles", buffer);
    Ok(is_single_sided)
}

/// What the triangles of a mesh say of their materials.
fn flags_of<'a>(mesh: &'a Mesh, flags: &'a [[u32; 2]]) -> impl Iterator<Item = u32> + 'a {
    let has_colors = usize::from(!mesh.colors.is_empty());
    let materials = mesh.triangle_materials.iter();
    materials.map(move |&material| flags[material as usize][has_colors])
}

/// A mesh's structure and what it is built from.
struct BottomLevel {
    structure: wgpu::Blas,
    size: wgpu::BlasTriangleGeometrySizeDescriptor,
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
}

impl BottomLevel {
    fn new(gpu: &Gpu, mesh: &Mesh, order: &[u32], is_opaque: bool) -> Result<Self, GpuError> {
        let triangles = order.iter().map(|&t| mesh.triangles[t as usize]);
        let indices: Vec<[u32; 3]> = triangles.collect();
        let upload = |label, bytes: &[u8]| -> Result<wgpu::Buffer, GpuError> {
            let usage = wgpu::BufferUsages::BLAS_INPUT;
            let buffer = gpu.empty_buffer(label, bytes.len() as u64, usage)?;
            gpu.queue().write_buffer(&buffer, 0, bytes);
            Ok(buffer)
        };
        let size = wgpu::BlasTriangleGeometrySizeDescriptor {
            vertex_format: wgpu::VertexFormat::Float32x3,
            vertex_count: mesh.positions.len() as u32,
            index_format: Some(wgpu::IndexFormat::Uint32),
            index_count: Some(3 * indices.len() as u32),
            flags: match is_opaque {
                true => wgpu::AccelerationStructureGeometryFlags::OPAQUE,
                false => wgpu::AccelerationStructureGeometryFlags::empty(),
            },
        };
        let descriptor = wgpu::CreateBlasDescriptor {
            label: Some("mesh"),
            flags: wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE,
            update_mode: wgpu::AccelerationStructureUpdateMode::Build,
        };
        let sizes = wgpu::BlasGeometrySizeDescriptors::Triangles {
            descriptors: vec![size.clone()],
        };
        Ok(Self {
            structure: gpu.device().create_blas(&descriptor, sizes),
            size,
            positions: upload("positions", bytemuck::cast_slice(&mesh.positions))?,
            indices: upload("indices", bytemuck::cast_slice(&indices))?,
        })
    }

    fn entry(&self) -> wgpu::BlasBuildEntry<'_> {
        wgpu::BlasBuildEntry {
            blas: &self.structure,
            geometry: wgpu::BlasGeometries::TriangleGeometries(vec![wgpu::BlasTriangleGeometry {
                size: &self.size,
                vertex_buffer: &self.positions,
                first_vertex: 0,
                vertex_stride: size_of::<glam::Vec3>() as u64,
                index_buffer: Some(&self.indices),
                first_index: Some(0),
                transform_buffer: None,
                transform_buffer_offset: None,
            }]),
        }
    }
}
