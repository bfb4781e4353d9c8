// What the users' functions can ask: the attributes of the current hit, images, globals. The calls are those of texgen's
// kernels (`host_stub.wgsl` there), but for ambient occlusion, which is traced in one of two ways.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/geometry.wgsl
//!include shared/images.wgsl
//!include shared/surface.wgsl
//!include shared/programs.wgsl

@group(0) @binding(31) var<storage, read> args: array<u32>; // the fake stack

// What the attributes of the current hit are computed from.
struct Site {
    surface: Surface,
    anchor: vec3f, // the hit's position; the surface's own moves for bump maps
    instance: u32,
    bounce: u32,
    kind: u32, // of the ray that found it
    slot: u32, // of the path
    ao_purpose: u32, // dimension of random numbers for the rays of ambient occlusion
    occluded: u32, // four counts of eight bits
    footprint: f32, // width of the ray cone, metres
}

var<private> site: Site;

fn patina_program_word(i: u32) -> u32 {
    return programs[i];
}

fn patina_arg_word(i: u32) -> u32 {
    return args[i];
}

fn patina_attr_WorldPos() -> vec4f {
    return vec4f(site.surface.position, 1.0);
}

fn patina_attr_LocalPos() -> vec4f {
    return vec4f(transform_point(instances[site.instance].object_from_world, site.surface.position), 1.0);
}

fn patina_attr_Normal() -> vec4f {
    return vec4f(site.surface.shading_normal, 0.0);
}

fn patina_attr_GeomNormal() -> vec4f {
    return vec4f(site.surface.geometric_normal, 0.0);
}

fn patina_attr_LocalNormal() -> vec4f {
    return vec4f(normalize(transform_transposed(instances[site.instance].world_from_object, site.surface.shading_normal)), 0.0);
}

fn patina_attr_Tangent() -> vec4f {
    let tangent = surface_tangent(site.surface, site.instance, site.surface.shading_normal);
    // The normal is turned where the back is seen: the whole frame is, so that normal maps lean the same way from both sides.
    return select(-tangent, tangent, site.surface.front);
}

fn patina_attr_Bitangent() -> vec4f {
    let tangent = patina_attr_Tangent();
    return vec4f(cross(site.surface.shading_normal, tangent.xyz) * tangent.w, 0.0);
}

fn patina_attr_TexCoord0() -> vec4f {
    return vec4f(interpolate_uv(site.surface.triangle, site.surface.weights, 0u), 0.0, 1.0);
}

fn patina_attr_TexCoord1() -> vec4f {
    return vec4f(interpolate_uv(site.surface.triangle, site.surface.weights, 1u), 0.0, 1.0);
}

fn patina_attr_Color0() -> vec4f {
    return interpolate_color(site.surface.triangle, site.surface.weights);
}

fn patina_attr_ViewDir() -> vec4f {
    return vec4f(site.surface.wo, 0.0);
}

// Half the divergence of the interpolated normal over the triangle, 1/metres; positive where the surface bulges.
fn patina_attr_Curvature() -> vec4f {
    let t = site.surface.triangle;
    let a = vertices[t.x];
    let b = vertices[t.y];
    let c = vertices[t.z];
    let na = octahedral_decode(a.w);
    let nb = octahedral_decode(b.w);
    let nc = octahedral_decode(c.w);
    let ab = bitcast<vec3f>(b.xyz) - bitcast<vec3f>(a.xyz);
    let ac = bitcast<vec3f>(c.xyz) - bitcast<vec3f>(a.xyz);
    let across = cross(ab, ac);
    let along = 0.5 * (dot(nb - na, cross(ac, across)) + dot(nc - na, cross(across, ab))) / max(dot(across, across), 1e-37);
    // Curvature lives in object space; the scale of the instance turns it into the world's.
    let scale = pow(max(site.surface.area_scale, 1e-30) / max(length(across), 1e-30), 0.5);
    return vec4f(along / scale);
}

