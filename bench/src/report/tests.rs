//! Reports of made-up figures: whether every number arrives, and whether what is written is well-formed.

use crate::scaling::{Piece, PiecePoint, ScalingReport, Team, ThreadPoint, TogetherPoint};
use crate::spread::Spread;
use crate::sweeps::{LeftOut, SweepPoint, SweepReport};
use crate::textures::{Absent, TextureResult};

use engine::stats::DeviceFacts;

use super::conditions::Conditions;
use super::figures::Figures;
use super::scaling::ScalingFigures;
use super::{charts, page, paper};

/// A number that no other place has, with one digit behind the point.
fn number(place: u32) -> f64 {
    f64::from(1013 * (place + 1) % 7919) / 10.0
}

fn spread(place: u32) -> Spread {
    let median = number(place);
    Spread {
        median,
        low: median - 0.3,
        high: median + 0.7,
    }
}

fn row(place: u32, mode: &'static str, texture: &'static str, ao_rays: u32) -> TextureResult {
    TextureResult {
        mode,
        texture,
        ao_rays,
        ms_per_spp: spread(20 * place),
        increase: spread(20 * place + 1),
        private_bytes: 10_000 + place,
        registers: None,
        stack_bytes: None,
        spills: None,
        build_ms_cold: number(20 * place + 2),
        build_ms_warm: number(20 * place + 3),
        edit_ms: number(20 * place + 4),
        source_edit_ms: number(20 * place + 5),
        pipelines_created: u64::from(20_000 + place),
        picture: vec![[0.1, 0.2, place as f32 / 16.0]; 8 * 4],
    }
}

fn figures() -> Figures {
    let mut results = Vec::new();
    for ao_rays in [4, 16] {
        for mode in ["stack", "inlined"] {
            for texture in ["gray", "rust", "scratches"] {
                results.push(row(results.len() as u32, mode, texture, ao_rays));
            }
        }
    }
    let point = |place: u32, value: f64, mode| SweepPoint {
        value,
        mode,
        ms_per_spp: spread(300 + 10 * place),
        gray_ms_per_spp: spread(301 + 10 * place),
        increase: spread(302 + 10 * place),
    };
    Figures {
        conditions: Conditions {
            patina: "0.0.0",
            commit: "0123456789ab",
            date: "2026-01-02T03:04Z".to_owned(),
            device: DeviceFacts {
                title: "Some <GPU>".to_owned(),
                name: "Some <GPU> & \"more\"".to_owned(),
                backend: "vulkan".to_owned(),
                driver: "driver 1.2".to_owned(),
            },
            width: 8,
            height: 4,
            samples_per_pixel: 2,
            max_depth: 3,
            runs: 5,
        },
        scene: "a </script> scene.glb".to_owned(),
        material: "paint & varnish".to_owned(),
        triangles: 123_456,
        coverage: 0.125,
        results,
        absent: vec![Absent {
            mode: "rayquery",
            reason: "the adapter has no ray queries <yet>".to_owned(),
        }],
        statistics_device: None,
        statistics_absent: None,
        sweeps: vec![
            SweepReport {
                sweep: "textures",
                label: "different textures in the kernel",
                texture: "one noise",
                points: vec![
                    point(0, 1.0, "stack"),
                    point(1, 1.0, "inlined"),
                    point(2, 30.0, "stack"),
                    point(3, 30.0, "inlined"),
                ],
                left_out: vec![LeftOut {
                    value: 100.0,
                    setting: None,
                    reason: "it takes too long".to_owned(),
                }],
                absent: Vec::new(),
                ended: None,
            },
            SweepReport {
                sweep: "coverage",
                label: "share of the picture covered, percent",
                texture: "rust",
                points: vec![point(4, 12.5, "stack")],
                left_out: vec![LeftOut {
                    value: 0.25,
                    setting: Some("zoom"),
                    reason: "it can't be seen".to_owned(),
                }],
                absent: Vec::new(),
                ended: Some("it <failed>".to_owned()),
            },
        ],
        paper: &paper::TABLE,
    }
}

