//! `cargo xtask farm`: a picture in parts on a real scheduler, of which a machine is lost half-way. Slurm runs on this host alone: a
//! controller and three nodes, without systemd. The merged film must be the whole to the bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};

use crate::steps::{Step, cargo, root};
use crate::{DEMO_LOOK, DEMO_SCENE, vulkan};

const PACKAGES: [&str; 2] = ["slurm-wlm", "munge"];
const NODES: u32 = 3;
/// The node that is lost.
const LOST: &str = "n2";
const PARTS: &str = "16";
const SPP: &str = "128";
/// Long enough for a part that a node can be lost within it.
const FLAGS: [&str; 6] = ["--size", "320x180", "--seed", "5", "--device", "native:1"];
/// Longest that anything is waited for.
const PATIENCE: Duration = Duration::from_secs(600);

/// Installs what is missing, renders, loses a node, compares.
///
/// # Errors
/// What can't be installed or started; films that differ.
pub(crate) fn run() -> Result<()> {
    if !Step::new("sbatch").args(["--version"]).succeeds() {
        vulkan::install_packages(
            &PACKAGES,
            "Install Slurm and munge, and run this command again.",
        )?;
    }
    cargo(["build", "--locked", "--release", "--package", "patina"]).run()?;
    let out = root().join("out/farm");
    let _ = fs::remove_dir_all(&out);
    fs::create_dir_all(out.join("state"))
        .with_context(|| format!("cannot create {}", out.display()))?;
    let whole = out.join("whole.patina-film");
    let look = root().join(DEMO_LOOK).display().to_string();
    let scene = root().join(DEMO_SCENE).display().to_string();
    let film = whole.display().to_string();
    let render = ["render", &scene, "--look", &look, "--spp", SPP, "-o", &film];
    patina(render.into_iter().chain(FLAGS))?;
    let (job, all) = (out.join("job"), out.join("all.patina-film"));
    let export = [
        "farm", "export", "--to", "slurm", "--parts", PARTS, "--spp", SPP, "-o",
    ];
    let export = export
        .into_iter()
        .chain([job.to_str().context("a path in UTF-8")?, "--result"]);
    let rest = [
        all.to_str().context("a path in UTF-8")?,
        &scene,
        "--",
        "--look",
        &look,
    ];
    patina(export.chain(rest).chain(FLAGS))?;

    let slurm = Slurm::start(&out)?;
    let submitted =
        (slurm.command("sh").arg(job.join("submit.sh")).status()).context("sh can't be started")?;
    ensure!(submitted.success(), "submit.sh: {submitted}");
    slurm.wait(
        || {
            slurm
                .ask("squeue", &["-h", "-t", "R", "-w", LOST, "-o", "%i"])
                .lines()
                .count()
                > 0
        },
        "a part on the node that is to be lost",
    )?;
    sleep(Duration::from_secs(1));
    let lost = slurm.lose(LOST)?;
    println!("lost {LOST} with part {lost}");
    let mut is_back = false;
    let begun = Instant::now();
    slurm.wait(
        || {
            // What is queued again waits for two minutes otherwise.
            for id in slurm
                .ask("squeue", &["-h", "-r", "-t", "PD", "-o", "%i"])
                .lines()
            {
                slurm.ask(
                    "scontrol",
                    &["update", &format!("JobId={id}"), "StartTime=now"],
                );
            }
            if !is_back && begun.elapsed() > Duration::from_secs(30) {
                is_back = slurm.node(LOST).is_ok();
            }
            slurm.ask("squeue", &["-h"]).trim().is_empty()
        },
        "the end of all parts",
    )?;
    let log = fs::read_to_string(job.join("merge.log")).unwrap_or_default();
    ensure!(all.exists(), "nothing was merged:\n{log}");
    ensure!(
        fs::read(&all)? == fs::read(&whole)?,
        "the merged film differs from the whole:\n{log}"
    );
    println!(
        "the film of {PARTS} parts, of which one was lost on the way, is the whole to the bit"
    );
    Ok(())
}

fn program() -> PathBuf {
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    target.join("release")
}

fn patina<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<()> {
    Step::new(program().join("patina")).args(arguments).run()
}

/// A cluster on this host. It ends with this value.
struct Slurm {
    folder: PathBuf,
    daemons: Vec<Child>,
}

