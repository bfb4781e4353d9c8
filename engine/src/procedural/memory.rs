//! The words the GPU reads: a head for each material, then the programs; and what changed in them since the last
//! upload. Knows nothing of nodes.

use std::ops::Range;

use super::HEAD_WORDS;

/// Head word: where the program begins, in words from the start; 0 is no program.
pub const HEAD_PROGRAM: u32 = 0;
/// Head word: the first word of [`super::Outputs`], or the `FLAG_*` bits of a blend.
pub const HEAD_FLAGS: u32 = 1;
/// Head word: the link that is the mask of a blend.
pub const HEAD_MASK: u32 = 2;
/// Head word: material of a blend where the mask is 0.
pub const HEAD_BASE: u32 = 3;
/// Head word: material of a blend where the mask is 1.
pub const HEAD_OVER: u32 = 4;
/// Head word: AO tables needed by this material and everything below its blends, one bit each.
pub const HEAD_AO: u32 = 5;
/// Head word: the mask as f32 bits where [`FLAG_CONSTANT_MASK`] is set.
pub const HEAD_MASK_VALUE: u32 = 6;
/// Head word: where the program of the bump height begins; 0 is none.
pub const HEAD_BUMP_PROGRAM: u32 = 7;
/// Head word: metres per unit of the bump height, as f32 bits.
pub const HEAD_BUMP_SCALE: u32 = 8;
/// Head word: the opacity where no node drives it, as f32 bits.
pub const HEAD_OPACITY: u32 = 9;
/// Three head words: the emission where no node drives it, else the factor on what does, as f32 bits.
pub const HEAD_EMISSION: u32 = 10;
/// Head word: the second word of [`super::Outputs`].
pub const HEAD_MORE: u32 = 13;
/// In [`HEAD_FLAGS`]: the material is a blend of two others.
pub const FLAG_BLEND: u32 = 1 << 31;
/// In [`HEAD_FLAGS`] of a blend: the mask is a constant and not a link.
pub const FLAG_CONSTANT_MASK: u32 = 1 << 30;

/// A program's room is at least this many words, so that a small one can grow.
const MIN_ROOM: u32 = 32;

/// Heads and programs in one buffer.
#[derive(Debug, Clone, Default)]
pub(super) struct ProgramMemory {
    words: Vec<u32>,
    /// Of a material: for its program, and for that of its bump height.
    rooms: Vec<[Range<u32>; 2]>,
    changed: RangeSet,
}

impl ProgramMemory {
    /// Empty heads for so many materials.
    pub(super) fn new(materials: usize) -> Self {
        Self {
            words: vec![0; materials * HEAD_WORDS as usize],
            rooms: vec![[0..0, 0..0]; materials],
            changed: RangeSet::default(),
        }
    }

    pub(super) fn words(&self) -> &[u32] {
        &self.words
    }

    pub(super) fn head(&self, material: u32, word: u32) -> u32 {
        self.words[(material * HEAD_WORDS + word) as usize]
    }

    pub(super) fn set_head(&mut self, material: u32, word: u32, value: u32) {
        let at = material * HEAD_WORDS + word;
        let slot = &mut self.words[at as usize];
        if *slot != value {
            *slot = value;
            self.changed.add(at..at + 1);
        }
    }

    /// Puts a program, with what lies before it, into its room, or into a new one twice its size behind everything else. `head_word`
    /// says which program of the material: [`HEAD_PROGRAM`] or [`HEAD_BUMP_PROGRAM`].
    pub(super) fn store(&mut self, material: u32, head_word: u32, before: &[u32], program: &[u32]) {
        let words = [before, program].concat();
        let len = words.len() as u32;
        let room = &mut self.rooms[material as usize][usize::from(head_word == HEAD_BUMP_PROGRAM)];
        if len > room.end - room.start {
            let start = self.words.len() as u32;
            *room = start..start + (2 * len).max(MIN_ROOM);
            self.words.resize(room.end as usize, 0);
        }
        let start = room.start;
        let target = &mut self.words[start as usize..(start + len) as usize];
        if target != words {
            target.copy_from_slice(&words);
            self.changed.add(start..start + len);
        }
        self.set_head(material, head_word, start + before.len() as u32);
    }

