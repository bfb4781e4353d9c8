//! How long methods take until their picture is good enough, as JSON, a table of text, a chart and a page with the pictures.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use engine::film::write;
use engine::scene::view::View;
use engine::stats::grouped;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use pictures::seen::{AREA, FINAL, NOTICED};
use plotters::prelude::*;
use serde::Serialize;

use super::charts::{self, ChartError};
use super::conditions::Conditions;
use super::page::{PageError, STYLE};
use crate::methods::{Curve, How, MethodsReport};

const SIZE: (u32, u32) = (820, 460);
const FONT: (&str, u32) = ("sans-serif", 14);

/// Each method has one colour, distinct also to those who don't tell red from green.
fn color(how: How) -> RGBColor {
    match how {
        How::Path => RGBColor(120, 120, 120),
        How::Adaptive => RGBColor(86, 180, 233),
        How::Draft => RGBColor(230, 159, 0),
        How::Cache => RGBColor(0, 114, 178),
        How::Photons => RGBColor(204, 121, 167),
        How::CachePhotons => RGBColor(0, 158, 115),
    }
}

/// Figures with their conditions. The JSON form is read by other programs: fields are added, never renamed.
#[derive(Debug, Serialize)]
pub struct MethodsFigures {
    /// Under which they were found.
    #[serde(flatten)]
    pub conditions: Conditions,
    /// What was rendered.
    pub scene: String,
    /// Its triangles, those of each instance counted.
    pub triangles: u64,
    /// Brightness in stops by which pictures were compared.
    pub exposure: f32,
    /// What was found.
    #[serde(flatten)]
    pub report: MethodsReport,
}

