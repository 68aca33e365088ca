//! Everything that is said of an estimate against a reference, under the names that users and other programs rely on.

use super::{
    Alignment, Delta, ErrorStatistics, Matching, Pairing, Pose3, PoseErrors, RunTraces, Similarity,
    Trajectory,
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    score::prediction_correction::{MetricOptions, PredictionCorrection, Traces},
};
use nalgebra::Vector3;
use serde::Serialize;

/// Share of the reference's poses that must have a pose of the estimate. A localiser that loses track early and falls silent
/// would otherwise be judged by its good beginning.
pub const LEAST_COMPLETENESS: f64 = 0.9;

/// How an estimate is judged.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct EvaluationOptions {
    /// How poses are paired.
    pub matching: Matching,
    /// What the estimate is moved by first.
    pub alignment: Alignment,
    /// Both are seen from above, after the alignment: x, y and heading.
    pub in_plane: bool,
    /// Between which poses the relative error is measured.
    pub delta: Delta,
    /// Fewer matched poses than [`LEAST_COMPLETENESS`] are noted, not refused.
    pub allow_incomplete: bool,
    /// For the prediction–correction metric.
    pub metric: MetricOptions,
}

/// What an estimate is worth; serialised, its fields are the JSON keys.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Evaluation {
    /// Pairs of poses that the errors are over.
    pub matched: usize,
    /// Poses of the reference.
    pub total: usize,
    /// Share of the reference's poses that are in a pair.
    pub completeness: f64,
    /// Poses of the estimate.
    pub estimate_poses: usize,
    /// Absolute pose error.
    pub ape: ErrorStatistics,
    /// Relative pose error.
    pub rpe: ErrorStatistics,
    /// What the relative error was measured between.
    pub rpe_delta: MeasuredPairs,
    /// What the estimate was moved by.
    pub alignment: AppliedAlignment,
    /// Were both seen from above?
    pub in_plane: bool,
    /// Seconds that the stamps of a pair may differ by; none where poses were paired in order.
    pub max_difference_s: Option<f64>,
    /// Seconds that were added to the estimate's stamps; none where poses were paired in order.
    pub offset_s: Option<f64>,
    /// The metric of Ruiz-Mayor et al. (2006); none without the estimates before correction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prediction_correction: Option<PredictionCorrection>,
    /// What a reader may take wrongly.
    pub notes: Vec<String>,
    /// The estimate's poses that were matched, moved onto the reference, with their own stamps.
    #[serde(skip)]
    pub aligned: Trajectory,
    /// All that was compared, seen from above.
    #[serde(skip)]
    pub traces: RunTraces,
}

/// The pairs of poses of a relative error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeasuredPairs {
    /// How far apart they are.
    #[serde(flatten)]
    pub delta: Delta,
    /// Their number.
    pub pairs: usize,
}

/// An alignment and what it found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AppliedAlignment {
    /// Its kind.
    pub kind: Alignment,
    /// Quaternion x, y, z, w of the rotation.
    pub rotation_xyzw: [f64; 4],
    /// Translation in metres, after rotation and scale.
    pub translation_m: [f64; 3],
    /// Scale (in the plane alone for `sim2`); 1 for kinds without.
    pub scale: f64,
}

impl AppliedAlignment {
    fn new(kind: Alignment, found: &Similarity) -> Self {
        let turn = Pose3 {
            position_m: found.translation_m,
            rotation: found.rotation,
        };
        Self {
            kind,
            rotation_xyzw: turn.quaternion(),
            translation_m: found.translation_m.into(),
            scale: found.scale.x,
        }
    }
}

