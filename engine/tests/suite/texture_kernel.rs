//! The generated texture kernel on a real device: what programs compute is what the language's page promises.
//! Skipped with a notice where there is no adapter.

use std::sync::Arc;

use ::device::{Device, DeviceError, Extent, Recording, Resources, Trust, Usage};
use engine::passes::wgsl::ComposedWgsl;
use texgen::{
    Graph, HOST_STUB, Interpolation, Library, NodeId, Ramp, SourceFile, Swizzle, TextureType,
    Value, emit_inlined,
};

use crate::support::device;

const TEXTURES: &[(&str, &str)] = &[
    (
        "ramp",
        "fn userProc(r: ramp1D, t: f32) -> vec4f { return rampEval(r, t); }",
    ),
    (
        "array",
        "fn userProc(a: array<vec3f, 3>, i: i32, k: u32, b: bool) -> vec3f {
            var copy = a;
            return a[i] + copy[k] * select(1.0, 10.0, b);
        }",
    ),
    (
        "arrays",
        "fn sum(a: array<mat3x3f, 2>, i: i32) -> f32 { return a[i][2].y; }
        fn userProc(a: array<f32, 2>, b: array<i32, 2>, c: array<u32, 2>, d: array<bool, 2>, e: array<vec2f, 2>,
                    f: array<vec4f, 2>, g: array<mat3x3f, 2>, h: array<mat4x4f, 2>, i: i32) -> vec4f {
            let u32 = g;
            let whole = h;
            return vec4f(
                a[i] + f32(b[i]) * 10.0 + f32(c[i]) * 100.0,
                select(0.0, 1.0, d[i]) + e[i].y * 10.0,
                f[i].w + g[i][2].y * 10.0 + sum(u32, i) * 100.0,
                h[i][3].x + whole[i][1].z * 10.0,
            );
        }",
    ),
    (
        "matrix",
        "fn userProc(m: mat3x3f, n: mat4x4f) -> vec3f { return m * vec3f(1.0, 2.0, 3.0) + (n * vec4f(1.0)).xyz; }",
    ),
    ("one", "fn userProc(x: f32) -> f32 { return x; }"),
    ("two", "fn userProc(x: vec2f) -> vec2f { return x; }"),
    ("three", "fn userProc(x: vec3f) -> vec3f { return x; }"),
    (
        "four",
        "fn userProc(a: vec4f, b: vec4f) -> vec4f { return a * 10.0 + b; }",
    ),
    ("bits", "fn userProc(x: u32) -> f32 { return bitcast<f32>(x); }"),
    (
        "endless",
        "fn userProc(x: f32) -> f32 { var s = x; while x > 0.0 { s += 1.0; } return s; }",
    ),
    (
        "occluded",
        "fn userProc(x: f32) -> f32 { return 100.0 * x + 10.0 * readAttr(AO).x + readAttr(AO1).x; }",
    ),
    (
        "members",
        "struct Inner { m: mat2x2f, list: array<f32, 3> }
        struct Outer { x: f32, v: vec2f, inner: Inner }
        fn add(a: ptr<function, f32>, b: f32) -> f32 { *a += b; return *a; }
        fn turn(v: ptr<function, vec2f>) { *v = vec2f(-(*v).y, (*v).x); }
        fn both(o: ptr<function, Outer>, i: i32) { turn(&(*o).v); _ = add(&o.inner.list[i], 10.0); }
        fn userProc(x: f32, i: i32) -> vec4f {
            var o = Outer(x, vec2f(1.0, 2.0), Inner(mat2x2f(1.0, 2.0, 3.0, 4.0), array<f32, 3>(5.0, 6.0, 7.0)));
            let sum = add(&o.x, 1.0);
            both(&o, i);
            turn(&o.inner.m[1]);
            return vec4f(o.x + sum, o.v.x * 10.0 + o.v.y, o.inner.m[1].x * 10.0 + o.inner.m[0].x,
                o.inner.list[0] + o.inner.list[1] * 100.0 + o.inner.list[2] * 10000.0);
        }",
    ),
    (
        "elements",
        "fn next(n: ptr<function, i32>) -> i32 { *n += 1; return *n; }
        fn double(a: ptr<function, f32>) { *a *= 2.0; }
        fn swap(a: ptr<function, f32>, b: ptr<function, f32>) { let t = *a; *a = *b; *b = t; }
        fn userProc(x: f32) -> vec4f {
            var n = 0;
            var p = array<array<f32, 2>, 2>(array<f32, 2>(x, 2.0), array<f32, 2>(3.0, 4.0));
            // The index is computed once.
            double(&p[next(&n)][0]);
            for (var i = 0; i < 3; i++) { double(&p[0][i % 2]); }
            var q = array<f32, 2>(5.0, 8.0);
            swap(&p[0][1], &q[1]);
            return vec4f(p[0][0], p[0][1], p[1][0], q[1]) + f32(n) * 100.0;
        }",
    ),
    (
        "several",
        "struct Several { first: f32, pair: vec2f, color: vec3f, all: vec4f }
        fn userProc(x: f32) -> Several {
            return Several(x, vec2f(x + 1.0, x + 2.0), vec3f(x, 2.0 * x, 3.0 * x), vec4f(x, x, x, 9.0));
        }",
    ),
    (
        "gathered",
        "fn userProc(a: vec2f, b: vec3f, c: f32, d: f32) -> vec4f { return vec4f(a.x + b.x, a.y + b.y, c, d); }",
    ),
];

