//! Files that must not be lost: what was read is never overwritten, and what was rendered is kept.

use super::*;

/// The triangle with an image that is beside it.
fn painted() -> Bench {
    let bench = Bench::new();
    let images = "\"images\": [{ \"uri\": \"paint.png\" }],\n  \"textures\": [{ \"source\": 0 }],\n  \"materials\": [";
    let scene = TRIANGLE.replace("\"materials\": [", images).replace(
        "\"metallicFactor\": 0",
        "\"baseColorTexture\": { \"index\": 0 }",
    );
    fs::write(bench.path("painted.gltf"), scene).expect("written");
    let paint = image::RgbImage::from_pixel(2, 2, image::Rgb([200, 100, 50]));
    paint.save(bench.path("paint.png")).expect("written");
    fs::create_dir(bench.path("user_textures")).expect("a folder");
    let texture = "fn userProc(photo: sam2D) -> vec3f { return tex2D(photo, vec2f(0.5)).rgb; }\n";
    fs::write(bench.path("user_textures/t.wgsl"), texture).expect("written");
    fs::create_dir(bench.path("user_textures/lib")).expect("a folder");
    for unused in ["user_textures/other.wgsl", "user_textures/lib/shared.wgsl"] {
        fs::write(bench.path(unused), texture).expect("written");
    }
    let look =
        "[node.t]\ntexture = \"t\"\nphoto = \"photo.png\"\n[material.Glow]\nbase_color = \"t\"\n";
    fs::write(bench.path("a.look.toml"), look).expect("written");
    paint.save(bench.path("photo.png")).expect("written");
    bench
}

#[test]
fn what_a_scene_was_made_of_is_not_overwritten() {
    let bench = painted();
    fs::create_dir(bench.path("below")).expect("a folder");
    fs::hard_link(bench.path("paint.png"), bench.path("hard.png")).expect("a hard link");
    let mut outputs = vec!["paint.png", "below/../paint.png", "hard.png"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("paint.png", bench.path("soft.png")).expect("a link");
        outputs.push("soft.png");
    }
    let before = fs::read(bench.path("paint.png")).expect("there");
    for output in outputs {
        bench
            .run(&format!(
                "render painted.gltf --size 8x8 --spp 1 -o {output}"
            ))
            .expect_error(2, output);
    }
    let look = "render triangle.gltf --look a.look.toml --size 8x8 --spp 1";
    for line in [
        "-o photo.png",
        "--stats-json user_textures/t.wgsl",
        // The look doesn't use them.
        "--stats-json user_textures/other.wgsl",
        "--stats-json user_textures/lib/shared.wgsl",
        "--stats-json below/../a.look.toml",
        "--stats-json ./triangle.gltf",
    ] {
        bench
            .run(&format!("{look} {line}"))
            .expect_error(2, "is an input");
    }
    for line in [
        "texture preview t --look a.look.toml -o photo.png",
        "bench render painted.gltf --json below/../paint.png",
        "bench render --json user_textures/t.wgsl",
        "texture doc -o user_textures/t.wgsl",
        "texture doc -o user_textures/lib/shared.wgsl",
        "watch painted.gltf -o ./below/../paint.png",
        "merge triangle.gltf -o below/../triangle.gltf.patina-film -o ./triangle.gltf.patina-film",
    ] {
        bench.run(line).expect_code(2);
    }
    assert_eq!(fs::read(bench.path("paint.png")).expect("there"), before);
    for texture in ["t", "other", "lib/shared"] {
        let path = bench.path(&format!("user_textures/{texture}.wgsl"));
        let text = fs::read_to_string(path).expect("there");
        assert!(text.contains("userProc"), "{texture}");
    }
}

#[cfg(unix)]
#[test]
fn an_output_that_is_a_link_stays_one() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    fs::create_dir(bench.path("below")).expect("a folder");
    std::os::unix::fs::symlink("below/real.png", bench.path("a.png")).expect("a link");
    let line = "render triangle.gltf --size 8x8 --spp 1 -o a.png";
    bench.run(line).expect_code(0);
    let link = fs::symlink_metadata(bench.path("a.png")).expect("there");
    assert!(link.file_type().is_symlink());
    image::open(bench.path("below/real.png")).expect("a picture");
    let long = "x".repeat(300);
    bench
        .run(&format!("render no/such.glb -o {long}.png"))
        .expect_error(1, "cannot write");
}

#[test]
fn what_one_device_keeps_alone_is_named_as_it_was_asked_for() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    for flag in ["--resume", "--refresh", "--checkpoint=5m"] {
        let name = flag.split('=').next().expect("a word");
        bench
            .run(&format!(
                "render triangle.gltf --size 8x8 --spp 1 --device native:1,native:1 {flag} -o a.png"
            ))
            .expect_error(2, &format!("{name} needs a single device"));
    }
}

#[cfg(unix)]
#[test]
fn a_file_that_is_too_large_for_a_limit_costs_no_other() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    // 96 KiB of numbers; the limit is 20 or 40 KiB.
    let line =
        "render triangle.gltf --size 128x128 --spp 1 --exr-compression none -o a.exr -o a.png";
    let mut limited = Command::new("sh");
    limited
        .args(["-c", "ulimit -f 40; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_patina"))
        .args(line.split(' '))
        .current_dir(&bench.dir)
        .env("PATINA_CACHE", "off")
        .env("TMPDIR", bench.dir.path())
        .stdin(Stdio::null());
    let ended = Outcome::of(limited.output().expect("sh starts"), line);
    ended.expect_error(1, "a.exr");
    image::open(bench.path("a.png")).expect("a picture");
    assert!(!bench.path("a.exr").exists());
}

#[cfg(unix)]
#[test]
fn samples_are_kept_where_the_picture_can_not_be_written() {
    if !device() {
        return;
    }
    for seconds in [3, 10, 40] {
        let bench = Bench::new();
        fs::create_dir(bench.path("out")).expect("a folder");
        let line = "render triangle.gltf --size 64x64 --spp 1000000 --checkpoint=0.05 -o out/a.png";
        let child = bench
            .command(line)
            .env("TMPDIR", bench.dir.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("patina starts");
        std::thread::sleep(std::time::Duration::from_secs(seconds));
        // At once, whatever is being written there.
        fs::rename(bench.path("out"), bench.path("gone")).expect("renamed");
        std::thread::sleep(std::time::Duration::from_millis(500));
        let is_sent = kill(&["-INT", &child.id().to_string()]);
        assert!(is_sent, "it still runs");
        let ended = Outcome::of(child.wait_with_output().expect("it ends"), line);
        if ended.code == Some(130) {
            continue;
        }
        let ended = ended.expect_error(1, "patina merge ");
        // The first one that can't be written may fail otherwise than those after it, which are all alike.
        let told = ended.stderr.matches("no checkpoint").count();
        assert!((1..=2).contains(&told), "{}", ended.stderr);
        assert!(
            bench.path("a.kept.patina-film").exists(),
            "{}",
            ended.stderr
        );
        let (_, command) = ended
            .stderr
            .split_once("patina merge ")
            .expect("it is there");
        fs::create_dir(bench.path("out")).expect("a folder");
        bench
            .run(&format!("merge {}", command.trim()))
            .expect_code(0);
        image::open(bench.path("out/a.png")).expect("a picture");
        return;
    }
    panic!("40 s into a render there was no sample");
}
