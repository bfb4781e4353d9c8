/// Bands or rings, bent by noise, as Blender's wave texture: 0 to 1.
/// @group patterns
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param kind       0 bands along x, 1 along y, 2 along z, 3 diagonal, 4 rings about x, 5 about y, 6 about z, 7 spheres [0 .. 7] = 0
/// @param profile    0 sine, 1 saw, 2 triangle [0 .. 2] = 0
/// @param scale      waves per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 6
/// @param distortion how far they bend, in waves [0 .. 10] = 1
/// @param detail     octaves of the bends [1 .. 12] = 2
/// @param detail_scale bends per wave [0.01 .. 10] = 1
/// @param phase      shift, in waves [-10 .. 10] = 0
fn userProc(
    position: vec4f,
    kind: u32,
    profile: u32,
    scale: f32,
    distortion: f32,
    detail: f32,
    detail_scale: f32,
    phase: f32,
) -> f32 {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    var x = p.x;
    switch kind {
        case 1u: { x = p.y; }
        case 2u: { x = p.z; }
        case 3u: { x = (p.x + p.y + p.z) * 0.57735; }
        case 4u: { x = length(p.yz); }
        case 5u: { x = length(p.xz); }
        case 6u: { x = length(p.xy); }
        case 7u: { x = length(p); }
        default: {}
    }
    x += phase + distortion * 0.5 * fbm3D(p * detail_scale, clamp(detail, 1.0, 12.0), 2.0, 0.5, pixel * detail_scale);
    var wave = 0.5 - 0.5 * cos(6.2831853 * x);
    if profile == 1u {
        wave = fract(x);
    } else if profile == 2u {
        wave = abs(2.0 * fract(x) - 1.0);
    }
    return mix(0.5, wave, octaveSeen(1.5 * pixel * (1.0 + 0.5 * distortion)));
}