/// A graph, and what each of some nodes must give.
struct Case {
    graph: Graph,
    expected: Vec<(NodeId, [f32; 4])>,
}

impl Case {
    fn new() -> Self {
        let textures = TEXTURES
            .iter()
            .map(|&(name, text)| {
                TextureType::parse(SourceFile::new(name, name, text))
                    .unwrap_or_else(|problems| panic!("{problems}"))
            })
            .collect();
        let library = Library::new(textures).expect("names differ");
        Self {
            graph: Graph::new(Arc::new(library)),
            expected: Vec::new(),
        }
    }

    /// Adds a node with these values.
    fn node(&mut self, texture: &str, occlusion: [u32; 2], values: &[(&str, Value)]) -> NodeId {
        let name = format!("{texture} {}", self.graph.ids().len());
        let node = self
            .graph
            .add_node(&name, texture, occlusion)
            .expect("a known texture");
        for (parameter, value) in values {
            self.graph
                .set_value(node, parameter, value.clone())
                .unwrap_or_else(|error| panic!("{error}"));
        }
        node
    }

    fn link(&mut self, node: NodeId, parameter: &str, source: NodeId, swizzle: &str) {
        let swizzle: Option<Swizzle> =
            (!swizzle.is_empty()).then(|| swizzle.parse().expect("a swizzle"));
        self.graph
            .set_link(node, parameter, source, swizzle)
            .unwrap_or_else(|error| panic!("{error}"));
    }

    fn expect(&mut self, node: NodeId, value: [f32; 4]) {
        self.expected.push((node, value));
    }
}

#[test]
fn outputs_of_one_node_reach_what_takes_them_by_name() {
    let mut case = Case::new();
    let source = case.node("several", [0, 0], &[("x", Value::F32(3.0))]);
    let other = case.node("several", [0, 0], &[]);
    case.link(other, "x", source, "color.b");
    let gathered = case.node("gathered", [0, 0], &[]);
    case.link(gathered, "a", source, "pair");
    case.link(gathered, "b", other, "color");
    case.link(gathered, "c", other, "all.w");
    case.link(gathered, "d", other, "");
    case.expect(gathered, [4.0 + 9.0, 5.0 + 18.0, 9.0, 9.0]);
    case.expect(other, [9.0; 4]);
    for form in [Form::Stack, Form::Inlined] {
        let Some((results, _)) = run(&case, form) else {
            return;
        };
        for ((node, expected), result) in case.expected.iter().zip(&results) {
            assert_eq!(result, expected, "{form:?}: {}", case.graph.name(*node));
        }
    }
}

