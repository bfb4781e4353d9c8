//! Random functions give the same natively as on a GPU device.
//!
//! What is computed from floats alone by operations that are exact everywhere (sums, products, comparisons, rounding,
//! conversions) must agree to the bit, as integers must. Functions that devices only approximate stand last: nothing is
//! computed from their results, and each has a tolerance of its own.

use device::native::compile::Options;

use crate::support::{Gpu, HEAD, compile, gpu, parse, run, try_parse};

/// Numbers that look random (PCG, O'Neill 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u32 {
        let state = self.0;
        self.0 = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let shifted = (((state >> 18) ^ state) >> 27) as u32;
        shifted.rotate_right((state >> 59) as u32)
    }

    fn below(&mut self, n: u32) -> u32 {
        self.next() % n
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u32) as usize]
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    F32,
    I32,
    U32,
    Bool,
}

/// A scalar, or a vector of two to four.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Type {
    scalar: Scalar,
    width: u32,
}

impl Type {
    fn name(self) -> String {
        let scalar = match self.scalar {
            Scalar::F32 => "f32",
            Scalar::I32 => "i32",
            Scalar::U32 => "u32",
            Scalar::Bool => "bool",
        };
        match self.width {
            1 => scalar.to_owned(),
            width => format!("vec{width}<{scalar}>"),
        }
    }

    fn of(self, scalar: Scalar) -> Self {
        Self { scalar, ..self }
    }
}

/// Invocations of a kernel, each with inputs of its own.
const INVOCATIONS: u32 = 32;
/// Words of input for each.
const INPUTS: u32 = 12;
/// Results of each function.
const RESULTS: u32 = 4;

/// Writes functions.
struct Writer {
    random: Random,
    /// Variables in scope, with what they hold; floats are at most 1000 in size.
    variables: Vec<(String, Type)>,
    names: u32,
    /// Loops around the place.
    loops: u32,
}

impl Writer {
    fn ty(&mut self) -> Type {
        let scalar = self.random.one_of(&[
            Scalar::F32,
            Scalar::F32,
            Scalar::I32,
            Scalar::U32,
            Scalar::Bool,
        ]);
        let width = self.random.one_of(&[1, 1, 2, 3, 4]);
        Type { scalar, width }
    }

    fn leaf(&mut self, ty: Type) -> String {
        let fitting: Vec<usize> = (0..self.variables.len())
            .filter(|&index| self.variables[index].1 == ty)
            .collect();
        if !fitting.is_empty() && self.random.below(4) > 0 {
            let index = self.random.one_of(&fitting);
            return self.variables[index].0.clone();
        }
        if ty.width > 1 {
            let scalar = Type { width: 1, ..ty };
            let parts: Vec<String> = (0..ty.width).map(|_| self.leaf(scalar)).collect();
            return format!("{}({})", ty.name(), parts.join(", "));
        }
        let input = self.random.below(4);
        match (ty.scalar, self.random.below(3)) {
            (Scalar::F32, 0) => format!("{:?}", self.random.below(2000) as f32 / 8.0 - 125.0),
            (Scalar::F32, _) => format!("floats[{input}]"),
            (Scalar::I32, 0) => format!(
                "i32({})",
                self.random
                    .one_of(&[0, 1, -1, 7, 31, -1000, 65536, i32::MAX])
            ),
            (Scalar::I32, _) => format!("signed[{input}]"),
            (Scalar::U32, 0) => {
                format!("{}u", self.random.one_of(&[0, 1, 3, 32, 33, 255, u32::MAX]))
            }
            (Scalar::U32, _) => format!("unsigned[{input}]"),
            (Scalar::Bool, 0) => self.random.one_of(&["true", "false"]).to_owned(),
            (Scalar::Bool, _) => format!("(unsigned[{input}] % 3u == 1u)"),
        }
    }

    /// An expression that is the same on all devices.
    fn exact(&mut self, ty: Type, depth: u32) -> String {
        if depth == 0 || self.random.below(6) == 0 {
            return self.leaf(ty);
        }
        let d = depth - 1;
        if self.random.below(8) == 0 {
            return self.any_type(ty, d);
        }
        match ty.scalar {
            Scalar::F32 => self.exact_float(ty, d),
            Scalar::Bool => self.exact_bool(ty, d),
            Scalar::I32 | Scalar::U32 => self.exact_int(ty, d),
        }
    }

