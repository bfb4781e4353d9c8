//! `deny.toml`, as far as it can be held against what Cargo knows: licences, bans and sources. cargo-deny reads the same
//! file, but takes ten minutes to build.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, bail};
use spdx::{Expression, Licensee, ParseMode};
use toml_edit::{DocumentMut, Item, Table, Value};

use crate::metadata::{Metadata, Package};
use crate::root;

/// What is allowed.
#[derive(Debug)]
pub(crate) struct Policy {
    licences: Vec<Licensee>,
    registries: Vec<String>,
    banned: Vec<(String, String)>,
    /// Names and versions of which there may be others.
    doubled: Vec<(String, String)>,
}

impl Policy {
    /// Reads the project's file.
    ///
    /// # Errors
    /// It can't be read, or isn't understood.
    pub(crate) fn read() -> Result<Self> {
        let text = std::fs::read_to_string(root().join("deny.toml"));
        Self::parse(&text.context("cannot read deny.toml")?)
    }

    /// Understands the file. What it demands is demanded here; a setting that would demand something else is refused, so
    /// that nobody trusts in it.
    ///
    /// # Errors
    /// The place that isn't understood.
    pub(crate) fn parse(text: &str) -> Result<Self> {
        let document: DocumentMut = text.parse().context("deny.toml is no TOML")?;
        let table = |name: &str| {
            let table = document.get(name).and_then(Item::as_table);
            table.with_context(|| format!("deny.toml has no table [{name}]"))
        };
        let (licenses, bans, sources) = (table("licenses")?, table("bans")?, table("sources")?);
        only(licenses, "licenses", &[("allow", None)])?;
        only(
            bans,
            "bans",
            &[
                ("multiple-versions", Some("deny")),
                ("wildcards", Some("deny")),
                ("allow-wildcard-paths", Some("true")),
                ("deny", None),
                ("skip", None),
            ],
        )?;
        only(
            sources,
            "sources",
            &[
                ("unknown-registry", Some("deny")),
                ("unknown-git", Some("deny")),
                ("allow-registry", None),
            ],
        )?;
        let licences = texts(licenses, "allow")?;
        Ok(Self {
            licences: licences
                .iter()
                .map(|licence| {
                    Licensee::parse(licence)
                        .with_context(|| format!("`{licence}` in deny.toml is no licence"))
                })
                .collect::<Result<_>>()?,
            registries: texts(sources, "allow-registry")?,
            banned: reasoned(bans, "deny")?,
            doubled: reasoned(bans, "skip")?
                .into_iter()
                .map(|(spec, _)| match spec.split_once('@') {
                    Some((name, version)) => Ok((name.to_owned(), version.to_owned())),
                    None => bail!("`{spec}` in deny.toml's skip list has no version: NAME@VERSION"),
                })
                .collect::<Result<_>>()?,
        })
    }

    /// Licences in the order of the file.
    pub(crate) fn licences(&self) -> &[Licensee] {
        &self.licences
    }

    /// Everything that isn't as the file demands, a line each.
    pub(crate) fn violations(&self, metadata: &Metadata) -> Vec<String> {
        let mut found = Vec::new();
        for package in &metadata.packages {
            if metadata.is_member(package) {
                for dependency in &package.dependencies {
                    if dependency.req == "*" && dependency.path.is_none() {
                        let (member, name) = (&package.name, &dependency.name);
                        found.push(format!("{member} takes any version of {name}: name one"));
                    }
                }
                continue;
            }
            found.extend(self.licence_problem(package));
            found.extend(self.source_problem(package));
            for (name, reason) in &self.banned {
                if package.name == *name {
                    found.push(format!("{} is banned: {reason}", package.label()));
                }
            }
        }
        found.extend(self.doubles(metadata));
        found.sort();
        found
    }

    fn licence_problem(&self, package: &Package) -> Option<String> {
        let label = package.label();
        let Some(text) = &package.license else {
            return Some(format!("{label} doesn't name its licence in SPDX's words"));
        };
        match expression(text) {
            Err(error) => Some(format!("{label}: the licence `{text}`: {error:#}")),
            Ok(expression) => {
                let allows = |wanted: &_| self.licences.iter().any(|l| l.satisfies(wanted));
                let is_allowed = expression.evaluate(allows);
                (!is_allowed).then(|| format!("{label}: the licence `{text}` is not allowed"))
            }
        }
    }

