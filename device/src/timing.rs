//! Time of each kernel on the device.

use std::{collections::BTreeMap, time::Duration};

use crate::{Device, DeviceError, device::Kind, gpu::Timestamps};

/// Collects the time of dispatches by label. A device without a clock of its own only counts them.
#[derive(Debug)]
pub struct Timer {
    clock: Clock,
    /// Of the recording that is being played.
    labels: Vec<String>,
    totals: BTreeMap<String, (f64, u64)>,
}

/// What measures time.
#[derive(Debug)]
enum Clock {
    None,
    Device(Timestamps),
    /// Dispatches are done when they return.
    Wall,
}

impl Timer {
    /// Counts dispatches.
    pub fn counting() -> Self {
        Self {
            clock: Clock::None,
            labels: Vec::new(),
            totals: BTreeMap::new(),
        }
    }

    /// Times dispatches, where the device has a clock.
    ///
    /// # Errors
    /// If the device is out of memory.
    pub fn timing(device: &Device) -> Result<Self, DeviceError> {
        let clock = match &device.kind {
            Kind::Gpu(gpu) if device.description().timestamps => {
                Clock::Device(Timestamps::new(gpu)?)
            }
            Kind::Gpu(_) => Clock::None,
            Kind::Native(_) => Clock::Wall,
        };
        Ok(Self {
            clock,
            ..Self::counting()
        })
    }

    /// Whether times are measured.
    pub fn is_timing(&self) -> bool {
        !matches!(self.clock, Clock::None)
    }

    /// Milliseconds and dispatches so far, by label.
    pub fn totals(&self) -> &BTreeMap<String, (f64, u64)> {
        &self.totals
    }

    /// A dispatch follows. Where it is timed, the timestamps and its number among them.
    pub(crate) fn next(&mut self, label: &str) -> Option<(&Timestamps, u32)> {
        self.count(label, 0.0);
        self.timestamps()?;
        let number = self.labels.len() as u32;
        if number >= Timestamps::CAPACITY {
            return None;
        }
        self.labels.push(label.to_owned());
        Some((self.timestamps()?, number))
    }

    /// A dispatch took so long, by the clock on the wall.
    pub(crate) fn add(&mut self, label: &str, took: Duration) {
        let is_timed = matches!(self.clock, Clock::Wall);
        self.count(
            label,
            if is_timed {
                took.as_secs_f64() * 1e3
            } else {
                0.0
            },
        );
    }

    fn count(&mut self, label: &str, milliseconds: f64) {
        match self.totals.get_mut(label) {
            Some((total, count)) => {
                *total += milliseconds;
                *count += 1;
            }
            None => {
                self.totals.insert(label.to_owned(), (milliseconds, 1));
            }
        }
    }

    fn timestamps(&self) -> Option<&Timestamps> {
        match &self.clock {
            Clock::Device(timestamps) => Some(timestamps),
            Clock::None | Clock::Wall => None,
        }
    }

    /// All dispatches of a recording have been told: the timestamps, and how many there are.
    pub(crate) fn end(&self) -> Option<(&Timestamps, u32)> {
        let count = self.labels.len() as u32;
        let timestamps = self.timestamps()?;
        (count > 0).then_some((timestamps, count))
    }

    pub(crate) fn collect(&mut self, device: &Device) -> Result<(), DeviceError> {
        let Some((timestamps, count)) = self.end() else {
            return Ok(());
        };
        let Kind::Gpu(gpu) = &device.kind else {
            return Ok(());
        };
        let times = timestamps.milliseconds(gpu, count)?;
        for (label, milliseconds) in self.labels.drain(..).zip(times) {
            self.totals.entry(label).or_default().0 += milliseconds;
        }
        Ok(())
    }
}
