//! What hangs on the visible nodes: instances of meshes, lights and cameras.

use super::accessor::Accessor;
use super::animation::Places;
use super::deform::Pose;
use super::document::Document;
use super::geometry::{Builder, Built, has_triangles};
use super::hierarchy::{Nodes, describe, unit_quaternion};
use super::lights_cameras;
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use crate::import::format::NodeNames;
use crate::import::mesh::warn_of_dropped;
use crate::import::place::{MAX_INSTANCES, check_count, invertible};
use crate::{Camera, Environment, Instance, Material, Mesh, PunctualLight};
use glam::{Affine3A, DAffine3, DMat4, DVec3, Mat3A, Vec3};
use gltf::json;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};

const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// A mesh to build. Nodes that show the same mesh in the same pose share it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Request {
    mesh: usize,
    /// Weights of the morph targets, as bits, where the node has its own.
    weights: Option<Vec<u32>>,
    /// A skinned mesh takes its place from its joints, not from its node.
    skin: Option<usize>,
    /// The weights are an animation's.
    has_moving_weights: bool,
}

impl Request {
    /// Whether it may look otherwise at another time.
    fn moves(&self) -> bool {
        self.skin.is_some() || self.has_moving_weights
    }
}

/// What is the same whenever it is seen, for files that are read again and again: the environment with its warnings, and meshes.
#[derive(Debug, Default)]
pub(super) struct Kept {
    pub(super) environment: Mutex<Option<(Environment, Vec<String>)>>,
    built: Mutex<HashMap<Request, Built>>,
    /// Those that bend, by their numbers, and whether they are mirrored.
    unbent: Mutex<HashMap<(usize, bool), Unbent>>,
}

/// A mesh as it is before it is bent.
#[derive(Debug, Clone)]
struct Unbent {
    positions: Arc<Vec<Vec3>>,
    triangles: Arc<Vec<[u32; 3]>>,
}

impl Kept {
    fn get(&self, request: &Request) -> Option<Built> {
        let kept = self.built.lock().unwrap_or_else(PoisonError::into_inner);
        kept.get(request).cloned()
    }

    fn put(&self, request: &Request, built: &Built) {
        let mut kept = self.built.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(request.clone(), built.clone());
    }

    /// Tells a mesh where its vertices are before they are bent, where it has the same triangles then.
    fn unbend(
        &self,
        (number, is_mirrored): (usize, bool),
        builder: &Builder<'_>,
        mesh: &mut Mesh,
    ) -> Result<(), ImportError> {
        let lock = || self.unbent.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().get(&(number, is_mirrored)).cloned();
        let unbent = match known {
            Some(unbent) => unbent,
            None => {
                let at_rest = Pose {
                    bends: true,
                    is_mirrored,
                    ..Pose::default()
                };
                let built = builder.build(number, &at_rest)?.mesh;
                let unbent = Unbent {
                    positions: built.positions.into(),
                    triangles: built.triangles.into(),
                };
                lock().insert((number, is_mirrored), unbent.clone());
                unbent
            }
        };
        let is_same =
            unbent.positions.len() == mesh.positions.len() && *unbent.triangles == mesh.triangles;
        mesh.unbent = is_same.then_some(unbent.positions);
        Ok(())
    }
}

/// Where everything stands, and what is kept of meshes.
pub(super) struct Stage<'a> {
    pub(super) nodes: &'a Nodes,
    pub(super) places: &'a Places,
    /// `None` for a file that is read once.
    pub(super) kept: Option<&'a Kept>,
}

