//! The table of lights: emissive triangles and punctual lights. Those with a place are chosen by the light tree, those
//! infinitely far away by their irradiance.

use std::{collections::HashMap, f32::consts::PI};

use bytemuck::{Pod, Zeroable};
use glam::{Mat3, Vec3};

use crate::{
    alias::alias_table,
    bvh::SceneBvh,
    scene::{Image, LightKind, LightSource, MAX_ANGULAR_DIAMETER, Material, PunctualLight, Scene},
    texturing::ProgramTraits,
};

use super::{
    light_tree::{self, Emitter, GpuLightNode},
    materials::GpuMaterial,
};

const TRIANGLE: u32 = 0;
const POINT: u32 = 1;
const SPOT: u32 = 2;
const DIRECTIONAL: u32 = 3;

/// `Light` in `lights.wgsl`. Of lights that aren't triangles `triangle` is their group; of triangles `range` is their share of the area of
/// their lamp, and the bits of `spot_scale` are the number of its other triangle.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuLight {
    position: Vec3,
    kind: u32,
    direction: Vec3,
    range: f32,
    intensity: Vec3,
    leaf: u32,
    triangle: u32,
    instance: u32,
    spot_scale: f32,
    spot_outer: f32,
}

impl GpuLight {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(GpuLight, $member))),*] };
        }
        offsets![
            position, kind, direction, range, intensity, leaf, triangle, instance, spot_scale,
            spot_outer,
        ]
    }
}

/// A light on its way into the tree.
struct Placed {
    /// Its instance and triangle in the scene; of others what comes behind these.
    source: (u32, u32),
    /// Its number in the table.
    light: u32,
    emitter: Emitter,
    /// Its material and its corners, metres; of a triangle.
    surface: Option<(u32, [Vec3; 3])>,
}

/// Cosine of the angle between the normals of two triangles up to which they are one lamp: two and a half degrees.
const SAME_PLANE: f32 = 0.999;

/// Joins triangles that have an edge in common, two at a time, to lamps of which a point is sampled at once. A panel of two triangles is the
/// usual lamp, and to choose one of both, for each point that it lights, takes as long as to sample it.
fn join_pairs(lights: &mut [GpuLight], emitters: Vec<Placed>) -> Vec<(u32, Emitter)> {
    // Of each edge of an instance and a material, who lies there and waits for another one.
    let mut waiting = HashMap::<_, usize>::new();
    let mut lamps: Vec<(u32, Emitter)> = Vec::with_capacity(emitters.len());
    for placed in emitters {
        let Placed {
            source: (instance, _),
            light,
            emitter,
            surface,
        } = placed;
        let Some((material, corners)) = surface else {
            lamps.push((light, emitter));
            continue;
        };
        let bits = corners.map(|corner| corner.to_array().map(f32::to_bits));
        let edges = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| {
            let ends = [bits[a].min(bits[b]), bits[a].max(bits[b])];
            (instance, material, ends)
        });
        let partner = edges.iter().find_map(|edge| {
            let &lamp = waiting.get(edge)?;
            let (first, other) = &lamps[lamp];
            let is_alone = lights[*first as usize].range >= 1.0;
            (is_alone && other.axis.dot(emitter.axis) >= SAME_PLANE).then_some(lamp)
        });
        let Some(lamp) = partner else {
            for edge in edges {
                waiting.insert(edge, lamps.len());
            }
            lamps.push((light, emitter));
            continue;
        };
        let (first, other) = &mut lamps[lamp];
        // Both have one radiance, so that this is a share of the area.
        let share = other.intensity / (other.intensity + emitter.intensity);
        // One of them must not vanish beside the other.
        if !(0.01..=0.99).contains(&share) {
            lamps.push((light, emitter));
            continue;
        }
        for (own, share, partner) in [(*first, share, light), (light, 1.0 - share, *first)] {
            let own = &mut lights[own as usize];
            (own.range, own.spot_scale) = (share, f32::from_bits(partner));
        }
        *other = other.union(&emitter);
    }
    lamps
}

/// The lights of a scene but for its environment.
#[derive(Debug, Default)]
pub struct LightTable {
    /// Lights with a place: triangles by instance and triangle in the hierarchy's order, then points and spots.
    pub placed: Vec<GpuLight>,
    /// Those infinitely far away.
    pub directional: Vec<GpuLight>,
    /// The hierarchy over `placed`.
    pub tree: Vec<GpuLightNode>,
    /// Where those of `placed` are, a few at a time and in their order.
    pub(super) lamps: Vec<Lamp>,
}

