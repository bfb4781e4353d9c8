// Meshes of egui: colours are premultiplied and as the screen wants them, and so are textures.

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) place: vec2f,
    @location(1) color: vec4f,
}

@group(0) @binding(0) var image: texture_2d<f32>;
@group(0) @binding(1) var image_sampler: sampler;

@vertex
fn place(@location(0) position: vec2f, @location(1) place: vec2f, @location(2) color: vec4f) -> Corner {
    return Corner(vec4f(position, 0.0, 1.0), place, color);
}

@fragment
fn fill(corner: Corner) -> @location(0) vec4f {
    return corner.color * textureSampleLevel(image, image_sampler, corner.place, 0.0);
}
