/// Bright swirls of sines fed into sines, as Blender's magic texture.
/// @group patterns
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param scale      swirls per metre [0.01 .. 100] [soft 0.5 .. 20] [log] = 5
/// @param depth      how often it is fed back [0 .. 10] = 2
/// @param distortion how strongly [0 .. 10] = 1
fn userProc(position: vec4f, scale: f32, depth: u32, distortion: f32) -> vec3f {
    let p = modulo3(position.xyz * scale, 6.2831853) * 5.0;
    var x = sin(p.x + p.y + p.z);
    var y = cos(-p.x + p.y - p.z);
    var z = -cos(-p.x - p.y + p.z);
    for (var step = 0u; step < 10u; step++) {
        if step >= depth {
            break;
        }
        let d = distortion;
        let next = vec3f(sin(d * (x - y + z)), cos(d * (-x + y + z)), -cos(d * (x + y - z)));
        x = next.x;
        y = next.y;
        z = next.z;
    }
    // Far away it is its mean, which is apart from 0.5 only where it is fed back as often as by default.
    let mean = select(vec3f(0.5), vec3f(0.734, 0.235, 0.686), depth == 2u);
    return mix(mean, 0.5 - 0.5 * vec3f(x, y, z), octaveSeen(position.w * scale * 2.0));
}

fn modulo3(v: vec3f, y: f32) -> vec3f {
    return v - y * floor(v / y);
}
