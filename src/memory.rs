//! What a render will take: told before it begins, and refused where that isn't there. How much there is, the system says where it
//! is Linux; elsewhere `--memory` does.

use std::fs;
use std::path::Path;

use device::Device;
use engine::film::Layers;
use engine::film::write::Format;
use engine::procedural::Procedural;
use engine::renderer::{DeviceMemory, RenderSettings, file_bytes, snapshot_bytes};
use engine::scene::import::environment_image_size;
use engine::scene::look::EnvironmentLook;
use engine::scene::{Environment, Scene};
use engine::settings::Method;
use engine::system::Disk;
use pictures::seen::noise_bytes;

use crate::console;
use crate::failure::Failure;
use crate::job::RenderJob;
use crate::left::left;
use crate::progress::Bar;

/// Bytes of a pixel while PNG and JPEG files are made: radiance, what is shown of it, and its coverage.
const SHOWN: u64 = 32;
/// Bytes of a texel of the environment in the program.
const TEXEL: u64 = size_of::<[f32; 3]>() as u64;

/// What a render takes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Need {
    devices: Vec<OnDevice>,
    /// Copies of the film that are handed around.
    film: u64,
    /// What files are made from, the noise is looked at with, or the picture is judged by.
    files: u64,
    /// The scene's pictures, as the program keeps them: they are there already, and those of other moments are the same.
    pictures: u64,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct OnDevice {
    name: String,
    bytes: DeviceMemory,
    /// Its memory is the machine's.
    is_shared: bool,
}

impl Need {
    /// Of a job on these devices.
    pub(crate) fn of(
        job: &RenderJob,
        settings: &RenderSettings,
        scene: &Scene,
        procedural: &Procedural,
        devices: &[Device],
    ) -> Self {
        let bytes = |device: &Device, settings: &RenderSettings| {
            DeviceMemory::of(device, scene, procedural, settings)
        };
        let on_device = |device: &Device| OnDevice {
            name: device.description().name.clone(),
            bytes: bytes(device, settings),
            is_shared: device.traits().shares_the_processor,
        };
        let mut on_devices: Vec<_> = devices.iter().map(on_device).collect();
        let is_judged =
            settings.method != Method::Path && job.motion.has_equal_halves(job.whole_spp);
        // Where several devices render, a renderer that is made for it on one of them tells how right the picture is.
        let judge = (is_judged && devices.len() > 1).then(|| RenderSettings {
            method: Method::Path,
            layers: Layers::default(),
            ..settings.clone()
        });
        if let (Some(judge), [first, ..], [device, ..]) = (&judge, &mut on_devices[..], devices) {
            first.bytes = both(first.bytes, bytes(device, judge));
        }
        // It is compared with two films of paths, of each moment of a shutter where it was open.
        let films = match job.motion.shutter.is_some() {
            true => 4,
            false => 2,
        };
        let judged_by =
            is_judged.then(|| films * snapshot_bytes(judge.as_ref().unwrap_or(settings)));
        let copies = match devices.len() {
            // One is written while the next one is read.
            1 => 1 + u64::from(job.checkpoints.is_some()),
            // Each hands over its own, and they are added up.
            several => 1 + several as u64,
        };
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        let file = |format| match format {
            Format::Exr => file_bytes(settings, &job.shown_layers),
            Format::Png | Format::Jpeg => SHOWN * pixels,
        };
        let outputs = job.outputs.pictures.iter();
        let size = [settings.width, settings.height].map(u64::from);
        let look = job.limits.flip.map(|_| noise_bytes(size));
        let environment = match &scene.environment {
            Environment::Constant(_) => 0,
            Environment::Image { image, .. } => {
                TEXEL * u64::from(image.width) * u64::from(image.height)
            }
        };
        let images = scene.images.iter().map(|image| image.rgba8.len() as u64);
        Self {
            pictures: environment + images.sum::<u64>(),
            devices: on_devices,
            film: copies * snapshot_bytes(settings),
            files: outputs
                .map(|output| file(output.format))
                .chain(look)
                .chain(judged_by)
                .max()
                .unwrap_or_default(),
        }
    }

    /// Of the machine's memory.
    fn machine(&self) -> u64 {
        let shared = self.devices.iter().filter(|device| device.is_shared);
        let devices: u64 = shared.map(|device| device.bytes.total()).sum();
        self.film + self.files + self.pictures + devices
    }

