//! `patina info` of a scene: meshes, materials with what drives them, images, cameras, lights, and what nothing uses.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use engine::load;
use engine::scene::import;
use engine::scene::look::{Look, MaterialLook};
use engine::scene::material_parameters::{Constant, Number, PARAMETERS, Parameter, Takes, Unit};
use engine::scene::{
    Animation, Camera, Environment, Image, LightKind, Material, Mesh, Projection, PunctualLight,
    Scene, TEXTURES,
};
use serde::Serialize;

use crate::console::{self, grouped};
use crate::failure::Failure;

use super::animation::AnimationInfo;
use super::look::{Driven, unused_nodes};
use super::table::{counted, number, numbers, section};

/// A scene, with what a look makes of it where there is one.
#[derive(Serialize)]
pub(super) struct SceneInfo {
    file: String,
    look: Option<String>,
    /// With every place of every mesh counted.
    triangles: u64,
    /// Places of meshes.
    instances: usize,
    /// Lowest and highest corner, metres; absent where there is nothing.
    bounds: Option<[[f32; 3]; 2]>,
    /// For people.
    environment: String,
    meshes: Vec<MeshInfo>,
    materials: Vec<MaterialInfo>,
    images: Vec<ImageInfo>,
    cameras: Vec<CameraInfo>,
    lights: Vec<LightInfo>,
    animations: Vec<AnimationInfo>,
    unused: Unused,
}

#[derive(Serialize)]
struct MeshInfo {
    name: String,
    triangles: usize,
    vertices: usize,
    /// How often it is placed.
    instances: usize,
    /// Sets of texture coordinates.
    texture_coordinates: usize,
    /// It has colours at its vertices.
    colors: bool,
    tangents: bool,
    /// Custom attributes, which textures read.
    attributes: Vec<String>,
    materials: Vec<String>,
}

