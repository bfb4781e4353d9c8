//! What a material looks like at places: its constants, its pictures, and what its programs drive; blends are mixed.

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{Vec3, Vec4};
use rayon::prelude::*;
use texgen::Program;

use crate::evaluate::{EvaluateError, Sites};
use crate::procedural::{MaskRecipe, Output, Procedural, Recipe, SurfaceRecipe};
use crate::scene::{AlphaMode, Material, Scene};

use super::BakeError;
use super::images::sample;
use super::place::{Place, Placed};

/// Outputs by number; numbers are in all components. The normal is a direction in the world, and the bump is in it.
///
/// The last one is the normal of the coat, which no program drives.
pub(super) type Appearance = [Vec3; Output::ALL.len() + 1];

/// Where an [`Appearance`] has the normal of the coat.
pub(super) const COAT_NORMAL: usize = Output::ALL.len();

/// A material with all that is below its blends.
pub(super) struct Painter<'a> {
    scene: &'a Scene,
    sites: &'a Sites<'a>,
    /// What lies below comes first; the material itself is the last.
    recipes: Vec<(u32, Recipe)>,
    /// Tables of ambient occlusion that its programs read, a bit each.
    pub(super) occlusion: u32,
    /// Vertices have colours.
    has_colors: bool,
    /// Results of programs that weren't finite.
    non_finite: AtomicU64,
}

/// The places of a batch, with what textures read there.
pub(super) struct Batch<'a> {
    pub(super) placed: &'a Placed<'a>,
    pub(super) places: &'a [Place],
    /// A stride of values for each.
    pub(super) values: &'a [[f32; 4]],
    /// Ambient occlusion of each.
    pub(super) occlusion: &'a [[f32; 4]],
}

