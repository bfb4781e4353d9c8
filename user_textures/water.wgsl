/// Height of waves on water that run in many directions, for a material's `bump`, in metres. They move with time.
/// @group surface
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param length     of the longest waves [0.01 .. 100] [soft 0.1 .. 10] [log] [unit m] = 0.5
/// @param height     of the longest waves [0 .. 10] [soft 0 .. 0.2] [unit m] = 0.02
/// @param wind       direction in the plane of x and z [angle] [-3.1416 .. 3.1416] = 0.6
/// @param spread     how far directions differ [0 .. 1] [percent] = 0.6
/// @param choppiness how sharp the crests are [0 .. 1] [percent] = 0.4
/// @param time       seconds [attr Time]
fn userProc(
    position: vec4f,
    length: f32,
    height: f32,
    wind: f32,
    spread: f32,
    choppiness: f32,
    time: f32,
) -> f32 {
    var p = position.xz;
    var sum = 0.0;
    for (var i = 0u; i < 14u; i++) {
        // Each wave is shorter than the one before, and runs as fast as deep water lets it.
        let scale = pow(0.78, f32(i));
        let wavelength = max(length, 1e-4) * scale;
        let r = random1to2(i + 11u);
        let angle = wind + spread * 3.1415927 * (r.x - 0.5);
        let direction = vec2f(cos(angle), sin(angle));
        let k = 6.2831853 / wavelength;
        let phase = k * dot(p, direction) - sqrt(9.81 * k) * time + 6.2831853 * r.y;
        let crest = mix(0.5 + 0.5 * sin(phase), exp(2.0 * sin(phase) - 2.0), choppiness);
        sum += scale * crest * octaveSeen(2.0 * position.w / wavelength);
        // Short waves ride on long ones.
        p += direction * (0.04 * wavelength * cos(phase));
    }
    return height * 0.22 * sum;
}
