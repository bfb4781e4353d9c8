//! Where cards go that nobody has placed: in columns, what is read to the left of what reads it.

use std::collections::{BTreeSet, HashMap, HashSet};

use egui::{Pos2, Rect, pos2, vec2};

use super::frames::around;
use super::rows::WIDTH;

/// Points from one column to the next.
pub(super) const COLUMN: f32 = 250.0;
/// Points between two cards of a column: a frame with its title fits between them.
const GAP: f32 = 48.0;

/// Frames within each other that are kept together.
const DEEPEST: u32 = 8;

/// One card to be placed.
#[derive(Debug, Clone)]
pub(super) struct Card<'a> {
    pub(super) id: &'a str,
    pub(super) height: f32,
    /// Cards that read it, by their place in the list.
    pub(super) readers: Vec<usize>,
}

impl Card<'_> {
    fn rect(&self, place: Pos2) -> Rect {
        Rect::from_min_size(place, vec2(WIDTH, self.height))
    }
}

/// What goes into a column as a whole: a card, or the cards of a frame.
struct Block {
    members: Vec<usize>,
    /// Where it lies while its members have places of their own, margins included.
    rect: Rect,
}

/// Places all cards; upper left corners, in the order of `cards`. Readers stand to the right of what they read, the
/// rightmost column ends at x = 0. A circle is cut somewhere. The cards of a frame stay together, and no other card lies among them:
/// frames that share none don't overlap. One within another is kept together there; those that share some are as one.
pub(super) fn arrange(cards: &[Card<'_>], frames: &[BTreeSet<usize>]) -> Vec<Pos2> {
    let mut places = vec![Pos2::ZERO; cards.len()];
    let all: Vec<usize> = (0..cards.len()).collect();
    let frames: Vec<&BTreeSet<usize>> = frames.iter().collect();
    arrange_part(cards, &all, &frames, DEEPEST, &mut places);
    places
}

fn arrange_part(
    cards: &[Card<'_>],
    part: &[usize],
    frames: &[&BTreeSet<usize>],
    deepest: u32,
    places: &mut [Pos2],
) {
    let mut blocks = Vec::new();
    let mut loose: BTreeSet<usize> = part.iter().copied().collect();
    for (members, mut inner) in components(frames) {
        loose.retain(|card| !members.contains(card));
        inner.retain(|frame| frame.len() < members.len());
        // Where frames overlap, none is within the others.
        let is_one = |(part, _): &(BTreeSet<usize>, _)| part.len() == members.len();
        if deepest == 0 || components(&inner).iter().any(is_one) {
            inner.clear();
        }
        let members: Vec<usize> = members.into_iter().collect();
        arrange_part(cards, &members, &inner, deepest.saturating_sub(1), places);
        let rects = members.iter().map(|&i| cards[i].rect(places[i]));
        if let Some(rect) = around(rects) {
            blocks.push(Block { members, rect });
        }
    }
    for i in loose {
        places[i] = Pos2::ZERO;
        blocks.push(Block {
            members: vec![i],
            rect: cards[i].rect(Pos2::ZERO),
        });
    }
    // In the order of the cards, wherever their frames stand in the look.
    blocks.sort_by_key(|block| block.members[0]);
    in_columns(cards, &blocks, places);
}

/// Cards of frames that share some, each with its frames.
fn components<'f>(
    frames: &[&'f BTreeSet<usize>],
) -> Vec<(BTreeSet<usize>, Vec<&'f BTreeSet<usize>>)> {
    let mut parts: Vec<(BTreeSet<usize>, Vec<&BTreeSet<usize>>)> = Vec::new();
    for &frame in frames.iter().filter(|frame| !frame.is_empty()) {
        let (mut members, mut own) = (frame.clone(), vec![frame]);
        parts.retain_mut(|(others, theirs)| {
            let is_apart = others.is_disjoint(frame);
            if !is_apart {
                members.append(others);
                own.append(theirs);
            }
            is_apart
        });
        parts.push((members, own));
    }
    parts
}

fn in_columns(cards: &[Card<'_>], blocks: &[Block], places: &mut [Pos2]) {
    let mut block_of = HashMap::new();
    for (number, block) in blocks.iter().enumerate() {
        block_of.extend(block.members.iter().map(|&i| (i, number)));
    }
    // Cards of other blocks that read one of this, and their blocks.
    let readers: Vec<Vec<(usize, usize)>> = blocks
        .iter()
        .enumerate()
        .map(|(number, block)| {
            let all = block.members.iter().flat_map(|&i| &cards[i].readers);
            let with_block = all.filter_map(|&card| Some((card, *block_of.get(&card)?)));
            with_block.filter(|(_, other)| *other != number).collect()
        })
        .collect();
    let depths = depths(&readers);
    let columns = depths.iter().max().map_or(0, |depth| depth + 1);
    let mut right = WIDTH;
    for column in 0..columns {
        let mut members: Vec<usize> = (0..blocks.len()).filter(|&b| depths[b] == column).collect();
        // At the height of its readers, which have their places by now.
        let wanted = |b: usize| {
            let placed = readers[b].iter().filter(|(_, of)| depths[*of] < column);
            let heights: Vec<f32> = placed.map(|&(card, _)| places[card].y).collect();
            match heights.len() {
                0 => f32::MAX,
                count => heights.iter().sum::<f32>() / count as f32,
            }
        };
        let wanted: HashMap<usize, f32> = members.iter().map(|&b| (b, wanted(b))).collect();
        members.sort_by(|a, b| wanted[a].total_cmp(&wanted[b]));
        let (mut y, mut width) = (0.0, 0.0f32);
        for b in members {
            let Block { members, rect } = &blocks[b];
            let corner = pos2(right - rect.width(), y);
            for &i in members {
                places[i] = corner + (places[i] - rect.min);
            }
            y += rect.height() + GAP;
            width = width.max(rect.width());
        }
        right -= width + COLUMN - WIDTH;
    }
}

/// How many links lie between a block and whatever is read by none, at most.
fn depths(readers: &[Vec<(usize, usize)>]) -> Vec<usize> {
    let mut depths: HashMap<usize, usize> = HashMap::new();
    for i in 0..readers.len() {
        depth(readers, i, &mut depths);
    }
    (0..readers.len()).map(|i| depths[&i]).collect()
}

fn depth(readers: &[Vec<(usize, usize)>], first: usize, known: &mut HashMap<usize, usize>) {
    // Chains of nodes may be longer than the stack is deep.
    let mut open = vec![first];
    let mut entered = HashSet::new();
    while let Some(&i) = open.last() {
        if known.contains_key(&i) {
            open.pop();
            continue;
        }
        let missing: Vec<usize> = (readers[i].iter().map(|&(_, reader)| reader))
            .filter(|reader| !known.contains_key(reader) && !entered.contains(reader))
            .collect();
        if !entered.contains(&i) && !missing.is_empty() {
            entered.insert(i);
            open.extend(missing);
            continue;
        }
        let below = readers[i]
            .iter()
            .filter_map(|(_, reader)| known.get(reader));
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
        let places = arrange(&cards, &[]);
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
        let places = arrange(&cards, &[]);
        let rect = |i: usize| {
            let size = vec2(190.0, cards[i].height);
            Rect::from_min_size(places[i], size)
        };
        for i in 0..cards.len() {
            for other in 0..i {
                assert!(!rect(i).intersects(rect(other)), "{i} lies on {other}");
            }
        }
    }

    /// Random graphs under random frames; a frame is drawn around its cards as the window does.
    #[test]
    fn frames_neither_overlap_nor_have_strangers_in_them() {
        for seed in 1..=300 {
            let mut random = Random(seed);
            let count = 1 + random.below(30);
            let cards: Vec<Card<'_>> = (0..count)
                .map(|i| {
                    let links = random.below(4);
                    // What is read by former cards, so that there is no circle; now and then by any.
                    let among = if seed % 5 == 0 { count } else { i };
                    let readers = (0..links.min(among)).map(|_| random.below(among));
                    let readers: Vec<usize> = readers.collect();
                    Card {
                        height: 40.0 + random.below(400) as f32,
                        ..card("card", &readers)
                    }
                })
                .collect();
            let mut frames = vec![BTreeSet::new(); random.below(6)];
            for i in 0..count {
                if let Some(frame) = random.pick_mut(&mut frames) {
                    frame.insert(i);
                }
            }
            let is_apart = seed % 3 != 0;
            if !is_apart {
                // Cards that are in several.
                for _ in 0..count {
                    if let Some(frame) = random.pick_mut(&mut frames) {
                        frame.insert(random.below(count));
                    }
                }
            }
            let places = arrange(&cards, &frames);
            let rects: Vec<Rect> = (0..count).map(|i| cards[i].rect(places[i])).collect();
            for i in 0..count {
                for other in 0..i {
                    assert!(!rects[i].intersects(rects[other]), "{seed}: {i} on {other}");
                }
            }
            if !is_apart {
                continue;
            }
            let seen = frames
                .iter()
                .map(|frame| around(frame.iter().map(|&i| rects[i])));
            let seen: Vec<Option<Rect>> = seen.collect();
            for (number, frame) in seen.iter().enumerate() {
                let Some(frame) = frame else { continue };
                for other in seen[..number].iter().flatten() {
                    assert!(!frame.intersects(*other), "{seed}: frames overlap");
                }
                let strangers = (0..count).filter(|i| !frames[number].contains(i));
                for stranger in strangers {
                    assert!(!frame.intersects(rects[stranger]), "{seed}: a stranger");
                }
            }
        }
    }

    #[test]
    fn frames_in_each_other_are_kept_together() {
        let cards: Vec<Card<'_>> = (0..8)
            .map(|i: usize| {
                card(
                    "card",
                    &i.checked_sub(1).map_or(vec![], |reader| vec![reader]),
                )
            })
            .collect();
        let frame = |cards: &[usize]| cards.iter().copied().collect::<BTreeSet<usize>>();
        let frames = [
            frame(&[1, 3, 5, 7]),
            frame(&[3, 7]),
            frame(&[7]),
            frame(&[]),
        ];
        let places = arrange(&cards, &frames);
        let rects: Vec<Rect> = (0..8).map(|i| cards[i].rect(places[i])).collect();
        for frame in &frames[..3] {
            let seen = around(frame.iter().map(|&i| rects[i])).expect("it has cards");
            let inside = (0..8).filter(|&i| seen.intersects(rects[i]));
            assert_eq!(inside.collect::<BTreeSet<usize>>(), *frame);
        }
        // What overlaps is as one, however much of it there is.
        let chain: Vec<BTreeSet<usize>> = (0..7).map(|i| frame(&[i, i + 1])).collect();
        let together = arrange(&cards, &chain);
        let apart = arrange(&cards, &[]);
        for i in 1..8 {
            assert_eq!(together[i] - together[0], apart[i] - apart[0]);
        }
        let deep: Vec<BTreeSet<usize>> = (1..500).map(|i| (0..i).collect()).collect();
        let many: Vec<Card<'_>> = (0..500).map(|_| card("card", &[])).collect();
        assert_eq!(arrange(&many, &deep).len(), 500);
    }

    /// xorshift64*.
    struct Random(u64);

    impl Random {
        fn below(&mut self, n: usize) -> usize {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n.max(1)
        }

        fn pick_mut<'a, T>(&mut self, all: &'a mut [T]) -> Option<&'a mut T> {
            // Some are in none.
            all.get_mut(self.below(all.len() + 1))
        }
    }

    #[test]
    fn circles_and_long_chains_end() {
        let circle = [card("a", &[1]), card("b", &[0])];
        assert_eq!(arrange(&circle, &[]).len(), 2);
        let long: Vec<[usize; 1]> = (0..20_000).map(|i: usize| [i.saturating_sub(1)]).collect();
        let chain: Vec<Card<'_>> = long
            .iter()
            .enumerate()
            .map(|(i, reader)| card("n", if i == 0 { &[] } else { reader }))
            .rev()
            .collect();
        assert_eq!(arrange(&chain, &[]).len(), chain.len());
    }
}
