//! Eight numbers at once, by AVX2: what kernels that run eight invocations together are made of.
//!
//! Each function does in every lane what the scalar code of the same operation does, to the bit. A mask has all bits of a
//! lane set, or none. The names are those of the operations of `kernel_ir::ir`.

use core::arch::x86_64::*;
use core::mem::transmute;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use device::native::compile::{Format, ImageHeader, runtime};

/// Lanes.
pub(crate) const W: usize = 8;
/// Floats.
pub(crate) type F = __m256;
/// Words.
pub(crate) type I = __m256i;
/// A mask.
pub(crate) type M = __m256i;

/// 2^52: a double that it was added to has a whole number in its low bits.
const DOUBLE: f64 = 4_503_599_627_370_496.0;

/// Memory of the invocations' own: word by word, of each the lanes.
#[repr(C, align(32))]
pub(crate) struct Own<const WORDS: usize>(pub(crate) [[u32; W]; WORDS]);

/// What is set more than once. It is a union because rustc compares such locals with one another, and of thousands that takes
/// longer than all the rest.
#[derive(Clone, Copy)]
pub(crate) union Changing<T: Copy> {
    pub(crate) now: T,
}

/// Functions that are only called, and inlined, where the processor was asked.
macro_rules! vectors {
    ($($(#[$attribute:meta])* fn $name:ident($($parameter:ident: $ty:ty),* $(,)?) $(-> $result:ty)? $body:block)+) => {
        $(
            $(#[$attribute])*
            #[inline]
            #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
            pub(crate) unsafe fn $name($($parameter: $ty),*) $(-> $result)? { unsafe { $body } }
        )+
    };
}

// Masks, and numbers that are the same in all lanes.
vectors! {
    fn floats(x: f32) -> F { _mm256_set1_ps(x) }
    fn words(x: u32) -> I { _mm256_set1_epi32(x as i32) }
    fn mask(x: bool) -> M { _mm256_set1_epi32(-i32::from(x)) }
    fn none() -> M { _mm256_setzero_si256() }
    fn all() -> M { _mm256_set1_epi32(-1) }
    fn and(a: M, b: M) -> M { _mm256_and_si256(a, b) }
    fn or(a: M, b: M) -> M { _mm256_or_si256(a, b) }
    /// `a` where not `b`.
    fn without(a: M, b: M) -> M { _mm256_andnot_si256(b, a) }
    fn any(m: M) -> bool { _mm256_testz_si256(m, m) == 0 }
    fn bits(m: M) -> u32 { _mm256_movemask_ps(_mm256_castsi256_ps(m)) as u32 }
    fn select_f(m: M, x: F, y: F) -> F { _mm256_blendv_ps(y, x, _mm256_castsi256_ps(m)) }
    fn select_i(m: M, x: I, y: I) -> I {
        _mm256_castps_si256(select_f(m, _mm256_castsi256_ps(x), _mm256_castsi256_ps(y)))
    }
    fn select_m(m: M, x: M, y: M) -> M { select_i(m, x, y) }
    fn array(a: I) -> [u32; W] { transmute(a) }
    fn of_array(a: [u32; W]) -> I { transmute(a) }
    /// `first`, and those that follow.
    fn count_from(first: u32) -> I { _mm256_add_epi32(words(first), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)) }
}

// Of one number.
vectors! {
    fn float_negate(a: F) -> F { _mm256_xor_ps(a, floats(-0.0)) }
    fn float_abs(a: F) -> F { _mm256_andnot_ps(floats(-0.0), a) }
    fn sqrt(a: F) -> F { _mm256_sqrt_ps(a) }
    fn floor(a: F) -> F { _mm256_floor_ps(a) }
    fn ceil(a: F) -> F { _mm256_ceil_ps(a) }
    fn truncate(a: F) -> F { _mm256_round_ps::<{ _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC }>(a) }
    fn nearest(a: F) -> F { _mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(a) }
    fn float_to_signed(a: F) -> I {
        // What doesn't fit comes out as the least number.
        let high = float_greater_equal(a, floats(2_147_483_648.0));
        and(_mm256_xor_si256(_mm256_cvttps_epi32(a), high), float_equal(a, a))
    }
    fn float_to_unsigned(a: F) -> I {
        // The maximum makes zero of what isn't a number.
        let a = _mm256_max_ps(a, floats(0.0));
        let half = floats(2_147_483_648.0);
        let high = float_greater_equal(a, half);
        let low = _mm256_sub_ps(a, _mm256_and_ps(_mm256_castsi256_ps(high), half));
        let low = _mm256_xor_si256(_mm256_cvttps_epi32(low), _mm256_slli_epi32::<31>(high));
        or(low, float_greater_equal(a, floats(4_294_967_296.0)))
    }
    fn signed_to_float(a: I) -> F { _mm256_cvtepi32_ps(a) }
    fn unsigned_to_float(a: I) -> F {
        // Only the sum rounds.
        let high = _mm256_cvtepi32_ps(_mm256_srli_epi32::<16>(a));
        let low = _mm256_cvtepi32_ps(and(a, words(0xffff)));
        _mm256_add_ps(_mm256_mul_ps(high, floats(65536.0)), low)
    }
    fn float_bits(a: F) -> I { _mm256_castps_si256(a) }
    fn bits_to_float(a: I) -> F { _mm256_castsi256_ps(a) }
    fn int_negate(a: I) -> I { _mm256_sub_epi32(none(), a) }
    fn int_not(a: I) -> I { _mm256_xor_si256(a, all()) }
    fn bool_not(a: M) -> M { _mm256_xor_si256(a, all()) }
    fn bool_to_int(a: M) -> I { _mm256_srli_epi32::<31>(a) }
    fn int_to_bool(a: I) -> M { not_equal(a, none()) }
    fn leading_zeros(a: I) -> I { of_array(array(a).map(u32::leading_zeros)) }
    fn trailing_zeros(a: I) -> I { of_array(array(a).map(u32::trailing_zeros)) }
    fn count_ones(a: I) -> I { of_array(array(a).map(u32::count_ones)) }
    fn reverse_bits(a: I) -> I {
        let bytes = _mm256_setr_epi8(
            3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12,
        );
        let a = _mm256_shuffle_epi8(a, bytes);
        let four = _mm256_set1_epi8(15);
        let reversed = _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15));
        let low = _mm256_shuffle_epi8(reversed, and(a, four));
        let high = _mm256_shuffle_epi8(reversed, and(_mm256_srli_epi32::<4>(a), four));
        or(_mm256_slli_epi32::<4>(low), high)
    }
}

