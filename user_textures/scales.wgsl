/// Scales of a fish, or shingles, in rows that overlap: x is the height, 1 at the tip, y the distance from the border, z a random
/// number of the scale.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param scale scales per unit of uv [0.1 .. 1000] [soft 2 .. 60] [log] = 10
/// @param round 0 square ends, 1 round ones [0 .. 1] [percent] = 1
fn userProc(texcoord: vec4f, scale: f32, round: f32) -> vec3f {
    let p = texcoord.xy * vec2f(scale, 2.0 * scale);
    let pixel = texcoord.w * 2.0 * scale;
    let row = floor(p.y);
    // Scales hang down: one of this row, or of the two rows above, is on top.
    for (var above = 0; above < 2; above++) {
        let r = row - 1.0 + f32(above);
        let x = p.x + 0.5 * modulo(r, 2.0);
        let column = floor(x);
        let d = vec2f(x - column - 0.5, (p.y - r) * 0.5);
        let end = 0.5 + mix(0.45, sqrt(max(0.25 - d.x * d.x, 0.0)), saturate(round));
        let inside = min(end - d.y, 0.5 - abs(d.x));
        if end > d.y {
            let number = random2to1(vec2u(vec2i(vec2f(column, r))));
            let shown = vec3f(saturate(d.y / max(end, 1e-3)), saturate(2.0 * min(inside, end - d.y)), number);
            return mix(vec3f(0.69, 0.4, 0.5), shown, octaveSeen(0.4 * pixel));
        }
    }
    return mix(vec3f(0.69, 0.4, 0.5), vec3f(0.0, 0.0, 0.5), octaveSeen(0.4 * pixel));
}
