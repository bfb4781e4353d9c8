//! Appearances as glTF's channels: which numbers are gathered, and how they lie in pictures of eight bits.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::procedural::Output;
use crate::scene::{AlphaMode, Image, Material};

use super::appearance::{Appearance, COAT_NORMAL, Painter};
use super::images::{encoded, linear8, srgb8};
use super::{BakeSettings, Maps, component};

/// Numbers that differ by less are the same in eight bits.
const SAME: f32 = 1.0 / 512.0;
/// Opacities that are so near to 0 or 1 are taken for it where a mask is asked for.
const NEAR: f32 = 0.02;
/// Borders of masks are so many texels wide to each side: samples and textures smooth them.
const REACH: usize = 2;

/// Which of a material's pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// RGB base colour, A opacity.
    BaseColor,
    /// R ambient occlusion, G roughness, B metallic.
    MetallicRoughness,
    /// Normal in the frame of the tangents.
    Normal,
    /// RGB emission.
    Emission,
    /// A weight of the dielectric's reflection.
    Specular,
    /// RGB its tint.
    SpecularColor,
    /// R share that goes through.
    Transmission,
    /// A share of the diffuse light that comes out on the other side.
    DiffuseTransmission,
    /// RGB its colour.
    DiffuseTransmissionColor,
    /// RGB sheen.
    SheenColor,
    /// A its roughness.
    SheenRoughness,
    /// R weight of the coat.
    Coat,
    /// G its roughness.
    CoatRoughness,
    /// Its normal in the frame of the tangents.
    CoatNormal,
    /// RG direction, B strength.
    Anisotropy,
    /// R weight of the thin film.
    Iridescence,
    /// G its thickness.
    IridescenceThickness,
}

impl Role {
    /// All of them.
    pub const ALL: [Self; 17] = [
        Self::BaseColor,
        Self::MetallicRoughness,
        Self::Normal,
        Self::Emission,
        Self::Specular,
        Self::SpecularColor,
        Self::Transmission,
        Self::DiffuseTransmission,
        Self::DiffuseTransmissionColor,
        Self::SheenColor,
        Self::SheenRoughness,
        Self::Coat,
        Self::CoatRoughness,
        Self::CoatNormal,
        Self::Anisotropy,
        Self::Iridescence,
        Self::IridescenceThickness,
    ];

    /// What every material of glTF may have a picture of.
    pub const USUAL: [Self; 3] = [Self::BaseColor, Self::MetallicRoughness, Self::Normal];

    /// For names of files.
    pub fn name(self) -> &'static str {
        match self {
            Self::BaseColor => "base_color",
            Self::MetallicRoughness => "metallic_roughness",
            Self::Normal => "normal",
            Self::Emission => "emission",
            Self::Specular => "specular",
            Self::SpecularColor => "specular_color",
            Self::Transmission => "transmission",
            Self::DiffuseTransmission => "diffuse_transmission",
            Self::DiffuseTransmissionColor => "diffuse_transmission_color",
            Self::SheenColor => "sheen_color",
            Self::SheenRoughness => "sheen_roughness",
            Self::Coat => "coat",
            Self::CoatRoughness => "coat_roughness",
            Self::CoatNormal => "coat_normal",
            Self::Anisotropy => "anisotropy",
            Self::Iridescence => "iridescence",
            Self::IridescenceThickness => "iridescence_thickness",
        }
    }

    /// Whether its RGB is colour, which glTF wants encoded by sRGB.
    pub fn is_color(self) -> bool {
        matches!(
            self,
            Self::BaseColor
                | Self::Emission
                | Self::SpecularColor
                | Self::DiffuseTransmissionColor
                | Self::SheenColor
        )
    }

    /// What its channels hold, RGBA.
    fn channels(self) -> [Source; 4] {
        use Source::{Number, Occlusion, One};
        let rgb = |key| [0, 1, 2].map(|i| Number(key, i));
        let [r, g, b] = match self {
            Self::BaseColor => rgb("base_color"),
            Self::MetallicRoughness => [Occlusion, Number("roughness", 0), Number("metallic", 0)],
            Self::Normal => rgb("normal"),
            Self::Emission => rgb("emission"),
            Self::SpecularColor => rgb("specular_color"),
            Self::Transmission => [Number("transmission", 0), One, One],
            Self::DiffuseTransmissionColor => rgb("diffuse_transmission_color"),
            Self::SheenColor => rgb("sheen_color"),
            Self::Coat => [Number("coat", 0), One, One],
            Self::CoatRoughness => [One, Number("coat_roughness", 0), One],
            Self::CoatNormal => rgb("coat_normal"),
            Self::Anisotropy => [
                Number("anisotropy_rotation", 0),
                Number("anisotropy_rotation", 1),
                Number("anisotropy", 0),
            ],
            Self::Iridescence => [Number("iridescence", 0), One, One],
            Self::IridescenceThickness => [One, Number("iridescence_thickness", 0), One],
            Self::Specular | Self::DiffuseTransmission | Self::SheenRoughness => [One; 3],
        };
        let a = match self {
            Self::BaseColor => Number("opacity", 0),
            Self::Specular => Number("specular", 0),
            Self::DiffuseTransmission => Number("diffuse_transmission", 0),
            Self::SheenRoughness => Number("sheen_roughness", 0),
            _ => One,
        };
        [r, g, b, a]
    }
}

