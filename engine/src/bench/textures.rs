//! What procedural textures cost: the same picture with plain gray, rust and scratches on a model, in each of several
//! forms in turn. The comparison of the paper ("Restricted Extensions for GPU
//! Photo-realistic Renderer", Sanzharov, Frolov et al., 2019, table 1): time over plain gray of the same form.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use texgen::{Diagnostics, TextureType, Value};

use crate::{
    film::Film,
    gpu::Gpu,
    procedural::{Procedural, TextureSources},
    renderer::{ReloadError, RenderEditError, RenderError, RenderSettings},
    scene::{
        Scene,
        look::{Look, LookError},
    },
};

use super::{
    forms::{Form, FormRenderer},
    inspect::Inspection,
    kernel,
    render::Spread,
};

/// Name of the material that is textured in the built-in scene.
pub const MODEL: &str = "model";
/// Standard errors that two pictures of one pixel may differ by, and the share of the pixels that may differ by more.
const SIGMAS: f32 = 3.5;
const OUTLIERS: f64 = 0.005;

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
    /// The look that is made of them.
    #[error(transparent)]
    Look(#[from] LookError),
    /// There is no material of that name to be textured.
    #[error("the scene has no material `{0}`")]
    NoMaterial(String),
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
enum Texture {
    Gray,
    Rust,
    Scratches,
}

impl Texture {
    const ALL: [Self; 3] = [Self::Gray, Self::Rust, Self::Scratches];

    fn name(self) -> &'static str {
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

    /// The look that puts it on a material: the paper's graphs. Rust is gray blended with rust by a mask of noise and
    /// ambient occlusion; scratches brighten gray.
    fn look(self, material: &str, ao_rays: u32) -> String {
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
    /// Rays of ambient occlusion at a hit.
    pub ao_rays: u32,
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
    pub ms_per_spp: Spread,
    /// More than gray of the same form takes, of run by run.
    pub increase_percent: Spread,
    /// Highest less lowest of these.
    pub increase_spread: f64,
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
}

struct Case {
    form: Form,
    texture: Texture,
    renderer: FormRenderer,
    times: Vec<f64>,
}

/// Measures all cases, after one run of each that isn't counted. `progress` hears of each render.
///
/// # Errors
/// The device; textures that don't fit; forms that show different pictures.
pub fn compare(
    gpu: &Gpu,
    setup: &Setup<'_>,
    mut progress: impl FnMut(),
) -> Result<Vec<TextureResult>, TextureBenchError> {
    if !setup
        .scene
        .materials
        .iter()
        .any(|m| m.name == setup.material)
    {
        return Err(TextureBenchError::NoMaterial(setup.material.to_owned()));
    }
    let mut cases = Vec::new();
    for &form in setup.forms {
        for texture in Texture::ALL {
            cases.push(Case {
                form,
                texture,
                renderer: renderer(gpu, setup, form, texture)?,
                times: Vec::new(),
            });
        }
    }
    for run in 0..=setup.runs {
        for case in &mut cases {
            case.renderer.restart();
            let start = Instant::now();
            case.renderer.render(setup.spp)?;
            if run > 0 {
                case.times.push(start.elapsed().as_secs_f64());
            }
            progress();
        }
    }
    same_pictures(&cases)?;
    let inspection = Inspection::new(gpu, setup.statistics_device);
    let mut results = Vec::new();
    for at in 0..cases.len() {
        let gray = cases[at - at % Texture::ALL.len()].times.clone();
        results.push(result(gpu, setup, &mut cases[at], &gray, &inspection)?);
        progress();
    }
    Ok(results)
}

/// Renders of [`compare`] and edits, for a progress bar.
pub fn steps(setup: &Setup<'_>) -> u64 {
    (setup.forms.len() * Texture::ALL.len()) as u64 * (u64::from(setup.runs) + 2)
}

fn renderer(
    gpu: &Gpu,
    setup: &Setup<'_>,
    form: Form,
    texture: Texture,
) -> Result<FormRenderer, TextureBenchError> {
    let mut scene = setup.scene.clone();
    let look = texture.look(setup.material, setup.ao_rays);
    let look = Look::parse(Path::new("bench.look.toml"), &look)?;
    let procedural =
        Procedural::build(&look, &mut scene, setup.sources).map_err(LookError::from)?;
    Ok(FormRenderer::new(
        gpu,
        &scene,
        &procedural,
        &setup.settings,
        form,
    )?)
}

fn result(
    gpu: &Gpu,
    setup: &Setup<'_>,
    case: &mut Case,
    gray: &[f64],
    inspection: &Inspection,
) -> Result<TextureResult, TextureBenchError> {
    let increases = case
        .times
        .iter()
        .zip(gray)
        .map(|(t, g)| (t / g - 1.0) * 100.0);
    let increase_percent = Spread::of(increases);
    let private_bytes = case.renderer.private_bytes();
    let said = inspection.of(&case.renderer);
    let usual = image(&mut case.renderer)?;
    let (mut edit_ms, mut pipelines_created, mut builds) = (0.0, 0, [0.0; 3]);
    if let Some((node, parameter, value)) = case.texture.edited() {
        let before = gpu.pipelines_created();
        let start = Instant::now();
        // A number that no cache has seen, in case it is pasted into a kernel.
        let value = value + (kernel::fresh_number() % 0xffff) as f32 * 1e-6;
        case.renderer
            .set_argument(node, parameter, Value::F32(value))?;
        first_image(&mut case.renderer)?;
        edit_ms = start.elapsed().as_secs_f64() * 1e3;
        pipelines_created = gpu.pipelines_created() - before;
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
        texture: case.texture.name(),
        ao_rays: setup.ao_rays,
        ms_per_spp: Spread::of(case.times.iter().map(|s| s * 1e3 / f64::from(setup.spp))),
        increase_spread: increase_percent.high - increase_percent.low,
        increase_percent,
        private_bytes,
        registers: said.registers,
        stack_bytes: said.stack_bytes,
        spills: said.spills,
        build_ms_cold: less_usual(builds[0]),
        build_ms_warm: less_usual(builds[2]),
        edit_ms,
        source_edit_ms: builds[0],
        pipelines_created,
    })
}

/// Milliseconds of one sample of all pixels, once everything is compiled.
fn image(renderer: &mut FormRenderer) -> Result<f64, RenderError> {
    renderer.restart();
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
fn same_pictures(cases: &[Case]) -> Result<(), TextureBenchError> {
    let textures = Texture::ALL.len();
    for (at, case) in cases.iter().enumerate().skip(textures) {
        let first = cases[at % textures].renderer.film()?;
        let share = outliers(&first, &case.renderer.film()?);
        if share > OUTLIERS {
            return Err(TextureBenchError::Differs {
                form: case.form.name(),
                texture: case.texture.name(),
                percent: share * 100.0,
            });
        }
    }
    Ok(())
}

/// Share of the pixels and channels whose means differ by more than [`SIGMAS`] standard errors of their difference.
fn outliers(a: &Film, b: &Film) -> f64 {
    let errors = a.standard_error().into_iter().zip(b.standard_error());
    let means = a.mean().into_iter().zip(b.mean());
    let (mut outside, mut all) = (0_u64, 0_u64);
    for ((ma, mb), (ea, eb)) in means.zip(errors) {
        for c in 0..3 {
            let error = ea[c].hypot(eb[c]) + 1e-4 * ma[c].abs();
            all += 1;
            outside += u64::from((ma[c] - mb[c]).abs() > SIGMAS * error);
        }
    }
    outside as f64 / all.max(1) as f64
}
