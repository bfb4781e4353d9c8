// Distributions of microfacets and what they reflect. Directions are in the local frame of the shading normal: z is the
// cosine. No materials here.
//!include shared/vectors.wgsl

const PI = 3.14159265358979;

// Widest mirror that single precision can evaluate.
const MIN_ALPHA = 0.001;

// Directional albedos, in blocks of ALBEDO_SIDE x ALBEDO_SIDE cells by cosine (x) and perceptual roughness (y). The first
// block: GGX as f0 * r + f90 * g; Charlie's sheen in b. Below it glass, one block between each two neighbouring indices:
// what a body's surface reflects and refracts together, from the outside and from the inside, at the lower index (rg) and
// at the higher one (ba). Computed by `gpu_scene::albedo`.
@group(0) @binding(21) var albedo_table: texture_2d<f32>;

const ALBEDO_SIDE = 32u;
const GLASS_BLOCKS = 15u;
const GLASS_MOST = 0.5; // of (index - 1) / (index + 1), by which the blocks are spread evenly

// Bilinear between a block's cells, whose first and last lie at 0 and 1.
fn albedo_block(block: u32, cosine: f32, roughness: f32) -> vec4f {
    let at = saturate(vec2f(cosine, roughness)) * f32(ALBEDO_SIDE - 1u);
    let cell = min(vec2u(at), vec2u(ALBEDO_SIDE - 2u));
    let f = at - vec2f(cell);
    let first = cell + vec2u(0u, block * ALBEDO_SIDE);
    let low = mix(textureLoad(albedo_table, first, 0), textureLoad(albedo_table, first + vec2u(1u, 0u), 0), f.x);
    let high = mix(textureLoad(albedo_table, first + vec2u(0u, 1u), 0), textureLoad(albedo_table, first + 1u, 0), f.x);
    return mix(low, high, f.y);
}

fn albedo_lookup(cosine: f32, roughness: f32) -> vec3f {
    return albedo_block(0u, cosine, roughness).xyz;
}

// The first two numbers of that table, roughly: a factor on f0 and what is added (Karis, "Physically Based Shading on Mobile", 2014).
fn rough_albedo_estimate(cosine: f32, roughness: f32) -> vec2f {
    let r = roughness * vec4f(-1.0, -0.0275, -0.572, 0.022) + vec4f(1.0, 0.0425, 1.04, -0.04);
    let grazing = min(r.x * r.x, exp2(-9.28 * cosine)) * r.x + r.y;
    return vec2f(-1.04, 1.04) * grazing + r.zw;
}

// Share of light that single scattering at the surface of a clear body reflects or refracts. `eta` is the index below over
// that above.
fn glass_albedo(cosine: f32, roughness: f32, eta: f32) -> f32 {
    let place = saturate(abs(eta - 1.0) / ((eta + 1.0) * GLASS_MOST)) * f32(GLASS_BLOCKS);
    let block = min(u32(place), GLASS_BLOCKS - 1u);
    let cells = albedo_block(1u + block, cosine, roughness);
    let pair = select(cells.xz, cells.yw, eta < 1.0);
    return mix(pair.x, pair.y, place - f32(block));
}

fn schlick_weight(cosine: f32) -> f32 {
    let m = saturate(1.0 - cosine);
    let m2 = m * m;
    return m2 * m2 * m;
}

fn schlick(f0: vec3f, cosine: f32) -> vec3f {
    return f0 + (vec3f(1.0) - f0) * schlick_weight(cosine);
}

// Density of normals (Trowbridge and Reitz), widths `alpha` along x and y.
fn ggx_d(h: vec3f, alpha: vec2f) -> f32 {
    let area = alpha.x * alpha.y;
    // 1 / (pi ax ay (hx²/ax² + hy²/ay² + hz²)²) without its cancellation at narrow peaks.
    let v = vec3f(alpha.y * h.x, alpha.x * h.y, area * h.z);
    let t = dot(v, v) / area;
    return area / (PI * t * t);
}

