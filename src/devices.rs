//! `patina devices`: what can be rendered on, and the limits that matter; and how those are opened that `--device` names.

use std::fmt::Write;

use device::{Device, DeviceChoice, DeviceDescription, DeviceError, DeviceOptions};

use crate::failure::Failure;
use crate::progress::Bar;
use crate::words::{Devices, NATIVE};
use crate::{cache, console};

/// Prints the list.
pub(crate) fn run() {
    let together: Vec<usize> = Device::together().iter().map(|d| d.index).collect();
    console::print(&list(&Device::all(), &together));
}

/// The devices that are wanted, one by one; none where nothing is said.
pub(crate) fn choices(wanted: &Devices) -> Vec<DeviceChoice> {
    let all = match wanted.all {
        true => Device::together(),
        false => Vec::new(),
    };
    let all = all.iter().map(|device| DeviceChoice::Index(device.index));
    all.chain(wanted.named.iter().cloned()).collect()
}

/// Opens devices that render together. One of several that can't be opened is left out, with a warning.
///
/// # Errors
/// A name or a number that no device has, or none can be opened.
pub(crate) fn open(wanted: &Devices, bar: &Bar) -> Result<Vec<Device>, Failure> {
    let mut choices = choices(wanted);
    if choices.is_empty() {
        choices.push(DeviceChoice::Best);
    }
    let cache = cache::folder();
    let mut opened = Vec::new();
    let mut refused = Vec::new();
    // Of the processor there may be several, if threads of their own are asked for; of all others one, however named.
    let mut whole = Vec::new();
    for choice in &choices {
        let options = DeviceOptions::new(choice).with_cache(cache.as_deref());
        match Device::open_with(&options) {
            Ok(device) => {
                let index = device.description().index;
                if matches!(choice, DeviceChoice::Native(_)) {
                    opened.push(device);
                } else if !whole.contains(&index) {
                    whole.push(index);
                    opened.push(device);
                }
            }
            Err(error @ DeviceError::NotFound { .. }) => return Err(Failure::because(error)),
            Err(error) => refused.push(error.to_string()),
        }
    }
    if opened.is_empty() {
        return Err(Failure::Failed(refused.join("\n")));
    }
    for reason in refused {
        let text = format!("{reason}; the other devices render without it");
        bar.suspend(|| console::warning(&text));
    }
    Ok(opened)
}

/// The parts that are not empty; drivers don't tell everything.
fn known(parts: &[&str]) -> String {
    let known: Vec<_> = parts
        .iter()
        .copied()
        .filter(|part| !part.is_empty())
        .collect();
    known.join(", ")
}

/// What each device does where `--device` isn't given; nothing where another one is better at it.
fn unasked(device: &DeviceDescription, all: &[DeviceDescription]) -> &'static str {
    let first = |is_meant: &dyn Fn(&DeviceDescription) -> bool| {
        let mut usable = all.iter().filter(|device| device.usable.is_ok());
        let found = usable.find(|device| is_meant(device));
        found.is_some_and(|found| found.index == device.index)
    };
    let is_own = |device: &DeviceDescription| device.name == NATIVE;
    let renders = first(&|device| !device.is_processor || is_own(device));
    let draws = first(&|device| !is_own(device));
    match (renders, draws) {
        (true, true) => "renders, and draws the window of `view`",
        (true, false) => "renders",
        (false, true) => "draws the window of `view`",
        (false, false) => "",
    }
}

/// `together` are the numbers of those that `--device all` takes.
fn list(adapters: &[DeviceDescription], together: &[usize]) -> String {
    let mut text = String::new();
    for adapter in adapters {
        let facts = [
            (
                "driver",
                known(&[&adapter.backend, &adapter.device_type, &adapter.driver]),
            ),
            (
                "memory",
                format!(
                    "{} per storage binding, {} per buffer",
                    console::bytes(adapter.max_storage_binding),
                    console::bytes(adapter.max_buffer)
                ),
            ),
            (
                "limits",
                format!(
                    "{} storage buffers per stage, {} invocations per workgroup, {} timestamps, {} ray queries",
                    adapter.storage_buffers_per_stage,
                    adapter.workgroup_invocations,
                    if adapter.timestamps { "with" } else { "no" },
                    if adapter.ray_queries { "with" } else { "no" }
                ),
            ),
            (
                "usable",
                match &adapter.usable {
                    Ok(()) if together.contains(&adapter.index) => {
                        "yes, by `--device all` too".to_owned()
                    }
                    Ok(()) => "yes".to_owned(),
                    Err(reason) => format!("no: {reason}"),
                },
            ),
        ];
        let unasked = unasked(adapter, adapters);
        let unasked =
            (!unasked.is_empty()).then(|| format!("where no `--device` is given: {unasked}"));
        let unasked = unasked.map(|text| ("used", text));
        let _ = writeln!(text, "{}: {}", adapter.index, adapter.name);
        for (name, value) in facts.into_iter().chain(unasked) {
            let _ = writeln!(text, "     {name:7} {value}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn old_gpu() -> DeviceDescription {
        DeviceDescription {
            index: 3,
            name: "Old GPU".into(),
            backend: "Vulkan".into(),
            driver: String::new(),
            device_type: "IntegratedGpu".into(),
            is_processor: false,
            max_storage_binding: 128 << 20,
            max_buffer: 1 << 30,
            storage_buffers_per_stage: 4,
            workgroup_invocations: 128,
            timestamps: false,
            ray_queries: false,
            usable: Err("4 storage buffers per stage, 8 are needed".into()),
        }
    }

    #[test]
    fn the_list_says_what_is_used_without_being_named() {
        let device = |index: usize, name: &str, is_processor: bool| DeviceDescription {
            index,
            name: name.to_owned(),
            is_processor,
            usable: Ok(()),
            ..old_gpu()
        };
        let native = |index| device(index, NATIVE, true);
        let software = |index| device(index, "llvmpipe", true);
        let used = |all: &[DeviceDescription]| -> Vec<&str> {
            all.iter().map(|device| unasked(device, all)).collect()
        };
        let both = "renders, and draws the window of `view`";
        let (renders, draws) = ("renders", "draws the window of `view`");
        assert_eq!(used(&[native(0)]), [renders]);
        assert_eq!(used(&[native(0), software(1)]), [renders, draws]);
        let all = [device(0, "GPU", false), native(1), software(2)];
        assert_eq!(used(&all), [both, "", ""]);
        let all = [old_gpu(), native(4), software(5)];
        assert_eq!(used(&all), ["", renders, draws]);
        let text = list(&all, &[]);
        let said = "used    where no `--device` is given: renders\n";
        assert!(text.contains(said), "{text}");
    }

    #[test]
    fn an_unusable_device_says_why() {
        let text = list(&[old_gpu()], &[]);
        assert!(text.starts_with("3: Old GPU\n"), "{text}");
        assert!(text.contains("Vulkan, IntegratedGpu\n"), "{text}");
        assert!(text.contains("128.0 MiB per storage binding"), "{text}");
        assert!(
            text.contains("no: 4 storage buffers per stage, 8 are needed"),
            "{text}"
        );
    }
}