    /// In words.
    pub(crate) fn text(&self) -> String {
        let of_device = |device: &OnDevice| {
            let DeviceMemory {
                film,
                layers,
                scene,
                paths,
            } = device.bytes;
            format!(
                "{} on {} (film {}, layers {}, scene about {}, paths {})",
                shown(device.bytes.total()),
                device.name,
                shown(film),
                shown(layers),
                shown(scene),
                shown(paths)
            )
        };
        let devices: Vec<_> = self.devices.iter().map(of_device).collect();
        let pictures = match self.pictures {
            0 => String::new(),
            bytes => format!(", {} for the scene's pictures", shown(bytes)),
        };
        format!(
            "{}, and {} for files and copies of the film{pictures}",
            devices.join(", "),
            shown(self.film + self.files)
        )
    }

    /// Whether it is there: within `most` where that is said, else within what the system has left.
    ///
    /// # Errors
    /// It isn't; the text says what to do.
    pub(crate) fn check(&self, most: Option<u64>, left: Option<u64>) -> Result<(), Failure> {
        let remedy = "render a part (--crop), a smaller picture (--scale), or fewer layers";
        let alone = |device: &&OnDevice| {
            !device.is_shared && most.is_some_and(|most| device.bytes.total() > most)
        };
        if let (Some(device), Some(most)) = (self.devices.iter().find(alone), most) {
            return Err(Failure::Failed(format!(
                "the render takes {} on {}, more than --memory {}: {remedy}; it would take {}",
                shown(device.bytes.total()),
                device.name,
                shown(most),
                self.text()
            )));
        }
        let (limit, because) = match (most, left) {
            (Some(most), _) => (most, format!("more than --memory {}", shown(most))),
            (None, Some(left)) => (left, format!("but {} are left", shown(left))),
            (None, None) => return Ok(()),
        };
        let needed = self.machine();
        // What is there already isn't among what is left.
        let there = if most.is_some() { 0 } else { self.pictures };
        if needed - there <= limit {
            return Ok(());
        }
        Err(Failure::Failed(format!(
            "the render takes {} of memory, {because}: {remedy}{}; it would take {}",
            shown(needed),
            retry(most, needed),
            self.text()
        )))
    }
}

/// How to have so many bytes taken all the same, where nobody has said how many may be.
fn retry(most: Option<u64>, needed: u64) -> String {
    match most {
        Some(_) => String::new(),
        None => format!(
            "; --memory {}G tries it all the same",
            needed.div_ceil(1 << 30)
        ),
    }
}

/// Of two renderers on one device.
fn both(one: DeviceMemory, other: DeviceMemory) -> DeviceMemory {
    DeviceMemory {
        film: one.film + other.film,
        layers: one.layers + other.layers,
        scene: one.scene + other.scene,
        paths: one.paths + other.paths,
    }
}

/// Most paths under way at once within a budget: they may take a quarter of it, or as much as a million of them do.
pub(crate) fn largest_wave(most: Option<u64>) -> u32 {
    let paths = most.map_or(u64::MAX, |most| most / 4 / PATH);
    paths.clamp(1 << 20, u64::from(u32::MAX)) as u32
}

/// Bytes of a path, about.
const PATH: u64 = 512;

/// Whether a look's environment can be read within `most` bytes, or within what the system has left: by the size that its file claims, so
/// that nothing is taken for one that can't.
///
/// # Errors
/// It can't; the text says what to do.
pub(crate) fn check_environment(job: &RenderJob) -> Result<(), Failure> {
    // What else is wrong with either is told where it is read.
    let Ok(Some(look)) = job.overrides.look(job.look.as_deref()) else {
        return Ok(());
    };
    let environment = look.environment.as_ref().map(|given| &given.value);
    let Some(EnvironmentLook::Image { image, .. }) = environment else {
        return Ok(());
    };
    let path = look.resolve(&image.value);
    let Some(size) = environment_image_size(&Disk, &path) else {
        return Ok(());
    };
    let file = fs::metadata(&path).map_or(0, |meta| meta.len());
    environment_fits(&path, size, file, job.memory, left())
}

/// See [`check_environment`]; the file has so many bytes.
fn environment_fits(
    path: &Path,
    [width, height]: [u32; 2],
    file: u64,
    most: Option<u64>,
    left: Option<u64>,
) -> Result<(), Failure> {
    let picture = TEXEL * u64::from(width) * u64::from(height);
    // It lies beside its file, then beside the one that the scene gets.
    let needed = picture + picture.max(file);
    let because = match (most, left) {
        (Some(most), _) if needed > most => format!("more than --memory {}", shown(most)),
        (None, Some(left)) if needed > left => format!("but {} are left", shown(left)),
        _ => return Ok(()),
    };
    Err(Failure::Failed(format!(
        "the environment {} of {width}x{height} texels takes {} of memory while it is read, {because}: scale it down{}",
        path.display(),
        shown(needed),
        retry(most, needed)
    )))
}

