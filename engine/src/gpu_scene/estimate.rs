//! What a scene will take on a device, before anything of it is there.

use std::collections::HashSet;

use device::Device;

use crate::{
    scene::{Environment, Scene},
    texturing::TextureReads,
};

use super::{GpuInstance, geometry, materials::GpuMaterial};

/// Bytes of a triangle's share in the hierarchy, at most: of the kernels' own, and of that which rays on a processor want (blocks of four
/// triangles of 160 bytes, seldom full, and nodes of 256).
const HIERARCHY: u64 = 40;
const HIERARCHY_OF_PROCESSOR: u64 = 120;
/// Bytes of a texel of the environment and of its table: four floats each.
const TEXEL: u64 = 16;

/// Bytes of a scene on a device: of its buffers nearly as they will be, of its hierarchy and images what they take at most as a rule.
pub(crate) fn bytes(device: &Device, scene: &Scene, reads: &TextureReads<'_>) -> u64 {
    let triangles: u64 = scene.meshes.iter().map(|m| m.triangles.len() as u64).sum();
    let hierarchy = match device.traits().calls_functions {
        true => HIERARCHY_OF_PROCESSOR,
        false => HIERARCHY,
    };
    let environment = match &scene.environment {
        Environment::Constant(_) => 0,
        Environment::Image { image, .. } => {
            2 * TEXEL * u64::from(image.width) * u64::from(image.height)
        }
    };
    let records = scene.instances.len() * size_of::<GpuInstance>()
        + scene.materials.len() * size_of::<GpuMaterial>();
    triangles * (16 + hierarchy)
        + geometry::vertex_bytes(scene, reads.attributes)
        + images(scene, reads)
        + environment
        + records as u64
}

/// Bytes of the images with the levels that textures read. They lie side by side in layers of one size, which are seldom full.
fn images(scene: &Scene, reads: &TextureReads<'_>) -> u64 {
    let with_levels: HashSet<u32> = reads.with_levels.iter().copied().collect();
    let texels = (0..).zip(&scene.images).map(|(number, image)| {
        let full = u64::from(image.width) * u64::from(image.height);
        match with_levels.contains(&number) {
            true => full * 4 / 3,
            false => full,
        }
    });
    let largest = scene
        .images
        .iter()
        .map(|image| image.width.max(image.height));
    let layer = largest.max().map_or(0, |side| u64::from(side).pow(2));
    4 * (texels.sum::<u64>() * 5 / 4 + layer)
}
