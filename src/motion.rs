//! When a scene is seen: flags to the moments that a render is of. Nothing is opened here.

use std::f64::consts::TAU;
use std::ops::Range;
use std::path::{Path, PathBuf};

use engine::adaptive::GRAIN;
use engine::scene::{Moment, Motion};

use crate::args::MotionArgs;
use crate::usage::UsageError;
use crate::words::{MAX_SPP, parse_decimal, parse_number, part_of};

/// Frames of a second where nothing is said.
const FPS: f64 = 24.0;
/// Moments that the shutter is open at where nothing is said.
const MOMENTS: u32 = 8;
/// Last number of a frame.
const MAX_FRAME: u32 = 999_999;
/// Digits of a frame's number in a file's name where nothing is said.
const DIGITS: usize = 4;

/// What of a scene over time is rendered.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MotionJob {
    frames: Frames,
    /// Which of them are rendered, counted from the first; all where nothing is said.
    share: Option<Range<u32>>,
    /// Frames of a second.
    fps: f64,
    /// Of the file, by name or number.
    pub(crate) animation: Option<String>,
    /// How long a picture is exposed.
    pub(crate) shutter: Option<Shutter>,
}

#[derive(Debug, Clone, PartialEq)]
enum Frames {
    /// One picture; after so many seconds, where that is said.
    One(Option<f64>),
    /// Those of these numbers.
    Range(Range<u32>, u32),
    /// The camera goes around once in so many frames, as the scene is after so many seconds.
    Turntable(u32, Option<f64>),
}

impl Frames {
    /// Pictures with numbers.
    fn count(&self) -> u32 {
        match self {
            Self::One(_) => 0,
            Self::Range(range, step) => range.len().div_ceil(*step as usize) as u32,
            Self::Turntable(count, _) => *count,
        }
    }
}

/// Which of so many frames part `I/N` has: as many as the others, but for one.
fn parse_frame_part(given: &str, frames: u32) -> Result<Range<u32>, UsageError> {
    if frames == 0 {
        return Err(UsageError::FramePartOfNone {
            given: given.to_owned(),
        });
    }
    let part = given.split_once('/').and_then(|(part, parts)| {
        let (part, parts) = (part.trim().parse().ok()?, parts.trim().parse().ok()?);
        ((1..=parts).contains(&part) && parts <= frames).then(|| part_of(frames, part, parts))
    });
    part.ok_or_else(|| UsageError::FramePart {
        given: given.to_owned(),
        frames,
    })
}

/// An open shutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shutter {
    /// Share of the time of a frame; the middle of it is the frame's own time.
    pub(crate) share: f64,
    /// Into how many moments it is divided.
    pub(crate) moments: u32,
}

/// One picture of those that are rendered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    /// In names of files.
    pub(crate) number: Option<u32>,
}

/// How a scene is seen at a moment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sight {
    pub(crate) moment: Moment,
    /// The camera stands so far around the scene, radians counter-clockwise as seen from above.
    pub(crate) turn: f64,
    /// What textures read as `FrameIndex`.
    pub(crate) frame_index: u32,
}