/// Builds the meshes that visible nodes show, and their instances, for a scene that has `before` instances.
pub(super) fn instances(
    document: &Document,
    stage: &Stage<'_>,
    materials: &[Material],
    before: usize,
    names: &mut NodeNames,
    warnings: &mut Warnings,
) -> Result<(Vec<Mesh>, Vec<Instance>), ImportError> {
    let nodes = stage.nodes;
    let (requests, mut instances) = list(document, stage, before, names, warnings)?;
    let builder = Builder {
        document,
        materials,
    };
    let built = requests
        .par_iter()
        .map(|request| {
            let kept = stage.kept.filter(|_| !request.moves());
            if let Some(built) = kept.and_then(|kept| kept.get(request)) {
                return Ok(built);
            }
            let bends = stage.places.is_moved && request.moves();
            let pose = Pose {
                bends,
                ..pose(document, nodes, request)?
            };
            let mut built = builder.build(request.mesh, &pose)?;
            match kept {
                Some(kept) => kept.put(request, &built),
                None => {
                    if let Some(kept) = stage.kept.filter(|_| stage.places.is_moved) {
                        kept.unbend((request.mesh, pose.is_mirrored), &builder, &mut built.mesh)?;
                    }
                }
            }
            Ok(built)
        })
        .collect::<Result<Vec<Built>, ImportError>>()?;
    if !stage.places.is_moved {
        warn_of_poses(&requests, &document.root, warnings);
    }
    let dropped = built.iter().map(|b| (b.mesh.name.as_str(), b.dropped));
    warn_of_dropped(dropped, warnings);

    // Meshes of which nothing is left go, and their instances with them.
    let mut renumbered = Vec::with_capacity(built.len());
    let mut meshes = Vec::with_capacity(built.len());
    for built in built {
        warnings.extend(built.warnings);
        let empty = built.mesh.triangles.is_empty();
        renumbered.push((!empty).then_some(meshes.len() as u32));
        if !empty {
            meshes.push(built.mesh);
        }
    }
    instances.retain_mut(|instance| match renumbered[instance.mesh as usize] {
        Some(number) => {
            instance.mesh = number;
            true
        }
        None => {
            names.gone_meshes.insert(std::mem::take(&mut instance.name));
            false
        }
    });
    Ok((meshes, instances))
}

/// Whether a primitive of a visible node has no material.
pub(super) fn want_material(document: &Document, nodes: &Nodes) -> bool {
    let root = &document.root;
    let meshes = nodes
        .visible
        .iter()
        .filter_map(|&node| root.nodes[node].mesh);
    let meshes: HashSet<usize> = meshes.map(|mesh| mesh.value()).collect();
    let mut primitives = meshes
        .iter()
        .filter_map(|&mesh| root.meshes.get(mesh))
        .flat_map(|mesh| &mesh.primitives);
    primitives.any(|primitive| primitive.material.is_none() && has_triangles(primitive))
}

/// The meshes to build, and instances that refer to that list.
fn list(
    document: &Document,
    stage: &Stage<'_>,
    before: usize,
    names: &mut NodeNames,
    warnings: &mut Warnings,
) -> Result<(Vec<Request>, Vec<Instance>), ImportError> {
    let nodes = stage.nodes;
    let root = &document.root;
    let mut requests = Vec::new();
    let mut numbers: HashMap<Request, u32> = HashMap::new();
    let mut instances = Vec::new();
    let mut assets: HashMap<usize, Arc<str>> = HashMap::new();
    for &index in &nodes.visible {
        let node = &root.nodes[index];
        let Some(mesh) = node.mesh else {
            continue;
        };
        let place = || describe(root, index);
        let places = match node.skin {
            Some(_) => vec![DAffine3::IDENTITY],
            None => placements(document, node, &nodes.world[index])
                .at(&document.path, || format!("{}, {INSTANCING}", place()))?,
        };
        let usable: Vec<Affine3A> = places.iter().filter_map(invertible).collect();
        if usable.len() < places.len() {
            warnings.push(format!(
                "{}: its transform flattens it or is not finite; it is left out",
                place()
            ));
        }
        let name = node.name.clone().unwrap_or_else(|| format!("node {index}"));
        if usable.is_empty() {
            names.gone_meshes.insert(name);
            continue;
        }
        check_count(&document.path, before + instances.len() + usable.len())?;
        // All pieces share the text.
        let top = nodes.tops[index];
        let asset = (top != index).then(|| {
            let names = assets.entry(top);
            let name = || {
                root.nodes[top]
                    .name
                    .clone()
                    .unwrap_or_else(|| format!("node {top}"))
            };
            Arc::clone(names.or_insert_with(|| name().into()))
        });
        document
            .budget
            .take(usable.len() as u64, name.len() as u64)
            .at(&document.path, place)?;
        let moved = stage.places.weights.get(&index);
        let request = Request {
            mesh: mesh.value(),
            weights: own_weights(root, node, mesh.value(), moved),
            skin: node.skin.map(|skin| skin.value()),
            has_moving_weights: moved.is_some(),
        };
        let next = requests.len() as u32;
        let number = *numbers.entry(request).or_insert_with_key(|request| {
            requests.push(request.clone());
            next
        });
        instances.extend(usable.into_iter().map(|transform| Instance {
            name: name.clone(),
            mesh: number,
            transform,
            asset: asset.clone(),
        }));
    }
    Ok((requests, instances))
}

