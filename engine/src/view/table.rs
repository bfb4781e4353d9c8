//! Transforms that were published as tables: AgX and Filmic of Blender's configuration. A colour's logarithm looks up a grid of
//! colours, between whose nodes is interpolated in tetrahedra, and a curve makes sRGB codes of what was found.
//!
//! The grids hold the values of the published ones at their own nodes, so that nothing is lost but by rounding. They are PNG files
//! that `cargo xtask views --write` makes.

use std::sync::LazyLock;

use glam::{Mat3, Vec3};

use super::chromatic::{E_GAMUT, REC709};
use super::srgb;

/// Smallest value that has a logarithm here.
const LEAST: f32 = 1e-10;
/// Nodes of a curve.
const CURVE: usize = 1024;

/// A grid and a curve.
#[derive(Debug)]
pub(super) struct Table {
    /// To the space whose logarithm is taken.
    from_rec709: Mat3,
    /// Logarithms to base 2 at the grid's ends.
    stops: [f32; 2],
    /// Nodes along a side.
    size: usize,
    /// The first component runs fastest.
    nodes: Vec<Vec3>,
    /// sRGB codes of what the grid has, from 0 to `curve_end`.
    curve: Vec<f32>,
    curve_end: f32,
}

/// Both configurations count 10 stops below middle grey and 15 above it.
const STOPS: [f32; 2] = [-12.473_931, 12.526_069];

/// AgX, of which the table is in E-Gamut and codes of a display with an exponent of 2.4.
pub(super) fn agx() -> &'static Table {
    static AGX: LazyLock<Table> = LazyLock::new(|| {
        let curve = |i: usize| srgb((i as f32 / (CURVE - 1) as f32).powf(2.4));
        Table {
            from_rec709: REC709.to(&E_GAMUT).as_mat3(),
            stops: STOPS,
            size: 57,
            nodes: nodes(include_bytes!("tables/agx.png"), 1023),
            curve: (0..CURVE).map(curve).collect(),
            curve_end: 1.0,
        }
    });
    &AGX
}

/// Filmic, of which the table takes colour from what is bright, and the curve is that of medium contrast.
pub(super) fn filmic() -> &'static Table {
    static FILMIC: LazyLock<Table> = LazyLock::new(|| {
        let curve = nodes(include_bytes!("tables/filmic-curve.png"), u16::MAX);
        Table {
            from_rec709: Mat3::IDENTITY,
            stops: STOPS,
            size: 33,
            nodes: nodes(include_bytes!("tables/filmic.png"), 4095),
            curve: curve.iter().map(|node| node.x).collect(),
            curve_end: 0.66,
        }
    });
    &FILMIC
}

/// The pixels of a PNG file, of which `white` is 1.
fn nodes(png: &[u8], white: u16) -> Vec<Vec3> {
    let picture = image::load_from_memory_with_format(png, image::ImageFormat::Png);
    let picture = picture.expect("a part of the program").into_rgb16();
    let scale = 1.0 / f32::from(white);
    let pixels = picture.pixels();
    (pixels.map(|pixel| Vec3::from(pixel.0.map(f32::from)) * scale)).collect()
}

impl Table {
    /// From scene-linear Rec.709 to sRGB codes.
    pub(super) fn apply(&self, rgb: Vec3) -> [f32; 3] {
        let [low, high] = self.stops;
        let stops = (self.from_rec709 * rgb).to_array();
        let stops = Vec3::from(stops.map(|x| x.max(LEAST).log2()));
        let last = (self.size - 1) as f32;
        let at = (stops - low).clamp(Vec3::ZERO, Vec3::splat(high - low)) * (last / (high - low));
        self.node(at).to_array().map(|x| self.code(x))
    }

    /// Interpolated in the tetrahedron that the order of the fractions tells: from the lower corner of the cell along its axes,
    /// the largest fraction first.
    fn node(&self, at: Vec3) -> Vec3 {
        let cell = at.floor().min(Vec3::splat((self.size - 2) as f32));
        let fraction = (at - cell).to_array();
        let [x, y, z] = cell.to_array().map(|x| x as usize);
        let mut node = (z * self.size + y) * self.size + x;
        let strides = [1, self.size, self.size * self.size];
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| fraction[b].total_cmp(&fraction[a]));
        let mut before = 1.0;
        let mut sum = Vec3::ZERO;
        for axis in axes {
            sum += self.nodes[node] * (before - fraction[axis]);
            before = fraction[axis];
            node += strides[axis];
        }
        sum + self.nodes[node] * before
    }

    fn code(&self, x: f32) -> f32 {
        let last = self.curve.len() - 1;
        let at = (x / self.curve_end).clamp(0.0, 1.0) * last as f32;
        let below = (at as usize).min(last - 1);
        let [a, b] = [self.curve[below], self.curve[below + 1]];
        a + (b - a) * (at - below as f32)
    }

    /// In the order of `view.wgsl`: the matrix row by row, the ends, the sizes, the curve, the grid.
    pub(super) fn numbers(&self) -> Vec<f32> {
        let head = [
            self.stops[0],
            self.stops[1],
            self.size as f32,
            self.curve_end,
            self.curve.len() as f32,
        ];
        let matrix = self.from_rec709.transpose().to_cols_array();
        let nodes = self.nodes.iter().flat_map(|node| node.to_array());
        let numbers = matrix.into_iter().chain(head);
        (numbers.chain(self.curve.iter().copied()).chain(nodes)).collect()
    }
}
