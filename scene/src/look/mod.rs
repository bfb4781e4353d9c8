//! The look file: what glTF cannot say. Texture nodes and what they drive, blends, ambient occlusion, includes,
//! environment, overrides of camera and material constants.
//!
//! This folder turns TOML text into a [`Look`], plain data in which every value remembers where it was written. It does
//! not know which materials the scene has or which parameters a texture takes: the engine brings those together.
//! `docs/look-file.md` is the reference for users.

mod document;
mod frame;
mod keys;
mod lamp;
mod light;
mod line_ends;
mod material;
mod parse;
mod reader;
mod rename;
mod rewrite;
#[cfg(test)]
mod tests;
mod value;
mod view;

use std::path::{Path, PathBuf};

use glam::{Affine3A, Vec3};
use texgen::{Diagnostics, SourceFile, Swizzle};

use crate::input::{self, Disk, Files};
use crate::sky::Sky;
use crate::view::ViewChoice;

pub use document::{Kept, LookDocument, Section};
pub use frame::FrameLook;
pub use lamp::direction_of;
pub use material::MaterialLook;
pub use parse::{Table, placed_fields, table};
pub use reader::{color, color_remedy, link_text, misplaced_key, unquoted};
pub use value::{Field, Span, Spanned, Value, find, parse_value};

/// What stands before the name of an image that the model brings, in place of a path.
pub const MODEL_IMAGE: &str = "model:";

/// The most AO tables a look may have: the hit of a path carries this many occlusion values.
pub const MAX_AO: usize = 4;

/// Keys of a look.
const KEYS: [&str; 10] = [
    "environment",
    "camera",
    "view",
    "light",
    "ao",
    "node",
    "material",
    "graph",
    "materialx",
    "include",
];

/// A look file, parsed. Paths in it are relative to the file itself; see [`Look::resolve`].
#[derive(Debug, Clone)]
pub struct Look {
    /// Where the text came from.
    pub path: PathBuf,
    /// The whole text; every [`Span`] points into it.
    pub file: SourceFile,
    /// Replaces the scene's environment.
    pub environment: Option<Spanned<EnvironmentLook>>,
    /// The group of lights that it is in.
    pub environment_group: Option<Spanned<String>>,
    /// Overrides of a glTF camera, or a camera of its own.
    pub camera: CameraLook,
    /// How the picture is shown.
    pub view: ViewChoice,
    /// `[light.NAME]` tables, in the order of the file.
    pub lights: Vec<LightLook>,
    /// `[ao.NAME]` tables, in the order of the file; at most [`MAX_AO`].
    pub ao: Vec<AoLook>,
    /// `[node.NAME]` tables, in the order of the file.
    pub nodes: Vec<NodeLook>,
    /// `[material.NAME]` tables, in the order of the file.
    pub materials: Vec<MaterialLook>,
    /// `[graph.NAME]` tables, in the order of the file.
    pub frames: Vec<FrameLook>,
    /// `[[materialx]]` tables, in the order of the file.
    pub materialx: Vec<MaterialxLook>,
    /// `[[include]]` tables, in the order of the file.
    pub includes: Vec<Include>,
    /// What can be read but is probably not meant so.
    pub warnings: Diagnostics,
    /// Times of the first and the last key, seconds; `None` where nothing changes with time.
    pub key_times: Option<[f64; 2]>,
}

/// `environment = { ... }`.
#[derive(Debug, Clone, PartialEq)]
pub enum EnvironmentLook {
    /// The same linear radiance from everywhere (`color` times `intensity`).
    Constant(Vec3),
    /// An equirectangular picture.
    Image {
        /// As written, relative to the look file.
        image: Spanned<String>,
        /// Degrees about +Y.
        rotation: f32,
        /// Factor on the radiance.
        intensity: f32,
    },
    /// A clear sky with its sun.
    Sky(Sky),
}

