// How a path stands to photons.

// Words of a path's own fields. While photons fly: the first has the range of their light, or 0. Of paths of the camera:
// 0: rgb that the path had gathered when its last ray left, then PATH_IS_... ;
// 1: `shares_words` of the ray that left the last diffuse surface, then how many had scattered before that.
const PATH_IS_FREE = 0u; // lights that the ray meets count
const PATH_IS_DIFFUSE = 1u; // the same, but the last surface has been asked for photons
const PATH_IS_CAUSTIC = 2u; // only casters since: the photons have brought this light
