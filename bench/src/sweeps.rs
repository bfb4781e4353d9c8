//! One thing is changed and everything else kept: how the cost of textures over plain grey grows with the length of a
//! program, with the textures of a scene, with rays of ambient occlusion, with the share of the picture and with the
//! length of paths. Each point is measured like a row of the main table: its gray, and a textured case in each form, in
//! turn.

use std::fmt::Write as _;

use serde::Serialize;

use device::Device;

use engine::{
    procedural::TextureSources,
    renderer::RenderSettings,
    scene::{Material, Scene},
};

use crate::{
    coverage,
    error::TextureBenchError,
    forms::Form,
    graphs::Texture,
    in_turn::{self, Absent, Case},
    kernel::{self, MOST_RUN_ON_CPU},
    spread::{self, Spread},
    textures::Setup,
};

/// What is changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sweep {
    /// Nodes of the material's program.
    Nodes,
    /// Different textures in the kernel; the material uses one of them.
    Textures,
    /// Rays of ambient occlusion at a hit.
    Ao,
    /// Share of the picture that the material covers.
    Coverage,
    /// Most surfaces that scatter light along a path.
    Bounces,
}

impl Sweep {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Nodes,
        Self::Textures,
        Self::Ao,
        Self::Coverage,
        Self::Bounces,
    ];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Textures => "textures",
            Self::Ao => "ao",
            Self::Coverage => "coverage",
            Self::Bounces => "bounces",
        }
    }

    /// What its values are.
    pub fn label(self) -> &'static str {
        match self {
            Self::Nodes => "nodes of the program",
            Self::Textures => "different textures in the kernel",
            Self::Ao => "AO rays per hit",
            Self::Coverage => "share of the picture covered, percent",
            Self::Bounces => "most scattering points of a path",
        }
    }

    /// What lies on the model.
    fn subject(self) -> &'static str {
        match self {
            Self::Nodes => "a chain of noises and mixes",
            Self::Textures => "one noise",
            Self::Ao | Self::Coverage | Self::Bounces => "rust",
        }
    }

    /// What is set one after the other. For the coverage, how high the model is in the picture.
    fn settings(self) -> &'static [f32] {
        match self {
            Self::Nodes => &[1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0],
            Self::Textures => &[1.0, 3.0, 10.0, 30.0, 100.0],
            Self::Ao => &[0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0],
            Self::Coverage => &[0.25, 0.5, 1.0, 2.0, 4.0],
            Self::Bounces => &[1.0, 2.0, 4.0, 8.0, 16.0],
        }
    }

    /// Whether gray is another picture at each value.
    fn changes_gray(self) -> bool {
        matches!(self, Self::Coverage | Self::Bounces)
    }
}

/// One form at one value.
#[derive(Debug, Clone, Serialize)]
pub struct SweepPoint {
    /// What was changed; percent for the coverage.
    pub value: f64,
    /// Name of the form.
    pub mode: &'static str,
    /// Wall time of a sample of all pixels.
    #[serde(flatten, serialize_with = "spread::flat_ms_per_spp")]
    pub ms_per_spp: Spread,
    /// That of plain grey beside it.
    #[serde(flatten, serialize_with = "spread::flat_gray")]
    pub gray_ms_per_spp: Spread,
    /// Percent more than gray of the same form takes, run by run.
    #[serde(flatten, serialize_with = "spread::flat_increase")]
    pub increase: Spread,
}

/// A value that was left out.
#[derive(Debug, Clone, Serialize)]
pub struct LeftOut {
    /// The value.
    pub value: f64,
    /// What it is, where it isn't what points have: `zoom` of the coverage, whose share isn't known then. 1 is a model as high as the
    /// picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setting: Option<&'static str>,
    /// Why.
    pub reason: String,
}

/// What was found by changing one thing.
#[derive(Debug, Clone, Serialize)]
pub struct SweepReport {
    /// [`Sweep::name`].
    pub sweep: &'static str,
    /// [`Sweep::label`].
    pub label: &'static str,
    /// What lay on the model.
    pub texture: &'static str,
    /// By value and form.
    pub points: Vec<SweepPoint>,
    /// Values without points.
    pub left_out: Vec<LeftOut>,
    /// Forms without points.
    pub absent: Vec<Absent>,
    /// Why there are no points of further values, if that is so: [`INTERRUPTED`], or what failed.
    pub ended: Option<String>,
}

/// What values of the coverage are that are left out.
const ZOOM: &str = "zoom";

