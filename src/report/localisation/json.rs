//! A record as one JSON object, for programs.

use crate::{
    error::{Error, Result},
    experiment::localisation::Record,
};

/// Every method's figures in the array `systems`, each with its `name`; a single model's at the top as well. A
/// method that could not be made has a `fault` instead of figures. What the clock said is under `timing`, where `seconds`, of all
/// the trials, are given; else nothing of it, and the same call has the same bytes.
pub fn json(record: &Record, seconds: Option<f64>) -> Result<serde_json::Value> {
    let failed = |e: serde_json::Error| Error::work(format!("result: {e}"));
    let mut all = serde_json::json!({
        "trials": record.trials,
        "stretches": record.stretches,
        "cells": record.cells,
        "unseen": record.unseen,
        "covered": record.covered,
        "judged": record.judged,
        "unseen_is_validation": record.unseen_is_validation,
        "people": record.people,
        "degraded": record.degraded,
        "noise": record.noise,
        "paired_tests": record.paired_tests,
        "more_particles": record.more_particles,
        "protocol": record.protocol,
    });
    if let Some(seconds) = seconds {
        all["timing"] = serde_json::json!({
            "seconds": seconds,
            "step_ms": record.timing.step_ms,
            "prediction_ms": record.timing.prediction_ms,
            "correction_ms": record.timing.correction_ms,
        });
    }
    let mut systems = Vec::new();
    for result in &record.results {
        let figures = serde_json::to_value(result).map_err(failed)?;
        if let (true, Some(fields)) = (result.name == "learned", figures.as_object()) {
            for (key, field) in fields.iter().filter(|(key, _)| *key != "name") {
                all[key] = field.clone();
            }
        }
        systems.push(figures);
    }
    for absent in &record.left_out {
        systems.push(serde_json::to_value(absent).map_err(failed)?);
    }
    all["systems"] = systems.into();
    Ok(all)
}
