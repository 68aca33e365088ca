//! When a robot counts as lost: constants fitted on the validation part, never on what is judged.
//!
//! The method's filter runs over sequences of the validation part from a start anywhere, and once more over each with a jump to
//! another in its middle, so that it is seen unsure and right, sure and right, and sure and wrong.

use super::{
    carried::{Ground, jumps, on_validation},
    method::Method,
    methods::MethodContext,
    sequences::{motion, validation_sequences},
    trial_play::scaled_sensor,
};
use crate::{
    belief::{Belief, Places},
    error::Result,
    localiser::{
        BayesLocaliser, LostConfig, PreparedSensorModel,
        lost::NEAR_M,
        sensor_model::{EvidenceScale, Memory, Remembered},
    },
    score::Auroc,
    seed::Seed,
};
use rayon::prelude::*;

/// Sequences that are driven, each with and without a jump.
pub(super) const SEQUENCES: usize = 12;

/// One step: was the robot lost, and what the score is made of.
#[derive(Debug, Clone)]
struct Point {
    is_lost: bool,
    near_mass: f64,
    ratios: Vec<f64>,
}

impl Point {
    fn score(&self, config: &LostConfig) -> f64 {
        config.score(self.near_mass, &self.ratios)
    }
}

/// The constants for a method; the usual ones where nothing can be validated, none where it is no filter with a sensor.
pub(super) fn tuned_lost(
    method: &Method,
    context: &MethodContext,
    scale: Option<EvidenceScale>,
) -> Result<Option<LostConfig>> {
    let is_filter = super::carried::is_filter(method);
    let usual = is_filter.then(LostConfig::default);
    let Some(source) = context.parts.source.as_ref().filter(|_| is_filter) else {
        return Ok(usual);
    };
    let trials = validation_sequences(context, SEQUENCES)?;
    if trials.is_empty() {
        return Ok(usual);
    }
    let places = Places::of(&source.recording);
    let ground = Ground {
        recording: &source.recording,
        places: &places,
        grid: &context.grid,
    };
    let carried = jumps(&trials, &places, |length_m| 0.5 * length_m, context.seed());
    let anywhere = Belief::uniform(context.grid.places())?;
    let fitted = on_validation(method, context, |sensor| {
        let memory = Memory::default(); // each sequence is driven twice
        let remembered = Remembered::new(sensor, &memory);
        let scaled = scaled_sensor(Some(&remembered), scale);
        let sensor = scaled
            .as_ref()
            .map_or(&remembered as &dyn PreparedSensorModel, |s| s);
        let drives = trials.iter().map(|trial| vec![trial]);
        let drives = drives.chain(carried.iter().map(|jump| vec![&jump.before, &jump.after]));
        let drives: Vec<_> = drives.collect();
        let drives = drives.par_iter().enumerate().map(|(number, legs)| {
            let stream = context
                .seed()
                .numbered_stream("tuning of lost", number as u64);
            let (grid, motion) = (&context.grid, motion(method, context));
            let robot = BayesLocaliser::new(grid, motion, anywhere.clone(), Some(sensor), stream)?;
            // Before its jump a robot is where the same sequence without one has it.
            let last = ground.drive(robot, legs)?.pop().unwrap_or_default();
            let steps = last.point_error_m.iter().zip(&last.sureness.near_mass);
            let steps = steps.zip(&last.sureness.ratios);
            let point = |((error_m, near_mass), ratios): ((&f64, &f64), &Vec<f64>)| Point {
                is_lost: *error_m > NEAR_M,
                near_mass: *near_mass,
                ratios: ratios.clone(),
            };
            Ok(steps.map(point).collect::<Vec<Point>>())
        });
        let points = drives.collect::<Result<Vec<_>>>()?;
        let (anywhere, carried) = points.split_at(trials.len());
        Ok(fitted(&anywhere.concat(), &carried.concat()))
    })?;
    Ok(fitted.or(usual))
}

