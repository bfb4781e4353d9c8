//! Running steps: a heading each, the time it took, and commands that fail loudly.

use std::env;
use std::ffi::OsString;
use std::io;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

/// The folder of the workspace.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("xtask lies inside the workspace")
}

/// Steps of a command, timed.
pub(crate) struct Steps {
    started: Instant,
    taken: Vec<(&'static str, Duration)>,
}

impl Steps {
    /// Starts the clock.
    pub(crate) fn new() -> Self {
        Self {
            started: Instant::now(),
            taken: Vec::new(),
        }
    }

    /// Runs a step under its heading.
    ///
    /// # Errors
    /// Those of the step, with its name.
    pub(crate) fn run(
        &mut self,
        name: &'static str,
        step: impl FnOnce() -> Result<()>,
    ) -> Result<()> {
        println!("\n== {name}");
        let clock = Instant::now();
        step().with_context(|| format!("step '{name}' failed"))?;
        let taken = clock.elapsed();
        println!("== {name}: {:.1} s", taken.as_secs_f64());
        self.taken.push((name, taken));
        Ok(())
    }

    /// Prints what each step took.
    pub(crate) fn finish(self) {
        println!("\n== Done in {:.1} s", self.started.elapsed().as_secs_f64());
        for (name, taken) in self.taken {
            println!("   {:8.1} s  {name}", taken.as_secs_f64());
        }
        println!();
    }
}

/// One command of a step, run in the workspace's folder.
pub(crate) struct Step {
    command: Command,
}

impl Step {
    /// A program without arguments.
    pub(crate) fn new(program: impl Into<OsString>) -> Self {
        let mut command = Command::new(program.into());
        command.current_dir(root());
        Self { command }
    }

    /// With more arguments.
    pub(crate) fn args<'a>(mut self, arguments: impl IntoIterator<Item = &'a str>) -> Self {
        self.command.args(arguments);
        self
    }

    /// With an environment variable.
    pub(crate) fn env(mut self, name: &str, value: &str) -> Self {
        self.command.env(name, value);
        self
    }

    /// In another folder.
    pub(crate) fn within(mut self, folder: &Path) -> Self {
        self.command.current_dir(folder);
        self
    }

    /// Runs it, its output going where ours goes.
    ///
    /// # Errors
    /// It can't be started or doesn't exit with 0.
    pub(crate) fn run(mut self) -> Result<()> {
        let line = self.line();
        println!("$ {line}");
        let status = self
            .command
            .status()
            .with_context(|| format!("cannot start `{line}`"))?;
        if !status.success() {
            bail!("`{line}` ended with {status}");
        }
        Ok(())
    }

    /// Whether it can be started and exits with 0; its output is dropped.
    pub(crate) fn succeeds(self) -> bool {
        self.quietly().is_ok_and(|status| status.success())
    }

    /// Whether it can be started, however it ends; its output is dropped.
    pub(crate) fn starts(self) -> bool {
        self.quietly().is_ok()
    }

    fn quietly(mut self) -> io::Result<ExitStatus> {
        self.command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
    }

    /// What it prints to stdout, or nothing where it fails.
    pub(crate) fn output(mut self) -> String {
        match self.command.stdin(Stdio::null()).output() {
            Ok(output) if output.status.success() => {
                String::from_utf8_lossy(&output.stdout).into_owned()
            }
            _ => String::new(),
        }
    }

    fn line(&self) -> String {
        let program = Path::new(self.command.get_program());
        let words = program
            .file_name()
            .into_iter()
            .chain(self.command.get_args());
        let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
        words.join(" ")
    }
}

/// The cargo that runs this program.
pub(crate) fn cargo<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Step {
    Step::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into())).args(arguments)
}
