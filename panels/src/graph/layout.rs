//! Where cards go that nobody has placed: in columns, what is read to the left of what reads it.

use std::collections::HashMap;

use egui::{Pos2, pos2};

/// Points from one column to the next.
const COLUMN: f32 = 250.0;
/// Points between two cards of a column.
const GAP: f32 = 24.0;

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
