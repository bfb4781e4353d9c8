// Powers of two by their bits: exact on all devices, and without a function of the library.

// Two to a power from -126 to 127.
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

// The largest one that is no larger than a positive number, which is none of the subnormal ones.
fn power_of_two_below(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) & 0x7f800000u);
}
