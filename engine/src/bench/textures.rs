//! What procedural textures cost: the same picture with plain grey, rust and scratches on a model, with the texture kernel
//! in its own form and in the inlined one, in turn. The comparison of the paper ("Restricted Extensions for GPU
//! Photo-realistic Renderer", Sanzharov, Frolov et al., 2019, table 1): time over plain grey of the same form.

use std::time::Instant;

use serde::Serialize;
use texgen::{Diagnostics, TextureType, Value, did_you_mean};

use device::Device;

use crate::{
    procedural::{SourcesError, TextureSources},
    renderer::{ReloadError, RenderEditError, RenderError, RenderSettings},
    scene::{Scene, look::LookError},
};

pub use super::in_turn::Absent;
use super::in_turn::{self, Case, SIGMAS};
use super::{
    forms::{Form, FormRenderer},
    inspect::Inspection,
    kernel,
    render::Spread,
};

/// Name of the material that is textured in the built-in scene.
pub const MODEL: &str = "model";

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum TextureBenchError {
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// An edit was refused.
    #[error(transparent)]
    Edit(#[from] RenderEditError),
    /// A source edit was refused.
    #[error(transparent)]
    Reload(#[from] ReloadError),
    /// The standard textures are missing or changed so that they don't fit.
    #[error("{0}")]
    Textures(Box<Diagnostics>),
    /// They can't be read.
    #[error(transparent)]
    Sources(#[from] SourcesError),
    /// There are none to fill a kernel with.
    #[error(transparent)]
    Kernel(#[from] kernel::KernelBenchError),
    /// The look that is made of them.
    #[error(transparent)]
    Look(#[from] LookError),
    /// There is no material of that name to be textured.
    #[error("the scene has no material `{name}`: {remedy}")]
    NoMaterial {
        /// As asked for.
        name: String,
        /// What there is.
        remedy: String,
    },
    /// The forms don't give the same picture, so their times mean nothing.
    #[error(
        "the {form} form shows another picture of {texture} than the stack form: {percent:.2} % of the pixels differ by \
         more than {SIGMAS} standard errors"
    )]
    Differs {
        /// Name of the form.
        form: &'static str,
        /// Name of the texture.
        texture: &'static str,
        /// Of the pixels.
        percent: f64,
    },
}

impl From<Diagnostics> for TextureBenchError {
    fn from(problems: Diagnostics) -> Self {
        Self::Textures(Box::new(problems))
    }
}

/// What is put on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Texture {
    Gray,
    Rust,
    Scratches,
}

impl Texture {
    const ALL: [Self; 3] = [Self::Gray, Self::Rust, Self::Scratches];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Gray => "gray",
            Self::Rust => "rust",
            Self::Scratches => "scratches",
        }
    }

    /// A node and its parameter that an edit changes.
    fn edited(self) -> Option<(&'static str, &'static str, f32)> {
        match self {
            Self::Gray => None,
            Self::Rust => Some(("rust_mask", "amount", 0.3)),
            Self::Scratches => Some(("scratches", "amount", 0.6)),
        }
    }

    /// Whether it reads ambient occlusion, so that the number of rays matters.
    fn reads_ao(self) -> bool {
        self == Self::Rust
    }

    /// The look that puts it on a material: the paper's graphs. Rust is gray blended with rust by a mask of noise and
    /// ambient occlusion; scratches brighten gray.
    pub(super) fn look(self, material: &str, ao_rays: u32) -> String {
        let head = format!("[ao.crevices]\ndistance = 0.25\nsamples = {ao_rays}\n");
        // Quoted as a TOML string.
        let table = format!("[material.{material:?}]\n");
        let surface = "metallic = 0.0\nroughness = 0.8\n";
        match self {
            Self::Gray => format!("{table}base_color = [0.5, 0.5, 0.5]\n{surface}"),
            Self::Rust => format!(
                "{head}[node.rust]\ntexture = \"rust_color\"\nscale = 7.0\n\
                 [node.rust_mask]\ntexture = \"rust_mask\"\nscale = 2.2\namount = 0.42\nocclusion = \"crevices\"\n\
                 [node.rusty]\ntexture = \"mix_color\"\na = [0.5, 0.5, 0.5, 1.0]\nb = \"rust\"\nfactor = \"rust_mask\"\n\
                 {table}base_color = \"rusty\"\n{surface}"
            ),
            Self::Scratches => format!(
                "[node.scratches]\ntexture = \"scratches\"\nscale = 6.0\namount = 0.8\n\
                 [node.scratched]\ntexture = \"mix_color\"\na = [0.5, 0.5, 0.5, 1.0]\nb = [0.8, 0.8, 0.8, 1.0]\n\
                 factor = \"scratches\"\n{table}base_color = \"scratched\"\n{surface}"
            ),
        }
    }
}

