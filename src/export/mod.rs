//! `patina export`: a scene as glTF, with pictures in place of textures in WGSL.

pub(crate) mod args;
pub(crate) mod job;

use std::io::Write;

use device::Device;
use engine::aside;
use engine::bake::{Baker, Moment};
use engine::load::load;
use engine::scene::export::glb;

use crate::bake::follow;
use crate::failure::Failure;
use crate::progress::Bar;
use crate::{console, library, output};

use job::GltfJob;

/// Bakes and writes the file.
///
/// # Errors
/// Mistakes in the look; no device; the file can't be written.
pub(crate) fn run(job: &GltfJob) -> Result<(), Failure> {
    let textures = library::texture_dirs(&job.fine.texture_dirs, job.look.as_deref())?;
    let loaded = load(&job.scene, job.look.as_deref(), &textures)?;
    let read = loaded.files(&engine::system::Disk, &job.scene, job.look.as_deref());
    output::check_all([&job.output], &read)?;
    console::diagnostics(&loaded.warnings);
    let bar = Bar::new("preparing the device");
    let device = Device::open(&job.fine.device).map_err(Failure::because)?;
    bar.follow(&device);
    let moment = Moment {
        camera: loaded.camera.transform.translation.into(),
        ..Moment::default()
    };
    let baker = Baker::new(&device, &loaded.scene, &loaded.procedural, moment)?;
    let progress = &mut follow(&bar, "baking");
    let (scene, warnings) = baker.scene(&loaded.camera, &job.fine.settings, progress)?;
    bar.stage("writing");
    let exported = glb(&scene).map_err(Failure::because)?;
    bar.finish();
    console::diagnostics(&warnings);
    for warning in &exported.warnings {
        console::warning(warning);
    }
    let path = job.output.display();
    let written = aside::replace(&job.output, |file| file.write_all(&exported.glb));
    written.map_err(|error| Failure::Failed(format!("cannot write {path}: {error}")))?;
    let bytes = console::bytes(exported.glb.len() as u64);
    console::note(&format!("wrote {path}: {bytes}"));
    Ok(())
}
