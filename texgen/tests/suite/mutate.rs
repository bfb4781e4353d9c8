//! Mutations of textures: cuts, insertions, repetitions, and words in the place of other words. Always the same ones for
//! a seed. A test of the whole renderer uses them too.

/// Numbers without a pattern.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// A number below `limit`, which may be 0 for nothing to choose from.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
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
pub(crate) const RICH: &str = "alias Real = f32;
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

/// Changes a few pieces of a texture.
pub(crate) fn mutate(text: &str, random: &mut Random) -> String {
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