impl<'a> Painter<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        procedural: &Procedural,
        sites: &'a Sites<'a>,
        material: u32,
        has_colors: bool,
    ) -> Result<Self, BakeError> {
        let mut occlusion = 0;
        let mut recipes = Vec::new();
        for index in procedural.below(material) {
            let recipe = procedural.recipe(index)?;
            let programs = match &recipe {
                Recipe::Blend { mask, .. } => match mask {
                    MaskRecipe::Driven(program, _) => vec![program],
                    MaskRecipe::Constant(_) => Vec::new(),
                },
                Recipe::Surface(surface) => {
                    let bump = surface.bump.iter().map(|(program, _)| program);
                    surface.program.iter().chain(bump).collect()
                }
            };
            occlusion |= programs.iter().fold(0, |all, p| all | p.occlusion_mask);
            recipes.push((index, recipe));
        }
        Ok(Self {
            scene,
            sites,
            recipes,
            occlusion,
            has_colors,
            non_finite: AtomicU64::new(0),
        })
    }

    /// How many results of programs weren't finite, in all batches so far: they count as 0.
    pub(super) fn non_finite(&self) -> u64 {
        self.non_finite.load(Ordering::Relaxed)
    }

    /// What the links of a program give at each place.
    fn run(
        &self,
        program: &Program,
        links: &[u32],
        values: &[[f32; 4]],
    ) -> Result<Vec<[f32; 4]>, EvaluateError> {
        let results = self.sites.run(program, links, values)?;
        let spoiled = results.par_iter().filter(|result| !is_finite(result));
        let spoiled = spoiled.count() as u64;
        self.non_finite.fetch_add(spoiled, Ordering::Relaxed);
        Ok(results)
    }

    /// Whether it is made of several surfaces.
    pub(super) fn is_mixed(&self) -> bool {
        self.recipes.len() > 1
    }

    /// Whether anything of the material differs from place to place: a program, a picture or the vertices give it, or surfaces
    /// are mixed.
    pub(super) fn varies(&self, output: Output) -> bool {
        if self.is_mixed() {
            return true;
        }
        let is_colored = self.has_colors && [Output::BASE_COLOR, Output::OPACITY].contains(&output);
        self.recipes.iter().any(|(index, recipe)| match recipe {
            Recipe::Blend { .. } => true,
            Recipe::Surface(surface) => {
                let is_driven = surface.outputs.iter().any(|(driven, _)| *driven == output);
                let material = &self.scene.materials[*index as usize];
                is_driven || is_colored || has_picture(material, output)
            }
        })
    }

    /// The surfaces that are seen of a material: those of a blend that its mask leaves out everywhere aren't.
    fn surfaces_of(&self, material: u32) -> Vec<u32> {
        let mut open = vec![material];
        // Blends may share what they blend: each is followed once.
        let mut met = HashSet::new();
        let mut surfaces = Vec::new();
        while let Some(index) = open.pop() {
            if !met.insert(index) {
                continue;
            }
            let recipe = self.recipes.iter().find(|(of, _)| *of == index);
            match recipe.map(|(_, recipe)| recipe) {
                Some(Recipe::Blend { base, over, mask }) => match mask {
                    MaskRecipe::Constant(share) if *share <= 0.0 => open.push(*base),
                    MaskRecipe::Constant(share) if *share >= 1.0 => open.push(*over),
                    _ => open.extend([*base, *over]),
                },
                _ => surfaces.push(index),
            }
        }
        surfaces
    }

    /// Whether a program of a surface drives one of these outputs.
    fn drives(&self, material: u32, keys: &[&str]) -> bool {
        self.recipes.iter().any(|(index, recipe)| match recipe {
            Recipe::Surface(surface) if *index == material => {
                let mut driven = surface.outputs.iter();
                driven.any(|(output, _)| keys.contains(&output.key()))
            }
            _ => false,
        })
    }

    /// Gives a blend what no picture holds of the surfaces that are seen of it, as far as it means something on them: what a body absorbs
    /// does where light goes through. Where they differ in that the blend keeps its own: says in what.
    pub(super) fn keep_constants(&self, material: &mut Material) -> Vec<&'static str> {
        let Some((last, Recipe::Blend { .. })) = self.recipes.last() else {
            return Vec::new();
        };
        let (mut all, mut films, mut clear) = (Vec::new(), Vec::new(), Vec::new());
        for index in self.surfaces_of(*last) {
            let surface = &self.scene.materials[index as usize];
            all.push(surface);
            if surface.iridescence > 0.0 || self.drives(index, &["iridescence"]) {
                films.push(surface);
            }
            if surface.transmission.max(surface.diffuse_transmission) > 0.0
                || self.drives(index, &["transmission", "diffuse_transmission"])
            {
                clear.push(surface);
            }
        }
        let mut lost = Vec::new();
        macro_rules! keep {
            ($surfaces:expr, $key:literal, $field:ident) => {
                match one(&$surfaces, |surface| surface.$field) {
                    Ok(Some(value)) => material.$field = value,
                    Ok(None) => {}
                    Err(Differing) => lost.push($key),
                }
            };
        }
        keep!(all, "unlit", unlit);
        keep!(films, "iridescence_ior", iridescence_ior);
        keep!(clear, "solid", is_solid);
        clear.retain(|surface| surface.is_solid);
        keep!(clear, "dispersion", dispersion);
        // What is absorbed is what counts; a colour and a distance together say it.
        match one(&clear, |surface| surface.absorption) {
            Ok(Some(_)) => {
                material.attenuate(clear[0].attenuation_color, clear[0].attenuation_distance);
            }
            Ok(None) => {}
            Err(Differing) => lost.push(match one(&clear, |surface| surface.attenuation_color) {
                Ok(_) => "attenuation_distance",
                Err(Differing) => "attenuation_color",
            }),
        }
        lost
    }

    /// Whether a coat has a normal map of its own; the surface below a coat has no part in its normal.
    pub(super) fn has_coat_normal(&self) -> bool {
        self.recipes.iter().any(|(index, recipe)| {
            let material = &self.scene.materials[*index as usize];
            matches!(recipe, Recipe::Surface(_)) && material.coat_normal_texture.is_some()
        })
    }

    /// What the material looks like at each place of a batch.
    pub(super) fn paint(&self, batch: &Batch<'_>) -> Result<Vec<Appearance>, BakeError> {
        let mut done: HashMap<u32, Vec<Appearance>> = HashMap::new();
        for (index, recipe) in &self.recipes {
            let painted = match recipe {
                Recipe::Surface(surface) => self.surface(*index, surface, batch)?,
                Recipe::Blend { base, over, mask } => {
                    let share = self.mask(mask, batch)?;
                    let (base, over) = (&done[base], &done[over]);
                    let mix =
                        |i: usize| std::array::from_fn(|o| base[i][o].lerp(over[i][o], share(i)));
                    (0..batch.places.len()).map(mix).collect()
                }
            };
            done.insert(*index, painted);
        }
        let last = self.recipes.last().map(|(index, _)| *index);
        Ok(last.and_then(|last| done.remove(&last)).unwrap_or_default())
    }

    fn mask(
        &self,
        mask: &MaskRecipe,
        batch: &Batch<'_>,
    ) -> Result<Box<dyn Fn(usize) -> f32>, EvaluateError> {
        Ok(match mask {
            MaskRecipe::Constant(share) => {
                let share = *share;
                Box::new(move |_| share)
            }
            MaskRecipe::Driven(program, link) => {
                let shares = self.run(program, &[*link], batch.values)?;
                Box::new(move |i| finite(shares[i])[0].clamp(0.0, 1.0))
            }
        })
    }

    fn surface(
        &self,
        index: u32,
        surface: &SurfaceRecipe,
        batch: &Batch<'_>,
    ) -> Result<Vec<Appearance>, BakeError> {
        let links: Vec<u32> = surface.outputs.iter().map(|(_, link)| *link).collect();
        let driven = match &surface.program {
            Some(program) => self.run(program, &links, batch.values)?,
            None => Vec::new(),
        };
        let rises = self.rises(surface, batch)?;
        let material = &self.scene.materials[index as usize];
        let one = |i: usize| {
            let given: Vec<(Output, Vec3)> = (surface.outputs.iter().enumerate())
                .map(|(o, (output, _))| (*output, finite(driven[i * links.len() + o]).into()))
                .collect();
            let rise = rises.get(i).copied().unwrap_or_default();
            self.at(material, surface, &given, rise, batch, i)
        };
        Ok((0..batch.places.len()).into_par_iter().map(one).collect())
    }

    /// How the height rises at each place, as a vector in the plane of its triangle; nothing where there is no height.
    fn rises(&self, surface: &SurfaceRecipe, batch: &Batch<'_>) -> Result<Vec<Vec3>, BakeError> {
        let Some((program, link)) = &surface.bump else {
            return Ok(Vec::new());
        };
        let layout = self.sites.layout();
        let stride = layout.stride();
        let frames: Vec<[Vec3; 2]> = batch.places.iter().map(steps).collect();
        let mut heights = vec![self.run(program, &[*link], batch.values)?];
        for direction in [0usize, 1] {
            let mut values = batch.values.to_vec();
            (values.par_chunks_mut(stride).enumerate()).for_each(|(i, values)| {
                let place = &batch.places[i];
                let moved = batch.placed.moved(place, frames[i][direction]);
                (batch.placed).write(&moved, layout, batch.occlusion[i], values);
            });
            heights.push(self.run(program, &[*link], &values)?);
        }
        let rise = |i: usize| -> Vec3 {
            let [here, along, across] = [0, 1, 2].map(|h: usize| finite(heights[h][i])[0]);
            let slope = |there: f32, step: Vec3| {
                step * ((there - here) * surface.bump_scale / step.length_squared().max(1e-30))
            };
            slope(along, frames[i][0]) + slope(across, frames[i][1])
        };
        Ok((0..batch.places.len()).map(rise).collect())
    }

    fn at(
        &self,
        material: &Material,
        surface: &SurfaceRecipe,
        driven: &[(Output, Vec3)],
        rise: Vec3,
        batch: &Batch<'_>,
        i: usize,
    ) -> Appearance {
        let (placed, place) = (batch.placed, &batch.places[i]);
        let given = |key: &str| {
            let found = driven.iter().find(|(output, _)| output.key() == key);
            found.map(|(_, value)| *value)
        };
        let texel = |texture| sample(self.scene, texture, |set| placed.uv(place, set));
        let base =
            texel(material.base_color_texture.as_ref()) * material.base_color * placed.color(place);
        let rough = texel(material.metallic_roughness_texture.as_ref());
        let constant = |key: &str| -> Vec3 {
            let m = material;
            let all = Vec3::splat;
            let rgb = |texture| Vec4::truncate(texel(texture));
            match key {
                "base_color" => base.truncate(),
                "metallic" => all(m.metallic * rough.z),
                "roughness" => all(m.roughness * rough.y),
                "emission" => m.emission * rgb(m.emission_texture.as_ref()),
                "emission_strength" => Vec3::ONE,
                "opacity" => all(opacity(m.alpha_mode, base.w)),
                "normal_scale" => all(m.normal_scale),
                "specular" => all(m.specular * texel(m.specular_texture.as_ref()).w),
                "specular_color" => m.specular_color * rgb(m.specular_color_texture.as_ref()),
                "ior" => all(m.ior),
                "transmission" => all(m.transmission * texel(m.transmission_texture.as_ref()).x),
                "diffuse_transmission" => {
                    all(m.diffuse_transmission * texel(m.diffuse_transmission_texture.as_ref()).w)
                }
                "diffuse_transmission_color" => {
                    let texture = m.diffuse_transmission_color_texture.as_ref();
                    m.diffuse_transmission_color * rgb(texture)
                }
                "coat" => all(m.coat * texel(m.coat_texture.as_ref()).x),
                "coat_roughness" => {
                    all(m.coat_roughness * texel(m.coat_roughness_texture.as_ref()).y)
                }
                "sheen_color" => m.sheen_color * rgb(m.sheen_color_texture.as_ref()),
                "sheen_roughness" => {
                    all(m.sheen_roughness * texel(m.sheen_roughness_texture.as_ref()).w)
                }
                "anisotropy" => all(m.anisotropy * texel(m.anisotropy_texture.as_ref()).z),
                "anisotropy_rotation" => all(rotation(m, texel(m.anisotropy_texture.as_ref()))),
                "iridescence" => all(m.iridescence * texel(m.iridescence_texture.as_ref()).x),
                "iridescence_thickness" => {
                    let [thin, thick] = m.iridescence_thickness;
                    let share = texel(m.iridescence_thickness_texture.as_ref()).y;
                    all(thin + (thick - thin) * share)
                }
                _ => Vec3::ZERO,
            }
        };
        let outputs = Output::ALL.map(|output| {
            let value = given(output.key());
            match output.key() {
                "emission" => value.map_or_else(
                    || constant("emission"),
                    |value| value.max(Vec3::ZERO) * surface.emission,
                ),
                // Radians, as what the material's own picture says.
                "anisotropy_rotation" => value.map_or_else(
                    || constant("anisotropy_rotation"),
                    |v| v * std::f32::consts::PI / 180.0,
                ),
                key => value.unwrap_or_else(|| constant(key)),
            }
        });
        let mut painted: Appearance = [Vec3::ZERO; COAT_NORMAL + 1];
        painted[..COAT_NORMAL].copy_from_slice(&outputs);
        let of = |output: Output| output.number() as usize;
        painted[of(Output::EMISSION)] *= painted[of(Output::EMISSION_STRENGTH)].x.max(0.0);
        let scale = painted[of(Output::NORMAL_SCALE)].x;
        let tangent = placed.tangent(placed.mesh, place);
        let by_map = |map: Option<_>, scale: f32| match map {
            None => place.normal,
            map => mapped(place.normal, tangent, texel(map).truncate(), scale),
        };
        painted[COAT_NORMAL] = by_map(
            material.coat_normal_texture.as_ref(),
            material.coat_normal_scale,
        );
        let normal = match given("normal").filter(|normal| is_direction(*normal)) {
            Some(normal) => normal.normalize(),
            None => by_map(material.normal_texture.as_ref(), scale),
        };
        // Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU", 2010.
        let leaning = normal - (rise - normal * rise.dot(normal));
        painted[of(Output::NORMAL)] = match is_direction(leaning) {
            true => leaning.normalize(),
            false => normal,
        };
        painted
    }
}

