//! The kernels of a renderer, compiled and bound.

use std::borrow::Cow;

use texgen::GeneratedKernel;

use super::culprit;
use crate::{
    gpu::{
        Gpu,
        kernel::{BoundKernel, Kernel, Resources},
    },
    gpu_scene::SceneFeatures,
    passes::{
        accumulate, advance, advance::After, ao, brdf, classify, proctex, proctex::TextureForm,
        raygen, traverse, traverse::Rays,
    },
    procedural::{CompileError, Procedural},
};

use super::RenderError;

/// All kernels. Those of textures exist only where a material has a program.
#[derive(Debug)]
pub(super) struct Kernels {
    raygen: Kernel,
    advance: [Kernel; 3],
    traverse: [Kernel; 2],
    brdf: Kernel,
    accumulate: Kernel,
    texture: Option<TextureKernels>,
}

#[derive(Debug)]
struct TextureKernels {
    classify: Kernel,
    ao: Kernel,
    proctex: Kernel,
}

impl Kernels {
    pub(super) fn new(
        gpu: &Gpu,
        features: &SceneFeatures,
        procedural: &Procedural,
        form: TextureForm,
    ) -> Result<Self, RenderError> {
        Ok(Self {
            raygen: raygen::kernel(gpu)?,
            advance: [
                advance::kernel(gpu, After::Raygen)?,
                advance::kernel(gpu, After::Classify)?,
                advance::kernel(gpu, After::Brdf)?,
            ],
            traverse: [
                traverse::kernel(gpu, Rays::Closest, features)?,
                traverse::kernel(gpu, Rays::Occlusion, features)?,
            ],
            brdf: brdf::kernel(gpu, features)?,
            accumulate: accumulate::kernel(gpu, features)?,
            texture: if procedural.is_empty() {
                None
            } else {
                Some(TextureKernels {
                    classify: classify::kernel(gpu, features)?,
                    ao: ao::kernel(gpu, features)?,
                    proctex: texture_kernel(gpu, features, procedural, form)?,
                })
            },
        })
    }

    /// Replaces the one generated kernel, or makes the texture kernels if a program is there for the first time.
    pub(super) fn rebuild_texture(
        &mut self,
        gpu: &Gpu,
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
        gpu: &Gpu,
        features: &SceneFeatures,
        proctex: Kernel,
    ) -> Result<(), RenderError> {
        match &mut self.texture {
            Some(texture) => texture.proctex = proctex,
            None => {
                self.brdf = brdf::kernel(gpu, features)?;
                self.texture = Some(TextureKernels {
                    classify: classify::kernel(gpu, features)?,
                    ao: ao::kernel(gpu, features)?,
                    proctex,
                });
            }
        }
        Ok(())
    }

    /// Bytes of private memory that a thread of the generated kernel asks for.
    pub(super) fn texture_private_bytes(&self) -> Option<u32> {
        let texture = self.texture.as_ref()?;
        Some(texture.proctex.private_bytes())
    }

    pub(super) fn has_texture(&self) -> bool {
        self.texture.is_some()
    }

    pub(super) fn bind(&self, gpu: &Gpu, resources: &Resources) -> Bound {
        let bind = |kernel: &Kernel| kernel.bind(gpu, resources);
        Bound {
            raygen: bind(&self.raygen),
            advance: self.advance.each_ref().map(bind),
            traverse: self.traverse.each_ref().map(bind),
            brdf: bind(&self.brdf),
            accumulate: bind(&self.accumulate),
            texture: self.texture.as_ref().map(|t| BoundTexture {
                classify: bind(&t.classify),
                ao: bind(&t.ao),
                proctex: bind(&t.proctex),
            }),
        }
    }
}

/// Builds the generated kernel. Where the driver refuses it, the textures that it refuses alone are named.
pub(super) fn texture_kernel(
    gpu: &Gpu,
    features: &SceneFeatures,
    procedural: &Procedural,
    form: TextureForm,
) -> Result<Kernel, RenderError> {
    let generated = generated_kernel(gpu, procedural, form)?;
    proctex::kernel(gpu, form, &generated, features).map_err(|error| {
        let library = procedural.graph().library();
        let build = |alone: &texgen::Library| {
            proctex::kernel(gpu, TextureForm::Stack, &alone.emit(1), features).map(|_| ())
        };
        culprit::named(error, library, build).into()
    })
}

/// The generated part of the kernel.
pub(super) fn generated_kernel(
    gpu: &Gpu,
    procedural: &Procedural,
    form: TextureForm,
) -> Result<GeneratedKernel, CompileError> {
    match form {
        TextureForm::Stack if gpu.is_cpu() => procedural.kernel_in_rounds(),
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
    pub(super) raygen: BoundKernel,
    /// Indexed by [`After`].
    pub(super) advance: [BoundKernel; 3],
    /// Indexed by [`Rays`].
    pub(super) traverse: [BoundKernel; 2],
    pub(super) brdf: BoundKernel,
    pub(super) accumulate: BoundKernel,
    pub(super) texture: Option<BoundTexture>,
}

#[derive(Debug)]
pub(super) struct BoundTexture {
    pub(super) classify: BoundKernel,
    pub(super) ao: BoundKernel,
    pub(super) proctex: BoundKernel,
}

impl Bound {
    /// Labels in the order in which a wave runs them.
    pub(super) fn labels(&self) -> impl Iterator<Item = &str> {
        let texture = self
            .texture
            .iter()
            .flat_map(|t| [&t.classify, &t.ao, &t.proctex]);
        let [after_raygen, after_classify, after_brdf] = &self.advance;
        let [closest, occlusion] = &self.traverse;
        [&self.raygen, after_raygen, closest]
            .into_iter()
            .chain(texture)
            .chain([
                after_classify,
                &self.brdf,
                after_brdf,
                occlusion,
                &self.accumulate,
            ])
            .map(BoundKernel::label)
    }
}
