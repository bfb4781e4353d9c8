// The spheres that photons are sent to. Where they overlap, photons come from as many of them.
//!include photons/settings.wgsl
//!include shared/vectors.wgsl
//!include shared/microfacet.wgsl

// 1 - cos of the angle that a sphere's radius fills, seen from a place: 2 from its inside.
fn cone_extent(place: vec3f, sphere: vec4f) -> f32 {
    let to = sphere.xyz - place;
    let sine2 = sphere.w * sphere.w / max(dot(to, to), 1e-30);
    if (sine2 >= 1.0) {
        return 2.0;
    }
    // 1 - cos would lose most digits of small angles.
    return sine2 / (1.0 + sqrt(1.0 - sine2));
}

// Sum of the solid angles of all targets, steradians.
fn angle_of_targets(place: vec3f) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < photon_settings.target_count; i++) {
        sum += cone_extent(place, photon_settings.targets[i]);
    }
    return 2.0 * PI * sum;
}

// Sum of the targets' cross-sections, square metres.
fn disks_of_targets() -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < photon_settings.target_count; i++) {
        sum += photon_settings.targets[i].w * photon_settings.targets[i].w;
    }
    return PI * sum;
}

struct Aim {
    origin: vec3f,
    direction: vec3f,
    weight: f32, // 1 / density: steradians, or square metres
}

// A direction from a place to one of the targets; `choice` says which, by their solid angles.
fn aim_from(place: vec3f, choice: f32, u: vec2f) -> Aim {
    let sum = angle_of_targets(place) / (2.0 * PI);
    var rest = choice * sum;
    var chosen = 0u;
    for (var i = 0u; i + 1u < photon_settings.target_count; i++) {
        let extent = cone_extent(place, photon_settings.targets[i]);
        if (rest < extent) {
            break;
        }
        rest -= extent;
        chosen = i + 1u;
    }
    let sphere = photon_settings.targets[chosen];
    let extent = cone_extent(place, sphere);
    let to = sphere.xyz - place;
    let axis = select(vec3f(0.0, 1.0, 0.0), normalize(to), dot(to, to) > 1e-30);
    let height = u.x * extent;
    let tangent = any_perpendicular(axis);
    let around = unit_circle(u.y) * sqrt(height * (2.0 - height));
    let direction = normalize(tangent * around.x + cross(axis, tangent) * around.y + axis * (1.0 - height));
    var times = 0.0;
    for (var i = 0u; i < photon_settings.target_count; i++) {
        let other = photon_settings.targets[i];
        let to_other = other.xyz - place;
        let off = direction - to_other * inverseSqrt(max(dot(to_other, to_other), 1e-30));
        let extent_other = cone_extent(place, other);
        // 1 - cos of the angle to its middle, which a place in the middle doesn't have.
        let is_in = i == chosen || extent_other >= 2.0 || 0.5 * dot(off, off) <= extent_other;
        times += select(0.0, 1.0, is_in);
    }
    return Aim(place, direction, 2.0 * PI * sum / times);
}

// A ray of parallel light to one of the targets.
fn aim_along(direction: vec3f, choice: f32, u: vec2f) -> Aim {
    let sum = disks_of_targets() / PI;
    var rest = choice * sum;
    var chosen = 0u;
    for (var i = 0u; i + 1u < photon_settings.target_count; i++) {
        let disk = photon_settings.targets[i].w * photon_settings.targets[i].w;
        if (rest < disk) {
            break;
        }
        rest -= disk;
        chosen = i + 1u;
    }
    let sphere = photon_settings.targets[chosen];
    let tangent = any_perpendicular(direction);
    let around = unit_circle(u.y) * (sqrt(u.x) * sphere.w);
    let across = tangent * around.x + cross(direction, tangent) * around.y;
    var times = 0.0;
    for (var i = 0u; i < photon_settings.target_count; i++) {
        let other = photon_settings.targets[i];
        let to = other.xyz - (sphere.xyz + across);
        let aside = to - direction * dot(to, direction);
        let is_in = i == chosen || dot(aside, aside) <= other.w * other.w;
        times += select(0.0, 1.0, is_in);
    }
    // From outside of the scene.
    let back = length(sphere.xyz - frame.bounds_center) + frame.bounds_radius + sphere.w;
    return Aim(sphere.xyz + across - direction * back, direction, PI * sum / times);
}
