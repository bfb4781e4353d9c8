//! Names as numbers: how kernels and files of pictures know what an object or a material is called.

/// The number of a name, as Cryptomatte has it (Friedman and Jones, "Cryptomatte specification 1.2.0"): 32-bit MurmurHash3 of
/// its UTF-8 bytes, changed in one bit where it wouldn't be a normal number as the bits of a 32-bit float, which is how files
/// keep it. Never 0. Two names may have the same number: one in four thousand million does with a given other.
pub fn name_id(name: &str) -> u32 {
    let hash = murmur3(name.as_bytes());
    match hash >> 23 & 255 {
        0 | 255 => hash ^ 1 << 23,
        _ => hash,
    }
}

/// MurmurHash3 of 32 bits with the seed 0 (Appleby 2011).
pub fn murmur3(bytes: &[u8]) -> u32 {
    let scramble = |word: u32| {
        let word = word.wrapping_mul(0xcc9e_2d51).rotate_left(15);
        word.wrapping_mul(0x1b87_3593)
    };
    let (words, rest) = bytes.as_chunks::<4>();
    let mut hash = 0_u32;
    for &word in words {
        hash ^= scramble(u32::from_le_bytes(word));
        hash = hash
            .rotate_left(13)
            .wrapping_mul(5)
            .wrapping_add(0xe654_6b64);
    }
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    hash ^= scramble(u32::from_le_bytes(last));
    // The length modulo 2^32, as the hash is defined.
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_specification() {
        // Values that are published for MurmurHash3_x86_32 with the seed 0.
        assert_eq!(murmur3(b""), 0);
        assert_eq!(murmur3(b"test"), 0xba6b_d213);
        assert_eq!(murmur3(b"Hello, world!"), 0xc036_3e43);
        assert_eq!(
            murmur3(b"The quick brown fox jumps over the lazy dog"),
            0x2e4f_f723
        );
        // The example of the specification.
        assert_eq!(name_id("hello"), 0x248b_fa47);
    }

    #[test]
    fn numbers_are_normal_floats() {
        assert_eq!(name_id(""), 1 << 23);
        for number in 0..100_000 {
            let id = f32::from_bits(name_id(&format!("object {number}")));
            assert!(id.is_normal(), "{number}");
        }
    }
}
