//! What ends a render, keeps it and goes on with it; what a command line says in place of the look.

use super::endings::signal_again;
use super::*;

/// A lit scene that is noisy: the triangle under a sky, with a rough surface.
const SKY: &str = "environment = { color = [0.5, 0.6, 0.9] }\n[material.Glow]\nemission = [0.1, 0.1, 0.1]\nroughness = 0.4\n";

fn sky() -> Bench {
    let bench = Bench::new();
    fs::write(bench.path("sky.look.toml"), SKY).expect("written");
    bench
}

#[test]
fn noise_and_time_end_a_render_and_say_so() {
    if !device() {
        return;
    }
    let bench = sky();
    let line = "render triangle.gltf --look sky.look.toml --size 32x32 --noise 0.2 -o a.png";
    let ended = bench.run(line).expect_code(0);
    assert!(
        ended.stdout.contains("ended by --noise 0.2"),
        "{}",
        ended.stdout
    );
    let line = "render triangle.gltf --look sky.look.toml --size 512x512 --time 2s -o b.png --stats --stats-json b.json";
    let said = bench.run(line).expect_code(0).stdout;
    assert!(said.contains("ended by --time 2s"), "{said}");
    // Nobody has asked for the most samples that there may be.
    assert!(!said.contains("1048576"), "{said}");
    let stats = fs::read_to_string(bench.path("b.json")).expect("written");
    let stats: serde_json::Value = serde_json::from_str(&stats).expect("JSON");
    assert_eq!(stats["samples_per_pixel"], serde_json::Value::Null);
    let line = "render triangle.gltf --size 16x16 --spp 4 --noise 1e-9 -o c.png";
    let ended = bench.run(line).expect_code(0);
    assert!(ended.stdout.contains("after 4 samples"), "{}", ended.stdout);
    let refused = bench.run("render triangle.gltf --time soon").expect_code(2);
    assert!(refused.stderr.contains("10m"), "{}", refused.stderr);
    bench.run("render triangle.gltf --noise 0").expect_code(2);
}

#[test]
fn a_black_picture_is_without_noise() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let dark = "environment = { color = [0, 0, 0] }\n[material.Glow]\nemission = [0, 0, 0]\n";
    fs::write(bench.path("dark.look.toml"), dark).expect("written");
    for flags in ["", "--adaptive", "--device native:1,native:1"] {
        let line = format!(
            "render triangle.gltf --look dark.look.toml --size 16x16 --noise 0.02 {flags} -o a.png"
        );
        let said = bench.run(&line).expect_code(0).stdout;
        assert!(said.contains("ended by --noise 0.02"), "{flags}: {said}");
    }
}

#[test]
fn time_leaves_no_pixel_without_a_sample() {
    if !device() {
        return;
    }
    let bench = sky();
    let scene = "render triangle.gltf --look sky.look.toml --size 1024x1024";
    for flags in [
        "",
        "--method photons",
        "--device native:1,native:1",
        "--device native:1,native:1 --method photons",
    ] {
        let line = format!("{scene} --spp 64 --time 0.000001s {flags} -o a.png");
        let said = bench.run(&line).expect_code(0).stdout;
        assert!(said.contains("ended by --time"), "{flags}: {said}");
        assert!(!said.contains("after 0 samples"), "{flags}: {said}");
    }
    // Threads that take several samples of a pixel at once begin with one of each, and it suffices.
    let small = scene.replace("1024x1024", "64x64");
    let line = format!("{small} --spp 4096 --time 0.000001s --device native -o c.png");
    let said = bench.run(&line).expect_code(0).stdout;
    assert!(said.contains("after 1 samples per pixel"), "{said}");
    // A round of all pixels takes too long to be waited for.
    let line = format!("{scene} --spp 256 --adaptive --time 0.000001s -o b.png");
    let warned = bench.run(&line).expect_code(0).stderr;
    assert!(warned.contains("those without any are black"), "{warned}");
}

