//! What procedural textures cost: the same picture with plain grey, rust and scratches on a model, with the texture kernel
//! in its own form and in the inlined one, in turn. The comparison of the paper ("Restricted Extensions for GPU
//! Photo-realistic Renderer", Sanzharov, Frolov et al., 2019, table 1): time over plain grey of the same form.

use std::time::Instant;

use serde::Serialize;
use texgen::{TextureType, Value, did_you_mean};

use device::Device;

use engine::{
    procedural::TextureSources,
    renderer::{RenderError, RenderSettings, Renderer},
    scene::Scene,
};

use crate::{
    error::TextureBenchError,
    forms::Form,
    graphs::Texture,
    in_turn::{self, Case},
    inspect::{self, Inspection},
    kernel,
    spread::{self, Spread},
};

pub use crate::in_turn::Absent;

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
    /// Asked again and again by [`crate::sweeps::sweep`] whether to end with what there is. [`compare`] has nothing before its end.
    pub is_over: fn() -> bool,
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
    #[serde(flatten, serialize_with = "spread::flat_ms_per_spp")]
    pub ms_per_spp: Spread,
    /// Percent more than gray of the same form takes, run by run.
    #[serde(flatten, serialize_with = "spread::flat_increase")]
    pub increase: Spread,
    /// Private memory of a thread of the kernel that has the textures in it: see
    /// [`inspect::private_bytes`].
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
struct TexturedCase {
    texture: Texture,
    ao_rays: u32,
    case: Case,
}

impl TexturedCase {
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
    device: &Device,
    setup: &Setup<'_>,
    mut progress: impl FnMut(),
) -> Result<Comparison, TextureBenchError> {
    setup.check()?;
    let (mut all, absent) = in_turn::of_each_form(setup.forms, |form| {
        let textured = |(texture, ao_rays): (Texture, u32)| {
            let look = texture.look(setup.material, ao_rays);
            Ok(TexturedCase {
                texture,
                ao_rays,
                case: setup.case(device, &look, form)?,
            })
        };
        TexturedCase::all(setup.ao_rays).map(textured).collect()
    })?;
    let mut cases: Vec<&mut Case> = all.iter_mut().map(|s| &mut s.case).collect();
    in_turn::run(&mut cases, setup.spp, setup.runs, || false, &mut progress)?;
    same_pictures(&all)?;
    let inspection = Inspection::new(device, setup.statistics_device);
    let mut measured = Vec::new();
    let mut gray = Vec::new();
    for textured in &mut all {
        // The first one of each form.
        if textured.texture == Texture::Gray {
            gray.clone_from(&textured.case.times);
        }
        measured.push(result(device, setup, textured, &gray, &inspection)?);
        progress();
    }
    let mut results = Vec::new();
    for &ao_rays in setup.ao_rays {
        for &form in setup.forms {
            for texture in Texture::ALL {
                let rows = all.iter().zip(&measured);
                let mut rows = rows.filter(|(textured, _)| textured.shows(form, texture, ao_rays));
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
    let all = setup.forms.len() * TexturedCase::all(setup.ao_rays).count();
    all as u64 * (u64::from(setup.runs) + 2)
}

impl Setup<'_> {
    /// # Errors
    /// The material is missing.
    pub(crate) fn check(&self) -> Result<(), TextureBenchError> {
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

    fn case(&self, device: &Device, look: &str, form: Form) -> Result<Case, TextureBenchError> {
        Case::new(device, self.scene, look, self.sources, &self.settings, form)
    }
}

fn result(
    device: &Device,
    setup: &Setup<'_>,
    textured: &mut TexturedCase,
    gray: &[f64],
    inspection: &Inspection,
) -> Result<TextureResult, TextureBenchError> {
    let texture = textured.texture;
    let case = &mut textured.case;
    let picture = case.renderer.film()?.mean();
    let private_bytes = inspect::private_bytes(&case.renderer);
    let said = inspection.of(&case.renderer);
    let usual = image(&mut case.renderer)?;
    let (mut edit_ms, mut pipelines_created, mut builds) = (0.0, 0, [0.0; 3]);
    if let Some((node, parameter, value)) = texture.edited() {
        let before = device.counts().pipelines;
        let start = Instant::now();
        // A number that no cache has seen, in case it is pasted into a kernel.
        let value = value + (kernel::fresh_number() % 0xffff) as f32 * 1e-6;
        case.renderer
            .edit_graph(|graph| graph.set_value(node, parameter, Value::F32(value)))?;
        first_image(&mut case.renderer)?;
        edit_ms = start.elapsed().as_secs_f64() * 1e3;
        pipelines_created = device.counts().pipelines - before;
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
        ao_rays: textured.ao_rays,
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
fn image(renderer: &mut Renderer) -> Result<f64, RenderError> {
    renderer.restart();
    let start = Instant::now();
    first_image(renderer)?;
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

fn first_image(renderer: &mut Renderer) -> Result<(), RenderError> {
    renderer.render(1)
}

/// Milliseconds from a changed source of the texture to the first image.
fn rebuild(
    renderer: &mut Renderer,
    texture: &TextureType,
    number: u64,
) -> Result<f64, TextureBenchError> {
    let file = kernel::variant(texture, texture.name(), number);
    let start = Instant::now();
    let reload = renderer.begin_reload(vec![file]);
    renderer.finish_reload(reload)?;
    first_image(renderer)?;
    Ok(start.elapsed().as_secs_f64() * 1e3)
}

/// All forms must show what the first one shows.
fn same_pictures(all: &[TexturedCase]) -> Result<(), TextureBenchError> {
    let Some(first_form) = all.first().map(|first| first.case.form) else {
        return Ok(());
    };
    for textured in all.iter().filter(|s| s.case.form != first_form) {
        let mut firsts = all.iter();
        let first = firsts.find(|s| s.shows(first_form, textured.texture, textured.ao_rays));
        if let Some(first) = first {
            let film = first.case.renderer.film()?;
            in_turn::same_picture(&film, &textured.case, textured.texture.name())?;
        }
    }
    Ok(())
}
