//! What becomes of a transform that no single node has: a node turns, scales and moves what another has turned before.

use glam::{Affine3A, DMat3, DQuat, DVec3, Quat, Vec3};

/// Of the longest axis: how far translation, rotation and scale may be from a transform that they stand for.
const SAME: f32 = 1e-4;
/// So often each pair of axes is turned: three times make a rotation exact.
const SWEEPS: u32 = 8;

/// A transform as a node has it: scale first, then rotation, then translation (glTF 2.0, section 3.5.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) scale: Vec3,
    pub(super) rotation: Quat,
    pub(super) translation: Vec3,
}

impl Place {
    /// A transform as one node has it, and, where its axes don't stay at right angles, as a node inside of it has the rest.
    pub(super) fn of(transform: &Affine3A) -> (Self, Option<Self>) {
        let (scale, rotation, translation) = transform.to_scale_rotation_translation();
        let alone = Self {
            scale,
            rotation,
            translation,
        };
        let axes = &transform.matrix3;
        let again = Affine3A::from_scale_rotation_translation(scale, rotation, Vec3::ZERO).matrix3;
        let longest = (0..3).map(|i| axes.col(i).length()).fold(0.0, f32::max);
        if !transform.is_finite() || again.abs_diff_eq(*axes, SAME * longest) {
            return (alone, None);
        }
        let (turned, scale, before) = singular_values(axes.as_dmat3());
        let outside = Self {
            scale: scale.as_vec3(),
            rotation: turned.as_quat(),
            translation,
        };
        let inside = Self {
            scale: Vec3::ONE,
            rotation: before.as_quat(),
            translation: Vec3::ZERO,
        };
        (outside, Some(inside))
    }
}

/// Rotation, scale and rotation that make the matrix, the last one first. The smallest scale is negative where it mirrors.
fn singular_values(matrix: DMat3) -> (DQuat, DVec3, DQuat) {
    let squares = matrix.transpose() * matrix;
    let vectors = eigenvectors(squares);
    // Largest first: what the smallest leaves open follows from the others.
    let mut order = [0, 1, 2];
    let length = |i: usize| (matrix * vectors.col(i)).length_squared();
    order.sort_by(|&a, &b| length(b).total_cmp(&length(a)));
    let (first, second) = (vectors.col(order[0]), vectors.col(order[1]));
    let from = DMat3::from_cols(first, second, first.cross(second));
    let moved = matrix * from;
    let x = moved.x_axis.normalize_or(DVec3::X);
    let y = (moved.y_axis - x * x.dot(moved.y_axis)).normalize_or(x.any_orthonormal_vector());
    let to = DMat3::from_cols(x, y, x.cross(y));
    let scale = DVec3::new(
        x.dot(moved.x_axis),
        y.dot(moved.y_axis),
        to.z_axis.dot(moved.z_axis),
    );
    let rotation = |axes: &DMat3| DQuat::from_mat3(axes).normalize();
    (rotation(&to), scale, rotation(&from.transpose()))
}

/// The eigenvectors of a symmetric matrix, by Jacobi's rotations (Golub and Van Loan, "Matrix Computations", 4th edition,
/// section 8.5).
fn eigenvectors(mut symmetric: DMat3) -> DMat3 {
    let mut vectors = DMat3::IDENTITY;
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let between = symmetric.col(q)[p];
            if between == 0.0 {
                continue;
            }
            let ratio = (symmetric.col(q)[q] - symmetric.col(p)[p]) / (2.0 * between);
            let tangent = ratio.signum() / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
            let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
            let sine = tangent * cosine;
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cosine;
            turn.col_mut(q)[q] = cosine;
            turn.col_mut(q)[p] = sine;
            turn.col_mut(p)[q] = -sine;
            symmetric = turn.transpose() * symmetric * turn;
            vectors *= turn;
        }
    }
    vectors
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{EulerRot, Mat3A};

    fn matrix(place: &Place) -> Affine3A {
        Affine3A::from_scale_rotation_translation(place.scale, place.rotation, place.translation)
    }

    #[test]
    fn two_nodes_make_any_transform() {
        let turn = |x: f32| Quat::from_euler(EulerRot::XYZ, x, 2.0 * x, -x);
        let far = Vec3::new(20_000.0, -3.0, 1e-3);
        let outside = [
            Vec3::new(1.0, 3.0, 1.0),
            Vec3::new(-1.0, 3.0, 0.5),
            Vec3::new(1e-3, 2e3, 1.0),
            Vec3::new(1.0, 1.0, 8.0),
            Vec3::new(-2.0, -3.0, -1.0),
        ];
        for scale in outside {
            for angle in [0.3, 0.8, 2.0] {
                let parent = Affine3A::from_scale_rotation_translation(scale, turn(1.0), far);
                let sheared = parent * Affine3A::from_quat(turn(angle));
                let (outer, inner) = Place::of(&sheared);
                let inner = inner.expect("one node can't have it");
                let again = matrix(&outer) * matrix(&inner);
                let longest = scale.abs().max_element();
                let axes: Mat3A = sheared.matrix3;
                assert!(
                    again.matrix3.abs_diff_eq(axes, 1e-5 * longest),
                    "{scale} {angle}: {again} {sheared}"
                );
                assert_eq!(again.translation, sheared.translation);
                assert!(outer.rotation.is_normalized() && inner.rotation.is_normalized());
            }
        }
    }

    #[test]
    fn one_node_is_enough_where_axes_stay_at_right_angles() {
        for scale in [Vec3::ONE, Vec3::new(-1.0, 2.0, 1e3), Vec3::splat(1e-4)] {
            let turned = Quat::from_rotation_x(0.7);
            let far = Vec3::splat(1e5);
            let transform = Affine3A::from_scale_rotation_translation(scale, turned, far);
            let (alone, rest) = Place::of(&transform);
            assert_eq!(rest, None);
            assert!(matrix(&alone).abs_diff_eq(transform, 1e-3));
        }
    }
}
