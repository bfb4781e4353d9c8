//! What of a material a texture can drive: the rows of [`PARAMETERS`] that have a number.

use crate::scene::material_parameters::{Driven, Feature, PARAMETERS, Parameter};

pub use crate::scene::material_parameters::Kind;

use super::is_same;

/// Words of a material's head before the links.
pub const HEAD_LINKS: u32 = 16;
/// Words of a material's head in the memory of texture programs.
pub const HEAD_WORDS: u32 = (HEAD_LINKS + Output::ALL.len() as u32).next_multiple_of(8);

/// A value of a material that a texture can drive. Its number is its place in the head and its bit in [`Outputs`]; the
/// results of a hit are stored in the order of these numbers.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Output(u32);

/// Places in [`PARAMETERS`] by number.
const ROWS: [usize; count()] = rows();

const fn count() -> usize {
    let mut count = 0;
    let mut i = 0;
    while i < PARAMETERS.len() {
        count += PARAMETERS[i].driven.is_some() as usize;
        i += 1;
    }
    count
}

const fn rows() -> [usize; count()] {
    let mut rows = [0; count()];
    let mut i = 0;
    while i < PARAMETERS.len() {
        if let Some(driven) = PARAMETERS[i].driven {
            rows[driven.number as usize] = i;
        }
        i += 1;
    }
    rows
}

impl Output {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; count()] = {
        let mut all = [Self(0); count()];
        let mut i = 0;
        while i < all.len() {
            all[i] = Self(i as u32);
            i += 1;
        }
        all
    };

    /// Linear colour.
    pub const BASE_COLOR: Self = Self::of("base_color");
    /// 0 dielectric .. 1 metal.
    pub const METALLIC: Self = Self::of("metallic");
    /// Perceptual roughness.
    pub const ROUGHNESS: Self = Self::of("roughness");
    /// Radiance, W/m²/sr, before the strength.
    pub const EMISSION: Self = Self::of("emission");
    /// Factor on the emission.
    pub const EMISSION_STRENGTH: Self = Self::of("emission_strength");
    /// How much of the surface is there.
    pub const OPACITY: Self = Self::of("opacity");
    /// Where reflections are stretched to, degrees from the tangent.
    pub const ANISOTROPY_ROTATION: Self = Self::of("anisotropy_rotation");
    /// The shading normal in the world.
    pub const NORMAL: Self = Self::of("normal");
    /// How far reflections are stretched.
    pub const ANISOTROPY: Self = Self::of("anisotropy");
    /// Factor on a normal map.
    pub const NORMAL_SCALE: Self = Self::of("normal_scale");
    /// Height above the surface. Stored as the slope of the surface, so it comes last: it is known last.
    pub const BUMP: Self = Self::of("bump");

    const fn of(key: &str) -> Self {
        let mut i = 0;
        while i < ROWS.len() {
            if is_same(PARAMETERS[ROWS[i]].key, key) {
                return Self(i as u32);
            }
            i += 1;
        }
        panic!("nothing that can be driven has this key");
    }

    /// Its row in the table.
    pub fn parameter(self) -> &'static Parameter {
        const ALL: &[Parameter] = &PARAMETERS;
        &ALL[ROWS[self.0 as usize]]
    }

    /// What the row's `driven.number` says.
    pub const fn number(self) -> u32 {
        self.0
    }

    /// Its key in a look.
    pub fn key(self) -> &'static str {
        self.parameter().key
    }

    /// What drives it.
    pub fn kind(self) -> Kind {
        self.parameter()
            .driven
            .map_or(Kind::Scalar, |driven| driven.kind)
    }

    /// As [`Self::words`], in constants.
    pub(crate) const fn most_words(self) -> u32 {
        match PARAMETERS[ROWS[self.0 as usize]].driven {
            Some(Driven {
                kind: Kind::Scalar, ..
            }) if self.0 != Self::BUMP.0 => 1,
            _ => 3,
        }
    }

    /// Words that its result takes in the state of a path.
    pub fn words(self) -> u32 {
        match self.kind() {
            // Of a height, the slope is stored.
            Kind::Scalar if self != Self::BUMP => 1,
            _ => 3,
        }
    }
}

