//! The node tree: world transforms and what is visible. Works without recursion, for trees of any depth.

use super::animation::{Local, Places};
use super::document::Document;
use crate::import::error::{At as _, Fault, ImportError, Warnings};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::json;

/// The nodes of a file in the world.
pub(super) struct Nodes {
    /// Node to world; may hold anything, also infinities.
    pub(super) world: Vec<DAffine3>,
    /// How each is turned by its own rotation and those above it, whatever their scales.
    pub(super) turns: Vec<DQuat>,
    /// The topmost node above each, which may be itself.
    pub(super) tops: Vec<usize>,
    /// Nodes of the rendered scene, parents before children.
    pub(super) visible: Vec<usize>,
    /// The rendered scene, where the file has any.
    pub(super) scene: Option<usize>,
}

/// Resolves the tree below `placement`, with the nodes that move at their `places`. Nodes that have two parents or are their own ancestors are an error.
pub(super) fn resolve(
    document: &Document,
    placement: DAffine3,
    places: &Places,
    warnings: &mut Warnings,
) -> Result<Nodes, ImportError> {
    let root = &document.root;
    let parents = parents(root).at(&document.path, || "nodes".into())?;
    let tops: Vec<usize> = (0..root.nodes.len())
        .filter(|&node| parents[node].is_none())
        .collect();

    let mut world = vec![DAffine3::IDENTITY; root.nodes.len()];
    let mut turns = vec![DQuat::IDENTITY; root.nodes.len()];
    let order = depth_first(root, tops.iter().copied());
    if order.len() < root.nodes.len() {
        // Nodes with one parent each that no root leads to can only be in a cycle.
        let mut reached = vec![false; root.nodes.len()];
        order.iter().for_each(|&node| reached[node] = true);
        let node = reached.iter().position(|reached| !reached).unwrap_or(0);
        return Err("is its own ancestor".to_owned()).at(&document.path, || describe(root, node));
    }
    let mut topmost: Vec<usize> = (0..root.nodes.len()).collect();
    for &node in &order {
        topmost[node] = parents[node].map_or(node, |parent| topmost[parent]);
        let parent = parents[node].map_or(placement, |parent| world[parent]);
        let local = local_transform(&root.nodes[node], places.of(node));
        let (local, turn) = local.unwrap_or_else(|problem| {
            warnings.push(format!("{}: {problem}", describe(root, node)));
            (DAffine3::IDENTITY, DQuat::IDENTITY)
        });
        world[node] = parent * local;
        let above = parents[node].map_or_else(|| turn_of(&placement), |parent| turns[parent]);
        turns[node] = (above * turn).normalize();
    }

    // Without a default scene the first one is meant, and without scenes everything.
    let scene = match root.scene {
        Some(scene) => Some(scene.value()),
        None if root.scenes.is_empty() => None,
        None => Some(0),
    };
    let visible = match scene {
        None => order,
        Some(index) => {
            let scene = root
                .scenes
                .get(index)
                .ok_or_else(|| "does not exist".to_owned())
                .at(&document.path, || format!("scene {index}"))?;
            let tops: Vec<usize> = scene.nodes.iter().map(|node| node.value()).collect();
            if let Some(node) = tops.iter().find(|&&node| node >= root.nodes.len()) {
                return Err(format!("node {node} does not exist"))
                    .at(&document.path, || format!("scene {index}"));
            }
            depth_first(root, tops.into_iter())
        }
    };
    Ok(Nodes {
        world,
        turns,
        tops: topmost,
        visible,
        scene,
    })
}

/// Number and name of a node.
pub(super) fn describe(root: &json::Root, node: usize) -> String {
    match root.nodes.get(node).and_then(|node| node.name.as_deref()) {
        Some(name) => format!("node {node} \"{name}\""),
        None => format!("node {node}"),
    }
}

fn children(node: &json::Node) -> impl DoubleEndedIterator<Item = usize> {
    node.children.iter().flatten().map(|child| child.value())
}

fn parents(root: &json::Root) -> Result<Vec<Option<usize>>, Fault> {
    let mut parents = vec![None; root.nodes.len()];
    for (parent, node) in root.nodes.iter().enumerate() {
        for child in children(node) {
            let slot = parents.get_mut(child).ok_or_else(|| {
                format!("{}: child {child} does not exist", describe(root, parent))
            })?;
            if slot.replace(parent).is_some() {
                return Err(format!("{} has two parents", describe(root, child)));
            }
        }
    }
    Ok(parents)
}

/// Nodes below `tops` in the order of the file, each once.
fn depth_first(root: &json::Root, tops: impl DoubleEndedIterator<Item = usize>) -> Vec<usize> {
    let mut seen = vec![false; root.nodes.len()];
    let mut order = Vec::new();
    let mut open: Vec<usize> = tops.rev().collect();
    while let Some(node) = open.pop() {
        if !std::mem::replace(&mut seen[node], true) {
            order.push(node);
            open.extend(children(&root.nodes[node]).rev());
        }
    }
    order
}

/// A node's transform and the rotation in it, with what animations say in place of what is written.
fn local_transform(node: &json::Node, moved: Option<&Local>) -> Result<(DAffine3, DQuat), Fault> {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        // The last row of an affine matrix is 0 0 0 1 and carries nothing.
        let matrix = DAffine3::from_mat4(matrix);
        return Ok((matrix, turn_of(&matrix)));
    }
    let moved = moved.copied().unwrap_or_default();
    let vector = |moved: Option<DVec3>, v: Option<[f32; 3]>, default| {
        moved.unwrap_or(v.map_or(default, |v| DVec3::from(v.map(f64::from))))
    };
    let rotation = match (moved.rotation, node.rotation) {
        (Some(rotation), _) => rotation,
        (None, None) => DQuat::IDENTITY,
        (None, Some(json::scene::UnitQuaternion(q))) => unit_quaternion(q)
            .ok_or("its rotation is not a quaternion; its transform is ignored")?,
    };
    let transform = DAffine3::from_scale_rotation_translation(
        vector(moved.scale, node.scale, DVec3::ONE),
        rotation,
        vector(moved.translation, node.translation, DVec3::ZERO),
    );
    Ok((transform, rotation))
}

/// The rotation in a transform, as far as it has one.
fn turn_of(transform: &DAffine3) -> DQuat {
    let (x, z) = (transform.matrix3.x_axis, transform.matrix3.z_axis);
    let up = z.cross(x).normalize_or_zero();
    let back = z.normalize_or_zero();
    match (up != DVec3::ZERO && back != DVec3::ZERO).then(|| up.cross(back)) {
        Some(right) => DQuat::from_mat3(&DMat3::from_cols(right, up, back)),
        None => DQuat::IDENTITY,
    }
}

/// A rotation from numbers that are only nearly of unit length.
pub(super) fn unit_quaternion(q: [f32; 4]) -> Option<DQuat> {
    let q = DQuat::from_array(q.map(f64::from));
    let length = q.length();
    (length > 1e-9 && length.is_finite()).then(|| q / length)
}
