//! `userProc` as naga sees it: the types of its parameters and of its result.

use naga::{
    ArraySize, Handle, Module, Scalar, ScalarKind, StructMember, Type, TypeInner, VectorSize,
};

use crate::args::words_of;
use crate::diagnostic::{Diagnostic, Diagnostics, SourceFile};
use crate::interface::{NamedOutput, Parameter, Widget};
use crate::scope::Outline;
use crate::suggest::did_you_mean;
use crate::swizzle::fault_of_output;
use crate::value::{ElementType, OutputType, ParameterType};

/// Most elements of an array parameter.
const MAX_ARRAY: u32 = 65_536;

/// Most words of all parameters together, 4 MiB. A node's arguments lie in memory several times, here and on the device.
const MAX_WORDS: u64 = 1 << 20;

const OUTPUTS_NOTE: &str = "each member of the struct is an output that links take by its name, the first one where they name none";

const TYPES_NOTE: &str = "parameters are f32, i32, u32, bool, vec2f, vec3f, vec4f, mat3x3f, mat4x4f, sam2D, ramp1D, or array<T, N> of the plain ones";

/// Keys of a node's table in a look that aren't parameters of its texture.
const NODE_KEYS: [&str; 3] = ["texture", "occlusion", "occlusion1"];

/// What `userProc` takes and gives.
pub(crate) struct Signature {
    pub(crate) parameters: Vec<Parameter>,
    /// What it returns, or the first member of it.
    pub(crate) output: OutputType,
    /// The members of a struct that it returns.
    pub(crate) outputs: Vec<NamedOutput>,
}

/// Most members of a struct that is returned.
const MAX_OUTPUTS: usize = 8;

/// Parameters and result of `userProc`; labels and defaults are still the plain ones.
pub(crate) fn read(
    file: &SourceFile,
    outline: &Outline<'_>,
    module: &Module,
) -> Result<Signature, Diagnostics> {
    let (Some(entry), Some((_, function))) = (
        outline.function("userProc"),
        module
            .functions
            .iter()
            .find(|(_, function)| function.name.as_deref() == Some("userProc")),
    ) else {
        return Err(missing_entry(file, outline).into());
    };
    let mut problems = Diagnostics::new();
    let mut parameters = Vec::new();
    let mut words = 0u64;
    for (argument, decl) in function.arguments.iter().zip(&entry.params) {
        let name = outline.word(decl.name).to_owned();
        let ty = parameter_type(module, argument.ty);
        words += ty.as_ref().map_or(0, |&ty| u64::from(words_of(ty)));
        if words > MAX_WORDS {
            let bytes = 4 * MAX_WORDS;
            problems.push(
                Diagnostic::error(format!(
                    "the parameters up to `{name}` hold more than {bytes} bytes: at most these are possible"
                ))
                .with_label(file, outline.span_of(&decl.ty), "")
                .with_note("put large tables into images"),
            );
            break;
        }
        match ty {
            Ok(ty) => parameters.push(Parameter {
                label: name.replace('_', " "),
                name,
                ty,
                default: ty.zero(),
                range: None,
                soft_range: None,
                unit: None,
                widget: Widget::Plain,
                is_data: false,
                attribute: None,
            }),
            Err(problem) => problems.push(
                Diagnostic::error(format!("parameter `{name}` {problem}"))
                    .with_label(file, outline.span_of(&decl.ty), "")
                    .with_note(TYPES_NOTE),
            ),
        }
    }
    let place = match entry.result.is_empty() {
        true => outline.span(entry.name),
        false => outline.span_of(&entry.result),
    };
    let mut outputs = Vec::new();
    let result = function.result.as_ref();
    let output = match result.map(|result| &module.types[result.ty].inner) {
        Some(TypeInner::Struct { members, .. }) => {
            match named_outputs(module, members) {
                Ok(named) => outputs = named,
                Err(problem) => {
                    let error = Diagnostic::error(problem).with_label(file, place, "");
                    problems.push(error.with_note(OUTPUTS_NOTE));
                    return Err(problems);
                }
            }
            outputs.first().map(|output| output.ty)
        }
        _ => result.and_then(|result| output_type(module, result.ty)),
    };
    if output.is_none() {
        problems.push(
            Diagnostic::error("`userProc` returns f32, vec2f, vec3f, vec4f or a struct of those")
                .with_label(
                    file,
                    place,
                    if entry.result.is_empty() {
                        "returns nothing"
                    } else {
                        ""
                    },
                )
                .with_note("write for example `fn userProc(...) -> vec4f`"),
        );
    }
    match output {
        Some(output) if problems.is_empty() => Ok(Signature {
            parameters,
            output,
            outputs,
        }),
        _ => Err(problems),
    }
}

