// ACES 2.0's output transform: what `engine::view::aces2` does on the processor, which says what is what. Matrices, scalars and
// tables come from there.

// Places in the numbers.
const ACES_TO_AP1 = 0u;
const ACES_TO_CONES = 9u;
const ACES_OPPONENT = 18u;
const ACES_OPPONENT_INVERSE = 27u;
const ACES_TO_DISPLAY = 36u;
const ACES_ADAPTATION = 45u;
const ACES_WHITE = 46u;
const ACES_EXPONENT = 47u;
const ACES_TONE_HALF = 48u;
const ACES_TONE_SCALE = 49u;
const ACES_MIDDLE = 50u;
const ACES_REACH = 51u;

const ACES_HUES = 360u;
// From table to table: their first sample is there twice.
const ACES_TABLE = 361u;

const ACES_J_MAX = 100.0;

fn cone_response(stimulus: vec3f) -> vec3f {
    let power = pow(abs(stimulus), vec3f(0.42));
    return sign(stimulus) * power / (27.13 + power);
}

fn cone_stimulus(response: vec3f) -> vec3f {
    let limited = min(abs(response), vec3f(0.99));
    return sign(response) * pow(27.13 * limited / (1.0 - limited), vec3f(1.0 / 0.42));
}

fn lightness_of_grey(nits: f32) -> f32 {
    let response = cone_response(vec3f(nits * display.numbers[ACES_ADAPTATION])).x;
    return 100.0 * pow(response / display.numbers[ACES_WHITE], display.numbers[ACES_EXPONENT]);
}

fn tonescale(nits: f32) -> f32 {
    let f = display.numbers[ACES_TONE_SCALE] * pow(nits / (nits + display.numbers[ACES_TONE_HALF]), 1.15);
    return max(f * f / (f + 0.04), 0.0) * 100.0;
}

fn chroma_norm(direction: vec2f) -> f32 {
    let c = direction.x;
    let s = direction.y;
    let series = 77.12896 + 11.34072 * c + 16.46899 * (2.0 * c * c - 1.0) + 7.8838 * (4.0 * c * c * c - 3.0 * c)
        + 14.66441 * s - 6.37224 * (2.0 * c * s) + 9.19364 * (3.0 * s - 4.0 * s * s * s);
    return series * (pow(3.379, 0.30596) - 0.45135);
}

fn toe(x: f32, limit: f32, wanted_strength: f32, wanted_slope: f32) -> f32 {
    if (x > limit) {
        return x;
    }
    let slope = max(wanted_slope, 0.001);
    let strength = sqrt(wanted_strength * wanted_strength + slope * slope);
    let scale = (limit + strength) / (limit + slope);
    let b = scale * x - strength;
    return 0.5 * (b + sqrt(b * b + 4.0 * slope * scale * x));
}

fn compressed_chroma(m: f32, j_before: f32, j: f32, direction: vec2f, reach: f32) -> f32 {
    let norm = chroma_norm(direction);
    let share = j / ACES_J_MAX;
    let rest = max(1.0 - share, 0.0);
    let power = 1.0 / display.numbers[ACES_EXPONENT];
    let limit = pow(share, power) * reach / norm;
    let scaled = m * pow(j / j_before, power) / norm;
    let saturated = limit - toe(limit - scaled, limit - 0.001, rest * 1.3, sqrt(share * share + 0.005));
    return toe(saturated, limit, share * 2.4, rest) * norm;
}

// Between two samples of a table.
fn aces_sample(table: u32, above: u32, t: f32) -> f32 {
    let at = ACES_REACH + table * ACES_TABLE + above;
    return mix(display.numbers[at - 1u], display.numbers[at], t);
}

// Lightness and colourfulness of the gamut's cusp at a hue, and the exponent of its upper hull.
fn gamut_hull(hue: f32) -> vec3f {
    let hues = ACES_REACH + ACES_TABLE;
    var low = 0u;
    var high = ACES_HUES;
    while (low + 1u < high) {
        let middle = (low + high) / 2u;
        if (display.numbers[hues + middle] < hue) {
            low = middle;
        } else {
            high = middle;
        }
    }
    let t = (hue - display.numbers[hues + low]) / (display.numbers[hues + high] - display.numbers[hues + low]);
    return vec3f(aces_sample(2u, high, t), aces_sample(3u, high, t), aces_sample(4u, high, t));
}

// Where the line of compression through a point meets the axis of greys; `lines` are their focus and gain.
fn line_axis(j: f32, m: f32, lines: vec2f) -> f32 {
    let scaled = m / lines.y;
    let a = scaled / lines.x;
    if (j < lines.x) {
        let b = 1.0 - scaled;
        return 2.0 * j / (b + sqrt(b * b + 4.0 * a * j));
    }
    let b = 1.0 + scaled + ACES_J_MAX * a;
    let c = ACES_J_MAX * scaled + j;
    return 2.0 * c / (b + sqrt(max(b * b - 4.0 * a * c, 0.0)));
}

