//! Control flow, memory, functions, workgroups, textures: small programs whose results are known.

use device::native::{
    buffer::Buffer,
    compile::{BindError, BindingKind, Cache, ErrorKind, Kernel, Options, Resource},
    image::{Format, Image},
};

use crate::support::{HEAD, compile, parse, run, single};

fn output(declarations: &str, body: &str, input: &[u32], outputs: usize) -> Vec<u32> {
    let text = single(declarations, body);
    let kernel =
        compile(&text, &Options::default()).unwrap_or_else(|error| panic!("{text}: {error}"));
    run(&kernel, input, outputs, 1)
}

#[test]
fn loops_and_switches() {
    let body = "
        var sum = 0u;
        for (var i = 0u; i < input[0]; i++) {
            if (i == 3u) { continue; }
            switch i {
                case 0u: { sum += 100u; }
                case 1u, 2u: { if (i == 2u) { break; } sum += 10u; }
                case 5u: { sum += 1000u; continue; }
                default: { sum += 1u; }
            }
            if (i >= 7u) { break; }
        }
        output[0] = sum;
        var n = input[0];
        loop {
            n = n / 2u;
            continuing { output[1] += 1u; break if n == 0u; }
        }
        while (true) { n += 1u; if (n > 5u) { break; } }
        output[2] = n;";
    assert_eq!(output("", body, &[20], 3), [100 + 10 + 1000 + 3, 5, 6]);
    // What is known when the kernel is compiled leaves only one side.
    let body = "const two = 2; switch two { case 1: { output[0] = 1u; } case 2: { output[0] = 2u; } default: {} }";
    assert_eq!(output("", body, &[0], 1), [2]);
}

#[test]
fn functions_return_from_anywhere() {
    let declarations = "
        struct Pair { a: u32, b: vec2f }
        fn find(limit: u32) -> Pair {
            for (var i = 0u; i < 10u; i++) {
                if (input[i] > limit) { return Pair(i, vec2f(f32(i), 1.0)); }
            }
            return Pair(99u, vec2f(0.0));
        }
        fn add(to: ptr<function, Pair>, amount: u32) { if (amount == 0u) { return; } (*to).a += amount; (*to).b.y += 1.0; }
        fn element(all: ptr<function, array<u32, 4>>, i: u32) -> u32 { (*all)[i] += 1u; return (*all)[i]; }";
    let body = "
        var pair = find(6u); add(&pair, 5u); add(&pair, 0u);
        output[0] = pair.a; output[1] = u32(pair.b.x) * 10u + u32(pair.b.y);
        output[2] = find(1000u).a;
        var all = array<u32, 4>(10u, 20u, 30u, 40u);
        output[3] = element(&all, input[1]) + element(&all, input[1]);";
    let input = [1, 3, 5, 7, 9, 9, 9, 9, 9, 9];
    let expected = [8, 32, 99, 41 + 42];
    assert_eq!(output(declarations, body, &input, 4), expected);
    // The same with each of them compiled apart.
    let options = Options {
        separate: &|_| true,
        ..Options::default()
    };
    let kernel = compile(&single(declarations, body), &options).expect("compiles");
    assert_eq!(kernel.statistics().functions, 4);
    assert_eq!(run(&kernel, &input, 4, 1), expected);
}

#[test]
fn private_variables_start_anew() {
    let text = format!(
        "{HEAD}
        var<private> count: u32 = 3u;
        var<private> seen: array<u32, 100>;
        fn step(i: u32) -> u32 {{ count += 1u; seen[i] += 1u; return count + 10u * seen[i]; }}
        @compute @workgroup_size(4) fn main(@builtin(global_invocation_id) id: vec3u) {{
            output[id.x] = step(id.x) + 1000u * step(id.x);
        }}"
    );
    for separate in [false, true] {
        let options = Options {
            separate: &|_| separate,
            ..Options::default()
        };
        let kernel = compile(&text, &options).expect("compiles");
        assert_eq!(run(&kernel, &[0], 8, 2), [25014; 8]);
    }
}

