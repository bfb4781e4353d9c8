//! Mistakes that naga has no place for, or another one than their author looks at; and names that mean something else somewhere.

use std::fmt::Write;

use crate::common::{errors, parse, valid_kernel};
use texgen::{Library, Severity};

/// Asserts that the errors of `text` hold all of `parts`, in their order, and that there are so many.
fn check(text: &str, count: usize, parts: &[&str]) {
    let problems = parse("t", text).expect_err(text);
    let report = problems.render();
    let mut at = 0;
    for part in parts {
        match report[at..].find(part) {
            Some(found) => at += found + part.len(),
            None => panic!("{part:?} is missing, or not in its place:\n{report}"),
        }
    }
    assert_eq!(problems.count(Severity::Error), count, "{report}");
}

fn warnings(text: &str) -> String {
    match parse("t", text) {
        Ok(texture) => texture.warnings().render(),
        Err(problems) => panic!("{problems}"),
    }
}

#[test]
fn errors_without_a_place_are_found_and_hide_no_others() {
    check(
        "fn a(x: f32) -> f32 {
    return x[0];
}

fn userProc() -> f32 {
    let bad: f32 = 1u;
    return a(1.0) + nothing;
}
",
        3,
        &[
            "`x` is `f32`, which has no components",
            "t.wgsl:2:12",
            "to be `f32`, but got `u32`",
            "t.wgsl:6:9",
            "`nothing`",
            "t.wgsl:7:21",
        ],
    );
    for (body, parts) in [
        (
            "let k = 1.0;\nreturn v[3] + k;",
            [
                "index 3 is beyond the end of `v`, which is `vec3<f32>`",
                "t.wgsl:3:8",
            ],
        ),
        (
            "for (var i = 0; i < 3; i++) {\nlet a = v.x;\nlet b = readAttr(WorldPos)[4] + a;\n}\nreturn 1.0;",
            [
                "index 4 is beyond the end of `readAttr(WorldPos)`, which is `vec4<f32>`",
                "t.wgsl:4:9",
            ],
        ),
        (
            "let k = v[1];\nreturn v[0] + k[0];",
            ["`k` is `f32`, which has no components", "t.wgsl:3:15"],
        ),
        (
            "if v.x && true { return 1.0; }\nreturn 0.0;",
            ["`&&` can't take `f32`", "t.wgsl:2:8"],
        ),
        (
            "let t = array<f32, 2>(1.0, 2.0);\nif v.x > 0.0 { return 1.0; } else if t == t { return 2.0; }\nreturn 0.0;",
            ["`==` can't compare an array", "t.wgsl:3:40"],
        ),
    ] {
        let text = format!(
            "fn userProc(v: vec3f) -> f32 {{\n{body}\n}}\nfn behind() -> f32 {{ return 1.0; }}"
        );
        check(&text, 1, &parts);
    }
}

#[test]
fn what_is_nested_too_deeply_is_told_where_it_is() {
    let [open, close] = ["(", ")"].map(|bracket| bracket.repeat(300));
    let entry = "fn userProc(x: f32) -> f32 { return x; }";
    check(
        &format!("{entry}\nfn f(x: f32) -> f32 {{\n    return {open}x{close};\n}}"),
        1,
        &["nested too deeply", "t.wgsl:3:5"],
    );
    check(
        &format!("{entry}\nconst A = {open}1.0{close};"),
        1,
        &["nested too deeply", "t.wgsl:2:7"],
    );
}

#[test]
fn types_that_textures_do_not_have_are_told_where_they_are() {
    check(
        "fn userProc() -> f32 {\n    var i: i64;\n    return 1.0lf;\n}",
        2,
        &[
            "`i64` is not available in textures",
            "t.wgsl:2:12",
            "use `i32`",
            "`f64` is not available in textures",
            "t.wgsl:3:12",
            "use `f32`",
        ],
    );
}

