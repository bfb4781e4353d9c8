//! Messages for people who know another language, for files with many errors, and for terminals.

use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::common::{errors, parse, valid_kernel};
use texgen::{HOST_STUB, Library, Severity};

/// Asserts that the errors of `text` hold all of `parts`, in their order, and nothing of naga's own.
fn check(text: &str, parts: &[&str]) {
    let report = errors(text);
    let mut at = 0;
    for part in parts {
        match report[at..].find(part) {
            Some(found) => at += found + part.len(),
            None => panic!("{part:?} is missing, or not in its place:\n{report}"),
        }
    }
    for internal in ["naga", "Handle", "t__", "Scalar", "base: ["] {
        let messages = report.lines().filter(|line| !line.contains(" | "));
        for line in messages {
            assert!(!line.contains(internal), "{internal:?} leaks:\n{report}");
        }
    }
}

fn count(text: &str) -> usize {
    match parse("t", text) {
        Ok(_) => 0,
        Err(problems) => problems.count(Severity::Error),
    }
}

#[test]
fn all_errors_of_a_function_are_shown() {
    let text = "fn helper(a: f32) -> f32 {
    let b = a + 1.0
    return b;
}
fn userProc(n: i32, x: f32) -> vec3f {
    let a = missing;
    let b = n * x;
    let c = a + b;
    var d = helper(vec2f(x));
    if c { d = 1.0; }
    for (var i = 0; i < unknown; i++) { d += x; }
    while nothing > 0.0 { d = 1u; }
    return d;
}
";
    check(
        text,
        &[
            "t.wgsl:2:20",
            "`;` is missing here",
            "identifier: `missing`",
            "t.wgsl:6:13",
            "`*` can't take `i32` and `f32`",
            "t.wgsl:7:13",
            "convert: `f32(n)`",
            "argument 1 of `helper` is to be `f32`, not `vec2<f32>`",
            "t.wgsl:9:20",
            "identifier: `unknown`",
            "t.wgsl:11:25",
            "identifier: `nothing`",
            "t.wgsl:12:11",
            "`u32` doesn't become `f32` by itself",
            "t.wgsl:12:27",
            "convert: `f32(1u)`",
        ],
    );
    // What follows from them is not told: `c` needs `a`; `d` is declared by a wrong call.
    assert_eq!(count(text), 7, "{}", errors(text));
}

#[test]
fn a_comment_that_is_not_closed_is_told_where_it_begins() {
    let text = "struct P { x: f32, a:/* \nfn userProc(k: f32) -> größe { return p.x; }\n";
    check(text, &["this comment is not closed", "t.wgsl:1:22", "`*/`"]);
    check(
        "/* a /* b */ fn userProc() -> f32 { return 1.0; }",
        &["not closed"],
    );
    assert_eq!(
        count("/* a /* b */ */ fn userProc() -> f32 { return 1.0; } /**/"),
        0
    );
}

#[test]
fn errors_of_declarations_do_not_hide_others() {
    check(
        "const A = missing;\nconst B = A + 1.0;\nstruct S { a: nothing }\nfn f(s: S) -> f32 { return 1.0; }\nfn userProc() -> f32 { let b = B; return f(S()) + lost; }\nfn g() -> f32 { return gone; }",
        &["`missing`", "t.wgsl:1:11", "`nothing`", "`gone`"],
    );
}

#[test]
fn operands_of_different_types_are_converted() {
    for (text, parts) in [
        (
            "fn userProc(n: i32, x: f32) -> f32 { return (n + 1) * x; }",
            &["`*` can't take `i32` and `f32`", "convert: `f32("][..],
        ),
        (
            "fn userProc(n: u32, x: f32) -> f32 { let y = x; return y - n; }",
            &["`-` can't take `f32` and `u32`", "convert: `f32(n)`"],
        ),
        (
            "fn userProc(x: vec3f) -> vec3f { let n = vec3i(1); return n * x; }",
            &[
                "`*` can't take `vec3<i32>` and `vec3<f32>`",
                "convert: `vec3f(",
            ],
        ),
        (
            "fn userProc(x: vec3f) -> vec3f { return x + vec2f(1.0); }",
            &["`+` can't take `vec3<f32>` and `vec2<f32>`"],
        ),
        (
            "fn userProc(x: f32) -> f32 { var i = 0; i = x; return f32(i); }",
            &["`f32` doesn't become `i32` by itself", "convert: `i32(x)`"],
        ),
        (
            "fn userProc(x: f32) -> f32 { return array<f32, 2>(x, x)[7]; }",
            &["7"],
        ),
        (
            "fn userProc(x: f32) -> f32 { return -(x > 1.0); }",
            &["`-` can't take `bool`"],
        ),
    ] {
        check(text, parts);
    }
}

