//! When a scene is looked at, and what moves it.

/// A moment of a scene that moves. The default is a scene at rest.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Moment {
    /// Seconds since the beginning. Before the first key and after the last one of an animation, what it moves stands still.
    pub seconds: f64,
    /// What moves the scene.
    pub motion: Motion,
}

/// What moves a scene.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Motion {
    /// Nothing: the file's nodes stand as they are written.
    #[default]
    Rest,
    /// All animations of the file together; where two move the same, its first one.
    Usual,
    /// The animation of this name, or of this number (from 0) where none has the name.
    Named(String),
}

/// An animation of a scene's file, as people want to know of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Animation {
    /// Name in the file, or a made-up one.
    pub name: String,
    /// Time of the first key, seconds.
    pub start: f64,
    /// Time of the last key, seconds.
    pub end: f64,
    /// Nodes that it moves, by name, each once, in the order of the file.
    pub nodes: Vec<String>,
    /// How many of its channels are translations, rotations, scales, and weights of morph targets.
    pub channels: [usize; 4],
}
