fn power(base: f32, exponent: f32) -> f32 {
    if exponent == 0.0 {
        return 1.0;
    }
    if base > 0.0 {
        return min(pow(base, exponent), 3e38);
    }
    if base == 0.0 || exponent != floor(exponent) {
        return 0.0;
    }
    let size = min(pow(-base, exponent), 3e38);
    return select(size, -size, modulo(exponent, 2.0) == 1.0);
}

/// A power; 0 where there is none, as of negative numbers to a fraction.
/// @param in1 first = (0, 0, 0, 0)
/// @param in2 second = (1, 1, 1, 1)
fn userProc(in1: vec4f, in2: vec4f) -> vec4f {
    return vec4f(power(in1.x, in2.x), power(in1.y, in2.y), power(in1.z, in2.z), power(in1.w, in2.w));
}
