//! A picture by several devices: see [`engine::fleet`].

use std::convert::Infallible;
use std::sync::Arc;
use std::time::{Duration, Instant};

use device::Device;
use engine::audit::{self, Audit};
use engine::film::{Film, Layers};
use engine::fingerprint::fingerprint;
use engine::fleet::{Fleet, Outcome, Plan, Recruit};
use engine::load::Loaded;
use engine::renderer::{RenderSettings, Renderer};
use engine::settings::Method;
use engine::stats::DeviceFacts;
use engine::system::System;

use crate::accuracy::Accuracy;
use crate::failure::Failure;
use crate::job::RenderJob;
use crate::memory::Need;
use crate::progress::Bar;
use crate::{cache, console, interrupt, memory};

use super::limits::{Look, Watch};
use super::pieces;
use super::{Ended, FAREWELL, Gathered, REFINEMENTS, REFINING, Rendered, Rest, is_as_wanted, mark};

/// How often a signal is looked for where nothing else happens.
const TICK: Duration = Duration::from_millis(100);

/// Renders until all samples are there, a signal comes, or no device is left.
///
/// # Errors
/// There is no device that renders any of it.
pub(super) fn render(
    job: &RenderJob,
    loaded: Loaded,
    settings: RenderSettings,
    devices: &[Device],
    bar: &Bar,
    mut watch: Watch,
) -> Result<Rendered, Failure> {
    let clock = Instant::now();
    if let Some(first) = devices.first() {
        bar.follow(first);
    }
    let mut plan = Plan {
        settings,
        scene: Arc::new(loaded.scene),
        procedural: Arc::new(loaded.procedural),
        spp: job.spp.get(),
        times_passes: job.stats || job.stats_json.is_some(),
        system: System::default(),
    };
    let need = Need::of(job, &plan.settings, &plan.scene, &plan.procedural, devices);
    let stated = pieces::is_one_film(job).and_then(|()| memory::state(job, &need, bar));
    stated.map_err(|failure| {
        Failure::Failed(format!(
            "{failure}; a single device could render it in pieces"
        ))
    })?;
    let mut prepare_seconds = None;
    let mut first = Instant::now();
    let mut refined = 0;
    let (fleet, ran) = loop {
        let fleet = Fleet::start(&plan, recruits(&plan, devices, bar)?);
        while !fleet.is_ready() {
            fleet.wait(TICK);
        }
        prepare_seconds.get_or_insert_with(|| {
            first = Instant::now();
            clock.elapsed().as_secs_f64()
        });
        let ran = run(job, &plan, &fleet, devices, bar, &mut watch)?;
        let is_wrong = ran.audit.as_ref().is_some_and(Audit::is_wrong);
        if !is_wrong || job.accuracy != Some(Accuracy::Final) || refined == REFINEMENTS {
            break (fleet, ran);
        }
        refined += 1;
        bar.stage(REFINING);
        watch.begin_anew();
        plan.settings.refinement += 1;
    };
    interrupt::writes_results();
    let render_seconds = first.elapsed().as_secs_f64();
    let settings_written = fingerprint(&plan.scene, &plan.procedural, &plan.settings);
    let Run {
        outcome,
        ended,
        audit,
    } = ran;
    let title = |list: Vec<&str>| list.join("\n");
    let used = outcome.devices.iter().filter(|share| share.is_used());
    let joined = |of: fn(&DeviceFacts) -> &str| {
        let mut words: Vec<&str> = outcome.devices.iter().map(|s| of(&s.device)).collect();
        words.dedup();
        words.join(" + ")
    };
    let facts = DeviceFacts {
        title: title(used.map(|share| share.device.title.as_str()).collect()),
        name: joined(|facts| &facts.name),
        backend: joined(|facts| &facts.backend),
        driver: joined(|facts| &facts.driver),
    };
    Ok(Rendered {
        device: outcome.device_names(),
        gathered: Gathered::Whole(outcome.film),
        samples: outcome.samples,
        names: job.layers.names(&plan.scene),
        paths: None,
        kept: None,
        ended,
        is_preview: false,
        facts,
        shares: outcome.devices,
        settings: settings_written,
        audit,
        stats: outcome.stats,
        prepare_seconds: prepare_seconds.unwrap_or_default(),
        render_seconds,
        rest: Rest::Together(fleet),
    })
}

/// What has come of a picture's samples.
struct Run {
    outcome: Outcome,
    ended: Option<Ended>,
    audit: Option<Audit>,
}