#[test]
fn a_render_ends_when_little_of_its_noise_is_seen() {
    if !device() {
        return;
    }
    let bench = sky();
    let scene = "render triangle.gltf --look sky.look.toml --size 64x48";
    bench
        .run(&format!("{scene} --spp 4096 --seed 9 -o truth.exr"))
        .expect_code(0);
    for flags in ["", "--device native:1,native:1", "--adaptive"] {
        let line = format!("{scene} --flip 0.01 {flags} -o a.exr");
        let ended = bench.run(&line).expect_code(0);
        let said = &ended.stdout;
        assert!(said.contains("ended by --flip 0.01"), "{flags}: {said}");
        let claim = said.split(" of the noise seen (FLIP)").next();
        let claim = claim.and_then(|text| text.split_whitespace().last());
        let claim: f64 = claim.expect("said").parse().expect("a number");
        let compared = bench.run("compare a.exr truth.exr").expect_code(0);
        let line = compared.stdout.lines().find(|line| line.contains("FLIP"));
        let known = line.and_then(|line| line.split_whitespace().last());
        let known: f64 = known.expect("said").parse().expect("a number");
        assert!(claim < 0.01, "{flags}: {claim}");
        // The noise has one seed, and the truth has some, too.
        let off = (known - claim).abs();
        assert!(off < 0.3 * claim + 0.0005, "{flags}: {claim}, {known}");
    }
    let line = format!("{scene} --flip 1e-9 --spp 40 -o c.png");
    let ended = bench.run(&line).expect_code(0);
    assert!(
        ended.stdout.contains("after 40 samples"),
        "{}",
        ended.stdout
    );
    let refused = bench.run("render triangle.gltf --flip 3").expect_code(2);
    assert!(refused.stderr.contains("less than 1"), "{}", refused.stderr);
    for other in ["--part 1/2", "--shutter 0.5"] {
        bench
            .run(&format!("render triangle.gltf --flip 0.1 {other}"))
            .expect_code(2);
    }
}

#[test]
fn an_adaptive_render_says_where_it_ended() {
    if !device() {
        return;
    }
    let bench = sky();
    let scene = "render triangle.gltf --look sky.look.toml --size 52x40";
    let line = format!("{scene} --adaptive --noise 0.004 --spp 4096 -o a.exr --layers samples");
    let ended = bench.run(&line).expect_code(0);
    let said = &ended.stdout;
    assert!(
        said.contains("samples per pixel on average, 64 to"),
        "{said}"
    );
    assert!(said.contains("ended by --noise 0.004"), "{said}");
    let line = format!("{scene} --adaptive --spp 96 -o b.png");
    let ended = bench.run(&line).expect_code(0);
    assert!(
        ended.stdout.contains("on average, 32 to"),
        "{}",
        ended.stdout
    );
    let part = format!("{scene} --adaptive --part 1/2");
    bench.run(&part).expect_code(2);
    let several = format!("{scene} --adaptive --device native:1,native:1");
    let refused = bench.run(&several).expect_code(2);
    assert!(
        refused.stderr.contains("--adaptive needs a single device"),
        "{}",
        refused.stderr
    );
}

#[test]
fn even_films_go_on_adaptively_and_not_the_other_way_round() {
    if !device() {
        return;
    }
    let bench = sky();
    let scene = "render triangle.gltf --look sky.look.toml --size 52x40 --flip 0.0001";
    let run = |flags: &str| bench.run(&format!("{scene} {flags} -o a.exr -o a.patina-film"));
    // Neither a multiple of what blocks get at once, nor as many as they begin with.
    run("--spp 40").expect_code(0);
    let ended = run("--spp 256 --adaptive --resume").expect_code(0);
    let said = &ended.stdout;
    assert!(said.contains("on average"), "{said}");
    assert!(!said.contains("40 to"), "{said}");
    run("--spp 512 --resume").expect_error(1, "as --adaptive gives them");
}

