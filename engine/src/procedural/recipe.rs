//! What a material is made of, for those who run its programs elsewhere: the programs, and where in their results lies what.

use glam::Vec3;
use texgen::{Program, link_word};

use super::wiring::{CompileError, Mask};
use super::{Output, Procedural};

/// What a material is made of.
#[derive(Debug, Clone)]
pub(crate) enum Recipe {
    /// Two others.
    Blend {
        /// Index of the one below.
        base: u32,
        /// Index of the one above.
        over: u32,
        /// Share of the latter.
        mask: MaskRecipe,
    },
    /// A surface with some outputs driven.
    Surface(Box<SurfaceRecipe>),
}

/// Share of a blend's upper side.
#[derive(Debug, Clone)]
pub(crate) enum MaskRecipe {
    /// The same everywhere.
    Constant(f32),
    /// First component of a program's result: the link.
    Driven(Program, u32),
}

/// What drives a surface.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceRecipe {
    /// What is driven, but for the height, and the link of each.
    pub(crate) outputs: Vec<(Output, u32)>,
    /// Gives them, where there are any.
    pub(crate) program: Option<Program>,
    /// Gives the height at a link.
    pub(crate) bump: Option<(Program, u32)>,
    /// Metres per unit of the height.
    pub(crate) bump_scale: f32,
    /// The emission, or the factor on a driven one.
    pub(crate) emission: Vec3,
}

impl Procedural {
    /// What a material is made of.
    ///
    /// # Errors
    /// A program can't be compiled; those of a graph that renders can be.
    pub(crate) fn recipe(&self, material: u32) -> Result<Recipe, CompileError> {
        let wiring = &self.wiring[material as usize];
        let roots = wiring.roots();
        if let Some(blend) = &wiring.blend {
            let mask = match blend.mask {
                Mask::Constant(value) => MaskRecipe::Constant(value),
                Mask::Driven(source) => {
                    let program = self.graph.compile_links(&[source.root()])?;
                    let link = link_word(program.results[0], source.swizzle);
                    MaskRecipe::Driven(program, link)
                }
            };
            return Ok(Recipe::Blend {
                base: blend.base,
                over: blend.over,
                mask,
            });
        }
        let program = match roots.is_empty() {
            true => None,
            false => Some(self.graph.compile_links(&roots)?),
        };
        let mut outputs = Vec::new();
        for output in Output::ALL {
            let (Some(source), Some(program)) = (wiring.output(output), &program) else {
                continue;
            };
            if let Some(root) = roots.iter().position(|&root| root == source.root())
                && output != Output::BUMP
            {
                outputs.push((output, link_word(program.results[root], source.swizzle)));
            }
        }
        let bump = match wiring.output(Output::BUMP) {
            None => None,
            Some(source) => {
                let program = self.graph.compile_links(&[source.root()])?;
                let link = link_word(program.results[0], source.swizzle);
                Some((program, link))
            }
        };
        let surface = &wiring.surface;
        Ok(Recipe::Surface(Box::new(SurfaceRecipe {
            outputs,
            program,
            bump,
            bump_scale: surface.bump_scale,
            emission: surface.emission,
        })))
    }

    /// A material and all that is below its blends, what lies below first.
    pub(crate) fn below(&self, material: u32) -> Vec<u32> {
        let mut is_below = vec![false; self.wiring.len()];
        if let Some(first) = is_below.get_mut(material as usize) {
            *first = true;
        }
        // What lies below a blend comes before it.
        for &index in self.order.iter().rev() {
            if let (true, Some(blend)) =
                (is_below[index as usize], &self.wiring[index as usize].blend)
            {
                is_below[blend.base as usize] = true;
                is_below[blend.over as usize] = true;
            }
        }
        let order = self.order.iter().copied();
        order.filter(|&index| is_below[index as usize]).collect()
    }

    /// Names of all materials with their indices, as the look calls them.
    pub fn materials(&self) -> impl Iterator<Item = (&str, u32)> {
        (self.material_names.iter()).map(|(name, &index)| (name.as_str(), index))
    }
}
