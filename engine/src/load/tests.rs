//! Loading as users see it: the demo, and looks that name what isn't there.

use std::collections::BTreeMap;
use std::{fs, io};

use super::*;

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/demo/demo.gltf")
}

/// Loads the demo scene with a look of this text.
fn with_look(text: &str) -> Result<Loaded, LoadError> {
    let folder = tempfile_folder();
    let look = folder.join("test.look.toml");
    fs::write(&look, text).expect("the temporary folder can be written");
    let loaded = load(&demo(), Some(&look), &[]);
    fs::remove_dir_all(&folder).expect("the folder is ours");
    loaded
}

fn tempfile_folder() -> PathBuf {
    use std::sync::atomic::{AtomicU32, Ordering};
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("patina-load-{}-{number}", std::process::id()));
    fs::create_dir_all(&folder).expect("the temporary folder can be written");
    folder
}

#[test]
fn a_scene_without_a_look_has_its_own_camera_and_nothing_procedural() {
    let loaded = load(&demo(), None, &[]).expect("the demo loads");
    assert_eq!(loaded.camera.name, "Camera");
    assert!(loaded.procedural.is_empty());
    assert!(loaded.camera_named("Camera").is_ok());
    let error = loaded.camera_named("Kamera").unwrap_err().to_string();
    assert!(error.contains("did you mean `Camera`?"), "{error}");
}