#[test]
fn habits_of_other_languages_get_the_wgsl_way() {
    let entry = "\nfn userProc() -> f32 { return 1.0; }\n";
    for (text, parts) in [
        (
            "fn userProc(a: f32) -> f32 { return lerp(a, 1.0, 0.5); }",
            &["`lerp`", "`mix(a, b, t)`"][..],
        ),
        (
            "fn userProc(a: f32) -> f32 { return mod(a, 1.0); }",
            &["`mod`", "x - y * floor(x / y)"],
        ),
        (
            "fn userProc(a: f32) -> f32 { return noise(vec3f(a)); }",
            &["`noise`", "the standard functions have"],
        ),
        (
            "fn userProc(a: sam2D) -> vec4f { return texture(a, vec2f()); }",
            &["`texture`", "`tex2D(image, uv)`"],
        ),
        (
            "fn userProc(a: f32) -> f32 { return float3(a).x; }",
            &["WGSL calls it `vec3f`"],
        ),
        (
            &format!("vec3 f(in vec2 p, float k) {{ return vec3(p, k); }}{entry}"),
            &[
                "`vec3 f(...)` is not how WGSL declares a function",
                "t.wgsl:1:1",
                "`fn f(p: vec2f, k: f32) -> vec3f { ... }`",
            ],
        ),
        (
            &format!("void mainImage(out vec4 c) {{ c = vec4(1.0); }}{entry}"),
            &[
                "`fn mainImage(c: ptr<function, vec4f>) { ... }`",
                "the entry of a texture is `fn userProc",
            ],
        ),
        (
            "fn userProc(a: f32) -> f32 {\n    return a > 0.0 ? 1.0 : 0.0;\n}",
            &[
                "no `condition ? a : b`",
                "t.wgsl:2:20",
                "select(b, a, condition)",
            ],
        ),
        (
            &format!("#include \"noise.glsl\"{entry}"),
            &["can't include other files", "t.wgsl:1:1", "/// @use NAME"],
        ),
        (
            "fn userProc(a: f32) -> f32 { return rand(a); }",
            &["`rand`", "`randomOf(vec4f)`, `random3to1(vec3u)`"],
        ),
        (
            "#define TAU 6.28\nfn userProc() -> f32 { return TAU; }",
            &["no `#define`", "`const TAU = ...;`"],
        ),
        (
            "fn userProc() -> f32 {\n    float x = 1.0;\n    return x;\n}",
            &[
                "`float x` is not how WGSL declares a variable",
                "t.wgsl:2:5",
                "`let x = ...;`",
            ],
        ),
        (
            "fn userProc(float x) -> f32 { return x; }",
            &["`float x` is not how WGSL declares a parameter", "`x: f32`"],
        ),
        (
            "fn userProc() -> f32 { var s = 0.0; for (int i = 0; i < 3; i++) { s += 1.0; } return s; }",
            &["`int i`", "`var i = ...`"],
        ),
        (
            "fn userProc() -> f32 { let x = 1.0h; return f32(x); }",
            &["`1.0h` is a number of 16 bits", "write `1.0f`"],
        ),
        (
            "fn userProc(a: f32) -> f32 { if (a > 0.0) return 1.0; return 0.0; }",
            &["expected", "braces are never left out"],
        ),
    ] {
        check(text, parts);
        assert_eq!(count(text), 1, "{}", errors(text));
        assert!(!errors(text).contains("enable f16"), "{}", errors(text));
    }
}

