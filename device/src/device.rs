//! An open device.

use std::path::{Path, PathBuf};

use crate::{
    Activity, Buffer, DeviceChoice, DeviceDescription, DeviceError, Format, Image, ImageUse,
    Limits, Recording, Timer, Traits, Usage,
    buffer::Memory,
    gpu::Gpu,
    image::Texels,
    native::{self, Processor},
};

/// The number of the processor itself, which comes behind all GPUs and before the drivers that use it.
fn own_number(drivers: &[DeviceDescription]) -> usize {
    drivers.iter().filter(|device| !device.is_processor).count()
}

/// Whether a name, or a part of one, means the processor itself: a device that comes before it in the list and has the part in its name is
/// meant first.
fn is_own(name: &str, all: impl FnOnce() -> Vec<DeviceDescription>) -> bool {
    let is_part = || native::NAME.contains(&name.to_lowercase());
    let is_first = || {
        let choice = DeviceChoice::Name(name.to_owned());
        let first = all().into_iter().find(|device| choice.admits(device));
        first.is_some_and(|device| device.name == native::NAME)
    };
    name.eq_ignore_ascii_case(native::NAME) || is_part() && is_first()
}

/// Which device to open, and how.
#[derive(Debug, Clone, Default)]
pub struct DeviceOptions {
    /// Which.
    pub choice: DeviceChoice,
    /// Compiled kernels are read from a file in this folder, where the device offers that and a file is there;
    /// [`Device::save_cache`] writes it.
    pub cache: Option<PathBuf>,
    /// With ray queries where the device has them: see [`Device::has_ray_queries`]. wgpu calls them experimental, so that
    /// only comparisons with them ask for this.
    pub ray_queries: bool,
}

impl DeviceOptions {
    /// A device as renders use it.
    pub fn new(choice: &DeviceChoice) -> Self {
        Self {
            choice: choice.clone(),
            ..Self::default()
        }
    }

    /// With [`Self::cache`], if there is a folder.
    pub fn with_cache(mut self, folder: Option<&Path>) -> Self {
        self.cache = folder.map(Path::to_owned);
        self
    }

    /// With [`Self::ray_queries`].
    pub fn with_ray_queries(mut self) -> Self {
        self.ray_queries = true;
        self
    }
}

/// What has been made since a device was opened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Texts of kernels handed to it.
    pub shader_modules: u64,
    /// Kernels compiled.
    pub pipelines: u64,
    /// Those of them that were compiled once more, to run several invocations at once.
    pub in_lanes: u64,
}

/// An open device. Clones share it.
#[derive(Debug, Clone)]
pub struct Device {
    pub(crate) kind: Kind,
}

#[derive(Debug, Clone)]
pub(crate) enum Kind {
    Gpu(Gpu),
    Native(Processor),
}

impl Device {
    /// All devices of the machine, the usual choice first.
    pub fn all() -> Vec<DeviceDescription> {
        let mut all = Gpu::all();
        let own = native::describe(own_number(&all));
        all.insert(own.index, own);
        all
    }

    /// Those that render one image together where nothing else is said, as [`Self::all`] lists them: every GPU, and the
    /// processor without a driver. Drivers in software are left out, for they would do with the same cores what these do without;
    /// and of a GPU that several interfaces offer, all but the first.
    pub fn together() -> Vec<DeviceDescription> {
        let mut chosen: Vec<DeviceDescription> = Vec::new();
        for device in Self::all() {
            let is_own = device.name == native::NAME;
            let is_known = |other: &DeviceDescription| {
                other.name == device.name && other.backend != device.backend
            };
            let is_left_out = device.is_processor && !is_own;
            if device.usable.is_ok() && !is_left_out && !chosen.iter().any(is_known) {
                chosen.push(device);
            }
        }
        chosen
    }

    /// Opens a device with everything that it offers.
    ///
    /// # Errors
    /// If there is none, none that fits the choice and what kernels need, or the driver refuses.
    pub fn open(choice: &DeviceChoice) -> Result<Self, DeviceError> {
        Self::open_with(&DeviceOptions::new(choice))
    }

    /// As [`Self::open`].
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_with(options: &DeviceOptions) -> Result<Self, DeviceError> {
        let has_gpu = || {
            let is_gpu = |device: &DeviceDescription| !device.is_processor && device.usable.is_ok();
            Gpu::all().iter().any(is_gpu)
        };
        let mut threads = None;
        // Drivers are asked only where the answer depends on them.
        let is_meant = match &options.choice {
            DeviceChoice::Native(count) => {
                threads = Some(*count);
                true
            }
            DeviceChoice::Best => !options.ray_queries && !has_gpu(),
            DeviceChoice::Driver => false,
            DeviceChoice::Index(index) => *index == own_number(&Gpu::all()),
            DeviceChoice::Name(name) => is_own(name, Self::all),
        };
        Ok(Self {
            kind: match is_meant {
                true => Kind::Native(Processor::open(threads)?),
                false => Kind::Gpu(Gpu::open(options)?),
            },
        })
    }

