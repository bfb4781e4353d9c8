// From radiance to sRGB codes: what `engine::view` does on the processor. The numbers of a transform lie in
// `display.numbers`, as `view::device_numbers` lists them.
//!include display/aces2.wgsl

const VIEW_STANDARD = 0u;
const VIEW_AGX = 1u;
const VIEW_KHRONOS_NEUTRAL = 2u;
const VIEW_ACES2 = 3u;

// Places in the numbers of a table.
const TABLE_STOPS = 9u;
const TABLE_SIZE = 11u;
const TABLE_CURVE_END = 12u;
const TABLE_CURVE_LENGTH = 13u;
const TABLE_CURVE = 14u;

fn srgb(linear: vec3f) -> vec3f {
    let c = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

// A matrix among the numbers, row by row, times a vector.
fn transformed(matrix: u32, v: vec3f) -> vec3f {
    return vec3f(
        dot(numbers3(matrix), v),
        dot(numbers3(matrix + 3u), v),
        dot(numbers3(matrix + 6u), v));
}

fn numbers3(at: u32) -> vec3f {
    return vec3f(display.numbers[at], display.numbers[at + 1u], display.numbers[at + 2u]);
}

// Khronos PBR Neutral: colours up to 0.8 stay as they are but for a small offset, brighter ones are compressed and lose
// colour (Khronos PBR Neutral tone mapper, specification 1.0).
fn neutral(scene: vec3f) -> vec3f {
    let linear = max(scene, vec3f(0.0));
    let start = 0.8 - 0.04;
    let least = min(linear.x, min(linear.y, linear.z));
    let offset = select(0.04, least - 6.25 * least * least, least < 0.08);
    let color = linear - offset;
    let peak = max_component(color);
    if (peak < start) {
        return color;
    }
    let room = 1.0 - start;
    let compressed = 1.0 - room * room / (peak + room - start);
    let faded = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0);
    return mix(color * (compressed / peak), vec3f(compressed), faded);
}

// sRGB codes by a grid of colours and a curve: AgX and Filmic.
fn tabulated(scene: vec3f) -> vec3f {
    let low = display.numbers[TABLE_STOPS];
    let range = display.numbers[TABLE_STOPS + 1u] - low;
    let last = display.numbers[TABLE_SIZE] - 1.0;
    let stops = log2(max(transformed(0u, scene), vec3f(1e-10)));
    let node = table_node(clamp(stops - low, vec3f(0.0), vec3f(range)) * (last / range));
    return vec3f(table_code(node.x), table_code(node.y), table_code(node.z));
}

// Interpolated in a tetrahedron: from the lower corner of the cell along its axes, the largest fraction first.
fn table_node(at: vec3f) -> vec3f {
    let size = u32(display.numbers[TABLE_SIZE]);
    let cell = min(floor(at), vec3f(f32(size) - 2.0));
    let f = at - cell;
    let corner = vec3u(cell);
    let strides = vec3u(3u, 3u * size, 3u * size * size);
    var node = TABLE_CURVE + u32(display.numbers[TABLE_CURVE_LENGTH]) + dot(corner, strides);
    // The axes in the order of their fractions.
    var largest = vec2f(f.x, f32(strides.x));
    var middle = vec2f(f.y, f32(strides.y));
    var least = vec2f(f.z, f32(strides.z));
    if (largest.x < middle.x) {
        let kept = largest;
        largest = middle;
        middle = kept;
    }
    if (middle.x < least.x) {
        let kept = middle;
        middle = least;
        least = kept;
    }
    if (largest.x < middle.x) {
        let kept = largest;
        largest = middle;
        middle = kept;
    }
    var sum = numbers3(node) * (1.0 - largest.x);
    node += u32(largest.y);
    sum += numbers3(node) * (largest.x - middle.x);
    node += u32(middle.y);
    sum += numbers3(node) * (middle.x - least.x);
    node += u32(least.y);
    return sum + numbers3(node) * least.x;
}

fn table_code(x: f32) -> f32 {
    let last = u32(display.numbers[TABLE_CURVE_LENGTH]) - 1u;
    let at = clamp(x / display.numbers[TABLE_CURVE_END], 0.0, 1.0) * f32(last);
    let below = min(u32(at), last - 1u);
    return mix(display.numbers[TABLE_CURVE + below], display.numbers[TABLE_CURVE + below + 1u], at - f32(below));
}

// Radiance as what a screen shows.
fn viewed(radiance: vec3f) -> vec3f {
    var linear = radiance * display.settings.gain;
    if (display.settings.is_balanced != 0u) {
        linear = vec3f(
            dot(display.settings.balance_red.xyz, linear),
            dot(display.settings.balance_green.xyz, linear),
            dot(display.settings.balance_blue.xyz, linear));
    }
    switch display.settings.view {
        case VIEW_STANDARD: { return srgb(linear); }
        case VIEW_KHRONOS_NEUTRAL: { return srgb(neutral(linear)); }
        case VIEW_ACES2: { return srgb(aces2(linear)); }
        default: { return tabulated(linear); }
    }
}