#[test]
fn wrong_uses_are_told_where_they_are_not_where_the_thing_is_declared() {
    for (text, parts) in [
        (
            "fn other() -> f32 { return 1.0; }\nfn userProc(scale: f32) -> f32 {\n    if scale { return 1.0; }\n    return other();\n}",
            &[
                "the `if` condition is `f32`, not `bool`",
                "t.wgsl:3:8",
                "declared here",
            ][..],
        ),
        (
            "fn userProc(x: f32) -> f32 {\n    var i = 0;\n    while x { i++; }\n    return f32(i);\n}",
            &["condition is `f32`", "t.wgsl:3:11"],
        ),
        (
            "fn userProc(im: sam2D, v: vec3f) -> vec4f {\n    return tex2D(im, v);\n}",
            &[
                "argument 2 of `tex2D` is to be `vec2<f32>`, not `vec3<f32>`",
                "t.wgsl:2:22",
            ],
        ),
        (
            "fn userProc(x: f32) -> f32 {\n    return perlin3D(x);\n}",
            &[
                "argument 1 of `perlin3D` is to be `vec3<f32>`, not `f32`",
                "t.wgsl:2:21",
            ],
        ),
        (
            "fn userProc(v: vec3f) -> f32 {\n    return v;\n}",
            &["the returned value is `vec3<f32>`", "t.wgsl:2:12"],
        ),
        (
            "fn userProc(v: vec3f) -> f32 {\n    let w = v * 2.0;\n    return w;\n}",
            &["the returned value is `vec3<f32>`", "t.wgsl:3:12"],
        ),
        (
            "fn userProc(v: vec3f) -> f32 {\n    var w = v;\n    return w;\n}",
            &["the returned value is `vec3<f32>`", "t.wgsl:3:12"],
        ),
        (
            "struct Q { a: f32, b: i32 }\nfn userProc() -> f32 {\n    let q = Q(1.0, 2.5);\n    return q.a;\n}",
            &["t.wgsl:3:20", "its members are declared here"],
        ),
        (
            "struct Q { a: f32, b: i32 }\nfn userProc(x: f32) -> f32 {\n    let q = Q(1.0, x);\n    return q.a;\n}",
            &[
                "member `b` is to be `i32`, not `f32`",
                "t.wgsl:3:20",
                "convert: `i32(x)`",
            ],
        ),
        (
            "fn userProc(a: i32, x: f32) -> f32 {\n    let b = a + 1;\n    return x * b;\n}",
            &[
                "`*` can't take `f32` and `i32`",
                "t.wgsl:3:12",
                "convert: `f32(b)`",
            ],
        ),
    ] {
        check(text, 1, parts);
    }
}

#[test]
fn a_bracket_that_is_not_closed_is_told_where_it_is() {
    check(
        "fn a(x: f32) -> f32 {\n    if x > 0.0 {\n        return x;\n}\nfn userProc() -> f32 { return a(1.0); }",
        1,
        &[
            "this `{` is not closed",
            "t.wgsl:1:21",
            "still open where `fn userProc` begins",
            "a `}` is missing",
        ],
    );
    check(
        "fn userProc() -> f32 { return (1.0 + 2.0",
        1,
        &["this `(` is not closed", "t.wgsl:1:31", "a `)` is missing"],
    );
    // A function in another one is wrong, but closed.
    let report = errors("fn userProc() -> f32 { fn a() { } return 1.0; }");
    assert!(!report.contains("closed"), "{report}");
}

#[test]
fn a_file_may_declare_names_of_wgsl_that_the_prelude_uses() {
    for text in [
        "fn mix(a: vec3f, b: vec3f) -> vec3f { return a * b; }
fn userProc(p: vec3f) -> vec3f { return mix(p, vec3f(perlin3D(p))); }",
        "alias u32 = i32;
fn userProc(n: u32) -> f32 { let k: u32 = n + 1i; return readAttr(AO).x * f32(k) + fbm3D(vec3f(), 2.0, 2.0, 0.5, 0.0); }",
        "struct vec4f { a: f32 }
fn floor(v: vec4f) -> f32 { return v.a; }
fn userProc(x: f32) -> f32 { return floor(vec4f(x)) + simplex3D(vec3f(x)) + readAttr(AO).x; }",
        "const max = 2.0;
fn userProc(p: vec3f) -> f32 { return max * voronoi3D(p, max).nearest; }",
    ] {
        let texture = parse("t", text).unwrap_or_else(|problems| panic!("{problems}"));
        valid_kernel(&Library::new(vec![texture]).expect("one"));
    }
    // Mistakes in it are told in its own names.
    check(
        "fn mix(a: f32) -> f32 { return a; }\nfn userProc(v: vec3f) -> f32 { return mix(v) + perlin3D(v); }",
        1,
        &[
            "argument 1 of `mix` is to be `f32`, not `vec3<f32>`",
            "t.wgsl:2:43",
        ],
    );
    check(
        "fn abs(a: f32) -> f32 { return abs(a); }\nfn userProc(x: f32) -> f32 { return abs(x); }",
        1,
        &["`abs` is recursive", "t.wgsl:1:4"],
    );
    // What it needs of memory counts.
    let large = "fn abs(x: f32) -> f32 { var a: array<f32, 1000>; a[i32(x)] = 1.0; return a[3]; }\nfn userProc(x: f32) -> f32 { return abs(x); }";
    assert!(warnings(large).contains("`abs`"), "{}", warnings(large));
}

