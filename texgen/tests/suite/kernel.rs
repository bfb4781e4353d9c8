//! The generated kernel: what is rewritten, what is not, and that the result is always valid.

use crate::common::{library, parse, valid_kernel};
use texgen::{Attribute, BuiltinAttribute, Library};

/// The section of a kernel that belongs to the one texture called `t`.
fn section(text: &str) -> String {
    let kernel = valid_kernel(&library(&[("t", text)]));
    let start = kernel.find("// ==== t ====").expect("there is a section");
    let body = kernel[start..].split_once("\n\n").expect("a title line").1;
    body.split("\n\nfn patina_call_t")
        .next()
        .expect("the source")
        .to_owned()
        + "\n"
}

#[test]
fn names_get_prefixes_and_everything_else_stays() {
    assert_eq!(
        section(
            "// fn noise in a comment\nfn  noise( p : vec2f )->f32 { /* noise */ return p.x; }\n\tfn userProc() -> f32 {return noise(vec2f());}\n"
        ),
        "// fn noise in a comment\nfn  t__noise( p : vec2f )->f32 { /* noise */ return p.x; }\n\tfn t__userProc() -> f32 {return t__noise(vec2f());}\n"
    );
}

#[test]
fn attributes_become_functions() {
    assert_eq!(
        section(
            "fn userProc() -> vec4f { return readAttr( /* uv */ TexCoord0 ) + readAttr(AO,) * readAttr(AO1)\n + readAttr(\n_WETNESS) + readGlobal(Time); }\n"
        ),
        "fn t__userProc() -> vec4f { return patina_attr_TexCoord0( /* uv */  ) + patina_attr_AO(patina_occlusion.x) * patina_attr_AO(patina_occlusion.y)\n + patina_attr_custom(\npatina_custom_WETNESS) + patina_global_Time(); }\n"
    );
}

#[test]
fn locals_may_have_any_name() {
    let text = "fn f() -> f32 { return 1.0; }
fn userProc(tex2D: f32, WorldPos: vec4f) -> vec4f {
    let readAttr = f() * tex2D;
    let f = readAttr;
    var Normal = WorldPos * f;
    { let readGlobal = Normal; Normal = readGlobal; }
    for (var AO = 0; AO < 3; AO++) { Normal.x += f32(AO); }
    return Normal;
}
";
    let expected = text
        .replace("fn f()", "fn t__f()")
        .replace("= f()", "= t__f()")
        .replace("fn userProc", "fn t__userProc");
    assert_eq!(section(text), expected);
}

#[test]
fn a_local_ends_with_its_block() {
    let text = "fn userProc() -> vec4f {
    { let readAttr = 1.0; }
    return readAttr(Normal);
}
";
    assert!(section(text).contains("return patina_attr_Normal();"));
}

#[test]
fn structs_constants_aliases_and_pointers_work() {
    let text = "alias Real = f32;
alias Reals = array<Real, SIZE>;
const SIZE = 2 + 1;
const_assert SIZE == 3;
struct Wave { amplitude: Real, @align(16) phase: vec3<Real>, SIZE: Reals, inner: Inner }
struct Inner { Wave: u32 }
fn add(w: ptr<function, Wave>, amount: Real) { (*w).amplitude += amount; w.SIZE[1] = Real(SIZE); w.inner.Wave = 1u; }
fn userProc(Wave_: f32) -> f32 {
    var w = Wave(1.0, vec3<Real>(), Reals(), Inner(0u));
    add(&w, Wave_);
    switch i32(w.amplitude) { case SIZE: { return 1.0; } case 1, 2: { } default: { return Real(); } }
    while w.amplitude < 3.0 { w.amplitude += 1.0; if w.amplitude > 2.0 { continue; } }
    loop { w.amplitude -= 1.0; continuing { break if w.amplitude < 0.0; } }
    let q = vec3f(w.phase.xy, w.amplitude);
    return select(q.x, q.y, all(q.xy < vec2(1.0)) && true);
}
";
    let out = section(text);
    assert!(out.contains("struct t__Wave { amplitude: t__Real, @align(16) phase: vec3<t__Real>, SIZE: t__Reals, inner: t__Inner }"), "{out}");
    assert!(out.contains("case t__SIZE: "), "{out}");
}

#[test]
fn unicode_names_and_windows_line_ends_survive() {
    let out = section(
        "// Größe\r\nfn größe(é: f32) -> f32 { return é; }\r\nfn userProc() -> f32 {\r\n    return größe(1.0);\r\n}",
    );
    assert_eq!(
        out,
        "// Größe\r\nfn t__größe(é: f32) -> f32 { return é; }\r\nfn t__userProc() -> f32 {\r\n    return t__größe(1.0);\r\n}\n"
    );
}

