//! The graph as its host sees it: values, links, edits, programs.

use std::collections::HashMap;
use std::sync::Arc;

use crate::common::library;
use texgen::{Graph, GraphError, Interpolation, Library, NodeId, Program, Ramp, Swizzle, Value};

fn textures() -> Arc<Library> {
    library(&[
        ("one", "fn userProc(x: f32) -> f32 { return x; }"),
        (
            "two",
            "fn userProc(a: vec4f, b: vec4f) -> vec4f { return a + b; }",
        ),
        ("three", "fn userProc(x: vec3f) -> vec3f { return x; }"),
        ("pair", "fn userProc(x: vec2f) -> vec2f { return x; }"),
        (
            "occluded",
            "fn userProc(x: f32) -> f32 { return x * readAttr(AO).x; }",
        ),
        (
            "ramped",
            "fn userProc(a: f32, ramp: ramp1D, b: f32) -> f32 { return rampEval(ramp, a).x * b; }",
        ),
        (
            "image",
            "fn userProc(tex: sam2D) -> vec4f { return tex2D(tex, vec2f()); }",
        ),
        (
            "plain",
            "/// @param i i = 3\n/// @param t t = true\nfn userProc(i: i32, u: u32, t: bool, m: mat3x3f, a: array<vec2f, 2>) -> f32 { return f32(i); }",
        ),
    ])
}

fn swizzle(text: &str) -> Option<Swizzle> {
    Some(text.parse().expect("a swizzle"))
}

/// Runs a program on numbers: a node's value is its own number plus twice the sum of its links' values, so that the
/// right result needs the right slots. Returns the results of the roots.
fn run(program: &Program, graph: &Graph) -> Vec<u64> {
    let mut block = 0;
    let by_block: HashMap<u32, NodeId> = graph
        .ids()
        .map(|id| {
            let start = block;
            block += graph
                .texture(id)
                .argument_layout()
                .last()
                .map_or(0, |last| last.end);
            (start, id)
        })
        .collect();
    let mut stack = vec![u64::MAX / 4; program.slots_needed as usize];
    for instruction in program.instructions(graph.library()).expect("a program") {
        let id = by_block[&instruction.args];
        let links = instruction
            .links
            .iter()
            .map(|&(_, word)| stack[(word & 0xffff) as usize]);
        let sum = links.fold(0u64, u64::wrapping_add);
        stack[instruction.slot as usize] = sum.wrapping_mul(2).wrapping_add(id.index() as u64 + 1);
    }
    program
        .results
        .iter()
        .map(|&slot| stack[slot as usize])
        .collect()
}

/// What `run` must give.
fn expected(graph: &Graph, id: NodeId, known: &mut HashMap<NodeId, u64>) -> u64 {
    if let Some(&value) = known.get(&id) {
        return value;
    }
    let parameters = graph.texture(id).parameters().to_vec();
    let mut sum = 0u64;
    for link in parameters
        .iter()
        .filter_map(|parameter| graph.link(id, &parameter.name))
    {
        sum = sum.wrapping_add(expected(graph, link.source, known));
    }
    let value = sum.wrapping_mul(2).wrapping_add(id.index() as u64 + 1);
    known.insert(id, value);
    value
}

#[test]
fn constants_lie_in_the_fake_stack() {
    let mut graph = Graph::new(textures());
    let a = graph.add_node("a", "two", [0, 0]).expect("known");
    let edit = graph
        .set_value(a, "b", Value::Vec4([1.0, 2.0, 3.0, 4.0]))
        .expect("fits");
    assert_eq!(
        (edit.words.len(), edit.words[0].clone(), edit.program),
        (1, 4..8, false)
    );
    assert_eq!(graph.args()[4..8], [1f32, 2.0, 3.0, 4.0].map(f32::to_bits));
    let edit = graph
        .set_value(a, "b", Value::Vec4([1.0, 9.0, 3.0, 4.0]))
        .expect("fits");
    assert_eq!(
        (edit.words.len(), edit.words[0].clone()),
        (1, 5..6),
        "only what changed"
    );
    let edit = graph
        .set_value(a, "b", Value::Vec4([1.0, 9.0, 3.0, 4.0]))
        .expect("fits");
    assert!(edit.words.is_empty());
}

