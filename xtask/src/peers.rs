//! `cargo xtask peers`: Patina beside other renderers, on the same scenes with the same number of threads, in turn.
//!
//! What is rendered how is here; the renderers are driven by the Python files of `benches/peers`, each of which reads a job
//! and writes a result as JSON (`exchange`). They are optional: what isn't installed is skipped with a notice.
//! `docs/peers.md` says how to install them and what is made equal.

mod exchange;
mod fit;
mod options;
mod report;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::steps::{cargo, root};

use exchange::{Comparison, Job, Listed, Origin, Outcome, Pictures, SceneList, Task};
use options::Options;
use report::{Measured, Report, Row, SceneReport, TextureReport, TextureRow};

/// Seed of references: none of the timed renders has it.
const REFERENCE_SEED: u32 = 1000;
/// The peer whose program changes.
const PATINA: &str = "patina";
/// Exit code of a driver whose renderer isn't installed.
const ABSENT: i32 = 3;

/// What the command can be told.
pub(crate) const USAGE: &str = options::USAGE;

/// Renders, compares, prints a table and writes `report.json` and `report.md`.
///
/// # Errors
/// A flag that makes no sense, a renderer that fails, a file that can't be read or written. Renderers and scenes that are
/// missing are no errors.
pub(crate) fn run(arguments: &[&str]) -> Result<()> {
    let options = Options::parse(arguments, std::env::var("PATINA_PEERS_PYTHON").ok())?;
    let bench = Bench::new(options)?;
    let mut notices = Vec::new();
    let peers = bench.available(&mut notices)?;
    if peers.is_empty() {
        println!("nothing to compare; docs/peers.md says how renderers are installed");
        return Ok(());
    }
    let scenes = bench.scenes(&mut notices)?;
    let references = bench.references(&scenes, &peers)?;
    if bench.options.prepare {
        println!("scenes and references are in {}", bench.out.display());
        return Ok(());
    }
    let report = bench.measure(&scenes, &peers, &references, notices)?;
    let text = report.markdown();
    println!("\n{text}");
    write(&bench.out.join("report.md"), &text)?;
    write(
        &bench.out.join("report.json"),
        &serde_json::to_string_pretty(&report)?,
    )?;
    println!(
        "report.md, report.json and pictures are in {}",
        bench.out.display()
    );
    Ok(())
}

/// A renderer that answered.
struct Peer {
    name: &'static str,
    version: String,
}

