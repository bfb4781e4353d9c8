//! Finding a Vulkan loader and driver, or installing Mesa's.
//!
//! Looks at files only, as nothing that could load a driver is built yet. The search follows the loader's own
//! documentation (Khronos, "Loader and Driver Interface"): environment variables first, then `vulkan/icd.d` in the
//! configuration and data folders.

use std::env;
use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

use crate::steps::Step;

const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];

/// What is there stays as it is, and nothing comes along that drivers don't need.
const INSTALL: [&str; 5] = [
    "install",
    "-y",
    "--no-install-recommends",
    "--no-upgrade",
    "--no-remove",
];

/// Variables that replace the search for drivers altogether.
const OVERRIDES: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

const BY_HAND: &str = "\
Patina needs a Vulkan loader and a driver; without a GPU, Mesa's software driver (lavapipe) will do. Install
  Debian, Ubuntu   apt-get install mesa-vulkan-drivers libvulkan1
  Fedora           dnf install mesa-vulkan-drivers vulkan-loader
  Arch             pacman -S vulkan-swrast vulkan-icd-loader
  Alpine           apk add mesa-vulkan-swrast vulkan-loader
and run this command again.";

/// Finds a Vulkan loader and at least one driver, or installs them. Systems other than Linux bring their own way to
/// the GPU (Metal, DirectX 12).
///
/// # Errors
/// There are none and they can't be installed; the text says what to install by hand.
pub(crate) fn ensure() -> Result<()> {
    if !cfg!(target_os = "linux") {
        println!("not needed on this system");
        return Ok(());
    }
    if !found() {
        if let Some(name) = OVERRIDES.iter().find(|name| env::var_os(name).is_some()) {
            bail!("{name} is set but leads to no driver; correct it or unset it.");
        }
        install()?;
        if !found() {
            bail!("the packages are installed, but no Vulkan driver can be found.\n{BY_HAND}");
        }
    }
    hint_at_newer_mesa();
    Ok(())
}

/// Installs Mesa's drivers and the loader with apt, as root or through sudo.
///
/// # Errors
/// There is no apt or no right to use it; the text says what to install by hand.
pub(crate) fn install() -> Result<()> {
    install_packages(&PACKAGES, BY_HAND)
}

/// Installs packages of Debian with apt, as root or through sudo.
///
/// # Errors
/// There is no apt or no right to use it; `by_hand` says what to do then.
pub(crate) fn install_packages(packages: &[&str], by_hand: &str) -> Result<()> {
    if !Step::new("apt-get").args(["--version"]).succeeds() {
        bail!("there is no apt-get on this system.\n{by_hand}");
    }
    let Some(privilege) = privilege() else {
        bail!("installing needs root or sudo.\n{by_hand}");
    };
    let apt = || {
        // `env`, because sudo does not pass variables on.
        let words = [
            "env",
            "DEBIAN_FRONTEND=noninteractive",
            "apt-get",
            "-o",
            "DPkg::Lock::Timeout=120",
        ];
        let mut words = privilege.iter().copied().chain(words);
        let program = words.next().expect("the list above is not empty");
        Step::new(program).args(words)
    };
    // An outdated list of packages may still do, so only the installation has to succeed.
    if let Err(error) = apt().args(["update"]).run() {
        println!("{error:#}; trying with the package lists there are");
    }
    let installed = apt().args(INSTALL).args(packages.iter().copied()).run();
    if let Err(error) = installed {
        bail!("{error:#}.\n{by_hand}");
    }
    Ok(())
}

/// What to put before a command that needs root; `None` where there is no way.
fn privilege() -> Option<&'static [&'static str]> {
    if Step::new("id").args(["-u"]).output().trim() == "0" {
        Some(&[])
    } else if Step::new("sudo").args(["-n", "true"]).succeeds() {
        Some(&["sudo", "-n"])
    } else if io::stdin().is_terminal() && Step::new("sudo").args(["--version"]).succeeds() {
        // Somebody is there to type the password.
        Some(&["sudo"])
    } else {
        None
    }
}

