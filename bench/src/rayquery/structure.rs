//! The scene's geometry in acceleration structures of the driver's: a bottom level per mesh, a top level of the instances,
//! with triangles and instances in the order in which they lie on the GPU anyway.

use device::gpu::{MeshTriangles, Placed, Structure};
use device::{DeviceError, Resources, Usage};

use engine::{
    gpu_scene::{RayRules, ray_rules, rows},
    scene::Mesh,
    schedule::Upload,
};

/// Builds the structures and names them: `scene_structure`, and in `first_triangles` where each instance's triangles begin
/// in the buffer of all triangles. Returns whether every triangle of the scene is single-sided, so that the hardware may
/// leave out all backs.
///
/// # Errors
/// More geometry than the driver's structures hold; what the driver reports.
pub(super) fn build(upload: &Upload<'_>, resources: &mut Resources) -> Result<bool, DeviceError> {
    let (device, scene) = (upload.device, upload.scene);
    let hierarchy = upload.gpu_scene.hierarchy();
    let rules = ray_rules(scene, |material| upload.procedural.traits(material));
    let is_single_sided = scene
        .meshes
        .iter()
        .all(|mesh| rules_of(mesh, &rules).all(|rules| rules.is_single_sided));
    // A triangle that may let a ray pass has to be judged by the kernel.
    let is_judged =
        |rules: RayRules| rules.may_let_pass || !is_single_sided && rules.is_single_sided;
    let triangles: Vec<Vec<[u32; 3]>> = (scene.meshes.iter().zip(&hierarchy.triangle_order))
        .map(|(mesh, order)| order.iter().map(|&t| mesh.triangles[t as usize]).collect())
        .collect();
    let meshes: Vec<_> = (scene.meshes.iter().zip(&triangles))
        .map(|(mesh, triangles)| MeshTriangles {
            positions: &mesh.positions,
            triangles,
            is_opaque: !rules_of(mesh, &rules).any(is_judged),
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
    let driver = device.gpu().ok_or(DeviceError::NoAdapter)?;
    let structure = Structure::new(driver, &meshes, &placed)?;
    resources.set_structure("scene_structure", structure);
    let words = bytemuck::cast_slice(&first_triangles);
    let buffer = device.filled_buffer("first triangles", Usage::Storage, words)?;
    resources.set_buffer("first_triangles", buffer);
    Ok(is_single_sided)
}

/// The rules of a mesh's triangles.
fn rules_of<'a>(mesh: &'a Mesh, rules: &'a [[RayRules; 2]]) -> impl Iterator<Item = RayRules> + 'a {
    let has_colors = usize::from(!mesh.colors.is_empty());
    let materials = mesh.triangle_materials.iter();
    materials.map(move |&material| rules[material as usize][has_colors])
}
