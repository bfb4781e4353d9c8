// What light samples know of a surface is one word, kept until the scattered ray has found its end: the packed normal of
// the side that reflects, or RECEIVER_ALL_AROUND where both sides do, which no unit vector is packed as.
//!include shared/geometry.wgsl

const RECEIVER_ALL_AROUND = 0x80008000u;

// The normal of the side that receives light; zero where both do.
fn receiver_normal(receiver: u32) -> vec3f {
    if (receiver == RECEIVER_ALL_AROUND) {
        return vec3f(0.0);
    }
    return octahedral_decode(receiver);
}

// The nearest of the normals that have a number: nodes of a grid of so many steps over the octahedral square, row by row, then one for
// all around. The axes are nodes where the steps are divisible by four. `gpu_scene::sky_parts::facings` lists the same.
fn receiver_facing(receiver: u32, steps: u32) -> u32 {
    if (receiver == RECEIVER_ALL_AROUND) {
        return (steps + 1u) * (steps + 1u);
    }
    let node = vec2u(round((unpack2x16snorm(receiver) * 0.5 + 0.5) * f32(steps)));
    return node.y * (steps + 1u) + node.x;
}
