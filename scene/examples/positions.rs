//! Where the vertices of a scene are after some seconds, for comparison with others: a line of JSON for each time.
//!
//! `cargo run --example positions -- FILE SECONDS...`

use std::path::PathBuf;

use scene::import::Importer;
use scene::{Instance, Moment, Motion, Scene};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = PathBuf::from(arguments.next().ok_or("name a file and times in seconds")?);
    let mut importer = Importer::new();
    for seconds in arguments {
        let seconds = seconds.parse()?;
        importer.begin(Moment {
            seconds,
            motion: Motion::Usual,
        });
        let scene = importer.load(&file)?.scene;
        let places = scene
            .instances
            .iter()
            .map(|instance| place(&scene, instance));
        let places: Vec<Value> = places.collect();
        println!("{}", json!({ "seconds": seconds, "places": places }));
    }
    Ok(())
}

/// Name and vertices of a place, in metres in the world, corner by corner of each triangle.
fn place(scene: &Scene, instance: &Instance) -> Value {
    let mesh = &scene.meshes[instance.mesh as usize];
    let corners = mesh.triangles.iter().flatten();
    let positions: Vec<[f32; 3]> = corners
        .map(|&v| {
            instance
                .transform
                .transform_point3(mesh.positions[v as usize])
        })
        .map(|point| point.to_array())
        .collect();
    json!({ "name": instance.name, "corners": positions })
}
