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
