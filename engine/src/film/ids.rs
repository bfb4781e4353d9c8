//! Ids with coverage: which objects a pixel shows, and how many of its samples each of them.
//!
//! A pixel has room for [`IDS`] of them. Where more are seen, those with the lowest numbers stay, with all of their samples,
//! and the others are dropped. What is kept then depends on what is seen alone, not on when: whatever is among the lowest
//! of all samples is among the lowest of any part of them, so it was never dropped before parts are added, and what was
//! dropped of a part has no place in the whole. Ids are hashes of names, so that nobody's names come first.

/// Most ids of a pixel. `film_layers/accumulate_ids.wgsl` has two of them in each of four planes.
pub const IDS: usize = 8;

/// Planes of a film that hold them, two a plane.
pub(super) const PLANES: usize = IDS / 2;

/// What a pixel shows of one object.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coverage {
    /// Of its name: see [`name_id`](scene::name_id). 0: nothing.
    pub id: u32,
    /// Of the pixel's samples, those that meet it first: 0 to 1.
    pub share: f32,
}

/// The ids of a pixel with their numbers of samples: ascending, then nothing but zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Counts([[u32; 2]; IDS]);

impl Counts {
    pub(super) fn of(planes: &[Vec<[u32; 4]>], pixel: usize) -> Self {
        Self(std::array::from_fn(|at| {
            let [id, count, next_id, next_count] = planes[at / 2][pixel];
            match at % 2 {
                0 => [id, count],
                _ => [next_id, next_count],
            }
        }))
    }

    pub(super) fn store(&self, planes: &mut [Vec<[u32; 4]>], pixel: usize) {
        let (pairs, _) = self.0.as_chunks::<2>();
        for (plane, [[a, b], [c, d]]) in planes.iter_mut().zip(pairs) {
            plane[pixel] = [*a, *b, *c, *d];
        }
    }

    /// Adds samples that meet an object: the twin of `film_layers/accumulate_ids.wgsl`.
    pub(super) fn add(&mut self, id: u32, count: u32) {
        let mut carried = [id, count];
        for here in &mut self.0 {
            if carried[0] == 0 {
                return;
            }
            if here[0] == carried[0] {
                here[1] = here[1].saturating_add(carried[1]);
                return;
            }
            if here[0] == 0 || carried[0] < here[0] {
                std::mem::swap(here, &mut carried);
            }
        }
    }

    pub(super) fn add_all(&mut self, other: &Self) {
        for [id, count] in other.0 {
            self.add(id, count);
        }
    }

    /// Whether so many samples can have given it: what is read from a file may be anything.
    pub(super) fn is_of(&self, samples: u32) -> bool {
        let used = self.0.iter().take_while(|[id, _]| *id != 0).count();
        let (used, free) = self.0.split_at(used);
        let total: u64 = used.iter().map(|[_, count]| u64::from(*count)).sum();
        let is_id = |[id, count]: &[u32; 2]| f32::from_bits(*id).is_normal() && *count > 0;
        used.iter().all(is_id)
            && used.is_sorted_by(|a, b| a[0] < b[0])
            && free.iter().all(|pair| *pair == [0; 2])
            && total <= u64::from(samples)
    }

    /// What covers most comes first; of two that cover as much, the lower id.
    pub(super) fn ranked(&self, samples: u32) -> [Coverage; IDS] {
        let mut ranked = self.0;
        ranked.sort_by_key(|&[id, count]| (std::cmp::Reverse(count), id));
        ranked.map(|[id, count]| Coverage {
            id,
            share: (f64::from(count) / f64::from(samples.max(1))) as f32,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: Counts = Counts([[0; 2]; IDS]);

    /// Samples of a pixel that shows more objects than it can keep, in some order.
    fn samples() -> Vec<u32> {
        let mut state = 1_u32;
        let next = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Few of many: 13 ids, some of them rare.
            (1 << 23) + ((state >> 16) % 5) * ((state >> 24) % 6)
        };
        (0..400).map(next).collect()
    }

    fn counted(samples: &[u32]) -> Counts {
        let mut counts = NONE;
        samples.iter().for_each(|&id| counts.add(id, 1));
        counts
    }

    #[test]
    fn what_is_kept_depends_on_neither_order_nor_parts() {
        let samples = samples();
        let whole = counted(&samples);
        // The lowest of all, each with all of its samples.
        let mut ids = samples.clone();
        ids.sort_unstable();
        ids.dedup();
        assert!(ids.len() > IDS, "some are dropped");
        for (kept, &id) in whole.0.iter().zip(&ids) {
            let count = samples.iter().filter(|&&other| other == id).count();
            assert_eq!(*kept, [id, count as u32]);
        }
        assert!(whole.is_of(400));
        assert!(!whole.is_of(10));
        let reversed: Vec<u32> = samples.iter().rev().copied().collect();
        assert_eq!(counted(&reversed), whole);
        for split in 0..samples.len() {
            let (first, last) = samples.split_at(split);
            for (first, last) in [(first, last), (last, first)] {
                let mut merged = counted(first);
                merged.add_all(&counted(last));
                assert_eq!(merged, whole);
            }
        }
    }

    #[test]
    fn what_covers_most_is_first() {
        let (a, b, c) = (1 << 24, 2 << 24, 3 << 24);
        let counts = counted(&[c, b, c, a, c, b, a]);
        let ranked = counts.ranked(14);
        let ids: Vec<u32> = ranked.iter().map(|coverage| coverage.id).collect();
        assert_eq!(ids[..4], [c, a, b, 0]);
        assert_eq!(ranked[0].share, 3.0 / 14.0);
        assert_eq!(ranked[3], Coverage::default());
    }

    #[test]
    fn what_no_samples_give_is_told_apart() {
        let id = 1 << 23;
        let with = |pairs: &[[u32; 2]]| {
            let mut counts = NONE;
            counts.0[..pairs.len()].copy_from_slice(pairs);
            counts.is_of(10)
        };
        assert!(with(&[]) && with(&[[id, 4], [id + 1, 6]]));
        for wrong in [
            &[[id, 0]][..],
            &[[1, 4]],
            &[[0, 4]],
            &[[0, 0], [id, 4]],
            &[[id, 4], [id, 4]],
            &[[id + 1, 4], [id, 4]],
            &[[id, 4], [id + 1, 7]],
            &[[f32::NAN.to_bits(), 1]],
        ] {
            assert!(!with(wrong), "{wrong:?}");
        }
    }
}
