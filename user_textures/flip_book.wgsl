/// Pictures of a sequence that lie in the rows of one image, played one after the other.
/// @group images
/// @param file    the image
/// @param texcoord where; link `place2d` to change it [attr TexCoord0]
/// @param columns pictures in a row [1 .. 64] = 4
/// @param rows    rows of pictures [1 .. 64] = 4
/// @param rate    pictures per second [0 .. 120] = 12
/// @param start   the picture at time 0 [0 .. 4096] = 0
/// @param blend   whether each becomes the next one smoothly = true
/// @param time    seconds [attr Time]
fn userProc(file: sam2D, texcoord: vec4f, columns: u32, rows: u32, rate: f32, start: f32, blend: bool, time: f32) -> vec4f {
    let grid = vec2u(max(columns, 1u), max(rows, 1u));
    let frame = start + rate * time;
    let whole = floor(frame);
    let first = flip_picture(file, texcoord, grid, whole);
    if !blend {
        return first;
    }
    return mix(first, flip_picture(file, texcoord, grid, whole + 1.0), frame - whole);
}

fn flip_picture(file: sam2D, texcoord: vec4f, grid: vec2u, frame: f32) -> vec4f {
    let number = u32(modulo(frame, f32(grid.x * grid.y)));
    let corner = vec2f(vec2u(number % grid.x, number / grid.x));
    let size = texSize(file);
    let pixels = texcoord.w * max(size.x / f32(grid.x), size.y / f32(grid.y));
    let lod = log2(max(pixels, 1.0));
    // Half a pixel of the smaller copy stays away from the border, beyond which the neighbouring picture begins.
    let half = min(0.5 * exp2(ceil(lod)) * vec2f(grid) / max(size, vec2f(1.0)), vec2f(0.5));
    let uv = (corner + clamp(fract(texcoord.xy), half, 1.0 - half)) / vec2f(grid);
    return tex2DLod(file, uv, lod);
}
