//! What an input of a node has: numbers, a text, or what another node gives.

use texgen::{OutputType, ParameterType};

use crate::types::Type;

/// A value on its way into a look.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    /// Numbers as they are written.
    Numbers(Type, [f32; 4]),
    /// A word.
    Text(String),
    /// Path of an image as a look has it, and whether it is encoded as sRGB.
    File { path: String, is_srgb: bool },
    /// What a node gives.
    Link(Link),
    /// A matrix: three rows of three numbers, or four of four, each a value.
    Matrix(Vec<Value>),
}

/// What a node of the look gives, or components of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Link {
    pub(crate) node: String,
    pub(crate) ty: Type,
    /// What the node's texture returns.
    pub(crate) output: OutputType,
    /// Components taken, in their order; all where there is none.
    pub(crate) picked: Option<Vec<u8>>,
    /// The fourth component is the width of the pixel, as of texture coordinates.
    pub(crate) is_place: bool,
}

impl Link {
    /// Component `i`, which is 0 for numbers.
    fn component(&self, i: usize) -> u8 {
        match &self.picked {
            Some(picked) => picked.get(i).or(picked.last()).copied().unwrap_or(0),
            None => i.min(self.output.components() - 1) as u8,
        }
    }

    /// The same with other components.
    pub(crate) fn pick(&self, ty: Type, components: &[usize]) -> Self {
        let is_number = self.output == OutputType::F32;
        let picked = components.iter().map(|&i| self.component(i)).collect();
        Self {
            ty,
            picked: (!is_number).then_some(picked),
            is_place: false,
            ..self.clone()
        }
    }

    /// As a look writes it where a parameter of that type takes it.
    pub(crate) fn text(&self, ty: ParameterType, is_coordinate: bool) -> String {
        let own = self.ty.components().max(1);
        let wanted = match ty {
            ParameterType::Vec2 => 2,
            ParameterType::Vec3 => 3,
            ParameterType::Vec4 if is_coordinate && !self.is_place => own.min(3),
            ParameterType::Vec4 => 4,
            _ => 1,
        };
        // Numbers are every component of what they drive.
        let taken = if own == 1 { 1 } else { wanted };
        let has = self.output.components();
        let is_whole = self.picked.is_none() && (has == 1 || has == taken);
        if is_whole || (self.picked.is_none() && taken == 4 && has == 3) {
            return self.node.clone();
        }
        let letters = (0..taken).map(|i| char::from(b"xyzw"[usize::from(self.component(i))]));
        format!("{}.{}", self.node, letters.collect::<String>())
    }
}

impl Value {
    /// A number.
    pub(crate) fn number(number: f32) -> Self {
        Self::Numbers(Type::Float, [number; 4])
    }

    /// A colour.
    pub(crate) fn color(rgb: [f32; 3]) -> Self {
        Self::Numbers(Type::Color3, [rgb[0], rgb[1], rgb[2], 1.0])
    }

    /// Its type; `Other` for texts.
    pub(crate) fn ty(&self) -> Type {
        match self {
            Self::Numbers(ty, _) => *ty,
            Self::Link(link) => link.ty,
            Self::Text(_) | Self::File { .. } | Self::Matrix(_) => Type::Other,
        }
    }

    /// The numbers, where they are known.
    pub(crate) fn known(&self) -> Option<[f32; 4]> {
        match self {
            Self::Numbers(_, numbers) => Some(*numbers),
            _ => None,
        }
    }

    /// Whether it is known to be this number in each of its components.
    pub(crate) fn is(&self, number: f32) -> bool {
        let count = self.ty().components();
        self.known()
            .is_some_and(|numbers| numbers[..count].iter().all(|&x| x == number))
    }

    /// Some of the components, as a value of that type.
    pub(crate) fn pick(&self, ty: Type, components: &[usize]) -> Self {
        match self {
            Self::Numbers(_, numbers) => {
                let mut picked = [0.0; 4];
                for (to, &from) in picked.iter_mut().zip(components) {
                    *to = numbers[from.min(3)];
                }
                if components.len() == 1 {
                    picked = [picked[0]; 4];
                }
                Self::Numbers(ty, picked)
            }
            Self::Link(link) => Self::Link(link.pick(ty, components)),
            other => other.clone(),
        }
    }

    /// One component.
    pub(crate) fn component(&self, i: usize) -> Self {
        self.pick(Type::Float, &[i])
    }

    /// The same value called another type of as many components.
    pub(crate) fn called(&self, ty: Type) -> Self {
        match self {
            Self::Numbers(_, numbers) => Self::Numbers(ty, *numbers),
            Self::Link(link) => Self::Link(Link { ty, ..link.clone() }),
            other => other.clone(),
        }
    }
}
