//! Rotations as 3 × 3 matrices: their quaternions and angles.

use nalgebra::{Matrix3, Vector4};

/// How far rows may be from unit length before the matrix is made orthogonal first. Relative, and wide: files hold matrices of
/// six digits.
const UNIT: f64 = 1e-5;

/// How far rows may be from right angles before that.
const RIGHT: f64 = 1e-12;

/// The unit quaternion (x, y, z, w), w ≥ 0, of a rotation; of the nearest rotation where the matrix is none to the last digits.
pub(super) fn quaternion(matrix: &Matrix3<f64>) -> Vector4<f64> {
    let gram = matrix * matrix.transpose();
    let skewed = (0..3).any(|row| {
        (0..3).any(|column| {
            let (expected, within) = if row == column {
                (1.0, UNIT + RIGHT)
            } else {
                (0.0, RIGHT)
            };
            (gram[(row, column)] - expected).abs() > within
        })
    });
    let m = if skewed { nearest(matrix) } else { *matrix };
    // The largest of the four components is found from the diagonal and divides the others: nothing cancels.
    let trace = m.trace();
    let by = [m[(0, 0)], m[(1, 1)], m[(2, 2)], trace];
    let largest = (1..4).fold(0, |best, k| if by[k] > by[best] { k } else { best });
    let sum = |i: usize, j: usize| m[(i, j)] + m[(j, i)];
    let difference = |i: usize, j: usize| m[(i, j)] - m[(j, i)];
    let q = match largest {
        0 => Vector4::new(
            1.0 - trace + 2.0 * m[(0, 0)],
            sum(0, 1),
            sum(0, 2),
            difference(2, 1),
        ),
        1 => Vector4::new(
            sum(0, 1),
            1.0 - trace + 2.0 * m[(1, 1)],
            sum(1, 2),
            difference(0, 2),
        ),
        2 => Vector4::new(
            sum(0, 2),
            sum(1, 2),
            1.0 - trace + 2.0 * m[(2, 2)],
            difference(1, 0),
        ),
        _ => Vector4::new(
            difference(2, 1),
            difference(0, 2),
            difference(1, 0),
            1.0 + trace,
        ),
    };
    let unit = q / q.norm();
    if unit.w < 0.0 { -unit } else { unit }
}

/// The angle of a rotation about its axis, in [0, π] radians.
pub(super) fn angle_rad(matrix: &Matrix3<f64>) -> f64 {
    let q = quaternion(matrix);
    2.0 * q.xyz().norm().atan2(q.w)
}

/// The rotation nearest to a matrix that is almost one, in the sum of squares.
fn nearest(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = matrix.svd(true, true);
    match (svd.u, svd.v_t) {
        (Some(u), Some(v_t)) => u * v_t,
        _ => *matrix,
    }
}

/// Is this a rotation but for the rounding of a few digits?
pub(super) fn is_rotation(matrix: &Matrix3<f64>) -> bool {
    const ROUNDED: f64 = 1e-3;
    let off = matrix * matrix.transpose() - Matrix3::identity();
    off.iter().all(|entry| entry.abs() <= ROUNDED) && matrix.determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Unit, Vector3};

    #[test]
    fn angles_and_quaternions_of_known_rotations() {
        let axes = [
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.1, -0.9, 0.3),
            Vector3::new(-0.5, 0.5, 4.0),
        ];
        for axis in axes {
            let axis = Unit::new_normalize(axis);
            for angle in [0.0, 1e-9, 0.3, 1.5, 3.0, 3.13] {
                let matrix = Rotation3::from_axis_angle(&axis, angle).into_inner();
                assert!((angle_rad(&matrix) - angle).abs() < 1e-14, "{angle}");
                let q = quaternion(&matrix);
                let expected = axis.into_inner() * (angle / 2.0).sin();
                assert!((q.xyz() - expected).norm() < 1e-14, "{axis:?} {angle}");
            }
        }
    }

    #[test]
    fn a_matrix_of_few_digits_counts_as_the_rotation_nearest_to_it() {
        let axis = Unit::new_normalize(Vector3::new(0.3, 0.2, -0.9));
        let matrix = Rotation3::from_axis_angle(&axis, 0.7).into_inner();
        let rounded = matrix.map(|entry: f64| (entry * 1e4).round() / 1e4);
        assert!(is_rotation(&rounded));
        assert!((angle_rad(&rounded) - 0.7).abs() < 1e-4);
        assert!((quaternion(&rounded).norm() - 1.0).abs() < 1e-15);
        assert!(!is_rotation(&(matrix * 1.1)) && !is_rotation(&-matrix));
    }
}
