//! What a frame of the panel costs for a very large look.

use std::fmt::Write;
use std::time::Instant;

use engine::procedural::TextureSources;
use engine::session::Edit;
use patina_panels::{Form, Textures};

use crate::support::harness_of;

const NODES: usize = 1000;

/// All nodes belong to one material: chains of ten, mixed.
fn look() -> String {
    let mut look = String::new();
    for i in 0..NODES {
        let _ = write!(look, "[node.n{i}]\ntexture = 'mix'\nb = {}\n", i % 7);
        if i > 0 {
            let _ = writeln!(look, "a = 'n{}'", if i % 10 == 0 { i - 10 } else { i - 1 });
        }
        if i >= 30 {
            let _ = writeln!(look, "c = 'n{}'", i / 2);
        }
    }
    let _ = write!(look, "[material.Iron]\nroughness = 'n{}'\n", NODES - 1);
    look
}

fn textures() -> Textures {
    let mut sources = TextureSources::default();
    let mix = "/// @param a one\n/// @param b other\n/// @param c share [0 .. 1] = 0.5\n\
               fn userProc(a: f32, b: f32, c: f32) -> f32 { return mix(a, b, c); }";
    sources.insert("mix", mix);
    Textures::load(&sources)
}

/// `cargo test --release -p patina-panels -- --ignored --nocapture frames`
#[test]
#[ignore = "prints figures"]
fn frames_of_a_large_look() {
    for (form, name) in [(Form::List, "list"), (Form::Graph, "graph")] {
        let mut harness = harness_of(form, &look(), textures(), &["Iron"]);
        harness.run_steps(3);
        for (what, edits) in [("at rest", false), ("while a value is dragged", true)] {
            let mut times: Vec<f64> = (0..40u8)
                .map(|i| {
                    let start = Instant::now();
                    if edits {
                        let value = texgen::Value::F32(f32::from(i));
                        let edit = [Edit::argument("n5", "b", &value)];
                        let document = &mut harness.state_mut().document;
                        document.apply("drag", &edit, Some(1)).expect("a look");
                    }
                    harness.step();
                    let shapes = harness.output().shapes.clone();
                    harness.ctx.tessellate(shapes, 1.0);
                    1e3 * start.elapsed().as_secs_f64()
                })
                .collect();
            times.sort_by(f64::total_cmp);
            println!(
                "{name} {what}: median {:.1} ms, worst {:.1} ms",
                times[20], times[39]
            );
        }
    }
}

/// However large a look is, all of it can be shown.
#[test]
fn a_large_look_is_shown() {
    for form in [Form::List, Form::Graph] {
        let mut harness = harness_of(form, &look(), textures(), &["Iron"]);
        harness.run_steps(2);
    }
}
