//! Jobs for schedulers: what they write is run here as their machines would.

use super::*;

const FLAGS: &str = "-- --size 24x16 --seed 3 --device native:1";

#[cfg(unix)]
#[test]
fn parts_of_a_farm_make_the_whole_and_what_is_lost_is_made_again() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let whole = "render triangle.gltf --size 24x16 --seed 3 --device native:1 --spp 20 -o whole.patina-film";
    bench.run(whole).expect_code(0);
    let export = |more: &str| {
        bench.run(&format!("farm export --to slurm --spp 20 --parts 3 -o job {more} --result all.patina-film triangle.gltf {FLAGS}"))
    };
    let said = export("").expect_code(0);
    assert!(said.stdout.contains("3 parts"), "{}", said.stdout);
    let path = env!("CARGO_BIN_EXE_patina");
    let folder = Path::new(path)
        .parent()
        .expect("a folder")
        .display()
        .to_string();
    let search = format!("{folder}:{}", std::env::var("PATH").unwrap_or_default());
    let run = |line: &str| {
        let mut words = line.split(' ');
        let mut command = Command::new(words.next().expect("a command"));
        let command = command
            .args(words)
            .current_dir(&bench.dir)
            .env("PATH", &search)
            .env("PATINA_CACHE", "off");
        Outcome::of(command.output().expect("sh starts"), line)
    };
    // The second part is lost, and one was begun: it isn't taken for whole.
    fs::create_dir_all(bench.path("job/begun")).expect("a folder");
    fs::write(bench.path("job/begun/lost-1.patina-film"), "half of it").expect("written");
    run("sh job/part.sh 1").expect_code(0);
    run("sh job/part.sh 3").expect_code(0);
    run("sh job/part.sh 4").expect_code(2);
    let merged = run("sh job/merge.sh").expect_code(1);
    assert!(
        merged.stderr.contains("samples 6..13 are missing"),
        "{}",
        merged.stderr
    );
    let said = export("--missing").expect_code(0);
    assert!(said.stdout.contains("parts"), "{}", said.stdout);
    for part in 1..=3 {
        run(&format!("sh job/part.sh {part}")).expect_code(0);
    }
    run("sh job/merge.sh").expect_code(0);
    let read = |name: &str| fs::read(bench.path(name)).expect("it is there");
    assert!(read("all.patina-film") == read("whole.patina-film"));
    let said = export("--missing").expect_code(0);
    assert!(
        said.stdout.contains("no samples are missing"),
        "{}",
        said.stdout
    );
}

#[test]
fn each_scheduler_gets_files_and_senseless_jobs_are_refused() {
    let bench = Bench::new();
    for (scheduler, file) in [
        ("slurm", "submit.sh"),
        ("openjd", "job.openjd.json"),
        ("opencue", "job.opencue.xml"),
        ("flamenco", "patina.js"),
    ] {
        let line = format!(
            "farm export --to {scheduler} -o {scheduler} --result a.png triangle.gltf {FLAGS}"
        );
        bench.run(&line).expect_code(0);
        let text = fs::read_to_string(bench.path(scheduler).join(file)).expect("it is there");
        assert!(text.contains("16"), "{text}");
    }
    let template = fs::read_to_string(bench.path("openjd/job.openjd.json")).expect("it is there");
    let template: serde_json::Value = serde_json::from_str(&template).expect("JSON");
    assert_eq!(
        template["steps"][1]["dependencies"][0]["dependsOn"],
        "Parts"
    );
    let read = |name: &str| fs::read_to_string(bench.path(name)).expect("it is there");
    let job = read("opencue/job.opencue.xml");
    // A layer of type `Post` would be none of this job's, and wait for nothing of it.
    assert!(
        job.contains("<layer name=\"merge\" type=\"Util\">"),
        "{job}"
    );
    assert!(job.contains("type=\"LAYER_ON_LAYER\""), "{job}");
    // The parts are the script's own: whatever submits it may leave settings out.
    let script = read("flamenco/patina.js");
    assert!(!script.contains("job.settings"), "{script}");
    for wrong in [
        "-- --camera all",
        "-- --checkpoint",
        "-- --spp 3",
        "-- --nonsense",
        "-- --size 0x0",
        "-- -o x.png",
        // What parts would fail by, or end with fewer samples.
        "-- --flip 0.1",
        "-- --adaptive",
        "-- --frames 0..4",
        "-- --turntable 4",
        "-- --accuracy final",
        "-- --quiet",
    ] {
        bench
            .run(&format!(
                "farm export --to slurm -o x --result a.png triangle.gltf {wrong}"
            ))
            .expect_code(2);
    }
    bench
        .run("farm export --to slurm -o x --result a.png triangle.gltf -- --shutter 0.5")
        .expect_error(2, "--part I/N");
    bench
        .run("farm export --to slurm -o x --result a.gif triangle.gltf")
        .expect_code(2);
}