/// `[camera]`: whatever is `None` is left as it is in the glTF file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CameraLook {
    /// The glTF camera that the overrides start from; the first one where absent.
    pub name: Option<Spanned<String>>,
    /// World position, metres.
    pub position: Option<Spanned<Vec3>>,
    /// World point that the camera looks at, metres.
    pub look_at: Option<Spanned<Vec3>>,
    /// World direction that is up in the picture.
    pub up: Option<Spanned<Vec3>>,
    /// Vertical field of view, degrees.
    pub y_fov: Option<Spanned<f32>>,
    /// Lens radius, metres.
    pub aperture_radius: Option<Spanned<f32>>,
    /// Focal length over the diameter of the lens: in place of the radius.
    pub f_number: Option<Spanned<f32>>,
    /// Height of the picture in the camera, metres: with the field of view it gives the focal length.
    pub sensor_height: Option<Spanned<f32>>,
    /// Sides of the aperture, 3 to 32; 0 is a disk.
    pub blades: Option<u32>,
    /// Turn of the aperture, degrees.
    pub blade_rotation: Option<Spanned<f32>>,
    /// Distance of the plane in focus, metres.
    pub focus_distance: Option<Spanned<f32>>,
}

impl CameraLook {
    /// Whether nothing is overridden.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// `[light.NAME]`: a light of the look's own, or overrides of the lights of that name in the scene's files; whatever is `None` is left as
/// it is there.
#[derive(Debug, Clone, PartialEq)]
pub struct LightLook {
    /// What it is called.
    pub name: Spanned<String>,
    /// Of the look's own lights: what they are. `None` for those of the scene's files.
    pub kind: Option<Spanned<LampKind>>,
    /// Whether it shines.
    pub on: Option<bool>,
    /// Radiant intensity of its brightest channel, W/sr; of a rectangle along its axis, of directional lights W/m².
    pub intensity: Option<Spanned<f32>>,
    /// Linear colour, by which the intensity is multiplied.
    pub color: Option<Spanned<Vec3>>,
    /// Where it stands, metres.
    pub position: Option<Spanned<Vec3>>,
    /// Where it shines to.
    pub aim: Option<Spanned<Aim>>,
    /// Width and height of a rectangle, metres.
    pub size: Option<Spanned<[f32; 2]>>,
    /// Within which angle from the axis a spot has all of its intensity, degrees.
    pub inner_cone_angle: Option<Spanned<f32>>,
    /// Beyond which it has none.
    pub outer_cone_angle: Option<Spanned<f32>>,
    /// How far it reaches, metres.
    pub range: Option<Spanned<f32>>,
    /// Degrees; 0 for light from a single direction.
    pub angular_diameter: Option<Spanned<f32>>,
    /// The group of lights that they belong to.
    pub group: Option<Spanned<String>>,
}

/// What a light of a look is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LampKind {
    /// A point that shines in all directions.
    Point,
    /// One that shines in a cone.
    Spot,
    /// Light from infinitely far away.
    Directional,
    /// A rectangle that shines to one side.
    Area,
}

impl LampKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Point, Self::Spot, Self::Directional, Self::Area];

    /// How a look writes it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Spot => "spot",
            Self::Directional => "directional",
            Self::Area => "area",
        }
    }
}

/// Where a light shines to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// Along a direction, of any length but 0.
    Direction(Vec3),
    /// At a point, from where it stands.
    At(Vec3),
}

/// `[ao.NAME]`: one kind of ambient occlusion, traced for every hit whose textures read it.
#[derive(Debug, Clone, PartialEq)]
pub struct AoLook {
    /// The name that nodes refer to.
    pub name: Spanned<String>,
    /// How its rays are traced.
    pub settings: AoSettings,
}

/// How ambient occlusion is traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AoSettings {
    /// Length of the rays, metres; greater than 0.
    pub distance: f32,
    /// Which side of the surface the rays are sent to.
    pub direction: AoDirection,
    /// Rays per hit, 1 to 255.
    pub samples: u32,
    /// Only the instance that was hit occludes.
    pub same_object: bool,
}

impl Default for AoSettings {
    /// What a texture that reads AO gets in a look without any `[ao.NAME]`.
    fn default() -> Self {
        Self {
            distance: 0.1,
            direction: AoDirection::Outside,
            samples: 16,
            same_object: false,
        }
    }
}

/// Which side of the surface occlusion is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum AoDirection {
    /// The side that was hit: crevices and contacts are dark.
    #[default]
    Outside,
    /// Below the surface: thin parts and convex edges are dark.
    Inside,
    /// Both sides, half of the rays each.
    Both,
}

/// `[node.NAME]`: one use of a texture with its arguments.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeLook {
    /// The name that links refer to.
    pub name: Spanned<String>,
    /// The texture, a file of the textures directory without `.wgsl`.
    pub texture: Spanned<String>,
    /// `occlusion`: the AO table that `readAttr(AO)` reads.
    pub occlusion: Option<Spanned<String>>,
    /// `occlusion1`: the AO table that `readAttr(AO1)` reads.
    pub occlusion1: Option<Spanned<String>>,
    /// Everything else, without meaning until the texture's parameters are known.
    pub params: Vec<Field>,
    /// Of those of them whose values change with time, the values of all keys, each as a field of its own.
    pub keyed: Vec<Field>,
}

