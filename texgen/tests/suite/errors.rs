//! What users see when a texture is wrong: each case with the lines that its report must hold.

use crate::common::{errors, parse};

/// Asserts that the errors of `text` hold all of `parts`, in their order.
fn check(text: &str, parts: &[&str]) {
    let report = errors(text);
    let mut at = 0;
    for part in parts {
        match report[at..].find(part) {
            Some(found) => at += found + part.len(),
            None => panic!(
                "{part:?} is missing, or not in its place, in the report on {text:?}:\n{report}"
            ),
        }
    }
}

#[test]
fn a_report_is_complete() {
    assert_eq!(
        errors(
            "fn noise(x: f32) -> f32 { return x; }\nfn userProc() -> f32 {\n    return nois(1.0);\n}\n"
        ),
        "error: no definition in scope for identifier: `nois`
  --> t.wgsl:3:12
  |
3 |     return nois(1.0);
  |            ^^^^ unknown identifier
  |
  = note: did you mean `noise`?
"
    );
}

#[test]
fn syntax_errors() {
    check(
        "fn userProc() -> f32 {\n    return 1.0\n}\n",
        &[
            "error: expected `;`, found \"}\"\n",
            "t.wgsl:2:15",
            "^ `;` is missing here",
        ],
    );
    check(
        "fn userProc() -> f32 {",
        &[
            "this `{` is not closed",
            "t.wgsl:1:22",
            "still open at the end",
            "note: a `}` is missing",
        ],
    );
    check(
        "fn userProc() -> f32 { return 1.0; }\nconst A = 1.0",
        &["expected `;`, found the end of the file", "t.wgsl:2:11"],
    );
    check(
        "fn userProc() -> f32 { return 1.0; } /* open",
        &["this comment is not closed"],
    );
    check(
        "fn userProc() -> f32 { let \u{1F600} = 1.0; return 1.0; }",
        &["t.wgsl:1:28"],
    );
}

#[test]
fn type_errors() {
    check(
        "fn userProc() -> f32 { return vec3f(1.0); }",
        &[
            "the returned value is `vec3<f32>`, but the function declares `f32`",
            "t.wgsl:1:31",
        ],
    );
    check(
        "fn userProc() -> f32 { if readAttr(AO).x > 0.0 { return 1.0; } }",
        &["not every way through the function", "t.wgsl:1:4"],
    );
    check(
        "fn f(x: f32) -> f32 { return x; }\nfn userProc() -> f32 { return f(1.0, 2.0); }",
        &[
            "error: requires 1 arguments, but 2 are provided",
            "t.wgsl:2:31",
        ],
    );
    check(
        "fn userProc() -> f32 { if 1.0 { return 1.0; } return 2.0; }",
        &["the `if` condition is `f32`, not `bool`", "t.wgsl:1:27"],
    );
    check(
        "fn userProc() -> f32 { let x = 1.0; x = 2.0; return x; }",
        &["t.wgsl:1:37", "with `var` instead of `let`"],
    );
    check("fn userProc() -> f32 { return 1.0.x; }", &["t.wgsl:1:35"]);
    check(
        "fn userProc(x: f32) -> f32 { return pow(x, 2u); }",
        &[
            "wrong type passed as argument #2 to `pow`",
            "accepts the following types for argument #2: f32, vec2<f32>, vec3<f32>, vec4<f32>\n",
        ],
    );
}

#[test]
fn recursion_and_redefinition() {
    check(
        "fn f(x: f32) -> f32 { return f(x); }\nfn userProc() -> f32 { return f(1.0); }",
        &[
            "`f` is recursive",
            "note: WGSL has no recursion: use a loop",
        ],
    );
    check(
        "fn a() { b(); }\nfn b() { a(); }\nfn userProc() -> f32 { return 1.0; }",
        &["is cyclic", "use a loop"],
    );
    check(
        "const A = 1;\nconst A = 2;\nfn userProc() -> f32 { return 1.0; }",
        &["redefinition of `A`", "t.wgsl:2:7", "rename one of them"],
    );
}

