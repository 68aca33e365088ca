//! A trajectory: poses in order, with time stamps or without.

use super::Pose3;
use crate::{
    error::{Error, Result},
    geometry::Pose,
};

/// Metres from the origin beyond which a coordinate is taken for damage.
pub(super) const FARTHEST_M: f64 = 1e9;

/// Poses in the order in which they were passed, and the file or system that they come from.
///
/// ```
/// use ballmark::{Pose, score::trajectory::Trajectory};
/// let walk = [Pose::new(0.0, 0.0, 0.0), Pose::new(1.0, 0.0, 0.1)];
/// let trajectory = Trajectory::in_plane("odometry", Some(vec![0.0, 0.5]), &walk)?;
/// assert_eq!((trajectory.len(), trajectory.path_m()), (2, 1.0));
/// let error = Trajectory::in_plane("odometry", Some(vec![0.5, 0.5]), &walk).unwrap_err();
/// assert!(error.to_string().contains("pose 1: stamp 0.5"));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    name: String,
    stamp_s: Option<Vec<f64>>,
    pose: Vec<Pose3>,
}

impl Trajectory {
    /// A trajectory of these poses. `name` stands in messages: a file or a system.
    ///
    /// # Errors
    /// Where there is no pose, a number is not finite or a place lies beyond 10⁹ m, stamps are fewer or more than poses, or a stamp
    /// is not after the one before it.
    pub fn new(
        name: impl Into<String>,
        stamp_s: Option<Vec<f64>>,
        pose: Vec<Pose3>,
    ) -> Result<Self> {
        let name = name.into();
        let wrong = |fault: String| Err(Error::file(&name, fault));
        if pose.is_empty() {
            return wrong("no pose; expected at least one".into());
        }
        let is_sound = |pose: &Pose3| {
            pose.position_m.iter().all(|x| x.abs() <= FARTHEST_M)
                && pose.rotation.iter().all(|entry| entry.is_finite())
        };
        if let Some(k) = pose.iter().position(|pose| !is_sound(pose)) {
            return wrong(format!(
                "pose {k}: {:?}; expected finite numbers, metres within ±1e9",
                pose[k].position_m.as_slice()
            ));
        }
        let trajectory = Self {
            name,
            stamp_s: None,
            pose,
        };
        match stamp_s {
            None => Ok(trajectory),
            Some(stamp_s) => trajectory.with_stamps(stamp_s),
        }
    }

    /// A trajectory in the plane.
    ///
    /// # Errors
    /// As [`Trajectory::new`].
    pub fn in_plane(
        name: impl Into<String>,
        stamp_s: Option<Vec<f64>>,
        pose: &[Pose],
    ) -> Result<Self> {
        Self::new(name, stamp_s, pose.iter().map(Pose3::from_plane).collect())
    }

    /// The same poses with these time stamps, in seconds.
    ///
    /// # Errors
    /// Where they are fewer or more than poses, not finite, or not rising.
    pub fn with_stamps(mut self, stamp_s: Vec<f64>) -> Result<Self> {
        let (poses, stamps) = (self.pose.len(), stamp_s.len());
        if poses != stamps {
            return Err(Error::file(
                &self.name,
                format!("{poses} poses and {stamps} time stamps; expected one each"),
            ));
        }
        if let Some((k, fault)) = not_rising(&stamp_s, |k| format!("pose {k}")) {
            return Err(Error::input(&self.name, format!("pose {k}"), fault));
        }
        self.stamp_s = Some(stamp_s);
        Ok(self)
    }

    /// The file or system that the poses come from.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of poses; never 0.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.pose.len()
    }

    /// The poses, in order.
    pub fn poses(&self) -> &[Pose3] {
        &self.pose
    }

    /// Seconds, one a pose, rising; none where the file has no times.
    pub fn stamps(&self) -> Option<&[f64]> {
        self.stamp_s.as_deref()
    }

    /// Length of the way from pose to pose, in metres.
    pub fn path_m(&self) -> f64 {
        let step = |pair: &[Pose3]| (pair[1].position_m - pair[0].position_m).norm();
        self.pose.windows(2).map(step).sum()
    }
}

/// The first stamp that is not finite or not after the one before it, and what is wrong with it; `place` names a pose.
pub(super) fn not_rising(
    stamp_s: &[f64],
    place: impl Fn(usize) -> String,
) -> Option<(usize, String)> {
    (0..stamp_s.len()).find_map(|k| {
        let (now, before) = (stamp_s[k], k.checked_sub(1).map(|before| stamp_s[before]));
        let fault = match before {
            _ if !now.is_finite() => "is not finite; expected seconds".into(),
            Some(before) if now == before => format!(
                "stands at {} already; expected one pose a stamp",
                place(k - 1)
            ),
            Some(before) if now < before => format!(
                "goes back behind {before} at {}; expected rising stamps",
                place(k - 1)
            ),
            _ => return None,
        };
        Some((k, format!("stamp {now} {fault}")))
    })
}
