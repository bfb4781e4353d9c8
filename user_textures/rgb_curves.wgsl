/// Each of red, green and blue through a curve of its own, then all through one.
/// @group colour
/// @param color    what goes in [color] = #7f6a55
/// @param factor   how much the curves do [0 .. 1] [percent] = 1
/// @param combined for all [smooth] = [(0, (0, 0, 0)), (0.5, (0.5, 0.5, 0.5)), (1, (1, 1, 1))]
/// @param red      for red [smooth] = [(0, (0, 0, 0)), (0.5, (0.6, 0.6, 0.6)), (1, (1, 1, 1))]
/// @param green    for green [smooth] = [(0, (0, 0, 0)), (1, (1, 1, 1))]
/// @param blue     for blue [smooth] = [(0, (0, 0, 0)), (0.5, (0.4, 0.4, 0.4)), (1, (1, 1, 1))]
fn userProc(color: vec4f, factor: f32, combined: ramp1D, red: ramp1D, green: ramp1D, blue: ramp1D) -> vec4f {
    let own = vec3f(rampEval(red, color.r).r, rampEval(green, color.g).g, rampEval(blue, color.b).b);
    let all = vec3f(rampEval(combined, own.r).r, rampEval(combined, own.g).g, rampEval(combined, own.b).b);
    return vec4f(mix(color.rgb, all, factor), color.a);
}
