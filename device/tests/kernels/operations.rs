//! Every operation on values whose results are known.

use device::native::compile::Options;

use crate::support::{compile, run, single};

/// What `expression` of type `ty` gives, as words; `a`, `b`, `c`, `d` are the input's floats, `i`, `j` its signed and `u`, `v` its
/// unsigned integers: read from memory, so that nothing is known when the kernel is compiled.
fn words(
    ty: &str,
    expression: &str,
    floats: [f32; 4],
    ints: [i32; 2],
    uints: [u32; 2],
) -> Vec<u32> {
    let (scalar, width) = match ty.split_once('<') {
        Some((vector, scalar)) => (
            scalar.trim_end_matches('>'),
            vector.trim_start_matches("vec").parse().expect("a width"),
        ),
        None => (ty, 1),
    };
    let store = |index: usize| {
        let value = match width {
            1 => "x".to_owned(),
            _ => format!("x[{index}]"),
        };
        match scalar {
            "bool" => format!("output[{index}] = u32({value});"),
            _ => format!("output[{index}] = bitcast<u32>({value});"),
        }
    };
    let stores: String = (0..width).map(store).collect();
    let body = format!(
        "let a = bitcast<f32>(input[0]); let b = bitcast<f32>(input[1]); let c = bitcast<f32>(input[2]);
         let d = bitcast<f32>(input[3]); let i = bitcast<i32>(input[4]); let j = bitcast<i32>(input[5]);
         let u = input[6]; let v = input[7]; let p = a < b;
         let x: {ty} = {expression}; {stores}"
    );
    let text = single("", &body);
    let kernel =
        compile(&text, &Options::default()).unwrap_or_else(|error| panic!("{text}: {error}"));
    let mut input = floats.map(f32::to_bits).to_vec();
    input.extend(ints.map(|x| x as u32));
    input.extend(uints);
    run(&kernel, &input, width, 1)
}

fn floats(expression: &str, ty: &str, values: [f32; 4]) -> Vec<f32> {
    let words = words(ty, expression, values, [0; 2], [0; 2]);
    words.into_iter().map(f32::from_bits).collect()
}

/// A float of floats, to within a few units of the last place.
#[track_caller]
fn float(expression: &str, values: [f32; 4], expected: f32) {
    let found = floats(expression, "f32", values)[0];
    let close = (found - expected).abs() <= 1e-6 * expected.abs().max(1e-6);
    let same = close || found == expected || (found.is_nan() && expected.is_nan());
    assert!(same, "{expression} of {values:?}: {found}, not {expected}");
}

#[track_caller]
fn vector(expression: &str, ty: &str, values: [f32; 4], expected: &[f32]) {
    let found = floats(expression, ty, values);
    for (found, expected) in found.iter().zip(expected) {
        let close = (found - expected).abs() <= 2e-6 * expected.abs().max(1.0);
        assert!(
            close,
            "{expression} of {values:?}: {found:?}, not {expected:?}"
        );
    }
    assert_eq!(found.len(), expected.len());
}

#[track_caller]
fn int(expression: &str, i: i32, j: i32, expected: i32) {
    let found = words("i32", expression, [0.0; 4], [i, j], [0; 2])[0] as i32;
    assert_eq!(found, expected, "{expression} of {i} and {j}");
}

#[track_caller]
fn uint(expression: &str, u: u32, v: u32, expected: u32) {
    let found = words("u32", expression, [0.0; 4], [0; 2], [u, v])[0];
    assert_eq!(found, expected, "{expression} of {u} and {v}");
}

#[track_caller]
fn truth(expression: &str, values: [f32; 4], expected: bool) {
    let found = words("bool", expression, values, [0; 2], [0; 2])[0];
    assert_eq!(found, u32::from(expected), "{expression} of {values:?}");
}

const INF: f32 = f32::INFINITY;
const NAN: f32 = f32::NAN;

