// The pixel filter: which of its samples count negatively, and by how much all of them count. `filter.rs` says why.

// Whether the sample of an axis lies in a negative lobe.
fn filter_is_negative(u: f32) -> bool {
    return abs(2.0 * u - 1.0) > frame.filter_positive;
}

// The weight of a sample; its mean is 1.
fn filter_weight(u: vec2f) -> f32 {
    let is_negative = filter_is_negative(u.x) != filter_is_negative(u.y);
    return select(frame.filter_weight, -frame.filter_weight, is_negative);
}
