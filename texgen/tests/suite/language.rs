//! The language as its page describes it, feature by feature: what a texture may hold makes a valid kernel, what it
//! may not hold is refused with the reason and a remedy.

use std::fmt::Write;

use crate::common::{errors, library, parse, shipped, valid_kernel};
use texgen::{ElementType, Library, PRELUDE, ParameterType, TextureType, Value, Widget};

/// Types that an array parameter may hold, with an expression that makes a number of one.
const ELEMENTS: [(ElementType, &str); 9] = [
    (ElementType::F32, "E"),
    (ElementType::I32, "f32(E)"),
    (ElementType::U32, "f32(E)"),
    (ElementType::Bool, "f32(E)"),
    (ElementType::Vec2, "E.y"),
    (ElementType::Vec3, "E.z"),
    (ElementType::Vec4, "E.w"),
    (ElementType::Mat3, "E[2].y"),
    (ElementType::Mat4, "E[3].x"),
];

#[test]
fn arrays_of_every_plain_type_are_read_in_every_way() {
    for (element, number) in ELEMENTS {
        let ty = element.parameter_type();
        let at = |index: &str| number.replace('E', &format!("a[{index}]"));
        let text = format!(
            "fn first(b: array<{ty}, 4>) -> f32 {{ return {}; }}
fn userProc(a: array<{ty}, 4>, i: i32, u: u32) -> f32 {{
    let whole = a;
    var sum = {} + {} + {} + {} + first(a) + {};
    for (var k = 0u; k < 4u; k++) {{ sum += {}; }}
    return sum;
}}",
            number.replace('E', "b[0]"),
            at("3"),
            at("i"),
            at("u"),
            at("i + i32(u) * 2"),
            number.replace('E', "whole[1]"),
            at("k"),
        );
        let library = library(&[("t", &text)]);
        assert_eq!(
            library.textures()[0].parameters()[0].ty,
            ParameterType::Array(element, 4)
        );
        let kernel = valid_kernel(&library);
        assert_eq!(
            kernel
                .matches(&format!("patina_element_{ty}(a, 4u,"))
                .count(),
            5,
            "read in place: {kernel}"
        );
    }
}

#[test]
fn arrays_of_types_by_another_name_are_read_in_every_way() {
    let kernel = valid_kernel(&library(&[(
        "t",
        "alias Color = vec3f;
alias Palette = array<Color, 4>;
const N = 3;
fn pick(t: array<Color, 4>, i: u32) -> Color { return t[i]; }
fn other(t: Palette) -> Color { return t[1]; }
fn last(t: array<f32, N>) -> f32 { return t[N - 1]; }
fn userProc(a: array<Color, 4>, b: Palette, c: array<f32, N>) -> Color {
    let patina = a;
    return pick(a, 2u) + other(b) + other(patina) + a[0] * last(c);
}",
    )]));
    assert!(
        kernel.contains("t__pick(t__patina_array0(a), 2u)"),
        "{kernel}"
    );
}

#[test]
fn the_result_type_of_a_function_that_loops_keeps_its_blanks() {
    valid_kernel(&library(&[(
        "t",
        "fn f(x: f32) -> array<f32, 4 - -1> {
    var a = array<f32, 4 - -1>();
    while a[0] < x { a[0] += 0.1; }
    return a;
}
fn userProc(x: f32) -> f32 { return f(x)[4]; }",
    )]));
}

#[test]
fn arrays_may_have_any_size_and_a_constant_for_it() {
    for size in ["1", "65536", "SIZE", "SIZE * 2 + 1"] {
        let text = format!(
            "const SIZE = 1000; fn userProc(a: array<f32, {size}>, i: u32) -> f32 {{ return a[i]; }}"
        );
        valid_kernel(&library(&[("t", &text)]));
    }
}

