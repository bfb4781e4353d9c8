//! The kernels of a renderer, compiled and bound.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::panic::resume_unwind;
use std::thread;

use device::{BoundKernel, Buffer, Device, DeviceError, Kernel, KernelCost, Resources, Usage};
use rayon::prelude::*;

use crate::{
    film::{Layers, layers::Sum},
    gpu_scene::SceneFeatures,
    passes::{brdf, film_layers, pass::Pass, proctex, wgsl},
    procedural::Procedural,
    schedule::Schedule,
};

use super::{RenderError, culprit};

/// Compilers recurse along a texture's expressions.
const STACK_BYTES: usize = 8 << 20;

/// The kernel of each pass that the scene needs, by the pass's name.
#[derive(Debug)]
pub(super) struct Kernels {
    by_name: BTreeMap<&'static str, Kernel>,
    passes: &'static [&'static Pass],
    /// The pass that the users' functions are in.
    texture: &'static str,
    /// What those that add to the planes of the film's layers are to do, one after the other.
    sums: Vec<(Sum, Buffer)>,
}

impl Kernels {
    pub(super) fn new(
        device: &Device,
        features: &SceneFeatures,
        layers: &Layers,
        procedural: &Procedural,
        schedule: &dyn Schedule,
    ) -> Result<Self, RenderError> {
        let mut kernels = Self {
            by_name: BTreeMap::new(),
            passes: schedule.passes(),
            texture: schedule.texture_pass().name,
            sums: Vec::new(),
        };
        // Of all that is compiled at once, this is what may take long.
        let _busy = (!procedural.is_empty()).then(|| {
            let activity = device.activity();
            activity.begin(|| compiling(procedural))
        });
        let sums = layers.sums().into_iter().map(|sum| {
            let words = film_layers::sum_words(&sum);
            let bytes = bytemuck::cast_slice(&words);
            let buffer = device.filled_buffer("a layer's sum", Usage::Uniform, bytes)?;
            Ok((sum, buffer))
        });
        kernels.sums = sums.collect::<Result<_, DeviceError>>()?;
        // Only the former compiles what users wrote; the passes have threads of their own.
        let both = with_large_stack(
            || texture_kernel(device, features, procedural, schedule),
            || kernels.missing(device, features),
        );
        let (texture, passes) = both.map_err(|error| DeviceError::Kernel {
            label: kernels.texture.to_owned(),
            message: format!(
                "cannot start a thread: {error}; end other programs, or raise what is limited (`ulimit -u`, or `-v`, their memory)"
            ),
        })?;
        kernels.by_name.extend(passes?);
        if let Some(kernel) = texture? {
            kernels.by_name.insert(kernels.texture, kernel);
        }
        Ok(kernels)
    }

    /// Compiles the passes that scenes with these features need and that aren't there, all but the generated one and those
    /// that add to layers of which there are none.
    fn missing(
        &self,
        device: &Device,
        features: &SceneFeatures,
    ) -> Result<Vec<(&'static str, Kernel)>, DeviceError> {
        let adding = [
            &film_layers::MEAN,
            &film_layers::MEANS,
            &film_layers::FIRST,
            &film_layers::IDS,
        ];
        let used: Vec<_> = self
            .sums
            .iter()
            .map(|(sum, _)| film_layers::pass_of(sum).name)
            .collect();
        let adding = adding.iter().map(|pass| pass.name);
        let mut apart: Vec<_> = adding.filter(|name| !used.contains(name)).collect();
        apart.push(self.texture);
        let is_missing = |pass: &&Pass| {
            let is_there = self.by_name.contains_key(pass.name) || apart.contains(&pass.name);
            (pass.exists)(features) && !is_there
        };
        let compile = |pass: &Pass| Ok((pass.name, pass.kernel(device, features)?));
        let passes = self.passes.par_iter().copied();
        passes.filter(is_missing).map(compile).collect()
    }

    /// Replaces the one generated kernel, or makes the texture kernels if a program is there for the first time.
    pub(super) fn rebuild_texture(
        &mut self,
        device: &Device,
        features: &SceneFeatures,
        procedural: &Procedural,
        schedule: &dyn Schedule,
    ) -> Result<(), RenderError> {
        match texture_kernel(device, features, procedural, schedule)? {
            Some(kernel) => self.set_texture(device, features, kernel),
            None => Ok(()),
        }
    }

    /// Takes a generated kernel that has been built elsewhere, in place of the one that is there, if one is.
    pub(super) fn set_texture(
        &mut self,
        device: &Device,
        features: &SceneFeatures,
        kernel: Kernel,
    ) -> Result<(), RenderError> {
        if !self.has_texture() {
            // They were compiled without programs.
            let former = self.by_name.clone();
            for pass in [brdf::PASS, film_layers::RECORD, film_layers::LIGHT] {
                self.by_name.remove(pass.name);
            }
            match self.missing(device, features) {
                Ok(passes) => self.by_name.extend(passes),
                Err(error) => {
                    self.by_name = former;
                    return Err(error.into());
                }
            }
        }
        self.by_name.insert(self.texture, kernel);
        Ok(())
    }

