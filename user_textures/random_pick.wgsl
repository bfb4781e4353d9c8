/// One of the colours of a ramp for each object, or for each value that is linked.
/// @group random
/// @param value  what the choice depends on; link a cell's or a tile's number [attr ObjectRandom]
/// @param colors what there is to choose from, by how much room each has [constant] = [(0, #7b3f2a), (0.25, #a4663f), (0.5, #c79a6b), (0.75, #59402f)]
/// @param seed   other choices [seed] = 0
fn userProc(value: f32, colors: ramp1D, seed: u32) -> vec4f {
    return rampEval(colors, randomOf(vec4f(value, 0.0, 0.0, f32(seed))).x);
}
