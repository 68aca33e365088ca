//! The player of the belief on a page: what it reads, and the still picture that stands in its place without JavaScript.

use super::Part;
use crate::{
    error::{Error, Result},
    experiment::belief_traces::BeliefTraces,
    report::{
        canvas::{colours_in_words, dashes},
        still::still,
    },
};

/// The program.
pub(super) const SCRIPT: &str = include_str!("player.js");

/// A player of these beliefs that starts with some systems side by side; `None` where there is nothing to play.
///
/// # Errors
/// Where what was kept is damaged.
pub fn player(traces: &BeliefTraces, shown: &[usize]) -> Result<Option<Part>> {
    if traces.trials.is_empty() || traces.systems.is_empty() {
        return Ok(None);
    }
    let data = serde_json::json!({
        "traces": traces,
        "colours": colours_in_words(),
        "dashes": dashes(),
        "shown": shown,
    });
    let data = serde_json::to_string(&data)
        .map_err(|e| Error::work(format!("kept beliefs as JSON: {e}")))?;
    Ok(Some(Part::Player {
        // Nothing in it may end the element that it stands in.
        data: data.replace('<', "\\u003c"),
        still: still("What was believed along the first trial", traces, shown)?,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A system's name can't end the element that the data stand in, and comes back whole.
    #[test]
    fn awkward_names_stay_inside_the_data() {
        let name = "</script><script>alert(1)</script>";
        let traces: BeliefTraces = serde_json::from_value(serde_json::json!({
            "is_route": true, "cell_m": 1.0, "cells": [[0.5], [1.5]], "plan": null, "systems": [[name, name]], "errors": [],
            "trials": [{ "number": 0, "kept_as": ["the first"], "travelled_m": [0.0], "truth": [[0.5]], "systems": [{
                "answer": [null], "expected_error_m": [1.0], "point_error_m": [1.0], "entropy_nats": [null],
                "is_lost": [null], "mass": "",
            }] }],
        }))
        .unwrap();
        assert_eq!(traces.check(), Ok(()));
        let Some(Part::Player { data, still }) = player(&traces, &[0]).unwrap() else {
            panic!("no player")
        };
        assert!(!data.contains('<') && !still.contains("<script"), "{data}");
        let read: serde_json::Value = serde_json::from_str(&data).unwrap();
        assert_eq!(read["traces"]["systems"][0][1], name);
    }
}
