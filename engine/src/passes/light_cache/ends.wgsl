// Where paths may end in the cache.
//!include shared/wave_memory.wgsl
//!include shared/queue_lists.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/materials.wgsl
//!include shared/images.wgsl
//!include shared/surface.wgsl
//!include shared/shadow_rays.wgsl
//!include light_cache/cells.wgsl

// How much wider than a cell a path must have become, as areas: where it is narrower, as behind a mirror or in a corner, one would
// see the cells. After Müller et al., "Real-time Neural Radiance Caching for Path Tracing", 2021, equations 3 and 4, for one segment.
const LEAST_SPREAD = 4.0;
// Surfaces that are smoother scatter other light to other places: a floor on which the sun shines lights the wall that it reflects it to,
// by a quarter in a room whose floor has a roughness of 0.5. So they have cells for each of some 300 directions, 15 degrees apart.
const SAME_ALL_AROUND = 0.7;
// What is smoother yet reflects to less than such a direction.
const LEAST_ROUGHNESS = 0.35;
// So do metals, which scatter nothing that goes all around.
const MOST_METALLIC = 0.5;

// Whether what a surface scatters on average, all around or in about one direction, can stand for what it scatters along one ray.
fn is_cached(triangle: vec4u) -> bool {
    let material = triangle.w & TRIANGLE_MATERIAL;
    let flags = materials[material].flags;
    let passes = (triangle.w & (TRIANGLE_PROGRAM_ALPHA | TRIANGLE_ALPHA)) != 0u
        || (flags & (MATERIAL_SOLID | MATERIAL_CLEAR | MATERIAL_UNLIT)) != 0u
        || materials[material].transmission > 0.0 || materials[material].diffuse_transmission > 0.0;
    let least = select(LEAST_ROUGHNESS, SAME_ALL_AROUND, materials[material].metallic > MOST_METALLIC);
    return !passes && materials[material].roughness >= least;
}

// Where a path may end in the cache.
struct CachedPlace {
    is_one: bool,
    position: vec3f,
    normal: vec3f,
    view: vec3f, // whereto it scatters; 0 where that is the same all around
    offset: vec3f, // by which its cell is moved
    side: f32, // of its cell
    spread: f32, // area that the path has spread over
    half: u32, // to which the path belongs
}

// The place at a path's hit. `depth` is how often the path has scattered.
fn end_at(slot: u32, hit: RayHit, depth: u32) -> CachedPlace {
    var place: CachedPlace;
    if (!is_cached(triangles[hit.triangle]) || any(path_words(PATH_MEDIA, slot) != vec4u(0u))) {
        return place;
    }
    let s = surface_at(hit);
    place.position = s.position;
    place.normal = s.geometric_normal;
    place.side = cell_side(s.position);
    let is_same = materials[triangles[hit.triangle].w & TRIANGLE_MATERIAL].roughness >= SAME_ALL_AROUND;
    place.view = select(s.wo, vec3f(0.0), is_same);
    let pdf = path_read(PATH_THROUGHPUT, slot).w;
    place.spread = hit.t_max * hit.t_max / (pdf * max(dot(s.geometric_normal, s.wo), 1e-3));
    place.is_one = place.spread > LEAST_SPREAD * place.side * place.side;
    // Cells are looked up, and learn, all around: no border shows.
    let id = path_id(slot);
    place.half = half_of(id);
    let turned = independent2(id.sample, hash2(id.key, 0x1f123bb5u + depth)) - 0.5;
    let tangent = any_perpendicular(s.geometric_normal);
    place.offset = place.side * (turned.x * tangent + turned.y * cross(s.geometric_normal, tangent));
    return place;
}

fn cell_of_place(place: CachedPlace, begins: bool) -> u32 {
    return cell_at(place.position + place.offset, place.normal, place.view, place.side, place.half, begins);
}

// What surfaces scatter there on average, and in w whether enough is known of it; `lesser` as for `cell_mean`.
fn known_mean(place: CachedPlace, lesser: u32) -> vec4f {
    let mean = cell_mean(cell_of_place(place, false), lesser);
    return vec4f(mean.xyz, f32(mean.w >= f32(light_cache_settings.least_count)));
}