    fn any_type(&mut self, ty: Type, d: u32) -> String {
        let bools = ty.of(Scalar::Bool);
        match self.random.below(if ty.width == 1 { 4 } else { 3 }) {
            0 => format!(
                "select({}, {}, {})",
                self.exact(ty, d),
                self.exact(ty, d),
                self.exact(bools, d)
            ),
            1 if ty.width > 1 => {
                let from = Type {
                    width: self.random.one_of(&[2, 3, 4]),
                    ..ty
                };
                let letters = &["x", "y", "z", "w"][..from.width as usize];
                let swizzle: String = (0..ty.width).map(|_| self.random.one_of(letters)).collect();
                format!("({}).{swizzle}", self.exact(from, d))
            }
            2 if ty.width > 1 => {
                let one = Type { width: 1, ..ty };
                let parts: Vec<String> = (0..ty.width).map(|_| self.exact(one, d)).collect();
                format!("{}({})", ty.name(), parts.join(", "))
            }
            _ => {
                let width = self.random.one_of(&[2, 3, 4]);
                let from = Type { width, ..ty };
                match ty.width {
                    1 => {
                        let index = self.exact(
                            Type {
                                scalar: Scalar::U32,
                                width: 1,
                            },
                            d,
                        );
                        format!("({})[({index}) % {width}u]", self.exact(from, d))
                    }
                    _ => self.leaf(ty),
                }
            }
        }
    }

    fn exact_float(&mut self, ty: Type, d: u32) -> String {
        let f = |writer: &mut Self| writer.exact(ty, d);
        let (a, b) = (f(self), f(self));
        // Kept small, so that nothing overflows.
        let kept = |x: String| format!("clamp({x}, {0}(-1000.0), {0}(1000.0))", ty.name());
        match self.random.below(16) {
            0..=2 => kept(format!("({a} + {b})")),
            3..=4 => kept(format!("({a} - {b})")),
            5..=7 => kept(format!("({a} * {b})")),
            8 => format!("(-{a})"),
            9 => format!(
                "{}({a})",
                self.random
                    .one_of(&["abs", "floor", "ceil", "trunc", "round", "fract", "sign"])
            ),
            10 => format!("{}({a}, {b})", self.random.one_of(&["min", "max", "step"])),
            11 => format!("clamp({a}, {0}(-4.0), {0}(4.0))", ty.name()),
            12 => {
                let ints = self.exact(ty.of(Scalar::I32), d);
                kept(format!("{}({ints})", ty.name()))
            }
            13 => {
                let ints = self.exact(ty.of(Scalar::U32), d);
                kept(format!("{}({ints})", ty.name()))
            }
            14 => {
                let bools = self.exact(ty.of(Scalar::Bool), d);
                format!("{}({bools})", ty.name())
            }
            _ if ty.width == 1 => {
                let width = self.random.one_of(&[2, 3, 4]);
                let vector = Type { width, ..ty };
                let (a, b) = (self.exact(vector, d), self.exact(vector, d));
                let whole = |x: String| {
                    format!("round(clamp({x}, vec{width}<f32>(-100.0), vec{width}<f32>(100.0)))")
                };
                kept(format!("dot({}, {})", whole(a), whole(b)))
            }
            _ => format!("saturate({a})"),
        }
    }

    fn exact_bool(&mut self, ty: Type, d: u32) -> String {
        let of = self.random.one_of(&[Scalar::F32, Scalar::I32, Scalar::U32]);
        let numbers = ty.of(of);
        match self.random.below(7) {
            0..=2 => {
                let (a, b) = (self.exact(numbers, d), self.exact(numbers, d));
                format!(
                    "({a} {} {b})",
                    self.random.one_of(&["<", "<=", ">", ">=", "==", "!="])
                )
            }
            3 => format!("(!{})", self.exact(ty, d)),
            4 => {
                let (a, b) = (self.exact(ty, d), self.exact(ty, d));
                format!("({a} {} {b})", self.random.one_of(&["&", "|", "==", "!="]))
            }
            5 => format!("{}({})", ty.name(), self.exact(numbers, d)),
            _ if ty.width == 1 => {
                let width = self.random.one_of(&[2, 3, 4]);
                let vector = Type { width, ..ty };
                let (a, b) = (self.exact(ty, d), self.exact(ty, d));
                let name = self.random.one_of(&["all", "any"]);
                let operator = self.random.one_of(&["&&", "||"]);
                format!(
                    "(({a} {operator} {b}) && {name}({}))",
                    self.exact(vector, d)
                )
            }
            _ => format!("(!{})", self.exact(ty, d)),
        }
    }

