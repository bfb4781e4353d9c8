//! Environment pictures.

use engine::scene::import::load_environment_image;

use crate::{check_message, file, memory};

/// Held beside what the picture needs. A header may promise a picture that isn't there: it is allocated before that is
/// known.
const SLACK: usize = 256 << 20;

pub(crate) fn run(data: &[u8]) -> bool {
    let path = file("input.picture", data);
    match memory::within(data.len(), SLACK, || {
        load_environment_image(&engine::input::Disk, &path)
    }) {
        Ok((image, warnings)) => {
            assert_eq!(
                image.rgb.len(),
                image.width as usize * image.height as usize
            );
            let mut values = image.rgb.iter().flatten();
            assert!(values.all(|v| v.is_finite() && *v >= 0.0), "a value");
            warnings.iter().for_each(|text| check_message(text));
            true
        }
        Err(error) => {
            check_message(&error.to_string());
            false
        }
    }
}
