//! Why a file is no picture, and how large pictures may be.

/// Longest side, pixels.
pub(crate) const MAX_SIDE: usize = 32768;
/// Bytes that a PNG file may take beside its pixels while it is read, such as for a colour profile; larger profiles are left out. Packed,
/// they have a thousandth of their size.
pub(crate) const PNG_ASIDE: u64 = 64 << 20;
/// Numbers of a file that are taken whatever its size: 256 MiB of floats.
const FREE_VALUES: u64 = 1 << 26;
/// No file that is whole has more numbers a byte.
const VALUES_PER_BYTE: u64 = 1 << 12;
/// Most numbers of a file: 4 GiB of floats.
const MAX_VALUES: u64 = 1 << 30;

/// Why a file is no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PictureError {
    /// Of no format that is known.
    #[error(
        "it is no picture that can be read; give a PNG, JPEG, OpenEXR (.exr) or Radiance (.hdr) file"
    )]
    Foreign,
    /// Not as its format has it.
    #[error("the picture can't be read: {0}; save or render it again")]
    Damaged(String),
    /// It holds something that isn't read.
    #[error("the picture {0}")]
    Unsupported(String),
}

impl PictureError {
    pub(crate) fn damaged(error: impl ToString) -> Self {
        Self::Damaged(error.to_string())
    }
}

/// Refuses sizes that a file of so many bytes can't have, before memory is taken.
pub(crate) fn check_size(
    [width, height]: [usize; 2],
    channels: usize,
    bytes: usize,
) -> Result<(), PictureError> {
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) {
        let what = format!("is {width}x{height} pixels large; sides of 1 to {MAX_SIDE} are read");
        return Err(PictureError::Unsupported(what));
    }
    let values = width as u64 * height as u64 * channels as u64;
    if values > FREE_VALUES.max(VALUES_PER_BYTE.saturating_mul(bytes as u64)) {
        return Err(PictureError::Damaged(format!(
            "it claims {width}x{height} pixels, which so small a file can't hold"
        )));
    }
    if values > MAX_VALUES {
        let what = format!("has {values} numbers; no more than {MAX_VALUES} are read");
        return Err(PictureError::Unsupported(what));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_believed_as_far_as_the_file_can_hold_them() {
        assert!(check_size([1280, 720], 4, 100).is_ok());
        assert!(check_size([32768, 32768], 4, 1000).is_err());
        assert!(check_size([32769, 1], 4, 1 << 30).is_err());
        assert!(check_size([0, 1], 4, 1 << 30).is_err());
        assert!(check_size([32768, 32768], 4, usize::MAX).is_err());
    }
}