/// Pictures of many samples by scene and peer.
type References = BTreeMap<(String, &'static str), PathBuf>;

struct Bench {
    options: Options,
    patina: PathBuf,
    /// Which build of it that is.
    build: String,
    out: PathBuf,
}

impl Bench {
    fn new(options: Options) -> Result<Self> {
        let patina = match &options.patina {
            Some(program) => root().join(program),
            None => {
                cargo(["build", "--release", "--package", "patina"]).run()?;
                let target = std::env::var_os("CARGO_TARGET_DIR");
                let target = target.map_or_else(|| root().join("target"), PathBuf::from);
                target.join("release/patina")
            }
        };
        let out = root().join(&options.out);
        for folder in ["jobs", "results", "pictures", "references"] {
            let folder = out.join(folder);
            fs::create_dir_all(&folder)
                .with_context(|| format!("cannot create {}", folder.display()))?;
        }
        Ok(Self {
            build: build(&patina)?,
            options,
            patina,
            out,
        })
    }

    /// The peers that are asked for and installed.
    fn available(&self, notices: &mut Vec<String>) -> Result<Vec<Peer>> {
        let mut found = Vec::new();
        for &name in options::PEERS {
            if !self.options.peers.iter().any(|asked| asked == name) {
                continue;
            }
            let driver = driver(&format!("peer_{name}.py"));
            let output = Command::new(&self.options.python)
                .arg(&driver)
                .arg("--version")
                .output();
            match presence(name, output)? {
                Presence::Version(version) => {
                    println!("{name}: {version}");
                    found.push(Peer { name, version });
                }
                Presence::Absent(notice) => {
                    println!("{notice}");
                    notices.push(notice);
                }
            }
        }
        Ok(found)
    }

    /// Writes the scenes, unless all of them have been written of the same folders.
    fn scenes(&self, notices: &mut Vec<String>) -> Result<Vec<Listed>> {
        let folder = self.out.join("scenes");
        let list = folder.join("scenes.json");
        let origin = Origin {
            scenes: root().join(&self.options.scenes),
            reference: root().join(&self.options.reference),
        };
        let known = read::<SceneList>(&list).ok();
        let known_origin = known.as_ref().and_then(|list| list.origin.as_ref());
        if known_origin != Some(&origin) {
            // What was rendered of others, though files of the same names.
            self.forget_jobs()?;
        }
        if !known.is_some_and(|list| is_whole(&list, &origin)) {
            println!("writing scenes to {}", folder.display());
            // Written last: what ends before leaves none, so that half of the scenes aren't taken for all. There may be none yet.
            let _ = fs::remove_file(&list);
            let mut command = Command::new(&self.options.python);
            command.arg(driver("scenes.py")).arg(&folder);
            command.arg("--scenes").arg(&origin.scenes);
            command.arg("--reference").arg(&origin.reference);
            finish(command, "scenes.py")?;
        }
        let list: SceneList = read(&list)?;
        for skipped in list.skipped {
            let notice = format!("{}: skipped, {}", skipped.name, skipped.reason);
            println!("{notice}");
            notices.push(notice);
        }
        let only = &self.options.only;
        let mut scenes = list.scenes;
        scenes.retain(|scene| only.is_empty() || only.contains(&scene.name));
        for scene in &mut scenes {
            scene.width = (scene.width / self.options.shrink).max(1);
            scene.height = (scene.height / self.options.shrink).max(1);
        }
        Ok(scenes)
    }

    /// Makes all results count as those of other jobs.
    fn forget_jobs(&self) -> Result<()> {
        let folder = self.out.join("jobs");
        fs::remove_dir_all(&folder)
            .and_then(|()| fs::create_dir(&folder))
            .with_context(|| format!("cannot empty {}", folder.display()))
    }

    /// Converged pictures for each scene that brings none, once for each job: of each peer, or by one for all. A reference of one's own
    /// leaves out by how much renderers differ in what they take to be right: that is told apart from noise.
    fn references(&self, scenes: &[Listed], peers: &[Peer]) -> Result<References> {
        let maker = match &self.options.reference_by {
            None => None,
            Some(name) => {
                let maker = peers.iter().find(|peer| peer.name == name);
                Some(
                    maker
                        .with_context(|| format!("{name} can't make references: it isn't there"))?,
                )
            }
        };
        let mut references = References::new();
        for scene in scenes.iter().filter(|scene| scene.task == Task::Render) {
            for peer in peers {
                let file = match &scene.reference {
                    Some(file) => file.clone(),
                    None => {
                        let maker = maker.unwrap_or(peer);
                        let name = format!("reference-{}-{}", scene.name, maker.name);
                        let job = Job {
                            seed: REFERENCE_SEED,
                            spp: vec![self.options.reference_spp],
                            out: self.out.join("references").join(&scene.name),
                            ..self.job(scene)
                        };
                        let outcome = self.outcome(maker, &name, &job, true, &[])?;
                        let render = outcome.renders.into_iter().next();
                        render.context("a peer rendered nothing")?.picture
                    }
                };
                references.insert((scene.name.clone(), peer.name), file);
            }
        }
        Ok(references)
    }

    fn measure(
        &self,
        scenes: &[Listed],
        peers: &[Peer],
        references: &References,
        notices: Vec<String>,
    ) -> Result<Report> {
        let mut report = Report::new(self.options.threads, notices);
        for scene in scenes {
            match scene.task {
                Task::Render => report.scenes.push(self.renders(scene, peers, references)?),
                Task::Textures => report.textures.push(self.textures(scene, peers)?),
            }
        }
        Ok(report)
    }

    /// All peers in turn, as often as there are runs.
    fn renders(
        &self,
        scene: &Listed,
        peers: &[Peer],
        references: &References,
    ) -> Result<SceneReport> {
        let mut outcomes: Vec<Vec<Outcome>> = peers.iter().map(|_| Vec::new()).collect();
        for run in 0..self.options.runs {
            for (peer, outcomes) in peers.iter().zip(&mut outcomes) {
                let job = Job {
                    seed: run,
                    ..self.job(scene)
                };
                let name = format!("{}-{}-{run}", scene.name, peer.name);
                let through = &self.options.through;
                outcomes.push(self.outcome(peer, &name, &job, self.options.resume, through)?);
            }
        }
        // What all pictures are held against, to see whether the renderers render the same.
        let common = &references[&(scene.name.clone(), peers[0].name)];
        let mut rows = Vec::new();
        for (peer, outcomes) in peers.iter().zip(&outcomes) {
            let reference = &references[&(scene.name.clone(), peer.name)];
            let name = format!("{}-{}", scene.name, peer.name);
            let errors = self.compare(&name, reference, pictures(outcomes), None)?;
            let alike = if scene.reference.is_none() && self.options.reference_by.is_none() {
                vec![Pictures {
                    file: reference.clone(),
                    spp: self.options.reference_spp,
                }]
            } else {
                // The render with the most samples says it best.
                pictures(&outcomes[outcomes.len() - 1..]).split_off(self.options.spp.len() - 1)
            };
            let sheet = self.out.join("pictures").join(format!("{name}.png"));
            let alike = self.compare(&format!("{name}-alike"), common, alike, Some(sheet))?;
            let pixels = f64::from(scene.width) * f64::from(scene.height);
            let measured = Measured {
                outcomes,
                errors: &errors,
                alike: &alike,
                pixels,
            };
            rows.push(Row::new(peer.name, &peer.version, &measured)?);
        }
        let reference = match (&scene.reference, &self.options.reference_by) {
            (Some(_), _) => "given".to_owned(),
            (None, None) => "own".to_owned(),
            (None, Some(maker)) => maker.clone(),
        };
        Ok(SceneReport::new(scene, reference, rows))
    }

    fn textures(&self, scene: &Listed, peers: &[Peer]) -> Result<TextureReport> {
        let mut rows = Vec::new();
        for peer in peers
            .iter()
            .filter(|peer| options::WITH_TEXTURES.contains(&peer.name))
        {
            for &rays in &self.options.ao_rays {
                let job = Job {
                    task: Task::Textures,
                    spp: vec![self.options.texture_spp],
                    ao_samples: vec![rays],
                    runs: self.options.runs,
                    ..self.job(scene)
                };
                let name = format!("{}-{}-{rays}", scene.name, peer.name);
                let outcome = self.outcome(
                    peer,
                    &name,
                    &job,
                    self.options.resume,
                    &self.options.through,
                )?;
                rows.extend(
                    outcome
                        .cases
                        .iter()
                        .map(|case| TextureRow::new(peer.name, rays, case)),
                );
            }
        }
        Ok(TextureReport::new(scene, rows))
    }

    /// What is the same in all jobs of a scene.
    fn job(&self, scene: &Listed) -> Job {
        Job {
            task: scene.task,
            scene: scene.file.clone(),
            width: scene.width,
            height: scene.height,
            spp: self.options.spp.clone(),
            out: self.out.join("pictures").join(&scene.name),
            max_depth: self.options.max_depth,
            threads: self.options.threads,
            seed: 0,
            environment: scene.environment,
            patina: self.patina.clone(),
            build: None,
            ao_samples: self.options.ao_rays.clone(),
            runs: self.options.runs,
        }
    }

    /// Lets a peer do a job, or reads what it wrote when it did the same job before and `reuse` is set.
    fn outcome(
        &self,
        peer: &Peer,
        name: &str,
        job: &Job,
        reuse: bool,
        through: &[String],
    ) -> Result<Outcome> {
        let (task, result) = self.files(name);
        let mut job = job.clone();
        job.build = (peer.name == PATINA).then(|| self.build.clone());
        let text = serde_json::to_string_pretty(&job)?;
        let known = fs::read_to_string(&task).is_ok_and(|known| job.gives_the_same_as(&known));
        if !(reuse && known && result.is_file()) {
            println!("{name}");
            // A result without its job would be taken for that of another.
            if let Err(error) = fs::remove_file(&result)
                && error.kind() != std::io::ErrorKind::NotFound
            {
                return Err(error).with_context(|| format!("cannot remove {}", result.display()));
            }
            write(&task, &text)?;
            let program = driver(&format!("peer_{}.py", peer.name));
            let words = [self.options.python.as_os_str(), program.as_os_str()];
            let words = words
                .into_iter()
                .chain([task.as_os_str(), result.as_os_str()]);
            let mut words = through.iter().map(OsStr::new).chain(words);
            let mut command = Command::new(words.next().expect("Python is always there"));
            command.args(words);
            finish(command, name)?;
        }
        read(&result)
    }

    /// Errors of pictures against a reference, in the order given.
    fn compare(
        &self,
        name: &str,
        reference: &Path,
        pictures: Vec<Pictures>,
        sheet: Option<PathBuf>,
    ) -> Result<Comparison> {
        let (task, result) = self.files(&format!("compare-{name}"));
        let job =
            serde_json::json!({ "reference": reference, "pictures": pictures, "sheet": sheet });
        write(&task, &job.to_string())?;
        let mut command = Command::new(&self.options.python);
        command
            .arg(driver("pictures.py"))
            .arg("compare")
            .args([&task, &result]);
        finish(command, name)?;
        read(&result)
    }

    fn files(&self, name: &str) -> (PathBuf, PathBuf) {
        let name = format!("{name}.json");
        (
            self.out.join("jobs").join(&name),
            self.out.join("results").join(&name),
        )
    }
}

fn pictures(outcomes: &[Outcome]) -> Vec<Pictures> {
    let renders = outcomes.iter().flat_map(|outcome| &outcome.renders);
    renders
        .map(|render| Pictures {
            file: render.picture.clone(),
            spp: render.spp,
        })
        .collect()
}

/// Tells builds of a program from each other: its size and when it was written.
fn build(program: &Path) -> Result<String> {
    let told = fs::metadata(program).and_then(|file| Ok((file.len(), file.modified()?)));
    let (size, written) = told.with_context(|| format!("cannot read {}", program.display()))?;
    let since = written.duration_since(std::time::UNIX_EPOCH)?;
    Ok(format!("{size} bytes, {} ns", since.as_nanos()))
}

/// Whether nothing would change if the scenes were written anew.
fn is_whole(list: &SceneList, origin: &Origin) -> bool {
    list.skipped.is_empty() && list.origin.as_ref() == Some(origin)
}

fn driver(file: &str) -> PathBuf {
    root().join("benches/peers").join(file)
}

/// What a driver said when it was asked for its renderer's version.
enum Presence {
    Version(String),
    /// With the reason, for the user.
    Absent(String),
}

/// # Errors
/// The driver failed in another way than by missing its renderer.
fn presence(name: &str, answer: std::io::Result<std::process::Output>) -> Result<Presence> {
    let absent =
        |reason: &str| Presence::Absent(format!("{name}: skipped, {reason} (docs/peers.md)"));
    let output = match answer {
        Ok(output) => output,
        Err(error) => return Ok(absent(&format!("Python can't be started: {error}"))),
    };
    let said = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        text.trim().lines().last().unwrap_or_default().to_owned()
    };
    match output.status.code() {
        Some(0) => Ok(Presence::Version(said(&output.stdout))),
        Some(ABSENT) => Ok(absent(&said(&output.stderr))),
        _ => bail!(
            "{name} can't say its version: {}",
            String::from_utf8_lossy(&output.stderr)
        ),
    }
}

