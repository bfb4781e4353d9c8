// What a window shows of a film: the mean or another channel of each pixel, exposed, brought to what a screen can show,
// and encoded as sRGB. The sums of a film are those of `accumulate.wgsl`.
//!include shared/vectors.wgsl
//!include display/view.wgsl

struct Display {
    width: u32,
    height: u32,
    channel: u32, // see `display::Channel`
    view: u32, // see `scene::view::ViewTransform`
    gain: f32, // of radiance
    distance_scale: f32, // shown half bright, metres
    most_samples: f32,
    is_balanced: u32,
    outlined: u32, // the material that has a line around it; MISS: none
    unused0: u32,
    unused1: u32,
    unused2: u32,
    // Rows of the matrix of the white balance.
    balance_red: vec4f,
    balance_green: vec4f,
    balance_blue: vec4f,
}

// In one buffer, as there may be no more than eight.
struct DisplayBuffer {
    settings: Display,
    numbers: array<f32>, // of the view transform
}

// No uniform: Mesa's software driver would compile the kernel again for each picture, with the channel's code alone.
@group(0) @binding(0) var<storage, read> display: DisplayBuffer;
@group(0) @binding(1) var<storage, read> film0: array<vec4u>;
@group(0) @binding(2) var<storage, read> film1: array<vec4u>;
@group(0) @binding(3) var<storage, read> film2: array<vec4u>;
@group(0) @binding(4) var<storage, read> film3: array<vec4u>;
@group(0) @binding(5) var<storage, read> film4: array<vec4u>;
@group(0) @binding(6) var<storage, read> guides: array<vec4u>;
// Of each workgroup: the sum of standard errors, that of luminances, and the pixels that have an error.
@group(0) @binding(7) var<storage, read_write> error_sums: array<vec4f>;
@group(0) @binding(8) var picture: texture_storage_2d<rgba8unorm, write>;

const CHANNEL_RADIANCE = 0u;
const CHANNEL_SAMPLES = 1u;
const CHANNEL_ERROR = 2u;
const CHANNEL_NORMAL = 3u;
const CHANNEL_DISTANCE = 4u;
const CHANNEL_MATERIAL = 5u;
const CHANNEL_OBJECT = 6u;
const CHANNEL_BASE_COLOR = 7u;
const CHANNEL_ROUGHNESS = 8u;
const CHANNEL_METALLIC = 9u;

const MISS = 0xffffffffu;

var<workgroup> partial: array<vec3f, 64>;

// A sum of 96 bits, as two's complement, in units of 2^-44.
fn radiance_sum(words: vec3u) -> f32 {
    if ((words.z >> 31u) == 0u) {
        return square_sum(words) * 0.00390625;
    }
    // Negated as a whole number, so that nothing cancels.
    let low = ~words.x + 1u;
    let middle = ~words.y + u32(low == 0u);
    let high = ~words.z + u32(low == 0u && middle == 0u);
    return -square_sum(vec3u(low, middle, high)) * 0.00390625;
}

// A sum of 96 bits without sign, in units of 2^-36.
fn square_sum(words: vec3u) -> f32 {
    return f32(words.z) * 268435456.0 + f32(words.y) * 0.0625 + f32(words.x) * 1.4551915228366852e-11;
}

// Blue, cyan, green, yellow, red for 0 to 1.
fn heat(x: f32) -> vec3f {
    let h = 4.0 * (1.0 - clamp(x, 0.0, 1.0));
    return clamp(vec3f(2.0 - h, min(h, 4.0 - h), h - 2.0), vec3f(0.0), vec3f(1.0));
}

// A colour for a number, so that neighbours differ.
fn name_color(number: u32) -> vec3f {
    if (number == MISS) {
        return vec3f(0.0);
    }
    // Steps of the golden ratio spread hues evenly however many there are.
    let hue = fract(f32(number + 1u) * 0.61803399) * 6.0;
    let pure = clamp(vec3f(abs(hue - 3.0) - 1.0, 2.0 - abs(hue - 2.0), 2.0 - abs(hue - 4.0)), vec3f(0.0), vec3f(1.0));
    let pale = 0.25 * f32(number / 7u % 3u);
    return mix(pure, vec3f(1.0), pale) * 0.9;
}

