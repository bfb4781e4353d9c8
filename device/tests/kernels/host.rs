//! Functions of the program in place of functions of the text.

use std::ops::Range;
use std::sync::Arc;

use device::{
    Device, DeviceChoice, Extent, HostFunction, Kernel, KernelSource, Recording, Resources, Text,
    Trust, Usage,
    native::{
        buffer::Buffer,
        compile::{BindError, Options, Resource},
    },
};

use crate::support::compile;

/// `mixed` of the text, and ten times as much, so that it is seen which of both ran.
#[derive(Debug)]
struct Mixed;

impl HostFunction for Mixed {
    fn words(&self) -> [usize; 2] {
        [6, 3]
    }

    fn call(&self, arguments: &[u32], result: &mut [u32]) {
        let number = |i: usize| f32::from_bits(arguments[i]);
        let sum = number(0) + number(1) + number(2);
        let signed = arguments[3].cast_signed();
        let yes = arguments[4] != 0;
        let all = [
            (10.0 * sum).to_bits(),
            (10 * signed).cast_unsigned(),
            u32::from(!yes) + arguments[5],
        ];
        result.copy_from_slice(&all);
    }
}

const TEXT: &str = "
    @group(0) @binding(0) var<storage, read_write> numbers: array<u32>;
    struct Result { sum: f32, signed: i32, word: u32 }
    fn mixed(v: vec3f, signed: i32, yes: bool, word: u32) -> Result {
        return Result(v.x + v.y + v.z, signed, u32(!yes) + word);
    }
    fn twice(i: u32) -> u32 {
        let once = mixed(vec3f(1.0, 2.0, f32(i)), -3, i == 2u, 5u);
        let again = mixed(vec3f(once.sum, 0.0, 0.0), once.signed, true, once.word);
        return u32(again.sum) + u32(-again.signed) * 1000u + again.word * 1000000u;
    }
    @compute @workgroup_size(4)
    fn main(@builtin(global_invocation_id) id: vec3u) { numbers[id.x] = twice(id.x); }";

/// The text, of which the program does these functions.
#[derive(Debug)]
struct Calling(&'static [&'static str]);

impl Text for Calling {
    fn wgsl(&self) -> &str {
        TEXT
    }

    fn locate(&self, span: Range<usize>, message: &str) -> Option<String> {
        TEXT.locate(span, message)
    }

    fn host_functions(&self) -> &[&'static str] {
        self.0
    }
}

#[test]
fn a_function_of_the_program_is_called() {
    let native = DeviceChoice::Name("native".to_owned());
    let device = Device::open(&native).expect("it is always there");
    assert!(device.traits().calls_functions);
    let ran = |host: &'static [&'static str]| -> Vec<u32> {
        let text = Calling(host);
        let source = KernelSource::new(&text, "main", Trust::All);
        let kernel = Kernel::new(&device, &source).unwrap_or_else(|error| panic!("{error}"));
        let mut resources = Resources::default();
        let buffer = device.buffer("numbers", Usage::Storage, 16);
        resources.set_buffer("numbers", buffer.expect("memory"));
        resources.set_function("mixed", Arc::new(Mixed));
        let mut recording = Recording::new("test");
        recording.dispatch(&kernel.bind(&device, &resources), Extent::One);
        device.play(&recording).expect("it runs");
        let read = device.read(resources.buffer("numbers"), 0, 16);
        bytemuck::pod_collect_to_vec(&read.expect("memory"))
    };
    let by_text = |i: u32| 3 + i + 3000 + 1_000_000 * (5 + u32::from(i != 2));
    assert_eq!(ran(&[]), [0, 1, 2, 3].map(by_text));
    let by_program = |i: u32| 100 * (3 + i) + 300_000 + 1_000_000 * (5 + u32::from(i != 2));
    assert_eq!(
        ran(&["mixed", "no such function"]),
        [0, 1, 2, 3].map(by_program)
    );
}

#[test]
fn another_function_is_refused() {
    #[derive(Debug)]
    struct Other;
    impl HostFunction for Other {
        fn words(&self) -> [usize; 2] {
            [6, 4]
        }
        fn call(&self, _: &[u32], _: &mut [u32]) {}
    }
    let options = Options {
        host: &["mixed"],
        ..Options::default()
    };
    let kernel = compile(TEXT, &options).expect("compiles");
    let bind = |function: Option<Resource>| {
        let buffer = Buffer::new(16).expect("memory");
        let bound = kernel.bind(|binding| match binding.name.as_str() {
            "mixed" => function.clone(),
            _ => Some(buffer.clone().into()),
        });
        bound.err()
    };
    let function = |function: Arc<dyn HostFunction>| Some(Resource::from(function));
    assert_eq!(bind(function(Arc::new(Mixed))), None);
    let mismatch = BindError::Mismatch("mixed".to_owned());
    assert_eq!(bind(function(Arc::new(Other))), Some(mismatch));
    assert_eq!(bind(None), Some(BindError::Missing("mixed".to_owned())));
}
