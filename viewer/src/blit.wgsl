// The picture over the whole viewport, as it is: no colour, no blending, no conversions.

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
}

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

// One triangle that covers everything.
@vertex
fn cover(@builtin(vertex_index) index: u32) -> Corner {
    let place = vec2f(f32(index & 1u), f32(index >> 1u)) * 2.0;
    return Corner(vec4f(place.x * 2.0 - 1.0, 1.0 - place.y * 2.0, 0.0, 1.0), place);
}

@fragment
fn copy(corner: Corner) -> @location(0) vec4f {
    return vec4f(textureSampleLevel(picture, picture_sampler, corner.place, 0.0).rgb, 1.0);
}