/// What a channel of a picture holds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// A component of an output, by its key.
    Number(&'static str, usize),
    /// Ambient occlusion of its own.
    Occlusion,
    One,
}

/// One picture of a material.
#[derive(Debug, Clone)]
pub struct BakedImage {
    /// What it holds.
    pub role: Role,
    /// Texels along a side.
    pub size: u32,
    /// Linear RGBA, row 0 on top. Colours may exceed 1; normals are from -1 to 1; the thickness is in nanometres.
    pub rgba: Vec<[f32; 4]>,
    /// Greatest of the RGB of an emission, a specular colour or a thickness, or 1 where that is more and it is no emission: what these
    /// are divided by in eight bits. 1 for others.
    pub most: f32,
}

impl BakedImage {
    /// As glTF stores it.
    pub fn eight_bits(&self) -> Vec<u8> {
        let scale = 1.0 / self.most;
        let texel = |texel: &[f32; 4]| -> [u8; 4] {
            let [r, g, b, a] = *texel;
            let rgb = match self.role {
                Role::Normal | Role::CoatNormal => [r, g, b].map(|x| linear8(0.5 + 0.5 * x)),
                Role::Anisotropy => [linear8(0.5 + 0.5 * r), linear8(0.5 + 0.5 * g), linear8(b)],
                role if role.is_color() => [r, g, b].map(|x| srgb8(x * scale)),
                _ => [r, g, b].map(|x| linear8(x * scale)),
            };
            [rgb[0], rgb[1], rgb[2], linear8(a)]
        };
        self.rgba.iter().flat_map(texel).collect()
    }

    /// As a picture of a scene.
    pub fn image(&self, name: String) -> Image {
        Image {
            name,
            width: self.size,
            height: self.size,
            rgba8: Arc::new(self.eight_bits()),
            srgb: self.role.is_color(),
        }
    }
}

/// A material whose looks are in pictures and constants alone.
#[derive(Debug, Clone)]
pub struct BakedMaterial {
    /// The constants; without any picture.
    pub material: Material,
    /// The pictures of what isn't the same everywhere, or of what was asked for.
    pub images: Vec<BakedImage>,
    /// The picture of metallic and roughness holds ambient occlusion as well.
    pub has_occlusion: bool,
    /// Share of the surface that has no place of its own: another part of it is shown there.
    pub overlap: f32,
    /// Share of the surface that has far less of the picture than the rest, and no texel: what lies nearest is shown there.
    pub missed: f32,
    /// Results of programs, in samples, that are not finite: they count as 0.
    pub non_finite: u64,
    /// What differs from place to place, but has one value in glTF: it is the mean.
    pub lost: Vec<&'static str>,
}

/// Which numbers are gathered for each texel, one after the other.
#[derive(Debug)]
pub(super) struct Planes {
    /// The outputs, with the number of their components.
    outputs: Vec<(Output, usize)>,
    /// The coat's normal comes behind them.
    has_coat_normal: bool,
    /// The material is made of several surfaces.
    is_mixed: bool,
}