/// Runs a command; what it says is shown only where it fails, as renderers talk much.
fn finish(mut command: Command, name: &str) -> Result<()> {
    let output = command
        .current_dir(root())
        .stdin(Stdio::null())
        .output()
        .with_context(|| format!("cannot start {}", command.get_program().display()))?;
    if !output.status.success() {
        let said = [output.stdout, output.stderr].concat();
        let said = String::from_utf8_lossy(&said);
        let lines: Vec<_> = said.lines().collect();
        let last = lines[lines.len().saturating_sub(20)..].join("\n");
        bail!("{name} ended with {}:\n{last}", output.status);
    }
    Ok(())
}

fn read<T: serde::de::DeserializeOwned>(path: &Path) -> Result<T> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text)
        .with_context(|| format!("{} isn't what was expected", path.display()))
}

/// Writes aside, then renames.
fn write(path: &Path, text: &str) -> Result<()> {
    let mut aside = path.as_os_str().to_owned();
    aside.push(".part");
    fs::write(&aside, text)
        .and_then(|()| fs::rename(&aside, path))
        .with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_written_anew_where_some_are_missing_or_others_are_meant() {
        let list = |text: &str| -> SceneList { serde_json::from_str(text).expect("a list") };
        let origin = |scenes: &str| Origin {
            scenes: scenes.into(),
            reference: "r".into(),
        };
        let whole = r#"{"scenes": [], "skipped": [], "origin": {"scenes": "a", "reference": "r"}}"#;
        assert!(is_whole(&list(whole), &origin("a")));
        assert!(!is_whole(&list(whole), &origin("b")));
        let skipped = whole.replace(
            r#""skipped": []"#,
            r#""skipped": [{"name": "knot", "reason": "it isn't there"}]"#,
        );
        assert!(!is_whole(&list(&skipped), &origin("a")));
        let old = r#"{"scenes": [], "skipped": []}"#;
        assert!(!is_whole(&list(old), &origin("a")));
    }

    #[test]
    fn a_program_that_is_built_anew_is_another_one() {
        let name = format!("patina-peers-{}", std::process::id());
        let program = std::env::temp_dir().join(name);
        let of = |text: &str| {
            fs::write(&program, text).expect("it can be written");
            build(&program).expect("it is there")
        };
        let (first, second) = (of("one"), of("three"));
        assert_ne!(first, second);
        assert_eq!(build(&program).expect("it is there"), second);
        fs::remove_file(&program).expect("it was there");
        assert!(build(&program).is_err());
    }

    #[test]
    fn a_missing_python_is_a_notice() {
        let missing = Err(std::io::Error::from(std::io::ErrorKind::NotFound));
        let Ok(Presence::Absent(notice)) = presence("cycles", missing) else {
            panic!("a peer without Python is absent");
        };
        assert!(notice.starts_with("cycles: skipped"), "{notice}");
        assert!(notice.contains("docs/peers.md"), "{notice}");
    }

    #[cfg(unix)]
    #[test]
    fn a_driver_says_whether_its_renderer_is_there() {
        use std::os::unix::process::ExitStatusExt as _;
        let answer = |code: i32, stdout: &str, stderr: &str| {
            Ok(std::process::Output {
                // As wait(2) packs it.
                status: std::process::ExitStatus::from_raw(code << 8),
                stdout: stdout.into(),
                stderr: stderr.into(),
            })
        };
        let Ok(Presence::Version(version)) = presence("cycles", answer(0, "chatter\n5.0.1\n", ""))
        else {
            panic!("there is one");
        };
        assert_eq!(version, "5.0.1");
        let missing = answer(ABSENT, "", "No module named 'bpy'\n");
        let Ok(Presence::Absent(notice)) = presence("cycles", missing) else {
            panic!("there is none");
        };
        assert!(notice.contains("No module named 'bpy'"), "{notice}");
        assert!(presence("cycles", answer(1, "", "Traceback")).is_err());
    }
}
