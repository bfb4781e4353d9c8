//! Changes of inputs: always the same ones for a seed. Bytes are flipped, cut, repeated and replaced by numbers that
//! break arithmetic; texts get pieces and words that matter to their language, so that many of the results still are of it;
//! the JSON inside a `.glb` is changed as text, and its lengths are mended.

mod words;

use std::ops::Range;

use words::{GLTF_PIECES, GLTF_WORDS, LOOK_PIECES, LOOK_WORDS, NUMBERS, WGSL_PIECES, WGSL_WORDS};

/// Numbers without a pattern.
#[derive(Debug)]
pub struct Random(pub u64);

impl Random {
    /// A number below `limit`, which may be 0 for nothing to choose from.
    pub fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit.max(1)
    }

    fn choose<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

/// Between the scene and the look of an input of the target `render`; a comment of the look.
pub const SEPARATOR: &[u8] = b"\n# look\n";

/// Numbers as they lie in binary files.
const WORDS: [u32; 12] = [
    0,
    1,
    2,
    127,
    255,
    0xFFFF,
    0x7FFF_FFFF,
    0x8000_0000,
    0xFFFF_FFFF,
    0x7F80_0000, // infinity
    0x7FC0_0000, // not a number
    0x7F7F_FFFF, // the largest
];

/// The scene and the look of an input of the target `render`.
pub fn split(input: &[u8]) -> (&[u8], &[u8]) {
    let at = (input.windows(SEPARATOR.len())).position(|window| window == SEPARATOR);
    input.split_at(at.unwrap_or(input.len()))
}

/// Changes one to four places of anything.
pub fn bytes(input: &[u8], random: &mut Random) -> Vec<u8> {
    let mut data = input.to_vec();
    for _ in 0..1 + random.below(4) {
        let at = random.below(data.len() + 1);
        let end = (at + random.below(16)).min(data.len());
        match random.below(16) {
            // Most formats fall apart when lengths change.
            0 => drop(data.drain(at..end)),
            1 => data.truncate(at),
            2 => {
                let copy = data[at..end].to_vec();
                let to = random.below(data.len() + 1);
                data.splice(to..to, copy);
            }
            3..=6 => {
                let word = random.choose(&WORDS).to_le_bytes();
                let length = word.len().min(data.len() - at);
                data[at..at + length].copy_from_slice(&word[..length]);
            }
            7..=9 => {
                if let Some(byte) = data.get_mut(at) {
                    *byte ^= 1 << random.below(8);
                }
            }
            _ => {
                if let Some(byte) = data.get_mut(at) {
                    *byte = random.below(256) as u8;
                }
            }
        }
    }
    data
}

/// Changes a texture.
pub fn texture(input: &[u8], random: &mut Random) -> Vec<u8> {
    text(input, WGSL_PIECES, WGSL_WORDS, random)
}

/// Changes a look.
pub fn look(input: &[u8], random: &mut Random) -> Vec<u8> {
    text(input, LOOK_PIECES, LOOK_WORDS, random)
}

/// Changes a `.gltf` or a `.glb`: its numbers, its words, or its bytes.
pub fn gltf(input: &[u8], random: &mut Random) -> Vec<u8> {
    if random.below(4) == 0 {
        return bytes(input, random);
    }
    let change = |json: &[u8], random: &mut Random| match random.below(3) {
        0 => text(json, GLTF_PIECES, GLTF_WORDS, random),
        _ => numbers(json, random),
    };
    let Some((json, rest)) = glb_parts(input) else {
        return change(input, random);
    };
    let mut json = change(json, random);
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut file = input[..8].to_vec();
    file.extend((20 + json.len() as u32 + rest.len() as u32).to_le_bytes());
    file.extend((json.len() as u32).to_le_bytes());
    file.extend(&input[16..20]);
    file.extend(json);
    file.extend(rest);
    file
}

/// Changes a scene, its look, or both.
pub fn scene(input: &[u8], random: &mut Random) -> Vec<u8> {
    let (scene, look_of) = split(input);
    let which = random.below(4);
    let mut changed = match which {
        0 => scene.to_vec(),
        _ => gltf(scene, random),
    };
    match which {
        2.. => changed.extend(look_of),
        _ => changed.extend(look(look_of, random)),
    }
    changed
}

/// The JSON of a `.glb`, and what follows it.
fn glb_parts(input: &[u8]) -> Option<(&[u8], &[u8])> {
    let data = input.strip_prefix(b"glTF")?.get(16..)?;
    let length = u32::from_le_bytes(*input[12..].first_chunk()?);
    data.split_at_checked(length as usize)
}

/// Replaces one to three numbers of a JSON text.
fn numbers(json: &[u8], random: &mut Random) -> Vec<u8> {
    let mut json = json.to_vec();
    for _ in 0..1 + random.below(3) {
        let is_start = |at: &usize| {
            json[*at].is_ascii_digit()
                && *at > 0
                && matches!(json[at - 1], b':' | b',' | b'[' | b'-')
        };
        let starts: Vec<usize> = (0..json.len()).filter(is_start).collect();
        let Some(&start) = starts.get(random.below(starts.len())) else {
            continue;
        };
        let is_number = |c: &u8| c.is_ascii_digit() || b".-+eE".contains(c);
        let digits = json[start..].iter().take_while(|c| is_number(c)).count();
        json.splice(start..start + digits, random.choose(NUMBERS).bytes());
    }
    json
}

/// Changes a few pieces of a text: words, numbers, cuts, insertions and repetitions.
fn text(input: &[u8], pieces: &[&str], words: &[&str], random: &mut Random) -> Vec<u8> {
    let mut chars: Vec<char> = String::from_utf8_lossy(input).chars().collect();
    for _ in 0..1 + random.below(4) {
        if random.below(2) == 0 {
            replace_word(&mut chars, words, random);
            continue;
        }
        let at = random.below(chars.len() + 1);
        let end = (at + random.below(14)).min(chars.len());
        match random.below(4) {
            0 => drop(chars.drain(at..end)),
            1 => drop(chars.splice(at..at, random.choose(pieces).chars())),
            2 => drop(chars.splice(at..end, random.choose(pieces).chars())),
            _ => {
                let copy: Vec<char> = chars[at..end].to_vec();
                let to = random.below(chars.len() + 1);
                chars.splice(to..to, copy);
            }
        }
    }
    chars.into_iter().collect::<String>().into_bytes()
}

/// Puts some other word in the place of one: one of the text's own, or one of the language's; now and then a number.
fn replace_word(chars: &mut Vec<char>, words: &[&str], random: &mut Random) {
    let is_part = |c: &char| c.is_alphanumeric() || *c == '_';
    let mut own: Vec<Range<usize>> = Vec::new();
    for (at, _) in chars.iter().enumerate().filter(|(_, c)| is_part(c)) {
        match own.last_mut() {
            Some(last) if last.end == at => last.end += 1,
            _ => own.push(at..at + 1),
        }
    }
    if own.is_empty() {
        return;
    }
    let word = own[random.below(own.len())].clone();
    let other: Vec<char> = match random.below(8) {
        0..4 => chars[own[random.below(own.len())].clone()].to_vec(),
        4..7 => random.choose(words).chars().collect(),
        _ => random.choose(NUMBERS).chars().collect(),
    };
    chars.splice(word, other);
}
