//! Rates of the kernels, and of Embree.

use std::{ops::ControlFlow, sync::Arc};

use device::native::accel::{Flags, Hit, Instance, Kernel, Mesh, Ray, Scene};
use glam::{Affine3A, Vec3};

use crate::{embree, scenes};

/// Rounds of which the medians are taken.
const ROUNDS: usize = 9;
/// Rays that are traced before it is another's turn.
const PART: usize = 1 << 12;

/// How the scene is looked at and lit.
struct View {
    from: Vec3,
    to: Vec3,
    degrees: f32,
    /// A corner and two sides of the lamp.
    lamp: [Vec3; 3],
}

fn view(name: &str) -> View {
    match name {
        "sponza" => View {
            from: Vec3::new(-8.5, 2.5, 0.3),
            to: Vec3::new(0.0, 2.2, 0.0),
            degrees: 70.0,
            lamp: [Vec3::new(-8.0, 9.0, -1.5), Vec3::X * 16.0, Vec3::Z * 3.0],
        },
        "cornell" => View {
            from: Vec3::Z * 3.9,
            to: Vec3::ZERO,
            degrees: 39.3077,
            lamp: [Vec3::new(-0.25, 0.999, -0.25), Vec3::X * 0.5, Vec3::Z * 0.5],
        },
        "living-room" => View {
            from: Vec3::new(5.105, 0.731, -2.318),
            to: Vec3::new(4.143, 0.805, -2.054),
            degrees: 75.0,
            lamp: [Vec3::new(-1.0, 2.4, -1.0), Vec3::X * 2.0, Vec3::Z * 2.0],
        },
        other => panic!("no view is called {other}"),
    }
}

/// Traces rays, to their closest hits or any, and says how long it took.
pub(crate) type Trace<'a> = Box<dyn Fn(&[Ray], bool) -> f64 + 'a>;

pub(crate) fn measure(name: &str, file: &str, library: Option<&str>) {
    let view = view(name);
    let geometry = scenes::load(file);
    let start = std::time::Instant::now();
    let mesh = Arc::new(geometry.build());
    println!(
        "{} triangles, built in {:.0} ms, {} levels, {} MB",
        geometry.triangles.len(),
        start.elapsed().as_secs_f64() * 1e3,
        mesh.depth(),
        mesh.bytes() >> 20,
    );
    let instance = Instance::new(Affine3A::IDENTITY, 0);
    let scenes = [Kernel::best(), Kernel::portable()].map(|kernel| {
        (
            kernel,
            Scene::new(vec![mesh.clone()], vec![instance], kernel),
        )
    });
    let scene = &scenes[0].1;

    let camera = scenes::camera(view.from, view.to, view.degrees, 512);
    let hits: Vec<Option<Hit>> = camera
        .iter()
        .map(|ray| scene.closest(ray, |_| true))
        .collect();
    let points = scenes::points(&geometry, &camera, &hits);
    let bounce = scenes::bounce(&points);
    let shadow = scenes::shadow(&points, view.lamp);
    let batches = [
        ("camera", &camera, false),
        ("bounce", &bounce, false),
        ("shadow", &shadow, true),
        // As light samples of an even sky.
        ("sky", &bounce, true),
    ];

    let mut tracers: Vec<(String, Trace<'_>)> = scenes
        .iter()
        .map(|(kernel, scene)| (kernel.to_string(), trace_by(scene)))
        .collect();
    if let Some(library) = library {
        for quality in [embree::Quality::Medium, embree::Quality::High] {
            let theirs = embree::Scene::build(library, &geometry, quality);
            let agree = bounce.iter().filter(|ray| {
                let ours = scene
                    .closest(ray, |_| true)
                    .map_or(f32::INFINITY, |hit| hit.t);
                let theirs = theirs.closest(ray);
                ours == theirs || (ours - theirs).abs() < 1e-4 * ours.abs().max(1.0)
            });
            let agree = agree.count();
            println!(
                "Embree, {quality:?}: {agree} of {} bounces agree",
                bounce.len()
            );
            tracers.push((format!("Embree, {quality:?}"), theirs.tracer()));
        }
    }

    for (what, rays, is_any) in batches {
        // In small parts, all in turn, so that other work on the machine meets all alike.
        let parts: Vec<&[Ray]> = rays.chunks(PART).collect();
        let mut times = vec![vec![[0.0; ROUNDS]; parts.len()]; tracers.len()];
        for round in 0..ROUNDS {
            for (i, part) in parts.iter().enumerate() {
                for ((_, trace), times) in tracers.iter().zip(&mut times) {
                    times[i][round] = trace(part, is_any);
                }
            }
        }
        print!("{what:8}");
        for ((name, _), times) in tracers.iter().zip(&mut times) {
            let seconds: f64 = times.iter_mut().map(median).sum();
            print!("  {name} {:.2}", rays.len() as f64 * 1e-6 / seconds);
        }
        println!("  Mrays/s of one thread");
    }
}

fn median(times: &mut [f64; ROUNDS]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[ROUNDS / 2]
}

fn trace_by(scene: &Scene) -> Trace<'_> {
    Box::new(|rays, is_any| {
        processor_seconds(|| {
            let hits = rays.iter().filter(|ray| {
                let hit = if is_any {
                    scene.any(ray, |_| true)
                } else {
                    scene.closest(ray, |_| true)
                };
                hit.is_some()
            });
            std::hint::black_box(hits.count());
        })
    })
}

/// Seconds that this thread has worked: on a machine with other work, the clock says little.
pub(crate) fn processor_seconds(work: impl FnOnce()) -> f64 {
    // Not `/proc/thread-self/schedstat`: that is written every few milliseconds only.
    let now = || -> f64 {
        let mut time = [0i64; 2];
        // SAFETY: Linux' clock of this thread, and room for its seconds and nanoseconds.
        let failed = unsafe { clock_gettime(3, &mut time) } != 0;
        assert!(!failed, "Linux has this clock");
        time[0] as f64 + time[1] as f64 * 1e-9
    };
    let start = now();
    work();
    now() - start
}

unsafe extern "C" {
    fn clock_gettime(clock: i32, to: &mut [i64; 2]) -> i32;
}

impl scenes::Geometry {
    pub(crate) fn build(&self) -> Mesh {
        let endless = |_| ControlFlow::Continue(());
        Mesh::build(&self.positions, &self.triangles, |_| Flags::NONE, &endless)
            .expect("it isn't cancelled")
    }
}
