//! Functions of the program that do what functions of a kernel's text say.

use std::fmt::Debug;

/// Does what a function of a kernel's text does, on devices that run kernels in this program's memory
/// ([`Traits::calls_functions`](crate::Traits::calls_functions)). Others run the text.
///
/// Kernels name such functions in [`Text::host_functions`](crate::Text::host_functions), and find them among the
/// [`Resources`](crate::Resources) like buffers.
pub trait HostFunction: Debug + Send + Sync {
    /// Words of the arguments and of the result: all scalars in the order of the text, each in a word of its own, bools
    /// as 0 or 1.
    fn words(&self) -> [usize; 2];

    /// Runs it, on any thread; `arguments` and `result` have so many words. A panic ends the program: machine code is
    /// among its callers.
    fn call(&self, arguments: &[u32], result: &mut [u32]);
}
