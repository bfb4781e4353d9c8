//! A compute kernel whose bindings are found by name: naga tells which globals an entry point uses, and [`Kernel::bind`]
//! looks each up among named resources. No list of binding numbers exists on the Rust side.

use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::{
    Device, DeviceError, Resources,
    device::Kind,
    gpu, native,
    native::compile::{Ahead, AheadFunction},
};

/// Whether a kernel's indices and loops are to be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trust {
    /// Our own code: no checks are inserted.
    All,
    /// Indices are checked and loops bounded: it contains a user's code.
    Nothing,
    /// Indices are checked. Loops end: our own do, and those of a user's code in it are bounded in its text.
    Loops,
}

/// The text of a kernel, which may be composed of pieces from several files.
pub trait Text: Debug + Sync {
    /// WGSL.
    fn wgsl(&self) -> &str;

    /// A message about a byte range of [`Self::wgsl`] with the place where that was written, if it is known.
    fn locate(&self, span: Range<usize>, message: &str) -> Option<String>;

    /// What the text may use beyond the base of WGSL.
    fn capabilities(&self) -> naga::valid::Capabilities {
        naga::valid::Capabilities::empty()
    }

    /// Functions of the text that are done by a [`HostFunction`](crate::HostFunction) of this name where the device
    /// offers that; those that the text doesn't declare are left out.
    fn host_functions(&self) -> &[&'static str] {
        &[]
    }

    /// Kernels that were compiled with the program, for processors: one that computes the same as an entry point of this
    /// text stands for it.
    fn ahead(&self) -> &'static [Ahead] {
        &[]
    }

    /// Functions that were compiled with the program, for processors: one that computes the same as a function of this text
    /// that [is separate](Self::is_separate) stands for it.
    fn ahead_functions(&self) -> &'static [AheadFunction] {
        &[]
    }

    /// Whether processors are to run several invocations of its kernels at once, as soon as there is code for that.
    fn runs_in_lanes(&self) -> bool {
        false
    }

    /// Of a text that [runs in lanes](Self::runs_in_lanes): whether a function is called once for each set of different
    /// arguments that invocations have. That is worth it where they decide what it does, and are mostly the same.
    fn runs_once(&self, _function: &str) -> bool {
        false
    }

    /// As [`Self::ahead_functions`], for kernels that run in lanes.
    fn ahead_lanes(&self) -> &'static [AheadFunction] {
        &[]
    }

    /// Override constants by which a kernel leaves out what isn't needed, and does the same as with them set: so a kernel
    /// that was compiled with all of them may stand for one without some.
    fn omissions(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether a function of the text is compiled on its own where the device compiles functions one by one: as long as
    /// neither it nor what it calls changes, its machine code is kept for the texts to come.
    fn is_separate(&self, _function: &str) -> bool {
        false
    }

    /// Rewrites what compilers are known not to take, before the module is validated.
    fn adapt(&self, _module: &mut naga::Module) {}
}

impl Text for &str {
    fn wgsl(&self) -> &str {
        self
    }

    fn locate(&self, span: Range<usize>, message: &str) -> Option<String> {
        let line = self.get(..span.start)?.matches('\n').count() + 1;
        Some(format!("line {line}: {message}"))
    }
}

/// What a kernel is compiled from.
#[derive(Debug, Clone)]
pub struct KernelSource<'a> {
    /// Its text.
    pub text: &'a dyn Text,
    /// Its entry point, which is also its label.
    pub entry: &'a str,
    /// What needs not be checked.
    pub trust: Trust,
    /// Values of `override` constants by name; those that the text doesn't declare are left out.
    pub constants: &'a [(&'static str, f64)],
}

impl<'a> KernelSource<'a> {
    /// Without constants.
    pub fn new(text: &'a dyn Text, entry: &'a str, trust: Trust) -> Self {
        Self {
            text,
            entry,
            trust,
            constants: &[],
        }
    }

    /// An error about this kernel.
    pub(crate) fn failed(&self, message: String) -> DeviceError {
        DeviceError::Kernel {
            label: self.entry.to_owned(),
            message,
        }
    }
}

/// [`KernelSource`] as a value that lasts, for tools that ask a driver about kernels.
#[derive(Debug, Clone)]
pub struct KernelText {
    /// Its text.
    pub text: Arc<dyn Text + Send + Sync>,
    /// Its entry point.
    pub entry: &'static str,
    /// What needs not be checked.
    pub trust: Trust,
    /// Values of its `override` constants.
    pub constants: Vec<(&'static str, f64)>,
}

impl KernelText {
    /// To be compiled.
    pub fn source(&self) -> KernelSource<'_> {
        KernelSource {
            text: &*self.text,
            entry: self.entry,
            trust: self.trust,
            constants: &self.constants,
        }
    }
}

/// What it took to compile a kernel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct KernelCost {
    /// Reading and checking its text.
    pub parsing: Duration,
    /// What the device does with it; drivers may put some of that off until it runs.
    pub compiling: Duration,
    /// Functions of machine code, where the device compiles them one by one.
    pub functions: usize,
    /// How many of them had to be compiled: the others were known from former texts.
    pub compiled: usize,
}

/// A compiled kernel. Clones share it.
#[derive(Debug, Clone)]
pub struct Kernel {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    label: Arc<str>,
    /// Binding number and name of each global that the entry point uses.
    bindings: Vec<(u32, String)>,
    program: Program,
    cost: KernelCost,
}

#[derive(Debug)]
enum Program {
    Gpu(gpu::Pipeline),
    Native(native::compile::Kernel),
}

