//! A program that ended while a texture kernel was built: the next start finds the marker, builds the textures one by one
//! and goes on where none is to blame. The cache of pipelines lies beside it.

#[path = "../engine/tests/suite/support/mod.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod support;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use ::device::{Device, DeviceChoice, DeviceOptions};

fn names(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        entry
            .expect("an entry")
            .file_name()
            .to_string_lossy()
            .into_owned()
    };
    entries.map(name).collect()
}

#[cfg(unix)]
#[test]
fn the_stack_of_the_first_thread_may_be_small() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // As it is where the memory that it would grow into is taken. A shell that can't set it leaves it as it is.
    let line = "ulimit -s 512 2>/dev/null; exec \"$0\" \"$@\"";
    let ended = Command::new("sh")
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["-c", line, env!("CARGO_BIN_EXE_patina")])
        .args(["render", "examples/demo/demo.gltf", "--device", "native"])
        .args(["--size", "8x8", "--spp", "1", "-o"])
        .arg(folder.path().join("a.png"))
        .env("PATINA_CACHE", "off")
        .stdin(Stdio::null())
        .output()
        .expect("sh starts");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{}: {said}", ended.status);
}

fn render(cache: &Path, out: &Path) -> Command {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_patina"));
    command
        .current_dir(root)
        .args(["render", "examples/demo/demo.gltf"])
        .args(["--look", "examples/demo/demo.look.toml"])
        .args(["--size", "16x16", "--spp", "1", "-o"])
        .arg(out)
        .env("PATINA_CACHE", cache)
        .stdin(Stdio::null());
    command
}

#[test]
fn a_build_that_ended_the_program_is_looked_into_at_the_next_start() {
    if support::device::open().is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (cache, out) = (folder.path().join("cache"), folder.path().join("a.png"));
    // An empty one is still being written: nothing has been built then.
    let stands = |name: &String| {
        let marker = std::fs::metadata(cache.join(name));
        name.starts_with("building_") && marker.is_ok_and(|marker| marker.len() > 0)
    };
    let marker = || names(&cache).iter().any(stands);

    // Ended from outside while it builds: the marker stays.
    let mut child = render(&cache, &out)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("patina starts");
    let start = Instant::now();
    while !marker() {
        assert!(start.elapsed() < Duration::from_secs(120), "no marker");
        assert!(child.try_wait().expect("a child").is_none(), "too fast");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().expect("it runs");
    child.wait().expect("it has ended");
    assert!(marker());

    let run = || render(&cache, &out).output().expect("patina starts");
    let second = run();
    let said = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(second.status.success(), "none is to blame: {said}");
    assert!(said.contains("ended without a word"), "{said}");
    let left: Vec<_> = names(&cache);
    assert!(
        !left.iter().any(|name| name.starts_with("building_")),
        "all went well, but there is {left:?}"
    );

    let third = run();
    let said = String::from_utf8_lossy(&third.stderr);
    assert!(
        third.status.success() && !said.contains("ended without a word"),
        "{said}"
    );
}

#[test]
fn compiled_pipelines_are_kept_where_the_device_offers_it() {
    if support::device::open_driver().is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let cached = || {
        let options = DeviceOptions::new(&DeviceChoice::Driver).with_cache(Some(folder.path()));
        Device::open_with(&options).expect("there is one")
    };
    let device = cached();
    device.save_cache().expect("the folder can be written");
    let files = names(folder.path());
    if !device.has_cache() {
        assert!(files.is_empty(), "{files:?}");
        return;
    }
    assert_eq!(files.len(), 1, "{files:?}");
    // Whatever is in the file, the device opens.
    let file = folder.path().join(&files[0]);
    let whole = std::fs::read(&file).expect("there");
    for broken in [
        b"".to_vec(),
        vec![7; 100],
        whole[..whole.len() / 2].to_vec(),
    ] {
        std::fs::write(&file, broken).expect("written");
        let device = cached();
        device.save_cache().expect("the folder can be written");
        assert_eq!(std::fs::read(&file).expect("there").len(), whole.len());
    }
    let off = Device::open(&DeviceChoice::Driver).expect("there is one");
    assert!(!off.has_cache());
}
