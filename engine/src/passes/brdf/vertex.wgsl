// A path and the vertex that it has come to: what the steps of `shade_vertex` hand each other, by value.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/outputs.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/materials.wgsl
//!include shared/media.wgsl
//!include shared/surface.wgsl
//!include shared/appearance.wgsl
//!include shared/bsdf.wgsl

// A path as the last vertex left it.
struct Path {
    slot: u32,
    id: PathId,
    depth: u32, // vertices that have scattered
    is_last: bool, // what it meets scatters no more: only emission matters
    throughput: vec3f,
    bsdf_pdf: f32, // of the ray's direction; 0 for camera rays
    radiance: vec3f, // gathered so far
    cone_width: f32, // of the ray, at its origin
}

fn path_state(slot: u32) -> Path {
    let throughput = path_read(PATH_THROUGHPUT, slot);
    let gathered = path_read(PATH_RADIANCE, slot);
    return Path(
        slot, path_id(slot), path_depth(slot), path_is_last(slot), throughput.xyz, throughput.w, gathered.xyz, gathered.w,
    );
}

// Where a path has met a surface.
struct Vertex {
    slot: u32,
    id: PathId,
    depth: u32,
    surface: Surface,
    instance: u32,
    own_material: u32, // of the triangle
    material: u32, // after blends
    driven: u32, // the outputs that the texture program gave
    flags: u32, // of the material
    is_solid: bool, // bounds a body
    is_inside: bool, // seen from the inside of a transparent body
    is_clear: bool, // a thin wall that light goes straight through
    media: vec4u, // the bodies that the ray went through
    medium: u32, // the one of them that it travelled in
    beyond: vec4u, // what is behind the surface of a body
}

fn vertex_at(p: Path, hit: RayHit) -> Vertex {
    var v: Vertex;
    v.slot = p.slot;
    v.id = p.id;
    v.depth = p.depth;
    v.surface = surface_at(hit);
    v.instance = hit.instance;
    v.own_material = v.surface.triangle.w & TRIANGLE_MATERIAL;
    v.material = v.own_material;
    if (runs_program(materials[v.own_material].flags, p.is_last)) {
        let resolved = path_words(PATH_STATE, p.slot);
        v.material = resolved.x;
        v.driven = resolved.y;
    }
    v.flags = materials[v.material].flags;
    v.is_solid = has_transmission && (v.flags & MATERIAL_SOLID) != 0u;
    v.is_inside = v.is_solid && !v.surface.front;
    v.is_clear = has_clear && (materials[v.own_material].flags & MATERIAL_CLEAR) != 0u;
    if (has_transmission) {
        v.media = path_words(PATH_MEDIA, p.slot);
        // Where the path began inside a body, its back says so.
        if (v.is_inside && !media_hold(v.media, v.own_material)) {
            v.media = media_entered(v.media, v.own_material);
        }
        v.medium = medium_among(v.media);
    }
    v.beyond = v.media;
    if (v.is_solid) {
        v.beyond = media_behind(v.is_inside, v.media, v.own_material);
    }
    return v;
}

// The frame of a BSDF in the world; x is where anisotropic reflections are stretched to.
struct ShadingFrame {
    tangent: vec3f,
    bitangent: vec3f,
    normal: vec3f,
}

fn to_local(basis: ShadingFrame, w: vec3f) -> vec3f {
    return vec3f(dot(w, basis.tangent), dot(w, basis.bitangent), dot(w, basis.normal));
}

fn to_world(basis: ShadingFrame, w: vec3f) -> vec3f {
    return basis.tangent * w.x + basis.bitangent * w.y + basis.normal * w.z;
}