/// Judges an estimate against a reference and, where a `prior` is given (the estimates before correction, with the
/// estimate's stamps), its correction apart from its prediction.
///
/// # Errors
/// Where a trajectory has a single pose, poses can't be paired ([`Pairing::of`]), fewer than [`LEAST_COMPLETENESS`] of the reference's
/// poses are matched (or of the matched ones have a prior) and that is not allowed, the alignment is not determined, or no poses are
/// as far apart as the relative error asks for.
pub fn evaluate(
    estimate: &Trajectory,
    reference: &Trajectory,
    prior: Option<&Trajectory>,
    options: &EvaluationOptions,
) -> Result<Evaluation> {
    options.delta.check()?;
    for trajectory in [Some(estimate), Some(reference), prior]
        .into_iter()
        .flatten()
    {
        if trajectory.len() < 2 {
            let fault = "holds one pose; expected a trajectory of at least two";
            return Err(Error::file(trajectory.name(), fault));
        }
    }
    let pairing = Pairing::of(estimate, reference, &options.matching)?;
    let total = reference.len();
    let completeness = pairing.covered() as f64 / total as f64;
    let mut notes = Vec::new();
    if completeness < LEAST_COMPLETENESS {
        let told = incomplete(estimate, reference, &pairing, options);
        if !options.allow_incomplete {
            return Err(
                Error::work(told).followed_by("expected a full estimate, or --allow-incomplete")
            );
        }
        notes.push(told);
    }
    if pairing.len() < 2 {
        return Err(Error::work(format!(
            "a single pose of {} is matched; expected at least two",
            estimate.name()
        )));
    }
    notes.extend(odd(estimate, reference, &pairing, completeness, options));

    let chosen = |of: &Trajectory, at: &[usize]| -> Vec<Pose3> {
        at.iter().map(|&k| of.poses()[k]).collect()
    };
    let (mut estimated, mut real) = (
        chosen(estimate, &pairing.estimate),
        chosen(reference, &pairing.reference),
    );
    let places = |of: &[Pose3]| -> Vec<Vector3<f64>> { of.iter().map(|p| p.position_m).collect() };
    let found = options.alignment.fit(&places(&estimated), &places(&real))?;
    let flat = |pose: Pose3| match options.in_plane {
        true => Pose3::from_plane(&pose.to_plane()),
        false => pose,
    };
    let moved = |pose: &Pose3| flat(found.apply(pose));
    estimated = estimated.iter().map(moved).collect();
    real = real.into_iter().map(flat).collect();

    let nothing = || Error::work("no pair of poses to compare; expected at least one");
    let ape = PoseErrors::absolute(&estimated, &real).statistics();
    let along = if options.delta.from_reference {
        &real
    } else {
        &estimated
    };
    let pairs = options.delta.pairs(along)?;
    let rpe = PoseErrors::relative(&estimated, &real, &pairs).statistics();

    let planar = |poses: &[Pose3]| -> Vec<Pose> { poses.iter().map(Pose3::to_plane).collect() };
    let times = reference.stamps();
    let mut traces = RunTraces {
        stamp_s: times.map(|times| pairing.reference.iter().map(|&k| times[k]).collect()),
        real: planar(&real),
        posterior: planar(&estimated),
        prior: vec![None; pairing.len()],
    };
    let prediction_correction = match prior {
        None => None,
        Some(prior) => {
            let of = before_correction(estimate, prior, &pairing, options, &mut notes)?;
            for &(pair, k) in &of {
                traces.prior[pair] = Some(moved(&prior.poses()[k]).to_plane());
            }
            let [real, prior, posterior] = traces.with_prior();
            let run = Traces {
                name: estimate.name(),
                real: &real,
                prior: &prior,
                posterior: &posterior,
            };
            let metric = PredictionCorrection::of(&[run], &options.metric)?;
            notes.extend(metric.notes());
            Some(metric)
        }
    };
    let stamps = estimate.stamps();
    let own = stamps.map(|stamps| pairing.estimate.iter().map(|&k| stamps[k]).collect());
    Ok(Evaluation {
        matched: pairing.len(),
        total,
        completeness,
        estimate_poses: estimate.len(),
        ape: ape.ok_or_else(nothing)?,
        rpe: rpe.ok_or_else(nothing)?,
        rpe_delta: MeasuredPairs {
            delta: options.delta,
            pairs: pairs.len(),
        },
        alignment: AppliedAlignment::new(options.alignment, &found),
        in_plane: options.in_plane,
        max_difference_s: stamps.map(|_| options.matching.max_difference_s),
        offset_s: stamps.map(|_| options.matching.offset_s),
        prediction_correction,
        notes,
        aligned: Trajectory::new(estimate.name(), own, estimated)?,
        traces,
    })
}

