//! Where meshes stand in the world: transforms that can be used, and how many of them there may be.

use super::error::ImportError;
use glam::{Affine3A, DAffine3, Mat3A};
use std::path::Path;

/// Instances of a scene at most.
pub(super) const MAX_INSTANCES: usize = 1 << 22;

/// Whether a scene that a file is added to may have so many instances then.
pub(super) fn check_count(path: &Path, instances: usize) -> Result<(), ImportError> {
    if instances <= MAX_INSTANCES {
        return Ok(());
    }
    Err(ImportError::TooLarge {
        path: path.to_owned(),
        problem: format!(
            "the scene would have more than {MAX_INSTANCES} instances; join meshes or split the scene"
        ),
    })
}

/// The transform in single precision, where it has an inverse there.
pub(super) fn invertible(world: &DAffine3) -> Option<Affine3A> {
    let transform = Affine3A {
        matrix3: Mat3A::from_cols(
            world.matrix3.x_axis.as_vec3().into(),
            world.matrix3.y_axis.as_vec3().into(),
            world.matrix3.z_axis.as_vec3().into(),
        ),
        translation: world.translation.as_vec3().into(),
    };
    let usable = transform.is_finite()
        && transform.matrix3.determinant() != 0.0
        && transform.inverse().is_finite();
    usable.then_some(transform)
}
