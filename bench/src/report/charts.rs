//! Charts of what was measured, as SVG. Heights are medians, whiskers reach from the lowest to the highest run.

use std::collections::BTreeSet;
use std::io;

use crate::spread::Spread;
use crate::sweeps::SweepReport;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::figures::{self, Figures};

/// Why there is no chart.
pub type ChartError = DrawingAreaErrorKind<io::Error>;

pub(super) type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Of the main chart: a group of bars needs room for its label.
const GROUP_WIDTH: u32 = 175;
const HEIGHT: u32 = 420;
const SWEEP_SIZE: (u32, u32) = (640, 340);
const FONT: (&str, u32) = ("sans-serif", 14);
const WHISKER: RGBColor = RGBColor(60, 60, 60);

/// Each form has one colour in all charts, distinct also to those who don't tell red from green.
fn color(mode: &str) -> RGBColor {
    match mode {
        "stack" => RGBColor(0, 114, 178),
        "inlined" => RGBColor(230, 159, 0),
        "rayquery" => RGBColor(0, 158, 115),
        _ => RGBColor(120, 120, 120),
    }
}

/// Some bars side by side.
struct Group {
    label: String,
    /// Whether the figures are someone else's.
    is_quoted: bool,
    bars: Vec<(&'static str, Spread)>,
}

/// Increases over grey by texture and number of AO rays, a bar for each form; beside them those of the paper.
///
/// # Errors
/// The chart can't be drawn.
pub fn increases(figures: &Figures) -> Result<String, ChartError> {
    let groups = groups(figures);
    let spreads = groups.iter().flat_map(|group| &group.bars);
    let range = y_range(spreads.map(|(_, spread)| spread));
    let columns = groups.len().max(4) as u32;
    draw((GROUP_WIDTH * columns + 80, HEIGHT), |area| {
        let width = groups.len().max(1) as f64;
        let mut chart = chart(
            area,
            "rendering time over plain grey",
            0.0..width,
            range.clone(),
        )?;
        let bottom = range.start;
        for (at, group) in groups.iter().enumerate() {
            let middle = at as f64 + 0.5;
            let step = 0.8 / group.bars.len().max(1) as f64;
            for (place, (mode, spread)) in group.bars.iter().enumerate() {
                let x = at as f64 + 0.1 + step * place as f64;
                let corners = [(x + 0.05 * step, 0.0), (x + 0.95 * step, spread.median)];
                let style = match group.is_quoted {
                    true => color(mode).mix(0.35).filled(),
                    false => color(mode).filled(),
                };
                chart.draw_series([Rectangle::new(corners, style)])?;
                if !group.is_quoted {
                    whisker(&mut chart, x + 0.5 * step, spread, 10)?;
                }
                let text = format!("{:+.0}", spread.median);
                let over = spread.high.max(spread.median).max(0.0);
                label(&mut chart, (x + 0.5 * step, over), &text, -4, VPos::Bottom)?;
            }
            label(&mut chart, (middle, bottom), &group.label, 8, VPos::Top)?;
        }
        let modes: BTreeSet<&'static str> = (groups.iter().flat_map(|group| &group.bars))
            .map(|(mode, _)| *mode)
            .collect();
        legend(&mut chart, modes)
    })
}

/// One line for each form.
pub(super) fn sweep(sweep: &SweepReport) -> Result<String, ChartError> {
    let range = y_range(sweep.points.iter().map(|point| &point.increase));
    // Values double from one to the next, and some begin with none.
    let place = |value: f64| match sweep.sweep {
        "coverage" => value,
        _ => (1.0 + value.max(0.0)).log2(),
    };
    let places = sweep.points.iter().map(|point| place(point.value));
    let (low, high) = bounds(places).unwrap_or((0.0, 1.0));
    let margin = 0.05 * (high - low).max(1.0);
    draw(SWEEP_SIZE, |area| {
        let caption = format!("{}: {}", sweep.label, sweep.texture);
        let x = low - margin..high + margin;
        let mut chart = chart(area, &caption, x, range.clone())?;
        let mut modes: Vec<&'static str> = sweep.points.iter().map(|point| point.mode).collect();
        modes.sort_unstable();
        modes.dedup();
        for &mode in &modes {
            let points = || sweep.points.iter().filter(|point| point.mode == mode);
            let line = points().map(|point| (place(point.value), point.increase.median));
            let mut line: Vec<(f64, f64)> = line.collect();
            // A model that comes nearer may be seen less of: shares are not in order by themselves.
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            let style = color(mode).stroke_width(2);
            chart.draw_series(LineSeries::new(line.iter().copied(), style))?;
            let dots = line.into_iter();
            chart.draw_series(dots.map(|at| Circle::new(at, 3, color(mode).filled())))?;
            for point in points() {
                whisker(&mut chart, place(point.value), &point.increase, 6)?;
            }
        }
        let mut labelled: Vec<f64> = Vec::new();
        for point in &sweep.points {
            if !labelled.contains(&point.value) {
                labelled.push(point.value);
                let at = (place(point.value), range.start);
                label(&mut chart, at, &figures::value(point.value), 8, VPos::Top)?;
            }
        }
        legend(&mut chart, modes)
    })
}

fn groups(figures: &Figures) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for row in figures.results.iter().filter(|row| row.texture != "gray") {
        // Scratches read no AO: their rows are the same for each number of rays.
        let label = match row.texture {
            "rust" => format!("rust, {} AO rays", row.ao_rays),
            other => other.to_owned(),
        };
        let group = match groups.iter().position(|group| group.label == label) {
            Some(place) => &mut groups[place],
            None => {
                groups.push(Group {
                    label,
                    is_quoted: false,
                    bars: Vec::new(),
                });
                groups.last_mut().expect("one was just added")
            }
        };
        if !group.bars.iter().any(|(mode, _)| *mode == row.mode) {
            group.bars.push((row.mode, row.increase));
        }
    }
    for texture in ["rust", "scratches"] {
        let published = figures.paper.iter().filter(|p| p.texture == texture);
        let bars = published.map(|p| (p.mode, Spread::of([p.increase_percent])));
        groups.push(Group {
            label: format!("{texture}, in the paper"),
            is_quoted: true,
            bars: bars.collect(),
        });
    }
    groups
}

