//! Machine code of functions, kept for kernels to come.

use std::{
    collections::HashMap,
    fmt,
    sync::{Arc, Mutex, PoisonError},
};

use kernel_ir::lanes::Passed;

use super::{generate::MachineCode, ir::Function};

/// How a function in lanes gets its parameters, and then those that it calls.
type InLanes = Vec<Vec<Passed>>;

/// Machine code of functions that were compiled, found by what they contain. A kernel that is compiled again with one
/// of its separate functions changed takes the others from here.
#[derive(Default)]
pub struct Cache {
    functions: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    by_content: HashMap<(Function, Option<InLanes>), (Arc<MachineCode>, u64)>,
    /// Counts kernels.
    time: u64,
}

/// Functions that the last so many kernels had no use for are forgotten.
const MOST_AGE: u64 = 16;

impl Cache {
    /// An empty cache.
    pub fn new() -> Self {
        Self::default()
    }

    /// Functions in it.
    pub fn len(&self) -> usize {
        self.lock().by_content.len()
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Code of a function with the same content, whatever the functions that it calls are numbered: for one invocation, or for
    /// several.
    pub(super) fn find(
        &self,
        function: &Function,
        lanes: Option<&InLanes>,
    ) -> Option<Arc<MachineCode>> {
        let mut kept = self.lock();
        let time = kept.time;
        let (code, used) = kept.by_content.get_mut(&key(function, lanes))?;
        *used = time;
        Some(code.clone())
    }

    pub(super) fn keep(
        &self,
        function: &Function,
        lanes: Option<&InLanes>,
        code: &Arc<MachineCode>,
    ) {
        let mut kept = self.lock();
        let time = kept.time;
        kept.by_content
            .insert(key(function, lanes), (code.clone(), time));
    }

    /// A kernel is done.
    pub(super) fn age(&self) {
        let mut kept = self.lock();
        kept.time += 1;
        let oldest = kept.time.saturating_sub(MOST_AGE);
        kept.by_content.retain(|_, (_, used)| *used >= oldest);
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.functions
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// The content without what doesn't matter: its name, and which functions it calls. Calls name them by position.
fn key(function: &Function, lanes: Option<&InLanes>) -> (Function, Option<InLanes>) {
    let function = Function {
        name: String::new(),
        callees: Vec::new(),
        ..function.clone()
    };
    (function, lanes.cloned())
}

impl fmt::Debug for Cache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Cache").field("len", &self.len()).finish()
    }
}
