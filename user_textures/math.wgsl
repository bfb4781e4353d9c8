/// One number of up to three. What can't be computed (a division by zero, the root of a negative number) is 0.
/// @group colour
/// @param operation 0 add, 1 subtract, 2 multiply, 3 divide, 4 multiply and add, 5 power, 6 logarithm, 7 root, 8 absolute, 9 least, 10 most, 11 less than, 12 greater than, 13 sign, 14 compare, 15 smooth least, 16 smooth most, 17 round, 18 floor, 19 ceiling, 20 truncate, 21 fraction, 22 modulo, 23 wrap, 24 snap, 25 ping-pong, 26 sine, 27 cosine, 28 tangent, 29 arcsine, 30 arccosine, 31 arctangent, 32 arctangent of both, 33 exponential [0 .. 33] = 2
/// @param a         first number [attr TexCoord0]
/// @param b         second number = 0.5
/// @param c         third number, for those that take one = 0
/// @param limit     whether the result is held between 0 and 1 = false
fn userProc(operation: u32, a: f32, b: f32, c: f32, limit: bool) -> f32 {
    let result = compute(operation, a, b, c);
    return select(result, saturate(result), limit);
}

fn compute(operation: u32, a: f32, b: f32, c: f32) -> f32 {
    let near = abs(b) < 1e-30;
    let divisor = select(b, 1.0, near);
    switch operation {
        case 0u: { return a + b; }
        case 1u: { return a - b; }
        case 2u: { return a * b; }
        case 3u: { return select(a / divisor, 0.0, near); }
        case 4u: { return a * b + c; }
        case 5u: { return power(a, b); }
        case 6u: { return select(log(max(a, 1e-30)) / log(max(b, 1e-30)), 0.0, a <= 0.0 || b <= 0.0 || b == 1.0); }
        case 7u: { return sqrt(max(a, 0.0)); }
        case 8u: { return abs(a); }
        case 9u: { return min(a, b); }
        case 10u: { return max(a, b); }
        case 11u: { return select(0.0, 1.0, a < b); }
        case 12u: { return select(0.0, 1.0, a > b); }
        case 13u: { return sign(a); }
        case 14u: { return select(0.0, 1.0, abs(a - b) <= max(c, 1e-5)); }
        case 15u: { return smooth_least(a, b, c); }
        case 16u: { return -smooth_least(-a, -b, c); }
        case 17u: { return floor(a + 0.5); }
        case 18u: { return floor(a); }
        case 19u: { return ceil(a); }
        case 20u: { return trunc(a); }
        case 21u: { return fract(a); }
        case 22u: { return select(a - b * trunc(a / divisor), 0.0, near); }
        case 23u: { return wrapped(a, b, c); }
        case 24u: { return select(floor(a / divisor) * b, 0.0, near); }
        case 25u: { return select(b - abs(modulo(a, 2.0 * divisor) - b), 0.0, near); }
        case 26u: { return sin(a); }
        case 27u: { return cos(a); }
        case 28u: { return clamp(tan(a), -1e6, 1e6); }
        case 29u: { return asin(clamp(a, -1.0, 1.0)); }
        case 30u: { return acos(clamp(a, -1.0, 1.0)); }
        case 31u: { return atan(a); }
        case 32u: { return select(atan2(a, b), 0.0, a == 0.0 && b == 0.0); }
        case 33u: { return exp(min(a, 80.0)); }
        default: { return a; }
    }
}

// Negative bases have whole powers only.
fn power(a: f32, b: f32) -> f32 {
    if a > 0.0 {
        return min(pow(a, b), 1e30);
    }
    let whole = floor(b + 0.5);
    if a == 0.0 || abs(b - whole) > 1e-5 {
        return select(0.0, 1.0, b == 0.0);
    }
    let size = min(pow(-a, b), 1e30);
    return select(size, -size, modulo(whole, 2.0) > 0.5);
}

fn smooth_least(a: f32, b: f32, width: f32) -> f32 {
    if width <= 0.0 {
        return min(a, b);
    }
    let h = max(width - abs(a - b), 0.0) / width;
    return min(a, b) - h * h * h * width / 6.0;
}

fn wrapped(a: f32, most: f32, least: f32) -> f32 {
    let range = most - least;
    if abs(range) < 1e-30 {
        return least;
    }
    return a - range * floor((a - least) / range);
}
