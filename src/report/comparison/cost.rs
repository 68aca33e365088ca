//! What recognisers cost, and what is had for it.

use super::{Picture, Reader, Sheet};
use crate::{
    error::Result,
    experiment::compare::{Comparison, ComparisonRecord},
    report::{Cell, Priced, Table, price_plot},
};

/// A recogniser's means over the datasets on which it gave an answer.
struct Cost {
    system: usize,
    matches: f64,
    bytes: f64,
    seconds_per_match: Option<f64>,
    coefficients: Vec<f64>,
}

fn costs(comparison: &Comparison) -> Vec<Cost> {
    let Some(section) = &comparison.record.recognition else {
        return Vec::new();
    };
    let rows = section.systems.iter().zip(&section.cells).enumerate();
    rows.filter_map(|(row, (&system, cells))| {
        let done: Vec<_> = cells.iter().filter_map(|cell| cell.done()).collect();
        let n = done.len() as f64;
        let times = comparison.timing.seconds_per_match.get(row);
        let times: Vec<f64> = times.into_iter().flatten().flatten().copied().collect();
        let coefficients = done
            .iter()
            .filter_map(|cell| cell.judgement.uncertainty_coefficient);
        (!done.is_empty()).then(|| Cost {
            system,
            matches: done.iter().map(|cell| cell.matches as f64).sum::<f64>() / n,
            bytes: done
                .iter()
                .map(|cell| cell.bytes_per_place as f64)
                .sum::<f64>()
                / n,
            seconds_per_match: (!times.is_empty())
                .then(|| times.iter().sum::<f64>() / times.len() as f64),
            coefficients: coefficients.collect(),
        })
    })
    .collect()
}

/// Seconds of a match of the first nearest neighbour: the unit t of Duckett & Nehmzow (2000), Table 2.
fn unit(record: &ComparisonRecord, costs: &[Cost]) -> Option<f64> {
    let mut costs = costs.iter();
    let nearest = costs.find(|cost| record.systems[cost.system].kind == "nearest");
    nearest?.seconds_per_match.filter(|&seconds| seconds > 0.0)
}

/// Time a match, in microseconds and in units of the nearest neighbour's, and bytes a pattern.
pub(super) fn sheet(comparison: &Comparison) -> Option<Sheet> {
    let record = &comparison.record;
    record.recognition.as_ref()?;
    let costs = costs(comparison);
    let unit = unit(record, &costs);
    let mut table = Table::new(["system", "patterns", "bytes each", "match (µs)", "T"]);
    for cost in &costs {
        let time = cost.seconds_per_match;
        table.row([
            Cell::Text(record.systems[cost.system].name.clone()),
            Cell::Number(cost.matches, 1),
            Cell::Number(cost.bytes, 0),
            Cell::number(time.map(|seconds| 1e6 * seconds), 3),
            Cell::number(time.zip(unit).map(|(seconds, unit)| seconds / unit), 2),
        ]);
    }
    table.caption(format!(
        "means over the datasets; T = time a match in units of the nearest neighbour's{};\n  \
         measured on this machine, so not the same from call to call",
        if unit.is_some() {
            ""
        } else {
            " (–: none takes part)"
        }
    ));
    Some(Sheet {
        name: "cost".into(),
        title: "Recognition: what it costs".into(),
        table,
        reader: Reader::Everyone,
    })
}

/// Quality against cost, as Fig. 6 of Duckett & Nehmzow (2000).
pub(super) fn picture(comparison: &Comparison) -> Result<Option<Picture>> {
    let record = &comparison.record;
    if record.recognition.is_none() {
        return Ok(None);
    }
    let costs = costs(comparison);
    let unit = unit(record, &costs);
    let priced: Vec<Priced> = costs
        .iter()
        .filter_map(|cost| {
            Some(Priced {
                name: record.systems[cost.system].name.clone(),
                price: cost.seconds_per_match? / unit.unwrap_or(1e-6),
                worth: cost.coefficients.clone(),
            })
        })
        .collect();
    let label = match unit {
        Some(_) => "time a match, in units of the nearest neighbour's",
        None => "time a match (µs)",
    };
    let svg = price_plot("Quality against cost", label, "U(L|R)", &priced)?;
    Ok(Some(("quality-against-cost".into(), svg)))
}