#[test]
fn a_draft_says_how_wrong_it_is() {
    if !device() {
        return;
    }
    let bench = sky();
    let scene = "render triangle.gltf --look sky.look.toml --size 48x40 --method draft";
    let ended = bench
        .run(&format!("{scene} --spp 32 -o a.png"))
        .expect_code(0);
    let said = &ended.stdout;
    assert!(said.contains("biased: brightness off by"), "{said}");
    bench
        .run(&format!("{scene} --spp 2 -o b.png"))
        .expect_code(0);
    bench
        .run(&format!("{scene} --adaptive --spp 64 -o c.png"))
        .expect_code(0);
    // Devices and parts each find out what they need, so all of that goes.
    for method in ["draft", "cache", "photons", "cache+photons"] {
        let scene = scene.replace("draft", method);
        let distributed = bench.run(&format!("{scene} --adaptive --spp 64 -o f.png"));
        match method.contains("photons") {
            true => distributed.expect_error(2, &format!("--method {method}")),
            false => distributed.expect_code(0),
        };
        bench
            .run(&format!("{scene} --clamp 2 --spp 4 --layers diffuse_direct,glossy_indirect,light_groups,shadow_catcher -o g.exr"))
            .expect_code(0);
        let ended = bench
            .run(&format!(
                "{scene} --spp 32 --device native:1,native:1 -o d.exr"
            ))
            .expect_code(0);
        let said = &ended.stdout;
        assert!(said.contains("biased: brightness off by"), "{said}");
        let part = format!("{scene} --device native --spp 32 --part");
        for number in ["1/2", "2/2"] {
            let name = number.replace('/', "-");
            bench
                .run(&format!("{part} {number} -o {name}.patina-film"))
                .expect_code(0);
        }
        bench
            .run("merge 1-2.patina-film 2-2.patina-film -o e.exr")
            .expect_code(0);
        bench.run("compare d.exr e.exr --max-mse 0").expect_code(0);
    }
    let refused = bench.run("render triangle.gltf --accuracy final --part 1/2 -o c.patina-film");
    refused.expect_error(2, "rendered again as a whole");
    bench
        .run(&format!(
            "{scene} --spp 4 --checkpoint=1s -o h.exr -o h.patina-film"
        ))
        .expect_code(0);
    bench
        .run(&format!(
            "{scene} --spp 64 --resume -o h.exr -o h.patina-film"
        ))
        .expect_error(1, "from 32 samples per pixel on");
    let clamped = bench.run(
        &format!("{scene} --spp 32 --clamp 2 -o c.png").replace("method draft", "accuracy final"),
    );
    let said = &clamped.expect_code(0).stdout;
    assert!(said.contains("beside what --clamp takes away"), "{said}");
    let groups = "environment = { color = [1.0, 1.0, 1.0], group = \"day\" }\n";
    fs::write(bench.path("groups.look.toml"), groups).expect("written");
    let grouped = scene.replace("sky.look.toml", "groups.look.toml");
    let light = format!("{grouped} --layers light_groups --spp 4 -o c.exr");
    bench.run(&light).expect_error(1, "from which lamps");
}