#[test]
fn what_follows_from_an_error_is_left_out_however_much_it_is() {
    let uses = "s+=x;".repeat(30_000);
    let mut chain = String::new();
    for i in 0..8_000 {
        let _ = write!(chain, "let x{}=x{i};", i + 1);
    }
    for body in [
        format!("let x = bad(); var s = 0.0; {uses} return s;"),
        format!("let x0 = bad(); {chain} return x8000;"),
    ] {
        check(
            &format!("fn userProc() -> f32 {{ {body} }}"),
            1,
            &["identifier: `bad`"],
        );
    }
}

#[test]
fn a_loop_that_is_left_out_takes_what_was_left_out_of_it() {
    check(
        "fn userProc(x: f32) -> f32 {
    var s = 0.0;
    for (var i = 0; i < 3; i += n) {
        s += missing1;
        s = 1u;
    }
    return s + missing2;
}",
        4,
        &[
            "`n`",
            "t.wgsl:3:33",
            "`missing1`",
            "t.wgsl:4:14",
            "`u32` doesn't become `f32`",
            "`missing2`",
            "t.wgsl:7:16",
        ],
    );
}

#[test]
fn parameters_that_a_look_cannot_set_are_warned_of() {
    for name in ["texture", "occlusion", "occlusion1"] {
        let text = format!("fn userProc({name}: f32) -> f32 {{ return {name}; }}");
        let report = warnings(&text);
        let said = format!("a look can't set a parameter called `{name}`");
        assert!(
            report.contains(&said) && report.contains("t.wgsl:1:13"),
            "{report}"
        );
    }
    assert_eq!(
        warnings(
            "fn userProc(occlusion2: f32) -> f32 { let texture = occlusion2; return texture; }"
        ),
        ""
    );
}

#[test]
fn an_attribute_of_the_mesh_is_no_value() {
    let report =
        errors("fn userProc() -> f32 { let k = _WETNESS; return readAttr(_WETNESS).x + f32(k); }");
    for part in [
        "`_WETNESS` is a name to be read, not a value",
        "t.wgsl:1:32",
        "write `readAttr(_WETNESS)`",
    ] {
        assert!(report.contains(part), "{report}");
    }
    assert!(!report.contains("report this"), "{report}");
    let declared = "const _WETNESS = 1000u;\nfn userProc() -> f32 { let k = _WETNESS; return readAttr(_WETNESS).x + f32(k); }";
    assert_eq!(warnings(declared), "");
    check(
        "fn userProc() -> f32 { let _near = 1.0; return _nearr; }",
        1,
        &["identifier: `_nearr`", "did you mean `_near`?"],
    );
}

#[test]
fn odd_lines_of_documentation_are_warned_of() {
    for (line, parts) in [
        (
            "@param scale how big [0 .. 1\u{a0}",
            &["`[` without `]`"][..],
        ),
        (
            "@parameter height of it",
            &[
                "there are no `@parameter` lines",
                "t.wgsl:1:5",
                "did you mean `@param`?",
            ],
        ),
        (
            "@param scale how big [attr AO] = 0.3",
            &[
                "the default of `scale` is never used",
                "t.wgsl:1:36",
                "it takes `AO`",
            ],
        ),
    ] {
        let text = format!("/// {line}\nfn userProc(scale: f32) -> f32 {{ return scale; }}");
        let report = warnings(&text);
        for part in parts {
            assert!(report.contains(part), "{part:?} is missing:\n{report}");
        }
    }
}

