// One thread per hit with a program.

@compute @workgroup_size(64)
fn proctex(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
           @builtin(local_invocation_index) local: u32) {
    let index = thread_index(workgroup, workgroups, local);
    if (index >= queue_length(QUEUE_PROCTEX)) {
        return;
    }
    let entry = queue_read(QUEUE_PROCTEX, index);
    run_textures(entry, ray_slot(entry & ENTRY_RAY));
}