/// The constants by which steps without and with a jump are told apart best, both counting alike as long as nobody who is not carried away pays for
/// those who are ([`PRICE`]); and the threshold that tells best.
///
/// Likelihood alone would do worse: steps after a jump are many, and most of a validation part's others are right.
fn fitted(anywhere: &[Point], carried: &[Point]) -> LostConfig {
    let usual = LostConfig::default();
    let of = |short: f64, base: f64, slope: f64| LostConfig {
        short,
        base,
        slope,
        ..usual.clone()
    };
    let shapes = BASES.iter().flat_map(|&b| SLOPES.map(|s| (b, s)));
    let grid = shapes.flat_map(|(b, s)| SHORTS.map(|short| of(short, b, s)));
    let all = [anywhere, carried].concat();
    let by_mass = area(anywhere, |point| 1.0 - point.near_mass);
    let merit = |config: &LostConfig| {
        let areas = [anywhere, carried].map(|points| area(points, |point| point.score(config)));
        let paid = (by_mass - areas[0]).max(0.0);
        areas.iter().sum::<f64>() - PRICE * paid - LIKELIHOOD * nats(&all, config)
    };
    let first = (usual.clone(), merit(&usual));
    let (mut best, _) = grid.fold(first, |best, config| match merit(&config) {
        merit if merit > best.1 => (config, merit),
        _ => best,
    });
    best.threshold = threshold(&all, &best);
    best
}

/// Weights of the newest observation, bases and slopes that are tried. No slope of 0, by which nobody would notice that he was carried away.
const SHORTS: [f64; 4] = [0.2, 0.3, 0.5, 0.8];
const BASES: [f64; 8] = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 6.0];
const SLOPES: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 3.0];

/// What a nat a step counts beside an area of 1: it decides between constants that tell alike.
const LIKELIHOOD: f64 = 0.02;

/// What an area counts that is lost against the mass alone where nobody is carried away, which is what robots meet on most days.
const PRICE: f64 = 5.0;

/// How well a score tells the lost steps; 1/2 where there are none, or no others.
fn area(points: &[Point], score: impl Fn(&Point) -> f64) -> f64 {
    let scored = points.iter().map(|point| (0, point.is_lost, score(point)));
    let auroc = Auroc::of(&scored.collect::<Vec<_>>(), 0, Seed(0));
    auroc.map_or(0.5, |auroc| auroc.value)
}

/// Mean −ln of what these constants make of the points.
fn nats(points: &[Point], config: &LostConfig) -> f64 {
    const LEAST: f64 = 1e-6;
    let of_point = |point: &Point| {
        let lost = point.score(config).clamp(LEAST, 1.0 - LEAST);
        -(if point.is_lost { lost } else { 1.0 - lost }).ln()
    };
    points.iter().map(of_point).sum::<f64>() / points.len().max(1) as f64
}

/// Who has a tenth of the belief or less near the estimate is lost, even if on the validation part all who had so little were right.
const MOST_THRESHOLD: f64 = 0.9;

