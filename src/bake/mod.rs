//! `patina bake`: a material or a node as pictures over texture coordinates.

pub(crate) mod args;
pub(crate) mod job;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use device::Device;
use engine::aside;
use engine::bake::{BakeError, Baker, Moment, Role, Target, shown, write_exr};
use engine::load::{Loaded, load};
use engine::scene::import::give_tangents;
use engine::scene::look::link_text;
use texgen::{Link, NodeId, OutputType, did_you_mean};

use crate::failure::Failure;
use crate::progress::Bar;
use crate::words::{Format, Output};
use crate::{console, interrupt, library, output};

use job::BakeJob;

/// What is baked.
enum Subject {
    Material(u32),
    Node(Link),
}

/// Makes and writes the pictures.
///
/// # Errors
/// Mistakes in the look; no such material, node or mesh; a mesh without texture coordinates; no device; a file can't be written.
pub(crate) fn run(job: &BakeJob) -> Result<(), Failure> {
    let textures = library::texture_dirs(&job.fine.texture_dirs, job.look.as_deref())?;
    let loaded = load(&job.scene, job.look.as_deref(), &textures)?;
    let read = loaded.files(&engine::system::Disk, &job.scene, job.look.as_deref());
    let subject = subject(&loaded, &job.name)?;
    output::check_all(&paths(job, &subject), &read)?;
    console::diagnostics(&loaded.warnings);
    let material = match subject {
        Subject::Material(material) => Some(material),
        Subject::Node(_) => None,
    };
    let instance = instance(&loaded, job.mesh.as_deref(), material)?;
    let mesh = &loaded.scene.meshes[loaded.scene.instances[instance as usize].mesh as usize];
    let mut layout = mesh.clone();
    give_tangents(&mut layout);
    // What only lies above other materials is on no triangle: it is seen as if it were on all.
    let own = material.filter(|material| mesh.triangle_materials.contains(material));
    if material.is_some() && own.is_none() {
        console::note(&format!(
            "mesh \"{}\" hasn't the material \"{}\" itself: it is baked over the whole mesh",
            mesh.name, job.name
        ));
    }
    let target = Target {
        instance,
        layout: &layout,
        material: own,
    };

    let bar = Bar::new("preparing the device");
    let device = Device::open(&job.fine.device).map_err(Failure::because)?;
    bar.follow(&device);
    let moment = Moment {
        camera: loaded.camera.transform.translation.into(),
        ..Moment::default()
    };
    let baker = Baker::new(&device, &loaded.scene, &loaded.procedural, moment)?;
    let settings = &job.fine.settings;
    let progress = &mut follow(&bar, "baking");
    let (overlap, missed, non_finite) = match subject {
        Subject::Material(material) => {
            let baked = baker.material(material, &target, settings, progress)?;
            bar.finish();
            for image in &baked.images {
                let output = named(&job.output, image.role);
                match output.format {
                    Format::Exr => write_floats(&output, image.size, &image.rgba)?,
                    _ => {
                        write_bytes(&output, image.size, &image.eight_bits())?;
                        if image.most != 1.0 {
                            let path = output.path.display();
                            let most = image.most;
                            console::note(&format!(
                                "{path} is divided by {most}: that is its factor in a material"
                            ));
                        }
                    }
                }
            }
            for key in baked.lost {
                console::warning(&format!(
                    "`{key}` differs from place to place, which no picture of glTF can hold"
                ));
            }
            (baked.overlap, baked.missed, baked.non_finite)
        }
        Subject::Node(source) => {
            let maps = baker.node(source, &target, settings, progress)?;
            bar.finish();
            let graph = loaded.procedural.graph();
            let ty =
                (graph.link_output(source.source, source.swizzle)).map_err(Failure::because)?;
            let is_color = matches!(ty, OutputType::Vec3 | OutputType::Vec4);
            let rgba = opaque(maps.rgba(), ty);
            match job.output.format {
                Format::Exr => write_floats(&job.output, maps.size, &rgba)?,
                _ => write_bytes(&job.output, maps.size, &shown(&rgba, is_color))?,
            }
            (maps.overlap, maps.missed, maps.non_finite)
        }
    };
    warn_of_overlap(&layout.name, overlap);
    warn_of_missed(&layout.name, missed);
    if let Some(words) = engine::bake::non_finite_warning(non_finite) {
        console::warning(&words);
    }
    Ok(())
}

/// Only four components have an alpha of their own.
fn opaque(mut rgba: Vec<[f32; 4]>, ty: OutputType) -> Vec<[f32; 4]> {
    if ty != OutputType::Vec4 {
        rgba.iter_mut().for_each(|texel| texel[3] = 1.0);
    }
    rgba
}

