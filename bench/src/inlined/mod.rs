//! Textures pasted into their kernel, constants and links with them, and ambient occlusion traced in a loop inside it: as
//! renderers do whose materials are code. All other passes are the usual ones. Any edit builds the kernel again.
//!
//! It needs a device with ten storage buffers per stage.

use std::borrow::Cow;
use std::sync::Arc;

use device::KernelText;
use engine::{
    gpu_scene::SceneFeatures,
    passes::{proctex, wgsl::ComposedWgsl},
    procedural::{CompileError, Procedural},
    schedule::Schedule,
};
use texgen::GeneratedKernel;

use crate::wgsl;

/// The usual passes, but for the one with the textures.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inlined;

/// The texture kernel's text with texgen's inlined form in it.
pub fn text(generated: &GeneratedKernel) -> ComposedWgsl {
    let mut text = wgsl::compose("inlined/inlined.wgsl");
    text.append_generated(generated);
    text
}

impl Schedule for Inlined {
    fn texture_kernel(
        &self,
        features: &SceneFeatures,
        procedural: &Procedural,
    ) -> Result<Option<KernelText>, CompileError> {
        if procedural.is_empty() {
            return Ok(None);
        }
        Ok(Some(KernelText {
            text: Arc::new(text(&procedural.inlined()?.kernel)),
            entry: proctex::PASS.name,
            trust: proctex::TRUST,
            constants: features.constants().to_vec(),
        }))
    }

    fn program_words<'a>(
        &self,
        procedural: &'a Procedural,
    ) -> Result<Cow<'a, [u32]>, CompileError> {
        Ok(Cow::Owned(procedural.inlined()?.heads))
    }

    fn edits_are_code(&self) -> bool {
        true
    }
}
