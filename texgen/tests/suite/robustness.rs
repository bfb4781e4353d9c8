//! Whatever a file holds: no panic, no overflow, and nothing accepted that fails later. The mutations are always the
//! same ones; with `PATINA_FULL` set there are many more of them.

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

/// Words for the place of other words, so that many of the results are still WGSL.
const WORDS: &[&str] = &[
    "readAttr",
    "readGlobal",
    "tex2D",
    "rampEval",
    "userProc",
    "f32",
    "i32",
    "u32",
    "bool",
    "vec2f",
    "vec3f",
    "vec4f",
    "mat3x3f",
    "array",
    "x",
    "y",
    "p",
    "i",
    "select",
    "mix",
    "abs",
    "fract",
    "if",
    "while",
    "loop",
    "for",
    "let",
    "var",
    "const",
    "return",
    "break",
    "continue",
    "AO",
    "WorldPos",
    "Time",
    "_WETNESS",
    "true",
    "1",
    "0.0",
    "2u",
    "größe",
];

/// A texture with what the shipped ones lack.
const RICH: &str = "alias Real = f32;
const N = 3;
struct Wave { amplitude: Real, phase: vec2f, rows: array<Real, N> }
fn add(w: ptr<function, Wave>, amount: Real) -> Wave {
    (*w).amplitude += amount;
    for (var i = 0; i < N; i++) { w.rows[i] += amount; if w.rows[i] > 9.0 { return *w; } }
    return *w;
}
fn spin(x: Real) -> array<Real, N> {
    var a = array<Real, N>(x, x, x);
    loop { a[1] += 1.0; if a[1] > x { break; } continuing { a[2] -= 0.5; break if a[2] < 0.0; } }
    while a[0] < 3.0 { a[0] += 1.0; switch i32(a[0]) { case 1: { continue; } case 2, N: { return a; } default: { } } }
    return a;
}
/// @param list = [1, 2, 3]
fn userProc(image: sam2D, ramp: ramp1D, list: array<f32, N>, points: array<vec3f, 2>, m: mat3x3f, n: i32, on: bool) -> vec4f {
    var w = Wave(1.0, readAttr(TexCoord0).xy, list);
    let p = &w;
    let added = add(p, list[n]);
    let i = spin(added.amplitude)[1] + points[1].x;
    if on { return tex2D(image, w.phase) + readAttr(_WETNESS); }
    return rampEval(ramp, i) * vec4f(m * points[n], readGlobal(Time).x) + readAttr(AO);
}
";

fn mutate(text: &str, random: &mut Random) -> String {
    let mut chars: Vec<char> = text.chars().collect();
    for _ in 0..1 + random.below(4) {
        if random.below(2) == 0 {
            replace_word(&mut chars, random);
            continue;
        }
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

/// Puts some other word in the place of one: one of the text's own, or one of [`WORDS`].
fn replace_word(chars: &mut Vec<char>, random: &mut Random) {
    let is_part = |c: &char| c.is_alphanumeric() || *c == '_';
    let mut words: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, _) in chars.iter().enumerate().filter(|(_, c)| is_part(c)) {
        match words.last_mut() {
            Some(last) if last.end == at => last.end += 1,
            _ => words.push(at..at + 1),
        }
    }
    if words.is_empty() {
        return;
    }
    let word = words[random.below(words.len())].clone();
    let other: Vec<char> = match random.below(2) {
        0 => chars[words[random.below(words.len())].clone()].to_vec(),
        _ => WORDS[random.below(WORDS.len())].chars().collect(),
    };
    drop(chars.splice(word, other));
}

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
