//! The packed program: a `.tar.gz` with one folder, to be unpacked anywhere.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

use anyhow::{Context, Result, bail};
use flate2::{Compression, write::GzEncoder};
use tar::{Builder, Header};

use crate::metadata::Metadata;
use crate::policy::Policy;
use crate::{licences, platform, root};

/// Folders of the checkout that go with the program: what it can be tried with and how textures and looks are written.
/// Without the library's textures, which are in the program: beside it they would count as the user's own.
const FOLDERS: [&str; 4] = [
    "docs",
    "examples/demo",
    "examples/gallery",
    "examples/window_room",
];
const FILES: [&str; 7] = [
    "README.md",
    "CHANGELOG.md",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "examples/render_gltf.rs",
    "examples/sponza-rust.look.toml",
    "examples/sponza-scratches.look.toml",
];

/// Packs a program that has been built, and returns the archive's path.
///
/// # Errors
/// The program doesn't run, a licence is not known, or a file can't be read or written.
pub(crate) fn pack(program: &Path, folder: &Path) -> Result<PathBuf> {
    let platform = platform()?;
    let name = format!("patina-{}-{platform}", env!("CARGO_PKG_VERSION"));
    let mut files: BTreeMap<PathBuf, Content> = BTreeMap::new();
    let executable = format!("patina{}", std::env::consts::EXE_SUFFIX);
    files.insert(executable.into(), Content::Program(program.to_owned()));
    for file in FILES {
        files.insert(file.into(), Content::File(root().join(file)));
    }
    for folder in FOLDERS {
        add(&root().join(folder), Path::new(folder), &mut files)?;
    }
    files.insert(
        "LICENCES-OF-OTHERS.txt".into(),
        Content::Text(others(&platform)?),
    );
    if let Some(page) = standard_library() {
        files.insert("LICENCES-OF-RUST.html".into(), Content::File(page));
    }

    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let manuals = folder.join(format!("{name}.manuals"));
    let written =
        write_manuals(program, &manuals).and_then(|()| add(&manuals, Path::new(""), &mut files));
    let path = folder.join(format!("{name}.tar.gz"));
    // A former archive stays whole until the new one is.
    let aside = folder.join(format!("{name}.tar.gz.part"));
    let packed = written.and_then(|()| {
        write(&aside, Path::new(&name), &files)
            .and_then(|()| Ok(fs::rename(&aside, &path)?))
            .with_context(|| format!("cannot write {}", path.display()))
    });
    let _ = fs::remove_file(&aside);
    let _ = fs::remove_dir_all(&manuals);
    packed.map(|()| path)
}

enum Content {
    Program(PathBuf),
    File(PathBuf),
    Text(String),
}

/// All files below a folder.
fn add(folder: &Path, name: &Path, files: &mut BTreeMap<PathBuf, Content>) -> Result<()> {
    let entries =
        fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    for entry in entries {
        let path = entry?.path();
        let name = name.join(path.file_name().unwrap_or_default());
        match path.is_dir() {
            true => add(&path, &name, files)?,
            false => {
                files.insert(name, Content::File(path));
            }
        }
    }
    Ok(())
}

fn write_manuals(program: &Path, folder: &Path) -> Result<()> {
    let written = Command::new(program).arg("manuals").arg(folder).status();
    let written = written.with_context(|| format!("cannot start {}", program.display()))?;
    if !written.success() {
        bail!("{} can't write its manuals", program.display());
    }
    Ok(())
}

/// Licences of all that is linked.
fn others(platform: &str) -> Result<String> {
    let policy = Policy::read()?;
    let metadata = Metadata::read(root(), Some(platform))?;
    let packages = licences::collect(&metadata.linked("patina")?, policy.licences())?;
    Ok(packages + &licences::of_data()?)
}

/// What the toolchain says of its standard library, which is in every program.
fn standard_library() -> Option<PathBuf> {
    let output = Command::new("rustc").args(["--print", "sysroot"]).output();
    let sysroot = String::from_utf8(output.ok()?.stdout).ok()?;
    let page = Path::new(sysroot.trim()).join("share/doc/rust/COPYRIGHT-library.html");
    page.is_file().then_some(page)
}

fn write(path: &Path, folder: &Path, files: &BTreeMap<PathBuf, Content>) -> Result<()> {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH)?;
    let file = File::create(path)?;
    let mut archive = Builder::new(GzEncoder::new(file, Compression::default()));
    for (name, content) in files {
        let (bytes, mode) = match content {
            Content::Program(path) => (read(path)?, 0o755),
            Content::File(path) => (read(path)?, 0o644),
            Content::Text(text) => (text.clone().into_bytes(), 0o644),
        };
        // Owner, rights and times of the machine that packs are nobody's business.
        let mut header = Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(mode);
        header.set_mtime(now.as_secs());
        archive.append_data(&mut header, folder.join(name), bytes.as_slice())?;
    }
    archive.into_inner()?.finish()?.sync_all()?;
    Ok(())
}

fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    use flate2::read::GzDecoder;

    /// The program of the test build, which Cargo puts beside the tests where it builds the whole workspace.
    fn program() -> Option<PathBuf> {
        let tests = std::env::current_exe().expect("the path of this test");
        let program = format!("patina{}", std::env::consts::EXE_SUFFIX);
        let program = tests.parent()?.parent()?.join(program);
        program.is_file().then_some(program)
    }

    fn run(program: &Path, folder: &Path, line: &str) -> Result<String, String> {
        let output = Command::new(program)
            .args(line.split_whitespace())
            .current_dir(folder)
            .env("PATINA_CACHE", "off")
            .output()
            .expect("the unpacked program starts");
        match output.status.success() {
            true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
            false => Err(String::from_utf8_lossy(&output.stderr).into_owned()),
        }
    }

    /// Links of the README and of `docs` to what isn't in a folder.
    fn broken_links(root: &Path) -> Vec<String> {
        let docs = fs::read_dir(root.join("docs")).expect("it is packed");
        let docs = docs.map(|entry| entry.expect("an entry").path());
        let pages = docs.filter(|path| path.extension().is_some_and(|e| e == "md"));
        let mut broken = Vec::new();
        for page in pages.chain([root.join("README.md")]) {
            let text = fs::read_to_string(&page).expect("it is packed");
            let links = text
                .split("](")
                .skip(1)
                .filter_map(|rest| rest.split([')', '#']).next());
            for link in links.filter(|link| !link.is_empty() && !link.contains("://")) {
                let target = page.parent().expect("a folder").join(link);
                if !target.exists() {
                    broken.push(format!("{}: {link}", page.display()));
                }
            }
        }
        broken
    }

    #[test]
    fn links_of_the_docs_lead_to_what_is_packed() {
        // As in the archive, without a program.
        let folder = tempfile::tempdir().expect("a folder");
        let mut files = BTreeMap::new();
        for file in FILES {
            files.insert(PathBuf::from(file), Content::File(root().join(file)));
        }
        for folder in FOLDERS {
            add(&root().join(folder), Path::new(folder), &mut files).expect("it is there");
        }
        for name in files.keys() {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("it can be made");
            fs::copy(root().join(name), path).expect("it can be copied");
        }
        let broken = broken_links(folder.path());
        assert!(broken.is_empty(), "{}", broken.join("\n"));
    }

    #[test]
    fn the_packed_program_renders_the_example_scene_wherever_it_is_unpacked() {
        let Some(built) = program() else {
            eprintln!("skipped: there is no program to pack (`cargo test --workspace` builds it)");
            return;
        };
        let [made, unpacked, empty] = [(); 3].map(|()| tempfile::tempdir().expect("a folder"));
        let archive = pack(&built, made.path()).expect("it can be packed");
        assert_eq!(
            fs::read_dir(&made).expect("a folder").count(),
            1,
            "nothing else is left"
        );
        let archive = GzDecoder::new(File::open(archive).expect("the archive"));
        let mut archive = tar::Archive::new(archive);
        archive.unpack(&unpacked).expect("it can be unpacked");
        let mut entries = fs::read_dir(&unpacked).expect("a folder");
        let root = entries
            .next()
            .expect("one folder")
            .expect("an entry")
            .path();
        assert!(entries.next().is_none(), "one folder");
        for file in [
            "LICENSE-MIT",
            "LICENCES-OF-OTHERS.txt",
            "man/man1/patina.1",
            "man/man1/patina-texture-new.1",
            "completions/patina.bash",
            "completions/_patina",
            "completions/patina.fish",
            "docs/look-file.md",
        ] {
            assert!(root.join(file).is_file(), "{file}");
        }
        let broken = broken_links(&root);
        assert!(broken.is_empty(), "{}", broken.join("\n"));
        let program = root.join(built.file_name().expect("a name"));
        let list = run(&program, empty.path(), "texture list").expect("textures");
        assert!(list.contains("rust_mask -> f32  (built in)"), "{list}");
        if let Err(why) = run(&program, empty.path(), "devices") {
            assert!(std::env::var_os("PATINA_REQUIRE_DEVICE").is_none(), "{why}");
            eprintln!("skipped: no device can render");
            return;
        }
        let demo = root.join("examples/demo");
        let line = format!(
            "render {0}/demo.gltf --look {0}/demo.look.toml --size 32x18 --spp 1 -o demo.png",
            demo.display()
        );
        run(&program, empty.path(), &line).expect("it renders");
        assert!(empty.path().join("demo.png").is_file());
    }
}
