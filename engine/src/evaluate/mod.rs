//! Values of a texture at points of one's choice, without a scene: for tests of textures.
//!
//! The kernel is the one that renders, with another host: attributes and globals come from a list of [`Point`]s
//! instead of hits.
//!
//! ```no_run
//! use engine::evaluate::{Evaluator, Point};
//! use device::{DeviceChoice, Device};
//!
//! // As in a test of a texture with a parameter `scale`.
//! let gpu = Device::best()?;
//! let mut stripes = Evaluator::of_file(&gpu, "user_textures/stripes.wgsl".as_ref())?;
//! stripes.set("scale", "3")?;
//! let points = [0.0, 0.25, 0.5].map(|u| Point::new().with("TexCoord0", &[u, 0.0]));
//! let values = stripes.evaluate(&points)?;
//! assert_eq!(values[0], values[2], "stripes repeat");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod host;
mod point;
mod sites;

use std::path::Path;

use texgen::{Diagnostics, GraphError, LOOP_LIMIT, Library, Link, Value, did_you_mean, link_word};

use device::{Device, DeviceError, Extent, Kernel, Recording, Resources, Trust, Usage};

use crate::gpu_scene::images::GpuImages;
use crate::isolated::{Isolated, Subject};
use crate::passes::wgsl::ComposedWgsl;
use crate::procedural::{EditError, MAX_STACK_SLOTS, Procedural, SourcesError, TextureSources};
use crate::renderer::{compiling, culprit};

pub use point::Point;

use host::Occlusion;

pub(crate) use point::Layout;
pub(crate) use sites::Sites;

/// Points of one dispatch.
const BATCH: usize = 1 << 16;

/// Why there are no values.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// The texture's file can't be read.
    #[error(transparent)]
    Source(#[from] SourcesError),
    /// Mistakes in the texture.
    #[error(transparent)]
    Mistakes(#[from] Diagnostics),
    /// An argument can't be set.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// An image is missing, or the graph is too large.
    #[error(transparent)]
    Graph(Box<GraphError>),
    /// More intermediate results than a thread can hold.
    #[error(
        "{needed} intermediate results are needed at once, and at most {MAX_STACK_SLOTS} are possible"
    )]
    TooManySlots {
        /// How many.
        needed: u32,
    },
    /// A point names something that can't be read.
    #[error("there is no attribute or global called `{name}` to be set{}", hint(.suggestion))]
    UnknownName {
        /// As given.
        name: String,
        /// A name it may have meant.
        suggestion: Option<String>,
    },
    /// Not one to four numbers.
    #[error("`{name}` takes 1 to 4 numbers, not {count}")]
    Components {
        /// The attribute or global.
        name: String,
        /// How many were given.
        count: usize,
    },
    /// A loop doesn't end.
    #[error(
        "the loops of texture `{texture}` took more than {LOOP_LIMIT} steps at one point; look for a loop that doesn't end"
    )]
    Endless {
        /// The texture.
        texture: String,
    },
    /// The device.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

fn hint(suggestion: &Option<String>) -> String {
    suggestion
        .as_ref()
        .map_or(String::new(), |name| format!("; did you mean `{name}`?"))
}

impl From<GraphError> for EvaluateError {
    fn from(error: GraphError) -> Self {
        Self::Graph(Box::new(error))
    }
}

/// Evaluates one texture or node.
#[derive(Debug)]
pub struct Evaluator {
    device: Device,
    isolated: Isolated,
    layout: Layout,
    kernel: Option<Made>,
    /// The kernel is of the former subject.
    is_replaced: bool,
}

/// A kernel with what it was made of.
#[derive(Debug)]
struct Made {
    slots: u32,
    text: String,
    kernel: Kernel,
}

impl Evaluator {
    /// Evaluates `isolated`.
    pub fn new(device: &Device, isolated: Isolated) -> Self {
        let library = isolated.procedural.graph().library();
        Self {
            device: device.clone(),
            layout: Layout::new(library.custom_attributes()),
            isolated,
            kernel: None,
            is_replaced: false,
        }
    }