    fn source_problem(&self, package: &Package) -> Option<String> {
        let source = package.source.as_deref();
        let registry = source.and_then(|source| source.strip_prefix("registry+"));
        let is_known = registry.is_some_and(|url| self.registries.iter().any(|r| r == url));
        (!is_known).then(|| {
            let source = source.unwrap_or("a folder outside of the workspace");
            format!("{} comes from {source}", package.label())
        })
    }

    /// Crates of which there are several versions, and exceptions that aren't any.
    fn doubles(&self, metadata: &Metadata) -> Vec<String> {
        let mut versions: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for package in &metadata.packages {
            let of_name = versions.entry(&package.name).or_default();
            of_name.insert(&package.version);
        }
        let mut found = Vec::new();
        for (name, version) in &self.doubled {
            let of_name = versions.get_mut(name.as_str());
            let before = of_name.as_ref().map_or(0, |v| v.len());
            let fits = |known: &str| {
                known
                    .strip_prefix(version.as_str())
                    .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '-', '+']))
            };
            if let Some(of_name) = of_name {
                of_name.retain(|known| !fits(known));
                if of_name.len() < before && !of_name.is_empty() {
                    continue;
                }
            }
            found.push(format!(
                "`{name}@{version}` in deny.toml's skip list is not needed"
            ));
        }
        for (name, versions) in versions {
            if versions.len() > 1 {
                let versions: Vec<_> = versions.into_iter().collect();
                found.push(format!("{name} comes in versions {}", versions.join(", ")));
            }
        }
        found
    }
}

/// An SPDX expression, or the older form with a slash for `OR`.
pub(crate) fn expression(text: &str) -> Result<Expression> {
    Expression::parse_mode(text, ParseMode::LAX)
        .map_err(|error| anyhow::anyhow!("{}", error.reason))
}

/// Refuses keys that aren't listed, and values other than the one that is done here.
fn only(table: &Table, name: &str, known: &[(&str, Option<&str>)]) -> Result<()> {
    for (key, value) in table {
        let Some((_, wanted)) = known.iter().find(|(known, _)| *known == key) else {
            bail!("deny.toml: `{key}` in [{name}] is not looked at by `cargo xtask test`");
        };
        let value = match value.as_value() {
            Some(Value::String(text)) => Some(text.value().clone()),
            Some(Value::Boolean(flag)) => Some(flag.value().to_string()),
            _ => None,
        };
        if let (Some(wanted), given) = (wanted, value)
            && given.as_deref() != Some(wanted)
        {
            bail!("deny.toml: `cargo xtask test` knows {key} = {wanted} alone");
        }
    }
    Ok(())
}

fn array<'a>(table: &'a Table, key: &str) -> Result<&'a toml_edit::Array> {
    let array = table.get(key).and_then(Item::as_array);
    array.with_context(|| format!("deny.toml: `{key}` is no list"))
}

fn texts(table: &Table, key: &str) -> Result<Vec<String>> {
    let text = |value: &Value| {
        let text = value.as_str().map(str::to_owned);
        text.with_context(|| format!("deny.toml: `{key}` holds something that is no text"))
    };
    array(table, key)?.iter().map(text).collect()
}

