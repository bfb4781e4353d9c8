//! Parts of a picture that films may hold alone: pixels of a whole that is never made.

/// Where a film lies in the whole picture that it is a part of. How large the part is, its film knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crop {
    /// First column in the whole, from the left.
    pub left: u32,
    /// First row in the whole, from the top.
    pub top: u32,
    /// Columns and rows of the whole.
    pub whole: [u32; 2],
}

impl Crop {
    /// Whether a part of so many columns and rows lies in the whole.
    pub fn holds(&self, width: u32, height: u32) -> bool {
        let fits = |first: u32, count: u32, whole: u32| {
            first.checked_add(count).is_some_and(|end| end <= whole)
        };
        fits(self.left, width, self.whole[0]) && fits(self.top, height, self.whole[1])
    }

    /// As settings have it: first column and row, columns and rows.
    pub fn written(&self, width: u32, height: u32) -> String {
        format!("{},{},{width},{height}", self.left, self.top)
    }

    /// That of a film of so many columns and rows, from settings; `None` where they make no sense, as those of a changed file.
    pub(crate) fn read(written: &str, size: &str, width: u32, height: u32) -> Option<Self> {
        let numbers: Option<Vec<u32>> = written.split(',').map(|n| n.parse().ok()).collect();
        let &[left, top, _, _] = numbers?.as_slice() else {
            return None;
        };
        let (columns, rows) = size.split_once('x')?;
        let whole = [columns.parse().ok()?, rows.parse().ok()?];
        let is_size = whole.iter().all(|&side| side <= super::MAX_SIDE);
        let crop = Self { left, top, whole };
        (is_size && crop.holds(width, height)).then_some(crop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_lies_in_its_whole() {
        let crop = Crop {
            left: 10,
            top: 4,
            whole: [40, 20],
        };
        assert!(crop.holds(30, 16) && !crop.holds(31, 16) && !crop.holds(30, 17));
        assert!(!crop.holds(u32::MAX, 1));
        let written = crop.written(30, 16);
        assert_eq!(written, "10,4,30,16");
        assert_eq!(Crop::read(&written, "40x20", 30, 16), Some(crop));
        for (written, size) in [
            ("10,4,30", "40x20"),
            ("-1,4,30,16", "40x20"),
            ("10,4,30,16", "39x20"),
            ("10,4,30,16", "40"),
            ("4294967295,4,30,16", "40x20"),
            ("10,4,30,16", "99999x20"),
        ] {
            assert_eq!(Crop::read(written, size, 30, 16), None, "{written} {size}");
        }
    }
}