    /// Evaluates something else from now on. Where only values and links differ, no kernel is made.
    pub fn replace(&mut self, isolated: Isolated) {
        let library = isolated.procedural.graph().library();
        self.layout = Layout::new(library.custom_attributes());
        self.isolated = isolated;
        self.is_replaced = true;
    }

    /// Evaluates the texture in a file, with its default arguments.
    ///
    /// # Errors
    /// The file can't be read; every mistake in it.
    pub fn of_file(device: &Device, path: &Path) -> Result<Self, EvaluateError> {
        let mut sources = TextureSources::default();
        let name = sources.add_file(path)?;
        let isolated = Isolated::new(Subject::Texture(&name), &sources)?;
        Ok(Self::new(device, isolated))
    }

    /// Sets a parameter to what a text says: `3`, `[1, 0.5, 0]`, `#c46a2a`, the path of an image.
    ///
    /// # Errors
    /// Unknown names, a value of another type, an image that can't be read.
    pub fn set(&mut self, parameter: &str, text: &str) -> Result<(), EvaluateError> {
        Ok(self.isolated.set(parameter, text)?)
    }

    /// Sets a parameter to a constant.
    ///
    /// # Errors
    /// Unknown parameter; a value of another type, or not finite.
    pub fn set_value(&mut self, parameter: &str, value: Value) -> Result<(), EvaluateError> {
        Ok(self.isolated.set_value(parameter, value)?)
    }

    /// What is evaluated.
    pub fn isolated(&self) -> &Isolated {
        &self.isolated
    }

    /// The values at some points, in their order: an `f32` fills all components, behind a `vec2f` follow 0 and 1, and
    /// behind a `vec3f` follows 1.
    ///
    /// # Errors
    /// An image parameter is not set, a point names what doesn't exist, a loop doesn't end, or the device fails.
    pub fn evaluate(&mut self, points: &[Point]) -> Result<Vec<[f32; 4]>, EvaluateError> {
        for point in points {
            self.check(point)?;
        }
        let graph = self.isolated.procedural.graph();
        let node = graph.node(&self.isolated.node);
        let node = node.expect("the subject is a node of its own graph");
        let link = Link {
            source: node,
            swizzle: self.isolated.take,
        };
        let program = graph.compile_links(&[link])?;
        let links = [link_word(program.results[0], link.swizzle)];
        if program.slots_needed > MAX_STACK_SLOTS {
            return Err(EvaluateError::TooManySlots {
                needed: program.slots_needed,
            });
        }
        let args = graph.args().to_vec();
        let [first, second] = graph.occlusion(node);
        self.compile(program.slots_needed, (first != second).then_some(second))?;
        let scene = &self.isolated.scene;
        let images = GpuImages::new(&self.device, scene, &self.isolated.procedural.reads())?;
        let mut resources = resources(&self.device, &images, &program.words, &args, &links)?;
        let Made { kernel, .. } = self.kernel.as_ref().expect("it was made before");
        let mut values = Vec::with_capacity(points.len());
        for batch in points.chunks(BATCH) {
            let header = [batch.len() as u32, images.user_base, 1, 0];
            let words = self.layout.words(header, batch);
            let procedural = &self.isolated.procedural;
            values.extend(dispatch(
                &self.device,
                kernel,
                procedural,
                &mut resources,
                &words,
                batch.len(),
            )?);
        }
        Ok(values)
    }

    fn check(&self, point: &Point) -> Result<(), EvaluateError> {
        for (name, components) in point.values() {
            if !self.layout.has(name) {
                let suggestion = did_you_mean(name, self.layout.names()).map(str::to_owned);
                return Err(EvaluateError::UnknownName {
                    name: name.to_owned(),
                    suggestion,
                });
            }
            if !(1..=4).contains(&components.len()) {
                return Err(EvaluateError::Components {
                    name: name.to_owned(),
                    count: components.len(),
                });
            }
        }
        Ok(())
    }

