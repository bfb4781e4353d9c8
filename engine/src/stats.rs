//! Where the time and the memory went, and what is wrong with the picture.

use std::fmt;

use device::DeviceDescription;
use serde::Serialize;
use texgen::LOOP_LIMIT;

/// What figures were measured on.
#[derive(Debug, Clone, Serialize)]
pub struct DeviceFacts {
    /// In one line, for people.
    #[serde(skip)]
    pub title: String,
    /// The driver's name for it.
    pub name: String,
    /// Vulkan, Metal, DX12 or native.
    pub backend: String,
    /// Driver and its version.
    pub driver: String,
}

impl DeviceFacts {
    /// What the device says of itself.
    pub fn new(device: &DeviceDescription) -> Self {
        Self {
            title: device.title(),
            name: device.name.clone(),
            backend: device.backend.clone(),
            driver: device.driver.clone(),
        }
    }
}

/// One kernel's share of the time.
#[derive(Debug, Clone, Serialize)]
pub struct PassStats {
    /// Name of the kernel.
    pub name: String,
    /// Milliseconds on the device; 0 without timestamps.
    pub milliseconds: f64,
    /// Of all passes' time, 0 to 1.
    pub share: f64,
    /// How often it was dispatched.
    pub dispatches: u64,
}

/// Figures of a render so far.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Stats {
    /// Passes in the order in which a wave runs them.
    pub passes: Vec<PassStats>,
    /// Rays traced: paths, shadow and ambient occlusion.
    pub rays: u64,
    /// Of these, shadow rays: to any hit.
    pub shadow_rays: u64,
    /// Of these, ambient occlusion.
    pub ao_rays: u64,
    /// Million rays per second of the time spent in traversal (of wall time, without timestamps).
    pub mrays_per_second: f64,
    /// Camera paths finished per second of wall time.
    pub samples_per_second: f64,
    /// Wall time spent in rendering, seconds.
    pub seconds: f64,
    /// Samples of the picture that were not finite and count as black.
    pub invalid_samples: u64,
    /// Samples of the picture that were brighter than 2^31 and were clamped to that: see [`crate::film`].
    pub clamped_samples: u64,
    /// A texture whose loops ran so long that they were ended early.
    pub endless_texture: Option<String>,
    /// Hits at which textures drove something by a value that was not finite: their samples count as black.
    pub non_finite_hits: u64,
    /// A node that gave such a value; those that read its result are innocent.
    pub non_finite_node: Option<NodeName>,
    /// Bytes of GPU memory by purpose.
    pub memory: Vec<(String, u64)>,
    /// Pipelines created since the device was opened.
    pub pipelines_created: u64,
    /// Shader modules created since the device was opened.
    pub shader_modules_created: u64,
    /// Whether passes were timed on the device.
    pub timestamps: bool,
}

/// A node of the look.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NodeName {
    /// Its name.
    pub node: String,
    /// The texture that it uses.
    pub texture: String,
}

/// What makes a picture differ from what its author meant, found while rendering.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Doubt {
    /// The loops of this texture were ended early.
    EndlessLoop(String),
    /// So many hits had a value that was not finite, from this node.
    NonFinite(u64, Option<NodeName>),
    /// So many samples count as black.
    Invalid(u64),
    /// So many samples were clamped.
    Clamped(u64),
}

impl Doubt {
    /// Whether both are about the same thing, however often that was met.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::EndlessLoop(a), Self::EndlessLoop(b)) => a == b,
            (Self::NonFinite(_, a), Self::NonFinite(_, b)) => a == b,
            (Self::Invalid(_), Self::Invalid(_)) | (Self::Clamped(_), Self::Clamped(_)) => true,
            _ => false,
        }
    }
}

