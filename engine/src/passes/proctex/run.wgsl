// A hit with a program: chooses the sides of blends, runs the programs, stores what they drive. `entry.wgsl` is the pass.
//!include shared/node_values.wgsl

const MAX_BLEND_DEPTH = 4096u; // blends have no circles: this is never met

// Where the heights of a bump map are evaluated: at the hit and beside it, along two directions in the triangle's plane.
struct BumpFrame {
    edge1: vec3f, // of the triangle in the world
    edge2: vec3f,
    along: vec3f, // unit vectors, perpendicular to each other
    across: vec3f,
    distance: f32, // metres from the hit
}

// `coin` chooses the sides: a difference to one side is off by the curvature of the height, which the other side evens
// out.
fn bump_frame(s: Surface, instance: u32, coin: u32) -> BumpFrame {
    let world_from_object = instances[instance].world_from_object;
    let a = vertex_position(s.triangle.x);
    let edge1 = transform_vector(world_from_object, vertex_position(s.triangle.y) - a);
    let edge2 = transform_vector(world_from_object, vertex_position(s.triangle.z) - a);
    let along = edge1 / max(length(edge1), 1e-30);
    // Half a pixel, but so far that what positions in the world are rounded by is less than a hundredth of their difference.
    let coarse = max(abs(s.position.x), max(abs(s.position.y), abs(s.position.z)));
    let distance = max(0.5 * site.footprint, max(1e-5 * coarse, 1e-7));
    let across = cross(s.geometric_normal, along);
    return BumpFrame(edge1, edge2, select(along, -along, (coin & 1u) != 0u), select(across, -across, (coin & 2u) != 0u),
        distance);
}

// Moves the site along its triangle: everything that is interpolated moves with it.
fn move_site(hit: Surface, bump: BumpFrame, by: vec3f) {
    let g11 = dot(bump.edge1, bump.edge1);
    let g12 = dot(bump.edge1, bump.edge2);
    let g22 = dot(bump.edge2, bump.edge2);
    let b1 = dot(by, bump.edge1);
    let b2 = dot(by, bump.edge2);
    let scale = 1.0 / max(g11 * g22 - g12 * g12, 1e-37);
    let second = (g22 * b1 - g12 * b2) * scale;
    let third = (g11 * b2 - g12 * b1) * scale;
    site.surface.weights = hit.weights + vec3f(-second - third, second, third);
    site.surface.position = hit.position + by;
}

fn write_vector(slot: u32, at: u32, v: vec3f) {
    result_write(slot, at, v.x);
    result_write(slot, at + 1u, v.y);
    result_write(slot, at + 2u, v.z);
}

fn head_vector(material: u32, word: u32) -> vec3f {
    return bitcast<vec3f>(vec3u(head_word(material, word), head_word(material, word + 1u), head_word(material, word + 2u)));
}

// Something that the program drives here is not finite: the sample is lost, see `spoil`.
var<private> is_spoilt: bool;

// What a link gives, in one component or three. What is not finite becomes 0: the path goes on, but never with a NaN.
fn finite_link(word: u32, is_vector: bool) -> vec3f {
    let given = patina_link(word).xyz;
    let v = select(given.xxx, given, is_vector);
    if (!patina_is_finite(v.xyzz)) {
        is_spoilt = true;
        return vec3f(0.0);
    }
    return v;
}

fn output(material: u32, which: u32) -> vec3f {
    return finite_link(head_word(material, HEAD_OUTPUTS + which), is_vector(which));
}

const INFINITY = 0x7f800000u; // bits

// Makes a sample one that is not finite, which `accumulate` drops and counts: the path's, or if a shadow ray's hit is at
// fault, that of the light which waits, should it arrive.
fn spoil(slot: u32, is_shadow: bool) {
    let field = select(PATH_RADIANCE, PATH_LIGHT, is_shadow);
    path_set_words(field, slot, vec4u(vec3u(INFINITY), path_words(field, slot).w));
    add_total(WORD_NON_FINITE, 1u);
    atomicMax(&queues[WORD_NON_FINITE_NODE], patina_non_finite);
}

fn is_driven(material: u32, flags: u32, which: u32) -> bool {
    if (HAS_MORE_OUTPUTS && which >= OUTPUTS_LOW) {
        return has_bit(head_word(material, HEAD_MORE), which - OUTPUTS_LOW);
    }
    return has_bit(flags, which);
}

