//! The texts that licences of dependencies ask to be passed on, in one file.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use spdx::Licensee;

use crate::metadata::Package;
use crate::policy;
use crate::root;

/// A larger file is no licence.
const MAX_BYTES: u64 = 1 << 20;

const RULE: &str =
    "================================================================================";

/// Licences of what lies in the sources without being ours.
const DATA: &[&str] = &["engine/src/view/tables/LICENSE.txt"];

/// The licences of data that the program is built with.
///
/// # Errors
/// One can't be read.
pub(crate) fn of_data() -> Result<String> {
    let mut list = String::new();
    for file in DATA {
        let text = read(&root().join(file))?;
        let folder = Path::new(file).parent().unwrap_or(Path::new(""));
        let _ = write!(list, "\n{RULE}\n{}\n{RULE}\n\n{text}\n", folder.display());
    }
    Ok(list)
}

/// All packages with their licences, and each text once with those that it belongs to. A package without a text of its own
/// gets the usual one of a licence that is `accepted`, with the names of its authors.
///
/// # Errors
/// A licence that isn't known, or a file that can't be read.
pub(crate) fn collect(packages: &[&Package], accepted: &[Licensee]) -> Result<String> {
    let mut list = String::from(
        "Patina is built of the packages below, whose authors ask that these texts go with it.\n\n",
    );
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in packages {
        let licence = package.license.as_deref().unwrap_or("see its text");
        let home = package.repository.as_deref().unwrap_or_default();
        let line = format!("{}: {licence} {home}", package.label());
        let _ = writeln!(list, "{}", line.trim_end());
        let folder = package.manifest_path.parent();
        let folder = folder.with_context(|| format!("{} lies nowhere", package.label()))?;
        let mut own = files(folder)?;
        if let Some(file) = &package.license_file {
            own.push(read(&folder.join(file))?);
        }
        if own.is_empty() {
            own = usual(package, accepted)?;
        }
        for text in own {
            texts.entry(text).or_default().insert(package.label());
        }
    }
    // In the order of those whom they belong to, as the list above has it.
    let mut texts: Vec<_> = texts.into_iter().map(|(text, of)| (of, text)).collect();
    texts.sort();
    for (of, text) in texts {
        let of: Vec<_> = of.into_iter().collect();
        let _ = write!(list, "\n{RULE}\n{}\n{RULE}\n\n{text}\n", of.join(", "));
    }
    Ok(list)
}

/// Texts of licences in a package's folder and those below it.
fn files(folder: &Path) -> Result<Vec<String>> {
    let mut texts = Vec::new();
    let mut todo = vec![folder.to_owned()];
    while let Some(folder) = todo.pop() {
        let entries = fs::read_dir(&folder)
            .with_context(|| format!("cannot read the folder {}", folder.display()))?;
        for entry in entries {
            let path = entry?.path();
            if path.is_dir() {
                todo.push(path);
            } else if is_licence(&path) && path.metadata()?.len() <= MAX_BYTES {
                texts.push(read(&path)?);
            }
        }
    }
    texts.retain(|text| !text.is_empty());
    Ok(texts)
}

/// By its name, or a text beside the font that it is about.
fn is_licence(path: &Path) -> bool {
    let upper = |part: Option<&std::ffi::OsStr>| {
        part.unwrap_or_default()
            .to_string_lossy()
            .to_ascii_uppercase()
    };
    let (name, ending) = (upper(path.file_name()), upper(path.extension()));
    if ["RS", "TOML", "HTML", "JSON", "YML", "WGSL"].contains(&ending.as_str()) {
        return false;
    }
    let is_of_font = || {
        let folder = path.parent().and_then(Path::file_name);
        ending == "TXT" && upper(folder) == "FONTS"
    };
    ["COPYING", "COPYRIGHT", "NOTICE", "OFL.", "UFL."]
        .iter()
        .any(|start| name.starts_with(start))
        || ["LICENSE", "LICENCE"]
            .iter()
            .any(|part| name.contains(part))
        || is_of_font()
}

fn read(path: &Path) -> Result<String> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n");
    let lines: Vec<_> = text.lines().map(str::trim_end).collect();
    Ok(lines.join("\n").trim_matches('\n').to_owned())
}

/// The usual texts of the licences under which the package is used.
fn usual(package: &Package, accepted: &[Licensee]) -> Result<Vec<String>> {
    let label = package.label();
    let text = package.license.as_deref();
    let text = text.with_context(|| format!("{label} has no licence"))?;
    let needed = policy::expression(text)?
        .minimized_requirements(accepted)
        .with_context(|| format!("{label}: `{text}` is not accepted"))?;
    let mut texts = Vec::new();
    for licence in needed {
        let id = licence.license.id();
        let id =
            id.with_context(|| format!("{label}: the licence `{licence}` has no usual text"))?;
        let mut text = id.text().trim().to_owned();
        if let Some(exception) = licence.addition.as_ref().and_then(|addition| addition.id()) {
            text += &format!("\n\n{}", exception.text().trim());
        }
        if !package.authors.is_empty() {
            text = format!("By {}\n\n{text}", package.authors.join(", "));
        }
        texts.push(text);
    }
    Ok(texts)
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::metadata::Metadata;
    use crate::{policy::Policy, root};

    #[test]
    fn every_linked_package_is_listed_with_a_text() {
        let policy = Policy::read().expect("it is understood");
        let platform = crate::platform().expect("rustc tells it");
        let metadata = Metadata::read(root(), Some(&platform)).expect("Cargo knows");
        let packages = metadata.linked("patina").expect("a package");
        let names: Vec<_> = packages.iter().map(|p| p.name.as_str()).collect();
        assert!(names.contains(&"wgpu") && names.contains(&"toml_edit"));
        let absent = ["tar", "patina", "engine", "serde_derive", "egui_kittest"];
        assert!(absent.iter().all(|name| !names.contains(name)), "{names:?}");
        let text = collect(&packages, policy.licences()).expect("texts");
        let (_, texts) = text.split_once(RULE).expect("texts follow the list");
        for package in &packages {
            assert!(texts.contains(&package.label()), "{}", package.label());
        }
        for wanted in [
            "Permission is hereby granted",
            "Apache License",
            "SIL OPEN FONT LICENSE",
        ] {
            assert!(texts.contains(wanted), "{wanted}");
        }
    }

    #[test]
    fn licences_are_known_by_their_names() {
        let yes = [
            "LICENSE",
            "license-mit",
            "COPYING.txt",
            "LICENSE.Apache2",
            "UNLICENSE",
            "fonts/Hack.txt",
        ];
        for name in yes {
            assert!(is_licence(Path::new(name)), "{name}");
        }
        for name in ["license.rs", "README.md", "src/copy.txt", "licenses.toml"] {
            assert!(!is_licence(Path::new(name)), "{name}");
        }
    }
}