#[test]
fn values_are_widened_and_nothing_else() {
    let mut graph = Graph::new(textures());
    let two = graph.add_node("two", "two", [0, 0]).expect("known");
    graph
        .set_value(two, "a", Value::F32(2.0))
        .expect("a number is every component");
    assert_eq!(graph.value(two, "a"), Some(&Value::Vec4([2.0; 4])));
    graph
        .set_value(two, "a", Value::Vec3([1.0, 2.0, 3.0]))
        .expect("alpha is added");
    assert_eq!(
        graph.value(two, "a"),
        Some(&Value::Vec4([1.0, 2.0, 3.0, 1.0]))
    );
    let wrong = graph
        .set_value(two, "a", Value::Vec2([0.0; 2]))
        .expect_err("too short");
    assert_eq!(
        wrong.to_string(),
        "parameter `a` of `two` is of type vec4f, but gets a value of type vec2f"
    );
    let plain = graph.add_node("plain", "plain", [0, 0]).expect("known");
    assert_eq!(graph.value(plain, "i"), Some(&Value::I32(3)));
    assert_eq!(graph.value(plain, "t"), Some(&Value::Bool(true)));
    graph
        .set_value(plain, "i", Value::F32(-2.0))
        .expect("whole");
    assert!(graph.set_value(plain, "i", Value::F32(0.5)).is_err());
    assert!(graph.set_value(plain, "u", Value::I32(-1)).is_err());
    graph
        .set_value(plain, "a", Value::Array(vec![Value::Vec2([1.0, 2.0]); 2]))
        .expect("fits");
    assert!(
        graph
            .set_value(plain, "a", Value::Array(vec![Value::F32(1.0)]))
            .is_err()
    );
}

#[test]
fn bad_values_are_refused() {
    let mut graph = Graph::new(textures());
    let one = graph.add_node("one", "one", [0, 0]).expect("known");
    let ramped = graph.add_node("r", "ramped", [0, 0]).expect("known");
    for bad in [f32::NAN, f32::INFINITY] {
        assert!(matches!(
            graph.set_value(one, "x", Value::F32(bad)),
            Err(GraphError::BadValue { .. })
        ));
        let ramp = Ramp {
            stops: vec![(bad, [0.0; 4])],
            interpolation: Interpolation::Linear,
        };
        assert!(matches!(
            graph.set_value(ramped, "ramp", Value::Ramp(ramp)),
            Err(GraphError::BadValue { .. })
        ));
    }
    let empty = Ramp {
        stops: vec![],
        interpolation: Interpolation::Linear,
    };
    let error = graph
        .set_value(ramped, "ramp", Value::Ramp(empty))
        .expect_err("no stops");
    assert_eq!(
        error.to_string(),
        "the value of parameter `ramp` of `r` has no stops: give at least one, like [0.0, \"#ffffff\"]"
    );
}

#[test]
fn unknown_names_are_explained() {
    let mut graph = Graph::new(textures());
    let error = graph.add_node("a", "ramepd", [0, 0]).expect_err("unknown");
    assert_eq!(
        error.to_string(),
        "there is no texture called `ramepd`; did you mean `ramped`?"
    );
    let a = graph.add_node("a", "ramped", [0, 0]).expect("known");
    let error = graph
        .set_value(a, "rmap", Value::F32(0.0))
        .expect_err("unknown");
    assert_eq!(
        error.to_string(),
        "texture `ramped` has no parameter `rmap`; did you mean `ramp`?"
    );
    assert!(matches!(
        graph.add_node("a", "one", [0, 0]),
        Err(GraphError::DuplicateNode { .. })
    ));
    assert!(matches!(
        graph.add_node("b", "one", [0, 4]),
        Err(GraphError::OcclusionSlot { slot: 4, .. })
    ));
    assert_eq!(graph.node("a"), Some(a));
    assert_eq!(graph.node("b"), None);
}

