/// Dots in rows: x is 1 on a dot, y the distance from its middle in radii, z a random number of the dot.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale      dots per unit of uv [0.1 .. 1000] [soft 1 .. 64] [log] = 10
/// @param radius     in the room that a dot has [0 .. 0.7] = 0.32
/// @param staggered  whether every other row is shifted by half a dot = true
/// @param randomness how irregular they lie and how large they are [0 .. 1] [percent] = 0
fn userProc(texcoord: vec4f, scale: f32, radius: f32, staggered: bool, randomness: f32) -> vec3f {
    var p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    p.x += select(0.0, 0.5 * modulo(floor(p.y), 2.0), staggered);
    let cell = floor(p);
    let r = random2to3(vec2u(vec2i(cell)));
    let size = max(radius * (1.0 - 0.6 * randomness * r.z), 1e-4);
    // A dot stays within its own room.
    let room = max(0.5 - size, 0.0);
    let d = length(p - cell - 0.5 - 2.0 * randomness * room * (r.xy - 0.5));
    let mask = 1.0 - edgeStep(size, d, pixel);
    let mean = 3.1416 * radius * radius * (1.0 - 0.5 * randomness);
    // From the middle of a room to anywhere in it; what isn't in the middle, or smaller, is farther on the whole.
    let far = 0.383 * (1.0 + 0.75 * randomness) / max(radius, 1e-4);
    return mix(vec3f(saturate(mean), far, 0.5), vec3f(mask, d / size, r.z), octaveSeen(0.6 * pixel));
}
