//! How a picture is divided.

use std::fmt;

/// Pieces begin with whole blocks of pixels: what adaptive sampling decides about, and what a wave begins with.
const BLOCK: u32 = 8;

/// A picture in bands of whole rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::render) struct Division {
    width: u32,
    height: u32,
    /// Of each piece but the last, which may have fewer.
    rows: u32,
}

/// Some rows of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Piece {
    /// From 0 on, from the top.
    pub(super) number: u32,
    /// First row.
    pub(super) top: u32,
    /// Columns, which are those of the picture, and rows.
    pub(super) width: u32,
    pub(super) rows: u32,
}

impl Division {
    /// In pieces of so many rows.
    pub(super) fn new([width, height]: [u32; 2], rows: u32) -> Self {
        Self {
            width,
            height,
            rows: rows.clamp(1, height.max(1)),
        }
    }

    /// In pieces of about so many pixels, or smaller ones that fit; the smallest there are where none do.
    pub(super) fn fitting(size: [u32; 2], pixels: u32, fits: impl Fn(&Self) -> bool) -> Self {
        let [width, height] = size;
        let mut rows = (pixels / width.max(1)).min(height) / BLOCK * BLOCK;
        loop {
            let division = Self::new(size, rows.max(BLOCK));
            if rows <= BLOCK || fits(&division) {
                return division;
            }
            rows = (rows / 2).next_multiple_of(BLOCK);
        }
    }

    /// How many pieces there are.
    pub(super) fn count(&self) -> u32 {
        self.height.div_ceil(self.rows)
    }

    /// The piece of this number.
    pub(super) fn piece(&self, number: u32) -> Piece {
        let top = number * self.rows;
        Piece {
            number,
            top,
            width: self.width,
            rows: self.rows.min(self.height.saturating_sub(top)),
        }
    }

    /// From the top.
    pub(super) fn pieces(self) -> impl Iterator<Item = Piece> {
        (0..self.count()).map(move |number| self.piece(number))
    }
}

impl fmt::Display for Division {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, rows, .. } = self;
        match self.count() {
            1 => write!(f, "1 piece of {width}x{rows}"),
            count => write!(f, "{count} pieces of {width}x{rows}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: u32 = 512 * 512;

    #[test]
    fn pieces_are_as_large_whatever_the_picture_is() {
        for (size, text) in [
            ([4096, 4096], "64 pieces of 4096x64"),
            ([16384, 16384], "1024 pieces of 16384x16"),
            ([512, 512], "1 piece of 512x512"),
            ([1920, 1080], "8 pieces of 1920x136"),
            ([100, 20], "2 pieces of 100x16"),
            ([16384, 1], "1 piece of 16384x1"),
        ] {
            let division = Division::fitting(size, PIXELS, |_| true);
            assert_eq!(division.to_string(), text);
        }
    }

    #[test]
    fn pieces_cover_the_picture_once() {
        for (size, most) in [
            ([1920, 1080], 40),
            ([1920, 1080], 8),
            ([33, 100], 16),
            ([3, 5], 8),
        ] {
            let division = Division::fitting(size, PIXELS, |division| division.rows <= most);
            let mut next = 0;
            for (number, piece) in division.pieces().enumerate() {
                assert_eq!((piece.number as usize, piece.top), (number, next));
                assert!(piece.rows > 0 && piece.rows <= most && piece.top.is_multiple_of(BLOCK));
                assert_eq!(piece.width, size[0]);
                next += piece.rows;
            }
            assert_eq!(next, size[1], "{division}");
        }
    }

    #[test]
    fn the_smallest_pieces_are_rows_of_blocks() {
        let division = Division::fitting([4096, 4096], PIXELS, |_| false);
        assert_eq!(division.to_string(), "512 pieces of 4096x8");
    }
}
