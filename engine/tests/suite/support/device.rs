//! The device that tests render on, which a machine may lack.

use ::device::Device;

/// Opens the best adapter; `None`, with a notice, where there is none: the test is to be skipped. Each test opens its
/// own, so that one test's driver error or count of pipelines is not another's.
///
/// # Panics
/// There is none although `PATINA_REQUIRE_DEVICE` is set: a run that must not skip anything.
pub(crate) fn open() -> Option<Device> {
    match Device::best() {
        Ok(gpu) => Some(gpu),
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