/// Fields of a path, of four words, that the results of any material find room in.
pub const MOST_RESULT_FIELDS: u32 = {
    // The second word of the outputs.
    let mut words = 1;
    let mut i = 0;
    while i < Output::ALL.len() {
        words += Output::ALL[i].most_words();
        i += 1;
    }
    words.div_ceil(4)
};

impl std::fmt::Debug for Output {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.key())
    }
}

/// A set of outputs.
///
/// Kernels keep it in one word, where the first [`Outputs::LOW`] have their bits. The others have theirs in a second word,
/// which is there only where the bit [`Outputs::MORE`] says so: then a head has it in a word of its own, and a path before
/// the results of the outputs that it is about.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Outputs(u64);

impl Outputs {
    /// So many outputs have their bits in the first word. The two bits above are [`Self::MORE`] and what says that a
    /// material is a blend, which has no outputs.
    pub const LOW: u32 = 30;
    /// In the first word: there is a second one.
    pub const MORE: u32 = 1 << Self::LOW;

    /// Those in the words of a head that is no blend's.
    pub fn of_words(low: u32, more: u32) -> Self {
        let low = u64::from(low & (Self::MORE - 1));
        Self(low | u64::from(more) << Self::LOW)
    }

    /// As a head has them: the first word, and the second one.
    pub fn words(self) -> [u32; 2] {
        let more = (self.0 >> Self::LOW) as u32;
        let low = self.0 as u32 & (Self::MORE - 1);
        match more {
            0 => [low, 0],
            _ => [low | Self::MORE, more],
        }
    }

    /// Adds one.
    pub fn insert(&mut self, output: Output) {
        self.0 |= 1 << output.number();
    }

    /// Whether one is there.
    pub fn contains(self, output: Output) -> bool {
        self.0 & (1 << output.number()) != 0
    }

    /// Whether none is there.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// All of them, in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = Output> {
        Output::ALL
            .into_iter()
            .filter(move |&output| self.contains(output))
    }

    /// Words that the results of a hit take.
    pub fn result_words(self) -> u32 {
        let second = u32::from(self.words()[0] & Self::MORE != 0);
        self.iter().map(Output::words).sum::<u32>() + second
    }

    /// Whether kernels must be able to do something for one of them.
    pub fn need(self, feature: Feature) -> bool {
        self.iter()
            .any(|output| output.parameter().needs == Some(feature))
    }
}

impl FromIterator<Output> for Outputs {
    fn from_iter<I: IntoIterator<Item = Output>>(outputs: I) -> Self {
        let mut set = Self::default();
        outputs.into_iter().for_each(|output| set.insert(output));
        set
    }
}

// Shifts stay within the set, and what kernels keep within its two words.
const _: () = assert!(count() <= Outputs::LOW as usize + 32);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_word_is_there_only_where_it_is_needed() {
        let few = Outputs(0b101);
        assert_eq!(few.words(), [0b101, 0]);
        let many = Outputs(1 << 29 | 1 << 30 | 1 << 61);
        assert_eq!(many.words(), [1 << 29 | Outputs::MORE, 1 | 1 << 31]);
        for set in [few, many] {
            let [low, more] = set.words();
            assert_eq!(Outputs::of_words(low, more), set);
        }
    }

    #[test]
    fn heights_of_bump_maps_come_last_and_take_three_words() {
        assert_eq!(Output::ALL.last(), Some(&Output::BUMP));
        assert_eq!(Output::BUMP.kind(), Kind::Scalar);
        let set: Outputs = [Output::BUMP, Output::ROUGHNESS, Output::BASE_COLOR]
            .into_iter()
            .collect();
        assert_eq!(set.result_words(), 3 + 1 + 3);
    }
}