// Of two.
vectors! {
    fn float_add(a: F, b: F) -> F { _mm256_add_ps(a, b) }
    fn float_subtract(a: F, b: F) -> F { _mm256_sub_ps(a, b) }
    fn float_multiply(a: F, b: F) -> F { _mm256_mul_ps(a, b) }
    fn float_divide(a: F, b: F) -> F { _mm256_div_ps(a, b) }
    fn float_min(a: F, b: F) -> F { _mm256_min_ps(a, b) }
    fn float_max(a: F, b: F) -> F { _mm256_max_ps(a, b) }
    fn add(a: I, b: I) -> I { _mm256_add_epi32(a, b) }
    fn subtract(a: I, b: I) -> I { _mm256_sub_epi32(a, b) }
    fn multiply(a: I, b: I) -> I { _mm256_mullo_epi32(a, b) }
    fn unsigned_divide(a: I, b: I) -> I {
        let half = |a: __m128i, b: __m128i| {
            let quotient = _mm256_floor_pd(_mm256_div_pd(unsigned_to_double(a), unsigned_to_double(b)));
            // Its low bits are the number.
            let bits = _mm256_castpd_ps(_mm256_add_pd(quotient, _mm256_set1_pd(DOUBLE)));
            _mm_castps_si128(_mm_shuffle_ps::<0b10_00_10_00>(_mm256_castps256_ps128(bits), _mm256_extractf128_ps::<1>(bits)))
        };
        halves(a, b, half)
    }
    fn unsigned_remainder(a: I, b: I) -> I { subtract(a, multiply(unsigned_divide(a, b), b)) }
    fn signed_divide(a: I, b: I) -> I {
        halves(a, b, |a, b| _mm256_cvttpd_epi32(_mm256_div_pd(_mm256_cvtepi32_pd(a), _mm256_cvtepi32_pd(b))))
    }
    fn signed_remainder(a: I, b: I) -> I { subtract(a, multiply(signed_divide(a, b), b)) }
    fn unsigned_to_double(a: __m128i) -> __m256d {
        let bits = or(_mm256_cvtepu32_epi64(a), _mm256_castpd_si256(_mm256_set1_pd(DOUBLE)));
        _mm256_sub_pd(_mm256_castsi256_pd(bits), _mm256_set1_pd(DOUBLE))
    }
    /// Quotients as doubles: no whole number of 32 bits is so near to another that they would round to it.
    fn halves(a: I, b: I, does: impl Fn(__m128i, __m128i) -> __m128i) -> I {
        let low = does(_mm256_castsi256_si128(a), _mm256_castsi256_si128(b));
        let high = does(_mm256_extracti128_si256::<1>(a), _mm256_extracti128_si256::<1>(b));
        _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(low), high)
    }
    fn xor(a: I, b: I) -> I { _mm256_xor_si256(a, b) }
    fn shift_left(a: I, b: I) -> I { _mm256_sllv_epi32(a, and(b, words(31))) }
    fn unsigned_shift_right(a: I, b: I) -> I { _mm256_srlv_epi32(a, and(b, words(31))) }
    fn signed_shift_right(a: I, b: I) -> I { _mm256_srav_epi32(a, and(b, words(31))) }
    fn unsigned_min(a: I, b: I) -> I { _mm256_min_epu32(a, b) }
    fn unsigned_max(a: I, b: I) -> I { _mm256_max_epu32(a, b) }
    fn signed_min(a: I, b: I) -> I { _mm256_min_epi32(a, b) }
    fn signed_max(a: I, b: I) -> I { _mm256_max_epi32(a, b) }
    fn bool_and(a: M, b: M) -> M { and(a, b) }
    fn bool_or(a: M, b: M) -> M { or(a, b) }
    fn bool_xor(a: M, b: M) -> M { xor(a, b) }
    fn float_equal(a: F, b: F) -> M { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_EQ_OQ>(a, b)) }
    fn float_not_equal(a: F, b: F) -> M { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_NEQ_UQ>(a, b)) }
    fn float_less(a: F, b: F) -> M { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b)) }
    fn float_less_equal(a: F, b: F) -> M { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) }
    fn float_greater(a: F, b: F) -> M { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_GT_OQ>(a, b)) }
    fn float_greater_equal(a: F, b: F) -> M { _mm256_castps_si256(_mm256_cmp_ps::<_CMP_GE_OQ>(a, b)) }
    fn equal(a: I, b: I) -> M { _mm256_cmpeq_epi32(a, b) }
    fn not_equal(a: I, b: I) -> M { bool_not(equal(a, b)) }
    fn unsigned_less(a: I, b: I) -> M { bool_not(unsigned_greater_equal(a, b)) }
    fn unsigned_less_equal(a: I, b: I) -> M { equal(unsigned_min(a, b), a) }
    fn unsigned_greater(a: I, b: I) -> M { bool_not(unsigned_less_equal(a, b)) }
    fn unsigned_greater_equal(a: I, b: I) -> M { equal(unsigned_max(a, b), a) }
    fn signed_less(a: I, b: I) -> M { _mm256_cmpgt_epi32(b, a) }
    fn signed_less_equal(a: I, b: I) -> M { bool_not(_mm256_cmpgt_epi32(a, b)) }
    fn signed_greater(a: I, b: I) -> M { _mm256_cmpgt_epi32(a, b) }
    fn signed_greater_equal(a: I, b: I) -> M { bool_not(_mm256_cmpgt_epi32(b, a)) }
}

