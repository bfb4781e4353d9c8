/// One vector of up to three. Where the result is a number, it is that number three times.
/// @group colour
/// @param operation 0 add, 1 subtract, 2 multiply, 3 divide, 4 multiply and add, 5 cross, 6 project, 7 reflect, 8 refract, 9 dot, 10 distance, 11 length, 12 scale, 13 normalise, 14 absolute, 15 least, 16 most, 17 floor, 18 ceiling, 19 fraction, 20 modulo, 21 snap, 22 sine, 23 cosine, 24 face forward [0 .. 24] = 0
/// @param a         first vector [attr LocalPos]
/// @param b         second vector
/// @param c         third vector, for those that take one
/// @param scale     factor of scale, or the ratio of refractive indices = 1
fn userProc(operation: u32, a: vec3f, b: vec3f, c: vec3f, scale: f32) -> vec3f {
    let near = abs(b) < vec3f(1e-30);
    let divisor = select(b, vec3f(1.0), near);
    switch operation {
        case 0u: { return a + b; }
        case 1u: { return a - b; }
        case 2u: { return a * b; }
        case 3u: { return select(a / divisor, vec3f(), near); }
        case 4u: { return a * b + c; }
        case 5u: { return cross(a, b); }
        case 6u: { return b * (dot(a, b) / max(dot(b, b), 1e-30)); }
        case 7u: { return reflect(a, unit(b)); }
        case 8u: { return refract(unit(a), unit(b), scale); }
        case 9u: { return vec3f(dot(a, b)); }
        case 10u: { return vec3f(distance(a, b)); }
        case 11u: { return vec3f(length(a)); }
        case 12u: { return a * scale; }
        case 13u: { return unit(a); }
        case 14u: { return abs(a); }
        case 15u: { return min(a, b); }
        case 16u: { return max(a, b); }
        case 17u: { return floor(a); }
        case 18u: { return ceil(a); }
        case 19u: { return fract(a); }
        case 20u: { return select(a - b * trunc(a / divisor), vec3f(), near); }
        case 21u: { return select(floor(a / divisor) * b, vec3f(), near); }
        case 22u: { return sin(a); }
        case 23u: { return cos(a); }
        case 24u: { return faceForward(a, b, c); }
        default: { return a; }
    }
}

fn unit(v: vec3f) -> vec3f {
    return v / max(length(v), 1e-30);
}