impl Planes {
    /// All that differ from place to place, and the normal.
    pub(super) fn of(painter: &Painter<'_>) -> Self {
        let varies = |output| painter.varies(output);
        let wanted = |output: &Output| {
            *output == Output::NORMAL
                || ![
                    Output::BUMP,
                    Output::NORMAL_SCALE,
                    Output::EMISSION_STRENGTH,
                ]
                .contains(output)
                    && (varies(*output)
                        || *output == Output::EMISSION && varies(Output::EMISSION_STRENGTH)
                        || *output == Output::ANISOTROPY_ROTATION && varies(Output::ANISOTROPY)
                        || *output == Output::ANISOTROPY && varies(Output::ANISOTROPY_ROTATION))
        };
        let components = |output: Output| match output {
            // As a direction: angles have no mean.
            Output::ANISOTROPY_ROTATION => 2,
            output => output.words() as usize,
        };
        let outputs = Output::ALL.into_iter().filter(wanted);
        Self {
            outputs: outputs.map(|output| (output, components(output))).collect(),
            has_coat_normal: painter.has_coat_normal(),
            is_mixed: painter.is_mixed(),
        }
    }

    fn of_outputs(&self) -> usize {
        self.outputs.iter().map(|(_, count)| count).sum()
    }

    /// Numbers of a texel: those of the outputs, of the coat's normal, and ambient occlusion.
    pub(super) fn stride(&self) -> usize {
        let coat = if self.has_coat_normal { 3 } else { 0 };
        self.of_outputs() + coat + 1
    }

    /// The numbers of a place.
    pub(super) fn texel(
        &self,
        painted: &Appearance,
        normal: Vec3,
        tangent: Vec4,
        open: f32,
    ) -> Vec<f32> {
        let mut numbers = Vec::with_capacity(self.stride());
        let along = tangent.truncate();
        let across = normal.cross(along) * tangent.w;
        let local = |bent: Vec3| {
            let up = bent.dot(normal).max(0.01);
            [bent.dot(along), bent.dot(across), up]
        };
        for &(output, count) in &self.outputs {
            match output {
                Output::NORMAL => numbers.extend(local(painted[output.number() as usize])),
                Output::ANISOTROPY_ROTATION => {
                    let angle = component(painted, output, 0);
                    numbers.extend([angle.cos(), angle.sin()]);
                }
                _ => numbers.extend((0..count).map(|i| component(painted, output, i))),
            }
        }
        if self.has_coat_normal {
            numbers.extend(local(painted[COAT_NORMAL]));
        }
        numbers.push(open);
        numbers
    }

    /// Where an output's numbers begin.
    fn place(&self, key: &str) -> Option<usize> {
        if key == "coat_normal" {
            return self.has_coat_normal.then(|| self.of_outputs());
        }
        let at = self.outputs.iter().position(|(o, _)| o.key() == key)?;
        Some(self.outputs[..at].iter().map(|(_, count)| count).sum())
    }

    /// The material with the pictures of what isn't the same everywhere.
    pub(super) fn baked(
        &self,
        surface: &Material,
        maps: &Maps,
        settings: &BakeSettings,
    ) -> BakedMaterial {
        let has_occlusion = settings.occlusion.is_some();
        let mut material = surface.clone();
        for texture in material.textures_mut() {
            *texture = None;
        }
        let mut images = Vec::new();
        for role in Role::ALL {
            let is_gathered = role.channels().iter().any(|channel| match channel {
                Source::Number(key, _) => self.place(key).is_some(),
                Source::Occlusion => has_occlusion,
                Source::One => false,
            });
            let is_kept = settings.keeps_flat && Role::USUAL.contains(&role);
            if !is_gathered && !is_kept {
                continue;
            }
            let image = self.image(role, surface, maps);
            let is_kept = is_kept || role == Role::MetallicRoughness && has_occlusion;
            match is_flat(&image) && !is_kept {
                true => set_constant(&mut material, role, image.rgba[0]),
                false => {
                    prepare(&mut material, &image);
                    images.push(image);
                }
            }
        }
        self.set_alpha_mode(&mut material, surface, maps);
        let lost = self.set_means(&mut material, maps);
        BakedMaterial {
            material,
            images,
            has_occlusion,
            overlap: maps.overlap,
            missed: maps.missed,
            non_finite: maps.non_finite,
            lost,
        }
    }

