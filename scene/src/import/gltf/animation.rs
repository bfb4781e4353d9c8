//! The animations of a file (glTF 2.0, section 3.11), and where they put nodes at a time.

use super::document::Document;
use super::hierarchy::describe;
use super::sampler::{Interpolation, Sampler};
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use crate::import::format::Described;
use crate::moment::{Animation, Moment, Motion};
use glam::{DQuat, DVec3};
use serde_json::Value;
use std::collections::{HashMap, HashSet};

/// What a channel moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

impl Path {
    /// All of them.
    const ALL: [(&'static str, Self); 4] = [
        ("translation", Self::Translation),
        ("rotation", Self::Rotation),
        ("scale", Self::Scale),
        ("weights", Self::Weights),
    ];
}

/// A property of a node that moves.
#[derive(Debug)]
struct Channel {
    node: usize,
    path: Path,
    sampler: Sampler,
}

/// What moves a file, read and checked.
#[derive(Debug, Default)]
pub(super) struct Tracks {
    channels: Vec<Channel>,
    /// What isn't shown as the file says.
    warnings: Vec<String>,
}

/// What animations say of the nodes at a time.
#[derive(Debug, Default)]
pub(super) struct Places {
    nodes: HashMap<usize, Local>,
    /// Weights of morph targets.
    pub(super) weights: HashMap<usize, Vec<f32>>,
    /// Something moves the file, whether or not it moves anything that is seen.
    pub(super) is_moved: bool,
}

/// A node's own transform, as far as it is animated.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Local {
    pub(super) translation: Option<DVec3>,
    pub(super) rotation: Option<DQuat>,
    pub(super) scale: Option<DVec3>,
}

impl Places {
    /// Of a node; `None` where its transform isn't animated.
    pub(super) fn of(&self, node: usize) -> Option<&Local> {
        self.nodes.get(&node)
    }
}

impl Tracks {
    /// Reads what moves the file; nothing for a scene at rest.
    pub(super) fn read(document: &Document, motion: &Motion) -> Result<Self, ImportError> {
        let all = list(document)?;
        let names = || names(all);
        let mut tracks = Self::default();
        let chosen: Vec<usize> = match motion {
            Motion::Rest => return Ok(tracks),
            Motion::Usual => (0..all.len()).collect(),
            Motion::Named(wanted) => {
                let by_name = names().position(|name| name == *wanted);
                let by_number = || wanted.parse().ok().filter(|&n: &usize| n < all.len());
                match by_name.or_else(by_number) {
                    Some(number) => vec![number],
                    // Another file of the scene may have it; whoever asks for it asks for what there is first.
                    None => return Ok(tracks),
                }
            }
        };
        let mut taken = HashSet::new();
        for number in chosen {
            let before = tracks.channels.len();
            let is_alone = tracks.add(document, number, &taken)?;
            taken.extend(tracks.channels[before..].iter().map(|c| (c.node, c.path)));
            if !is_alone {
                tracks.channels.truncate(before);
                // The first one alone: part of several would be a pose that nobody has made.
                let mut first = Self::default();
                first.add(document, 0, &HashSet::new())?;
                let name = names().next().unwrap_or_default();
                first.warnings.push(format!(
                    "animations of {} move the same: only `{name}` is shown; {}",
                    document.path.display(),
                    there_are(names())
                ));
                return Ok(first);
            }
        }
        Ok(tracks)
    }

    /// Adds an animation. False where it moves something that is `taken`.
    fn add(
        &mut self,
        document: &Document,
        number: usize,
        taken: &HashSet<(usize, Path)>,
    ) -> Result<bool, ImportError> {
        let source = &list(document)?[number];
        let name = source.get("name").and_then(Value::as_str).unwrap_or("");
        let mut own = HashSet::new();
        for (index, channel) in array(source, "channels").iter().enumerate() {
            let place = || format!("animation {number} \"{name}\", channel {index}");
            let read = self.channel(document, source, channel, &place);
            let Some(channel) = read.at(&document.path, place)? else {
                continue;
            };
            let target = (channel.node, channel.path);
            if taken.contains(&target) {
                return Ok(false);
            }
            match own.insert(target) {
                true => self.channels.push(channel),
                false => self.warnings.push(format!(
                    "{}: moves what an earlier channel moves and is left out",
                    place()
                )),
            }
        }
        Ok(true)
    }