#[test]
fn values_are_indexed() {
    let declarations = "
        const TABLE = array<f32, 6>(1.0, 2.0, 4.0, 8.0, 16.0, 32.0);
        struct Row { a: vec3f, b: array<u32, 3> }";
    let body = "
        output[0] = u32(TABLE[input[0]]);
        let computed = array<u32, 5>(input[0], input[1], 7u, 8u, 9u);
        output[1] = computed[input[1]];
        var rows = array<Row, 2>(Row(vec3f(1.0, 2.0, 3.0), array(4u, 5u, 6u)), Row(vec3f(7.0), array(8u, 9u, 10u)));
        rows[input[2]].b[input[1]] += 100u;
        rows[1].a.z = 0.5;
        rows[0].a[input[2]] *= 2.0;
        output[2] = rows[1].b[2] + rows[0].b[2];
        output[3] = u32(rows[0].a.y * 10.0 + rows[1].a.z * 2.0);
        var m = mat3x3f(); m[input[1]][input[2]] = 5.0; m[2] += vec3f(1.0);
        output[4] = u32(m[2][1] + m[2].x + m[0][0]);
        let copy = rows; output[5] = copy[1].b[1];
        var truths = array<vec3<bool>, 3>(); truths[input[1]] = vec3(true); truths[input[2]].y = true;
        output[7] = u32(any(truths[0])) + 10u * u32(truths[1].y) + 100u * u32(all(truths[2])) + 1000u * u32(truths[1].z);
        var v = vec4u(1u, 2u, 3u, 4u); v[input[1]] = 9u; output[6] = v.x + 10u * v.z;";
    let expected = [16, 7, 110 + 6, 41, 7, 9, 91, 110];
    assert_eq!(output(declarations, body, &[4, 2, 1], 8), expected);
}

#[test]
fn indices_are_restricted() {
    let body = "
        let far = input[0];
        output[far] = 5u;
        output[0] = input[far];
        var own = array<u32, 3>(1u, 2u, 3u);
        own[far] = 9u;
        output[1] = own[2] * 10u + own[far + 1u];
        output[2] = arrayLength(&input) * 10u + arrayLength(&output);
        output[3] = vec3u(1u, 2u, 3u)[far] + mat2x2f(1.0, 2.0, 3.0, 4.0)[far].x == 6.0;";
    let body = body.replace(
        "vec3u(1u, 2u, 3u)[far] + mat2x2f(1.0, 2.0, 3.0, 4.0)[far].x == 6.0",
        "vec3u(1u, 2u, 3u)[far] + u32(mat2x2f(1.0, 2.0, 3.0, 4.0)[far].x)",
    );
    // -1 as an index is as far away as can be.
    for far in [1000, 0x4000_0000, u32::MAX - 1] {
        let found = output("", &body, &[far, 7], 5);
        assert_eq!(found, [7, 99, 25, 6, 5], "index {far}");
    }
}

#[test]
fn constant_indices_of_short_buffers_are_restricted() {
    let kernel = compile(&single("", "output[3] = input[9];"), &Options::default());
    assert_eq!(run(&kernel.expect("compiles"), &[1, 2], 2, 1), [0, 2]);
}

#[test]
fn buffers_of_structs_have_lengths() {
    let text = "
        struct Items { count: u32, items: array<vec2u> }
        struct Settings { scale: vec3f, offset: u32, rows: mat2x2f }
        @group(0) @binding(0) var<storage, read_write> list: Items;
        @group(0) @binding(1) var<uniform> settings: Settings;
        @compute @workgroup_size(1) fn main() {
            list.count = arrayLength(&list.items);
            list.items[100].y = settings.offset + u32(settings.scale.z) + u32(settings.rows[1].y);
        }";
    let kernel = compile(text, &Options::default()).expect("compiles");
    let BindingKind::Buffer {
        least_bytes, array, ..
    } = kernel.bindings()[0].kind
    else {
        panic!("a buffer");
    };
    assert_eq!((least_bytes, array), (16, Some((8, 8))));
    let list = Buffer::new(8 + 3 * 8).expect("memory");
    let settings = Buffer::from_slice(&[0f32, 0.0, 7.0, f32::from_bits(40), 1.0, 2.0, 3.0, 500.0]);
    let settings = settings.expect("memory");
    let bound = kernel.bind(|binding| match binding.name.as_str() {
        "list" => Some(Resource::from(list.clone())),
        _ => Some(Resource::from(settings.clone())),
    });
    bound.expect("fits").dispatch([1, 1, 1]);
    assert_eq!(list.read::<u32>(0, 8), [3, 0, 0, 0, 0, 0, 0, 547]);
}