    /// What it took to compile the generated kernel, if there is one.
    pub(super) fn texture_cost(&self) -> Option<KernelCost> {
        self.by_name.get(self.texture).map(Kernel::cost)
    }

    pub(super) fn has_texture(&self) -> bool {
        self.by_name.contains_key(self.texture)
    }

    pub(super) fn bind(&self, device: &Device, resources: &Resources) -> Bound {
        let mut by_name = BTreeMap::<&'static str, Vec<BoundKernel>>::new();
        let names: Vec<_> = self
            .sums
            .iter()
            .map(|(sum, _)| film_layers::pass_of(sum).name)
            .collect();
        for (name, kernel) in &self.by_name {
            if !names.contains(name) {
                by_name.insert(name, vec![kernel.bind(device, resources)]);
            }
        }
        for (sum, words) in &self.sums {
            let name = film_layers::pass_of(sum).name;
            let Some(kernel) = self.by_name.get(name) else {
                continue; // each has been compiled
            };
            let mut resources = resources.clone();
            resources.set_buffer("layer_sum", words.clone());
            for (name, plane) in film_layers::PLANES.into_iter().zip(&sum.planes) {
                let buffer = resources.buffer(plane).clone();
                resources.set_buffer(name, buffer);
            }
            let bound = kernel.bind(device, &resources);
            by_name.entry(name).or_default().push(bound);
        }
        Bound {
            by_name,
            passes: self.passes,
        }
    }
}

/// Does two things at once, the first one on a thread whose stack is large. Where a system has no threads, it is done here.
///
/// # Errors
/// The system has no room for a thread.
fn with_large_stack<A: Send, B>(
    first: impl Fn() -> A + Copy + Send,
    second: impl FnOnce() -> B,
) -> io::Result<(A, B)> {
    thread::scope(|scope| {
        let named = thread::Builder::new()
            .name("texture kernel".to_owned())
            .stack_size(STACK_BYTES);
        match named.spawn_scoped(scope, first) {
            Ok(begun) => {
                let second = second();
                let first = begun.join().unwrap_or_else(|panic| resume_unwind(panic));
                Ok((first, second))
            }
            Err(error) if error.kind() == ErrorKind::Unsupported => Ok((first(), second())),
            Err(error) => Err(error),
        }
    })
}

/// Builds the generated kernel, if it is needed. Where the driver refuses it, the textures that it refuses alone are named.
pub(super) fn texture_kernel(
    device: &Device,
    features: &SceneFeatures,
    procedural: &Procedural,
    schedule: &dyn Schedule,
) -> Result<Option<Kernel>, RenderError> {
    let Some(text) = schedule.texture_kernel(features, procedural)? else {
        return Ok(None);
    };
    let _busy = (device.activity()).begin(|| compiling(procedural));
    let kernel = wgsl::compile(device, &text.source()).map_err(|error| {
        let library = procedural.graph().library();
        let build =
            |alone: &texgen::Library| proctex::kernel(device, &alone.emit(1), features).map(|_| ());
        culprit::named(error, library, build)
    })?;
    Ok(Some(kernel))
}

/// What is said while the kernel with the textures is compiled.
pub(crate) fn compiling(procedural: &Procedural) -> String {
    const MOST: usize = 4;
    let textures = procedural.graph().library().textures();
    let names: Vec<&str> = textures.iter().map(texgen::TextureType::name).collect();
    let shown = names[..names.len().min(MOST)].join("`, `");
    match names.len() {
        0 => "compiling the texture kernel".to_owned(),
        1 => format!("compiling the texture `{shown}`"),
        n if n <= MOST => format!("compiling the textures `{shown}`"),
        n => format!("compiling the textures `{shown}` and {} more", n - MOST),
    }
}

/// The kernels with their resources.
#[derive(Debug, Default)]
pub(super) struct Bound {
    by_name: BTreeMap<&'static str, Vec<BoundKernel>>,
    passes: &'static [&'static Pass],
}

impl Bound {
    /// The kernels of a pass, to be run one after the other: most have one, those of the film's layers one for each sum, and
    /// a pass that the scene doesn't need none.
    pub(super) fn get(&self, pass: &Pass) -> &[BoundKernel] {
        self.by_name.get(pass.name).map_or(&[], Vec::as_slice)
    }

    /// Names in the order in which a wave runs them.
    pub(super) fn labels(&self) -> impl Iterator<Item = &'static str> {
        let names = self.passes.iter().map(|pass| pass.name);
        names.filter(|name| self.by_name.contains_key(name))
    }
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    /// Takes a kilobyte of stack for each level, and a little more.
    fn recurse(levels: u32) -> u32 {
        let room = [levels; 256];
        black_box(&room);
        match levels {
            0 => 0,
            _ => recurse(levels - 1) + u32::from(room[255] > 0),
        }
    }

    #[test]
    fn what_recurses_has_a_large_stack() {
        // Twice what threads usually have.
        let both = with_large_stack(|| recurse(4000), || 7);
        assert_eq!(both.expect("there is room for a thread"), (4000, 7));
    }
}