#[derive(Serialize)]
struct MaterialInfo {
    name: String,
    /// With every place of every mesh counted; those of a blend are its own, not its sides'.
    triangles: u64,
    /// Constants that aren't those of glTF's default material, as a look would have them.
    constants: Vec<(&'static str, String)>,
    /// Its textures, by what they are read for.
    images: Vec<(&'static str, String)>,
    /// What the look says of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    look: Option<Driven>,
}

#[derive(Serialize)]
struct ImageInfo {
    name: String,
    width: u32,
    height: u32,
    /// Colour, not data.
    srgb: bool,
}

#[derive(Serialize)]
struct CameraInfo {
    name: String,
    position: [f32; 3],
    /// Unit direction in which it looks.
    direction: [f32; 3],
    /// Degrees, of a perspective one.
    y_fov: Option<f32>,
    /// Height of the view in metres, of an orthographic one.
    height: Option<f32>,
    /// Of the lens, metres.
    aperture_radius: f32,
}

#[derive(Serialize)]
struct LightInfo {
    name: String,
    kind: &'static str,
    /// W/sr; of a directional light and a disk W/m².
    intensity: [f32; 3],
    position: Option<[f32; 3]>,
    direction: Option<[f32; 3]>,
}

/// What is there and makes no difference.
#[derive(Debug, Default, PartialEq, Serialize)]
struct Unused {
    /// On no triangle, and in no blend that is on one.
    materials: Vec<String>,
    /// Placed nowhere.
    meshes: Vec<String>,
    /// Of no material that is used.
    images: Vec<String>,
    /// Nodes of the look that feed no material.
    nodes: Vec<String>,
    /// Tables of the look for materials that are unused.
    look_materials: Vec<String>,
}

impl SceneInfo {
    /// Reads a scene, and the look where one is given, with textures from some folders.
    pub(super) fn read(
        path: &Path,
        look: Option<&Path>,
        textures: &[PathBuf],
    ) -> Result<Self, Failure> {
        let Some(look) = look else {
            let imported = import::load(path).map_err(Failure::because)?;
            let warnings = imported.warnings.iter();
            warnings.for_each(|warning| console::warning(warning));
            return Ok(Self::of(path, &imported.scene, &animations(path), None));
        };
        let mut loaded = load::load(path, Some(look), textures)?;
        console::diagnostics(&loaded.warnings);
        let animations = animations(path);
        let look = loaded.look.as_ref();
        // What blends with itself has a surface below it that nobody has named; it is on no triangle.
        let own = loaded.procedural.scene_materials();
        let is_named = |name: &str| look.is_some_and(|look| table(look, name).is_some());
        let mut index = 0..;
        loaded.scene.materials.retain(|material| {
            let is_own = index.next().is_some_and(|index| index < own);
            is_own || is_named(&material.name)
        });
        Ok(Self::of(path, &loaded.scene, &animations, look))
    }

    fn of(path: &Path, scene: &Scene, animations: &[Animation], look: Option<&Look>) -> Self {
        let triangles = triangles_of_materials(scene);
        let says = |name: &str| look.and_then(|look| Some(Driven::of(table(look, name)?, look)));
        let places = places_of_meshes(scene);
        let materials = scene.materials.iter().zip(&triangles);
        Self {
            file: path.display().to_string(),
            look: look.map(|look| look.path.display().to_string()),
            triangles: scene.instanced_triangles(),
            instances: scene.instances.len(),
            bounds: (scene.bounds()).map(|(low, high)| [low.to_array(), high.to_array()]),
            environment: environment(&scene.environment),
            meshes: (scene.meshes.iter().zip(&places))
                .map(|(mesh, &instances)| MeshInfo::of(mesh, instances, scene))
                .collect(),
            materials: materials
                .map(|(material, &triangles)| {
                    let look = says(&material.name);
                    MaterialInfo {
                        name: material.name.clone(),
                        triangles,
                        constants: constants(material, look.as_ref()),
                        images: images(material, scene),
                        look,
                    }
                })
                .collect(),
            images: scene.images.iter().map(ImageInfo::of).collect(),
            cameras: scene.cameras.iter().map(CameraInfo::of).collect(),
            lights: scene.lights.iter().map(LightInfo::of).collect(),
            animations: animations.iter().map(AnimationInfo::of).collect(),
            unused: Unused::of(scene, look, &triangles, &places),
        }
    }

    pub(super) fn text(&self) -> String {
        let mut text = format!("{}: a scene", self.file);
        if let Some(look) = &self.look {
            text += &format!(", with {look}");
        }
        text += &format!(
            "\n  triangles    {} in {} of {}\n",
            grouped(self.triangles),
            counted(self.instances, "place", "places"),
            counted(self.meshes.len(), "mesh", "meshes")
        );
        if let Some([low, high]) = &self.bounds {
            let size: Vec<f32> = high.iter().zip(low).map(|(high, low)| high - low).collect();
            text += &format!(
                "  bounds       {} to {} m: {} m\n",
                numbers(low),
                numbers(high),
                numbers(&size)
            );
        }
        text += &format!("  environment  {}\n", self.environment);
        let rows: [(&str, Vec<Vec<String>>); 6] = [
            ("meshes", self.meshes.iter().map(MeshInfo::row).collect()),
            (
                "materials",
                self.materials.iter().map(MaterialInfo::row).collect(),
            ),
            ("images", self.images.iter().map(ImageInfo::row).collect()),
            (
                "cameras",
                self.cameras.iter().map(CameraInfo::row).collect(),
            ),
            ("lights", self.lights.iter().map(LightInfo::row).collect()),
            (
                "animations",
                self.animations.iter().map(AnimationInfo::row).collect(),
            ),
        ];
        for (title, rows) in &rows {
            text += &section(title, rows);
        }
        text + &section("unused", &self.unused.rows())
    }
}

impl MeshInfo {
    fn of(mesh: &Mesh, instances: usize, scene: &Scene) -> Self {
        let materials: BTreeSet<u32> = mesh.triangle_materials.iter().copied().collect();
        let name = |index: &u32| Some(scene.materials.get(*index as usize)?.name.clone());
        let custom = mesh.custom.iter();
        Self {
            name: mesh.name.clone(),
            triangles: mesh.triangles.len(),
            vertices: mesh.positions.len(),
            instances,
            texture_coordinates: [&mesh.uv0, &mesh.uv1]
                .iter()
                .filter(|set| !set.is_empty())
                .count(),
            colors: !mesh.colors.is_empty(),
            tangents: !mesh.tangents.is_empty(),
            attributes: custom.map(|attribute| attribute.name.clone()).collect(),
            materials: materials.iter().filter_map(name).collect(),
        }
    }

    fn row(&self) -> Vec<String> {
        let mut has = Vec::new();
        match self.texture_coordinates {
            0 => has.push("no texture coordinates".to_owned()),
            1 => has.push("texture coordinates".to_owned()),
            n => has.push(format!("{n} texture coordinates")),
        }
        if self.colors {
            has.push("colours".to_owned());
        }
        if self.tangents {
            has.push("tangents".to_owned());
        }
        has.extend(self.attributes.iter().cloned());
        vec![
            self.name.clone(),
            counted(self.triangles, "triangle", "triangles"),
            counted(self.instances, "place", "places"),
            has.join(", "),
            self.materials.join(", "),
        ]
    }
}

impl MaterialInfo {
    fn row(&self) -> Vec<String> {
        let mut says: Vec<String> = Vec::new();
        if let Some(look) = &self.look {
            // What it sets is among the constants.
            let driven = Driven {
                set: Vec::new(),
                ..look.clone()
            };
            says.push(driven.text());
        }
        let named = |(key, value): &(&str, String)| format!("{key} = {value}");
        says.extend(self.images.iter().map(named));
        says.extend(self.constants.iter().map(named));
        says.retain(|words| !words.is_empty());
        vec![
            self.name.clone(),
            format!("{} triangles", grouped(self.triangles)),
            says.join(", "),
        ]
    }
}

impl ImageInfo {
    fn of(image: &Image) -> Self {
        Self {
            name: image.short_name().to_owned(),
            width: image.width,
            height: image.height,
            srgb: image.srgb,
        }
    }

    fn row(&self) -> Vec<String> {
        let kind = match self.srgb {
            true => "colour",
            false => "data",
        };
        vec![
            self.name.clone(),
            format!("{}x{}", self.width, self.height),
            kind.to_owned(),
        ]
    }
}

impl CameraInfo {
    fn of(camera: &Camera) -> Self {
        let (y_fov, height) = match camera.projection {
            Projection::Perspective { y_fov } => (Some(y_fov.to_degrees()), None),
            Projection::Orthographic { y_mag } => (None, Some(2.0 * y_mag)),
        };
        Self {
            name: camera.name.clone(),
            position: camera.transform.translation.to_array(),
            direction: (-camera.transform.matrix3.z_axis).to_array(),
            y_fov,
            height,
            aperture_radius: camera.aperture_radius,
        }
    }

    fn row(&self) -> Vec<String> {
        let kind = match (self.y_fov, self.height) {
            (Some(y_fov), _) => format!("perspective, {}°", number(y_fov)),
            (_, Some(height)) => format!("orthographic, {} m", number(height)),
            _ => String::new(),
        };
        let lens = match self.aperture_radius > 0.0 {
            true => format!("lens of {} m", number(2.0 * self.aperture_radius)),
            false => String::new(),
        };
        vec![
            self.name.clone(),
            kind,
            format!("at {}", numbers(&self.position)),
            format!("towards {}", numbers(&self.direction)),
            lens,
        ]
    }
}

impl LightInfo {
    fn of(light: &PunctualLight) -> Self {
        let (kind, has_position, has_direction) = match light.kind {
            LightKind::Point => ("point", true, false),
            LightKind::Spot { .. } => ("spot", true, true),
            LightKind::Directional => ("directional", false, true),
            LightKind::Disk { .. } => ("disk", false, true),
        };
        Self {
            name: light.name.clone(),
            kind,
            intensity: light.intensity.to_array(),
            position: has_position.then(|| light.position.to_array()),
            direction: has_direction.then(|| light.direction.to_array()),
        }
    }

    fn row(&self) -> Vec<String> {
        let place = |word: &str, place: &Option<[f32; 3]>| {
            let place = place.as_ref();
            place.map_or(String::new(), |place| format!("{word} {}", numbers(place)))
        };
        vec![
            self.name.clone(),
            self.kind.to_owned(),
            numbers(&self.intensity),
            place("at", &self.position),
            place("towards", &self.direction),
        ]
    }
}

impl Unused {
    fn of(scene: &Scene, look: Option<&Look>, triangles: &[u64], places: &[usize]) -> Self {
        let shown = shown_materials(scene, look, triangles);
        let is_shown = |name: &str| shown.contains(name);
        let materials = scene.materials.iter();
        let used: BTreeSet<u32> = materials
            .clone()
            .filter(|material| is_shown(&material.name))
            .flat_map(|material| material.textures())
            .flatten()
            .map(|texture| texture.image)
            .collect();
        // Which ones nodes read is the look's business.
        let nodes_read = look.is_some_and(|look| !look.nodes.is_empty());
        let images = (0..).zip(&scene.images);
        let tables = look.iter().flat_map(|look| &look.materials);
        Self {
            meshes: (scene.meshes.iter().zip(places))
                .filter(|(_, places)| **places == 0)
                .map(|(mesh, _)| mesh.name.clone())
                .collect(),
            images: images
                .filter(|(index, _)| !used.contains(index) && !nodes_read)
                .map(|(_, image)| image.short_name().to_owned())
                .collect(),
            nodes: look.map(unused_nodes).unwrap_or_default(),
            look_materials: tables
                .map(|table| table.name.value.clone())
                .filter(|name| !is_shown(name))
                .collect(),
            materials: materials
                .map(|material| material.name.clone())
                .filter(|name| !is_shown(name))
                .collect(),
        }
    }

    fn rows(&self) -> Vec<Vec<String>> {
        let kinds = [
            ("material", &self.materials),
            ("mesh", &self.meshes),
            ("image", &self.images),
            ("node", &self.nodes),
            ("look's material", &self.look_materials),
        ];
        let rows = kinds.into_iter().flat_map(|(kind, names)| {
            let names = names.iter();
            names.map(move |name| vec![kind.to_owned(), name.clone()])
        });
        rows.collect()
    }
}

/// The animations of a scene that can be read. Where they are damaged the rest is still worth knowing.
fn animations(path: &Path) -> Vec<Animation> {
    import::animations(path).unwrap_or_else(|error| {
        console::warning(&error.to_string());
        Vec::new()
    })
}

/// Names of materials that are on a triangle, or below a blend that is.
fn shown_materials(scene: &Scene, look: Option<&Look>, triangles: &[u64]) -> BTreeSet<String> {
    let materials = scene.materials.iter().zip(triangles);
    let mut open: Vec<String> = materials
        .filter(|(_, triangles)| **triangles > 0)
        .map(|(material, _)| material.name.clone())
        .collect();
    let mut shown = BTreeSet::new();
    while let Some(name) = open.pop() {
        if !shown.insert(name.clone()) {
            continue;
        }
        let table = look.and_then(|look| table(look, &name));
        if let Some(blend) = table.and_then(|table| table.blend.as_ref()) {
            open.push(blend.value.base.value.clone());
            open.push(blend.value.over.value.clone());
        }
    }
    shown
}

/// What a look says of a material.
fn table<'l>(look: &'l Look, name: &str) -> Option<&'l MaterialLook> {
    let mut tables = look.materials.iter();
    tables.find(|table| table.name.value == name)
}