/// `{ crate = "..", reason = ".." }`: each must have its reason.
fn reasoned(table: &Table, key: &str) -> Result<Vec<(String, String)>> {
    let entry = |value: &Value| {
        let field = |field: &str| {
            let text = value.as_inline_table()?.get(field)?.as_str()?;
            Some(text.to_owned())
        };
        field("crate").zip(field("reason")).with_context(|| {
            format!("deny.toml: an entry of `{key}` lacks its crate or its reason")
        })
    };
    array(table, key)?.iter().map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dependency_is_as_deny_toml_demands() {
        let metadata = Metadata::read(root(), None).expect("Cargo knows its packages");
        let policy = Policy::read().expect("it is understood");
        let found = policy.violations(&metadata);
        assert!(found.is_empty(), "{}", found.join("\n"));
    }

    /// A workspace of `member`, which depends on other packages: name, version, source, licence.
    fn metadata(packages: &[[&str; 4]], requirement: &str) -> Metadata {
        let package = |name: &str, version: &str, source: Option<&str>, license: &str| {
            serde_json::json!({
                "id": format!("{name} {version}"), "name": name, "version": version, "source": source,
                "license": license, "license_file": null, "repository": null, "authors": [],
                "manifest_path": "/nowhere/Cargo.toml", "targets": [],
                "dependencies": [{ "name": "other", "req": requirement, "path": null }],
            })
        };
        let mut all = vec![package("member", "0.1.0", None, "MIT")];
        for [name, version, source, license] in packages {
            all.push(package(name, version, Some(source), license));
        }
        let text = serde_json::json!({
            "packages": all, "workspace_members": ["member 0.1.0"], "resolve": { "nodes": [] },
        });
        Metadata::parse(text.to_string().as_bytes()).expect("as Cargo prints it")
    }

    const INDEX: &str = "registry+https://github.com/rust-lang/crates.io-index";

    #[test]
    fn what_is_not_allowed_is_named() {
        let policy = Policy::parse(
            "[licenses]\nallow = [\"MIT\", \"Apache-2.0 WITH LLVM-exception\"]\n\
             [bans]\nmultiple-versions = \"deny\"\n\
             deny = [{ crate = \"cmake\", reason = \"no tools\" }]\n\
             skip = [{ crate = \"old@0.13\", reason = \"theirs\" }]\n\
             [sources]\nallow-registry = [\"https://github.com/rust-lang/crates.io-index\"]\n",
        )
        .expect("it is understood");
        let fine = [
            ["a", "1.0.0", INDEX, "MIT/GPL-3.0"],
            ["b", "1.0.0", INDEX, "Apache-2.0 WITH LLVM-exception"],
            ["old", "0.13.9", INDEX, "MIT"],
            ["old", "0.14.0", INDEX, "MIT"],
        ];
        let found = policy.violations(&metadata(&fine, "^1"));
        assert!(found.is_empty(), "{found:?}");

        let git = "git+https://example.com/a";
        let wrong = [
            ["a", "1.0.0", INDEX, "MIT AND GPL-3.0-only"],
            ["b", "1.0.0", git, "MIT"],
            ["cmake", "0.1.0", INDEX, "MIT"],
            ["d", "1.2.0", INDEX, "MIT"],
            ["d", "2.0.0", INDEX, "MIT"],
            ["e", "1.0.0", INDEX, "whatever"],
        ];
        let found = policy.violations(&metadata(&wrong, "*"));
        let wanted = [
            "a 1.0.0: the licence `MIT AND GPL-3.0-only` is not allowed",
            "b 1.0.0 comes from git+https://example.com/a",
            "cmake 0.1.0 is banned: no tools",
            "d comes in versions 1.2.0, 2.0.0",
            "e 1.0.0: the licence `whatever`: unknown term",
            "member takes any version of other: name one",
            "`old@0.13` in deny.toml's skip list is not needed",
        ];
        assert_eq!(found.len(), wanted.len(), "{found:#?}");
        for wanted in wanted {
            assert!(
                found.iter().any(|line| line.starts_with(wanted)),
                "{wanted}: {found:#?}"
            );
        }
    }

    #[test]
    fn a_setting_that_nothing_looks_at_is_refused() {
        let refused =
            |text: &str| format!("{:#}", Policy::parse(text).expect_err("not understood"));
        let rest = "[licenses]\nallow = []\n[sources]\nallow-registry = []\n";
        let error = refused(&format!(
            "{rest}[bans]\nskip = []\ndeny = []\nfeatures = []"
        ));
        assert!(error.contains("`features` in [bans]"), "{error}");
        let error = refused(&format!(
            "{rest}[bans]\nmultiple-versions = \"warn\"\nskip = []"
        ));
        assert!(error.contains("multiple-versions = deny"), "{error}");
        let error = refused(&format!(
            "{rest}[bans]\ndeny = [{{ crate = \"a\" }}]\nskip = []"
        ));
        assert!(error.contains("its reason"), "{error}");
    }
}
