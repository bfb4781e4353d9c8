//! The kernels of a renderer, compiled and bound.

use std::borrow::Cow;
use std::collections::BTreeMap;

use device::{BoundKernel, Device, DeviceError, Kernel, Resources};
use texgen::GeneratedKernel;

use crate::{
    gpu_scene::SceneFeatures,
    passes::{
        brdf,
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
    by_name: BTreeMap<&'static str, Kernel>,
}

impl Kernels {
    pub(super) fn new(
        gpu: &Device,
        features: &SceneFeatures,
        procedural: &Procedural,
        form: TextureForm,
    ) -> Result<Self, RenderError> {
        let mut kernels = Self {
            by_name: BTreeMap::new(),
        };
        kernels.compile_missing(gpu, features)?;
        if !procedural.is_empty() {
            let proctex = texture_kernel(gpu, features, procedural, form)?;
            kernels.by_name.insert(proctex::PASS.name, proctex);
        }
        Ok(kernels)
    }

    /// Compiles the passes that scenes with these features need and that aren't there, all but the generated one.
    fn compile_missing(
        &mut self,
        gpu: &Device,
        features: &SceneFeatures,
    ) -> Result<(), DeviceError> {
        for pass in schedule::WAVE {
            let is_generated = pass.name == proctex::PASS.name;
            let is_there = self.by_name.contains_key(pass.name);
            if (pass.exists)(features) && !is_generated && !is_there {
                let kernel = pass.kernel(gpu, features)?;
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
            // It was compiled without programs.
            let brdf = brdf::PASS.kernel(gpu, features)?;
            self.compile_missing(gpu, features)?;
            self.by_name.insert(brdf::PASS.name, brdf);
        }
        self.by_name.insert(proctex::PASS.name, proctex);
        Ok(())
    }

    pub(super) fn has_texture(&self) -> bool {
        self.by_name.contains_key(proctex::PASS.name)
    }

    pub(super) fn bind(&self, gpu: &Device, resources: &Resources) -> Bound {
        let bind = |(name, kernel): (&&'static str, &Kernel)| (*name, kernel.bind(gpu, resources));
        Bound {
            by_name: self.by_name.iter().map(bind).collect(),
        }
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
    by_name: BTreeMap<&'static str, BoundKernel>,
}

impl Bound {
    /// The kernel of a pass, if the scene needs it.
    pub(super) fn get(&self, pass: &Pass) -> Option<&BoundKernel> {
        self.by_name.get(pass.name)
    }

    /// Names in the order in which a wave runs them.
    pub(super) fn labels(&self) -> impl Iterator<Item = &'static str> {
        let names = schedule::WAVE.iter().map(|pass| pass.name);
        names.filter(|name| self.by_name.contains_key(name))
    }
}
