//! Measures rays and builds on one thread's processor time.
//!
//!     measure_rays rays sponza FILE.gltf [LIBEMBREE4.so]
//!     measure_rays rays cornell FILE.glb [LIBEMBREE4.so]
//!     measure_rays rays living-room FILE.gltf [LIBEMBREE4.so]
//!     measure_rays build TRIANGLES
//!     measure_rays leaks
//!
//! `rays` traces camera rays, cosine-distributed bounces and shadow rays by all kernels, and by Embree where its library is
//! given, in turn, and prints medians of their rates. `build` builds a generated mesh on all threads. `leaks` prints the
//! share of rays that escape from closed bodies at edges and corners.

mod embree;
mod leaks;
mod rays;
mod scenes;

use std::{
    ops::ControlFlow,
    sync::atomic::{AtomicU32, Ordering},
    time::Instant,
};

use device::native::accel::{Flags, Mesh};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["rays", view, file] => rays::measure(view, file, None),
        ["rays", view, file, library] => rays::measure(view, file, Some(library)),
        ["build", triangles] => build(triangles.parse().expect("a number of triangles")),
        ["leaks"] => leaks::measure(),
        _ => eprintln!(
            "usage: rays sponza|cornell|living-room FILE [LIBEMBREE4] | build TRIANGLES | leaks"
        ),
    }
}

fn build(triangles: usize) {
    let mesh = scenes::terrain(triangles);
    let reports = AtomicU32::new(0);
    let progress = |_| {
        reports.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    for _ in 0..3 {
        let start = Instant::now();
        let built = Mesh::build(&mesh.positions, &mesh.triangles, |_| Flags::NONE, &progress)
            .expect("it isn't cancelled");
        println!(
            "{} triangles on {} threads: {:.2} s, {} levels, {} MB, {} reports",
            mesh.triangles.len(),
            rayon::current_num_threads(),
            start.elapsed().as_secs_f64(),
            built.depth(),
            built.bytes() >> 20,
            reports.swap(0, Ordering::Relaxed),
        );
    }
}
