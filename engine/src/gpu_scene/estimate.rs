//! What a scene will take on a device, before anything of it is there.

use device::Device;

use crate::{
    scene::{Environment, Mesh, Scene},
    texturing::{ProgramTraits, TextureReads},
};

use super::{
    GpuInstance,
    environment::{MAX_TABLE, STRIP},
    geometry, images,
    light_tree::GpuLightNode,
    lights::GpuLight,
    materials::GpuMaterial,
};

/// Bytes of a triangle's share in the hierarchy, at most: of the kernels' own, and of that which rays on a processor want (blocks of four
/// triangles of 160 bytes, seldom full, and nodes of 256).
const HIERARCHY: u64 = 40;
const HIERARCHY_OF_PROCESSOR: u64 = 120;
/// Bytes of an instance's share in the hierarchy over all: of the kernels' own, and of that which rays on a processor want (its two maps, its
/// group and what finds that, a hierarchy of its own once it is asked for, and two nodes of 256 bytes for seven, once while they are built).
const INSTANCE: u64 = 40;
const INSTANCE_OF_PROCESSOR: u64 = 376;
/// Bytes of a light: its record, and at most two of the tree over them.
const LIGHT: u64 = (size_of::<GpuLight>() + 2 * size_of::<GpuLightNode>()) as u64;
/// Bytes of a texel of the environment and of a cell of its table: four words each.
const TEXEL: u64 = 16;

/// Bytes of a scene on a device: of its buffers and images as they will be, nearly, of its hierarchy what it takes at most as a rule.
///
/// `program` says what is known of a material's texture program.
pub(crate) fn bytes(
    device: &Device,
    scene: &Scene,
    reads: &TextureReads<'_>,
    program: impl Fn(u32) -> ProgramTraits,
) -> u64 {
    let triangles: u64 = scene.meshes.iter().map(|m| m.triangles.len() as u64).sum();
    let (hierarchy, instance) = match device.traits().calls_functions {
        true => (HIERARCHY_OF_PROCESSOR, INSTANCE_OF_PROCESSOR),
        false => (HIERARCHY, INSTANCE),
    };
    let environment = match &scene.environment {
        Environment::Constant(_) => 0,
        Environment::Image { image, .. } => {
            let texels = u64::from(image.width) * u64::from(image.height);
            let cells = texels.min(u64::from(MAX_TABLE.0) * u64::from(MAX_TABLE.1));
            // The processor has one strip of the picture beside it while it is made; drivers keep all of them until they are handed over.
            let on_the_way = match device.traits().calls_functions {
                true => texels.min(u64::from(STRIP)),
                false => texels,
            };
            // The table has every cell twice, and is there once more while it is made.
            TEXEL * (texels + 4 * cells + on_the_way)
        }
    };
    let records = scene.instances.len() * size_of::<GpuInstance>()
        + scene.materials.len() * size_of::<GpuMaterial>();
    triangles * (16 + hierarchy)
        + geometry::vertex_bytes(scene, reads.attributes)
        + instance * scene.instances.len() as u64
        + images::bytes(&device.limits(), scene, reads)
        + environment
        + LIGHT * lights(scene, program)
        + records as u64
}

/// Lights with records: triangles that glow, of all instances, and those that are points or far away.
fn lights(scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> u64 {
    let materials = (0..).zip(&scene.materials);
    let glows: Vec<bool> = materials
        .map(|(number, material)| {
            let program = program(number);
            !material.unlit
                && match program.decides_light {
                    true => program.brightness > 0.0,
                    false => material.emission.max_element() > 0.0,
                }
        })
        .collect();
    let is_light = |material: &&u32| glows.get(**material as usize) == Some(&true);
    let of_mesh = |mesh: &Mesh| mesh.triangle_materials.iter().filter(is_light).count();
    let of_meshes: Vec<usize> = scene.meshes.iter().map(of_mesh).collect();
    let instances = scene.instances.iter();
    let of_instances = instances.filter_map(|instance| of_meshes.get(instance.mesh as usize));
    (of_instances.sum::<usize>() + scene.lights.len()) as u64
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use device::DeviceChoice;

    use super::*;
    use crate::scene::{FloatImage, Image, Instance, Material};

    fn bytes_of(scene: &Scene, with_levels: &[u32]) -> u64 {
        let device = Device::open(&DeviceChoice::Native(1)).expect("the processor");
        let reads = TextureReads {
            with_levels,
            ..TextureReads::default()
        };
        bytes(&device, scene, &reads, |_| ProgramTraits::default())
    }

    #[test]
    fn a_long_image_takes_little() {
        let mut scene = Scene::default();
        let without = bytes_of(&scene, &[]);
        scene.images.push(Image {
            name: "long".to_owned(),
            width: 8200,
            height: 16,
            rgba8: vec![0u8; 4 * 8200 * 16].into(),
            srgb: true,
        });
        let alone = bytes_of(&scene, &[]) - without;
        assert!((2 << 20..3 << 20).contains(&alone), "{alone}");
        let with_levels = bytes_of(&scene, &[0]) - without;
        assert!((alone..2 * alone).contains(&with_levels), "{with_levels}");
    }

    #[test]
    fn a_large_environment_takes_little_more_than_its_picture() {
        let mut scene = Scene::default();
        let without = bytes_of(&scene, &[]);
        scene.environment = Environment::Image {
            image: Arc::new(FloatImage {
                width: 16384,
                height: 8192,
                rgb: Vec::new(),
            }),
            rotation: 0.0,
            intensity: 1.0,
        };
        let more = bytes_of(&scene, &[]) - without;
        assert!((2 << 30..(2 << 30) + (64 << 20)).contains(&more), "{more}");
    }

    #[test]
    fn triangles_that_glow_take_more_in_each_instance() {
        let mut scene = Scene::default();
        let instance = Instance {
            mesh: 0,
            name: String::new(),
            transform: glam::Affine3A::IDENTITY,
            asset: None,
        };
        scene.instances = vec![instance; 3];
        scene.materials = vec![Material::default(); 2];
        scene.meshes.push(Mesh {
            positions: vec![glam::Vec3::ZERO; 3],
            triangles: vec![[0, 1, 2]; 100],
            triangle_materials: [vec![0; 60], vec![1; 40]].concat(),
            ..Mesh::default()
        });
        let dark = bytes_of(&scene, &[]);
        scene.materials[1].emission = glam::Vec3::ONE;
        assert_eq!(bytes_of(&scene, &[]) - dark, 3 * 40 * 192);
        scene.materials[1].unlit = true;
        assert_eq!(bytes_of(&scene, &[]), dark);
        // What a program makes of it counts.
        let driven = |brightness| ProgramTraits {
            decides_light: true,
            brightness,
            ..ProgramTraits::default()
        };
        assert_eq!(lights(&scene, |_| driven(1.0)), 3 * 60);
        assert_eq!(lights(&scene, |_| driven(0.0)), 0);
    }

    #[test]
    fn instances_take_more_than_their_records() {
        let mut scene = Scene::default();
        let without = bytes_of(&scene, &[]);
        let instance = Instance {
            mesh: 0,
            name: String::new(),
            transform: glam::Affine3A::IDENTITY,
            asset: None,
        };
        scene.instances = vec![instance; 1000];
        let each = (bytes_of(&scene, &[]) - without) / 1000;
        assert!(each >= 500, "{each}");
    }
}