#[test]
fn a_statement_that_cannot_be_mended_is_told_once_and_hides_no_others() {
    check(
        "fn userProc(x: f32) -> f32 {
    loop {
        break if x > 1.0;
    }
    let a = nothing;
    if x { return 2.0; }
    return 1.0;
}",
        3,
        &[
            "a break if is only allowed in a continuing block",
            "t.wgsl:3:9",
            "`nothing`",
            "t.wgsl:5:13",
            "condition is `f32`",
            "t.wgsl:6:8",
        ],
    );
    check(
        "fn userProc(i: i32, x: f32) -> f32 {
    switch i { case 1: { return 1.0; } case 2, 1: { return 2.0; } default: {} }
    switch i {
        case 1, 1: { }
        default: { }
    }
    if x { return 3.0; }
    return 1.0;
}",
        3,
        &[
            "more than one `case` for `1`",
            "t.wgsl:2:53",
            "more than one `case` for `1`",
            "t.wgsl:3:5",
            "condition is `f32`",
            "t.wgsl:7:8",
        ],
    );
}

#[test]
fn integers_beside_numbers_with_fractions_are_converted() {
    for (statements, parts) in [
        (
            "let a = i * 2.0; return a;",
            [
                "`*` can't take `i32` and a number with a fraction",
                "t.wgsl:2:9",
                "convert: `f32(i)`",
            ],
        ),
        (
            "let a = 2.0 * i; return 1.0;",
            [
                "`*` can't take a number with a fraction and `i32`",
                "t.wgsl:2:9",
                "convert: `f32(i)`",
            ],
        ),
        (
            "return 1.0 - i;",
            [
                "`-` can't take a number with a fraction and `i32`",
                "t.wgsl:2:8",
                "convert: `f32(i)`",
            ],
        ),
        (
            "if i > 0.5 { return 1.0; } return 2.0;",
            [
                "`>` can't take `i32` and a number with a fraction",
                "t.wgsl:2:4",
                "convert: `f32(i)`",
            ],
        ),
        (
            "let a = sin(i / 2 * 0.5); return a;",
            [
                "`*` can't take `i32` and a number with a fraction",
                "t.wgsl:2:13",
                "convert: `f32(i / 2)`",
            ],
        ),
        (
            "let a = 1.0 - 2.0 * u32(i); return a;",
            [
                "`*` can't take a number with a fraction and `u32`",
                "t.wgsl:2:15",
                "convert: `f32(u32(i))`",
            ],
        ),
        (
            "let a = vec3i(i) * -2.5; return 1.0;",
            [
                "`*` can't take `vec3<i32>` and a number with a fraction",
                "t.wgsl:2:9",
                "convert: `vec3f(vec3i(i))`",
            ],
        ),
    ] {
        let text = format!("fn userProc(i: i32) -> f32 {{\n{statements}\n}}");
        check(&text, 1, &parts);
    }
    let report = errors("fn userProc(b: bool) -> f32 { let a = 1 + b; return 1.0; }");
    assert!(report.contains("a number meets something here"), "{report}");
    assert!(
        !report.contains("Abstract") && !report.contains("scalar"),
        "{report}"
    );
    for statement in ["var x = i; x *= 2.0;", "let v: i32 = 2.5;"] {
        let text = format!("fn userProc(i: i32) -> f32 {{ {statement} return 1.0; }}");
        let report = errors(&text);
        assert!(!report.contains("Abstract"), "{report}");
        assert!(report.contains("a number with a fraction"), "{report}");
        assert!(report.contains("by `f32(...)`"), "{report}");
    }
    let text = "fn twice(x: f32) -> f32 { return 2.0 * x; }\nfn userProc() -> f32 { let a = twice; return 1.0; }";
    let report = errors(text);
    assert!(report.contains("write `twice(...)`"), "{report}");
}