/// Lights and cameras of the visible nodes. Names of cameras are unique.
pub(super) fn lights_and_cameras(
    document: &Document,
    nodes: &Nodes,
    node_names: &mut NodeNames,
    warnings: &mut Warnings,
) -> Result<(Vec<PunctualLight>, Vec<Camera>), ImportError> {
    let root = &document.root;
    let all_lights = root
        .extensions
        .as_ref()
        .and_then(|extensions| extensions.khr_lights_punctual.as_ref())
        .map_or(&[][..], |extension| &extension.lights);
    let mut lights = Vec::new();
    let mut cameras: Vec<Camera> = Vec::new();
    // How many cameras were named after each name.
    let mut names: HashMap<String, u32> = HashMap::new();
    for &index in &nodes.visible {
        let node = &root.nodes[index];
        let world = &nodes.world[index];
        let node_name = || node.name.clone().unwrap_or_else(|| format!("node {index}"));
        let missing = |what: &str, number: usize| ImportError::Malformed {
            path: document.path.clone(),
            place: describe(root, index),
            problem: format!("{what} {number} does not exist"),
        };
        if let Some(camera) = node.camera {
            let Some(source) = root.cameras.get(camera.value()) else {
                return Err(missing("camera", camera.value()));
            };
            let candidates = source.name.iter().cloned().chain([node_name()]);
            let mut free = candidates.filter(|name| !names.contains_key(name));
            let name = free
                .next()
                .unwrap_or_else(|| numbered(&mut names, &node_name()));
            let turn = nodes.turns[index];
            let camera = lights_cameras::camera(source, name.clone(), world, turn, warnings);
            if let Some(camera) = camera {
                names.insert(name, 0);
                cameras.push(camera);
            }
        }
        let light = node
            .extensions
            .as_ref()
            .and_then(|e| e.khr_lights_punctual.as_ref());
        if let Some(light) = light {
            let Some(source) = all_lights.get(light.light.value()) else {
                return Err(missing("light", light.light.value()));
            };
            let name = source.name.clone().unwrap_or_else(node_name);
            match lights_cameras::light(source, name.clone(), world, warnings) {
                Some(light) => {
                    node_names.lights.push(node_name());
                    lights.push(light);
                }
                // Nothing but its transform is in the way, which may be another one at another moment, where there are several.
                None if lights_cameras::is_sound(source) && document.has_animations => {
                    node_names.gone_lights.insert((node_name(), name));
                }
                None => {}
            }
        }
    }
    Ok((lights, cameras))
}

/// `base` with the first number that makes it new. `names` remembers the last number of each name.
fn numbered(names: &mut HashMap<String, u32>, base: &str) -> String {
    loop {
        let number = names.entry(base.to_owned()).or_insert(0);
        *number += 1;
        let name = format!("{base}.{number:03}");
        if !names.contains_key(&name) {
            return name;
        }
    }
}

/// Where the mesh of a node stands: at the node, or at the places EXT_mesh_gpu_instancing lists.
fn placements(
    document: &Document,
    node: &json::Node,
    world: &DAffine3,
) -> Result<Vec<DAffine3>, Fault> {
    let extension = node
        .extensions
        .as_ref()
        .and_then(|e| e.others.get(INSTANCING));
    let Some(extension) = extension else {
        return Ok(vec![*world]);
    };
    let attribute = |name: &str, components: usize| {
        let Some(index) = extension.pointer(&format!("/attributes/{name}")) else {
            return Ok(None);
        };
        let index = index
            .as_u64()
            .and_then(|index| usize::try_from(index).ok())
            .ok_or_else(|| format!("{name} is not the number of an accessor"))?;
        let accessor = document
            .accessor(index)
            .map_err(|fault| format!("{name}: {fault}"))?;
        if accessor.components() != components || accessor.count() as usize > MAX_INSTANCES {
            return Err(format!("{name} has the wrong type or too many elements"));
        }
        Ok(Some(accessor))
    };
    let translations = attribute("TRANSLATION", 3)?;
    let rotations = attribute("ROTATION", 4)?;
    let scales = attribute("SCALE", 3)?;
    let given = [&translations, &rotations, &scales];
    let counts: Vec<u32> = given.into_iter().flatten().map(Accessor::count).collect();
    let Some(&count) = counts.first() else {
        return Ok(vec![*world]);
    };
    if counts.iter().any(|&other| other != count) {
        return Err("its attributes have different lengths".into());
    }
    // Places that can't be used and are left out take their time, too.
    let bytes = (size_of::<DAffine3>() + size_of::<Affine3A>()) as u64;
    document.budget.take(u64::from(count), bytes)?;
    let translations = translations.map(|a| a.all::<3>());
    let rotations = rotations.map(|a| a.all::<4>());
    let scales = scales.map(|a| a.all::<3>());
    let vector = |list: &Option<Vec<[f32; 3]>>, i: usize, default| match list {
        Some(list) => DVec3::from(list[i].map(f64::from)),
        None => default,
    };
    Ok((0..count as usize)
        .map(|i| {
            let rotation = rotations.as_ref().and_then(|list| unit_quaternion(list[i]));
            *world
                * DAffine3::from_scale_rotation_translation(
                    vector(&scales, i, DVec3::ONE),
                    rotation.unwrap_or_default(),
                    vector(&translations, i, DVec3::ZERO),
                )
        })
        .collect())
}

