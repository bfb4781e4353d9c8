//! Which crates of the workspace may know which others.

use crate::metadata::Metadata;

/// Every crate with those that it may depend on, which stand above it: so nothing runs back. What a program only shows or
/// measures is never below what makes pictures, and nothing is below the crates of plain data but the language.
const ARROWS: &[(&str, &[&str])] = &[
    ("texgen", &[]),
    ("kernel_ir", &[]),
    ("device", &["kernel_ir"]),
    ("kernels", &["kernel_ir", "device"]),
    ("scene", &["texgen"]),
    ("materialx", &["texgen", "scene"]),
    ("pictures", &["texgen"]),
    (
        "engine",
        &["texgen", "device", "kernels", "scene", "materialx"],
    ),
    (
        "patina-bench",
        &["texgen", "device", "scene", "engine", "pictures"],
    ),
    ("patina-panels", &["texgen", "device", "scene", "engine"]),
    (
        "patina-viewer",
        &["texgen", "device", "scene", "engine", "patina-panels"],
    ),
    ("fuzzing", &["texgen", "device", "scene", "engine"]),
    (
        "patina",
        &[
            "texgen",
            "device",
            "scene",
            "materialx",
            "engine",
            "pictures",
            "patina-bench",
            "patina-viewer",
            "fuzzing",
        ],
    ),
    ("dist", &[]),
    ("xtask", &[]),
];

/// Crates that only tests may depend on.
const FOR_TESTS: &[&str] = &["fuzzing"];

/// Every arrow between members that isn't allowed, a line each.
pub(crate) fn wrong_arrows(metadata: &Metadata) -> Vec<String> {
    let members: Vec<_> = (metadata.packages.iter())
        .filter(|package| metadata.is_member(package))
        .collect();
    let mut wrong = Vec::new();
    for package in &members {
        let name = &package.name;
        let Some((_, allowed)) = ARROWS.iter().find(|(known, _)| known == name) else {
            wrong.push(format!("{name} has no row in dist/src/arrows.rs"));
            continue;
        };
        for dependency in &package.dependencies {
            let other = dependency.name.as_str();
            if !members.iter().any(|member| member.name == other) {
                continue;
            }
            if !allowed.contains(&other) {
                wrong.push(format!("{name} must not depend on {other}"));
            } else if FOR_TESTS.contains(&other) && dependency.kind.as_deref() != Some("dev") {
                wrong.push(format!("{name} may depend on {other} in tests only"));
            }
        }
    }
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;

    #[test]
    fn crates_know_only_those_below_them() {
        let metadata = Metadata::read(root(), None).expect("Cargo knows its packages");
        let wrong = wrong_arrows(&metadata);
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn no_row_allows_an_arrow_back() {
        for (place, (name, allowed)) in ARROWS.iter().enumerate() {
            for other in *allowed {
                let is_above = ARROWS[..place].iter().any(|(known, _)| known == other);
                assert!(is_above, "{name} -> {other}");
            }
        }
    }

    #[test]
    fn an_arrow_back_is_found() {
        let package = |name: &str, other: &str| {
            serde_json::json!({
                "id": name, "name": name, "version": "0.1.0", "source": null, "license": null,
                "license_file": null, "repository": null, "authors": [], "targets": [],
                "manifest_path": "/nowhere/Cargo.toml",
                "dependencies": [{ "name": other, "req": "*", "path": "/nowhere", "kind": null }],
            })
        };
        let text = serde_json::json!({
            "packages": [package("scene", "engine"), package("engine", "scene"), package("patina", "fuzzing"),
                package("fuzzing", "glam"), package("stranger", "scene")],
            "workspace_members": ["scene", "engine", "patina", "fuzzing", "stranger"],
            "resolve": { "nodes": [] },
        });
        let metadata = Metadata::parse(text.to_string().as_bytes()).expect("as Cargo prints it");
        assert_eq!(
            wrong_arrows(&metadata),
            [
                "scene must not depend on engine",
                "patina may depend on fuzzing in tests only",
                "stranger has no row in dist/src/arrows.rs",
            ]
        );
    }
}