/// Waits until all samples are there, a signal comes, or no device is left; and looks how right the picture is.
fn run(
    job: &RenderJob,
    plan: &Plan,
    fleet: &Fleet,
    devices: &[Device],
    bar: &Bar,
    watch: &mut Watch,
) -> Result<Run, Failure> {
    let mut losses = Vec::new();
    let early = follow(fleet, job, bar, &mut losses, watch);
    if early.is_some() {
        interrupt::writes_results();
    }
    if early.is_some() && !job.outputs.films.is_empty() {
        // All pixels get the same samples, as a film that is to be merged should have, if that is a matter of moments.
        fleet.stop_after_sample();
        let farewell = Instant::now();
        while !fleet.is_over() && farewell.elapsed() < FAREWELL {
            fleet.wait(TICK);
        }
    }
    if early.is_some() {
        fleet.stop();
    }
    let outcome = fleet.outcome();
    tell(fleet, bar, &mut losses);
    for device in devices {
        // A cache that can't be written costs time at the next start, nothing else.
        let _ = device.save_cache();
    }
    let (lowest, _) = outcome.film.sample_bounds();
    let ended = match (early, outcome.is_complete) {
        (Some(ended), _) => Some(ended),
        (None, true) => None,
        (None, false) => {
            let reason = format!(
                "no device is left to finish the picture:\n{}",
                losses.join("\n")
            );
            if lowest == 0 {
                return Err(Failure::Failed(reason));
            }
            let had = format!(
                "{reason}\nevery pixel has at least {}",
                job.samples_told(lowest)
            );
            Some(Ended::Failed(had))
        }
    };
    let audit = match plan.settings.method != Method::Path && is_as_wanted(ended.as_ref()) {
        true => {
            bar.stage("looking how right the picture is");
            audit(plan, devices, &outcome.film)
        }
        false => None,
    };
    Ok(Run {
        outcome,
        ended,
        audit,
    })
}

/// What is wrong with a picture of cached light, by the first device that can tell.
fn audit(plan: &Plan, devices: &[Device], film: &Film) -> Option<Audit> {
    let settings = RenderSettings {
        method: Method::Path,
        layers: Layers::default(),
        ..plan.settings.clone()
    };
    devices.iter().find_map(|device| {
        let renderer = Renderer::new(device, &plan.scene, &plan.procedural, &settings);
        let mut renderer = renderer.ok()?;
        let mut paths = |seed| renderer.trace_apart(seed, audit::SAMPLES).ok();
        Audit::new(film, [&paths(1)?, &paths(2)?])
    })
}

/// The devices with what is to be done once each is ready. One whose driver doesn't survive a texture is left out.
fn recruits(plan: &Plan, devices: &[Device], bar: &Bar) -> Result<Vec<Recruit>, Failure> {
    let folder = cache::folder();
    let mut recruits = Vec::new();
    let mut reasons = Vec::new();
    for device in devices {
        let marker = match mark(&plan.procedural, device, folder.as_deref(), bar) {
            Ok(marker) => marker,
            Err(failure) => {
                let text = format!("{}: {failure}", device.description().title());
                bar.suspend(|| console::warning(&format!("{text}; the others render without it")));
                reasons.push(text);
                continue;
            }
        };
        recruits.push(plan.recruit(device).wrapped(move |worker| {
            drop(marker);
            worker
        }));
    }
    match recruits.is_empty() {
        true => Err(Failure::Failed(reasons.join("\n"))),
        false => Ok(recruits),
    }
}

/// Shows how far the picture is until it is done, or no device is left. What ends it before, if something does.
fn follow(
    fleet: &Fleet,
    job: &RenderJob,
    bar: &Bar,
    losses: &mut Vec<String>,
    watch: &mut Watch,
) -> Option<Ended> {
    let pixels = f64::from(job.width) * f64::from(job.height);
    while !fleet.is_over() {
        let progress = fleet.wait(TICK);
        tell(fleet, bar, losses);
        if progress.samples_done > 0 {
            interrupt::has_results();
        }
        let samples = progress.samples_done as f64 / pixels;
        bar.update(&watch.reached_so_far(&progress, samples), job.spp.get());
        if fleet.is_over() {
            break;
        }
        if interrupt::requested() {
            return Some(Ended::Interrupted);
        }
        let noise = |look: &Look| Ok::<_, Infallible>(fleet.look(|film| look.at(film)));
        let Ok(limit) = watch.reached(samples, noise);
        // All of a picture has a sample before its time may be over, once it is begun: caches of light may take longer than that.
        let may_end = || {
            let waits = samples == 0.0 && !matches!(job.method, Method::Path | Method::Photons);
            waits || fleet.has_all_pixels()
        };
        if let Some(limit) = limit.filter(|_| may_end()) {
            return Some(Ended::Enough(limit));
        }
    }
    None
}

/// Tells which devices have failed.
fn tell(fleet: &Fleet, bar: &Bar, losses: &mut Vec<String>) {
    for loss in fleet.losses() {
        let text = format!("{}: {}", loss.device, loss.reason);
        if !fleet.is_over() {
            bar.suspend(|| {
                console::warning(&format!("{text}; the other devices finish the picture"));
            });
        }
        losses.push(text);
    }
}