#[test]
fn what_the_merge_would_refuse_is_refused_at_once() {
    let bench = Bench::new();
    fs::write(bench.path("sky.exr"), "a sky").expect("written");
    let own = "environment = { image = \"sky.exr\" }\n";
    fs::write(bench.path("own.look.toml"), own).expect("written");
    fs::write(bench.path("wrong.look.toml"), "[view]\nexposur = 1\n").expect("written");
    for (result, flags, code, said) in [
        ("sky.exr", "--environment sky.exr", 2, "is an input"),
        ("./sky.exr", "--look own.look.toml", 2, "is an input"),
        ("job/00-10.patina-film", "", 2, "is an input"),
        ("a.exr --result ./a.exr", "", 2, "twice"),
        ("nodir/a.exr", "", 1, "the folder nodir does not exist"),
        ("job", "", 2, ".exr"),
        ("a.exr", "--environment no.hdr", 1, "no.hdr"),
        ("a.exr", "--look no.look.toml", 1, "no.look.toml"),
        ("a.exr", "--look wrong.look.toml", 1, "exposure"),
    ] {
        let line = format!(
            "farm export --to slurm --spp 20 --parts 2 -o job --result {result} triangle.gltf -- {flags}"
        );
        bench.run(&line).expect_error(code, said);
        assert!(!bench.path("job/part.sh").exists(), "{line}");
    }
    bench
        .run("farm export --to slurm -o job --result a.exr no.glb")
        .expect_error(1, "no.glb");
    let line =
        "farm export --to slurm -o job --result job/a.exr triangle.gltf -- --environment sky.exr";
    bench.run(line).expect_code(0);
    assert_eq!(fs::read(bench.path("sky.exr")).expect("there"), b"a sky");
}

/// Runs a script of a job with this in the place of the program.
#[cfg(unix)]
fn with_program(bench: &Bench, program: &str, script: &str) -> Command {
    use std::os::unix::fs::PermissionsExt;

    let folder = bench.path("programs");
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("patina"), program).expect("written");
    let executable = fs::Permissions::from_mode(0o755);
    fs::set_permissions(folder.join("patina"), executable).expect("it may be run");
    let path = std::env::var("PATH").unwrap_or_default();
    let mut command = Command::new("sh");
    command
        .args(script.split(' '))
        .current_dir(&bench.dir)
        .env("PATH", format!("{}:{path}", folder.display()))
        .stdin(Stdio::null());
    command
}

#[cfg(unix)]
#[test]
fn a_signal_to_the_script_of_a_part_ends_its_render() {
    let bench = Bench::new();
    bench
        .run("farm export --to openjd -o job --result a.exr triangle.gltf")
        .expect_code(0);
    // It writes what it has, as a render does, which takes a while.
    let program = "#!/bin/sh\nfor film; do :; done\ntrap 'sleep 1; echo half >begun; exit 143' TERM\necho $$ >pid\n\
                   while :; do sleep 0.1; done\n";
    let mut command = with_program(&bench, program, "job/part.sh 1");
    // A render that is left behind would hold pipes open.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("sh starts");
    let start = std::time::Instant::now();
    let render = loop {
        let text = fs::read_to_string(bench.path("pid")).unwrap_or_default();
        if text.ends_with('\n') {
            break text.trim().to_owned();
        }
        assert!(start.elapsed().as_secs() < 60, "the render doesn't begin");
        std::thread::sleep(std::time::Duration::from_millis(50));
    };
    assert!(kill(&["-TERM", &child.id().to_string()]));
    let status = child.wait().expect("it ends");
    let is_left = kill(&["-0", &render]);
    assert!(!is_left || kill(&["-KILL", &render]));
    assert!(!is_left, "the render goes on");
    assert_eq!(status.code(), Some(143));
    assert!(bench.path("begun").exists(), "it was waited for");
}

