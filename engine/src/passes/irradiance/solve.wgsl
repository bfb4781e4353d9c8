// Makes records of what their gather rays have found. One thread for each new record.
//!include shared/frame.wgsl
//!include shared/geometry.wgsl
//!include shared/microfacet.wgsl
//!include irradiance/records.wgsl

@group(0) @binding(51) var<storage, read_write> irradiance_records: array<vec4u>;
@group(0) @binding(55) var<storage, read> irradiance_gathered: array<vec4f>;

// Least and most radius, in pixels.
const LEAST_WIDTHS = 1.5;
const MOST_WIDTHS = 48.0;

// Rays of the first half of turns and those of the second know nothing of each other: what the two find differs by noise, theirs and that of the
// cells that they end in. So records know both, and each half of a picture's samples takes its own: the picture's halves differ by the records'
// noise, too.

// What the rays of a stratum have found on average: radiance, and the distance as harmonic mean.
fn gathered(ray: u32) -> vec4f {
    let sum = irradiance_gathered[ray];
    let turns = f32(irradiance_settings.turns);
    return vec4f(sum.xyz / turns, turns / sum.w);
}

// Where a ring begins, as the square of the sine.
fn ring_start(ring: u32) -> f32 {
    return f32(ring) / f32(irradiance_settings.rings);
}

