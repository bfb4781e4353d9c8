//! Where cards go that nobody has placed: in columns, what is read to the left of what reads it.

use std::collections::HashMap;

use egui::{Pos2, Rect, Vec2, pos2};

/// Points from one column to the next.
pub(super) const COLUMN: f32 = 250.0;
/// Points between two cards of a column: a frame with its title fits between them.
const GAP: f32 = 48.0;

/// Points around a card that finds a place among others, likewise.
const SPACE: f32 = 40.0;

/// One card to be placed.
#[derive(Debug, Clone)]
pub(super) struct Card<'a> {
    pub(super) id: &'a str,
    pub(super) height: f32,
    /// Cards that read it, by their place in the list.
    pub(super) readers: Vec<usize>,
}

/// Places all cards; upper left corners, in the order of `cards`. Readers stand to the right of what they read, the
/// rightmost column ends at x = 0. A circle is cut somewhere.
pub(super) fn arrange(cards: &[Card<'_>]) -> Vec<Pos2> {
    let depths = depths(cards);
    let columns = depths.iter().max().map_or(0, |depth| depth + 1);
    let mut places = vec![Pos2::ZERO; cards.len()];
    for column in 0..columns {
        let mut members: Vec<usize> = (0..cards.len()).filter(|&i| depths[i] == column).collect();
        // At the height of its readers, which have their places by now.
        let wanted = |i: usize| {
            let readers: Vec<usize> = (cards[i].readers.iter().copied())
                .filter(|&r| depths[r] < column)
                .collect();
            let sum: f32 = readers.iter().map(|&r| places[r].y).sum();
            match readers.len() {
                0 => f32::MAX,
                count => sum / count as f32,
            }
        };
        members.sort_by(|&a, &b| wanted(a).total_cmp(&wanted(b)));
        let mut y = 0.0;
        for i in members {
            places[i] = pos2(-COLUMN * column as f32, y);
            y += cards[i].height + GAP;
        }
    }
    places
}

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

/// How many links lie between a card and whatever is read by none, at most.
fn depths(cards: &[Card<'_>]) -> Vec<usize> {
    let mut depths: HashMap<usize, usize> = HashMap::new();
    for i in 0..cards.len() {
        depth(cards, i, &mut depths);
    }
    (0..cards.len()).map(|i| depths[&i]).collect()
}

fn depth(cards: &[Card<'_>], first: usize, known: &mut HashMap<usize, usize>) {
    // Chains of nodes may be longer than the stack is deep.
    let mut open = vec![first];
    let mut entered = vec![false; cards.len()];
    while let Some(&i) = open.last() {
        if known.contains_key(&i) {
            open.pop();
            continue;
        }
        let missing: Vec<usize> = (cards[i].readers.iter().copied())
            .filter(|reader| !known.contains_key(reader) && !entered[*reader])
            .collect();
        if !entered[i] && !missing.is_empty() {
            entered[i] = true;
            open.extend(missing);
            continue;
        }
        let below = cards[i]
            .readers
            .iter()
            .filter_map(|reader| known.get(reader));
        let depth = below.max().map_or(0, |depth| depth + 1);
        known.insert(i, depth);
        open.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card<'a>(id: &'a str, readers: &[usize]) -> Card<'a> {
        Card {
            id,
            height: 100.0,
            readers: readers.to_vec(),
        }
    }

    #[test]
    fn what_is_read_stands_to_the_left() {
        let cards = [
            card("material", &[]),
            card("color", &[0]),
            card("noise", &[0, 1]),
            card("loose", &[]),
        ];
        let places = arrange(&cards);
        assert!(places[1].x < places[0].x && places[2].x < places[1].x);
        assert_eq!(places[3].x, places[0].x);
        for (i, a) in places.iter().enumerate() {
            for b in &places[..i] {
                assert!(a.x != b.x || (a.y - b.y).abs() >= 100.0, "cards overlap");
            }
        }
    }

    #[test]
    fn cards_of_any_height_have_room() {
        let tall = |id, height, readers: &[usize]| Card {
            height,
            ..card(id, readers)
        };
        let cards = [
            card("material", &[]),
            tall("image", 700.0, &[0]),
            tall("ramp", 40.0, &[0]),
            tall("noise", 300.0, &[0]),
        ];
        let places = arrange(&cards);
        let rect = |i: usize| {
            let size = Vec2::new(190.0, cards[i].height);
            Rect::from_min_size(places[i], size)
        };
        for i in 0..cards.len() {
            for other in 0..i {
                assert!(!rect(i).intersects(rect(other)), "{i} lies on {other}");
            }
        }
    }

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

    #[test]
    fn circles_and_long_chains_end() {
        let circle = [card("a", &[1]), card("b", &[0])];
        assert_eq!(arrange(&circle).len(), 2);
        let long: Vec<[usize; 1]> = (0..20_000).map(|i: usize| [i.saturating_sub(1)]).collect();
        let chain: Vec<Card<'_>> = long
            .iter()
            .enumerate()
            .map(|(i, reader)| card("n", if i == 0 { &[] } else { reader }))
            .rev()
            .collect();
        assert_eq!(arrange(&chain).len(), chain.len());
    }
}
