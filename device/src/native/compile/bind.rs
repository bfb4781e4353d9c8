//! Resources of a kernel: what it declares, and what it is given.

use std::sync::Arc;

use kernel_ir::{Binding, BindingKind};

use super::{BoundKernel, Kernel};
use crate::{
    HostFunction,
    native::{buffer::Buffer, image::Image},
};

/// What is bound.
#[derive(Debug, Clone)]
pub enum Resource {
    /// Bytes of a buffer.
    Buffer {
        /// The buffer.
        buffer: Buffer,
        /// The byte at which the binding starts: a multiple of four.
        offset: u64,
        /// Bytes of the binding.
        size: u64,
    },
    /// An image.
    Image(Image),
    /// A function of the program.
    Function(Arc<dyn HostFunction>),
}

impl From<Buffer> for Resource {
    /// All of it.
    fn from(buffer: Buffer) -> Self {
        Self::Buffer {
            size: buffer.size(),
            offset: 0,
            buffer,
        }
    }
}

impl From<Image> for Resource {
    fn from(image: Image) -> Self {
        Self::Image(image)
    }
}

impl From<Arc<dyn HostFunction>> for Resource {
    fn from(function: Arc<dyn HostFunction>) -> Self {
        Self::Function(function)
    }
}

/// Why a resource can't be bound.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// Nothing was given.
    #[error("nothing is bound to `{0}`")]
    Missing(String),
    /// An image where a buffer is declared, or the other way around; or numbers of another kind; or an array of layers
    /// where one image is declared; or a place that isn't a multiple of four or lies behind the buffer's end; or a
    /// function of other arguments.
    #[error("what is bound to `{0}` is not what it declares")]
    Mismatch(String),
    /// A buffer smaller than what is declared.
    #[error("`{name}` needs {least} bytes, and is bound to {bytes}")]
    TooSmall {
        /// The global.
        name: String,
        /// Bytes that it needs.
        least: u32,
        /// Bytes that are bound.
        bytes: u64,
    },
}

impl Kernel {
    /// Looks up a resource for each binding. The same memory may be bound more than once.
    ///
    /// # Errors
    /// If one is missing, or isn't what the text declares.
    pub fn bind(
        &self,
        mut resource: impl FnMut(&Binding) -> Option<Resource>,
    ) -> Result<BoundKernel, BindError> {
        let mut resources = Vec::new();
        for binding in self.bindings() {
            let found =
                resource(binding).ok_or_else(|| BindError::Missing(binding.name.clone()))?;
            check(binding, &found)?;
            resources.push(found);
        }
        Ok(BoundKernel::new(self.clone(), resources.into()))
    }
}

fn check(binding: &Binding, resource: &Resource) -> Result<(), BindError> {
    let mismatch = || BindError::Mismatch(binding.name.clone());
    match (binding.kind, resource) {
        (
            BindingKind::Buffer { least_bytes, .. },
            Resource::Buffer {
                buffer,
                offset,
                size,
            },
        ) => {
            let end = offset.checked_add(*size).ok_or_else(mismatch)?;
            if !offset.is_multiple_of(4) || end > buffer.size() {
                return Err(mismatch());
            }
            if *size < u64::from(least_bytes) {
                return Err(BindError::TooSmall {
                    name: binding.name.clone(),
                    least: least_bytes,
                    bytes: *size,
                });
            }
        }
        (
            BindingKind::Image {
                arrayed, scalar, ..
            },
            Resource::Image(image),
        ) => {
            let float = scalar == naga::ScalarKind::Float;
            if image.format().is_float() != float || (!arrayed && image.size()[2] > 1) {
                return Err(mismatch());
            }
        }
        (BindingKind::Function { words }, Resource::Function(function)) => {
            if words != function.words() {
                return Err(mismatch());
            }
        }
        _ => return Err(mismatch()),
    }
    Ok(())
}
