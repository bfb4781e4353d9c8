/// Flakes of metal in a paint: normals in the world, one for each flake, for a material's `normal`. The fourth component is a
/// random number of the flake.
/// @group surface
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param size      width of a flake [0.00001 .. 1] [soft 0.0002 .. 0.01] [log] [unit m] = 0.004
/// @param roughness how far flakes are tilted [0 .. 1] [percent] = 0.35
/// @param coverage  share of the paint that has flakes [0 .. 1] [percent] = 0.7
fn userProc(position: vec4f, size: f32, roughness: f32, coverage: f32) -> vec4f {
    let n = readAttr(Normal).xyz;
    let id = voronoi3D(position.xyz / max(size, 1e-6), 1.0).id;
    let r = random1to3(id);
    // Flakes finer than the pixel are many at once: their mean is the surface's own normal.
    let seen = octaveSeen(0.5 * position.w / max(size, 1e-6));
    if unitFloat(hashU1(id + 77u)) > coverage {
        return vec4f(n, mix(0.5 * coverage, 0.0, seen));
    }
    let tilt = roughness * seen * (2.0 * r - 1.0);
    return vec4f(normalize(n + tilt), mix(0.5 * coverage, r.x, seen));
}