#[cfg(unix)]
#[test]
fn a_merge_is_of_the_parts_that_there_are() {
    let bench = Bench::new();
    bench
        .run("farm export --to openjd --spp 20 --parts 2 -o job --result a.exr triangle.gltf")
        .expect_code(0);
    let program = "#!/bin/sh\nfor word; do echo \"$word\"; done\n";
    let merge = || {
        let ended = with_program(&bench, program, "job/merge.sh").output();
        Outcome::of(ended.expect("sh starts"), "merge.sh")
    };
    let told = merge().expect_code(1);
    assert!(
        told.stderr.contains("samples 0..20 are missing"),
        "{}",
        told.stderr
    );
    fs::write(bench.path("job/10-20.patina-film"), "a film").expect("written");
    let words = merge().expect_code(0).stdout;
    assert!(words.contains("--expect\n0..20\n"), "{words}");
    assert!(words.ends_with("10-20.patina-film\n"), "{words}");
    assert!(!words.contains("00-10"), "{words}");
}

#[cfg(unix)]
#[test]
fn a_damaged_film_is_not_taken_for_the_part_that_is_rendered_again() {
    let bench = Bench::new();
    let export = |more: &str| {
        let line = "farm export --to openjd --spp 20 --parts 2 -o job --result a.exr";
        let said = bench.run(&format!("{line} {more} triangle.gltf"));
        let said = said.expect_code(0).stderr;
        let script = |name: &str| {
            let text = fs::read_to_string(bench.path("job").join(name));
            text.expect("it is there")
        };
        (said, script("part.sh"), script("merge.sh"))
    };
    let (_, parts, _) = export("");
    assert!(parts.contains("/00-10.patina-film"), "{parts}");
    for (damaged, again) in [("00-10", "00-10-again"), ("00-10-again", "00-10-again2")] {
        let damaged = format!("{damaged}.patina-film");
        fs::write(bench.path("job").join(&damaged), "half a film").expect("written");
        // Who gives the same command again has the same parts.
        let (_, same, _) = export("");
        assert!(same == parts, "{same}");
        let (said, parts, merge) = export("--missing");
        assert!(said.contains(&damaged), "{said}");
        // Other films may have its samples.
        assert!(said.contains("it is left out"), "{said}");
        for text in [&parts, &merge] {
            assert!(text.contains(&format!("/{again}.patina-film")), "{text}");
            assert!(text.contains("/10-20.patina-film"), "{text}");
            assert!(!text.contains(&format!("/{damaged}")), "{text}");
        }
    }
}

#[test]
fn parts_are_counted_and_gaps_are_named() {
    if !device() {
        return;
    }
    let bench = Bench::new();
    let line = "render triangle.gltf --size 16x16 --spp 10";
    for part in [1, 3] {
        bench
            .run(&format!("{line} --part {part}/3 -o {part}.patina-film"))
            .expect_code(0);
    }
    let refused = bench
        .run("merge 1.patina-film 3.patina-film --expect 0..10 -o a.png")
        .expect_code(1);
    assert!(
        refused.stderr.contains("samples 3..6 are missing"),
        "{}",
        refused.stderr
    );
    assert!(!bench.path("a.png").exists());
    let refused = bench
        .run("merge 1.patina-film 3.patina-film --expect 0..8 -o a.png")
        .expect_code(1);
    assert!(
        refused.stderr.contains("there are samples"),
        "{}",
        refused.stderr
    );
    bench
        .run("merge 1.patina-film --expect 0..3 -o a.png")
        .expect_code(0);
    for wrong in ["0/3", "4/3", "1", "1/0", "1/11"] {
        bench.run(&format!("{line} --part {wrong}")).expect_code(2);
    }
    let told = bench
        .run(&format!("{line} --progress openjd -o b.png"))
        .expect_code(0);
    assert!(!told.stdout.contains("people"), "{}", told.stdout);
}