@compute @workgroup_size(64)
fn solve_irradiance(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                    @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    let record = irradiance_settings.first_record + index;
    if (record >= irradiance_settings.end_record) {
        return;
    }
    let at = record * RECORD_WORDS;
    let first = index * gather_rays();
    if (irradiance_settings.solved == SOLVE_FIRST_HALF) {
        var sum = vec3f(0.0);
        for (var ray = 0u; ray < gather_rays(); ray++) {
            sum += irradiance_gathered[first + ray].xyz;
        }
        irradiance_records[at + 2u] = vec4u(bitcast<vec3u>(sum), 0u);
        return;
    }
    let normal = octahedral_decode(irradiance_records[at + 1u].w);
    let tangent = any_perpendicular(normal);
    let bitangent = cross(normal, tangent);

    var sum = vec3f(0.0);
    var inverse = 0.0; // sum of one over the distances
    var unlike = 0.0; // squares of what neighbouring strata differ by
    // Of each channel, along tangent and bitangent.
    var along_x = vec3f(0.0);
    var along_y = vec3f(0.0);
    var bands: array<vec3f, 9>;
    for (var sector = 0u; sector < irradiance_settings.sectors; sector++) {
        let before = (sector + irradiance_settings.sectors - 1u) % irradiance_settings.sectors;
        let middle = unit_circle((f32(sector) + 0.5) / f32(irradiance_settings.sectors));
        let border = unit_circle(f32(sector) / f32(irradiance_settings.sectors));
        var outward = vec3f(0.0);
        var across = vec3f(0.0);
        for (var ring = 0u; ring < irradiance_settings.rings; ring++) {
            let here = gathered(first + ring * irradiance_settings.sectors + sector);
            sum += here.xyz;
            inverse += 1.0 / max(here.w, 1e-6);
            let begin = ring_start(ring);
            let end = ring_start(ring + 1u);
            // Steps of radiance move where the place moves, the nearer side of them most.
            if (ring > 0u) {
                let inner = gathered(first + (ring - 1u) * irradiance_settings.sectors + sector);
                outward += (here.xyz - inner.xyz) * (sqrt(begin) * (1.0 - begin) / max(min(here.w, inner.w), 1e-6));
            }
            let side = gathered(first + ring * irradiance_settings.sectors + before);
            let step = luminance(here.xyz - side.xyz);
            unlike += step * step;
            across += (here.xyz - side.xyz) * ((sqrt(end) - sqrt(begin)) / max(min(here.w, side.w), 1e-6));

            let angle = (sqrt(1.0 - begin) - sqrt(1.0 - end)) * (2.0 * PI / f32(irradiance_settings.sectors));
            let cosine = 0.5 * (sqrt(1.0 - begin) + sqrt(1.0 - end));
            let sine = sqrt(1.0 - cosine * cosine);
            let direction = tangent * (middle.x * sine) + bitangent * (middle.y * sine) + normal * cosine;
            let basis = harmonics(direction);
            for (var i = 0u; i < 9u; i++) {
                bands[i] += here.xyz * (basis[i] * angle);
            }
        }
        outward *= 2.0 * PI / f32(irradiance_settings.sectors);
        along_x += outward * middle.x - across * border.y;
        along_y += outward * middle.y + across * border.x;
    }
    let irradiance = sum * (PI / f32(gather_rays()));
    let width = max(bitcast<f32>(irradiance_records[at + 8u].w), 1e-9);
    var radius = irradiance_settings.radius_share * f32(gather_rays()) / max(inverse, 1e-30);
    let steepest = max(length(vec2f(luminance(along_x), luminance(along_y))), 1e-30);
    // As small as may be where no ray has found anything: beside it may lie what the sun throws there by way of a table.
    radius = min(radius, irradiance_settings.most_change * luminance(irradiance) / steepest);
    let kept = clamp(radius, LEAST_WIDTHS * width, MOST_WIDTHS * width);
    // Where the radius had to grow, what is near would make the gradient too steep for it.
    let calmer = min(1.0, radius / kept);

    irradiance_records[at].w = bitcast<u32>(kept);
    irradiance_records[at + 1u] = vec4u(bitcast<vec3u>(irradiance), irradiance_records[at + 1u].w);
    let red = (tangent * along_x.x + bitangent * along_y.x) * calmer;
    let green = (tangent * along_x.y + bitangent * along_y.y) * calmer;
    let blue = (tangent * along_x.z + bitangent * along_y.z) * calmer;
    // Were neighbouring strata alike but for their noise, the irradiance would be wrong by this: standard error, of itself.
    let error = sqrt(0.5 * unlike) * (PI / f32(gather_rays())) / max(luminance(irradiance), 1e-30);
    var difference = vec3f(0.0);
    if (irradiance_settings.solved == SOLVE_HALVES) {
        let of_half = bitcast<vec3f>(irradiance_records[at + 2u].xyz) * (2.0 * PI / f32(gather_rays() * irradiance_settings.turns));
        difference = of_half - irradiance;
    }
    irradiance_records[at + 2u] = bitcast<vec4u>(vec4f(difference, min(error, 1.0)));
    irradiance_records[at + 3u] = bitcast<vec4u>(vec4f(red, green.x));
    irradiance_records[at + 4u] = bitcast<vec4u>(vec4f(green.yz, blue.xy));
    // Radiance to irradiance, band by band, over the irradiance itself.
    let scale = 1.0 / max(max_component(irradiance), 1e-30);
    let own = harmonics(normal);
    var others = vec3f(0.0);
    for (var i = 0u; i < 9u; i++) {
        let of_band = select(select(0.25 * PI, 2.0 * PI / 3.0, i < 4u), PI, i < 1u);
        bands[i] = clamp(bands[i] * of_band * scale, vec3f(-MOST_HARMONIC), vec3f(MOST_HARMONIC));
        others += select(bands[i] * own[i], vec3f(0.0), i == 0u);
    }
    bands[0] = irradiance * scale - others;
    var words: array<u32, 16>;
    words[0] = bitcast<u32>(blue.z);
    for (var i = 0u; i < 27u; i++) {
        let band = i / 3u;
        let number = pack2x16snorm(vec2f(bands[band][i % 3u] / MOST_HARMONIC, 0.0));
        words[1u + i / 2u] |= (number & 0xffffu) << (16u * (i & 1u));
    }
    words[15] = (bitcast<u32>(width) & 0xffffff00u) | u32(255.0 * calmer);
    for (var i = 0u; i < 4u; i++) {
        irradiance_records[at + 5u + i] = vec4u(words[4u * i], words[4u * i + 1u], words[4u * i + 2u], words[4u * i + 3u]);
    }
}
