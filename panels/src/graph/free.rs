//! Places among others: the nearest one where something lies on nothing.

use egui::{Pos2, Rect, Vec2, pos2};

/// Points around a card that finds a place among others, likewise.
const SPACE: f32 = 40.0;

/// The place nearest to `wanted` for something of that size, where it lies on nothing of what is there.
pub(super) fn free_place(wanted: Pos2, size: Vec2, taken: &[Rect]) -> Pos2 {
    // Where its upper left corner can't be.
    let blocked: Vec<Rect> = taken
        .iter()
        .map(|rect| Rect::from_min_max(rect.min - size, rect.max).expand(SPACE))
        .collect();
    let inside = |low: f32, x: f32, high: f32| low < x && x < high;
    // Something else can only be nearest where it touches one of them.
    let edges = blocked
        .iter()
        .flat_map(|rect| [rect.left(), rect.right()])
        .chain([wanted.x]);
    let mut columns: Vec<f32> = edges.collect();
    let away = |x: f32| (x - wanted.x).abs();
    columns.sort_by(|&a, &b| away(a).total_cmp(&away(b)));
    let mut best = (f32::INFINITY, wanted);
    for x in columns {
        if away(x) >= best.0 {
            break;
        }
        let spans = blocked
            .iter()
            .filter(|rect| inside(rect.left(), x, rect.right()));
        let spans: Vec<[f32; 2]> = spans.map(|rect| [rect.top(), rect.bottom()]).collect();
        let place = pos2(x, nearest_outside(wanted.y, spans));
        let distance = place.distance(wanted);
        if distance < best.0 {
            best = (distance, place);
        }
    }
    best.1
}

/// The number nearest to `wanted` that lies within none of the spans.
fn nearest_outside(wanted: f32, mut spans: Vec<[f32; 2]>) -> f32 {
    let (mut above, mut below) = (wanted, wanted);
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    for &[low, high] in &spans {
        if low < below && below < high {
            below = high;
        }
    }
    spans.sort_by(|a, b| b[1].total_cmp(&a[1]));
    for &[low, high] in &spans {
        if low < above && above < high {
            above = low;
        }
    }
    match below - wanted <= wanted - above {
        true => below,
        false => above,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_free_place_is_found() {
        let size = Vec2::new(100.0, 50.0);
        let at = |x: f32, y: f32| Rect::from_min_size(pos2(x, y), size);
        let wanted = pos2(0.0, 0.0);
        assert_eq!(free_place(wanted, size, &[]), wanted);
        assert_eq!(free_place(wanted, size, &[at(200.0, 0.0)]), wanted);
        // Below is nearer than beside.
        let found = free_place(wanted, size, &[at(0.0, -10.0)]);
        assert_eq!(found, pos2(0.0, 80.0));
        // A wall of cards, and beyond it a hole that is too small.
        let wall: Vec<Rect> = (-20..20).map(|i| at(0.0, 60.0 * i as f32)).collect();
        let found = free_place(wanted, size, &wall);
        assert_eq!(found.x.abs(), 140.0);
        let mut taken = wall;
        for _ in 0..200 {
            let found = Rect::from_min_size(free_place(wanted, size, &taken), size);
            assert!(!taken.iter().any(|other| other.intersects(found)));
            taken.push(found);
        }
    }
}