/// Bits of the morph weights of a node, `moved` by an animation or its own, where they differ from those of its mesh.
fn own_weights(
    root: &json::Root,
    node: &json::Node,
    mesh: usize,
    moved: Option<&Vec<f32>>,
) -> Option<Vec<u32>> {
    let own = moved.or(node.weights.as_ref())?;
    let default = root.meshes.get(mesh).and_then(|mesh| mesh.weights.as_ref());
    if default == Some(own) || (default.is_none() && own.iter().all(|&weight| weight == 0.0)) {
        return None;
    }
    Some(own.iter().map(|weight| weight.to_bits()).collect())
}

fn pose(document: &Document, nodes: &Nodes, request: &Request) -> Result<Pose, ImportError> {
    let weights = match &request.weights {
        Some(own) => own.iter().map(|&bits| f32::from_bits(bits)).collect(),
        None => {
            let mesh = document.root.meshes.get(request.mesh);
            mesh.and_then(|mesh| mesh.weights.clone())
                .unwrap_or_default()
        }
    };
    let joints = match request.skin {
        None => Vec::new(),
        Some(skin) => {
            joints(document, nodes, skin).at(&document.path, || format!("skin {skin}"))?
        }
    };
    document
        .budget
        .take((joints.len() + weights.len()) as u64, 64)
        .at(&document.path, || format!("mesh {}", request.mesh))?;
    Ok(Pose {
        weights,
        is_mirrored: Pose::mirror(&joints),
        joints,
        bends: false,
    })
}

/// Bind pose to world for each joint of a skin (glTF 2.0, section 3.7.3.3).
fn joints(document: &Document, nodes: &Nodes, skin: usize) -> Result<Vec<Affine3A>, Fault> {
    let skin = document.root.skins.get(skin).ok_or("does not exist")?;
    let inverse_bind = match skin.inverse_bind_matrices {
        None => Vec::new(),
        Some(accessor) => {
            let accessor = document.accessor(accessor.value())?;
            if accessor.components() != 16 || (accessor.count() as usize) < skin.joints.len() {
                return Err("its inverse bind matrices are of the wrong type or too few".into());
            }
            accessor.gather::<16>(0..skin.joints.len() as u32)
        }
    };
    if skin.joints.is_empty() {
        return Err("has no joints".into());
    }
    skin.joints
        .iter()
        .enumerate()
        .map(|(number, joint)| {
            let world = nodes
                .world
                .get(joint.value())
                .ok_or_else(|| format!("joint {} does not exist", joint.value()))?;
            let bind = inverse_bind
                .get(number)
                .map_or(DAffine3::IDENTITY, |matrix| {
                    DAffine3::from_mat4(DMat4::from_cols_array(&matrix.map(f64::from)))
                });
            let matrix = *world * bind;
            Ok(Affine3A {
                matrix3: Mat3A::from_cols(
                    matrix.matrix3.x_axis.as_vec3().into(),
                    matrix.matrix3.y_axis.as_vec3().into(),
                    matrix.matrix3.z_axis.as_vec3().into(),
                ),
                translation: matrix.translation.as_vec3().into(),
            })
        })
        .collect()
}

fn warn_of_poses(requests: &[Request], root: &json::Root, warnings: &mut Warnings) {
    if requests.iter().any(|request| request.skin.is_some()) {
        warnings.push("skinned meshes are shown with their joints at rest");
    }
    let morphs = |request: &Request| {
        let mesh = root.meshes.get(request.mesh);
        mesh.is_some_and(|mesh| mesh.primitives.iter().any(|p| p.targets.is_some()))
    };
    if requests.iter().any(morphs) {
        warnings.push("morph targets are shown at their default weights");
    }
}
