/// Four independent random numbers for each instance of a mesh.
/// @group random
/// @param seed other numbers [seed] = 0
fn userProc(seed: u32) -> vec4f {
    let id = u32(readAttr(InstanceId).x + 0.5);
    let r = random2to3(vec2u(id, seed));
    return vec4f(r, random2to1(vec2u(id, seed + 7919u)));
}