// Smith's Lambda times 2 plus 1.
fn ggx_root(v: vec3f, alpha: vec2f) -> f32 {
    let a = alpha * v.xy;
    return sqrt(1.0 + dot(a, a) / (v.z * v.z));
}

// The pdf of a direction that is reflected at a visible normal, of those that leave the surface: G1 D / (4 cos), over the share of the
// spherical cap that is left.
fn ggx_reflection_pdf(wo: vec3f, h: vec3f, alpha: vec2f) -> f32 {
    let a = alpha * wo.xy;
    return ggx_d(h, alpha) / (2.0 * (reflection_bound(wo, alpha) * wo.z + sqrt(dot(a, a) + wo.z * wo.z)));
}

// The pdf of any visible normal, G1 D |wo h| / cos.
fn ggx_normal_pdf(wo: vec3f, h: vec3f, alpha: vec2f) -> f32 {
    return abs(dot(wo, h)) * ggx_d(h, alpha) / (0.5 * (1.0 + ggx_root(wo, alpha)) * abs(wo.z));
}

// How far down the spherical cap of visible normals has to reach for all reflections above the surface, 1 being all of it (Eto and
// Tokuyoshi, "Bounded VNDF Sampling for Smith-GGX Reflections", SIGGRAPH Asia 2023, eq. 5).
fn reflection_bound(wo: vec3f, alpha: vec2f) -> f32 {
    let a = min(alpha.x, alpha.y);
    let s = 1.0 + length(wo.xy);
    return (1.0 - a * a) * s * s / (s * s + a * a * wo.z * wo.z);
}

// G2 D / (4 cos cos), height-correlated.
fn ggx_reflection(wo: vec3f, wi: vec3f, h: vec3f, alpha: vec2f) -> f32 {
    let roots = ggx_root(wo, alpha) + ggx_root(wi, alpha);
    return ggx_d(h, alpha) / (2.0 * abs(wo.z * wi.z) * roots);
}

// A visible normal (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", HPG 2023). `bound` is 1, or where light is
// reflected `reflection_bound`.
fn sample_visible_normal(wo: vec3f, alpha: vec2f, bound: f32, u: vec2f) -> vec3f {
    let v = normalize(vec3f(wo.xy * alpha, wo.z));
    let lowest = bound * v.z;
    let z = (1.0 - u.y) * (1.0 + lowest) - lowest;
    let h = vec3f(sqrt(saturate(1.0 - z * z)) * unit_circle(u.x), z) + v;
    return normalize(vec3f(h.xy * alpha, max(h.z, 1e-7)));
}

fn sample_cosine(u: vec2f) -> vec3f {
    return vec3f(sqrt(u.x) * unit_circle(u.y), sqrt(max(1.0 - u.x, 1e-12)));
}

fn sample_hemisphere(u: vec2f) -> vec3f {
    let z = max(u.x, 1e-6);
    return vec3f(sqrt(saturate(1.0 - z * z)) * unit_circle(u.y), z);
}

// Charlie's sheen without its colour (Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF", 2017).
fn charlie(wo: vec3f, wi: vec3f, alpha: f32) -> f32 {
    let h = normalize(wo + wi);
    let sine2 = max(1.0 - h.z * h.z, 0.0078125 * 0.0078125);
    let d = (2.0 + 1.0 / alpha) * pow(sine2, 0.5 / alpha) / (2.0 * PI);
    return d / (4.0 * wo.z * wi.z * (1.0 + charlie_lambda(wo.z, alpha) + charlie_lambda(wi.z, alpha)));
}

fn charlie_lambda(cosine: f32, alpha: f32) -> f32 {
    if (cosine < 0.5) {
        return exp(charlie_fit(cosine, alpha));
    }
    return exp(2.0 * charlie_fit(0.5, alpha) - charlie_fit(1.0 - cosine, alpha));
}

fn charlie_fit(x: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let a = mix(21.5473, 25.3245, t);
    let b = mix(3.82987, 3.32435, t);
    let c = mix(0.19823, 0.16801, t);
    let d = mix(-1.97760, -1.27393, t);
    let e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow(max(x, 1e-6), c)) + d * x + e;
}