/// How often each mesh is placed.
fn places_of_meshes(scene: &Scene) -> Vec<usize> {
    let mut places = vec![0; scene.meshes.len()];
    for instance in &scene.instances {
        places[instance.mesh as usize] += 1;
    }
    places
}

/// Triangles of each material, with every place of a mesh counted.
fn triangles_of_materials(scene: &Scene) -> Vec<u64> {
    let mut triangles = vec![0; scene.materials.len()];
    for (mesh, places) in scene.meshes.iter().zip(places_of_meshes(scene)) {
        for &material in &mesh.triangle_materials {
            triangles[material as usize] += places as u64;
        }
    }
    triangles
}

/// What a material has that glTF's default material has not, but for what nodes drive.
fn constants(material: &Material, look: Option<&Driven>) -> Vec<(&'static str, String)> {
    let is_driven = |key: &str| {
        let mut driven = look.iter().flat_map(|look| &look.driven);
        driven.any(|link| link.parameter == key)
    };
    let kept = (PARAMETERS.iter()).filter(|parameter| !is_driven(parameter.key));
    let changed = kept.filter_map(|parameter| {
        let constant = parameter.constant(material)?;
        (Some(constant) != parameter.default()).then(|| {
            let text = match constant {
                Constant::Color(color) => numbers(&color.to_array()),
                Constant::Number(value) => number(as_written(parameter, value)),
                Constant::Flag(flag) => flag.to_string(),
                Constant::Word(word) => word.to_owned(),
            };
            (parameter.key, text)
        })
    });
    changed.collect()
}

