//! The crate `wide`: what the program is compiled for, SSE2, NEON or simd128.

use wide::{f32x4, f32x8};

use super::{
    super::{Scene, build::Hierarchy, layout::TriangleBlock},
    Bundle, Candidate, Hit, Met, Ray, bundle,
    lanes::{Isa, Lanes, Word},
    levels,
    stack::Stack,
};

/// See [`levels::trace`].
#[inline(never)] // not into what chooses among the instruction sets
pub(super) fn trace<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    only: Option<u32>,
    filter: &impl Fn(&Candidate) -> bool,
) -> Option<Hit> {
    levels::trace::<Portable, ANY>(Portable, scene, ray, only, filter)
}

/// See [`bundle::trace`].
pub(super) fn trace_bundle(scene: &Scene, bundle: &Bundle, only: Option<u32>) -> Met {
    bundle::trace(Portable, scene, bundle, only)
}

#[derive(Clone, Copy)]
pub(super) struct Portable;

impl Isa for Portable {
    type F8 = F8;
    type F4 = F4;

    #[inline(never)]
    fn in_mesh<const ANY: bool>(
        self,
        mesh: &Hierarchy<TriangleBlock>,
        ray: &Ray,
        t_max: f32,
        stack: &mut Stack<'_>,
        instance: u32,
        hit: &mut Option<Hit>,
        filter: &impl Fn(&Candidate) -> bool,
    ) -> Option<f32> {
        levels::in_mesh::<Self, ANY>(self, mesh, ray, t_max, stack, instance, hit, filter)
    }

    #[inline(always)]
    fn twice(self, &[a, b, c, d]: &[f32; 4]) -> F8 {
        F8(f32x8::new([a, b, c, d, a, b, c, d]))
    }

    #[inline(always)]
    fn last_first(self, values: &[u32; 8], mask: u32, to: &mut [Word; 8]) {
        let mut at = 0;
        for (lane, &value) in values.iter().enumerate().rev() {
            if mask >> lane & 1 != 0 {
                to[at].write(value);
                at += 1;
            }
        }
    }
}

macro_rules! lanes {
    ($name:ident, $vector:ty, $n:literal) => {
        #[derive(Clone, Copy)]
        pub(super) struct $name($vector);

        #[rustfmt::skip]
        impl Lanes<$n> for $name {
            type Isa = Portable;
            type Mask = $vector;
            #[inline(always)] fn load(_: Portable, values: &[f32; $n]) -> Self { Self(<$vector>::new(*values)) }
            #[inline(always)] fn load_bits(_: Portable, values: &[u32; $n]) -> Self { Self(<$vector>::new(values.map(f32::from_bits))) }
            #[inline(always)] fn splat(_: Portable, value: f32) -> Self { Self(<$vector>::splat(value)) }
            #[inline(always)] fn to_array(self) -> [f32; $n] { self.0.to_array() }
            #[inline(always)] fn add(self, b: Self) -> Self { Self(self.0 + b.0) }
            #[inline(always)] fn sub(self, b: Self) -> Self { Self(self.0 - b.0) }
            #[inline(always)] fn mul(self, b: Self) -> Self { Self(self.0 * b.0) }
            #[inline(always)] fn later(self, b: Self) -> Self { Self(self.0.fast_max(b.0)) }
            #[inline(always)] fn earlier(self, b: Self) -> Self { Self(self.0.fast_min(b.0)) }
            #[inline(always)] fn not_after(self, b: Self) -> u32 { Self::mask_bits(self.le(b)) }
            #[inline(always)] fn mul_add(self, b: Self, c: Self) -> Self { Self(self.0.mul_add(b.0, c.0)) }
            #[inline(always)] fn xor(self, b: Self) -> Self { Self(self.0 ^ b.0) }
            #[inline(always)] fn and(self, b: Self) -> Self { Self(self.0 & b.0) }
            #[inline(always)] fn le(self, b: Self) -> $vector { self.0.simd_le(b.0) }
            #[inline(always)] fn lt(self, b: Self) -> $vector { self.0.simd_lt(b.0) }
            #[inline(always)] fn both(a: $vector, b: $vector) -> $vector { a & b }
            #[inline(always)] fn mask_bits(mask: $vector) -> u32 { mask.to_bitmask() as u32 }
            #[inline(always)] fn sign_bits(self) -> u32 { self.0.to_bitmask() as u32 }
        }
    };
}
lanes!(F8, f32x8, 8);
lanes!(F4, f32x4, 4);
