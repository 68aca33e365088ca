//! The first method against the best of those that learn nothing, in words.

use crate::experiment::{
    localisation::{PairedTest, Record},
    paired_trials::SURE_P,
};

/// The best of those that learn nothing: the one that finds the robot soonest; none where there is no such rival. The first method with
/// more particles is none.
fn best(record: &Record) -> Option<&PairedTest> {
    let is_itself = |test: &&PairedTest| {
        let mut checks = record.more_particles.iter();
        checks.any(|check| (&check.test.name, &check.test.against) == (&test.name, &test.against))
    };
    let rivals = record.paired_tests.iter().filter(|test| !is_itself(test));
    let rivals = rivals.filter(|test| !test.name.starts_with("learned"));
    let metres = |test: &PairedTest| test.distance_difference_m.unwrap_or(f64::INFINITY);
    rivals.min_by(|a, b| metres(a).total_cmp(&metres(b)))
}

/// Its key in results.
pub(super) fn name(record: &Record) -> Option<&str> {
    best(record).map(|test| test.name.as_str())
}

/// Does the first method find the robot sooner than the rival that finds it soonest? None where there is no such rival.
pub(super) fn in_words(record: &Record) -> Option<String> {
    let title = |name: &str| {
        let mut results = record.results.iter();
        let found = results.find(|result| result.name == name)?;
        Some(found.title.clone())
    };
    let best = best(record)?;
    let (first, second) = (title(&best.against)?, title(&best.name)?);
    // The rival's metres less the first one's.
    let found = match best.distance_difference_m? {
        m if m > 0.0 => format!("{m:.1} m sooner"),
        m if m < 0.0 => format!("{:.1} m later", -m),
        _ => "after as many metres".to_string(),
    };
    let chance = match best.p_distance_holm {
        _ if best.is_too_few() => format!("too few of these for any p below {SURE_P}"),
        Some(p) if p < 0.001 => "p < 0.001".to_string(),
        Some(p) if p < SURE_P => format!("p = {p:.3}"),
        Some(p) => format!("p = {p:.2}: it may be chance"),
        None => "no p".to_string(),
    };
    let units = match best.units {
        1 => "a single run or stretch".to_string(),
        n => format!("{n} runs or stretches"),
    };
    Some(format!(
        "{first} against {second}: the robot is found {found},\n  on average of {} trials in {units}; {chance}",
        best.trials
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    fn record(tests: &Value) -> Record {
        let summary = json!({
            "converged_fraction": 1.0, "mean_error_below_1m_is_uncertain": false, "error_by_distance": [],
        });
        let result = |name: &str, title: &str| {
            let mut result = summary.clone();
            result["name"] = name.into();
            result["title"] = title.into();
            result["tracking"] = summary.clone();
            result["held_out"] = json!([]);
            result
        };
        let results = [
            result("learned", "4 learned features"),
            result("learned_bits", "4 learned, as bits"),
            result("map", "occupancy map"),
            result("kernel", "raw-scan kernel"),
        ];
        let record = json!({
            "trials": 20, "stretches": 7, "cells": 9, "unseen": 9, "covered": 9, "unseen_is_validation": false,
            "priors": [], "results": results, "left_out": [], "paired_tests": tests,
        });
        serde_json::from_value(record).unwrap()
    }

    fn test(name: &str, difference_m: f64, p: Option<f64>) -> Value {
        json!({
            "name": name, "against": "learned", "trials": 20, "units": 7,
            "distance_difference_m": difference_m, "p_distance_holm": p, "least_p_found_holm": p.map(|_| 0.0001),
        })
    }

    #[test]
    fn the_best_of_those_that_learn_nothing_is_named() {
        let words = |kernel_m: f64, p: Option<f64>| {
            let tests = [
                test("learned_bits", -9.0, Some(0.5)),
                test("map", 2.0, Some(0.5)),
                test("kernel", kernel_m, p),
            ];
            in_words(&record(&json!(tests))).unwrap()
        };
        assert_eq!(
            words(-1.25, Some(0.0314)),
            "4 learned features against raw-scan kernel: the robot is found 1.2 m later,\n  on average of 20 trials in 7 \
             runs or stretches; p = 0.031"
        );
        assert!(words(1.0, Some(0.25)).ends_with("p = 0.25: it may be chance"));
        assert!(words(1.0, Some(0.0001)).contains("1.0 m sooner,"));
        assert!(words(1.0, None).ends_with("too few of these for any p below 0.05"));
        assert!(words(7.0, None).contains("against occupancy map"));
        let mut few = test("map", 2.0, Some(0.06));
        few["least_p_found_holm"] = json!(0.06);
        few["units"] = json!(1);
        assert_eq!(
            in_words(&record(&json!([few]))).unwrap(),
            "4 learned features against occupancy map: the robot is found 2.0 m sooner,\n  on average of 20 trials in a \
             single run or stretch; too few of these for any p below 0.05"
        );
        assert_eq!(
            in_words(&record(&json!([test("learned_bits", 1.0, None)]))),
            None
        );
        // Itself with more particles is no rival.
        let tests = json!([test("map", 2.0, None), test("kernel", -3.0, None)]);
        let mut more = record(&tests);
        let check = json!([{ "particles": 5, "more": 20, "test": tests[1], "changes": true }]);
        more.more_particles = serde_json::from_value(check).unwrap();
        assert!(in_words(&more).unwrap().contains("against occupancy map"));
    }
}
