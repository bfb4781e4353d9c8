//! What is wrong with a command line, in words that say what is right.

use std::path::PathBuf;

use engine::adaptive::GRAIN;
use engine::film::MAX_SIDE;
use engine::scene::view::WhiteBalance;
use thiserror::Error;

/// Most samples per pixel, and the end of the last range of samples.
pub(crate) const MAX_SPP: u32 = engine::film::MAX_SAMPLES;
/// Strongest exposure in stops, either way.
pub(crate) use engine::scene::view::MAX_EXPOSURE;

/// A command line that makes no sense.
#[derive(Debug, Error, PartialEq)]
pub(crate) enum UsageError {
    /// Not `WxH`, or outside the limits.
    #[error("--size {given}: {problem}; give width x height in pixels, as in --size 1280x720")]
    Size {
        /// As typed.
        given: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A scale that makes no size.
    #[error("--scale {given}: the picture would be {sides} pixels; sides are from 1 to {MAX_SIDE}")]
    Scale {
        /// As typed.
        given: String,
        /// Width and height, with an x between them.
        sides: String,
    },
    /// Not a whole number in the range.
    #[error("{flag} {given}: must be a whole number from {low} to {high}")]
    Number {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
        /// Smallest value allowed.
        low: u32,
        /// Largest value allowed.
        high: u32,
    },
    /// No edit of a look.
    #[error("--set {given}: {form}")]
    Set {
        /// As typed.
        given: String,
        /// What it should be.
        form: String,
    },
    /// Not three numbers.
    #[error("{flag} {given}: write three numbers with commas between, as in {flag} 0,1.6,4")]
    Point {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
    },
    /// Not a time.
    #[error(
        "{flag} {given}: write a time above 0 with its unit, as in {flag}{sign}90s, {flag}{sign}10m or {flag}{sign}1h30m",
        sign = sign_behind(.flag)
    )]
    Time {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
    },
    /// What one device can do alone.
    #[error("{flag} needs a single device; name one, as in --device native")]
    OneDevice {
        /// The flag's name.
        flag: &'static str,
    },
    /// Not a finite number of stops in range.
    #[error(
        "--exposure {given}: must be a number of stops from -{MAX_EXPOSURE} to {MAX_EXPOSURE}, as in --exposure 1.5"
    )]
    Exposure {
        /// As typed.
        given: String,
    },
    /// Not a temperature with or without a tint, in range.
    #[error(
        "--white-balance {given}: must be kelvins from {} to {}, and a tint from {} to {} where there is one, as in \
         --white-balance 3200 or --white-balance 5600,20",
        WhiteBalance::TEMPERATURES.start(), WhiteBalance::TEMPERATURES.end(),
        WhiteBalance::TINTS.start(), WhiteBalance::TINTS.end()
    )]
    WhiteBalance {
        /// As typed.
        given: String,
    },
    /// The extension says no format.
    #[error(
        "-o {}: the file name must end in .png or .jpg (8-bit sRGB) or .exr (linear float)",
        path.display()
    )]
    Extension {
        /// As typed.
        path: PathBuf,
    },
    /// The extension says no format of a picture or a film.
    #[error(
        "-o {}: the file name must end in .png or .jpg (8-bit sRGB), .exr (linear float) or .patina-film (to be gone on with and merged)",
        path.display()
    )]
    ExtensionOfFilm {
        /// As typed.
        path: PathBuf,
    },
    /// Only one form of scenes is written.
    #[error("-o {}: the file name must end in .glb (glTF 2.0 binary)", path.display())]
    Exported {
        /// As typed.
        path: PathBuf,
    },
    /// Differences are shown, not kept as radiance.
    #[error("--diff {}: the file name must end in .png or .jpg", path.display())]
    Difference {
        /// As typed.
        path: PathBuf,
    },
    /// The extension says no form of a report.
    #[error(
        "-o {}: the file name must end in .html (a page to read), .json (figures for programs) or .svg (the chart)",
        path.display()
    )]
    Report {
        /// As typed.
        path: PathBuf,
    },
    /// A piece that would cut blocks of pixels.
    #[error("--tiles {given}: the side of a piece must be a multiple of 8 pixels")]
    Tile {
        /// As typed.
        given: String,
    },
    /// Nothing says what is to be textured.
    #[error(
        "--scene {}: say what is textured: --material NAME for a material of the scene, or --insert FILE for a model",
        path.display()
    )]
    Untextured {
        /// The scene.
        path: PathBuf,
    },
    /// Two results would overwrite each other.
    #[error("{} is to be written twice; give each output a name of its own", path.display())]
    Twice {
        /// The file.
        path: PathBuf,
    },
    /// A result would overwrite an input.
    #[error("{} is an input; write the result to another file", path.display())]
    OverwritesInput {
        /// The file.
        path: PathBuf,
    },
    /// The same part twice.
    #[error("{} is given twice; each part may be merged once", path.display())]
    PartTwice {
        /// The file.
        path: PathBuf,
    },
    /// Layers that there can't be together.
    #[error("--layers: {0}")]
    Layers(String),
    /// Not one of the words that a flag knows.
    #[error("{flag} {given}: must be {}", known.join(", "))]
    Word {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
        /// What it may be.
        known: Vec<&'static str>,
    },
    /// Not a number in the range.
    #[error("{flag} {given}: must be a number {range}")]
    Decimal {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
        /// Which numbers there are.
        range: &'static str,
    },
    /// Not a range of samples.
    #[error(
        "{flag} {given}: write two whole numbers from 0 to {MAX_SPP}, the smaller one first, as in {flag} 0..64"
    )]
    SampleRange {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
    },
    /// Not a range of frames.
    #[error(
        "--frames {given}: write two whole numbers from 0 to {most}, the smaller one first, and a step where not all are wanted, \
         as in --frames 0..48 or --frames 0..48:2"
    )]
    Frames {
        /// As typed.
        given: String,
        /// The last number of a frame.
        most: u32,
    },
    /// Flags that make no sense together.
    #[error("{flag} can't be combined with {other}: {because}")]
    Apart {
        /// A flag.
        flag: &'static str,
        /// Another one.
        other: &'static str,
        /// And the remedy.
        because: &'static str,
    },
    /// Samples that can't be dealt out evenly.
    #[error("--shutter: {spp} samples can't be dealt out evenly to {moments} moments; {remedy}")]
    Moments {
        /// Samples of the whole picture.
        spp: u32,
        /// Moments.
        moments: u32,
        /// What to write.
        remedy: String,
    },
    /// Samples by which a picture of several moments can't be judged.
    #[error(
        "--accuracy final: by {spp} samples a picture of {moments} moments can't be judged, of which each needs a multiple of {GRAIN}; {remedy}"
    )]
    JudgedMoments {
        /// Samples of the whole picture.
        spp: u32,
        /// Moments.
        moments: u32,
        /// What to write.
        remedy: String,
    },
    /// Not a part of a number of samples.
    #[error(
        "--part {given}: write which of how many, at most {spp}, as in --part 3/16; each part needs a sample"
    )]
    Part {
        /// As typed.
        given: String,
        /// Samples of the whole.
        spp: u32,
    },
    /// Not a part of a number of frames.
    #[error(
        "--frame-part {given}: write which of how many, as in --frame-part 3/16; each part needs one of the {frames} frames that \
         --frames or --turntable ask for"
    )]
    FramePart {
        /// As typed.
        given: String,
        /// All of them.
        frames: u32,
    },
    /// What the farm decides.
    #[error(
        "{flag}: which samples of one picture go to which file is the farm's business; leave the flag out behind `--`"
    )]
    FarmFlag {
        /// As typed.
        flag: String,
    },
    /// What parts of a farm can't have.
    #[error(
        "--shutter: a farm's parts are ranges of samples, which don't tell the moments that they are of; render the parts by hand, \
         with --spp N and --part I/N, and add them by `patina merge`"
    )]
    FarmShutter,
    /// What `patina render` wouldn't understand.
    #[error("behind `--`: {message}")]
    FarmFlags {
        /// What it says.
        message: String,
    },
    /// Layers beside the picture, and only files of pictures.
    #[error(
        "--layers: PNG and JPEG files hold the picture alone; name a file that ends in .exr or .patina-film as well, as in \
         -o room.exr"
    )]
    NoFileOfLayers,
    /// How EXR files are to be, and none is written.
    #[error(
        "{flag}: PNG and JPEG files have nothing of it; name a file that ends in .exr or .patina-film as well, as in -o room.exr"
    )]
    NoFileOfForm {
        /// The flag's name.
        flag: &'static str,
    },
    /// What EXR files can't be.
    #[error("{flag}: {problem}")]
    Form {
        /// The flag's name.
        flag: &'static str,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// Not an amount of memory.
    #[error("--memory {given}: write a number with its unit, as in --memory 8G or --memory 500M")]
    Memory {
        /// As typed.
        given: String,
    },
    /// Not a part of the picture.
    #[error(
        "--crop {given}: write the part's first column and row, its width and its height, as in --crop 100,50,640,360; it must lie in the picture of {width} x {height}"
    )]
    Crop {
        /// As typed.
        given: String,
        /// Columns of the picture.
        width: u32,
        /// Its rows.
        height: u32,
    },
    /// Not `NAME=VALUE`.
    #[error("{flag} {given}: write NAME=VALUE, as in {example}")]
    Pair {
        /// The flag's name.
        flag: &'static str,
        /// As typed.
        given: String,
        /// How it is done.
        example: &'static str,
    },
    /// Not one to four numbers.
    #[error(
        "--at {given}: `{name}` takes 1 to 4 numbers with commas between, as in --at \"WorldPos=1,2,3\""
    )]
    Numbers {
        /// The point as typed.
        given: String,
        /// The attribute.
        name: String,
    },
    /// Not two numbers, the second one the larger.
    #[error("--range {given}: write two numbers, the smaller one first, as in --range -1..1")]
    Range {
        /// As typed.
        given: String,
    },
    /// A name that no texture should have.
    #[error("`{given}` can't be the name of a texture: {problem}")]
    TextureName {
        /// As typed.
        given: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A texture's file in place of its name.
    #[error("{}: textures are named here, not their files: write `{name} --textures {}`", given.display(), folder.display())]
    TextureFile {
        /// As typed.
        given: PathBuf,
        /// The texture's name.
        name: String,
        /// Where it lies.
        folder: PathBuf,
    },
    /// `--name ''` of a material.
    #[error(
        "--name: the name is empty; write what the material of the scene is called, or leave the flag out"
    )]
    EmptyName,
    /// `--device ''`.
    #[error("--device: the name is empty; `patina devices` lists names and numbers")]
    EmptyDevice,
    /// A device that is to render beside itself.
    #[error("--device: {given} is given twice; each device renders once")]
    DeviceTwice {
        /// As typed.
        given: String,
    },
    /// Several where one does the work.
    #[error("--device {given}: this works on one device; name one, as in --device native")]
    SeveralDevices {
        /// As typed.
        given: String,
    },
    /// A part of no frames.
    #[error("--frame-part {given}: say of which frames, with --frames or --turntable")]
    FramePartOfNone {
        /// As typed.
        given: String,
    },
}

/// What stands between a flag and its value.
fn sign_behind(flag: &str) -> char {
    match flag {
        "--checkpoint" => '=', // it goes without a value, too
        _ => ' ',
    }
}
