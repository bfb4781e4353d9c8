//! What somebody who watches a render wants of it: another size, a part of the picture, short waves, and what the
//! camera sees first.

use std::time::Duration;

use device::{Buffer, Device, DeviceError, Kernel, Resources, Usage};

use crate::{
    display::{DeviceFilm, GroupPlanes},
    film::{Crop, Layers, MAX_SIDE, PICTURE_PLANES},
    frame::Frame,
    gpu_scene::SceneFeatures,
    passes::guide,
    schedule::{self, ScheduleError},
};

use super::lanes::begin_wave;
use super::{Burst, RenderError, RenderSettings, Renderer};

/// The guides of a picture: see `guide.wgsl`.
#[derive(Debug)]
pub(super) struct Guides {
    kernel: Kernel,
    /// What the kernel was made for.
    features: SceneFeatures,
    /// Made for a size; `None` where they show another view, another look or another scene.
    buffer: Option<Buffer>,
}

/// Makes the film's buffers.
pub(super) fn allocate_film(
    device: &Device,
    width: u32,
    height: u32,
    layers: &Layers,
    resources: &mut Resources,
) -> Result<(), DeviceError> {
    let bytes = u64::from(width) * u64::from(height) * 16;
    let names = layers.buffers();
    let planes: Vec<_> = names
        .iter()
        .map(|_| device.buffer("the picture", Usage::Storage, bytes))
        .collect::<Result<_, _>>()?;
    for (name, plane) in names.into_iter().zip(planes) {
        resources.set_buffer(name, plane);
    }
    Ok(())
}

