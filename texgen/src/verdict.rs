//! What naga says of a whole text.

use naga::front::wgsl;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::problem::Problem;
use crate::validation;

/// What a texture may use beyond plain WGSL: `pack2x16float`, `unpack2x16float` and `quantizeToF16` compute with `f32`, and
/// all Vulkan, Metal and DirectX 12 devices have them.
pub const CAPABILITIES: Capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32;

/// Parses and validates a whole module.
pub(crate) fn check(text: &str) -> Result<naga::Module, Problem> {
    let module = wgsl::parse_str(text).map_err(|error| Problem {
        message: error.message().to_owned(),
        labels: error
            .labels()
            .filter_map(|(span, label)| Some((span.to_range()?, label.to_owned())))
            .collect(),
        notes: error.notes().map(str::to_owned).collect(),
        function: None,
        conversion: None,
    })?;
    match Validator::new(ValidationFlags::all(), CAPABILITIES).validate(&module) {
        Ok(_) => Ok(module),
        Err(error) => Err(validation::problem(&error, &module, text)),
    }
}
