//! What a driver says about a kernel that it has compiled: registers, stack, spills. For reports; nothing depends on it.
//!
//! Vulkan tells (`VK_KHR_pipeline_executable_properties`) if it is asked when the pipeline is created, which wgpu doesn't
//! do. So [`Inspector`] opens the device once more and compiles the kernel again, from the SPIR-V that wgpu would hand to
//! the driver. That needs the feature `driver-statistics`; without it, and where the driver tells nothing,
//! [`Inspector::open`] says so.

#[cfg(feature = "driver-statistics")]
mod vulkan;

use serde::Serialize;

use crate::{DeviceError, KernelText};

/// What a driver says about a kernel.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct KernelStatistics {
    /// Registers of a thread.
    pub registers: Option<f64>,
    /// Bytes of memory of a thread beside them: arrays that are indexed at run time, and what was spilled.
    pub stack_bytes: Option<f64>,
    /// Registers, or accesses to them, that did not fit: each driver counts in its own way.
    pub spills: Option<f64>,
    /// All that the driver says, in its own words.
    pub all: Vec<(String, f64)>,
}

/// What drivers call the figures, in lower case: NVIDIA's own, AMD's own, Mesa's for AMD and Intel.
const REGISTERS: [&str; 4] = ["register count", "numusedvgprs", "vgprs", "grf registers"];
const STACK: [&str; 1] = ["stack size"];
/// Bytes of all threads of a subgroup together.
const STACK_OF_SUBGROUP: [&str; 2] = ["scratch size", "scratch memory size"];
/// Those of one driver are added.
const SPILLS: [&str; 3] = ["spilled vgprs", "spilled sgprs", "spill count"];

impl KernelStatistics {
    /// Finds the figures among what a driver says of a kernel that it runs with so many threads in a subgroup.
    pub fn new(all: Vec<(String, f64)>, subgroup: u32) -> Self {
        let find = |name: &&str| {
            let mut named = all.iter();
            let found = named.find(|(said, _)| said.to_lowercase() == *name);
            found.map(|(_, value)| *value)
        };
        Self {
            registers: REGISTERS.iter().find_map(find),
            stack_bytes: STACK.iter().find_map(find).or_else(|| {
                let together = STACK_OF_SUBGROUP.iter().find_map(find);
                together.map(|bytes| bytes / f64::from(subgroup.max(1)))
            }),
            spills: SPILLS.iter().filter_map(find).reduce(|a, b| a + b),
            all,
        }
    }
}

/// Asks the driver of one device.
#[derive(Debug)]
pub struct Inspector {
    #[cfg(feature = "driver-statistics")]
    device: vulkan::Device,
    #[cfg(not(feature = "driver-statistics"))]
    never: std::convert::Infallible,
}

impl Inspector {
    /// Opens the first Vulkan device whose name contains this, letter case ignored, to ask it.
    ///
    /// # Errors
    /// Why it can't be asked, in words.
    #[cfg(feature = "driver-statistics")]
    pub fn open(name: &str) -> Result<Self, String> {
        vulkan::Device::open(name).map(|device| Self { device })
    }

    /// This program has been built without the feature `driver-statistics`.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(feature = "driver-statistics"))]
    pub fn open(_name: &str) -> Result<Self, String> {
        Err("this program was built without the feature `driver-statistics`".to_owned())
    }

    /// Its name.
    #[cfg(feature = "driver-statistics")]
    pub fn device_name(&self) -> &str {
        self.device.name()
    }

    /// There is no such device.
    #[cfg(not(feature = "driver-statistics"))]
    pub fn device_name(&self) -> &str {
        match self.never {}
    }

    /// What the driver says about a kernel. Takes as long as compiling it.
    ///
    /// # Errors
    /// A kernel that doesn't build.
    #[cfg(feature = "driver-statistics")]
    pub fn inspect(&self, kernel: &KernelText) -> Result<KernelStatistics, DeviceError> {
        let said = self.device.inspect(kernel);
        said.map_err(|message| DeviceError::Refused {
            label: kernel.entry.to_owned(),
            message,
        })
    }

    /// There is no such device.
    ///
    /// # Errors
    /// None.
    #[cfg(not(feature = "driver-statistics"))]
    pub fn inspect(&self, _kernel: &KernelText) -> Result<KernelStatistics, DeviceError> {
        match self.never {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statistics(said: &[(&str, f64)]) -> [Option<f64>; 3] {
        let all = said.iter().map(|&(name, value)| (name.to_owned(), value));
        let found = KernelStatistics::new(all.collect(), 32);
        [found.registers, found.stack_bytes, found.spills]
    }

    #[test]
    fn figures_are_found_by_the_names_that_drivers_give_them() {
        let nvidia = [
            ("Register Count", 96.0),
            ("Binary Size", 5120.0),
            ("Stack Size", 464.0),
        ];
        assert_eq!(statistics(&nvidia), [Some(96.0), Some(464.0), None]);
        let amd = [
            ("SGPRs", 80.0),
            ("VGPRs", 120.0),
            ("Spilled SGPRs", 2.0),
            ("Spilled VGPRs", 5.0),
            ("Code size", 9000.0),
            ("Scratch size", 8192.0),
        ];
        assert_eq!(statistics(&amd), [Some(120.0), Some(256.0), Some(7.0)]);
        let intel = [("Spill Count", 0.0), ("Scratch Memory Size", 0.0)];
        assert_eq!(statistics(&intel), [None, Some(0.0), Some(0.0)]);
        assert_eq!(statistics(&[]), [None; 3]);
    }

    #[test]
    fn a_device_that_is_not_there_is_named() {
        let error = Inspector::open("no such device").expect_err("there is none");
        assert!(!error.is_empty());
    }
}
