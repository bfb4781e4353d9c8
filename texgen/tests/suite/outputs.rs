//! Textures that give several values, which links take by name.

use std::sync::Arc;

use texgen::{Graph, GraphError, HOST_STUB, Library, OutputType, Swizzle, emit_inlined};

use crate::common::{errors, library, parse, valid_kernel, validate};

const CELLS: &str = "struct Cells { distance: f32, cell: vec2f, color: vec3f, all: vec4f }
/// Cells.
/// @output cell  a number of the cell
/// @output color its colour
/// @param x where
fn userProc(x: f32) -> Cells {
    return Cells(x, vec2f(x), vec3f(x), vec4f(x));
}";

fn textures() -> Arc<Library> {
    library(&[
        ("cells", CELLS),
        (
            "sum",
            "fn userProc(a: vec3f, b: f32) -> vec3f { return a + b; }",
        ),
        (
            "placed",
            "/// @param p where [attr LocalPos]\nfn userProc(p: vec4f) -> vec4f { return p; }",
        ),
    ])
}

fn take(text: &str) -> Option<Swizzle> {
    Some(text.parse().expect("a swizzle"))
}

#[test]
fn members_of_a_struct_are_outputs_with_descriptions() {
    let texture = parse("cells", CELLS).expect("valid");
    let outputs: Vec<_> = (texture.outputs().iter())
        .map(|output| (&*output.name, output.ty, &*output.label))
        .collect();
    assert_eq!(
        outputs,
        [
            ("distance", OutputType::F32, ""),
            ("cell", OutputType::Vec2, "a number of the cell"),
            ("color", OutputType::Vec3, "its colour"),
            ("all", OutputType::Vec4, ""),
        ]
    );
    assert_eq!(texture.output(), OutputType::F32, "of the first");
    assert_eq!(texture.docs(), "Cells.");
    assert!(texture.warnings().is_empty());
    let odd = CELLS.replace("@output color", "@output colour");
    let warnings = parse("cells", &odd).expect("valid").warnings().render();
    assert!(warnings.contains("no output `colour`") && warnings.contains("did you mean `color`?"));
}

#[test]
fn structs_that_links_could_not_name_are_refused() {
    for (member, says) in [
        ("x: f32", "can't be called `x`"),
        ("rgb: vec3f", "can't be called `rgb`"),
        ("number: i32", "`number` is none of f32"),
        ("inner: mat3x3f", "`inner` is none of f32"),
        (
            "größe: f32",
            "can't be called `größe`: links write names with",
        ),
        (
            "a_very_long_name_of_what_it_gives: f32",
            "it is longer than 31 letters",
        ),
    ] {
        let text = format!(
            "struct S {{ first: f32, {member} }}\nfn userProc() -> S {{ var s: S; return s; }}"
        );
        let report = errors(&text);
        assert!(
            report.contains(says) && report.contains("t.wgsl:2:"),
            "{report}"
        );
    }
    let members: Vec<String> = (0..9).map(|i| format!("m{i}: f32")).collect();
    let text = format!(
        "struct S {{ {} }}\nfn userProc() -> S {{ var s: S; return s; }}",
        members.join(", ")
    );
    assert!(errors(&text).contains("returns 9 values: at most 8"));
}

#[test]
fn links_take_outputs_and_components_of_them() {
    let mut graph = Graph::new(textures());
    let cells = graph.add_node("cells", "cells", [0, 0]).expect("known");
    let sum = graph.add_node("sum", "sum", [0, 0]).expect("known");
    for (text, gives) in [
        ("color", OutputType::Vec3),
        ("cell.y", OutputType::F32),
        ("distance", OutputType::F32),
        ("all.zyx", OutputType::Vec3),
    ] {
        assert_eq!(graph.link_output(cells, take(text)), Ok(gives), "{text}");
    }
    graph
        .set_link(sum, "a", cells, take("color"))
        .expect("fits");
    graph
        .set_link(sum, "b", cells, take("cell.y"))
        .expect("fits");
    for (text, says) in [
        (
            "colour",
            "`cells` has no output `colour`; did you mean `color`?: it has distance, cell, color, all",
        ),
        ("cell.z", "`cells` gives vec2f: it has no `.cell.z`"),
        (
            "cell",
            "`cells.cell` gives vec2f, but parameter `b` of `sum` is of type f32: take a part of it, like `.x`",
        ),
    ] {
        let error = graph.set_link(sum, "b", cells, take(text)).expect_err(text);
        assert!(error.to_string().contains(says), "{error}");
    }
    let plain = graph
        .link_output(sum, take("color"))
        .expect_err("one value");
    assert!(matches!(plain, GraphError::UnknownOutput { .. }));
    assert!(plain.to_string().contains("it gives vec3f"), "{plain}");
}