#[test]
fn operators_of_floats() {
    let x = [7.5, -2.0, 0.25, 3.0];
    float("a + b", x, 5.5);
    float("a - b", x, 9.5);
    float("a * b", x, -15.0);
    float("a / b", x, -3.75);
    float("a % b", x, 1.5);
    float("b % d", [0.0, -7.0, 0.0, 3.0], -1.0);
    float("-a", x, -7.5);
    truth("a < b", x, false);
    truth("a <= a", x, true);
    truth("a > b", x, true);
    truth("b >= a", x, false);
    truth("a == a", x, true);
    truth("a != a", [NAN; 4], true);
    truth("a == a", [NAN; 4], false);
    truth("!(a < b) && (c > 0.0 || d < 0.0)", x, true);
    truth("(a < b) | (c < d)", x, true);
    truth("(a < b) & (c < d)", x, false);
    truth("(a < b) == (b < a)", x, false);
    truth("(a < b) != (b < a)", x, true);
    truth("all(vec2(a, b) < vec2(b, c))", x, false);
    truth("any(vec2(a, b) < vec2(b, c))", x, true);
    truth(
        "all(select(vec2(true), vec2(false), vec2(p, !p)) == vec2(true, false))",
        x,
        true,
    );
    float("select(a, b, p)", x, 7.5);
    float("select(a, b, !p)", x, -2.0);
    vector(
        "select(vec2(a, b), vec2(c, d), vec2(p, !p))",
        "vec2<f32>",
        x,
        &[7.5, 3.0],
    );
}

#[test]
fn operators_of_integers() {
    int("i + j", i32::MAX, 1, i32::MIN);
    int("i - j", i32::MIN, 1, i32::MAX);
    int("i * j", 1 << 20, 1 << 13, 0);
    int("-i", i32::MIN, 0, i32::MIN);
    int("~i", 5, 0, -6);
    int("i & j", 12, 10, 8);
    int("i | j", 12, 10, 14);
    int("i ^ j", 12, 10, 6);
    int("i << u32(j)", 3, 33, 6);
    int("i >> u32(j)", -8, 1, -4);
    uint("u >> v", 0x8000_0000, 31, 1);
    uint("u >> v", 6, 33, 3);
    int("i / j", -7, 2, -3);
    int("i % j", -7, 2, -1);
    int("i / j", 7, 0, 7);
    int("i % j", 7, 0, 0);
    int("i / j", i32::MIN, -1, i32::MIN);
    int("i % j", i32::MIN, -1, 0);
    int("i / -1", i32::MIN, 0, i32::MIN);
    int("i / 3", -7, 0, -2);
    uint("u / v", u32::MAX, 2, i32::MAX as u32);
    uint("u % v", u32::MAX, 10, 5);
    uint("u / v", 9, 0, 9);
    uint("u % v", 9, 0, 0);
    uint("u * v", 0xffff, 0x10001, u32::MAX);
    uint(
        "u32(u < v) + 2u * u32(u <= v) + 4u * u32(u > v) + 8u * u32(u >= v)",
        1,
        u32::MAX,
        3,
    );
    int(
        "i32(i < j) + 2 * i32(i <= j) + 4 * i32(i > j) + 8 * i32(i >= j)",
        1,
        -1,
        12,
    );
    int("i32(i == j) + 2 * i32(i != j)", 4, 4, 1);
    int("dot(vec3(i, j, 2), vec3(3, i, j))", 2, 5, 6 + 10 + 10);
    int("(vec2(i, j) * 2 + vec2(1)).y", 2, 5, 11);
}

#[test]
fn conversions() {
    int("i32(bitcast<f32>(i))", (-2.9f32).to_bits() as i32, 0, -2);
    int(
        "i32(bitcast<f32>(i))",
        3e9f32.to_bits() as i32,
        0,
        2_147_483_520,
    );
    int(
        "i32(bitcast<f32>(i))",
        (-3e9f32).to_bits() as i32,
        0,
        i32::MIN,
    );
    uint("u32(bitcast<f32>(u))", 3e9f32.to_bits(), 0, 3_000_000_000);
    uint("u32(bitcast<f32>(u))", 5e9f32.to_bits(), 0, 4_294_967_040);
    uint("u32(bitcast<f32>(u))", (-5f32).to_bits(), 0, 0);
    uint("u32(bitcast<f32>(u))", INF.to_bits(), 0, 4_294_967_040);
    uint(
        "bitcast<u32>(f32(u))",
        u32::MAX,
        0,
        4_294_967_296f32.to_bits(),
    );
    int(
        "bitcast<i32>(f32(i))",
        -16_777_217,
        0,
        (-16_777_216f32).to_bits() as i32,
    );
    int("i32(u32(i))", -1, 0, -1);
    int("i32(bool(i)) + i32(bool(j))", 7, 0, 1);
    float("f32(p)", [1.0, 2.0, 0.0, 0.0], 1.0);
    float("f32(bool(a)) + f32(bool(b))", [0.0, NAN, 0.0, 0.0], 1.0);
    vector(
        "vec3<f32>(vec3<i32>(vec3(a, b, c)))",
        "vec3<f32>",
        [1.9, -1.9, 0.9, 0.0],
        &[1.0, -1.0, 0.0],
    );
}