/// Tells what a render will take.
///
/// # Errors
/// It is more than there is.
pub(crate) fn state(job: &RenderJob, need: &Need, bar: &Bar) -> Result<(), Failure> {
    need.check(job.memory, left())?;
    tell(&need.text(), bar);
    Ok(())
}

/// Tells what a render will take, in words.
pub(crate) fn tell(text: &str, bar: &Bar) {
    bar.suspend(|| console::note(&format!("memory: at most {text}")));
}

/// Bytes in the unit that suits them.
fn shown(bytes: u64) -> String {
    let bytes = bytes as f64;
    match bytes {
        b if b >= 1024.0 * 1024.0 * 1024.0 => format!("{:.1} GiB", b / f64::from(1 << 30)),
        b => format!("{:.0} MiB", (b / f64::from(1 << 20)).ceil()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(gibibytes: u64, is_shared: bool) -> Need {
        let bytes = DeviceMemory {
            film: gibibytes << 29,
            layers: gibibytes << 29,
            scene: 5 << 20,
            paths: 3 << 20,
        };
        let name = "A".to_owned();
        Need {
            devices: vec![OnDevice {
                name,
                bytes,
                is_shared,
            }],
            film: 1 << 30,
            files: 1 << 30,
            pictures: 0,
        }
    }

    #[test]
    fn pictures_of_the_scene_count_and_are_there_already() {
        let bare = need(4, true);
        let whole = bare.machine();
        let with = Need {
            pictures: 3 << 30,
            ..bare
        };
        assert!(with.text().ends_with("3.0 GiB for the scene's pictures"));
        let fits = |most, left| with.check(most, left).is_ok();
        assert!(fits(Some(whole + (3 << 30)), None) && !fits(Some(whole + (2 << 30)), None));
        assert!(fits(None, Some(whole)) && !fits(None, Some(whole - 1)));
    }

    #[test]
    fn a_large_environment_is_refused_before_it_is_read() {
        let path = Path::new("sky.exr");
        let fits = |file, most, left| environment_fits(path, [16384, 8192], file, most, left);
        let gibibytes = |n: u64| Some(n << 30);
        assert!(fits(0, gibibytes(3), gibibytes(1)).is_ok());
        assert!(fits(0, None, None).is_ok());
        let text = fits(0, gibibytes(2), None)
            .expect_err("no room")
            .to_string();
        for word in ["sky.exr", "16384x8192", "3.0 GiB", "--memory 2.0 GiB"] {
            assert!(text.contains(word), "{word}: {text}");
        }
        // The file of one with many channels is larger than what is shown of it.
        let text = fits(2 << 30, None, gibibytes(3)).expect_err("no room");
        assert!(text.to_string().contains("--memory 4G tries it"), "{text}");
    }

    #[test]
    fn waves_leave_most_of_a_budget_to_the_picture() {
        assert_eq!(largest_wave(None), u32::MAX);
        assert_eq!(largest_wave(Some(1 << 30)), 1 << 20);
        assert_eq!(largest_wave(Some(4 << 30)), 1 << 21);
        assert_eq!(largest_wave(Some(u64::MAX)), u32::MAX);
    }

    #[test]
    fn what_is_not_there_is_refused() {
        let gibibytes = |n: u64| Some(n << 30);
        let refused = |need: &Need, most, left| match need.check(most, left) {
            Ok(()) => None,
            Err(failure) => Some(failure.to_string()),
        };
        let shared = need(4, true);
        assert_eq!(refused(&shared, None, gibibytes(7)), None);
        assert_eq!(refused(&shared, None, None), None);
        let text = refused(&shared, None, gibibytes(6)).expect("it isn't there");
        for word in [
            "6.0 GiB",
            "--crop",
            "--memory 7G",
            "layers 2.0 GiB",
            "scene about 5 MiB",
        ] {
            assert!(text.contains(word), "{word}: {text}");
        }
        // Who says how much it may be knows better than the system.
        assert_eq!(refused(&shared, gibibytes(7), gibibytes(1)), None);
        assert!(refused(&shared, gibibytes(6), gibibytes(64)).is_some());
        // A device of its own has its own memory.
        let own = need(4, false);
        assert_eq!(refused(&own, None, gibibytes(2)), None);
        let text = refused(&own, gibibytes(3), None).expect("too much for the device");
        assert!(text.contains("on A"), "{text}");
    }
}
