/// A brick wall, as Blender's node of that name: rows of bricks in two colours, with mortar. The fourth component is 1 on the mortar.
/// @group patterns
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param color1           colour of some bricks [color] = #a4502f
/// @param color2           colour of other bricks [color] = #7a3524
/// @param mortar           colour between them [color] = #b8b0a4
/// @param scale            bricks are scaled by this, per unit of uv [0.1 .. 100] [log] = 5
/// @param mortar_size      width of the mortar, of which Blender's number is half [0 .. 0.25] = 0.02
/// @param mortar_smooth    how soft it ends [0 .. 1] = 0.1
/// @param bias             more of the first colour below 0, of the second above [-1 .. 1] = 0
/// @param brick_width      width [0.01 .. 10] [soft 0.1 .. 2] = 0.5
/// @param row_height       height [0.01 .. 10] [soft 0.1 .. 2] = 0.25
/// @param offset           shift of some rows, in bricks [0 .. 1] = 0.5
/// @param offset_frequency one of so many rows is shifted [1 .. 99] = 2
/// @param squash           width of bricks in some rows, as a factor [0.1 .. 10] = 1
/// @param squash_frequency one of so many rows is [1 .. 99] = 2
fn userProc(
    texcoord: vec4f,
    color1: vec3f,
    color2: vec3f,
    mortar: vec3f,
    scale: f32,
    mortar_size: f32,
    mortar_smooth: f32,
    bias: f32,
    brick_width: f32,
    row_height: f32,
    offset: f32,
    offset_frequency: u32,
    squash: f32,
    squash_frequency: u32,
) -> vec4f {
    let p = texcoord.xy * scale;
    let pixel = texcoord.w * scale;
    let height = max(row_height, 1e-3);
    let row = floor(p.y / height);
    let squashed = modulo(row, f32(max(squash_frequency, 1u))) < 1.0;
    let width = max(brick_width, 1e-3) * select(1.0, squash, squashed);
    let shifted = modulo(row, f32(max(offset_frequency, 1u))) < 1.0;
    let x = p.x + select(0.0, offset * width, shifted);
    let column = floor(x / width);
    let inside = vec2f(x - column * width, p.y - row * height);
    let border = min(min(inside.x, width - inside.x), min(inside.y, height - inside.y));
    let half = 0.5 * mortar_size;
    let soft = half * (1.0 + mortar_smooth);
    let joint = 1.0 - softStep(half * (1.0 - mortar_smooth), soft, border, pixel);
    // Far away both fade into what they cover.
    let seen = octaveSeen(pixel / height);
    // One of so many rows has bricks of another width.
    let unlike = 1.0 / f32(max(squash_frequency, 1u));
    let wide = saturate(1.0 - mortar_size / max(brick_width, 1e-3));
    let other = saturate(1.0 - mortar_size / max(brick_width * squash, 1e-3));
    let share = 1.0 - saturate(1.0 - mortar_size / height) * mix(wide, other, unlike);
    let tint = saturate(random2to1(vec2u(vec2i(vec2f(column, row)))) + bias);
    let brick = mix(color1, color2, mix(saturate(0.5 + bias), tint, seen));
    let cover = mix(share, joint, seen) * step(1e-6, mortar_size);
    return vec4f(mix(brick, mortar, cover), cover);
}