#[test]
fn atomics_count_over_threads() {
    let text = "
        struct Counts { sum: atomic<u32>, most: atomic<u32>, least: atomic<i32>, bits: atomic<u32>, swaps: atomic<u32>, last: atomic<u32> }
        @group(0) @binding(0) var<storage, read_write> counts: Counts;
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
            atomicAdd(&counts.sum, id.x);
            atomicMax(&counts.most, id.x);
            atomicMin(&counts.least, -i32(id.x));
            atomicOr(&counts.bits, 1u << (id.x % 32u));
            loop {
                let old = atomicLoad(&counts.swaps);
                let result = atomicCompareExchangeWeak(&counts.swaps, old, old + 2u);
                if (result.exchanged) { break; }
            }
            if (id.x == 5u) {
                atomicStore(&counts.last, 7u);
                let before = atomicExchange(&counts.last, 8u);
                atomicSub(&counts.last, before + atomicXor(&counts.last, 1u) + atomicAnd(&counts.last, 0xffu));
            }
        }";
    let kernel = compile(text, &Options::default()).expect("compiles");
    let counts = Buffer::new(24).expect("memory");
    let bound = kernel
        .bind(|_| Some(Resource::from(counts.clone())))
        .expect("fits");
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(4)
        .build()
        .expect("threads");
    pool.install(|| bound.dispatch([1000, 1, 1]));
    let n = 64_000u32;
    let sum = (0..n).fold(0u32, u32::wrapping_add);
    let last = 9u32.wrapping_sub(7 + 8 + 9);
    let expected = [sum, n - 1, (1 - n as i32) as u32, u32::MAX, 2 * n, last];
    assert_eq!(counts.read::<u32>(0, 6), expected);
}

#[test]
fn built_ins_tell_the_place() {
    let text = "
        @group(0) @binding(0) var<storage, read_write> output: array<atomic<u32>>;
        struct Place { @builtin(local_invocation_id) local: vec3u, @builtin(workgroup_id) group: vec3u }
        @compute @workgroup_size(2, 3, 2) fn main(place: Place, @builtin(global_invocation_id) id: vec3u,
            @builtin(local_invocation_index) index: u32, @builtin(num_workgroups) groups: vec3u) {
            let size = vec3u(2u, 3u, 2u);
            if (all(id == place.group * size + place.local) && index == place.local.x + 2u * (place.local.y + 3u * place.local.z)) {
                let all = groups * size;
                atomicAdd(&output[id.x + all.x * (id.y + all.y * id.z)], 1u);
            }
        }";
    let kernel = compile(text, &Options::default()).expect("compiles");
    assert_eq!(kernel.workgroup_size(), [2, 3, 2]);
    let output = Buffer::new(4 * 12 * 24).expect("memory");
    let bound = kernel
        .bind(|_| Some(Resource::from(output.clone())))
        .expect("fits");
    bound.dispatch([0, 7, 7]);
    bound.dispatch([2, 3, 4]);
    assert_eq!(output.read::<u32>(0, 288), [1; 288]);
}