#[test]
fn nodes_cannot_ask_for_gigabytes() {
    let large = "fn userProc(t: array<mat4x4f, 65536>) -> f32 { return t[0][0][0]; }";
    let small = "fn userProc(x: f32) -> f32 { return x; }";
    let textures = library(&[("large", large), ("small", small)]);
    let mut graph = Graph::new(textures);
    // Of 4 MiB each.
    let refused = (0..300).find_map(|i| graph.add_node(&format!("n{i}"), "large", [0, 0]).err());
    let error = refused.expect("1.2 GB").to_string();
    assert_eq!(
        error,
        "the constants of all nodes up to `n16` take more than 67108864 bytes: at most these are possible; use fewer nodes of `large`, or put its large tables into images"
    );
    // Nothing has changed.
    assert_eq!(graph.args().len(), 16 << 20);
    assert_eq!(graph.node("n16"), None);
    assert!(matches!(
        graph.add_node("s", "small", [0, 0]),
        Err(GraphError::TooManyConstants { .. })
    ));
}

#[test]
fn links_are_checked_and_widened() {
    let mut graph = Graph::new(textures());
    let mut add = |name: &str| graph.add_node(name, name, [0, 0]).expect("known");
    let (one, two, three, pair, ramped) = (
        add("one"),
        add("two"),
        add("three"),
        add("pair"),
        add("ramped"),
    );
    for (node, parameter, source, through) in [
        (two, "a", one, None),
        (two, "a", three, None),
        (three, "x", one, None),
        (pair, "x", one, swizzle(".x")),
        (pair, "x", three, swizzle("zy")),
    ] {
        graph
            .set_link(node, parameter, source, through)
            .expect("fits");
    }
    let error = graph
        .set_link(ramped, "a", three, None)
        .expect_err("too many components");
    assert_eq!(
        error.to_string(),
        "`three` gives vec3f, but parameter `a` of `ramped` is of type f32: take a part of it, like `.x`"
    );
    let error = graph.set_link(two, "b", pair, None).expect_err("too few");
    assert!(
        error
            .to_string()
            .ends_with("take one component of it, like `.x`, or link a texture that gives more")
    );
    let error = graph
        .set_link(two, "b", pair, swizzle("z"))
        .expect_err("no such component");
    assert_eq!(error.to_string(), "`pair` gives vec2f: it has no `.z`");
    let error = graph
        .set_link(ramped, "ramp", one, None)
        .expect_err("not linkable");
    assert!(error.to_string().contains("can't be linked"), "{error}");
}

#[test]
fn circles_are_refused_and_named() {
    let mut graph = Graph::new(textures());
    let ids: Vec<_> = ["a", "b", "c"]
        .iter()
        .map(|name| graph.add_node(name, "one", [0, 0]).expect("known"))
        .collect();
    graph.set_link(ids[0], "x", ids[1], None).expect("fits");
    graph.set_link(ids[1], "x", ids[2], None).expect("fits");
    let error = graph
        .set_link(ids[2], "x", ids[0], None)
        .expect_err("a circle");
    assert_eq!(
        error.to_string(),
        "cyclic link: c -> a -> b -> c; take one of these links away"
    );
    let error = graph
        .set_link(ids[0], "x", ids[0], None)
        .expect_err("a circle");
    assert_eq!(
        error,
        GraphError::Cycle {
            nodes: vec!["a".into(), "a".into()]
        }
    );
    assert_eq!(graph.link(ids[2], "x"), None, "the graph is unchanged");
}

#[test]
fn a_ramp_grows_without_moving_anything_else() {
    let mut graph = Graph::new(textures());
    let a = graph.add_node("a", "ramped", [0, 0]).expect("known");
    let b = graph.add_node("b", "ramped", [0, 0]).expect("known");
    let blocks = |graph: &Graph| {
        [
            graph.compile(&[a]).expect("fine").words[2],
            graph.compile(&[b]).expect("fine").words[2],
        ]
    };
    let before = blocks(&graph);
    let size = graph.args().len();
    let ramp = |n: usize| {
        Value::Ramp(Ramp {
            stops: (0..n).rev().map(|i| (i as f32, [i as f32; 4])).collect(),
            interpolation: Interpolation::Smooth,
        })
    };
    graph.set_value(a, "ramp", ramp(3)).expect("fits");
    assert_eq!(graph.args().len(), size, "there is room for a few stops");
    let edit = graph.set_value(a, "ramp", ramp(100)).expect("fits");
    assert!(graph.args().len() > size);
    let at = graph.args()[before[0] as usize + 1] as usize;
    assert!(
        edit.words.iter().any(|range| range.contains(&at))
            && edit
                .words
                .iter()
                .any(|range| range.contains(&(before[0] as usize + 1)))
    );
    assert_eq!(graph.args()[at], 100 | 1 << 30);
    assert_eq!(
        graph.args()[at + 1 + 5],
        1f32.to_bits(),
        "sorted by position"
    );
    let size = graph.args().len();
    graph.set_value(b, "ramp", ramp(3)).expect("fits");
    graph.set_value(a, "ramp", ramp(150)).expect("fits");
    assert_eq!(graph.args().len(), size, "room was reserved");
    assert_eq!(blocks(&graph), before);
}

