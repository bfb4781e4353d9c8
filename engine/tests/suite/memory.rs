//! What a render is said to take before it begins, compared with the buffers that it has then.

use engine::film::Layers;
use engine::renderer::{DeviceMemory, RenderSettings, Renderer, snapshot_bytes};
use engine::scene::Projection;
use glam::Vec3;

use crate::support::device;
use crate::support::scenes::{
    Shot, camera, faceted_sphere, floor, lambert, no_textures, scene, settings,
};

/// Buffers of paths, by name.
const PATHS: [&str; 4] = ["paths", "rays", "queues", "layer_samples"];
/// Those of a scene.
const SCENE: [&str; 7] = [
    "nodes",
    "triangles",
    "vertices",
    "instances",
    "materials",
    "lights",
    "image layers",
];

#[test]
fn what_is_said_is_what_is_taken() {
    let Some(device) = device::open() else {
        return;
    };
    let bodies = [
        (floor(4.0), lambert(Vec3::splat(0.7))),
        (faceted_sphere(64), lambert(Vec3::splat(0.4))),
    ];
    let mut scene = scene(bodies, Vec3::ONE);
    let projection = Projection::Perspective { y_fov: 0.9 };
    let camera = camera(Vec3::new(0.5, 2.0, 5.0), Vec3::ZERO, Vec3::Y, projection);
    let shot = Shot {
        size: (300, 200),
        max_depth: 2,
        spp: 1,
    };
    let procedural = no_textures(&mut scene);
    for layers in [Layers::default(), Layers::all()] {
        let settings = RenderSettings {
            layers: layers.of_scene(&scene),
            ..settings(&camera, shot)
        };
        let said = DeviceMemory::of(&device, &scene, &procedural, &settings);
        let mut renderer = Renderer::new(&device, &scene, &procedural, &settings)
            .unwrap_or_else(|error| panic!("{error}"));
        let rendered = renderer.render(1).and_then(|()| renderer.stats());
        let buffers = rendered.unwrap_or_else(|error| panic!("{error}")).memory;
        let taken = |is_one: &dyn Fn(&str) -> bool| -> u64 {
            let of = buffers.iter().filter(|(name, _)| is_one(name));
            of.map(|(_, bytes)| bytes).sum()
        };
        assert_eq!(said.film, taken(&|name| name.starts_with("film")));
        assert_eq!(said.layers, taken(&|name| name.starts_with("layer ")));
        assert_eq!(said.film + said.layers, snapshot_bytes(&settings));
        assert_eq!(said.paths, taken(&|name| PATHS.contains(&name)));
        // What rays on a processor want is no buffer, and hierarchies are known when they are built.
        let of_scene = taken(&|name| SCENE.contains(&name));
        assert!(said.scene >= of_scene, "{} {of_scene}", said.scene);
        let per_triangle = (said.scene - of_scene) / scene.instanced_triangles();
        assert!(per_triangle <= 128, "{per_triangle} bytes beside buffers");
        // Nothing else counts.
        let rest = taken(&|_| true) - said.film - said.layers - said.paths - of_scene;
        assert!(rest < 1 << 20, "{rest} bytes of what isn't said");
    }
}