/// A sum over a workgroup in steps, with values that live across barriers in loops, arrays and private variables.
#[test]
fn barriers_hold_workgroups_together() {
    let text = format!(
        "{HEAD}
        var<workgroup> partial: array<u32, 64>;
        var<workgroup> shared_flag: u32;
        var<private> calls: array<u32, 70>;
        fn sum(local: u32) {{
            for (var step = 32u; step > 0u; step /= 2u) {{
                workgroupBarrier();
                calls[step] += 1u;
                if (local < step) {{ partial[local] += partial[local + step]; }}
            }}
        }}
        @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {{
            var own = array<u32, 8>();
            own[local % 8u] = id.x;
            let zero = partial[local];
            partial[local] = input[id.x] + zero;
            sum(local);
            if (local == 5u) {{ shared_flag = id.x; }}
            let flag = workgroupUniformLoad(&shared_flag);
            let total = workgroupUniformLoad(&partial[0]);
            if (local % 2u == 1u) {{ output[id.x] = 1u; return; }}
            output[id.x] = total + own[local % 8u] + flag + 1000000u * (calls[1] + calls[32] + calls[33]);
        }}"
    );
    let input: Vec<u32> = (0..128).collect();
    let kernel = compile(&text, &Options::default()).expect("compiles");
    let found = run(&kernel, &input, 128, 2);
    for (id, found) in (0..).zip(found) {
        let group = id / 64;
        let total: u32 = (64 * group..64 * group + 64).sum();
        let expected = match id % 2 {
            1 => 1,
            _ => total + id + 64 * group + 5 + 2_000_000,
        };
        assert_eq!(found, expected, "invocation {id}");
    }
}