#[test]
fn all_errors_of_a_file_are_shown() {
    check(
        "fn userProc() -> f32 { return missing1; }\nfn a() -> f32 { return missing2 + readAttr(Norml).x; }\nfn b() -> f32 { return 1u; }\nfn c() { discard; }\n",
        &[
            "`missing1`",
            "t.wgsl:1:31",
            "`missing2`",
            "t.wgsl:2:24",
            "called `Norml`",
            "did you mean `Normal`?",
            "the returned value",
            "t.wgsl:3:24",
            "`discard`",
        ],
    );
}

#[test]
fn a_lot_of_errors_is_cut_off() {
    let functions: String = (0..200)
        .map(|i| format!("fn wrong{i}() -> f32 {{ return missing; }}\n"))
        .collect();
    let problems = parse(
        "t",
        &format!("{functions}fn userProc() -> f32 {{ return wrong0(); }}"),
    )
    .expect_err("wrong");
    assert_eq!(problems.len(), 50);
}

#[test]
fn calls_that_double_are_refused() {
    let doubling: String = (1..40)
        .map(|i| {
            format!(
                "fn g{i}(x: f32) -> f32 {{ return g{}(x) + g{}(x); }}\n",
                i - 1,
                i - 1
            )
        })
        .collect();
    check(
        &format!(
            "fn g0(x: f32) -> f32 {{ return x; }}\n{doubling}fn userProc(x: f32) -> f32 {{ return g39(x); }}"
        ),
        &["too large once its calls are expanded", "t.wgsl:41:4"],
    );
}

#[test]
fn structures_that_double_are_refused() {
    let doubling: String = (1..40)
        .map(|i| format!("struct S{i} {{ a: S{}, b: S{} }}\n", i - 1, i - 1))
        .collect();
    check(
        &format!(
            "struct S0 {{ x: f32, S1: f32 }}\n{doubling}fn userProc(x: f32) -> f32 {{ let s = S39(); return x; }}"
        ),
        &[
            "too large once the structures in it are written out",
            "t.wgsl:40:8",
        ],
    );
}

#[test]
fn constants_that_double_are_refused() {
    // naga copies all that is in a constant where an element of it is taken.
    let doubling: String = (1..26)
        .map(|i| format!("const A{i} = array(A{}, A{});\n", i - 1, i - 1))
        .collect();
    let table = format!("array<f32, 20000>({})", "1,".repeat(20_000));
    let uses = |name: &str| format!("x += {name}[0];").repeat(1000);
    for text in [
        format!(
            "const A0 = array(1.0, 2.0);\n{doubling}fn userProc(x: f32) -> f32 {{ let a = A25[0]; return x; }}"
        ),
        format!(
            "const T = {table};\nfn userProc() -> f32 {{ var x = 0.0; {} return x; }}",
            uses("T")
        ),
        format!(
            "const T = {table};\nfn userProc() -> f32 {{ const L = T; var x = 0.0; {} return x; }}",
            uses("L")
        ),
    ] {
        check(
            &text,
            &[
                "the constants are too large once they are written out",
                "through one function, so that it is named once",
                "`array<T, N>` parameters",
            ],
        );
    }
}

#[test]
fn deep_nesting_is_refused_in_the_users_terms() {
    let [open, close] = ["(", ")"].map(|bracket| bracket.repeat(500));
    check(
        &format!("fn userProc(x: f32) -> f32 {{ return {open}x{close}; }}"),
        &["error: nested too deeply", "t.wgsl:1:"],
    );
    let [open, close] = ["{", "}"].map(|brace| brace.repeat(500));
    check(
        &format!("fn userProc(x: f32) -> f32 {{ {open}{close} return x; }}"),
        &["error: nested too deeply", "t.wgsl:1:"],
    );
}

