//! Axis-aligned boxes, as hierarchies are built over them.

use glam::{DVec3, Vec3A};

/// Nothing further from the origin than this is ever hit, metres: a triangle there has edges of at least an ulp, 2^41,
/// and its distance along a ray is a product of three such lengths, which single precision can't hold. Boxes end here,
/// so that neither their sizes nor a ray's distances to their sides overflow.
pub(super) const REACH: f32 = (1u128 << 64) as f32;

/// A box; its sides belong to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: Vec3A,
    pub(crate) high: Vec3A,
}

impl Bounds {
    /// Holds nothing; what it is joined with is the other.
    pub(crate) const EMPTY: Self = Self {
        low: Vec3A::splat(f32::MAX),
        high: Vec3A::splat(f32::MIN),
    };

    /// The smallest box around the points.
    pub(crate) fn around(points: impl IntoIterator<Item = Vec3A>) -> Self {
        points
            .into_iter()
            .map(|p| Self { low: p, high: p })
            .fold(Self::EMPTY, |a, b| a.union(&b))
    }

    /// The smallest box around both.
    pub(crate) fn union(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    /// Half of the surface's area.
    pub(crate) fn half_area(&self) -> f32 {
        let d = self.high - self.low;
        (d.x + d.y) * d.z + d.x * d.y
    }

    /// The middle.
    pub(crate) fn center(&self) -> Vec3A {
        self.low * 0.5 + self.high * 0.5
    }

    /// Length of each side, exact or nearly so.
    pub(crate) fn size(&self) -> DVec3 {
        self.high.as_dvec3() - self.low.as_dvec3()
    }

    /// The part within reach, and at the origin what is no number: neither can be hit beyond it.
    pub(crate) fn within_reach(&self) -> Self {
        let clip = |v: Vec3A| {
            Vec3A::select(v.is_nan_mask(), Vec3A::ZERO, v)
                .clamp(Vec3A::splat(-REACH), Vec3A::splat(REACH))
        };
        let (low, high) = (clip(self.low), clip(self.high));
        Self {
            low: low.min(high),
            high: low.max(high),
        }
    }
}