#[test]
fn programs_evaluate_shared_nodes_once_and_keep_roots() {
    let mut graph = Graph::new(textures());
    let ids: Vec<_> = (0..5)
        .map(|i| {
            graph
                .add_node(&i.to_string(), "two", [0, 0])
                .expect("known")
        })
        .collect();
    for (node, parameter, source) in [
        (0, "a", 1),
        (0, "b", 2),
        (1, "a", 3),
        (2, "a", 3),
        (2, "b", 4),
    ] {
        graph
            .set_link(ids[node], parameter, ids[source], None)
            .expect("fits");
    }
    let roots = [ids[0], ids[3], ids[2], ids[0]];
    let program = graph.compile(&roots).expect("fine");
    assert_eq!(program.words[0], 5, "each node once");
    assert_eq!(program.results[0], program.results[3]);
    let mut known = HashMap::new();
    let wanted: Vec<u64> = roots
        .iter()
        .map(|&root| expected(&graph, root, &mut known))
        .collect();
    assert_eq!(run(&program, &graph), wanted);
    assert_eq!(graph.compile(&[]).expect("fine").words, [0]);
    let short = Program {
        words: program.words[..5].to_vec(),
        ..Program::default()
    };
    assert!(short.instructions(graph.library()).is_err());
}

#[test]
fn a_thousand_nodes_a_hundred_deep() {
    let mut graph = Graph::new(textures());
    let ids: Vec<_> = (0..1500)
        .map(|i| {
            graph
                .add_node(&i.to_string(), "two", [0, 0])
                .expect("known")
        })
        .collect();
    for i in 10..1500 {
        // Layers of ten: everything reads two nodes of the layer below, so the depth is 150.
        let below = (i / 10 - 1) * 10;
        graph
            .set_link(ids[i], "a", ids[below + i * 7 % 10], None)
            .expect("fits");
        graph
            .set_link(ids[i], "b", ids[below + (i * 3 + 1) % 10], swizzle("wzyx"))
            .expect("fits");
    }
    let roots = [ids[1499], ids[1490]];
    let program = graph.compile(&roots).expect("fine");
    assert!(program.slots_needed <= 24, "{} slots", program.slots_needed);
    let mut known = HashMap::new();
    let wanted: Vec<u64> = roots
        .iter()
        .map(|&root| expected(&graph, root, &mut known))
        .collect();
    assert_eq!(run(&program, &graph), wanted);
}

#[test]
fn a_very_long_chain_needs_two_slots_and_no_deep_stack() {
    let mut graph = Graph::new(textures());
    let ids: Vec<_> = (0..20_000)
        .map(|i| {
            graph
                .add_node(&i.to_string(), "one", [0, 0])
                .expect("known")
        })
        .collect();
    // Built from the far end, so that the search for circles stays short.
    for pair in ids.windows(2).rev() {
        graph.set_link(pair[1], "x", pair[0], None).expect("fits");
    }
    let program = graph.compile(&[ids[ids.len() - 1]]).expect("fine");
    assert_eq!(program.words[0], 20_000);
    assert!(program.slots_needed <= 2);
}

#[test]
fn occlusion_is_in_the_program() {
    let mut graph = Graph::new(textures());
    let a = graph.add_node("a", "occluded", [2, 3]).expect("known");
    let program = graph.compile(&[a]).expect("fine");
    assert_eq!(program.occlusion_mask, 1 << 2, "AO1 is not read");
    assert_eq!(program.words.last(), Some(&(2 | 3 << 8)));
    assert!(graph.set_occlusion(a, [1, 0]).expect("a slot").program);
    assert_eq!(graph.compile(&[a]).expect("fine").occlusion_mask, 1 << 1);
    let b = graph.add_node("b", "one", [2, 3]).expect("known");
    assert!(!graph.set_occlusion(b, [1, 0]).expect("a slot").program);
    assert_eq!(graph.compile(&[b]).expect("fine").occlusion_mask, 0);
}

