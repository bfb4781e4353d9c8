//! What a device is to do, as data: the same list is played by any device.

use crate::{BoundKernel, Buffer};

/// How many workgroups run.
#[derive(Debug, Clone)]
pub enum Extent {
    /// Enough workgroups of 64 for this many threads.
    Threads(u32),
    /// One workgroup.
    One,
    /// Three words of a buffer at this byte, written by another kernel.
    Indirect(Buffer, u64),
}

/// Most workgroups in a row; more go into further rows.
const MOST_IN_A_ROW: u32 = 32768;

impl Extent {
    /// Workgroups along x and y for so many threads.
    pub(crate) fn groups(threads: u32) -> [u32; 2] {
        let groups = threads.div_ceil(64);
        [groups.min(MOST_IN_A_ROW), groups.div_ceil(MOST_IN_A_ROW)]
    }
}

/// One thing to do.
#[derive(Debug, Clone)]
pub enum Command {
    /// Run a kernel.
    Dispatch(BoundKernel, Extent),
    /// Set all bytes of a buffer to zero.
    Clear(Buffer),
    /// Copy the first bytes of one buffer to another.
    Copy {
        /// Read.
        from: Buffer,
        /// Written.
        to: Buffer,
        /// How many, a multiple of four.
        bytes: u64,
    },
}

/// A list of commands, done one after the other: each sees what those before it wrote.
#[derive(Debug, Clone)]
pub struct Recording {
    label: &'static str,
    commands: Vec<Command>,
}

impl Recording {
    /// An empty list; the label is for debuggers.
    pub fn new(label: &'static str) -> Self {
        Self {
            label,
            commands: Vec::new(),
        }
    }

    /// For debuggers.
    pub fn label(&self) -> &'static str {
        self.label
    }

    /// What is to be done.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// The kernels that it runs.
    pub fn kernels(&self) -> impl Iterator<Item = &BoundKernel> {
        self.commands.iter().filter_map(|command| match command {
            Command::Dispatch(kernel, _) => Some(kernel),
            Command::Clear(_) | Command::Copy { .. } => None,
        })
    }

    /// Each command in a list of its own.
    pub(crate) fn apart(&self) -> impl Iterator<Item = Self> {
        self.commands.iter().map(|command| Self {
            label: self.label,
            commands: vec![command.clone()],
        })
    }

    /// Runs a kernel.
    pub fn dispatch(&mut self, kernel: &BoundKernel, extent: Extent) {
        self.commands
            .push(Command::Dispatch(kernel.clone(), extent));
    }

    /// Sets all bytes of a buffer to zero.
    pub fn clear(&mut self, buffer: &Buffer) {
        self.commands.push(Command::Clear(buffer.clone()));
    }

    /// Copies a whole buffer to one that is at least as large.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer) {
        self.commands.push(Command::Copy {
            from: from.clone(),
            to: to.clone(),
            bytes: from.size(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_fill_rows_of_workgroups() {
        assert_eq!(Extent::groups(0), [0, 0]);
        assert_eq!(Extent::groups(1), [1, 1]);
        assert_eq!(Extent::groups(65), [2, 1]);
        assert_eq!(Extent::groups(64 * MOST_IN_A_ROW), [MOST_IN_A_ROW, 1]);
        assert_eq!(Extent::groups(64 * MOST_IN_A_ROW + 1), [MOST_IN_A_ROW, 2]);
    }
}