#[test]
fn parts_of_a_value_are_told_with_their_types() {
    for (expression, parts) in [
        (
            "vec2f(1.0, i)",
            [
                "argument 2 of `vec2<f32>` is to be `f32`, not `i32`",
                "t.wgsl:2:20",
                "convert: `f32(i)`",
            ],
        ),
        (
            "vec4f(vec3i(i), 1.0)",
            [
                "argument 1 of `vec4<f32>` is to be `vec3<f32>`, not `vec3<i32>`",
                "t.wgsl:2:15",
                "convert: `vec3f(vec3i(i))`",
            ],
        ),
        (
            "array<f32, 2>(1.0, i)",
            [
                "element 2 of `array<f32, 2>` is to be `f32`, not `i32`",
                "t.wgsl:2:28",
                "convert: `f32(i)`",
            ],
        ),
        (
            "array<vec2f, 2>(vec2f(1.0), v)",
            [
                "element 2 of `array<vec2<f32>, 2>` is to be `vec2<f32>`, not `vec3<f32>`",
                "t.wgsl:2:37",
                "^",
            ],
        ),
        (
            "mat2x2f(vec2f(1.0), v)",
            [
                "column 2 of `mat2x2<f32>` is to be `vec2<f32>`, not `vec3<f32>`",
                "t.wgsl:2:29",
                "^",
            ],
        ),
    ] {
        let text = format!(
            "fn userProc(i: i32, v: vec3f) -> f32 {{\nlet a = {expression};\nreturn 1.0;\n}}"
        );
        check(&text, 1, &parts);
    }
}

#[test]
fn values_that_are_worked_out_while_reading_get_remedies() {
    for (text, note) in [
        ("const X = 1.0f + 1i;", "both sides must be of one type"),
        (
            "const Y = vec3f(1.0) * vec2f(2.0);",
            "both sides must be of one type",
        ),
        (
            "const A = array<f32, 3>(1.0, 2.0, 3.0);\nconst B = A[5];",
            "counted from 0 on",
        ),
        (
            "const Z = extractBits(12u, 1u, 2u);",
            "call it within a function",
        ),
        (
            "fn add(p: ptr<function, f32>) { *p += 1.0; }\nfn f() { var v = vec3f(1.0); add(&v.x); }",
            "`var part = v.x; f(&part); v.x = part;`",
        ),
    ] {
        let report = errors(&format!("{text}\nfn userProc() -> f32 {{ return 1.0; }}"));
        assert!(report.contains(note), "{report}");
        assert!(!report.contains("see msg"), "{report}");
    }
}

#[test]
fn names_that_are_no_values_or_stand_twice_get_the_right_remedy() {
    let once = |note: &str| format!("= note: names of {note}: rename one of them");
    for (text, place, note) in [
        (
            "fn userProc() -> vec3f { return vec3f; }",
            "t.wgsl:1:33",
            "`vec3f` is a type: write `vec3f(...)`".to_owned(),
        ),
        (
            "fn userProc() -> f32 { return sin; }",
            "t.wgsl:1:31",
            "`sin` is a function: write `sin(...)`".to_owned(),
        ),
        (
            "fn userProc() -> f32 { { let z = 1.0; } return z; }",
            "t.wgsl:1:48",
            "declare `z` further up or out".to_owned(),
        ),
        (
            "fn userProc(x: f32) -> f32 { let a = 1.0; let a = 2.0; return x; }",
            "t.wgsl:1:47",
            once("variables are unique within a block, those of parameters within a function"),
        ),
        (
            "fn userProc(x: f32, x: f32) -> f32 { return 1.0; }",
            "t.wgsl:1:21",
            once("variables are unique within a block, those of parameters within a function"),
        ),
        (
            "struct S { a: f32, a: f32 }\nfn userProc() -> f32 { return 1.0; }",
            "t.wgsl:1:20",
            once("members are unique within their struct"),
        ),
        (
            "fn f() {} fn f() {}\nfn userProc() -> f32 { return 1.0; }",
            "t.wgsl:1:14",
            once("functions, structs, constants and aliases are unique within a file"),
        ),
        (
            "fn userProc(x: f32) -> f32 { x = 2.0; return x; }",
            "t.wgsl:1:30",
            "a parameter can't be changed; copy it: `var my_x = x;`".to_owned(),
        ),
    ] {
        check(text, 1, &[place, &note]);
        let report = errors(text);
        assert!(!report.contains("did you mean"), "{report}");
        assert!(!report.contains("instead of `let`"), "{report}");
    }
}