#[test]
fn constants_and_links_replace_each_other() {
    let mut graph = Graph::new(textures());
    let a = graph.add_node("a", "one", [0, 0]).expect("known");
    let b = graph.add_node("b", "one", [0, 0]).expect("known");
    graph.set_value(a, "x", Value::F32(5.0)).expect("fits");
    assert!(graph.set_link(a, "x", b, None).expect("fits").program);
    assert!(
        !graph.set_link(a, "x", b, None).expect("fits").program,
        "nothing changed"
    );
    assert!(graph.clear_link(a, "x").expect("known").program);
    assert_eq!(
        graph.value(a, "x"),
        Some(&Value::F32(5.0)),
        "the constant is back"
    );
    graph.set_link(a, "x", b, None).expect("fits");
    assert!(
        graph
            .set_value(a, "x", Value::F32(1.0))
            .expect("fits")
            .program
    );
    assert_eq!(graph.link(a, "x"), None);
}

#[test]
fn images_must_be_set_before_use() {
    let mut graph = Graph::new(textures());
    let a = graph.add_node("a", "image", [0, 0]).expect("known");
    let error = graph.compile(&[a]).expect_err("no image");
    assert_eq!(
        error.to_string(),
        "parameter `tex` of `a` is an image and has none: set `tex` to an image file"
    );
    graph.set_value(a, "tex", Value::Image(7)).expect("fits");
    graph.compile(&[a]).expect("fine");
    assert_eq!(graph.args()[0], 7);
}

#[test]
fn a_new_version_of_a_texture_keeps_values_and_links() {
    let old = library(&[(
        "t",
        "fn userProc(a: f32, b: f32, c: f32) -> f32 { return a; }",
    )]);
    let new = library(&[
        ("u", "fn userProc() -> f32 { return 0.0; }"),
        (
            "t",
            "fn userProc(extra: vec3f, b: vec4f, c: f32) -> f32 { return c; }",
        ),
    ]);
    let mut graph = Graph::new(old);
    let x = graph.add_node("x", "t", [1, 0]).expect("known");
    let y = graph.add_node("y", "t", [0, 0]).expect("known");
    graph.set_value(x, "b", Value::F32(2.0)).expect("fits");
    graph.set_value(x, "a", Value::F32(2.0)).expect("fits");
    graph.set_link(y, "c", x, None).expect("fits");
    assert!(!graph.keeps_given(&new), "`a` is gone, `b` another type");
    let (graph, dropped) = graph.with_library(new).expect("fits");
    assert!(dropped.is_empty());
    assert!(graph.keeps_given(graph.library()));
    // What has its default, or was added, may be anything.
    let other = library(&[(
        "t",
        "fn userProc(c: f32, b: vec4f, more: f32) -> f32 { return c; }",
    )]);
    assert!(graph.keeps_given(&other));
    assert_eq!(graph.value(x, "b"), Some(&Value::Vec4([2.0; 4])));
    assert_eq!(graph.link(y, "c").map(|link| link.source), Some(x));
    assert_eq!(graph.occlusion(x), [1, 0]);
    // A value that fits no more gives way to the default, a link that fits no more is an error.
    let retyped = library(&[(
        "t",
        "/// @param b = 7\nfn userProc(b: i32, c: f32) -> f32 { return c; }",
    )]);
    let (retyped, dropped) = graph.with_library(retyped).expect("links fit");
    assert_eq!(retyped.value(x, "b"), Some(&Value::I32(7)));
    assert_eq!(dropped.len(), 1);
    assert_eq!(
        dropped[0].to_string(),
        "parameter `b` of `x` is of type i32 now and has its default: its former value doesn't fit"
    );
    let unlinkable = library(&[("t", "fn userProc(c: mat3x3f) -> f32 { return c[0].x; }")]);
    let error = graph.with_library(unlinkable).expect_err("linked");
    assert!(error.to_string().contains("`c` of `y`"), "{error}");
    assert!(matches!(
        graph.with_library(library(&[])),
        Err(GraphError::UnknownTexture { .. })
    ));
}
