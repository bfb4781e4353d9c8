//! What meshes of any format need: triangles that can be rendered, corners with values of their own, normals, tangents, and
//! parts joined to one mesh.

pub(super) mod join;
pub(super) mod normals;
pub(super) mod split;
pub(super) mod tangents;
pub(super) mod triangles;

use super::error::Warnings;
use crate::Mesh;

/// What a vertex costs with all its attributes but the custom ones.
pub(super) const VERTEX_BYTES: u64 = 72;
/// What a custom attribute of a vertex costs.
pub(super) const VALUE_BYTES: u64 = 16;

/// Counts of triangles and values that could not be used.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Dropped {
    pub(super) degenerate: u64,
    pub(super) non_finite: u64,
    pub(super) bad_values: u64,
}

impl Dropped {
    pub(super) fn add(&mut self, other: Self) {
        self.degenerate += other.degenerate;
        self.non_finite += other.non_finite;
        self.bad_values += other.bad_values;
    }
}

/// What a vertex of the mesh costs.
fn vertex_bytes(mesh: &Mesh) -> u64 {
    VERTEX_BYTES + VALUE_BYTES * mesh.custom.len() as u64
}

/// One warning for each kind of what was left out of meshes, with the number and the first mesh concerned.
pub(super) fn warn_of_dropped<'m>(
    meshes: impl Iterator<Item = (&'m str, Dropped)> + Clone,
    warnings: &mut Warnings,
) {
    let mut warn = |count: fn(&Dropped) -> u64, what: &str| {
        let total: u64 = meshes.clone().map(|(_, dropped)| count(&dropped)).sum();
        let first = meshes.clone().find(|(_, dropped)| count(dropped) > 0);
        if let Some((name, _)) = first {
            warnings.push(format!("{total} {what} (first in mesh \"{name}\")"));
        }
    };
    warn(
        |d| d.degenerate,
        "degenerate triangles (without area) were left out",
    );
    warn(
        |d| d.non_finite,
        "triangles with infinite or NaN positions were left out",
    );
    warn(
        |d| d.bad_values,
        "normals, colours or texture coordinates could not be used and were replaced",
    );
}
