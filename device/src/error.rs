//! What a device or its driver refused.

/// What a device or its driver refused.
#[derive(Debug, Clone, thiserror::Error)]
pub enum DeviceError {
    /// No adapter at all.
    #[error(
        "no graphics adapter was found; install a Vulkan driver (Debian/Ubuntu: `apt install mesa-vulkan-drivers libvulkan1`)"
    )]
    NoAdapter,
    /// The choice matches no usable device.
    #[error("no usable device matches `{wanted}`; there are:\n{available}")]
    NotFound {
        /// What was asked for.
        wanted: String,
        /// One device per line.
        available: String,
    },
    /// The driver would not open the device.
    #[error("the device `{name}` could not be opened: {reason}")]
    Open {
        /// Device.
        name: String,
        /// The driver's words.
        reason: String,
    },
    /// A kernel failed to build.
    #[error("kernel `{label}` failed to build:\n{message}")]
    Kernel {
        /// Kernel.
        label: String,
        /// Errors with file and line.
        message: String,
    },
    /// The driver refused a kernel that is valid WGSL.
    #[error("the graphics driver refused the kernel `{label}`:\n{message}")]
    Refused {
        /// Kernel.
        label: String,
        /// The driver's words, and what is known about the cause.
        message: String,
    },
    /// A buffer or image is larger than the device allows.
    #[error("{what} needs {needed} bytes, but this device binds at most {limit}; {remedy}")]
    TooLarge {
        /// What does not fit.
        what: String,
        /// Bytes.
        needed: u64,
        /// Bytes.
        limit: u64,
        /// What to do.
        remedy: &'static str,
    },
    /// Its memory is used up.
    #[error(
        "the graphics device has too little memory left; end what else uses it, or take a smaller picture or scene, or `--device native`"
    )]
    OutOfMemory,
    /// The processor's memory is used up.
    #[error(
        "the memory has no room left for {what}, {bytes} bytes; end what else uses it, or take a smaller picture, fewer layers, or `--memory`"
    )]
    NoRoom {
        /// What does not fit.
        what: String,
        /// Bytes.
        bytes: u64,
    },
    /// The device is gone, and all that was on it: open another one.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// An error that the driver reported while working.
    #[error("the graphics driver reported an error: {0}")]
    Driver(String),
}
