//! What compiled kernels call that run eight invocations at once: each function takes an address and rows of eight words, of
//! which the last is the mask of the lanes that it is for. The lanes follow one another, from the first.

use std::sync::{
    Arc,
    atomic::{AtomicI32, AtomicU32, Ordering::Relaxed},
};

use crate::{
    HostFunction,
    native::compile::{
        ImageHeader,
        ir::{AtomicOperation, Runtime},
    },
};

/// Of each lane a word.
type Row = [u32; 8];

/// (what is worked on, rows)
pub(in super::super) type Helper = unsafe extern "C" fn(*mut u8, *mut Row);

/// Does something for each lane of a mask.
fn lanes(mask: &Row, mut does: impl FnMut(usize)) {
    for (lane, &is_set) in mask.iter().enumerate() {
        if is_set != 0 {
            does(lane);
        }
    }
}

/// Puts a word where the mask is set; all of a row is written, for it belongs to these lanes alone.
fn fill(row: &mut Row, word: u32, mask: &Row) {
    for (target, &is_set) in row.iter_mut().zip(mask) {
        *target = if is_set != 0 { word } else { *target };
    }
}

/// Rows that machine code has written.
///
/// # Safety
/// There are so many, and nothing else uses them.
unsafe fn rows<'a, const N: usize>(rows: *mut Row) -> &'a mut [Row; N] {
    // SAFETY: the caller's; machine code aligns its stack to 16 bytes.
    unsafe { &mut *rows.cast() }
}

/// Offsets, words, mask: stores the words.
///
/// # Safety
/// There is a word at each offset behind the address that a lane of the mask has.
pub(in super::super) unsafe extern "C" fn scatter(base: *mut u8, given: *mut Row) {
    // SAFETY: the caller's.
    unsafe {
        let [offsets, words, mask] = rows::<3>(given);
        lanes(mask, |lane| {
            base.add(offsets[lane] as usize)
                .cast::<u32>()
                .write(words[lane]);
        });
    }
}

/// Offsets, four rows of words, mask: stores the words that lanes have in these rows one behind the other.
///
/// # Safety
/// There are four words at each offset behind the address that a lane of the mask has.
pub(in super::super) unsafe extern "C" fn scatter_four(base: *mut u8, given: *mut Row) {
    // SAFETY: the caller's.
    unsafe {
        let [offsets, x, y, z, w, mask] = rows::<6>(given);
        lanes(mask, |lane| {
            base.add(offsets[lane] as usize)
                .cast::<[u32; 4]>()
                .write([x[lane], y[lane], z[lane], w[lane]]);
        });
    }
}

/// As [`scatter`], each word in one piece.
///
/// # Safety
/// As [`scatter`].
pub(in super::super) unsafe extern "C" fn scatter_atomic(base: *mut u8, given: *mut Row) {
    // SAFETY: the caller's.
    unsafe {
        let [offsets, words, mask] = rows::<3>(given);
        lanes(mask, |lane| {
            word(base, offsets[lane]).store(words[lane], Relaxed)
        });
    }
}

/// # Safety
/// There is a word, which lives.
unsafe fn word<'a>(base: *mut u8, offset: u32) -> &'a AtomicU32 {
    // SAFETY: the caller's.
    unsafe { AtomicU32::from_ptr(base.add(offset as usize).cast()) }
}

/// Offsets, expected words, new words, mask; what was there comes into the first row.
///
/// # Safety
/// As [`scatter`].
pub(in super::super) unsafe extern "C" fn compare_exchange(base: *mut u8, given: *mut Row) {
    // SAFETY: the caller's.
    unsafe {
        let [offsets, expected, words, mask] = rows::<4>(given);
        lanes(mask, |lane| {
            let word = word(base, offsets[lane]);
            let found = word.compare_exchange(expected[lane], words[lane], Relaxed, Relaxed);
            offsets[lane] = found.unwrap_or_else(|found| found);
        });
    }
}