impl Stats {
    /// Figures of several devices that work at the same time, in one: counts, times of passes and memory are added up. What
    /// follows from the time on the wall, `seconds` and `samples_per_second`, is left at 0.
    pub fn together<'a>(all: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut sum = Self::default();
        for stats in all {
            for pass in &stats.passes {
                match sum.passes.iter_mut().find(|known| known.name == pass.name) {
                    Some(known) => {
                        known.milliseconds += pass.milliseconds;
                        known.dispatches += pass.dispatches;
                    }
                    None => sum.passes.push(pass.clone()),
                }
            }
            for (name, bytes) in &stats.memory {
                match sum.memory.iter_mut().find(|(known, _)| known == name) {
                    Some((_, known)) => *known += bytes,
                    None => sum.memory.push((name.clone(), *bytes)),
                }
            }
            sum.rays += stats.rays;
            sum.shadow_rays += stats.shadow_rays;
            sum.ao_rays += stats.ao_rays;
            sum.mrays_per_second += stats.mrays_per_second;
            sum.invalid_samples += stats.invalid_samples;
            sum.clamped_samples += stats.clamped_samples;
            sum.non_finite_hits += stats.non_finite_hits;
            sum.pipelines_created += stats.pipelines_created;
            sum.shader_modules_created += stats.shader_modules_created;
            sum.timestamps |= stats.timestamps;
            let texture = stats.endless_texture.clone();
            sum.endless_texture = sum.endless_texture.take().or(texture);
            let node = stats.non_finite_node.clone();
            sum.non_finite_node = sum.non_finite_node.take().or(node);
        }
        let milliseconds: f64 = sum.passes.iter().map(|pass| pass.milliseconds).sum();
        for pass in &mut sum.passes {
            pass.share = match milliseconds > 0.0 {
                true => pass.milliseconds / milliseconds,
                false => 0.0,
            };
        }
        sum.memory.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        sum
    }

    /// What is wrong with the picture so far.
    pub fn doubts(&self) -> Vec<Doubt> {
        let mut doubts = Vec::new();
        doubts.extend(self.endless_texture.clone().map(Doubt::EndlessLoop));
        if self.non_finite_hits > 0 {
            let node = self.non_finite_node.clone();
            doubts.push(Doubt::NonFinite(self.non_finite_hits, node));
        } else if self.invalid_samples > 0 {
            // Those that textures spoil are told by the node.
            doubts.push(Doubt::Invalid(self.invalid_samples));
        }
        if self.clamped_samples > 0 {
            doubts.push(Doubt::Clamped(self.clamped_samples));
        }
        doubts
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EndlessLoop(texture) => write!(
                f,
                "the loops of texture `{texture}` took more than {LOOP_LIMIT} steps at one hit and were ended early; \
                 look for a loop that doesn't end"
            ),
            Self::NonFinite(hits, node) => {
                match node {
                    Some(NodeName { node, texture }) => {
                        write!(f, "node `{node}` (texture `{texture}`)")?;
                    }
                    None => write!(f, "a texture")?,
                }
                write!(
                    f,
                    " gives values that are not finite (NaN or infinite); {} samples of surfaces count as black; look for a \
                     division by zero, or the root or logarithm of a negative number",
                    grouped(*hits)
                )
            }
            Self::Invalid(samples) => write!(
                f,
                "{} samples were not finite and count as black; a texture may give values that are far too large",
                grouped(*samples)
            ),
            Self::Clamped(samples) => write!(
                f,
                "{} samples were brighter than 2147483648 and were clamped to that; the picture is darker there than it should be",
                grouped(*samples)
            ),
        }
    }
}

/// A count with thousands separated by commas.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_names_what_is_to_be_mended() {
        let node = NodeName {
            node: "dirt".to_owned(),
            texture: "noise".to_owned(),
        };
        let doubt = |hits| Doubt::NonFinite(hits, Some(node.clone()));
        let text = doubt(1_234_567).to_string();
        for part in ["node `dirt` (texture `noise`)", "1,234,567", "black"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(doubt(1).is_same(&doubt(2)));
        assert!(!doubt(1).is_same(&Doubt::NonFinite(1, None)));
    }

    #[test]
    fn counts_are_grouped_by_three() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_000), "1,000");
        assert_eq!(grouped(12_345_678), "12,345,678");
    }
}
