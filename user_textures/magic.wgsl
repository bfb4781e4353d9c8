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
    return mix(mean_of(depth, distortion), 0.5 - 0.5 * vec3f(x, y, z), octaveSeen(position.w * scale * 2.0));
}

// What it is far away, as was measured: apart from 0.5 where it is fed back, but for distortions of 2 and more. Within
// 0.1: depths above 4 have the mean of 4, which is off most between distortions of 1 and 2.
fn mean_of(depth: u32, distortion: f32) -> vec3f {
    switch depth {
        case 0u: {
            return vec3f(0.5);
        }
        case 1u: {
            return between(distortion, vec3f(0.5, 0.033, 0.967), vec3f(0.5, 0.121, 0.879), vec3f(0.5, 0.276, 0.724), vec3f(0.5, 0.433, 0.567));
        }
        case 2u: {
            return between(distortion, vec3f(0.764, 0.003, 0.921), vec3f(0.862, 0.046, 0.783), vec3f(0.733, 0.237, 0.687), vec3f(0.547, 0.468, 0.593));
        }
        case 3u: {
            return between(distortion, vec3f(0.825, 0.01, 0.962), vec3f(0.964, 0.107, 0.943), vec3f(0.819, 0.282, 0.814), vec3f(0.55, 0.487, 0.616));
        }
        default: {
            return between(distortion, vec3f(0.852, 0.012, 0.967), vec3f(0.999, 0.077, 0.95), vec3f(0.853, 0.17, 0.865), vec3f(0.53, 0.535, 0.675));
        }
    }
}

// What was measured for distortions of 0.3, 0.6, 1 and 1.5.
fn between(distortion: f32, a: vec3f, b: vec3f, c: vec3f, d: vec3f) -> vec3f {
    var mean = mix(vec3f(0.5, 0.0, 1.0), a, saturate(distortion / 0.3));
    mean = mix(mean, b, saturate((distortion - 0.3) / 0.3));
    mean = mix(mean, c, saturate((distortion - 0.6) / 0.4));
    mean = mix(mean, d, saturate((distortion - 1.0) / 0.5));
    return mix(mean, vec3f(0.5), saturate((distortion - 1.5) / 0.5));
}

fn modulo3(v: vec3f, y: f32) -> vec3f {
    return v - y * floor(v / y);
}
