//! What kernels know of materials: the record of a material in memory, its flags, its textures, and what texture programs
//! can drive. All of it follows from [`PARAMETERS`], and so does its WGSL (`wgsl.rs`); nothing of it is written twice.

mod output;
mod wgsl;

pub use output::{HEAD_LINKS, HEAD_WORDS, Kind, MOST_RESULT_FIELDS, Output, Outputs};
pub use wgsl::{material_wgsl, output_wgsl};

use crate::scene::material_parameters::{Field, PARAMETERS};

/// What a member of the record is, by its type in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// `f32`.
    F32,
    /// `u32`.
    U32,
    /// `vec2f`.
    Vec2,
    /// `vec3f`.
    Vec3,
    /// `vec4f`.
    Vec4,
}

impl Type {
    const fn words(self) -> usize {
        match self {
            Self::F32 | Self::U32 => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 => 4,
        }
    }

    /// WGSL, section 14.4.1, in words.
    const fn alignment(self) -> usize {
        match self {
            Self::F32 | Self::U32 => 1,
            Self::Vec2 => 2,
            Self::Vec3 | Self::Vec4 => 4,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::U32 => "u32",
            Self::Vec2 => "vec2f",
            Self::Vec3 => "vec3f",
            Self::Vec4 => "vec4f",
        }
    }
}

/// A member of the record.
#[derive(Debug, Clone, Copy)]
pub struct Member {
    /// As kernels call it.
    pub name: &'static str,
    /// What it is.
    pub ty: Type,
    /// Words from the start.
    pub offset: usize,
}

/// Members that are no parameter themselves, before those that are: what most hits read is together.
const FIRST: [(&str, Type); 6] = [
    ("base_color", Type::Vec4), // with alpha
    ("flags", Type::U32),
    ("texture_mask", Type::U32),   // bit per texture that is there
    ("light_radiance", Type::F32), // mean radiance by which triangles are in the table of lights; 0: they are not
    ("dielectric_f0", Type::F32),
    ("alpha_cutoff", Type::F32),
];

/// The same, behind them.
const LAST: [(&str, Type); 4] = [
    ("absorption", Type::Vec3), // 1/metres
    ("coat_normal_scale", Type::F32),
    ("iridescence_thickness", Type::Vec2), // nanometres, where its texture is 0 and 1
    ("id", Type::U32),                     // of its name
];

const COUNT: usize = FIRST.len() + recorded_parameters() + LAST.len();

/// All members but the textures, which come behind them, in no particular order.
pub const MEMBERS: [Member; COUNT] = members();

/// Rows of four words before the textures.
pub const ROWS: usize = rows();

/// Where each parameter stands in the record, in words, if it does.
pub const PLACES: [Option<usize>; PARAMETERS.len()] = places();

const fn recorded_parameters() -> usize {
    let mut count = 0;
    let mut i = 0;
    while i < PARAMETERS.len() {
        count += PARAMETERS[i].is_recorded as usize;
        i += 1;
    }
    count
}

/// Puts each member, in the order of the lists, where it fits first.
const fn members() -> [Member; COUNT] {
    let nothing = Member {
        name: "",
        ty: Type::F32,
        offset: 0,
    };
    let (mut members, mut count, mut used) = ([nothing; COUNT], 0, 0u64);
    let mut i = 0;
    while i < FIRST.len() {
        (members[count], used) = placed(FIRST[i].0, FIRST[i].1, used);
        count += 1;
        i += 1;
    }
    let mut i = 0;
    while i < PARAMETERS.len() {
        if PARAMETERS[i].is_recorded {
            let ty = match PARAMETERS[i].field {
                Field::Number(..) => Type::F32,
                Field::Color(..) => Type::Vec3,
                _ => panic!("numbers and colours are recorded, nothing else"),
            };
            (members[count], used) = placed(PARAMETERS[i].key, ty, used);
            count += 1;
        }
        i += 1;
    }
    let mut i = 0;
    while i < LAST.len() {
        (members[count], used) = placed(LAST[i].0, LAST[i].1, used);
        count += 1;
        i += 1;
    }
    members
}

const fn placed(name: &'static str, ty: Type, used: u64) -> (Member, u64) {
    let mask = (1 << ty.words()) - 1;
    let mut offset = 0;
    while used & (mask << offset) != 0 {
        offset += ty.alignment();
    }
    assert!(
        offset + ty.words() <= 64,
        "the record has more than 64 words"
    );
    (Member { name, ty, offset }, used | mask << offset)
}

const fn rows() -> usize {
    let mut end = 0;
    let mut i = 0;
    while i < MEMBERS.len() {
        let last = MEMBERS[i].offset + MEMBERS[i].ty.words();
        if last > end {
            end = last;
        }
        i += 1;
    }
    end.div_ceil(4)
}

const fn places() -> [Option<usize>; PARAMETERS.len()] {
    let mut places = [None; PARAMETERS.len()];
    let mut i = 0;
    while i < PARAMETERS.len() {
        if PARAMETERS[i].is_recorded {
            places[i] = Some(place_of(PARAMETERS[i].key));
        }
        i += 1;
    }
    places
}

/// Where a member stands, in words.
///
/// # Panics
/// There is none of this name; while compiling, where it is asked for by a constant.
pub const fn place_of(name: &str) -> usize {
    let mut i = 0;
    while i < MEMBERS.len() {
        if is_same(MEMBERS[i].name, name) {
            return MEMBERS[i].offset;
        }
        i += 1;
    }
    panic!("the record has no such member");
}

/// Whether two texts are the same, for constants.
const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

macro_rules! flags {
    ($($(#[doc = $doc:literal])+ $name:ident = $value:literal;)*) => {
        /// Bits of a record's flags; kernels call them `MATERIAL_...`.
        pub mod flag {
            $($(#[doc = $doc])+ pub const $name: u32 = $value;)*

            /// Above the flags: the number of the light group that its emission is in.
            pub const LIGHT_GROUP_SHIFT: u32 = 28;

            /// All of them, by their names.
            pub const ALL: &[(&str, u32)] = &[$((stringify!($name), $name)),*];
        }
    };
}

flags! {
    /// Both sides reflect and emit.
    DOUBLE_SIDED = 1;
    /// The base colour is shown as it is.
    UNLIT = 2;
    /// The base colour's alpha has a threshold.
    MASK = 4;
    /// It is coverage.
    BLEND = 8;
    /// Has a head in the texture programs.
    PROGRAM = 16;
    /// And needs it to know how much light comes out of it: emission, opacity.
    PROGRAM_LAST = 32;
    /// And is sampled as a light, whose emission the program tells.
    PROGRAM_LIGHT = 64;
    /// Bounds a body.
    SOLID = 128;
    /// A thin wall that light goes through straight on, so that shadow rays can follow it.
    CLEAR = 256;
    /// Pictures without environment show the shadows on it alone.
    SHADOW_CATCHER = 512;
    /// A mirror or a body of glass, as far as is known without looking at textures: it may throw caustics.
    CASTER = 1024;
}