/// What is rendered, and how often.
#[derive(Debug)]
pub struct Setup<'a> {
    /// With a material to be textured and no look on it yet.
    pub scene: &'a Scene,
    /// That material.
    pub material: &'a str,
    /// The standard textures.
    pub sources: &'a TextureSources,
    /// Size, depth, camera.
    pub settings: RenderSettings,
    /// Samples per pixel of a run.
    pub spp: u32,
    /// Timed runs of each case, in turn.
    pub runs: u32,
    /// Rays of ambient occlusion at a hit: a row of each texture for each number. At least one.
    pub ao_rays: &'a [u32],
    /// Which forms are compared.
    pub forms: &'a [Form],
    /// The driver that is asked about kernels: see [`Inspection::new`].
    pub statistics_device: Option<&'a str>,
}

/// A row of the comparison.
#[derive(Debug, Clone, Serialize)]
pub struct TextureResult {
    /// `stack`, `inlined` or `rayquery`.
    pub mode: &'static str,
    /// `gray`, `rust` or `scratches`.
    pub texture: &'static str,
    /// Rays of ambient occlusion at a hit.
    pub ao_rays: u32,
    /// Wall time of a sample of all pixels.
    #[serde(flatten, serialize_with = "in_turn::flat_ms_per_spp")]
    pub ms_per_spp: Spread,
    /// Percent more than gray of the same form takes, run by run.
    #[serde(flatten, serialize_with = "in_turn::flat_increase")]
    pub increase: Spread,
    /// Private memory of a thread of the kernel that has the textures in it: see [`FormRenderer::private_bytes`].
    pub private_bytes: u32,
    /// Registers of a thread of that kernel, where the driver tells.
    pub registers: Option<f64>,
    /// Bytes of memory of such a thread beside registers, where the driver tells.
    pub stack_bytes: Option<f64>,
    /// What did not fit into registers, as the driver counts it.
    pub spills: Option<f64>,
    /// From changed source to the first image, with a kernel that no cache knows, less a usual image.
    pub build_ms_cold: f64,
    /// The same with one that was built before.
    pub build_ms_warm: f64,
    /// From the edit of a parameter to the first image that shows it.
    pub edit_ms: f64,
    /// From changed source to the first image that shows it.
    pub source_edit_ms: f64,
    /// Pipelines that the edit of a parameter created.
    pub pipelines_created: u64,
    /// The picture of the last run: linear Rec.709, row 0 on top, as large as the settings say.
    #[serde(skip)]
    pub picture: Vec<[f32; 3]>,
}

/// All rows of [`compare`].
#[derive(Debug, Clone)]
pub struct Comparison {
    /// By number of AO rays, form and texture. Rows of textures that read no AO are the same for every number.
    pub results: Vec<TextureResult>,
    /// Forms without rows.
    pub absent: Vec<Absent>,
    /// Whose driver told registers and stack.
    pub statistics_device: Option<String>,
    /// Why nothing is known of them, if that is so.
    pub statistics_absent: Option<String>,
}

/// A texture that is measured in one form.
struct Subject {
    texture: Texture,
    ao_rays: u32,
    case: Case,
}

impl Subject {
    /// Of gray and of textures without AO there is one for all numbers of rays.
    fn all(ao_rays: &[u32]) -> impl Iterator<Item = (Texture, u32)> {
        let each = move |texture: Texture| {
            let numbers = if texture.reads_ao() {
                ao_rays
            } else {
                &ao_rays[..1]
            };
            numbers.iter().map(move |&number| (texture, number))
        };
        Texture::ALL.into_iter().flat_map(each)
    }

    fn shows(&self, form: Form, texture: Texture, ao_rays: u32) -> bool {
        let same_rays = !texture.reads_ao() || self.ao_rays == ao_rays;
        self.case.form == form && self.texture == texture && same_rays
    }
}

/// Measures all cases, after one run of each that isn't counted. `progress` hears of each render.
///
/// # Errors
/// The device; textures that don't fit; forms that show different pictures.
pub fn compare(
    gpu: &Device,
    setup: &Setup<'_>,
    mut progress: impl FnMut(),
) -> Result<Comparison, TextureBenchError> {
    setup.check()?;
    let (mut subjects, absent) = in_turn::of_each_form(setup.forms, |form| {
        let subject = |(texture, ao_rays): (Texture, u32)| {
            let look = texture.look(setup.material, ao_rays);
            Ok(Subject {
                texture,
                ao_rays,
                case: setup.case(gpu, &look, form)?,
            })
        };
        Subject::all(setup.ao_rays).map(subject).collect()
    })?;
    let mut cases: Vec<&mut Case> = subjects.iter_mut().map(|s| &mut s.case).collect();
    in_turn::run(&mut cases, setup.spp, setup.runs, &mut progress)?;
    same_pictures(&subjects)?;
    let inspection = Inspection::new(gpu, setup.statistics_device);
    let mut measured = Vec::new();
    let mut gray = Vec::new();
    for subject in &mut subjects {
        // The first one of each form.
        if subject.texture == Texture::Gray {
            gray.clone_from(&subject.case.times);
        }
        measured.push(result(gpu, setup, subject, &gray, &inspection)?);
        progress();
    }
    let mut results = Vec::new();
    for &ao_rays in setup.ao_rays {
        for &form in setup.forms {
            for texture in Texture::ALL {
                let rows = subjects.iter().zip(&measured);
                let mut rows = rows.filter(|(subject, _)| subject.shows(form, texture, ao_rays));
                results.extend(rows.next().map(|(_, row)| TextureResult {
                    ao_rays,
                    ..row.clone()
                }));
            }
        }
    }
    Ok(Comparison {
        results,
        absent,
        statistics_device: inspection.device().map(str::to_owned),
        statistics_absent: inspection.absent().map(str::to_owned),
    })
}