/// Names of the language beside its functions, of WGSL and of what the kernel calls behind the user's back.
const TAKEN: &[&str] = &[
    "sam2D",
    "ramp1D",
    "WorldPos",
    "AO",
    "Time",
    "SceneMax",
    "f32",
    "i32",
    "u32",
    "bool",
    "vec2f",
    "vec3f",
    "vec4f",
    "vec3",
    "mat3x3f",
    "array",
    "ptr",
    "function",
    "select",
    "min",
    "max",
    "mix",
    "bitcast",
    "round",
    "userProc",
    "helper",
    "Pair",
    "SIZE",
    "Real",
    "args",
    "at",
    "result",
    "p0",
    "links0",
    "occlusion",
    "position",
    "compute",
    "group",
    "override_",
    "größe",
    "名前",
    "t__helper",
    "t__userProc",
];

#[test]
fn any_name_may_be_shadowed() {
    let functions = PRELUDE.lines().filter_map(|line| line.strip_prefix("fn "));
    let functions = functions.filter_map(|function| Some(function.split_once('(')?.0));
    for name in functions.chain(TAKEN.iter().copied()) {
        let declared = format!(
            "const SIZE = 4; alias Real = f32; struct Pair {{ a: Real, b: Real }}
fn helper(x: Real) -> Pair {{ return Pair(x, x); }}
fn userProc(list: array<f32, 4>, index: i32, limit: f32, image: sam2D, ramp: ramp1D) -> vec4f {{
    let pair = helper(limit);
    var sum = list[index] + pair.a + tex2D(image, vec2f()).x + rampEval(ramp, limit).x + readAttr(AO).x;
    {{
        let {name} = sum;
        var k = 0;
        loop {{ if {name} > 3.0 || k > 9 {{ break; }} k++; }}
        while k < 3 {{ k += 1; }}
        sum += {name} + list[index];
    }}
    return vec4f(sum);
}}"
        );
        valid_kernel(&library(&[("t", &declared)]));
        let as_parameter = format!(
            "fn userProc({name}: f32, list_: array<f32, 2>) -> f32 {{ var s = {name}; while s < 1.0 {{ s += {name} + list_[1]; }} return s; }}"
        );
        valid_kernel(&library(&[("t", &as_parameter)]));
        let as_member = format!(
            "struct S_ {{ {name}: f32 }} fn userProc() -> f32 {{ let s = S_(2.0); return s.{name}; }}"
        );
        valid_kernel(&library(&[("t", &as_member)]));
    }
}

#[test]
fn a_local_may_have_the_name_of_the_result_type_of_its_function() {
    // The guard of a loop returns a zero of that type.
    let text = "struct Pair { a: f32 }
alias Real = f32;
fn pair() -> Pair { let Pair = 1.0; var x = Pair; while x < 9.0 { x += 1.0; } return make(x); }
fn make(x: f32) -> Pair { return Pair(x); }
fn table() -> array<Real, 3> { let Real = 1.0; var a = zero(); while a[0] < Real { a[0] += 0.1; } return a; }
fn zero() -> array<Real, 3> { return array<Real, 3>(); }
fn userProc(list: array<f32, 3>, i: i32) -> vec3f {
    let vec3f = pair().a; let u32 = 1.0;
    var x = vec3f * u32;
    loop { if x > 5.0 { break; } x += list[i]; }
    return vec3<f32>(x, table()[1], list[i]);
}";
    valid_kernel(&library(&[("t", text)]));
}