/// Lights that lie together, to be asked where they are: a point, or neighbouring triangles of one instance.
#[derive(Debug)]
pub(crate) struct Lamp {
    /// As many of the table's lights, behind those of the lamps before.
    pub(crate) lights: usize,
    /// Places among which it is, metres; above surfaces, on the side that they emit to.
    pub(crate) places: Vec<Vec3>,
}

/// Most lamps of an instance that are asked for.
const LAMPS: usize = 4;
/// Places of a triangle lie so much of their distance to its middle from its corners, and above it so much of its size.
const INSIDE: f32 = 0.01;
const ABOVE: f32 = 1e-3;

impl Lamp {
    /// Of triangles, by their corners and the sign of their normals.
    fn of(lights: &[GpuLight], handedness: f32) -> Self {
        let mut asked = vec![0, lights.len() / 2, lights.len() - 1];
        asked.dedup();
        let places = asked.into_iter().flat_map(|number| {
            let light = &lights[number];
            let middle = light.position + (light.direction + light.intensity) / 3.0;
            let normal = light.direction.cross(light.intensity) * handedness;
            let rise = normal.normalize_or_zero() * (ABOVE * normal.length().sqrt());
            let corners = [Vec3::ZERO, light.direction, light.intensity];
            corners.map(|edge| (light.position + edge).lerp(middle, INSIDE) + rise)
        });
        Self {
            lights: lights.len(),
            places: places.collect(),
        }
    }
}

impl LightTable {
    /// Gathers the lights and tells emissive materials that they are among them.
    ///
    /// `program` says what is known of a material's texture program.
    pub fn gather(
        scene: &Scene,
        bvh: &SceneBvh,
        program: impl Fn(u32) -> ProgramTraits,
        materials: &mut [GpuMaterial],
    ) -> Self {
        // Many materials may have the same picture.
        let mut means = HashMap::new();
        let mut mean = |image: u32| {
            let mean = means.entry(image);
            *mean.or_insert_with(|| mean_color(&scene.images[image as usize]))
        };
        for (i, (material, source)) in materials.iter_mut().zip(&scene.materials).enumerate() {
            let program = program(i as u32);
            material.set_light_radiance(match (source.unlit, program.decides_light) {
                (true, _) => 0.0,
                (false, true) => program.brightness,
                (false, false) => average_emission(source, &mut mean),
            });
        }
        Self::of(scene, bvh, materials)
    }

    /// As [`Self::gather`], of materials that know how bright they are.
    pub(super) fn of(scene: &Scene, bvh: &SceneBvh, materials: &[GpuMaterial]) -> Self {
        let mut table = Self::default();
        let mut emitters = Vec::new();
        table.add_triangles(scene, bvh, materials, &mut emitters);
        table.add_punctual(scene, &mut emitters);
        // In the scene's order, not the hierarchy's: which light a random number chooses is the same on every device.
        emitters.sort_by_key(|emitter| emitter.source);
        let lamps = join_pairs(&mut table.placed, emitters);
        table.tree = light_tree::build(&lamps);
        for (place, node) in (0..).zip(&table.tree) {
            // The second record is no node.
            if place != 1
                && let Some(light) = node.light()
            {
                let first = &mut table.placed[light as usize];
                first.leaf = place;
                if first.kind == TRIANGLE && first.range < 1.0 {
                    let partner = first.spot_scale.to_bits();
                    table.placed[partner as usize].leaf = place;
                }
            }
        }
        table
    }

    fn add_triangles(
        &mut self,
        scene: &Scene,
        bvh: &SceneBvh,
        materials: &[GpuMaterial],
        emitters: &mut Vec<Placed>,
    ) {
        let radiance = |material: u32| materials[material as usize].light_radiance();
        for (place, &source) in (0..).zip(&bvh.instance_order) {
            let instance = &scene.instances[source as usize];
            let mesh = &scene.meshes[instance.mesh as usize];
            if !mesh.triangle_materials.iter().any(|&m| radiance(m) > 0.0) {
                continue;
            }
            let handedness = handedness(&Mat3::from(instance.transform.matrix3));
            let own = self.placed.len();
            let first = bvh.mesh_first_triangle[instance.mesh as usize];
            for (triangle, &t) in (first..).zip(&bvh.triangle_order[instance.mesh as usize]) {
                let material = mesh.triangle_materials[t as usize];
                if radiance(material) <= 0.0 {
                    continue;
                }
                let corners = mesh.triangles[t as usize].map(|v| {
                    instance
                        .transform
                        .transform_point3(mesh.positions[v as usize])
                });
                let [a, b, c] = corners;
                let normal = (b - a).cross(c - a);
                let area = 0.5 * normal.length();
                let intensity = area * radiance(material);
                // A triangle without area can't be hit, nor can a point on it be sampled.
                if !(area > 0.0 && intensity > 0.0 && intensity.is_finite()) {
                    continue;
                }
                emitters.push(Placed {
                    source: (source, t),
                    light: self.placed.len() as u32,
                    emitter: Emitter::triangle(
                        corners,
                        normal.normalize_or(Vec3::Y) * handedness,
                        intensity,
                        scene.materials[material as usize].double_sided,
                    ),
                    surface: Some((material, corners)),
                });
                self.placed.push(GpuLight {
                    position: a,
                    kind: TRIANGLE,
                    direction: b - a,
                    range: 1.0,
                    intensity: c - a,
                    triangle,
                    instance: place,
                    ..GpuLight::zeroed()
                });
            }
            let own = &self.placed[own..];
            let lamps = own.chunks(own.len().div_ceil(LAMPS).max(1));
            (self.lamps).extend(lamps.map(|lights| Lamp::of(lights, handedness)));
        }
    }