#[test]
fn the_camera_of_a_look_overrides_the_file() {
    let loaded = with_look(
        "[camera]\nposition = [0, 1, 5]\nlook_at = [0, 1, 0]\ny_fov = 90\naperture_radius = 0.1",
    )
    .unwrap();
    let camera = loaded.camera;
    let forward = camera.transform.transform_vector3(glam::Vec3::NEG_Z);
    assert!(forward.distance(glam::Vec3::NEG_Z) < 1e-6, "{forward}");
    assert!(
        camera
            .transform
            .transform_vector3(glam::Vec3::Y)
            .distance(glam::Vec3::Y)
            < 1e-6
    );
    assert_eq!(camera.focus_distance, 5.0);
    assert_eq!(camera.aperture_radius, 0.1);
    let crate::scene::Projection::Perspective { y_fov } = camera.projection else {
        panic!("y_fov makes it perspective");
    };
    assert!((y_fov - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
}

#[test]
fn a_view_of_everything_fits_narrow_pictures() {
    let away = |loaded: &Loaded| {
        let narrow = loaded.camera_for(0.5).transform.translation;
        narrow.distance(loaded.camera.transform.translation)
    };
    let mut loaded = load(&demo(), None, &[]).expect("the demo loads");
    assert_eq!(away(&loaded), 0.0, "it has a camera");
    for text in ["", "[camera]\nblades = 6", "[camera]\nposition = [0, 1, 5]"] {
        let chosen = with_look(text).expect("a look").look.expect("one");
        let is_placed = chosen.camera.position.is_some();
        loaded.look = Some(chosen);
        loaded.scene.cameras.clear();
        loaded.camera = default_camera(&loaded.scene);
        assert_eq!(away(&loaded) == 0.0, is_placed, "{text}");
    }
}

#[test]
fn an_f_number_is_a_radius_by_the_focal_length() {
    let camera = |text: &str| with_look(&format!("[camera]\n{text}")).map(|loaded| loaded.camera);
    // 24 mm high, 90 degrees: a focal length of 12 mm.
    let lens = camera("y_fov = 90\nf_number = 2\nblades = 6\nblade_rotation = 90").unwrap();
    assert!((lens.aperture_radius - 0.003).abs() < 1e-7);
    assert_eq!(lens.aperture_blades, 6);
    assert!((lens.aperture_rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    let small = camera("y_fov = 90\nf_number = 2\nsensor_height = 0.012").unwrap();
    assert!((small.aperture_radius - 0.0015).abs() < 1e-7);
    for (text, mentions) in [
        ("f_number = 2\naperture_radius = 0.1", "leave out one"),
        ("blades = 2", "from 3 to 32"),
        ("f_number = 0", "greater than 0"),
    ] {
        let error = camera(text).unwrap_err().to_string();
        assert!(error.contains(mentions), "{text}: {error}");
    }
}

#[test]
fn an_include_is_placed_named_and_thinned() {
    let scene = demo();
    let text = format!(
        "[[include]]\nfile = {:?}\nname = 'copy'\nonly = ['Gear']\ntranslation = [10, 0, 0]\nscale = 2\n[material.'copy/Steel']\nroughness = 0.125",
        scene.display().to_string()
    );
    let plain = load(&scene, None, &[]).unwrap();
    let loaded = with_look(&text).unwrap();
    assert_eq!(
        loaded.scene.instances.len(),
        plain.scene.instances.len() + 1
    );
    assert_eq!(loaded.scene.meshes.len(), plain.scene.meshes.len() + 1);
    let gear = plain
        .scene
        .instances
        .iter()
        .find(|i| i.name == "Gear")
        .unwrap();
    let copy = loaded.scene.instances.last().unwrap();
    let expected = glam::Vec3A::new(10.0, 0.0, 0.0) + gear.transform.translation * 2.0;
    assert!(copy.transform.translation.distance(expected) < 1e-4);
    let mesh = &loaded.scene.meshes[copy.mesh as usize];
    let material = &loaded.scene.materials[mesh.triangle_materials[0] as usize];
    assert_eq!(
        (material.name.as_str(), material.roughness),
        ("copy/Steel", 0.125)
    );
    let original = plain
        .scene
        .materials
        .iter()
        .find(|m| m.name == "Steel")
        .unwrap();
    assert_ne!(original.roughness, 0.125);
}

#[track_caller]
fn refused(text: &str, place: &str, says: &str) {
    let error = with_look(text).expect_err("this look is wrong").to_string();
    assert!(error.contains(place) && error.contains(says), "{error}");
}

#[test]
fn mistakes_name_line_and_remedy() {
    refused(
        "[camera]\nname = 'Camra'",
        "test.look.toml:2:8",
        "did you mean `Camera`?",
    );
    refused(
        "[camera]\nposition = [1, 2, 3]\nlook_at = [1, 2, 3]",
        "test.look.toml:3:11",
        "no direction",
    );
    refused(
        "[[include]]\nfile = 'missing.glb'",
        "test.look.toml:2:8",
        "missing.glb",
    );
    refused(
        "environment = { image = 'missing.hdr' }",
        "test.look.toml:1:25",
        "missing.hdr",
    );
    let gear = format!(
        "[[include]]\nfile = {:?}\nonly = ['Gaer']",
        demo().display().to_string()
    );
    refused(&gear, "test.look.toml:3:9", "did you mean `Gear`?");
    refused(
        "[material.Stel]\nroughness = 1",
        "test.look.toml:1:11",
        "did you mean `Steel`?",
    );
    refused(
        "[material.Steel]\nalpha_cutoff = 0.5",
        "test.look.toml:2:16",
        "alpha_mode",
    );
}

#[test]
fn a_sky_comes_with_its_sun() {
    let lights = |sky: &str| {
        let look = format!("environment = {{ sky = {{ {sky} }}, intensity = 2 }}");
        with_look(&look).expect("it loads").scene
    };
    let scene = lights("sun_elevation = 30");
    assert!(matches!(
        scene.environment,
        Environment::Image { intensity: 2.0, .. }
    ));
    let sun = scene.lights.last().expect("it is up");
    assert!((sun.direction.y + 0.5).abs() < 1e-5 && sun.intensity.x > 3.0);
    assert!(matches!(sun.kind, crate::scene::LightKind::Disk { .. }));
    assert!(lights("sun_elevation = -3").lights.is_empty());
    assert!(lights("sun = false").lights.is_empty());
}

#[test]
fn blends_of_constant_materials_need_no_textures() {
    let text = "[material.Steel]\nblend = { base = 'Steel', over = 'Dust', mask = 0.25 }\n[material.Dust]\nbase_color = '#fff'";
    let loaded = with_look(text).unwrap();
    let index = loaded
        .scene
        .materials
        .iter()
        .position(|m| m.name == "Steel")
        .unwrap() as u32;
    assert!(loaded.procedural.is_procedural(index));
    refused(
        "[material.Steel]\nblend = { base = 'Copper', over = 'Steel', mask = 0.25 }",
        "2:9",
        "blended from itself",
    );
    refused(
        "[material.Steel]\nblend = { base = 'Copper', over = 'Floor', mask = 0.5 }\n[material.Floor]\nblend = { base = 'Steel', over = 'Stone', mask = 0.5 }",
        "test.look.toml:",
        "blended from itself",
    );
    refused(
        "[material.Steel]\nblend = { base = 'Steel', over = 'Coper', mask = 0.25 }",
        "2:34",
        "did you mean `Copper`?",
    );
}

#[test]
fn a_scene_without_triangles_is_an_error() {
    let folder = tempfile_folder();
    let path = folder.join("empty.gltf");
    fs::write(
        &path,
        r#"{"asset":{"version":"2.0"},"scenes":[{}],"scene":0}"#,
    )
    .unwrap();
    let error = load(&path, None, &[]).unwrap_err();
    fs::remove_dir_all(&folder).unwrap();
    assert!(matches!(error, LoadError::Empty { .. }), "{error}");
}

/// Files in memory, and nothing but them.
#[derive(Debug)]
struct InMemory(BTreeMap<PathBuf, Vec<u8>>);

impl Files for InMemory {
    fn read_start(&self, path: &Path, length: u64) -> io::Result<Vec<u8>> {
        let mut bytes = self.read(path, u64::MAX)?;
        bytes.truncate(usize::try_from(length).unwrap_or(usize::MAX));
        Ok(bytes)
    }

    fn read(&self, path: &Path, _: u64) -> io::Result<Vec<u8>> {
        let bytes = self.0.get(path).cloned();
        bytes.ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn has(&self, path: &Path) -> bool {
        self.0.contains_key(path)
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<PathBuf>> {
        let paths = self.0.keys().filter(|path| path.parent() == Some(folder));
        Ok(paths.cloned().collect())
    }

    fn write(&self, _: &Path, _: &[u8]) -> io::Result<()> {
        Err(io::ErrorKind::ReadOnlyFilesystem.into())
    }
}

impl Assets for InMemory {}

/// A triangle whose positions and picture are files beside it.
const TRIANGLE: &str = r#"{
    "asset": { "version": "2.0" },
    "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
    "materials": [{ "name": "Plain", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
    "textures": [{ "source": 0 }], "images": [{ "uri": "a%20picture.png" }],
    "buffers": [{ "uri": "corners.bin", "byteLength": 36 }],
    "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
    "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [0, 0, 0], "max": [1, 1, 0] }]
}"#;

#[test]
fn everything_that_a_picture_is_made_of_may_lie_in_memory() {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut png = io::Cursor::new(Vec::new());
    let picture = image::RgbaImage::from_pixel(2, 2, image::Rgba([200, 100, 50, 255]));
    let written = picture.write_to(&mut png, image::ImageFormat::Png);
    written.expect("memory takes everything");
    let look = "environment = { image = 'sky.png' }\n[[include]]\nfile = 'more/triangle.gltf'\n\
                [node.shown]\ntexture = 'show'\npicture = 'painted.png'\n\
                [material.Plain]\nroughness = 'shown.x'\n";
    let texture =
        "fn userProc(picture: sam2D) -> vec4f { return tex2D(picture, vec2f(0.5)); }".to_owned();
    let corners: Vec<u8> = corners.into_iter().flat_map(f32::to_le_bytes).collect();
    let png = png.into_inner();
    let files: Arc<dyn Assets> = Arc::new(InMemory(
        [
            ("here/triangle.gltf", TRIANGLE.as_bytes().to_vec()),
            ("here/corners.bin", corners.clone()),
            ("here/a picture.png", png.clone()),
            ("here/more/triangle.gltf", TRIANGLE.as_bytes().to_vec()),
            ("here/more/corners.bin", corners),
            ("here/more/a picture.png", png.clone()),
            ("here/sky.png", png.clone()),
            ("here/painted.png", png),
            ("here/textures/show.wgsl", texture.into_bytes()),
        ]
        .map(|(path, bytes)| (PathBuf::from(path), bytes))
        .into(),
    ));
    let scene = Path::new("here/triangle.gltf");
    let look = Look::parse(Path::new("here/a.look.toml"), look).unwrap_or_else(|e| panic!("{e}"));
    let loaded = load_from(&files, scene, Some(look), &["here/textures".into()]);
    let loaded = loaded.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.scene.instances.len(), 2);
    // Of the two triangles, each its own, and that of the node.
    assert_eq!(loaded.scene.images.len(), 3);
    assert!(matches!(
        loaded.scene.environment,
        Environment::Image { .. }
    ));
    assert!(loaded.procedural.graph().library().get("show").is_some());
    let found = loaded.files(&*files, scene, None);
    for name in [
        "corners.bin",
        "a picture.png",
        "more/corners.bin",
        "sky.png",
        "painted.png",
        "textures/show.wgsl",
    ] {
        assert!(found.contains(&Path::new("here").join(name)), "{name}");
    }
    let missing = load_from(&files, Path::new("elsewhere.glb"), None, &[]);
    assert!(matches!(missing, Err(LoadError::Import(_))));
}

/// A triangle under a look without an environment, as a file with these materials and extras of its scene has it.
fn triangle_with(materials: &str, extras: &str) -> Loaded {
    let corners: Vec<u8> = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let gltf = format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [0], "extras": {extras} }}], "nodes": [{{ "mesh": 0 }}],
            "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0, "TEXCOORD_0": 1 }}, "material": 0 }}] }}],
            "materials": [{materials}], "textures": [{{ "source": 0 }}], "images": [{{ "uri": "glow.png" }}],
            "buffers": [{{ "uri": "corners.bin", "byteLength": 36 }}], "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}, {{ "buffer": 0, "byteLength": 24 }}],
            "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }},
                {{ "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" }}] }}"#
    );
    let folder = tempfile_folder();
    fs::write(folder.join("corners.bin"), corners).expect("a file");
    image::RgbImage::from_pixel(2, 2, image::Rgb([9, 200, 90]))
        .save(folder.join("glow.png"))
        .expect("a picture");
    let path = folder.join("triangle.gltf");
    fs::write(&path, gltf).expect("a file");
    let loaded = load(&path, None, &[]).unwrap_or_else(|error| panic!("{error}"));
    fs::remove_dir_all(&folder).expect("the folder is ours");
    loaded
}

