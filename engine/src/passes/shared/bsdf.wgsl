// The metallic-roughness BSDF of glTF 2.0 (appendix B) with KHR_materials_specular and KHR_materials_ior:
// a Lambert base under a GGX layer, mixed with a GGX metal. Single scattering, height-correlated Smith.
// Directions are in the local frame of the shading normal: z is the cosine.

const PI = 3.14159265358979;

struct Bsdf {
    base_color: vec3f,
    metallic: f32,
    alpha: f32, // GGX width, roughness squared
    dielectric_f0: vec3f,
    specular: f32, // weight of the dielectric's specular lobe
}

struct BsdfSample {
    wi: vec3f,
    weight: vec3f, // f cos / pdf; zero: no sample
    pdf: f32,
}

// Widest mirror that single precision can evaluate.
const MIN_ALPHA = 0.001;

fn make_bsdf(base_color: vec3f, metallic: f32, roughness: f32, dielectric_f0: vec3f, specular: f32) -> Bsdf {
    let r = saturate(roughness);
    return Bsdf(clamp(base_color, vec3f(0.0), vec3f(1.0)), saturate(metallic), max(r * r, MIN_ALPHA), dielectric_f0, saturate(specular));
}

fn schlick(f0: vec3f, cosine: f32) -> vec3f {
    let m = saturate(1.0 - cosine);
    let m2 = m * m;
    return f0 + (vec3f(1.0) - f0) * (m2 * m2 * m);
}

fn max_component(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

fn ggx_d(h: vec3f, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    // 1 + (a2 - 1) cos² without the cancellation near the pole.
    let t = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    return a2 / (PI * t * t);
}

// Smith's Lambda times 2 plus 1: sqrt(1 + alpha² tan²).
fn ggx_root(v: vec3f, alpha: f32) -> f32 {
    return sqrt(1.0 + alpha * alpha * (v.x * v.x + v.y * v.y) / (v.z * v.z));
}

// Probability of sampling the specular lobe.
fn specular_probability(b: Bsdf, wo: vec3f) -> f32 {
    let dielectric = b.specular * max_component(schlick(b.dielectric_f0, wo.z));
    let specular = mix(dielectric, max_component(schlick(b.base_color, wo.z)), b.metallic);
    let diffuse = (1.0 - b.metallic) * (1.0 - dielectric) * max_component(b.base_color);
    if (specular <= 0.0) {
        return 0.0;
    }
    if (diffuse <= 0.0) {
        return 1.0;
    }
    return clamp(specular / (specular + diffuse), 0.1, 0.9);
}

// f cos and the pdf of sampling wi, both for one pair of directions above the surface.
fn bsdf_eval(b: Bsdf, wo: vec3f, wi: vec3f) -> vec4f {
    if (wo.z <= 0.0 || wi.z <= 0.0) {
        return vec4f(0.0);
    }
    let p_specular = specular_probability(b, wo);
    var f = vec3f(0.0);
    var pdf = (1.0 - p_specular) * wi.z / PI;
    let h = normalize(wo + wi);
    let cosine = dot(wo, h);
    let dielectric_fresnel = min(schlick(b.dielectric_f0, cosine), vec3f(1.0));
    f += (1.0 - b.metallic) * (1.0 - b.specular * max_component(dielectric_fresnel)) * b.base_color / PI;
    if (p_specular > 0.0) {
        let d = ggx_d(h, b.alpha);
        let root_o = ggx_root(wo, b.alpha);
        let root_i = ggx_root(wi, b.alpha);
        // G2 / (4 cos cos) with G2 = 1 / (1 + Lambda_o + Lambda_i).
        let visibility = 1.0 / (2.0 * wo.z * wi.z * (root_o + root_i));
        let metal_fresnel = schlick(b.base_color, cosine);
        let fresnel = mix(b.specular * dielectric_fresnel, metal_fresnel, b.metallic);
        f += fresnel * d * visibility;
        // pdf of visible normals: G1 D / (4 cos_o).
        pdf += p_specular * d / (2.0 * (1.0 + root_o) * wo.z);
    }
    return vec4f(f * wi.z, pdf);
}

// A visible normal (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023).
fn sample_visible_normal(wo: vec3f, alpha: f32, u: vec2f) -> vec3f {
    let v = normalize(vec3f(wo.xy * alpha, wo.z));
    let phi = 2.0 * PI * u.x;
    let z = (1.0 - u.y) * (1.0 + v.z) - v.z;
    let s = sqrt(saturate(1.0 - z * z));
    let h = vec3f(s * cos(phi), s * sin(phi), z) + v;
    return normalize(vec3f(h.xy * alpha, max(h.z, 1e-7)));
}

fn sample_cosine(u: vec2f) -> vec3f {
    let r = sqrt(u.x);
    let phi = 2.0 * PI * u.y;
    return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 1e-12)));
}

fn bsdf_sample(b: Bsdf, wo: vec3f, u: vec2f, lobe: f32) -> BsdfSample {
    if (wo.z <= 0.0) {
        return BsdfSample(vec3f(0.0), vec3f(0.0), 0.0);
    }
    var wi: vec3f;
    if (lobe < specular_probability(b, wo)) {
        wi = reflect(-wo, sample_visible_normal(wo, b.alpha, u));
    } else {
        wi = sample_cosine(u);
    }
    let value = bsdf_eval(b, wo, wi);
    if (value.w <= 0.0) {
        return BsdfSample(vec3f(0.0), vec3f(0.0), 0.0);
    }
    return BsdfSample(wi, value.xyz / value.w, value.w);
}
