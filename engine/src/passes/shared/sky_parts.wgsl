// How light samples of the sky are spread over its parts. Where nothing else is known, by what each sends and how much of that a surface
// of that facing receives (in the spirit of Clarberg et al., "Wavelet Importance Sampling", 2005). Where it is known from where which
// parts are seen, in a room through its windows alone, by that too: samples then go where they may arrive, and as many to lamps as may.
// Space is cut into cells that a hash finds, each with a probability for each part; `renderer/irradiance/sky.rs` says where these come
// from. A part is wider than what is seen of it past the frame of a window, so most samples of what is known go through openings, see
// `openings.wgsl`: uniformly over one of them.
//!include shared/frame.wgsl
//!include shared/random.wgsl
//!include shared/abilities.wgsl
//!include shared/environment.wgsl
//!include shared/receiver.wgsl
//!include shared/powers.wgsl
//!include shared/openings.wgsl

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
// The same for each cell, and for each opening in the next texels. In one more the share of the light samples that the sky gets, of
// those the share that goes through openings, and which part of diffusely scattered rays is enough beside them; then the columns of
// `openings.wgsl`.
@group(0) @binding(63) var known_sky: texture_2d<f32>;

const FIRST_OPENING_TEXEL = SKY_PARTS / 4u;
const SHARES_TEXEL = FIRST_OPENING_TEXEL + OPENINGS / 4u;
const FIRST_EXIT_TEXEL = SHARES_TEXEL + 1u;

// Whether that is so.
fn sky_is_known() -> bool {
    return leaves_diffuse && (frame.caches & CACHE_SKY) != 0u;
}

fn sky_shares(row: u32) -> vec3f {
    return textureLoad(known_sky, vec2u(SHARES_TEXEL, row), 0).xyz;
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

// A part of the sky or an opening, and how samples come there.
struct SkyPart {
    index: u32,
    low: f32, // probability of those before
    probability: f32,
}

// Which of those in so many texels of a row a number in [0, 1) chooses; `texels` is a power of two.
fn chosen_in_row(row: u32, first: u32, texels: u32, u: f32) -> SkyPart {
    var texel = 0u;
    var low = 0.0;
    for (var step = texels / 2u; step > 0u; step /= 2u) {
        let before = sky_texel(first + texel + step - 1u, row).w;
        if (u >= before) {
            texel += step;
            low = before;
        }
    }
    let four = sky_texel(first + texel, row);
    var i = 0u;
    while (i < 3u && u >= four[i]) {
        low = four[i];
        i++;
    }
    return SkyPart(4u * texel + i, low, four[i] - low);
}

// The probability of one of them.
fn probability_in_row(row: u32, first: u32, index: u32) -> f32 {
    let texel = index / 4u;
    let four = sky_texel(first + texel, row);
    if (index % 4u != 0u) {
        return four[index % 4u] - four[index % 4u - 1u];
    }
    if (texel == 0u) {
        return four.x;
    }
    return four.x - sky_texel(first + texel - 1u, row).w;
}

// A sample of the environment by a row.
fn parts_sample(u: vec2f, row: u32) -> EnvironmentSample {
    let part = chosen_in_row(row, 0u, SKY_PARTS / 4u, u.x);
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
    return parts_pdf_at(environment_uv(direction), direction, row);
}

// The same where the direction lies there in the environment's picture.
fn parts_pdf_at(uv: vec2f, direction: vec3f, row: u32) -> f32 {
    let cell = min(vec2u(uv * vec2f(frame.distribution_size)), frame.distribution_size - 1u);
    let in_part = cell_pdf(cell + vec2u(0u, frame.distribution_size.y), polar_sine(direction));
    return probability_in_row(row, 0u, sky_part(cell)) * in_part;
}

// Share of the samples of a row that go through openings.
fn openings_share(row: u32) -> f32 {
    if (!sky_is_known()) {
        return 0.0;
    }
    return textureLoad(known_sky, vec2u(SHARES_TEXEL, row), 0).y;
}

// The number of the opening that a ray leaves by, 0 for none.
fn opening_at(exit: Exit) -> u32 {
    let square = exit_square(exit);
    let four = textureLoad(known_sky, vec2u(FIRST_EXIT_TEXEL + square.x / 8u, square.y), 0);
    let two = u32(four[(square.x / 2u) % 4u]);
    return select(two & 0xffu, two >> 8u, (square.x & 1u) != 0u);
}

// First and last corner in squares, each as column + 256 row; the side; one over its area.
fn opening_record(opening: u32) -> vec4f {
    let at = vec2u((opening - 1u) % EXIT_COLUMNS, (opening - 1u) / EXIT_COLUMNS);
    return textureLoad(known_sky, at + vec2u(FIRST_EXIT_TEXEL, FIRST_OPENING_ROW), 0);
}

// pdf per solid angle of samples through openings, in a direction.
fn openings_pdf(origin: vec3f, direction: vec3f, row: u32) -> f32 {
    let exit = exit_of(origin, direction);
    return opening_pdf(exit, opening_at(exit), row);
}

// The same for a ray that leaves the box there, by that opening.
fn opening_pdf(exit: Exit, opening: u32, row: u32) -> f32 {
    if (opening == 0u) {
        return 0.0;
    }
    return probability_in_row(row, FIRST_OPENING_TEXEL, opening - 1u) * opening_record(opening).w
        * exit.distance * exit.distance / exit.cosine;
}

// A direction through an opening.
fn openings_direction(u: vec2f, row: u32, origin: vec3f) -> vec3f {
    let chosen = chosen_in_row(row, FIRST_OPENING_TEXEL, OPENINGS / 4u, u.x);
    let rest = saturate((u.x - chosen.low) / chosen.probability);
    let opening = opening_record(chosen.index + 1u);
    let corners = vec2u(opening.xy);
    let low = vec2f(vec2u(corners.x & 0xffu, corners.x >> 8u));
    let high = vec2f(vec2u(corners.y & 0xffu, corners.y >> 8u));
    let place = mix(low, high, vec2f(rest, u.y)) / f32(EXIT_SQUARES);
    let to = point_of_side(u32(opening.z), place) - origin;
    return to / max(length(to), 1e-20);
}

// A sample of the environment where it is known from where it is seen.
fn seen_sample(u: vec2f, row: u32, origin: vec3f) -> EnvironmentSample {
    let share = openings_share(row);
    var sampled: EnvironmentSample;
    var by_parts = 0.0;
    if (u.x < share) {
        let wi = openings_direction(vec2f(u.x / share, u.y), row, origin);
        let uv = environment_uv(wi);
        sampled = EnvironmentSample(wi, environment_texel(uv), 0.0);
        by_parts = parts_pdf_at(uv, wi, row);
    } else {
        sampled = parts_sample(vec2f(min((u.x - share) / (1.0 - share), 0.99999994), u.y), row);
        by_parts = sampled.pdf;
    }
    sampled.pdf = (1.0 - share) * by_parts;
    if (share > 0.0) {
        sampled.pdf += share * openings_pdf(origin, sampled.wi, row);
    }
    return sampled;
}

// pdf per solid angle of that.
fn seen_pdf(origin: vec3f, direction: vec3f, row: u32) -> f32 {
    let share = openings_share(row);
    var pdf = (1.0 - share) * parts_pdf(direction, row);
    if (share > 0.0) {
        pdf += share * openings_pdf(origin, direction, row);
    }
    return pdf;
}
