//! What lies in one hierarchy of the lower level: a mesh, or all meshes that are placed once and by the same transform.
//!
//! Exporters cut a building into hundreds of meshes whose boxes overlap everywhere, and a ray that has to enter each of them for itself takes
//! twice as long as one that goes through all their triangles at once (docs/performance.md).

use std::collections::HashMap;

use crate::scene::{self, Scene};

/// Instances of the scene whose triangles lie in one hierarchy, by their places in the order of instances.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Group {
    /// A mesh that is placed often, bends, or stands alone.
    Alone { place: u32, mesh: u32 },
    /// Meshes that are placed by one transform, once each.
    Joined(Vec<Member>),
}

/// One of several meshes in a hierarchy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Member {
    /// Place of its instance.
    pub(super) place: u32,
    pub(super) mesh: u32,
    /// Its first triangle among those of the hierarchy.
    pub(super) start: u32,
}

/// Groups the instances of a scene, given in their order. What moves apart from others has a transform of its own, so that groups move as a
/// whole; they follow from the scene at its moment, never from another one.
pub(super) fn of<'s>(
    scene: &Scene,
    instances: impl Iterator<Item = &'s scene::Instance> + Clone,
) -> Vec<Group> {
    let mut uses = vec![0u32; scene.meshes.len()];
    for instance in instances.clone() {
        uses[instance.mesh as usize] += 1;
    }
    let mut groups: Vec<Group> = Vec::new();
    let mut by_transform: HashMap<[u32; 12], usize> = HashMap::new();
    for (place, instance) in (0..).zip(instances) {
        let mesh = instance.mesh;
        let alone = Group::Alone { place, mesh };
        if uses[mesh as usize] > 1 || scene.meshes[mesh as usize].unbent.is_some() {
            groups.push(alone);
            continue;
        }
        let transform = instance.transform.to_cols_array().map(f32::to_bits);
        let &mut at = by_transform.entry(transform).or_insert(groups.len());
        if at == groups.len() {
            groups.push(alone);
            continue;
        }
        let triangles = |mesh: u32| scene.meshes[mesh as usize].triangles.len() as u32;
        let mut members = match &mut groups[at] {
            &mut Group::Alone { place, mesh } => vec![Member {
                place,
                mesh,
                start: 0,
            }],
            Group::Joined(members) => std::mem::take(members),
        };
        let start = (members.last()).map_or(0, |last| last.start + triangles(last.mesh));
        members.push(Member { place, mesh, start });
        groups[at] = Group::Joined(members);
    }
    groups
}

impl Group {
    /// The place of one of its instances, whose transform all have.
    pub(super) fn place(&self) -> u32 {
        match self {
            Self::Alone { place, .. } => *place,
            Self::Joined(members) => members[0].place,
        }
    }

    /// Its meshes, in the order of their triangles.
    pub(super) fn meshes(&self) -> impl Iterator<Item = u32> {
        let (alone, joined) = match self {
            Self::Alone { mesh, .. } => (Some(*mesh), &[][..]),
            Self::Joined(members) => (None, &members[..]),
        };
        alone
            .into_iter()
            .chain(joined.iter().map(|member| member.mesh))
    }

    /// Whether a hierarchy over the one is over the other, too, as far as the meshes are the same.
    pub(super) fn has_meshes_of(&self, other: &Self) -> bool {
        self.meshes().eq(other.meshes())
    }

    /// By which its members are found.
    pub(super) fn directory(&self) -> Directory {
        let Self::Joined(members) = self else {
            return Directory(vec![]);
        };
        let last = members.last().map_or(0, |member| member.start);
        let first_of = |entry: u32| {
            let after = members.partition_point(|member| member.start <= entry * ENTRY);
            after as u32 - 1
        };
        Directory((0..=last / ENTRY).map(first_of).collect())
    }

    /// The instance's place and the mesh's own number of a triangle.
    #[inline]
    pub(super) fn find(&self, directory: &Directory, triangle: u32) -> (u32, u32) {
        match self {
            Self::Alone { place, .. } => (*place, triangle),
            Self::Joined(members) => {
                let entry = (triangle / ENTRY) as usize;
                let entry = entry.min(directory.0.len() - 1);
                let mut rest = &members[directory.0[entry] as usize..];
                while let [_, next, ..] = rest
                    && next.start <= triangle
                {
                    rest = &rest[1..];
                }
                (rest[0].place, triangle - rest[0].start)
            }
        }
    }
}

/// Triangles of a group for each entry of its directory.
const ENTRY: u32 = 32;

/// Of each so many triangles of a group the member that the first of them belongs to: each hit asks for its own, and a search among a hundred
/// members is a twentieth of what a ray takes.
#[derive(Debug)]
pub(super) struct Directory(Vec<u32>);

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};

    use super::*;
    use crate::scene::{Instance, Mesh};

    fn scene(placed: &[(u32, f32)]) -> Scene {
        let mesh = |triangles: usize| Mesh {
            triangles: vec![[0, 1, 2]; triangles],
            ..Mesh::default()
        };
        Scene {
            meshes: vec![mesh(3), mesh(1), mesh(2), mesh(5)],
            instances: (placed.iter())
                .map(|&(mesh, x)| Instance {
                    mesh,
                    name: String::new(),
                    transform: Affine3A::from_translation(Vec3::X * x),
                    asset: None,
                })
                .collect(),
            ..Scene::default()
        }
    }

    #[test]
    fn what_is_placed_alike_and_once_lies_together() {
        let scene = scene(&[(0, 0.0), (1, 0.0), (2, 1.0), (3, 0.0)]);
        let groups = of(&scene, scene.instances.iter());
        let member = |place, mesh, start| Member { place, mesh, start };
        let joined = Group::Joined(vec![member(0, 0, 0), member(1, 1, 3), member(3, 3, 4)]);
        assert_eq!(groups, [joined, Group::Alone { place: 2, mesh: 2 }]);
        let directory = groups[0].directory();
        let found = [0, 2, 3, 4, 8].map(|triangle| groups[0].find(&directory, triangle));
        assert_eq!(found, [(0, 0), (0, 2), (1, 0), (3, 0), (3, 4)]);
    }

    #[test]
    fn members_are_found_by_any_of_their_triangles() {
        let sizes = [1, 31, 32, 1, 1, 200, 3, 64, 5];
        let mut start = 0;
        let mut members = vec![];
        for (place, size) in (0..).zip(sizes) {
            let mesh = place;
            members.push(Member { place, mesh, start });
            start += size;
        }
        let group = Group::Joined(members.clone());
        let directory = group.directory();
        for triangle in 0..start {
            let (place, own) = group.find(&directory, triangle);
            let member = members[place as usize];
            assert_eq!(member.start + own, triangle);
            assert!(own < sizes[place as usize], "{triangle}");
        }
    }

    #[test]
    fn what_is_placed_often_or_bends_stays_alone() {
        let mut scene = scene(&[(0, 0.0), (1, 0.0), (0, 1.0), (2, 0.0)]);
        scene.meshes[2].unbent = Some(std::sync::Arc::new(vec![]));
        let groups = of(&scene, scene.instances.iter());
        let alone = |place, mesh| Group::Alone { place, mesh };
        assert_eq!(groups, [alone(0, 0), alone(1, 1), alone(2, 0), alone(3, 2)]);
    }
}
