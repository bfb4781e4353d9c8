//! The last check of a texture: a kernel of it alone, as far as a compiler can go without a device. What it accepts never
//! fails later in the kernel of a scene.

use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::{ValidationFlags, Validator};

use crate::attribute::HOST_STUB;
use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::guard::guarded;
use crate::library::Library;
use crate::pointer_arguments::copy_pointer_arguments;
use crate::texture::TextureType;
use crate::verdict::{self, CAPABILITIES};

impl TextureType {
    /// Parses and checks a user texture. The file's name is the texture's name.
    ///
    /// # Errors
    /// Everything that is wrong with the file, each with its place and a remedy.
    pub fn parse(file: SourceFile) -> Result<Self, Diagnostics> {
        let checked = guarded(|| Self::check(file.clone()).and_then(try_out));
        checked.unwrap_or_else(|panic| {
            let start = file.text().find("userProc").unwrap_or(0);
            let error = Diagnostic::error(format!("the compiler ended unexpectedly: {panic}"))
                .with_label(&file, start..start, "somewhere in this texture")
                .with_note("this is a fault of Patina or of its parts: please report it together with the file");
            Err(error.into())
        })
    }
}

/// Emits a kernel of this texture alone, has naga check it, and writes it as drivers get it.
///
/// # Errors
/// Any that there are: they are faults of this crate or of naga, not of the texture.
fn try_out(texture: TextureType) -> Result<TextureType, Diagnostics> {
    let file = texture.file().clone();
    let library = Library::new(vec![texture]).map_err(Diagnostics::from)?;
    let kernel = library.emit(1);
    let mut diagnostic = match verdict::check(&format!("{}\n{HOST_STUB}", kernel.wgsl)) {
        Ok(module) => match spirv(module) {
            Ok(()) => return Ok(library.into_only()),
            Err(message) => Diagnostic::error(message),
        },
        Err(problem) => {
            let span = problem.labels.first();
            let span = span.map_or(0..0, |(span, _)| span.clone());
            kernel.source_map.diagnostic(span, &problem.message)
        }
    };
    if diagnostic.labels.is_empty() {
        let text = file.text();
        let start = text.find("userProc").unwrap_or(0);
        let end = text[start..]
            .find('(')
            .map_or(start, |length| start + length);
        diagnostic = diagnostic.with_label(&file, start..end, "");
    }
    Err(diagnostic
        .with_note("the texture is valid, but not as a part of the kernel: please report this together with the file")
        .into())
}

/// Writes a kernel for drivers, with the checks that users' code is given.
fn spirv(mut module: naga::Module) -> Result<(), String> {
    copy_pointer_arguments(&mut module);
    let info = Validator::new(ValidationFlags::all(), CAPABILITIES)
        .validate(&module)
        .map_err(|error| error.as_inner().to_string())?;
    let options = spv::Options {
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            ..BoundsCheckPolicies::default()
        },
        force_loop_bounding: true,
        ..spv::Options::default()
    };
    match spv::write_vec(&module, &info, &options, None) {
        Ok(_) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}
