//! The rotation, translation and scale that lay an estimate onto a reference with least squared distances.

use super::Pose3;
use crate::error::{Error, Result};
use nalgebra::{DMatrix, Matrix3, Vector3};
use serde::Serialize;
use std::{fmt, str::FromStr};

/// What an estimate may be moved by before it is judged.
///
/// ```
/// use ballmark::score::trajectory::Alignment;
/// assert_eq!("sim3".parse::<Alignment>()?, Alignment::Sim3);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Alignment {
    /// Nothing: estimate and reference are in one frame, as those of a robot on its map are.
    #[default]
    None,
    /// A turn about the vertical axis and a shift in the plane; heights stay.
    Se2,
    /// A rotation and a translation in space. It may turn a trajectory in the plane upside down where a mirror image fits better.
    Se3,
    /// As `Se2`, with a scale in the plane.
    Sim2,
    /// As `Se3`, with a scale.
    Sim3,
}

impl Alignment {
    /// What `--align` calls them.
    pub const NAMES: [&'static str; 5] = ["none", "se2", "se3", "sim2", "sim3"];

    /// The similarity of this kind that lays places of an estimate onto those of a reference, pair by pair.
    ///
    /// # Errors
    /// Where the places don't determine it: they are one place, or in space lie on one line.
    pub fn fit(self, estimate: &[Vector3<f64>], reference: &[Vector3<f64>]) -> Result<Similarity> {
        match self {
            Self::None => Ok(Similarity::identity()),
            Self::Se2 => umeyama(estimate, reference, 2, false),
            Self::Se3 => umeyama(estimate, reference, 3, false),
            Self::Sim2 => umeyama(estimate, reference, 2, true),
            Self::Sim3 => umeyama(estimate, reference, 3, true),
        }
    }
}

impl FromStr for Alignment {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "none" => Ok(Self::None),
            "se2" => Ok(Self::Se2),
            "se3" => Ok(Self::Se3),
            "sim2" => Ok(Self::Sim2),
            "sim3" => Ok(Self::Sim3),
            _ => Err(Error::usage(format!(
                "alignment `{}`: expected one of {}",
                name.escape_debug(),
                Self::NAMES.join(", ")
            ))),
        }
    }
}

impl fmt::Display for Alignment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Se2 => "se2",
            Self::Se3 => "se3",
            Self::Sim2 => "sim2",
            Self::Sim3 => "sim3",
        })
    }
}

/// x ↦ c R x + t; orientations are turned by R alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// R.
    pub rotation: Matrix3<f64>,
    /// t, in metres.
    pub translation_m: Vector3<f64>,
    /// c along each axis before the rotation: three times the same, or 1 for the height.
    pub scale: Vector3<f64>,
}

impl Similarity {
    /// What changes nothing.
    pub fn identity() -> Self {
        Self {
            rotation: Matrix3::identity(),
            translation_m: Vector3::zeros(),
            scale: Vector3::repeat(1.0),
        }
    }

    /// The moved pose.
    pub fn apply(&self, pose: &Pose3) -> Pose3 {
        let scaled = self.scale.component_mul(&pose.position_m);
        Pose3 {
            position_m: self.rotation * scaled + self.translation_m,
            rotation: self.rotation * pose.rotation,
        }
    }
}

