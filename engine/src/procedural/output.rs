//! What of a material a texture can drive.

/// A value of a material that a texture can drive. The number is its place in the head and its bit among the flags;
/// the results of a hit are stored in the order of these numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Output {
    /// Linear colour.
    BaseColor = 0,
    /// 0 dielectric .. 1 metal.
    Metallic = 1,
    /// Perceptual roughness.
    Roughness = 2,
    /// Radiance, W/m²/sr, before the strength.
    Emission = 3,
    /// How much of the surface is there.
    Opacity = 4,
    /// Shading normal in the world.
    Normal = 5,
    /// Weight of a dielectric's reflection.
    Specular = 6,
    /// Its tint at normal incidence, linear.
    SpecularColor = 7,
    /// Index of refraction.
    Ior = 8,
    /// Factor on the emission.
    EmissionStrength = 9,
    /// Factor on the slopes of the normal map.
    NormalScale = 10,
    /// Share of the light below the reflection that goes through.
    Transmission = 11,
    /// Share of the diffuse light that comes out on the other side.
    DiffuseTransmission = 12,
    /// Its linear colour.
    DiffuseTransmissionColor = 13,
    /// Weight of the coat.
    Coat = 14,
    /// Perceptual roughness of the coat.
    CoatRoughness = 15,
    /// Linear colour of the sheen.
    SheenColor = 16,
    /// Perceptual roughness of the sheen.
    SheenRoughness = 17,
    /// How far reflections are stretched, 0 to 1.
    Anisotropy = 18,
    /// Where they are stretched to, radians from the tangent.
    AnisotropyRotation = 19,
    /// Weight of a thin film.
    Iridescence = 20,
    /// Its thickness, nanometres.
    IridescenceThickness = 21,
    /// Height above the surface. Stored as the slope of the surface, so it comes last: it is known last.
    Bump = 23,
}

/// What a node must give to drive an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One number.
    Scalar,
    /// One, three or four components.
    Color,
    /// Three or four components.
    Vector,
}

impl Output {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 23] = [
        Self::BaseColor,
        Self::Metallic,
        Self::Roughness,
        Self::Emission,
        Self::Opacity,
        Self::Normal,
        Self::Specular,
        Self::SpecularColor,
        Self::Ior,
        Self::EmissionStrength,
        Self::NormalScale,
        Self::Transmission,
        Self::DiffuseTransmission,
        Self::DiffuseTransmissionColor,
        Self::Coat,
        Self::CoatRoughness,
        Self::SheenColor,
        Self::SheenRoughness,
        Self::Anisotropy,
        Self::AnisotropyRotation,
        Self::Iridescence,
        Self::IridescenceThickness,
        Self::Bump,
    ];

    /// Its key in a look.
    pub fn key(self) -> &'static str {
        match self {
            Self::BaseColor => "base_color",
            Self::Metallic => "metallic",
            Self::Roughness => "roughness",
            Self::Emission => "emission",
            Self::Opacity => "opacity",
            Self::Normal => "normal",
            Self::Specular => "specular",
            Self::SpecularColor => "specular_color",
            Self::Ior => "ior",
            Self::EmissionStrength => "emission_strength",
            Self::NormalScale => "normal_scale",
            Self::Transmission => "transmission",
            Self::DiffuseTransmission => "diffuse_transmission",
            Self::DiffuseTransmissionColor => "diffuse_transmission_color",
            Self::Coat => "coat",
            Self::CoatRoughness => "coat_roughness",
            Self::SheenColor => "sheen_color",
            Self::SheenRoughness => "sheen_roughness",
            Self::Anisotropy => "anisotropy",
            Self::AnisotropyRotation => "anisotropy_rotation",
            Self::Iridescence => "iridescence",
            Self::IridescenceThickness => "iridescence_thickness",
            Self::Bump => "bump",
        }
    }

    /// What drives it.
    pub fn kind(self) -> Kind {
        match self {
            Self::BaseColor
            | Self::Emission
            | Self::SpecularColor
            | Self::DiffuseTransmissionColor
            | Self::SheenColor => Kind::Color,
            Self::Normal => Kind::Vector,
            _ => Kind::Scalar,
        }
    }

    /// Its bit among the flags of a head.
    pub fn bit(self) -> u32 {
        1 << self as u32
    }

    /// Words that its result takes in the state of a path.
    pub fn words(self) -> u32 {
        match self {
            Self::Bump => 3,
            _ if self.kind() == Kind::Scalar => 1,
            _ => 3,
        }
    }
}

/// Words that the results of a hit take whose material has these flags.
pub(super) fn result_words(flags: u32) -> u32 {
    let driven = Output::ALL.iter().filter(|o| flags & o.bit() != 0);
    driven.map(|output| output.words()).sum()
}

/// Whether a program with these flags may let light through.
pub(super) fn transmits(flags: u32) -> bool {
    flags & (Output::Transmission.bit() | Output::DiffuseTransmission.bit()) != 0
}

/// Whether it may have a coat, sheen, a thin film or anisotropy.
pub(super) fn has_layers(flags: u32) -> bool {
    let layers = [
        Output::Coat,
        Output::SheenColor,
        Output::Anisotropy,
        Output::Iridescence,
    ];
    layers.iter().any(|output| flags & output.bit() != 0)
}