// Functions of numbers, of one lane after the other.
vectors! {
    fn call_1(does: extern "C" fn(f32) -> f32, a: F, m: M) -> F {
        let mut a = array(float_bits(a));
        lanes(m, |lane| a[lane] = does(f32::from_bits(a[lane])).to_bits());
        bits_to_float(of_array(a))
    }
    fn call_2(does: extern "C" fn(f32, f32) -> f32, a: F, b: F, m: M) -> F {
        let (mut a, b) = (array(float_bits(a)), array(float_bits(b)));
        lanes(m, |lane| a[lane] = does(f32::from_bits(a[lane]), f32::from_bits(b[lane])).to_bits());
        bits_to_float(of_array(a))
    }
    /// What `does` makes of the words, which stand for what it takes.
    fn call_words(a: I, b: I, m: M, does: impl Fn(u32, u32) -> u32) -> I {
        let (mut a, b) = (array(a), array(b));
        lanes(m, |lane| a[lane] = does(a[lane], b[lane]));
        of_array(a)
    }
    /// The lanes of a mask, from the first.
    fn lanes(m: M, does: impl FnMut(usize)) {
        let mut does = does;
        let mut left = bits(m);
        while left != 0 {
            does(left.trailing_zeros() as usize & 7);
            left &= left - 1;
        }
    }
}

