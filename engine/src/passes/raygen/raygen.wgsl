// Camera rays: how a path starts. `entry.wgsl` is the pass.
//!include shared/frame.wgsl
//!include shared/rays.wgsl
//!include shared/paths.wgsl
//!include shared/queues.wgsl
//!include shared/random.wgsl
//!include shared/vectors.wgsl

// Steps of each lobe in the table of distances: the positive lobe first, then the negative one. See `filter.rs`.
const FILTER_SLOTS = 512u;

@group(0) @binding(22) var<storage, read> filter_table: array<f32>;

// Where a sample lies along an axis, seen from the centre of its pixel, distributed as the filter's absolute value.
fn filter_offset(u: f32) -> f32 {
    let side = 2.0 * u - 1.0;
    if (frame.filter_is_box != 0u) {
        return side * frame.filter_radius;
    }
    var share = abs(side) / frame.filter_positive;
    var first = 0u;
    if (abs(side) > frame.filter_positive) {
        share = (abs(side) - frame.filter_positive) / (1.0 - frame.filter_positive);
        first = FILTER_SLOTS + 1u;
    }
    share = min(share, 1.0);
    let end = sqrt(0.5 * min(share, 1.0 - share));
    let scaled = select(1.0 - end, end, share < 0.5) * f32(FILTER_SLOTS);
    let slot = min(u32(scaled), FILTER_SLOTS - 1u);
    let distance = mix(filter_table[first + slot], filter_table[first + slot + 1u], scaled - f32(slot));
    return sign(side) * distance * frame.filter_radius;
}

fn disk(u: vec2f) -> vec2f {
    // Concentric map (Shirley and Chiu 1997).
    let a = 2.0 * u - 1.0;
    if (a.x == 0.0 && a.y == 0.0) {
        return vec2f(0.0);
    }
    if (abs(a.x) > abs(a.y)) {
        return a.x * unit_circle(0.125 * a.y / a.x);
    }
    return a.y * unit_circle(0.25 - 0.125 * a.x / a.y);
}

// A point of the aperture, whose corners are at distance 1: one of the triangles between its centre and a side.
fn aperture(u: vec2f) -> vec2f {
    if (frame.aperture_blades < 3u) {
        return disk(u);
    }
    let blades = f32(frame.aperture_blades);
    let scaled = u.x * blades;
    let blade = min(floor(scaled), blades - 1.0);
    let turned = frame.aperture_rotation / 6.28318531;
    let rim = mix(unit_circle(turned + blade / blades), unit_circle(turned + (blade + 1.0) / blades), scaled - blade);
    return sqrt(u.y) * rim;
}

fn start_path(slot: u32) {
    let path = path_id(slot);
    let pixel = pixel_coordinates(path.pixel);
    // Parallel rays are as wide as a pixel from the start.
    let width = select(0.0, 2.0 * frame.half_height / whole_size().y, frame.orthographic != 0u);
    path_write(PATH_RADIANCE, slot, vec4f(0.0, 0.0, 0.0, width));
    path_write(PATH_LIGHT, slot, vec4f(0.0));
    path_set_words(PATH_STATE, slot, vec4u(0u));
    path_set_words(PATH_MEDIA, slot, frame.camera_media);
    path_set_words(PATH_LIGHT_POINT, slot, vec4u(MISS, 0u, 0u, 0u));
    rays[shadow_ray(slot)].triangle = MISS;
    if (!is_rendered(pixel) || path.number >= frame.sample_limit) {
        // Padding of a block at the border, or a part that nobody looks at.
        return;
    }
    let size = whole_size();
    let place = random4(path, DIMENSION_CAMERA, GROUP_CAMERA);
    let film = vec2f(place_in_whole(pixel)) + 0.5 + vec2f(filter_offset(place.x), filter_offset(place.y));
    let ndc = vec2f(2.0 * film.x - size.x, size.y - 2.0 * film.y) / size.y * frame.half_height;
    var origin: vec3f;
    var direction: vec3f; // in the camera's frame
    if (frame.orthographic != 0u) {
        origin = vec3f(ndc, 0.0);
        direction = vec3f(0.0, 0.0, -1.0);
    } else {
        origin = vec3f(0.0);
        direction = vec3f(ndc, -1.0);
    }
    if (frame.aperture_radius > 0.0) {
        let focus = origin + direction * frame.focus_distance;
        origin += vec3f(aperture(place.zw) * frame.aperture_radius, 0.0);
        direction = focus - origin;
    }
    let world_origin = frame.camera_position + frame.camera_right * origin.x + frame.camera_up * origin.y;
    let world_direction = normalize(
        frame.camera_right * direction.x + frame.camera_up * direction.y + frame.camera_back * direction.z);
    rays[own_ray(slot)] = RayHit(world_origin, 0.0, world_direction, 1e30, vec2f(0.0), MISS, 0u);
    path_write(PATH_THROUGHPUT, slot, vec4f(1.0, 1.0, 1.0, 0.0));
    queue_append(QUEUE_ACTIVE, slot);
}