/// Why a sweep has ended that was told to.
pub const INTERRUPTED: &str = "interrupted";

/// Measures one sweep; rust has the first number of AO rays of the setup. `progress` hears of each render. What fails, as
/// [`crate::textures::compare`] may, ends it: the points before stay.
pub fn sweep(
    device: &Device,
    setup: &Setup<'_>,
    what: Sweep,
    mut progress: impl FnMut(),
) -> SweepReport {
    let mut report = SweepReport {
        sweep: what.name(),
        label: what.label(),
        texture: what.subject(),
        points: Vec::new(),
        left_out: Vec::new(),
        absent: Vec::new(),
        ended: None,
    };
    report.ended = match points(device, setup, what, &mut report, &mut progress) {
        Ok(true) => None,
        Ok(false) => Some(INTERRUPTED.to_owned()),
        Err(error) => Some(error.to_string()),
    };
    report
}

/// Measures the points of a sweep; false where it is ended before the last one.
fn points(
    device: &Device,
    setup: &Setup<'_>,
    what: Sweep,
    report: &mut SweepReport,
    progress: &mut dyn FnMut(),
) -> Result<bool, TextureBenchError> {
    setup.check()?;
    let mut grays = Vec::new();
    for &setting in what.settings() {
        if (setup.is_over)() {
            return Ok(false);
        }
        let step = match Step::new(device, setup, what, setting)? {
            Ok(step) => step,
            Err(left_out) => {
                report.left_out.push(left_out);
                continue;
            }
        };
        if grays.is_empty() || what.changes_gray() {
            let gray = Texture::Gray.look(setup.material, 1);
            (grays, report.absent) = in_turn::of_each_form(setup.forms, |form| {
                let sources = setup.sources;
                let gray = Case::new(device, setup.scene, &gray, sources, &step.settings, form)?;
                Ok(vec![gray])
            })?;
        }
        let made: Result<Vec<Case>, _> = (grays.iter())
            .map(|gray: &Case| step.case(device, gray.form))
            .collect();
        let mut textured = made?;
        // Each beside its gray.
        let pairs = grays.iter_mut().zip(&mut textured);
        let mut cases: Vec<&mut Case> = pairs.flat_map(|(gray, case)| [gray, case]).collect();
        if !in_turn::run(&mut cases, setup.spp, setup.runs, setup.is_over, progress)? {
            return Ok(false);
        }
        if let Some((first, others)) = textured.split_first() {
            let film = first.renderer.film()?;
            for case in others {
                in_turn::same_picture(&film, case, what.subject())?;
            }
        }
        for (gray, case) in grays.iter().zip(&textured) {
            report.points.push(SweepPoint {
                value: step.value,
                mode: case.form.name(),
                ms_per_spp: in_turn::ms_per_spp(&case.times, setup.spp),
                gray_ms_per_spp: in_turn::ms_per_spp(&gray.times, setup.spp),
                increase: in_turn::increase(&case.times, &gray.times),
            });
        }
    }
    Ok(true)
}

/// Most renders of [`sweep`], for a progress bar.
pub fn steps(setup: &Setup<'_>, what: Sweep) -> u64 {
    let cases = 2 * setup.forms.len() * what.settings().len();
    cases as u64 * (u64::from(setup.runs) + 1)
}

/// What is rendered at one value.
struct Step {
    value: f64,
    scene: Scene,
    look: String,
    sources: TextureSources,
    settings: RenderSettings,
}

impl Step {
    /// The inner error is the reason why this value can't be measured here, though others can.
    fn new(
        device: &Device,
        setup: &Setup<'_>,
        what: Sweep,
        setting: f32,
    ) -> Result<Result<Self, LeftOut>, TextureBenchError> {
        let number = setting as u32;
        let rays = setup.ao_rays.first().copied().unwrap_or(1);
        let mut step = Self {
            value: f64::from(setting),
            scene: setup.scene.clone(),
            look: Texture::Rust.look(setup.material, rays),
            sources: setup.sources.clone(),
            settings: setup.settings.clone(),
        };
        let left_out = |value: f64, reason: &str| {
            Ok(Err(LeftOut {
                value,
                setting: (what == Sweep::Coverage).then_some(ZOOM),
                reason: reason.to_owned(),
            }))
        };
        match what {
            Sweep::Nodes => step.look = chain(setup.material, number),
            Sweep::Textures => {
                if device.traits().compiles_slowly && number as usize > MOST_RUN_ON_CPU {
                    let reason = "a software driver compiles a kernel of so many textures for minutes or longer";
                    return left_out(step.value, reason);
                }
                step.look = chain(setup.material, 1);
                step.add_textures(number as usize - 1)?;
            }
            Sweep::Ao if number == 0 => {
                if !step.without_ao()? {
                    return left_out(0.0, "`rust_mask` doesn't read AO as expected");
                }
            }
            Sweep::Ao => step.look = Texture::Rust.look(setup.material, number),
            Sweep::Bounces => step.settings.max_depth = number,
            Sweep::Coverage => {
                let camera = &setup.settings.camera;
                match coverage::framing(setup.scene, setup.material, camera, setting) {
                    Some(camera) => step.settings.camera = camera,
                    None => return left_out(step.value, "the camera can't be turned to the model"),
                }
                let share = coverage::measure(device, setup.scene, setup.material, &step.settings)?;
                step.value = share * 100.0;
            }
        }
        Ok(Ok(step))
    }

