//! Boxes along the axes, and the references to what they enclose, from which hierarchies are built.

use wide::f32x4;

/// A box. The fourth lane of both corners is free: [`Reference`] keeps an index there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub(super) low: f32x4,
    pub(super) high: f32x4,
}

impl Bounds {
    /// Nothing: inside out, so that whatever is added counts.
    pub(super) const EMPTY: Self = Self {
        low: f32x4::new([f32::INFINITY; 4]),
        high: f32x4::new([f32::NEG_INFINITY; 4]),
    };

    #[inline(always)]
    pub(super) fn union(self, other: Self) -> Self {
        Self {
            low: self.low.fast_min(other.low),
            high: self.high.fast_max(other.high),
        }
    }

    #[inline(always)]
    pub(super) fn with(self, point: f32x4) -> Self {
        Self {
            low: self.low.fast_min(point),
            high: self.high.fast_max(point),
        }
    }

    /// Half of the centre: of finite corners it is finite, and so is the difference of two.
    #[inline(always)]
    pub(super) fn half_centre(self) -> f32x4 {
        self.low * f32x4::splat(0.25) + self.high * f32x4::splat(0.25)
    }

    /// Half of the surface of a box that isn't empty, lengths in units of 1 / `scale`.
    #[inline(always)]
    pub(super) fn half_area(self, scale: f32) -> f32 {
        // Scaled first: the difference of two finite numbers needn't be finite.
        let scale = f32x4::splat(scale);
        let [x, y, z, _] = (self.high * scale - self.low * scale).to_array();
        x * y + y * z + z * x
    }

    /// A power of two that takes the box's longest side to 1/2 .. 2, or as near as there is one.
    pub(super) fn unit_scale(self) -> f32 {
        let quarter = f32x4::splat(0.25);
        let [x, y, z, _] = (self.high * quarter - self.low * quarter).to_array();
        let quarter_side = x.max(y).max(z);
        let exponent = quarter_side.to_bits() >> 23; // with a bias of 127
        f32::from_bits((252 - exponent.min(251)).min(253) << 23)
    }

    pub(super) fn corners(self) -> [[f32; 3]; 2] {
        [self.low, self.high].map(|corner| {
            let [x, y, z, _] = corner.to_array();
            [x, y, z]
        })
    }
}

/// A box and the index of what it encloses, which lies in the fourth lane of the lower corner, as the bits of an ordinary
/// number: arithmetic with denormal ones takes a hundred times as long.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reference(Bounds);

impl Reference {
    /// Of the index's bits: an exponent that it doesn't reach.
    const INDEX_BITS: u32 = 1 << 29;

    /// In place of one: there is nothing.
    pub(super) const NONE: Self = Self(Bounds::EMPTY);

    pub(super) fn is_none(&self) -> bool {
        self.0.low.to_array()[0] == f32::INFINITY
    }

    /// Around `points`, or `None` where one isn't finite. `index` is below 2^29.
    pub(super) fn around(index: u32, points: &[[f32; 3]]) -> Option<Self> {
        let mut bounds = Bounds::EMPTY;
        for &[x, y, z] in points {
            if !(x.is_finite() && y.is_finite() && z.is_finite()) {
                return None;
            }
            // Zeros have one sign, so that bounds don't depend on the order in which they are united.
            bounds = bounds.with(f32x4::new([x + 0.0, y + 0.0, z + 0.0, 0.0]));
        }
        let [x, y, z, _] = bounds.low.to_array();
        bounds.low = f32x4::new([x, y, z, f32::from_bits(index + Self::INDEX_BITS)]);
        Some(Self(bounds))
    }

    #[inline(always)]
    pub(super) fn index(&self) -> u32 {
        self.0.low.to_array()[3].to_bits() - Self::INDEX_BITS
    }

    #[inline(always)]
    pub(super) fn bounds(&self) -> Bounds {
        self.0
    }
}