impl Renderer {
    /// Renders a picture of another size from now on, from the first sample. Nothing is compiled.
    ///
    /// # Errors
    /// A size that can't be rendered or does not fit; nothing has changed then.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), RenderError> {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(RenderError::Size { width, height });
        }
        let layers = &self.settings.layers;
        allocate_film(&self.device, width, height, layers, &mut self.resources)?;
        (self.settings.width, self.settings.height) = (width, height);
        self.settings.crop = None;
        self.film_pixels = 0;
        self.bind();
        self.region = None;
        self.frame = self.fresh_frame();
        self.restart();
        Ok(())
    }

    /// Renders another part of the picture, or another picture, from now on, from the first sample. Nothing is compiled, and no memory
    /// is taken where the film is no larger than one before. What is known of the light is forgotten, unless that is of
    /// [the whole](Self::learn_of_whole).
    ///
    /// # Errors
    /// A size that can't be rendered or does not fit, a part beyond the picture; nothing has changed then.
    pub fn set_part(
        &mut self,
        [width, height]: [u32; 2],
        crop: Option<Crop>,
    ) -> Result<(), RenderError> {
        let settings = RenderSettings {
            width,
            height,
            crop,
            ..self.settings.clone()
        };
        super::check_size(&settings)?;
        let pixels =
            |settings: &RenderSettings| u64::from(settings.width) * u64::from(settings.height);
        self.film_pixels = self.film_pixels.max(pixels(&self.settings));
        if pixels(&settings) > self.film_pixels {
            let layers = &settings.layers;
            allocate_film(&self.device, width, height, layers, &mut self.resources)?;
            self.bind();
            self.film_pixels = pixels(&settings);
        }
        self.settings = settings;
        self.region = None;
        self.renew_frame();
        if self.knows_whole() {
            self.begin_anew();
        } else {
            self.restart();
        }
        Ok(())
    }

    /// Forgets all samples: the next wave starts the picture anew. What was written before is submitted.
    pub fn restart(&mut self) {
        self.whole = None;
        self.forget_light();
        self.begin_anew();
    }

    /// Forgets all samples, but not what is known of the light.
    pub(super) fn begin_anew(&mut self) {
        self.restarts += 1;
        // The film is cleared when it is needed next: an edit doesn't wait for that, nor do hundreds of them clear it
        // hundreds of times.
        self.is_stale = true;
        self.forget_guides();
        self.survey = None;
        self.position = 0;
        self.burst = Burst::default();
        self.rendered = 0;
        self.device.flush();
    }

    /// How often the picture has begun anew since the renderer was made.
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// From now on only these pixels get samples: first column and row, then those behind the last. What the others have
    /// stays.
    pub fn set_region(&mut self, region: Option<[u32; 4]>) {
        if region != self.region {
            self.region = region;
            self.renew_frame();
        }
    }

    /// Waves are kept shorter than this from now on, so that edits, and other users of the device, needn't wait for longer.
    pub fn set_longest_wave(&mut self, longest: Duration) {
        self.longest_wave = longest;
    }

    /// Waves have at least so many paths from now on, however long they take, so that a picture that is waited for comes after
    /// a few of them.
    pub fn set_smallest_wave(&mut self, paths: u32) {
        self.smallest_wave = paths;
    }

    /// Tells kernels anew what the picture is of. What is known of the light stays.
    pub(super) fn renew_frame(&mut self) {
        let knows_sky = self.frame.knows_sky();
        self.frame = self.fresh_frame();
        self.frame.set_known_sky(knows_sky);
    }

    pub(super) fn fresh_frame(&self) -> Frame {
        let mut frame = Frame::new(&self.settings, self.capacity, &self.scene);
        if let Some([left, top, right, bottom]) = self.region {
            let (width, height) = (self.settings.width, self.settings.height);
            frame.region_min = left.min(width) | top.min(height) << 16;
            frame.region_max = right.min(width) | bottom.min(height) << 16;
        }
        frame
    }

    /// The film on the device, with the groups of lights that it keeps apart, and with the guides if they have been traced for it.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn device_film(&mut self) -> Result<DeviceFilm, RenderError> {
        self.clear_stale_film()?;
        Ok(DeviceFilm {
            width: self.settings.width,
            height: self.settings.height,
            planes: PICTURE_PLANES.map(|name| self.resources.buffer(name).clone()),
            guides: self.guides.as_ref().and_then(|g| g.buffer.clone()),
            groups: self.light_groups(),
        })
    }

    fn light_groups(&self) -> Vec<GroupPlanes> {
        let sums = self.settings.layers.sums().into_iter();
        let of_group = sums.filter_map(|sum| {
            let plane = |&name: &&'static str| self.resources.buffer(name).clone();
            let planes: Vec<_> = sum.planes.iter().map(plane).collect();
            Some(GroupPlanes {
                number: sum.layer.light_group()?,
                planes: planes.try_into().ok()?,
            })
        });
        of_group.collect()
    }

    /// Traces what the camera's rays hit first, pinhole-sharp, unless that is known, and runs its textures. The film stays as it
    /// is. The first time, a kernel is compiled.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn trace_guides(&mut self) -> Result<(), RenderError> {
        if !self.schedule.goes_in_rounds() {
            let reason = "a schedule without rounds keeps no first hits that could be looked at";
            return Err(ScheduleError::Unsupported(reason).into());
        }
        let features = self.scene.features;
        let former = self.guides.take();
        let guides = match former.filter(|guides| guides.features == features) {
            Some(guides) => guides,
            None => Guides {
                kernel: guide::PASS.kernel(&self.device, &features)?,
                features,
                buffer: None,
            },
        };
        if guides.buffer.is_some() {
            self.guides = Some(guides);
            return Ok(());
        }
        let pixels = u64::from(self.settings.width) * u64::from(self.settings.height);
        let buffer = self.device.buffer("guides", Usage::Storage, pixels * 32)?;
        let mut resources = self.resources.clone();
        resources.set_buffer("guides", buffer.clone());
        let kernel = guides.kernel.bind(&self.device, &resources);
        let mut frame = Frame::new(&self.settings, self.capacity, &self.scene);
        frame.set_pinhole();
        frame.sample_limit = 1;
        for first in (0..frame.padded_pixels).step_by(self.capacity as usize) {
            frame.first_pixel = first;
            frame.wave_size = self.capacity.min(frame.padded_pixels - first);
            begin_wave(&self.device, &self.resources, &frame);
            self.submit(frame.wave_size, |wave| {
                schedule::start(wave);
                schedule::find_hits(wave);
                wave.run_kernel(&kernel, guide::PASS.work);
            })?;
        }
        self.guides = Some(Guides {
            buffer: Some(buffer),
            ..guides
        });
        Ok(())
    }

    pub(super) fn forget_guides(&mut self) {
        if let Some(guides) = &mut self.guides {
            guides.buffer = None;
        }
    }
}
