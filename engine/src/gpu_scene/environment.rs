//! The environment on the GPU: its picture and the alias table by which directions are sampled.

use device::{Device, DeviceError, Format, Image, ImageUse, Resources};

use crate::{
    alias::{AliasCell, alias_table},
    scene::{Environment, FloatImage},
};

use super::{
    images::filled_image,
    sky_parts::{PARTS, SKY_PARTS, facing_rows},
};

/// Largest sampling table; larger pictures are summed up into its cells.
pub(super) const MAX_TABLE: (u32, u32) = (1024, 512);
/// Texels of the picture that are made ready for the device at once.
pub(super) const STRIP: u32 = 1 << 20;
/// Columns and rows of the table of a constant environment: each part of the sky has a column, and rows enough to follow the sine of the
/// polar angle.
const CONSTANT_TABLE: [u32; 2] = [SKY_PARTS[0], 256];

/// The environment as kernels see it.
#[derive(Debug)]
pub struct GpuEnvironment {
    /// `environment_image`.
    pub image: Image,
    /// `environment_table`.
    pub table: Image,
    /// `facing_sky`.
    facing: Image,
    /// Texels of the picture.
    pub size: [u32; 2],
    /// Cells of the table.
    pub table_size: [u32; 2],
    /// Factor on the picture.
    pub scale: [f32; 3],
    /// Rotation / 360°.
    pub turn: f32,
    /// Whether any light comes from it.
    pub emits: bool,
    /// Whether it is nowhere much brighter than elsewhere: a ray that leaves a surface is as good a way to find its light as any.
    pub is_even: bool,
    /// Probability of each part of the sky, row by row.
    pub(crate) parts: Vec<f64>,
}

impl GpuEnvironment {
    /// Uploads the environment.
    ///
    /// # Errors
    /// If the picture is larger than the device allows.
    pub fn new(device: &Device, environment: &Environment) -> Result<Self, DeviceError> {
        match environment {
            Environment::Constant(radiance) => {
                let white = FloatImage {
                    width: 1,
                    height: 1,
                    rgb: vec![[1.0; 3]],
                };
                let [columns, rows] = CONSTANT_TABLE;
                let weights: Vec<f64> = (0..columns * rows)
                    .map(|cell| row_sine(cell / columns, rows))
                    .collect();
                let emits = radiance.max_element() > 0.0;
                Self::upload(
                    device,
                    &white,
                    CONSTANT_TABLE,
                    &weights,
                    radiance.to_array(),
                    0.0,
                    (emits, true),
                )
            }
            Environment::Image {
                image,
                rotation,
                intensity,
            } => {
                let limit = device.limits().image_side;
                if image.width.max(image.height) > limit {
                    return Err(DeviceError::TooLarge {
                        what: "the environment picture's side".to_owned(),
                        needed: u64::from(image.width.max(image.height)),
                        limit: u64::from(limit),
                        remedy: "reduce the picture",
                    });
                }
                let table = [image.width.min(MAX_TABLE.0), image.height.min(MAX_TABLE.1)];
                let weights = table_weights(image, table);
                let emits = *intensity > 0.0 && weights.iter().any(|&w| w > 0.0);
                Self::upload(
                    device,
                    image,
                    table,
                    &weights,
                    [*intensity; 3],
                    rotation / 360.0,
                    (emits, is_even(&weights, table)),
                )
            }
        }
    }

    /// Gives its images the names by which kernels know them.
    pub(super) fn name(&self, resources: &mut Resources) {
        resources.set_image("environment_image", self.image.clone());
        resources.set_image("environment_table", self.table.clone());
        resources.set_image("facing_sky", self.facing.clone());
    }

    /// Stands for what is known of where the sky is seen, until something is.
    pub(super) fn name_unknown_sky(
        device: &Device,
        resources: &mut Resources,
    ) -> Result<(), DeviceError> {
        let nothing = bytemuck::bytes_of(&[0.0_f32; 4]);
        let image = filled_image(device, "unknown sky", [1; 2], Format::Rgba32Float, nothing)?;
        resources.set_image("known_sky", image);
        Ok(())
    }

