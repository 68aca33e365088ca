//! A place and an orientation in space.

use super::rotation;
use crate::geometry::Pose;
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Where something is and how it is turned: x ↦ R x + t leads from its own frame to the world's.
///
/// The rotation is kept as the matrix that the file has or the quaternion gives, as `evo` keeps it: matrices of few digits
/// give the same errors there and here.
///
/// ```
/// use ballmark::{Pose, score::trajectory::Pose3};
/// use ballmark::nalgebra::Vector3;
/// // A quarter turn about the vertical axis.
/// let turned = Pose3::from_quaternion(Vector3::new(1.0, 2.0, 0.5), [0.0, 0.0, 1.0, 1.0]).unwrap();
/// let flat = turned.to_plane();
/// assert!((flat.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
/// assert!((turned.angle_rad() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
/// // From (1, 2), facing north, the origin lies 2 m behind and 1 m to the left.
/// let origin = Pose3::from_plane(&Pose::default()).relative_to(&turned);
/// assert!((origin.position_m - Vector3::new(-2.0, 1.0, -0.5)).norm() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose3 {
    /// Metres.
    pub position_m: Vector3<f64>,
    /// Columns are the directions of the own axes in the world.
    pub rotation: Matrix3<f64>,
}

impl Pose3 {
    /// A pose in the plane: z = 0, turned about the vertical axis.
    pub fn from_plane(pose: &Pose) -> Self {
        Self {
            position_m: Vector3::new(pose.x_m, pose.y_m, 0.0),
            rotation: Rotation3::from_axis_angle(&Vector3::z_axis(), pose.heading_rad).into_inner(),
        }
    }

    /// A pose from a quaternion in the order of TUM files, x, y, z, w; its length doesn't count. None where it has no length.
    pub fn from_quaternion(position_m: Vector3<f64>, xyzw: [f64; 4]) -> Option<Self> {
        let [x, y, z, w] = xyzw;
        let unit = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6)?;
        Some(Self {
            position_m,
            rotation: unit.to_rotation_matrix().into_inner(),
        })
    }

    /// The unit quaternion of the rotation: x, y, z, w, with w ≥ 0.
    pub fn quaternion(&self) -> [f64; 4] {
        rotation::quaternion(&self.rotation).into()
    }

    /// Seen from above: x, y, and the direction of the own x axis.
    pub fn to_plane(&self) -> Pose {
        let heading_rad = self.rotation[(1, 0)].atan2(self.rotation[(0, 0)]);
        Pose::new(self.position_m.x, self.position_m.y, heading_rad)
    }

    /// This pose in the frame of `base`: base⁻¹ · self.
    pub fn relative_to(&self, base: &Self) -> Self {
        let back = base.rotation.transpose();
        Self {
            position_m: back * self.position_m - back * base.position_m,
            rotation: back * self.rotation,
        }
    }

    /// How far it is turned about whatever axis, in [0, π] radians.
    pub fn angle_rad(&self) -> f64 {
        rotation::angle_rad(&self.rotation)
    }
}
