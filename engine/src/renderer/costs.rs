//! What each node's texture and each AO table costs, measured at what the camera sees first.
//!
//! Once a picture of fewer pixels is rendered up to its first hits, which tells how often each node runs. Then each node is
//! timed alone at all of these hits, with constants in place of its links, against a run in which nothing is done. Only buffers
//! are written, and in the end they are as they were.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;
use texgen::NodeId;

use crate::{
    frame::Frame,
    gpu::{GpuError, kernel::Extent, timing::Timer},
    passes::{advance::After, proctex::TextureForm},
    procedural::Hits,
    settings::RenderSettings,
    wave::{self, Queue},
};

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
    left: Vec<Subject>,
    costs: TextureCosts,
}

#[derive(Debug, Clone, Copy)]
enum Subject {
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
            let cost = match subject {
                Subject::Node { node, runs } => self.node_cost(&survey.frame, node, runs)?,
                Subject::Occlusion(table) => self.occlusion_cost(&survey.frame, table)?,
            };
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
        if self.kernels.has_texture() && self.form == TextureForm::Stack {
            let procedural = self.procedural.clone();
            let resolved = self.materials_of_hits(&frame, procedural.programs())?;
            // Without blends, they are the materials of the surfaces.
            let own = self.materials_of_hits(&frame, &procedural.idle_programs())?;
            self.restore_programs();
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
            left.extend((0..procedural.ao_count() as u32).map(Subject::Occlusion));
            let nodes = procedural.count_runs(&hits).into_iter();
            left.extend(nodes.map(|(node, runs)| Subject::Node { node, runs }));
        }
        Ok(Survey {
            frame,
            left,
            costs: TextureCosts::default(),
        })
    }

    /// The whole picture in fewer pixels, whose textures are seen as finely as in the real one.
    fn small_frame(&self) -> Frame {
        let most = match self.gpu.is_cpu() {
            true => PIXELS_ON_CPU,
            false => PIXELS_ON_GPU,
        };
        let of = |divisor: u32| {
            let side = |pixels: u32| (pixels / divisor).max(1);
            let settings = RenderSettings {
                width: side(self.settings.width),
                height: side(self.settings.height),
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

    fn queue_length(&self, queue: Queue) -> Result<u32, GpuError> {
        let queues = self.resources.buffer("queues");
        Ok(self.read_words(queues, queue.length_offset(), 1)?[0])
    }

    fn read_words(&self, from: &wgpu::Buffer, at: u64, count: u64) -> Result<Vec<u32>, GpuError> {
        if count == 0 {
            return Ok(Vec::new());
        }
        let bytes = self.gpu.read_buffer(from, at, 4 * count)?;
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
                *spent = self.nanoseconds("proctex", |wave| {
                    for _ in 0..DISPATCHES {
                        let texture = wave.bound.texture.as_ref();
                        let proctex = &texture.expect("there are programs").proctex;
                        wave.run_queue(proctex, Queue::Proctex);
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
            times.push(self.nanoseconds("ao", |wave| {
                let texture = wave.bound.texture.as_ref();
                let ao = &texture.expect("there are programs").ao;
                wave.run_queue(ao, Queue::Ao);
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
        let queue = self.gpu.queue();
        let write = |name: &str, bytes: &[u8]| {
            queue.write_buffer(self.resources.buffer(name), 0, bytes);
        };
        write("frame", bytemuck::bytes_of(frame));
        write("queues", bytemuck::cast_slice(&wave::fresh_queues()));
        let paths = Extent::Threads(frame.wave_size);
        self.nanoseconds("", |wave| {
            wave.run(&wave.bound.raygen, paths);
            wave.run(wave.after(After::Raygen), Extent::One);
            wave.find_hits();
        })?;
        Ok(())
    }

    fn write_programs(&self, words: &[u32]) {
        let buffer = self.resources.buffer("programs");
        (self.gpu.queue()).write_buffer(buffer, 0, bytemuck::cast_slice(words));
    }

    fn restore_programs(&self) {
        self.write_programs(self.procedural.programs());
    }

    /// How long the passes with this label take.
    fn nanoseconds(
        &self,
        label: &str,
        record: impl FnOnce(&mut Recorder<'_>),
    ) -> Result<f64, GpuError> {
        // Its own timer: these passes are no part of the render.
        let mut timer = Timer::new(&self.gpu, true)?;
        let sizes = self.resources.buffer("dispatch_sizes");
        let mut recorder = Recorder::new(&self.gpu, &self.bound, sizes, &mut timer);
        record(&mut recorder);
        let commands = recorder.finish();
        let clock = Instant::now();
        self.gpu.queue().submit([commands]);
        self.gpu.wait()?;
        let took = clock.elapsed();
        timer.collect(&self.gpu)?;
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
