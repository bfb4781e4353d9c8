//! A whole scene without programs: each instance's driven materials in pictures of its own.

use std::collections::HashMap;

use glam::{Vec2, Vec4};
use texgen::{Diagnostic, Diagnostics};

use crate::scene::import::give_tangents;
use crate::scene::{Camera, CustomAttribute, Mesh, Sampler, Scene, TextureRef};

use super::cover::{Drawn, cover, crushed};
use super::unwrap::unwrap;
use super::{
    BakeError, BakeSettings, BakedMaterial, Baker, Progress, Role, Target, non_finite_warning,
};

/// Texels between pieces of what is unwrapped here.
const MARGIN: f32 = 4.0;
/// Texture coordinates in which more than this share overlaps, or is crushed to nothing, are made anew.
const MOST_OVERLAP: f64 = 2e-3;
/// Pictures of small things have so many texels along a side at least.
const LEAST_SIZE: u32 = 32;

impl Baker<'_> {
    /// The scene with pictures in place of programs. Instances whose materials are driven get meshes of their own, with new
    /// texture coordinates where theirs overlap, are missing, or leave a part of the surface without texels; the one with the
    /// greatest surface has pictures of the settings' size, others smaller ones. `camera` is the first one, if the scene hasn't it.
    ///
    /// # Errors
    /// As [`Self::material`].
    pub fn scene(
        &self,
        camera: &Camera,
        settings: &BakeSettings,
        progress: Progress<'_>,
    ) -> Result<(Scene, Diagnostics), BakeError> {
        let old = self.scene;
        let mut new = Builder::new(old);
        let areas: Vec<f32> = (0..old.instances.len())
            .map(|instance| self.driven_area(instance))
            .collect();
        let most = areas.iter().copied().fold(0.0, f32::max);
        for (instance, &area) in areas.iter().enumerate() {
            let placed = &old.instances[instance];
            let mesh = match area > 0.0 {
                false => new.shared_mesh(placed.mesh),
                true => {
                    let share = (area / most).sqrt();
                    let size = ((settings.size as f32 * share) as u32).next_power_of_two();
                    let settings = BakeSettings {
                        size: size.clamp(LEAST_SIZE.min(settings.size), settings.size),
                        ..*settings
                    };
                    let done = instance as f32 / areas.len() as f32;
                    let each = 1.0 / areas.len() as f32;
                    let told = &mut |share: f32| progress(done + each * share);
                    self.own_mesh(instance as u32, &settings, &mut new, told)?
                }
            };
            let mut placed = placed.clone();
            placed.mesh = mesh;
            new.scene.instances.push(placed);
        }
        put_first(&mut new.scene.cameras, camera);
        Ok((new.scene, new.warnings))
    }

    /// Of an instance, the surface that programs drive, in the world, square metres.
    fn driven_area(&self, instance: usize) -> f32 {
        let placed = &self.scene.instances[instance];
        let mesh = &self.scene.meshes[placed.mesh as usize];
        let triangles = mesh.triangles.iter().zip(&mesh.triangle_materials);
        let driven = triangles.filter(|(_, material)| self.procedural.is_procedural(**material));
        let area = |(corners, _): (&[u32; 3], &u32)| {
            let [a, b, c] = corners.map(|i| {
                placed
                    .transform
                    .transform_point3(mesh.positions[i as usize])
            });
            // What has no size is driven, too.
            (0.5 * (b - a).cross(c - a).length()).max(1e-20)
        };
        driven.map(area).sum()
    }

    fn own_mesh(
        &self,
        instance: u32,
        settings: &BakeSettings,
        new: &mut Builder<'_>,
        progress: Progress<'_>,
    ) -> Result<u32, BakeError> {
        let placed = &self.scene.instances[instance as usize];
        let mesh = &self.scene.meshes[placed.mesh as usize];
        let mut driven: Vec<u32> = mesh.triangle_materials.clone();
        driven.sort_unstable();
        driven.dedup();
        driven.retain(|&material| self.procedural.is_procedural(material));
        let mut layout = self.layout(instance, &driven, settings.size);
        give_tangents(&mut layout);
        let mut replaced = HashMap::new();
        for &material in &driven {
            let target = Target {
                instance,
                layout: &layout,
                material: Some(material),
            };
            let baked = match self.material(material, &target, settings, progress) {
                Ok(baked) => baked,
                // Nothing of it covers a texel: nothing of it will be seen, either.
                Err(BakeError::Empty { .. }) => continue,
                Err(error) => return Err(error),
            };
            let name = format!(
                "{} of {}",
                self.scene.materials[material as usize].name, placed.name
            );
            replaced.insert(material, new.material(baked, name));
        }
        for material in &mut layout.triangle_materials {
            *material = match replaced.get(material) {
                Some(own) => *own,
                None => new.shared_material(*material),
            };
        }
        layout.unbent = None;
        new.scene.meshes.push(layout);
        Ok(new.scene.meshes.len() as u32 - 1)
    }

    /// The mesh of an instance with texture coordinates that don't overlap where it has one of the `driven` materials.
    fn layout(&self, instance: u32, driven: &[u32], size: u32) -> Mesh {
        let placed = &self.scene.instances[instance as usize];
        let mesh = &self.scene.meshes[placed.mesh as usize];
        let is_driven = |triangle: usize| driven.contains(&mesh.triangle_materials[triangle]);
        let own: Vec<u32> = (0..mesh.triangles.len() as u32)
            .filter(|&triangle| is_driven(triangle as usize))
            .collect();
        let is_usable =
            !mesh.uv0.is_empty() && driven.iter().all(|&material| is_apart(mesh, material));
        if is_usable && mesh.colors.is_empty() {
            return mesh.clone();
        }
        let old = |triangle: u32| {
            mesh.triangles[triangle as usize]
                .map(|i| mesh.uv0.get(i as usize).copied().unwrap_or_default())
        };
        let made: Vec<[Vec2; 3]> = match is_usable {
            true => own.iter().map(|&triangle| old(triangle)).collect(),
            false => {
                let corners = own.iter().map(|&triangle| {
                    mesh.triangles[triangle as usize].map(|i| {
                        placed
                            .transform
                            .transform_point3(mesh.positions[i as usize])
                    })
                });
                unwrap(&corners.collect::<Vec<_>>(), MARGIN / size as f32)
            }
        };
        let mut uv: Vec<[Vec2; 3]> = (0..mesh.triangles.len() as u32).map(old).collect();
        for (&triangle, made) in own.iter().zip(made) {
            uv[triangle as usize] = made;
        }
        let mut layout = split(mesh, &uv, &is_driven);
        if !is_usable {
            // They were those of other texture coordinates.
            layout.tangents.clear();
        }
        layout
    }
}