    /// One channel; `None` where it moves nothing that there is.
    fn channel(
        &mut self,
        document: &Document,
        animation: &Value,
        channel: &Value,
        place: &dyn Fn() -> String,
    ) -> Result<Option<Channel>, Fault> {
        let target = channel.get("target").ok_or("has no target")?;
        let path = target.get("path").and_then(Value::as_str).unwrap_or("");
        let Some(&(_, path)) = Path::ALL.iter().find(|(name, _)| *name == path) else {
            self.warnings.push(match path {
                "pointer" => {
                    "KHR_animation_pointer is not supported: what it moves stands still".to_owned()
                }
                _ => format!("{}: `{path}` can't be animated; it stands still", place()),
            });
            return Ok(None);
        };
        // Without a node an extension says what is meant, and by the specification the channel is ignored.
        let Some(node) = index(target, "node")? else {
            return Ok(None);
        };
        let source =
            (document.root.nodes.get(node)).ok_or_else(|| format!("node {node} does not exist"))?;
        if source.matrix.is_some() && path != Path::Weights {
            self.warnings.push(format!(
                "{}: {} has a matrix, which can't be animated; it stands still",
                place(),
                describe(&document.root, node)
            ));
            return Ok(None);
        }
        let width = match path {
            Path::Translation | Path::Scale => 3,
            Path::Rotation => 4,
            Path::Weights => match targets(document, node) {
                0 => return Ok(None),
                targets => targets,
            },
        };
        let number = index(channel, "sampler")?.ok_or("has no sampler")?;
        let sampler = (array(animation, "samplers").get(number))
            .ok_or_else(|| format!("sampler {number} does not exist"))?;
        let accessor = |key: &str| {
            index(sampler, key)?.ok_or_else(|| format!("sampler {number} has no {key}"))
        };
        let interpolation = match sampler.get("interpolation").and_then(Value::as_str) {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                return Err(format!(
                    "sampler {number}: interpolation {other} is unknown"
                ));
            }
        };
        let accessors = [accessor("input")?, accessor("output")?];
        let is_scalar = path == Path::Weights;
        let sampler = Sampler::read(document, accessors, interpolation, width, is_scalar)
            .map_err(|fault| format!("sampler {number}: {fault}"))?;
        Ok(Some(Channel {
            node,
            path,
            sampler,
        }))
    }

    /// Where the nodes are at a moment.
    pub(super) fn at(&self, moment: &Moment, warnings: &mut Warnings) -> Places {
        for warning in &self.warnings {
            warnings.push(warning.clone());
        }
        let mut places = Places {
            is_moved: moment.motion != Motion::Rest,
            ..Places::default()
        };
        for Channel {
            node,
            path,
            sampler,
        } in &self.channels
        {
            let vector = || DVec3::from_slice(&sampler.at(moment.seconds));
            let local = places.nodes.entry(*node);
            match path {
                Path::Translation => local.or_default().translation = Some(vector()),
                Path::Scale => local.or_default().scale = Some(vector()),
                Path::Rotation => local.or_default().rotation = sampler.rotation_at(moment.seconds),
                Path::Weights => {
                    let weights = sampler.at(moment.seconds);
                    let weights = weights.into_iter().map(|weight| weight as f32).collect();
                    places.weights.insert(*node, weights);
                }
            }
        }
        places
    }

    /// Times of the first and the last key of all channels, seconds.
    fn range(&self) -> [f32; 2] {
        let ranges = self.channels.iter().map(|channel| channel.sampler.range());
        ranges
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
            .unwrap_or_default()
    }
}

/// All animations of a file. Those that make no sense have nothing but a name; what is wrong with the first of them is told.
pub(super) fn describe_all(document: &Document) -> Result<Described, ImportError> {
    let mut described = Described::default();
    for (number, name) in names(list(document)?).enumerate() {
        let mut animation = Animation {
            name,
            ..Animation::default()
        };
        match describe_one(document, number, &mut animation) {
            Ok(()) => {}
            Err(problem) if described.problem.is_none() => described.problem = Some(problem),
            Err(_) => {}
        }
        described.animations.push(animation);
    }
    Ok(described)
}

fn describe_one(
    document: &Document,
    number: usize,
    animation: &mut Animation,
) -> Result<(), ImportError> {
    let mut tracks = Tracks::default();
    tracks.add(document, number, &HashSet::new())?;
    [animation.start, animation.end] = tracks.range().map(f64::from);
    let mut seen = HashSet::new();
    for channel in &tracks.channels {
        animation.channels[channel.path as usize] += 1;
        if seen.insert(channel.node) {
            let name = document.root.nodes[channel.node].name.clone();
            animation
                .nodes
                .push(name.unwrap_or_else(|| format!("node {}", channel.node)));
        }
    }
    Ok(())
}

/// The animations as they are written.
fn list(document: &Document) -> Result<&[Value], ImportError> {
    match &document.animations {
        Value::Null => Ok(&[]),
        Value::Array(list) => Ok(list),
        _ => Err("is not a list".to_owned()).at(&document.path, || "animations".to_owned()),
    }
}

fn names(all: &[Value]) -> impl Iterator<Item = String> {
    let name = |(number, animation): (usize, &Value)| {
        let name = animation.get("name").and_then(Value::as_str);
        name.map_or_else(|| format!("animation {number}"), str::to_owned)
    };
    all.iter().enumerate().map(name)
}

/// The first few names, for messages.
fn there_are(names: impl Iterator<Item = String>) -> String {
    let mut names: Vec<String> = names.take(21).map(|name| format!("`{name}`")).collect();
    if names.is_empty() {
        return "it has none".to_owned();
    }
    if names.len() > 20 {
        names[20] = "others".to_owned();
    }
    format!("it has {}", names.join(", "))
}

fn array<'v>(value: &'v Value, key: &str) -> &'v [Value] {
    value
        .get(key)
        .and_then(Value::as_array)
        .map_or(&[], Vec::as_slice)
}

/// A number of something; `None` where there is none.
fn index(value: &Value, key: &str) -> Result<Option<usize>, Fault> {
    let Some(value) = value.get(key) else {
        return Ok(None);
    };
    let number = value
        .as_u64()
        .and_then(|number| usize::try_from(number).ok());
    number
        .map(Some)
        .ok_or_else(|| format!("its {key} is not a number of anything"))
}

/// Morph targets of a node's mesh.
fn targets(document: &Document, node: usize) -> usize {
    let mesh = document.root.nodes[node].mesh;
    let mesh = mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
    let counts = mesh.into_iter().flat_map(|mesh| &mesh.primitives);
    let counts = counts.map(|primitive| primitive.targets.as_ref().map_or(0, Vec::len));
    counts.max().unwrap_or(0)
}
