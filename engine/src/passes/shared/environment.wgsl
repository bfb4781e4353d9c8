// Light from infinitely far away: an equirectangular picture and its sampling table.

@group(0) @binding(19) var environment_image: texture_2d<f32>;
// Alias cell (column | row << 16), its threshold, pdf over the unit square. Then as many rows once more: the same among the cells of each part of the sky,
// see sky_parts.wgsl, with columns and rows inside of it.
@group(0) @binding(20) var environment_table: texture_2d<u32>;

// Whether light comes from it.
override has_environment: bool = true;

// Radiance from a direction.
fn environment_radiance(direction: vec3f) -> vec3f {
    if (has_environment && sky_is_constant()) {
        return constant_sky_radiance();
    }
    return environment_texel(environment_uv(direction));
}

// Whether it is the same in all directions.
fn sky_is_constant() -> bool {
    return all(frame.environment_size == vec2u(1u));
}

fn constant_sky_radiance() -> vec3f {
    return textureLoad(environment_image, vec2u(0u), 0).xyz * frame.environment_scale;
}

// Radiance at a point of the picture, both in [0, 1]: bilinear, wrapping in u, clamped in v.
fn environment_texel(picture: vec2f) -> vec3f {
    if (!has_environment) {
        return vec3f(0.0);
    }
    if (sky_is_constant()) {
        return constant_sky_radiance();
    }
    let uv = picture * vec2f(frame.environment_size) - 0.5;
    let base = floor(uv);
    let f = uv - base;
    let size = vec2i(frame.environment_size);
    let i = vec2i(base);
    let x0 = select(i.x, size.x - 1, i.x < 0);
    let x1 = select(i.x + 1, 0, i.x + 1 >= size.x);
    let y0 = clamp(i.y, 0, size.y - 1);
    let y1 = clamp(i.y + 1, 0, size.y - 1);
    let top = mix(textureLoad(environment_image, vec2i(x0, y0), 0), textureLoad(environment_image, vec2i(x1, y0), 0), f.x);
    let bottom = mix(textureLoad(environment_image, vec2i(x0, y1), 0), textureLoad(environment_image, vec2i(x1, y1), 0), f.x);
    return mix(top, bottom, f.y).xyz * frame.environment_scale;
}

// u = frac(atan2(x, -z) / 2 pi + turn), v = acos(y) / pi. Drivers' acos is off by up to 2e-4, which shows in sharp
// pictures; from a sine, atan2 is ten times as exact, at the poles too.
fn environment_uv(direction: vec3f) -> vec2f {
    let azimuth = atan2(direction.x, -direction.z) / (2.0 * PI);
    let polar = atan2(polar_sine(direction), direction.y) / PI;
    return vec2f(fract(azimuth + frame.environment_turn), polar);
}

// Sine of the angle to the vertical.
fn polar_sine(direction: vec3f) -> f32 {
    return length(direction.xz);
}

// pdf per solid angle inside a cell, where the polar angle has this sine.
fn cell_pdf(cell: vec2u, sine: f32) -> f32 {
    return bitcast<f32>(textureLoad(environment_table, cell, 0).z) / (2.0 * PI * PI * max(sine, 1e-6));
}

struct EnvironmentSample {
    wi: vec3f,
    radiance: vec3f,
    pdf: f32, // per solid angle
}

// A cell of a table, and a place inside it along one side.
struct TableCell {
    at: vec2u, // column and row
    place: f32, // in [0, 1)
}

// A cell by its number, row by row. Tables have at most 2^19 cells: a quotient of floats is exact enough, and integers are slow to divide.
fn table_cell(cell: Cell, width: u32) -> TableCell {
    let row = u32((f32(cell.index) + 0.5) / f32(width));
    return TableCell(vec2u(cell.index - row * width, row), cell.place);
}

// What an alias table makes of one of its cells.
fn alias_choice(chosen: TableCell, entry: vec4u) -> TableCell {
    let threshold = bitcast<f32>(entry.y);
    if (chosen.place >= threshold) {
        return TableCell(vec2u(entry.x & 0xffffu, entry.x >> 16u), (chosen.place - threshold) / (1.0 - threshold));
    }
    return TableCell(chosen.at, chosen.place / threshold);
}

fn environment_sample(u: vec2f) -> EnvironmentSample {
    let size = frame.distribution_size;
    let first = table_cell(cell_of(u.x, size.x * size.y, bitcast<u32>(u.x) ^ hash(bitcast<u32>(u.y))), size.x);
    let chosen = alias_choice(first, textureLoad(environment_table, first.at, 0));
    return sample_in_cell(chosen.at, vec2f(chosen.place, u.y), chosen.at);
}

// The sample at a place inside a cell, whose pdf a row of the table tells. Radiance and pdf are those of the cell that was chosen. Found
// again from the direction, they would be a neighbour's where sines and atan2 are off by a little, and beside a lamp that neighbour may
// be darker by orders of magnitude.
fn sample_in_cell(cell: vec2u, place: vec2f, entry: vec2u) -> EnvironmentSample {
    let uv = (vec2f(cell) + place) / vec2f(frame.distribution_size);
    let polar = unit_circle(0.5 * uv.y);
    let azimuth = unit_circle(uv.x - frame.environment_turn);
    let wi = vec3f(polar.y * azimuth.y, polar.x, -polar.y * azimuth.x);
    return EnvironmentSample(wi, environment_texel(uv), cell_pdf(entry, polar.y));
}

// A direction to a sky that is the same everywhere, for a surface that receives light on the side of `normal`, by the cosine there; from
// anywhere where that is zero.
fn constant_sky_sample(u: vec2f, normal: vec3f) -> EnvironmentSample {
    let turned = unit_circle(u.y);
    if (all(normal == vec3f(0.0))) {
        let z = 1.0 - 2.0 * u.x;
        let wi = vec3f(sqrt(saturate(1.0 - z * z)) * turned, z);
        return EnvironmentSample(wi, constant_sky_radiance(), constant_sky_pdf(wi, normal));
    }
    let tangent = any_perpendicular(normal);
    let around = sqrt(u.x) * turned;
    let wi = tangent * around.x + cross(normal, tangent) * around.y + normal * sqrt(1.0 - u.x);
    return EnvironmentSample(wi, constant_sky_radiance(), constant_sky_pdf(wi, normal));
}

// pdf per solid angle of that.
fn constant_sky_pdf(direction: vec3f, normal: vec3f) -> f32 {
    if (all(normal == vec3f(0.0))) {
        return 1.0 / (4.0 * PI);
    }
    return max(dot(direction, normal), 0.0) / PI;
}