/// Makes a camera the first one. It takes the place of one of its name that stands where it does: that one differs by its lens at most.
pub(super) fn put_first(cameras: &mut Vec<Camera>, camera: &Camera) {
    match cameras.first_mut() {
        Some(first) if (&first.name, first.transform) == (&camera.name, camera.transform) => {
            first.clone_from(camera);
        }
        _ => cameras.insert(0, camera.clone()),
    }
}

/// Whether no two places of what has a material share one of the picture, and all have one.
fn is_apart(mesh: &Mesh, material: u32) -> bool {
    const SIDE: u32 = 512;
    let triangles = (0u32..).zip(mesh.triangles.iter().zip(&mesh.triangle_materials));
    let drawn: Vec<Drawn> = triangles
        .filter(|(_, (_, of))| **of == material)
        .map(|(triangle, (corners, _))| Drawn {
            triangle,
            uv: corners.map(|i| mesh.uv0[i as usize]),
        })
        .collect();
    // What hasn't a texel shows what lies on the nearest one.
    let lost = crushed(mesh, &drawn, |_, area| area * f64::from(SIDE * SIDE) < 2.0);
    if lost > MOST_OVERLAP {
        return false;
    }
    let covered = cover(&drawn, SIDE, 1, 0..SIDE);
    let all = covered.samples.len() as f64 + covered.twice as f64;
    all > 0.0 && covered.twice as f64 <= MOST_OVERLAP * all
}

/// The mesh with these texture coordinates for each corner, and no vertex colours where `is_driven`: pictures hold them.
fn split(mesh: &Mesh, uv: &[[Vec2; 3]], is_driven: &dyn Fn(usize) -> bool) -> Mesh {
    let mut sources: Vec<u32> = Vec::new();
    let mut new = Mesh {
        name: mesh.name.clone(),
        triangle_materials: mesh.triangle_materials.clone(),
        ..Mesh::default()
    };
    let mut known: HashMap<(u32, [u32; 2], bool), u32> = HashMap::new();
    let mut is_white = Vec::new();
    for (number, corners) in mesh.triangles.iter().enumerate() {
        let driven = is_driven(number);
        let mut corner = |i: usize| {
            let (vertex, uv) = (corners[i], uv[number][i]);
            let key = (vertex, uv.to_array().map(f32::to_bits), driven);
            *known.entry(key).or_insert_with(|| {
                sources.push(vertex);
                new.uv0.push(uv);
                is_white.push(driven);
                sources.len() as u32 - 1
            })
        };
        new.triangles.push([corner(0), corner(1), corner(2)]);
    }
    new.positions = taken(&mesh.positions, &sources);
    new.normals = taken(&mesh.normals, &sources);
    new.tangents = taken(&mesh.tangents, &sources);
    new.uv1 = taken(&mesh.uv1, &sources);
    new.colors = taken(&mesh.colors, &sources);
    for (color, is_white) in new.colors.iter_mut().zip(is_white) {
        if is_white {
            *color = Vec4::ONE;
        }
    }
    let custom = mesh.custom.iter().map(|custom| CustomAttribute {
        name: custom.name.clone(),
        values: taken(&custom.values, &sources),
    });
    new.custom = custom.collect();
    new
}

