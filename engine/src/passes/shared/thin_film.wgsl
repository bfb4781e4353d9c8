// What a thin film on a surface reflects: interference in the film, as a colour (Belcour and Barla, "A Practical
// Extension to Microfacet Theory for the Modeling of Varying Iridescence", 2017, as KHR_materials_iridescence has it).
//!include shared/microfacet.wgsl

// Linear Rec.709 that `path` nanometres of optical path difference and a phase shift make of white light: the cosine
// transform of the eye's sensitivity, which the paper fits by Gaussians.
fn film_sensitivity(path: f32, shift: vec3f) -> vec3f {
    let phase = 2.0 * PI * path * 1e-9;
    let height = vec3f(5.4856e-13, 4.4201e-13, 5.2481e-13);
    let center = vec3f(1.6810e6, 1.7953e6, 2.2084e6);
    let variance = vec3f(4.3278e9, 9.3046e9, 6.6121e9);
    var xyz = height * sqrt(2.0 * PI * variance) * cos(center * phase + shift) * exp(-variance * (phase * phase));
    xyz.x += 9.7470e-14 * sqrt(2.0 * PI * 4.5282e9) * cos(2.2399e6 * phase + shift.x) * exp(-4.5282e9 * phase * phase);
    xyz /= 1.0685e-7;
    return vec3f(
        dot(xyz, vec3f(3.2404542, -1.5371385, -0.4985314)),
        dot(xyz, vec3f(-0.9692660, 1.8760108, 0.0415560)),
        dot(xyz, vec3f(0.0556434, -0.2040259, 1.0572252)),
    );
}

// Reflection at `cosine` of a film of so many nanometres over a surface that reflects `f0` in the air.
fn film_reflection(cosine: f32, film_ior: f32, thickness: f32, f0: vec3f) -> vec3f {
    // One that is thinner than atoms fades away.
    let ior = mix(1.0, film_ior, smoothstep(0.0, 0.03, thickness));
    let sine2 = (1.0 - cosine * cosine) / (ior * ior);
    if (sine2 >= 1.0) {
        return vec3f(1.0);
    }
    let inner_cosine = sqrt(1.0 - sine2);
    // The upper side of the film, then the lower one.
    let upper0 = (ior - 1.0) / (ior + 1.0);
    // As the reflection of bodies that are nearly alike, that of a film of nearly no index fades at grazing angles; see `dielectric_fresnel`.
    let grazing = schlick_weight(cosine) * min(7.07 * abs(upper0), 1.0);
    let upper = upper0 * upper0 + (1.0 - upper0 * upper0) * grazing;
    let passed = 1.0 - upper;
    let root = sqrt(clamp(f0, vec3f(0.0), vec3f(0.9999)));
    let base_ior = (vec3f(1.0) + root) / (vec3f(1.0) - root);
    let lower_root = (base_ior - ior) / (base_ior + ior);
    let lower = schlick(lower_root * lower_root, inner_cosine);
    // Half a wavelength is lost where the index rises.
    let shift = vec3f(PI) + select(vec3f(0.0), vec3f(PI), base_ior < vec3f(ior));
    let path = 2.0 * ior * thickness * inner_cosine;

    let both = clamp(upper * lower, vec3f(0.0), vec3f(0.9999));
    let amplitude = sqrt(both);
    let between = passed * passed * lower / (vec3f(1.0) - both);
    var reflected = vec3f(upper) + between;
    var order = between - passed;
    for (var m = 1u; m <= 2u; m++) {
        order *= amplitude;
        reflected += order * 2.0 * film_sensitivity(f32(m) * path, f32(m) * shift);
    }
    return clamp(reflected, vec3f(0.0), vec3f(1.0));
}
