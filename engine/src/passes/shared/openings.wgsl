// Openings: where rays to the sky leave the box around the scene. In a room these are its windows, which lie in the same places of the
// box wherever one looks from, while the parts of the sky that are seen through them differ from place to place. Each is a rectangle on a
// side of the box. They lie in the image of what is known of the sky, in the last columns; `renderer/irradiance/openings.rs` finds them.
//!include shared/frame.wgsl

// As many as there are at most: the numbers are from 1 on, and 0 is none.
const OPENINGS = 64u;
// Squares along each side of a side of the box, of which openings are made.
const EXIT_SQUARES = 128u;
// Columns that they have in the image: in the first rows the squares, a row of a side in each, two of them in a number; then the openings.
const EXIT_COLUMNS = EXIT_SQUARES / 8u;
const FIRST_OPENING_ROW = 6u * EXIT_SQUARES;

// Where a ray leaves the box.
struct Exit {
    side: u32, // twice the axis, and one where that grows
    place: vec2f, // along the next two axes, in [0, 1]
    distance: f32,
    cosine: f32, // to the side
}

fn exit_of(origin: vec3f, direction: vec3f) -> Exit {
    let grows = direction > vec3f(0.0);
    let steep = max(abs(direction), vec3f(1e-12));
    let way = max(select(origin - frame.bounds_min, frame.bounds_max - origin, grows), vec3f(0.0)) / steep;
    let distance = min(min(way.x, way.y), way.z);
    let size = max(frame.bounds_max - frame.bounds_min, vec3f(1e-20));
    let place = saturate((origin + direction * distance - frame.bounds_min) / size);
    if (way.x <= distance) {
        return Exit(u32(grows.x), place.yz, distance, steep.x);
    }
    if (way.y <= distance) {
        return Exit(2u + u32(grows.y), place.zx, distance, steep.y);
    }
    return Exit(4u + u32(grows.z), place.xy, distance, steep.z);
}

// Column and row of the square that a ray leaves by, in a picture of all sides, one below the other.
fn exit_square(exit: Exit) -> vec2u {
    let square = min(vec2u(exit.place * f32(EXIT_SQUARES)), vec2u(EXIT_SQUARES - 1u));
    return vec2u(square.x, exit.side * EXIT_SQUARES + square.y);
}

// The point of a side of the box at such a place.
fn point_of_side(side: u32, place: vec2f) -> vec3f {
    let low = frame.bounds_min;
    let size = frame.bounds_max - low;
    let at = f32(side & 1u);
    if (side < 2u) {
        return low + size * vec3f(at, place);
    }
    if (side < 4u) {
        return low + size * vec3f(place.y, at, place.x);
    }
    return low + size * vec3f(place, at);
}
