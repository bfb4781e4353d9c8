//! What a renderer says of its work: times of passes, counts of rays, memory.

use std::collections::BTreeMap;

use crate::{
    stats::{NodeName, PassStats, Stats},
    wave::Totals,
};

use super::{RenderError, Renderer};

impl Renderer {
    /// Milliseconds and dispatches of each pass that has run.
    fn times(&self) -> BTreeMap<&'static str, (f64, u64)> {
        let of = |label: &str| {
            let (milliseconds, dispatches) = self.lanes.times(label);
            let alone = self.timer.totals().get(label).copied();
            let (more, others) = alone.unwrap_or_default();
            (milliseconds + more, dispatches + others)
        };
        let times = self.bound.labels().map(|label| (label, of(label)));
        times
            .filter(|(_, (_, dispatches))| *dispatches > 0)
            .collect()
    }

    /// Figures so far.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn stats(&self) -> Result<Stats, RenderError> {
        let mut totals = Totals::read(&self.device, &self.resources)?;
        totals.add(&self.lanes.totals(&self.device)?);
        if self.is_stale {
            totals = totals.without_faults();
        }
        let times = self.times();
        let all: f64 = times.values().map(|(ms, _)| ms).sum();
        let passes: Vec<PassStats> = self
            .bound
            .labels()
            .filter_map(|label| {
                let (milliseconds, dispatches) = *times.get(label)?;
                Some(PassStats {
                    name: label.to_owned(),
                    milliseconds,
                    share: if all > 0.0 { milliseconds / all } else { 0.0 },
                    dispatches,
                })
            })
            .collect();
        let tracing: f64 = ["traverse_closest", "traverse_occlusion", "ao"]
            .iter()
            .filter_map(|n| times.get(*n))
            .map(|(ms, _)| ms * 1e-3)
            .sum();
        let rays = totals.rays + totals.ao_rays;
        let tracing = if tracing > 0.0 { tracing } else { self.seconds };
        let rate = |count: u64, seconds: f64| {
            if seconds > 0.0 {
                count as f64 / seconds
            } else {
                0.0
            }
        };
        let padded = u128::from(self.frame.padded_pixels);
        let pixels = u128::from(self.settings.width) * u128::from(self.settings.height);
        let samples = (u128::from(self.rendered) * pixels / padded) as u64;
        let mut sizes = BTreeMap::<&str, u64>::new();
        for (name, bytes) in self
            .resources
            .buffer_sizes()
            .chain(self.lanes.buffer_sizes())
        {
            *sizes.entry(name).or_default() += bytes;
        }
        let sizes = sizes.into_iter().map(|(n, b)| (n.to_owned(), b));
        let mut memory: Vec<(String, u64)> = sizes.collect();
        memory.push(("image layers".to_owned(), self.scene.image_bytes));
        memory.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        let counts = self.device.counts();
        Ok(Stats {
            passes,
            rays,
            shadow_rays: totals.shadow_rays,
            ao_rays: totals.ao_rays,
            mrays_per_second: rate(rays, tracing) * 1e-6,
            samples_per_second: rate(samples, self.seconds),
            seconds: self.seconds,
            invalid_samples: totals.invalid,
            clamped_samples: totals.clamped,
            endless_texture: totals.overrun.and_then(|number| {
                let textures = self.procedural.graph().library().textures();
                Some(textures.get(number as usize)?.name().to_owned())
            }),
            non_finite_hits: totals.non_finite,
            non_finite_node: totals.non_finite_node.and_then(|place| {
                let graph = self.procedural.graph();
                let node = graph.ids().find(|&id| graph.block(id).start == place)?;
                Some(NodeName {
                    node: graph.name(node).to_owned(),
                    texture: graph.texture(node).name().to_owned(),
                })
            }),
            memory,
            pipelines_created: counts.pipelines,
            shader_modules_created: counts.shader_modules,
            timestamps: self.timer.is_timing(),
        })
    }
}