    fn exact_int(&mut self, ty: Type, d: u32) -> String {
        let (a, b) = (self.exact(ty, d), self.exact(ty, d));
        let name = ty.name();
        match self.random.below(16) {
            0..=3 => format!(
                "({a} {} {b})",
                self.random.one_of(&["+", "-", "*", "&", "|", "^"])
            ),
            4 => format!("({a} {} {b})", self.random.one_of(&["/", "%"])),
            5..=6 => {
                let by = self.exact(ty.of(Scalar::U32), d);
                let mask = ty.of(Scalar::U32).name();
                format!(
                    "({a} {} ({by} & {mask}(31u)))",
                    self.random.one_of(&["<<", ">>"])
                )
            }
            7 => format!("(~{a})"),
            8 if ty.scalar == Scalar::I32 => format!("(-{a})"),
            8..=9 => {
                let functions = [
                    "abs",
                    "countOneBits",
                    "countLeadingZeros",
                    "countTrailingZeros",
                    "reverseBits",
                    "firstLeadingBit",
                    "firstTrailingBit",
                ];
                format!("{}({a})", self.random.one_of(&functions))
            }
            10 => format!("{}({a}, {b})", self.random.one_of(&["min", "max"])),
            11 => format!(
                "extractBits({a}, {}u, {}u)",
                self.random.below(32),
                self.random.below(33)
            ),
            12 => format!(
                "insertBits({a}, {b}, {}u, {}u)",
                self.random.below(32),
                self.random.below(33)
            ),
            13 => {
                let other = match ty.scalar {
                    Scalar::I32 => Scalar::U32,
                    _ => Scalar::I32,
                };
                let cast = self.random.one_of(&["", "bitcast"]);
                let inner = self.exact(ty.of(other), d);
                match cast {
                    "" => format!("{name}({inner})"),
                    _ => format!("bitcast<{name}>({inner})"),
                }
            }
            14 => format!("{name}({})", self.exact(ty.of(Scalar::F32), d)),
            _ => format!("{name}({})", self.exact(ty.of(Scalar::Bool), d)),
        }
    }

    /// A float that devices approximate, and how far from each other they may be: relative, and absolute.
    fn approximate(&mut self) -> (String, f32, f32) {
        let one = Type {
            scalar: Scalar::F32,
            width: 1,
        };
        let three = Type { width: 3, ..one };
        let x = self.exact(one, 2);
        let y = self.exact(one, 2);
        let small = format!("clamp({x}, -8.0, 8.0)");
        let positive = format!("(abs({x}) + 0.125)");
        let unit = format!("clamp({x} * 0.001, -0.99, 0.99)");
        match self.random.below(20) {
            0 => (format!("({x} / {positive})"), 3e-7, 0.0),
            1 => (format!("sqrt({positive})"), 5e-7, 0.0),
            2 => (format!("inverseSqrt({positive})"), 1e-6, 0.0),
            // Lavapipe approximates sines to 2e-4.
            3 => (format!("sin({small})"), 0.0, 5e-4),
            4 => (format!("cos({small})"), 0.0, 5e-4),
            5 => (format!("tan({unit})"), 1e-3, 1e-3),
            6 => (format!("asin({unit})"), 1e-3, 1e-3),
            7 => (format!("acos({unit})"), 1e-3, 1e-3),
            8 => (format!("atan({x})"), 1e-4, 1e-4),
            9 => (format!("atan2({x}, {positive})"), 1e-4, 1e-4),
            10 => (format!("exp({small})"), 2e-5, 0.0),
            11 => (format!("exp2({small})"), 2e-5, 0.0),
            12 => (format!("log({positive})"), 2e-5, 2e-6),
            13 => (format!("log2({positive})"), 2e-5, 2e-6),
            14 => (format!("pow({positive}, clamp({y}, -2.0, 2.0))"), 1e-4, 0.0),
            15 => {
                let (a, b) = (self.exact(three, 2), self.exact(three, 2));
                let (name, scale) = self.random.one_of(&[("dot", 3e6), ("distance", 4e3)]);
                (format!("{name}({a}, {b})"), 2e-6, scale * 2e-7)
            }
            16 => {
                let (a, b) = (self.exact(three, 2), self.exact(three, 2));
                (format!("cross({a}, {b}).y"), 1e-6, 2e6 * 2e-7)
            }
            17 => {
                let a = self.exact(three, 2);
                (
                    format!("normalize({a} + vec3f(2000.0, 0.0, 0.0)).x"),
                    2e-6,
                    1e-6,
                )
            }
            18 => (format!("mix({x}, {y}, saturate({unit}))"), 1e-6, 1e3 * 3e-7),
            _ => (
                format!("(tanh({small}) + smoothstep(-3.0, 5.0, {y}))"),
                1e-4,
                1e-4,
            ),
        }
    }

