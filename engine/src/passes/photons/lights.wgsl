// How much light goes from each lamp to what throws caustics: photons start by that. No passes of a wave.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/environment.wgsl
//!include shared/lights.wgsl
//!include shared/estimator.wgsl
//!include photons/targets.wgsl

// For each light the bits of its weight, and of the sum of all weights up to it; then what `lamp_media` reads.
@group(0) @binding(57) var<storage, read_write> photon_lights: array<vec2u>;

// Samples of the environment by which its power is found.
const ENVIRONMENT_SAMPLES = 4096u;

// About the flux that a light sends to the targets.
fn light_weight(index: u32) -> f32 {
    if (index >= photon_settings.light_count + photon_settings.directional_count) {
        var sum = 0.0;
        for (var i = 0u; i < ENVIRONMENT_SAMPLES; i++) {
            let sampled = environment_sample(independent2(i, 0x51ed270bu));
            if (sampled.pdf > 0.0) {
                sum += luminance(sampled.radiance) / sampled.pdf;
            }
        }
        return sum / f32(ENVIRONMENT_SAMPLES) * disks_of_targets();
    }
    let light = light_at(index);
    if (index >= photon_settings.light_count) {
        let extent = light.position[DISTANT_EXTENT];
        let spread = select(1.0, 2.0 * PI * extent, extent > 0.0);
        return luminance(light.intensity) * spread * disks_of_targets();
    }
    if (light.kind == LIGHT_TRIANGLE) {
        let middle = light.position + (light.direction + light.intensity) / 3.0;
        let area = 0.5 * length(cross(light.direction, light.intensity));
        let material = triangles[light.triangle].w & TRIANGLE_MATERIAL;
        return materials[material].light_radiance * area * angle_of_targets(middle);
    }
    return luminance(light.intensity) * angle_of_targets(light.position);
}

// One thread for each light.
@compute @workgroup_size(64)
fn weigh_lights(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
                @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index < all_lights()) {
        photon_lights[index] = vec2u(bitcast<u32>(max(light_weight(index), 0.0)), 0u);
    }
}

// One thread.
@compute @workgroup_size(1)
fn sum_lights() {
    // Of many small numbers and few large ones: what is lost at one addition is added with the next (Kahan 1965).
    var sum = 0.0;
    var lost = 0.0;
    for (var i = 0u; i < all_lights(); i++) {
        let next = bitcast<f32>(photon_lights[i].x) - lost;
        let total = sum + next;
        lost = (total - sum) - next;
        sum = total;
        photon_lights[i].y = bitcast<u32>(sum);
    }
}
