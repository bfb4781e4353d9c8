//! The scene's geometry in acceleration structures of the driver's: a bottom level per mesh, a top level of the instances,
//! with triangles and instances in the order in which they lie on the GPU anyway.

use device::gpu::{MeshTriangles, Placed, Structure};
use device::{Device, DeviceError, Resources, Usage};

use crate::{
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
    gpu: &Device,
    scene: &Scene,
    program: impl Fn(u32) -> ProgramTraits,
    gpu_scene: &GpuScene,
    resources: &mut Resources,
) -> Result<bool, DeviceError> {
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
    let triangles: Vec<Vec<[u32; 3]>> = (scene.meshes.iter().zip(&hierarchy.triangle_order))
        .map(|(mesh, order)| order.iter().map(|&t| mesh.triangles[t as usize]).collect())
        .collect();
    let meshes: Vec<_> = (scene.meshes.iter().zip(&triangles))
        .map(|(mesh, triangles)| MeshTriangles {
            positions: &mesh.positions,
            triangles,
            is_opaque: flags_of(mesh, &flags).all(|flags| flags & judged == 0),
        })
        .collect();
    let placed = hierarchy.instance_order.iter().map(|&source| {
        let instance = &scene.instances[source as usize];
        Placed {
            mesh: instance.mesh as usize,
            rows: rows(&instance.transform),
        }
    });
    let placed: Vec<_> = placed.collect();
    let first_triangles: Vec<u32> = placed
        .iter()
        .map(|placed| hierarchy.mesh_first_triangle[placed.mesh])
        .collect();
    let driver = gpu.gpu().ok_or(DeviceError::NoAdapter)?;
    let structure = Structure::new(driver, &meshes, &placed)?;
    resources.set_structure("scene_structure", structure);
    let words = bytemuck::cast_slice(&first_triangles);
    let buffer = gpu.filled_buffer("first triangles", Usage::Storage, words)?;
    resources.set_buffer("first_triangles", buffer);
    Ok(is_single_sided)
}

/// What the triangles of a mesh say of their materials.
fn flags_of<'a>(mesh: &'a Mesh, flags: &'a [[u32; 2]]) -> impl Iterator<Item = u32> + 'a {
    let has_colors = usize::from(!mesh.colors.is_empty());
    let materials = mesh.triangle_materials.iter();
    materials.map(move |&material| flags[material as usize][has_colors])
}