impl MethodsFigures {
    /// As JSON, with a line end behind it.
    ///
    /// # Errors
    /// None is known.
    pub fn json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }

    fn conditions(&self) -> String {
        let Conditions {
            width,
            height,
            max_depth,
            runs,
            ..
        } = self.conditions;
        format!(
            "{}: {} triangles, {width}x{height} pixels, depth {max_depth}, {runs} {} in turn",
            self.scene,
            grouped(self.triangles),
            if runs == 1 { "run" } else { "runs" }
        )
    }

    /// A line for each method: when it is final, and by how much sooner than paths.
    fn rows(&self) -> Vec<[String; 7]> {
        let row = |curve: &Curve| {
            let last = curve.points.last();
            let of_last =
                |text: &dyn Fn(&crate::methods::Point) -> String| last.map_or("-".to_owned(), text);
            [
                curve.how.name().to_owned(),
                curve
                    .final_seconds
                    .map_or("not reached".to_owned(), |seconds| format!("{seconds:.1}")),
                curve
                    .speedup
                    .map_or("-".to_owned(), |speedup| format!("{speedup:.1}")),
                curve
                    .error_speedup
                    .map_or("-".to_owned(), |speedup| format!("{speedup:.2}")),
                of_last(&|point| point.spp.to_string()),
                of_last(&|point| format!("{:.4}", point.flip)),
                of_last(&|point| format!("{:.5}", point.relative_mse)),
            ]
        };
        self.report.curves.iter().map(row).collect()
    }

    const HEAD: [&str; 7] = [
        "method",
        "s to final",
        "times paths",
        "by error",
        "samples",
        "FLIP",
        "relative MSE",
    ];

    /// For people, on a terminal.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{}\n{}\n\n",
            self.conditions.device.title,
            self.conditions()
        );
        let rows = self.rows();
        let lines = || std::iter::once(Self::HEAD.map(str::to_owned)).chain(rows.iter().cloned());
        let width = |column: usize| lines().map(|line| line[column].chars().count()).max();
        let widths: Vec<usize> = (0..Self::HEAD.len())
            .map(|column| width(column).unwrap_or(0))
            .collect();
        for line in lines() {
            let cells = line.iter().zip(&widths);
            let cells: Vec<String> = cells.map(|(cell, &w)| format!("{cell:>w$}")).collect();
            // Writing to a string can't fail.
            let _ = writeln!(text, "{}", cells.join("  "));
        }
        for left_out in &self.report.left_out {
            let _ = writeln!(text, "{left_out}");
        }
        let _ = writeln!(text, "{}", final_means());
        text
    }

    /// FLIP over seconds, both as logarithms, a line for each method.
    ///
    /// # Errors
    /// It can't be drawn.
    pub fn svg(&self) -> Result<String, ChartError> {
        let points = || self.report.curves.iter().flat_map(|curve| &curve.points);
        let bounds = |values: &mut dyn Iterator<Item = f64>| {
            values
                .map(|value| value.max(1e-6))
                .fold((f64::MAX, f64::MIN), |(low, high), value| {
                    (low.min(value), high.max(value))
                })
        };
        let x = bounds(&mut points().map(|point| point.seconds.median));
        let y = bounds(&mut points().map(|point| point.flip).chain([FINAL]));
        let x = match x.0 <= x.1 {
            true => x.0 * 0.8..x.1 * 1.25,
            false => 0.1..1.0,
        };
        let y = y.0 * 0.8..y.1 * 1.25;
        charts::draw(SIZE, |area| {
            let mut chart = ChartBuilder::on(area)
                .caption("FLIP over seconds", ("sans-serif", 17))
                .margin(12)
                .set_label_area_size(LabelAreaPosition::Left, 58)
                .set_label_area_size(LabelAreaPosition::Bottom, 36)
                .build_cartesian_2d(x.clone().log_scale(), y.log_scale())?;
            chart
                .configure_mesh()
                .light_line_style(BLACK.mix(0.04))
                .bold_line_style(BLACK.mix(0.12))
                .label_style(FONT)
                .draw()?;
            let limit = [(x.start, FINAL), (x.end, FINAL)];
            chart.draw_series(LineSeries::new(limit, BLACK.mix(0.5)))?;
            for curve in &self.report.curves {
                let color = color(curve.how);
                let line: Vec<(f64, f64)> = curve
                    .points
                    .iter()
                    .map(|point| (point.seconds.median.max(1e-6), point.flip.max(1e-6)))
                    .collect();
                chart
                    .draw_series(LineSeries::new(line.iter().copied(), color.stroke_width(2)))?
                    .label(curve.how.name())
                    .legend(move |(x, y)| {
                        Rectangle::new([(x, y - 5), (x + 10, y + 5)], color.filled())
                    });
                chart.draw_series(
                    line.into_iter()
                        .map(|at| Circle::new(at, 3, color.filled())),
                )?;
            }
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK.mix(0.2))
                .label_font(FONT)
                .draw()
        })
    }

    /// A page that needs no other file.
    ///
    /// # Errors
    /// The chart can't be drawn, a picture not encoded.
    pub fn html(&self) -> Result<String, PageError> {
        let chart = PreEscaped(self.svg()?);
        let title = "How long methods take";
        let pictures = self.pictures()?;
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
                    p { (self.conditions.device.title) br; (self.conditions()) br;
                        "patina " (self.conditions.patina) ", commit " (self.conditions.commit) ", "
                        (self.conditions.date) }
                    div.scroll {
                        table {
                            thead { tr { @for cell in Self::HEAD { th { (cell) } } } }
                            tbody {
                                @for row in self.rows() { tr { @for cell in row { td { (cell) } } } }
                            }
                        }
                    }
                    @for left_out in &self.report.left_out { p.note { (left_out) } }
                    p.note { (final_means()) }
                    div.scroll { (chart) }
                    h2 { "Pictures" }
                    (pictures)
                }
            }
        };
        Ok(page.into_string())
    }

    /// The reference, and the last picture of each method.
    fn pictures(&self) -> Result<Markup, PageError> {
        let size = [self.conditions.width, self.conditions.height];
        let reference = ("reference".to_owned(), &self.report.reference);
        let curves = self.report.curves.iter().map(|curve| {
            let last = curve.points.last();
            let after = last.map_or(String::new(), |point| {
                format!(", {} samples, {:.1} s", point.spp, point.seconds.median)
            });
            (format!("{}{after}", curve.how.name()), &curve.picture)
        });
        let mut shown = Vec::new();
        for (caption, picture) in std::iter::once(reference).chain(curves) {
            if picture.is_empty() {
                continue;
            }
            let jpeg = write::jpeg(size, picture, &View::exposed(self.exposure))?;
            let uri = format!("data:image/jpeg;base64,{}", BASE64_STANDARD.encode(jpeg));
            shown.push((uri, caption));
        }
        Ok(html! {
            div.pictures {
                @for (uri, caption) in &shown {
                    figure { img style="max-width:100%" src=(uri) alt=(caption); figcaption { (caption) } }
                }
            }
        })
    }
}

/// What is meant by it.
fn final_means() -> String {
    format!(
        "final: mean FLIP below {FINAL}, and no connected area of more than {} % of the picture above {}; \
         by error: seconds of paths over its own, until the least mean squared error that both have reached",
        100.0 * AREA,
        NOTICED * FINAL
    )
}
