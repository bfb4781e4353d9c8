//! What texgen accepts, the device accepts: mutated textures that pass its checks are built into the kernel that really
//! runs, by the driver. With `PATINA_FULL` set there are many more of them.

#[path = "../../engine/tests/suite/support/device.rs"]
#[expect(dead_code, reason = "it is a part of other tests")]
mod opened;

use std::time::{Duration, Instant};

use engine::gpu_scene::SceneFeatures;
use engine::passes::proctex;
use fuzzing::{WGSL, mutate::Random};
use texgen::{Library, SourceFile, TextureType};

#[test]
fn what_texgen_accepts_the_device_accepts() {
    let Some(device) = opened::open() else {
        return;
    };
    let seeds = (WGSL.seeds)();
    let features = SceneFeatures {
        programs: true,
        textures: true,
        program_shadows: true,
        ..SceneFeatures::default()
    };
    let budget = match std::env::var_os("PATINA_FULL").is_some() {
        true => Duration::from_secs(300),
        false => Duration::from_secs(10),
    };
    let mut random = Random(23);
    let (start, mut built) = (Instant::now(), 0);
    let mut together: Vec<TextureType> = Vec::new();
    while start.elapsed() < budget {
        let seed = &seeds[random.below(seeds.len())];
        let text = String::from_utf8((WGSL.mutate)(seed, &mut random)).expect("a text");
        let name = format!("mutated {}", together.len());
        let Ok(texture) = TextureType::parse(SourceFile::new(name.clone(), name, text)) else {
            continue;
        };
        together.push(texture);
        if together.len() < 4 {
            continue;
        }
        let textures = std::mem::take(&mut together);
        let library = Library::new(textures).unwrap_or_else(|problem| panic!("{problem}"));
        let kernel = library.emit(4);
        if let Err(error) = proctex::kernel(&device, &kernel, &features) {
            let texts = library.textures().iter().map(|t| t.file().text());
            panic!("{error}\n{}", texts.collect::<Vec<_>>().join("\n// ----\n"));
        }
        built += 1;
    }
    eprintln!("{built} kernels of four mutated textures");
    assert!(built > 0);
}
