// Light samples: one light by the light tree or, of those far away, by its power, and one point on it. The Rust twin is
// `lights::GpuLight`.

struct Light {
    position: vec3f, // of a triangle: its first vertex in the world; of a directional light: see DISTANT_ below
    kind: u32,
    direction: vec3f, // where a spot or directional light shines; of a triangle: first edge
    range: f32, // of a triangle: its share of the area of its lamp
    intensity: vec3f, // of a triangle: second edge
    leaf: u32, // its lamp's node in the light tree; of a directional light: what the alias table has instead
    triangle: u32, // of others the group of lights
    instance: u32,
    spot_scale: f32, // 1 / (cos inner - cos outer); of a triangle: the bits are the number of the lamp's other one
    spot_outer: f32, // cos outer
}

const LIGHT_TRIANGLE = 0u;
const LIGHT_POINT = 1u;
const LIGHT_SPOT = 2u;
const LIGHT_DIRECTIONAL = 3u;

// Components of a directional light's `position`.
const DISTANT_PROBABILITY = 0u; // of being chosen among its like
const DISTANT_THRESHOLD = 1u; // of the alias table
const DISTANT_EXTENT = 2u; // 1 - cos of the angular radius; 0: all light comes from one direction

// 64 bytes a record: `frame.light_count` lights with a place, of them the triangles first, by instance and triangle; then
// `frame.directional_count` directional ones; then the nodes of the light tree.
@group(0) @binding(15) var<storage, read> lights: array<array<vec4u, 4>>;
//!include shared/receiver.wgsl
//!include shared/light_tree.wgsl
//!include shared/sky_parts.wgsl

fn light_at(index: u32) -> Light {
    let w = lights[index];
    return Light(bitcast<vec3f>(w[0].xyz), w[0].w, bitcast<vec3f>(w[1].xyz), bitcast<f32>(w[1].w),
        bitcast<vec3f>(w[2].xyz), w[2].w, w[3].x, w[3].y, bitcast<f32>(w[3].z), bitcast<f32>(w[3].w));
}

struct LightSample {
    wi: vec3f, // to the light, unit
    distance: f32,
    radiance: vec3f, // divided by nothing; of a punctual light: irradiance-like, to be used with pdf
    pdf: f32, // per solid angle, choice of the light included; of a punctual light the choice alone
    delta: bool, // can't be hit by a BSDF sample
    // Where a texture program has yet to tell the radiance: triangle, instance, barycentrics. Else MISS.
    point: vec4u,
    group: u32, // of lights
}

// The environment, directional lights and lights with a place get equal shares of the samples, as far as there are any.
fn light_groups() -> u32 {
    return u32(frame.environment_probability > 0.0) + min(frame.directional_count, 1u) + min(frame.light_count, 1u);
}

// How light samples are spread at a place from which rays start.
struct LightShares {
    environment: f32,
    other: f32, // of each of the other groups
    rays: f32, // of those that a surface scatters diffusely, and that find only what is sampled as well, the part that is enough
    sky_row: u32, // of the parts of the sky, see sky_parts.wgsl
}

// `receiver` is the side that receives light, `id` the path.
fn light_shares(origin: vec3f, receiver: u32, id: PathId) -> LightShares {
    var shares = LightShares(frame.environment_probability, 1.0 / f32(max(light_groups(), 1u)), 1.0, 0u);
    if (sky_is_known()) {
        shares.sky_row = sky_row(origin, receiver, id);
        let of_sky = sky_shares(shares.sky_row);
        shares.environment = of_sky.x;
        shares.rays = of_sky.z;
        shares.other = (1.0 - shares.environment) / f32(max(light_groups(), 2u) - 1u);
    } else {
        shares.sky_row = receiver_facing(receiver, FACING_STEPS);
    }
    return shares;
}

// Whether a sky that is the same in all directions is sampled as such.
fn sky_is_plain() -> bool {
    return sky_is_constant();
}

// pdf per solid angle of light samples of the environment in a direction from `origin`, its choice included.
fn sky_pdf(origin: vec3f, direction: vec3f, receiver: u32, shares: LightShares) -> f32 {
    if (sky_is_known()) {
        return shares.environment * seen_pdf(origin, direction, shares.sky_row);
    }
    if (sky_is_plain()) {
        return shares.environment * constant_sky_pdf(direction, receiver_normal(receiver));
    }
    return shares.environment * parts_pdf(direction, shares.sky_row);
}

