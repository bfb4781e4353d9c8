//! The table of lights: emissive triangles and punctual lights, chosen by power.

use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3};

use crate::{
    alias::alias_table,
    bvh::SceneBvh,
    procedural::ProgramTraits,
    scene::{Image, LightKind, Material, PunctualLight, Scene},
};

use super::materials::GpuMaterial;

const TRIANGLE: u32 = 0;
const POINT: u32 = 1;
const SPOT: u32 = 2;
const DIRECTIONAL: u32 = 3;

/// `Light` in `lights.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuLight {
    position: Vec3,
    kind: u32,
    direction: Vec3,
    range: f32,
    intensity: Vec3,
    probability: f32,
    alias_index: u32,
    alias_threshold: f32,
    spot_scale: f32,
    spot_outer: f32,
    triangle: u32,
    instance: u32,
    spare: [u32; 2],
}

impl GpuLight {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(GpuLight, $member))),*] };
        }
        offsets![
            position,
            kind,
            direction,
            range,
            intensity,
            probability,
            alias_index,
            alias_threshold,
            spot_scale,
            spot_outer,
            triangle,
            instance
        ]
    }
}

/// Gathers the lights and tells each emissive material its pdf per area.
///
/// `program` says what is known of a material's texture program. `radius` is that of a sphere around the scene, metres.
pub fn gather(
    scene: &Scene,
    bvh: &SceneBvh,
    radius: f32,
    program: impl Fn(u32) -> ProgramTraits,
    materials: &mut [GpuMaterial],
) -> Vec<GpuLight> {
    let strength: Vec<f32> = scene
        .materials
        .iter()
        .enumerate()
        .map(|(i, m)| {
            let program = program(i as u32);
            match (m.unlit, program.decides_light) {
                (true, _) => 0.0,
                (false, true) => program.brightness,
                (false, false) => average_emission(m, &scene.images),
            }
        })
        .collect();
    let mut lights = Vec::new();
    let mut weights = Vec::new();
    for (place, &source) in bvh.instance_order.iter().enumerate() {
        let instance = &scene.instances[source as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        if !mesh
            .triangle_materials
            .iter()
            .any(|&m| strength[m as usize] > 0.0)
        {
            continue;
        }
        let first = bvh.mesh_first_triangle[instance.mesh as usize];
        for (offset, &t) in bvh.triangle_order[instance.mesh as usize]
            .iter()
            .enumerate()
        {
            let material = mesh.triangle_materials[t as usize] as usize;
            if strength[material] <= 0.0 {
                continue;
            }
            let [a, b, c] = mesh.triangles[t as usize].map(|v| {
                instance
                    .transform
                    .transform_point3(mesh.positions[v as usize])
            });
            let area = 0.5 * (b - a).cross(c - a).length();
            // A triangle without area can't be hit, nor can a point on it be sampled.
            if area <= 0.0 || !area.is_finite() {
                continue;
            }
            weights.push(f64::from(area * strength[material] * std::f32::consts::PI));
            lights.push(GpuLight {
                position: a,
                kind: TRIANGLE,
                direction: b - a,
                intensity: c - a,
                triangle: first + offset as u32,
                instance: place as u32,
                ..GpuLight::zeroed()
            });
        }
    }
    for light in &scene.lights {
        let (entry, weight) = punctual(light, radius);
        if weight > 0.0 {
            lights.push(entry);
            weights.push(weight);
        }
    }
    let total: f64 = weights.iter().sum();
    for (light, cell) in lights.iter_mut().zip(alias_table(&weights)) {
        light.probability = cell.probability;
        light.alias_index = cell.alias;
        light.alias_threshold = cell.threshold;
    }
    if total > 0.0 {
        for (material, &strength) in materials.iter_mut().zip(&strength) {
            material.light_pdf = (f64::from(strength * std::f32::consts::PI) / total) as f32;
        }
    }
    lights
}

fn punctual(light: &PunctualLight, radius: f32) -> (GpuLight, f64) {
    let luminance = luminance(light.intensity);
    let mut entry = GpuLight {
        position: light.position,
        direction: light.direction,
        range: light.range,
        intensity: light.intensity,
        ..GpuLight::zeroed()
    };
    let sphere = 4.0 * std::f32::consts::PI;
    let power = match light.kind {
        LightKind::Point => {
            entry.kind = POINT;
            luminance * sphere
        }
        LightKind::Spot {
            inner_angle,
            outer_angle,
        } => {
            entry.kind = SPOT;
            entry.spot_outer = outer_angle.cos();
            entry.spot_scale = 1.0 / (inner_angle.cos() - outer_angle.cos()).max(1e-4);
            luminance * sphere * 0.5 * (1.0 - 0.5 * (inner_angle.cos() + outer_angle.cos()))
        }
        LightKind::Directional => {
            entry.kind = DIRECTIONAL;
            luminance * std::f32::consts::PI * radius * radius
        }
    };
    (entry, f64::from(power))
}

fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Mean luminance that a material emits: factor times its image's mean.
fn average_emission(material: &Material, images: &[Image]) -> f32 {
    if material.emission.max_element() <= 0.0 {
        return 0.0;
    }
    let mean = material
        .emission_texture
        .map_or(Vec3::ONE, |t| mean_color(&images[t.image as usize]));
    // A picture that is black on average may still hold light that rounding lost.
    luminance(material.emission * mean).max(luminance(material.emission) * 1e-4)
}

fn mean_color(image: &Image) -> Vec3 {
    let decode: Vec<f32> = (0..256u32)
        .map(|v| {
            let v = v as f32 / 255.0;
            match image.srgb {
                false => v,
                true if v <= 0.04045 => v / 12.92,
                true => ((v + 0.055) / 1.055).powf(2.4),
            }
        })
        .collect();
    let mut sum = glam::DVec3::ZERO;
    for texel in image.rgba8.chunks_exact(4) {
        sum += Vec3::new(
            decode[texel[0] as usize],
            decode[texel[1] as usize],
            decode[texel[2] as usize],
        )
        .as_dvec3();
    }
    (sum / (image.rgba8.len() / 4).max(1) as f64).as_vec3()
}

/// Sign of a transform's determinant: -1 where it mirrors.
pub fn handedness(matrix: &Mat3) -> f32 {
    if matrix.determinant() < 0.0 {
        -1.0
    } else {
        1.0
    }
}