    fn name(&mut self) -> String {
        self.names += 1;
        format!("v{}", self.names)
    }

    fn statements(&mut self, count: u32, depth: u32, text: &mut String) {
        for _ in 0..count {
            self.statement(depth, text);
        }
    }

    fn scope(&mut self, count: u32, depth: u32) -> String {
        let outer = self.variables.len();
        let mut text = String::new();
        self.statements(count, depth, &mut text);
        self.variables.truncate(outer);
        text
    }

    fn statement(&mut self, depth: u32, text: &mut String) {
        let one = |scalar| Type { scalar, width: 1 };
        match self.random.below(if depth > 0 { 10 } else { 5 }) {
            0..=1 => {
                let (ty, name) = (self.ty(), self.name());
                text.push_str(&format!("var {name} = {};\n", self.exact(ty, 3)));
                self.variables.push((name, ty));
            }
            2..=3 => {
                let candidates: Vec<_> = self.variables.clone();
                if candidates.is_empty() {
                    return;
                }
                let index = self.random.below(candidates.len() as u32) as usize;
                let (name, ty) = candidates[index].clone();
                if ty.width > 1 && self.random.below(2) == 0 {
                    let index = self.exact(one(Scalar::U32), 1);
                    let value = self.exact(Type { width: 1, ..ty }, 2);
                    text.push_str(&format!("{name}[({index}) % {}u] = {value};\n", ty.width));
                } else {
                    text.push_str(&format!("{name} = {};\n", self.exact(ty, 3)));
                }
            }
            4 => {
                // An array, written and read at computed places, which may be outside.
                let (ty, name, value) = (self.ty(), self.name(), self.name());
                let elements: Vec<String> = (0..5).map(|_| self.exact(ty, 1)).collect();
                let (at, from) = (
                    self.exact(one(Scalar::U32), 2),
                    self.exact(one(Scalar::I32), 2),
                );
                let write = self.exact(ty, 2);
                text.push_str(&format!(
                    "var {name} = array<{}, 5>({});\n{name}[{at}] = {write};\nvar {value} = {name}[{from}];\n",
                    ty.name(),
                    elements.join(", ")
                ));
                self.variables.push((value, ty));
            }
            5..=6 => {
                let condition = self.exact(one(Scalar::Bool), 3);
                let (accept, reject) = (self.scope(2, depth - 1), self.scope(2, depth - 1));
                text.push_str(&format!(
                    "if ({condition}) {{\n{accept}}} else {{\n{reject}}}\n"
                ));
            }
            7..=8 => {
                let (name, count) = (self.name(), self.exact(one(Scalar::U32), 1));
                self.loops += 1;
                let body = self.scope(2, depth - 1);
                self.loops -= 1;
                let condition = self.exact(one(Scalar::Bool), 2);
                let leave = self.random.one_of(&["break", "continue"]);
                text.push_str(&format!(
                    "for (var {name} = 0u; {name} < ({count}) % 7u; {name}++) {{\n{body}if ({condition}) {{ {leave}; }}\n}}\n"
                ));
            }
            _ => {
                let selector = self.exact(one(Scalar::U32), 2);
                let cases: Vec<String> = (0..3).map(|_| self.scope(1, depth - 1)).collect();
                let leave = if self.random.below(2) == 0 {
                    "break;"
                } else {
                    ""
                };
                text.push_str(&format!(
                    "switch ({selector}) % 5u {{\ncase 0u, 3u: {{\n{}{leave}}}\ncase 1u: {{\n{}}}\ndefault: {{\n{}}}\n}}\n",
                    cases[0], cases[1], cases[2]
                ));
            }
        }
    }

