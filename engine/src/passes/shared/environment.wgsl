// Light from infinitely far away: an equirectangular picture and its sampling table.

@group(0) @binding(19) var environment_image: texture_2d<f32>;
@group(0) @binding(20) var environment_table: texture_2d<u32>; // alias cell, its threshold, pdf over the unit square

// Whether light comes from it.
override has_environment: bool = true;

// Radiance from a direction: bilinear, wrapping in u, clamped in v.
fn environment_radiance(direction: vec3f) -> vec3f {
    if (!has_environment) {
        return vec3f(0.0);
    }
    let uv = environment_uv(direction) * vec2f(frame.environment_size) - 0.5;
    let base = floor(uv);
    let f = uv - base;
    let size = vec2i(frame.environment_size);
    let i = vec2i(base);
    let x0 = (i.x + size.x) % size.x;
    let x1 = (i.x + 1) % size.x;
    let y0 = clamp(i.y, 0, size.y - 1);
    let y1 = clamp(i.y + 1, 0, size.y - 1);
    let top = mix(textureLoad(environment_image, vec2i(x0, y0), 0), textureLoad(environment_image, vec2i(x1, y0), 0), f.x);
    let bottom = mix(textureLoad(environment_image, vec2i(x0, y1), 0), textureLoad(environment_image, vec2i(x1, y1), 0), f.x);
    return mix(top, bottom, f.y).xyz * frame.environment_scale;
}

// u = frac(atan2(x, -z) / 2 pi + turn), v = acos(y) / pi.
fn environment_uv(direction: vec3f) -> vec2f {
    let azimuth = atan2(direction.x, -direction.z) / (2.0 * PI);
    return vec2f(fract(azimuth + frame.environment_turn), acos(clamp(direction.y, -1.0, 1.0)) / PI);
}

// pdf per solid angle of sampling this direction, given that the environment was chosen.
fn environment_pdf(direction: vec3f) -> f32 {
    let uv = environment_uv(direction);
    let cell = min(vec2u(uv * vec2f(frame.distribution_size)), frame.distribution_size - 1u);
    let sine = sqrt(max(1.0 - direction.y * direction.y, 1e-12));
    return bitcast<f32>(textureLoad(environment_table, cell, 0).z) / (2.0 * PI * PI * sine);
}

fn environment_sample(u: vec2f) -> vec3f {
    let count = frame.distribution_size.x * frame.distribution_size.y;
    let chosen = cell_of(u.x, count, bitcast<u32>(u.x) ^ hash(bitcast<u32>(u.y)));
    var cell = chosen.index;
    var place = chosen.place;
    let entry = textureLoad(environment_table, vec2u(cell % frame.distribution_size.x, cell / frame.distribution_size.x), 0);
    let threshold = bitcast<f32>(entry.y);
    if (place >= threshold) {
        cell = entry.x;
        place = (place - threshold) / (1.0 - threshold);
    } else {
        place /= threshold;
    }
    let uv = (vec2f(f32(cell % frame.distribution_size.x), f32(cell / frame.distribution_size.x)) + vec2f(place, u.y))
        / vec2f(frame.distribution_size);
    let theta = uv.y * PI;
    let phi = (uv.x - frame.environment_turn) * 2.0 * PI;
    return vec3f(sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi));
}
