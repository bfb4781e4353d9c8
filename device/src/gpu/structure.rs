//! Acceleration structures of a driver's, for kernels with ray queries.

use std::sync::Arc;

use glam::Vec3;

use crate::DeviceError;

use super::Gpu;

/// The triangles of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct MeshTriangles<'a> {
    /// Corners.
    pub positions: &'a [Vec3],
    /// Three corners each.
    pub triangles: &'a [[u32; 3]],
    /// No triangle ever lets a ray pass, so that the hardware needn't ask the kernel.
    pub is_opaque: bool,
}

/// A mesh at a place.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Which mesh.
    pub mesh: usize,
    /// From its space to the world's: three rows of a matrix.
    pub rows: [[f32; 4]; 3],
}

/// Meshes and their places, to be traced by ray queries. Clones share it.
#[derive(Debug, Clone)]
pub struct Structure {
    top: Arc<wgpu::Tlas>,
}

impl Structure {
    /// Builds the structure of a mesh for each mesh, and one above them. Waits for the device.
    ///
    /// # Errors
    /// More geometry than the driver's structures hold; what the driver reports.
    pub fn new(
        gpu: &Gpu,
        meshes: &[MeshTriangles<'_>],
        instances: &[Placed],
    ) -> Result<Self, DeviceError> {
        let device = gpu.device();
        let limits = device.limits();
        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let mut levels: Vec<Option<BottomLevel>> = Vec::new();
        for mesh in meshes {
            let limit = limits.max_blas_primitive_count;
            check("a mesh's triangles", mesh.triangles.len(), limit)?;
            let is_empty = mesh.triangles.is_empty();
            levels.push((!is_empty).then(|| BottomLevel::new(gpu, mesh)));
        }
        let limit = limits.max_tlas_instance_count;
        check("the instances", instances.len(), limit)?;
        let mut top = device.create_tlas(&wgpu::CreateTlasDescriptor {
            label: Some("instances"),
            max_instances: instances.len() as u32,
            flags: wgpu::AccelerationStructureFlags::PREFER_FAST_TRACE,
            update_mode: wgpu::AccelerationStructureUpdateMode::Build,
        });
        for (place, instance) in instances.iter().enumerate() {
            top[place] = levels[instance.mesh].as_ref().map(|level| {
                let mut transform = [0.0; 12];
                transform.copy_from_slice(instance.rows.as_flattened());
                wgpu::TlasInstance::new(&level.structure, transform, 0, 0xff)
            });
        }
        let geometries: Vec<_> = levels.iter().flatten().map(BottomLevel::entry).collect();
        let mut encoder = gpu.encoder("acceleration structures");
        encoder.build_acceleration_structures(&geometries, [&top]);
        gpu.queue().submit([encoder.finish()]);
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(DeviceError::Driver(error.to_string()));
        }
        gpu.wait()?;
        Ok(Self { top: Arc::new(top) })
    }

    pub(super) fn as_binding(&self) -> wgpu::BindingResource<'_> {
        self.top.as_binding()
    }
}

fn check(what: &str, needed: usize, limit: u32) -> Result<(), DeviceError> {
    if needed > limit as usize {
        return Err(DeviceError::TooLarge {
            what: what.to_owned(),
            needed: needed as u64,
            limit: u64::from(limit),
            remedy: "this driver's acceleration structures hold no more",
        });
    }
    Ok(())
}

/// A mesh's structure and what it is built from.
struct BottomLevel {
    structure: wgpu::Blas,
    size: wgpu::BlasTriangleGeometrySizeDescriptor,
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
}

impl BottomLevel {
    fn new(gpu: &Gpu, mesh: &MeshTriangles<'_>) -> Self {
        let upload = |label, bytes: &[u8]| {
            let usage = wgpu::BufferUsages::BLAS_INPUT;
            let size = (bytes.len() as u64).next_multiple_of(16);
            let buffer = gpu.plain_buffer(label, usage, size);
            gpu.write(&buffer, 0, bytes);
            buffer
        };
        let size = wgpu::BlasTriangleGeometrySizeDescriptor {
            vertex_format: wgpu::VertexFormat::Float32x3,
            vertex_count: mesh.positions.len() as u32,
            index_format: Some(wgpu::IndexFormat::Uint32),
            index_count: Some(3 * mesh.triangles.len() as u32),
            flags: match mesh.is_opaque {
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
        Self {
            structure: gpu.device().create_blas(&descriptor, sizes),
            size,
            positions: upload("positions", bytemuck::cast_slice(mesh.positions)),
            indices: upload("indices", bytemuck::cast_slice(mesh.triangles)),
        }
    }

    fn entry(&self) -> wgpu::BlasBuildEntry<'_> {
        wgpu::BlasBuildEntry {
            blas: &self.structure,
            geometry: wgpu::BlasGeometries::TriangleGeometries(vec![wgpu::BlasTriangleGeometry {
                size: &self.size,
                vertex_buffer: &self.positions,
                first_vertex: 0,
                vertex_stride: size_of::<Vec3>() as u64,
                index_buffer: Some(&self.indices),
                first_index: Some(0),
                transform_buffer: None,
                transform_buffer_offset: None,
            }]),
        }
    }
}
