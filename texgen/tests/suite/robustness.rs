//! Whatever a file holds: no panic, no overflow, and nothing accepted that fails later. The mutations are always the
//! same ones; with `PATINA_FULL` set there are many more of them.

use std::time::{Duration, Instant};

use crate::common::{parse, shipped, valid_kernel};
use crate::mutate::{RICH, Random, mutate};
use texgen::Library;

#[test]
fn mutated_textures_are_survived_and_what_is_accepted_is_valid() {
    let full = std::env::var_os("PATINA_FULL").is_some();
    let (budget, most) = match full {
        true => (Duration::from_secs(600), 200_000),
        false => (Duration::from_secs(15), 12_000),
    };
    let start = Instant::now();
    let mut random = Random(11);
    let mut texts: Vec<String> = shipped()
        .iter()
        .map(|file| file.text().to_owned())
        .collect();
    texts.extend([RICH, RICH, RICH].map(str::to_owned));
    let (mut tried, mut accepted, mut slowest) = (0, 0, Duration::ZERO);
    // Accepted textures share kernels with others, as they do in a scene.
    let mut together = Vec::new();
    while start.elapsed() < budget && tried < most {
        tried += 1;
        let text = mutate(&texts[random.below(texts.len())], &mut random);
        let began = Instant::now();
        let verdict = parse(&format!("mutated {}", together.len()), &text);
        slowest = slowest.max(began.elapsed());
        match verdict {
            Ok(texture) => {
                accepted += 1;
                together.push(texture);
                if together.len() == 8 {
                    let textures = std::mem::take(&mut together);
                    valid_kernel(&Library::new(textures).expect("names differ"));
                }
            }
            Err(problems) => {
                assert!(!problems.is_empty());
                for problem in &problems {
                    assert!(
                        problem.location().is_some(),
                        "an error without a place: {problem}\n{text}"
                    );
                    assert!(
                        !problem
                            .notes
                            .iter()
                            .any(|note| note.contains("please report")),
                        "valid as a texture, but not in the kernel: {problem}\n{text}"
                    );
                }
            }
        }
    }
    eprintln!("{tried} mutated textures, {accepted} accepted, the slowest took {slowest:?}");
    assert!(accepted * 20 > tried, "most mutations must be subtle");
    // Far more than any took; a machine may be busy.
    assert!(slowest < Duration::from_secs(5), "{slowest:?}");
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