#[test]
fn programs_compute_what_the_language_promises() {
    let mut case = Case::new();

    let stops = vec![
        (1.0, [1.0, 2.0, 3.0, 4.0]),
        (0.0, [0.0; 4]),
        (0.5, [1.0; 4]),
        (0.5, [2.0; 4]),
    ];
    for (interpolation, t, value) in [
        (Interpolation::Linear, 0.25, [0.5; 4]),
        (Interpolation::Linear, -1.0, [0.0; 4]),
        (Interpolation::Linear, 0.5, [2.0; 4]),
        (Interpolation::Linear, 0.75, [1.5, 2.0, 2.5, 3.0]),
        (Interpolation::Linear, 9.0, [1.0, 2.0, 3.0, 4.0]),
        (Interpolation::Smooth, 0.125, [0.15625; 4]),
        (Interpolation::Constant, 0.4, [0.0; 4]),
        (Interpolation::Constant, 0.9, [2.0; 4]),
    ] {
        let ramp = Ramp {
            stops: stops.clone(),
            interpolation,
        };
        let node = case.node(
            "ramp",
            [0, 0],
            &[("r", Value::Ramp(ramp)), ("t", Value::F32(t))],
        );
        case.expect(node, value);
    }

    let rows = Value::Array(
        [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]
            .map(Value::Vec3)
            .to_vec(),
    );
    for (i, k, b, value) in [
        (0, 2, false, [8.0, 10.0, 12.0, 1.0]),
        (2, 0, true, [17.0, 28.0, 39.0, 1.0]),
        // Beyond the end: the last element.
        (7, 0, false, [8.0, 10.0, 12.0, 1.0]),
        (-1, 0, false, [8.0, 10.0, 12.0, 1.0]),
    ] {
        let values = [
            ("a", rows.clone()),
            ("i", Value::I32(i)),
            ("k", Value::U32(k)),
            ("b", Value::Bool(b)),
        ];
        let node = case.node("array", [0, 0], &values);
        case.expect(node, value);
    }

    let all = |of: fn(f32) -> Value| Value::Array(vec![of(1.0), of(2.0)]);
    let values = [
        ("a", all(Value::F32)),
        ("b", all(|x| Value::I32(-x as i32))),
        ("c", all(|x| Value::U32(x as u32 + 5))),
        ("d", all(|x| Value::Bool(x > 1.5))),
        ("e", all(|x| Value::Vec2([0.0, x]))),
        ("f", all(|x| Value::Vec4([0.0, 0.0, 0.0, x]))),
        (
            "g",
            all(|x| Value::Mat3([[0.0; 3], [0.0; 3], [0.0, x, 0.0]])),
        ),
        (
            "h",
            all(|x| {
                let [mut y, mut w] = [[0.0; 4]; 2];
                (y[2], w[0]) = (x + 2.0, x + 6.0);
                Value::Mat4([[0.0; 4], y, [0.0; 4], w])
            }),
        ),
        ("i", Value::I32(1)),
    ];
    let arrays = case.node("arrays", [0, 0], &values);
    case.expect(arrays, [682.0, 21.0, 222.0, 48.0]);

    let columns = [[1.0, 0.0, 2.0], [0.0, 1.0, 0.0], [0.0, 5.0, 1.0]];
    let more = [[1.0; 4], [0.0; 4], [0.0; 4], [2.0, 0.0, 0.0, 0.0]];
    let matrix = case.node(
        "matrix",
        [0, 0],
        &[("m", Value::Mat3(columns)), ("n", Value::Mat4(more))],
    );
    case.expect(matrix, [4.0, 18.0, 6.0, 1.0]);

    // Links: without and with swizzles, widened, chained, rounded.
    let one = case.node("one", [0, 0], &[("x", Value::F32(7.0))]);
    case.expect(one, [7.0; 4]);
    let two = case.node("two", [0, 0], &[("x", Value::Vec2([3.0, 4.0]))]);
    case.expect(two, [3.0, 4.0, 0.0, 1.0]);
    let three = case.node("three", [0, 0], &[]);
    case.link(three, "x", one, "");
    case.expect(three, [7.0, 7.0, 7.0, 1.0]);
    let four = case.node("four", [0, 0], &[]);
    case.link(four, "a", matrix, "zyx");
    case.link(four, "b", one, "");
    case.expect(four, [67.0, 187.0, 47.0, 17.0]);
    let again = case.node("four", [0, 0], &[]);
    case.link(again, "a", four, "wxyz");
    case.link(again, "b", two, "y");
    case.expect(again, [174.0, 674.0, 1874.0, 474.0]);
    let pair = case.node("two", [0, 0], &[]);
    case.link(pair, "x", four, "wz");
    case.expect(pair, [17.0, 47.0, 0.0, 1.0]);
    let rounded = case.node("one", [0, 0], &[("x", Value::F32(1.6))]);
    let linked = case.node("array", [0, 0], &[("a", rows)]);
    case.link(linked, "i", rounded, "");
    case.link(linked, "b", rounded, "x");
    case.expect(linked, [17.0, 28.0, 39.0, 1.0]);

    // AO slots belong to nodes: the stub's AO of slot s is s.
    let inner = case.node("occluded", [2, 3], &[]);
    let outer = case.node("occluded", [1, 0], &[]);
    case.link(outer, "x", inner, "");
    case.expect(outer, [2310.0; 4]);

    for form in [Form::Stack, Form::Inlined] {
        check(&case, form);
    }
}

