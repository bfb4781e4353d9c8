//! The kernels of a renderer, compiled and bound.

use std::collections::BTreeMap;

use device::{BoundKernel, Device, DeviceError, Kernel, Resources};

use crate::{
    gpu_scene::SceneFeatures,
    passes::{brdf, pass::Pass, proctex, wgsl},
    procedural::Procedural,
    schedule::Schedule,
};

use super::{RenderError, culprit};

/// The kernel of each pass that the scene needs, by the pass's name.
#[derive(Debug)]
pub(super) struct Kernels {
    by_name: BTreeMap<&'static str, Kernel>,
    passes: &'static [&'static Pass],
    /// The pass that the users' functions are in.
    texture: &'static str,
}

impl Kernels {
    pub(super) fn new(
        gpu: &Device,
        features: &SceneFeatures,
        procedural: &Procedural,
        schedule: &dyn Schedule,
    ) -> Result<Self, RenderError> {
        let mut kernels = Self {
            by_name: BTreeMap::new(),
            passes: schedule.passes(),
            texture: schedule.texture_pass().name,
        };
        kernels.compile_missing(gpu, features)?;
        if let Some(kernel) = texture_kernel(gpu, features, procedural, schedule)? {
            kernels.by_name.insert(kernels.texture, kernel);
        }
        Ok(kernels)
    }

    /// Compiles the passes that scenes with these features need and that aren't there, all but the generated one.
    fn compile_missing(
        &mut self,
        gpu: &Device,
        features: &SceneFeatures,
    ) -> Result<(), DeviceError> {
        for pass in self.passes {
            let is_generated = pass.name == self.texture;
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
        schedule: &dyn Schedule,
    ) -> Result<(), RenderError> {
        match texture_kernel(gpu, features, procedural, schedule)? {
            Some(kernel) => self.set_texture(gpu, features, kernel),
            None => Ok(()),
        }
    }

    /// Takes a generated kernel that has been built elsewhere, in place of the one that is there, if one is.
    pub(super) fn set_texture(
        &mut self,
        gpu: &Device,
        features: &SceneFeatures,
        kernel: Kernel,
    ) -> Result<(), RenderError> {
        if !self.has_texture() {
            // It was compiled without programs.
            let brdf = brdf::PASS.kernel(gpu, features)?;
            self.compile_missing(gpu, features)?;
            self.by_name.insert(brdf::PASS.name, brdf);
        }
        self.by_name.insert(self.texture, kernel);
        Ok(())
    }

    pub(super) fn has_texture(&self) -> bool {
        self.by_name.contains_key(self.texture)
    }

    pub(super) fn bind(&self, gpu: &Device, resources: &Resources) -> Bound {
        let bind = |(name, kernel): (&&'static str, &Kernel)| (*name, kernel.bind(gpu, resources));
        Bound {
            by_name: self.by_name.iter().map(bind).collect(),
            passes: self.passes,
        }
    }
}

/// Builds the generated kernel, if it is needed. Where the driver refuses it, the textures that it refuses alone are named.
pub(super) fn texture_kernel(
    gpu: &Device,
    features: &SceneFeatures,
    procedural: &Procedural,
    schedule: &dyn Schedule,
) -> Result<Option<Kernel>, RenderError> {
    let Some(text) = schedule.texture_kernel(gpu, features, procedural)? else {
        return Ok(None);
    };
    let _busy = (gpu.activity()).begin(|| compiling(procedural));
    let kernel = wgsl::compile(gpu, &text.source()).map_err(|error| {
        let library = procedural.graph().library();
        let build =
            |alone: &texgen::Library| proctex::kernel(gpu, &alone.emit(1), features).map(|_| ());
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
#[derive(Debug)]
pub(super) struct Bound {
    by_name: BTreeMap<&'static str, BoundKernel>,
    passes: &'static [&'static Pass],
}

impl Bound {
    /// The kernel of a pass, if the scene needs it.
    pub(super) fn get(&self, pass: &Pass) -> Option<&BoundKernel> {
        self.by_name.get(pass.name)
    }

    /// Names in the order in which a wave runs them.
    pub(super) fn labels(&self) -> impl Iterator<Item = &'static str> {
        let names = self.passes.iter().map(|pass| pass.name);
        names.filter(|name| self.by_name.contains_key(name))
    }
}