#[test]
fn no_line_is_longer_than_the_terminal() {
    let text = "fn userProc() -> f32 { discard; return readAttr(Nothing_that_is_known).x + lerp(1.0, 2.0, 3.0); }
@compute @workgroup_size(1) fn main() { let image = textureSample(texture_with_a_long_name, sampler_with_a_long_name, vec2f()); }
@group(0) @binding(0) var texture_with_a_long_name: texture_2d<f32>; var<private> a_variable: f32; override k = 1.0;
";
    let problems = parse("t", text).expect_err("wrong");
    for columns in [60, 80, 200] {
        let report = problems.render_within(columns);
        let longest = report.lines().map(|line| line.chars().count()).max();
        assert!(
            longest <= Some(columns),
            "{longest:?} > {columns}:\n{report}"
        );
    }
}

#[test]
fn a_texture_of_nothing_but_errors_is_refused_in_little_memory() {
    let text = format!(
        "fn userProc() -> f32 {{ {} return 1.0; }}",
        "discard; ".repeat(20_000)
    );
    let problems = parse("t", &text).expect_err("wrong");
    assert_eq!(problems.count(Severity::Error), 20_000);
    let report = problems.render();
    assert!(report.len() < 50_000, "{}", report.len());
    assert!(
        report.contains("19950 more errors are not shown"),
        "{report}"
    );
}

#[test]
fn functions_of_half_precision_and_endless_loops_are_accepted() {
    for text in [
        "fn userProc(a: vec2f) -> vec2f { return unpack2x16float(pack2x16float(a)) + quantizeToF16(a); }",
        "fn userProc(a: f32) -> f32 { var i = a; for (;;) { i += 1.0; if i > 9.0 { return i; } } }",
        "fn userProc(a: f32) -> f32 { for (var i = 0; ; i++) { switch i { case 9: { return a; } default: { break; } } } }",
        "fn userProc(a: f32) -> f32 { loop { for (var i = 0; i < 3; i++) { if a > 1.0 { break; } } if a < 2.0 { return a; } } }",
        "fn userProc(a: f32) -> f32 { { loop { return a; } } }",
        "fn userProc(a: f32) -> f32 { if a > 1.0 { loop { return 1.0; } } else { return 2.0; } }",
        "fn userProc(a: f32) -> f32 { if a > 1.0 { return 1.0; } else if a > 0.0 { { for (;;) { return a; } } } else { loop { } } }",
        "fn userProc(a: f32) -> f32 { switch i32(a) { case 1, 2: { loop { return a; } } default: { return 2.0; } } }",
    ] {
        let texture = parse("t", text).unwrap_or_else(|problems| panic!("{problems}"));
        valid_kernel(&Library::new(vec![texture]).expect("one"));
    }
    for text in [
        "fn userProc(a: f32) -> f32 { for (;;) { if a > 9.0 { break; } } }",
        "fn userProc(a: f32) -> f32 { loop { continuing { break if a > 9.0; } } }",
        "fn userProc(a: f32) -> f32 { for (; a < 9.0 ;) { return a; } }",
        "fn userProc(a: f32) -> f32 { if a > 1.0 { loop { return a; } } }",
        "fn userProc(a: f32) -> f32 { switch i32(a) { case 1: { loop { return a; } } default: { break; } } }",
    ] {
        check(text, &["not every way through the function"]);
    }
}

#[test]
fn pointers_to_components_are_copied() {
    let text = "
        struct P { x: f32, a: array<f32, 4>, m: mat2x2f }
        fn next(i: ptr<function, i32>) -> i32 { *i += 1; return *i; }
        fn add(a: ptr<function, f32>, by: f32) -> f32 { *a += by; return *a; }
        fn turn(v: ptr<function, vec2f>) { *v = (*v).yx; }
        fn deep(p: ptr<function, P>, i: i32) { _ = add(&(*p).x, 1.0); _ = add(&p.a[i], add(&p.a[0], 2.0)); turn(&p.m[1]); }
        fn userProc(k: f32, n: i32) -> f32 {
            var p = P(); var i = 0;
            deep(&p, n);
            while add(&p.x, 1.0) < 5.0 { p.a[1] += 1.0; }
            for (let q = &p.a[next(&i)]; add(q, k) < 9.0; i++) { if add(&p.a[2], 1.0) > 3.0 { break; } }
            return p.x;
        }";
    let texture = parse("t", text).unwrap_or_else(|problems| panic!("{problems}"));
    let kernel = valid_kernel(&Library::new(vec![texture]).expect("one"));
    let mut module =
        naga::front::wgsl::parse_str(&format!("{kernel}\n{HOST_STUB}")).expect("valid");
    assert!(texgen::copy_pointer_arguments(&mut module));
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
    let info = info.unwrap_or_else(|error| panic!("{error:?}"));
    // Without the copies naga panics here.
    let written = naga::back::spv::write_vec(&module, &info, &Default::default(), None);
    assert!(written.is_ok());
    assert!(
        !texgen::copy_pointer_arguments(&mut module),
        "nothing is left to be copied"
    );
}