impl Slurm {
    fn start(folder: &Path) -> Result<Self> {
        let host = Command::new("hostname")
            .arg("-s")
            .output()
            .context("hostname can't be started")?;
        let host = String::from_utf8_lossy(&host.stdout).trim().to_owned();
        let at = folder.display();
        let configuration = format!(
            "ClusterName=patina\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser=root\nSlurmdUser=root\nAuthType=auth/munge\n\
             StateSaveLocation={at}/state\nSlurmdSpoolDir={at}/%n\nSlurmctldPidFile={at}/ctld.pid\nSlurmdPidFile={at}/%n.pid\n\
             SlurmctldLogFile={at}/ctld.log\nSlurmdLogFile={at}/%n.log\nSlurmctldPort=16817\nProctrackType=proctrack/linuxproc\n\
             TaskPlugin=task/none\nMpiDefault=none\nSelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nSchedulerType=sched/backfill\n\
             ReturnToService=2\nSlurmdTimeout=10\nInactiveLimit=0\nKillWait=5\nMinJobAge=3600\nAccountingStorageType=accounting_storage/none\n\
             JobAcctGatherType=jobacct_gather/none\nNodeName=n[1-{NODES}] NodeHostname={host} NodeAddr=127.0.0.1 Port=[17001-1700{NODES}] \
             CPUs=1 RealMemory=500 State=UNKNOWN\nPartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
        );
        fs::write(folder.join("slurm.conf"), configuration)?;
        let mut slurm = Self {
            folder: folder.to_owned(),
            daemons: Vec::new(),
        };
        // It may run already.
        let munge = "mkdir -p /run/munge && chown munge /run/munge && (munge -n >/dev/null 2>&1 || runuser -u munge -- munged)";
        Step::new("sh").args(["-c", munge]).run()?;
        let controller = slurm
            .command("slurmctld")
            .arg("-D")
            .spawn()
            .context("slurmctld can't be started")?;
        slurm.daemons.push(controller);
        sleep(Duration::from_secs(2));
        for number in 1..=NODES {
            let node = slurm.node(&format!("n{number}"))?;
            slurm.daemons.push(node);
        }
        let idle =
            || slurm.ask("sinfo", &["-h", "-t", "idle", "-o", "%D"]).trim() == NODES.to_string();
        slurm.wait(idle, "the nodes")?;
        Ok(slurm)
    }

    /// A command that knows the cluster, and finds the program that is tried.
    fn command(&self, name: &str) -> Command {
        let mut command = Command::new(name);
        let path = std::env::var("PATH").unwrap_or_default();
        command
            .env("SLURM_CONF", self.folder.join("slurm.conf"))
            .env("PATH", format!("{}:{path}", program().display()))
            .stdin(Stdio::null());
        command
    }

    fn node(&self, name: &str) -> Result<Child> {
        fs::create_dir_all(self.folder.join(name))?;
        let mut command = self.command("slurmd");
        command
            .args(["-D", "-N", name])
            .spawn()
            .context("slurmd can't be started")
    }

    /// What a command of Slurm prints; nothing where it fails.
    fn ask(&self, name: &str, arguments: &[&str]) -> String {
        let output = self
            .command(name)
            .args(arguments)
            .stderr(Stdio::null())
            .output();
        output.map_or_else(
            |_| String::new(),
            |output| String::from_utf8_lossy(&output.stdout).into_owned(),
        )
    }

    fn wait(&self, mut is_so: impl FnMut() -> bool, what: &str) -> Result<()> {
        let begun = Instant::now();
        while !is_so() {
            if begun.elapsed() > PATIENCE {
                bail!(
                    "waited for {what} in vain; logs are in {}",
                    self.folder.display()
                );
            }
            sleep(Duration::from_millis(500));
        }
        Ok(())
    }

    /// Ends a node as if its power had gone: its daemon, then all that runs in its name. The daemon alone would be no test: what it
    /// had started would go on and count. Which part it had.
    fn lose(&self, node: &str) -> Result<String> {
        let part = self
            .ask("squeue", &["-h", "-t", "R", "-w", node, "-o", "%i"])
            .trim()
            .to_owned();
        let variable = format!("SLURMD_NODENAME={node}");
        let mut doomed = vec![
            fs::read_to_string(self.folder.join(format!("{node}.pid")))?
                .trim()
                .to_owned(),
        ];
        for entry in fs::read_dir("/proc")?.flatten() {
            let path = entry.path();
            let environment = fs::read(path.join("environ")).unwrap_or_default();
            let is_its = environment
                .split(|&byte| byte == 0)
                .any(|word| word == variable.as_bytes());
            let name = fs::read_to_string(path.join("cmdline")).unwrap_or_default();
            let steps = self.ask("squeue", &["-h", "-t", "R", "-w", node, "-o", "%A"]);
            let is_step = steps
                .lines()
                .any(|job| name.contains(&format!("slurmstepd: [{job}.")));
            if is_its || is_step {
                doomed.push(entry.file_name().to_string_lossy().into_owned());
            }
        }
        // All at once, so that none can report the end of another.
        let pids: Vec<&str> = doomed.iter().map(String::as_str).collect();
        let _ = Command::new("kill").arg("-KILL").args(&pids).status();
        Ok(part)
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        self.ask("scancel", &["--state=PENDING"]);
        self.ask("scancel", &["--state=RUNNING"]);
        for daemon in &mut self.daemons {
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
        // A node that came back.
        let pid = fs::read_to_string(self.folder.join(format!("{LOST}.pid"))).unwrap_or_default();
        if !pid.trim().is_empty() {
            let _ = Command::new("kill").arg(pid.trim()).status();
        }
    }
}