    /// Takes over intensity and rotation; false where that is not all that has changed, and nothing is done.
    pub fn update(&mut self, device: &Device, environment: &Environment) -> bool {
        let (scale, turn) = match environment {
            Environment::Constant(radiance) => (radiance.to_array(), 0.0),
            Environment::Image {
                rotation,
                intensity,
                ..
            } => ([*intensity; 3], rotation / 360.0),
        };
        // A picture that is black emits at no intensity.
        let emitted = self.scale.iter().any(|&s| s > 0.0);
        let emits = scale.iter().any(|&s| s > 0.0);
        if emitted != emits {
            return false;
        }
        let turn = turn.rem_euclid(1.0);
        if turn != self.turn {
            let rows = facing_rows(&self.parts, turn);
            let [width, height, _] = self.facing.size();
            self.facing
                .write(device, [0; 3], [width, height], bytemuck::cast_slice(&rows));
        }
        (self.scale, self.turn) = (scale, turn);
        true
    }

    fn upload(
        device: &Device,
        image: &FloatImage,
        table_size: [u32; 2],
        weights: &[f64],
        scale: [f32; 3],
        turn: f32,
        (emits, is_even): (bool, bool),
    ) -> Result<Self, DeviceError> {
        let (in_parts, parts) = part_tables(weights, table_size);
        let whole = (alias_table(weights).into_iter()).map(|cell| (cell, table_size[0]));
        let cells: Vec<[u32; 4]> = whole
            .chain(in_parts)
            .map(|(c, width)| {
                [
                    (c.alias % width) | ((c.alias / width) << 16),
                    c.threshold.to_bits(),
                    (c.probability * weights.len() as f32).to_bits(),
                    0,
                ]
            })
            .collect();
        let rows = facing_rows(&parts, turn);
        Ok(Self {
            facing: filled_image(
                device,
                "sky by facing",
                [PARTS as u32 / 4, (rows.len() / PARTS) as u32],
                Format::Rgba32Float,
                bytemuck::cast_slice(&rows),
            )?,
            image: picture(device, image)?,
            table: filled_image(
                device,
                "environment table",
                [table_size[0], 2 * table_size[1]],
                Format::Rgba32Uint,
                bytemuck::cast_slice(&cells),
            )?,
            size: [image.width, image.height],
            table_size,
            scale,
            turn: turn.rem_euclid(1.0),
            emits,
            is_even,
            parts,
        })
    }
}

/// The picture on the device. It goes there in strips of whole rows: at once it would take more room beside than it has itself.
fn picture(device: &Device, image: &FloatImage) -> Result<Image, DeviceError> {
    let size = [image.width, image.height, 1];
    let there = device.image(
        "environment image",
        ImageUse::Read,
        size,
        Format::Rgba32Float,
    )?;
    let rows = (STRIP / image.width).max(1);
    let strips = image.rgb.chunks((rows * image.width) as usize);
    for (row, strip) in (0..).step_by(rows as usize).zip(strips) {
        let texels: Vec<[f32; 4]> = strip.iter().map(|c| [c[0], c[1], c[2], 1.0]).collect();
        let size = [image.width, strip.len() as u32 / image.width];
        there.write(device, [0, row, 0], size, bytemuck::cast_slice(&texels));
    }
    Ok(there)
}

/// Of each cell its entry in the alias table of its part of the sky, whose cells are numbered row by row, with the number of columns there;
/// and the probability of each part.
fn part_tables(weights: &[f64], table: [u32; 2]) -> (Vec<(AliasCell, u32)>, Vec<f64>) {
    let total = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mut entries: Vec<_> = (alias_table(weights).into_iter())
        .map(|cell| (cell, 1))
        .collect();
    let mut probabilities = Vec::new();
    let [columns, rows] = SKY_PARTS;
    for part in 0..columns * rows {
        let across =
            begin(part % columns, columns, table[0])..begin(part % columns + 1, columns, table[0]);
        let down = begin(part / columns, rows, table[1])..begin(part / columns + 1, rows, table[1]);
        let cells: Vec<usize> = (down.flat_map(|y| across.clone().map(move |x| y * table[0] + x)))
            .map(|cell| cell as usize)
            .collect();
        let own: Vec<f64> = cells.iter().map(|&cell| weights[cell]).collect();
        let width = across.len() as u32;
        for (&cell, entry) in cells.iter().zip(alias_table(&own)) {
            entries[cell] = (entry, width);
        }
        probabilities.push(own.iter().sum::<f64>() / total);
    }
    (entries, probabilities)
}

/// The first column of a table that lies in a column of parts, or the first row.
fn begin(part: u32, parts: u32, side: u32) -> u32 {
    (part * side).div_ceil(parts)
}

/// A cell is bright where its radiance is as many times the mean of all directions.
const BRIGHT: f64 = 16.0;
/// Share of the light that may come from bright cells.
const MOST_FROM_BRIGHT: f64 = 0.1;