/// Tells a bar of the progress, and ends the work when a signal asks for it.
pub(crate) fn follow<'b>(bar: &'b Bar, what: &'b str) -> impl FnMut(f32) -> ControlFlow<()> + 'b {
    move |share| {
        bar.stage(&format!("{what}, {:.0} %", 100.0 * share));
        match interrupt::requested() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// Says where a picture shows less than there is.
pub(crate) fn warn_of_overlap(mesh: &str, overlap: f32) {
    // Rounding at borders of triangles isn't worth a word.
    if overlap > 1e-3 {
        console::warning(&format!(
            "{:.0} % of mesh \"{mesh}\" has no place of its own on the picture, because its texture coordinates overlap or repeat: what is \
             shown there is from elsewhere; give each part its own place where the mesh was unwrapped",
            (100.0 * overlap).max(1.0)
        ));
    }
}

/// Says where a picture has nothing of the surface.
fn warn_of_missed(mesh: &str, missed: f32) {
    if missed > 1e-3 {
        console::warning(&format!(
            "{:.0} % of the surface of mesh \"{mesh}\" has no texel and shows what lies nearest; take a larger --size, or give it more of \
             the picture where the mesh was unwrapped",
            (100.0 * missed).max(1.0)
        ));
    }
}

fn subject(loaded: &Loaded, name: &str) -> Result<Subject, Failure> {
    let materials: Vec<(&str, u32)> = loaded.procedural.materials().collect();
    let in_scene = || (0..).zip(&loaded.scene.materials);
    let material = (materials.iter())
        .find(|(known, _)| *known == name)
        .map(|(_, index)| *index)
        .or_else(|| in_scene().find(|(_, m)| m.name == name).map(|(i, _)| i));
    if let Some(material) = material {
        return Ok(Subject::Material(material));
    }
    let graph = loaded.procedural.graph();
    if let Some((node, link)) = link_text(name)
        .ok()
        .and_then(|link| Some((graph.node(&link.node)?, link)))
    {
        // An output that isn't there is said so.
        let given = graph.link_output(node, link.swizzle);
        given.map_err(Failure::because)?;
        return Ok(Subject::Node(Link {
            source: node,
            swizzle: link.swizzle,
        }));
    }
    let nodes: Vec<NodeId> = graph.ids().collect();
    let known = (in_scene().map(|(_, m)| m.name.as_str()))
        .chain(nodes.iter().map(|&node| graph.name(node)));
    Err(unknown(
        "material or node",
        name,
        &known.collect::<Vec<_>>(),
    ))
}

fn unknown(what: &str, name: &str, known: &[&str]) -> Failure {
    const SHOWN: usize = 20;
    let remedy = match did_you_mean(name, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if known.is_empty() => "there are none".to_owned(),
        None => {
            let shown: Vec<&str> = known.iter().take(SHOWN).copied().collect();
            format!("there are: {}", shown.join(", "))
        }
    };
    Failure::Failed(format!("there is no {what} called `{name}`; {remedy}"))
}

/// Which instance is meant: by its name or its mesh's, one with the material before others, or the first with the material.
fn instance(loaded: &Loaded, name: Option<&str>, material: Option<u32>) -> Result<u32, Failure> {
    let scene = &loaded.scene;
    let mesh_of = |instance: &engine::scene::Instance| &scene.meshes[instance.mesh as usize];
    let has = |instance: &engine::scene::Instance| {
        let mut materials = mesh_of(instance).triangle_materials.iter();
        material.is_none_or(|material| materials.any(|&m| m == material))
    };
    let all = || (0..).zip(&scene.instances);
    let Some(name) = name else {
        let found = all().find(|(_, instance)| has(instance));
        return found.map(|(index, _)| index).ok_or_else(|| {
            Failure::Failed(
                "no mesh has this material itself: say on which one it is to lie, by --mesh NAME"
                    .to_owned(),
            )
        });
    };
    let is_named = |instance: &engine::scene::Instance| {
        instance.name == name || mesh_of(instance).name == name
    };
    let found = all()
        .find(|(_, instance)| is_named(instance) && has(instance))
        .or_else(|| all().find(|(_, instance)| is_named(instance)));
    found.map(|(index, _)| index).ok_or_else(|| {
        let mut known: Vec<&str> = (scene.instances.iter())
            .flat_map(|i| [i.name.as_str(), mesh_of(i).name.as_str()])
            .collect();
        known.sort_unstable();
        known.dedup();
        unknown("mesh or instance", name, &known)
    })
}

/// All files that may be written.
fn paths(job: &BakeJob, subject: &Subject) -> Vec<PathBuf> {
    match subject {
        Subject::Node(_) => vec![job.output.path.clone()],
        Subject::Material(_) => Role::ALL.map(|role| named(&job.output, role).path).into(),
    }
}

/// `floor.png` to `floor_normal.png`.
fn named(output: &Output, role: Role) -> Output {
    let stem = output
        .path
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    let ending = output.path.extension().unwrap_or_default();
    let name = format!("{stem}_{}.{}", role.name(), ending.to_string_lossy());
    Output {
        path: output.path.with_file_name(name),
        format: output.format,
    }
}

fn write_bytes(output: &Output, size: u32, rgba: &[u8]) -> Result<(), Failure> {
    let path = &output.path;
    let has_all = output::write_texture(output, [size; 2], rgba).map_err(Failure::because)?;
    console::note(&format!("wrote {}", path.display()));
    if !has_all {
        let path = path.display();
        console::warning(&format!("{path} can't hold its fourth channel; write .png"));
    }
    Ok(())
}

fn write_floats(output: &Output, size: u32, rgba: &[[f32; 4]]) -> Result<(), Failure> {
    let path: &Path = &output.path;
    let written = aside::replace(path, |file| write_exr(file, size, rgba));
    written
        .map_err(|error| Failure::Failed(format!("cannot write {}: {error}", path.display())))?;
    console::note(&format!("wrote {}", path.display()));
    Ok(())
}

impl From<BakeError> for Failure {
    fn from(error: BakeError) -> Self {
        match error {
            BakeError::Interrupted => Self::Interrupted,
            BakeError::Evaluate(error) => error.into(),
            error => Self::because(error),
        }
    }
}
