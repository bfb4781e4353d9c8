//! What a texture can ask the renderer for at a hit: attributes (`readAttr`) and globals (`readGlobal`).
//!
//! The one table of names. The functions that a host has to bring are made from it; the prelude and the documentation's
//! table are compared with it by tests.

use std::fmt;

/// Something `readAttr(NAME)` reads at the hit.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Attribute {
    /// One of [`BUILTIN_ATTRIBUTES`], by its place there.
    Builtin(BuiltinAttribute),
    /// A custom mesh attribute, with its leading underscore (glTF `_WETNESS`).
    Custom(String),
}

impl Attribute {
    /// The name as a texture writes it.
    pub fn name(&self) -> &str {
        match self {
            Attribute::Builtin(builtin) => builtin.name(),
            Attribute::Custom(name) => name,
        }
    }
}

impl fmt::Display for Attribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<BuiltinAttribute> for Attribute {
    fn from(builtin: BuiltinAttribute) -> Self {
        Attribute::Builtin(builtin)
    }
}

/// A host's function for a name, doing nothing. `occlusion` has one for all its names, in `host_stub.wgsl`.
macro_rules! host_function {
    (occlusion $prefix:literal $name:ident) => {
        ""
    };
    ($components:ident $prefix:literal $name:ident) => {
        concat!(
            "fn ",
            $prefix,
            stringify!($name),
            "() -> vec4f { return vec4f(0.0, 0.0, 0.0, 1.0); }\n"
        )
    };
}

/// Whether there is one number in all components.
macro_rules! is_number {
    (vector) => {
        false
    };
    (number) => {
        true
    };
    (occlusion) => {
        true
    };
}

/// Rows: a name, whether its components are a `vector` or all the same `number`, and one sentence.
macro_rules! named_enum {
    ($(#[$outer:meta])* $name:ident, $list:ident, $list_doc:literal, $host:ident, $prefix:literal:
     $($variant:ident $components:ident $doc:literal,)*) => {
        $(#[$outer])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name {
            $(#[doc = $doc] $variant,)*
        }

        #[doc = $list_doc]
        pub const $list: &[$name] = &[$($name::$variant,)*];

        impl $name {
            /// The name as a texture writes it.
            pub fn name(self) -> &'static str {
                match self {
                    $($name::$variant => stringify!($variant),)*
                }
            }

            /// One sentence for users: what the four components hold, with units.
            pub fn description(self) -> &'static str {
                match self {
                    $($name::$variant => $doc,)*
                }
            }

            /// Whether all four components hold the same number.
            pub fn is_number(self) -> bool {
                match self {
                    $($name::$variant => is_number!($components),)*
                }
            }

            /// The one of that name.
            pub fn from_name(name: &str) -> Option<Self> {
                $list.iter().copied().find(|candidate| candidate.name() == name)
            }
        }

        macro_rules! $host {
            () => {
                concat!($(host_function!($components $prefix $variant)),*)
            };
        }
    };
}

named_enum! {
    /// An attribute that every hit has, whatever the mesh.
    BuiltinAttribute, BUILTIN_ATTRIBUTES, "All built-in attributes, in the order of the prelude's constants.",
    attribute_functions, "patina_attr_":
    WorldPos vector "Position in the world, metres; w = 1.",
    LocalPos vector "Position in the object's own space, before its node's transform; w = 1.",
    Normal vector "Shading normal in the world, unit length, on the side of the viewer; w = 0.",
    GeomNormal vector "Normal of the triangle itself in the world, unit length, on the side of the viewer; w = 0.",
    LocalNormal vector "Shading normal in the object's own space, unit length; w = 0.",
    Tangent vector "Tangent in the world, unit length, the mesh's or along its first texture coordinates, turned around where the back is seen; w = handedness of the bitangent, +1 or -1, of which the back has the other one.",
    Bitangent vector "Bitangent in the world, unit length, turned around where the back is seen; w = 0.",
    TexCoord0 vector "First texture coordinates (u, v, 0, 1); v = 0 is the top row of an image.",
    TexCoord1 vector "Second texture coordinates (u, v, 0, 1); equal to the first where the mesh has one set only.",
    Color0 vector "Vertex colour, linear; (1, 1, 1, 1) where the mesh has none.",
    ViewDir vector "Direction from the hit towards where the ray came from, in the world, unit length; w = 0.",
    AO occlusion "Ambient occlusion of the node's first AO slot in every component: 1 = open, 0 = fully occluded.",
    AO1 occlusion "Ambient occlusion of the node's second AO slot, like AO.",
    Curvature number "Mean curvature in 1/metres in every component: positive on ridges, negative in creases.",
    Footprint vector "Width of the pixel here: x in metres in the world, y in uv of TexCoord0, z in the object's own space.",
    InstanceId number "Number of the instance in every component, exact up to 16 million.",
    ObjectRandom vector "Four random numbers in [0, 1), constant over an instance and stable between renders.",
    MaterialId number "Number of the material in every component.",
    FrontFacing number "1 in every component where the front of the triangle is seen, 0 where the back is.",
    Bounce number "Number of bounces before this hit in every component: 0 for what the camera sees.",
    RayKind number "What found this hit, in every component: 0 = camera ray, 1 = ray that a surface scattered, 2 = shadow ray (for opacity only).",
    Time number "Time of the frame in seconds in every component.",
}

named_enum! {
    /// A setting of the whole render, read by `readGlobal(NAME)`.
    Global, GLOBALS, "All globals, in the order of the prelude's constants.",
    global_functions, "patina_global_":
    Time number "Time of the frame in seconds in every component.",
    FrameIndex number "Number of the frame in every component, from 0.",
    SampleIndex number "Number of the sample of this pixel in every component, from 0.",
    Resolution vector "Image size in pixels: width, height, 1/width, 1/height.",
    CameraPos vector "Position of the camera in the world, metres; w = 1.",
    SceneMin vector "Least corner of the scene's bounds in the world, metres; w = 1.",
    SceneMax vector "Greatest corner of the scene's bounds in the world, metres; w = 1.",
}

/// What the host must supply in the same module, with bodies that do nothing, a line for each function: tests put it beside
/// a generated kernel to validate the whole.
pub const HOST_STUB: &str = concat!(
    include_str!("host_stub.wgsl"),
    attribute_functions!(),
    global_functions!()
);
