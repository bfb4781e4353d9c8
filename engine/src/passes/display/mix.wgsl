// Adds a multiple of the light of one group to a copy of a picture's sums. One thread per pixel. `film/mix.rs` has the twin of the
// arithmetic.
//!include shared/exact_sums.wgsl

struct Mix {
    pixels: u32,
    negative: u32, // bits of the channels that are taken away
    red: u32, // multiples, in units of 2^-24
    green: u32,
    blue: u32,
}

// No uniform, as in `display.wgsl`.
@group(0) @binding(0) var<storage, read> mix_of: Mix;
@group(0) @binding(1) var<storage, read_write> film0: array<vec4u>;
@group(0) @binding(2) var<storage, read_write> film1: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> film2: array<vec4u>;
// A plane of the group for each channel.
@group(0) @binding(4) var<storage, read> group_red: array<vec4u>;
@group(0) @binding(5) var<storage, read> group_green: array<vec4u>;
@group(0) @binding(6) var<storage, read> group_blue: array<vec4u>;

const FACTOR_BITS = 24u;

fn negated(whole: vec3u) -> vec3u {
    return add_wide(~whole, vec3u(1u, 0u, 0u));
}

// Product of two words, the less significant half first.
fn product(a: u32, b: u32) -> vec2u {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let cross_a = (a >> 16u) * (b & 0xffffu);
    let cross_b = (a & 0xffffu) * (b >> 16u);
    let middle = (low >> 16u) + (cross_a & 0xffffu) + (cross_b & 0xffffu);
    let high = (a >> 16u) * (b >> 16u) + (cross_a >> 16u) + (cross_b >> 16u) + (middle >> 16u);
    return vec2u((low & 0xffffu) | (middle << 16u), high);
}

// A multiple of a sum of 96 bits, rounded to the nearest unit.
fn times(sum: vec3u, magnitude: u32, channel: u32) -> vec3u {
    let is_below = (sum.z >> 31u) != 0u;
    let whole = select(sum, negated(sum), is_below);
    let low = product(whole.x, magnitude);
    let middle = product(whole.y, magnitude);
    let high = product(whole.z, magnitude);
    let word1 = low.y + middle.x;
    let carried = middle.y + u32(word1 < low.y);
    let word2 = carried + high.x;
    let word3 = high.y + u32(word2 < carried);
    let rounded0 = low.x + (1u << (FACTOR_BITS - 1u));
    let carry0 = u32(rounded0 < low.x);
    let rounded1 = word1 + carry0;
    let carry1 = u32(rounded1 < carry0);
    let rounded2 = word2 + carry1;
    let rounded3 = word3 + u32(rounded2 < carry1);
    let above = 32u - FACTOR_BITS;
    let units = vec3u(
        (rounded0 >> FACTOR_BITS) | (rounded1 << above),
        (rounded1 >> FACTOR_BITS) | (rounded2 << above),
        (rounded2 >> FACTOR_BITS) | (rounded3 << above));
    let takes_away = ((mix_of.negative >> channel) & 1u) != 0u;
    return select(units, negated(units), is_below != takes_away);
}

@compute @workgroup_size(64)
fn mix_group(@builtin(workgroup_id) workgroup: vec3u, @builtin(num_workgroups) workgroups: vec3u,
             @builtin(local_invocation_index) local: u32) {
    let at = (workgroup.y * workgroups.x + workgroup.x) * 64u + local;
    if (at >= mix_of.pixels) {
        return;
    }
    let light_red = group_red[at].xyz;
    let light_green = group_green[at].xyz;
    let light_blue = group_blue[at].xyz;
    // Most lamps reach a part of the picture.
    if (all((light_red | light_green | light_blue) == vec3u(0u))) {
        return;
    }
    let words0 = film0[at];
    let words1 = film1[at];
    let words2 = film2[at];
    let red = add_wide(words0.xyz, times(light_red, mix_of.red, 0u));
    let green = add_wide(vec3u(words0.w, words1.xy), times(light_green, mix_of.green, 1u));
    let blue = add_wide(vec3u(words1.zw, words2.x), times(light_blue, mix_of.blue, 2u));
    film0[at] = vec4u(red, green.x);
    film1[at] = vec4u(green.yz, blue.xy);
    film2[at] = vec4u(blue.z, words2.yzw);
}