#[test]
fn pointers_to_parts_of_variables_change_those_parts() {
    let mut case = Case::new();
    for (i, list) in [(0, 70_615.0), (1, 71_605.0), (2, 170_605.0)] {
        let values = [("x", Value::F32(2.0)), ("i", Value::I32(i))];
        let node = case.node("members", [0, 0], &values);
        case.expect(node, [6.0, -19.0, -39.0, list]);
    }
    let elements = case.node("elements", [0, 0], &[("x", Value::F32(1.0))]);
    case.expect(elements, [104.0, 108.0, 106.0, 104.0]);
    for form in [Form::Stack, Form::Inlined] {
        check(&case, form);
    }
}

/// Runs a case and compares its results; nothing may have been cut.
fn check(case: &Case, form: Form) {
    let Some((results, faults)) = run(case, form) else {
        return;
    };
    for ((node, expected), result) in case.expected.iter().zip(&results) {
        for (found, wanted) in result.iter().zip(expected) {
            // Sums and products of small numbers: one rounding of a fused operation at most.
            assert!(
                (found - wanted).abs() <= 1e-5 * wanted.abs(),
                "{}: {result:?} instead of {expected:?}",
                case.graph.name(*node)
            );
        }
    }
    assert_eq!(faults, [0.0; 2]);
}

#[test]
fn an_endless_loop_is_cut_and_reported() {
    let mut case = Case::new();
    let endless = case.node("endless", [0, 0], &[("x", Value::F32(1.0))]);
    case.expect(endless, [0.0; 4]);
    let after = case.node("one", [0, 0], &[("x", Value::F32(3.0))]);
    case.expect(after, [3.0; 4]);
    let Some((results, [overrun, _])) = run(&case, Form::Stack) else {
        return;
    };
    assert_eq!(
        results,
        [[0.0; 4], [3.0; 4]],
        "the rest of the program runs"
    );
    let number = case.graph.library().index_of("endless").expect("known");
    assert_eq!(overrun, number as f32 + 1.0);
}

#[test]
fn the_first_node_whose_result_is_not_finite_is_told() {
    for bits in [0x7fc0_0000, 0x7f80_0000, 0xff80_0000] {
        let mut case = Case::new();
        let sound = case.node("one", [0, 0], &[("x", Value::F32(2.0))]);
        let broken = case.node("bits", [0, 0], &[("x", Value::U32(bits))]);
        let reader = case.node("four", [0, 0], &[]);
        case.link(reader, "a", sound, "");
        case.link(reader, "b", broken, "");
        case.expect(reader, [0.0; 4]);
        for form in [Form::Stack, Form::Inlined] {
            let Some((_, [_, told])) = run(&case, form) else {
                return;
            };
            let place = case.graph.block(broken).start;
            assert_eq!(told, place as f32 + 1.0, "{form:?}, {bits:#x}");
        }
    }
}

