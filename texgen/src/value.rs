//! The types of parameters and the values they take: plain data, no layout (see `args`), no WGSL.

use std::fmt;

/// The type of a parameter of `userProc`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParameterType {
    /// `f32`
    F32,
    /// `i32`
    I32,
    /// `u32`
    U32,
    /// `bool`
    Bool,
    /// `vec2f`
    Vec2,
    /// `vec3f`
    Vec3,
    /// `vec4f`
    Vec4,
    /// `mat3x3f`
    Mat3,
    /// `mat4x4f`
    Mat4,
    /// `sam2D`
    Image,
    /// `ramp1D`
    Ramp,
    /// `array<T, N>` of one of the types above but `sam2D` and `ramp1D`.
    Array(ElementType, u32),
}

/// What an array parameter may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ElementType {
    /// `f32`
    F32,
    /// `i32`
    I32,
    /// `u32`
    U32,
    /// `bool`
    Bool,
    /// `vec2f`
    Vec2,
    /// `vec3f`
    Vec3,
    /// `vec4f`
    Vec4,
    /// `mat3x3f`
    Mat3,
    /// `mat4x4f`
    Mat4,
}

impl ElementType {
    /// The parameter type of one element.
    pub fn parameter_type(self) -> ParameterType {
        match self {
            ElementType::F32 => ParameterType::F32,
            ElementType::I32 => ParameterType::I32,
            ElementType::U32 => ParameterType::U32,
            ElementType::Bool => ParameterType::Bool,
            ElementType::Vec2 => ParameterType::Vec2,
            ElementType::Vec3 => ParameterType::Vec3,
            ElementType::Vec4 => ParameterType::Vec4,
            ElementType::Mat3 => ParameterType::Mat3,
            ElementType::Mat4 => ParameterType::Mat4,
        }
    }
}

impl ParameterType {
    /// Whether another node's output can drive it: numbers, vectors and `bool` can; images, ramps, matrices
    /// and arrays can't.
    pub fn is_linkable(self) -> bool {
        use ParameterType::*;
        matches!(self, F32 | I32 | U32 | Bool | Vec2 | Vec3 | Vec4)
    }

    /// The value of a parameter that nobody gave a default: zero, `false`, the identity, a ramp from black to
    /// white.
    /// An image has none.
    pub fn zero(self) -> Option<Value> {
        Some(match self {
            ParameterType::F32 => Value::F32(0.0),
            ParameterType::I32 => Value::I32(0),
            ParameterType::U32 => Value::U32(0),
            ParameterType::Bool => Value::Bool(false),
            ParameterType::Vec2 => Value::Vec2([0.0; 2]),
            ParameterType::Vec3 => Value::Vec3([0.0; 3]),
            ParameterType::Vec4 => Value::Vec4([0.0; 4]),
            ParameterType::Mat3 => Value::Mat3([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            ParameterType::Mat4 => Value::Mat4([
                [1.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]),
            ParameterType::Image => return None,
            ParameterType::Ramp => Value::Ramp(Ramp::black_to_white()),
            ParameterType::Array(element, count) => {
                let zero = element.parameter_type().zero()?;
                Value::Array(vec![zero; count as usize])
            }
        })
    }
}

impl fmt::Display for ParameterType {
    /// As it is written in WGSL.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ParameterType::F32 => "f32",
            ParameterType::I32 => "i32",
            ParameterType::U32 => "u32",
            ParameterType::Bool => "bool",
            ParameterType::Vec2 => "vec2f",
            ParameterType::Vec3 => "vec3f",
            ParameterType::Vec4 => "vec4f",
            ParameterType::Mat3 => "mat3x3f",
            ParameterType::Mat4 => "mat4x4f",
            ParameterType::Image => "sam2D",
            ParameterType::Ramp => "ramp1D",
            ParameterType::Array(element, count) => {
                return write!(f, "array<{}, {count}>", element.parameter_type());
            }
        })
    }
}

/// What `userProc` returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OutputType {
    /// `f32`
    F32,
    /// `vec2f`
    Vec2,
    /// `vec3f`
    Vec3,
    /// `vec4f`
    Vec4,
}

impl OutputType {
    /// 1 to 4.
    pub fn components(self) -> usize {
        match self {
            OutputType::F32 => 1,
            OutputType::Vec2 => 2,
            OutputType::Vec3 => 3,
            OutputType::Vec4 => 4,
        }
    }

    /// The type of that many components.
    pub fn from_components(components: usize) -> Option<Self> {
        Some(match components {
            1 => OutputType::F32,
            2 => OutputType::Vec2,
            3 => OutputType::Vec3,
            4 => OutputType::Vec4,
            _ => return None,
        })
    }
}

impl fmt::Display for OutputType {
    /// As it is written in WGSL.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            OutputType::F32 => "f32",
            OutputType::Vec2 => "vec2f",
            OutputType::Vec3 => "vec3f",
            OutputType::Vec4 => "vec4f",
        })
    }
}

