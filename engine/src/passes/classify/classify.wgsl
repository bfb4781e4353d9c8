// Sorts out the hits whose material has a texture program, and those whose program wants ambient occlusion: hits of the
// paths' own rays, surfaces that shadow rays met and that may let them pass, and points of lights that were sampled.
// `entry.wgsl` is the pass.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/programs.wgsl

fn append(ray: u32, material: u32, bits: u32) {
    queue_append(QUEUE_PROCTEX, ray | bits);
    let ao = head_word(material, HEAD_AO);
    if (ao != 0u) {
        queue_append_ao(ray, ao);
    }
}

fn classify_hits(slot: u32) {
    if (has_program_shadows) {
        let shadow = shadow_ray(slot);
        let blocker = rays[shadow].triangle;
        let light = path_words(PATH_LIGHT_POINT, slot);
        if (blocker != MISS && (triangles[blocker].w & TRIANGLE_PROGRAM_ALPHA) != 0u) {
            append(shadow, triangles[blocker].w & TRIANGLE_MATERIAL, 0u);
            // The path waits until its shadow ray is through.
            return;
        }
        if (blocker == MISS && light.x != MISS) {
            // The light is in sight: its point becomes a hit, and the program tells what it emits.
            rays[shadow].triangle = light.x;
            rays[shadow].instance = light.y;
            rays[shadow].barycentrics = bitcast<vec2f>(light.zw);
            path_set_words(PATH_LIGHT_POINT, slot, vec4u(MISS, 0u, 0u, 0u));
            append(shadow, triangles[light.x].w & TRIANGLE_MATERIAL, ENTRY_LIGHT);
        }
    }
    let hit = rays[own_ray(slot)].triangle;
    if (hit == MISS) {
        return;
    }
    let material = triangles[hit].w & TRIANGLE_MATERIAL;
    if (runs_program(materials[material].flags, path_is_last(slot))) {
        append(own_ray(slot), material, 0u);
    }
}