#[test]
fn only_variables_that_are_known_at_a_place_are_proposed_there() {
    let report = |body: &str| errors(&format!("fn userProc(x: f32) -> f32 {{ {body} }}"));
    for body in [
        "let brightness = brightnes + x; return brightness;",
        "if x > 0.0 { let brightness = x; } return brightnes;",
        "for (var brightness = 0; brightness < 3; brightness++) { } return f32(brightnes);",
    ] {
        let report = report(body);
        assert!(report.contains("`brightnes`"), "{report}");
        assert!(!report.contains("did you mean"), "{report}");
    }
    for body in [
        "let brightness = x; return brightnes;",
        "for (var brightness = x; brightness < brightnes; ) { } return x;",
        "var brightness = x; { let other = x; brightness += brightnes; } return x;",
    ] {
        let report = report(body);
        assert!(report.contains("did you mean `brightness`?"), "{report}");
    }
    for body in [
        "let brightness = brightness + x; return brightness;",
        "if x > 0.0 { let brightness = x; } return brightness;",
    ] {
        let report = report(body);
        assert!(
            report.contains("a variable is known from behind"),
            "{report}"
        );
    }
}

#[test]
fn what_is_nested_deeper_than_software_drivers_follow_is_warned_of() {
    let rows = |count: usize, row: &str| -> String {
        (0..count)
            .map(|i| row.replace("$", &i.to_string()))
            .collect()
    };
    let texture =
        |body: String| format!("fn userProc(x: i32) -> f32 {{ var v = 0.0;\n{body}\nreturn v; }}");
    let cases = |row: &str| format!("switch x {{ {} default: {{ }} }}", rows(90, row));
    let leave = "if x == $ { return $.5; }\n";
    for deep in [
        texture(rows(90, leave)),
        texture(cases("case $: { return $.5; }")),
        texture(format!(
            "{} {{ }}",
            rows(90, "if x == $ { v = $.5; } else ")
        )),
        texture(format!(
            "loop {{ {} v += 1.0; }}",
            rows(90, "if v > $.5 { break; }\n")
        )),
        texture(format!(
            "for (var i = 0; i < x; i++) {{ {} }}",
            rows(90, "if i == $ { continue; }\n")
        )),
        format!(
            "fn h(x: i32) -> f32 {{ {} return 0.0; }}\n{}",
            rows(40, leave),
            texture(format!("{} v = h(x);", rows(40, leave)))
        ),
        // The kernel's guard leaves each of them early.
        texture(rows(90, "while v > $.5 { v -= 1.0; }\n")),
        texture(rows(90, "for (var i = 0; i < x; i++) { v += 1.0; }\n")),
        format!(
            "fn h(x: i32) -> i32 {{ var n = x; {} return n; }}\n{}",
            rows(40, "loop { n--; if n < $ { break; } }\n"),
            texture(format!("{} v = f32(h(x));", rows(40, leave)))
        ),
    ] {
        let report = warnings(&deep);
        assert!(
            report.starts_with("warning: `userProc` is nested "),
            "{report}"
        );
        assert!(report.contains("llvmpipe"), "{report}");
        assert_eq!(report.matches("warning:").count(), 1, "{report}");
    }
    for flat in [
        texture(rows(40, leave)),
        texture(rows(200, "if x == $ { v = $.5; }\n")),
        texture(cases("case $: { v = $.5; }")),
        texture(cases("case $: { v = $.5; break; }")),
        texture(rows(
            90,
            "for (var i = 0; i < 3; i++) { if i == x { break; } }\n",
        )),
        texture(rows(40, "while v > $.5 { v -= 1.0; }\n")),
        // Those in there only break.
        texture(format!(
            "loop {{ v += 1.0; continuing {{ {} break if v > 9.0; }} }}",
            rows(90, "while v < -$.5 { v += 1.0; }\n")
        )),
    ] {
        assert_eq!(warnings(&flat), "");
    }
    // It is told where it is, once.
    let helper = format!(
        "fn h(x: i32) -> f32 {{ {} return 0.0; }}\nfn userProc(x: i32) -> f32 {{ return h(x); }}",
        rows(90, leave)
    );
    let report = warnings(&helper);
    assert!(report.contains("`h` is nested 90 deep"), "{report}");
    assert!(report.contains("t.wgsl:1:4"), "{report}");
    assert_eq!(report.matches("warning:").count(), 1, "{report}");
}
