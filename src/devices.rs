//! `patina devices`: what can be rendered on, and the limits that matter.

use std::fmt::Write;

use device::{Device, DeviceDescription};

use crate::console;

/// Prints the list.
pub(crate) fn run() {
    console::print(&list(&Device::all()));
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

fn list(adapters: &[DeviceDescription]) -> String {
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
                    Ok(()) => "yes".to_owned(),
                    Err(reason) => format!("no: {reason}"),
                },
            ),
        ];
        let _ = writeln!(text, "{}: {}", adapter.index, adapter.name);
        for (name, value) in facts {
            let _ = writeln!(text, "     {name:7} {value}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unusable_device_says_why() {
        let adapter = DeviceDescription {
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
        };
        let text = list(&[adapter]);
        assert!(text.starts_with("3: Old GPU\n"), "{text}");
        assert!(text.contains("Vulkan, IntegratedGpu\n"), "{text}");
        assert!(text.contains("128.0 MiB per storage binding"), "{text}");
        assert!(
            text.contains("no: 4 storage buffers per stage, 8 are needed"),
            "{text}"
        );
    }
}