/// Surfaces don't agree.
struct Differing;

/// What all surfaces have; nothing where there are none.
fn one<T: PartialEq>(
    surfaces: &[&Material],
    of: impl Fn(&Material) -> T,
) -> Result<Option<T>, Differing> {
    let Some((first, others)) = surfaces.split_first() else {
        return Ok(None);
    };
    let value = of(first);
    match others.iter().all(|other| of(other) == value) {
        true => Ok(Some(value)),
        false => Err(Differing),
    }
}

/// Steps along and across the triangle of a place, at whose ends heights are compared.
fn steps(place: &Place) -> [Vec3; 2] {
    let along = place.edges[0].normalize_or(place.geometric.any_orthonormal_vector());
    let across = place.geometric.cross(along);
    let coarse = place.position.abs().max_element();
    let distance = (0.5 * place.footprint).max(1e-4 * coarse).max(1e-7);
    let side = |bit: u32| match place.sides & bit {
        0 => distance,
        _ => -distance,
    };
    [along * side(1), across * side(2)]
}

fn is_finite(result: &[f32; 4]) -> bool {
    result[..3].iter().all(|x| x.is_finite())
}

/// As the kernels take a result that is not finite.
fn finite(value: [f32; 4]) -> [f32; 3] {
    let [x, y, z, _] = value;
    match is_finite(&value) {
        true => [x, y, z],
        false => [0.0; 3],
    }
}

