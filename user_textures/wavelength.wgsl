/// The colour of light of one wavelength, as far as screens can show it.
/// @group colour
/// @param nanometres of the light [380 .. 780] [unit nm] = 580
/// @param intensity  factor [0 .. 100] = 1
fn userProc(nanometres: f32, intensity: f32) -> vec3f {
    return intensity * wavelength(nanometres);
}