#[test]
fn accuracy_chooses_how_light_is_found() {
    if !device() {
        return;
    }
    let bench = sky();
    let scene = "render triangle.gltf --look sky.look.toml --size 48x40 --spp 32";
    for (accuracy, is_biased) in [("draft", true), ("final", true), ("reference", false)] {
        let ended = bench
            .run(&format!("{scene} --accuracy {accuracy} -o {accuracy}.png"))
            .expect_code(0);
        let said = &ended.stdout;
        assert_eq!(said.contains("biased:"), is_biased, "{accuracy}: {said}");
    }
    bench
        .run(&format!("{scene} --accuracy final --adaptive -o e.png"))
        .expect_code(0);
    for flags in ["", "--adaptive"] {
        let line = format!("{scene} --accuracy final {flags} --noise 0.5 -o e.png");
        let ended = bench.run(&line.replace("--spp 32", "--spp 256"));
        let said = &ended.expect_code(0).stdout;
        assert!(said.contains("ended by --noise 0.5"), "{said}");
        assert!(said.contains("biased:"), "{said}");
    }
    let by_itself = format!(
        "{} --accuracy final -o f.png",
        scene.replace("--spp 32", "")
    );
    let ended = bench.run(&by_itself).expect_code(0);
    let said = &ended.stdout;
    assert!(said.contains("ended by --flip 0.03"), "{said}");
    assert!(said.contains("biased:"), "{said}");
    let longer = format!("{scene} --accuracy final").replace("--spp 32", "--spp 64");
    let kept = "--checkpoint=1s -o kept.exr -o kept.patina-film";
    bench
        .run(&format!("{scene} --accuracy final {kept}"))
        .expect_code(0);
    bench
        .run(&format!("{longer} --resume {kept}"))
        .expect_code(0);
    bench
        .run(&format!("{longer} -o at-once.exr"))
        .expect_code(0);
    bench
        .run("compare kept.exr at-once.exr --max-mse 0")
        .expect_code(0);
    for (device, name) in [("native", "one"), ("native:1,native:1", "two")] {
        let line = format!("{scene} --accuracy final --device {device} -o {name}.exr");
        bench.run(&line).expect_code(0);
    }
    bench
        .run("compare one.exr two.exr --max-mse 0")
        .expect_code(0);
    bench
        .run(&format!("{scene} --accuracy final --method path"))
        .expect_error(2, "cannot be used with");
}

#[test]
fn methods_are_compared_by_their_time_to_a_good_picture() {
    if !device() {
        return;
    }
    let bench = sky();
    let measure = "bench methods triangle.gltf --look sky.look.toml --size 24x16 --spp 64 --reference-spp 256";
    let ended = bench
        .run(&format!("{measure} -o m.html -o m.json -o m.svg"))
        .expect_code(0);
    for method in [
        "path",
        "adaptive",
        "draft",
        "cache",
        "photons",
        "cache+photons",
    ] {
        assert!(ended.stdout.contains(method), "{}", ended.stdout);
    }
    let page = std::fs::read_to_string(bench.path("m.html")).expect("it was written");
    assert!(page.contains("<svg") && page.contains("data:image/jpeg"));
    let json = std::fs::read_to_string(bench.path("m.json")).expect("it was written");
    assert!(json.contains("\"final_seconds\""), "{json}");
    bench
        .run("bench methods --methods photon")
        .expect_error(2, "photons");
    bench
        .run(&format!("{measure} --reference m.html"))
        .expect_error(1, "m.html");
}

/// The bytes of a film that is rendered at one go.
fn whole(bench: &Bench, line: &str) -> Vec<u8> {
    bench
        .run(&format!("{line} -o whole.patina-film"))
        .expect_code(0);
    fs::read(bench.path("whole.patina-film")).expect("it is there")
}

#[test]
fn a_render_that_is_killed_goes_on_to_the_same_bits() {
    if !device() {
        return;
    }
    let wanted = match std::env::var_os("PATINA_FULL") {
        Some(_) => 50,
        None => 12,
    };
    let plain = "triangle.gltf --look sky.look.toml --size 192x192";
    killed(
        &format!("{plain} --spp 48 --layers normal,depth"),
        wanted,
        500,
    );
    killed(&format!("{plain} --spp 96 --adaptive"), wanted / 4, 500);
    // Most of the time goes by before the first sample: paths that go ahead are none of the picture's.
    let room = "--size 48x30 --spp 32 --method draft";
    killed(&format!("{} {room}", window_room()), wanted / 3, 1000);
}

/// A room of which nearly all light comes through a window.
fn window_room() -> String {
    let room = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/examples/window_room/room.gltf"
    );
    let look = room.replace(".gltf", ".look.toml");
    format!("{room} --look {look}")
}

