// Image textures: all pictures lie in the layers of one array texture, so that no binding array is needed.
// Wrapping and filtering are done here, on texels, so neighbours in a layer never bleed into each other.

@group(0) @binding(16) var image_table: texture_2d<u32>; // row by row: x | y << 16, width | height << 16, layer | srgb << 31, sampler
@group(0) @binding(17) var image_layers: texture_2d_array<f32>;
@group(0) @binding(18) var image_layers_srgb: texture_2d_array<f32>; // the same texels, decoded from sRGB

const IMAGE_NONE = 0xffffffffu;
const IMAGE_TABLE_WIDTH = 1024u;

// Sampler bits: wrap u (2 bits), wrap v (2 bits), nearest filter, uv set.
const WRAP_REPEAT = 0u;
const WRAP_MIRROR = 1u;
const SAMPLER_NEAREST = 16u;
const SAMPLER_UV1 = 32u;
// For images of texture arguments: levels below the full one (5 bits), row of the first of these in the table.
const SAMPLER_LEVELS_SHIFT = 6u;
const SAMPLER_LEVEL_ROW_SHIFT = 11u;

struct ImageRect {
    corner: vec2i,
    size: vec2i,
    layer: u32,
    srgb: bool,
}

fn image_rect(image: u32) -> ImageRect {
    let row = textureLoad(image_table, vec2u(image % IMAGE_TABLE_WIDTH, image / IMAGE_TABLE_WIDTH), 0);
    return ImageRect(
        vec2i(vec2u(row.x & 0xffffu, row.x >> 16u)),
        vec2i(vec2u(row.y & 0xffffu, row.y >> 16u)),
        row.z & 0x7fffffffu,
        (row.z >> 31u) != 0u,
    );
}

// A coordinate in the picture, [0, 1]. Done before it is counted in texels: integers are slow to divide.
fn wrap_coordinate(u: f32, mode: u32) -> f32 {
    var wrapped = u;
    if (mode == WRAP_REPEAT) {
        wrapped = fract(u);
    } else if (mode == WRAP_MIRROR) {
        let there = 2.0 * fract(0.5 * u);
        wrapped = min(there, 2.0 - there);
    }
    return clamp(wrapped, 0.0, 1.0);
}

// A texel beside the picture at most: the one on the other side, or the border's, which is its own mirror image too.
fn wrap_texel(i: i32, size: i32, mode: u32) -> i32 {
    if (mode == WRAP_REPEAT) {
        return select(select(i, i - size, i >= size), i + size, i < 0);
    }
    return clamp(i, 0, size - 1);
}

fn load_texel(rect: ImageRect, x: i32, y: i32) -> vec4f {
    let at = rect.corner + vec2i(x, y);
    if (rect.srgb) {
        return textureLoad(image_layers_srgb, at, rect.layer, 0);
    }
    return textureLoad(image_layers, at, rect.layer, 0);
}

// uv (0, 0) is the upper left corner of the picture. A coordinate that is not finite reads the corner.
fn sample_image(image: u32, sampler: u32, uv: vec2f) -> vec4f {
    let rect = image_rect(image);
    let wrap_u = sampler & 3u;
    let wrap_v = (sampler >> 2u) & 3u;
    let texel = vec2f(wrap_coordinate(uv.x, wrap_u), wrap_coordinate(uv.y, wrap_v)) * vec2f(rect.size);
    if ((sampler & SAMPLER_NEAREST) != 0u) {
        let i = min(vec2i(texel), rect.size - 1);
        return load_texel(rect, i.x, i.y);
    }
    let shifted = texel - 0.5;
    let base = floor(shifted);
    let f = shifted - base;
    let i = vec2i(base);
    let x0 = wrap_texel(i.x, rect.size.x, wrap_u);
    let x1 = wrap_texel(i.x + 1, rect.size.x, wrap_u);
    let y0 = wrap_texel(i.y, rect.size.y, wrap_v);
    let y1 = wrap_texel(i.y + 1, rect.size.y, wrap_v);
    let top = mix(load_texel(rect, x0, y0), load_texel(rect, x1, y0), f.x);
    let bottom = mix(load_texel(rect, x0, y1), load_texel(rect, x1, y1), f.x);
    return mix(top, bottom, f.y);
}

// A level between two whole ones is a mixture of them, or the nearer one where the filter is nearest.
fn sample_image_level(image: u32, sampler: u32, uv: vec2f, lod: f32) -> vec4f {
    let below = (sampler >> SAMPLER_LEVELS_SHIFT) & 31u;
    let level = clamp(lod, 0.0, f32(below));
    if ((sampler & SAMPLER_NEAREST) != 0u) {
        return sample_image(level_row(image, sampler, u32(level + 0.5)), sampler, uv);
    }
    let fine = u32(level);
    let finer = sample_image(level_row(image, sampler, fine), sampler, uv);
    let mixed = level - f32(fine);
    if (mixed <= 0.0) {
        return finer;
    }
    return mix(finer, sample_image(level_row(image, sampler, fine + 1u), sampler, uv), mixed);
}

// Row of a level in the table of images. A level that isn't there is the last one.
fn level_row(image: u32, sampler: u32, level: u32) -> u32 {
    let below = (sampler >> SAMPLER_LEVELS_SHIFT) & 31u;
    let found = min(level, below);
    return select((sampler >> SAMPLER_LEVEL_ROW_SHIFT) + found - 1u, image, found == 0u);
}