#[test]
fn statements_of_all_kinds_are_kept() {
    let text = "const LIMIT: i32 = 12;
const_assert LIMIT > 2;
alias Table = array<vec2<f32>, 3>;
struct Inner { v: vec3<f32>, n: i32 }
struct Outer { inner: array<Inner, 2>, m: mat2x2<f32> }
fn early(x: f32) -> f32 {
    if x < 0.0 { return -1.0; } else if x == 0.0 { return 0.0; } else { }
    return 1.0;
}
fn nothing() { return; }
fn bump(p: ptr<function, i32>, q: ptr<function, Outer>) { *p += 1; (*q).inner[1].n = *p; q.m[0][1] = f32(*p); }
@must_use fn three(x: f32) -> f32 { return early(early(early(x))); }
fn userProc(x: f32, n: i32, flag: bool) -> vec4f {
    var count = n;
    var outer = Outer();
    let table = Table(vec2f(1.0), vec2f(2.0), vec2f(3.0));
    var copy = table;
    bump(&count, &outer);
    let p = &outer.inner[1].v;
    (*p).y = three(x);
    p.x -= 1.0;
    copy[count & 1].x *= 2.0;
    nothing();
    _ = three(x);
    switch n {
        case 0: { count = 1; }
        case 1, 2, LIMIT: { count <<= 1u; }
        default: { count ^= 5; }
    }
    switch u32(n) { default { } }
    for (var i = 0; ; ) { if i > 3 { break; } i++; if flag { continue; } count -= 1; }
    return vec4f(outer.inner[1].v, copy[1].x + f32(count));
}";
    valid_kernel(&library(&[("t", text)]));
    for loops in [
        "for (var i = 0; i < 3; i++) { for (var i = 5; i > 0; i--) { s += f32(i); } }",
        "while s < 3.0 { s += 1.0; if s > 1.0 { continue; } s += 0.5; }",
        "loop { s += 1.0; if s > 3.0 { break; } continuing { s += 0.1; break if s > 2.0; } }",
        "loop { switch i32(s) { case 1: { break; } default: { continue; } } continuing { s += 1.0; break if s > 9.0; } }",
        "loop { loop { if s > 1.0 { return s; } s += 1.0; } }",
        "{ let s = 3; { let s = f32(s); _ = s; } }",
        "if (s < 1.0 && s > 0.5) || !(s >= 2.0) { s = select(1.0, s, s < 3.0); }",
        "s = vec3<f32>(1.0, s, array<f32, 2>(s, 2.0)[1]).z;",
        "const N = 2 << 1; var a: array<f32, N>; a[N - 1] = s; s = a[3];",
    ] {
        let text = format!("fn userProc(x: f32) -> f32 {{ var s = x; {loops} return s; }}");
        valid_kernel(&library(&[("t", &text)]));
    }
}

#[test]
fn comments_may_hold_anything() {
    let text = "// @compute fn main() { textureSample(); } override k = 1.0; \"discard;\"
/* @group(0) @binding(0) var<storage> x: array<f32>; /* nested: enable f16; */ readAttr(Nothing) */
fn userProc(/* fn noise( */ x: f32 // patina_stack, dpdx(
) -> f32 { /* return readAttr(Foo); */ return x; // userProc(
}
// unfinished: fn userProc(";
    let kernel = valid_kernel(&library(&[("t", text)]));
    for line in text.lines().filter(|line| line.starts_with("//")) {
        assert!(kernel.contains(line), "{line}");
    }
}

#[test]
fn comments_may_stand_in_the_types_of_array_parameters() {
    let kernels = [
        "array<f32, // three */\n3>, b: array<vec3f, /* two */ 2>",
        "array<f32, /* /* three */ */\n3>, b: array<vec3f, // two /*\n2>",
        "array<f32, 3>, // three */\nb: array<vec3f, 2> /* two */",
    ]
    .map(|types| {
        let text = format!("fn userProc(a: {types}) -> f32 {{ return a[0] + b[1].x; }}\n// behind");
        let kernel = valid_kernel(&library(&[("t", &text)]));
        let start = kernel.find("fn t__userProc").expect("is there");
        let end = kernel.find("// behind").expect("is there");
        // Lines stay what they are.
        let lines = kernel[start..end].matches('\n').count();
        assert_eq!(lines, text.matches('\n').count(), "{kernel}");
        kernel
    });
    assert!(kernels[0].contains("a: u32\n, b: u32)"), "{}", kernels[0]);
    assert!(kernels[2].contains("a: u32 /* array<f32, 3> */, //"));
}