/// How the kernel comes to the textures.
#[derive(Clone, Copy, Debug)]
enum Form {
    Stack,
    Inlined,
}

/// Runs the program of all expected nodes in one thread; their results, and the kernel's `patina_overrun` and
/// `patina_non_finite`. The graph is data, or pasted into the kernel.
fn run(case: &Case, form: Form) -> Option<(Vec<[f32; 4]>, [f32; 2])> {
    let device = device::open()?;
    let roots: Vec<NodeId> = case.expected.iter().map(|&(node, _)| node).collect();
    let program = case.graph.compile(&roots).expect("no image is missing");
    let library = case.graph.library();
    let kernel = match form {
        Form::Stack => library.emit(program.slots_needed),
        Form::Inlined => {
            let kernel = emit_inlined(
                &case.graph,
                &[roots.iter().map(|&root| root.into()).collect()],
            );
            kernel.expect("no image is missing")
        }
    };
    let slots = match form {
        Form::Inlined => (0..roots.len() as u32).collect(),
        _ => program.results.clone(),
    };
    let mut text = ComposedWgsl::default();
    text.text.push_str(&host(&kernel.wgsl, &slots));
    let size = 16 * (roots.len() as u64 + 1);
    let results = read_back(&device, &text, &program.words, case.graph.args(), size);
    let mut rows = results.unwrap_or_else(|error| panic!("{error}"));
    let [overrun, non_finite, ..] = rows.pop().expect("one row more than roots");
    Some((rows, [overrun, non_finite]))
}

/// Runs the kernel in one thread; the `size` bytes of its results.
fn read_back(
    device: &Device,
    text: &ComposedWgsl,
    program: &[u32],
    args: &[u32],
    size: u64,
) -> Result<Vec<[f32; 4]>, DeviceError> {
    let kernel = text.compile(device, "main", Trust::Loops, &[])?;
    let mut resources = Resources::default();
    for (name, words) in [("program", program), ("args", args)] {
        let bytes = bytemuck::cast_slice(words);
        resources.set_buffer(name, device.filled_buffer(name, Usage::Storage, bytes)?);
    }
    resources.set_buffer("results", device.buffer("results", Usage::Storage, size)?);
    let mut recording = Recording::new("textures");
    recording.dispatch(&kernel.bind(device, &resources), Extent::One);
    device.play(&recording)?;
    let bytes = device.read(resources.buffer("results"), 0, size)?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// The kernel with a host that reads the two buffers, gives slot numbers as AO, and stores all results.
fn host(kernel: &str, results: &[u32]) -> String {
    let mut stub = HOST_STUB.to_owned();
    for (old, new) in [
        (
            "fn patina_program_word(i: u32) -> u32 { return 0u; }",
            "@group(0) @binding(0) var<storage> program: array<u32>;
             fn patina_program_word(i: u32) -> u32 { return program[i]; }",
        ),
        (
            "fn patina_arg_word(i: u32) -> u32 { return 0u; }",
            "@group(0) @binding(1) var<storage> args: array<u32>;
             fn patina_arg_word(i: u32) -> u32 { return args[i]; }",
        ),
        (
            "fn patina_attr_AO(slot: u32) -> vec4f { return vec4f(0.0); }",
            "fn patina_attr_AO(slot: u32) -> vec4f { return vec4f(f32(slot)); }",
        ),
    ] {
        assert!(stub.contains(old), "the stub has changed: {old}");
        stub = stub.replace(old, new);
    }
    let stores: String = results
        .iter()
        .enumerate()
        .map(|(row, slot)| format!("    results[{row}] = patina_link({slot}u);\n"))
        .collect();
    format!(
        "{kernel}\n{stub}
@group(0) @binding(2) var<storage, read_write> results: array<vec4f>;
@compute @workgroup_size(1) fn main() {{
    // The inlined kernel needs no program buffer: named here, it still is a binding.
    patina_run_program(program[0] * 0u + args[0] * 0u);
{stores}    results[{}] = vec4f(f32(patina_overrun), f32(patina_non_finite), 0.0, 0.0);
}}",
        results.len()
    )
}
