//! Renders a glTF file through the engine's API and prints the picture's mean radiance.
//!
//! `cargo run --release --example render_gltf -- scene.glb 512 512 64 9 [out.png]`

use std::{error::Error, path::PathBuf, sync::Arc, time::Instant};

use device::Device;
use engine::{
    renderer::RenderSettings,
    session::{Inputs, Session},
};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let usage = "usage: render_gltf SCENE [WIDTH HEIGHT SPP DEPTH [OUT.png]]";
    let inputs = Inputs {
        scene: PathBuf::from(args.first().ok_or(usage)?),
        look: None,
        textures: Vec::new(),
        camera: None,
    };
    let number = |i: usize, default: u32| args.get(i).map_or(Ok(default), |a| a.parse());
    let (width, height, max_depth) = (number(1, 512)?, number(2, 512)?, number(4, 9)?);
    let spp = number(3, 64)?;
    let start = Instant::now();
    let mut session = Session::open(
        inputs,
        Arc::new(Device::best),
        Arc::new(move |camera| RenderSettings {
            max_depth,
            ..RenderSettings::new(width, height, &camera)
        }),
    )?;
    for warning in session.warnings().iter() {
        eprintln!("warning: {}", warning.message);
    }
    let device = session.device().description();
    println!("{} ({})", device.name, device.driver);
    println!("scene and kernels: {:.2} s", start.elapsed().as_secs_f64());
    session.time_passes()?;
    while !session.step(spp)?.is_done() {}
    let stats = session.stats()?;
    for pass in &stats.passes {
        println!(
            "{:12} {:9.1} ms {:5.1} % {:6}",
            pass.name,
            pass.milliseconds,
            pass.share * 100.0,
            pass.dispatches
        );
    }
    println!(
        "{:.3} s, {:.2} Mrays/s, {:.3} Msamples/s, invalid {}",
        stats.seconds,
        stats.mrays_per_second,
        stats.samples_per_second * 1e-6,
        stats.invalid_samples
    );
    let mean = session.snapshot()?.film.mean();
    let total = mean.iter().fold([0.0f64; 3], |t, p| {
        std::array::from_fn(|c| t[c] + f64::from(p[c]))
    });
    println!("mean {:?}", total.map(|t| t / mean.len() as f64));
    if let Some(out) = args.get(5) {
        let encode = |v: f32| {
            (if v <= 0.0031308 {
                12.92 * v
            } else {
                1.055 * v.powf(1.0 / 2.4) - 0.055
            }
            .clamp(0.0, 1.0)
                * 255.0
                + 0.5) as u8
        };
        let bytes: Vec<u8> = mean.iter().flatten().map(|&v| encode(v)).collect();
        image::save_buffer(out, &bytes, width, height, image::ColorType::Rgb8)?;
    }
    Ok(())
}
