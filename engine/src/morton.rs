//! Morton's curve: numbers of cells in space such that cells with near numbers lie near each other.

use glam::UVec3;

/// The number of a cell, whose coordinates are below 2^21.
pub(crate) fn code(cell: UVec3) -> u64 {
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}

/// The lowest 21 bits of a number, two places apart.
fn spread(coordinate: u32) -> u64 {
    let mut v = u64::from(coordinate & 0x1f_ffff);
    v = (v | v << 32) & 0x001f_0000_0000_ffff;
    v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_of_the_coordinates_take_turns() {
        assert_eq!(code(UVec3::new(0b11, 0b01, 0b10)), 0b101_011);
        assert_eq!(code(UVec3::splat(0x1f_ffff)), (1 << 63) - 1);
    }
}