impl MotionJob {
    /// # Errors
    /// A flag that makes no sense.
    pub(crate) fn from_args(args: &MotionArgs) -> Result<Self, UsageError> {
        let seconds = (args.at.as_deref())
            .map(|at| parse_seconds("--at", at))
            .transpose()?;
        let frames = match (&args.frames, &args.turntable) {
            (Some(frames), _) => {
                let (range, step) = parse_frames(frames)?;
                Frames::Range(range, step)
            }
            (None, Some(count)) => {
                Frames::Turntable(parse_number("--turntable", count, 1, MAX_FRAME)?, seconds)
            }
            (None, None) => Frames::One(seconds),
        };
        let fps = (args.fps.as_deref()).map(|fps| {
            parse_decimal("--fps", fps, "from 0.001 to 10000", |x| {
                (0.001..=10_000.0).contains(&x)
            })
            // As it is written, not as the nearest single.
            .map(|single| fps.parse().unwrap_or(f64::from(single)))
        });
        let share = (args.shutter.as_deref())
            .map(|share| {
                let range = "of frames from 0 to 1, as in --shutter 0.5 for half of a frame";
                parse_decimal("--shutter", share, range, |x| (0.0..=1.0).contains(&x))
                    .map(|single| share.parse().unwrap_or(f64::from(single)))
            })
            .transpose()?;
        let moments = match &args.motion_samples {
            Some(moments) => parse_number("--motion-samples", moments, 1, MAX_SPP)?,
            None => MOMENTS,
        };
        let count = frames.count();
        let part = args.frame_part.as_deref();
        Ok(Self {
            share: part.map(|part| parse_frame_part(part, count)).transpose()?,
            frames,
            fps: fps.transpose()?.unwrap_or(FPS),
            animation: args.animation.clone(),
            shutter: (share.filter(|&share| share > 0.0)).map(|share| Shutter { share, moments }),
        })
    }

    /// Whether there are pictures with numbers.
    pub(crate) fn is_sequence(&self) -> bool {
        !matches!(self.frames, Frames::One(_))
    }

    /// All pictures.
    pub(crate) fn frames(&self) -> Vec<Frame> {
        let numbered = |number| Frame {
            number: Some(number),
        };
        let all: Vec<Frame> = match &self.frames {
            Frames::One(_) => vec![Frame { number: None }],
            Frames::Range(range, step) => range
                .clone()
                .step_by(*step as usize)
                .map(numbered)
                .collect(),
            Frames::Turntable(count, _) => (0..*count).map(numbered).collect(),
        };
        match &self.share {
            None => all,
            Some(share) => all[share.start as usize..share.end as usize].to_vec(),
        }
    }

    /// Whether both halves of a picture of so many samples have as many of each moment: else what moves would look like noise.
    pub(crate) fn has_equal_halves(&self, spp: u32) -> bool {
        let is_even = |shutter: Shutter| spp.is_multiple_of(shutter.moments.saturating_mul(GRAIN));
        self.shutter.is_none_or(is_even)
    }

    /// How a picture sees the scene: once for each moment at which its shutter is open.
    pub(crate) fn sights(&self, frame: Frame) -> Vec<Sight> {
        match self.shutter {
            None => vec![self.sight(frame, 0.0)],
            Some(Shutter { share, moments }) => (0..moments)
                .map(|moment| {
                    // The middle of each part.
                    let place = (f64::from(moment) + 0.5) / f64::from(moments) - 0.5;
                    self.sight(frame, share * place)
                })
                .collect(),
        }
    }

    /// How the scene is seen a frame before a picture, and a frame after; `None` where nothing moves.
    pub(crate) fn beside(&self, frame: Frame) -> Option<[Sight; 2]> {
        let around = [self.sight(frame, -1.0), self.sight(frame, 1.0)];
        let is_still = |sight: &Sight| sight.moment.motion == Motion::Rest && sight.turn == 0.0;
        (!around.iter().all(is_still)).then_some(around)
    }

    /// How a picture sees the scene so many frames after its own time.
    fn sight(&self, frame: Frame, after: f64) -> Sight {
        let number = frame.number.unwrap_or(0);
        let position = f64::from(number) + after;
        let (seconds, turn, frame_index, is_still) = match self.frames {
            Frames::One(at) => {
                let seconds = at.unwrap_or(0.0);
                let index = (seconds * self.fps).round().clamp(0.0, f64::from(u32::MAX));
                (seconds + after / self.fps, 0.0, index as u32, at.is_none())
            }
            Frames::Range(..) => (position / self.fps, 0.0, number, false),
            Frames::Turntable(count, at) => {
                let turn = TAU * position / f64::from(count);
                (at.unwrap_or(0.0), turn, number, at.is_none())
            }
        };
        let motion = match (&self.animation, is_still) {
            (Some(name), _) => Motion::Named(name.clone()),
            (None, true) if self.shutter.is_none() => Motion::Rest,
            (None, true) if matches!(self.frames, Frames::Turntable(..)) => Motion::Rest,
            (None, _) => Motion::Usual,
        };
        Sight {
            moment: Moment { seconds, motion },
            turn,
            frame_index,
        }
    }