#[test]
fn expressions_that_are_deep_through_brackets_are_refused() {
    let in_body = |body: &str| format!("fn userProc(x: f32) -> f32 {{ {body} }}");
    let sums = |levels: usize| {
        let around = |inner: String, _| format!("({inner}{})", "+x".repeat(490));
        (0..levels).fold("1.0".to_owned(), around)
    };
    let chain = format!("{}{{ }}", "if (x == 1.0) { return x; } else ".repeat(3000));
    let branches = (0..20).fold(String::new(), |inner, _| {
        format!("{}{{ {inner} }}", "if x > 0.0 { } else ".repeat(100))
    });
    for body in [
        format!("return {};", sums(2)),
        format!("return {};", sums(40)),
        format!("var a = array<f32, 2>(); return a{};", "[0]".repeat(16_000)),
        format!("if x > 0.0 {{ }} else if x > {} {{ }} return x;", sums(3)),
    ] {
        check(
            &in_body(&body),
            &["error: this expression is too long", "t.wgsl:1:", "`let`"],
        );
    }
    // However long each condition is, as long as it isn't itself too long.
    let long = format!(
        "{}{{ }}",
        "if x > 1.0 && x < 2.0 || x > 3.0 && x < 4.0 || x == 5.0 { } else ".repeat(100)
    );
    for body in [chain, branches, long] {
        check(
            &in_body(&format!("{body} return x;")),
            &["error: this statement is too long", "t.wgsl:1:", "`switch`"],
        );
    }
    // Of those beside each other the deepest counts.
    let beside = ["(x * x + 1.0 - x / (3.0 + x))"; 200].join(" + ");
    parse("t", &in_body(&format!("return {beside};")))
        .unwrap_or_else(|problems| panic!("{problems}"));
}

#[test]
fn the_entry() {
    check(
        "",
        &["the texture has no function `userProc`", "t.wgsl:1:1"],
    );
    check(
        "fn userproc() -> f32 { return 1.0; }",
        &["no function `userProc`", "t.wgsl:1:4", "was this meant?"],
    );
    check("const userProc = 1.0;", &["no function `userProc`"]);
    check(
        "fn userProc() -> i32 { return 1; }",
        &[
            "`userProc` returns f32, vec2f, vec3f, vec4f or a struct of those",
            "t.wgsl:1:18",
        ],
    );
    check(
        "fn userProc() { }",
        &["`userProc` returns f32", "returns nothing"],
    );
    check(
        "struct S { a: f32 }\nfn userProc(s: S, m: mat2x2f, t: array<S, 2>, p: ptr<function, f32>, b: array<f32, 70000>) -> f32 { return s.a; }",
        &[
            "`s` is a struct",
            "`m` is of a type",
            "`t` is an array of",
            "`p` is of a type",
            "`b` has 70000 elements",
        ],
    );
    check(
        "fn userProc() -> f32 { return userProc(); }",
        &["recursive"],
    );
}

#[test]
fn attributes() {
    check(
        "fn userProc() -> vec4f { return readAttr(TexCoord); }",
        &[
            "no attribute called `TexCoord`",
            "t.wgsl:1:42",
            "did you mean `TexCoord0`?",
        ],
    );
    check(
        "fn userProc() -> vec4f { return readAttr(FrameIndex); }",
        &["no attribute called", "write `readGlobal(FrameIndex)`"],
    );
    check(
        "fn userProc() -> vec4f { return readGlobal(Normal); }",
        &["no global called", "write `readAttr(Normal)`"],
    );
    check(
        "fn userProc() -> vec4f { return readAttr(1u); }",
        &["`readAttr` takes one name"],
    );
    check(
        "fn userProc() -> vec4f { return readAttr(AO, AO); }",
        &["`readAttr` takes one name"],
    );
    check(
        "fn userProc() -> vec4f { return readAttr(); }",
        &["`readAttr` takes one name"],
    );
    check(
        "fn userProc() -> vec4f { let Normal = 2u; return readAttr(Normal); }",
        &["`Normal` is declared in this file", "declared here"],
    );
    check(
        "fn userProc() -> vec4f { return WorldPos; }",
        &[
            "`WorldPos` is a name to be read, not a value",
            "write `readAttr(WorldPos)`",
        ],
    );
    check(
        "fn userProc() -> vec4f { let r = readAttr; return r(AO); }",
        &["`readAttr` can only be called"],
    );
}