    pub(super) fn take_changes(&mut self) -> Vec<Range<u32>> {
        self.changed.take()
    }
}

/// Ranges of words, merged when they are taken.
#[derive(Debug, Clone, Default)]
pub(super) struct RangeSet {
    ranges: Vec<Range<u32>>,
    /// How many were left when they were last merged.
    merged: usize,
}

impl RangeSet {
    pub(super) fn add(&mut self, range: Range<u32>) {
        if range.is_empty() {
            return;
        }
        self.ranges.push(range);
        // Edits without an upload between them must not pile up. Merging waits for as many again as can't be merged.
        if self.ranges.len() >= (2 * self.merged).max(4096) {
            self.ranges = merged(std::mem::take(&mut self.ranges));
            self.merged = self.ranges.len();
        }
    }

    /// Disjoint ranges in ascending order.
    pub(super) fn take(&mut self) -> Vec<Range<u32>> {
        self.merged = 0;
        merged(std::mem::take(&mut self.ranges))
    }
}

/// Sorted, with ranges joined that overlap or touch.
fn merged(mut ranges: Vec<Range<u32>>) -> Vec<Range<u32>> {
    ranges.sort_by_key(|r| r.start);
    let mut out: Vec<Range<u32>> = Vec::new();
    for range in ranges {
        match out.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => out.push(range),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_fits_stays_where_it_is() {
        let mut memory = ProgramMemory::new(2);
        memory.store(1, HEAD_PROGRAM, &[], &[7; 20]);
        let start = memory.head(1, HEAD_PROGRAM);
        assert_eq!(start, 2 * HEAD_WORDS);
        memory.take_changes();
        memory.store(1, HEAD_PROGRAM, &[], &[8; 40]);
        assert_eq!(memory.head(1, HEAD_PROGRAM), start);
        assert_eq!(memory.take_changes(), vec![start..start + 40]);
        memory.store(0, HEAD_PROGRAM, &[], &[1]);
        memory.store(1, HEAD_PROGRAM, &[], &[9; 41]);
        assert!(memory.head(1, HEAD_PROGRAM) > memory.head(0, HEAD_PROGRAM));
        assert_eq!(
            memory.words().len() as u32,
            memory.head(1, HEAD_PROGRAM) + 82
        );
    }

    #[test]
    fn storing_the_same_again_changes_nothing() {
        let mut memory = ProgramMemory::new(1);
        memory.store(0, HEAD_PROGRAM, &[], &[1, 2, 3]);
        memory.set_head(0, HEAD_FLAGS, 5);
        assert!(!memory.take_changes().is_empty());
        memory.store(0, HEAD_PROGRAM, &[], &[1, 2, 3]);
        memory.set_head(0, HEAD_FLAGS, 5);
        assert_eq!(memory.take_changes(), []);
    }

    #[test]
    fn ranges_pile_up_only_while_they_are_apart() {
        let mut set = RangeSet::default();
        for i in 0..100_000 {
            set.add(7 * (i % 10)..7 * (i % 10) + 1);
        }
        assert!(set.ranges.len() < 4096);
        for i in 0..100_000 {
            set.add(2 * i..2 * i + 1);
        }
        // Each of the five odd ones joins its two neighbours.
        assert_eq!(set.take().len(), 100_000 - 5);
        assert!(set.take().is_empty());
    }

    #[test]
    fn ranges_that_touch_are_joined() {
        assert_eq!(merged(vec![8..9, 0..2, 2..4, 3..5, 9..10]), [0..5, 8..10]);
    }
}