    fn case(&self, device: &Device, form: Form) -> Result<Case, TextureBenchError> {
        Case::new(
            device,
            &self.scene,
            &self.look,
            &self.sources,
            &self.settings,
            form,
        )
    }

    /// So many further textures in the kernel, on materials that nothing in the scene is made of.
    fn add_textures(&mut self, count: usize) -> Result<(), TextureBenchError> {
        let originals = kernel::originals(&self.sources)?;
        for (number, texture) in originals.iter().cycle().take(count).enumerate() {
            let name = format!("swept{number:03}");
            let file = kernel::variant(texture, &name, number as u64);
            self.sources.insert(&name, file.text());
            let _ = write!(
                self.look,
                "[node.{name}]\ntexture = \"{name}\"\n[material.{name}]\nmetallic = \"{name}.x\"\n"
            );
            self.scene.materials.push(Material {
                name,
                ..Material::default()
            });
        }
        Ok(())
    }

    /// The mask's own text with a constant where it read ambient occlusion; whether it did.
    fn without_ao(&mut self) -> Result<bool, TextureBenchError> {
        const READ: &str = "readAttr(AO)";
        let Some(mask) = self.sources.read("rust_mask") else {
            return Ok(false);
        };
        let mask = mask?;
        if !mask.text().contains(READ) {
            return Ok(false);
        }
        let open = mask.text().replace(READ, "vec4f(1.0)");
        self.sources.insert("rust_mask", &open);
        self.look = self.look.replace("occlusion = \"crevices\"\n", "");
        Ok(true)
    }
}