#[test]
fn what_textures_cannot_have() {
    let entry = "\nfn userProc() -> f32 { return 1.0; }";
    for (text, parts) in [
        (
            "@compute @workgroup_size(1) fn main() {}",
            &[
                "entry points (`@compute`)",
                "the entry of a texture is `fn userProc",
            ][..],
        ),
        (
            "@fragment fn main() -> @location(0) vec4f { return vec4f(); }",
            &["entry points (`@fragment`)"],
        ),
        (
            "@group(0) @binding(0) var<storage> a: array<f32>;",
            &["buffers, images or samplers of its own", "array<T, N>"],
        ),
        (
            "@group(0) @binding(0) var t: texture_2d<f32>;",
            &[
                "buffers, images or samplers",
                "`texture_2d` is not available",
                "sam2D",
            ],
        ),
        (
            "var<private> a: f32;",
            &["module-scope variables", "ptr<function, T>"],
        ),
        ("var<workgroup> a: f32;", &["workgroup variables"]),
        (
            "override k = 1.0;",
            &["`override` constants", "parameter of `userProc`"],
        ),
        ("enable f16;", &["`enable` directives"]),
        (
            "diagnostic(off, derivative_uniformity);",
            &["`diagnostic` directives"],
        ),
        (
            "fn f() { discard; }",
            &["`discard` is not possible", "opacity"],
        ),
        (
            "fn f() -> f32 { return dpdx(1.0); }",
            &["no neighbouring pixels", "readAttr(Footprint)"],
        ),
        (
            "fn f() { workgroupBarrier(); }",
            &["`workgroupBarrier` is not possible"],
        ),
        (
            "fn f() -> u32 { return subgroupAdd(1u); }",
            &["`subgroupAdd` is not possible"],
        ),
        (
            "struct A { a: atomic<u32> }",
            &["a texture can't have atomics"],
        ),
        (
            "fn f() -> f16 { return 1.0h; }",
            &["`f16` is not available", "`f32`"],
        ),
        (
            "fn f(a: sam2D) -> vec4f { return textureSample(a, a, vec2f()); }",
            &["`textureSample` is not possible", "`tex2D(image, uv)`"],
        ),
        (
            "fn f() -> vec4f { return tex2D(sam2D(3u), vec2f()); }",
            &["a `sam2D` can't be made by a texture"],
        ),
        (
            "fn tex2D() {}",
            &["`tex2D` is taken", "rename it, for example `mytex2D`"],
        ),
        ("const Normal = 1.0;", &["`Normal` is taken"]),
        ("fn patina_link() {}", &["begin with `patina_`"]),
        (
            "fn f() { var big: array<f32, 100000>; }",
            &["400000 bytes of variables in `f`", "read in place"],
        ),
    ] {
        check(&format!("{text}{entry}"), parts);
    }
}

#[test]
fn the_users_own_names_are_not_mistaken_for_builtins() {
    parse("t", "fn dpdx(x: f32) -> f32 { return x; } fn textureSample() -> f32 { return 1.0; } fn userProc() -> f32 { let atomic = 1.0; return dpdx(1.0) + textureSample() + atomic; }")
        .unwrap_or_else(|problems| panic!("{problems}"));
}

#[test]
fn parameter_lines() {
    let texture = parse(
        "t",
        "//! About the file.
/// About the texture.
/// @param a how high it is [0 .. 10, unit m] [soft 0 .. 1] [log] = 2.5
/// @param b [color] = #ff0000
/// @param c = ((1, 2, 3), (4, 5, 6), (7, 8, 9))
/// @param d the ramp [constant] = [(0, #000), (1, (1, 2, 3))]
/// @param e = [1, 2, 3]
/// More about it.
@must_use fn userProc(a: f32, b: vec4f, c: mat3x3f, d: ramp1D, e: array<i32, 3>, some_thing: bool) -> f32 { return a; }",
    )
    .unwrap_or_else(|problems| panic!("{problems}"));
    assert!(texture.warnings().is_empty(), "{}", texture.warnings());
    assert_eq!(
        texture.docs(),
        "About the file.\nAbout the texture.\nMore about it."
    );
    let [a, b, c, d, e, f] = texture.parameters() else {
        panic!("six parameters")
    };
    assert_eq!(
        (a.label.as_str(), a.range, a.soft_range),
        ("how high it is", Some((0.0, 10.0)), Some((0.0, 1.0)))
    );
    assert_eq!(
        (a.unit.as_deref(), a.widget, a.default.clone()),
        (
            Some("m"),
            texgen::Widget::Log,
            Some(texgen::Value::F32(2.5))
        )
    );
    assert_eq!(b.default, Some(texgen::Value::Vec4([1.0, 0.0, 0.0, 1.0])));
    assert_eq!(
        c.default,
        Some(texgen::Value::Mat3([
            [1.0, 2.0, 3.0],
            [4.0, 5.0, 6.0],
            [7.0, 8.0, 9.0]
        ]))
    );
    let Some(texgen::Value::Ramp(ramp)) = &d.default else {
        panic!("a ramp")
    };
    assert_eq!(
        (ramp.stops[1], ramp.interpolation),
        ((1.0, [1.0, 2.0, 3.0, 1.0]), texgen::Interpolation::Constant)
    );
    assert_eq!(
        e.default,
        Some(texgen::Value::Array(
            [1, 2, 3].map(texgen::Value::I32).to_vec()
        ))
    );
    assert_eq!(
        (f.label.as_str(), f.default.clone()),
        ("some thing", Some(texgen::Value::Bool(false)))
    );
}

