//! The table itself, in the order in which panels and the documentation show it.

use glam::Vec3;

use crate::{AlphaMode, Material};

use super::{Constant, Driven, Feature, Field, Kind, Number, Parameter, Takes, Unit, Valid};

/// Number and colour of a field of [`Material`] with the parameter's name.
macro_rules! number {
    ($field:ident) => {
        Field::Number(|m| m.$field, |m, value| m.$field = value)
    };
}
macro_rules! color {
    ($field:ident) => {
        Field::Color(|m| m.$field, |m, value| m.$field = value)
    };
}
macro_rules! flag {
    ($field:ident) => {
        Field::Flag(|m| m.$field, |m, value| m.$field = value)
    };
}

const COLOR: Takes = Takes::Color { is_share: false };
const SHARE_COLOR: Takes = Takes::Color { is_share: true };
const SHARE: Takes = linear(Valid::Share, 0.0, 1.0, Unit::None);

const fn linear(valid: Valid, from: f32, to: f32, unit: Unit) -> Takes {
    Takes::Number(Number {
        valid,
        slider: (from, to),
        is_log: false,
        unit,
    })
}

const fn log(valid: Valid, from: f32, to: f32, unit: Unit) -> Takes {
    Takes::Number(Number {
        valid,
        slider: (from, to),
        is_log: true,
        unit,
    })
}

/// A row: key, label, what it takes, where it is kept, what it means.
const fn row(
    key: &'static str,
    label: &'static str,
    takes: Takes,
    field: Field,
    help: &'static str,
) -> Parameter {
    Parameter {
        key,
        label,
        help,
        takes,
        is_common: false,
        driven: None,
        field,
        is_recorded: false,
        needs: None,
    }
}

impl Parameter {
    const fn common(mut self) -> Self {
        self.is_common = true;
        self
    }

    /// The kernels' record of a material has it.
    const fn recorded(mut self) -> Self {
        self.is_recorded = true;
        self
    }

    /// A node may drive it, by what its constants are.
    const fn driven(self, number: u32) -> Self {
        let kind = match self.takes {
            Takes::Color { .. } => Kind::Color,
            _ => Kind::Scalar,
        };
        self.driven_by(kind, number)
    }

    const fn driven_by(mut self, kind: Kind, number: u32) -> Self {
        self.driven = Some(Driven { kind, number });
        self
    }

    const fn needs(mut self, feature: Feature) -> Self {
        self.needs = Some(feature);
        self
    }
}

fn alpha_mode(material: &Material) -> Constant {
    Constant::Word(match material.alpha_mode {
        AlphaMode::Opaque => "opaque",
        AlphaMode::Mask { .. } => "mask",
        AlphaMode::Blend => "blend",
    })
}

fn alpha_cutoff(material: &Material) -> Constant {
    Constant::Number(match material.alpha_mode {
        AlphaMode::Mask { cutoff } => cutoff,
        _ => 0.5,
    })
}

/// After how many metres light has the attenuation colour, or would have one.
fn attenuation_distance(material: &Material) -> f32 {
    match material.attenuation_distance {
        distance if distance.is_finite() => distance,
        _ => 1.0,
    }
}