fn opacity_of(material: u32, flags: u32) -> f32 {
    if (is_driven(material, flags, OUTPUT_OPACITY)) {
        return saturate(output(material, OUTPUT_OPACITY).x);
    }
    return bitcast<f32>(head_word(material, HEAD_OPACITY));
}

// A driven emission with the constant factor, or the constant one.
fn emission_of(material: u32, flags: u32) -> vec3f {
    let factor = head_vector(material, HEAD_EMISSION);
    if (is_driven(material, flags, OUTPUT_EMISSION)) {
        return factor * max(output(material, OUTPUT_EMISSION), vec3f(0.0));
    }
    return factor;
}

// What the program says about a hit of a shadow ray: how much light passes, or what a light emits.
fn shade_shadow(slot: u32, material: u32, flags: u32, is_light: bool) {
    let may_pass = (site.surface.triangle.w & TRIANGLE_PROGRAM_ALPHA) != 0u;
    let opacity = select(1.0, opacity_of(material, flags), may_pass);
    var factor = vec3f(1.0 - opacity);
    if (is_light) {
        factor = emission_of(material, flags) * opacity;
        if (is_driven(material, flags, OUTPUT_EMISSION_STRENGTH)) {
            factor *= max(output(material, OUTPUT_EMISSION_STRENGTH).x, 0.0);
        }
        rays[shadow_ray(slot)].triangle = MISS; // as the shadow ray's own result: nothing is in the way
    }
    let waiting = path_words(PATH_LIGHT, slot);
    path_set_words(PATH_LIGHT, slot, vec4u(bitcast<vec3u>(bitcast<vec3f>(waiting.xyz) * factor), waiting.w));
}

// Stores `wanted` outputs of a path's hit, but for the bump, and returns the words they take.
fn store_outputs(slot: u32, material: u32, flags: u32, wanted: u32) -> u32 {
    var at = 0u;
    var first = 0u; // the number of the word's first output
    var rest = wanted & OUTPUTS_STORED;
    loop {
        if (rest == 0u) {
            if (!HAS_MORE_OUTPUTS || first != 0u || (wanted & OUTPUTS_MORE) == 0u) {
                break;
            }
            let more = head_word(material, HEAD_MORE);
            result_write(slot, at, bitcast<f32>(more));
            at += 1u;
            first = OUTPUTS_LOW;
            rest = more & OUTPUTS_STORED_MORE;
            continue;
        }
        let which = first + firstTrailingBit(rest);
        rest &= rest - 1u;
        var v: vec3f;
        switch which {
            case OUTPUT_EMISSION: { v = emission_of(material, flags); }
            case OUTPUT_OPACITY: { v = vec3f(opacity_of(material, flags)); }
            case OUTPUT_ANISOTROPY_ROTATION: { v = radians(output(material, which)); }
            default: { v = output(material, which); }
        }
        if (is_vector(which)) {
            write_vector(slot, at, v);
            at += 3u;
        } else {
            result_write(slot, at, v.x);
            at += 1u;
        }
    }
    return at;
}

const NO_NODE = 0xffffffffu; // in the place of a link

// Stores what a program has found for nodes that the film keeps.
fn store_nodes(slot: u32, program: u32) {
    for (var i = 0u; i < node_layers; i += 1u) {
        let link = programs[program - node_layers + i];
        if (link != NO_NODE) {
            path_set_words(node_field(i), slot, bitcast<vec4u>(patina_link(link)));
        }
    }
}

