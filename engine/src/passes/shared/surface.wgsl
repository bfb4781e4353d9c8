// The surface at a hit: position and frames in the world, facing the viewer.
//!include shared/vectors.wgsl

struct Surface {
    position: vec3f,
    wo: vec3f, // to the viewer
    geometric_normal: vec3f, // on the viewer's side
    shading_normal: vec3f, // interpolated, flipped together with the geometric one
    weights: vec3f, // barycentric
    triangle: vec4u,
    front: bool, // the viewer is on the side that glTF calls front
    area_scale: f32, // twice the triangle's area in the world
    // How far above its triangle the point lies on the curved surface that the vertices' normals suggest: rays that leave from there aren't
    // stopped by the coarseness of the mesh (Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021, chapter 4). Zero where the
    // surface is flat or hollow.
    lift: vec3f,
    // How far rays start from the surface beyond what `position` itself asks for: where the triangle is wide, since both the position and where
    // a ray meets the triangle are rounded as its farthest corners are; and where the node takes large coordinates of its mesh nearly
    // away, as in models that were moved to the origin.
    coarseness: f32,
}

// A vertex's share of the lift of a point; `normal` is on the viewer's side.
fn lift_by(to: vec3f, normal: vec3f, weight: f32) -> vec3f {
    return normal * (-weight * min(dot(to, normal), 0.0));
}

fn surface_at(hit: RayHit) -> Surface {
    let triangle = triangles[hit.triangle];
    let weights = barycentric_weights(hit.barycentrics);
    let world_from_object = instances[hit.instance].world_from_object;
    let object_from_world = instances[hit.instance].object_from_world;
    let va = vertices[triangle.x];
    let vb = vertices[triangle.y];
    let vc = vertices[triangle.z];
    let a = bitcast<vec3f>(va.xyz);
    let edge1 = bitcast<vec3f>(vb.xyz) - a;
    let edge2 = bitcast<vec3f>(vc.xyz) - a;
    let inside = edge1 * weights.y + edge2 * weights.z; // from the first vertex
    let position = transform_point(world_from_object, a + inside);
    let terms = transform_terms(world_from_object, a + inside);
    let coarse = select(vec3f(0.0), terms, terms > 4.0 * abs(position) + 1.0);
    // The transform's determinant defines the winding (glTF 2.0, section 3.7.4): a normal moved by the inverse
    // transpose stays on the side that it was on.
    let world1 = transform_vector(world_from_object, edge1);
    let world2 = transform_vector(world_from_object, edge2);
    let widest = max_component(max(abs(world1), abs(world2)));
    let world_cross = cross(world1, world2) * instances[hit.instance].handedness;
    let area_scale = length(world_cross);
    var geometric = world_cross / max(area_scale, 1e-30);
    let wo = -hit.direction;
    let front = dot(geometric, wo) >= 0.0;
    var lift = vec3f(0.0);
    var object_normal = octahedral_decode(va.w);
    if (va.w != vb.w || vb.w != vc.w) {
        let na = object_normal;
        let nb = octahedral_decode(vb.w);
        let nc = octahedral_decode(vc.w);
        object_normal = na * weights.x + nb * weights.y + nc * weights.z;
        let side = select(-1.0, 1.0, front);
        lift = transform_vector(world_from_object, lift_by(inside, na * side, weights.x)
            + lift_by(inside - edge1, nb * side, weights.y) + lift_by(inside - edge2, nc * side, weights.z));
    }
    var shading = transform_transposed(object_from_world, object_normal);
    let shading_length = length(shading);
    shading = select(geometric, shading / shading_length, shading_length > 1e-20);
    if (!front) {
        geometric = -geometric;
        shading = -shading;
    }
    return Surface(position, wo, geometric, shading, weights, triangle, front, area_scale, lift,
        max(max_component(coarse) / 65536.0, widest / 4194304.0));
}

// Along the first texture coordinates of a triangle, in the object and of any length, and the handedness of the bitangent, as
// MikkTSpace has it; zero where it has none.
fn tangent_by_uv(triangle: vec4u) -> vec4f {
    if ((triangle.w & TRIANGLE_HAS_UV) == 0u) {
        return vec4f(0.0);
    }
    let a = bitcast<vec3f>(vertices[triangle.x].xyz);
    let edge1 = bitcast<vec3f>(vertices[triangle.y].xyz) - a;
    let edge2 = bitcast<vec3f>(vertices[triangle.z].xyz) - a;
    let uv = bitcast<vec2f>(vertices[triangle.x + 1u].xy);
    let uv1 = bitcast<vec2f>(vertices[triangle.y + 1u].xy) - uv;
    let uv2 = bitcast<vec2f>(vertices[triangle.z + 1u].xy) - uv;
    // v grows down the picture, and the bitangent points up.
    let handedness = select(1.0, -1.0, uv1.x * uv2.y - uv2.x * uv1.y > 0.0);
    return vec4f((edge2 * uv1.y - edge1 * uv2.y) * handedness, handedness);
}

// Unit tangent in the world and handedness of the bitangent, perpendicular to `normal`: the mesh's, or along its texture coordinates where
// its file has none; an arbitrary one without either.
fn surface_tangent(s: Surface, instance: u32, normal: vec3f) -> vec4f {
    var along: vec4f;
    if ((s.triangle.w & TRIANGLE_HAS_TANGENT) != 0u) {
        let pa = vertices[s.triangle.x + 1u].zw;
        let pb = vertices[s.triangle.y + 1u].zw;
        let pc = vertices[s.triangle.z + 1u].zw;
        let object_tangent = octahedral_decode(pa.x) * s.weights.x + octahedral_decode(pb.x) * s.weights.y
            + octahedral_decode(pc.x) * s.weights.z;
        along = vec4f(object_tangent, select(-1.0, 1.0, (pa.y & 1u) != 0u));
    } else {
        along = tangent_by_uv(s.triangle);
    }
    let world_tangent = transform_vector(instances[instance].world_from_object, along.xyz);
    let across = world_tangent - normal * dot(world_tangent, normal);
    let across_length = length(across);
    if (across_length > 1e-20) {
        return vec4f(across / across_length, along.w * instances[instance].handedness);
    }
    return vec4f(any_perpendicular(normal), 1.0);
}
