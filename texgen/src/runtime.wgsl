// Results of the current program's nodes, by slot.
var<private> patina_stack: array<vec4f, STACK_SLOTS>;

// AO slots of the current node: x for AO, y for AO1.
var<private> patina_occlusion: vec2u;

// Iterations that the current node's loops have used. A loop ends once they reach the limit, so that an endless
// loop in a texture can't hang the machine.
const patina_loop_limit = LOOP_LIMIT;
var<private> patina_loops: u32;

// Type number + 1 of the last texture that reached the limit in this invocation, else 0: for the host to report.
var<private> patina_overrun: u32;

// Place + 1 in the fake stack of the arguments of the first node whose result was not finite in this invocation, else 0:
// for the host to report.
var<private> patina_non_finite: u32;

// By its bits: compilers may assume that there are no infinities and no NaN.
fn patina_is_finite(v: vec4f) -> bool {
    let exponents = bitcast<vec4u>(v) & vec4u(0x7f800000u);
    return max(max(exponents.x, exponents.y), max(exponents.z, exponents.w)) < 0x7f800000u;
}

fn patina_check(result: vec4f, args: u32) {
    if patina_non_finite == 0u && !patina_is_finite(result) {
        patina_non_finite = args + 1u;
    }
}

fn patina_loops_spent() -> bool {
    patina_loops += 1u;
    return patina_loops > patina_loop_limit;
}

// In the place of a link: the node's constant, where there would be an attribute else.
const patina_constant = 0x40000000u;

// A place whose w is the width of the pixel there, or that of the hit where it has none.
fn patina_place(p: vec4f, own: f32) -> vec4f {
    return vec4f(p.xyz, select(own, p.w, p.w > 0.0));
}

// The result that a link word refers to, through its swizzle.
fn patina_link(word: u32) -> vec4f {
    let v = patina_stack[word & 0xffffu];
    if (word >> 31u) == 0u {
        return v;
    }
    return vec4f(
        patina_component(v, (word >> 16u) & 7u),
        patina_component(v, (word >> 19u) & 7u),
        patina_component(v, (word >> 22u) & 7u),
        patina_component(v, (word >> 25u) & 7u),
    );
}

// 0 to 3 select a component, 4 is the constant 0, 5 the constant 1.
fn patina_component(v: vec4f, selector: u32) -> f32 {
    if selector > 3u {
        return f32(selector - 4u);
    }
    return v[selector & 3u];
}

// The next link of an instruction.
fn patina_next_link(at: ptr<function, u32>) -> vec4f {
    let word = patina_program_word(*at);
    *at += 1u;
    return patina_link(word);
}

fn patina_arg_f32(at: u32) -> f32 {
    return bitcast<f32>(patina_arg_word(at));
}

fn patina_arg_vec2f(at: u32) -> vec2f {
    return vec2f(patina_arg_f32(at), patina_arg_f32(at + 1u));
}

fn patina_arg_vec3f(at: u32) -> vec3f {
    return vec3f(patina_arg_f32(at), patina_arg_f32(at + 1u), patina_arg_f32(at + 2u));
}

fn patina_arg_vec4f(at: u32) -> vec4f {
    return vec4f(patina_arg_f32(at), patina_arg_f32(at + 1u), patina_arg_f32(at + 2u), patina_arg_f32(at + 3u));
}

fn patina_arg_mat3x3f(at: u32) -> mat3x3f {
    return mat3x3f(patina_arg_vec3f(at), patina_arg_vec3f(at + 3u), patina_arg_vec3f(at + 6u));
}

fn patina_arg_mat4x4f(at: u32) -> mat4x4f {
    return mat4x4f(
        patina_arg_vec4f(at),
        patina_arg_vec4f(at + 4u),
        patina_arg_vec4f(at + 8u),
        patina_arg_vec4f(at + 12u),
    );
}

fn patina_arg_i32(at: u32) -> i32 {
    return bitcast<i32>(patina_arg_word(at));
}

// For indices, in functions that have a local called `u32`.
alias patina_u32 = u32;

fn patina_arg_u32(at: u32) -> u32 {
    return patina_arg_word(at);
}

fn patina_arg_bool(at: u32) -> bool {
    return patina_arg_word(at) != 0u;
}

// The language's own types and functions, as the prelude declares them.
struct sam2D { patina_image: u32 }
struct ramp1D { patina_ramp: u32 }

fn tex2D(image: sam2D, uv: vec2f) -> vec4f {
    return patina_sample_image(image.patina_image, uv);
}

fn tex2DLod(image: sam2D, uv: vec2f, lod: f32) -> vec4f {
    return patina_sample_image_lod(image.patina_image, uv, lod);
}

fn texSize(image: sam2D) -> vec2f {
    return patina_image_size(image.patina_image);
}

// Value of stop i: behind the ramp's header lie (position, r, g, b, a) of each stop.
fn patina_ramp_stop(ramp: u32, i: u32) -> vec4f {
    return patina_arg_vec4f(ramp + 2u + 5u * i);
}

// A ramp lies in the fake stack: the number of its stops in bits 0..30 and the interpolation in bits 30..32
// (0 linear, 1 smooth, 2 constant), then its stops by ascending position. It is read in place.
fn rampEval(ramp: ramp1D, t: f32) -> vec4f {
    let header = patina_arg_word(ramp.patina_ramp);
    // The number of stops at or before t, by bisection.
    var low = 0u;
    var high = header & 0x3fffffffu;
    let count = high;
    loop {
        let middle = (low + high) / 2u;
        if patina_arg_f32(ramp.patina_ramp + 1u + 5u * middle) <= t {
            low = middle + 1u;
        } else {
            high = middle;
        }
        continuing {
            break if low >= high;
        }
    }
    if low == 0u {
        return patina_ramp_stop(ramp.patina_ramp, 0u);
    }
    let before = patina_ramp_stop(ramp.patina_ramp, low - 1u);
    if low == count || (header >> 30u) == 2u {
        return before;
    }
    let t0 = patina_arg_f32(ramp.patina_ramp + 1u + 5u * (low - 1u));
    let t1 = patina_arg_f32(ramp.patina_ramp + 1u + 5u * low);
    var f = (t - t0) / (t1 - t0);
    if (header >> 30u) == 1u {
        f = f * f * (3.0 - 2.0 * f);
    }
    return mix(before, patina_ramp_stop(ramp.patina_ramp, low), f);
}