    /// Makes the kernel, unless there is one with enough slots.
    fn compile(&mut self, slots: u32, second_occlusion: Option<u32>) -> Result<(), EvaluateError> {
        let has = self.kernel.as_ref().map_or(0, |made| made.slots);
        if has >= slots && !self.is_replaced {
            return Ok(());
        }
        let slots = slots.max(has);
        let library = self.isolated.procedural.graph().library();
        let occlusion = Occlusion::Named(second_occlusion);
        let source = host::source(&self.layout, occlusion, &library.emit(slots));
        let is_same = |made: &Made| made.text == source.text;
        if !self.kernel.as_ref().is_some_and(is_same) {
            let kernel = compiled(&self.device, library, &self.layout, occlusion, &source)?;
            self.kernel = Some(Made {
                slots,
                text: source.text,
                kernel,
            });
        }
        self.is_replaced = false;
        Ok(())
    }
}

/// A kernel of this text; the error names the texture that is at fault.
fn compiled(
    device: &Device,
    library: &Library,
    layout: &Layout,
    occlusion: Occlusion,
    source: &ComposedWgsl,
) -> Result<Kernel, DeviceError> {
    let kernel = |source: &ComposedWgsl| source.compile(device, "evaluate", Trust::Nothing, &[]);
    kernel(source).map_err(|error| {
        culprit::named(error, library, |alone| {
            let source = host::source(layout, occlusion, &alone.emit(1));
            kernel(&source).map(|_| ())
        })
    })
}

/// What a kernel reads besides the points: images, a program, the constants, and where the wanted results lie.
fn resources(
    device: &Device,
    images: &GpuImages,
    program: &[u32],
    args: &[u32],
    links: &[u32],
) -> Result<Resources, DeviceError> {
    let mut resources = Resources::default();
    resources.set_image("image_table", images.table.clone());
    resources.set_image("image_layers", images.layers.clone());
    resources.set_image("image_layers_srgb", images.layers_srgb.clone());
    for (name, words) in [("programs", program), ("args", args), ("links", links)] {
        let buffer = device.filled_buffer(name, Usage::Storage, bytemuck::cast_slice(words))?;
        resources.set_buffer(name, buffer);
    }
    Ok(resources)
}

/// The results at some points, whose words begin with their header; `count` of them.
fn dispatch(
    device: &Device,
    kernel: &Kernel,
    procedural: &Procedural,
    resources: &mut Resources,
    points: &[[u32; 4]],
    count: usize,
) -> Result<Vec<[f32; 4]>, EvaluateError> {
    let [threads, _, results, _] = points[0];
    let bytes = 16 * count as u64 * u64::from(results);
    let points = device.filled_buffer("points", Usage::Storage, bytemuck::cast_slice(points))?;
    resources.set_buffer("points", points);
    resources.set_buffer("values", device.buffer("values", Usage::Storage, bytes)?);
    resources.set_buffer("overrun", device.buffer("overrun", Usage::Storage, 4)?);
    let mut recording = Recording::new("evaluate");
    let bound = kernel.bind(device, resources);
    recording.dispatch(&bound, Extent::Threads(threads));
    // Some drivers compile a kernel when it runs for the first time.
    let _busy = (device.activity()).begin(|| compiling(procedural));
    device.play(&recording)?;
    let overrun = device.read(resources.buffer("overrun"), 0, 4)?;
    let overrun: Vec<u32> = bytemuck::pod_collect_to_vec(&overrun);
    if overrun[0] != 0 {
        let textures = procedural.graph().library().textures();
        let texture = textures.get(overrun[0] as usize - 1);
        return Err(EvaluateError::Endless {
            texture: texture.map_or_else(String::new, |texture| texture.name().to_owned()),
        });
    }
    let values = device.read(resources.buffer("values"), 0, bytes)?;
    Ok(bytemuck::pod_collect_to_vec(&values))
}