impl Kernel {
    /// Compiles one entry point.
    ///
    /// # Errors
    /// With file and line, if the text is not valid or the driver refuses it.
    pub fn new(device: &Device, source: &KernelSource<'_>) -> Result<Self, DeviceError> {
        let capabilities = match &device.kind {
            Kind::Gpu(gpu) => gpu.capabilities(),
            Kind::Native(_) => naga::valid::Capabilities::empty(),
        };
        let start = Instant::now();
        let parsed = Parsed::new(source, capabilities)?;
        let parsing = start.elapsed();
        let bindings = parsed.bindings();
        let program = match &device.kind {
            Kind::Gpu(gpu) => Program::Gpu(gpu::Pipeline::new(gpu, source, parsed)?),
            Kind::Native(processor) => Program::Native(processor.compile(source, parsed)?),
        };
        let (functions, compiled) = match &program {
            Program::Gpu(_) => (0, 0),
            Program::Native(kernel) => {
                let statistics = kernel.statistics();
                (statistics.functions, statistics.compiled)
            }
        };
        let cost = KernelCost {
            parsing,
            compiling: start.elapsed().saturating_sub(parsing),
            functions,
            compiled,
        };
        Ok(Self {
            shared: Arc::new(Shared {
                label: source.entry.into(),
                bindings,
                program,
                cost,
            }),
        })
    }

    /// The entry point's name.
    pub fn label(&self) -> &str {
        &self.shared.label
    }

    /// What it took to compile it.
    pub fn cost(&self) -> KernelCost {
        self.shared.cost
    }

    /// Looks up its resources.
    ///
    /// # Panics
    /// One of them is missing: see [`Resources::buffer`].
    pub fn bind(&self, device: &Device, resources: &Resources) -> BoundKernel {
        let bound = match (&self.shared.program, &device.kind) {
            (Program::Gpu(pipeline), Kind::Gpu(gpu)) => {
                let bindings = self.shared.bindings.iter();
                let found = bindings.map(|(binding, name)| (*binding, resources.get(name)));
                Bound::Gpu(pipeline.bind(gpu, found))
            }
            (Program::Native(kernel), Kind::Native(_)) => {
                let bound = kernel.bind(|binding| native::resource(&resources.get(&binding.name)));
                Bound::Native(Arc::new(bound.unwrap_or_else(|error| panic!("{error}"))))
            }
            _ => unreachable!("a kernel is used with the device that compiled it"),
        };
        BoundKernel {
            label: Arc::clone(&self.shared.label),
            bound,
        }
    }
}

/// A kernel with its resources: ready to be dispatched. Clones share both.
#[derive(Debug, Clone)]
pub struct BoundKernel {
    label: Arc<str>,
    pub(crate) bound: Bound,
}

#[derive(Debug, Clone)]
pub(crate) enum Bound {
    Gpu(gpu::BoundPipeline),
    Native(Arc<native::compile::BoundKernel>),
}

impl BoundKernel {
    /// The kernel's name.
    pub fn label(&self) -> &str {
        &self.label
    }
}

/// A kernel's text as naga knows it, valid, and one of its entry points.
#[derive(Debug)]
pub(crate) struct Parsed {
    pub(crate) module: naga::Module,
    pub(crate) info: naga::valid::ModuleInfo,
    pub(crate) entry: usize,
}

impl Parsed {
    pub(crate) fn new(
        source: &KernelSource<'_>,
        capabilities: naga::valid::Capabilities,
    ) -> Result<Self, DeviceError> {
        let located = |span: Option<naga::Span>, message: &str| {
            let range = span.and_then(|span| span.to_range());
            let text = range.and_then(|range| source.text.locate(range, message));
            source.failed(text.unwrap_or_else(|| message.to_owned()))
        };
        let mut module = naga::front::wgsl::parse_str(source.text.wgsl())
            .map_err(|e| located(e.labels().next().map(|(span, _)| span), e.message()))?;
        source.text.adapt(&mut module);
        let capabilities = capabilities | source.text.capabilities();
        let flags = naga::valid::ValidationFlags::all();
        let info = naga::valid::Validator::new(flags, capabilities)
            .validate(&module)
            .map_err(|e| {
                let span = e.spans().last().map(|(span, _)| *span);
                located(span, &error_chain(e.as_inner()))
            })?;
        let entry = module
            .entry_points
            .iter()
            .position(|entry| entry.name == source.entry)
            .ok_or_else(|| source.failed(format!("it has no entry point `{}`", source.entry)))?;
        Ok(Self {
            module,
            info,
            entry,
        })
    }

    /// The globals that the entry point uses and that are bound.
    pub(crate) fn globals(&self) -> impl Iterator<Item = (u32, &naga::GlobalVariable)> {
        let uses = self.info.get_entry_point(self.entry);
        let globals = self.module.global_variables.iter();
        globals.filter_map(|(handle, global)| {
            let binding = global.binding?;
            (!uses[handle].is_empty()).then_some((binding.binding, global))
        })
    }

    fn bindings(&self) -> Vec<(u32, String)> {
        self.globals()
            .map(|(binding, global)| (binding, global.name.clone().unwrap_or_default()))
            .collect()
    }

    /// Of these constants those that the text declares.
    pub(crate) fn declared<'a>(
        &'a self,
        constants: &'a [(&'static str, f64)],
    ) -> impl Iterator<Item = (&'static str, f64)> + 'a {
        let declares = |name: &str| {
            let mut overrides = self.module.overrides.iter();
            overrides.any(|(_, declared)| declared.name.as_deref() == Some(name))
        };
        let constants = constants.iter().copied();
        constants.filter(move |(name, _)| declares(name))
    }
}

/// An error with its causes, one after the other.
fn error_chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        text.push_str(": ");
        text.push_str(&inner.to_string());
        cause = inner.source();
    }
    text
}