// The hit of a path that `entry` of QUEUE_PROCTEX names.
fn run_textures(entry: u32, slot: u32) {
    is_spoilt = false;
    patina_non_finite = 0u;
    let ray = entry & ENTRY_RAY;
    let is_light = (entry & ENTRY_LIGHT) != 0u;
    let is_shadow = is_shadow_ray(ray);
    let path = path_id(slot);
    let hit = ray_read(ray);
    let depth = path_depth(slot);
    // A shadow ray meets what the path's next ray could have met, and a lamp looks the same to both.
    var kind = select(RAY_CAMERA, RAY_SCATTERED, depth > 0u);
    if (is_shadow && !is_light) {
        kind = RAY_SHADOW;
    }
    let distance = select(hit.t_max, hit.t_min, is_shadow && !is_light);
    let cone_width = path_read(PATH_RADIANCE, slot).w + frame.pixel_spread * distance;
    let surface = surface_at(hit);
    site.surface = surface;
    site.anchor = surface.position;
    site.instance = hit.instance;
    site.bounce = depth;
    site.kind = kind;
    site.slot = slot;
    site.ao_purpose = vertex_dimension(depth, select(DIMENSION_AO, DIMENSION_SHADOW_AO, is_shadow));
    site.occluded = occluded_rays(ray);
    site.footprint = cone_width;

    let may_pass = (site.surface.triangle.w & TRIANGLE_PROGRAM_ALPHA) != 0u;
    var material = site.surface.triangle.w & TRIANGLE_MATERIAL;
    var flags = head_word(material, HEAD_FLAGS);
    // What chooses the sides of blends, for those that have one.
    var choice = 0.0;
    if ((flags & HEAD_IS_BLEND) != 0u) {
        // The well-spread number is the first surface's that a ray meets: those behind what it passes have one of their own each.
        if (is_shadow || hit.t_min > 0.0) {
            let dimension = select(DIMENSION_BLEND, DIMENSION_SHADOW_BLEND, is_shadow);
            choice = random_at(path, vertex_dimension(depth, dimension), triangle_number(surface.triangle),
                instances[hit.instance].source);
        } else {
            choice = random2(path, vertex_dimension(depth, DIMENSION_BLEND)).x;
        }
    }

    // All programs run from this one loop, so that the users' functions stand in the kernel once: first those of the
    // material and of the blends above it, then the height of its bump map at three points.
    var program = head_word(material, HEAD_PROGRAM);
    var blends = 0u;
    var bumps = 0u; // heights known
    var words = 0u;
    var heights = vec3f(0.0);
    let shows_nodes = node_layers != 0u && depth == 0u && !is_shadow;
    if (shows_nodes) {
        for (var i = 0u; i < node_layers; i += 1u) {
            path_set_words(node_field(i), slot, vec4u(0u));
        }
    }
    var bump: BumpFrame;
    loop {
        if (program != 0u) {
            patina_run_program(program);
            if (shows_nodes && bumps == 0u) {
                store_nodes(slot, program);
            }
        }
        if (bumps == 0u) {
            if ((flags & HEAD_IS_BLEND) != 0u && blends < MAX_BLEND_DEPTH) {
                // One side is chosen at random, so a blend costs one material and is right on average.
                var mask = bitcast<f32>(head_word(material, HEAD_MASK_VALUE));
                if ((flags & HEAD_CONSTANT_MASK) == 0u) {
                    mask = finite_link(head_word(material, HEAD_MASK), false).x;
                }
                mask = saturate(mask);
                if (choice < mask) {
                    choice /= mask;
                    material = head_word(material, HEAD_OVER);
                } else {
                    choice = (choice - mask) / (1.0 - mask);
                    material = head_word(material, HEAD_BASE);
                }
                flags = head_word(material, HEAD_FLAGS);
                program = head_word(material, HEAD_PROGRAM);
                blends += 1u;
                continue;
            }
            if (is_shadow) {
                shade_shadow(slot, material, flags, is_light);
                break;
            }
            // Driven or not, the next kernel asks for the opacity.
            let outputs = (flags & OUTPUTS) | select(0u, 1u << OUTPUT_OPACITY, may_pass);
            words = store_outputs(slot, material, flags, outputs);
            path_set_words(PATH_STATE, slot, vec4u(material, outputs, path_words(PATH_STATE, slot).zw));
            if (!is_driven(material, flags, OUTPUT_BUMP)) {
                break;
            }
            program = head_word(material, HEAD_BUMP_PROGRAM);
            bump = bump_frame(surface, hit.instance,
                hash2(hash2(path.key, vertex_dimension(depth, DIMENSION_BUMP)), path.sample));
            bumps = 1u;
            continue;
        }
        heights[bumps - 1u] = output(material, OUTPUT_BUMP).x;
        if (bumps == 3u) {
            let slopes = (heights.yz - heights.x) * (bitcast<f32>(head_word(material, HEAD_BUMP_SCALE)) / bump.distance);
            // Heights rise on the front.
            let rise = (bump.along * slopes.x + bump.across * slopes.y) * select(-1.0, 1.0, surface.front);
            write_vector(slot, words, rise);
            break;
        }
        move_site(surface, bump, select(bump.across, bump.along, bumps == 1u) * bump.distance);
        bumps += 1u;
    }
    if (is_spoilt) {
        spoil(slot, is_shadow);
    }
    if (patina_overrun != 0u) {
        atomicMax(&queues[WORD_OVERRUN], patina_overrun);
    }
}
