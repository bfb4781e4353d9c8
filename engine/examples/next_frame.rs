//! How long it takes to go from one moment of a scene to the next: reading it, bringing it to the device, a sample of each pixel.
//! Beside that, the first moment, with all that is done once.
//!
//! `cargo run --release --package engine --example next_frame -- SCENE [DEVICE]`

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use device::{Device, DeviceChoice};
use engine::renderer::RenderSettings;
use engine::scene::{Moment, Motion};
use engine::session::{Inputs, Sequence, Session};
use engine::system::System;

/// Frames that are measured; their median is shown.
const FRAMES: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let scene = arguments.next().ok_or("usage: next_frame SCENE [DEVICE]")?;
    let choice = arguments
        .next()
        .map_or(DeviceChoice::Best, DeviceChoice::Name);
    let device = Device::open(&choice)?;
    println!("{}", device.description().title());
    let inputs = Inputs {
        scene: scene.into(),
        look: None,
        textures: Vec::new(),
        camera: None,
    };
    let mut sequence = Sequence::read(inputs, System::default(), &[])?;
    let mut session: Option<Session> = None;
    let mut rows: Vec<[f64; 3]> = Vec::new();
    for frame in 0..=FRAMES {
        let clock = Instant::now();
        let opening = sequence.at(&Moment {
            seconds: frame as f64 / 24.0,
            motion: Motion::Usual,
        })?;
        let read = clock.elapsed();
        let settings = RenderSettings::new(256, 256, &opening.loaded().camera);
        let clock = Instant::now();
        let mut shown = match session.take() {
            Some(mut session) => {
                session.show(opening, &settings, false)?;
                session
            }
            None => {
                let device = device.clone();
                opening.start(
                    Arc::new(move || Ok(device.clone())),
                    Arc::new(move |_| settings.clone()),
                )?
            }
        };
        let brought = clock.elapsed();
        let clock = Instant::now();
        while !shown.step(1)?.is_done() {}
        shown.snapshot()?;
        let row = [read, brought, clock.elapsed()].map(|time| time.as_secs_f64() * 1e3);
        match frame {
            0 => println!("first  {}", text(&row)),
            _ => rows.push(row),
        }
        session = Some(shown);
    }
    let median = |column: usize| {
        let mut times: Vec<f64> = rows.iter().map(|row| row[column]).collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    println!("next   {}", text(&[median(0), median(1), median(2)]));
    Ok(())
}

fn text([read, brought, sample]: &[f64; 3]) -> String {
    format!("read {read:8.1} ms  to the device {brought:8.1} ms  a sample {sample:8.1} ms")
}
