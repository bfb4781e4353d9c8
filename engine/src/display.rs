//! What a window shows of a film: written to a texture on the device that rendered it, nothing is read back.

use bytemuck::{Pod, Zeroable};

use crate::film;
use crate::gpu::{
    Gpu, GpuError,
    kernel::{Extent, Kernel, Resources},
};
use crate::passes;

/// How radiance becomes what a screen can show.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ViewTransform {
    /// sRGB as it is; what is brighter than white is clipped. As PNG files are written.
    #[default]
    Standard,
    /// Khronos PBR Neutral: base colours keep their look, highlights are compressed.
    Neutral,
    /// A curve like that of film: more contrast, soft highlights.
    Filmic,
}

impl ViewTransform {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Standard, Self::Neutral, Self::Filmic];

    /// Its name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Standard => "Standard",
            Self::Neutral => "Neutral",
            Self::Filmic => "Filmic",
        }
    }
}

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
    /// Stops: +1 is twice as bright.
    pub exposure: f32,
    /// To what a screen can show.
    pub view: ViewTransform,
    /// What is shown.
    pub channel: Channel,
    /// Distance that is shown half bright, metres.
    pub distance_scale: f32,
    /// Samples that are shown as the hottest.
    pub most_samples: u32,
}

/// A film on the device.
#[derive(Debug, Clone)]
pub struct DeviceFilm {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    pub(crate) planes: [wgpu::Buffer; film::PLANES.len()],
    pub(crate) guides: Option<wgpu::Buffer>,
}

impl DeviceFilm {
    /// A copy that later samples don't change.
    ///
    /// # Errors
    /// The device has no room for it.
    pub fn copy(&self, gpu: &Gpu) -> Result<Self, GpuError> {
        let descriptor = wgpu::CommandEncoderDescriptor {
            label: Some("a copy of the film"),
        };
        let mut encoder = gpu.device().create_command_encoder(&descriptor);
        let mut copy = |buffer: &wgpu::Buffer| {
            let usage = wgpu::BufferUsages::STORAGE;
            let copy = gpu.empty_buffer("a copy of the film", buffer.size(), usage)?;
            encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
            Ok(copy)
        };
        let planes: Vec<_> = self
            .planes
            .iter()
            .map(&mut copy)
            .collect::<Result<_, GpuError>>()?;
        let guides = self.guides.as_ref().map(&mut copy).transpose()?;
        gpu.queue().submit([encoder.finish()]);
        let planes = planes.try_into().expect("as many as there were");
        Ok(Self {
            planes,
            guides,
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
    spare: u32,
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
            spare
        ]
    }
}

/// Shows films of one device in a texture.
#[derive(Debug)]
pub struct Display {
    gpu: Gpu,
    kernel: Kernel,
    parameters: wgpu::Buffer,
    /// In place of guides that aren't there.
    nothing: wgpu::Buffer,
    target: Option<Target>,
}

#[derive(Debug)]
struct Target {
    size: [u32; 2],
    texture: wgpu::Texture,
    error_sums: wgpu::Buffer,
}

impl Display {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let bytes = size_of::<GpuDisplay>() as u64;
        Ok(Self {
            gpu: gpu.clone(),
            kernel: passes::display::kernel(gpu)?,
            parameters: gpu.empty_buffer("display", bytes, wgpu::BufferUsages::STORAGE)?,
            nothing: gpu.storage_buffer("no guides", &[])?,
            target: None,
        })
    }