/// The values of these vertices; none where there are none.
fn taken<T: Copy>(values: &[T], vertices: &[u32]) -> Vec<T> {
    match values.is_empty() {
        true => Vec::new(),
        false => vertices.iter().map(|&i| values[i as usize]).collect(),
    }
}

/// The new scene while it is made.
struct Builder<'a> {
    old: &'a Scene,
    scene: Scene,
    /// New numbers of meshes and materials that are as they were.
    meshes: HashMap<u32, u32>,
    materials: HashMap<u32, u32>,
    warnings: Diagnostics,
}

impl<'a> Builder<'a> {
    fn new(old: &'a Scene) -> Self {
        Self {
            old,
            scene: Scene {
                images: old.images.clone(),
                lights: old.lights.clone(),
                cameras: old.cameras.clone(),
                environment: old.environment.clone(),
                ..Scene::default()
            },
            meshes: HashMap::new(),
            materials: HashMap::new(),
            warnings: Diagnostics::new(),
        }
    }

    fn shared_mesh(&mut self, mesh: u32) -> u32 {
        if let Some(known) = self.meshes.get(&mesh) {
            return *known;
        }
        let mut copy = self.old.meshes[mesh as usize].clone();
        copy.unbent = None;
        for material in &mut copy.triangle_materials {
            *material = self.shared_material(*material);
        }
        self.scene.meshes.push(copy);
        let number = self.scene.meshes.len() as u32 - 1;
        self.meshes.insert(mesh, number);
        number
    }

    fn shared_material(&mut self, material: u32) -> u32 {
        if let Some(known) = self.materials.get(&material) {
            return *known;
        }
        let copy = self.old.materials[material as usize].clone();
        self.scene.materials.push(copy);
        let number = self.scene.materials.len() as u32 - 1;
        self.materials.insert(material, number);
        number
    }

    fn material(&mut self, baked: BakedMaterial, name: String) -> u32 {
        let BakedMaterial {
            mut material,
            images,
            lost,
            overlap,
            missed,
            non_finite,
            ..
        } = baked;
        for key in lost {
            let message = format!(
                "{name}: `{key}` differs from place to place, which glTF has no picture for"
            );
            self.warnings.push(Diagnostic::warning(message));
        }
        if overlap > 0.01 {
            let message = format!(
                "{name}: {:.0} % of the surface winds over itself where it was unwrapped, and shows what is elsewhere",
                100.0 * overlap
            );
            self.warnings.push(Diagnostic::warning(message));
        }
        if missed > 0.01 {
            let message = format!(
                "{name}: {:.0} % of the surface has no texel and shows what lies nearest; take a larger --size",
                100.0 * missed
            );
            self.warnings.push(Diagnostic::warning(message));
        }
        if let Some(words) = non_finite_warning(non_finite) {
            let message = format!("{name}: {words}");
            self.warnings.push(Diagnostic::warning(message));
        }
        for image in images {
            let file = format!("{name}, {}", image.role.name());
            self.scene.images.push(image.image(file));
            let texture = TextureRef {
                image: self.scene.images.len() as u32 - 1,
                uv_set: 0,
                sampler: Sampler::default(),
                transform: [glam::Vec3::X, glam::Vec3::Y],
            };
            *image.role.texture(&mut material) = Some(texture);
        }
        material.name = name;
        self.scene.materials.push(material);
        self.scene.materials.len() as u32 - 1
    }
}

impl Role {
    /// Where a material has such a picture.
    fn texture(self, m: &mut crate::scene::Material) -> &mut Option<TextureRef> {
        match self {
            Self::BaseColor => &mut m.base_color_texture,
            Self::MetallicRoughness => &mut m.metallic_roughness_texture,
            Self::Normal => &mut m.normal_texture,
            Self::Emission => &mut m.emission_texture,
            Self::Specular => &mut m.specular_texture,
            Self::SpecularColor => &mut m.specular_color_texture,
            Self::Transmission => &mut m.transmission_texture,
            Self::DiffuseTransmission => &mut m.diffuse_transmission_texture,
            Self::DiffuseTransmissionColor => &mut m.diffuse_transmission_color_texture,
            Self::SheenColor => &mut m.sheen_color_texture,
            Self::SheenRoughness => &mut m.sheen_roughness_texture,
            Self::Coat => &mut m.coat_texture,
            Self::CoatRoughness => &mut m.coat_roughness_texture,
            Self::CoatNormal => &mut m.coat_normal_texture,
            Self::Anisotropy => &mut m.anisotropy_texture,
            Self::Iridescence => &mut m.iridescence_texture,
            Self::IridescenceThickness => &mut m.iridescence_thickness_texture,
        }
    }
}