/// Renders of [`compare`] and edits, for a progress bar.
pub fn steps(setup: &Setup<'_>) -> u64 {
    let subjects = setup.forms.len() * Subject::all(setup.ao_rays).count();
    subjects as u64 * (u64::from(setup.runs) + 2)
}

impl Setup<'_> {
    /// # Errors
    /// The material is missing.
    pub(super) fn check(&self) -> Result<(), TextureBenchError> {
        let names = || self.scene.materials.iter().map(|m| m.name.as_str());
        if names().any(|name| name == self.material) {
            return Ok(());
        }
        let remedy = match did_you_mean(self.material, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("it has {}", names().take(20).collect::<Vec<_>>().join(", ")),
        };
        let name = self.material.to_owned();
        Err(TextureBenchError::NoMaterial { name, remedy })
    }

    fn case(&self, gpu: &Device, look: &str, form: Form) -> Result<Case, TextureBenchError> {
        Case::new(gpu, self.scene, look, self.sources, &self.settings, form)
    }
}

fn result(
    gpu: &Device,
    setup: &Setup<'_>,
    subject: &mut Subject,
    gray: &[f64],
    inspection: &Inspection,
) -> Result<TextureResult, TextureBenchError> {
    let texture = subject.texture;
    let case = &mut subject.case;
    let picture = case.renderer.film()?.mean();
    let private_bytes = case.renderer.private_bytes();
    let said = inspection.of(&case.renderer);
    let usual = image(&mut case.renderer)?;
    let (mut edit_ms, mut pipelines_created, mut builds) = (0.0, 0, [0.0; 3]);
    if let Some((node, parameter, value)) = texture.edited() {
        let before = gpu.counts().pipelines;
        let start = Instant::now();
        // A number that no cache has seen, in case it is pasted into a kernel.
        let value = value + (kernel::fresh_number() % 0xffff) as f32 * 1e-6;
        case.renderer
            .edit_graph(|graph| graph.set_value(node, parameter, Value::F32(value)))?;
        first_image(&mut case.renderer)?;
        edit_ms = start.elapsed().as_secs_f64() * 1e3;
        pipelines_created = gpu.counts().pipelines - before;
        // A source that nobody has seen, another one, and the first again. Nodes are named after their textures.
        let library = std::sync::Arc::clone(case.renderer.procedural().graph().library());
        if let Some(texture) = library.textures().iter().find(|t| t.name() == node) {
            let fresh = kernel::fresh_number();
            for (build, number) in builds.iter_mut().zip([fresh, fresh + 1, fresh]) {
                *build = rebuild(&mut case.renderer, texture, number)?;
            }
        }
    }
    let less_usual = |ms: f64| if ms > 0.0 { (ms - usual).max(0.0) } else { 0.0 };
    Ok(TextureResult {
        mode: case.form.name(),
        texture: texture.name(),
        ao_rays: subject.ao_rays,
        ms_per_spp: in_turn::ms_per_spp(&case.times, setup.spp),
        increase: in_turn::increase(&case.times, gray),
        private_bytes,
        registers: said.registers,
        stack_bytes: said.stack_bytes,
        spills: said.spills,
        build_ms_cold: less_usual(builds[0]),
        build_ms_warm: less_usual(builds[2]),
        edit_ms,
        source_edit_ms: builds[0],
        pipelines_created,
        picture,
    })
}

/// Milliseconds of one sample of all pixels, once everything is compiled.
fn image(renderer: &mut FormRenderer) -> Result<f64, RenderError> {
    renderer.restart()?;
    let start = Instant::now();
    first_image(renderer)?;
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

fn first_image(renderer: &mut FormRenderer) -> Result<(), RenderError> {
    renderer.render(1)
}

/// Milliseconds from a changed source of the texture to the first image.
fn rebuild(
    renderer: &mut FormRenderer,
    texture: &TextureType,
    number: u64,
) -> Result<f64, TextureBenchError> {
    let file = kernel::variant(texture, texture.name(), number);
    let start = Instant::now();
    renderer.reload(vec![file])?;
    first_image(renderer)?;
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

/// All forms must show what the first one shows.
fn same_pictures(subjects: &[Subject]) -> Result<(), TextureBenchError> {
    let Some(first_form) = subjects.first().map(|first| first.case.form) else {
        return Ok(());
    };
    for subject in subjects.iter().filter(|s| s.case.form != first_form) {
        let mut firsts = subjects.iter();
        let first = firsts.find(|s| s.shows(first_form, subject.texture, subject.ao_rays));
        if let Some(first) = first {
            let film = first.case.renderer.film()?;
            in_turn::same_picture(&film, &subject.case, subject.texture.name())?;
        }
    }
    Ok(())
}