fn shown(at: u32, mean: vec3f, count: u32, relative_error: f32) -> vec3f {
    switch display.settings.channel {
        case CHANNEL_RADIANCE: { return viewed(mean); }
        case CHANNEL_SAMPLES: { return heat(f32(count) / max(display.settings.most_samples, 1.0)); }
        // From 0.1 % to 100 %.
        case CHANNEL_ERROR: { return heat(1.0 + log2(max(relative_error, 1e-9)) / 9.9657843); }
        case CHANNEL_NORMAL: {
            let guide = guides[2u * at];
            if (guide.y == MISS) {
                return vec3f(0.0);
            }
            return octahedral(guide.w) * 0.5 + 0.5;
        }
        case CHANNEL_DISTANCE: {
            let distance = bitcast<f32>(guides[2u * at].x);
            return vec3f(display.settings.distance_scale / (display.settings.distance_scale + distance));
        }
        case CHANNEL_MATERIAL: { return name_color(guides[2u * at].y); }
        case CHANNEL_OBJECT: { return name_color(guides[2u * at].z); }
        default: { return look_of(guides[2u * at + 1u]); }
    }
}

// Numbers are shown as they are, colours encoded, and emission as the picture is.
fn look_of(guide: vec4u) -> vec3f {
    let base_color_red_green = unpack2x16unorm(guide.x);
    let base_color_blue_roughness = unpack2x16unorm(guide.y);
    switch display.settings.channel {
        case CHANNEL_BASE_COLOR: { return srgb(vec3f(base_color_red_green, base_color_blue_roughness.x)); }
        case CHANNEL_ROUGHNESS: { return vec3f(base_color_blue_roughness.y); }
        case CHANNEL_METALLIC: { return vec3f(unpack2x16unorm(guide.z).x); }
        default: { return viewed(unpack_shared_exponent(guide.w)); }
    }
}

// As `guide.wgsl` packs it.
fn unpack_shared_exponent(packed: u32) -> vec3f {
    let bits = vec3u(packed, packed >> 9u, packed >> 18u) & vec3u(511u);
    return vec3f(bits) * exp2(f32(packed >> 27u) - 24.0);
}

// As `octahedral_decode` of `geometry.wgsl`, which binds the whole scene.
fn octahedral(packed: u32) -> vec3f {
    let e = unpack2x16snorm(packed);
    var v = vec3f(e, 1.0 - abs(e.x) - abs(e.y));
    if (v.z < 0.0) {
        let folded = (vec2f(1.0) - abs(v.yx)) * select(vec2f(-1.0), vec2f(1.0), v.xy >= vec2f(0.0));
        v = vec3f(folded, v.z);
    }
    return normalize(v);
}

// Of whole 255ths, so that all devices round it to the same.
const OUTLINE = vec3f(255.0, 158.0, 26.0) / 255.0;

fn is_outlined(x: u32, y: u32) -> bool {
    return guides[2u * (y * display.settings.width + x)].y == display.settings.outlined;
}

// Whether a pixel lies on the line: the outermost ones of what is seen of the material, and those beside it.
fn is_on_outline(at: u32) -> bool {
    let width = display.settings.width;
    let height = display.settings.height;
    let x = at % width;
    let y = at / width;
    let left = is_outlined(max(x, 1u) - 1u, y);
    let right = is_outlined(min(x + 1u, width - 1u), y);
    let above = is_outlined(x, max(y, 1u) - 1u);
    let below = is_outlined(x, min(y + 1u, height - 1u));
    if (is_outlined(x, y)) {
        return !(left && right && above && below);
    }
    return left || right || above || below;
}

@compute @workgroup_size(64)
fn display_film(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let group = workgroup.y * workgroups.x + workgroup.x;
    let at = group * 64u + local;
    var sums = vec3f(0.0);
    if (at < display.settings.width * display.settings.height) {
        let words0 = film0[at];
        let words1 = film1[at];
        let words2 = film2[at];
        let words3 = film3[at];
        let words4 = film4[at];
        let count = words4.z;
        let n = max(f32(count), 1.0);
        let mean = vec3f(
            radiance_sum(words0.xyz),
            radiance_sum(vec3u(words0.w, words1.xy)),
            radiance_sum(vec3u(words1.zw, words2.x))) / n;
        let square = vec3f(
            square_sum(words2.yzw),
            square_sum(words3.xyz),
            square_sum(vec3u(words3.w, words4.xy))) / n;
        // The error of the luminance as if the channels had their errors in common: no less than it is.
        let spread = sqrt(max(square - mean * mean, vec3f(0.0)) / max(n - 1.0, 1.0));
        let error = luminance(spread);
        let light = max(luminance(mean), 0.0);
        let relative = select(1.0, error / max(light, 1e-6), count > 1u);
        if (count > 1u) {
            sums = vec3f(error, light, 1.0);
        }
        var color = shown(at, mean, count, relative);
        if (display.settings.outlined != MISS && is_on_outline(at)) {
            color = OUTLINE;
        }
        textureStore(picture, vec2u(at % display.settings.width, at / display.settings.width), vec4f(color, 1.0));
    }
    partial[local] = sums;
    for (var step = 32u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if (local < step) {
            partial[local] += partial[local + step];
        }
    }
    if (local == 0u) {
        error_sums[group] = vec4f(partial[0], 0.0);
    }
}
