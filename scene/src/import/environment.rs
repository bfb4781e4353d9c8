//! Environment pictures, each a file of its own.

use super::error::ImportError;
use super::panorama;
use crate::FloatImage;
use crate::input::Files;
use std::path::Path;

/// Largest file (4 GiB).
const MAX_FILE: u64 = 4 << 30;

/// As much of a file tells the size of its picture, as a rule: names and colour profiles may stand before it.
const HEAD: u64 = 1 << 20;

/// The columns and rows of a picture that [`load_environment_image`] reads, by the first MiB of its file. `None` where that doesn't
/// tell, and where the file can't be read or has no such picture: why, that function says.
pub fn environment_image_size(files: &dyn Files, path: &Path) -> Option<[u32; 2]> {
    let start = files.read_start(path, HEAD).ok()?;
    texgen::guarded(|| panorama::size(&start)).ok().flatten()
}

/// Reads an equirectangular picture: OpenEXR or Radiance HDR, or PNG, JPEG and WebP, which are taken as sRGB.
/// Returns it with warnings: values that are negative or not finite become 0, and of an OpenEXR file with several layers the
/// first one with colours or luminance is taken, as it is seen in the display window.
///
/// # Errors
/// Where the file can't be read, is damaged, or is larger than 2^27 texels.
pub fn load_environment_image(
    files: &dyn Files,
    path: &Path,
) -> Result<(FloatImage, Vec<String>), ImportError> {
    let bytes = files
        .read(path, MAX_FILE)
        .map_err(|source| ImportError::Read {
            path: path.to_owned(),
            source,
        })?;
    // The decoders are foreign code fed with foreign bytes: a panic in one must not end the program.
    let decoded = texgen::guarded(|| panorama::decode(bytes))
        .unwrap_or_else(|_| Err("the decoder gave up on it".into()));
    let (mut image, notes) = decoded.map_err(|problem| {
        let path = path.to_owned();
        match problem.ends_with(panorama::SCALE_IT_DOWN) {
            true => ImportError::TooLarge { path, problem },
            false => ImportError::Environment { path, problem },
        }
    })?;
    let mut bad = 0u64;
    for value in image.rgb.iter_mut().flatten() {
        if !(value.is_finite() && *value >= 0.0) {
            *value = 0.0;
            bad += 1;
        }
    }
    let mut warnings = notes;
    if bad > 0 {
        warnings.push(format!(
            "{bad} values are negative or not finite; 0 is used"
        ));
    }
    let warnings = (warnings.iter())
        .map(|warning| format!("{}: {warning}", path.display()))
        .collect();
    Ok((image, warnings))
}