    fn image(&self, role: Role, surface: &Material, maps: &Maps) -> BakedImage {
        let channels = role.channels().map(|channel| match channel {
            Source::One => Err(1.0),
            Source::Occlusion => Ok(maps.stride - 1),
            Source::Number(key, i) => match self.place(key) {
                Some(place) => Ok(place + i),
                None => Err(constant(surface, key, i)),
            },
        });
        let texel =
            |texel: &[f32]| channels.map(|channel| channel.map_or_else(|c| c, |i| texel[i]));
        let mut rgba: Vec<[f32; 4]> = maps.plane(0, maps.stride).map(texel).collect();
        if matches!(role, Role::Normal | Role::CoatNormal) {
            for texel in &mut rgba {
                let normal = Vec3::new(texel[0], texel[1], texel[2]).normalize_or(Vec3::Z);
                [texel[0], texel[1], texel[2]] = normal.to_array();
            }
        }
        // What else is a colour ends at 1, in renderers, too.
        let is_scaled = matches!(
            role,
            Role::Emission | Role::SpecularColor | Role::IridescenceThickness
        );
        let least = if role == Role::Emission { 1e-6 } else { 1.0 };
        let greatest = rgba
            .iter()
            .flat_map(|t| &t[..3])
            .copied()
            .fold(least, f32::max);
        BakedImage {
            role,
            size: maps.size,
            rgba,
            most: if is_scaled { greatest } else { 1.0 },
        }
    }

    /// Alpha means what the opacity needs: nothing where it is 1, a mask where it is 0 or 1 but for borders.
    fn set_alpha_mode(&self, material: &mut Material, surface: &Material, maps: &Maps) {
        let Some(place) = self.place("opacity") else {
            return;
        };
        let opacities: Vec<f32> = maps.plane(place, 1).map(|texel| texel[0]).collect();
        let is_between = |opacity: &f32| (SAME..=1.0 - SAME).contains(opacity);
        material.alpha_mode = match surface.alpha_mode {
            _ if opacities.iter().all(|&o| o > 1.0 - SAME) => AlphaMode::Opaque,
            // Each sample lies on one side of the cutoff.
            AlphaMode::Mask { .. } if !self.is_mixed => AlphaMode::Mask { cutoff: 0.5 },
            AlphaMode::Blend if opacities.iter().any(is_between) => AlphaMode::Blend,
            _ if is_cut(&opacities, maps) => AlphaMode::Mask { cutoff: 0.5 },
            _ => AlphaMode::Blend,
        };
        if material.alpha_mode == AlphaMode::Opaque {
            material.base_color.w = 1.0;
        }
    }

    /// What glTF has one number for, and the texture more.
    fn set_means(&self, material: &mut Material, maps: &Maps) -> Vec<&'static str> {
        let Some(place) = self.place("ior") else {
            return Vec::new();
        };
        let shown = || {
            let texels = maps.plane(place, 1).zip(&maps.is_shown);
            texels.filter(|(_, is_shown)| **is_shown)
        };
        let count = shown().count();
        if count == 0 {
            return Vec::new();
        }
        let mean = shown().map(|(texel, _)| f64::from(texel[0])).sum::<f64>() / count as f64;
        material.ior = mean as f32;
        match shown().any(|(texel, _)| (texel[0] - material.ior).abs() > SAME) {
            true => vec!["ior"],
            false => Vec::new(),
        }
    }
}

/// A constant of a material that no program drives.
fn constant(material: &Material, key: &str, i: usize) -> f32 {
    let m = material;
    match key {
        "base_color" => m.base_color[i],
        "opacity" => match m.alpha_mode {
            AlphaMode::Opaque => 1.0,
            _ => m.base_color.w,
        },
        "roughness" => m.roughness,
        "metallic" => m.metallic,
        "anisotropy" => m.anisotropy,
        _ => 1.0,
    }
}

/// Whether opacities are 0 or 1, but for the borders between both: nine of ten texels that are between lie at one.
fn is_cut(opacities: &[f32], maps: &Maps) -> bool {
    let is_between =
        |texel: &usize| maps.is_shown[*texel] && (NEAR..1.0 - NEAR).contains(&opacities[*texel]);
    let between: Vec<usize> = (0..opacities.len()).filter(is_between).collect();
    let borders = (between.par_iter())
        .filter(|texel| is_border(opacities, maps, **texel))
        .count();
    borders * 10 >= between.len() * 9
}

/// Whether there are both 0 and 1 beside a texel.
fn is_border(opacities: &[f32], maps: &Maps, texel: usize) -> bool {
    let side = maps.size as usize;
    let around = |at: usize| at.saturating_sub(REACH)..(at + REACH + 1).min(side);
    let (mut has_none, mut has_all) = (false, false);
    for y in around(texel / side) {
        for x in around(texel % side) {
            let beside = y * side + x;
            if maps.is_shown[beside] {
                has_none |= opacities[beside] < NEAR;
                has_all |= opacities[beside] >= 1.0 - NEAR;
            }
        }
    }
    has_none && has_all
}

