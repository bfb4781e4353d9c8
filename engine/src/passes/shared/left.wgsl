// What a vertex leaves for caches of light: how it scatters, how much light it would scatter diffusely, and how much of its sample of
// the BSDF stands for that. `brdf/leave.wgsl` writes it, the passes of `irradiance` and `photons` read it in the same round.
//!include shared/paths.wgsl

// Words of a path's fields, the first two where it scatters diffusely:
// PATH_PLACE: where rays leave the surface, then the normal that its vertices give it, octahedral.
// PATH_DIFFUSE: rgb that a unit of irradiance adds to the path's radiance, then the normal that it is shaded with.
// PATH_LEFT: `shares_words` of the path's next ray, then vertices that had scattered before, then how this one does; of a ray that
// has met nothing, rgb that the sky would add if no light sample could have found it, then that.
// PATH_UNSENT: rgb that the ray has found in this round on a surface which light samples know nothing of, and no photons come from.

const LEFT_NONE = 0u; // nothing has scattered in this round
const LEFT_DIFFUSE = 1u; // light from all sides equally, among others
const LEFT_CASTER = 2u; // a mirror or a body of glass, which throws caustics
const LEFT_OTHER = 3u; // some other way
const LEFT_SKY = 4u; // no surface: the sky
const LEFT_KIND = 7u; // mask of these
const LEFT_ON = 8u; // besides: the path goes on
// Besides, where all is scattered diffusely: of the path's rays few go on from here if a cache knows this place, and light samples count
// for more. Instead of shares there is by how much they count for less where it doesn't, then which part of the rays these few are.
const LEFT_FEW = 16u;

// A surface is a caster if its microfacets' distribution is at most as wide as this, and at most this much of the light that
// enters it is scattered diffusely. It has to be flagged as one: photons are sent to no others.
const CASTER_ALPHA = 0.1;
const CASTER_BODY = 0.02;