/// All keys of `[material.NAME]` but `blend`.
pub const PARAMETERS: [Parameter; 36] = [
    row(
        "base_color",
        "Base colour",
        SHARE_COLOR,
        Field::Color(
            |m| m.base_color.truncate(),
            |m, color| m.base_color = color.extend(m.base_color.w),
        ),
        "colour of a dielectric's body, or of a metal's reflection",
    )
    .common()
    .driven(0),
    row(
        "metallic",
        "Metallic",
        SHARE,
        number!(metallic),
        "0 is a dielectric, 1 a metal",
    )
    .common()
    .recorded()
    .driven(1),
    row(
        "roughness",
        "Roughness",
        SHARE,
        number!(roughness),
        "perceptual roughness",
    )
    .common()
    .recorded()
    .driven(2),
    row(
        "emission",
        "Emission",
        COLOR,
        color!(emission),
        "emitted radiance, W/m²/sr",
    )
    .common()
    .recorded()
    .driven(3),
    row(
        "emission_strength",
        "Emission strength",
        log(Valid::NotNegative, 0.0, 1000.0, Unit::None),
        Field::Number(
            |_| 1.0,
            |m, strength| m.emission = (m.emission * strength).min(Vec3::MAX),
        ),
        "factor on the emission, on glTF's own where `emission` is absent",
    )
    .common()
    .driven(9),
    row(
        "normal",
        "Normal",
        Takes::Link,
        Field::None,
        "shading normal in the world, as `readAttr(Normal)` gives it; the normal map of the glTF file is not used then",
    )
    .common()
    .driven_by(Kind::Vector, 5),
    row(
        "bump",
        "Bump",
        Takes::Link,
        Field::None,
        "height above the surface: the shading normal leans as if the surface were raised by it",
    )
    .common()
    .driven_by(Kind::Scalar, 22),
    row(
        "bump_scale",
        "Bump scale",
        log(Valid::Any, 0.0, 1.0, Unit::Metres),
        Field::Shown(|_| Constant::Number(1.0)),
        "metres per unit of `bump`, 1 if absent",
    ),
    row(
        "normal_scale",
        "Normal map scale",
        linear(Valid::Any, 0.0, 2.0, Unit::None),
        number!(normal_scale),
        "factor on the normal map of the scene",
    )
    .recorded()
    .driven(10),
    row(
        "opacity",
        "Opacity",
        SHARE,
        Field::Number(
            |_| 1.0,
            |m, opacity| {
                m.base_color.w = opacity;
                // Where alpha is ignored its picture may have any, which must not count for what is there as a whole.
                if opacity < 1.0 || m.alpha_mode != AlphaMode::Opaque {
                    m.alpha_mode = AlphaMode::Blend;
                }
            },
        ),
        "how much of the surface is there, in place of what alpha means in glTF",
    )
    .driven(4),
    row(
        "alpha",
        "Alpha",
        SHARE,
        Field::Number(|m| m.base_color.w, |m, alpha| m.base_color.w = alpha),
        "alpha of the base colour",
    ),
    row(
        "alpha_mode",
        "Alpha mode",
        Takes::Choice(&["opaque", "mask", "blend"]),
        Field::Shown(alpha_mode),
        "what alpha means, as in glTF",
    ),
    row(
        "alpha_cutoff",
        "Alpha cutoff",
        linear(Valid::NotNegative, 0.0, 1.0, Unit::None),
        Field::Shown(alpha_cutoff),
        "threshold of `\"mask\"`",
    ),
    row(
        "specular",
        "Specular",
        SHARE,
        number!(specular),
        "weight of a dielectric's reflection",
    )
    .recorded()
    .driven(6),
    row(
        "specular_color",
        "Specular colour",
        COLOR,
        color!(specular_color),
        "tint of it at normal incidence",
    )
    .recorded()
    .driven(7),
    row(
        "ior",
        "Index of refraction",
        linear(Valid::Ior, 1.0, 3.0, Unit::None),
        number!(ior),
        "index of refraction of the dielectric",
    )
    .recorded()
    .driven(8),
    row(
        "transmission",
        "Transmission",
        SHARE,
        number!(transmission),
        "share of the light below the reflection that goes through, as through glass",
    )
    .recorded()
    .driven(11)
    .needs(Feature::Transmission),
    row(
        "solid",
        "Solid",
        Takes::Flag,
        flag!(is_solid),
        "the surface bounds a body, which refracts; otherwise it is a thin wall",
    ),
    row(
        "attenuation_color",
        "Attenuation colour",
        SHARE_COLOR,
        Field::Color(
            |m| m.attenuation_color,
            |m, color| m.attenuate(color, attenuation_distance(m)),
        ),
        "white light has this colour after the attenuation distance",
    ),
    row(
        "attenuation_distance",
        "Attenuation distance",
        log(Valid::Positive, 0.0001, 10.0, Unit::Metres),
        Field::Number(attenuation_distance, |m, distance| {
            m.attenuate(m.attenuation_color, distance);
        }),
        "way through the body; 1 where neither look nor glTF file says it",
    ),
    row(
        "dispersion",
        "Dispersion",
        linear(Valid::NotNegative, 0.0, 2.0, Unit::None),
        number!(dispersion),
        "how much the index of the body differs by colour: 20 divided by its Abbe number",
    )
    .recorded(),
    row(
        "priority",
        "Priority",
        Takes::Whole {
            most: 1000,
            slider: (-10, 10),
        },
        Field::Number(|m| m.priority as f32, |m, value| m.priority = value as i32),
        "where bodies overlap, the inside of the one with the highest counts, among equals that of the one entered last; \
         0 if absent",
    )
    .recorded(),
    row(
        "diffuse_transmission",
        "Diffuse transmission",
        SHARE,
        number!(diffuse_transmission),
        "share of the diffuse light that comes out on the other side, as of a leaf",
    )
    .recorded()
    .driven(12)
    .needs(Feature::Transmission),
    row(
        "diffuse_transmission_color",
        "Diffuse transmission colour",
        SHARE_COLOR,
        color!(diffuse_transmission_color),
        "its colour",
    )
    .recorded()
    .driven(13),
    row("coat", "Coat", SHARE, number!(coat), "weight of a clear coat")
        .recorded()
        .driven(14)
        .needs(Feature::Layers),
    row(
        "coat_roughness",
        "Coat roughness",
        SHARE,
        number!(coat_roughness),
        "perceptual roughness of the coat",
    )
    .recorded()
    .driven(15),
    row(
        "sheen_color",
        "Sheen colour",
        SHARE_COLOR,
        color!(sheen_color),
        "sheen of cloth; black is none",
    )
    .recorded()
    .driven(16)
    .needs(Feature::Layers),
    row(
        "sheen_roughness",
        "Sheen roughness",
        SHARE,
        number!(sheen_roughness),
        "perceptual roughness of the sheen",
    )
    .recorded()
    .driven(17),
    row(
        "anisotropy",
        "Anisotropy",
        SHARE,
        number!(anisotropy),
        "how far reflections are stretched, as by brushed metal",
    )
    .recorded()
    .driven(18)
    .needs(Feature::Layers),
    row(
        "anisotropy_rotation",
        "Anisotropy rotation",
        linear(Valid::Any, -180.0, 180.0, Unit::Degrees),
        number!(anisotropy_rotation),
        "where to, counter-clockwise from the tangent",
    )
    .recorded()
    .driven(19),
    row(
        "iridescence",
        "Iridescence",
        SHARE,
        number!(iridescence),
        "weight of a thin film, as of soap",
    )
    .recorded()
    .driven(20)
    .needs(Feature::Layers),
    row(
        "iridescence_thickness",
        "Film thickness",
        linear(Valid::NotNegative, 0.0, 1200.0, Unit::Nanometres),
        Field::Number(
            |m| m.iridescence_thickness[1],
            |m, thickness| m.iridescence_thickness = [thickness; 2],
        ),
        "thickness of the thin film",
    )
    .driven(21),
    row(
        "iridescence_ior",
        "Film index of refraction",
        linear(Valid::AtLeastOne, 1.0, 3.0, Unit::None),
        number!(iridescence_ior),
        "index of refraction of the thin film",
    )
    .recorded(),
    row(
        "double_sided",
        "Double sided",
        Takes::Flag,
        flag!(double_sided),
        "the back emits too, and is not see-through",
    ),
    row(
        "unlit",
        "Unlit",
        Takes::Flag,
        flag!(unlit),
        "the base colour is shown as it is",
    ),
    row(
        "shadow_catcher",
        "Shadow catcher",
        Takes::Flag,
        flag!(shadow_catcher),
        "with `--transparent` only the shadows on it are seen",
    ),
];

const _: () = assert!(
    numbers_are_dense(),
    "each number from 0 up to that of `bump` drives one parameter, and `bump` has the highest"
);

const fn numbers_are_dense() -> bool {
    let mut seen = 0u64;
    let mut count = 0;
    let mut bump = 0;
    let mut i = 0;
    while i < PARAMETERS.len() {
        if let Some(driven) = PARAMETERS[i].driven {
            seen |= 1 << driven.number;
            count += 1;
            if let Takes::Link = PARAMETERS[i].takes
                && let Kind::Scalar = driven.kind
            {
                bump = driven.number;
            }
        }
        i += 1;
    }
    seen == (1 << count) - 1 && bump == count - 1
}
