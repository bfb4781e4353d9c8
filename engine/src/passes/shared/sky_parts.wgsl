// How light samples of the sky are spread over its parts. Where nothing else is known, by what each sends and how much of that a surface
// of that facing receives (in the spirit of Clarberg et al., "Wavelet Importance Sampling", 2005). Where it is known from where which
// parts are seen, in a room through its windows alone, by that too: samples then go where they may arrive, and as many to lamps as may.
// Space is cut into cells that a hash finds, each with a probability for each part; `renderer/irradiance/sky.rs` says where these come
// from.
//!include shared/frame.wgsl
//!include shared/random.wgsl
//!include shared/abilities.wgsl
//!include shared/environment.wgsl
//!include shared/receiver.wgsl
//!include shared/powers.wgsl

// Parts of the sky: as many columns and rows of its picture. The Rust twins are in `gpu_scene::sky_parts`.
const SKY_COLUMNS = 32u;
const SKY_ROWS = 16u;
const SKY_PARTS = 512u;
// Cells; where two places share one, both are served worse, but not wrongly.
const SKY_CELLS = 8192u;
// Steps of the grids of normals, see `receiver_facing`: without and with cells.
const FACING_STEPS = 16u;
const CELL_FACING_STEPS = 4u;

// A row for each facing: in each texel, for four parts, the probability that a sample goes there or to a part before.
@group(0) @binding(65) var facing_sky: texture_2d<f32>;
// The same for each cell, and in one more texel the share of the light samples that the sky gets.
@group(0) @binding(63) var known_sky: texture_2d<f32>;

// Whether that is so.
fn sky_is_known() -> bool {
    return leaves_diffuse && (frame.caches & CACHE_SKY) != 0u;
}

fn sky_share(row: u32) -> f32 {
    return textureLoad(known_sky, vec2u(SKY_PARTS / 4u, row), 0).x;
}

// Four parts of a row of the one or the other.
fn sky_texel(texel: u32, row: u32) -> vec4f {
    if (sky_is_known()) {
        return textureLoad(known_sky, vec2u(texel, row), 0);
    }
    return textureLoad(facing_sky, vec2u(texel, row), 0);
}

// The row of a point from which rays start, for a side that receives light. It is that of the point's cell or of a neighbour's, by the
// numbers of the path, so that no border shows.
fn sky_row(origin: vec3f, receiver: u32, id: PathId) -> u32 {
    return hash2(sky_cell(origin, id, 1.0), receiver_facing(receiver, CELL_FACING_STEPS)) % SKY_CELLS;
}

// The row of a cell so many times as wide, a power of two, for all sides.
fn wider_sky_row(origin: vec3f, id: PathId, wider: f32) -> u32 {
    return sky_cell(origin, id, wider) % SKY_CELLS;
}

fn sky_cell(origin: vec3f, id: PathId, wider: f32) -> u32 {
    let wanted = max(distance(origin, frame.camera_position) * frame.sky_cell_scale, frame.bounds_radius * 0.015625);
    let side = power_of_two_below(wanted) * wider;
    let stream = hash2(id.key, id.sample ^ 0x3c6ef372u);
    let moved = vec3f(
        f32(stream & 1023u),
        f32((stream >> 10u) & 1023u),
        f32((stream >> 20u) & 1023u)) * (1.0 / 1024.0);
    let place = vec3i(floor(origin / side + moved));
    return hash2(hash2(hash2(hash(bitcast<u32>(side)), bitcast<u32>(place.x)), bitcast<u32>(place.y)), bitcast<u32>(place.z));
}

// The part of the sky that a cell of the environment's table lies in.
fn sky_part(cell: vec2u) -> u32 {
    let place = cell * vec2u(SKY_COLUMNS, SKY_ROWS) / frame.distribution_size;
    return place.y * SKY_COLUMNS + place.x;
}

// A part of the sky, and how samples come there.
struct SkyPart {
    index: u32,
    low: f32, // probability of the parts before
    probability: f32,
}

// The part that a number in [0, 1) chooses.
fn chosen_sky_part(row: u32, u: f32) -> SkyPart {
    var texel = 0u;
    var low = 0.0;
    for (var step = SKY_PARTS / 8u; step > 0u; step /= 2u) {
        let before = sky_texel(texel + step - 1u, row).w;
        if (u >= before) {
            texel += step;
            low = before;
        }
    }
    let four = sky_texel(texel, row);
    var i = 0u;
    while (i < 3u && u >= four[i]) {
        low = four[i];
        i++;
    }
    return SkyPart(4u * texel + i, low, four[i] - low);
}

// The probability of a part.
fn sky_part_probability(row: u32, part: u32) -> f32 {
    let texel = part / 4u;
    let four = sky_texel(texel, row);
    if (part % 4u != 0u) {
        return four[part % 4u] - four[part % 4u - 1u];
    }
    if (texel == 0u) {
        return four.x;
    }
    return four.x - sky_texel(texel - 1u, row).w;
}

// A sample of the environment by a row.
fn parts_sample(u: vec2f, row: u32) -> EnvironmentSample {
    let part = chosen_sky_part(row, u.x);
    let grid = vec2u(SKY_COLUMNS, SKY_ROWS);
    let at = vec2u(part.index % SKY_COLUMNS, part.index / SKY_COLUMNS);
    let corner = (at * frame.distribution_size + grid - 1u) / grid;
    let size = ((at + 1u) * frame.distribution_size + grid - 1u) / grid - corner;
    // Few bits of the number that has chosen the part are left; a hash refills them.
    let salt = bitcast<u32>(u.x) ^ hash(bitcast<u32>(u.y));
    let rest = (u.x - part.low + unit_number(hash(~salt)) * (1.0 / 16777216.0)) / part.probability;
    let first = table_cell(cell_of(clamp(rest, 0.0, 0.99999994), size.x * size.y, salt), size.x);
    let below = vec2u(0u, frame.distribution_size.y);
    let chosen = alias_choice(first, textureLoad(environment_table, corner + first.at + below, 0));
    let cell = corner + chosen.at;
    var sampled = sample_in_cell(cell, vec2f(chosen.place, u.y), cell + below);
    sampled.pdf *= part.probability;
    return sampled;
}

// pdf per solid angle of that.
fn parts_pdf(direction: vec3f, row: u32) -> f32 {
    let uv = environment_uv(direction);
    let cell = min(vec2u(uv * vec2f(frame.distribution_size)), frame.distribution_size - 1u);
    let in_part = cell_pdf(cell + vec2u(0u, frame.distribution_size.y), polar_sine(direction));
    return sky_part_probability(row, sky_part(cell)) * in_part;
}