/// Umeyama, *Least-squares estimation of transformation parameters between two point patterns*, IEEE PAMI 13(4), 1991, in the
/// first `m` dimensions.
fn umeyama(
    x: &[Vector3<f64>],
    y: &[Vector3<f64>],
    m: usize,
    with_scale: bool,
) -> Result<Similarity> {
    let n = x.len() as f64;
    if x.len() != y.len() || x.is_empty() {
        return Err(Error::work(format!(
            "cannot align {} places with {}; expected as many, and at least one",
            x.len(),
            y.len()
        )));
    }
    let mean = |of: &[Vector3<f64>]| of.iter().sum::<Vector3<f64>>() / n; // (eq. 34, 35)
    let (mean_x, mean_y) = (mean(x), mean(y));
    let mut variance = 0.0; // σ_x² (eq. 36)
    let mut covariance = DMatrix::<f64>::zeros(m, m); // Σ_xy (eq. 38)
    for (x, y) in x.iter().zip(y) {
        let (dx, dy) = (x - mean_x, y - mean_y);
        let (dx, dy) = (dx.rows(0, m), dy.rows(0, m));
        variance += dx.norm_squared() / n;
        covariance += dy * dx.transpose() / n;
    }
    let svd = covariance.svd(true, true);
    let d = &svd.singular_values;
    // R is determined where at least m − 1 singular values are not 0 (text between eq. 38 and 39).
    let negligible = d.max().max(f64::MIN_POSITIVE) * 1e-13;
    let rank = d.iter().filter(|&&value| value > negligible).count();
    let (Some(u), Some(v_t), true) = (svd.u, svd.v_t, rank + 1 >= m && d.max() > 0.0) else {
        let fault = if m == 3 {
            "the places lie on one line (or are one place), about which it could be turned in any way; expected --align se2 or none"
        } else {
            "the places are one place; expected --align none"
        };
        return Err(Error::work(format!("cannot align the estimate: {fault}")));
    };
    let mut s = DMatrix::<f64>::identity(m, m); // S (eq. 43): no mirror image
    if u.determinant() * v_t.determinant() < 0.0 {
        // The axis of least variance is the one to turn round.
        let least = d.imin();
        s[(least, least)] = -1.0;
    }
    let turn = &u * &s * &v_t; // (eq. 40)
    let c = match with_scale {
        true => (DMatrix::from_diagonal(d) * &s).trace() / variance, // (eq. 42)
        false => 1.0,
    };
    let mut rotation = Matrix3::identity();
    rotation.view_mut((0, 0), (m, m)).copy_from(&turn);
    let mut scale = Vector3::repeat(1.0);
    scale.rows_mut(0, m).fill(c);
    let mut translation_m = mean_y - rotation * scale.component_mul(&mean_x); // (eq. 41)
    translation_m.rows_mut(m, 3 - m).fill(0.0);
    Ok(Similarity {
        rotation,
        translation_m,
        scale,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn cloud() -> Vec<Vector3<f64>> {
        (0..40)
            .map(|k| {
                let t = f64::from(k) * 0.3;
                Vector3::new(t.sin() * 5.0 + t, (1.3 * t).cos() * 3.0, (0.7 * t).sin())
            })
            .collect()
    }

    #[test]
    fn a_moved_cloud_is_moved_back() {
        let rotation = Rotation3::from_euler_angles(0.4, -0.7, 2.0).into_inner();
        let shift = Vector3::new(10.0, -3.0, 0.5);
        let cloud = cloud();
        let moved: Vec<_> = cloud.iter().map(|x| rotation * x * 2.5 + shift).collect();
        let found = Alignment::Sim3.fit(&cloud, &moved).unwrap();
        assert!((found.rotation - rotation).norm() < 1e-12);
        assert!((found.translation_m - shift).norm() < 1e-11);
        assert!((found.scale - Vector3::repeat(2.5)).norm() < 1e-12);
        let rigid = Alignment::Se3.fit(&cloud, &moved).unwrap();
        assert_eq!(rigid.scale, Vector3::repeat(1.0));
        assert!((rigid.rotation - rotation).norm() < 1e-12);
    }

    #[test]
    fn in_the_plane_heights_stay_and_nothing_is_turned_over() {
        let flat: Vec<_> = cloud()
            .iter()
            .map(|x| Vector3::new(x.x, x.y, 7.0))
            .collect();
        // A mirror image: in space it is reached by turning the plane over, in the plane it is not.
        let mirror: Vec<_> = flat.iter().map(|x| Vector3::new(x.x, -x.y, 7.0)).collect();
        let distance = |kind: Alignment| {
            let fit = kind.fit(&flat, &mirror).unwrap();
            let moved = flat.iter().map(|&position_m| {
                fit.apply(&Pose3 {
                    position_m,
                    rotation: Matrix3::identity(),
                })
                .position_m
            });
            moved.zip(&mirror).map(|(a, b)| (a - b).norm()).sum::<f64>()
        };
        assert!(distance(Alignment::Se3) < 1e-9);
        assert!(distance(Alignment::Se2) > 1.0);
        let fit = Alignment::Sim2.fit(&flat, &mirror).unwrap();
        assert_eq!((fit.scale.z, fit.translation_m.z), (1.0, 0.0));
        assert_eq!(fit.rotation[(2, 2)], 1.0);
        assert!(fit.rotation.determinant() > 0.0);
    }

    #[test]
    fn what_does_not_determine_it_is_refused() {
        let line: Vec<_> = (0..9).map(|k| Vector3::repeat(f64::from(k))).collect();
        let error = Alignment::Se3.fit(&line, &line).unwrap_err().to_string();
        assert!(error.contains("one line"), "{error}");
        assert!(Alignment::Se2.fit(&line, &line).is_ok());
        let one = [Vector3::zeros(); 4];
        assert!(Alignment::Se2.fit(&one, &one).is_err());
        assert!(Alignment::None.fit(&one, &one).is_ok());
    }
}