/// A number of a material as a look has it, where angles are degrees.
fn as_written(parameter: &Parameter, value: f32) -> f32 {
    match parameter.takes {
        Takes::Number(Number {
            unit: Unit::Degrees,
            ..
        }) => value.to_degrees(),
        _ => value,
    }
}

/// A material's textures by name.
fn images(material: &Material, scene: &Scene) -> Vec<(&'static str, String)> {
    let named = TEXTURES.into_iter().zip(material.textures());
    named
        .filter_map(|(name, texture)| {
            let image = scene.images.get((*texture)?.image as usize)?;
            Some((name, image.short_name().to_owned()))
        })
        .collect()
}

fn environment(environment: &Environment) -> String {
    match environment {
        Environment::Constant(radiance) if radiance.max_element() <= 0.0 => "none".to_owned(),
        Environment::Constant(radiance) => numbers(&radiance.to_array()),
        Environment::Image { image, .. } => {
            format!("a picture of {}x{} pixels", image.width, image.height)
        }
    }
}

#[cfg(test)]
mod tests {
    use engine::scene::{Instance, TextureRef};

    use super::*;

    fn named(name: &str) -> Material {
        Material {
            name: name.to_owned(),
            ..Material::default()
        }
    }

    fn mesh(name: &str, material: u32) -> Mesh {
        Mesh {
            name: name.to_owned(),
            positions: vec![glam::Vec3::ZERO, glam::Vec3::X, glam::Vec3::Y],
            uv0: vec![glam::Vec2::ZERO; 3],
            triangles: vec![[0, 1, 2]; 2],
            triangle_materials: vec![material; 2],
            ..Mesh::default()
        }
    }