/// Goes through the tags of HTML or SVG: each one that is opened must be closed in order. Text between them must not hold
/// brackets, so that everything is either a tag or escaped.
fn check_tags(text: &str) {
    const VOID: [&str; 4] = ["meta", "img", "br", "link"];
    let mut open: Vec<&str> = Vec::new();
    for part in text.split('<').skip(1) {
        let (tag, after) = part.split_once('>').expect("a tag ends");
        assert!(!after.contains('>'), "a bracket that isn't escaped: {part}");
        let quotes = tag.matches('"').count();
        assert!(quotes.is_multiple_of(2), "quotes of attributes: {tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "closes what was opened last");
        } else if !tag.starts_with(['!', '?']) && !tag.ends_with('/') {
            let name = tag.split_whitespace().next().expect("a tag has a name");
            if !VOID.contains(&name) {
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

#[test]
fn the_page_is_well_formed_and_needs_no_other_file() {
    let page = page::html(&figures()).expect("it is written");
    check_tags(&page);
    for outside in ["src=\"http", "href=", "@import", "url(", "<script"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("Some &lt;GPU&gt; &amp; &quot;more&quot;"));
    // The pictures of two forms and two numbers of rays all differ.
    assert_eq!(page.matches("data:image/jpeg;base64,").count(), 12);
    assert_eq!(page.matches("<svg").count(), 3);
    // They are dark: (0.1 + 0.2) / 3 is brought to 0.25.
    assert!(page.contains("All brighter by 1.3 stops."));
}

#[test]
fn what_a_driver_tells_of_kernels_has_columns_where_it_does() {
    let mut figures = figures();
    let page = page::html(&figures).expect("it is written");
    assert!(!page.contains(">registers<"));
    figures.statistics_device = Some("A <driver>".to_owned());
    figures.results[1].registers = Some(128.0);
    figures.results[1].stack_bytes = Some(640.0);
    figures.results[1].spills = Some(0.5);
    let page = page::html(&figures).expect("it is written");
    check_tags(&page);
    for text in [">registers<", ">128<", ">640<", ">0.5<", "A &lt;driver&gt;"] {
        assert!(page.contains(text), "{text}");
    }
    figures.statistics_device = None;
    figures.statistics_absent = Some("it says nothing".to_owned());
    let page = page::html(&figures).expect("it is written");
    assert!(page.contains("it says nothing"));
}

#[test]
fn every_figure_is_in_the_page() {
    let figures = figures();
    let page = page::html(&figures).expect("it is written");
    let contains = |text: String| assert!(page.contains(&text), "{text}");
    for row in figures.results.iter() {
        contains(format!(
            "{:.2} ({:.2}",
            row.ms_per_spp.median, row.ms_per_spp.low
        ));
        if row.texture != "gray" {
            contains(format!(
                "{:+.1} % ({:+.1}",
                row.increase.median, row.increase.low
            ));
            for bytes_or_count in [u64::from(row.private_bytes), row.pipelines_created] {
                contains(format!("<td>{bytes_or_count}</td>"));
            }
            let times = [
                row.build_ms_cold,
                row.build_ms_warm,
                row.edit_ms,
                row.source_edit_ms,
            ];
            for time in times {
                contains(format!("<td>{time:.1}</td>"));
            }
        }
    }
    for point in figures.sweeps.iter().flat_map(|sweep| &sweep.points) {
        contains(format!("{:+.1} %", point.increase.median));
        contains(format!("{:.2} (", point.ms_per_spp.median));
        contains(format!("{:.2} (", point.gray_ms_per_spp.median));
    }
    for words in [
        "driver 1.2",
        "2026-01-02T03:04Z",
        "0123456789ab",
        "12.5 %",
        "123,456",
        "the adapter has no ray queries &lt;yet&gt;",
        "it takes too long",
        "it &lt;failed&gt;",
        "+46 %",
        "604",
        "+15 %",
        "Theirs, not measured here",
    ] {
        contains(words.to_owned());
    }
}

#[test]
fn json_has_plain_numbers_under_the_promised_names() {
    let figures = figures();
    let text = figures.json().expect("it is JSON");
    let json: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
    let rows = json["results"].as_array().expect("a list");
    assert_eq!(rows.len(), figures.results.len());
    for (row, figure) in figures.results.iter().zip(rows) {
        assert_eq!(figure["mode"], row.mode);
        assert_eq!(figure["texture"], row.texture);
        assert_eq!(figure["private_bytes"], row.private_bytes);
        assert_eq!(figure["pipelines_created"], row.pipelines_created);
        for (name, expected) in [
            ("ms_per_spp", row.ms_per_spp.median),
            ("ms_per_spp_low", row.ms_per_spp.low),
            ("ms_per_spp_high", row.ms_per_spp.high),
            ("increase_percent", row.increase.median),
            ("increase_low", row.increase.low),
            ("increase_high", row.increase.high),
            ("increase_spread", row.increase.high - row.increase.low),
            ("build_ms_cold", row.build_ms_cold),
            ("build_ms_warm", row.build_ms_warm),
            ("edit_ms", row.edit_ms),
            ("source_edit_ms", row.source_edit_ms),
        ] {
            let number = figure[name].as_f64().expect("a plain number");
            // The reader may be off by a last bit.
            assert!((number - expected).abs() < 1e-9, "{name}: {figure}");
        }
        assert!(figure.get("picture").is_none());
    }
    let points = &json["sweeps"][0]["points"];
    assert_eq!(points[2]["value"], 30.0);
    assert_eq!(points[2]["mode"], "stack");
    assert!(points[2]["increase_percent"].is_number());
    assert!(points[2]["gray_ms_per_spp_low"].is_number());
    assert_eq!(json["sweeps"][0]["left_out"][0]["value"], 100.0);
    assert_eq!(json["sweeps"][1]["left_out"][0]["setting"], "zoom");
    assert_eq!(json["coverage"], 0.125);
    assert_eq!(json["absent"][0]["mode"], "rayquery");
    assert_eq!(json["commit"], "0123456789ab");
    assert_eq!(json["paper"][0]["increase_percent"], 46.0);
    assert_eq!(json["paper"][1]["stack_bytes"], serde_json::Value::Null);
}

#[test]
fn charts_are_drawn_of_whatever_there_is() {
    let mut figures = figures();
    let chart = charts::increases(&figures).expect("it is drawn");
    check_tags(&chart);
    for words in [
        "rust, 4 AO rays",
        "rust, 16 AO rays",
        "scratches",
        "in the paper",
        "inlined",
    ] {
        assert!(chart.contains(words), "{words}");
    }
    // Nothing but the paper, and figures that are no numbers.
    figures.results.clear();
    check_tags(&charts::increases(&figures).expect("it is drawn"));
    let sweep = &mut figures.sweeps[0];
    check_tags(&charts::sweep(sweep).expect("it is drawn"));
    sweep.points[0].increase.median = f64::NAN;
    sweep.points.truncate(1);
    check_tags(&charts::sweep(sweep).expect("it is drawn"));
    sweep.points.clear();
    check_tags(&charts::sweep(sweep).expect("it is drawn"));
}

#[test]
fn the_table_shows_forms_that_are_absent_and_values_left_out() {
    let table = figures().table();
    for words in [
        "no ray queries",
        "     100  it takes too long",
        "zoom 0.25  it can't be seen",
        "further values left out: it <failed>",
        "paint & varnish covers 12.5 %",
        "16 AO rays",
    ] {
        assert!(table.contains(words), "{words}:\n{table}");
    }
}

fn scaling() -> ScalingFigures {
    let spread = |value: f64| Spread::of([value, 1.1 * value]);
    let of_threads = |side: u32, threads: u32| ThreadPoint {
        side,
        threads,
        seconds: spread(8.0 / f64::from(threads)),
        samples_per_second: 1e5 * f64::from(threads),
        speedup: spread(f64::from(threads)),
        efficiency: 1.0,
    };
    let of_pieces = |side: u32, tile: u32, piece: Piece, team: Team| PiecePoint {
        side,
        tile,
        piece,
        team,
        seconds: spread(1.0),
        samples_per_second: 1e5,
    };
    ScalingFigures {
        patina: "0.0.0",
        commit: "0123456789ab",
        date: "2026-01-02T03:04Z".to_owned(),
        device: figures().conditions.device,
        scene: "<box> & more".to_owned(),
        triangles: 36,
        samples_per_pixel: 4,
        max_depth: 9,
        runs: 2,
        report: ScalingReport {
            threads: vec![of_threads(256, 1), of_threads(256, 2)],
            together: vec![TogetherPoint {
                side: 256,
                devices: vec!["native:1".to_owned(), "a & b".to_owned()],
                alone: vec![1e5, 3e5],
                together: 3.9e5,
                of_sum: spread(0.97),
                one: None,
                of_one: None,
                shares: vec![0.25, 0.75],
            }],
            pieces: vec![
                of_pieces(256, 32, Piece::Range, Team::Beside),
                of_pieces(512, 32, Piece::Range, Team::Beside),
                of_pieces(512, 64, Piece::Range, Team::Beside),
                of_pieces(512, 64, Piece::Tile, Team::Inside),
            ],
            left_out: vec![left_out()],
        },
    }
}

fn left_out() -> crate::scaling::LeftOut {
    crate::scaling::LeftOut {
        case: "pieces of 2048x2048, 2048x2048".to_owned(),
        reason: "it would take <long>".to_owned(),
    }
}

#[test]
fn a_report_of_scaling_is_whole_in_all_forms() {
    let figures = scaling();
    let table = figures.table();
    for words in [
        "speed-up",
        "native:1 100,000 (25 %)",
        "0.97",
        "left out",
        "by ranges",
    ] {
        assert!(table.contains(words), "{words}:\n{table}");
    }
    check_tags(&figures.svg().expect("a chart"));
    let page = figures.html().expect("a page");
    check_tags(&page);
    assert!(page.contains("&lt;box&gt; &amp; more"));
    let json = figures.json().expect("it is JSON");
    let value: serde_json::Value = serde_json::from_str(&json).expect("it is JSON");
    assert_eq!(value["pieces"][3]["piece"], "tile");
    assert_eq!(value["threads"][1]["threads"], 2);
}
