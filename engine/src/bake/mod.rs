//! What a material looks like, or what a node gives, as pictures over texture coordinates.
//!
//! Each texel shows some points of the surface. What textures read there is what a hit would have that is looked at from
//! straight above: places in the world and in the object, normals, ambient occlusion, attributes of the mesh. Programs run in
//! the kernel of [`evaluate`](crate::evaluate), pictures and constants are added here, blends are mixed by their shares.
//!
//! What depends on the direction it is seen from can't be baked: it is as seen from above.

mod appearance;
mod cover;
mod files;
mod gltf;
mod images;
mod occlusion;
mod place;
mod scene;
#[cfg(test)]
mod tests;
mod unwrap;

use std::ops::ControlFlow;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use texgen::{Link, link_word};

use crate::evaluate::{EvaluateError, Sites};
use crate::procedural::{CompileError, MAX_STACK_SLOTS, Output, Procedural};
use crate::scene::look::AoSettings;
use crate::scene::{Mesh, Scene};
use device::{Device, DeviceError};

pub use files::{shown, write_exr};
pub use gltf::{BakedImage, BakedMaterial, Role};

use appearance::{Appearance, Batch, Painter};
use cover::{Drawn, Sample, cover, crushed, nearest};
use occlusion::Occluders;
use place::{Place, Placed};

/// Most texels along a side.
pub const MAX_SIZE: u32 = 8192;
/// Most samples along a side of a texel.
pub const MAX_GRID: u32 = 8;
/// Samples that are computed at once.
const BATCH: usize = 1 << 16;
/// Samples of a band of rows, whose places are found at once.
const BAND: usize = 1 << 22;

/// Why there are no pictures.
#[derive(Debug, thiserror::Error)]
pub enum BakeError {
    /// Nothing says where on a picture a point of the surface is.
    #[error(
        "mesh \"{mesh}\" has no texture coordinates (TEXCOORD_0), by which a picture would lie on it; unwrap it where it was modelled"
    )]
    NoCoordinates {
        /// The mesh.
        mesh: String,
    },
    /// No texel shows anything.
    #[error(
        "the texture coordinates of mesh \"{mesh}\" cover no texel where it has the material; unwrap it where it was modelled, or \
         take a larger --size"
    )]
    Empty {
        /// The mesh.
        mesh: String,
    },
    /// A program can't run.
    #[error(transparent)]
    Program(#[from] CompileError),
    /// A texture or the device.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// Too many triangles.
    #[error("{0}")]
    Geometry(String),
    /// The caller wanted no more.
    #[error("interrupted")]
    Interrupted,
}

impl From<DeviceError> for BakeError {
    fn from(error: DeviceError) -> Self {
        Self::Evaluate(error.into())
    }
}

/// How finely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BakeSettings {
    /// Texels along a side, 1 to [`MAX_SIZE`].
    pub size: u32,
    /// Samples along a side of a texel, 1 to [`MAX_GRID`].
    pub grid: u32,
    /// Ambient occlusion goes with the pictures, as far as this, metres.
    pub occlusion: Option<f32>,
    /// Base colour, metallic-roughness and normal are pictures even where they are the same everywhere.
    pub keeps_flat: bool,
}

/// When the scene is seen, and from where: what textures may ask.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moment {
    /// Seconds.
    pub time: f32,
    /// Number of the frame.
    pub frame: u32,
    /// The camera in the world, metres.
    pub camera: Vec3,
}

/// A mesh that pictures are made for.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// Index into [`Scene::instances`]: where it is.
    pub instance: u32,
    /// The instance's mesh, or one with the same triangles that has other texture coordinates in its first set, by which the
    /// pictures lie on it, and tangents, which normal maps are told by.
    pub layout: &'a Mesh,
    /// Only triangles of this material; all without it.
    pub material: Option<u32>,
}

/// Pictures of one target: some planes of numbers, and which texels show anything. The others repeat the nearest that does.
#[derive(Debug)]
pub struct Maps {
    /// Texels along a side.
    pub size: u32,
    /// Components of all planes in a row, texel by texel, row 0 on top.
    values: Vec<f32>,
    /// Components of a texel.
    stride: usize,
    /// Which texels show something of their own.
    is_shown: Vec<bool>,
    /// Share of the surface that has no place of its own: another part of it is shown there.
    pub overlap: f32,
    /// Share of the surface that has far less of the picture than the rest, and no texel: what lies nearest is shown there.
    pub missed: f32,
    /// Samples with numbers that are not finite: they count as 0.
    pub non_finite: u64,
}

