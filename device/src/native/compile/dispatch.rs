//! Runs a kernel over its workgroups.

use std::{fmt, ops::Range, ptr::null_mut, sync::Arc};

use rayon::prelude::*;

use super::{BindingKind, ImageHeader, Kernel, Resource, ir::context};

/// A kernel with its resources. Clones share both.
#[derive(Clone)]
pub struct BoundKernel {
    kernel: Kernel,
    bound: Arc<Bound>,
}

struct Bound {
    /// Keeps the memory alive that the context points to; of functions, this is that memory.
    resources: Box<[Resource]>,
    /// What machine code reads of the dispatch, see [`context`]; the numbers of workgroups are left open.
    context: Vec<u64>,
    _headers: Box<[ImageHeader]>,
}

// SAFETY: the pointers within point to memory that `Bound` owns or shares, and which only machine code touches.
unsafe impl Send for Bound {}
// SAFETY: as above.
unsafe impl Sync for Bound {}

/// The machine code of an entry point. It runs the invocations of one workgroup: context of the dispatch, scratch memory, the
/// workgroup's place.
pub type EntryPoint = unsafe extern "C" fn(*const u64, *mut u64, u32, u32, u32);

impl BoundKernel {
    /// `resources` fit the kernel's bindings, one by one.
    pub(super) fn new(kernel: Kernel, resources: Box<[Resource]>) -> Self {
        let images = resources.iter().filter_map(|resource| match resource {
            Resource::Image(image) => Some(image),
            Resource::Buffer { .. } | Resource::Function(_) => None,
        });
        let headers: Box<[ImageHeader]> = images
            .map(|image| {
                let [width, height, layers] = image.size();
                ImageHeader {
                    width,
                    height,
                    layers,
                    format: image.format(),
                    texels: image.texels().words().as_ptr() as *mut u32,
                }
            })
            .collect();
        let mut next_header = headers.iter();
        let mut context = vec![0; context::words(resources.len())];
        for (slot, (binding, resource)) in kernel.bindings().iter().zip(&resources).enumerate() {
            let (address, last) = match resource {
                Resource::Buffer {
                    buffer,
                    offset,
                    size,
                } => {
                    let address = buffer.words().as_ptr() as u64 + offset;
                    let last = match binding.kind {
                        BindingKind::Buffer {
                            array: Some((start, stride)),
                            ..
                        } => {
                            let length = (size - u64::from(start)) / u64::from(stride);
                            // Never less than one element: that was checked.
                            u32::try_from(length).unwrap_or(u32::MAX) - 1
                        }
                        _ => 0,
                    };
                    (address, last)
                }
                Resource::Image(_) => {
                    let header = next_header.next().expect("one for each image");
                    (std::ptr::from_ref(header) as u64, 0)
                }
                Resource::Function(function) => (std::ptr::from_ref(function) as u64, 0),
            };
            context[context::binding(slot) as usize / 8] = address;
            context[context::last_index(slot) as usize / 8] = u64::from(last);
        }
        Self {
            kernel,
            bound: Arc::new(Bound {
                resources,
                context,
                _headers: headers,
            }),
        }
    }

    /// The kernel.
    pub fn kernel(&self) -> &Kernel {
        &self.kernel
    }

    /// What is bound, in the order of [`Kernel::bindings`].
    pub fn resources(&self) -> &[Resource] {
        &self.bound.resources
    }

    /// Runs so many workgroups along each axis, on the threads of the pool of rayon that the caller is in
    /// (`pool.install(|| bound.dispatch(..))`), and waits for their end.
    pub fn dispatch(&self, workgroups: [u32; 3]) {
        let Some(run) = Run::new(self, workgroups) else {
            return;
        };
        // Pieces of some workgroups each, so that handing them out costs nothing beside them.
        let threads = rayon::current_num_threads() as u64;
        let piece = (run.all / (threads * 64)).clamp(1, 64);
        let pieces = run.all.div_ceil(piece);
        if threads == 1 || pieces == 1 {
            return run.range(&mut run.scratch(), 0..run.all);
        }
        (0..pieces).into_par_iter().for_each_init(
            || run.scratch(),
            |scratch, number| {
                let first = number * piece;
                run.range(scratch, first..(first + piece).min(run.all));
            },
        );
    }

    /// As [`Self::dispatch`], all of it on the calling thread.
    pub fn dispatch_alone(&self, workgroups: [u32; 3]) {
        if let Some(run) = Run::new(self, workgroups) {
            run.range(&mut run.scratch(), 0..run.all);
        }
    }
}

/// A dispatch under way.
struct Run<'a> {
    kernel: &'a Kernel,
    context: Vec<u64>,
    columns: u64,
    rows: u64,
    all: u64,
}

impl<'a> Run<'a> {
    /// Nothing where there are no workgroups.
    fn new(bound: &'a BoundKernel, workgroups: [u32; 3]) -> Option<Self> {
        let [columns, rows, layers] = workgroups.map(u64::from);
        let all = columns.checked_mul(rows)?.checked_mul(layers)?;
        let mut context = bound.bound.context.clone();
        context[context::WORKGROUPS as usize / 8] =
            u64::from(workgroups[0]) | u64::from(workgroups[1]) << 32;
        context[context::WORKGROUPS as usize / 8 + 1] = u64::from(workgroups[2]);
        let kernel = &bound.kernel;
        (all > 0).then_some(Self {
            kernel,
            context,
            columns,
            rows,
            all,
        })
    }

    fn scratch(&self) -> Scratch {
        Scratch::new(self.kernel.scratch_bytes)
    }

    fn range(&self, scratch: &mut Scratch, workgroups: Range<u64>) {
        let entry = self.kernel.entry();
        for index in workgroups {
            let (x, rest) = (index % self.columns, index / self.columns);
            let (y, z) = (rest % self.rows, rest / self.rows);
            let start = scratch.cleared();
            // SAFETY: the code was made for a context of these bindings, which were checked; scratch memory is as large
            // as it asks for; everything lives until the dispatch's end.
            unsafe { entry(self.context.as_ptr(), start, x as u32, y as u32, z as u32) };
        }
    }
}

impl fmt::Debug for BoundKernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BoundKernel")
            .field("kernel", &self.kernel)
            .field("resources", &self.bound.resources)
            .finish()
    }
}

/// Memory of one workgroup at a time, zero when the workgroup begins.
struct Scratch {
    words: Vec<u64>,
}

impl Scratch {
    fn new(bytes: u32) -> Self {
        Self {
            words: vec![0; bytes.div_ceil(8) as usize],
        }
    }

    fn cleared(&mut self) -> *mut u64 {
        if self.words.is_empty() {
            return null_mut();
        }
        self.words.fill(0);
        self.words.as_mut_ptr()
    }
}