    /// A function, and how far its results may differ.
    fn function(&mut self, number: u32) -> (String, Vec<(f32, f32)>) {
        self.variables.clear();
        let mut text = String::new();
        self.statements(5, 2, &mut text);
        let mut tolerances = Vec::new();
        let mut results = Vec::new();
        for _ in 0..RESULTS {
            if self.random.below(3) == 0 {
                let (expression, relative, absolute) = self.approximate();
                results.push(format!("bitcast<u32>({expression})"));
                tolerances.push((relative, absolute));
            } else {
                let scalar =
                    self.random
                        .one_of(&[Scalar::F32, Scalar::I32, Scalar::U32, Scalar::Bool]);
                let expression = self.exact(Type { scalar, width: 1 }, 4);
                results.push(match scalar {
                    Scalar::Bool => format!("u32({expression})"),
                    _ => format!("bitcast<u32>({expression})"),
                });
                tolerances.push((0.0, 0.0));
            }
        }
        let early = self.exact(
            Type {
                scalar: Scalar::Bool,
                width: 1,
            },
            2,
        );
        let text = format!(
            "fn f{number}(floats: vec4f, signed: vec4i, unsigned: vec4u) -> vec4u {{\n{text}
             if ({early}) {{ return vec4u({0}, 0u, 0u, 1u); }}\nreturn vec4u({1});\n}}\n",
            results[0],
            results.join(", ")
        );
        (text, tolerances)
    }
}

/// Inputs of all invocations: floats, signed and unsigned integers.
fn inputs(random: &mut Random) -> Vec<u32> {
    let mut words = Vec::new();
    for _ in 0..INVOCATIONS {
        for _ in 0..4 {
            // Quarters, and some that aren't.
            let quarters = random.below(800) as f32 / 4.0 - 100.0;
            let any = random.next() as f32 / u32::MAX as f32 * 10.0 - 5.0;
            words.push(random.one_of(&[quarters, any, 0.0, 1.0]).to_bits());
        }
        for _ in 0..8 {
            let (any, few) = (random.next(), random.below(40));
            words.push(random.one_of(&[any, few, few.wrapping_neg(), 0, 0x8000_0000, u32::MAX]));
        }
    }
    words
}

/// Floats that are less than any that is represented fully count as zero: devices differ.
fn flushed(bits: u32) -> f32 {
    let x = f32::from_bits(bits);
    if x.is_subnormal() { 0.0 } else { x }
}

fn agrees(a: u32, b: u32, (relative, absolute): (f32, f32)) -> bool {
    if a == b {
        return true;
    }
    let (x, y) = (flushed(a), flushed(b));
    // Zeros may have either sign.
    x == y && x == 0.0
        || relative + absolute > 0.0
            && ((x - y).abs() <= relative * x.abs().max(y.abs()) + absolute
                || x.is_nan() && y.is_nan())
}

/// A kernel that calls so many functions, what it reads, and how far each of its results may be off elsewhere.
fn kernel(seed: u64, functions: u32) -> (String, Vec<u32>, Vec<(f32, f32)>) {
    let mut writer = Writer {
        random: Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1),
        variables: Vec::new(),
        names: 0,
        loops: 0,
    };
    let (mut text, mut calls, mut tolerances) = (HEAD.to_owned(), String::new(), Vec::new());
    for number in 0..functions {
        // Constants that overflow or divide by zero are no valid WGSL.
        let (function, of) = loop {
            let written = writer.function(number);
            if try_parse(&written.0).is_ok() {
                break written;
            }
        };
        text.push_str(&function);
        tolerances.extend(of);
        let at = number * RESULTS;
        calls.push_str(&format!(
            "{{ let r = f{number}(floats, signed, unsigned); let at = id.x * {0}u + {at}u;
             output[at] = r.x; output[at + 1u] = r.y; output[at + 2u] = r.z; output[at + 3u] = r.w; }}\n",
            functions * RESULTS
        ));
    }
    text.push_str(&format!(
        "@compute @workgroup_size({INVOCATIONS}) fn main(@builtin(global_invocation_id) id: vec3u) {{
         let at = id.x * {INPUTS}u;
         let unsigned = vec4u(input[at + 8u], input[at + 9u], input[at + 10u], input[at + 11u]);
         let signed = bitcast<vec4i>(vec4u(input[at + 4u], input[at + 5u], input[at + 6u], input[at + 7u]));
         let floats = bitcast<vec4f>(vec4u(input[at], input[at + 1u], input[at + 2u], input[at + 3u]));\n{calls}}}\n"
    ));
    let input = inputs(&mut writer.random);
    (text, input, tolerances)
}