#[test]
fn what_ends_before_the_first_sample_leaves_nothing() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    for method in ["draft", "cache"] {
        let line = format!(
            "render {} --size 64x40 --method {method} --time 0.01s",
            window_room()
        );
        for output in ["a.patina-film", "a.png --checkpoint=0.001"] {
            bench
                .run(&format!("{line} -o {output}"))
                .expect_error(1, "the time was over before the first sample");
        }
        let left = bench.files();
        assert!(!left.iter().any(|name| name.starts_with('a')), "{left:?}");
    }
}

/// Ends a render at random times, by a signal that it notices or by one that it doesn't, so often, before so many milliseconds are over, and goes on with it.
fn killed(scene: &str, wanted: usize, longest: u64) {
    let bench = sky();
    let line = format!("render {scene}");
    let whole = whole(&bench, &line);
    let resumed = format!("{line} --checkpoint=0.02 --resume -o part.patina-film");
    let mut kills = 0;
    for round in 0..4 * wanted as u64 {
        let mut child = bench
            .command(&resumed)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("patina starts");
        let pause = 60 + ((round * 0x9e37_79b9) >> 7) % longest;
        std::thread::sleep(std::time::Duration::from_millis(pause));
        let is_done = child.try_wait().expect("it is known").is_some();
        if !is_done {
            match round % 3 {
                0 => signal_again(&child, "-INT"),
                _ => child.kill().expect("killed"),
            }
            kills += 1;
        }
        child.wait().expect("it has ended");
        if is_done {
            let film = fs::read(bench.path("part.patina-film")).expect("it is there");
            assert!(film == whole, "after {kills} kills");
            // Begun anew.
            fs::remove_file(bench.path("part.patina-film")).expect("removed");
        }
        if kills >= wanted {
            break;
        }
    }
    assert!(kills >= wanted / 2, "{kills} kills");
    bench.run(&resumed).expect_code(0);
    assert!(
        fs::read(bench.path("part.patina-film")).expect("it is there") == whole,
        "after {kills} kills"
    );
    let leftovers: Vec<_> = bench
        .files()
        .into_iter()
        .filter(|name| name.contains("patina-") && !name.ends_with(".patina-film"))
        .collect();
    assert!(leftovers.len() <= kills, "{leftovers:?}");
}

#[test]
fn a_time_that_a_resumed_draft_cannot_begin_in_is_said_to_be_too_short() {
    if !device() {
        return;
    }
    let bench = sky();
    let line =
        "render triangle.gltf --look sky.look.toml --size 32x24 --method draft -o a.patina-film";
    bench.run(&format!("{line} --spp 64")).expect_code(0);
    let before = fs::read(bench.path("a.patina-film")).expect("it is there");
    let ended = bench
        .run(&format!("{line} --spp 256 --resume --time 0.000001s"))
        .expect_code(0);
    let said = ended.stderr;
    assert!(said.contains("nothing was added"), "{said}");
    assert!(fs::read(bench.path("a.patina-film")).expect("it is there") == before);
}

