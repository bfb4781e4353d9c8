// Arithmetic of vectors and colours.

fn max_component(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

// Cosine and sine of an angle in whole turns, to 1e-7. Drivers' own may be off by 2e-4, each in its way: paths would take
// other ways from device to device. What is left of the nearest quarter turn goes into polynomials through the Chebyshev
// nodes.
fn unit_circle(turns: f32) -> vec2f {
    let quarters = round(4.0 * turns);
    let r = 4.0 * turns - quarters;
    let z = r * r;
    let sine = r * (((-0.0046021491 * z + 0.079680219) * z - 0.64596349) * z + 1.57079637);
    let cosine = (((0.00090673991 * z - 0.020861529) * z + 0.25366941) * z - 1.23370051) * z + 1.0;
    let quarter = u32(i32(quarters)) & 3u;
    let turned = select(vec2f(cosine, sine), vec2f(-sine, cosine), (quarter & 1u) != 0u);
    return select(turned, -turned, quarter >= 2u);
}

// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
fn any_perpendicular(n: vec3f) -> vec3f {
    let sign = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (sign + n.z);
    return vec3f(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x);
}
