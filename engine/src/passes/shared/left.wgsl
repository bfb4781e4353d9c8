// What a vertex leaves for the cache of irradiance: how much light it would scatter diffusely, and how much of its sample of the
// BSDF stands for that. `brdf/leave.wgsl` writes it, the passes of `irradiance` read it in the same round.
//!include shared/paths.wgsl

// Words of a path's fields:
// PATH_PLACE: where rays leave the surface, then the normal that its vertices give it, octahedral.
// PATH_DIFFUSE: rgb that a unit of irradiance adds to the path's radiance, then the normal that it is shaded with.
// PATH_LEFT: `shares_words` of the path's next ray, then vertices that had scattered before, then whether there is all this.

const LEFT_NONE = 0u;
const LEFT_ENDED = 1u; // the path ends here
const LEFT_ON = 2u; // it goes on
