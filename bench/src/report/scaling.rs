//! How rendering scales, as JSON, tables of text, a chart and a page.

use std::fmt::Write as _;

use engine::stats::{DeviceFacts, grouped};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use plotters::prelude::*;
use plotters::style::text_anchor::VPos;
use serde::Serialize;

use super::charts::{self, ChartError};
use super::page::{PageError, STYLE};
use crate::scaling::{LeftOut, Piece, ScalingReport, Team};
use crate::spread::Spread;

/// The chart of the threads and that of the pieces, side by side.
const SIZE: (u32, u32) = (1200, 380);
/// Lines of sizes of pictures: distinct also to those who don't tell red from green.
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(120, 120, 120),
];
const FONT: (&str, u32) = ("sans-serif", 14);

/// Figures with their conditions. The JSON form is read by other programs: fields are added, never renamed.
#[derive(Debug, Serialize)]
pub struct ScalingFigures {
    /// Version of the program.
    pub patina: &'static str,
    /// Commit that it was built from, with `-modified` where more was changed; `unknown` outside of a repository.
    pub commit: &'static str,
    /// When the report was made: UTC, ISO 8601.
    pub date: String,
    /// The processor.
    pub device: DeviceFacts,
    /// What was rendered.
    pub scene: String,
    /// Its triangles, those of each instance counted.
    pub triangles: u64,
    /// Of each run.
    pub samples_per_pixel: u32,
    /// Most scattering vertices of a path.
    pub max_depth: u32,
    /// Timed runs of each case, in turn.
    pub runs: u32,
    /// What was found.
    #[serde(flatten)]
    pub report: ScalingReport,
}

/// A table, for text and for the page.
struct Table {
    title: String,
    head: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// `1.234 (1.200 to 1.300)`
fn seconds(spread: &Spread) -> String {
    let Spread { median, low, high } = spread;
    format!("{median:.3} ({low:.3} to {high:.3})")
}

/// `0.97 (0.95 to 0.99)`
fn ratio(spread: &Spread) -> String {
    let Spread { median, low, high } = spread;
    format!("{median:.2} ({low:.2} to {high:.2})")
}

fn rate(samples_per_second: f64) -> String {
    grouped(samples_per_second.max(0.0) as u64)
}

fn square(side: u32) -> String {
    format!("{side}x{side}")
}

impl ScalingFigures {
    /// As JSON, with a line end behind it.
    ///
    /// # Errors
    /// None is known.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }

    fn conditions(&self) -> String {
        format!(
            "{}: {} triangles, {} samples per pixel, depth {}; medians of {} runs in turn (lowest to highest)",
            self.scene,
            grouped(self.triangles),
            self.samples_per_pixel,
            self.max_depth,
            self.runs
        )
    }

    /// For people, on a terminal.
    pub fn table(&self) -> String {
        let mut text = format!("{}\n{}\n", self.device.title, self.conditions());
        for table in self.tables() {
            let columns = 0..table.head.len();
            let lines = || std::iter::once(&table.head).chain(&table.rows);
            let width = |column: usize| lines().map(|line| line[column].chars().count()).max();
            let widths: Vec<usize> = columns.map(|c| width(c).unwrap_or(0)).collect();
            // Writing to a string can't fail.
            let _ = writeln!(text, "\n{}", table.title);
            for line in lines() {
                let cells = line.iter().zip(&widths);
                let cells: Vec<String> = cells.map(|(cell, &w)| format!("{cell:>w$}")).collect();
                let _ = writeln!(text, "{}", cells.join("  "));
            }
        }
        for LeftOut { case, reason } in &self.report.left_out {
            let _ = writeln!(text, "left out: {case}: {reason}");
        }
        text
    }

    fn tables(&self) -> Vec<Table> {
        let all = [self.threads(), self.together()];
        let pieces = Piece::ALL.map(|piece| Team::ALL.map(|team| self.pieces(piece, team)));
        let all = all.into_iter().chain(pieces.into_iter().flatten());
        all.filter(|table| !table.rows.is_empty()).collect()
    }

    fn threads(&self) -> Table {
        let rows = self.report.threads.iter().map(|point| {
            vec![
                square(point.side),
                point.threads.to_string(),
                seconds(&point.seconds),
                rate(point.samples_per_second),
                ratio(&point.speedup),
                format!("{:.2}", point.efficiency),
            ]
        });
        let head = [
            "picture",
            "threads",
            "seconds",
            "samples/s",
            "speed-up",
            "per thread",
        ];
        Table {
            title: "by threads".to_owned(),
            head: head.map(str::to_owned).into(),
            rows: rows.collect(),
        }
    }

    fn together(&self) -> Table {
        let rows = self.report.together.iter().map(|point| {
            let parts = point.devices.iter().zip(&point.alone).zip(&point.shares);
            let parts: Vec<String> = parts
                .map(|((name, &alone), share)| {
                    format!("{name} {} ({:.0} %)", rate(alone), 100.0 * share)
                })
                .collect();
            vec![
                square(point.side),
                parts.join(", "),
                rate(point.together),
                ratio(&point.of_sum),
                point.one.map_or("-".to_owned(), rate),
                point.of_one.as_ref().map_or("-".to_owned(), ratio),
            ]
        });
        let head = [
            "picture",
            "alone, samples/s (share)",
            "together",
            "of the sum",
            "one device of all threads",
            "together, of that",
        ];
        Table {
            title: "devices on one image".to_owned(),
            head: head.map(str::to_owned).into(),
            rows: rows.collect(),
        }
    }

