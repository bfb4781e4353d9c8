//! The table of directional albedos in `microfacet.wgsl`: what share of light a rough surface reflects. It depends on
//! nothing but cosine, roughness and, for glass, the index of refraction. Its integrals take seconds, so they are part
//! of the program as a file, which a test computes anew.

#[cfg(test)]
mod integrals;

use device::{Device, DeviceError, Format, Image};

use super::images::filled_image;

/// Cells along each side of a block; as `ALBEDO_SIDE` in `microfacet.wgsl`.
const SIDE: u32 = 32;
/// Blocks of glass, as `GLASS_BLOCKS`.
const GLASS_BLOCKS: u32 = 15;
/// Cells of a block.
const CELLS: usize = (SIDE * SIDE) as usize;

/// Floats, little-endian: of each cell of the block of surfaces three numbers, then of each cell of the slices between which
/// the blocks of glass lie, two.
const NUMBERS: &[u8] = include_bytes!("table.f32");

/// Puts the table on the device.
///
/// # Errors
/// The device is out of memory.
pub fn upload(gpu: &Device) -> Result<Image, DeviceError> {
    filled_image(
        gpu,
        "albedo table",
        [SIDE, SIDE * (1 + GLASS_BLOCKS)],
        Format::Rgba32Float,
        bytemuck::cast_slice(&table()),
    )
}

/// The blocks, one below the other. A block of glass has the numbers of the slices at its two ends.
fn table() -> Vec<[f32; 4]> {
    let (words, _) = NUMBERS.as_chunks();
    let numbers: Vec<f32> = words.iter().map(|word| f32::from_le_bytes(*word)).collect();
    let (surfaces, glass) = numbers.split_at(3 * CELLS);
    let (surfaces, _) = surfaces.as_chunks();
    let mut table: Vec<_> = surfaces
        .iter()
        .map(|&[f0, f90, sheen]| [f0, f90, sheen, 0.0])
        .collect();
    let (glass, _) = glass.as_chunks();
    let next = glass.iter().skip(CELLS);
    table.extend((glass.iter().zip(next)).map(|(&[a, b], &[c, d])| [a, b, c, d]));
    table
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::*;

    /// `PATINA_UPDATE=1` writes the file.
    #[test]
    fn the_file_holds_the_integrals() {
        let numbers = integrals::numbers();
        if std::env::var_os("PATINA_UPDATE").is_some() {
            let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu_scene/albedo/table.f32");
            fs::write(file, bytes).expect("written");
            return;
        }
        assert_eq!(NUMBERS.len(), 4 * numbers.len());
        let (words, _) = NUMBERS.as_chunks();
        for (word, number) in words.iter().zip(numbers) {
            // Sines and powers of the platform differ in their last places, and sums of hundreds of them by some.
            let of_file = f32::from_le_bytes(*word);
            assert!(
                (of_file - number).abs() < 1e-5,
                "{of_file}, computed: {number}"
            );
        }
        assert_eq!(table().len(), CELLS * (1 + GLASS_BLOCKS as usize));
    }
}
