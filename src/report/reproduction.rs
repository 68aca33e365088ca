//! A paper's tables, ours, over seeds, beside what is printed.

mod answers;
mod duckett1998;
mod duckett2000;
mod figure;
mod order;

use super::comparison::{Picture, Sheet};
use crate::{
    error::Result,
    experiment::{over_seeds::Reproduction, reproduce::Paper},
};

/// The tables of a paper. What depends on this machine's speed has a name that begins with `timing`.
///
/// # Errors
/// Where the record is of no paper that has a comparison.
pub fn sheets(reproduction: &Reproduction) -> Result<Vec<Sheet>> {
    Ok(match reproduction.paper()? {
        // No comparisons: `report::thrun1998` and `report::ruizmayor2006` have their tables.
        Paper::Thrun1998 | Paper::Ruizmayor2006 => Vec::new(),
        Paper::Duckett1998 => duckett1998::sheets(reproduction),
        Paper::Duckett2000 => duckett2000::sheets(reproduction),
    })
}

/// The pictures of a paper, likewise.
///
/// # Errors
/// As [`sheets`], and where a picture can't be drawn.
pub fn pictures(reproduction: &Reproduction) -> Result<Vec<Picture>> {
    match reproduction.paper()? {
        Paper::Thrun1998 | Paper::Ruizmayor2006 => Ok(Vec::new()),
        Paper::Duckett1998 => duckett1998::pictures(reproduction),
        Paper::Duckett2000 => duckett2000::pictures(reproduction),
    }
}

/// What holds for all tables.
pub fn caption_lines(reproduction: &Reproduction) -> Vec<String> {
    let seeds = &reproduction.seeds;
    let mut lines = vec![format!(
        "mean over {} seeds, {} to {}, ± half of its 95 % interval (Student's t over the seeds); (n): n of the seeds have one",
        seeds.count,
        seeds.first,
        seeds.first + seeds.count as u64 - 1,
    )];
    if seeds.toy {
        lines.push("at toy size: the figures mean little".to_string());
    }
    lines
}
