//! Files that move, in miniature.

use super::tests::{floats, import, import_at, import_within, square};
use crate::import::Importer;
use crate::import::budget::Budget;
use crate::input::{Disk, FileId, Files};
use crate::{Moment, Motion, Scene};
use glam::Vec3;
use serde_json::{Value, json};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn usual(seconds: f64) -> Moment {
    Moment {
        seconds,
        motion: Motion::Usual,
    }
}

fn at(tree: &Value, seconds: f64) -> Scene {
    import_at(tree.clone(), &usual(seconds))
        .unwrap_or_else(|error| panic!("{error}"))
        .scene
}

fn error(tree: &Value) -> String {
    let read = import_at(tree.clone(), &usual(0.5)).map(drop);
    read.expect_err("must be refused").to_string()
}

/// A list of a file, which is made where there is none.
fn list<'t>(tree: &'t mut Value, name: &str) -> &'t mut Vec<Value> {
    if tree[name].is_null() {
        tree[name] = json!([]);
    }
    tree[name].as_array_mut().expect("a list")
}

/// Adds numbers as an accessor; its number.
fn accessor(tree: &mut Value, numbers: &[f32], kind: &str) -> usize {
    let width = match kind {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    };
    let buffer = list(tree, "buffers").len();
    list(tree, "buffers").push(floats(numbers));
    let view = list(tree, "bufferViews").len();
    list(tree, "bufferViews").push(json!({ "buffer": buffer, "byteLength": numbers.len() * 4 }));
    let accessor = list(tree, "accessors").len();
    list(tree, "accessors").push(json!({
        "bufferView": view, "componentType": 5126, "count": numbers.len() / width, "type": kind,
    }));
    accessor
}

/// Adds an animation of one channel.
fn animate(tree: &mut Value, node: usize, path: &str, times: &[f32], values: &[f32]) {
    let input = accessor(tree, times, "SCALAR");
    let kind = match path {
        "rotation" => "VEC4",
        "weights" => "SCALAR",
        _ => "VEC3",
    };
    let output = accessor(tree, values, kind);
    list(tree, "animations").push(json!({
        "name": path,
        "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
        "samplers": [{ "input": input, "output": output }],
    }));
}

const RIGHT: [f32; 6] = [0.0, 0.0, 0.0, 4.0, 0.0, 0.0];

#[test]
fn nodes_move_with_their_children_and_not_at_rest() {
    let mut tree = square();
    tree["nodes"] = json!([{ "children": [1], "translation": [0, 7, 0] }, { "mesh": 0 }]);
    animate(&mut tree, 0, "translation", &[1.0, 3.0], &RIGHT);
    animate(
        &mut tree,
        1,
        "scale",
        &[0.0, 2.0],
        &[1.0, 1.0, 1.0, 3.0, 3.0, 3.0],
    );
    let place = |scene: &Scene| {
        let transform = scene.instances[0].transform;
        (transform.translation.to_array(), transform.matrix3.x_axis.x)
    };
    assert_eq!(place(&at(&tree, 0.0)), ([0.0, 0.0, 0.0], 1.0));
    assert_eq!(place(&at(&tree, 1.5)), ([1.0, 0.0, 0.0], 2.5));
    assert_eq!(place(&at(&tree, 99.0)), ([4.0, 0.0, 0.0], 3.0));
    let rest = import(tree.clone()).expect("it is sound").scene;
    assert_eq!(place(&rest), ([0.0, 7.0, 0.0], 1.0));
    // What doesn't move is built as it is without animations.
    assert_eq!(rest.meshes[0].positions, at(&tree, 1.5).meshes[0].positions);
    // One alone.
    let named = |name: &str| {
        let motion = Motion::Named(name.to_owned());
        place(
            &import_at(
                tree.clone(),
                &Moment {
                    seconds: 1.5,
                    motion,
                },
            )
            .unwrap()
            .scene,
        )
    };
    assert_eq!(named("scale"), ([0.0, 7.0, 0.0], 2.5));
    assert_eq!(named("0"), ([1.0, 0.0, 0.0], 1.0));
}

#[test]
fn what_shrinks_to_nothing_is_gone_for_that_time() {
    let mut tree = square();
    animate(
        &mut tree,
        0,
        "scale",
        &[0.0, 1.0],
        &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
    );
    assert_eq!(at(&tree, 0.5).instances.len(), 1);
    assert_eq!(at(&tree, 1.0).instances.len(), 0);
}

