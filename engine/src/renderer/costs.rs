//! What each node's texture and each AO table costs, measured at what the camera sees first.
//!
//! Once a picture of fewer pixels is rendered up to its first hits, which tells how often each node runs. Then each node is
//! timed alone at all of these hits, with constants in place of its links, against a run in which nothing is done. Only buffers
//! are written, and in the end they are as they were.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Serialize;
use texgen::NodeId;

use device::{Buffer, DeviceError, Timer};

use crate::{
    frame::Frame,
    passes::{ao, proctex},
    procedural::Hits,
    schedule::{self, Run},
    settings::RenderSettings,
    wave::{self, Queue},
};

use super::lanes::begin_wave;
use super::record::Recorder;
use super::{RenderError, Renderer};

/// Pixels of the picture that is measured, about: enough for a time that means something, few enough for a short one.
const PIXELS_ON_CPU: u32 = 1 << 12;
const PIXELS_ON_GPU: u32 = 1 << 18;
/// Timings of which the median counts, and dispatches of one.
const TIMINGS: usize = 3;
const DISPATCHES: u32 = 2;

/// What a node's texture, or an AO table, costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TextureCost {
    /// Name of the node, or of the AO table.
    pub name: String,
    /// Texture of the node; `None` for an AO table.
    pub texture: Option<String>,
    /// Nanoseconds that one run takes, averaged over runs that are done at a time: many more than one on a GPU.
    pub nanoseconds: f64,
    /// How often it runs for one sample of each pixel, per pixel. Only what the camera sees first is counted.
    pub runs_per_pixel: f64,
}

impl TextureCost {
    /// Nanoseconds for one sample of a pixel.
    pub fn per_sample(&self) -> f64 {
        self.nanoseconds * self.runs_per_pixel
    }
}

/// Costs as far as they are known.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct TextureCosts {
    /// The greatest first.
    pub list: Vec<TextureCost>,
    /// Everything has been measured.
    pub is_done: bool,
}

/// A measurement under way.
#[derive(Debug)]
pub(super) struct Survey {
    frame: Frame,
    /// Still to be measured, the last one first.
    left: Vec<Measurand>,
    costs: TextureCosts,
}

#[derive(Debug, Clone, Copy)]
enum Measurand {
    Node { node: NodeId, runs: u64 },
    Occlusion(u32),
}

impl Renderer {
    /// Measures one more texture or AO table; the first call finds out which there are. An edit, or another view, begins
    /// anew. The film stays as it is. Nothing is compiled.
    ///
    /// Without timestamps of the device, wall-clock times are taken.
    ///
    /// # Errors
    /// What the driver reports.
    pub fn measure_costs(&mut self) -> Result<&TextureCosts, RenderError> {
        let mut survey = match self.survey.take() {
            Some(survey) => survey,
            None => self.survey()?,
        };
        if let Some(subject) = survey.left.pop() {
            let totals = self.totals()?;
            let cost = match subject {
                Measurand::Node { node, runs } => self.node_cost(&survey.frame, node, runs)?,
                Measurand::Occlusion(table) => self.occlusion_cost(&survey.frame, table)?,
            };
            self.restore_totals(&totals);
            let list = &mut survey.costs.list;
            list.push(cost);
            list.sort_by(|a, b| b.per_sample().total_cmp(&a.per_sample()));
        }
        survey.costs.is_done = survey.left.is_empty();
        Ok(&self.survey.insert(survey).costs)
    }

    /// Finds out which nodes the first hits run, and how often.
    fn survey(&mut self) -> Result<Survey, RenderError> {
        let frame = self.small_frame();
        let mut left = Vec::new();
        if self.kernels.has_texture() && !self.schedule.edits_are_code() {
            let procedural = self.procedural.clone();
            let totals = self.totals()?;
            let resolved = self.materials_of_hits(&frame, procedural.programs())?;
            // Without blends, they are the materials of the surfaces.
            let own = self.materials_of_hits(&frame, &procedural.idle_programs())?;
            self.restore_programs();
            self.restore_totals(&totals);
            let mut counts = BTreeMap::<(u32, u32), u64>::new();
            for pair in own.into_iter().zip(resolved) {
                *counts.entry(pair).or_default() += 1;
            }
            let hits: Vec<_> = counts
                .into_iter()
                .map(|((material, resolved), count)| Hits {
                    material,
                    resolved,
                    count,
                })
                .collect();
            left.extend((0..procedural.ao_count() as u32).map(Measurand::Occlusion));
            let nodes = procedural.count_runs(&hits).into_iter();
            left.extend(nodes.map(|(node, runs)| Measurand::Node { node, runs }));
        }
        Ok(Survey {
            frame,
            left,
            costs: TextureCosts::default(),
        })
    }

    /// The whole picture in fewer pixels, whose textures are seen as finely as in the real one.
    fn small_frame(&self) -> Frame {
        let most = match self.device.traits().shares_the_processor {
            true => PIXELS_ON_CPU,
            false => PIXELS_ON_GPU,
        };
        let of = |divisor: u32| {
            let side = |pixels: u32| (pixels / divisor).max(1);
            let [columns, rows] = self.settings.whole();
            let settings = RenderSettings {
                width: side(columns),
                height: side(rows),
                crop: None,
                ..self.settings.clone()
            };
            Frame::new(&settings, self.capacity, &self.scene)
        };
        let whole = of(1);
        let mut frame = (1..)
            .map(of)
            .find(|frame| frame.padded_pixels <= most.min(self.capacity))
            .expect("a single block fits");
        frame.set_pinhole();
        frame.set_footprint(&whole);
        frame.sample_limit = 1;
        frame.wave_size = frame.padded_pixels;
        frame
    }