fn sky_sample(u: vec2f, origin: vec3f, receiver: u32, shares: LightShares) -> EnvironmentSample {
    if (sky_is_known()) {
        return seen_sample(u, shares.sky_row, origin);
    }
    if (sky_is_plain()) {
        return constant_sky_sample(u, receiver_normal(receiver));
    }
    return parts_sample(u, shares.sky_row);
}

// A light for the surface point `p`. `origin` is where scattered rays start: the density of what they hit is found from
// there, so that this does so too. `receiver` is the side that receives light, `shares` what `light_shares` says of both.
fn light_sample(p: vec3f, origin: vec3f, receiver: u32, shares: LightShares, choice: f32, u: vec2f) -> LightSample {
    var pick = choice;
    if (has_environment && pick < shares.environment) {
        let e = sky_sample(u, origin, receiver, shares);
        return LightSample(e.wi, FAR, e.radiance, shares.environment * e.pdf, false, vec4u(MISS), frame.environment_group);
    }
    pick -= shares.environment;
    let salt = bitcast<u32>(choice) ^ hash(bitcast<u32>(u.x));
    if (frame.directional_count > 0u) {
        if (pick < shares.other || frame.light_count == 0u) {
            return directional_sample(saturate(pick / shares.other), shares.other, salt, u);
        }
        pick -= shares.other;
    }
    if (frame.light_count == 0u) {
        return no_light();
    }
    let chosen = choose_light(origin, receiver_normal(receiver), saturate(pick / shares.other), salt);
    if (chosen.probability <= 0.0) {
        return no_light();
    }
    let light = light_at(chosen.index);
    let probability = chosen.probability * shares.other;
    if (light.kind == LIGHT_TRIANGLE) {
        return lamp_sample(light, probability, p, u);
    }
    return punctual_sample(light, probability, p);
}

// A point of a lamp of one or two triangles, uniform over both; `light` is the first of them.
fn lamp_sample(light: Light, probability: f32, p: vec3f, u: vec2f) -> LightSample {
    var chosen = light;
    var place = u.x;
    if (light.range < 1.0) {
        if (u.x < light.range) {
            place = u.x / light.range;
        } else {
            place = (u.x - light.range) / (1.0 - light.range);
            chosen = light_at(bitcast<u32>(light.spot_scale));
        }
        place = min(place, 0.99999994);
    }
    return triangle_sample(chosen, probability * chosen.range, p, vec2f(place, u.y));
}

fn no_light() -> LightSample {
    return LightSample(vec3f(0.0, 1.0, 0.0), 0.0, vec3f(0.0), 0.0, true, vec4u(MISS), 0u);
}

fn directional_sample(pick: f32, share: f32, salt: u32, u: vec2f) -> LightSample {
    let cell = cell_of(pick, frame.directional_count, salt);
    var light = light_at(frame.light_count + cell.index);
    if (cell.place >= light.position[DISTANT_THRESHOLD]) {
        light = light_at(frame.light_count + light.leaf);
    }
    let probability = light.position[DISTANT_PROBABILITY] * share;
    let extent = light.position[DISTANT_EXTENT];
    if (extent <= 0.0) {
        return LightSample(-light.direction, FAR, light.intensity, probability, true, vec4u(MISS), light.triangle);
    }
    // Uniform over the cone.
    let height = u.x * extent;
    let sine = sqrt(height * (2.0 - height));
    let tangent = any_perpendicular(light.direction);
    let bitangent = cross(light.direction, tangent);
    let turn = unit_circle(u.y);
    let wi = (tangent * turn.x + bitangent * turn.y) * sine - light.direction * (1.0 - height);
    let pdf = probability * disk_pdf(extent);
    return LightSample(normalize(wi), FAR, light.intensity, pdf, false, vec4u(MISS), light.triangle);
}

// pdf per solid angle inside a cone.
fn disk_pdf(extent: f32) -> f32 {
    return 1.0 / (2.0 * PI * extent);
}

// What disks in the sky give to a ray.
struct DiskLight {
    radiance: vec3f,
    group: u32, // of lights: that of the last disk, where they overlap
}

// Radiance of the disks in the sky that a ray meets, weighed against their own samples, of which each has a share. `bsdf_pdf` is 0 for
// camera rays.
fn disk_radiance(direction: vec3f, bsdf_pdf: f32, share: f32) -> DiskLight {
    var sum = DiskLight(vec3f(0.0), 0u);
    for (var i = 0u; i < frame.directional_count; i++) {
        let light = light_at(frame.light_count + i);
        let extent = light.position[DISTANT_EXTENT];
        let off = direction + light.direction;
        // 1 - cos of the angle to its middle.
        if (extent > 0.0 && 0.5 * dot(off, off) <= extent) {
            let light_pdf = light.position[DISTANT_PROBABILITY] * share * disk_pdf(extent);
            sum.radiance += light.intensity * met_light_weight(bsdf_pdf, light_pdf);
            sum.group = light.triangle;
        }
    }
    return sum;
}

