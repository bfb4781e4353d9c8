/// Threads over and under each other: x is the height (0 between the threads), y 1 on the warp and 0 on the weft, z a random
/// number of the thread.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale   threads per unit of uv [0.1 .. 2000] [soft 5 .. 400] [log] = 24
/// @param over    each thread goes over so many [1 .. 8] = 1
/// @param under   and then under so many [1 .. 8] = 1
/// @param shift   each thread begins so many later: 1 is plain or twill [0 .. 8] = 1
/// @param width   width of a thread, of the room it has [0.1 .. 1] [percent] = 0.85
fn userProc(texcoord: vec4f, scale: f32, over: u32, under: u32, shift: u32, width: f32) -> vec3f {
    let p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    let cell = floor(p);
    let f = p - cell - 0.5;
    let period = f32(max(over, 1u) + max(under, 1u));
    let phase = modulo(cell.x + f32(shift) * cell.y, period);
    let warp_on_top = phase < f32(max(over, 1u));
    // Where a thread meets its opposite beside it, it bends down.
    let warp = thread(f.x, f.y, width, warp_on_top);
    let weft = thread(f.y, f.x, width, !warp_on_top);
    let on_warp = warp > weft;
    let height = max(warp, weft);
    let number = random2to1(select(vec2u(vec2i(vec2f(cell.y, -1.0))), vec2u(vec2i(vec2f(cell.x, -2.0))), on_warp));
    let seen = octaveSeen(0.7 * pixel);
    let share = f32(max(over, 1u)) / period;
    // Where only one of both threads is, it is on top.
    let on_top = width * (1.0 - width * (1.0 - share));
    return mix(vec3f(0.64 * width, on_top, 0.5), vec3f(height, select(0.0, 1.0, on_warp), number), seen);
}

// Height of a thread at a distance across and along it within one crossing.
fn thread(across: f32, along: f32, width: f32, on_top: bool) -> f32 {
    let round = 1.0 - (2.0 * across / max(width, 1e-3)) * (2.0 * across / max(width, 1e-3));
    if round <= 0.0 {
        return 0.0;
    }
    let bend = cos(3.1415927 * along);
    return sqrt(round) * (0.5 + select(-0.35, 0.35, on_top) * (0.35 + 0.65 * bend));
}