#[test]
fn textures_are_read_and_written() {
    let text = "
        @group(0) @binding(0) var wide: texture_2d<f32>;
        @group(0) @binding(1) var layers: texture_2d_array<f32>;
        @group(0) @binding(2) var colors: texture_2d_array<f32>;
        @group(0) @binding(3) var numbers: texture_2d<u32>;
        @group(0) @binding(4) var picture: texture_storage_2d<rgba8unorm, write>;
        @group(0) @binding(5) var<storage, read_write> output: array<vec4f>;
        @compute @workgroup_size(1) fn main() {
            output[0] = textureLoad(wide, vec2i(1, 1), 0);
            output[1] = textureLoad(layers, vec2u(1u, 0u), 1, 0);
            output[2] = textureLoad(colors, vec2u(1u, 0u), 1, 0);
            output[3] = vec4f(textureLoad(numbers, vec2u(0u, 1u), 0));
            output[4] = textureLoad(wide, vec2i(-5, 100), 0);
            output[5] = vec4f(vec4u(textureDimensions(layers), textureNumLayers(layers), textureNumLevels(layers)));
            textureStore(picture, vec2u(1u, 1u), vec4f(1.0, 0.5, 2.0, -1.0));
            textureStore(picture, vec2i(-1, 0), vec4f(1.0));
            textureStore(picture, vec2i(2, 0), vec4f(1.0));
        }";
    let kernel = compile(text, &Options::default()).expect("compiles");
    let image = |format, layers| Image::new(format, 2, 2, layers).expect("memory");
    let wide = image(Format::Rgba32Float, 1);
    wide.texels()
        .write(wide.offset(1, 1, 0), &[1.0f32, -2.0, 3.5, 4.0]);
    let layers = image(Format::Rgba8Unorm, 2);
    layers
        .texels()
        .write(layers.offset(1, 0, 1), &[255u8, 0, 51, 128]);
    let numbers = image(Format::Rgba32Uint, 1);
    numbers
        .texels()
        .write(numbers.offset(0, 1, 0), &[1u32, 2, 3, 4]);
    let picture = image(Format::Rgba8Unorm, 1);
    let output = Buffer::new(6 * 16).expect("memory");
    let bound = kernel.bind(|binding| {
        Some(match binding.name.as_str() {
            "wide" => wide.clone().into(),
            "layers" => layers.clone().into(),
            "colors" => layers.viewed_as(Format::Rgba8UnormSrgb).into(),
            "numbers" => numbers.clone().into(),
            "picture" => picture.clone().into(),
            _ => output.clone().into(),
        })
    });
    bound.expect("fits").dispatch([1, 1, 1]);
    let found = output.read::<[f32; 4]>(0, 6);
    let near = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert_eq!(found[0], [1.0, -2.0, 3.5, 4.0]);
    assert!(
        near(found[1], [1.0, 0.0, 0.2, 128.0 / 255.0]),
        "{:?}",
        found[1]
    );
    assert!(
        near(found[2], [1.0, 0.0, 0.033_104_77, 128.0 / 255.0]),
        "{:?}",
        found[2]
    );
    assert_eq!(found[3], [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(
        found[4],
        [1.0, -2.0, 3.5, 4.0],
        "restricted to the last texel"
    );
    assert_eq!(found[5], [2.0, 2.0, 2.0, 1.0]);
    let picture = picture.read_rows();
    assert_eq!(
        picture,
        [[0; 4], [0; 4], [0; 4], [255, 128, 255, 0]].as_flattened()
    );
}

#[test]
fn overrides_choose_code() {
    let text = single(
        "override fast: bool = true; override n: u32; override twice = n * 2u;",
        "if (fast) { output[0] = twice; } else { output[0] = input[n]; }",
    );
    let (module, info) = parse(&text);
    let build = |constants: &[(&str, f64)]| {
        Kernel::new(&module, &info, "main", constants, &Options::default())
    };
    let fast = build(&[("n", 21.0), ("unknown", 1.0)]).expect("compiles");
    assert_eq!(fast.bindings().len(), 2);
    assert_eq!(run(&fast, &[0], 1, 1), [42]);
    let slow = build(&[("n", 1.0), ("fast", 0.0)]).expect("compiles");
    assert_eq!(run(&slow, &[5, 6], 1, 1), [6]);
    assert!(slow.statistics().code_bytes > fast.statistics().code_bytes);
    assert!(matches!(
        build(&[]).map_err(|e| e.kind),
        Err(ErrorKind::Constants(_))
    ));
}

#[test]
fn loops_end_at_their_limit() {
    let options = Options {
        loop_limit: Some(1000),
        ..Options::default()
    };
    let body = "var n = 0u; loop { n += 1u; if (n == 0u) { break; } } output[0] = n;
        for (var i = 0u; i < 10u; i++) { output[1] += 1u; }";
    let kernel = compile(&single("", body), &options).expect("compiles");
    assert_eq!(run(&kernel, &[0], 2, 1), [1000, 10]);
}

#[test]
fn a_changed_function_is_all_that_is_compiled() {
    let text = |number: u32| {
        single(
            &format!(
                "fn low(x: u32) -> u32 {{ return x * 3u; }}
                 fn first(x: u32) -> u32 {{ return low(x) + {number}u; }}
                 fn second(x: u32) -> u32 {{ return low(x) + array(2u, 5u, 9u, 11u, 17u)[x]; }}"
            ),
            "output[0] = first(input[0]) + 1000u * second(input[0]);",
        )
    };
    let cache = Cache::new();
    let options = Options {
        separate: &|name| name != "main",
        cache: Some(&cache),
        ..Options::default()
    };
    let mut compiled = Vec::new();
    for number in [1, 2, 1] {
        let kernel = compile(&text(number), &options).expect("compiles");
        assert_eq!(run(&kernel, &[1], 1, 1), [8003 + number]);
        compiled.push(kernel.statistics().compiled);
    }
    assert_eq!(compiled, [4, 1, 0]);
}

#[test]
fn what_cannot_run_is_an_error_with_its_place() {
    let refused = |text: &str, part: &str, kind: fn(&ErrorKind) -> bool| {
        let error = compile(text, &Options::default()).expect_err("an error");
        assert!(kind(&error.kind), "{error:?}");
        let found = error.span.to_range().map(|range| &text[range]);
        assert!(
            found.is_some_and(|found| found.contains(part)),
            "{found:?}: {error}"
        );
    };
    let unsupported = |kind: &ErrorKind| matches!(kind, ErrorKind::Unsupported(_));
    refused(
        "@group(0) @binding(0) var picture: texture_2d<f32>;
         @group(0) @binding(1) var smooth_sampler: sampler;
         @group(0) @binding(2) var<storage, read_write> output: array<vec4f>;
         @compute @workgroup_size(1) fn main() { output[0] = textureSampleLevel(picture, smooth_sampler, vec2f(0.5), 0.0); }",
        "smooth_sampler",
        unsupported,
    );
    refused(
        "@group(0) @binding(0) var picture: texture_3d<f32>;
         @group(0) @binding(2) var<storage, read_write> output: array<vec4f>;
         @compute @workgroup_size(1) fn main() { output[0] = textureLoad(picture, vec3u(0u), 0); }",
        "picture",
        unsupported,
    );
    // naga keeps no place of this one.
    let copied = single(
        "",
        "var big = array<f32, 5000>(); let copy = big; output[0] = u32(copy[input[0]]);",
    );
    let error = compile(&copied, &Options::default()).expect_err("an error");
    assert!(
        matches!(error.kind, ErrorKind::TooLarge { scalars: 5000, .. }),
        "{error:?}"
    );
    let deep = "
        fn low(x: u32) -> u32 { var own = array<u32, 60000>(); own[x] = 1u; return own[x + 1u]; }
        fn middle(x: u32) -> u32 { var own = array<u32, 60000>(); own[x] = low(x); return own[x + 1u]; }
        fn high(x: u32) -> u32 { var own = array<u32, 60000>(); own[x] = middle(x); return own[x + 1u]; }";
    for separate in [true, false] {
        let options = Options {
            separate: &|_| separate,
            ..Options::default()
        };
        let error = compile(&single(deep, "output[0] = high(input[0]);"), &options).err();
        let kind = error.map(|error| error.kind);
        assert!(
            matches!(kind, Some(ErrorKind::Stack { bytes, .. }) if bytes >= 720_000),
            "{kind:?}"
        );
    }
    let huge = single(
        "",
        "var huge = array<u32, 500000000>(); output[0] = huge[input[0]];",
    );
    let kind = compile(&huge, &Options::default())
        .map_err(|error| error.kind)
        .err();
    assert!(matches!(kind, Some(ErrorKind::Stack { .. })), "{kind:?}");
    let (module, info) = parse(&single("", ""));
    let missing = Kernel::new(&module, &info, "other", &[], &Options::default());
    assert!(matches!(
        missing.map_err(|e| e.kind),
        Err(ErrorKind::NoEntryPoint(_))
    ));
}

#[test]
fn what_does_not_fit_is_not_bound() {
    let kernel = compile(
        "@group(0) @binding(3) var<storage, read_write> big: array<vec4f, 100>;
         @group(1) @binding(0) var numbers: texture_2d<u32>;
         @group(0) @binding(9) var<storage> unused: array<f32>;
         @compute @workgroup_size(1) fn main() { big[0] = vec4f(textureLoad(numbers, vec2u(0u), 0)); }",
        &Options::default(),
    )
    .expect("compiles");
    let names: Vec<_> = kernel
        .bindings()
        .iter()
        .map(|binding| (binding.name.as_str(), binding.group, binding.binding))
        .collect();
    assert_eq!(names, [("big", 0, 3), ("numbers", 1, 0)]);
    let buffer = |bytes| Resource::from(Buffer::new(bytes).expect("memory"));
    let image = |format, layers| Resource::from(Image::new(format, 1, 1, layers).expect("memory"));
    let bind = |big: Option<Resource>, numbers: Option<Resource>| {
        let bound = kernel.bind(|binding| match binding.name.as_str() {
            "big" => big.clone(),
            _ => numbers.clone(),
        });
        bound.err()
    };
    let numbers = || Some(image(Format::Rgba32Uint, 1));
    assert_eq!(bind(Some(buffer(1600)), numbers()), None);
    assert!(matches!(
        bind(Some(buffer(1596)), numbers()),
        Some(BindError::TooSmall { least: 1600, .. })
    ));
    assert!(matches!(bind(None, numbers()), Some(BindError::Missing(name)) if name == "big"));
    let mismatch = |error| matches!(error, Some(BindError::Mismatch(_)));
    assert!(mismatch(bind(
        Some(buffer(1600)),
        Some(image(Format::Rgba8Unorm, 1))
    )));
    assert!(mismatch(bind(
        Some(buffer(1600)),
        Some(image(Format::Rgba32Uint, 2))
    )));
    assert!(mismatch(bind(numbers(), numbers())));
    let beyond = Resource::Buffer {
        buffer: Buffer::new(1600).expect("memory"),
        offset: 16,
        size: 1600,
    };
    assert!(mismatch(bind(Some(beyond), numbers())));
}

/// Runs `fn f(x: f32, y: f32) -> f32` of a text for 64 pairs of numbers, alone and in lanes.
#[cfg(target_arch = "x86_64")]
fn both(declarations: &str, input: &[f32; 128]) -> [Vec<u32>; 2] {
    let text = format!(
        "{HEAD}{declarations}
        @compute @workgroup_size(64) fn main(@builtin(local_invocation_index) i: u32) {{
            output[i] = bitcast<u32>(f(bitcast<f32>(input[2u * i]), bitcast<f32>(input[2u * i + 1u])));
        }}"
    );
    let options = Options::default();
    let alone = compile(&text, &options).unwrap_or_else(|error| panic!("{text}: {error}"));
    let in_lanes = alone.clone();
    let input = input.map(f32::to_bits);
    let expected = run(&alone, &input, 64, 1);
    let (module, info) = parse(&text);
    let added = in_lanes.add_lanes(&module, &info, "main", &[], &options, &|_| false);
    added.unwrap_or_else(|error| panic!("{text}: {error}"));
    [expected, run(&in_lanes, &input, 64, 1)]
}

#[cfg(target_arch = "x86_64")]
#[test]
fn lanes_follow_no_address_that_none_of_them_has_made() {
    let function = "
        fn f(x: f32, y: f32) -> f32 {
            var a = array<f32, 4>(0.1, 0.2, 0.3, 0.4);
            if (x > 0.0) { return 0.5; }
            for (var i = 0u; i < 4u; i++) {
                let p = &a[i];
                if (y < *p) { return *p; }
            }
            return 1.0;
        }";
    // Eight lanes that have all gone, eight of which half have, and others.
    let mut input = [0.0; 128];
    for (i, pair) in input.chunks_exact_mut(2).enumerate() {
        let has_gone = i < 8 || (i < 16 && i % 2 == 0);
        pair[0] = if has_gone { 1.0 } else { -1.0 };
        pair[1] = i as f32 * 0.01;
    }
    let [expected, found] = both(function, &input);
    assert_eq!(found, expected);
}

#[cfg(target_arch = "x86_64")]
#[test]
fn what_has_too_many_loops_for_lanes_is_refused_in_no_time() {
    let calls: Vec<String> = (0..300).map(|i| format!("n(x + {i}.0)")).collect();
    let text = format!(
        "{HEAD}
        fn n(x: f32) -> f32 {{
            var sum = 0.0;
            var y = x;
            while (y > 1.0) {{ y *= 0.5; if (y > 3.0) {{ sum += 1.0; }} if (y > 300.0) {{ return sum; }} }}
            return sum;
        }}
        @compute @workgroup_size(8) fn main() {{
            let x = bitcast<f32>(input[0]);
            output[0] = bitcast<u32>({});
        }}",
        calls.join(" + ")
    );
    let options = Options::default();
    let kernel = compile(&text, &options).unwrap_or_else(|error| panic!("{error}"));
    let (module, info) = parse(&text);
    let added = kernel.add_lanes(&module, &info, "main", &[], &options, &|_| false);
    assert!(added.is_err(), "billions of steps");
}

/// Each is called once, so that all would be inlined: on a thread with a stack of two megabytes.
#[test]
fn functions_may_call_each_other_a_thousand_deep() {
    let mut functions = "fn f0(x: u32) -> u32 { return x; }\n".to_owned();
    for i in 1..1000 {
        let before = i - 1;
        functions += &format!(
            "fn f{i}(x: u32) -> u32 {{ if (x > 7u) {{ return f{before}(x) + 1u; }} return x; }}\n"
        );
    }
    let text = single(&functions, "output[0] = f999(input[0]);");
    let compiled = std::thread::Builder::new()
        .stack_size(2 << 20)
        .spawn(move || {
            let kernel =
                compile(&text, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
            run(&kernel, &[8], 1, 1)
        });
    let found = compiled.expect("a thread").join().expect("it ends");
    assert_eq!(found, [8 + 999]);
}

#[test]
fn a_result_behind_an_endless_loop_is_never_asked_for() {
    let declarations = "fn endless() -> u32 { loop {} return 1u; }";
    let body = "output[0] = 5u; if (input[0] == 1u) { output[0] = endless() + 1u; }";
    assert_eq!(output(declarations, body, &[0], 1), [5]);
}
