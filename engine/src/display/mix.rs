//! The lights of a film mixed on the device that rendered it: what is shown is a copy of its sums, to which each group's light is added as
//! often as wanted. Nothing is read back, and the film stays as it is.

use bytemuck::{Pod, Zeroable};
use device::{Buffer, Device, DeviceError, Extent, Kernel, Recording, Resources, Usage};

use crate::film::{self, GroupFactors, Multiple};
use crate::passes;

use super::DeviceFilm;

/// Planes of a film with the sums of radiance, all of them or in part.
const RADIANCE: usize = 3;

/// What the kernel calls the planes of a group.
const GROUP: [&str; 3] = ["group_red", "group_green", "group_blue"];

/// The light of a group on a device, a plane for each channel.
#[derive(Debug, Clone)]
pub(crate) struct GroupPlanes {
    /// Number of the group.
    pub(crate) number: usize,
    pub(crate) planes: [Buffer; 3],
}

/// `Mix` in `mix.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuMix {
    pixels: u32,
    negative: u32,
    red: u32,
    green: u32,
    blue: u32,
}

impl GpuMix {
    fn new(pixels: u32, multiple: &Multiple) -> Self {
        let [red, green, blue] = multiple.magnitudes;
        let bits = multiple.is_negative.iter().zip(0..);
        Self {
            pixels,
            negative: bits.map(|(&is_set, bit)| u32::from(is_set) << bit).sum(),
            red,
            green,
            blue,
        }
    }

    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(Self, $member))),*] };
        }
        offsets![pixels, negative, red, green, blue]
    }
}

/// Mixes the lights of films of one device.
#[derive(Debug)]
pub struct Mixer {
    device: Device,
    kernel: Kernel,
    /// What was mixed last.
    copy: Option<Copy>,
    /// A [`GpuMix`] for each group of which anything has been added so far.
    settings: Vec<Buffer>,
}

#[derive(Debug)]
struct Copy {
    size: [u32; 2],
    planes: [Buffer; RADIANCE],
}

impl Mixer {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(device: &Device) -> Result<Self, DeviceError> {
        let kernel = passes::display::mixing_kernel(device)?;
        Ok(Self::with_kernel(device, kernel))
    }

    /// Another one with the same kernel, for a film that is shown beside.
    #[must_use]
    pub fn another(&self) -> Self {
        Self::with_kernel(&self.device, self.kernel.clone())
    }

    fn with_kernel(device: &Device, kernel: Kernel) -> Self {
        Self {
            device: device.clone(),
            kernel,
            copy: None,
            settings: Vec::new(),
        }
    }

    /// The picture of a film with its groups of lights multiplied by factors, without these groups. It is good until the next film is
    /// mixed. Number and squares of samples are those of the film, and so are the guides; groups that it doesn't keep apart stay as they are.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn mix(
        &mut self,
        film: &DeviceFilm,
        factors: &GroupFactors,
    ) -> Result<DeviceFilm, DeviceError> {
        let groups = film.groups.iter();
        let added: Vec<_> = groups
            .map(|group| (group, factors.multiple(group.number)))
            .filter(|(_, multiple)| !multiple.is_none())
            .collect();
        if added.is_empty() {
            return Ok(film.picture());
        }
        let size = [film.width, film.height];
        let former = self.copy.take().filter(|copy| copy.size == size);
        let copy = match former {
            Some(copy) => copy,
            None => Copy::new(&self.device, film)?,
        };
        let planes = &self.copy.insert(copy).planes;
        let bytes = size_of::<GpuMix>() as u64;
        while self.settings.len() < added.len() {
            let settings = self.device.buffer("a light mix", Usage::Storage, bytes)?;
            self.settings.push(settings);
        }
        let pixels = film.width * film.height;
        let mut recording = Recording::new("light mix");
        for (from, to) in film.planes.iter().zip(planes) {
            recording.copy(from, to);
        }
        for ((group, multiple), settings) in added.into_iter().zip(&self.settings) {
            let mix = GpuMix::new(pixels, &multiple);
            self.device.write(settings, 0, bytemuck::bytes_of(&mix));
            let mut resources = Resources::default();
            resources.set_buffer("mix_of", settings.clone());
            for (name, plane) in film::PICTURE_PLANES.into_iter().zip(planes) {
                resources.set_buffer(name, plane.clone());
            }
            for (name, plane) in GROUP.into_iter().zip(&group.planes) {
                resources.set_buffer(name, plane.clone());
            }
            let bound = self.kernel.bind(&self.device, &resources);
            recording.dispatch(&bound, Extent::Threads(pixels));
        }
        self.device.start(&recording)?;
        let mut mixed = film.picture();
        mixed.planes[..RADIANCE].clone_from_slice(planes);
        Ok(mixed)
    }
}

impl Copy {
    fn new(device: &Device, film: &DeviceFilm) -> Result<Self, DeviceError> {
        let plane = |plane: usize| {
            let bytes = film.planes[plane].size();
            device.buffer("a mixed picture", Usage::Storage, bytes)
        };
        Ok(Self {
            size: [film.width, film.height],
            planes: [plane(0)?, plane(1)?, plane(2)?],
        })
    }
}