impl Maps {
    /// Linear RGBA of each texel, where there are four components.
    pub fn rgba(&self) -> Vec<[f32; 4]> {
        let texels = self.values.chunks_exact(4);
        texels.map(|t| [t[0], t[1], t[2], t[3]]).collect()
    }

    /// So many components from `first` on of each texel.
    fn plane(&self, first: usize, count: usize) -> impl Iterator<Item = &[f32]> {
        let texels = self.values.chunks_exact(self.stride);
        texels.map(move |texel| &texel[first..first + count])
    }
}

/// Computes pictures of a scene's materials and nodes.
#[derive(Debug)]
pub struct Baker<'a> {
    device: &'a Device,
    scene: &'a Scene,
    procedural: &'a Procedural,
    sites: Sites<'a>,
    moment: Moment,
}

/// Gives the numbers of each place of a batch, whose openness it is told as well.
type Paint<'p> = &'p mut dyn FnMut(&Batch<'_>, &[f32]) -> Result<Vec<f32>, BakeError>;

/// How far it is, from 0 to 1; says whether to go on.
pub type Progress<'p> = &'p mut dyn FnMut(f32) -> ControlFlow<()>;

impl<'a> Baker<'a> {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// The device refuses.
    pub fn new(
        device: &'a Device,
        scene: &'a Scene,
        procedural: &'a Procedural,
        moment: Moment,
    ) -> Result<Self, BakeError> {
        Ok(Self {
            device,
            scene,
            procedural,
            sites: Sites::new(device, scene, procedural, 0)?,
            moment,
        })
    }

    /// What a node, or one of its outputs, gives: four components, the last ones filled up as [`evaluate`](crate::evaluate) does it.
    ///
    /// # Errors
    /// The mesh has no texture coordinates, the node's program can't run, the device fails, or the caller wants no more.
    pub fn node(
        &self,
        source: impl Into<Link>,
        target: &Target<'_>,
        settings: &BakeSettings,
        progress: Progress<'_>,
    ) -> Result<Maps, BakeError> {
        let source = source.into();
        let program = self.procedural.graph().compile_links(&[source]);
        let program = program.map_err(CompileError::from)?;
        let link = link_word(program.results[0], source.swizzle);
        let tables = program.occlusion_mask;
        if program.slots_needed > MAX_STACK_SLOTS {
            let needed = program.slots_needed;
            return Err(EvaluateError::TooManySlots { needed }.into());
        }
        // The kernel has room for what the materials need: a node that none uses may need more.
        let (device, slots) = (self.device, program.slots_needed);
        let sites = Sites::new(device, self.scene, self.procedural, slots)?;
        self.draw(target, settings, 4, tables, progress, &mut |batch, _| {
            let values = sites.run(&program, &[link], batch.values)?;
            Ok(values.into_iter().flatten().collect())
        })
    }

    /// What a material looks like, as glTF wants to be told.
    ///
    /// # Errors
    /// As [`Self::node`].
    pub fn material(
        &self,
        material: u32,
        target: &Target<'_>,
        settings: &BakeSettings,
        progress: Progress<'_>,
    ) -> Result<BakedMaterial, BakeError> {
        let placed = self.placed(target);
        let has_colors = !placed.mesh.colors.is_empty();
        let (scene, sites) = (self.scene, &self.sites);
        let painter = Painter::new(scene, self.procedural, sites, material, has_colors)?;
        let planes = gltf::Planes::of(&painter);
        let tables = painter.occlusion;
        let paint = &mut |batch: &Batch<'_>, open: &[f32]| {
            let painted = painter.paint(batch)?;
            let rows = (batch.places.par_iter().zip(&painted)).zip(open);
            let rows = rows.map(|((place, painted), open)| {
                let tangent = placed.tangent(target.layout, place);
                planes.texel(painted, place.normal, tangent, *open)
            });
            Ok(rows.collect::<Vec<_>>().concat())
        };
        let maps = self.draw(target, settings, planes.stride(), tables, progress, paint)?;
        let mut surface = scene.materials[material as usize].clone();
        let not_mixed = painter.keep_constants(&mut surface);
        let mut baked = planes.baked(&surface, &maps, settings);
        baked.lost.extend(not_mixed);
        baked.non_finite += painter.non_finite();
        Ok(baked)
    }

    fn placed<'t>(&'t self, target: &Target<'_>) -> Placed<'t> {
        let mesh = self.scene.instances[target.instance as usize].mesh;
        Placed::new(
            self.scene,
            &self.scene.meshes[mesh as usize],
            target.instance,
            self.sites.layout(),
            &self.moment,
        )
    }

    /// Finds the points that texels show, has `paint` give `stride` components for each, and averages them.
    fn draw(
        &self,
        target: &Target<'_>,
        settings: &BakeSettings,
        stride: usize,
        tables: u32,
        progress: Progress<'_>,
        paint: Paint<'_>,
    ) -> Result<Maps, BakeError> {
        let placed = self.placed(target);
        let mesh = placed.mesh;
        if target.layout.uv0.is_empty() {
            let mesh = mesh.name.clone();
            return Err(BakeError::NoCoordinates { mesh });
        }
        let drawn = drawn(target);
        let (size, grid) = (
            settings.size.clamp(1, MAX_SIZE),
            settings.grid.clamp(1, MAX_GRID),
        );
        let occluders = match tables != 0 || settings.occlusion.is_some() {
            true => Some(Occluders::new(self.scene)?),
            false => None,
        };
        let mut sums = Sums::new(size, stride);
        let row_samples = (size * grid * grid) as usize;
        let band = (BAND / row_samples).clamp(1, size as usize) as u32;
        let mut has_texel = vec![false; target.layout.triangles.len()];
        let mut first = 0;
        while first < size {
            let end = (first + band).min(size);
            let covered = cover(&drawn, size, grid, first..end);
            sums.twice = sums.twice.saturating_add(covered.twice);
            for sample in &covered.samples {
                has_texel[sample.triangle as usize] = true;
            }
            for samples in covered.samples.chunks(BATCH) {
                let done = sums.taken as f32 / (u64::from(size) * row_samples as u64) as f32;
                if progress(done).is_break() {
                    return Err(BakeError::Interrupted);
                }
                let side = 1.0 / (size * grid) as f32;
                let places: Vec<Place> = (samples.par_iter())
                    .map(|sample| place(&placed, target, sample, side))
                    .collect();
                let found = self.occluded(occluders.as_ref(), &places, target, tables, settings);
                let values = self.values(&placed, &places, &found.tables);
                let batch = Batch {
                    placed: &placed,
                    places: &places,
                    values: &values,
                    occlusion: &found.tables,
                };
                let painted = paint(&batch, &found.open)?;
                sums.add(samples, &painted);
            }
            first = end;
        }
        let name = &mesh.name;
        let mut maps = (sums.mean()).ok_or_else(|| BakeError::Empty { mesh: name.clone() })?;
        let is_lost = |drawn: &Drawn, _| !has_texel[drawn.triangle as usize];
        maps.missed = crushed(target.layout, &drawn, is_lost) as f32;
        Ok(maps)
    }

    fn values(
        &self,
        placed: &Placed<'_>,
        places: &[Place],
        occlusion: &[[f32; 4]],
    ) -> Vec<[f32; 4]> {
        let layout = self.sites.layout();
        let mut values = vec![[0.0; 4]; places.len() * layout.stride()];
        let rows = values.par_chunks_mut(layout.stride()).enumerate();
        rows.for_each(|(i, row)| placed.write(&places[i], layout, occlusion[i], row));
        values
    }

    fn occluded(
        &self,
        occluders: Option<&Occluders>,
        places: &[Place],
        target: &Target<'_>,
        tables: u32,
        settings: &BakeSettings,
    ) -> Occluded {
        let mut found = Occluded {
            tables: vec![[1.0; 4]; places.len()],
            open: vec![1.0; places.len()],
        };
        let Some(occluders) = occluders else {
            return found;
        };
        let asked = settings.occlusion.map(|distance| AoSettings {
            distance,
            ..AoSettings::default()
        });
        let all = self.procedural.ao();
        let sides = found.tables.par_iter_mut().zip(&mut found.open);
        sides.enumerate().for_each(|(i, (of_tables, open))| {
            let openness = |table: &AoSettings, seed: u32| {
                let seed = seed
                    .wrapping_add(i as u32)
                    .wrapping_add(places[i].triangle << 8);
                occluders.openness(&places[i], target.instance, table, seed)
            };
            for (table, value) in of_tables.iter_mut().enumerate() {
                if tables & (1 << table) != 0 {
                    *value = openness(&all[table], table as u32);
                }
            }
            if let Some(asked) = &asked {
                *open = openness(asked, 7);
            }
        });
        found
    }
}

