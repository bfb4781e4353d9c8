//! What a window shows of a film: written to a texture on the device that rendered it, nothing is read back.

mod mix;
mod pixels;

use bytemuck::{Pod, Zeroable};
use scene::view::{View, ViewTransform};

use crate::film;
use crate::passes;
use crate::view::{ViewEncoder, device_numbers};
use device::{
    Buffer, Device, DeviceError, Extent, Format, Image, ImageUse, Kernel, Recording, Resources,
    Usage,
};

pub(crate) use self::mix::GroupPlanes;
pub use self::mix::{GpuMix, Mixer};
pub use self::pixels::Surfaces;

/// What is shown of each pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Channel {
    /// Mean radiance: the picture.
    #[default]
    Radiance,
    /// Number of samples, as heat, relative to the most.
    Samples,
    /// Relative standard error, as heat: blue is 0.1 %, red 100 %.
    Error,
    /// Shading normal of the surface that is seen first, normal maps and textures included, from -1..1 to 0..1.
    Normal,
    /// Its distance; nearer is brighter.
    Distance,
    /// Its material, each with a colour of its own.
    Material,
    /// Its object.
    Object,
    /// Its base colour, encoded as sRGB without exposure or view transform.
    BaseColor,
    /// Its roughness: black is 0, white 1.
    Roughness,
    /// How metallic it is: black is 0, white 1.
    Metallic,
    /// What it emits, shown as the picture is.
    Emission,
}

impl Channel {
    /// All of them, in the order of `display.wgsl`.
    pub const ALL: [Self; 11] = [
        Self::Radiance,
        Self::Samples,
        Self::Error,
        Self::Normal,
        Self::Distance,
        Self::Material,
        Self::Object,
        Self::BaseColor,
        Self::Roughness,
        Self::Metallic,
        Self::Emission,
    ];

    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radiance => "Picture",
            Self::Samples => "Samples",
            Self::Error => "Error",
            Self::Normal => "Normal",
            Self::Distance => "Distance",
            Self::Material => "Material",
            Self::Object => "Object",
            Self::BaseColor => "Base colour",
            Self::Roughness => "Roughness",
            Self::Metallic => "Metallic",
            Self::Emission => "Emission",
        }
    }

    /// Whether it needs [`crate::renderer::Renderer::trace_guides`].
    pub fn needs_guides(self) -> bool {
        !matches!(self, Self::Radiance | Self::Samples | Self::Error)
    }
}

/// How a film is shown.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DisplaySettings {
    /// Exposure, white balance, and the way to what a screen can show.
    pub view: View,
    /// What is shown.
    pub channel: Channel,
    /// Distance that is shown half bright, metres.
    pub distance_scale: f32,
    /// Samples that are shown as the hottest.
    pub most_samples: u32,
    /// The material of the scene that has a line around it, where the film has guides.
    pub outlined: Option<u32>,
}

impl DisplaySettings {
    /// Whether the film needs [`crate::renderer::Renderer::trace_guides`].
    pub fn needs_guides(&self) -> bool {
        self.channel.needs_guides() || self.outlined.is_some()
    }
}

/// The sums of a picture on the device.
#[derive(Debug, Clone)]
pub struct DeviceFilm {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    pub(crate) planes: [Buffer; film::PICTURE_PLANES.len()],
    pub(crate) guides: Option<Buffer>,
    /// Of lights that it keeps apart.
    pub(crate) groups: Vec<GroupPlanes>,
}

impl DeviceFilm {
    /// Whether it keeps groups of lights apart, so that they can be mixed.
    pub fn has_groups(&self) -> bool {
        !self.groups.is_empty()
    }

    /// The same without its groups of lights.
    #[must_use]
    pub fn picture(&self) -> Self {
        Self {
            groups: Vec::new(),
            ..self.clone()
        }
    }