    /// For the list of what a film was rendered from.
    pub(crate) fn written(&self, spp: u32) -> Option<(String, String)> {
        let Shutter { share, moments } = self.shutter?;
        let fps = self.fps;
        let text = format!(
            "shutter open for {share} of a frame at {fps} frames per second, at {moments} moments of {spp} samples"
        );
        Some(("motion".to_owned(), text))
    }
}

/// Where the samples of each moment end, of those from `first` on that a picture of `spp` samples has.
pub(crate) fn shares(moments: u32, spp: u32, samples: &Range<u32>) -> Vec<u32> {
    let end = |moment: u32| (u64::from(spp) * u64::from(moment) / u64::from(moments)) as u32;
    (1..=moments)
        .map(|moment| end(moment).clamp(samples.start, samples.end) - samples.start)
        .collect()
}

/// The name of a frame's file: the number takes the place of `####`, the longest row of these (of equal ones the last), or stands
/// before the ending.
pub(crate) fn numbered(path: &Path, number: u32) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let digits = |start: usize| name[start..].bytes().take_while(|&c| c == b'#').count();
    let rows = name.match_indices('#').map(|(start, _)| start);
    let file = match rows.max_by_key(|&start| (digits(start), start)) {
        Some(start) => {
            let count = digits(start);
            let (before, after) = (&name[..start], &name[start + count..]);
            format!("{before}{number:0count$}{after}")
        }
        None => {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let mut file = format!("{stem}.{number:0DIGITS$}");
            if let Some(extension) = path.extension() {
                file += &format!(".{}", extension.to_string_lossy());
            }
            file
        }
    };
    path.with_file_name(file)
}

fn parse_seconds(flag: &'static str, given: &str) -> Result<f64, UsageError> {
    let range = "of seconds, as in --at 1.5";
    parse_decimal(flag, given, range, |_| true)
        .map(|single| given.parse().unwrap_or(f64::from(single)))
}

