//! What a schedule may want to know of a device.

/// How a device likes its work. Schedules decide by these, never by what kind of device it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Traits {
    /// Threads of a dispatch.
    pub waves: WaveSizes,
    /// Recordings that it plays side by side, each on a thread of its own ([`Device::side_by_side`](crate::Device::side_by_side));
    /// 0: it takes one at a time and spreads each dispatch over all that it has.
    pub lanes: u32,
    /// The threads of a workgroup run one after the other: what several of them have in common each works out again.
    pub runs_threads_in_turn: bool,
    /// Functions of kernels may be the program's own: see [`HostFunction`](crate::HostFunction).
    pub calls_functions: bool,
    /// A kernel is compiled when it runs for the first time, in seconds rather than moments.
    pub compiles_slowly: bool,
    /// It works with the processor's cores, which a window and everything else need, too.
    pub shares_the_processor: bool,
}

/// Threads of a dispatch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WaveSizes {
    /// Where nobody knows yet how fast the device is.
    pub first: u32,
    /// More gain nothing.
    pub most: u32,
}

/// What fits a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Texels of an image's longer side.
    pub image_side: u32,
    /// Layers of an image.
    pub image_layers: u32,
    /// Storage buffers of a kernel.
    pub storage_buffers: u32,
}