/// Ambient occlusion of places.
struct Occluded {
    /// By the look's tables.
    tables: Vec<[f32; 4]>,
    /// As far as the settings say.
    open: Vec<f32>,
}

fn drawn(target: &Target<'_>) -> Vec<Drawn> {
    let mesh = target.layout;
    let triangles = (0..).zip(mesh.triangles.iter().zip(&mesh.triangle_materials));
    let wanted = triangles
        .filter(|(_, (_, material))| target.material.is_none_or(|wanted| wanted == **material));
    let drawn = |(triangle, (corners, _)): (u32, (&[u32; 3], &u32))| Drawn {
        triangle,
        uv: corners.map(|i| mesh.uv0[i as usize]),
    };
    wanted.map(drawn).collect()
}

fn place(placed: &Placed<'_>, target: &Target<'_>, sample: &Sample, side: f32) -> Place {
    let corners = target.layout.triangles[sample.triangle as usize];
    let uv: [Vec2; 3] = corners.map(|i| target.layout.uv0[i as usize]);
    Place {
        sides: sample.corner,
        ..placed.at(sample.triangle, sample.weights, uv, side)
    }
}

/// What the samples of texels add up to.
struct Sums {
    size: u32,
    stride: usize,
    values: Vec<f32>,
    counts: Vec<u32>,
    taken: u64,
    twice: u64,
    non_finite: u64,
}

