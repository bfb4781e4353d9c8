// Sums that are exact in any order: whole numbers of 96 bits, the least significant word first. `film.rs` has the twin.

// Bits behind the point, and the largest value that leaves room for 2^20 samples.
const SUM_BITS = 44;
const LARGEST = 2147483520.0;

// Sum of two numbers of 96 bits, modulo 2^96; the least significant word first.
fn add_wide(a: vec3u, b: vec3u) -> vec3u {
    let low = a.x + b.x;
    let middle = a.y + b.y;
    let carried = middle + u32(low < a.x);
    return vec3u(low, carried, a.z + b.z + u32(middle < a.y) + u32(carried < middle));
}

// A number below 2^(95 - bits) as a whole number of units of 2^-bits, rounded to nearest, as two's complement.
fn fixed_point(value: f32, bits: i32) -> vec3u {
    let word = bitcast<u32>(value);
    let mantissa = (word & 0x7fffffu) | 0x800000u;
    let shift = i32((word >> 23u) & 255u) - 150 + bits;
    var whole = vec3u(0u);
    if (shift >= 0) {
        let bit = u32(shift) & 31u;
        let low = mantissa << bit;
        let high = (mantissa >> 1u) >> (31u - bit); // without a shift by 32
        switch shift >> 5u {
            case 0: { whole = vec3u(low, high, 0u); }
            case 1: { whole = vec3u(0u, low, high); }
            default: { whole = vec3u(0u, 0u, low); }
        }
    } else if (shift >= -24) {
        let right = u32(-shift);
        whole.x = (mantissa + (1u << (right - 1u))) >> right;
    }
    if (value < 0.0) {
        whole = add_wide(~whole, vec3u(1u, 0u, 0u));
    }
    return whole;
}
