//! `patina bench kernel`: how long the texture kernel takes to build, and what a hit costs beside things it doesn't use.

use std::path::PathBuf;

use device::{Device, DeviceChoice};
use engine::procedural::TextureSources;
use patina_bench::kernel;

use crate::failure::Failure;
use crate::progress::Bar;
use crate::{console, library};

/// Textures in the kernels that are built.
const COUNTS: [usize; 4] = [1, 10, 30, 100];

/// Measures and prints two tables.
///
/// # Errors
/// The textures are wrong or missing, or there is no device.
pub(crate) fn run(
    most: usize,
    texture_dirs: &[PathBuf],
    device: &DeviceChoice,
) -> Result<(), Failure> {
    let bar = Bar::new("measuring");
    let folders = library::texture_dirs(texture_dirs, None)?;
    let sources = TextureSources::search(&folders).map_err(Failure::because)?;
    let device = Device::open(device).map_err(Failure::because)?;
    bar.follow(&device);
    bar.suspend(|| console::print(&device.description().title()));

    let head = "                    first, s: read and                changed, s:     text\n\
                textures   lines   check each     text  compile         in all  + wave     text  compile   again";
    bar.suspend(|| console::print(&format!("\n{head}")));
    for count in COUNTS.into_iter().filter(|&count| count <= most) {
        let row = kernel::rebuild(&device, &sources, count).map_err(Failure::because)?;
        let wave = |seconds: Option<f64>| {
            seconds.map_or("not run".to_owned(), |seconds| format!("{seconds:.3}"))
        };
        let line = format!(
            "{:8} {:>7} {:12.3} {:8.3} {:8.3} {:14.3} {:>7} {:8.3} {:8.3} {:7.3}",
            row.textures,
            console::grouped(row.lines as u64),
            row.first.textures,
            row.first.parsing,
            row.first.compiling,
            row.cold.build,
            wave(row.cold.first_wave),
            row.cold.parsing,
            row.cold.compiling,
            row.warm.build,
        );
        bar.suspend(|| console::print(&line));
    }

    let rows = kernel::hits(&device, &sources, most).map_err(Failure::because)?;
    bar.finish();
    console::print("\nbesides                              textures    lines   ns/hit    ratio");
    for row in rows {
        console::print(&format!(
            "{:36} {:8} {:>8} {:8.1} {:8.3}",
            row.what,
            row.textures,
            console::grouped(row.lines as u64),
            row.nanoseconds,
            row.ratio
        ));
    }
    Ok(())
}
