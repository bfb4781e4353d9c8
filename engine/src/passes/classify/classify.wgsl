// Sorts out the hits whose material has a texture program, and those whose program wants ambient occlusion.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/queues.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/programs.wgsl

@compute @workgroup_size(64)
fn classify(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
            @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_ACTIVE)) {
        return;
    }
    let slot = queue_read(QUEUE_ACTIVE, index);
    let hit = rays[slot].triangle;
    if (hit == MISS) {
        return;
    }
    let material = triangles[hit].w & TRIANGLE_MATERIAL;
    if (!runs_program(materials[material].flags, bounce_number())) {
        return;
    }
    queue_append(QUEUE_PROCTEX, slot);
    let ao = head_word(material, HEAD_AO);
    if (ao != 0u) {
        atomicStore(&queues[ao_word(slot)], 0u);
        queue_append(QUEUE_AO, slot | (ao << 28u));
    }
}