    /// The same sums with the guides of another film of this size.
    #[must_use]
    pub fn with_guides_of(&self, other: &Self) -> Self {
        Self {
            guides: other.guides.clone(),
            ..self.clone()
        }
    }

    /// A copy that later samples don't change.
    ///
    /// # Errors
    /// The device has no room for it.
    pub fn copy(&self, device: &Device) -> Result<Self, DeviceError> {
        let label = "a copy of the film";
        let mut recording = Recording::new(label);
        let mut copy = |buffer: &Buffer| {
            let copy = device.buffer(label, Usage::Storage, buffer.size())?;
            recording.copy(buffer, &copy);
            Ok(copy)
        };
        let planes: Vec<_> = self
            .planes
            .iter()
            .map(&mut copy)
            .collect::<Result<_, DeviceError>>()?;
        let guides = self.guides.as_ref().map(&mut copy).transpose()?;
        let groups = self.groups.iter().map(|group| {
            let [red, green, blue] = &group.planes;
            Ok(GroupPlanes {
                planes: [copy(red)?, copy(green)?, copy(blue)?],
                ..*group
            })
        });
        let groups = groups.collect::<Result<_, DeviceError>>()?;
        device.start(&recording)?;
        let planes = planes.try_into().expect("as many as there were");
        Ok(Self {
            planes,
            guides,
            groups,
            ..*self
        })
    }
}

/// `Display` in `display.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuDisplay {
    width: u32,
    height: u32,
    channel: u32,
    view: u32,
    gain: f32,
    distance_scale: f32,
    most_samples: f32,
    is_balanced: u32,
    outlined: u32,
    unused0: u32,
    unused1: u32,
    unused2: u32,
    balance_red: [f32; 4],
    balance_green: [f32; 4],
    balance_blue: [f32; 4],
}

impl GpuDisplay {
    /// Byte offset of each member, for comparison with its WGSL twin.
    pub fn offsets() -> Vec<(&'static str, usize)> {
        macro_rules! offsets {
            ($($member:ident),* $(,)?) => { vec![$((stringify!($member), std::mem::offset_of!(Self, $member))),*] };
        }
        offsets![
            width,
            height,
            channel,
            view,
            gain,
            distance_scale,
            most_samples,
            is_balanced,
            outlined,
            unused0,
            unused1,
            unused2,
            balance_red,
            balance_green,
            balance_blue,
        ]
    }
}

/// Shows films of one device in a texture.
#[derive(Debug)]
pub struct Display {
    device: Device,
    kernel: Kernel,
    /// [`GpuDisplay`] and the numbers of this transform.
    parameters: Buffer,
    transform: ViewTransform,
    /// In place of guides that aren't there.
    nothing: Buffer,
    target: Option<Target>,
}

#[derive(Debug)]
struct Target {
    size: [u32; 2],
    image: Image,
    error_sums: Buffer,
}

impl Display {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(device: &Device) -> Result<Self, DeviceError> {
        let transform = ViewTransform::default();
        Ok(Self {
            device: device.clone(),
            kernel: passes::display::kernel(device)?,
            parameters: parameters(device, transform)?,
            transform,
            nothing: device.filled_buffer("no guides", Usage::Storage, &[])?,
            target: None,
        })
    }