/// What drives an input: an output of a node.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Link {
    /// Name of the node.
    pub node: String,
    /// Components picked from its result (`x`, `rgb`, ...); `None` takes it whole.
    pub swizzle: Option<Swizzle>,
}

/// A constant or a link.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// Linear colour; a scalar is in all three components.
    Constant(Vec3),
    /// Driven by a node.
    Link(Link),
}

/// `blend = { base, over, mask }`: `over` where the mask is 1, `base` where it is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct BlendLook {
    /// A material; the material itself means what glTF (and the other keys of the table) made of it.
    pub base: Spanned<String>,
    /// A material.
    pub over: Spanned<String>,
    /// Share of `over`, 0 to 1; a scalar.
    pub mask: Spanned<Input>,
}

/// `[[materialx]]`: materials of a MaterialX document, which is read each time anew.
#[derive(Debug, Clone, PartialEq)]
pub struct MaterialxLook {
    /// As written, relative to the look file.
    pub file: Spanned<String>,
    /// Only this material of the document; all where absent.
    pub material: Option<Spanned<String>>,
    /// What it is called in the look; as in the document where absent.
    pub name: Option<Spanned<String>>,
    /// Whether drafts are read, too: procedural textures of glTF.
    pub drafts: bool,
}

/// `[[include]]`: another glTF file, placed in the scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Include {
    /// As written, relative to the look file.
    pub file: Spanned<String>,
    /// Goes before the names of what is included, as in `car/Paint`.
    pub name: Option<Spanned<String>>,
    /// Only these nodes of the file, by name; all where absent.
    pub only: Option<Vec<Spanned<String>>>,
    /// From the file's world to this one.
    pub transform: Affine3A,
}

/// Why there is no look.
#[derive(Debug, thiserror::Error)]
pub enum LookError {
    /// The file can't be read.
    #[error("cannot read the look {}: {source}{}", path.display(), input::remedy(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file has mistakes.
    #[error(transparent)]
    Invalid(#[from] Diagnostics),
}

impl Look {
    /// Reads and parses a look file of the disk.
    ///
    /// # Errors
    /// The file can't be read, or its mistakes, all of them.
    pub fn load(path: &Path) -> Result<Self, LookError> {
        Ok(Self::parse(path, &Self::read_text(&Disk, path)?)?)
    }

    /// Reads the text of a look file.
    ///
    /// # Errors
    /// It is no regular file, no text, too large, or can't be read.
    pub fn read_text(files: &dyn Files, path: &Path) -> Result<String, LookError> {
        input::read_text(files, path, parse::MAX_BYTES as u64).map_err(|source| LookError::Read {
            path: path.to_owned(),
            source,
        })
    }

    /// Parses the text of a look file that lies, or would lie, at `path`.
    ///
    /// # Errors
    /// All mistakes of the text, in its order.
    pub fn parse(path: &Path, text: &str) -> Result<Self, Diagnostics> {
        Self::parse_at(path, text, 0.0)
    }

    /// As [`Self::parse`], with values that are keyed as they are after so many seconds.
    ///
    /// # Errors
    /// All mistakes of the text, in its order, those at other keys included.
    pub fn parse_at(path: &Path, text: &str, seconds: f64) -> Result<Self, Diagnostics> {
        let (mut look, reader) = parse::parse(path, text, seconds);
        if reader.problems.is_empty() {
            look.warnings = reader.warnings.in_order();
            return Ok(look);
        }
        Err(reader.problems.in_order())
    }

    /// A look that says nothing, as if read from `path`.
    pub fn empty(path: &Path, file: SourceFile) -> Self {
        Self {
            path: path.to_owned(),
            file,
            environment: None,
            environment_group: None,
            lights: Vec::new(),
            camera: CameraLook::default(),
            view: ViewChoice::default(),
            ao: Vec::new(),
            nodes: Vec::new(),
            materials: Vec::new(),
            frames: Vec::new(),
            materialx: Vec::new(),
            includes: Vec::new(),
            warnings: Diagnostics::new(),
            key_times: None,
        }
    }

    /// A path written in the look, made relative to where the look lies.
    pub fn resolve(&self, written: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(written)
    }
}