/// `A..B` or `A..B:STEP`; B isn't among them.
fn parse_frames(given: &str) -> Result<(Range<u32>, u32), UsageError> {
    let (range, step) = match given.split_once(':') {
        Some((range, step)) => (range, step.trim().parse().ok()),
        None => (given, Some(1)),
    };
    let range = range.split_once("..").and_then(|(first, end)| {
        let range = first.trim().parse().ok()?..end.trim().parse().ok()?;
        (range.start < range.end && range.end <= MAX_FRAME + 1).then_some(range)
    });
    (range.zip(step.filter(|&step| step > 0))).ok_or_else(|| UsageError::Frames {
        given: given.to_owned(),
        most: MAX_FRAME,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(line: &str) -> Result<MotionJob, UsageError> {
        use clap::Parser as _;
        #[derive(clap::Parser)]
        struct Line {
            #[command(flatten)]
            motion: MotionArgs,
        }
        let words = ["patina"].into_iter().chain(line.split_whitespace());
        MotionJob::from_args(&Line::try_parse_from(words).expect("flags").motion)
    }

    fn numbers(line: &str) -> Vec<u32> {
        let frames = job(line).expect("a job").frames();
        frames.iter().filter_map(|frame| frame.number).collect()
    }

    #[test]
    fn frames_are_counted_without_the_last() {
        assert_eq!(numbers("--frames 3..6"), [3, 4, 5]);
        assert_eq!(numbers("--frames 0..7:3"), [0, 3, 6]);
        assert_eq!(numbers("--turntable 3"), [0, 1, 2]);
        assert!(numbers("--at 2").is_empty());
        for bad in [
            "3",
            "3..3",
            "4..3",
            "0..9:0",
            "-1..3",
            "0..1e3",
            "0..3:x",
            "0..9999999",
        ] {
            let error = job(&format!("--frames={bad}")).expect_err(bad);
            assert!(matches!(error, UsageError::Frames { .. }), "{bad}: {error}");
        }
    }

    #[test]
    fn parts_of_frames_are_all_of_them() {
        assert_eq!(numbers("--frames 3..10 --frame-part 1/3"), [3, 4]);
        let parts = (1..=4).flat_map(|i| numbers(&format!("--frames 0..20:2 --frame-part {i}/4")));
        assert_eq!(parts.collect::<Vec<_>>(), numbers("--frames 0..20:2"));
        assert_eq!(numbers("--turntable 4 --frame-part 4/4"), [3]);
        for bad in ["0/3", "4/3", "3", "1/8", "a/b", "1/0"] {
            let error = job(&format!("--frames 3..10 --frame-part {bad}")).expect_err(bad);
            assert!(
                matches!(error, UsageError::FramePart { .. }),
                "{bad}: {error}"
            );
        }
        let error = job("--frame-part 1/1").expect_err("no frames");
        assert!(error.to_string().contains("--turntable"), "{error}");
    }

    #[test]
    fn a_frame_and_its_time_are_the_same_sight() {
        let alone = |line: &str| {
            let job = job(line).expect("a job");
            job.sights(job.frames()[0])
        };
        assert_eq!(alone("--frames 36..37"), alone("--at 1.5"));
        assert_eq!(
            alone("--frames 15..16 --fps 10"),
            alone("--at 1.5 --fps 10")
        );
        let sight = &alone("--at 1.5")[0];
        assert_eq!((sight.moment.seconds, sight.frame_index), (1.5, 36));
        assert_eq!(sight.moment.motion, Motion::Usual);
        // Nothing said is a scene at rest.
        let rest = &alone("")[0];
        assert_eq!((&rest.moment, rest.frame_index), (&Moment::default(), 0));
        assert_eq!(
            alone("--animation Walk")[0].moment.motion,
            Motion::Named("Walk".to_owned())
        );
    }

    #[test]
    fn an_open_shutter_is_divided_around_the_frame() {
        let job = job("--frames 24..25 --shutter 0.5 --motion-samples 4").expect("a job");
        let sights = job.sights(job.frames()[0]);
        let places: Vec<f64> = (sights.iter())
            .map(|sight| (sight.moment.seconds * 24.0 - 24.0) * 16.0)
            .collect();
        for (found, wanted) in places.iter().zip([-3.0, -1.0, 1.0, 3.0]) {
            assert!((found - wanted).abs() < 1e-9, "{places:?}");
        }
        assert!(sights.iter().all(|sight| sight.frame_index == 24));
        assert_eq!(shares(4, 16, &(0..16)), [4, 8, 12, 16]);
        // A part of the samples has a part of the moments.
        assert_eq!(shares(4, 16, &(6..12)), [0, 2, 6, 6]);
    }

    #[test]
    fn a_turntable_goes_around_once() {
        let job = job("--turntable 8").expect("a job");
        let turns: Vec<f64> = (job.frames().into_iter())
            .map(|frame| job.sights(frame)[0].turn / TAU * 8.0)
            .collect();
        assert_eq!(turns, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    }

    #[test]
    fn files_are_numbered() {
        let named = |path: &str, number| numbered(Path::new(path), number);
        assert_eq!(named("a/out.exr", 1), Path::new("a/out.0001.exr"));
        assert_eq!(
            named("a/my.out.exr", 12345),
            Path::new("a/my.out.12345.exr")
        );
        assert_eq!(named("f##_x.png", 7), Path::new("f07_x.png"));
        assert_eq!(named("out", 7), Path::new("out.0007"));
        assert_eq!(named("#/out.####.png", 7), Path::new("#/out.0007.png"));
        assert_eq!(named("shot#3-###.png", 7), Path::new("shot#3-007.png"));
        assert_eq!(named("##_##.png", 7), Path::new("##_07.png"));
        assert_eq!(named("f#.png", 12), Path::new("f12.png"));
    }
}
