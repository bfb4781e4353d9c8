//! What `patina info` tells of animations.

use engine::scene::Animation;
use serde::Serialize;

use super::table::{counted, number};

/// An animation of the scene's own file.
#[derive(Serialize)]
pub(super) struct AnimationInfo {
    name: String,
    /// Times of the first and the last key, seconds.
    start: f64,
    end: f64,
    /// Nodes that it moves.
    nodes: Vec<String>,
    /// Channels by what they move.
    translations: usize,
    rotations: usize,
    scales: usize,
    weights: usize,
}

impl AnimationInfo {
    pub(super) fn of(animation: &Animation) -> Self {
        let Animation {
            name,
            start,
            end,
            nodes,
            channels: [translations, rotations, scales, weights],
        } = animation.clone();
        Self {
            name,
            start,
            end,
            nodes,
            translations,
            rotations,
            scales,
            weights,
        }
    }

    pub(super) fn row(&self) -> Vec<String> {
        const SHOWN: usize = 4;
        let moves = [
            (self.translations, "translation", "translations"),
            (self.rotations, "rotation", "rotations"),
            (self.scales, "scale", "scales"),
            (self.weights, "set of weights", "sets of weights"),
        ];
        let moves = moves.iter().filter(|(count, ..)| *count > 0);
        let moves: Vec<_> = moves.map(|&(n, one, many)| counted(n, one, many)).collect();
        let mut nodes = self
            .nodes
            .iter()
            .take(SHOWN)
            .cloned()
            .collect::<Vec<_>>()
            .join(", ");
        if self.nodes.len() > SHOWN {
            nodes += &format!(" and {} more", self.nodes.len() - SHOWN);
        }
        vec![
            self.name.clone(),
            format!(
                "{} to {} s",
                number(self.start as f32),
                number(self.end as f32)
            ),
            moves.join(", "),
            format!("of {nodes}"),
        ]
    }
}