/// Texels, mask; four rows come of it.
///
/// # Safety
/// `header` is that of an image whose texels live, and the texels of lanes in the mask are its own; there is room for four rows.
pub(in super::super) unsafe extern "C" fn load_texel(header: *mut u8, given: *mut Row) {
    // SAFETY: the caller's.
    unsafe {
        let [texels, mask] = *rows::<2>(given);
        let words = rows::<4>(given);
        lanes(&mask, |lane| {
            let mut four = [0; 4];
            super::load_texel(header.cast::<ImageHeader>(), texels[lane], &mut four);
            for (row, word) in words.iter_mut().zip(four) {
                row[lane] = word;
            }
        });
    }
}

/// Fills words of lanes' own memory with zeros.
///
/// # Safety
/// `target` points to so many bytes for each lane.
pub(in super::super) unsafe extern "C" fn own_zero(
    target: *mut Row,
    _: *const u32,
    bytes: u32,
    mask: *const Row,
) {
    // SAFETY: the caller's.
    unsafe {
        let words = bytes as usize / 4;
        if *mask == [u32::MAX; 8] {
            return target.write_bytes(0, words);
        }
        for word in 0..words {
            fill(&mut *target.add(word), 0, &*mask);
        }
    }
}

/// Copies the same words to each lane's own memory.
///
/// # Safety
/// As [`own_zero`]; `source` points to so many bytes.
pub(in super::super) unsafe extern "C" fn own_copy(
    target: *mut Row,
    source: *const u32,
    bytes: u32,
    mask: *const Row,
) {
    // SAFETY: the caller's.
    unsafe {
        for word in 0..bytes as usize / 4 {
            let copied = source.add(word).read();
            fill(&mut *target.add(word), copied, &*mask);
        }
    }
}

/// The most words that [`host`] hands over, and back.
pub(in super::super) const MOST_HOST_WORDS: u32 = 32;

/// Calls a function that was bound for each lane; what it takes and gives is in lanes' own memory.
///
/// # Safety
/// The function is bound, and takes and gives so many words, which are [`MOST_HOST_WORDS`] at most and there for each lane.
pub(in super::super) unsafe extern "C" fn host(
    function: *const Arc<dyn HostFunction>,
    taken: *const Row,
    taken_words: u32,
    given: *mut Row,
    given_words: u32,
    mask: *const Row,
) {
    let mut arguments = [0; MOST_HOST_WORDS as usize];
    let mut result = [0; MOST_HOST_WORDS as usize];
    let (arguments, result) = (
        &mut arguments[..taken_words as usize],
        &mut result[..given_words as usize],
    );
    // SAFETY: the caller's.
    unsafe {
        lanes(&*mask, |lane| {
            for (word, argument) in arguments.iter_mut().enumerate() {
                *argument = (*taken.add(word))[lane];
            }
            (*function).call(arguments, result);
            for (word, result) in result.iter().enumerate() {
                (*given.add(word))[lane] = *result;
            }
        });
    }
}

macro_rules! atomics {
    ($($name:ident = |$word:ident, $x:ident| $does:expr;)+) => {
        $(
            unsafe extern "C" fn $name(base: *mut u8, given: *mut Row) {
                // SAFETY: as `scatter`: offsets, words, mask; what was there comes into the first row.
                unsafe {
                    let [offsets, words, mask] = rows::<3>(given);
                    lanes(mask, |lane| {
                        let ($word, $x) = (word(base, offsets[lane]), words[lane]);
                        offsets[lane] = $does;
                    });
                }
            }
        )+
    };
}

/// The same word with a sign.
///
/// # Safety
/// None.
unsafe fn signed(word: &AtomicU32) -> &AtomicI32 {
    // SAFETY: it has the same size and alignment, and lives as long.
    unsafe { AtomicI32::from_ptr(word.as_ptr().cast()) }
}