    /// Shows a film. The image has the film's size, 8 bits per channel, sRGB-encoded in a linear format; it stays the same
    /// one while the size does. Where guides are asked for and missing, the picture is shown.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn show(
        &mut self,
        film: &DeviceFilm,
        settings: &DisplaySettings,
    ) -> Result<&Image, DeviceError> {
        let size = [film.width, film.height];
        let former = self.target.take().filter(|target| target.size == size);
        let target = match former {
            Some(target) => target,
            None => Target::new(&self.device, size)?,
        };
        let target = self.target.insert(target);
        let channel = match settings.channel.needs_guides() && film.guides.is_none() {
            true => Channel::Radiance,
            false => settings.channel,
        };
        let outlined = settings.outlined.filter(|_| film.guides.is_some());
        let transform = settings.view.transform;
        if transform != self.transform {
            self.parameters = parameters(&self.device, transform)?;
            self.transform = transform;
        }
        let encoder = ViewEncoder::new(&settings.view);
        let balance = encoder.balance().unwrap_or_default();
        let row = |i: usize| balance.row(i).extend(0.0).to_array();
        let parameters = GpuDisplay {
            width: film.width,
            height: film.height,
            channel: channel as u32,
            view: transform as u32,
            gain: encoder.gain(),
            distance_scale: settings.distance_scale.max(1e-6),
            most_samples: settings.most_samples as f32,
            is_balanced: u32::from(encoder.balance().is_some()),
            outlined: outlined.unwrap_or(u32::MAX),
            unused0: 0,
            unused1: 0,
            unused2: 0,
            balance_red: row(0),
            balance_green: row(1),
            balance_blue: row(2),
        };
        self.device
            .write(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        let mut resources = Resources::default();
        resources.set_buffer("display", self.parameters.clone());
        for (name, plane) in film::PICTURE_PLANES.into_iter().zip(&film.planes) {
            resources.set_buffer(name, plane.clone());
        }
        let guides = film.guides.as_ref().unwrap_or(&self.nothing);
        resources.set_buffer("guides", guides.clone());
        resources.set_buffer("error_sums", target.error_sums.clone());
        resources.set_image("picture", target.image.clone());
        let bound = self.kernel.bind(&self.device, &resources);
        let mut recording = Recording::new("display");
        recording.dispatch(&bound, Extent::Threads(film.width * film.height));
        self.device.start(&recording)?;
        Ok(&target.image)
    }

    /// The error of the film that was shown last: the sum of all pixels' standard errors over that of their luminances. `None`
    /// before the second sample. Waits for the device.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn relative_error(&self) -> Result<Option<f64>, DeviceError> {
        let Some(target) = &self.target else {
            return Ok(None);
        };
        let buffer = &target.error_sums;
        let bytes = self.device.read(buffer, 0, buffer.size())?;
        let sums = bytemuck::pod_collect_to_vec::<_, [f32; 4]>(&bytes);
        let total = |i: usize| sums.iter().map(|sum| f64::from(sum[i])).sum::<f64>();
        Ok((total(2) > 0.0).then(|| total(0) / total(1).max(1e-12)))
    }

    /// What is shown, as 8-bit RGBA, row 0 on top. Empty before the first film.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn read(&self) -> Result<Vec<u8>, DeviceError> {
        match &self.target {
            Some(target) => target.image.read(&self.device),
            None => Ok(Vec::new()),
        }
    }
}

/// A buffer with the numbers of a transform, and room for what is written for each picture.
fn parameters(device: &Device, transform: ViewTransform) -> Result<Buffer, DeviceError> {
    let numbers = device_numbers(transform);
    let head = size_of::<GpuDisplay>() as u64;
    // An array in a buffer has one element at least.
    let bytes = size_of_val(&*numbers).max(4) as u64;
    let buffer = device.buffer("display", Usage::Storage, head + bytes)?;
    if !numbers.is_empty() {
        device.write(&buffer, head, bytemuck::cast_slice(&numbers));
    }
    Ok(buffer)
}

impl Target {
    fn new(device: &Device, size: [u32; 2]) -> Result<Self, DeviceError> {
        let [width, height] = size;
        // As many workgroups as `Extent::Threads` makes, those that fill its last row included.
        let groups = (width * height).div_ceil(64);
        let groups = groups.min(32768) * groups.div_ceil(32768);
        let size_in_layers = [width, height, 1];
        let shown = ImageUse::Shown;
        let image = device.image("what is shown", shown, size_in_layers, Format::Rgba8Unorm)?;
        let bytes = u64::from(groups) * 16;
        Ok(Self {
            size,
            image,
            error_sums: device.buffer("error sums", Usage::Storage, bytes)?,
        })
    }
}
