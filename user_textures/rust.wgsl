/// Rust as a whole: the colour of metal, and of rust that creeps out of creases over it. The fourth component is where it rusts, to drive
/// metalness and roughness (`.w`). The node's `occlusion` names the AO slot.
/// @group weathering
/// @param position where; link `mapping` or `warp` to change it [attr LocalPos]
/// @param open     how open it lies [attr AO]
/// @param metal    colour of the metal [color] = #9a9a98
/// @param amount   how much of an open surface rusts [0 .. 1] [percent] = 0.4
/// @param scale    patches per metre [0.01 .. 1000] [soft 0.5 .. 50] [log] = 5
/// @param ramp     colours from old to fresh rust [smooth] = [(0.0, #170d09), (0.3, #43200f), (0.6, #7d3d17), (1.0, #c98a4b)]
fn userProc(position: vec4f, open: f32, metal: vec3f, amount: f32, scale: f32, ramp: ramp1D) -> vec4f {
    let p = position.xyz * scale;
    let pixel = position.w * scale;
    let fray = vec3f(perlin3D(p * 2.7), perlin3D(p * 2.7 + 11.3), perlin3D(p * 2.7 + 23.9));
    let patches = fbm3D(p + 0.25 * fray, 6.0, 2.03, 0.55, pixel);
    let speckles = fbm3D(p * 9.0 + 0.5 * fray, 4.0, 2.03, 0.55, pixel * 9.0);
    let covered = clamp(amount, 0.0005, 0.9995);
    let threshold = 0.15 * log((1.0 - covered) / covered);
    let level = patches + 1.2 * (1.0 - open) + 0.12 * speckles - threshold;
    let width = 0.03 + 0.3 * (1.0 - fractalSeen(6.0, 2.03, 0.55, pixel));
    let mask = smoothstep(-width, width, level);
    // Young rust at the rim, old scale in the middle; pits let no light out.
    let age = saturate(0.75 - 0.8 * level + 0.45 * speckles);
    let pits = 1.0 - 0.5 * smoothstep(0.3, 0.7, speckles);
    // Water carries a little rust over the metal beside it.
    let stain = 0.6 * smoothstep(-0.5, 0.0, level);
    let bare = mix(metal, metal * vec3f(0.62, 0.36, 0.2), stain);
    return vec4f(mix(bare, rampEval(ramp, age).rgb * pits, mask), mask);
}
