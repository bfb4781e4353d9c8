//! Films on a device pixel by pixel: to be worked on elsewhere, and to be shown again.

use device::{Device, DeviceError, Usage};

use crate::film::{Film, Layers};

use super::DeviceFilm;

/// What the camera sees first, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Surfaces {
    /// Linear base colour, 0 to 1; black where nothing is.
    pub base_color: Vec<[f32; 3]>,
    /// Shading normal in the world; zero where nothing is.
    pub normal: Vec<[f32; 3]>,
}

impl DeviceFilm {
    /// Mean radiance, row by row from the top. Waits for the device.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn radiance(&self, device: &Device) -> Result<Vec<[f32; 3]>, DeviceError> {
        let read = |plane| {
            let bytes = device.read(plane, 0, self.pixels() * 16)?;
            Ok(bytemuck::pod_collect_to_vec(&bytes))
        };
        let planes: Result<_, DeviceError> = self.planes.iter().map(read).collect();
        let film = Film::from_planes(self.width, self.height, Layers::default(), planes?);
        Ok(film.mean())
    }

    /// What its guides say of surfaces; `None` where it has none. Waits for the device.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn surfaces(&self, device: &Device) -> Result<Option<Surfaces>, DeviceError> {
        let Some(guides) = &self.guides else {
            return Ok(None);
        };
        let bytes = device.read(guides, 0, self.pixels() * 32)?;
        let records = bytemuck::pod_collect_to_vec::<_, [u32; 8]>(&bytes);
        let surfaces = records.iter().map(surface);
        let (base_color, normal) = surfaces.unzip();
        Ok(Some(Surfaces { base_color, normal }))
    }

    /// A film of one sample of each pixel with this radiance, to be shown on a device.
    ///
    /// # Errors
    /// The device has no room.
    ///
    /// # Panics
    /// There are other than `width` times `height` pixels.
    pub fn of_radiance(
        device: &Device,
        [width, height]: [u32; 2],
        radiance: &[[f32; 3]],
    ) -> Result<Self, DeviceError> {
        let mut film = Film::new(width, height);
        assert_eq!(film.pixels(), radiance.len(), "as many pixels as there are");
        for (pixel, &radiance) in radiance.iter().enumerate() {
            film.add_sample(pixel, radiance);
        }
        let planes = film.planes_by_name().map(|(_, plane)| {
            let label = "a picture to be shown";
            device.filled_buffer(label, Usage::Storage, bytemuck::cast_slice(plane))
        });
        let planes: Vec<_> = planes.collect::<Result<_, _>>()?;
        Ok(Self {
            width,
            height,
            planes: planes.try_into().expect("a film has these planes"),
            guides: None,
            groups: Vec::new(),
        })
    }

    fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// Base colour and normal of a record of `guide.wgsl`.
fn surface(record: &[u32; 8]) -> ([f32; 3], [f32; 3]) {
    const NOTHING: u32 = u32::MAX;
    if record[1] == NOTHING {
        return ([0.0; 3], [0.0; 3]);
    }
    let unorm = |bits: u32| (bits & 0xffff) as f32 / 65535.0;
    let color = [unorm(record[4]), unorm(record[4] >> 16), unorm(record[5])];
    (color, octahedral_normal(record[3]))
}

/// As `octahedral_decode` of `geometry.wgsl`.
fn octahedral_normal(packed: u32) -> [f32; 3] {
    let snorm = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let (x, y) = (snorm(packed), snorm(packed >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let folded = |a: f32, other: f32| match z < 0.0 {
        true => (1.0 - other.abs()) * if a < 0.0 { -1.0 } else { 1.0 },
        false => a,
    };
    let v = glam::Vec3::new(folded(x, y), folded(y, x), z);
    v.normalize_or_zero().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use device::DeviceChoice;

    #[test]
    fn what_is_brought_to_a_device_is_what_it_shows() {
        let device = Device::open(&DeviceChoice::Native(1)).expect("the processor");
        let radiance = [[0.0, 0.5, 2.0], [-0.25, 1.0, 100.0]];
        let film = DeviceFilm::of_radiance(&device, [2, 1], &radiance).expect("there is room");
        assert_eq!(film.radiance(&device).expect("it reads"), radiance);
        assert!(film.surfaces(&device).expect("it reads").is_none());
    }

    #[test]
    fn normals_are_unpacked_on_both_sides() {
        let packed = |x: f32, y: f32| {
            let snorm = |v: f32| u32::from(((v * 32767.0).round() as i16) as u16);
            snorm(x) | snorm(y) << 16
        };
        for (x, y, wanted) in [
            (0.0, 0.0, [0.0, 0.0, 1.0]),
            (1.0, 0.0, [1.0, 0.0, 0.0]),
            (0.0, -1.0, [0.0, -1.0, 0.0]),
            (1.0, 1.0, [0.0, 0.0, -1.0]),
        ] {
            let found = octahedral_normal(packed(x, y));
            let far = found.iter().zip(wanted).map(|(a, b)| (a - b).abs());
            assert!(far.fold(0.0, f32::max) < 1e-4, "{found:?} {wanted:?}");
        }
        assert_eq!(
            surface(&[0, u32::MAX, u32::MAX, 0, 0, 0, 0, 0]),
            ([0.0; 3], [0.0; 3])
        );
    }
}
