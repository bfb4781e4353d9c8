/// Bark of an old tree: plates that are long along the trunk, with deep furrows between them. The colour; the fourth component is the
/// height, for `bump`.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param axis    along the trunk = (0, 1, 0)
/// @param scale   plates around per metre [0.1 .. 1000] [log] = 14
/// @param stretch length of a plate over its width [1 .. 20] = 3.5
/// @param ridge   colour of the plates [color] = #7d6650
/// @param furrow  colour of the furrows [color] = #1f1610
fn userProc(position: vec4f, axis: vec3f, scale: f32, stretch: f32, ridge: vec3f, furrow: vec3f) -> vec4f {
    let n = axis / max(length(axis), 1e-6);
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let along = dot(p, n);
    let q = p + n * along * (1.0 / max(stretch, 1.0) - 1.0);
    let bent = q + 0.45 * fbmVector3D(q * 0.9, 4.0, 2.2, 0.55, pixel);
    let edge = voronoiEdge3D(bent, 1.0);
    let number = unitFloat(voronoi3D(bent, 1.0).id);
    // Plates are layered across the trunk and rough along it.
    let layers = ridged3D(bent * vec3f(2.3), 4.0, 2.1, 0.5, 1.0, pixel * 2.3);
    let rough = fbm3D(q * 6.0, 4.0, 2.1, 0.6, pixel * 6.0);
    let seen = octaveSeen(0.6 * pixel);
    let plate = mix(0.51, smoothstep(0.0, 0.22, edge), seen);
    let height = saturate(plate * (0.55 + 0.3 * layers + 0.25 * rough + 0.2 * (number - 0.5) * seen));
    let tint = 1.0 + 0.35 * (number - 0.5) * seen + 0.25 * rough;
    return vec4f(mix(furrow, ridge * tint, smoothstep(0.05, 0.75, height)), height);
}