atomics! {
    atomic_add = |word, x| word.fetch_add(x, Relaxed);
    atomic_subtract = |word, x| word.fetch_sub(x, Relaxed);
    atomic_and = |word, x| word.fetch_and(x, Relaxed);
    atomic_or = |word, x| word.fetch_or(x, Relaxed);
    atomic_xor = |word, x| word.fetch_xor(x, Relaxed);
    atomic_unsigned_min = |word, x| word.fetch_min(x, Relaxed);
    atomic_unsigned_max = |word, x| word.fetch_max(x, Relaxed);
    atomic_signed_min = |word, x| signed(word).fetch_min(x as i32, Relaxed) as u32;
    atomic_signed_max = |word, x| signed(word).fetch_max(x as i32, Relaxed) as u32;
    atomic_exchange = |word, x| word.swap(x, Relaxed);
}

/// What does an atomic operation.
pub(in super::super) fn atomic(op: AtomicOperation) -> Helper {
    match op {
        AtomicOperation::Add => atomic_add,
        AtomicOperation::Subtract => atomic_subtract,
        AtomicOperation::And => atomic_and,
        AtomicOperation::Or => atomic_or,
        AtomicOperation::Xor => atomic_xor,
        AtomicOperation::UnsignedMin => atomic_unsigned_min,
        AtomicOperation::UnsignedMax => atomic_unsigned_max,
        AtomicOperation::SignedMin => atomic_signed_min,
        AtomicOperation::SignedMax => atomic_signed_max,
        AtomicOperation::Exchange => atomic_exchange,
    }
}

macro_rules! numbers {
    ($($name:ident = ($does:ty), |$f:ident, $a:ident, $b:ident| $made:expr;)+) => {
        $(
            /// Calls a function of numbers for each lane.
            unsafe extern "C" fn $name(does: *mut u8, given: *mut Row) {
                // SAFETY: the function is one of those that `numbers` names this for.
                unsafe {
                    let $f = std::mem::transmute::<*mut u8, $does>(does);
                    let [first, second, mask] = rows::<3>(given);
                    lanes(mask, |lane| {
                        let ($a, $b) = (first[lane], second[lane]);
                        let _ = $b;
                        first[lane] = $made;
                    });
                }
            }
        )+
    };
}

numbers! {
    float_of_float = (extern "C" fn(f32) -> f32), |f, a, b| f(f32::from_bits(a)).to_bits();
    float_of_floats = (extern "C" fn(f32, f32) -> f32), |f, a, b| f(f32::from_bits(a), f32::from_bits(b)).to_bits();
    float_of_float_and_word = (extern "C" fn(f32, i32) -> f32), |f, a, b| f(f32::from_bits(a), b as i32).to_bits();
    word_of_float = (extern "C" fn(f32) -> u32), |f, a, b| f(f32::from_bits(a));
    float_of_word = (extern "C" fn(u32) -> f32), |f, a, b| f(a).to_bits();
}

/// What calls a function of numbers for lanes: with the function, and rows of what it takes, the last for those that take one twice. The
/// first row becomes what it gives.
pub(in super::super) fn numbers(function: Runtime) -> Option<Helper> {
    Some(match function {
        Runtime::Sin
        | Runtime::Cos
        | Runtime::Tan
        | Runtime::Asin
        | Runtime::Acos
        | Runtime::Sinh
        | Runtime::Cosh
        | Runtime::Tanh
        | Runtime::Asinh
        | Runtime::Acosh
        | Runtime::Atanh
        | Runtime::Exp
        | Runtime::Exp2
        | Runtime::Log
        | Runtime::Log2
        | Runtime::FrexpFraction => float_of_float,
        Runtime::Pow => float_of_floats,
        Runtime::Ldexp => float_of_float_and_word,
        Runtime::FrexpExponent | Runtime::FloatToHalf => word_of_float,
        Runtime::HalfToFloat => float_of_word,
        Runtime::Zero
        | Runtime::Copy
        | Runtime::LoadTexel
        | Runtime::StoreTexel
        | Runtime::Host => return None,
    })
}
