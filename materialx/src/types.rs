//! MaterialX's types and what is written of them.

/// A type of MaterialX.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Type {
    /// `true` or `false`.
    Boolean,
    /// A whole number.
    Integer,
    /// A number.
    Float,
    /// A colour.
    Color3,
    /// A colour with opacity.
    Color4,
    /// Two numbers.
    Vector2,
    /// Three numbers.
    Vector3,
    /// Four numbers.
    Vector4,
    /// Matrices, texts, file names, shaders.
    Other,
}

impl Type {
    /// The type of that name.
    pub fn of(name: &str) -> Self {
        match name {
            "boolean" => Self::Boolean,
            "integer" => Self::Integer,
            "float" => Self::Float,
            "color3" => Self::Color3,
            "color4" => Self::Color4,
            "vector2" => Self::Vector2,
            "vector3" => Self::Vector3,
            "vector4" => Self::Vector4,
            _ => Self::Other,
        }
    }

    /// Its name in MaterialX; empty for those that nothing is computed with.
    pub fn name(self) -> &'static str {
        match self {
            Self::Boolean => "boolean",
            Self::Integer => "integer",
            Self::Float => "float",
            Self::Color3 => "color3",
            Self::Color4 => "color4",
            Self::Vector2 => "vector2",
            Self::Vector3 => "vector3",
            Self::Vector4 => "vector4",
            Self::Other => "",
        }
    }

    /// How many numbers it is.
    pub fn components(self) -> usize {
        match self {
            Self::Boolean | Self::Integer | Self::Float => 1,
            Self::Vector2 => 2,
            Self::Color3 | Self::Vector3 => 3,
            Self::Color4 | Self::Vector4 => 4,
            Self::Other => 0,
        }
    }

    /// Whether colour spaces mean something to it.
    pub fn is_color(self) -> bool {
        matches!(self, Self::Color3 | Self::Color4)
    }
}

/// The numbers of a value as it is written; components that aren't there are 0. `None` where it is something else.
pub(crate) fn numbers(ty: Type, text: &str) -> Option<[f32; 4]> {
    if ty == Type::Boolean {
        return match text.trim() {
            "true" | "True" | "1" => Some([1.0; 4]),
            "false" | "False" | "0" => Some([0.0; 4]),
            _ => None,
        };
    }
    let mut values = [0.0; 4];
    let mut count = 0;
    let parts = text.split([',', ' ', '\t', '\n', '\r']);
    for part in parts.filter(|part| !part.is_empty()) {
        *values.get_mut(count)? = part.parse().ok().filter(|x: &f32| x.is_finite())?;
        count += 1;
    }
    match (ty.components(), count) {
        // A number for a vector is every component.
        (_, 1) => Some([values[0]; 4]),
        (wanted, count) if wanted == count => Some(values),
        _ => None,
    }
}

/// A colour of one of MaterialX's colour spaces as linear Rec.709. `None` for spaces that aren't known.
pub(crate) fn to_linear(space: &str, rgb: [f32; 3]) -> Option<[f32; 3]> {
    /// Rows: from ACEScg (AP1, white D60 adapted by Bradford) to Rec.709.
    const AP1: [[f32; 3]; 3] = [
        [1.705_05, -0.621_79, -0.083_26],
        [-0.130_26, 1.140_80, -0.010_55],
        [-0.024_00, -0.128_97, 1.152_97],
    ];
    /// From Display P3.
    const P3: [[f32; 3]; 3] = [
        [1.224_94, -0.224_94, 0.0],
        [-0.042_06, 1.042_06, 0.0],
        [-0.019_64, -0.078_64, 1.098_27],
    ];
    /// From Adobe RGB.
    const ADOBE: [[f32; 3]; 3] = [
        [1.398_36, -0.398_36, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -0.042_93, 1.042_93],
    ];
    let power = |gamma: f32| rgb.map(|c| c.max(0.0).powf(gamma));
    let times = |m: [[f32; 3]; 3], c: [f32; 3]| m.map(|r| r[0] * c[0] + r[1] * c[1] + r[2] * c[2]);
    Some(match space {
        "lin_rec709" | "lin_rec709_scene" | "none" | "raw" | "linear" | "lin_srgb" => rgb,
        "srgb_texture" | "srgb_rec709_scene" | "srgb" => rgb.map(from_srgb),
        "gamma18" | "g18_rec709" | "g18_rec709_scene" => power(1.8),
        "gamma22" | "g22_rec709" | "g22_rec709_scene" => power(2.2),
        "gamma24" | "g24_rec709" | "rec709_display" => power(2.4),
        "acescg" | "lin_ap1" | "lin_ap1_scene" => times(AP1, rgb),
        "g22_ap1" | "g22_ap1_scene" => times(AP1, power(2.2)),
        "lin_displayp3" | "lin_p3d65_scene" => times(P3, rgb),
        "srgb_displayp3" | "srgb_p3d65_scene" => times(P3, rgb.map(from_srgb)),
        "adobergb" | "g22_adobergb_scene" => times(ADOBE, power(2.199_218_8)),
        "lin_adobergb" | "lin_adobergb_scene" => times(ADOBE, rgb),
        _ => return None,
    })
}

fn from_srgb(c: f32) -> f32 {
    match c <= 0.040_45 {
        true => c / 12.92,
        false => ((c + 0.055) / 1.055).powf(2.4),
    }
}
