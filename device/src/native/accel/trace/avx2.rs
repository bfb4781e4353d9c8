//! x86-64 with AVX2 and FMA.

use std::arch::x86_64::*;

use super::{
    super::{Scene, build::Hierarchy, layout::TriangleBlock},
    Bundle, Candidate, Hit, Met, Ray, bundle,
    lanes::{Isa, Lanes, Word},
    levels,
    stack::Stack,
};

/// Whether [`trace`] may be called.
pub(super) fn is_available() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

/// See [`levels::trace`]; where [`is_available`].
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn trace<const ANY: bool>(
    scene: &Scene,
    ray: &Ray,
    only: Option<u32>,
    filter: &impl Fn(&Candidate) -> bool,
) -> Option<Hit> {
    levels::trace::<Avx2, ANY>(Avx2(()), scene, ray, only, filter)
}

/// See [`bundle::trace`]; where [`is_available`].
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn trace_bundle(scene: &Scene, bundle: &Bundle, only: Option<u32>) -> Met {
    bundle::trace(Avx2(()), scene, bundle, only)
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
#[expect(clippy::too_many_arguments, reason = "as in `levels`")]
fn in_mesh<const ANY: bool>(
    isa: Avx2,
    mesh: &Hierarchy<TriangleBlock>,
    ray: &Ray,
    t_max: f32,
    stack: &mut Stack<'_>,
    instance: u32,
    hit: &mut Option<Hit>,
    filter: &impl Fn(&Candidate) -> bool,
) -> Option<f32> {
    levels::in_mesh::<Avx2, ANY>(isa, mesh, ray, t_max, stack, instance, hit, filter)
}

/// An intrinsic of the features above. That each is inlined into `trace`, whose features it has, is what `inline(always)` is
/// for.
macro_rules! intrinsic {
    ($call:expr) => {{
        // SAFETY: a vector exists only where there is an `Avx2`, and that only where the processor has these features. What
        // is loaded and stored are arrays of the vector's size.
        unsafe { $call }
    }};
}

/// Made by [`trace`] alone.
#[derive(Clone, Copy)]
pub(super) struct Avx2(());

impl Isa for Avx2 {
    type F8 = F8;
    type F4 = F4;

    #[inline(always)]
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
        // SAFETY: the value exists, so the processor has these features.
        unsafe { in_mesh::<ANY>(self, mesh, ray, t_max, stack, instance, hit, filter) }
    }

    #[inline(always)]
    fn twice(self, values: &[f32; 4]) -> F8 {
        intrinsic!(F8(_mm256_broadcast_ps(&*values.as_ptr().cast())))
    }

    #[inline(always)]
    fn last_first(self, values: &[u32; 8], mask: u32, to: &mut [Word; 8]) {
        let lanes = &LAST_FIRST[mask as usize & 0xff];
        intrinsic!({
            let lanes = _mm256_cvtepu8_epi32(_mm_loadl_epi64(lanes.as_ptr().cast()));
            let values = _mm256_loadu_si256(values.as_ptr().cast());
            let ordered = _mm256_permutevar8x32_epi32(values, lanes);
            _mm256_storeu_si256(to.as_mut_ptr().cast(), ordered);
        });
    }
}

/// For each mask the lanes whose bits it has, the last of them first.
static LAST_FIRST: [[u8; 8]; 256] = {
    let mut all = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut at) = (8, 0);
        while lane > 0 {
            lane -= 1;
            if mask >> lane & 1 != 0 {
                all[mask][at] = lane as u8;
                at += 1;
            }
        }
        mask += 1;
    }
    all
};