#[test]
fn what_has_neither_lamps_nor_surroundings_is_seen_in_another_light() {
    let display = r#"{ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 } }"#;
    let bright = r#"{ "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 },
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 5 } } }"#;
    let lamp = r#"{ "emissiveFactor": [0.5, 0.5, 0.5] }"#;
    let own = r#"{ "environment": { "constant": [0.25, 0.5, 1] } }"#;
    for (materials, extras, is_white) in [
        ("{}", "{}", true),
        (display, "{}", true),
        (bright, "{}", false),
        (lamp, "{}", false),
        ("{}", own, false),
    ] {
        let mut loaded = triangle_with(materials, extras);
        let sky = |loaded: &Loaded| match loaded.scene.environment {
            Environment::Constant(color) => color,
            Environment::Image { .. } => panic!("no picture was named"),
        };
        let given = sky(&loaded);
        assert_eq!(given == glam::Vec3::ONE, is_white, "{materials} {extras}");
        assert_eq!(
            loaded.warnings.is_empty(),
            !is_white,
            "{materials} {extras}"
        );
        // A light that takes its place leaves alone what is the file's.
        loaded.lit_by(StandIn::Dark);
        let left = if is_white { glam::Vec3::ZERO } else { given };
        assert_eq!(sky(&loaded), left, "{materials} {extras}");
    }
}