/// Compares so many functions in one kernel; the first that differs.
fn compare(gpu: &Gpu, seed: u64, functions: u32) -> Result<(), String> {
    let (text, input, tolerances) = kernel(seed, functions);
    let outputs = (INVOCATIONS * functions * RESULTS) as usize;
    let separate = seed % 2 == 1;
    let options = Options {
        separate: &|_| separate,
        ..Options::default()
    };
    let kernel = compile(&text, &options).map_err(|error| format!("{text}\n{error}"))?;
    let native = run(&kernel, &input, outputs, 1);
    let other = gpu.run(&text, &input, outputs, 1);
    let columns = (functions * RESULTS) as usize;
    for (index, (&a, &b)) in native.iter().zip(&other).enumerate() {
        // A function that returned early has no approximate results but the first.
        if !agrees(a, b, tolerances[index % columns]) {
            let (invocation, result) = (index / columns, index % columns);
            let number = result / RESULTS as usize;
            let start = text.find(&format!("fn f{number}(")).unwrap_or_default();
            let end = text[start..]
                .find("\nfn ")
                .or(text[start..].find("@compute"));
            let function = &text[start..start + end.unwrap_or(text.len() - start)];
            let first = invocation * INPUTS as usize;
            let input = &input[first..first + INPUTS as usize];
            let (x, y) = (f32::from_bits(a), f32::from_bits(b));
            return Err(format!(
                "seed {seed}, result {} of invocation {invocation}: natively {a} ({x}), elsewhere {b} ({y})\ninput {input:?}\n{function}",
                result % RESULTS as usize
            ));
        }
    }
    Ok(())
}

/// Compares so many functions with themselves in lanes, apart and inlined.
#[cfg(target_arch = "x86_64")]
fn compare_in_lanes(seed: u64, functions: u32) -> Result<(), String> {
    let (text, input, _) = kernel(seed, functions);
    let outputs = (INVOCATIONS * functions * RESULTS) as usize;
    let separate = seed % 2 == 1;
    let options = Options {
        separate: &|_| separate,
        ..Options::default()
    };
    let alone = compile(&text, &options).map_err(|error| format!("{text}\n{error}"))?;
    let in_lanes = alone.clone();
    let expected = run(&alone, &input, outputs, 1);
    let (module, info) = parse(&text);
    let added = in_lanes.add_lanes(&module, &info, "main", &[], &options, &|_| false);
    added.map_err(|error| format!("seed {seed}: {error}\n{text}"))?;
    let found = run(&in_lanes, &input, outputs, 1);
    // What isn't a number has many bits.
    let is_same =
        |a: u32, b: u32| a == b || f32::from_bits(a).is_nan() && f32::from_bits(b).is_nan();
    let mut both = found.iter().zip(&expected);
    let columns = (functions * RESULTS) as usize;
    match both.position(|(&a, &b)| !is_same(a, b)) {
        None => Ok(()),
        Some(at) => Err(format!(
            "seed {seed}, f{}, invocation {}: {:?} in lanes, else {:?}\n{text}",
            at % columns / RESULTS as usize,
            at / columns,
            found[at],
            expected[at]
        )),
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn random_functions_are_the_same_in_lanes() {
    let functions = match std::env::var_os("PATINA_FULL") {
        Some(_) => 10_000,
        None => 320,
    };
    const AT_ONCE: u32 = 8;
    let mut failures = Vec::new();
    for seed in 0..u64::from(functions / AT_ONCE) {
        failures.extend(compare_in_lanes(seed, AT_ONCE).err());
        if !failures.is_empty() {
            break;
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn random_functions_agree_with_another_device() {
    let Some(gpu) = gpu() else { return };
    let functions = match std::env::var_os("PATINA_FULL") {
        Some(_) => 10_000,
        None => 240,
    };
    const AT_ONCE: u32 = 8;
    let mut failures = Vec::new();
    for seed in 0..u64::from(functions / AT_ONCE) {
        failures.extend(compare(gpu, seed, AT_ONCE).err());
        if failures.len() > 3 {
            break;
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}
