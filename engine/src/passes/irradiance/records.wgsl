// Records of irradiance, and what lies between them.
//
// A record knows the light that other surfaces scatter to a place, from everywhere above it: the irradiance, how that changes from
// place to place (Ward and Heckbert, "Irradiance Gradients", 1992) and how it changes with the normal (its spherical harmonics up to
// the second order: Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001). Of light that
// comes from lamps and from the sky directly it knows nothing.
//!include irradiance/settings.wgsl
//!include shared/vectors.wgsl

// Nine of each:
//  0: position, radius
//  1: irradiance rgb, octahedral normal
//  2: by how much half of its rays find more than all, rgb; the irradiance's standard error, of itself
//  3..5.x: gradient in space, red, green, blue: nine numbers
//  5.y..8.z: what the nine harmonics of the irradiance are multiplied by, rgb each, in units of MOST_HARMONIC times the largest of rgb of the
//     irradiance: 27 numbers of 16 bits. In place of the first, what all normals have in common: such that the irradiance at the record's own
//     normal comes out
//  8.w: width of a pixel there, but for its last eight bits: how far the record would reach if it might be smaller than it may, in 255ths of
//     how far it reaches
const RECORD_WORDS = 9u;
const MOST_HARMONIC = 16.0;

// A record's weight falls with the angle between the normals, too: this is where it has fallen to nothing, as sqrt(1 - cosine).
const FARTHEST_TURN = 0.15; // 12.2 degrees

// How the second-order harmonics of radiance become those of irradiance.
const HARMONIC_0 = 0.282094792;
const HARMONIC_1 = 0.488602512;
const HARMONIC_2 = 1.092548431;
const HARMONIC_20 = 0.315391565;
const HARMONIC_22 = 0.546274215;

// The nine real spherical harmonics.
fn harmonics(n: vec3f) -> array<f32, 9> {
    return array<f32, 9>(
        HARMONIC_0,
        HARMONIC_1 * n.y, HARMONIC_1 * n.z, HARMONIC_1 * n.x,
        HARMONIC_2 * n.x * n.y, HARMONIC_2 * n.y * n.z, HARMONIC_20 * (3.0 * n.z * n.z - 1.0), HARMONIC_2 * n.x * n.z,
        HARMONIC_22 * (n.x * n.x - n.y * n.y));
}