/// Whether the loader and a driver whose library exists are there; says what was found.
fn found() -> bool {
    let libraries = Libraries::new();
    let loader = ["libvulkan.so.1", "libvulkan.so"]
        .iter()
        .find_map(|name| libraries.find(name));
    match &loader {
        Some(path) => println!("loader: {}", path.display()),
        None => println!("loader: libvulkan.so.1 not found"),
    }
    let drivers: Vec<_> = manifests()
        .into_iter()
        .filter(|manifest| has_library(manifest, &libraries))
        .collect();
    for driver in &drivers {
        println!("driver: {}", driver.display());
    }
    if drivers.is_empty() {
        println!("driver: none found");
    }
    loader.is_some() && !drivers.is_empty()
}

/// Driver manifests (`*.json`) where the loader would look for them.
fn manifests() -> Vec<PathBuf> {
    let listed = |name: &str| -> Vec<PathBuf> {
        env::var_os(name).map_or_else(Vec::new, |value| {
            env::split_paths(&value)
                .filter(|path| !path.as_os_str().is_empty())
                .collect()
        })
    };
    for name in OVERRIDES {
        let files = listed(name);
        if !files.is_empty() {
            println!("{name} is set");
            return files.iter().flat_map(|path| json_files(path)).collect();
        }
    }
    let home = env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
    let one_or = |name: &str, default: PathBuf| match listed(name) {
        paths if paths.is_empty() => vec![default],
        paths => paths,
    };
    let many_or = |name: &str, default: &[&str]| match listed(name) {
        paths if paths.is_empty() => default.iter().map(PathBuf::from).collect(),
        paths => paths,
    };
    let folders = [
        one_or("XDG_CONFIG_HOME", home.join(".config")),
        many_or("XDG_CONFIG_DIRS", &["/etc/xdg"]),
        vec!["/usr/local/etc".into(), "/etc".into()],
        one_or("XDG_DATA_HOME", home.join(".local/share")),
        many_or("XDG_DATA_DIRS", &["/usr/local/share", "/usr/share"]),
    ];
    let standard = folders
        .into_iter()
        .flatten()
        .map(|folder| folder.join("vulkan/icd.d"));
    let mut found: Vec<PathBuf> = listed("VK_ADD_DRIVER_FILES")
        .into_iter()
        .chain(standard)
        .flat_map(|path| json_files(&path))
        .collect();
    found.sort();
    found.dedup();
    found
}

/// The manifest itself, or those in a folder.
fn json_files(path: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(path) else {
        return vec![path.to_owned()]
            .into_iter()
            .filter(|path| path.is_file())
            .collect();
    };
    entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "json")
        })
        .collect()
}

/// Whether the library a manifest names is there: packages may be removed and leave their manifest.
fn has_library(manifest: &Path, libraries: &Libraries) -> bool {
    let Ok(text) = fs::read_to_string(manifest) else {
        return false;
    };
    let Some(library) = library_path(&text) else {
        return false;
    };
    if library.contains('/') {
        let folder = manifest.parent().unwrap_or(Path::new(""));
        // Joining keeps an absolute path as it is.
        folder.join(library).exists()
    } else {
        libraries.find(library).is_some()
    }
}

/// The value of `library_path` in a manifest. The one string is not worth a JSON parser.
fn library_path(manifest: &str) -> Option<&str> {
    let (_, rest) = manifest.split_once("\"library_path\"")?;
    let (_, rest) = rest.split_once(':')?;
    let (_, rest) = rest.split_once('"')?;
    let (value, _) = rest.split_once('"')?;
    (!value.is_empty()).then_some(value)
}

/// Shared libraries the dynamic linker can find.
struct Libraries {
    /// What `ldconfig -p` printed.
    cache: String,
    folders: Vec<PathBuf>,
}