#[test]
fn odd_parameter_lines_warn_and_wrong_defaults_are_errors() {
    let warnings = |line: &str| {
        let text = format!("/// {line}\nfn userProc(scale: f32) -> f32 {{ return scale; }}");
        parse("t", &text)
            .unwrap_or_else(|problems| panic!("{problems}"))
            .warnings()
            .render()
    };
    for (line, parts) in [
        (
            "@param scla how big",
            &[
                "`userProc` has no parameter `scla`",
                "t.wgsl:1:12",
                "did you mean `scale`?",
            ][..],
        ),
        (
            "@param scale how big [colour]",
            &["unknown key `colour`", "did you mean `color`?"],
        ),
        ("@param scale how big [1 .. 0]", &["not a range"]),
        ("@param scale how big [0 .. 1", &["`[` without `]`"]),
        (
            "@param scale [0 .. 1] how big",
            &["text behind the brackets is not read"],
        ),
        ("@param", &["`@param` without a name"]),
    ] {
        let report = warnings(line);
        for part in parts {
            assert!(report.contains(part), "{part:?} is missing:\n{report}");
        }
    }
    check(
        "/// @param x it [0 .. 1] = red\nfn userProc(x: f32) -> f32 { return x; }",
        &[
            "the default of `x` holds `red`, which is not a number",
            "t.wgsl:1:28",
            "looks like `= 0.5`",
        ],
    );
    check(
        "/// @param x = (1, 2)\nfn userProc(x: vec3f) -> f32 { return x.x; }",
        &["is not of type vec3f"],
    );
    check(
        "/// @param x = 1\nfn userProc(x: sam2D) -> f32 { return texSize(x).x; }",
        &["images have none"],
    );
}

#[test]
fn types_are_named_as_wgsl_names_them() {
    for (text, said) in [
        (
            "fn f(p: vec2f) -> f32 { return p.x; }\nfn userProc(a: vec3f) -> f32 { return f(a); }",
            "argument 1 of `f` is to be `vec2<f32>`, not `vec3<f32>`",
        ),
        (
            "fn userProc(a: vec3f, b: f32) -> vec3f { return select(a, b, true); }",
            "reject value of type vec3<f32> does not match accept value of type f32",
        ),
    ] {
        let report = errors(text);
        assert!(report.contains(said), "{report}");
        assert!(!report.contains("Scalar"), "{report}");
    }
}

#[test]
fn errors_are_separated_by_one_empty_line() {
    let report =
        errors("fn f() -> f32 { return nothing; }\nfn userProc() -> f32 { return nor_this; }\n");
    assert_eq!(report.matches("error: ").count(), 2, "{report}");
    assert!(report.contains("\n\nerror: "), "{report}");
    assert!(!report.contains("\n\n\n"), "{report}");
}

#[test]
fn a_description_above_a_helper_is_not_lost_silently() {
    let text = "/// Stripes.
/// @param width of a stripe = 0.5
fn helper() -> f32 { return 1.0; }
fn userProc(width: f32) -> f32 { return width * helper(); }
";
    let warnings = |text: &str| match parse("t", text) {
        Ok(texture) => texture.warnings().to_string(),
        Err(problems) => panic!("{problems}"),
    };
    let report = warnings(text);
    for part in [
        "t.wgsl:2:1",
        "stands elsewhere",
        "right above `fn userProc`",
    ] {
        assert!(report.contains(part), "{report}");
    }
    // A helper may describe parameters of its own.
    let text = text.replace("@param width", "@param p");
    assert_eq!(warnings(&text), "");
}
