//! What Cargo knows of the packages that the program is built of.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::Deserialize;

/// The output of `cargo metadata`, as far as it is of use here.
#[derive(Debug, Deserialize)]
pub(crate) struct Metadata {
    pub(crate) packages: Vec<Package>,
    workspace_members: BTreeSet<String>,
    resolve: Resolve,
}

#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Package {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) version: String,
    /// Where it comes from; nothing for a member of the workspace.
    pub(crate) source: Option<String>,
    /// An SPDX expression.
    pub(crate) license: Option<String>,
    pub(crate) license_file: Option<PathBuf>,
    pub(crate) repository: Option<String>,
    #[serde(default)]
    pub(crate) authors: Vec<String>,
    pub(crate) manifest_path: PathBuf,
    pub(crate) dependencies: Vec<Dependency>,
    targets: Vec<Target>,
}

#[derive(Debug, Clone, Deserialize)]
pub(crate) struct Dependency {
    pub(crate) name: String,
    pub(crate) req: String,
    pub(crate) path: Option<PathBuf>,
    /// Nothing for what the code needs, else `build` or `dev`.
    pub(crate) kind: Option<String>,
}

#[derive(Debug, Clone, Deserialize)]
struct Target {
    kind: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
struct Node {
    id: String,
    deps: Vec<Edge>,
}

#[derive(Debug, Deserialize)]
struct Edge {
    pkg: String,
    dep_kinds: Vec<EdgeKind>,
}

#[derive(Debug, Deserialize)]
struct EdgeKind {
    /// Nothing for what is linked, else `build` or `dev`.
    kind: Option<String>,
}

impl Metadata {
    /// Asks Cargo, for one platform or for all of them.
    ///
    /// # Errors
    /// Cargo can't be started or refuses, as where the lock file is not up to date.
    pub(crate) fn read(root: &Path, platform: Option<&str>) -> Result<Self> {
        let mut command = cargo(root);
        command.args(["metadata", "--locked", "--format-version", "1"]);
        if let Some(platform) = platform {
            command.args(["--filter-platform", platform]);
        }
        let output = command.output().context("cannot start cargo")?;
        if !output.status.success() {
            bail!(
                "`cargo metadata` failed:\n{}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
        Self::parse(&output.stdout)
    }

    /// Understands what Cargo printed.
    ///
    /// # Errors
    /// It is no such output.
    pub(crate) fn parse(text: &[u8]) -> Result<Self> {
        serde_json::from_slice(text).context("the output of `cargo metadata` is not understood")
    }

    /// Whether a package is part of this project.
    pub(crate) fn is_member(&self, package: &Package) -> bool {
        self.workspace_members.contains(&package.id)
    }

    /// Packages of others whose code is in a program of this workspace, sorted by name. What only takes part in the
    /// build is not among them.
    ///
    /// # Errors
    /// There is no such program.
    pub(crate) fn linked(&self, program: &str) -> Result<Vec<&Package>> {
        let mut linked = self.reached(program)?;
        linked.retain(|package| !self.is_member(package));
        linked.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
        Ok(linked)
    }

    /// All packages whose code is in a program of this workspace, its own among them.
    ///
    /// # Errors
    /// There is no such program.
    fn reached(&self, program: &str) -> Result<Vec<&Package>> {
        let by_id: HashMap<&str, &Package> =
            self.packages.iter().map(|p| (p.id.as_str(), p)).collect();
        let nodes: HashMap<&str, &Node> = self
            .resolve
            .nodes
            .iter()
            .map(|node| (node.id.as_str(), node))
            .collect();
        let start = self.packages.iter().find(|p| p.name == program);
        let start = start.with_context(|| format!("no package is called {program}"))?;
        let mut seen = BTreeSet::from([start.id.as_str()]);
        let mut todo = vec![start.id.as_str()];
        while let Some(id) = todo.pop() {
            for edge in nodes.get(id).into_iter().flat_map(|node| &node.deps) {
                let is_linked = edge.dep_kinds.iter().any(|kind| kind.kind.is_none());
                let is_macro = by_id.get(edge.pkg.as_str()).is_some_and(|p| p.is_macro());
                if is_linked && !is_macro && seen.insert(&edge.pkg) {
                    todo.push(&edge.pkg);
                }
            }
        }
        let reached = seen.iter().filter_map(|id| by_id.get(id).copied());
        Ok(reached.collect())
    }
}

impl Package {
    fn is_macro(&self) -> bool {
        self.targets
            .iter()
            .any(|target| target.kind.iter().any(|kind| kind == "proc-macro"))
    }

    /// Name and version.
    pub(crate) fn label(&self) -> String {
        format!("{} {}", self.name, self.version)
    }
}

/// The Cargo that runs this program.
fn cargo(root: &Path) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root);
    command
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;

    #[test]
    fn reports_see_changes_of_all_that_the_program_is_made_of() {
        let metadata = Metadata::read(root(), None).expect("Cargo knows its packages");
        let build = std::fs::read_to_string(root().join("build.rs")).expect("it is there");
        let reached = metadata.reached("patina").expect("there is one");
        let own = reached.iter().filter(|package| metadata.is_member(package));
        let folders = own.filter_map(|package| {
            let folder = package.manifest_path.parent()?.strip_prefix(root()).ok()?;
            Some(folder.display().to_string())
        });
        // The program itself lies in none.
        let folders: Vec<String> = folders.filter(|folder| !folder.is_empty()).collect();
        assert!(folders.len() > 5, "{folders:?}");
        for folder in folders {
            assert!(build.contains(&format!("    {folder:?},")), "{folder}");
            let has_script = root().join(&folder).join("build.rs").is_file();
            let script = format!("{folder}/build.rs");
            assert!(!has_script || build.contains(&script), "{script}");
        }
    }
}