impl Libraries {
    fn new() -> Self {
        // Not on every user's PATH.
        let cache = ["ldconfig", "/sbin/ldconfig", "/usr/sbin/ldconfig"]
            .iter()
            .map(|program| Step::new(*program).args(["-p"]).output())
            .find(|output| !output.is_empty())
            .unwrap_or_default();
        let own = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
        let multiarch = format!("/usr/lib/{}-linux-gnu", env::consts::ARCH);
        let standard = [
            "/usr/local/lib",
            "/usr/lib64",
            "/usr/lib",
            "/lib64",
            "/lib",
            &multiarch,
        ];
        Self {
            cache,
            folders: env::split_paths(&own)
                .chain(standard.iter().map(PathBuf::from))
                .collect(),
        }
    }

    fn find(&self, name: &str) -> Option<PathBuf> {
        let in_folder = self.folders.iter().map(|folder| folder.join(name));
        in_folder
            .into_iter()
            .find(|path| path.is_file())
            .or_else(|| in_cache(&self.cache, name))
    }
}

/// The path of a library in the output of `ldconfig -p`, whose lines read `name (kind) => path`.
fn in_cache(cache: &str, name: &str) -> Option<PathBuf> {
    cache
        .lines()
        .filter_map(|line| line.trim().split_once(" => "))
        .find(|(key, _)| key.split_whitespace().next() == Some(name))
        .map(|(_, path)| PathBuf::from(path))
        .filter(|path| path.exists())
}

/// Debian 12 ships a Mesa whose software driver is slow with large kernels; its backports have a better one.
fn hint_at_newer_mesa() {
    let version = Step::new("dpkg-query")
        .args(["-W", "-f", "${Version}", PACKAGES[0]])
        .output();
    if version.starts_with("22.") {
        println!(
            "Mesa {version} works. Where there is no GPU, Mesa 25 is faster:\n\
             on Debian 12, `apt-get install -t bookworm-backports {}` once backports are enabled.",
            PACKAGES[0]
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_of_a_manifest_is_found() {
        let manifest = r#"{
            "ICD": { "api_version": "1.3.230",
                     "library_path" : "/usr/lib/x86_64-linux-gnu/libvulkan_lvp.so" },
            "file_format_version": "1.0.0"
        }"#;
        assert_eq!(
            library_path(manifest),
            Some("/usr/lib/x86_64-linux-gnu/libvulkan_lvp.so")
        );
        for broken in [
            "",
            "{}",
            r#"{ "library_path" }"#,
            r#""library_path": """#,
            r#""library_path": "x"#,
        ] {
            assert_eq!(library_path(broken), None, "{broken}");
        }
    }

    #[test]
    fn a_cached_library_counts_only_if_it_exists() {
        let here = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
        let cache = format!(
            "3 libs found in cache\n\tlibvulkan.so.1 (libc6,x86-64) => {here}\n\tlibgone.so (libc6) => /gone.so\n"
        );
        assert_eq!(in_cache(&cache, "libvulkan.so.1"), Some(here.into()));
        assert_eq!(in_cache(&cache, "libvulkan.so"), None);
        assert_eq!(in_cache(&cache, "libgone.so"), None);
    }

    #[test]
    fn manifests_are_files_or_lie_in_folders() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let file = folder.join("Cargo.toml");
        assert_eq!(json_files(&file), [file]);
        assert!(
            json_files(&folder.join("src")).is_empty(),
            "no JSON in there"
        );
        assert!(json_files(Path::new("/no/such/place")).is_empty());
    }

    /// apt says what it would do; what it would upgrade it lists with the present version in brackets.
    #[test]
    fn installing_upgrades_nothing() {
        let would = Step::new("apt-get")
            .args(["--simulate"])
            .args(INSTALL)
            .args(PACKAGES)
            .output();
        if would.is_empty() {
            eprintln!("skipped: there is no apt-get, or it knows no packages");
            return;
        }
        let upgrades: Vec<_> = would
            .lines()
            .filter(|line| {
                PACKAGES
                    .iter()
                    .any(|p| line.starts_with(&format!("Inst {p} [")))
            })
            .collect();
        assert!(upgrades.is_empty(), "{upgrades:?}");
    }
}
