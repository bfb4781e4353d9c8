//! What meshes of any format need: triangles that can be rendered, corners with values of their own, tangents, and parts
//! joined to one mesh.

pub(super) mod join;
pub(super) mod split;
pub(super) mod tangents;
pub(super) mod triangles;

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