/// That too few poses are matched, and what tells a lost track from an estimate at a lower rate.
fn incomplete(
    estimate: &Trajectory,
    reference: &Trajectory,
    pairing: &Pairing,
    options: &EvaluationOptions,
) -> String {
    let (covered, total) = (pairing.covered(), reference.len());
    let span = match (estimate.stamps(), reference.stamps()) {
        (Some(stamps), Some(theirs)) => {
            let (from, to) = (stamps[0], stamps[stamps.len() - 1]);
            let spanned = theirs.iter().filter(|&&stamp| {
                from + options.matching.offset_s <= stamp && stamp <= to + options.matching.offset_s
            });
            let share = 100.0 * spanned.count() as f64 / total as f64;
            format!(
                "; its {} poses span {share:.1} % of them in time",
                estimate.len()
            )
        }
        _ => String::new(),
    };
    format!(
        "{} has a pose for {covered} of {total} poses of {} ({:.1} %, under {:.0} %){span}",
        estimate.name(),
        reference.name(),
        100.0 * covered as f64 / total as f64,
        100.0 * LEAST_COMPLETENESS
    )
}

/// Poses before the first or after the last of `other`, whose stamps allow no pair; `of`'s stamps get the offset.
fn outside(of: &Trajectory, other: &Trajectory, matching: &Matching) -> usize {
    let (Some(stamps), Some(theirs)) = (of.stamps(), other.stamps()) else {
        return 0;
    };
    let from = theirs[0] - matching.max_difference_s - matching.offset_s;
    let to = theirs[theirs.len() - 1] + matching.max_difference_s - matching.offset_s;
    let beyond = |stamp: &&f64| **stamp < from || **stamp > to;
    stamps.iter().filter(beyond).count()
}

/// What is unlikely to be meant.
fn odd(
    estimate: &Trajectory,
    reference: &Trajectory,
    pairing: &Pairing,
    completeness: f64,
    options: &EvaluationOptions,
) -> Vec<String> {
    let mut notes = Vec::new();
    let (name, reference_name) = (estimate.name(), reference.name());
    let shared = pairing.len() - pairing.covered();
    if shared > 0 {
        notes.push(format!(
            "{shared} poses of {name} share a pose of {reference_name} with another: its stamps are denser than --max-difference"
        ));
    }
    let outside = outside(estimate, reference, &options.matching);
    if completeness >= LEAST_COMPLETENESS
        && outside as f64 > (1.0 - LEAST_COMPLETENESS) * estimate.len() as f64
    {
        notes.push(format!(
            "{outside} of {} poses of {name} lie outside the time of {reference_name} and are not judged; if {name} is the \
             reference, give it second",
            estimate.len()
        ));
    }
    if estimate.poses() == reference.poses() {
        notes.push(format!(
            "{name} and {reference_name} hold the same poses: there is no error to measure"
        ));
    }
    notes
}

/// The matched pairs, by number, that have an estimate before correction, and its number.
fn before_correction(
    estimate: &Trajectory,
    prior: &Trajectory,
    pairing: &Pairing,
    options: &EvaluationOptions,
    notes: &mut Vec<String>,
) -> Result<Vec<(usize, usize)>> {
    let same_clock = Matching {
        offset_s: 0.0,
        ..options.matching
    };
    let mut prior_of = vec![None; estimate.len()];
    let known = Pairing::of(prior, estimate, &same_clock)?;
    for (k, at) in known.estimate.into_iter().zip(known.reference) {
        prior_of[at] = Some(k);
    }
    let of: Vec<(usize, usize)> = (0..pairing.len())
        .filter_map(|pair| Some((pair, prior_of[pairing.estimate[pair]]?)))
        .collect();
    let matched = pairing.len();
    if of.len() < matched {
        let told = format!(
            "{} has a prior for {} of {matched} matched poses of {}",
            prior.name(),
            of.len(),
            estimate.name()
        );
        let few = (of.len() as f64) < LEAST_COMPLETENESS * matched as f64;
        if of.is_empty() || (few && !options.allow_incomplete) {
            return Err(Error::work(told).followed_by(
                "expected a prior for every pose of the estimate, or --allow-incomplete",
            ));
        }
        notes.push(told);
    }
    Ok(of)
}