    /// Sizes of pieces downwards, of pictures to the right, as in the paper.
    fn pieces(&self, piece: Piece, team: Team) -> Table {
        let points = || {
            let all = self.report.pieces.iter();
            all.filter(move |point| point.piece == piece && point.team == team)
        };
        let mut sides: Vec<u32> = points().map(|point| point.side).collect();
        sides.sort_unstable();
        sides.dedup();
        let mut tiles: Vec<u32> = points().map(|point| point.tile).collect();
        tiles.sort_unstable();
        tiles.dedup();
        let rows = tiles.iter().map(|&tile| {
            let cell = |&side: &u32| {
                let mut at = points().filter(|point| (point.side, point.tile) == (side, tile));
                at.next()
                    .map_or("-".to_owned(), |point| seconds(&point.seconds))
            };
            let cells = sides.iter().map(cell);
            std::iter::once(square(tile)).chain(cells).collect()
        });
        let head = sides.iter().map(|&side| format!("{}, s", square(side)));
        Table {
            title: format!("by {}s, {}", piece.name(), team.name()),
            head: std::iter::once(piece.name().to_owned())
                .chain(head)
                .collect(),
            rows: rows.collect(),
        }
    }

    /// The sides of the pictures that something is known of.
    fn sides(&self) -> Vec<u32> {
        let threads = self.report.threads.iter().map(|point| point.side);
        let mut sides: Vec<u32> = threads
            .chain(self.report.pieces.iter().map(|point| point.side))
            .collect();
        sides.sort_unstable();
        sides.dedup();
        sides
    }

    /// Two charts in one: speed by threads, and by the size of ranges with a piece for each thread.
    ///
    /// # Errors
    /// It can't be drawn.
    pub fn svg(&self) -> Result<String, ChartError> {
        let sides = self.sides();
        charts::draw(SIZE, |area| {
            let (left, right) = area.split_horizontally((SIZE.0 / 2) as i32);
            let lines = sides.iter().map(|&side| {
                let points = self.report.threads.iter().filter(move |p| p.side == side);
                let line = points.map(|p| {
                    let log = f64::from(p.threads).log2();
                    (log, 100.0 * p.efficiency, p.threads.to_string())
                });
                (square(side), line.collect())
            });
            let caption = "speed of a thread beside others, of the speed of the fewest";
            lines_of(&left, caption, &lines.collect::<Vec<_>>())?;
            let lines = sides.iter().map(|&side| {
                let points = self.report.pieces.iter().filter(move |p| {
                    p.side == side && p.piece == Piece::Range && p.team == Team::Beside
                });
                let best = points
                    .clone()
                    .map(|p| p.samples_per_second)
                    .fold(0.0, f64::max);
                let line = points.map(|p| {
                    let log = f64::from(p.tile).log2();
                    let share = 100.0 * p.samples_per_second / best.max(1e-9);
                    (log, share, p.tile.to_string())
                });
                (square(side), line.collect())
            });
            let caption = "speed by the side of ranges, of the best one";
            lines_of(&right, caption, &lines.collect::<Vec<_>>())
        })
    }

    /// A page that needs no other file.
    ///
    /// # Errors
    /// The chart can't be drawn.
    pub fn html(&self) -> Result<String, PageError> {
        let chart = PreEscaped(self.svg()?);
        let title = "How rendering scales";
        let tables: Vec<Markup> = self.tables().iter().map(markup).collect();
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { (title) }
                    p { (self.device.title) br; (self.conditions()) br;
                        "patina " (self.patina) ", commit " (self.commit) ", " (self.date) }
                    div.scroll { (chart) }
                    @for table in &tables { (table) }
                    @for LeftOut { case, reason } in &self.report.left_out {
                        p.note { "Left out: " (case) ": " (reason) "." }
                    }
                    p.note {
                        "A piece of TxT is as many pixels in the order of blocks, row by row; a range is one sample of them, "
                        "a tile all of their samples."
                    }
                }
            }
        };
        Ok(page.into_string())
    }
}

fn markup(table: &Table) -> Markup {
    html! {
        h2 { (table.title) }
        div.scroll {
            table {
                thead { tr { @for cell in &table.head { th { (cell) } } } }
                tbody {
                    @for row in &table.rows { tr { @for cell in row { td { (cell) } } } }
                }
            }
        }
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
/// Places, percent and labels of the places.
type Line = (String, Vec<(f64, f64, String)>);

fn lines_of(area: &Area<'_>, caption: &str, lines: &[Line]) -> Result<(), ChartError> {
    let places = || lines.iter().flat_map(|(_, line)| line);
    let low = places().map(|point| point.0).fold(f64::MAX, f64::min);
    let high = places().map(|point| point.0).fold(f64::MIN, f64::max);
    let (low, high) = match low <= high {
        true => (low, high),
        false => (0.0, 1.0),
    };
    let top = places().map(|point| point.1).fold(100.0, f64::max);
    let margin = 0.05 * (high - low).max(1.0);
    let x = low - margin..high + margin;
    let mut chart = charts::chart(area, caption, x, 0.0..1.15 * top)?;
    for ((name, line), color) in lines.iter().zip(COLORS.iter().cycle()) {
        let color = *color;
        let points = line.iter().map(|point| (point.0, point.1));
        chart
            .draw_series(LineSeries::new(points.clone(), color.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| Rectangle::new([(x, y - 5), (x + 10, y + 5)], color.filled()));
        chart.draw_series(points.map(|at| Circle::new(at, 3, color.filled())))?;
    }
    let mut labelled: Vec<&str> = Vec::new();
    for (place, _, text) in places() {
        if !labelled.contains(&text.as_str()) {
            labelled.push(text);
            charts::label(&mut chart, (*place, 0.0), text, 8, VPos::Top)?;
        }
    }
    if lines.is_empty() {
        return Ok(());
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.2))
        .label_font(FONT)
        .draw()
}
