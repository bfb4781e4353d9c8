//! The order of the passes. A wave takes paths from the camera to the film; a round takes each path that is under way to its
//! next surface, and its shadow ray to the light.

use crate::passes::{
    accumulate, advance, ao, brdf, classify, film_layers, pass::Pass, proctex, raygen, traverse,
};

/// The passes of a wave, in the order in which they first run. Those of textures exist only where a
/// material has a program, those of layers where the film has more than the picture.
pub static WAVE: [&Pass; 14] = [
    &raygen::PASS,
    &advance::AFTER_RAYGEN,
    &traverse::CLOSEST,
    &classify::PASS,
    &advance::AFTER_CLASSIFY,
    &ao::PASS,
    &proctex::PASS,
    &film_layers::RECORD,
    &brdf::PASS,
    &advance::AFTER_BRDF,
    &traverse::OCCLUSION,
    &accumulate::PASS,
    &film_layers::MEAN,
    &film_layers::FIRST,
];

/// What runs passes, or notes that they are to be run. A pass that the scene doesn't need is left out.
pub trait Run {
    /// Runs a pass.
    fn run(&mut self, pass: &'static Pass);
}

/// Paths start at the camera.
pub fn start(wave: &mut impl Run) {
    wave.run(&raygen::PASS);
    wave.run(&advance::AFTER_RAYGEN);
}

/// What rays meet, and what the texture programs say about it.
pub fn find_hits(wave: &mut impl Run) {
    wave.run(&traverse::CLOSEST);
    wave.run(&classify::PASS);
    wave.run(&advance::AFTER_CLASSIFY);
    wave.run(&ao::PASS);
    wave.run(&proctex::PASS);
}

/// Each path goes on to its next surface.
pub fn round(wave: &mut impl Run) {
    find_hits(wave);
    wave.run(&film_layers::RECORD);
    wave.run(&brdf::PASS);
    wave.run(&advance::AFTER_BRDF);
    wave.run(&traverse::OCCLUSION);
}

/// What the paths have gathered goes to the film.
pub fn end(wave: &mut impl Run) {
    wave.run(&accumulate::PASS);
    wave.run(&film_layers::MEAN);
    wave.run(&film_layers::FIRST);
}