#[test]
fn what_was_kept_is_gone_on_with_where_it_fits() {
    if !device() {
        return;
    }
    let bench = sky();
    let line = "render triangle.gltf --look sky.look.toml --size 32x24";
    let whole = whole(&bench, &format!("{line} --spp 24"));
    // A film goes on, too, and a merged one.
    bench
        .run(&format!("{line} --sample-range 0..4 -o a.patina-film"))
        .expect_code(0);
    bench
        .run(&format!("{line} --sample-range 4..8 -o b.patina-film"))
        .expect_code(0);
    bench
        .run("merge a.patina-film b.patina-film -o c.patina-film")
        .expect_code(0);
    let ended = bench
        .run(&format!("{line} --spp 24 --resume -o c.patina-film"))
        .expect_code(0);
    assert!(
        ended.stdout.contains("resumed c.patina-film: 8 samples"),
        "{}",
        ended.stdout
    );
    assert!(fs::read(bench.path("c.patina-film")).expect("it is there") == whole);
    // So does one whose ending is written in other letters.
    let film = "-o e.PATINA-FILM";
    bench.run(&format!("{line} --spp 8 {film}")).expect_code(0);
    let ended = bench.run(&format!("{line} --spp 24 --resume {film}"));
    let said = ended.expect_code(0).stdout;
    assert!(said.contains("resumed e.PATINA-FILM: 8 samples"), "{said}");
    assert!(fs::read(bench.path("e.PATINA-FILM")).expect("it is there") == whole);
    // The checkpoint of a picture has its name, and stays.
    bench
        .run(&format!("{line} --spp 8 --checkpoint --refresh -o d.png"))
        .expect_code(0);
    bench
        .run(&format!("{line} --spp 24 --resume -o d.png"))
        .expect_code(0);
    assert!(fs::read(bench.path("d.patina-film")).expect("it is there") == whole);
    for (other, named) in [
        ("render triangle.gltf --size 32x24", "scene"),
        (
            "render triangle.gltf --look sky.look.toml --size 24x24",
            "size",
        ),
        (
            "render triangle.gltf --look sky.look.toml --size 32x24 --seed 1",
            "seed",
        ),
    ] {
        let refused = bench
            .run(&format!("{other} --resume -o d.png"))
            .expect_code(1);
        assert!(
            refused.stderr.contains("cannot resume")
                && refused.stderr.contains(&format!("{named} was ")),
            "{}",
            refused.stderr
        );
    }
    fs::write(bench.path("d.patina-film"), "damaged").expect("written");
    bench
        .run(&format!("{line} --resume -o d.png"))
        .expect_code(1);
    let refused = bench
        .run(&format!(
            "{line} --resume --device native:1,native:1 -o d.png"
        ))
        .expect_code(2);
    assert!(
        refused.stderr.contains("single device"),
        "{}",
        refused.stderr
    );
}

#[test]
fn a_command_line_overrides_the_look() {
    if !device() {
        return;
    }
    let bench = sky();
    let line = "render triangle.gltf --size 16x16 --spp 4";
    let mut given = bench.command(&format!("{line} --look sky.look.toml -o a.png"));
    given.args([
        "--set",
        "material.Glow.emission=[0.7, 0.2, 0.1]",
        "--set",
        "environment.color=[0, 0, 0]",
    ]);
    Outcome::of(given.output().expect("patina starts"), line).expect_code(0);
    let other = SKY
        .replace("[0.1, 0.1, 0.1]", "[0.7, 0.2, 0.1]")
        .replace("[0.5, 0.6, 0.9]", "[0, 0, 0]");
    fs::write(bench.path("other.look.toml"), other).expect("written");
    bench
        .run(&format!("{line} --look other.look.toml -o b.png"))
        .expect_code(0);
    let pixels = |name: &str| {
        image::open(bench.path(name))
            .expect("a picture")
            .to_rgb32f()
    };
    assert!(pixels("a.png") == pixels("b.png"));
    // Without a look, too; from elsewhere; in half the size.
    bench.run(&format!("{line} --set material.Glow.emission=[0,0,0] --camera-at 0,0,-3 --look-at 0,0,0 --scale 50% -o c.png")).expect_code(0);
    assert_eq!(pixels("c.png").dimensions(), (8, 8));
    for wrong in [
        "--set nothing.scale=1",
        "--set material.Glow.roughness=2",
        "--camera-at 0,0,3 --look-at 0,0,3",
    ] {
        bench
            .run(&format!("{line} {wrong} -o d.png"))
            .expect_code(1);
    }
    for wrong in [
        "--set scale",
        "--camera-at 1,2",
        "--scale none",
        "--environment missing.hdr --set x",
    ] {
        bench
            .run(&format!("{line} {wrong} -o d.png"))
            .expect_code(2);
    }
    bench
        .run(&format!("{line} --camera all -o e.png"))
        .expect_code(0);
    assert!(
        bench.files().contains(&"e-Front.png".to_owned()),
        "{:?}",
        bench.files()
    );
}
