//! Checked reading of accessors (glTF 2.0, section 3.6.2): strides, sparse substitution, normalized integers.
//!
//! [`Document::accessor`] proves with 64-bit arithmetic that every element lies inside its buffer; reading afterwards
//! can't fail. Nothing is allocated from a count before the bytes behind it have been seen.

use super::document::{Document, offset, slice};
use crate::import::error::{At as _, Fault, ImportError};
use gltf::json;
use json::accessor::{ComponentType, Type};
use json::validation::Checked;

/// Elements an accessor may have without a byte behind them (no buffer view: all zero).
const MAX_UNBACKED: u64 = 1 << 24;

/// An accessor all of whose elements are known to be readable.
pub(super) struct Accessor<'a> {
    count: u32,
    components: usize,
    component: ComponentType,
    normalized: bool,
    /// `None` stands for zeros.
    base: Option<Elements<'a>>,
    sparse: Option<Sparse<'a>>,
}

/// Whether the type of an accessor is one that is read here. Others may come from extensions that are ignored.
fn is_readable(accessor: &json::Accessor) -> bool {
    let Checked::Valid(json::accessor::GenericComponentType(component)) = accessor.component_type
    else {
        return false;
    };
    match accessor.type_ {
        Checked::Invalid => false,
        Checked::Valid(Type::Mat2 | Type::Mat3 | Type::Mat4) => component == ComponentType::F32,
        Checked::Valid(_) => true,
    }
}

/// Evenly spaced elements.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// Elements that replace those of the base.
struct Sparse<'a> {
    /// Strictly increasing.
    indices: Vec<u32>,
    values: Elements<'a>,
}

impl Document {
    /// Looks up an accessor and checks that it lies inside its buffers.
    pub(super) fn accessor(&self, index: usize) -> Result<Accessor<'_>, Fault> {
        let accessor = self
            .root
            .accessors
            .get(index)
            .ok_or_else(|| format!("accessor {index} does not exist"))?;
        self.check(accessor)
            .map_err(|fault| format!("accessor {index} {fault}"))
    }

    /// Checks all buffer views and accessors, also those that nothing shows: where one reaches beyond its data, the
    /// file has been cut or its numbers are garbage, and what it shows can't be trusted either.
    pub(super) fn check_layout(&self) -> Result<(), ImportError> {
        let place = || "binary data".to_owned();
        for (index, view) in self.root.buffer_views.iter().enumerate() {
            if !self.is_absent(view) {
                self.view(index).map(drop).at(&self.path, place)?;
            }
        }
        for (index, accessor) in self.root.accessors.iter().enumerate() {
            let sparse = accessor.sparse.as_ref();
            let mut views = accessor
                .buffer_view
                .into_iter()
                .chain(
                    sparse
                        .into_iter()
                        .flat_map(|sparse| [sparse.indices.buffer_view, sparse.values.buffer_view]),
                )
                .filter_map(|view| self.root.buffer_views.get(view.value()));
            if !views.any(|view| self.is_absent(view)) && is_readable(accessor) {
                self.accessor(index).map(drop).at(&self.path, place)?;
            }
        }
        Ok(())
    }

    fn check(&self, accessor: &json::Accessor) -> Result<Accessor<'_>, Fault> {
        let Checked::Valid(json::accessor::GenericComponentType(component)) =
            accessor.component_type
        else {
            return Err("has an unknown componentType".into());
        };
        let Checked::Valid(kind) = accessor.type_ else {
            return Err("has an unknown type".into());
        };
        let components = match kind {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            Type::Vec4 | Type::Mat2 => 4,
            Type::Mat3 => 9,
            Type::Mat4 => 16,
        };
        // Columns of small integer matrices are padded; nothing that is read here uses them.
        let is_matrix = matches!(kind, Type::Mat2 | Type::Mat3 | Type::Mat4);
        if is_matrix && component != ComponentType::F32 {
            return Err("is a matrix of integers, which is not supported".into());
        }
        let element = components * component.size();
        let count = u32::try_from(accessor.count.0).map_err(|_| "has too many elements")?;

        let base = match accessor.buffer_view {
            Some(view) => {
                let start = offset(accessor.byte_offset);
                Some(self.elements(view.value(), start, u64::from(count), element as u64)?)
            }
            None if u64::from(count) > MAX_UNBACKED => {
                return Err(format!("has {count} elements but no data"));
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(self.sparse(sparse, count, element as u64)?),
            None => None,
        };
        Ok(Accessor {
            count,
            components,
            component,
            normalized: accessor.normalized,
            base,
            sparse,
        })
    }

    fn elements(
        &self,
        view: usize,
        start: u64,
        count: u64,
        size: u64,
    ) -> Result<Elements<'_>, Fault> {
        let (bytes, stride) = self
            .view(view)
            .map_err(|fault| format!("can't be read: {fault}"))?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            return Err(format!(
                "has elements of {size} bytes at a stride of {stride}"
            ));
        }
        let needed = match count.checked_sub(1) {
            None => Some(0),
            Some(last) => last
                .checked_mul(stride)
                .and_then(|bytes| bytes.checked_add(size)),
        };
        let inside = needed.and_then(|needed| slice(bytes, start, needed)).ok_or_else(|| {
            format!(
                "reaches beyond buffer view {view}: {count} elements from byte {start} in {} bytes",
                bytes.len()
            )
        })?;
        Ok(Elements {
            bytes: inside,
            stride: stride as usize,
        })
    }

    fn sparse(
        &self,
        sparse: &json::accessor::sparse::Sparse,
        count: u32,
        element: u64,
    ) -> Result<Sparse<'_>, Fault> {
        let Checked::Valid(json::accessor::IndexComponentType(component)) =
            sparse.indices.component_type
        else {
            return Err("has sparse indices of an unknown type".into());
        };
        let replaced = sparse.count.0;
        if replaced > u64::from(count) {
            return Err(format!("replaces {replaced} of {count} elements"));
        }
        self.budget.take(replaced, 4)?;
        let indices = Accessor {
            count: replaced as u32,
            components: 1,
            component,
            normalized: false,
            base: Some(self.elements(
                sparse.indices.buffer_view.value(),
                sparse.indices.byte_offset.0,
                replaced,
                component.size() as u64,
            )?),
            sparse: None,
        }
        .indices()?;
        if indices.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err("has sparse indices that do not increase".into());
        }
        if indices.last().is_some_and(|&last| last >= count) {
            return Err("has a sparse index out of range".into());
        }
        let values = self.elements(
            sparse.values.buffer_view.value(),
            sparse.values.byte_offset.0,
            replaced,
            element,
        )?;
        Ok(Sparse { indices, values })
    }
}

