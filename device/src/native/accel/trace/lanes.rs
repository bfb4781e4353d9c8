//! Vectors of four and eight floats, as traversal uses them.

use std::mem::MaybeUninit;

use super::{
    super::{build::Hierarchy, layout::TriangleBlock},
    Candidate, Hit, Ray,
    stack::Stack,
};

/// An instruction set. A value of this type is proof that the processor has it: vectors are made by it alone, so that all
/// operations on vectors are safe.
pub(super) trait Isa: Copy {
    /// Eight floats, for the children of a node.
    type F8: Lanes<8, Isa = Self>;
    /// Four floats, for the triangles of a block.
    type F4: Lanes<4, Isa = Self>;

    /// [`levels::in_mesh`](super::levels::in_mesh), compiled for these instructions and not inlined.
    #[expect(clippy::too_many_arguments, reason = "as there")]
    fn in_mesh<const ANY: bool>(
        self,
        mesh: &Hierarchy<TriangleBlock>,
        ray: &Ray,
        t_max: f32,
        stack: &mut Stack<'_>,
        instance: u32,
        hit: &mut Option<Hit>,
        filter: &impl Fn(&Candidate) -> bool,
    ) -> Option<f32>;

    /// Four floats, and the same four again.
    fn twice(self, values: &[f32; 4]) -> Self::F8;

    /// Writes the values whose bits are in `mask`, the last of them first; what comes after them is anything.
    fn last_first(self, values: &[u32; 8], mask: u32, to: &mut [Word; 8]);
}

/// A word that is written.
pub(super) type Word = MaybeUninit<u32>;

/// A vector of `N` floats.
pub(super) trait Lanes<const N: usize>: Copy {
    type Isa: Copy;
    type Mask: Copy;

    fn load(isa: Self::Isa, values: &[f32; N]) -> Self;
    fn load_bits(isa: Self::Isa, values: &[u32; N]) -> Self;
    fn splat(isa: Self::Isa, value: f32) -> Self;
    fn to_array(self) -> [f32; N];

    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    /// `self * b + c`; whether it is rounded in between depends on the instruction set.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// The greater of numbers of which at most the lesser is negative: of two negative ones either. As bits, such numbers are
    /// in the order of integers, which processors compare in a quarter of the time.
    fn later(self, other: Self) -> Self;
    /// The lesser, or either of two negative ones.
    fn earlier(self, other: Self) -> Self;
    /// Where `self`, which isn't negative, isn't greater than `other`: a bit for each lane.
    fn not_after(self, other: Self) -> u32;

    fn xor(self, other: Self) -> Self;
    fn and(self, other: Self) -> Self;

    /// False where one of both is NaN, as `lt`.
    fn le(self, other: Self) -> Self::Mask;
    fn lt(self, other: Self) -> Self::Mask;
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// A bit for each lane.
    fn mask_bits(mask: Self::Mask) -> u32;
    /// The highest bit of each lane.
    fn sign_bits(self) -> u32;
}