    /// The material that each hit with a program ends at, path by path.
    fn materials_of_hits(&mut self, frame: &Frame, words: &[u32]) -> Result<Vec<u32>, RenderError> {
        self.find_first_hits(frame, words)?;
        let length = self.queue_length(Queue::Proctex)?;
        let queues = self.resources.buffer("queues");
        let list = wave::proctex_list(self.capacity);
        // The own ray of a path has its number.
        let mut slots = self.read_words(queues, list, u64::from(length))?;
        let states = self.resources.buffer("paths");
        let (at, paths) = (wave::state_field(self.capacity), frame.wave_size);
        let states = self.read_words(states, at, 4 * u64::from(paths))?;
        let material = |slot: &u32| states.get(4 * *slot as usize).copied();
        slots.sort_unstable();
        Ok(slots.iter().filter_map(material).collect())
    }

    /// What the kernels have counted: a measurement is no part of the picture.
    fn totals(&self) -> Result<Vec<u32>, DeviceError> {
        let Range { start, end } = wave::TOTALS;
        self.read_words(self.resources.buffer("queues"), 4 * start, end - start)
    }

    fn restore_totals(&self, totals: &[u32]) {
        let (queues, at) = (self.resources.buffer("queues"), 4 * wave::TOTALS.start);
        self.device.write(queues, at, bytemuck::cast_slice(totals));
    }

    fn queue_length(&self, queue: Queue) -> Result<u32, DeviceError> {
        let queues = self.resources.buffer("queues");
        Ok(self.read_words(queues, queue.length_offset(), 1)?[0])
    }

    fn read_words(&self, from: &Buffer, at: u64, count: u64) -> Result<Vec<u32>, DeviceError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let bytes = self.device.read(from, at, 4 * count)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    fn node_cost(
        &mut self,
        frame: &Frame,
        node: NodeId,
        runs: u64,
    ) -> Result<TextureCost, RenderError> {
        let alone = self.procedural.programs_of(node)?;
        let idle = self.procedural.idle_programs();
        // Hits whose ambient occlusion is known.
        let words = self.procedural.programs().to_vec();
        self.find_first_hits(frame, &words)?;
        let hits = self.queue_length(Queue::Proctex)?;
        let mut times = Vec::new();
        for _ in 0..TIMINGS {
            let mut spent = [0.0; 2];
            for (spent, words) in spent.iter_mut().zip([&alone, &idle]) {
                self.write_programs(words);
                *spent = self.nanoseconds(proctex::PASS.name, frame.wave_size, |wave| {
                    for _ in 0..DISPATCHES {
                        wave.run(&proctex::PASS);
                    }
                })?;
            }
            times.push((spent[0] - spent[1]) / f64::from(DISPATCHES));
        }
        self.restore_programs();
        let graph = self.procedural.graph();
        Ok(TextureCost {
            name: graph.name(node).to_owned(),
            texture: Some(graph.texture(node).name().to_owned()),
            // A cheap one may be lost in the noise.
            nanoseconds: median(times).max(0.0) / f64::from(hits.max(1)),
            runs_per_pixel: runs as f64 / f64::from(frame.pixels()),
        })
    }

    fn occlusion_cost(&mut self, frame: &Frame, table: u32) -> Result<TextureCost, RenderError> {
        let words = self.procedural.programs_with_ao(table);
        self.find_first_hits(frame, &words)?;
        let hits = self.queue_length(Queue::Ao)?;
        let mut times = Vec::new();
        for _ in 0..TIMINGS {
            times.push(self.nanoseconds(ao::PASS.name, frame.wave_size, |wave| {
                wave.run(&ao::PASS);
            })?);
        }
        self.restore_programs();
        let spent = match hits {
            0 => 0.0,
            hits => median(times) / f64::from(hits),
        };
        Ok(TextureCost {
            name: self.procedural.ao_names()[table as usize].clone(),
            texture: None,
            nanoseconds: spent,
            runs_per_pixel: f64::from(hits) / f64::from(frame.pixels()),
        })
    }

    /// Runs a wave up to its first hits, by these programs.
    fn find_first_hits(&mut self, frame: &Frame, words: &[u32]) -> Result<(), RenderError> {
        self.write_programs(words);
        begin_wave(&self.device, &self.resources, frame);
        self.nanoseconds("", frame.wave_size, |wave| {
            schedule::start(wave);
            schedule::find_hits(wave);
        })?;
        Ok(())
    }

    fn write_programs(&self, words: &[u32]) {
        let buffer = self.resources.buffer("programs");
        self.device.write(buffer, 0, bytemuck::cast_slice(words));
    }

    fn restore_programs(&self) {
        self.write_programs(self.procedural.programs());
    }

    /// How long the passes with this label take.
    fn nanoseconds(
        &self,
        label: &str,
        paths: u32,
        record: impl FnOnce(&mut Recorder<'_>),
    ) -> Result<f64, DeviceError> {
        // Its own timer: these passes are no part of the render.
        let mut timer = Timer::timing(&self.device)?;
        let sizes = self.resources.buffer("dispatch_sizes");
        let mut recorder = Recorder::new(&self.bound, sizes, paths);
        record(&mut recorder);
        let recording = recorder.finish();
        let start = self.system.clock.now();
        self.device.play_timed(&recording, &mut timer)?;
        let took = self.system.clock.now() - start;
        Ok(match timer.is_timing() {
            true => timer.totals().get(label).map_or(0.0, |(ms, _)| ms * 1e6),
            false => took.as_secs_f64() * 1e9,
        })
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
