// The scene's geometry in memory. The Rust twins are in `gpu_scene`; a test compares the layouts.

// Three absolute offsets into `vertices`, then the material in the low 24 bits and flags above.
@group(0) @binding(11) var<storage, read> triangles: array<vec4u>;

const TRIANGLE_MATERIAL = 0x00ffffffu;
const TRIANGLE_ALPHA = 0x80000000u; // alpha must be looked up before a hit counts
const TRIANGLE_HAS_UV = 0x40000000u; // a vertex has its second vec4: uv0, tangent
const TRIANGLE_HAS_EXTRA = 0x20000000u; // a vertex has its third vec4: uv1, colour
const TRIANGLE_HAS_TANGENT = 0x10000000u;
const TRIANGLE_HAS_COLOR = 0x08000000u;
const TRIANGLE_SINGLE_SIDED = 0x04000000u; // rays pass through its back
const TRIANGLE_PROGRAM_ALPHA = 0x02000000u; // a texture program decides whether a hit counts
const TRIANGLE_HAS_CUSTOM = 0x01000000u; // a vertex has custom attributes behind the others

// A number by which random decisions know a triangle. Its place among the triangles is the hierarchy's business, and
// differs from device to device.
fn triangle_number(triangle: vec4u) -> u32 {
    return triangle.x + triangle.y * 0x9e3779b1u + triangle.z * 0x85ebca77u;
}

// A vertex is one to three vec4u: position and octahedral normal; uv0, octahedral tangent, its handedness in bit 0 and
// above it the place of the table of custom attributes; uv1 and colour (rgba16unorm). Then a vec4f for each custom
// attribute that the mesh has. The table has a word for each attribute that textures read: the number of its record
// in a vertex, 0 where the mesh has none.
@group(0) @binding(12) var<storage, read> vertices: array<vec4u>;

struct Instance {
    // Rows of the affine maps.
    world_from_object: array<vec4f, 3>,
    object_from_world: array<vec4f, 3>,
    root: u32, // BLAS root in `nodes`
    handedness: f32, // sign of the determinant
    id: u32, // of its name
    source: u32, // index of the instance in the scene
    asset: u32, // of the name of the whole that it is a piece of
    motion: u32, // index of the first of two records about where the instance was and will be; 0 where it isn't known
    // Padding: the maps are 16-byte words.
    unused_b: u32,
    unused_c: u32,
}

@group(0) @binding(13) var<storage, read> instances: array<Instance>;

fn transform_point(rows: array<vec4f, 3>, p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(dot(rows[0], q), dot(rows[1], q), dot(rows[2], q));
}

// The sizes of what is added up for a point: it is rounded by so much.
fn transform_terms(rows: array<vec4f, 3>, p: vec3f) -> vec3f {
    let q = vec4f(abs(p), 1.0);
    return vec3f(dot(abs(rows[0]), q), dot(abs(rows[1]), q), dot(abs(rows[2]), q));
}

fn transform_vector(rows: array<vec4f, 3>, v: vec3f) -> vec3f {
    return vec3f(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

// By the transpose: normals go to the world by the transpose of object_from_world.
fn transform_transposed(rows: array<vec4f, 3>, v: vec3f) -> vec3f {
    return rows[0].xyz * v.x + rows[1].xyz * v.y + rows[2].xyz * v.z;
}

fn vertex_position(offset: u32) -> vec3f {
    return bitcast<vec3f>(vertices[offset].xyz);
}

// Octahedral unit vector of two signed 16-bit numbers (Cigolle et al., JCGT 3(2), 2014).
fn octahedral_decode(packed: u32) -> vec3f {
    let e = unpack2x16snorm(packed);
    var v = vec3f(e, 1.0 - abs(e.x) - abs(e.y));
    if (v.z < 0.0) {
        let folded = (vec2f(1.0) - abs(v.yx)) * select(vec2f(-1.0), vec2f(1.0), v.xy >= vec2f(0.0));
        v = vec3f(folded, v.z);
    }
    return normalize(v);
}

// A unit vector packed as `octahedral_decode` reads it.
fn octahedral_encode(v: vec3f) -> u32 {
    var e = v.xy / (abs(v.x) + abs(v.y) + abs(v.z));
    if (v.z < 0.0) {
        e = (vec2f(1.0) - abs(e.yx)) * select(vec2f(-1.0), vec2f(1.0), e >= vec2f(0.0));
    }
    return pack2x16snorm(e);
}

// Weights of the three vertices.
fn barycentric_weights(b: vec2f) -> vec3f {
    return vec3f(1.0 - b.x - b.y, b.x, b.y);
}

// TEXCOORD_0 or TEXCOORD_1; the first where the mesh has no second one, zero where it has neither.
fn interpolate_uv(triangle: vec4u, weights: vec3f, uv_set: u32) -> vec2f {
    if (uv_set == 0u || (triangle.w & TRIANGLE_HAS_EXTRA) == 0u) {
        if ((triangle.w & TRIANGLE_HAS_UV) == 0u) {
            return vec2f(0.0);
        }
        let a = bitcast<vec2f>(vertices[triangle.x + 1u].xy);
        let b = bitcast<vec2f>(vertices[triangle.y + 1u].xy);
        let c = bitcast<vec2f>(vertices[triangle.z + 1u].xy);
        return a * weights.x + b * weights.y + c * weights.z;
    }
    let a = bitcast<vec2f>(vertices[triangle.x + 2u].xy);
    let b = bitcast<vec2f>(vertices[triangle.y + 2u].xy);
    let c = bitcast<vec2f>(vertices[triangle.z + 2u].xy);
    return a * weights.x + b * weights.y + c * weights.z;
}

// A custom attribute by its number among those that textures read; 0 where the mesh has none.
fn interpolate_custom(triangle: vec4u, weights: vec3f, number: u32) -> vec4f {
    if ((triangle.w & TRIANGLE_HAS_CUSTOM) == 0u) {
        return vec4f(0.0);
    }
    let table = vertices[triangle.x + 1u].w >> 1u;
    let record = vertices[table + number / 4u][number % 4u];
    if (record == 0u) {
        return vec4f(0.0);
    }
    let a = bitcast<vec4f>(vertices[triangle.x + record]);
    let b = bitcast<vec4f>(vertices[triangle.y + record]);
    let c = bitcast<vec4f>(vertices[triangle.z + record]);
    return a * weights.x + b * weights.y + c * weights.z;
}

fn vertex_color(offset: u32) -> vec4f {
    let packed = vertices[offset + 2u].zw;
    return vec4f(unpack2x16unorm(packed.x), unpack2x16unorm(packed.y));
}

// COLOR_0, linear; white where the mesh has none.
fn interpolate_color(triangle: vec4u, weights: vec3f) -> vec4f {
    if ((triangle.w & TRIANGLE_HAS_COLOR) == 0u) {
        return vec4f(1.0);
    }
    return vertex_color(triangle.x) * weights.x + vertex_color(triangle.y) * weights.y + vertex_color(triangle.z) * weights.z;
}