#[test]
fn names_of_all_scripts_survive() {
    let text = "const Größe = 2.0; struct 構造 { 値: f32 } alias Δ = f32;
fn épaisseur(ρ: Δ) -> 構造 { return 構造(ρ * Größe); }
/// @param толщина the thickness = 3
fn userProc(толщина: f32) -> f32 { let 値 = épaisseur(толщина); return 値.値; }";
    let library = library(&[("t", text)]);
    valid_kernel(&library);
    let parameter = &library.textures()[0].parameters()[0];
    assert_eq!(
        (parameter.name.as_str(), &parameter.default),
        ("толщина", &Some(Value::F32(3.0)))
    );
}

#[test]
fn fifty_copies_of_a_real_texture_coexist() {
    for name in ["rust_mask", "voronoi"] {
        let files = shipped();
        let file = files.iter().find(|f| f.name() == name).expect("shipped");
        let names: Vec<String> = (0..50).map(|i| format!("{name} {i}")).collect();
        let textures: Vec<(&str, &str)> = names.iter().map(|n| (n.as_str(), file.text())).collect();
        let kernel = valid_kernel(&library(&textures));
        assert_eq!(
            kernel.matches("__userProc(").count(),
            100,
            "declared and called"
        );
    }
}

/// The kernel cut into its sections: name of the texture and text.
fn sections(kernel: &str) -> Vec<(String, String)> {
    let mut sections = Vec::new();
    for part in kernel.split("\n// ==== ").skip(1) {
        let (name, text) = part.split_once(" ====").expect("a title");
        sections.push((name.to_owned(), text.to_owned()));
    }
    sections
}

#[test]
fn an_edit_of_one_of_ten_textures_changes_only_its_section() {
    let names: Vec<String> = (0..10).map(|i| format!("texture{i}")).collect();
    let text = |i: usize| {
        format!(
            "struct S {{ v: f32 }} const K = {i}.0; fn f(s: S) -> f32 {{ return s.v * K; }}
fn userProc(x: f32, a: array<f32, 3>) -> f32 {{ return f(S(x)) + a[1] + readAttr(_M{i}).x; }}"
        )
    };
    let kernel = |changed: usize, edit: &dyn Fn(String) -> String| {
        let texts: Vec<String> = (0..10)
            .map(|i| if i == changed { edit(text(i)) } else { text(i) })
            .collect();
        let pairs: Vec<(&str, &str)> = names
            .iter()
            .zip(&texts)
            .map(|(name, text)| (name.as_str(), text.as_str()))
            .collect();
        valid_kernel(&library(&pairs))
    };
    let before = kernel(0, &|text| text);
    assert_eq!(before, kernel(0, &|text| text), "always the same text");
    let before = sections(&before);
    assert_eq!(before.len(), 11, "ten textures and the loop over programs");
    let edits: [&dyn Fn(String) -> String; 5] = [
        &|text| text.replace("* K", "* K + 1.0"),
        &|text| format!("// a comment\n\n{text}"),
        &|text| text.replace("x: f32, a", "y: vec3f, x: f32, a"),
        // A new attribute stands before the others' in the alphabet, yet nobody else's text changes.
        &|text| text.replace("return f(", "return readAttr(_A).y + f("),
        &|text| text.replace("readAttr(_M4).x", "1.0"),
    ];
    for edit in edits {
        let after = sections(&kernel(4, edit));
        for ((name, old), (new_name, new)) in before.iter().zip(&after) {
            assert_eq!(name, new_name);
            assert_eq!(old == new, name != "texture4", "{name}:\n{old}\n{new}");
        }
    }
}

#[test]
fn a_new_texture_changes_no_other_section() {
    let text = "fn userProc(x: f32) -> f32 { return x + readAttr(_WET).x; }";
    let kernel = |names: &[&str]| {
        let pairs: Vec<(&str, &str)> = names.iter().map(|name| (*name, text)).collect();
        sections(&valid_kernel(&library(&pairs)))
    };
    let before = kernel(&["a", "c", "d"]);
    let after = kernel(&["a", "b", "c", "d"]);
    for (name, text) in before.iter().filter(|(name, _)| name != "programs") {
        let found = after.iter().find(|(n, _)| n == name).expect("is there");
        assert_eq!(*text, found.1);
    }
}

