//! The device that tests render on, which a machine may lack.

use ::device::{Device, DeviceChoice};

/// The device that tests render on: `PATINA_DEVICE` names it, or it is the best that there is. So one suite is run on
/// several devices.
pub(crate) fn choice() -> DeviceChoice {
    let name = std::env::var("PATINA_DEVICE");
    name.map_or(DeviceChoice::Best, DeviceChoice::Name)
}

/// Opens the device of [`choice`]; `None`, with a notice, where there is none: the test is to be skipped. Each test opens
/// its own, so that one test's driver error or count of pipelines is not another's.
///
/// # Panics
/// There is none although `PATINA_REQUIRE_DEVICE` is set: a run that must not skip anything.
pub(crate) fn open() -> Option<Device> {
    required(&choice())
}

/// As [`open`], a device with a driver, which may be one in software: for what the processor alone doesn't do, and to
/// compare with.
pub(crate) fn open_driver() -> Option<Device> {
    required(&DeviceChoice::Driver)
}

/// The processor, for converged pictures by paths to compare with: devices agree on these, as other tests see to, and a software driver
/// takes several times as long for them.
///
/// # Panics
/// Never: there is a processor.
pub(crate) fn open_for_reference() -> Device {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let choice = DeviceChoice::Native(u32::try_from(threads).unwrap_or(1));
    Device::open(&choice).expect("a processor needs no driver")
}

fn required(choice: &DeviceChoice) -> Option<Device> {
    match Device::open(choice) {
        Ok(device) => Some(device),
        Err(error) => {
            assert!(
                std::env::var_os("PATINA_REQUIRE_DEVICE").is_none(),
                "PATINA_REQUIRE_DEVICE is set, but: {error}"
            );
            eprintln!("skipped: {error}");
            None
        }
    }
}

/// Whether the long form of a test is wanted: `PATINA_FULL` is set.
pub(crate) fn full_run() -> bool {
    std::env::var_os("PATINA_FULL").is_some()
}
