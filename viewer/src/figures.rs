//! How quickly the window follows its user: noted frame by frame, told when it is closed.

use std::fmt;

/// A frame of the window, as far as figures go.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Frame {
    /// Seconds since the start.
    pub(crate) at: f64,
    /// There is a picture.
    pub(crate) has_picture: bool,
    /// Changes whose first picture has been shown, and how long the last one took, seconds.
    pub(crate) answered: u64,
    pub(crate) latency: Option<f64>,
    /// Pixels of the viewport per pixel of the picture, along a side.
    pub(crate) coarseness: f64,
    /// The picture has all of its pixels.
    pub(crate) is_whole: bool,
    /// A button of the pointer is held, as in a drag.
    pub(crate) is_held: bool,
}

/// What is told of all frames.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Figures {
    /// Seconds from the start to the first frame with a picture.
    first_picture: Option<f64>,
    /// Seconds between frames while the pointer was held.
    frames: Vec<f64>,
    /// Pictures of changes meanwhile.
    held_pictures: u64,
    /// The coarseness of each.
    coarseness: Vec<f64>,
    /// Seconds from a change to its first picture.
    latencies: Vec<f64>,
    /// Seconds from letting go until the picture was whole again.
    sharp: Vec<f64>,
    /// When the pointer was let go, where the picture isn't whole yet.
    let_go: Option<f64>,
    last: Frame,
}

impl Figures {
    pub(crate) fn note(&mut self, frame: Frame) {
        let last = std::mem::replace(&mut self.last, frame);
        if frame.has_picture {
            self.first_picture.get_or_insert(frame.at);
        }
        let new = frame.answered - last.answered.min(frame.answered);
        if new > 0 {
            self.latencies.extend(frame.latency);
        }
        match (last.is_held, frame.is_held) {
            (true, true) => {
                self.frames.push(frame.at - last.at);
                self.held_pictures += new;
                if new > 0 {
                    self.coarseness.push(frame.coarseness);
                }
            }
            (true, false) => self.let_go = (!frame.is_whole).then_some(frame.at),
            (false, true) => self.let_go = None,
            (false, false) => {
                if frame.is_whole
                    && let Some(let_go) = self.let_go.take()
                {
                    self.sharp.push(frame.at - let_go);
                }
            }
        }
    }
}

/// That part of the sorted values lies below; 0 where there is none.
fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let index = (part * sorted.len() as f64) as usize;
    let last = sorted.len().saturating_sub(1);
    sorted.get(index.min(last)).copied().unwrap_or_default()
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms = |values: &[f64], part| 1e3 * quantile(values, part);
        match self.first_picture {
            Some(first) => writeln!(f, "first picture  {first:.2} s after the start")?,
            None => writeln!(f, "first picture  none")?,
        }
        let held: f64 = self.frames.iter().sum();
        if held > 0.0 {
            let (median, most) = (ms(&self.frames, 0.5), ms(&self.frames, 0.95));
            writeln!(
                f,
                "while dragging {held:.1} s: frames of {median:.0} ms (median), {most:.0} ms (95 %); {:.1} pictures/s at 1:{:.0}",
                self.held_pictures as f64 / held,
                quantile(&self.coarseness, 0.5),
            )?;
        }
        if !self.latencies.is_empty() {
            let (median, most) = (ms(&self.latencies, 0.5), ms(&self.latencies, 0.95));
            let count = self.latencies.len();
            writeln!(
                f,
                "changes        {median:.0} ms to a picture (median), {most:.0} ms (95 %), of {count}"
            )?;
        }
        if !self.sharp.is_empty() {
            let (median, most) = (ms(&self.sharp, 0.5), ms(&self.sharp, 1.0));
            let count = self.sharp.len();
            writeln!(
                f,
                "sharp again    {median:.0} ms after letting go (median), {most:.0} ms (longest), of {count}"
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_told_of() {
        let mut figures = Figures::default();
        let mut frame = Frame {
            at: 0.2,
            ..Frame::default()
        };
        figures.note(frame);
        (frame.at, frame.has_picture, frame.is_whole) = (0.4, true, true);
        figures.note(frame);
        // A second of frames, every other one with a new picture.
        (frame.is_held, frame.is_whole) = (true, false);
        (frame.coarseness, frame.latency) = (4.0, Some(0.03));
        for step in 0..=50_u64 {
            frame.at = 1.0 + 0.02 * step as f64;
            frame.answered = step / 2;
            figures.note(frame);
        }
        (frame.at, frame.is_held) = (2.02, false);
        figures.note(frame);
        (frame.at, frame.is_whole) = (2.22, true);
        figures.note(frame);
        (frame.at) = 9.0;
        figures.note(frame);
        let told = figures.to_string();
        let lines: Vec<&str> = told.lines().collect();
        assert_eq!(
            lines,
            [
                "first picture  0.40 s after the start",
                "while dragging 1.0 s: frames of 20 ms (median), 20 ms (95 %); 25.0 pictures/s at 1:4",
                "changes        30 ms to a picture (median), 30 ms (95 %), of 25",
                "sharp again    200 ms after letting go (median), 200 ms (longest), of 1",
            ]
        );
    }

    #[test]
    fn nothing_is_told_of_what_did_not_happen() {
        assert_eq!(Figures::default().to_string(), "first picture  none\n");
    }
}
