/// Wood cut from a trunk: rings about an axis, fibres and pores along it. The fourth component is the height, for `bump`.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param axis       along the trunk = (1, 0.03, 0.06)
/// @param center     a point on the middle of the trunk [unit m] = (0, -0.35, 0.2)
/// @param rings      rings per metre [1 .. 2000] [soft 10 .. 200] [log] = 45
/// @param distortion how irregular the rings are [0 .. 2] = 0.6
/// @param fibres     strength of the fibres [0 .. 1] [percent] = 0.5
/// @param pores      strength of the pores [0 .. 1] [percent] = 0.4
/// @param early      colour of spring's wood [color] = #c99a62
/// @param late       colour of autumn's wood [color] = #7d4e28
fn userProc(
    position: vec4f,
    axis: vec3f,
    center: vec3f,
    rings: f32,
    distortion: f32,
    fibres: f32,
    pores: f32,
    early: vec3f,
    late: vec3f,
) -> vec4f {
    let n = axis / max(length(axis), 1e-6);
    let d = position.xyz - center;
    let along = dot(d, n);
    let across = d - n * along;
    let pixel = position.w * rings;
    // A trunk bends and bulges slowly along its length.
    let bulge = fbm3D((across + 0.15 * n * along) * 5.0, 3.0, 2.0, 0.5, position.w * 5.0);
    let radius = length(across) * rings + 2.5 * distortion * bulge;
    let ring = floor(radius);
    let year = random1to1(u32(i32(ring)));
    // Growth slows down over the year, and stops at once.
    let t = fract(radius);
    let season = pow(t, 1.5 + 2.0 * year) * (1.0 - smoothstep(0.93, 1.0, t));
    let seen = octaveSeen(pixel);
    let shown = mix(0.33, season, seen);
    // Fibres are long and thin.
    let f = (across + 0.02 * n * along) * rings * 9.0;
    let fibre = fbm3D(f, 3.0, 2.3, 0.6, pixel * 9.0);
    let pore_field = perlin3D((across + 0.05 * n * along) * rings * 14.0 + 40.0);
    let pore = smoothstep(0.28, 0.5, pore_field) * (1.0 - t) * octaveSeen(pixel * 7.0);
    let tone = saturate(shown * 0.85 + 0.22 * (year - 0.5) * seen + 0.35 * fibres * fibre + 0.12 * bulge);
    let color = mix(early, late, tone) * (1.0 - 0.55 * pores * pore);
    let height = saturate(0.6 - 0.25 * shown + 0.15 * fibres * fibre - 0.6 * pores * pore);
    return vec4f(color, height);
}