macro_rules! lanes {
    ($name:ident, $n:literal, $vector:ty, $load:ident, $store:ident, $splat:ident, $add:ident, $sub:ident,
     $mul:ident, $fma:ident, $xor:ident, $and:ident, $signs:ident,
     $bits:ident, $of_bits:ident, $earlier:ident, $later:ident, $after:ident,
     |$a:ident, $b:ident| le $le:expr, lt $lt:expr) => {
        #[derive(Clone, Copy)]
        pub(super) struct $name($vector);

        #[rustfmt::skip]
        impl Lanes<$n> for $name {
            type Isa = Avx2;
            type Mask = $vector;
            #[inline(always)] fn load(_: Avx2, values: &[f32; $n]) -> Self { intrinsic!(Self($load(values.as_ptr()))) }
            #[inline(always)] fn load_bits(_: Avx2, values: &[u32; $n]) -> Self { intrinsic!(Self($load(values.as_ptr().cast()))) }
            #[inline(always)] fn splat(_: Avx2, value: f32) -> Self { intrinsic!(Self($splat(value))) }
            #[inline(always)] fn to_array(self) -> [f32; $n] {
                let mut values = [0.0; $n];
                intrinsic!($store(values.as_mut_ptr(), self.0));
                values
            }
            #[inline(always)] fn add(self, b: Self) -> Self { intrinsic!(Self($add(self.0, b.0))) }
            #[inline(always)] fn sub(self, b: Self) -> Self { intrinsic!(Self($sub(self.0, b.0))) }
            #[inline(always)] fn mul(self, b: Self) -> Self { intrinsic!(Self($mul(self.0, b.0))) }
            #[inline(always)] fn mul_add(self, b: Self, c: Self) -> Self { intrinsic!(Self($fma(self.0, b.0, c.0))) }
            #[inline(always)] fn later(self, b: Self) -> Self { intrinsic!(Self($of_bits($later($bits(self.0), $bits(b.0))))) }
            #[inline(always)] fn earlier(self, b: Self) -> Self { intrinsic!(Self($of_bits($earlier($bits(self.0), $bits(b.0))))) }
            #[inline(always)] fn not_after(self, b: Self) -> u32 {
                let after = intrinsic!($signs($of_bits($after($bits(self.0), $bits(b.0)))));
                after as u32 ^ ((1 << $n) - 1)
            }
            #[inline(always)] fn xor(self, b: Self) -> Self { intrinsic!(Self($xor(self.0, b.0))) }
            #[inline(always)] fn and(self, b: Self) -> Self { intrinsic!(Self($and(self.0, b.0))) }
            #[inline(always)] fn le(self, b: Self) -> $vector { let ($a, $b) = (self.0, b.0); intrinsic!($le) }
            #[inline(always)] fn lt(self, b: Self) -> $vector { let ($a, $b) = (self.0, b.0); intrinsic!($lt) }
            #[inline(always)] fn both(a: $vector, b: $vector) -> $vector { intrinsic!($and(a, b)) }
            #[inline(always)] fn mask_bits(mask: $vector) -> u32 { intrinsic!($signs(mask)) as u32 }
            #[inline(always)] fn sign_bits(self) -> u32 { intrinsic!($signs(self.0)) as u32 }
        }
    };
}

lanes!(F8, 8, __m256, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_set1_ps, _mm256_add_ps, _mm256_sub_ps,
    _mm256_mul_ps, _mm256_fmadd_ps, _mm256_xor_ps, _mm256_and_ps,
    _mm256_movemask_ps,
    _mm256_castps_si256, _mm256_castsi256_ps, _mm256_min_epi32, _mm256_max_epi32, _mm256_cmpgt_epi32,
    |a, b| le _mm256_cmp_ps::<_CMP_LE_OQ>(a, b), lt _mm256_cmp_ps::<_CMP_LT_OQ>(a, b));
lanes!(F4, 4, __m128, _mm_loadu_ps, _mm_storeu_ps, _mm_set1_ps, _mm_add_ps, _mm_sub_ps,
    _mm_mul_ps, _mm_fmadd_ps, _mm_xor_ps, _mm_and_ps,
    _mm_movemask_ps,
    _mm_castps_si128, _mm_castsi128_ps, _mm_min_epi32, _mm_max_epi32, _mm_cmpgt_epi32,
    |a, b| le _mm_cmple_ps(a, b), lt _mm_cmplt_ps(a, b));