/// A constant for a parameter. Colours are linear Rec.709.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// For `f32`.
    F32(f32),
    /// For `i32`.
    I32(i32),
    /// For `u32`.
    U32(u32),
    /// For `bool`.
    Bool(bool),
    /// For `vec2f`.
    Vec2([f32; 2]),
    /// For `vec3f`.
    Vec3([f32; 3]),
    /// For `vec4f`.
    Vec4([f32; 4]),
    /// For `mat3x3f`: columns.
    Mat3([[f32; 3]; 3]),
    /// For `mat4x4f`: columns.
    Mat4([[f32; 4]; 4]),
    /// For `sam2D`: a handle chosen by the host, given back to its `patina_sample_image`.
    Image(u32),
    /// For `ramp1D`.
    Ramp(Ramp),
    /// For `array<T, N>`: exactly N values of T.
    Array(Vec<Value>),
}

impl Value {
    /// Whether a parameter of type `ty` takes this value as it is.
    pub fn fits(&self, ty: ParameterType) -> bool {
        match (self, ty) {
            (Value::F32(_), ParameterType::F32)
            | (Value::I32(_), ParameterType::I32)
            | (Value::U32(_), ParameterType::U32)
            | (Value::Bool(_), ParameterType::Bool)
            | (Value::Vec2(_), ParameterType::Vec2)
            | (Value::Vec3(_), ParameterType::Vec3)
            | (Value::Vec4(_), ParameterType::Vec4)
            | (Value::Mat3(_), ParameterType::Mat3)
            | (Value::Mat4(_), ParameterType::Mat4)
            | (Value::Image(_), ParameterType::Image)
            | (Value::Ramp(_), ParameterType::Ramp) => true,
            (Value::Array(values), ParameterType::Array(element, count)) => {
                values.len() == count as usize
                    && values
                        .iter()
                        .all(|value| value.fits(element.parameter_type()))
            }
            _ => false,
        }
    }

    /// What kind of value this is, for messages: the WGSL name of its type.
    pub fn type_name(&self) -> String {
        match self {
            Value::F32(_) => "f32".into(),
            Value::I32(_) => "i32".into(),
            Value::U32(_) => "u32".into(),
            Value::Bool(_) => "bool".into(),
            Value::Vec2(_) => "vec2f".into(),
            Value::Vec3(_) => "vec3f".into(),
            Value::Vec4(_) => "vec4f".into(),
            Value::Mat3(_) => "mat3x3f".into(),
            Value::Mat4(_) => "mat4x4f".into(),
            Value::Image(_) => "image".into(),
            Value::Ramp(_) => "ramp".into(),
            Value::Array(values) => match values.first() {
                Some(first) => format!("array<{}, {}>", first.type_name(), values.len()),
                None => "empty array".into(),
            },
        }
    }
}

/// How a ramp goes from one stop to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// Straight lines.
    #[default]
    Linear,
    /// Smoothstep between neighbours: no kinks at the stops.
    Smooth,
    /// The value of the stop before, until the next one.
    Constant,
}

/// A colour ramp or curve: values at positions, interpolated between, constant outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// (position, linear RGBA), in any order: they are sorted by position when used. Positions usually span [0, 1].
    pub stops: Vec<(f32, [f32; 4])>,
    /// Between the stops.
    pub interpolation: Interpolation,
}

impl Ramp {
    /// From (0, 0, 0) at 0 to (1, 1, 1) at 1, opaque.
    pub fn black_to_white() -> Self {
        Self {
            stops: vec![(0.0, [0.0, 0.0, 0.0, 1.0]), (1.0, [1.0; 4])],
            interpolation: Interpolation::Linear,
        }
    }
}

/// The linear RGBA of `#rgb`, `#rrggbb` or `#rrggbbaa`: the colour is sRGB-encoded as on the web, alpha is not.
pub fn color_from_hex(text: &str) -> Option<[f32; 4]> {
    let digits = text.strip_prefix('#')?;
    if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let byte = |at: usize, len: usize| {
        let value = u32::from_str_radix(digits.get(at..at + len)?, 16).ok()?;
        Some(if len == 1 { value * 17 } else { value } as f32 / 255.0)
    };
    let (len, has_alpha) = match digits.len() {
        3 => (1, false),
        6 => (2, false),
        8 => (2, true),
        _ => return None,
    };
    let linear = |encoded: f32| {
        // IEC 61966-2-1.
        if encoded <= 0.04045 {
            encoded / 12.92
        } else {
            ((encoded + 0.055) / 1.055).powf(2.4)
        }
    };
    Some([
        linear(byte(0, len)?),
        linear(byte(len, len)?),
        linear(byte(2 * len, len)?),
        if has_alpha { byte(6, 2)? } else { 1.0 },
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_colours_are_decoded_from_srgb() {
        assert_eq!(color_from_hex("#fff"), Some([1.0; 4]));
        assert_eq!(color_from_hex("#00000000"), Some([0.0; 4]));
        let mid = color_from_hex("#808080").expect("valid")[0];
        assert!((mid - 0.2158605).abs() < 1e-5, "{mid}");
        for bad in ["", "#", "#12", "#gggggg", "123456", "#1234567", "#é23"] {
            assert_eq!(color_from_hex(bad), None, "{bad}");
        }
    }

    #[test]
    fn every_type_has_a_fitting_zero_but_images() {
        let ty = ParameterType::Array(ElementType::Vec3, 3);
        assert!(ty.zero().is_some_and(|zero| zero.fits(ty)));
        assert!(ParameterType::Image.zero().is_none());
        assert!(
            !Value::Array(vec![Value::F32(0.0); 2]).fits(ParameterType::Array(ElementType::F32, 3))
        );
    }
}
