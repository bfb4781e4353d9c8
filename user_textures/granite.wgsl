/// Granite: grains of feldspar, quartz and mica, each of one colour. The fourth component is a random number of the grain, for the
/// roughness.
/// @group materials
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param size     of a grain [0.0001 .. 1] [log] [unit m] = 0.022
/// @param feldspar colour of most grains [color] = #b89a8a
/// @param quartz   colour of clear grains [color] = #c9c6c0
/// @param mica     colour of dark grains [color] = #26241f
/// @param dark     share of dark grains [0 .. 1] [percent] = 0.25
fn userProc(position: vec4f, size: f32, feldspar: vec3f, quartz: vec3f, mica: vec3f, dark: f32) -> vec4f {
    let p = position.xyz / max(size, 1e-6);
    let pixel = position.w / max(size, 1e-6);
    // Ragged borders between the grains, small grains between large ones.
    let q = p + 0.35 * vec3f(perlin3D(p * 2.1), perlin3D(p * 2.1 + 9.0), perlin3D(p * 2.1 + 17.0));
    let large = voronoi3D(q, 1.0);
    let small = voronoi3D(q * 2.6 + 4.0, 1.0);
    let of_small = random1to1(small.id + 17u);
    let use_small = of_small < 0.35;
    let r = random1to3(select(large.id, small.id, use_small));
    var color = mix(feldspar, feldspar * 1.25, r.y);
    if r.x < dark {
        color = mica * (0.6 + 0.8 * r.y);
    } else if r.x < dark + 0.3 * (1.0 - dark) {
        color = quartz * (0.8 + 0.3 * r.y);
    }
    let cloud = 1.0 + 0.12 * perlin3D(p * 5.0) * octaveSeen(pixel * 5.0);
    let mean = mix(mix(feldspar * 1.12, quartz, 0.3), mica, dark);
    let seen = octaveSeen(0.5 * pixel);
    return vec4f(mix(mean, color * cloud, seen), mix(0.5, r.z, seen));
}
