//! More outputs than one word has bits for: the kernels' own code stores the results of a hit and finds them again. It runs
//! on the processor, for tables that nobody has yet.

use device::{Device, DeviceChoice, DeviceError, Extent, Recording, Resources, Trust, Usage};
use engine::material_record::{Kind, Output, Outputs, output_wgsl};
use engine::passes::wgsl::ComposedWgsl;

/// Fifteen more than there are.
const COUNT: usize = Output::ALL.len() + 15;
/// Sets of outputs that are tried.
const SETS: usize = 500;
/// Words of results, at most three for each output, and the second word.
const ROOM: usize = 3 * COUNT + 1;

/// Each thread has a set of outputs in its head, stores their results and asks for all of them. Result `c` of output `o`
/// is `o + c / 4`; what isn't there gives -1. The words that were taken come behind them.
const HARNESS: &str = r"
@group(0) @binding(0) var<storage, read> heads: array<vec2u>;
@group(0) @binding(1) var<storage, read_write> results: array<f32>;
@group(0) @binding(2) var<storage, read_write> found: array<vec4f>;

const HEAD_MORE = 13u;

fn head_word(material: u32, word: u32) -> u32 {
    return select(0u, heads[material].y, word == HEAD_MORE);
}

fn result_read(slot: u32, at: u32) -> f32 {
    return results[slot * ROOM + at];
}

fn result_write(slot: u32, at: u32, value: f32) {
    results[slot * ROOM + at] = value;
}

fn output(material: u32, which: u32) -> vec3f {
    return f32(which) + vec3f(0.0, 0.25, 0.5);
}

fn emission_of(material: u32, flags: u32) -> vec3f {
    return output(material, OUTPUT_EMISSION);
}

fn opacity_of(material: u32, flags: u32) -> f32 {
    return output(material, OUTPUT_OPACITY).x;
}

@compute @workgroup_size(64)
fn outputs(@builtin(global_invocation_id) id: vec3u) {
    let slot = id.x;
    if (slot >= arrayLength(&heads)) {
        return;
    }
    let flags = heads[slot].x;
    var words = store_outputs(slot, slot, flags, flags & OUTPUTS);
    if (is_driven(slot, flags, OUTPUT_BUMP)) {
        write_vector(slot, words, output(slot, OUTPUT_BUMP));
        words += 3u;
    }
    for (var which = 0u; which < COUNT; which++) {
        var value = vec3f(-1.0);
        if (has_output(slot, flags & OUTPUTS, which)) {
            let at = result_place(slot, flags & OUTPUTS, which);
            value.x = result_read(slot, at);
            if (is_vector(which)) {
                value.y = result_read(slot, at + 1u);
                value.z = result_read(slot, at + 2u);
            }
        }
        found[slot * COUNT + which] = vec4f(value, f32(words));
    }
}
";

/// The text of a function.
fn function<'s>(source: &'s str, name: &str) -> &'s str {
    let start = source.find(&format!("fn {name}(")).expect("it is there");
    let length = source[start..].find("\n}\n").expect("it ends") + 3;
    &source[start..start + length]
}

/// The outputs there are, more of all kinds, and the height of bump maps as the last one.
fn table() -> Vec<(String, Kind)> {
    let (bump, own) = Output::ALL.split_last().expect("there are some");
    let mut table: Vec<_> = (own.iter())
        .map(|output| (output.key().to_owned(), output.kind()))
        .collect();
    let kinds = [Kind::Scalar, Kind::Color, Kind::Vector];
    table.extend((0..15).map(|i| (format!("more_{i}"), kinds[i % 3])));
    table.push((bump.key().to_owned(), bump.kind()));
    table
}

