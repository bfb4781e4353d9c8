//! What users see when a texture is wrong.

use crate::common::errors;

#[test]
fn a_syntax_error_points_into_the_file() {
    assert_eq!(errors("fn userProc() -> f32 {\n    return 1.0\n}\n"), "");
}
#[test]
fn show() {
    for text in [
        "fn userProc() -> f32 { return nois(1.0); }\nfn noise(x: f32) -> f32 { return x; }",
        "fn userProc() -> f32 { return vec3f(1.0); }",
        "fn f(x: f32) -> f32 { return x; }\nfn userProc() -> f32 { return f(1.0, 2.0) + f(vec2f()); }",
        "fn f(x: f32) -> f32 { return f(x); }\nfn userProc() -> f32 { return f(1.0); }",
        "fn userProc() -> f32 { let x = 1; x = 2; return 1.0; }",
        "fn userProc() -> f32 { if 1.0 { return 1.0; } }",
        "fn userProc() -> f32 { var a: array<f32, 2>; a[5] = 1.0; return 1.0 + 1u; }",
        "const A = 1;\nconst A = 2;\nfn userProc() -> f32 { return 1.0; }",
        "fn userproc() -> f32 { return 1.0; }",
        "fn userProc() -> i32 { return 1; }",
        "fn userProc() { }",
        "struct S { a: f32 }\nfn userProc(s: S, m: mat2x2f, t: array<S, 2>) -> f32 { return s.a; }",
        "fn userProc() -> vec4f { return readAttr(TexCoord); }",
        "fn userProc() -> vec4f { return readAttr(vec2f()) + WorldPos; }",
        "@group(0) @binding(0) var t: texture_2d<f32>;\nvar<private> x: f32;\noverride k: f32 = 1.0;\n@compute @workgroup_size(1) fn main() { workgroupBarrier(); }\nfn userProc() -> f32 { return dpdx(1.0) + textureSampleLevel(t, s, vec2f(), 0.0).x; }",
        "fn userProc() -> f32 { return missing1; }\nfn a() -> f32 { return missing2; }\nfn b() -> f32 { return 1u; }\nfn c(x: Missing) {}",
        "enable f16;\nfn userProc() -> f32 { return f32(1.0h); }",
        "fn userProc() -> f32 { let a = 1.0; return a.x + vec2f().z; }",
        "fn userProc() -> f32 { return pow(1.0, 2u) + sin(1.0, 2.0) + mix(vec3f(), vec3f(), vec2f()).x; }",
        "/// @param x the x [0 .. 1] = red\n/// @param y the y\n/// @param x again [colour]\nfn userProc(x: f32) -> f32 { return x; }",
        "fn tex2D() -> f32 { return 1.0; }\nfn userProc() -> f32 { return tex2D(); }",
        "fn userProc() -> f32 {",
        "",
        "fn userProc() -> f32 { var a: array<f32, 100000>; return a[3]; }",
    ] {
        eprintln!("==================== {text}\n{}", errors(text));
    }
}
