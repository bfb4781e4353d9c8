//! Where caustics come from: spheres around all surfaces that may throw them, which photons are sent to.

use glam::{Vec3, Vec4};

use crate::{scene::Scene, texturing::ProgramTraits};

use super::materials::casts_caustics;

/// Most spheres: as many as `photons/settings.wgsl` has room for.
pub const MOST_TARGETS: usize = 16;

/// Middle and radius, metres, of spheres that hold all casters. Radii may overlap.
pub(super) fn targets(scene: &Scene, program: impl Fn(u32) -> ProgramTraits) -> Vec<Vec4> {
    let casts: Vec<bool> = (0..)
        .zip(&scene.materials)
        .map(|(number, material)| casts_caustics(material, &program(number)))
        .collect();
    let mut groups = vec![spheres(scene, &casts)];
    groups.retain(|group| !group.is_empty());
    // The widest group is cut in two, until there are as many as may be.
    while groups.len() < MOST_TARGETS {
        let width = |group: &Vec<Vec4>| match group.len() {
            1 => 0.0,
            _ => around(group).w,
        };
        let widest = (0..groups.len()).max_by(|&a, &b| {
            let (a, b) = (width(&groups[a]), width(&groups[b]));
            a.total_cmp(&b)
        });
        let Some(widest) = widest.filter(|&at| groups[at].len() > 1) else {
            break;
        };
        let (left, right) = cut(groups.swap_remove(widest));
        groups.extend([left, right]);
    }
    groups.iter().map(|group| around(group)).collect()
}

/// One sphere for each instance with a caster.
fn spheres(scene: &Scene, casts: &[bool]) -> Vec<Vec4> {
    let of = |instance: &crate::scene::Instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        let materials = mesh.triangle_materials.iter();
        let casting = materials
            .zip(&mesh.triangles)
            .filter(|(material, _)| casts[**material as usize]);
        let points = || {
            let corners = casting.clone().flat_map(|(_, corners)| corners);
            let place = |&corner: &u32| mesh.positions[corner as usize];
            corners.map(move |corner| instance.transform.transform_point3(place(corner)))
        };
        let low = points().reduce(Vec3::min)?;
        let high = points().reduce(Vec3::max)?;
        let middle = low * 0.5 + high * 0.5;
        let radius = points().map(|point| point.distance(middle));
        let radius = radius.fold(0.0, f32::max);
        // A little more than all of it: a ray along its border still counts.
        let radius = (radius * 1.0001).max(1e-6 * middle.abs().max_element());
        (middle.is_finite() && radius.is_finite()).then(|| middle.extend(radius.max(1e-9)))
    };
    scene.instances.iter().filter_map(of).collect()
}

/// A sphere around some.
fn around(group: &[Vec4]) -> Vec4 {
    if let [one] = group {
        return *one;
    }
    let corner = |side: f32| group.iter().map(move |s| s.truncate() + side * s.w);
    let low = corner(-1.0).reduce(Vec3::min).unwrap_or_default();
    let high = corner(1.0).reduce(Vec3::max).unwrap_or_default();
    let middle = low * 0.5 + high * 0.5;
    let reach = group
        .iter()
        .map(|s| s.truncate().distance(middle) + s.w)
        .fold(0.0, f32::max);
    middle.extend(reach)
}

/// Two halves, left and right along the longest side.
fn cut(mut group: Vec<Vec4>) -> (Vec<Vec4>, Vec<Vec4>) {
    let middles = || group.iter().map(|s| s.truncate());
    let low = middles().reduce(Vec3::min).unwrap_or_default();
    let high = middles().reduce(Vec3::max).unwrap_or_default();
    let axis = (high - low).max_position();
    group.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
    let right = group.split_off(group.len() / 2);
    (group, right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_spheres_become_few_that_hold_them_all() {
        let row: Vec<Vec4> = (0..100)
            .map(|i| Vec4::new((i % 10) as f32, (i / 10) as f32, 0.0, 0.2))
            .collect();
        let (left, right) = cut(row.clone());
        assert_eq!((left.len(), right.len()), (50, 50));
        let whole = around(&row);
        for one in &row {
            assert!(one.truncate().distance(whole.truncate()) + one.w <= whole.w * 1.0001);
        }
        assert_eq!(around(&row[..1]), row[0]);
    }
}