#[test]
fn functions_of_numbers() {
    let x = [2.0, -3.5, 0.5, 4.0];
    float("abs(b)", x, 3.5);
    int("abs(i)", -7, 0, 7);
    uint("abs(u)", 7, 0, 7);
    float("min(a, b)", x, -3.5);
    float("max(a, b)", x, 2.0);
    // Of a constant and what isn't a number, the constant.
    float("max(a, 0.0)", [NAN; 4], 0.0);
    float("min(1.0, a)", [NAN; 4], 1.0);
    int("min(i, j) * 100 + max(i, j)", -2, 3, -197);
    uint("min(u, v) * 100u + max(u, v)", u32::MAX, 3, 299);
    float("clamp(b, -1.0, 1.0)", x, -1.0);
    int("clamp(i, -1, j)", 9, 3, 3);
    float("saturate(a)", x, 1.0);
    float("sign(b) * 10.0 + sign(a)", x, -9.0);
    int("sign(i) * 10 + sign(j)", -5, 0, -10);
    float("cos(a)", x, 2f32.cos());
    float("sin(b)", x, (-3.5f32).sin());
    float("tan(c)", x, 0.5f32.tan());
    float("acos(c)", x, 0.5f32.acos());
    float("asin(c)", x, 0.5f32.asin());
    float("atan(b)", x, (-3.5f32).atan());
    float("atan2(b, a)", x, (-3.5f32).atan2(2.0));
    float("cosh(c)", x, 0.5f32.cosh());
    float("sinh(c)", x, 0.5f32.sinh());
    float("tanh(c)", x, 0.5f32.tanh());
    float("acosh(a)", x, 2f32.acosh());
    float("asinh(a)", x, 2f32.asinh());
    float("atanh(c)", x, 0.5f32.atanh());
    float("exp(b)", x, (-3.5f32).exp());
    float("exp2(b)", x, (-3.5f32).exp2());
    float("log(c)", x, 0.5f32.ln());
    float("log2(a)", x, 1.0);
    float("pow(a, b)", x, 2f32.powf(-3.5));
    float("ldexp(a, 3)", x, 16.0);
    float("ldexp(a, -3)", x, 0.25);
    float("radians(a)", x, 2f32.to_radians());
    float("degrees(a)", x, 2f32.to_degrees());
    float("ceil(b)", x, -3.0);
    float("floor(b)", x, -4.0);
    float("round(b)", x, -4.0);
    float("round(a)", [2.5, 0.0, 0.0, 0.0], 2.0);
    float("trunc(b)", x, -3.0);
    float("fract(b)", x, 0.5);
    float("sqrt(a)", x, 2f32.sqrt());
    float("inverseSqrt(d)", x, 0.5);
    float("fma(a, b, c)", x, -6.5);
    float("mix(a, d, c)", x, 3.0);
    vector(
        "mix(vec2(a, b), vec2(d, d), c)",
        "vec2<f32>",
        x,
        &[3.0, 0.25],
    );
    float("step(a, d) * 10.0 + step(d, a)", x, 10.0);
    float("smoothstep(0.0, a, c)", x, 0.25 * 0.25 * (3.0 - 0.5));
    float("quantizeToF16(a)", [1.0009, 0.0, 0.0, 0.0], 1.000_976_6);
    vector(
        "vec2(modf(b).fract, modf(b).whole)",
        "vec2<f32>",
        x,
        &[-0.5, -3.0],
    );
    vector(
        "vec3(frexp(b).fract, f32(frexp(b).exp), frexp(0.0).fract)",
        "vec3<f32>",
        x,
        &[-0.875, 2.0, 0.0],
    );
    vector(
        "modf(vec2(a, b)).whole",
        "vec2<f32>",
        [1.5, -2.5, 0.0, 0.0],
        &[1.0, -2.0],
    );
}