/// Three triangles, of which one is scaled to nothing, and a lamp that is, too. It has an animation: another moment may be another one.
const HALF_GONE: &str = r#"{
    "asset": { "version": "2.0" }, "extensionsUsed": ["KHR_lights_punctual"], "animations": [{ "channels": [], "samplers": [] }],
    "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "spot", "name": "Beam" }, { "type": "point", "name": "Glow" }] } },
    "scenes": [{ "nodes": [0, 1, 2, 3, 4], "extras": { "environment": { "uri": "no such.exr" } } }],
    "nodes": [{ "mesh": 0, "name": "Gone", "scale": [0, 0, 0] }, { "mesh": 0, "name": "Body" }, { "mesh": 0, "name": "Other" },
        { "name": "Spot", "scale": [0, 0, 0], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        { "name": "Bulb", "extensions": { "KHR_lights_punctual": { "light": 1 } } }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }], "materials": [{ "name": "Unused" }],
    "buffers": [{ "byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }],
    "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
    "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }] }"#;

/// Nothing flashes where the only lamp is switched off by its size.
#[test]
fn nothing_stands_in_for_a_lamp_that_is_gone_at_the_moment() {
    let file = |nodes: &str, more: &str| {
        let text = HALF_GONE
            .replace(
                r#", "extras": { "environment": { "uri": "no such.exr" } }"#,
                "",
            )
            .replace("[0, 1, 2, 3, 4]", nodes)
            .replace(r#""type": "spot""#, &format!(r#""type": "spot"{more}"#));
        text.into_bytes()
    };
    let still = file("[0, 1, 2, 3]", "");
    let still = String::from_utf8_lossy(&still).replace("\"animations\"", "\"others\"");
    let still = still.into_bytes();
    let files: Arc<dyn Assets> = Arc::new(InMemory(
        [
            ("bare.gltf", file("[0, 1, 2]", "")),
            ("lit.gltf", file("[0, 1, 2, 3]", "")),
            ("wrong.gltf", file("[0, 1, 2, 3]", r#", "intensity": -1"#)),
            ("still.gltf", still),
        ]
        .map(|(name, bytes)| (PathBuf::from(name), bytes))
        .into(),
    ));
    let include = "[[include]]\nname = 'more'\nfile = 'lit.gltf'\n";
    let own = "[light.Beam]\ntype = 'point'\nposition = [0, 1, 0]\n";
    for (name, look, is_white) in [
        ("bare.gltf", None, true),
        ("lit.gltf", None, false),
        ("lit.gltf", Some(String::new()), false),
        ("bare.gltf", Some(include.to_owned()), false),
        (
            "bare.gltf",
            Some(format!("{include}only = ['Body']\n")),
            true,
        ),
        // What can't be a lamp at any moment is none that is gone.
        ("wrong.gltf", None, true),
        // Nor what never moves.
        ("still.gltf", None, true),
        ("wrong.gltf", Some(own.to_owned()), false),
    ] {
        let parsed = look.as_ref().map(|text| {
            Look::parse(Path::new("a.look.toml"), text).unwrap_or_else(|e| panic!("{e}"))
        });
        let loaded = load_from(&files, Path::new(name), parsed, &[]);
        let mut loaded = loaded.unwrap_or_else(|error| panic!("{name} {look:?}: {error}"));
        assert_eq!(
            !is_black(&loaded.scene.environment),
            is_white,
            "{name} {look:?}"
        );
        let told = loaded.warnings.to_string();
        assert_eq!(
            told.contains("neither lamps"),
            is_white,
            "{name} {look:?}: {told}"
        );
        loaded.lit_by(StandIn::Studio);
        assert_eq!(
            !is_black(&loaded.scene.environment),
            is_white,
            "{name} {look:?}"
        );
    }
}

#[test]
fn what_is_gone_at_the_moment_is_no_mistake() {
    let files: Arc<dyn Assets> = Arc::new(InMemory(
        [(PathBuf::from("half.gltf"), HALF_GONE.as_bytes().to_vec())].into(),
    ));
    let loaded = |text: &str| {
        let look = Look::parse(Path::new("a.look.toml"), text).unwrap_or_else(|e| panic!("{e}"));
        load_from(&files, Path::new("half.gltf"), Some(look), &[])
    };
    let lit = "environment = { color = [1, 1, 1] }\n";
    let include = "[[include]]\nfile = 'half.gltf'\nname = 'more'\nonly = ";
    for (text, instances, lights) in [
        (String::new(), 2, 1),
        ("[light.Beam]\nintensity = 2".to_owned(), 2, 1),
        ("[material.default]\nroughness = 0.5".to_owned(), 2, 1),
        (format!("{include}['Gone']"), 2, 1),
        (
            format!("{include}['Gone', 'Body', 'Spot']\n[light.Beam]\non = false"),
            3,
            1,
        ),
        // By the name of the node, and by its own.
        (format!("{include}['Bulb']"), 2, 2),
        (format!("{include}['Glow']"), 2, 2),
    ] {
        let scene = loaded(&format!("{lit}{text}"));
        let scene = scene
            .unwrap_or_else(|error| panic!("{text}: {error}"))
            .scene;
        assert_eq!(scene.instances.len(), instances, "{text}");
        assert_eq!(scene.lights.len(), lights, "{text}");
    }
    for (text, says) in [
        (
            format!("{lit}[light.Baem]\non = false"),
            "did you mean `Beam`?",
        ),
        (format!("{lit}{include}['Gome']"), "did you mean `Gone`?"),
        // Without another one, its own environment is wanted.
        (String::new(), "no such.exr"),
    ] {
        let error = loaded(&text).expect_err("it is wrong").to_string();
        assert!(error.contains(says), "{text}: {error}");
    }
    let warnings = loaded(lit).expect("it loads").warnings;
    let told = warnings.iter().any(|w| w.message.contains("no such.exr"));
    assert!(told, "{warnings}");
}