/// Warns of parameters that no look can set: in a node's table their names mean something else.
pub(crate) fn warn_of_keys(file: &SourceFile, outline: &Outline<'_>, problems: &mut Diagnostics) {
    let Some(entry) = outline.function("userProc") else {
        return;
    };
    for parameter in &entry.params {
        let name = outline.word(parameter.name);
        if NODE_KEYS.contains(&name) {
            problems.push(
                Diagnostic::warning(format!("a look can't set a parameter called `{name}`"))
                    .with_label(
                        file,
                        outline.span(parameter.name),
                        "the key of a node means something else",
                    )
                    .with_note(format!("rename it, for example `my_{name}`")),
            );
        }
    }
}

/// The members of a struct as outputs; else what is wrong with one.
fn named_outputs(module: &Module, members: &[StructMember]) -> Result<Vec<NamedOutput>, String> {
    if members.len() > MAX_OUTPUTS {
        let count = members.len();
        return Err(format!(
            "`userProc` returns {count} values: at most {MAX_OUTPUTS} are possible"
        ));
    }
    let output = |member: &StructMember| {
        let name = member.name.clone().unwrap_or_default();
        let Some(ty) = output_type(module, member.ty) else {
            return Err(format!(
                "the output `{name}` is none of f32, vec2f, vec3f and vec4f"
            ));
        };
        if let Some(fault) = fault_of_output(&name) {
            return Err(format!("an output can't be called `{name}`: {fault}"));
        }
        Ok(NamedOutput {
            name,
            ty,
            label: String::new(),
        })
    };
    members.iter().map(output).collect()
}

fn missing_entry(file: &SourceFile, outline: &Outline<'_>) -> Diagnostic {
    let error = Diagnostic::error("the texture has no function `userProc`").with_note(
        "the value of the texture at a hit is what `fn userProc(...) -> vec4f { ... }` returns",
    );
    let near = did_you_mean(
        "userProc",
        outline
            .functions
            .iter()
            .map(|function| outline.word(function.name)),
    );
    match near.and_then(|near| outline.function(near)) {
        Some(function) => error.with_label(file, outline.span(function.name), "was this meant?"),
        None => error.with_label(file, 0..0, ""),
    }
}

fn parameter_type(module: &Module, handle: Handle<Type>) -> Result<ParameterType, String> {
    let ty = &module.types[handle];
    if let TypeInner::Array { base, size, .. } = ty.inner {
        let element = element_type(&module.types[base].inner)
            .ok_or("is an array of something that can't come from outside")?;
        return match size {
            ArraySize::Constant(count) if count.get() <= MAX_ARRAY => {
                Ok(ParameterType::Array(element, count.get()))
            }
            ArraySize::Constant(count) => Err(format!(
                "has {} elements: at most {MAX_ARRAY} are possible; use an image",
                count.get()
            )),
            _ => Err("is an array without a fixed size".into()),
        };
    }
    if let TypeInner::Struct { .. } = ty.inner {
        // The prelude's structs can't be declared again, so the name says which one it is.
        return match ty.name.as_deref() {
            Some("sam2D") => Ok(ParameterType::Image),
            Some("ramp1D") => Ok(ParameterType::Ramp),
            _ => Err(
                "is a struct, which can't come from outside: take its members as parameters".into(),
            ),
        };
    }
    element_type(&ty.inner)
        .map(ElementType::parameter_type)
        .ok_or("is of a type that can't come from outside".into())
}

fn element_type(inner: &TypeInner) -> Option<ElementType> {
    Some(match *inner {
        TypeInner::Scalar(Scalar { kind, width: 4 }) => match kind {
            ScalarKind::Float => ElementType::F32,
            ScalarKind::Sint => ElementType::I32,
            ScalarKind::Uint => ElementType::U32,
            _ => return None,
        },
        TypeInner::Scalar(Scalar {
            kind: ScalarKind::Bool,
            ..
        }) => ElementType::Bool,
        TypeInner::Vector {
            size,
            scalar: Scalar::F32,
        } => match size {
            VectorSize::Bi => ElementType::Vec2,
            VectorSize::Tri => ElementType::Vec3,
            VectorSize::Quad => ElementType::Vec4,
        },
        TypeInner::Matrix {
            columns: VectorSize::Tri,
            rows: VectorSize::Tri,
            scalar: Scalar::F32,
        } => ElementType::Mat3,
        TypeInner::Matrix {
            columns: VectorSize::Quad,
            rows: VectorSize::Quad,
            scalar: Scalar::F32,
        } => ElementType::Mat4,
        _ => return None,
    })
}

fn output_type(module: &Module, handle: Handle<Type>) -> Option<OutputType> {
    Some(match element_type(&module.types[handle].inner)? {
        ElementType::F32 => OutputType::F32,
        ElementType::Vec2 => OutputType::Vec2,
        ElementType::Vec3 => OutputType::Vec3,
        ElementType::Vec4 => OutputType::Vec4,
        _ => return None,
    })
}