// Weights of a triangle's second and third vertex, uniform over it (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019).
fn triangle_point(u: vec2f) -> vec2f {
    if (u.y <= u.x) {
        return vec2f(u.x - u.y * 0.5, u.y * 0.5);
    }
    return vec2f(u.x * 0.5, u.y - u.x * 0.5);
}

fn triangle_sample(light: Light, probability: f32, p: vec3f, u: vec2f) -> LightSample {
    let b = triangle_point(u);
    let normal = cross(light.direction, light.intensity);
    let area = 0.5 * length(normal);
    let to = light.position + light.direction * b.x + light.intensity * b.y - p;
    let distance2 = dot(to, to);
    if (distance2 <= 0.0 || area <= 0.0) {
        return no_light();
    }
    let distance = sqrt(distance2);
    let wi = to / distance;
    let cosine = -dot(normal, wi) / (2.0 * area) * instances[light.instance].handedness;
    let triangle = triangles[light.triangle];
    let material = triangle.w & TRIANGLE_MATERIAL;
    let two_sided = (materials[material].flags & MATERIAL_DOUBLE_SIDED) != 0u;
    if (abs(cosine) < 1e-7 || (cosine < 0.0 && !two_sided)) {
        return no_light();
    }
    var point = vec4u(MISS);
    var radiance = vec3f(1.0);
    if ((materials[material].flags & MATERIAL_PROGRAM_LIGHT) != 0u) {
        point = vec4u(light.triangle, light.instance, bitcast<vec2u>(b));
    } else {
        radiance = materials[material].emission
            * material_texture(material, TEXTURE_EMISSION, triangle, barycentric_weights(b)).xyz;
    }
    if ((triangle.w & TRIANGLE_ALPHA) != 0u) {
        // Scattered rays find the lamp only where it is there.
        radiance *= material_coverage(material, triangle, barycentric_weights(b));
    }
    let pdf = probability / area * distance2 / abs(cosine);
    return LightSample(wi, distance, radiance, pdf, false, point, light_group(materials[material].flags));
}

fn punctual_sample(light: Light, probability: f32, p: vec3f) -> LightSample {
    let to = light.position - p;
    let distance2 = max(dot(to, to), 1e-20);
    let distance = sqrt(distance2);
    let wi = to / distance;
    var radiance = light.intensity / distance2;
    // KHR_lights_punctual: a window that falls to zero at the range, and the spot's cone.
    let ratio = distance / light.range;
    let window = saturate(1.0 - ratio * ratio * ratio * ratio);
    radiance *= window;
    if (light.kind == LIGHT_SPOT) {
        let cone = saturate((dot(light.direction, -wi) - light.spot_outer) * light.spot_scale);
        radiance *= cone * cone;
    }
    return LightSample(wi, distance, radiance, probability, true, vec4u(MISS), light.triangle);
}

// The number of a triangle's light; `frame.light_count` where it is none.
fn light_of(instance: u32, triangle: u32) -> u32 {
    var low = 0u;
    var high = frame.light_count;
    while (low < high) {
        let middle = (low + high) / 2u;
        let kind = lights[middle][0].w;
        let place = lights[middle][3].xy; // triangle and instance
        if (kind == LIGHT_TRIANGLE && (place.y < instance || (place.y == instance && place.x < triangle))) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    if (low < frame.light_count) {
        let found = light_at(low);
        if (found.kind == LIGHT_TRIANGLE && found.instance == instance && found.triangle == triangle) {
            return low;
        }
    }
    return frame.light_count;
}

// pdf per solid angle with which `light_sample` finds the point of an emissive triangle that a scattered ray has hit, at
// an angle of this cosine, where lights with a place have that share.
fn light_hit_pdf(hit: RayHit, receiver: u32, cosine: f32, share: f32) -> f32 {
    let index = light_of(hit.instance, hit.triangle);
    if (index == frame.light_count) {
        return 0.0;
    }
    let light = light_at(index);
    let area = 0.5 * length(cross(light.direction, light.intensity));
    let probability = light_probability(light.leaf, hit.origin, receiver_normal(receiver)) * share * light.range;
    return probability / area * hit.t_max * hit.t_max / cosine;
}

// Power heuristic (Veach 1997, section 9.2.4).
fn mis_weight(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf; // squares of densities may be too large for a number
    return 1.0 / (1.0 + ratio * ratio);
}
