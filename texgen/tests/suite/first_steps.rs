//! What people write who begin with WGSL: the message names the remedy, not what the compiler had expected.

use crate::common::{errors, parse};

/// Asserts that there is one error that holds all of `parts`.
fn check(text: &str, parts: &[&str]) {
    let report = errors(text);
    for part in parts {
        assert!(report.contains(part), "{part:?} is missing:\n{report}");
    }
    assert_eq!(report.matches("error: ").count(), 1, "{report}");
}

fn body(text: &str) -> String {
    format!("fn userProc(a: vec3f, k: f32, n: i32) -> f32 {{\n    {text}\n}}")
}

#[test]
fn vectors_and_numbers_as_arguments() {
    for (expression, parts) in [
        (
            "max(a, 0.0).x",
            [
                "`max` takes vectors of one size or numbers, not both",
                "write `vec3f(0.0)` for the number",
            ],
        ),
        (
            "clamp(a, 0.0, 1.0).x",
            ["`clamp` takes vectors", "write `vec3f(0.0)`"],
        ),
        ("pow(a, k).x", ["`pow` takes vectors", "write `vec3f(k)`"]),
        (
            "step(0.5, a).x",
            ["`step` takes vectors", "write `vec3f(0.5)`"],
        ),
        (
            "smoothstep(0.0, 1.0, a).x",
            ["`smoothstep` takes vectors", "write `vec3f(0.0)`"],
        ),
        (
            "max(a, n).x",
            ["`max` takes vectors", "write `vec3f(f32(n))`"],
        ),
    ] {
        let text = body(&format!("return {expression};"));
        check(&text, &parts);
        let report = errors(&text);
        for word in ["Abstract", "inconsistent", "constrains", "Because"] {
            assert!(!report.contains(word), "{report}");
        }
    }
}

/// What is proposed has to be right: `vec3u(-1)` isn't.
#[test]
fn numbers_below_zero_do_not_meet_those_without_a_sign() {
    let body = |expression: &str| {
        format!(
            "fn f(a: vec3u, n: i32) {{\n    let c = a + a;\n    let x = {expression};\n}}\nfn userProc(k: f32) -> f32 {{\n    f(vec3u(1), i32(k));\n    return k;\n}}"
        )
    };
    for (expression, remedy, mended) in [
        (
            "max(a, -1)",
            "write `vec3i(a)` for the vector and `vec3i(-1)` for the number",
            "max(vec3i(a), vec3i(-1))",
        ),
        (
            "max(a, -1.5)",
            "write `vec3i(a)` for the vector and `vec3i(i32(-1.5))` for the number",
            "max(vec3i(a), vec3i(i32(-1.5)))",
        ),
        (
            "max(c, -1)",
            "write `vec3i(...)`",
            "max(vec3i(c), vec3i(-1))",
        ),
        ("max(a, 1)", "write `vec3u(1)`", "max(a, vec3u(1))"),
        ("a * -1", "by `vec3i(...)`", "vec3i(a) * -1"),
        ("max(n, 1.5)", "by `f32(...)`", "max(f32(n), 1.5)"),
    ] {
        check(&body(expression), &[remedy]);
        parse("t", &body(mended)).unwrap_or_else(|problems| panic!("{problems}"));
    }
}

#[test]
fn calls_with_numbers_without_a_type() {
    for (expression, remedy) in [
        ("k * mix(1.0, 2.0, 0.5)", "`mix(1.0f, ...)`"),
        ("k * mix(1, 2.0, 0.5)", "`mix(1.0f, ...)`"),
        ("smoothstep(0.0, 1.0, 0.5)", "`smoothstep(0.0f, ...)`"),
        ("smoothstep(0, 1, 0.5)", "`smoothstep(0.0f, ...)`"),
        ("mix(0, 1, 0.5)", "`mix(0.0f, ...)`"),
        (
            "k * determinant(mat2x2(1.0, 0.0, 0.0, 1.0))",
            "as `vec3f(...)`",
        ),
    ] {
        let text = body(&format!("return {expression};"));
        check(&text, &["numbers without a type", remedy]);
    }
    for (expression, part) in [
        (
            "inverseSqrt(0.0)",
            "what `inverseSqrt` gives here is not a finite number",
        ),
        ("inverseSqrt(0.0f)", "not a finite number"),
    ] {
        check(
            &body(&format!("let x = {expression}; return k * x;")),
            &[part],
        );
    }
}