/// Sets of outputs as bits: each alone, none, all, and others.
fn sets() -> Vec<u64> {
    let all = (1 << COUNT) - 1;
    let mut state = 1u64;
    let mut random = || {
        // Knuth's generator for 64 bits (MMIX).
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        state >> 17
    };
    let mut sets: Vec<u64> = (0..COUNT).map(|number| 1 << number).collect();
    sets.extend([0, all]);
    sets.resize_with(SETS, || random() & all);
    sets
}

fn run(text: ComposedWgsl, heads: &[[u32; 2]]) -> Result<Vec<[f32; 4]>, DeviceError> {
    let device = Device::open(&DeviceChoice::Name("native".to_owned()))?;
    let kernel = text.compile(&device, "outputs", Trust::Nothing, &[])?;
    let mut resources = Resources::default();
    let buffers: [(&str, Vec<u8>); 3] = [
        ("heads", bytemuck::cast_slice(heads).to_vec()),
        ("results", vec![0; 4 * ROOM * heads.len()]),
        ("found", vec![0; 16 * COUNT * heads.len()]),
    ];
    for (name, bytes) in buffers {
        let buffer = device.filled_buffer(name, Usage::Storage, &bytes)?;
        resources.set_buffer(name, buffer);
    }
    let bound = kernel.bind(&device, &resources);
    let mut recording = Recording::new("outputs");
    recording.dispatch(&bound, Extent::Threads(heads.len() as u32));
    device.play(&recording)?;
    let found = device.read(
        resources.buffer("found"),
        0,
        (16 * COUNT * heads.len()) as u64,
    )?;
    Ok(bytemuck::pod_collect_to_vec(&found))
}

#[test]
fn results_beyond_the_first_word_are_found_again() {
    const { assert!(COUNT > Outputs::LOW as usize) };
    let table = table();
    let named: Vec<_> = (table.iter())
        .map(|(key, kind)| (key.as_str(), *kind))
        .collect();
    let mut source = ComposedWgsl::of("shared/outputs.wgsl");
    let own = output_wgsl(None);
    assert!(source.text.contains(&own));
    source.text = source.text.replace(&own, &output_wgsl(Some(&named)));
    let program = ComposedWgsl::of("proctex/run.wgsl").text;
    for name in ["is_driven", "store_outputs", "write_vector"] {
        source.text += function(&program, name);
    }
    source.text += HARNESS;
    source.text += &format!("const COUNT = {COUNT}u;\nconst ROOM = {ROOM}u;\n");

    let low = (1u64 << Outputs::LOW) - 1;
    let head = |set: &u64| match (set >> Outputs::LOW) as u32 {
        0 => [*set as u32, 0],
        more => [(set & low) as u32 | Outputs::MORE, more],
    };
    let sets = sets();
    let heads: Vec<_> = sets.iter().map(head).collect();
    let found = run(source, &heads).unwrap_or_else(|error| panic!("{error}"));
    for (set, found) in sets.iter().zip(found.chunks_exact(COUNT)) {
        let is_vector = |number: usize| number == COUNT - 1 || table[number].1 != Kind::Scalar;
        let is_there = |number: &usize| set & 1 << number != 0;
        let results = (0..COUNT).filter(is_there);
        let second = usize::from(set >> Outputs::LOW != 0);
        let words = results
            .map(|n| if is_vector(n) { 3 } else { 1 })
            .sum::<usize>()
            + second;
        for (number, found) in found.iter().enumerate() {
            let x = number as f32;
            // What a program gives for an angle is in degrees, what is stored in radians.
            let x = match number == Output::ANISOTROPY_ROTATION.number() as usize {
                true => x.to_radians(),
                false => x,
            };
            let expected = match (is_there(&number), is_vector(number)) {
                (false, _) => [-1.0; 3],
                (true, false) => [x, -1.0, -1.0],
                (true, true) => [x, x + 0.25, x + 0.5],
            };
            assert_eq!(found[..3], expected, "output {number} of {set:#x}");
            assert_eq!(found[3], words as f32, "words of {set:#x}");
        }
    }
}
