// Light samples: one light by its power (alias table), one point on it. The Rust twin is `lights::GpuLight`.

struct Light {
    position: vec3f, // of a triangle: its first vertex in the world
    kind: u32,
    direction: vec3f, // where a spot or directional light shines; of a triangle: first edge
    range: f32,
    intensity: vec3f, // of a triangle: second edge
    probability: f32, // of being chosen among lights other than the environment
    alias_index: u32,
    alias_threshold: f32,
    spot_scale: f32, // 1 / (cos inner - cos outer)
    spot_outer: f32, // cos outer
    triangle: u32,
    instance: u32,
    spare0: u32,
    spare1: u32,
}

const LIGHT_TRIANGLE = 0u;
const LIGHT_POINT = 1u;
const LIGHT_SPOT = 2u;
const LIGHT_DIRECTIONAL = 3u;

@group(0) @binding(15) var<storage, read> lights: array<Light>;

struct LightSample {
    wi: vec3f, // to the light, unit
    distance: f32,
    radiance: vec3f, // divided by nothing; of a punctual light: irradiance-like, to be used with pdf
    pdf: f32, // per solid angle, choice of the light included; of a punctual light the choice alone
    delta: bool, // can't be hit by a BSDF sample
    // Where a texture program has yet to tell the radiance: triangle, instance, barycentrics. Else MISS.
    point: vec4u,
}

const FAR = 1e30;

fn light_sample(p: vec3f, choice: f32, u: vec2f) -> LightSample {
    var pick = choice;
    if (has_environment && pick < frame.environment_probability) {
        let e = environment_sample(u);
        return LightSample(e.wi, FAR, e.radiance, frame.environment_probability * e.pdf, false, vec4u(MISS));
    }
    let none = LightSample(vec3f(0.0, 1.0, 0.0), 0.0, vec3f(0.0), 0.0, true, vec4u(MISS));
    if (frame.light_count == 0u) {
        return none;
    }
    let share = 1.0 - frame.environment_probability;
    pick = saturate((pick - frame.environment_probability) / share);
    let chosen = cell_of(pick, frame.light_count, bitcast<u32>(choice) ^ hash(bitcast<u32>(u.x)));
    var index = chosen.index;
    if (chosen.place >= lights[index].alias_threshold) {
        index = lights[index].alias_index;
    }
    let light = lights[index];
    let probability = light.probability * share;

    if (light.kind == LIGHT_TRIANGLE) {
        // Uniform over the triangle (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019).
        var b = vec2f(u.x * 0.5, u.y - u.x * 0.5);
        if (u.y <= u.x) {
            b = vec2f(u.x - u.y * 0.5, u.y * 0.5);
        }
        let normal = cross(light.direction, light.intensity);
        let area = 0.5 * length(normal);
        let to = light.position + light.direction * b.x + light.intensity * b.y - p;
        let distance2 = dot(to, to);
        if (distance2 <= 0.0 || area <= 0.0) {
            return none;
        }
        let distance = sqrt(distance2);
        let wi = to / distance;
        let cosine = -dot(normal, wi) / (2.0 * area) * instances[light.instance].handedness;
        let triangle = triangles[light.triangle];
        let material = triangle.w & TRIANGLE_MATERIAL;
        let two_sided = (materials[material].flags & MATERIAL_DOUBLE_SIDED) != 0u;
        if (abs(cosine) < 1e-7 || (cosine < 0.0 && !two_sided)) {
            return none;
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
        return LightSample(wi, distance, radiance, probability / area * distance2 / abs(cosine), false, point);
    }
    if (light.kind == LIGHT_DIRECTIONAL) {
        return LightSample(-light.direction, FAR, light.intensity, probability, true, vec4u(MISS));
    }
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
    return LightSample(wi, distance, radiance, probability, true, vec4u(MISS));
}

// Power heuristic (Veach 1997, section 9.2.4).
fn mis_weight(pdf: f32, other: f32) -> f32 {
    let a = pdf * pdf;
    return a / (a + other * other);
}
