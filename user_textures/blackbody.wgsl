/// The colour of a glowing body: a candle has 1900 kelvin, a lamp 2800, the sun 5800. Its luminance is `intensity`.
/// @group colour
/// @param temperature of the body [1000 .. 25000] [log] [unit K] = 2800
/// @param intensity   luminance [0 .. 100] = 1
fn userProc(temperature: f32, intensity: f32) -> vec3f {
    return intensity * blackbody(temperature);
}