#[test]
fn two_files_may_declare_the_same_names() {
    let a = "struct S { a: f32 } const K = 1.0; alias T = f32; fn h(s: S) -> T { return s.a; } fn userProc() -> f32 { return h(S(K)); }";
    let b = "struct S { b: vec2f } const K = 2u; alias T = vec2f; fn h(s: S) -> T { return s.b * f32(K); } fn userProc() -> vec2f { return h(S(T())); }";
    valid_kernel(&library(&[("a", a), ("b", b)]));
}

#[test]
fn fifty_copies_of_one_file_coexist() {
    let text =
        "const K = 2.0; fn h() -> f32 { return K; } fn userProc(x: f32) -> f32 { return h() * x; }";
    let names: Vec<String> = (0..50).map(|i| format!("copy{i}")).collect();
    let textures: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), text)).collect();
    valid_kernel(&library(&textures));
}

#[test]
fn odd_texture_names_make_distinct_prefixes() {
    let text = "fn f() -> f32 { return 1.0; } fn userProc() -> f32 { return f(); }";
    let tricky = "fn b__f() -> f32 { return 1.0; } fn userProc() -> f32 { let a__b__f = 1.0; let a__userProc = b__f(); return a__b__f * a__userProc; }";
    let names = [
        "a",
        "a b",
        "a_b",
        "a__b",
        "a-b",
        "1",
        "",
        "größe",
        "patina",
        "patina_link",
        "fn",
        "a\nb",
        "_",
        "a_2",
    ];
    let mut textures: Vec<(&str, &str)> = names.iter().map(|name| (*name, text)).collect();
    textures[0].1 = tricky;
    valid_kernel(&library(&textures));
}

#[test]
fn an_edit_changes_its_own_section_only() {
    let text = |body: &str| format!("fn userProc(x: f32) -> f32 {{ return {body}; }}");
    let other = text("x");
    let kernel = |body: &str| {
        valid_kernel(&library(&[
            ("a", &other),
            ("b", &text(body)),
            ("c", &other),
        ]))
    };
    let (before, after) = (kernel("x * 2.0"), kernel("x + 3.0"));
    let differing: Vec<_> = before
        .lines()
        .zip(after.lines())
        .filter(|(a, b)| a != b)
        .collect();
    assert_eq!(before.lines().count(), after.lines().count());
    assert_eq!(differing.len(), 1, "{differing:?}");
}

#[test]
fn every_parameter_type_is_loaded() {
    let text = "fn userProc(a: f32, b: i32, c: u32, d: bool, e: vec2f, f: vec3f, g: vec4f, h: mat3x3f, i: mat4x4f, j: sam2D, k: ramp1D, l: array<f32, 5>, m: array<vec3f, 2>, n: array<mat4x4f, 2>, o: array<bool, 3>) -> vec4f {
    let size = texSize(j);
    let whole = l;
    return tex2D(j, e) + tex2DLod(j, e, f.x) + rampEval(k, a) + g * f32(b) * f32(c) * h[0].x * i[1] * l[2] * l[b] + vec4f(m[c], whole[1]) * n[1] * f32(o[0] || d) * size.x;
}
";
    let out = section(text);
    assert!(out.contains("l: u32 /* array<f32, 5> */"), "{out}");
    assert!(
        out.contains("patina_element_f32(l, 5u, u32(2)) * patina_element_f32(l, 5u, u32(b))"),
        "{out}"
    );
    assert!(out.contains("let whole = patina_array_f32_5(l);"), "{out}");
}

#[test]
fn array_parameters_can_be_shadowed_nested_and_handed_on() {
    let text = "fn sum(a: array<f32, 3>) -> f32 { return a[0] + a[1] + a[2]; }
fn userProc(a: array<f32, 3>, b: array<i32, 3>) -> f32 {
    let x = a[b[a_index(b[0])]] + sum(a);
    { var a = a; a[1] = x; return sum(a); }
}
fn a_index(i: i32) -> i32 { return i; }
";
    let out = section(text);
    assert!(out.contains("patina_element_f32(a, 3u, u32(patina_element_i32(b, 3u, u32(t__a_index(patina_element_i32(b, 3u, u32(0)))))))"), "{out}");
    assert!(
        out.contains("var a = patina_array_f32_3(a); a[1] = x; return t__sum(a);"),
        "{out}"
    );
}

#[test]
fn more_than_32_parameters_are_possible() {
    let parameters: Vec<String> = (0..100).map(|i| format!("p{i}: vec3f")).collect();
    let sum: Vec<String> = (0..100).map(|i| format!("p{i}")).collect();
    let text = format!(
        "fn userProc({}) -> vec3f {{ return {}; }}",
        parameters.join(", "),
        sum.join(" + ")
    );
    valid_kernel(&library(&[("many", &text)]));
}

