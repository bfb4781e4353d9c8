//! The checksum of a film's file, and of what a film was rendered from.

use std::io::{self, Read, Write};

/// FNV-1a over words of 64 bits: eight times as fast as over bytes, and as good at telling accidents apart.
#[derive(Debug)]
pub(crate) struct Hash(u64);

impl Hash {
    pub(crate) fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.word(*word));
        self.end(rest, bytes.len() as u64);
    }

    fn word(&mut self, word: [u8; 8]) {
        // The rotation lets the high bits of a word reach the low ones.
        self.0 = (self.0 ^ u64::from_le_bytes(word))
            .wrapping_mul(0x0100_0000_01b3)
            .rotate_left(29);
    }

    /// What ends a run of so many bytes: those that fill no word.
    fn end(&mut self, rest: &[u8], length: u64) {
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.word(last);
        self.word(length.to_le_bytes());
    }

    pub(crate) fn value(&self) -> u64 {
        self.0
    }

    /// As text.
    pub(crate) fn finish(&self) -> String {
        format!("{:016x}", self.0)
    }
}

/// One run of bytes for [`Hash::bytes`] that comes in pieces.
#[derive(Debug)]
pub(crate) struct Run {
    hash: Hash,
    /// Bytes that fill no word yet.
    rest: Vec<u8>,
    length: u64,
}

impl Run {
    /// Goes on after what has been hashed.
    pub(crate) fn after(hash: Hash) -> Self {
        let rest = Vec::with_capacity(8);
        let length = 0;
        Self { hash, rest, length }
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.length += bytes.len() as u64;
        let missing = match self.rest.is_empty() {
            true => 0,
            false => (8 - self.rest.len()).min(bytes.len()),
        };
        let (first, bytes) = bytes.split_at(missing);
        self.rest.extend_from_slice(first);
        if let Ok(word) = <[u8; 8]>::try_from(&self.rest[..]) {
            self.hash.word(word);
            self.rest.clear();
        }
        let (words, rest) = bytes.as_chunks::<8>();
        words.iter().for_each(|word| self.hash.word(*word));
        self.rest.extend_from_slice(rest);
    }

    /// With all of them.
    pub(crate) fn finish(mut self) -> Hash {
        self.hash.end(&self.rest, self.length);
        self.hash
    }
}

/// A file whose bytes go into a checksum on their way.
pub(crate) struct Hashed<F> {
    pub(crate) file: F,
    pub(crate) run: Run,
}

impl<F: Write> Write for Hashed<F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.run.bytes(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl<F: Read> Read for Hashed<F> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(bytes)?;
        self.run.bytes(&bytes[..count]);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_may_come_in_pieces() {
        let bytes: Vec<u8> = (0..100).collect();
        let mut whole = Hash::new();
        whole.bytes(b"before");
        whole.bytes(&bytes);
        for sizes in [&[1, 2, 5, 8, 16, 3, 65][..], &[100], &[7, 93], &[0, 9, 91]] {
            let mut before = Hash::new();
            before.bytes(b"before");
            let mut run = Run::after(before);
            let mut left = &bytes[..];
            for &size in sizes {
                let (piece, rest) = left.split_at(size);
                run.bytes(piece);
                left = rest;
            }
            assert_eq!(run.finish().value(), whole.value(), "{sizes:?}");
        }
    }

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
