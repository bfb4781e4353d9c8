//! What the paper found, to be set beside what is measured here: V. Sanzharov, V. Frolov et al., "Restricted Extensions
//! for GPU Photo-realistic Renderer", 2019, table 1. Sponza with a model inserted, on the authors' GPU.

use serde::Serialize;

/// A figure of the paper.
#[derive(Debug, Serialize)]
pub struct Published {
    /// `rust` or `scratches`.
    pub texture: &'static str,
    /// What the paper calls it.
    pub approach: &'static str,
    /// The form here that works so.
    pub mode: &'static str,
    /// Rendering time over that of plain grey.
    pub increase_percent: f64,
    /// Stack frame of a thread, where the paper has it.
    pub stack_bytes: Option<u32>,
}

/// Where the figures are from, for people.
pub(super) const SOURCE: &str = "V. Sanzharov, V. Frolov et al., “Restricted Extensions for GPU Photo-realistic \
    Renderer”, 2019, table 1: Sponza with a model inserted, on the authors’ GPU";

/// All of them.
pub static TABLE: [Published; 6] = [
    figure("rust", CYCLES, 46.0, Some(604)),
    figure("rust", RTX, 33.0, None),
    figure("rust", PROPOSED, 21.0, Some(464)),
    figure("scratches", CYCLES, 9.0, Some(412)),
    figure("scratches", RTX, 4.0, None),
    figure("scratches", PROPOSED, 15.0, Some(336)),
];

const CYCLES: (&str, &str) = ("Cycles’ approach", "inlined");
const RTX: (&str, &str) = ("RTX", "rayquery");
const PROPOSED: (&str, &str) = ("proposed", "stack");

const fn figure(
    texture: &'static str,
    (approach, mode): (&'static str, &'static str),
    increase_percent: f64,
    stack_bytes: Option<u32>,
) -> Published {
    Published {
        texture,
        approach,
        mode,
        increase_percent,
        stack_bytes,
    }
}