#[test]
fn functions_that_return_a_number_but_declare_none() {
    for text in [
        "fn userProc() { return 1.0; }",
        "fn userProc(a: f32) { if a > 0 { return 1; } }",
        "fn one() { let a = 2.0; return mix(0, 1, 0.5); }\nfn userProc(a: f32) -> f32 { one(); return a; }",
    ] {
        let parts = ["the function declares none", "write `-> TYPE`"];
        check(text, &parts);
    }
}

#[test]
fn what_other_languages_allow() {
    for (text, parts) in [
        (
            "let K = 3.0;\nfn userProc(a: f32) -> f32 { return a; }",
            ["write `const K = 3.0;`", "t.wgsl:1:1"],
        ),
        (
            "fn userProc(a: f32) -> f32 { let t = [1.0, 2.0]; return t[0]; }",
            ["write `array(1.0, 2.0)`", "t.wgsl:1:38"],
        ),
        (
            "fn userProc(a: f32) -> f32 { return atan(a, 1.0); }",
            ["write `atan2(a, 1.0)`", "t.wgsl:1:37"],
        ),
        (
            "fn userProc(a: f32) -> vec3f { return 1.0; }",
            ["write `vec3f(1.0)`", "t.wgsl:1:39"],
        ),
        (
            "fn userProc(a: f32) -> f32 { return a \u{2212} 1.0; }",
            ["minus sign (U+2212)", "write `-`"],
        ),
        (
            "fn userProc(a: f32) ->\u{a0}f32 { return a; }",
            ["no-break space (U+00A0)", "write a blank"],
        ),
        (
            "fn userProc(a: vec3f) -> f32 {\n    let x = max(a.x, 2.0));\n    return x;\n}",
            ["this `)` closes nothing", "t.wgsl:2:26"],
        ),
        (
            "/// @param i = foo\nfn userProc(i: sam2D) -> vec4f { return tex2D(i, vec2f(0.0)); }",
            ["images have no defaults", "set the image in the look file"],
        ),
    ] {
        check(text, &parts);
    }
    // In comments anything may stand.
    let text = "// a \u{2212} b\nfn userProc(a: f32) -> f32 { return a; } // \u{a0}";
    parse("t", text).unwrap_or_else(|problems| panic!("{problems}"));
}

#[test]
fn documentation_in_the_wrong_place_or_with_too_few_slashes() {
    for (text, parts) in [
        (
            "// @param a label = 0.5\nfn userProc(a: f32) -> f32 { return a; }",
            ["`@param` is not read", "t.wgsl:1:1", "write `/// @param"],
        ),
        (
            "/// @output mask of it\nstruct S { mask: f32, color: vec3f }\nfn userProc(a: f32) -> S { return S(a, vec3f(a)); }",
            [
                "describes an output",
                "t.wgsl:1:1",
                "right above `fn userProc`",
            ],
        ),
    ] {
        let texture = parse("t", text).unwrap_or_else(|problems| panic!("{problems}"));
        let report = texture.warnings().render();
        for part in parts {
            assert!(report.contains(part), "{part:?} is missing:\n{report}");
        }
    }
    check(
        "// @use waves\nfn userProc(a: f32) -> f32 { return wave(a); }",
        &["identifier: `wave`", "`@use` is not read", "/// @use"],
    );
    // What is read is not odd, nor is any other comment.
    let text = "// @param is a key\n/// @param a it\n// @param a was: 0.5\n/// @output mask of it\nfn userProc(a: f32) -> S { return S(a, vec3f(a)); }\nstruct S { mask: f32, color: vec3f }";
    let texture = parse("t", text).unwrap_or_else(|problems| panic!("{problems}"));
    assert!(texture.warnings().is_empty(), "{}", texture.warnings());
}
