//! Which devices a machine has.

/// One device of the machine.
#[derive(Debug, Clone)]
pub struct DeviceDescription {
    /// Number to choose it by.
    pub index: usize,
    /// The driver's name for it.
    pub name: String,
    /// Vulkan, Metal or DX12, or `no driver`.
    pub backend: String,
    /// Driver and its version; of the processor itself, its threads and how wide its vectors are.
    pub driver: String,
    /// `discrete GPU`, `integrated GPU`, `virtual GPU`, `CPU` or `other`.
    pub device_type: String,
    /// The processor does the work, by a software driver or without any.
    pub is_processor: bool,
    /// Bytes of the largest storage binding.
    pub max_storage_binding: u64,
    /// Bytes of the largest buffer.
    pub max_buffer: u64,
    /// Storage buffers that one kernel can bind.
    pub storage_buffers_per_stage: u32,
    /// Threads of the largest workgroup.
    pub workgroup_invocations: u32,
    /// Whether passes can be timed on the device.
    pub timestamps: bool,
    /// Whether kernels can trace rays in acceleration structures of the driver's.
    pub ray_queries: bool,
    /// Why it can't be used, if it can't.
    pub usable: Result<(), String>,
}

impl DeviceDescription {
    /// Its name and what drives it, for people. Drivers don't tell everything.
    pub fn title(&self) -> String {
        let known = [&*self.backend, &*self.driver].into_iter();
        let known: Vec<&str> = known.filter(|part| !part.is_empty()).collect();
        format!("{} ({})", self.name, known.join(", "))
    }
}

/// Which device to open.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum DeviceChoice {
    /// Discrete before integrated before virtual; where there is no GPU, the processor without a driver.
    #[default]
    Best,
    /// The same among those that have a driver, which may be one in software: one of these draws a window.
    Driver,
    /// By [`DeviceDescription::index`].
    Index(usize),
    /// The best whose name contains this, letter case ignored.
    Name(String),
    /// The processor without a driver, with so many threads of its own.
    Native(u32),
}

impl DeviceChoice {
    /// Whether a device is meant by it, if it is the best of those that are.
    pub(crate) fn admits(&self, device: &DeviceDescription) -> bool {
        let is_meant = match self {
            Self::Best | Self::Driver => true,
            Self::Index(index) => device.index == *index,
            // No driver's.
            Self::Native(_) => false,
            Self::Name(name) => device.name.to_lowercase().contains(&name.to_lowercase()),
        };
        is_meant && device.usable.is_ok()
    }
}

impl std::fmt::Display for DeviceChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Best => f.write_str("any"),
            Self::Driver => f.write_str("any with a driver"),
            Self::Index(index) => write!(f, "{index}"),
            Self::Name(name) => f.write_str(name),
            Self::Native(threads) => write!(f, "native:{threads}"),
        }
    }
}
