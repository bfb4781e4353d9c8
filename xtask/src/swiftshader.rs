//! SwiftShader, Google's software driver, as a second opinion: it shares no line with Mesa's. Debian has it only as a part
//! of Chromium, so the package is unpacked into the target folder and nothing is installed.

use std::fs;
use std::path::{Path, PathBuf};

use crate::steps::{Step, root};

/// What its device is called, as far as all versions agree.
pub(crate) const DEVICE: &str = "SwiftShader";

/// The Debian package that holds it.
const PACKAGE: &str = "chromium-common";

/// The manifest, which the library lies beside.
const MANIFEST: &str = "usr/lib/chromium/vk_swiftshader_icd.json";

/// Where the system may have it: beside Debian's Chromium, Fedora's, Arch's.
const INSTALLED: [&str; 3] = [
    "/usr/lib/chromium/vk_swiftshader_icd.json",
    "/usr/lib64/chromium-browser/vk_swiftshader_icd.json",
    "/usr/lib/chromium-browser/vk_swiftshader_icd.json",
];

/// Its manifest for the Vulkan loader; says why where there is none.
pub(crate) fn manifest() -> Option<PathBuf> {
    let folder = root().join("target/swiftshader");
    let unpacked = folder.join(MANIFEST);
    let known = INSTALLED.map(PathBuf::from);
    let mut known = known.into_iter().chain([unpacked.clone()]);
    if let Some(manifest) = known.find(|path| is_whole(path)) {
        return Some(manifest);
    }
    match fetch(&folder) {
        Ok(()) if is_whole(&unpacked) => Some(unpacked),
        Ok(()) => {
            println!("skipped: Debian's {PACKAGE} holds no SwiftShader any more");
            None
        }
        Err(why) => {
            println!("skipped: {why}");
            None
        }
    }
}

fn is_whole(manifest: &Path) -> bool {
    let library = manifest.with_file_name("libvk_swiftshader.so");
    cfg!(target_os = "linux") && manifest.is_file() && library.is_file()
}

/// Downloads and unpacks the package: that takes no privilege.
fn fetch(folder: &Path) -> Result<(), String> {
    let has = |program: &str| Step::new(program).args(["--version"]).succeeds();
    if !has("apt-get") || !has("dpkg-deb") {
        return Err("SwiftShader is fetched on Debian and Ubuntu only".to_owned());
    }
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let download = Step::new("apt-get").args(["download", PACKAGE]);
    if !download.within(folder).succeeds() {
        return Err(format!(
            "apt-get can't download {PACKAGE} (without a network, or its lists are out of date)"
        ));
    }
    let packages = fs::read_dir(folder).map_err(|error| error.to_string())?;
    let package = packages
        .flatten()
        .map(|entry| entry.path())
        .find(|path| path.extension().is_some_and(|ending| ending == "deb"))
        .ok_or("apt-get has downloaded nothing")?;
    let unpacked = Step::new("dpkg-deb")
        .args(["--extract", &package.to_string_lossy(), "."])
        .within(folder)
        .succeeds();
    let _ = fs::remove_file(&package);
    match unpacked {
        true => Ok(()),
        false => Err(format!("{} can't be unpacked", package.display())),
    }
}