/// Whether little of the light comes from small bright parts: of a sun in the sky, say.
fn is_even(weights: &[f64], table: [u32; 2]) -> bool {
    let sine = |cell: usize| row_sine(cell as u32 / table[0], table[1]);
    let light: f64 = weights.iter().sum();
    let angle: f64 = (0..weights.len()).map(sine).sum();
    let from_bright: f64 = (weights.iter().enumerate())
        .filter(|(cell, weight)| **weight * angle > BRIGHT * light * sine(*cell))
        .map(|(_, weight)| weight)
        .sum();
    from_bright <= MOST_FROM_BRIGHT * light
}

/// Sine of the polar angle in the middle of a row.
fn row_sine(row: u32, rows: u32) -> f64 {
    ((f64::from(row) + 0.5) / f64::from(rows) * std::f64::consts::PI).sin()
}

/// Luminance times solid angle of each cell. Texels are spread as bilinear interpolation spreads them, so that no
/// direction with light has a pdf of zero.
fn table_weights(image: &FloatImage, table: [u32; 2]) -> Vec<f64> {
    let (w, h) = (image.width as i64, image.height as i64);
    let luminance = |x: i64, y: i64| {
        let [r, g, b] = image.rgb[(y.clamp(0, h - 1) * w + x.rem_euclid(w)) as usize];
        f64::from(0.2126 * r + 0.7152 * g + 0.0722 * b)
    };
    let mut weights = vec![0.0; (table[0] * table[1]) as usize];
    for y in 0..h {
        let row = (y * i64::from(table[1]) / h) as u32;
        let sine = row_sine(row, table[1]);
        for x in 0..w {
            let column = (x * i64::from(table[0]) / w) as u32;
            let mut sum = 0.0;
            for (dy, wy) in [(-1, 1.0), (0, 2.0), (1, 1.0)] {
                for (dx, wx) in [(-1, 1.0), (0, 2.0), (1, 1.0)] {
                    sum += wx * wy * luminance(x + dx, y + dy);
                }
            }
            weights[(row * table[0] + column) as usize] += sum * sine;
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a sky is even of which so many texels are so much brighter than the rest.
    fn with_bright(texels: usize, radiance: f32) -> bool {
        let table = [64, 32];
        let mut image = FloatImage {
            width: table[0],
            height: table[1],
            rgb: vec![[0.5, 0.7, 1.0]; 64 * 32],
        };
        image.rgb[16 * 64..][..texels].fill([radiance; 3]);
        is_even(&table_weights(&image, table), table)
    }

    #[test]
    fn parts_of_the_sky_hold_what_the_whole_does() {
        // Tables that parts divide, that they don't, and that have fewer cells than parts.
        for table in [[64, 32], [50, 27], [7, 3], [1, 1]] {
            let count = table[0] * table[1];
            let weights: Vec<f64> = (0..count).map(|i| f64::from(i * 7 % 13)).collect();
            let whole = alias_table(&weights);
            let (entries, parts) = part_tables(&weights, table);
            assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12 || count == 1);
            for cell in 0..count {
                let [x, y] = [cell % table[0], cell / table[0]];
                let part = y * SKY_PARTS[1] / table[1] * SKY_PARTS[0] + x * SKY_PARTS[0] / table[0];
                let by_part = parts[part as usize] as f32 * entries[cell as usize].0.probability;
                let at_once = whole[cell as usize].probability;
                assert!(
                    (by_part - at_once).abs() < 1e-6 || count == 1,
                    "{table:?} {cell}"
                );
            }
        }
    }

    #[test]
    fn a_large_picture_arrives_whole() {
        let device = Device::open(&device::DeviceChoice::Native(1)).expect("the processor");
        // Two strips, the second one shorter.
        let (width, height) = (2048, STRIP / 2048 + 3);
        let rgb = (0..width * height).map(|i| [i as f32, 0.5, 2.0]).collect();
        let image = FloatImage { width, height, rgb };
        let there = picture(&device, &image).expect("there is room");
        let bytes = there.read(&device).expect("it can be read");
        let texels: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        let is_there = |(i, texel): (usize, &[f32; 4])| *texel == [i as f32, 0.5, 2.0, 1.0];
        assert_eq!(texels.len(), image.rgb.len());
        assert!(texels.iter().enumerate().all(is_there));
    }

    #[test]
    fn a_sun_makes_a_sky_uneven() {
        assert!(with_bright(0, 0.0));
        assert!(with_bright(1, 50.0)); // little light
        assert!(with_bright(400, 10.0)); // large
        assert!(!with_bright(1, 1e4));
        assert!(!with_bright(8, 200.0));
    }
}
