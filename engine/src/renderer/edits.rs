//! Live edits: what the user changes becomes a few words written to buffers. Pipelines are touched only when a
//! program outgrows the kernel's stack or a scene gets its first program.

use std::ops::Range;

use device::{Device, Resources, Usage};

use crate::{
    procedural::{EditError, Procedural},
    scene::look::{AoDirection, AoSettings},
    schedule::Schedule,
    wave::GpuAoTable,
};

use super::{RenderError, Renderer};

/// Why a change of the texture graph did not happen. The picture and the graph are as before.
#[derive(Debug, thiserror::Error)]
pub enum RenderEditError {
    /// The graph refused it.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The device.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// Creates the buffers of programs, arguments and AO tables, with room to grow.
pub(super) fn allocate(
    device: &Device,
    procedural: &Procedural,
    schedule: &dyn Schedule,
    resources: &mut Resources,
) -> Result<(), RenderError> {
    for (name, words) in [
        ("programs", &*schedule.program_words(procedural)?),
        ("args", procedural.args()),
    ] {
        let bytes = (words.len() as u64 * 4 * 3 / 2).max(1024);
        let buffer = device.buffer(name, Usage::Storage, bytes)?;
        device.write(&buffer, 0, bytemuck::cast_slice(words));
        resources.set_buffer(name, buffer);
    }
    write_ao(device, procedural, resources);
    Ok(())
}

fn write_ao(device: &Device, procedural: &Procedural, resources: &Resources) {
    let mut tables = [GpuAoTable::default(); 4];
    // A look without tables still has its default one, which nodes that read AO use.
    let used = procedural.ao_count().max(1);
    for (table, settings) in tables.iter_mut().zip(procedural.ao()).take(used) {
        *table = ao_table(settings);
    }
    device.write(
        resources.buffer("ao_tables"),
        0,
        bytemuck::cast_slice(&tables),
    );
}

fn ao_table(settings: &AoSettings) -> GpuAoTable {
    GpuAoTable {
        distance: settings.distance,
        direction: match settings.direction {
            AoDirection::Outside => 0,
            AoDirection::Inside => 1,
            AoDirection::Both => 2,
        },
        samples: settings.samples.min(255),
        same_object: u32::from(settings.same_object),
    }
}

impl Renderer {
    /// The texture graph as it is now.
    pub fn procedural(&self) -> &Procedural {
        &self.procedural
    }

    /// Changes the texture graph itself, by small buffer writes, for comparisons in which there is no look. Whatever has a
    /// look edits that, in a [`crate::session::Session`].
    ///
    /// # Errors
    /// What the graph refuses, or the device.
    pub fn edit_graph(
        &mut self,
        change: impl FnOnce(&mut Procedural) -> Result<(), EditError>,
    ) -> Result<(), RenderEditError> {
        change(&mut self.procedural)?;
        Ok(self.write_changes()?)
    }

    /// Writes what changed and starts the picture anew, where that can be seen.
    pub(super) fn write_changes(&mut self) -> Result<(), RenderError> {
        let changes = self.procedural.take_changes();
        if changes.is_empty() {
            return Ok(());
        }
        let is_shown = self.procedural.shows(&changes);
        let needs_kernels = !self.kernels.has_texture() && !self.procedural.is_empty();
        let are_code = self.schedule.edits_are_code();
        let needs_kernels = needs_kernels || changes.kernel || are_code;
        if needs_kernels {
            self.scene.features.programs = true;
            self.kernels.rebuild_texture(
                &self.device,
                &self.scene.features,
                &self.procedural,
                &*self.schedule,
            )?;
        }
        let words = self.procedural.result_words() + self.scene.features.path_words();
        let (device, capacity) = (&self.device, self.capacity);
        let grown = (self.schedule).grow_results(device, capacity, words, &mut self.resources)?;
        (self.lanes).grow_results(device, &*self.schedule, capacity, words)?;
        let fits = |name: &str, words: &[u32]| {
            self.resources.buffer(name).size() >= words.len() as u64 * 4
        };
        if grown
            || are_code
            || !fits("programs", self.procedural.programs())
            || !fits("args", self.procedural.args())
        {
            allocate(
                &self.device,
                &self.procedural,
                &*self.schedule,
                &mut self.resources,
            )?;
            self.bind();
        } else {
            self.write_ranges("programs", self.procedural.programs(), &changes.programs);
            self.write_ranges("args", self.procedural.args(), &changes.args);
            if needs_kernels {
                self.bind();
            }
        }
        if changes.ao {
            write_ao(&self.device, &self.procedural, &self.resources);
        }
        // What no material needs is not seen: the picture goes on.
        if is_shown || needs_kernels {
            self.restart();
        }
        Ok(())
    }

    /// Makes room for the programs and arguments of another graph than `former`, and writes them.
    pub(super) fn resize_programs(&mut self, former: &Procedural) -> Result<(), RenderError> {
        let now = &self.procedural;
        let words = now.result_words() + self.scene.features.path_words();
        (self.schedule).grow_results(&self.device, self.capacity, words, &mut self.resources)?;
        (self.lanes).grow_results(&self.device, &*self.schedule, self.capacity, words)?;
        let is_same = (
            former.programs(),
            former.args(),
            former.ao(),
            former.ao_count(),
        ) == (now.programs(), now.args(), now.ao(), now.ao_count());
        if !is_same {
            allocate(&self.device, now, &*self.schedule, &mut self.resources)?;
        }
        Ok(())
    }

    fn write_ranges(&self, name: &str, words: &[u32], ranges: &[Range<u32>]) {
        for range in ranges {
            let words = &words[range.start as usize..range.end as usize];
            self.device.write(
                self.resources.buffer(name),
                u64::from(range.start) * 4,
                bytemuck::cast_slice(words),
            );
        }
    }
}