#[test]
fn functions_of_vectors() {
    let x = [1.0, 2.0, -2.0, 4.0];
    float("dot(vec3(a, b, c), vec3(b, c, d))", x, 2.0 - 4.0 - 8.0);
    float("length(vec3(a, b, c))", x, 3.0);
    float("length(c)", x, 2.0);
    float("distance(vec2(a, b), vec2(d, -c))", x, 3.0);
    vector(
        "cross(vec3(a, b, c), vec3(d, a, b))",
        "vec3<f32>",
        x,
        &[6.0, -10.0, -7.0],
    );
    vector(
        "normalize(vec3(a, b, c))",
        "vec3<f32>",
        x,
        &[1.0 / 3.0, 2.0 / 3.0, -2.0 / 3.0],
    );
    vector(
        "faceForward(vec2(a, b), vec2(a, b), vec2(c, d))",
        "vec2<f32>",
        x,
        &[-1.0, -2.0],
    );
    vector(
        "reflect(vec2(a, c), vec2(0.0, 1.0))",
        "vec2<f32>",
        x,
        &[1.0, 2.0],
    );
    vector(
        "refract(vec2(0.6, -0.8) * a, vec2(0.0, 1.0), c)",
        "vec2<f32>",
        [1.0, 0.0, 0.5, 0.0],
        &[0.3, -0.953_939_2],
    );
    vector(
        "refract(vec2(0.8, -0.6) * a, vec2(0.0, 1.0), b)",
        "vec2<f32>",
        x,
        &[0.0, 0.0],
    );
    vector(
        "vec4(a, b, c, d).wzyx",
        "vec4<f32>",
        x,
        &[4.0, -2.0, 2.0, 1.0],
    );
    vector(
        "vec4(a, b, c, d)[u + 1u] * vec2(1.0, a)",
        "vec2<f32>",
        x,
        &[2.0, 2.0],
    );
}

#[test]
fn matrices() {
    let x = [1.0, 2.0, 3.0, 4.0];
    vector(
        "mat2x2(a, b, c, d) * vec2(a, b)",
        "vec2<f32>",
        x,
        &[7.0, 10.0],
    );
    vector(
        "vec2(a, b) * mat2x2(a, b, c, d)",
        "vec2<f32>",
        x,
        &[5.0, 11.0],
    );
    vector(
        "(mat2x2(a, b, c, d) * mat2x2(d, c, b, a))[1]",
        "vec2<f32>",
        x,
        &[5.0, 8.0],
    );
    vector(
        "(mat2x3(a, b, c, d, a, b) * mat3x2(a, b, c, d, a, b))[2]",
        "vec3<f32>",
        x,
        &[9.0, 4.0, 7.0],
    );
    vector(
        "transpose(mat2x3(a, b, c, d, a, b))[1]",
        "vec2<f32>",
        x,
        &[2.0, 1.0],
    );
    vector(
        "(mat2x2(a, b, c, d) * b + mat2x2(d, d, d, d))[u]",
        "vec2<f32>",
        x,
        &[6.0, 8.0],
    );
    float("determinant(mat2x2(a, b, c, d))", x, -2.0);
    float(
        "determinant(mat3x3(a, b, c, d, a, b, c, d, b))",
        x,
        1.0 * (2.0 - 8.0) - 2.0 * (8.0 - 6.0) + 3.0 * (16.0 - 3.0),
    );
    float(
        "determinant(mat4x4(a, 0, 0, 0, 0, b, 0, 0, 0, 0, c, 0, 1, 2, 3, d))",
        x,
        24.0,
    );
}

#[test]
fn bits() {
    uint(
        "countTrailingZeros(u) * 100u + countTrailingZeros(v)",
        8,
        0,
        332,
    );
    uint(
        "countLeadingZeros(u) * 100u + countLeadingZeros(v)",
        1,
        0,
        3132,
    );
    uint("countOneBits(u)", 0xf0f0_0001, 0, 9);
    uint("reverseBits(u)", 0x8000_0003, 0, 0xc000_0001);
    uint("firstTrailingBit(u)", 24, 0, 3);
    uint("firstTrailingBit(u)", 0, 0, u32::MAX);
    uint("firstLeadingBit(u)", 24, 0, 4);
    uint("firstLeadingBit(u)", 0, 0, u32::MAX);
    int("firstLeadingBit(i) * 100 + firstLeadingBit(j)", -2, 24, 4);
    int("firstLeadingBit(i)", -1, 0, -1);
    uint("extractBits(u, v, 8u)", 0x1234_5678, 4, 0x67);
    uint("extractBits(u, 28u, v)", 0xf234_5678, 8, 0xf);
    uint("extractBits(u, 40u, v)", 0xf234_5678, 8, 0);
    uint("extractBits(u, 0u, v)", 0xf234_5678, 32, 0xf234_5678);
    int("extractBits(i, 4u, u32(j))", 0x0f80, 8, -8);
    int("extractBits(i, 4u, u32(j))", 0x0f80, 0, 0);
    uint("insertBits(u, v, 8u, 8u)", 0x1234_5678, 0xabc, 0x1234_bc78);
    uint("insertBits(u, v, 0u, 32u)", 1, 0xabc, 0xabc);
    uint("insertBits(u, v, 32u, 4u)", 1, 0xabc, 1);
    uint("insertBits(u, v, 3u, 0u)", 1, 0xabc, 1);
}