// Memory: lanes that aren't in the mask write nothing; what they read comes from the place without an offset.
vectors! {
    fn offsets(o: I, m: M) -> [u32; W] { array(and(o, m)) }
    fn gather(p: *const u8, o: I, m: M) -> I {
        let o = offsets(o, m);
        let word = |lane: usize| p.add(o[lane] as usize).cast::<i32>().read();
        _mm256_setr_epi32(word(0), word(1), word(2), word(3), word(4), word(5), word(6), word(7))
    }
    fn gather_atomic(p: *const u8, o: I, m: M) -> I {
        let o = offsets(o, m);
        of_array(o.map(|o| AtomicU32::from_ptr(p.add(o as usize).cast_mut().cast()).load(Relaxed)))
    }
    /// Two words that follow each other.
    fn gather_2(p: *const u8, o: I, m: M) -> (I, I) {
        let o = offsets(o, m);
        let two = |lane: usize| _mm_loadl_epi64(p.add(o[lane] as usize).cast());
        let four = |a: usize, b: usize| _mm_unpacklo_epi32(two(a), two(b)); // a0 b0 a1 b1
        let low = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(0, 1)), four(4, 5));
        let high = _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(2, 3)), four(6, 7));
        (_mm256_unpacklo_epi64(low, high), _mm256_unpackhi_epi64(low, high))
    }
    /// Four words that follow each other.
    fn gather_4(p: *const u8, o: I, m: M) -> (I, I, I, I) {
        let o = offsets(o, m);
        let four = |lane: usize| _mm_loadu_si128(p.add(o[lane] as usize).cast());
        let both = |lane: usize| _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(lane)), four(lane + 4));
        let (a, b, c, d) = (both(0), both(1), both(2), both(3));
        transposed(a, b, c, d)
    }
    /// Within each half: rows for columns.
    fn transposed(a: I, b: I, c: I, d: I) -> (I, I, I, I) {
        let (ab, cd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpacklo_epi32(c, d));
        let (x, y) = (_mm256_unpacklo_epi64(ab, cd), _mm256_unpackhi_epi64(ab, cd));
        let (ab, cd) = (_mm256_unpackhi_epi32(a, b), _mm256_unpackhi_epi32(c, d));
        (x, y, _mm256_unpacklo_epi64(ab, cd), _mm256_unpackhi_epi64(ab, cd))
    }
    fn scatter(p: *mut u8, o: I, x: I, m: M) {
        let (o, x) = (array(o), array(x));
        lanes(m, |lane| p.add(o[lane] as usize).cast::<u32>().write(x[lane]));
    }
    fn scatter_atomic(p: *mut u8, o: I, x: I, m: M) {
        let (o, x) = (array(o), array(x));
        lanes(m, |lane| AtomicU32::from_ptr(p.add(o[lane] as usize).cast()).store(x[lane], Relaxed));
    }
    /// Four words that follow each other.
    fn scatter_4(p: *mut u8, o: I, x: I, y: I, z: I, w: I, m: M) {
        let o = array(o);
        let (a, b, c, d) = transposed(x, y, z, w);
        let all: [[u32; 4]; W] = transmute([a, b, c, d]);
        // Lane 4 stands behind lane 0, and so on.
        lanes(m, |lane| p.add(o[lane] as usize).cast::<[u32; 4]>().write_unaligned(all[2 * (lane & 3) + (lane >> 2)]));
    }
    /// A row of what was handed over.
    fn row(rows: *const u8, number: usize) -> I { _mm256_loadu_si256(rows.cast::<I>().add(number)) }
    fn own_load(p: *const u8) -> I { _mm256_load_si256(p.cast()) }
    /// Nobody else looks, and a store under a mask takes longer than all of it once more: it is what the compiler would make
    /// of any other load.
    fn own_store(p: *mut u8, x: I, m: M) { _mm256_store_si256(p.cast(), select_i(m, x, p.cast::<I>().read_volatile())) }
    /// Of the words at these bytes of each lane's own memory, the bytes in all of it.
    fn own_offsets(o: I) -> I { _mm256_add_epi32(_mm256_slli_epi32::<3>(o), _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28)) }
}

