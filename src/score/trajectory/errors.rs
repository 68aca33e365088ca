//! Absolute and relative pose errors.

use super::{Pose3, Statistics};
use rayon::prelude::*;
use serde::Serialize;

/// Errors of poses, or of movements between them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseErrors {
    /// Metres, one a pose or a pair.
    pub translation_m: Vec<f64>,
    /// Degrees about whatever axis, in [0, 180], one a pose or a pair.
    pub rotation_deg: Vec<f64>,
}

/// Statistics of both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorStatistics {
    /// Of the distances, in metres.
    pub translation_m: Statistics,
    /// Of the angles, in degrees.
    pub rotation_deg: Statistics,
}

impl PoseErrors {
    /// The absolute pose error (APE): how far each pose is from the reference's, estimate⁻¹ · reference (Kümmerle et al., *On
    /// measuring the accuracy of SLAM algorithms*, Autonomous Robots 27, 2009). `estimate` and `reference` are of one length.
    ///
    /// ```
    /// use ballmark::{Pose, score::trajectory::{Pose3, PoseErrors}};
    /// let estimate = [Pose::new(1.0, 0.0, 0.5)].map(|pose| Pose3::from_plane(&pose));
    /// let reference = [Pose::new(1.0, 2.0, 0.5)].map(|pose| Pose3::from_plane(&pose));
    /// let errors = PoseErrors::absolute(&estimate, &reference);
    /// assert_eq!((errors.translation_m[0], errors.rotation_deg[0]), (2.0, 0.0));
    /// ```
    pub fn absolute(estimate: &[Pose3], reference: &[Pose3]) -> Self {
        Self::of(
            estimate.par_iter().zip(reference),
            |(estimate, reference)| {
                let rotation = estimate.rotation.transpose() * reference.rotation;
                let distance = (estimate.position_m - reference.position_m).norm();
                (distance, super::rotation::angle_rad(&rotation))
            },
        )
    }

    /// The relative pose error (RPE): how much the movement between the two poses of each pair differs,
    /// (Qᵢ⁻¹ Qⱼ)⁻¹ (Pᵢ⁻¹ Pⱼ) with Q the reference and P the estimate (Sturm et al., *A benchmark for the evaluation of RGB-D
    /// SLAM systems*, 2012, eq. 1). Pairs are numbers of poses, below the length of both.
    ///
    /// ```
    /// use ballmark::{Pose, score::trajectory::{Pose3, PoseErrors}};
    /// let reference = [0.0, 1.0, 2.0].map(|x| Pose3::from_plane(&Pose::new(x, 0.0, 0.0)));
    /// let estimate = [0.0, 1.5, 2.5].map(|x| Pose3::from_plane(&Pose::new(x, 9.0, 0.0)));
    /// let errors = PoseErrors::relative(&estimate, &reference, &[(0, 1), (1, 2)]);
    /// assert_eq!(errors.translation_m, [0.5, 0.0]);
    /// ```
    pub fn relative(estimate: &[Pose3], reference: &[Pose3], pairs: &[(usize, usize)]) -> Self {
        Self::of(pairs.par_iter(), |&(i, j)| {
            let moved = reference[j].relative_to(&reference[i]);
            let estimated = estimate[j].relative_to(&estimate[i]);
            let error = estimated.relative_to(&moved);
            (error.position_m.norm(), error.angle_rad())
        })
    }

    fn of<T: Send>(
        items: impl IndexedParallelIterator<Item = T>,
        error: impl Fn(T) -> (f64, f64) + Sync + Send,
    ) -> Self {
        let both = |item: T| {
            let (metres, radians) = error(item);
            (metres, radians.to_degrees())
        };
        let (translation_m, rotation_deg) = items.with_min_len(1024).map(both).unzip();
        Self {
            translation_m,
            rotation_deg,
        }
    }

    /// Statistics of both; none of none.
    pub fn statistics(&self) -> Option<ErrorStatistics> {
        Some(ErrorStatistics {
            translation_m: Statistics::of(&self.translation_m)?,
            rotation_deg: Statistics::of(&self.rotation_deg)?,
        })
    }
}