    fn image(name: &str) -> Image {
        Image {
            name: name.to_owned(),
            width: 4,
            height: 2,
            rgba8: vec![0; 32].into(),
            srgb: true,
        }
    }

    /// `Car` is placed twice, `Spare` nowhere; nothing has the materials `Steel` and `Gold`.
    fn scene() -> Scene {
        let mut paint = named("Paint");
        paint.roughness = 0.5;
        paint.base_color_texture = Some(TextureRef {
            image: 1,
            uv_set: 0,
            sampler: engine::scene::Sampler::default(),
            transform: [glam::Vec3::X, glam::Vec3::Y],
        });
        let instance = |x: f32| Instance {
            name: "Node".to_owned(),
            mesh: 0,
            transform: glam::Affine3A::from_translation(glam::Vec3::new(x, 0.0, 0.0)),
            asset: None,
        };
        Scene {
            meshes: vec![mesh("Car", 0), mesh("Spare", 1)],
            instances: vec![instance(0.0), instance(2.0)],
            materials: vec![paint, named("Steel"), named("Gold")],
            images: vec![image("lost.png"), image("paint.png")],
            ..Scene::default()
        }
    }

    #[test]
    fn what_is_there_is_counted_and_what_is_unused_is_named() {
        let info = SceneInfo::of(Path::new("a.glb"), &scene(), &[], None);
        assert_eq!(info.triangles, 4);
        assert_eq!(info.bounds, Some([[0.0; 3], [3.0, 1.0, 0.0]]));
        assert_eq!(info.materials[0].triangles, 4);
        assert_eq!(info.materials[0].images[0].0, "base_color");
        let expected = Unused {
            materials: vec!["Steel".to_owned(), "Gold".to_owned()],
            meshes: vec!["Spare".to_owned()],
            images: vec!["lost.png".to_owned()],
            ..Unused::default()
        };
        assert_eq!(info.unused, expected);
        let text = info.text();
        for wanted in [
            "triangles    4 in 2 places of 2 meshes",
            "0 0 0 to 3 1 0 m: 3 1 0 m",
            "materials (3)",
            "base_color = paint.png, roughness = 0.5",
            "4x2",
            "unused (4)",
        ] {
            assert!(text.contains(wanted), "{wanted}:\n{text}");
        }
    }

    /// A look reads `model:0` and `model:paint.png`.
    #[test]
    fn images_have_the_names_that_a_look_has_for_them() {
        let mut scene = scene();
        scene.images = vec![image("image 0"), image("image 1 \"paint.png\"")];
        let info = SceneInfo::of(Path::new("a.glb"), &scene, &[], None);
        let names: Vec<&str> = info.images.iter().map(|i| i.name.as_str()).collect();
        assert_eq!(names, ["0", "paint.png"]);
        assert_eq!(info.materials[0].images[0].1, "paint.png");
        assert_eq!(info.unused.images, ["0"]);
    }

    #[test]
    fn angles_are_in_degrees_as_in_a_look() {
        let mut scene = scene();
        scene.materials[0].anisotropy_rotation = 45f32.to_radians();
        let text = SceneInfo::of(Path::new("a.glb"), &scene, &[], None).text();
        assert!(text.contains("anisotropy_rotation = 45"), "{text}");
    }

    #[test]
    fn a_look_says_what_drives_materials_and_uses_what_it_blends() {
        let text = "[node.rust]\ntexture = \"rust\"\n[node.idle]\ntexture = \"rust\"\n\
                    [material.Gold]\nbase_color = \"rust\"\n\
                    [material.Paint]\nblend = { base = \"Paint\", over = \"Steel\", mask = 0.25 }\n";
        let look = Look::parse(Path::new("a.look.toml"), text).expect("a look");
        let info = SceneInfo::of(Path::new("a.glb"), &scene(), &[], Some(&look));
        assert_eq!(info.unused.materials, ["Gold"]);
        assert_eq!(info.unused.look_materials, ["Gold"]);
        assert_eq!(info.unused.nodes, ["idle"]);
        let text = info.text();
        assert!(text.contains("Steel over Paint by 0.25"), "{text}");
        assert!(text.contains("base_color = rust"), "{text}");
    }
}