impl<'a> Accessor<'a> {
    /// Number of elements.
    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// Components of an element.
    pub(super) fn components(&self) -> usize {
        self.components
    }

    /// Whether a byte of it is in a buffer. Compressed files have accessors without any.
    pub(super) fn has_data(&self) -> bool {
        self.base.is_some() || self.sparse.is_some()
    }

    /// The elements at `indices`, all of which must be below [`count`](Self::count). Integers become floats,
    /// normalized where the accessor says so. `N` may differ from the number of components: what is missing is 0.
    pub(super) fn gather<const N: usize>(
        &self,
        indices: impl Iterator<Item = u32>,
    ) -> Vec<[f32; N]> {
        indices.map(|index| self.element(index)).collect()
    }

    /// Like [`gather`](Self::gather) for all elements in order.
    pub(super) fn all<const N: usize>(&self) -> Vec<[f32; N]> {
        self.gather(0..self.count)
    }

    /// All elements of a scalar accessor of unsigned integers.
    pub(super) fn indices(&self) -> Result<Vec<u32>, Fault> {
        if self.components != 1 {
            return Err("is not scalar, indices must be".into());
        }
        let read: fn(&[u8]) -> u32 = match self.component {
            ComponentType::U8 => |b| u32::from(b[0]),
            ComponentType::U16 => |b| u32::from(u16::from_le_bytes([b[0], b[1]])),
            ComponentType::U32 => |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            ComponentType::I8 | ComponentType::I16 | ComponentType::F32 => {
                return Err("is not of unsigned integers, indices must be".into());
            }
        };
        Ok((0..self.count)
            .map(|index| self.bytes(index).map_or(0, read))
            .collect())
    }

    fn bytes(&self, index: u32) -> Option<&'a [u8]> {
        if let Some(sparse) = &self.sparse
            && let Ok(at) = sparse.indices.binary_search(&index)
        {
            return Some(sparse.values.at(at));
        }
        self.base.as_ref().map(|base| base.at(index as usize))
    }

    fn element<const N: usize>(&self, index: u32) -> [f32; N] {
        let Some(bytes) = self.bytes(index) else {
            return [0.0; N];
        };
        let components = self.components;
        let pick = |read: &dyn Fn(usize) -> f32| {
            std::array::from_fn(|i| if i < components { read(i) } else { 0.0 })
        };
        // Scales of section 3.11 (KHR_mesh_quantization uses the same).
        match (self.component, self.normalized) {
            (ComponentType::F32, _) => pick(&|i| {
                let b = &bytes[i * 4..i * 4 + 4];
                f32::from_le_bytes([b[0], b[1], b[2], b[3]])
            }),
            (ComponentType::U8, false) => pick(&|i| f32::from(bytes[i])),
            (ComponentType::U8, true) => pick(&|i| f32::from(bytes[i]) / 255.0),
            (ComponentType::I8, false) => pick(&|i| f32::from(bytes[i] as i8)),
            (ComponentType::I8, true) => pick(&|i| (f32::from(bytes[i] as i8) / 127.0).max(-1.0)),
            (ComponentType::U16, normalized) => pick(&|i| {
                let value = u16::from_le_bytes([bytes[i * 2], bytes[i * 2 + 1]]);
                f32::from(value) / if normalized { 65535.0 } else { 1.0 }
            }),
            (ComponentType::I16, false) => {
                pick(&|i| f32::from(i16::from_le_bytes([bytes[i * 2], bytes[i * 2 + 1]])))
            }
            (ComponentType::I16, true) => pick(&|i| {
                let value = i16::from_le_bytes([bytes[i * 2], bytes[i * 2 + 1]]);
                (f32::from(value) / 32767.0).max(-1.0)
            }),
            (ComponentType::U32, _) => pick(&|i| {
                let b = &bytes[i * 4..i * 4 + 4];
                u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32
            }),
        }
    }
}

impl<'a> Elements<'a> {
    fn at(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}
