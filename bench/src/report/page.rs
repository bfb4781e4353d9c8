//! The report as a page for people: one file that needs no other, with tables, charts and pictures in it.

use crate::sweeps::SweepReport;
use crate::textures::Absent;
use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use engine::film::write;
use engine::scene::view::View;
use engine::stats::grouped;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::charts;
use super::figures::{self, Figures, milliseconds, percent, value, value_left_out};
use super::paper;

/// Widest picture of the page, pixels.
const THUMBNAIL: u32 = 320;

pub(super) const STYLE: &str = "\
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1100px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.7em; } h2 { font-size: 1.25em; margin-top: 2em; }
table { border-collapse: collapse; margin: 0.8em 0; font-variant-numeric: tabular-nums; }
th, td { padding: 0.25em 0.8em; border-bottom: 1px solid #ddd; text-align: right; }
th { background: #f4f4f4; } .name { text-align: left; }
.scroll { overflow-x: auto; } svg { max-width: 100%; height: auto; }
.pictures { display: flex; flex-wrap: wrap; gap: 12px; } figure { margin: 0; }
figure img { display: block; max-width: 320px; } figcaption, .note { color: #555; font-size: 0.92em; }
.quoted { background: #faf6ec; }";

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum PageError {
    /// A chart can't be drawn.
    #[error("the chart can't be drawn: {0}")]
    Chart(#[from] charts::ChartError),
    /// A picture can't be encoded.
    #[error("a picture of the page can't be encoded: {0}")]
    Picture(#[from] std::io::Error),
}

/// The whole page.
///
/// # Errors
/// A chart can't be drawn, a picture not encoded.
pub fn html(figures: &Figures) -> Result<String, PageError> {
    let chart = PreEscaped(charts::increases(figures)?);
    let pictures = pictures(figures)?;
    let sweeps = figures.sweeps.iter().map(sweep);
    let sweeps = sweeps.collect::<Result<Vec<Markup>, _>>()?;
    let title = "What procedural textures cost";
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
                (facts(figures))
                h2 { "Over plain grey" }
                div.scroll { (chart) }
                p.note {
                    "Rendering time over the same picture with plain grey, of the same form, run beside it: median, and "
                    "whiskers from the lowest to the highest run. Pale bars are the paper’s."
                }
                @for ao_rays in figures.ao_rays() {
                    h2 { (ao_rays) " rays of ambient occlusion per hit" }
                    (results(figures, ao_rays))
                }
                (absent(&figures.absent))
                (statistics(figures))
                p.note {
                    "Private memory is what the kernel’s own variables take for each thread, by their types. Builds are "
                    "from a changed source to the first image, less a usual image: cold is a text that no cache knows, warm "
                    "one that was built before. An edit is of a parameter; pipelines are those that it created. Scratches "
                    "read no ambient occlusion: their figures are the same in all tables."
                }
                h2 { "In the paper" }
                (published())
                h2 { "Pictures" }
                (pictures)
                @for sweep in &sweeps { (sweep) }
            }
        }
    };
    Ok(page.into_string())
}

/// Under which conditions it was measured.
fn facts(figures: &Figures) -> Markup {
    let conditions = &figures.conditions;
    let rows = [
        ("adapter", conditions.device.name.clone()),
        (
            "driver",
            format!(
                "{}, {}",
                conditions.device.backend, conditions.device.driver
            ),
        ),
        ("date", conditions.date.clone()),
        (
            "program",
            format!("patina {}, commit {}", conditions.patina, conditions.commit),
        ),
        (
            "scene",
            format!(
                "{}, {} triangles; {} is textured and covers {:.1} % of the picture",
                figures.scene,
                grouped(figures.triangles),
                figures.material,
                figures.coverage * 100.0
            ),
        ),
        (
            "settings",
            format!(
                "{} x {} pixels, {} samples per pixel, at most {} scattering points of a path; {} runs of each case, in turn",
                conditions.width,
                conditions.height,
                conditions.samples_per_pixel,
                conditions.max_depth,
                conditions.runs
            ),
        ),
    ];
    html! {
        table {
            @for (name, fact) in rows {
                tr { th.name { (name) } td.name { (fact) } }
            }
        }
    }
}

fn results(figures: &Figures, ao_rays: u32) -> Markup {
    let rows = || figures.results.iter().filter(|row| row.ao_rays == ao_rays);
    // Without a driver that tells, the columns would be empty.
    let is_told = rows().any(|row| row.registers.is_some());
    let figure = |known: Option<f64>| known.map_or("–".to_owned(), value);
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        th.name { "form" } th.name { "texture" } th { "ms per sample" } th { "over grey" }
                        th { "private, bytes" }
                        @if is_told { th { "registers" } th { "stack, bytes" } th { "spills" } }
                        th { "build cold, ms" } th { "build warm, ms" }
                        th { "edit, ms" } th { "source edit, ms" } th { "pipelines" }
                    }
                }
                tbody {
                    @for row in rows() {
                        tr {
                            td.name { (row.mode) } td.name { (figures::shown(row.texture)) }
                            td { (milliseconds(&row.ms_per_spp)) }
                            @if row.texture == "gray" {
                                @for _ in 0..(if is_told { 10 } else { 7 }) { td { "–" } }
                            } @else {
                                td { (percent(&row.increase)) }
                                td { (row.private_bytes) }
                                @if is_told {
                                    td { (figure(row.registers)) }
                                    td { (figure(row.stack_bytes)) }
                                    td { (figure(row.spills)) }
                                }
                                td { (format!("{:.1}", row.build_ms_cold)) }
                                td { (format!("{:.1}", row.build_ms_warm)) }
                                td { (format!("{:.1}", row.edit_ms)) }
                                td { (format!("{:.1}", row.source_edit_ms)) }
                                td { (row.pipelines_created) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Who told registers, or why nobody did.
fn statistics(figures: &Figures) -> Markup {
    html! {
        @if let Some(device) = &figures.statistics_device {
            p.note {
                "Registers, stack and spills of the kernel with the textures in it: what the driver of " (device) " says."
            }
        }
        @if let Some(reason) = &figures.statistics_absent {
            p.note { "Registers are not known: " (reason) }
        }
    }
}

fn absent(forms: &[Absent]) -> Markup {
    html! {
        @for form in forms {
            p { "The form " b { (form.mode) } " is absent: " (form.reason) }
        }
    }
}

fn published() -> Markup {
    html! {
        table.quoted {
            thead {
                tr {
                    th.name { "texture" } th.name { "approach" } th.name { "form here" } th { "over grey" }
                    th { "stack frame, bytes" }
                }
            }
            tbody {
                @for figure in &paper::TABLE {
                    tr {
                        td.name { (figure.texture) } td.name { (figure.approach) } td.name { (figure.mode) }
                        td { (format!("{:+.0} %", figure.increase_percent)) }
                        td { (figure.stack_bytes.map_or("–".to_owned(), |bytes| bytes.to_string())) }
                    }
                }
            }
        }
        p.note {
            "Theirs, not measured here: " (paper::SOURCE) ". Another scene, camera and device: compare increases, and only "
            "roughly."
        }
    }
}

fn sweep(sweep: &SweepReport) -> Result<Markup, PageError> {
    let chart = PreEscaped(charts::sweep(sweep)?);
    Ok(html! {
        h2 { "By " (sweep.label) }
        p.note { "On the model: " (sweep.texture) "." }
        div.scroll { (chart) }
        table {
            thead {
                tr {
                    th { (sweep.label) } th.name { "form" } th { "grey, ms per sample" } th { "ms per sample" }
                    th { "over grey" }
                }
            }
            tbody {
                @for point in &sweep.points {
                    tr {
                        td { (value(point.value)) } td.name { (point.mode) }
                        td { (milliseconds(&point.gray_ms_per_spp)) }
                        td { (milliseconds(&point.ms_per_spp)) }
                        td { (percent(&point.increase)) }
                    }
                }
                @for left_out in &sweep.left_out {
                    tr {
                        td { (value_left_out(left_out)) }
                        td.name colspan="4" { "left out: " (left_out.reason) }
                    }
                }
            }
        }
        (absent(&sweep.absent))
        @if let Some(reason) = &sweep.ended {
            p { "Further values are left out: " (reason) }
        }
    })
}

/// The picture of each form and texture, once.
fn pictures(figures: &Figures) -> Result<Markup, PageError> {
    let size = (figures.conditions.width, figures.conditions.height);
    let first = figures.results.first();
    let stops = first.map_or(0.0, |row| missing_stops(&row.picture));
    let mut shown = Vec::new();
    for (at, row) in figures.results.iter().enumerate() {
        let mut before = figures.results[..at].iter();
        let is_new = !before.any(|earlier| {
            (earlier.mode, earlier.texture) == (row.mode, row.texture)
                && earlier.picture == row.picture
        });
        if is_new && !row.picture.is_empty() {
            let (size, rgb) = shrunk(&row.picture, size);
            let jpeg = write::jpeg(size, &rgb, &View::exposed(stops))?;
            let uri = format!("data:image/jpeg;base64,{}", BASE64_STANDARD.encode(jpeg));
            let caption = match row.texture {
                "rust" => format!("{}, rust, {} AO rays", row.mode, row.ao_rays),
                texture => format!("{}, {}", row.mode, figures::shown(texture)),
            };
            shown.push((uri, caption));
        }
    }
    Ok(html! {
        div.pictures {
            @for (uri, caption) in &shown {
                figure { img src=(uri) alt=(caption); figcaption { (caption) } }
            }
        }
        @if stops > 0.0 { p.note { (format!("All brighter by {stops:.1} stops.")) } }
    })
}

/// Exposure that brings a dark picture to medium brightness; bright ones stay as they are.
fn missing_stops(rgb: &[[f32; 3]]) -> f32 {
    const MEDIUM: f32 = 0.25;
    // Single bright samples don't count for more than white.
    let values = rgb.iter().flatten().map(|value| value.clamp(0.0, 1.0));
    let mean = values.sum::<f32>() / (3 * rgb.len()).max(1) as f32;
    match mean > 0.0 {
        true => (MEDIUM / mean).log2().clamp(0.0, 10.0),
        false => 0.0,
    }
}

/// A picture at most [`THUMBNAIL`] pixels wide: each pixel is the mean of a block, what doesn't fill a block is cut off.
fn shrunk(rgb: &[[f32; 3]], (width, height): (u32, u32)) -> ([u32; 2], Vec<[f32; 3]>) {
    let block = width.div_ceil(THUMBNAIL).max(1).min(height.max(1));
    let (columns, rows) = (width / block, height / block);
    let mean = |column: u32, row: u32| {
        let mut sum = [0.0; 3];
        for y in row * block..(row + 1) * block {
            for x in column * block..(column + 1) * block {
                let pixel = rgb[(y * width + x) as usize];
                sum = std::array::from_fn(|c| sum[c] + pixel[c]);
            }
        }
        sum.map(|sum| sum / (block * block) as f32)
    };
    let pixels = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let shrunk = pixels.map(|(column, row)| mean(column, row)).collect();
    ([columns, rows], shrunk)
}
