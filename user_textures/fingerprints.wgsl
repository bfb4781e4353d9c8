/// Fingerprints on glass and lacquer: 0 is clean, 1 is a ridge of a print. Good for roughness.
/// @group weathering
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale   prints per unit of uv [0.1 .. 100] [soft 1 .. 20] [log] = 5
/// @param amount  share of the places that have one [0 .. 1] [percent] = 0.6
/// @param ridges  ridges across a print [4 .. 40] = 14
/// @param smudge  how blurred they are [0 .. 1] [percent] = 0.3
fn userProc(texcoord: vec4f, scale: f32, amount: f32, ridges: f32, smudge: f32) -> f32 {
    let p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    var print = 0.0;
    for (var k = 0; k < 9; k++) {
        let cell = floor(p) + vec2f(f32(k % 3), f32(k / 3)) - 1.0;
        let seed = vec2u(vec2i(cell));
        let r = random2to3(seed);
        let s = random2to3(seed + 1013u);
        if r.z < amount {
            let d = rotate2D(p - cell - 0.25 - 0.5 * r.xy, 6.2831853 * s.x);
            // An oval, higher than wide.
            let oval = length(d * vec2f(1.0, 0.72)) / 0.33;
            if oval < 1.0 {
                // Ridges are arches over a core, pushed about by noise.
                let bend = 0.05 * valueNoise2D(d * 9.0 + 31.0 * s.xy);
                let core = length(vec2f(d.x, 0.55 * (d.y + 0.08 * (s.y - 0.5)) + 0.6 * d.x * d.x)) + bend;
                let wave = 0.5 + 0.5 * cos(6.2831853 * ridges * core / 0.66);
                let line = smoothstep(0.35, 0.65, mix(wave, 0.5, 0.6 * smudge));
                let shown = mix(0.5, line, octaveSeen(pixel * ridges * 1.6));
                let pressed = 0.6 + 0.4 * valueNoise2D(d * 6.0 + 77.0 * s.yz);
                print = max(print, smoothstep(1.0, 0.7, oval) * shown * saturate(pressed));
            }
        }
    }
    return mix(0.12 * amount, print, octaveSeen(0.5 * pixel));
}
