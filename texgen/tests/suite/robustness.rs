//! Whatever a file holds: no panic, no overflow, and nothing accepted that fails later.

use std::time::{Duration, Instant};

use crate::common::{parse, shipped, valid_kernel};
use texgen::Library;

/// Numbers without a pattern.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % limit.max(1)
    }
}

/// Pieces that matter to the language.
const PIECES: &[&str] = &[
    "fn ",
    "userProc",
    "{",
    "}",
    "(",
    ")",
    "<",
    ">",
    "array<f32, 4>",
    "readAttr",
    "AO",
    "_X",
    "loop",
    "for (",
    ";",
    "let ",
    "var ",
    "return ",
    "continuing",
    "switch x",
    "case 1: ",
    "/*",
    "*/",
    "//",
    "/// @param x [",
    "]",
    "=",
    "@",
    "struct S ",
    "alias A = f32;",
    "const c = 1;",
    "::",
    "..",
    "1e",
    "0x",
    "\u{0}",
    "é",
    "\u{2028}",
    "\"",
    "ptr<function,",
    "&",
    "*",
    "vec3f",
    "sam2D",
    "ramp1D",
    ".xyz",
    "[",
    "-",
    "%",
    "patina_",
    "override ",
    "enable f16;",
];

fn mutate(text: &str, random: &mut Random) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for _ in 0..1 + random.below(4) {
        let at = random.below(chars.len() + 1);
        let end = (at + random.below(12)).min(chars.len());
        match random.below(4) {
            0 => drop(chars.drain(at..end)),
            1 => drop(chars.splice(at..at, PIECES[random.below(PIECES.len())].chars())),
            2 => drop(chars.splice(at..end, PIECES[random.below(PIECES.len())].chars())),
            _ => {
                let copy: Vec<char> = chars[at..end].to_vec();
                let to = random.below(chars.len() + 1);
                drop(chars.splice(to..to, copy));
            }
        }
    }
    chars.into_iter().collect()
}

#[test]
fn mutated_textures_are_survived_and_what_is_accepted_is_valid() {
    let budget = Duration::from_secs(5);
    let start = Instant::now();
    let mut random = Random(11);
    let texts: Vec<String> = shipped()
        .iter()
        .map(|file| file.text().to_owned())
        .collect();
    let (mut tried, mut accepted) = (0, 0);
    while start.elapsed() < budget && tried < 3000 {
        tried += 1;
        let text = mutate(&texts[random.below(texts.len())], &mut random);
        match parse("mutated", &text) {
            Ok(texture) => {
                accepted += 1;
                valid_kernel(&Library::new(vec![texture]).expect("one texture"));
            }
            Err(problems) => {
                assert!(!problems.is_empty());
                for problem in &problems {
                    assert!(
                        problem.location().is_some(),
                        "an error without a place: {problem}\n{text}"
                    );
                }
            }
        }
    }
    eprintln!("{tried} mutated textures, {accepted} accepted");
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