/// A look with a program of so many nodes: noises, and mixes by the noise before them, each of which changes the contrast
/// of the next noise. The result is about as bright as gray, so that paths are as long.
fn chain(material: &str, nodes: u32) -> String {
    let mut look = String::new();
    for node in 0..nodes {
        // Writing to a string can't fail.
        let _ = match (node % 2, node.checked_sub(1)) {
            (1, Some(before)) => writeln!(
                look,
                "[node.n{node}]\ntexture = \"mix_color\"\na = [0.4, 0.4, 0.4, 1.0]\nb = [0.6, 0.6, 0.6, 1.0]\n\
                 factor = \"n{before}\""
            ),
            (_, before) => {
                let contrast = before.map_or("0.5".to_owned(), |before| format!("\"n{before}.x\""));
                let scale = 2.0 + 0.37 * node as f32;
                writeln!(
                    look,
                    "[node.n{node}]\ntexture = \"fbm\"\nscale = {scale:.2}\noctaves = 3.0\ncontrast = {contrast}"
                )
            }
        };
    }
    let last = nodes.saturating_sub(1);
    let _ = write!(
        look,
        "[material.{material:?}]\nbase_color = \"n{last}\"\nmetallic = 0.0\nroughness = 0.8\n"
    );
    look
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use device::DeviceChoice;
    use texgen::{Attribute, BuiltinAttribute, TextureType};

    use super::*;
    use crate::scenes::{self, MODEL};
    use engine::procedural::Procedural;
    use engine::scene::look::Look;

    fn sources() -> TextureSources {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../user_textures");
        TextureSources::scan(&[folder]).expect("the folder is there")
    }

    fn built(look: &str, mut scene: Scene, sources: &TextureSources) -> Procedural {
        let look = Look::parse(Path::new("bench.look.toml"), look);
        let look = look.unwrap_or_else(|problems| panic!("{problems}"));
        Procedural::build(&look, &mut scene, sources)
            .unwrap_or_else(|problems| panic!("{problems}"))
    }

    fn step(look: String) -> Step {
        let scene = scenes::arcade();
        Step {
            value: 0.0,
            look,
            sources: sources(),
            settings: RenderSettings::new(8, 8, &scene.cameras[0]),
            scene,
        }
    }

    /// What a sweep over bounces by two threads gives.
    fn swept(forms: &[Form], is_over: fn() -> bool, progress: impl FnMut()) -> SweepReport {
        let device = Device::open(&DeviceChoice::Native(2));
        let device = device.unwrap_or_else(|error| panic!("{error}"));
        let (scene, sources) = (scenes::arcade(), sources());
        let setup = Setup {
            scene: &scene,
            material: MODEL,
            sources: &sources,
            settings: RenderSettings::new(8, 8, &scene.cameras[0]),
            spp: 2,
            runs: 1,
            ao_rays: &[1],
            forms,
            statistics_device: None,
            is_over,
        };
        sweep(&device, &setup, Sweep::Bounces, progress)
    }

    #[test]
    fn values_of_the_coverage_that_are_left_out_are_zooms() {
        let device = Device::open(&DeviceChoice::Native(1));
        let device = device.unwrap_or_else(|error| panic!("{error}"));
        let (mut scene, sources) = (scenes::arcade(), sources());
        scene.materials.push(Material {
            name: "unused".to_owned(),
            ..Material::default()
        });
        let setup = Setup {
            scene: &scene,
            material: "unused",
            sources: &sources,
            settings: RenderSettings::new(8, 8, &scene.cameras[0]),
            spp: 2,
            runs: 1,
            ao_rays: &[1],
            forms: &[Form::Stack],
            statistics_device: None,
            is_over: || false,
        };
        let report = sweep(&device, &setup, Sweep::Coverage, || ());
        let left_out = report.left_out.iter();
        let values: Vec<_> = left_out.map(|out| (out.value, out.setting)).collect();
        let expected = [0.25, 0.5, 1.0, 2.0, 4.0].map(|zoom| (zoom, Some("zoom")));
        assert_eq!(values, expected);
    }

    #[test]
    fn what_ends_a_sweep_is_told_beside_the_points_before() {
        let ended = swept(&[Form::Stack], || true, || ());
        assert_eq!(ended.ended.as_deref(), Some(INTERRUPTED));
        assert!(ended.points.is_empty());
        // Not the processor's.
        let failed = swept(&[Form::RayQuery], || false, || ());
        let reason = failed.ended.unwrap_or_default();
        assert!(reason.contains("ray queries"), "{reason}");
        // Gray and rust are rendered twice for each value.
        static RENDERS: AtomicUsize = AtomicUsize::new(0);
        let later = swept(
            &[Form::Stack],
            || RENDERS.load(Ordering::Relaxed) > 4,
            || {
                RENDERS.fetch_add(1, Ordering::Relaxed);
            },
        );
        assert_eq!(later.ended.as_deref(), Some(INTERRUPTED));
        assert_eq!(later.points.len(), 1);
    }

    #[test]
    fn a_chain_has_as_many_nodes_as_wanted() {
        for &nodes in Sweep::Nodes.settings() {
            let nodes = nodes as u32;
            let procedural = built(&chain(MODEL, nodes), scenes::arcade(), &sources());
            assert_eq!(procedural.graph().ids().len() as u32, nodes);
            // Each needs the one before: as few slots as any kernel has.
            assert!(procedural.stack_slots() <= 8);
        }
    }

    #[test]
    fn further_textures_are_in_the_kernel() {
        let mut step = step(chain(MODEL, 1));
        step.add_textures(29).expect("the textures are right");
        let procedural = built(&step.look, step.scene, &step.sources);
        assert_eq!(procedural.graph().library().textures().len(), 30);
    }

    #[test]
    fn rust_without_rays_reads_no_occlusion() {
        let rust = Texture::Rust.look(MODEL, 4);
        let mut step = step(rust.clone());
        assert_eq!(
            built(&rust, step.scene.clone(), &step.sources).ao_count(),
            1
        );
        assert!(step.without_ao().expect("the mask can be read"));
        let procedural = built(&step.look, step.scene, &step.sources);
        let textures = procedural.graph().library();
        let ao = Attribute::from(BuiltinAttribute::AO);
        let reads = |t: &TextureType| t.attributes().contains(&ao);
        assert!(!textures.textures().iter().any(reads), "nothing is traced");
    }
}