    /// The best device.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn best() -> Result<Self, DeviceError> {
        Self::open(&DeviceChoice::Best)
    }

    /// The driver's side of it, for a window that shows what the device makes. None where the processor renders.
    pub fn gpu(&self) -> Option<&Gpu> {
        match &self.kind {
            Kind::Gpu(gpu) => Some(gpu),
            Kind::Native(_) => None,
        }
    }

    /// What was opened.
    pub fn description(&self) -> &DeviceDescription {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.description(),
            Kind::Native(processor) => processor.description(|| own_number(&Gpu::all())),
        }
    }

    /// How it likes its work.
    pub fn traits(&self) -> Traits {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.traits(),
            Kind::Native(processor) => processor.traits(),
        }
    }

    /// What fits it.
    pub fn limits(&self) -> Limits {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.limits(),
            Kind::Native(processor) => processor.limits(),
        }
    }

    /// Whether kernels can trace rays in acceleration structures of the driver's, because that was asked for and is there.
    pub fn has_ray_queries(&self) -> bool {
        self.gpu().is_some_and(Gpu::has_ray_queries)
    }

    /// What has been made on it so far.
    pub fn counts(&self) -> Counts {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.counts(),
            Kind::Native(processor) => processor.counts(),
        }
    }

    /// Waits for faster code that is being made of kernels while they run already. Only whoever measures needs to.
    pub fn finish_compiling(&self) {
        if let Kind::Native(processor) = &self.kind {
            processor.finish_compiling();
        }
    }

    /// What the device is busy with that may take long.
    pub fn activity(&self) -> &Activity {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.activity(),
            Kind::Native(processor) => processor.activity(),
        }
    }

    /// Whether compiled kernels are kept in a file.
    pub fn has_cache(&self) -> bool {
        self.gpu().is_some_and(Gpu::has_cache)
    }

    /// Writes the kernels compiled so far to the cache's file; nothing where there is no cache.
    ///
    /// # Errors
    /// The file can't be written. Nothing depends on it but the time of the next start.
    pub fn save_cache(&self) -> std::io::Result<()> {
        self.gpu().map_or(Ok(()), Gpu::save_cache)
    }

    /// The first error that the driver has reported since the last call.
    ///
    /// # Errors
    /// That error.
    pub fn check(&self) -> Result<(), DeviceError> {
        self.gpu().map_or(Ok(()), Gpu::check)
    }

    /// Waits until the device has done all that it was given.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn wait(&self) -> Result<(), DeviceError> {
        self.gpu().map_or(Ok(()), Gpu::wait)
    }

    /// Whether the device is gone.
    pub fn is_lost(&self) -> bool {
        self.gpu().is_some_and(Gpu::is_lost)
    }

    /// A zeroed buffer of at least 16 bytes.
    ///
    /// # Errors
    /// If it is larger than one binding of this device.
    pub fn buffer(&self, label: &str, usage: Usage, bytes: u64) -> Result<Buffer, DeviceError> {
        let size = bytes.next_multiple_of(16).max(16);
        let limit = match &self.kind {
            Kind::Gpu(gpu) => {
                let description = gpu.description();
                description.max_storage_binding.min(description.max_buffer)
            }
            Kind::Native(_) => native::MAX_BUFFER,
        };
        if size > limit {
            return Err(DeviceError::TooLarge {
                what: label.to_owned(),
                needed: size,
                limit,
                remedy: "use a smaller scene or picture, or a device with larger limits (see `patina devices`)",
            });
        }
        let memory = match &self.kind {
            Kind::Gpu(gpu) => Memory::Gpu(gpu.buffer(label, usage, size)),
            Kind::Native(processor) => Memory::Native(processor.buffer(label, size)?),
        };
        Ok(Buffer { size, memory })
    }

    /// A buffer that begins with these bytes; bindings can't be empty, so there is a spare word where there are none.
    ///
    /// # Errors
    /// As [`Self::buffer`].
    pub fn filled_buffer(
        &self,
        label: &str,
        usage: Usage,
        contents: &[u8],
    ) -> Result<Buffer, DeviceError> {
        let buffer = self.buffer(label, usage, contents.len() as u64)?;
        if !contents.is_empty() {
            self.write(&buffer, 0, contents);
        }
        Ok(buffer)
    }

    /// An image.
    ///
    /// # Errors
    /// The device is out of memory.
    pub fn image(
        &self,
        label: &str,
        usage: ImageUse,
        size: [u32; 3],
        format: Format,
    ) -> Result<Image, DeviceError> {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.image(label, usage, size, format),
            Kind::Native(processor) => Ok(Image {
                size,
                format,
                texels: Texels::Native(processor.image(label, size, format)?),
            }),
        }
    }

    /// Writes to a buffer, before whatever is played next. The offset and the number of bytes are multiples of four.
    pub fn write(&self, buffer: &Buffer, offset: u64, bytes: &[u8]) {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.write(buffer.gpu(), offset, bytes),
            Kind::Native(_) => buffer.native().write(offset, bytes),
        }
    }

    /// Hands over what was written, so that the device begins with it.
    pub fn flush(&self) {
        if let Kind::Gpu(gpu) = &self.kind {
            gpu.flush();
        }
    }

    /// A range of a buffer. Waits for the device.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn read(&self, buffer: &Buffer, offset: u64, bytes: u64) -> Result<Vec<u8>, DeviceError> {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.read(buffer.gpu(), offset, bytes),
            Kind::Native(_) => {
                let words = buffer
                    .native()
                    .read::<u32>(offset, bytes.div_ceil(4) as usize);
                let read: &[u8] = bytemuck::cast_slice(&words);
                Ok(read[..bytes as usize].to_vec())
            }
        }
    }

    /// Hands a recording to the device, which plays it behind all that it was given before. Doesn't wait.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn start(&self, recording: &Recording) -> Result<(), DeviceError> {
        match &self.kind {
            Kind::Gpu(gpu) => drop(gpu.play(recording, None)),
            Kind::Native(processor) => processor.play(recording, None),
        }
        Ok(())
    }

    /// Plays a recording, and waits until that is done; what others gave the device behind it isn't waited for.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn play(&self, recording: &Recording) -> Result<(), DeviceError> {
        match &self.kind {
            Kind::Gpu(gpu) => gpu.wait_for(gpu.play(recording, None)),
            Kind::Native(processor) => {
                processor.play(recording, None);
                Ok(())
            }
        }
    }

    /// As [`Self::play_timed`], each command by itself: some drivers compile a kernel when it runs for the first time, and so it
    /// is known which one takes long. `say` tells what is under way while a kernel with this label runs.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn play_apart(
        &self,
        recording: &Recording,
        timer: &mut Timer,
        say: impl Fn(&str) -> String,
    ) -> Result<(), DeviceError> {
        for alone in recording.apart() {
            let _busy = alone.kernels().next().map(|kernel| {
                let activity = self.activity();
                activity.begin(|| say(kernel.label()))
            });
            self.play_timed(&alone, timer)?;
        }
        Ok(())
    }

    /// As [`Self::play`]; each dispatch is counted, and timed where the timer does that.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn play_timed(&self, recording: &Recording, timer: &mut Timer) -> Result<(), DeviceError> {
        match &self.kind {
            Kind::Gpu(gpu) => {
                gpu.wait_for(gpu.play(recording, Some(timer)))?;
                timer.collect(self)
            }
            Kind::Native(processor) => {
                processor.play(recording, Some(timer));
                Ok(())
            }
        }
    }

    /// Does `work` for each of some items: at the same time as far as the device has threads for them, on those. What is played
    /// within, [`Self::play_alone`] plays.
    ///
    /// # Errors
    /// One of those that `work` gave, where it gave any; what hadn't begun then isn't done.
    pub fn side_by_side<T: Send, E: Send>(
        &self,
        items: &mut [T],
        work: impl Fn(&mut T) -> Result<(), E> + Send + Sync,
    ) -> Result<(), E> {
        match &self.kind {
            Kind::Gpu(_) => items.iter_mut().try_for_each(work),
            Kind::Native(processor) => processor.side_by_side(items, work),
        }
    }

    /// As [`Self::play_timed`], but a device that works on threads of the program does it all on this one.
    ///
    /// # Errors
    /// What the driver reported.
    pub fn play_alone(&self, recording: &Recording, timer: &mut Timer) -> Result<(), DeviceError> {
        match &self.kind {
            Kind::Gpu(_) => self.play_timed(recording, timer),
            Kind::Native(processor) => {
                processor.play_alone(recording, timer);
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_name_means_the_first_device_in_the_list_that_has_it() {
        let own = native::describe(1);
        let device = |name: &str| DeviceDescription {
            name: name.to_owned(),
            ..own.clone()
        };
        let all = || vec![device("Innovative GPU"), own.clone(), device("llvmpipe")];
        for (name, is_meant) in [
            ("native", true),
            ("Native", true),
            ("NAT", true),
            ("ive", false),
            ("e", false),
            ("llvm", false),
            ("natives", false),
        ] {
            assert_eq!(is_own(name, all), is_meant, "{name}");
        }
        let drivers = || vec![own.clone(), device("llvmpipe")];
        assert!(is_own("ve", drivers) && is_own("v", drivers));
        assert!(!is_own("vm", drivers));
    }
}