#[test]
fn packing() {
    let x = [0.5, -1.0, 2.0, -0.25];
    let word = |expression: &str| words("u32", expression, x, [0; 2], [0x80ff_017f, 0])[0];
    assert_eq!(word("pack4x8snorm(vec4(a, b, c, d))"), 0xe07f_8140);
    assert_eq!(word("pack4x8unorm(vec4(a, b, c, d))"), 0x00ff_0080);
    assert_eq!(word("pack2x16snorm(vec2(a, b))"), 0x8001_4000);
    assert_eq!(word("pack2x16unorm(vec2(a, c))"), 0xffff_8000);
    assert_eq!(word("pack2x16float(vec2(a, b))"), 0xbc00_3800);
    assert_eq!(word("pack4xI8(vec4(1, -1, 300, -128))"), 0x802c_ff01);
    assert_eq!(word("pack4xU8(vec4(1u, 2u, 300u, 255u))"), 0xff2c_0201);
    assert_eq!(word("pack4xI8Clamp(vec4(1, -1, 300, -300))"), 0x807f_ff01);
    assert_eq!(word("pack4xU8Clamp(vec4(1u, 2u, 300u, 255u))"), 0xffff_0201);
    assert_eq!(
        word("u32(dot4I8Packed(u, 0x01010101u) + 200)"),
        200 + 127 + 1 - 1 - 128
    );
    assert_eq!(word("dot4U8Packed(u, 0x01010101u)"), 127 + 1 + 255 + 128);
    let vector = |expression: &str, ty: &str| -> Vec<f32> {
        let words = words(ty, expression, x, [0; 2], [0x80ff_017f, 0xbc00_3800]);
        words.into_iter().map(f32::from_bits).collect()
    };
    let near = |found: Vec<f32>, expected: &[f32]| {
        assert!(
            found
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-6),
            "{found:?}"
        );
        assert_eq!(found.len(), expected.len());
    };
    near(
        vector("unpack4x8snorm(u)", "vec4<f32>"),
        &[1.0, 1.0 / 127.0, -1.0 / 127.0, -1.0],
    );
    near(
        vector("unpack4x8unorm(u)", "vec4<f32>"),
        &[127.0 / 255.0, 1.0 / 255.0, 1.0, 128.0 / 255.0],
    );
    near(
        vector("unpack2x16snorm(u)", "vec2<f32>"),
        &[383.0 / 32767.0, -32513.0 / 32767.0],
    );
    near(
        vector("unpack2x16unorm(u)", "vec2<f32>"),
        &[383.0 / 65535.0, 33023.0 / 65535.0],
    );
    near(vector("unpack2x16float(v)", "vec2<f32>"), &[0.5, -1.0]);
    near(
        vector("vec4<f32>(unpack4xI8(u))", "vec4<f32>"),
        &[127.0, 1.0, -1.0, -128.0],
    );
    near(
        vector("vec4<f32>(unpack4xU8(u))", "vec4<f32>"),
        &[127.0, 1.0, 255.0, 128.0],
    );
}

#[test]
fn angles_of_all_octants_are_right() {
    let angle = |y: f32, x: f32| {
        let found = words("f32", "atan2(a, b)", [y, x, 0.0, 0.0], [0; 2], [0; 2])[0];
        let expected = f64::from(y).atan2(f64::from(x)) as f32;
        let off = f32::from_bits(found).to_bits().abs_diff(expected.to_bits());
        assert!(
            off <= 3,
            "{y}, {x}: {} for {expected}",
            f32::from_bits(found)
        );
    };
    for step in 0..48 {
        let turn = 7.5_f32.to_radians() * step as f32 + 0.01;
        angle(3.0 * turn.sin(), 3.0 * turn.cos());
    }
    for (y, x) in [
        (0.0, 1.0),
        (0.0, -1.0),
        (-0.0, -1.0),
        (1.0, 0.0),
        (-1.0, 0.0),
        (0.0, 0.0),
        (1e-30, 1e30),
        (1.0, 1.0),
    ] {
        angle(y, x);
    }
}
