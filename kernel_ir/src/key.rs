//! What tells programs apart.

use std::hash::{Hash, Hasher};

use crate::ir::{Function, Program};

impl Program {
    /// A hash of all that one of its functions does, with those that it calls, whatever they are called and numbered: as
    /// [`Self::key`], but for that function alone.
    pub fn function_key(&self, index: usize) -> u128 {
        let function = &self.functions[index];
        let mut hash = Fnv::new();
        let Function {
            name: _,
            parameters,
            instructions,
            value_types,
            variable_types,
            labels,
            stack_bytes,
            callees,
        } = function;
        parameters.hash(&mut hash);
        instructions.hash(&mut hash);
        value_types.hash(&mut hash);
        variable_types.hash(&mut hash);
        (labels, stack_bytes).hash(&mut hash);
        for &callee in callees {
            // No function of WGSL calls itself, so this ends.
            hash.write(&self.function_key(callee).to_le_bytes());
        }
        hash.state
    }

    /// A hash of all that the program does (FNV-1a, 128 bits): the same on every platform, and of two programs that do
    /// different things the same only by a chance that is none.
    pub fn key(&self) -> u128 {
        let mut hash = Fnv::new();
        self.functions.hash(&mut hash);
        self.bindings.hash(&mut hash);
        self.workgroup_size.hash(&mut hash);
        self.scratch_bytes.hash(&mut hash);
        hash.state
    }
}

/// FNV-1a with 128 bits (Fowler, Noll, Vo; IETF draft-eastlake-fnv). Numbers count as their bytes, the lowest first, and
/// sizes as 64 bits, so that what is hashed when Patina is built is found on another kind of machine.
struct Fnv {
    state: u128,
}

impl Fnv {
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

    fn new() -> Self {
        Self {
            state: 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d,
        }
    }
}

impl Hasher for Fnv {
    fn finish(&self) -> u64 {
        self.state as u64
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.state = (self.state ^ u128::from(byte)).wrapping_mul(Self::PRIME);
        }
    }

    fn write_u32(&mut self, number: u32) {
        self.write(&number.to_le_bytes());
    }

    fn write_i32(&mut self, number: i32) {
        self.write(&number.to_le_bytes());
    }

    fn write_usize(&mut self, number: usize) {
        self.write(&(number as u64).to_le_bytes());
    }

    fn write_isize(&mut self, number: isize) {
        self.write(&(number as i64).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_one_that_is_published() {
        let mut hash = Fnv::new();
        hash.write(b"a");
        assert_eq!(hash.state, 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
    }
}