    /// Shows a film. The texture has the film's size, 8 bits per channel, sRGB-encoded in a linear format; it stays the same
    /// one while the size does. Where guides are asked for and missing, the picture is shown.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn show(
        &mut self,
        film: &DeviceFilm,
        settings: &DisplaySettings,
    ) -> Result<&wgpu::Texture, GpuError> {
        let size = [film.width, film.height];
        let former = self.target.take().filter(|target| target.size == size);
        let target = match former {
            Some(target) => target,
            None => Target::new(&self.gpu, size)?,
        };
        let target = self.target.insert(target);
        let channel = match settings.channel.needs_guides() && film.guides.is_none() {
            true => Channel::Radiance,
            false => settings.channel,
        };
        let parameters = GpuDisplay {
            width: film.width,
            height: film.height,
            channel: channel as u32,
            view: settings.view as u32,
            gain: settings.exposure.exp2(),
            distance_scale: settings.distance_scale.max(1e-6),
            most_samples: settings.most_samples as f32,
            spare: 0,
        };
        (self.gpu.queue()).write_buffer(&self.parameters, 0, bytemuck::bytes_of(&parameters));
        let mut resources = Resources::default();
        resources.set_buffer("display", self.parameters.clone());
        for (name, plane) in film::PLANES.into_iter().zip(&film.planes) {
            resources.set_buffer(name, plane.clone());
        }
        let guides = film.guides.as_ref().unwrap_or(&self.nothing);
        resources.set_buffer("guides", guides.clone());
        resources.set_buffer("error_sums", target.error_sums.clone());
        let view = target
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        resources.set_view("picture", view);
        let bound = self.kernel.bind(&self.gpu, &resources);
        let descriptor = wgpu::CommandEncoderDescriptor {
            label: Some("display"),
        };
        let mut encoder = self.gpu.device().create_command_encoder(&descriptor);
        bound.record(
            &mut encoder,
            Extent::Threads(film.width * film.height),
            None,
        );
        self.gpu.queue().submit([encoder.finish()]);
        Ok(&target.texture)
    }

    /// The error of the film that was shown last: the sum of all pixels' standard errors over that of their luminances. `None`
    /// before the second sample. Waits for the device.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn relative_error(&self) -> Result<Option<f64>, GpuError> {
        let Some(target) = &self.target else {
            return Ok(None);
        };
        let buffer = &target.error_sums;
        let bytes = self.gpu.read_buffer(buffer, 0, buffer.size())?;
        let sums = bytemuck::pod_collect_to_vec::<_, [f32; 4]>(&bytes);
        let total = |i: usize| sums.iter().map(|sum| f64::from(sum[i])).sum::<f64>();
        Ok((total(2) > 0.0).then(|| total(0) / total(1).max(1e-12)))
    }

    /// What is shown, as 8-bit RGBA, row 0 on top. Empty before the first film.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn read(&self) -> Result<Vec<u8>, GpuError> {
        let Some(Target { size, texture, .. }) = &self.target else {
            return Ok(Vec::new());
        };
        let [width, height] = *size;
        // Rows of a copy begin at multiples of this.
        let stride = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(stride) * u64::from(height);
        let buffer = self
            .gpu
            .empty_buffer("what is shown", bytes, wgpu::BufferUsages::STORAGE)?;
        let descriptor = wgpu::CommandEncoderDescriptor {
            label: Some("what is shown"),
        };
        let mut encoder = self.gpu.device().create_command_encoder(&descriptor);
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride),
                    rows_per_image: None,
                },
            },
            texture.size(),
        );
        self.gpu.queue().submit([encoder.finish()]);
        let padded = self.gpu.read_buffer(&buffer, 0, bytes)?;
        let rows = padded.chunks(stride as usize);
        Ok(rows
            .flat_map(|row| &row[..width as usize * 4])
            .copied()
            .collect())
    }
}

impl Target {
    fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let [width, height] = size;
        // As many workgroups as `Extent::Threads` makes, those that fill its last row included.
        let groups = (width * height).div_ceil(64);
        let groups = groups.min(32768) * groups.div_ceil(32768);
        let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
            label: Some("what is shown"),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let bytes = u64::from(groups) * 16;
        Ok(Self {
            size,
            texture,
            error_sums: gpu.empty_buffer("error sums", bytes, wgpu::BufferUsages::STORAGE)?,
        })
    }
}
