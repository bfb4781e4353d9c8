//! The kernels of a renderer, compiled and bound.

use std::borrow::Cow;
use std::collections::BTreeMap;

use device::{BoundKernel, Device, DeviceError, Kernel, Resources};
use texgen::GeneratedKernel;

use crate::{
    film::{Layers, layers::Plane},
    gpu_scene::SceneFeatures,
    passes::{
        brdf, film_layers,
        pass::Pass,
        proctex::{self, TextureForm},
    },
    procedural::{CompileError, Procedural},
    schedule,
};

use super::{RenderError, culprit};

/// The kernel of each pass that the scene needs, by the pass's name.
#[derive(Debug)]
pub(super) struct Kernels {
    layers: Layers,
    by_name: BTreeMap<&'static str, Kernel>,
    /// Those that add to the planes of the film's layers.
    planes: Vec<(Plane, Kernel)>,
}

impl Kernels {
    pub(super) fn new(
        gpu: &Device,
        features: &SceneFeatures,
        layers: &Layers,
        procedural: &Procedural,
        form: TextureForm,
    ) -> Result<Self, RenderError> {
        let planes = layers.planes().into_iter().map(|plane| {
            let kernel = film_layers::plane_kernel(gpu, &plane)?;
            Ok((plane, kernel))
        });
        let mut kernels = Self {
            layers: layers.clone(),
            by_name: BTreeMap::new(),
            planes: planes.collect::<Result<_, DeviceError>>()?,
        };
        kernels.compile_missing(gpu, features)?;
        if !procedural.is_empty() {
            let proctex = texture_kernel(gpu, features, procedural, form)?;
            kernels.by_name.insert(proctex::PASS.name, proctex);
        }
        Ok(kernels)
    }

    /// Compiles the passes that scenes with these features need and that aren't there, all but the generated one and those
    /// of the film's planes.
    fn compile_missing(
        &mut self,
        gpu: &Device,
        features: &SceneFeatures,
    ) -> Result<(), DeviceError> {
        let apart = [proctex::PASS, film_layers::MEAN, film_layers::FIRST].map(|pass| pass.name);
        let layers = film_layers::constants(&self.layers);
        for pass in schedule::WAVE {
            let is_there = self.by_name.contains_key(pass.name) || apart.contains(&pass.name);
            if (pass.exists)(features) && !is_there {
                let kernel = pass.kernel_with(gpu, features, &layers)?;
                self.by_name.insert(pass.name, kernel);
            }
        }
        Ok(())
    }

    /// Replaces the one generated kernel, or makes the texture kernels if a program is there for the first time.
    pub(super) fn rebuild_texture(
        &mut self,
        gpu: &Device,
        features: &SceneFeatures,
        procedural: &Procedural,
        form: TextureForm,
    ) -> Result<(), RenderError> {
        let proctex = texture_kernel(gpu, features, procedural, form)?;
        self.set_texture(gpu, features, proctex)
    }

    /// Takes a generated kernel that has been built elsewhere, in place of the one that is there, if one is.
    pub(super) fn set_texture(
        &mut self,
        gpu: &Device,
        features: &SceneFeatures,
        proctex: Kernel,
    ) -> Result<(), RenderError> {
        if !self.has_texture() {
            // They were compiled without programs.
            let former = self.by_name.clone();
            for pass in [brdf::PASS, film_layers::RECORD] {
                self.by_name.remove(pass.name);
            }
            if let Err(error) = self.compile_missing(gpu, features) {
                self.by_name = former;
                return Err(error.into());
            }
        }
        self.by_name.insert(proctex::PASS.name, proctex);
        Ok(())
    }

    pub(super) fn has_texture(&self) -> bool {
        self.by_name.contains_key(proctex::PASS.name)
    }

    pub(super) fn bind(&self, gpu: &Device, resources: &Resources) -> Bound {
        let mut by_name = BTreeMap::<&'static str, Vec<BoundKernel>>::new();
        for (name, kernel) in &self.by_name {
            by_name.insert(name, vec![kernel.bind(gpu, resources)]);
        }
        for (plane, kernel) in &self.planes {
            let mut resources = resources.clone();
            let buffer = resources.buffer(plane.name).clone();
            resources.set_buffer(film_layers::PLANE, buffer);
            let name = film_layers::pass_of(plane).name;
            let bound = kernel.bind(gpu, &resources);
            by_name.entry(name).or_default().push(bound);
        }
        Bound { by_name }
    }
}

/// Builds the generated kernel. Where the driver refuses it, the textures that it refuses alone are named.
pub(super) fn texture_kernel(
    gpu: &Device,
    features: &SceneFeatures,
    procedural: &Procedural,
    form: TextureForm,
) -> Result<Kernel, RenderError> {
    let generated = generated_kernel(gpu, procedural, form)?;
    let _busy = (gpu.activity()).begin(|| compiling(procedural));
    proctex::kernel(gpu, form, &generated, features).map_err(|error| {
        let library = procedural.graph().library();
        let build = |alone: &texgen::Library| {
            proctex::kernel(gpu, TextureForm::Stack, &alone.emit(1), features).map(|_| ())
        };
        culprit::named(error, library, build).into()
    })
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

/// The generated part of the kernel.
pub(super) fn generated_kernel(
    gpu: &Device,
    procedural: &Procedural,
    form: TextureForm,
) -> Result<GeneratedKernel, CompileError> {
    match form {
        TextureForm::Stack if gpu.traits().runs_all_cases => procedural.kernel_in_rounds(),
        TextureForm::Stack => Ok(procedural.kernel()),
        TextureForm::Inlined => Ok(procedural.inlined()?.kernel),
    }
}

/// The words that the kernel reads its heads, and its programs if it has any, from.
pub(super) fn program_words(
    procedural: &Procedural,
    form: TextureForm,
) -> Result<Cow<'_, [u32]>, RenderError> {
    Ok(match form {
        TextureForm::Stack => Cow::Borrowed(procedural.programs()),
        TextureForm::Inlined => Cow::Owned(procedural.inlined()?.heads),
    })
}

/// The kernels with their resources.
#[derive(Debug)]
pub(super) struct Bound {
    by_name: BTreeMap<&'static str, Vec<BoundKernel>>,
}

impl Bound {
    /// The kernels of a pass, to be run one after the other: most have one, those of the film's layers one for each plane, and
    /// a pass that the scene doesn't need none.
    pub(super) fn get(&self, pass: &Pass) -> &[BoundKernel] {
        self.by_name.get(pass.name).map_or(&[], Vec::as_slice)
    }

    /// Names in the order in which a wave runs them.
    pub(super) fn labels(&self) -> impl Iterator<Item = &'static str> {
        let names = schedule::WAVE.iter().map(|pass| pass.name);
        names.filter(|name| self.by_name.contains_key(name))
    }
}
