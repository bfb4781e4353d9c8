//! Whatever a file holds: no panic and no overflow. Changes of textures by the thousand are tried by the crate `fuzzing`.

use std::time::Instant;

use crate::common::parse;

/// naga's work grows with the square of a function, and each error costs a try.
#[test]
fn mistakes_of_a_long_function_are_told_after_some_of_them() {
    let line = |index: usize| format!("let b{index} = a[7]{};\n", " + 1.0".repeat(20));
    let lines: String = (0..800).map(line).collect();
    let text = format!("fn userProc() -> f32 {{\nlet a = array<f32, 3>();\n{lines}return 1.0;\n}}");
    let problems = parse("t", &text).expect_err("indices beyond the end");
    let report = problems.render();
    let count = problems.len();
    assert!((2..10).contains(&count), "{count}");
    assert!(
        report.contains("there may be more errors than these"),
        "{report}"
    );
    // Those of short ones are all told.
    let short: String = (0..40)
        .map(|i| format!("fn f{i}x() -> f32 {{ let a = array<f32, 3>(); return a[7]; }}\n"))
        .collect();
    let text = format!("{short}fn userProc() -> f32 {{ return 1.0; }}");
    assert_eq!(parse("t", &text).expect_err("the same").len(), 40);
}

#[test]
fn deep_and_long_files_are_survived() {
    let entry = "fn userProc(x: f32) -> f32 { return x; }";
    let in_body = |body: &str| format!("fn userProc(x: f32) -> f32 {{ {body} }}");
    for text in [
        in_body(&format!(
            "return {}x{};",
            "(".repeat(20_000),
            ")".repeat(20_000)
        )),
        in_body(&format!("return {}x;", "-".repeat(20_000))),
        in_body(&format!("return x{};", "+x".repeat(100_000))),
        in_body(&format!("return x{};", " + x * x".repeat(20_000))),
        in_body(&format!(
            "{}{} return x;",
            "{".repeat(10_000),
            "}".repeat(10_000)
        )),
        in_body(&format!(
            "{} return x;",
            "if x > 0.0 {} else ".repeat(5_000) + "{}"
        )),
        in_body(&format!(
            "let v = vec4f(); return v{}.x;",
            ".xyzw".repeat(20_000)
        )),
        format!(
            "{entry} alias T = {}f32{};",
            "array<".repeat(10_000),
            ", 1>".repeat(10_000)
        ),
        format!("{entry} {}", "/*".repeat(50_000)),
        format!("{entry} {}", "@a ".repeat(50_000)),
        format!(
            "{entry} {}",
            (0..3000)
                .map(|i| format!("alias A{} = A{i};", i + 1))
                .collect::<String>()
        ),
        format!(
            "{entry} {}",
            (0..3000)
                .map(|i| format!("fn f{i}x() {{ f{}x(); }}", i + 1))
                .collect::<String>()
        ),
        format!(
            "const a0x = 1; {entry} {}",
            (0..3000)
                .map(|i| format!("const a{}x = a{i}x;", i + 1))
                .collect::<String>()
        ),
        format!(
            "fn f0x() {{}} {entry} {}",
            (0..3000)
                .map(|i| format!("fn f{}x() {{ f{i}x(); }}", i + 1))
                .collect::<String>()
        ),
        format!(
            "alias A0 = f32; {entry} {}",
            (0..24)
                .map(|i| format!("alias A{} = array<A{i}, 200>;", i + 1))
                .collect::<String>()
        ),
        "x".repeat(300_000),
        in_body(&format!("return x{};", "+x".repeat(490))),
        in_body(&format!(
            "{} {{ }} return x;",
            "if x > 0.0 { } else ".repeat(120)
        )),
        format!(
            "{entry} {}",
            (0..900)
                .map(|i| format!("alias A{} = A{i};", i + 1))
                .collect::<String>()
        ),
        format!(
            "{entry} alias A900 = f32; {}",
            (0..900)
                .map(|i| format!("alias A{i} = A{};", i + 1))
                .collect::<String>()
        ),
        format!(
            "{entry} fn f900x() {{}} {}",
            (0..900)
                .map(|i| format!("fn f{i}x() {{ f{}x(); }}", i + 1))
                .collect::<String>()
        ),
        format!(
            "const a900x = 1; {entry} {}",
            (0..900)
                .map(|i| format!("const a{i}x = a{}x;", i + 1))
                .collect::<String>()
        ),
        format!(
            "{entry} {}",
            (0..90)
                .map(|i| format!(
                    "fn f{i}x() -> f32 {{ {} return 1.0; }}",
                    "{".repeat(100) + &"}".repeat(100)
                ))
                .collect::<String>()
        ),
    ] {
        let start = Instant::now();
        let verdict = parse("deep", &text);
        eprintln!(
            "{:.60}: {} in {:?}",
            text,
            if verdict.is_ok() {
                "accepted"
            } else {
                "refused"
            },
            start.elapsed()
        );
    }
}