fn line_crossing(axis: f32, slope: f32, exponent: f32, cusp: vec2f, reference: f32) -> f32 {
    let shifted = reference * pow(max(axis, 0.0) / reference, exponent);
    return shifted * cusp.y / (cusp.x - slope * cusp.y);
}

fn gamut_boundary(hull: vec3f, lines: vec2f, axis: f32, slope: f32) -> f32 {
    let cusp_axis = line_axis(hull.x, hull.y, lines);
    let lower = line_crossing(axis, slope, 1.0 / 1.14, hull.xy, cusp_axis);
    let upper = line_crossing(
        ACES_J_MAX - axis, -slope, hull.z, vec2f(ACES_J_MAX - hull.x, hull.y), ACES_J_MAX - cusp_axis);
    let width = 0.12 * hull.y;
    let h = max(width - abs(lower - upper), 0.0) / width;
    return min(lower, upper) - h * h * h * width / 6.0;
}

fn remapped_chroma(m: f32, boundary: f32, reach: f32) -> f32 {
    let share = max(boundary / reach, 0.75);
    let threshold = share * boundary;
    if (m <= threshold || share >= 1.0) {
        return m;
    }
    let scale = (reach - threshold) / ((reach - threshold) / (boundary - threshold) - 1.0);
    let x = (m - threshold) / scale;
    return threshold + scale * x / (1.0 + x);
}

// Lightness and colourfulness drawn into the gamut of the display.
fn compressed_gamut(j: f32, m: f32, hue: f32, reach: f32) -> vec2f {
    if (m <= 0.0 || j > ACES_J_MAX) {
        return vec2f(j, 0.0);
    }
    let hull = gamut_hull(hue);
    let focus = mix(hull.x, display.numbers[ACES_MIDDLE], min(1.3 - hull.x / ACES_J_MAX, 1.0));
    let threshold = mix(hull.x, ACES_J_MAX, 0.3);
    var gain = ACES_J_MAX * 1.35;
    if (j > threshold) {
        let steep = log2((ACES_J_MAX - threshold) / max(ACES_J_MAX - j, 1e-4)) * 0.30103;
        gain *= steep * steep + 1.0;
    }
    let lines = vec2f(focus, gain);
    let axis = line_axis(j, m, lines);
    let slope = select(ACES_J_MAX - axis, axis, axis < focus) * (axis - focus) / (focus * gain);
    let boundary = gamut_boundary(hull, lines, axis, slope);
    if (boundary <= 0.0) {
        return vec2f(j, 0.0);
    }
    let power = 1.0 / display.numbers[ACES_EXPONENT];
    let farthest = line_crossing(axis, slope, power, vec2f(ACES_J_MAX, reach), ACES_J_MAX);
    let compressed = remapped_chroma(m, boundary, farthest);
    return vec2f(axis + compressed * slope, compressed);
}

// From scene-linear Rec.709 to that of the display.
fn aces2(scene: vec3f) -> vec3f {
    let ap1 = clamp(transformed(ACES_TO_AP1, scene), vec3f(0.0), vec3f(1024.0));
    let opponents = transformed(ACES_OPPONENT, cone_response(transformed(ACES_TO_CONES, ap1)));
    if (opponents.x <= 0.0) {
        return vec3f(0.0);
    }
    let exponent = display.numbers[ACES_EXPONENT];
    let white = display.numbers[ACES_WHITE];
    let j_before = 100.0 * pow(opponents.x, exponent);
    let nits = cone_stimulus(vec3f(opponents.x * white)).x / display.numbers[ACES_ADAPTATION];
    let j = lightness_of_grey(tonescale(nits));
    if (j <= 0.0) {
        return vec3f(0.0);
    }
    let m_before = length(opponents.yz);
    // Greys have no hue: any will do.
    let direction = select(vec2f(1.0, 0.0), opponents.yz / max(m_before, 1e-20), m_before > 1e-10);
    let angle = degrees(atan2(direction.y, direction.x));
    let hue = select(angle, angle + 360.0, angle < 0.0);
    let degree = min(u32(hue), ACES_HUES - 1u);
    let reach = aces_sample(0u, degree + 1u, hue - f32(degree));
    let m = compressed_chroma(m_before, j_before, j, direction, reach);
    let shown = compressed_gamut(j, m, hue, reach);
    let achromatic = pow(max(shown.x, 0.0) / 100.0, 1.0 / exponent);
    let cones = cone_stimulus(transformed(ACES_OPPONENT_INVERSE, vec3f(achromatic, shown.y * direction)));
    return transformed(ACES_TO_DISPLAY, cones);
}