/// The threshold that finds most of the lost for the false alarms that it gives (Youden, *Index for rating diagnostic tests*, Cancer
/// 3, 1950), in the middle between two scores, so that where a gap parts the lost from the others it is not at its edge; the usual one where there
/// are no lost steps, or no others.
fn threshold(points: &[Point], config: &LostConfig) -> f64 {
    let usual = LostConfig::default().threshold;
    let lost = points.iter().filter(|point| point.is_lost).count() as f64;
    let found = points.len() as f64 - lost;
    let scores = points.iter().map(|p| (p.score(config), p.is_lost));
    let mut scores: Vec<(f64, bool)> = scores.collect();
    scores.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut caught, mut alarms) = (0.0, 0.0);
    let mut best = (f64::NEG_INFINITY, usual);
    let mut groups = scores.chunk_by(|a, b| a.0 == b.0).peekable();
    while let Some(alike) = groups.next() {
        let lost_here = alike.iter().filter(|(_, is_lost)| *is_lost).count() as f64;
        caught += lost_here;
        alarms += alike.len() as f64 - lost_here;
        let index = caught / lost - alarms / found;
        if index > best.0 {
            let next = groups.peek().map_or(alike[0].0, |below| below[0].0);
            best = (index, 0.5 * (alike[0].0 + next));
        }
    }
    // NaN and what is no threshold of a probability
    match lost > 0.0 && found > 0.0 && best.1 > 0.0 && best.1 < 1.0 {
        true => best.1.min(MOST_THRESHOLD),
        false => usual,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;

    /// Points that follow the very model.
    fn points(base: f64, slope: f64) -> Vec<Point> {
        let mut stream = Seed(5).stream("points");
        (0..6000)
            .map(|_| {
                let near_mass: f64 = stream.random_range(0.2..1.0);
                let explains: f64 = stream.random_range(-4.0..4.0);
                let sure = near_mass / (1.0 + (-base - slope * explains).exp());
                Point {
                    is_lost: !stream.random_bool(sure),
                    near_mass,
                    ratios: vec![explains],
                }
            })
            .collect()
    }

    /// Sure and wrong after a jump, where only what was sensed tells; unsure at first without one.
    #[test]
    fn both_kinds_of_lost_steps_are_told() {
        let anywhere = points(3.0, 0.25);
        let carried: Vec<Point> = points(0.0, 3.0)
            .into_iter()
            .map(|point| Point {
                near_mass: 0.99,
                ..point
            })
            .collect();
        let fitted = fitted(&anywhere, &carried);
        assert!(fitted.check().is_ok());
        let mass_alone = LostConfig {
            base: 60.0,
            slope: 0.0,
            ..fitted.clone()
        };
        let area = |points: &[Point], config| area(points, |point| point.score(config));
        assert!(area(&carried, &fitted) > area(&carried, &mass_alone) + 0.2);
        assert!(area(&anywhere, &fitted) > area(&anywhere, &mass_alone) - 0.01);
    }

    /// A map that is wrong in places contradicts a robot that is where it believes, as it does one that was carried away. Without a price the fit
    /// would give some .05 of the area where nobody is carried away for more where somebody is.
    #[test]
    fn who_is_not_carried_away_hardly_pays() {
        let mut stream = Seed(7).stream("price");
        let mut points = |count: usize, is_lost: bool, near_mass: [f64; 2], ratio: [f64; 2]| {
            let mut between = |[low, high]: [f64; 2]| stream.random_range(low..high);
            let point = |_| Point {
                is_lost,
                near_mass: between(near_mass),
                ratios: vec![between(ratio)],
            };
            (0..count).map(point).collect::<Vec<Point>>()
        };
        let anywhere = [
            points(60, true, [0.4, 0.7], [0.0, 2.0]),
            points(300, false, [0.95, 1.0], [1.0, 3.0]),
            points(150, false, [0.95, 1.0], [-2.0, 0.0]),
        ];
        let carried = [
            points(300, true, [0.5, 1.0], [-2.0, 0.0]),
            points(300, false, [0.5, 1.0], [0.0, 2.0]),
        ];
        let (anywhere, carried) = (anywhere.concat(), carried.concat());
        let fitted = fitted(&anywhere, &carried);
        let area = |points: &[Point]| area(points, |point| point.score(&fitted));
        assert!(area(&anywhere) > 0.98, "{} {fitted:?}", area(&anywhere));
        assert!(area(&carried) > 0.7, "{} {fitted:?}", area(&carried));
    }

    /// Where one snapshot tells all, the newest counts most; where each tells little, many count.
    #[test]
    fn the_weight_of_the_newest_follows_what_a_snapshot_tells() {
        let mut stream = Seed(6).stream("ratios");
        let mut points = |newest: f64, older: f64, noise: f64| -> Vec<Point> {
            let point = |number: usize| {
                let is_lost = number.is_multiple_of(2);
                let sign = if is_lost { -1.0 } else { 1.0 };
                let mut ratio = |mean: f64| sign * mean + noise * stream.random_range(-1.0..1.0);
                Point {
                    is_lost,
                    near_mass: 0.99,
                    ratios: (0..8)
                        .map(|k| ratio(if k == 0 { newest } else { older }))
                        .collect(),
                }
            };
            (0..600).map(point).collect()
        };
        let (sharp, blurred) = (points(2.0, 0.0, 3.0), points(0.5, 0.5, 3.0));
        assert_eq!(fitted(&sharp, &sharp).short, 0.8);
        assert_eq!(fitted(&blurred, &blurred).short, 0.2);
    }

    #[test]
    fn with_nothing_to_learn_from_the_usual_constants_stay() {
        assert_eq!(fitted(&[], &[]), LostConfig::default());
    }

    /// Scores .9 and .6 (lost), .55 and .4 (found), .3 (lost), .1 and .05 (found): 2/3 − 0 between .6 and .55 is the best.
    #[test]
    fn the_threshold_by_hand() {
        let config = LostConfig {
            base: 60.0,
            ..LostConfig::default()
        };
        let points: Vec<Point> = [
            (0.9, true),
            (0.6, true),
            (0.55, false),
            (0.4, false),
            (0.3, true),
            (0.1, false),
            (0.05, false),
        ]
        .map(|(score, is_lost)| Point {
            is_lost,
            near_mass: 1.0 - score,
            ratios: Vec::new(),
        })
        .to_vec();
        assert!((threshold(&points, &config) - 0.575).abs() < 1e-9);
        assert_eq!(threshold(&points[5..], &config), 0.5);
        let far_apart = [points[0].clone(), points[6].clone()].map(|point| Point {
            near_mass: if point.is_lost { 0.01 } else { 0.05 },
            ..point
        });
        assert_eq!(threshold(&far_apart, &config), MOST_THRESHOLD);
    }
}