// x: width of the ray cone in metres; y: the same in units of TexCoord0; z: in object space.
fn patina_attr_Footprint() -> vec4f {
    let t = site.surface.triangle;
    var uv_per_metre = 0.0;
    if ((t.w & TRIANGLE_HAS_UV) != 0u) {
        let a = bitcast<vec2f>(vertices[t.x + 1u].xy);
        let ab = bitcast<vec2f>(vertices[t.y + 1u].xy) - a;
        let ac = bitcast<vec2f>(vertices[t.z + 1u].xy) - a;
        uv_per_metre = sqrt(abs(ab.x * ac.y - ab.y * ac.x) / max(site.surface.area_scale, 1e-30));
    }
    let object_from_world = instances[site.instance].object_from_world;
    let scale = (length(object_from_world[0].xyz) + length(object_from_world[1].xyz) + length(object_from_world[2].xyz)) / 3.0;
    return vec4f(site.footprint, site.footprint * uv_per_metre, site.footprint * scale, 0.0);
}

fn patina_attr_InstanceId() -> vec4f {
    return vec4f(f32(instances[site.instance].source));
}

fn patina_attr_ObjectRandom() -> vec4f {
    let number = hash(instances[site.instance].source * 0x9e3779b9u + 0x7f4a7c15u);
    let x = f32(number >> 8u) * (1.0 / 16777216.0);
    let y = hash(bitcast<u32>(x));
    let z = hash(y);
    return vec4f(x, vec3f(vec3u(y, z, hash(z)) >> vec3u(8u)) * (1.0 / 16777216.0));
}

fn patina_attr_MaterialId() -> vec4f {
    return vec4f(f32(site.surface.triangle.w & TRIANGLE_MATERIAL));
}

fn patina_attr_FrontFacing() -> vec4f {
    return vec4f(select(0.0, 1.0, site.surface.front));
}

fn patina_attr_Bounce() -> vec4f {
    return vec4f(f32(site.bounce));
}

const RAY_CAMERA = 0u;
const RAY_SCATTERED = 1u;
const RAY_SHADOW = 2u;

fn patina_attr_RayKind() -> vec4f {
    return vec4f(f32(site.kind));
}

fn patina_attr_Time() -> vec4f {
    return vec4f(frame.time);
}

fn patina_attr_custom(index: u32) -> vec4f {
    return interpolate_custom(site.surface.triangle, site.surface.weights, index);
}

fn patina_global_Time() -> vec4f {
    return vec4f(frame.time);
}

fn patina_global_FrameIndex() -> vec4f {
    return vec4f(f32(frame.frame_index));
}

fn patina_global_SampleIndex() -> vec4f {
    return vec4f(f32(path_id(site.slot).sample));
}

fn patina_global_Resolution() -> vec4f {
    let size = whole_size();
    return vec4f(size, 1.0 / size);
}

fn patina_global_CameraPos() -> vec4f {
    return vec4f(frame.camera_position, 1.0);
}

fn patina_global_SceneMin() -> vec4f {
    return vec4f(frame.bounds_min, 1.0);
}

fn patina_global_SceneMax() -> vec4f {
    return vec4f(frame.bounds_max, 1.0);
}

fn user_image(image: u32) -> vec4u {
    let row = frame.user_image_base + image;
    return textureLoad(image_table, vec2u(row % IMAGE_TABLE_WIDTH, row / IMAGE_TABLE_WIDTH), 0);
}

fn patina_sample_image(image: u32, uv: vec2f) -> vec4f {
    let row = frame.user_image_base + image;
    return sample_image(row, user_image(image).w, uv);
}

fn patina_sample_image_lod(image: u32, uv: vec2f, lod: f32) -> vec4f {
    return sample_image_level(frame.user_image_base + image, user_image(image).w, uv, lod);
}

fn patina_image_size(image: u32) -> vec2f {
    let size = user_image(image).y;
    return vec2f(f32(size & 0xffffu), f32(size >> 16u));
}