// What the program's functions do to memory.
vectors! {
    fn own_zero(target: *mut u8, bytes: u32, m: M) {
        for word in 0..bytes as usize / 4 {
            own_store(target.add(4 * W * word), none(), m);
        }
    }
    fn own_copy(target: *mut u8, source: *const u8, bytes: u32, m: M) {
        for word in 0..bytes as usize / 4 {
            own_store(target.add(4 * W * word), words(source.cast::<u32>().add(word).read()), m);
        }
    }
    /// As `runtime::load_texel`, whose four words of each lane come into its own memory.
    fn load_texel(header: *const u8, texel: I, target: *mut u8, m: M) {
        let header = header.cast::<ImageHeader>().read();
        let mut store = |word: usize, x: I| own_store(target.add(4 * W * word), x, m);
        // An image has no more texels than 32 bits count, but more bytes. Lanes that aren't in the mask read the first.
        let texels = array(and(texel, m));
        if matches!(header.format, Format::Rgba32Float | Format::Rgba32Uint) {
            let all = header.texels.cast::<__m128i>();
            let four = |lane: usize| _mm_loadu_si128(all.add(texels[lane] as usize));
            let both = |lane: usize| _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(four(lane)), four(lane + 4));
            let (x, y, z, w) = transposed(both(0), both(1), both(2), both(3));
            [x, y, z, w].into_iter().enumerate().for_each(|(word, words)| store(word, words));
            return;
        }
        let texels = texels.map(|texel| header.texels.add(texel as usize).read());
        let bytes = of_array(texels);
        let byte = |number: i32| and(_mm256_srl_epi32(bytes, _mm_cvtsi32_si128(8 * number)), words(255));
        let unit = |byte: I| float_bits(_mm256_mul_ps(_mm256_cvtepi32_ps(byte), floats(1.0 / 255.0)));
        if header.format == Format::Rgba8Unorm {
            (0..3).for_each(|number| store(number as usize, unit(byte(number))));
        } else {
            let table = runtime::srgb();
            let light = |byte: I| of_array(array(byte).map(|byte| table[byte as usize & 255].to_bits()));
            (0..3).for_each(|number| store(number as usize, light(byte(number))));
        }
        store(3, unit(byte(3)));
    }
}

/// As `runtime::host`, for each lane of a mask: `TAKEN` and `GIVEN` words are in its own memory.
#[inline]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(crate) unsafe fn host<const TAKEN: usize, const GIVEN: usize>(
    bound: *const u8,
    taken: *const u8,
    given: *mut u8,
    m: M,
) {
    let (taken, given) = (taken.cast::<u32>(), given.cast::<u32>());
    let (mut arguments, mut result) = ([0; TAKEN], [0; GIVEN]);
    // SAFETY: the caller's: `bound` is a function that was bound, and lanes have so many words of their own.
    unsafe {
        lanes(m, |lane| {
            for (word, argument) in arguments.iter_mut().enumerate() {
                *argument = taken.add(W * word + lane).read();
            }
            runtime::host(
                bound.cast(),
                arguments.as_ptr(),
                TAKEN as u32,
                result.as_mut_ptr(),
                GIVEN as u32,
            );
            for (word, result) in result.iter().enumerate() {
                given.add(W * word + lane).write(*result);
            }
        });
    }
}

// Atomic operations: those of the lanes happen one after the other, from the first.
vectors! {
    fn add_same(p: *mut u8, x: u32, m: M) -> I {
        let bits = bits(m);
        let sum = x.wrapping_mul(bits.count_ones());
        let found = AtomicU32::from_ptr(p.cast()).fetch_add(sum, Relaxed);
        let before = _mm256_setr_epi32(0x00, 0x01, 0x03, 0x07, 0x0f, 0x1f, 0x3f, 0x7f);
        // Bits of lanes before each, counted by a table of nibbles.
        let before = and(words(bits), before);
        let table = _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
        let low = and(before, words(15));
        let count = _mm256_add_epi32(
            and(_mm256_shuffle_epi8(table, low), words(15)),
            and(_mm256_shuffle_epi8(table, _mm256_srli_epi32::<4>(before)), words(15)),
        );
        _mm256_add_epi32(words(found), _mm256_mullo_epi32(words(x), count))
    }
    fn atomic(p: *mut u8, o: I, x: I, m: M, does: impl Fn(&AtomicU32, u32) -> u32) -> I {
        let (o, mut x) = (array(o), array(x));
        lanes(m, |lane| x[lane] = does(AtomicU32::from_ptr(p.add(o[lane] as usize).cast()), x[lane]));
        of_array(x)
    }
    fn compare_exchange(p: *mut u8, o: I, expected: I, x: I, m: M) -> I {
        let (o, expected, mut x) = (array(o), array(expected), array(x));
        lanes(m, |lane| {
            let word = AtomicU32::from_ptr(p.add(o[lane] as usize).cast());
            let outcome = word.compare_exchange(expected[lane], x[lane], Relaxed, Relaxed);
            x[lane] = outcome.unwrap_or_else(|found| found);
        });
        of_array(x)
    }
}
