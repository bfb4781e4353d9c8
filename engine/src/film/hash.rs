//! The checksum of a film's file, and of what a film was rendered from.

/// FNV-1a over words of 64 bits: eight times as fast as over bytes, and as good at telling accidents apart.
#[derive(Debug)]
pub(crate) struct Hash(u64);

impl Hash {
    pub(crate) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        let mut add = |word: u64| {
            // The rotation lets the high bits of a word reach the low ones.
            self.0 = (self.0 ^ word)
                .wrapping_mul(0x0100_0000_01b3)
                .rotate_left(29);
        };
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| add(u64::from_le_bytes(*word)));
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        add(u64::from_le_bytes(last));
        add(bytes.len() as u64);
    }

    pub(crate) fn value(&self) -> u64 {
        self.0
    }

    /// As text.
    pub(crate) fn finish(&self) -> String {
        format!("{:016x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_tell_apart_what_differs() {
        let of = |pieces: &[&[u8]]| {
            let mut hash = Hash::new();
            pieces.iter().for_each(|piece| hash.bytes(piece));
            hash.value()
        };
        let all = [
            of(&[]),
            of(&[b""]),
            of(&[b"\0"]),
            of(&[b"a"]),
            of(&[b"abcdefgh"]),
            of(&[b"abcdefghi"]),
            of(&[b"abcdefgh", b"i"]),
            of(&[b"\x80bcdefgh"]),
        ];
        for (i, a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|b| a != b), "{i}");
        }
        assert_eq!(of(&[b"abcdefghi"]), of(&[b"abcdefghi"]));
    }
}