    fn add_punctual(&mut self, scene: &Scene, emitters: &mut Vec<Placed>) {
        let mut irradiances = Vec::new();
        for (number, light) in (0..).zip(&scene.lights) {
            let strength = luminance(light.intensity);
            if !(strength > 0.0 && strength.is_finite()) {
                continue;
            }
            let mut entry = GpuLight {
                position: light.position,
                direction: light.direction,
                range: light.range,
                intensity: light.intensity,
                triangle: scene.light_groups.of(LightSource::Light(&light.name)),
                ..GpuLight::zeroed()
            };
            let angle = match light.kind {
                LightKind::Directional | LightKind::Disk { .. } => {
                    irradiances.push(f64::from(strength));
                    self.directional.push(distant(light, entry));
                    continue;
                }
                LightKind::Point => {
                    entry.kind = POINT;
                    PI
                }
                LightKind::Spot {
                    inner_angle,
                    outer_angle,
                } => {
                    entry.kind = SPOT;
                    entry.spot_outer = outer_angle.cos();
                    entry.spot_scale = 1.0 / (inner_angle.cos() - outer_angle.cos()).max(1e-4);
                    outer_angle
                }
            };
            emitters.push(Placed {
                source: (u32::MAX, number),
                light: self.placed.len() as u32,
                emitter: Emitter::point(light.position, light.direction, angle, strength),
                surface: None,
            });
            self.placed.push(entry);
            self.lamps.push(Lamp {
                lights: 1,
                places: vec![light.position],
            });
        }
        for (light, cell) in self.directional.iter_mut().zip(alias_table(&irradiances)) {
            // `DISTANT_PROBABILITY` and `DISTANT_THRESHOLD`.
            light.position.x = cell.probability;
            light.position.y = cell.threshold;
            light.leaf = cell.alias;
        }
    }

    /// What the buffer `lights` holds.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = bytemuck::cast_slice(&self.placed).to_vec();
        bytes.extend_from_slice(bytemuck::cast_slice(&self.directional));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.tree));
        // At least one record, so that the array binding is never shorter than its element.
        bytes.resize(bytes.len().max(size_of::<GpuLight>()), 0);
        bytes
    }
}

/// A directional light: irradiance, or of a disk radiance and `DISTANT_EXTENT`.
fn distant(light: &PunctualLight, entry: GpuLight) -> GpuLight {
    let (mut intensity, mut extent) = (light.intensity, 0.0);
    if let LightKind::Disk { angular_diameter } = light.kind {
        // Smaller ones have no area in single precision.
        let radius = 0.5 * angular_diameter.clamp(1e-5, MAX_ANGULAR_DIAMETER);
        intensity /= PI * radius.sin().powi(2);
        // 1 - cos, which itself would lose most digits.
        extent = 2.0 * (0.5 * radius).sin().powi(2);
    }
    GpuLight {
        kind: DIRECTIONAL,
        position: Vec3::new(0.0, 0.0, extent),
        intensity,
        ..entry
    }
}

/// Of linear sRGB.
pub(crate) fn luminance(c: Vec3) -> f32 {
    c.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Mean luminance that a material emits: factor times its image's mean.
fn average_emission(material: &Material, mean: impl FnOnce(u32) -> Vec3) -> f32 {
    if material.emission.max_element() <= 0.0 {
        return 0.0;
    }
    let mean = material
        .emission_texture
        .map_or(Vec3::ONE, |t| mean(t.image));
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