/// Whether all texels are the same in eight bits.
fn is_flat(image: &BakedImage) -> bool {
    let stored = |x: f32| match image.role.is_color() {
        true => encoded(x / image.most),
        false => x / image.most,
    };
    let first = image.rgba[0];
    let [r, g, b, a] = first;
    let rgb = [r, g, b].map(stored);
    let is_same = |texel: &[f32; 4]| {
        let is_near = |i: usize| texel[i] == first[i] || (stored(texel[i]) - rgb[i]).abs() < SAME;
        (0..3).all(is_near) && (texel[3] - a).abs() < SAME
    };
    match image.role {
        Role::Normal | Role::CoatNormal => {
            image.rgba.iter().all(|t| t[0].abs().max(t[1].abs()) < SAME)
        }
        _ => image.rgba.par_iter().all(is_same),
    }
}

/// Gives a material the constant that a picture without differences stands for.
fn set_constant(m: &mut Material, role: Role, [r, g, b, a]: [f32; 4]) {
    let rgb = Vec3::new(r, g, b);
    match role {
        Role::BaseColor => m.base_color = rgb.clamp(Vec3::ZERO, Vec3::ONE).extend(a),
        Role::MetallicRoughness => {
            (m.roughness, m.metallic) = (g.clamp(0.0, 1.0), b.clamp(0.0, 1.0));
        }
        Role::Normal | Role::CoatNormal => {}
        Role::Emission => m.emission = rgb.max(Vec3::ZERO),
        Role::Specular => m.specular = a.clamp(0.0, 1.0),
        Role::SpecularColor => m.specular_color = rgb.max(Vec3::ZERO),
        Role::Transmission => m.transmission = r.clamp(0.0, 1.0),
        Role::DiffuseTransmission => m.diffuse_transmission = a.clamp(0.0, 1.0),
        Role::DiffuseTransmissionColor => {
            m.diffuse_transmission_color = rgb.clamp(Vec3::ZERO, Vec3::ONE);
        }
        Role::SheenColor => m.sheen_color = rgb.clamp(Vec3::ZERO, Vec3::ONE),
        Role::SheenRoughness => m.sheen_roughness = a.clamp(0.0, 1.0),
        Role::Coat => m.coat = r.clamp(0.0, 1.0),
        Role::CoatRoughness => m.coat_roughness = g.clamp(0.0, 1.0),
        Role::Anisotropy => {
            (m.anisotropy, m.anisotropy_rotation) = (b.clamp(0.0, 1.0), g.atan2(r));
        }
        Role::Iridescence => m.iridescence = r.clamp(0.0, 1.0),
        Role::IridescenceThickness => m.iridescence_thickness = [g.max(0.0); 2],
    }
}

/// Sets the factors that a picture is multiplied by.
fn prepare(m: &mut Material, image: &BakedImage) {
    match image.role {
        Role::BaseColor => m.base_color = Vec4::ONE,
        Role::MetallicRoughness => (m.metallic, m.roughness) = (1.0, 1.0),
        Role::Normal => m.normal_scale = 1.0,
        Role::Emission => m.emission = Vec3::splat(image.most),
        Role::Specular => m.specular = 1.0,
        Role::SpecularColor => m.specular_color = Vec3::splat(image.most),
        Role::Transmission => m.transmission = 1.0,
        Role::DiffuseTransmission => m.diffuse_transmission = 1.0,
        Role::DiffuseTransmissionColor => m.diffuse_transmission_color = Vec3::ONE,
        Role::SheenColor => m.sheen_color = Vec3::ONE,
        Role::SheenRoughness => m.sheen_roughness = 1.0,
        Role::Coat => m.coat = 1.0,
        Role::CoatRoughness => m.coat_roughness = 1.0,
        Role::CoatNormal => m.coat_normal_scale = 1.0,
        Role::Anisotropy => (m.anisotropy, m.anisotropy_rotation) = (1.0, 0.0),
        Role::Iridescence => m.iridescence = 1.0,
        Role::IridescenceThickness => m.iridescence_thickness = [0.0, image.most],
    }
}