impl Sums {
    fn new(size: u32, stride: usize) -> Self {
        let texels = (size as usize).pow(2);
        Self {
            size,
            stride,
            values: vec![0.0; texels * stride],
            counts: vec![0; texels],
            taken: 0,
            twice: 0,
            non_finite: 0,
        }
    }

    fn add(&mut self, samples: &[Sample], painted: &[f32]) {
        for (sample, painted) in samples.iter().zip(painted.chunks_exact(self.stride)) {
            let at = sample.texel as usize;
            self.counts[at] += 1;
            let is_finite = painted.iter().all(|value| value.is_finite());
            self.non_finite += u64::from(!is_finite);
            let sums = &mut self.values[at * self.stride..][..self.stride];
            for (sum, value) in sums.iter_mut().zip(painted) {
                *sum += if value.is_finite() { *value } else { 0.0 };
            }
        }
        self.taken += samples.len() as u64;
    }

    /// The means; nothing where no texel shows anything.
    fn mean(mut self) -> Option<Maps> {
        if self.taken == 0 {
            return None;
        }
        let rows = self.values.par_chunks_mut(self.stride).zip(&self.counts);
        rows.for_each(|(texel, &count)| {
            for value in texel {
                *value /= count.max(1) as f32;
            }
        });
        let is_shown: Vec<bool> = self.counts.iter().map(|&count| count > 0).collect();
        for (texel, source) in nearest(&is_shown, self.size) {
            let source = source as usize * self.stride;
            let texel = texel as usize * self.stride;
            self.values.copy_within(source..source + self.stride, texel);
        }
        Some(Maps {
            size: self.size,
            stride: self.stride,
            overlap: (self.twice as f64 / (self.taken as f64 + self.twice as f64)) as f32,
            missed: 0.0,
            non_finite: self.non_finite,
            is_shown,
            values: self.values,
        })
    }
}

/// What is to be said of so many results of textures that are not finite; nothing where there are none.
pub fn non_finite_warning(results: u64) -> Option<String> {
    (results > 0).then(|| {
        format!(
            "textures give values that are not finite (NaN or infinite); {results} of them count as 0; look for a division by \
             zero, or the root or logarithm of a negative number"
        )
    })
}

/// The number of a component of an output among those of a place.
fn component(painted: &Appearance, output: Output, component: usize) -> f32 {
    painted[output.number() as usize][component]
}