#[test]
fn outputs_that_nothing_reads_have_no_slot() {
    let mut graph = Graph::new(textures());
    let cells = graph.add_node("cells", "cells", [0, 0]).expect("known");
    let sum = graph.add_node("sum", "sum", [0, 0]).expect("known");
    let placed = graph.add_node("placed", "placed", [0, 0]).expect("known");
    graph
        .set_link(sum, "a", cells, take("color"))
        .expect("fits");
    graph
        .set_link(placed, "p", cells, take("cell"))
        .expect("a place");
    let roots = [
        sum.into(),
        placed.into(),
        texgen::Link {
            source: cells,
            swizzle: take("all"),
        },
    ];
    let program = graph.compile_links(&roots).expect("compiles");
    let instructions = program.instructions(graph.library()).expect("decodes");
    let first = &instructions[0];
    let kept: Vec<usize> = first.further.iter().map(|(number, _)| *number).collect();
    assert_eq!(kept, [1, 2, 3]);
    let slot = |number: usize| first.further[number - 1].1;
    assert_eq!(program.results[2], slot(3));
    let of = |texture: &str| {
        let number = graph
            .library()
            .textures()
            .iter()
            .position(|t| t.name() == texture);
        let mut found = instructions.iter().filter(|i| Some(i.texture) == number);
        found.next().expect("there is one").links[0].1
    };
    assert_eq!(of("sum") & 0xffff, slot(2));
    // Two components of a place: no third, and no width of the pixel.
    assert_eq!(
        (of("placed") & 0xffff, of("placed") >> 22 & 0x3f),
        (slot(1), 4 | 4 << 3)
    );

    let alone = graph.compile(&[cells]).expect("compiles");
    assert_eq!(alone.slots_needed, 1);
    assert!(
        alone.instructions(graph.library()).expect("decodes")[0]
            .further
            .is_empty()
    );
}

#[test]
fn kernels_of_such_textures_are_valid() {
    let library = textures();
    assert!(valid_kernel(&library).contains("patina_keep("));
    let mut graph = Graph::new(Arc::clone(&library));
    let cells = graph.add_node("cells", "cells", [0, 0]).expect("known");
    let sum = graph.add_node("sum", "sum", [0, 0]).expect("known");
    graph
        .set_link(sum, "a", cells, take("color.bgr"))
        .expect("fits");
    let all = texgen::Link {
        source: cells,
        swizzle: take("all"),
    };
    let kernel = emit_inlined(&graph, &[vec![sum.into(), all]])
        .expect("compiles")
        .wgsl;
    validate(&format!("{kernel}\n{HOST_STUB}")).unwrap_or_else(|problem| panic!("{problem}"));
    let plain = crate::common::library(&[("t", "fn userProc() -> f32 { return 1.0; }")]);
    assert!(
        !valid_kernel(&plain).contains("patina_keep"),
        "only where it is needed"
    );
}

#[test]
fn a_reload_that_takes_an_output_away_says_so() {
    let mut graph = Graph::new(textures());
    let cells = graph.add_node("cells", "cells", [0, 0]).expect("known");
    let sum = graph.add_node("sum", "sum", [0, 0]).expect("known");
    graph
        .set_link(sum, "a", cells, take("color"))
        .expect("fits");
    let changed = library(&[
        ("cells", "fn userProc(x: f32) -> f32 { return x; }"),
        (
            "sum",
            "fn userProc(a: vec3f, b: f32) -> vec3f { return a + b; }",
        ),
    ]);
    let error = graph.with_library(changed).expect_err("it is gone");
    assert!(error.to_string().contains("no output `color`"), "{error}");
}