/// Runs `fill` on an empty picture.
pub(super) fn draw(
    size: (u32, u32),
    fill: impl FnOnce(&DrawingArea<SVGBackend<'_>, plotters::coord::Shift>) -> Result<(), ChartError>,
) -> Result<String, ChartError> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        area.fill(&WHITE)?;
        fill(&area)?;
        area.present()?;
    }
    Ok(svg)
}

/// Axes with percent on the left; below, there is room for labels.
pub(super) fn chart<'a, 'b>(
    area: &'a DrawingArea<SVGBackend<'b>, plotters::coord::Shift>,
    caption: &str,
    x: std::ops::Range<f64>,
    y: std::ops::Range<f64>,
) -> Result<Chart<'a, 'b>, ChartError> {
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 17))
        .margin(12)
        .set_label_area_size(LabelAreaPosition::Left, 58)
        .set_label_area_size(LabelAreaPosition::Bottom, 30)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(0)
        .y_label_formatter(&|value: &f64| format!("{value:.0} %"))
        .light_line_style(WHITE.mix(0.0))
        .bold_line_style(BLACK.mix(0.12))
        .label_style(FONT)
        .draw()?;
    Ok(chart)
}

pub(super) fn whisker(
    chart: &mut Chart<'_, '_>,
    x: f64,
    spread: &Spread,
    width: u32,
) -> Result<(), ChartError> {
    let Spread { median, low, high } = *spread;
    let style = WHISKER.filled();
    chart.draw_series([ErrorBar::new_vertical(x, low, median, high, style, width)])?;
    Ok(())
}

/// A text in the middle of a point, so many pixels below it.
pub(super) fn label(
    chart: &mut Chart<'_, '_>,
    at: (f64, f64),
    text: &str,
    below: i32,
    vertical: VPos,
) -> Result<(), ChartError> {
    let style = FONT
        .into_text_style(chart.plotting_area())
        .pos(Pos::new(HPos::Center, vertical));
    let text = Text::new(text.to_owned(), (0, below), style);
    chart.draw_series([EmptyElement::at(at) + text])?;
    Ok(())
}

/// Colours and names of the forms, in the upper left corner.
fn legend<'a, 'b: 'a>(
    chart: &mut Chart<'a, 'b>,
    modes: impl IntoIterator<Item = &'static str>,
) -> Result<(), ChartError> {
    for mode in modes {
        chart
            .draw_series(std::iter::empty::<Circle<(f64, f64), i32>>())?
            .label(mode)
            .legend(move |(x, y)| {
                Rectangle::new([(x, y - 5), (x + 10, y + 5)], color(mode).filled())
            });
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.2))
        .label_font(FONT)
        .draw()
}

/// From zero or below to above the highest.
fn y_range<'a>(spreads: impl Iterator<Item = &'a Spread>) -> std::ops::Range<f64> {
    let all = spreads.flat_map(|spread| [spread.low, spread.high]);
    let (low, high) = bounds(all).unwrap_or((0.0, 1.0));
    let (low, high) = (low.min(0.0), high.max(1.0));
    // Room for the numbers over the bars.
    let room = 0.12 * (high - low);
    low..high + room
}

fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| value.is_finite())
        .fold(None, |bounds, value| {
            let (low, high) = bounds.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        })
}