#[test]
fn much_private_memory_is_warned_of_and_too_much_is_refused() {
    let warnings = |text: &str| match parse("t", text) {
        Ok(texture) => texture.warnings().render(),
        Err(problems) => panic!("{problems}"),
    };
    let variable = |count: u32| {
        format!(
            "fn userProc(x: f32) -> f32 {{ var a: array<f32, {count}>; a[i32(x)] = 1.0; return a[3]; }}"
        )
    };
    let table = |count: u32| {
        format!(
            "fn h(x: f32) -> f32 {{ const A = array<f32, {count}>(); return A[i32(x)] + A[i32(2.0 * x)]; }}\nfn userProc(x: f32) -> f32 {{ return h(x); }}"
        )
    };
    assert_eq!(warnings(&variable(200)), "");
    assert_eq!(warnings(&table(200)), "");
    let report = warnings(&variable(1000));
    for part in [
        "warning: 4004 bytes",
        "`userProc`",
        "1024",
        "t.wgsl:1:",
        "`array<T, N>` parameters",
    ] {
        assert!(report.contains(part), "{part:?} is missing:\n{report}");
    }
    let report = warnings(&table(1000));
    assert!(report.contains("in `userProc`, `h`"), "{report}");
    check(
        &variable(5000),
        &["20004 bytes of variables", "at most 16384 are possible"],
    );
    check(
        &table(100_000_000),
        &["400000008 bytes of variables", "t.wgsl:1:"],
    );
    // So does what no variable holds.
    for (text, parts) in [
        (
            "fn userProc(t: array<f32, 65536>) -> f32 { let c = t; return c[u32(readAttr(WorldPos).x)]; }",
            &["262144 bytes of variables in `userProc`", "t.wgsl:1:52"][..],
        ),
        (
            "fn userProc(t: array<f32, 65536>) -> f32 { return (t)[3]; }",
            &["262144 bytes of variables in `userProc`", "t.wgsl:1:52"],
        ),
        (
            "fn h(t: array<f32, 3000>) -> f32 { return t[2]; }\nfn userProc(t: array<f32, 3000>) -> f32 { return h(t); }",
            &["24000 bytes of variables in `userProc`, `h`", "t.wgsl:2:"],
        ),
        (
            "fn userProc() -> f32 { let z = array<f32, 20000000>(); return z[5]; }",
            &["80000000 bytes of variables in `userProc`", "t.wgsl:1:"],
        ),
        (
            "struct S { a: array<f32, 20000> }\nfn f() -> S { return S(); }\nfn userProc() -> f32 { let s = f(); return s.a[3]; }",
            &["160000 bytes of variables in `userProc`, `f`"],
        ),
    ] {
        check(text, parts);
    }
    assert_eq!(
        warnings("fn userProc(t: array<f32, 200>) -> f32 { let c = t; return c[3]; }"),
        ""
    );
    // Parameters are read where they lie, but not without end.
    assert_eq!(
        warnings("fn userProc(a: array<f32, 60000>, x: f32) -> f32 { return a[i32(x)]; }"),
        ""
    );
    let many: Vec<String> = (0..1000)
        .map(|i| format!("p{i}: array<mat4x4f, 65536>"))
        .collect();
    check(
        &format!(
            "fn userProc({}) -> f32 {{ return p0[0][0][0]; }}",
            many.join(", ")
        ),
        &[
            "the parameters up to `p1` hold more than 4194304 bytes",
            "images",
        ],
    );
}