#[test]
fn every_refusal_says_why_and_what_to_do() {
    let module = |text: &str| format!("{text}\nfn userProc() -> f32 {{ return 1.0; }}");
    let body = |text: &str| format!("fn userProc() -> f32 {{ {text} return 1.0; }}");
    let cases = [
        (
            module("@vertex fn main() -> @builtin(position) vec4f { return vec4f(); }"),
            "entry points",
        ),
        (
            module("@group(0) @binding(0) var<uniform> u: vec4f;"),
            "buffers, images or samplers",
        ),
        (
            module("@group(0) @binding(0) var s: sampler;"),
            "`sampler` is not available",
        ),
        (
            module("@group(1) @binding(0) var t: texture_storage_2d<rgba8unorm, write>;"),
            "is not available",
        ),
        (module("@id(7) override k: f32;"), "`override`"),
        (
            module("requires readonly_and_readwrite_storage_textures;"),
            "`requires` directives",
        ),
        (module("enable subgroups;"), "`enable` directives"),
        (
            module("var<workgroup> a: array<f32, 4>;"),
            "workgroup variables",
        ),
        (module("var<private> a = 1.0;"), "module-scope variables"),
        (module("var total = 0.0;"), "module-scope variables"),
        (
            body("storageBarrier();"),
            "`storageBarrier` is not possible",
        ),
        (
            body("textureBarrier();"),
            "`textureBarrier` is not possible",
        ),
        (body("let x = fwidthFine(1.0);"), "neighbouring pixels"),
        (body("let x = dpdyCoarse(1.0);"), "neighbouring pixels"),
        (
            body("let x = atomicAdd(&a, 1u);"),
            "nothing shared between hits",
        ),
        (
            body("let x = subgroupBroadcast(1u, 0u);"),
            "independently of each other",
        ),
        (
            body("let x = quadSwapX(1.0);"),
            "independently of each other",
        ),
        (body("let x = arrayLength(&a);"), "needs a buffer"),
        (
            body("let x = textureLoad(t, vec2i(), 0);"),
            "`textureLoad` is not possible",
        ),
        (
            body("textureStore(t, vec2i(), vec4f());"),
            "`textureStore` is not possible",
        ),
        (body("let x = textureDimensions(t);"), "`texSize(image)`"),
        (body("let x = vec2h();"), "`f32` types"),
        (body("let x = ramp1D(1u);"), "can't be made by a texture"),
        (body("discard;"), "`discard`"),
        (
            body("@diagnostic(off, derivative_uniformity) if true { }"),
            "`@diagnostic` attributes",
        ),
        (
            module("fn a() { b(); } fn b() { c(); } fn c() { a(); }"),
            "use a loop",
        ),
    ];
    for (text, part) in cases {
        let problems = parse("t", &text).expect_err(&text);
        let report = problems.render();
        assert!(report.contains(part), "{part:?} is missing:\n{report}");
        let first = &problems.as_slice()[0];
        assert!(first.location().is_some(), "no place:\n{report}");
        assert!(!first.notes.is_empty(), "no remedy:\n{report}");
    }
}

