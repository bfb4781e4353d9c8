//! `patina texture preview`: a texture on three objects, rendered within a second, or a material on a ball, within some. Of a
//! material a small picture is there at once, and is written again when it is finer.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use device::Device;
use engine::isolated::Subject;
use engine::preview::{MaterialPreview, Preview};
use engine::procedural::TextureSources;
use engine::renderer::Renderer;
use engine::scene::look::{Look, Value, parse_value};
use engine::scene::view::View;

use crate::failure::Failure;
use crate::output;
use crate::progress::{Bar, Reached};
use crate::{console, interrupt};

use super::job::PreviewJob;

/// Samples per pixel, where the time suffices.
const MAX_SPP: u32 = 64;
/// Samples per pixel, whatever time they take.
const MIN_SPP: u32 = 2;
/// From the start until no further samples are taken: writing the picture takes the rest of a second.
const PATIENCE: Duration = Duration::from_millis(900);
/// The same for materials, whose light is less even.
const PATIENCE_OF_MATERIALS: Duration = Duration::from_millis(5500);
/// Width of the first picture of a material, pixels: it is there within 0.3 s, half of which compiling takes.
const FIRST_WIDTH: u32 = 80;
/// Samples per pixel of the first picture.
const FIRST_SPP: u32 = 2;
/// One wave takes no longer, so that the first picture is there soon.
const LONGEST_WAVE: Duration = Duration::from_millis(60);
/// The same where compiling alone takes seconds: the rest of five.
const MORE_PATIENCE: Duration = Duration::from_millis(3800);

/// Renders and writes the picture.
///
/// # Errors
/// Mistakes in the texture or its arguments; no device; the picture can't be written.
pub(crate) fn run(job: &PreviewJob) -> Result<(), Failure> {
    let start = Instant::now();
    let target = &job.target;
    let written = [job.output.path.clone()];
    let named: Vec<PathBuf> = target.look.iter().cloned().collect();
    output::check_all(&written, &named)?;
    let sources = super::sources(&target.texture_dirs, target.look.as_deref())?;
    let look = target.look.as_deref().map(Look::load).transpose()?;
    let mut read = match &look {
        Some(look) => engine::load::files(Path::new(""), Some(look)),
        None => Vec::new(),
    };
    for (_, value) in &target.sets {
        named_by(value, &mut read);
    }
    output::check_all(&written, &read)?;
    let studio = match (&look, job.is_material) {
        (Some(look), true) => {
            let preview = MaterialPreview::new(look, &target.name, &sources)?;
            console::diagnostics(preview.warnings());
            Studio::Material(Box::new(preview))
        }
        (Some(look), false) => texture(job, Subject::Node(&target.name, look), &sources)?,
        (None, _) => texture(job, Subject::Texture(&target.name), &sources)?,
    };

    let bar = Bar::new("preparing the device");
    let device = Device::open(&target.device).map_err(Failure::because)?;
    bar.follow(&device);
    if job.is_material {
        first_picture(&studio, &device, job)?;
    }
    let mut renderer = studio.renderer(&device, job.size)?;
    let patience = match (device.traits().compiles_slowly, job.is_material) {
        (true, _) => MORE_PATIENCE,
        (false, true) => PATIENCE_OF_MATERIALS,
        (false, false) => PATIENCE,
    };
    renderer.set_longest_wave(LONGEST_WAVE);
    let mut is_complete = true;
    let mut shown = 0;
    loop {
        let progress = renderer.step(MAX_SPP).map_err(Failure::because)?;
        bar.update(&Reached::of(&progress, MAX_SPP), MAX_SPP);
        interrupt::has_results();
        let spp = progress.samples_done * u64::from(MAX_SPP) / progress.samples_total.max(1);
        if interrupt::requested() {
            is_complete = false;
            break;
        }
        // Again with twice as many samples, and so on.
        if job.is_material && spp > 2 * shown && !progress.is_done() {
            shown = spp;
            let film = renderer.film().map_err(Failure::because)?;
            output::write(&job.output, &film, None, &View::default()).map_err(Failure::because)?;
        }
        if progress.is_done() || (spp >= u64::from(MIN_SPP) && start.elapsed() > patience) {
            break;
        }
    }
    let film = renderer.film().map_err(Failure::because)?;
    interrupt::writes_results();
    bar.finish();

    output::write(&job.output, &film, None, &View::default()).map_err(Failure::because)?;
    console::note(&format!("wrote {}", job.output.path.display()));
    match is_complete {
        true => Ok(()),
        false => Err(Failure::Interrupted),
    }
}

/// The files that an argument may name: an image is a text, or a table with one.
fn named_by(argument: &str, files: &mut Vec<PathBuf>) {
    match parse_value(argument) {
        Some(value) => texts(&value.value, files),
        // It may be a path without quotes, which may have some in it, or a table with numbers that TOML has no place for.
        None => {
            files.push(argument.into());
            let parts = argument.split(['"', '\'']).filter(|part| !part.is_empty());
            files.extend(parts.map(PathBuf::from));
        }
    }
}

/// All texts in a value, as paths.
fn texts(value: &Value, files: &mut Vec<PathBuf>) {
    match value {
        Value::Text(text) => files.push(text.into()),
        Value::List(items) => items.iter().for_each(|item| texts(&item.value, files)),
        Value::Table(fields) => fields.iter().for_each(|f| texts(&f.value.value, files)),
        Value::Bool(_) | Value::Integer(_) | Value::Float(_) | Value::Date => {}
    }
}

/// A small picture of few samples, which is there before the large one has any.
fn first_picture(studio: &Studio, device: &Device, job: &PreviewJob) -> Result<(), Failure> {
    let mut renderer = studio.renderer(device, job.size.min(FIRST_WIDTH))?;
    while !(renderer.step(FIRST_SPP).map_err(Failure::because)?).is_done() {
        if interrupt::requested() {
            return Ok(());
        }
    }
    let film = renderer.film().map_err(Failure::because)?;
    output::write(&job.output, &film, None, &View::default()).map_err(Failure::because)
}

/// What is rendered.
enum Studio {
    Texture(Box<Preview>),
    Material(Box<MaterialPreview>),
}

impl Studio {
    fn renderer(&self, device: &Device, width: u32) -> Result<Renderer, Failure> {
        let renderer = match self {
            Self::Texture(preview) => preview.renderer(device, width),
            Self::Material(preview) => preview.renderer(device, width),
        };
        renderer.map_err(Failure::because)
    }
}

/// A texture or node with its arguments.
fn texture(
    job: &PreviewJob,
    subject: Subject<'_>,
    sources: &TextureSources,
) -> Result<Studio, Failure> {
    let mut preview = Preview::new(subject, sources, job.range)?;
    console::diagnostics(preview.warnings());
    for (parameter, value) in &job.target.sets {
        preview.set(parameter, value).map_err(Failure::because)?;
    }
    Ok(Studio::Texture(Box::new(preview)))
}