fn opacity(mode: AlphaMode, alpha: f32) -> f32 {
    match mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask { cutoff } => f32::from(u8::from(alpha >= cutoff)),
        AlphaMode::Blend => alpha.clamp(0.0, 1.0),
    }
}

fn rotation(material: &Material, texel: Vec4) -> f32 {
    let turned = match material.anisotropy_texture {
        Some(_) => (2.0 * texel.y - 1.0).atan2(2.0 * texel.x - 1.0),
        None => 0.0,
    };
    material.anisotropy_rotation + turned
}

fn mapped(normal: Vec3, tangent: Vec4, map: Vec3, scale: f32) -> Vec3 {
    let texel = 2.0 * map - 1.0;
    let along = tangent.truncate();
    let across = normal.cross(along) * tangent.w;
    let bent = along * (texel.x * scale) + across * (texel.y * scale) + normal * texel.z;
    bent.normalize_or(normal)
}

fn is_direction(v: Vec3) -> bool {
    (1e-12..1e12).contains(&v.length_squared())
}

/// Whether a picture of the material's decides about an output.
fn has_picture(m: &Material, output: Output) -> bool {
    let texture = match output.key() {
        "base_color" | "opacity" => &m.base_color_texture,
        "metallic" | "roughness" => &m.metallic_roughness_texture,
        "emission" => &m.emission_texture,
        "specular" => &m.specular_texture,
        "specular_color" => &m.specular_color_texture,
        "transmission" => &m.transmission_texture,
        "diffuse_transmission" => &m.diffuse_transmission_texture,
        "diffuse_transmission_color" => &m.diffuse_transmission_color_texture,
        "coat" => &m.coat_texture,
        "coat_roughness" => &m.coat_roughness_texture,
        "sheen_color" => &m.sheen_color_texture,
        "sheen_roughness" => &m.sheen_roughness_texture,
        "anisotropy" | "anisotropy_rotation" => &m.anisotropy_texture,
        "iridescence" => &m.iridescence_texture,
        "iridescence_thickness" => &m.iridescence_thickness_texture,
        _ => &None,
    };
    texture.is_some()
}