#[test]
fn morph_targets_follow_their_weights() {
    let mut tree = square();
    let target = accessor(&mut tree, &[0.0, 0.0, 1.0].repeat(4), "VEC3");
    tree["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }, {}]);
    animate(&mut tree, 0, "weights", &[0.0, 1.0], &[0.0, 0.0, 8.0, 0.0]);
    for (seconds, z) in [(0.0, 0.0), (0.25, 2.0), (1.0, 8.0)] {
        assert_eq!(at(&tree, seconds).meshes[0].positions[0].z, z, "{seconds}");
    }
}

#[test]
fn skins_follow_their_joints() {
    let mut tree = square();
    let joints = accessor(&mut tree, &[0.0; 16], "VEC4");
    tree["accessors"][joints]["componentType"] = 5121.into();
    let weights = accessor(&mut tree, &[1.0, 0.0, 0.0, 0.0].repeat(4), "VEC4");
    tree["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = joints.into();
    tree["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights.into();
    tree["skins"] = json!([{ "joints": [1] }]);
    tree["nodes"] = json!([{ "mesh": 0, "skin": 0 }, {}]);
    animate(&mut tree, 1, "translation", &[0.0, 1.0], &RIGHT);
    assert_eq!(
        at(&tree, 0.5).meshes[0].positions[1],
        Vec3::new(3.0, 0.0, 0.0)
    );
}

/// A crowd: each of its nodes has a skin of its own.
#[test]
fn a_mesh_may_be_posed_many_times() {
    let corner = |i: usize| [i % 3, i / 3 % 2, i % 2].map(|x| x as f32);
    let corners: Vec<f32> = (0..600).flat_map(corner).collect();
    let crowd = |skin: fn(usize) -> usize| {
        let mut tree = json!({});
        let positions = accessor(&mut tree, &corners, "VEC3");
        // Without data: all vertices hang on the first joint, and stay where they are.
        for (ty, component) in [("joints", 5121), ("weights", 5126)] {
            list(&mut tree, "accessors").push(json!({
                "componentType": component, "count": 600, "type": "VEC4", "name": ty,
            }));
        }
        let attributes = json!({
            "POSITION": positions, "JOINTS_0": positions + 1, "WEIGHTS_0": positions + 2,
        });
        tree["meshes"] = json!([{ "primitives": [{ "attributes": attributes }] }]);
        tree["skins"] = vec![json!({ "joints": [0] }); 40].into();
        let person = |number: usize| json!({ "mesh": 0, "skin": skin(number) });
        tree["nodes"] = (0..40).map(person).collect();
        // What its bytes explain, and nothing else.
        import_within(tree, &Moment::default(), Budget::new(0))
    };
    let one = crowd(|_| 0).expect("they share a pose").scene;
    assert_eq!((one.meshes.len(), one.instances.len()), (1, 40));
    let many = crowd(|number| number).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(many.scene.meshes.len(), 40);
}

#[test]
fn animations_that_fight_are_not_mixed() {
    let mut tree = square();
    animate(&mut tree, 0, "translation", &[0.0, 1.0], &RIGHT);
    animate(&mut tree, 0, "translation", &[0.0, 1.0], &[9.0; 6]);
    let imported = import_at(tree, &usual(0.5)).expect("the first one is shown");
    assert_eq!(imported.scene.instances[0].transform.translation.x, 2.0);
    let warnings = imported.warnings.join("\n");
    assert!(
        warnings.contains("only `translation` is shown"),
        "{warnings}"
    );
}

#[test]
fn malformed_animations_are_refused_with_their_place() {
    let mut sound = square();
    animate(&mut sound, 0, "translation", &[0.0, 1.0], &RIGHT);
    let at = |pointer: &str, value: Value| {
        let mut tree = sound.clone();
        *tree
            .pointer_mut(pointer)
            .unwrap_or_else(|| panic!("{pointer}")) = value;
        tree
    };
    let animation = "/animations/0";
    for (pointer, value, says) in [
        ("/animations", json!({}), "animations"),
        ("/animations/0/channels/0", json!(3), "has no target"),
        (
            "/animations/0/channels/0/sampler",
            json!(1),
            "sampler 1 does not exist",
        ),
        (
            "/animations/0/channels/0/sampler",
            json!(-1),
            "sampler is not a number",
        ),
        (
            "/animations/0/channels/0/target/node",
            json!(9),
            "node 9 does not exist",
        ),
        (
            "/animations/0/samplers/0/input",
            json!(99),
            "accessor 99 does not exist",
        ),
        ("/animations/0/samplers/0/input", json!(null), "input"),
        ("/animations/0/samplers/0/output", json!(2), "components"),
        ("/accessors/2/count", json!(1), "has 1 times and 2 values"),
    ] {
        let message = error(&at(pointer, value));
        assert!(
            message.contains(says) && message.contains("animation"),
            "{pointer}: {message}"
        );
    }
    let mut odd = at(
        animation,
        json!({ "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
        "samplers": [{ "input": 2, "output": 3, "interpolation": "CURVED" }] }),
    );
    assert!(error(&odd).contains("CURVED"));
    // A spline has three values for each key.
    odd["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE".into();
    assert!(error(&odd).contains("6 values are needed"));
    for times in [[1.0, 0.0], [0.0, f32::NAN]] {
        let mut tree = square();
        animate(&mut tree, 0, "translation", &times, &RIGHT);
        assert!(error(&tree).contains("animation 0"));
        // At rest nobody asks.
        import(tree).expect("nothing of it is shown");
    }
}

#[test]
fn an_animation_plays_whatever_is_wrong_with_others() {
    let mut tree = square();
    tree["asset"] = json!({ "version": "2.0" });
    animate(&mut tree, 0, "scale", &[1.0, 0.0], &RIGHT);
    animate(&mut tree, 0, "translation", &[0.0, 1.0], &RIGHT);
    let named = |name: &str| Moment {
        seconds: 0.5,
        motion: Motion::Named(name.to_owned()),
    };
    let moved = import_at(tree.clone(), &named("translation")).expect("it is sound");
    assert_eq!(moved.scene.instances[0].transform.translation.x, 2.0);
    let broken = import_at(tree.clone(), &named("scale")).map(drop);
    let broken = broken.expect_err("its times go back").to_string();
    assert!(broken.contains("animation 0"), "{broken}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, serde_json::to_vec(&tree).expect("it is JSON")).expect("written");
    let animations = Importer::new().animations(&path).expect("it is read");
    let told = animations.iter().map(|a| (a.name.as_str(), a.end));
    let expected = [("scale", 0.0), ("translation", 1.0)];
    assert_eq!(told.collect::<Vec<_>>(), expected);
    // Whoever asks for what there is hears of it.
    let problem = crate::import::animations(&path).expect_err("one makes no sense");
    assert!(problem.to_string().contains("animation 0"), "{problem}");
}

#[test]
fn what_cannot_be_moved_stands_still_with_a_warning() {
    let mut tree = square();
    animate(&mut tree, 0, "translation", &[0.0, 1.0], &RIGHT);
    let target = tree["animations"][0]["channels"][0]["target"].clone();
    for (target, says) in [
        (json!({ "path": "pointer" }), "KHR_animation_pointer"),
        (
            json!({ "node": 0, "path": "colour" }),
            "`colour` can't be animated",
        ),
        (json!({ "node": 0, "path": "weights" }), ""),
        (json!({ "path": "translation" }), ""),
        (target, "has a matrix"),
    ] {
        tree["animations"][0]["channels"][0]["target"] = target;
        tree["nodes"][0] = json!({ "mesh": 0 });
        if says == "has a matrix" {
            tree["nodes"][0]["matrix"] = json!(glam::Mat4::IDENTITY.to_cols_array());
        }
        let imported = import_at(tree.clone(), &usual(1.0)).expect("it is shown");
        assert_eq!(imported.scene.instances[0].transform.translation.x, 0.0);
        assert!(
            imported.warnings.join("\n").contains(says),
            "{says}: {:?}",
            imported.warnings
        );
    }
}

/// A file in memory that counts how often it is read.
#[derive(Debug)]
struct Counting(Vec<u8>, std::sync::atomic::AtomicU32);

impl Files for Counting {
    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        self.read_start(path, most)
    }

    fn read_start(&self, _: &Path, most: u64) -> io::Result<Vec<u8>> {
        self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Ok(self.0[..self.0.len().min(most as usize)].to_vec())
    }

    fn has(&self, _: &Path) -> bool {
        true
    }

    fn list(&self, _: &Path) -> io::Result<Vec<PathBuf>> {
        Ok(Vec::new())
    }

    fn write(&self, _: &Path, _: &[u8]) -> io::Result<()> {
        Err(io::ErrorKind::ReadOnlyFilesystem.into())
    }

    fn id(&self, path: &Path) -> FileId {
        Disk.id(path)
    }
}

#[test]
fn one_moment_after_the_other_is_each_as_if_alone() {
    let mut tree = square();
    tree["asset"] = json!({ "version": "2.0" });
    animate(&mut tree, 0, "translation", &[0.0, 1.0], &RIGHT);
    let text = serde_json::to_vec(&tree).expect("it is JSON");
    let files = Arc::new(Counting(text, Default::default()));
    let mut importer = Importer::from_files(files.clone());
    let reads = || files.1.load(std::sync::atomic::Ordering::Relaxed);
    let mut first = 0;
    for seconds in [0.25, 0.5, 0.25] {
        importer.begin(usual(seconds));
        let mut scene = importer
            .load(Path::new("a.gltf"))
            .expect("it is read")
            .scene;
        importer
            .append(&mut scene, Path::new("a.gltf"), glam::Affine3A::IDENTITY)
            .expect("once more");
        let alone = at(&tree, seconds);
        for instance in &scene.instances {
            assert_eq!(instance.transform, alone.instances[0].transform);
        }
        assert_eq!(scene.meshes[1].positions, alone.meshes[0].positions);
        first = if first == 0 { reads() } else { first };
    }
    assert_eq!(reads(), first, "it stays open");
    let animations = importer
        .animations(Path::new("a.gltf"))
        .expect("there is one");
    assert_eq!((animations[0].start, animations[0].end), (0.0, 1.0));
    assert_eq!(
        (&*animations[0].nodes, animations[0].channels),
        (&["node 0".to_owned()][..], [1, 0, 0, 0])
    );
}

/// As a node that mirrors what hangs on it does: fronts stay outside, at rest too.
#[test]
fn skins_that_mirror_stay_right_side_out() {
    let mut tree = square();
    let normals = accessor(&mut tree, &[0.0, 0.0, 1.0].repeat(4), "VEC3");
    let joints = accessor(&mut tree, &[0.0; 16], "VEC4");
    tree["accessors"][joints]["componentType"] = json!(5123);
    let weights = accessor(&mut tree, &[1.0, 0.0, 0.0, 0.0].repeat(4), "VEC4");
    let attributes = &mut tree["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normals);
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    tree["skins"] = json!([{ "joints": [1] }]);
    tree["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "scale": [-1, 1, 1] }]);
    animate(&mut tree, 1, "translation", &[0.0, 1.0], &RIGHT);
    let rest = import(tree.clone()).expect("it is sound").scene;
    for scene in [rest, at(&tree, 0.5)] {
        let mesh = &scene.meshes[0];
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            let normal = (b - a).cross(c - a).normalize();
            assert_eq!(normal, Vec3::Z);
            assert!(
                triangle
                    .iter()
                    .all(|&v| mesh.normals[v as usize] == Vec3::Z)
            );
        }
    }
}

/// With a normal map and no normals, both of which part corners by how a mesh lies.
#[test]
fn what_bends_has_the_same_vertices_at_all_moments() {
    let mut tree = square();
    tree["asset"] = json!({ "version": "2.0" });
    let primitive = |tree: &mut Value, key: &str, value: Value| {
        tree["meshes"][0]["primitives"][0][key] = value;
    };
    let up = [0.0, 0.0, 0.0].repeat(3).into_iter().chain([0.0, 0.0, 1.0]);
    let target = accessor(&mut tree, &up.collect::<Vec<_>>(), "VEC3");
    primitive(&mut tree, "targets", json!([{ "POSITION": target }]));
    let turned = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0];
    let uv = accessor(&mut tree, &turned, "VEC2");
    tree["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uv);
    let pixel = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNoaPgPAAODAgAApfuJAAAAAElFTkSuQmCC";
    tree["images"] = json!([{ "uri": pixel }]);
    tree["textures"] = json!([{ "source": 0 }]);
    tree["materials"] = json!([{ "normalTexture": { "index": 0 } }]);
    primitive(&mut tree, "material", json!(0));
    animate(&mut tree, 0, "weights", &[0.0, 1.0], &[0.0, 1.0]);
    let text = serde_json::to_vec(&tree).expect("it is JSON");
    let mut importer = Importer::from_files(Arc::new(Counting(text, Default::default())));
    let mut meshes = [0.0, 0.5, 1.0].map(|seconds| {
        importer.begin(usual(seconds));
        let read = importer.load(Path::new("a.gltf"));
        read.expect("it is read").scene.meshes.remove(0)
    });
    for mesh in &meshes {
        assert_eq!(mesh.triangles, meshes[0].triangles);
        assert_eq!(mesh.uv0, meshes[0].uv0);
        assert_eq!(mesh.tangents.len(), 6, "flat triangles share none");
        assert_eq!(mesh.unbent.as_deref(), Some(&meshes[0].positions));
    }
    // What is given tangents later is split alike before and after it is bent.
    for mesh in &mut meshes {
        mesh.tangents.clear();
        crate::import::give_tangents(mesh);
    }
    for mesh in &meshes {
        assert_eq!(mesh.triangles, meshes[0].triangles);
        assert_eq!(mesh.unbent.as_deref(), Some(&meshes[0].positions));
    }
}

#[test]
fn what_is_scaled_to_nothing_is_known_by_its_name() {
    let mut tree = square();
    tree["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "name": "Lamp" }] } });
    tree["materials"] = json!([{ "name": "unused" }]);
    tree["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }]);
    let light = json!({ "KHR_lights_punctual": { "light": 0 } });
    tree["nodes"] = json!([
        { "name": "Body", "children": [1, 2], "mesh": 0 },
        { "name": "Bulb", "extensions": light },
        { "name": "Eye", "camera": 0 },
    ]);
    let scales = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    animate(&mut tree, 0, "scale", &[0.0, 1.0], &scales);
    let there = import_at(tree.clone(), &usual(0.0)).expect("it is sound");
    assert_eq!(there.names.lights, ["Bulb"]);
    assert!(there.names.gone_meshes.is_empty() && there.names.gone_lights.is_empty());
    let gone = import_at(tree, &usual(1.0)).expect("it is sound");
    assert!(gone.scene.instances.is_empty() && gone.scene.lights.is_empty());
    assert!(gone.names.gone_meshes.contains("Body"));
    let lamp = ("Bulb".to_owned(), "Lamp".to_owned());
    assert!(gone.names.lights.is_empty() && gone.names.gone_lights.contains(&lamp));
    // The material of what has none, and the camera, are those of all moments.
    let names = |scene: &Scene| {
        scene
            .materials
            .iter()
            .map(|m| m.name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(names(&gone.scene), ["unused", "default"]);
    assert_eq!(names(&there.scene), names(&gone.scene));
    let transform = |scene: &Scene| scene.cameras[0].transform;
    assert_eq!(transform(&there.scene), transform(&gone.scene));
}

/// It isn't there at any moment, so that its name is free.
#[test]
fn a_light_that_can_not_be_used_is_not_gone() {
    let mut tree = square();
    tree["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "torch" }, { "type": "point", "intensity": -1 }, { "type": "spot", "color": [1, -1, 1] },
        { "type": "spot", "name": "Beam" },
    ] } });
    let node = |light: usize| json!({ "name": format!("L{light}"), "scale": [0, 0, 0], "extensions": { "KHR_lights_punctual": { "light": light } } });
    let body = json!({ "mesh": 0, "children": [1, 2, 3, 4] });
    let nodes = std::iter::once(body).chain((0..4).map(node));
    tree["nodes"] = nodes.collect();
    // Nothing brings one back in a file that never moves.
    let still = import(tree.clone()).expect("it is sound");
    assert!(still.scene.lights.is_empty() && still.names.gone_lights.is_empty());
    animate(&mut tree, 0, "translation", &[0.0, 1.0], &RIGHT);
    let read = import(tree).expect("it is sound");
    assert!(read.scene.lights.is_empty());
    let gone: Vec<_> = read.names.gone_lights.into_iter().collect();
    assert_eq!(gone, [("L3".to_owned(), "Beam".to_owned())]);
}

#[test]
fn the_environment_is_decoded_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, sky) = (folder.path().join("a.gltf"), folder.path().join("sky.png"));
    let mut tree = square();
    tree["asset"] = json!({ "version": "2.0" });
    tree["scenes"] = json!([{ "nodes": [0], "extras": { "environment": { "uri": "sky.png" } } }]);
    animate(&mut tree, 0, "translation", &[0.0, 1.0], &RIGHT);
    std::fs::write(&path, tree.to_string()).expect("written");
    let pixels = image::RgbImage::from_pixel(2, 1, image::Rgb([9, 200, 90]));
    pixels.save(&sky).expect("a picture");
    let mut importer = Importer::new();
    for seconds in [0.0, 0.5] {
        importer.begin(usual(seconds));
        let read = importer.load(&path).expect("it is sound");
        assert!(read.environment_problem.is_none());
        let crate::Environment::Image { image, .. } = read.scene.environment else {
            panic!("it has a picture");
        };
        assert_eq!((image.width, image.height), (2, 1));
        // From now on it is what was kept.
        let _ = std::fs::remove_file(&sky);
    }
}