#[test]
fn every_key_of_a_parameter_line_is_understood() {
    let read = |keys: &str, ty: &str| {
        let text =
            format!("/// @param x the label {keys}\nfn userProc(x: {ty}) -> f32 {{ return 1.0; }}");
        let texture = parse("t", &text).unwrap_or_else(|problems| panic!("{problems}"));
        assert!(texture.warnings().is_empty(), "{}", texture.warnings());
        assert_eq!(texture.parameters()[0].label, "the label");
        texture.parameters()[0].clone()
    };
    for (key, widget) in [
        ("color", Widget::Color),
        ("angle", Widget::Angle),
        ("log", Widget::Log),
        ("percent", Widget::Percent),
        ("seed", Widget::Seed),
    ] {
        let ty = if key == "color" { "vec3f" } else { "f32" };
        assert_eq!(read(&format!("[{key}]"), ty).widget, widget);
    }
    let all = read("[-1.5 .. 2e3, soft 0 .. 1, unit m/s, log] = 0.25", "f32");
    assert_eq!(all.range, Some((-1.5, 2000.0)));
    assert_eq!(all.soft_range, Some((0.0, 1.0)));
    assert_eq!(all.unit.as_deref(), Some("m/s"));
    assert_eq!(all.default, Some(Value::F32(0.25)));
    assert!(read("[data]", "sam2D").is_data);
    for (key, interpolation) in [
        ("linear", texgen::Interpolation::Linear),
        ("smooth", texgen::Interpolation::Smooth),
        ("constant", texgen::Interpolation::Constant),
    ] {
        match read(
            &format!("[{key}] = [(0, #000), (0.5, #f00), (1, #fff)]"),
            "ramp1D",
        )
        .default
        {
            Some(Value::Ramp(ramp)) => {
                assert_eq!((ramp.interpolation, ramp.stops.len()), (interpolation, 3));
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_default_of_every_type_is_understood() {
    let mut list = String::new();
    let mut docs = String::new();
    let defaults = [
        ("f32", "-2.5"),
        ("i32", "-3"),
        ("u32", "4"),
        ("bool", "true"),
        ("vec2f", "(1, 2)"),
        ("vec3f", "#ff8000"),
        ("vec4f", "(1, 2, 3, 4)"),
        ("mat3x3f", "((1, 2, 3), (4, 5, 6), (7, 8, 9))"),
        (
            "mat4x4f",
            "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 5))",
        ),
        ("ramp1D", "[(0, #000000), (1, (1, 0.5, 0.25, 1))]"),
        ("array<bool, 2>", "[true, false]"),
        ("array<u32, 2>", "[1, 2]"),
        ("array<vec4f, 2>", "[(1, 2, 3, 4), #ffffff]"),
        ("array<mat3x3f, 1>", "[((2, 0, 0), (0, 2, 0), (0, 0, 2))]"),
    ];
    for (i, (ty, default)) in defaults.iter().enumerate() {
        let _ = writeln!(docs, "/// @param p{i} = {default}");
        let _ = write!(list, "p{i}: {ty}, ");
    }
    let text = format!("{docs}fn userProc({list}) -> f32 {{ return 1.0; }}");
    let texture = parse("t", &text).unwrap_or_else(|problems| panic!("{problems}"));
    for parameter in texture.parameters() {
        let value = parameter.default.as_ref().expect("given");
        assert!(value.fits(parameter.ty), "{}: {value:?}", parameter.name);
        assert_ne!(Some(value), parameter.ty.zero().as_ref());
    }
}

#[test]
fn documentation_is_what_stands_above_the_entry() {
    let docs = |text: &str| -> String {
        let text = format!("{text}fn userProc(x: f32) -> f32 {{ return x; }}");
        let texture: TextureType =
            parse("t", &text).unwrap_or_else(|problems| panic!("{problems}"));
        texture.docs().to_owned()
    };
    assert_eq!(
        docs("/// One.\n///\n/// Two.\n/// @param x y\n"),
        "One.\n\nTwo."
    );
    assert_eq!(
        docs("//! The file.\nfn f() {}\n/// The entry.\n"),
        "The file.\nThe entry."
    );
    assert_eq!(docs("/** Block\n * two\n */\n"), "Block\ntwo");
    assert_eq!(docs("/// A helper.\nfn f() {}\n"), "");
    assert_eq!(docs("// Plain.\n//// Ruler.\n"), "");
}

#[test]
fn errors_of_several_files_name_their_files() {
    for (name, text) in [("a b", "fn userProc() -> f32 { return x; }"), ("größe", "")] {
        let report = parse(name, text).expect_err("wrong").render();
        assert!(report.contains(&format!("--> {name}.wgsl:1:")), "{report}");
    }
    assert!(errors("fn userProc() -> f32 {\n\treturn readAttr(Foo).x;\n}").contains("t.wgsl:2:18"));
    assert!(Library::default().textures().is_empty());
}