#[test]
fn short_counted_loops_stay_and_others_are_guarded() {
    let guarded = |body: &str| {
        section(&format!(
            "fn userProc(n: f32) -> f32 {{ var x = n; {body} return x; }}"
        ))
        .matches("patina_loops_spent")
        .count()
    };
    assert_eq!(
        guarded(
            "for (var i = -1; i <= 1; i++) { for (var j = 0u; j < 3u; j += 1u) { x += f32(i) * f32(j); } }"
        ),
        0
    );
    assert_eq!(guarded("for (var i = 0; i < 1000; i++) { x += 1.0; }"), 1);
    assert_eq!(guarded("for (var i = 0; i < i32(n); i++) { x += 1.0; }"), 1);
    assert_eq!(guarded("for (var i = 0; i < 9; i++) { i = 0; }"), 1);
    assert_eq!(guarded("for (var i = 0; i < 9; i++) { (i) -= 1; }"), 1);
    assert_eq!(
        guarded("for (var i = 0; i < 9; i++) { let p = &i; *p = 0; }"),
        1
    );
    assert_eq!(guarded("while x < 3.0 { x += 1.0; } loop { break; }"), 2);
    assert_eq!(
        guarded("loop { continuing { loop { break; } break if x > 1.0; } }"),
        2
    );
}

#[test]
fn a_function_that_only_returns_from_its_loop_stays_valid() {
    let text = "struct S { a: f32 }
fn f() -> S { loop { return S(1.0); } }
fn g() { loop {} }
fn userProc() -> f32 { g(); return f().a; }
";
    assert!(
        section(text)
            .contains("loop { if patina_loops_spent() { return t__S(); } return t__S(1.0); }")
    );
}

#[test]
fn a_function_whose_blocks_end_in_endless_loops_stays_valid() {
    let text = "fn f(x: f32) -> f32 { if x > 0.0 { loop { return x; } } else { return 2.0; } }
fn userProc() -> f32 { return f(1.0); }
";
    assert!(section(text).contains("else { return 2.0; } return f32(); }"));
}

#[test]
fn the_source_map_leads_back_to_the_file() {
    let text = "const K = 1.0;\nfn userProc() -> vec4f {\n    return K * readAttr(Normal);\n}\n";
    let kernel = library(&[("a", "fn userProc() -> f32 { return 1.0; }"), ("b", text)]).emit(1);
    for (needle, line, column) in [
        ("b__K * ", 3, 12),
        ("patina_attr_Normal()", 3, 16),
        ("return b__K", 3, 5),
    ] {
        let at = kernel.wgsl.find(needle).expect("is in the kernel");
        let problem = kernel.source_map.diagnostic(at..at + 4, "no good");
        let location = problem.location().expect("has a place");
        assert_eq!(
            (location.path.as_str(), location.line, location.column),
            ("b.wgsl", line, column),
            "{needle}"
        );
    }
    assert!(kernel.source_map.origin(0).is_none());
}

#[test]
fn what_a_texture_reads_is_known() {
    let texture = parse("t", "fn h() -> vec4f { return readAttr(AO); } fn userProc() -> vec4f { return h() + readAttr(_WET) + readAttr(AO); }").expect("valid");
    let expected = [
        Attribute::from(BuiltinAttribute::AO),
        Attribute::Custom("_WET".into()),
    ];
    assert_eq!(
        texture.attributes().iter().cloned().collect::<Vec<_>>(),
        expected
    );
}

#[test]
fn custom_attributes_are_numbered_over_the_library() {
    let text = |name: &str| format!("fn userProc() -> vec4f {{ return readAttr({name}); }}");
    let library = library(&[
        ("a", &text("_Z")),
        ("b", &text("_A")),
        ("c", &format!("const _Z = 7u; {}", text("_Z"))),
    ]);
    assert_eq!(library.custom_attributes(), ["_A", "_Z"]);
    let kernel = valid_kernel(&library);
    assert!(kernel.contains("const patina_custom_A = 0u;\nconst patina_custom_Z = 1u;\n"));
    assert_eq!(
        kernel
            .matches("patina_attr_custom(patina_custom_Z)")
            .count(),
        2
    );
}

#[test]
fn an_empty_library_makes_a_kernel() {
    valid_kernel(&Library::default());
}

#[test]
fn a_texture_says_whether_it_reads_mip_levels() {
    for (text, expected) in [
        (
            "fn userProc(i: sam2D) -> vec4f { return tex2D(i, vec2f()); } // not tex2DLod",
            false,
        ),
        (
            "fn userProc(i: sam2D) -> vec4f { return tex2DLod(i, vec2f(), 1.0); }",
            true,
        ),
        (
            "fn userProc(i: sam2D) -> vec4f { let tex2DLod = 1.0; return vec4f(tex2DLod); }",
            false,
        ),
        (
            "fn h(i: sam2D) -> vec4f { return tex2DLod(i, vec2f(), 1.0); } fn userProc(i: sam2D) -> vec4f { return h(i); }",
            true,
        ),
    ] {
        let library = library(&[("t", text)]);
        assert_eq!(library.textures()[0].reads_levels(), expected, "{text}");
    }
}
