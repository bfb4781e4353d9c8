//! What came of a fleet's work: the film, and who did how much of it.

use std::ops::Range;
use std::time::Duration;

use serde::Serialize;

use crate::film::Film;
use crate::stats::{DeviceFacts, Stats};

use super::queue::joined;
use super::state::Member;

/// A picture that several devices have rendered.
#[derive(Debug)]
pub struct Outcome {
    /// All that was gathered.
    pub film: Film,
    /// The numbers of the samples that pixels may have, from the first one on; where [`Self::is_complete`], they have all.
    pub samples: Range<u32>,
    /// Nothing is missing of what was wanted in the end.
    pub is_complete: bool,
    /// Each device's part, in the order in which they were given.
    pub devices: Vec<DeviceShare>,
    /// Figures of all together; times of passes are sums over devices.
    pub stats: Stats,
}

/// A device's part of the work.
#[derive(Debug, Clone, Serialize)]
pub struct DeviceShare {
    /// The device.
    #[serde(flatten)]
    pub device: DeviceFacts,
    /// Samples of pixels in the film that are its.
    pub samples: u64,
    /// Of all, 0 to 1.
    pub share: f64,
    /// Ranges that it took.
    pub ranges: u64,
    /// Time spent in rendering, seconds.
    pub seconds: f64,
    /// While it rendered.
    pub samples_per_second: f64,
    /// Why it was left out, if it failed.
    pub failure: Option<String>,
    /// The paths in the film that are its, ascending: see [`crate::renderer::Renderer::paths_per_sample`].
    #[serde(skip)]
    pub paths: Vec<Range<u64>>,
    #[serde(skip)]
    is_used: bool,
}

impl DeviceShare {
    /// Whether any of the picture is its.
    pub fn is_used(&self) -> bool {
        self.is_used
    }
}

impl Outcome {
    /// The devices that the picture is of, by name, each name once.
    pub fn device_names(&self) -> String {
        let mut names: Vec<&str> = Vec::new();
        for share in self.devices.iter().filter(|share| share.is_used) {
            if !names.contains(&share.device.name.as_str()) {
                names.push(&share.device.name);
            }
        }
        names.join(" + ")
    }
}

/// What an outcome is made of.
pub(super) struct Harvest<'a> {
    pub(super) members: &'a [Member],
    pub(super) facts: &'a [DeviceFacts],
    /// From the first device that was ready until now.
    pub(super) took: Duration,
    /// Samples of pixels, of so many paths.
    pub(super) samples: &'a dyn Fn(u64) -> u64,
    /// Numbers of samples, of a range of paths.
    pub(super) sample_numbers: &'a dyn Fn(&Range<u64>) -> Range<u32>,
    pub(super) film: Film,
    pub(super) is_complete: bool,
}

pub(super) fn gather(harvest: Harvest<'_>) -> Outcome {
    let total: u64 = harvest.members.iter().map(Member::paths).sum();
    let per_second = |samples: u64, seconds: f64| match seconds > 0.0 {
        true => samples as f64 / seconds,
        false => 0.0,
    };
    let share = |(member, facts): (&Member, &DeviceFacts)| {
        let samples = (harvest.samples)(member.paths());
        let seconds = member.took.as_secs_f64();
        DeviceShare {
            device: facts.clone(),
            samples,
            share: member.paths() as f64 / total.max(1) as f64,
            ranges: member.ranges,
            seconds,
            samples_per_second: per_second(samples, seconds),
            failure: member.failure.clone(),
            paths: member.collected.clone(),
            is_used: !member.collected.is_empty(),
        }
    };
    let devices: Vec<DeviceShare> = (harvest.members.iter().zip(harvest.facts))
        .map(share)
        .collect();
    let all = devices.iter().flat_map(|share| share.paths.iter().cloned());
    let all = joined(all.collect());
    let end = all.last().map_or(0, |last| last.end);
    let seconds = harvest.took.as_secs_f64();
    let mut stats = Stats::together(harvest.members.iter().filter_map(|m| m.stats.as_ref()));
    stats.seconds = seconds;
    stats.samples_per_second = per_second((harvest.samples)(total), seconds);
    Outcome {
        samples: (harvest.sample_numbers)(&(0..end)),
        film: harvest.film,
        is_complete: harvest.is_complete,
        devices,
        stats,
    }
}
