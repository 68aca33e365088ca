//! One printed figure and what came of it with each seed.

use crate::{
    report::{Cell, Table, paper::text},
    score::MeanInterval,
};

/// A figure of the paper, or one that it has no number for, and ours.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Figure {
    /// What it is of.
    pub quantity: String,
    /// Environment, or whatever else stands in a column.
    pub place: String,
    /// As printed.
    pub printed: Option<f64>,
    /// How many decimals are printed.
    pub decimals: usize,
    /// Ours, one a seed; none where a seed has none.
    pub values: Vec<Option<f64>>,
}

/// How a printed figure lies to ours: within what one more seed would give in 95 of 100, or outside of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Agrees,
    HigherHere,
    LowerHere,
}

impl Figure {
    /// Over the seeds that have one.
    pub fn mean(&self) -> Option<MeanInterval> {
        let values: Vec<f64> = self.values.iter().copied().flatten().collect();
        MeanInterval::of(&values)
    }

    pub fn printed(&self) -> Cell {
        Cell::number(self.printed, self.decimals)
    }

    /// Mean ± half of its interval, and of how many seeds where not of all.
    pub fn ours(&self) -> Cell {
        let Some(mean) = self.mean() else {
            return Cell::Missing;
        };
        let decimals = self.decimals.max(if self.decimals == 0 { 1 } else { 0 });
        let half = mean.half().map(|half| format!(" ± {half:.decimals$}"));
        let of = match mean.count == self.values.len() {
            true => String::new(),
            false => format!(" ({})", mean.count),
        };
        let shown = mean.mean;
        text(format!(
            "{shown:.decimals$}{}{of}",
            half.unwrap_or_default()
        ))
    }

    /// None without a printed figure, or with fewer than two seeds.
    pub fn verdict(&self) -> Option<Verdict> {
        let printed = self.printed?;
        let [low, high] = self.mean()?.one_more()?;
        let rounding = 0.5 * 10_f64.powi(-(self.decimals as i32)) + 1e-12;
        Some(match printed {
            printed if printed < low - rounding => Verdict::HigherHere,
            printed if printed > high + rounding => Verdict::LowerHere,
            _ => Verdict::Agrees,
        })
    }
}

/// Where a quantity agrees with what is printed, in a sentence.
pub(super) fn sentence(quantity: &str, figures: &[Figure]) -> String {
    let of = |verdict: Option<Verdict>, words: &str| {
        let alike = figures.iter().filter(|figure| figure.verdict() == verdict);
        let places: Vec<&str> = alike.map(|figure| figure.place.as_str()).collect();
        (!places.is_empty()).then(|| format!("{words} {}", places.join(", ")))
    };
    let parts: Vec<String> = [
        of(Some(Verdict::Agrees), "agrees in"),
        of(Some(Verdict::HigherHere), "higher here in"),
        of(Some(Verdict::LowerHere), "lower here in"),
        of(None, "not judged in"),
    ]
    .into_iter()
    .flatten()
    .collect();
    format!("{quantity}: {}", parts.join("; "))
}

/// What the sentences mean.
pub(super) const AGREES: &str = "agrees: the paper's figure, of one recording, lies where one more seed would fall in 95 of 100";

/// All figures, one a row, for programs.
pub(super) fn in_rows(figures: &[Figure]) -> Table {
    let headers = [
        "quantity",
        "place",
        "paper",
        "mean",
        "ci95_low",
        "ci95_high",
        "seeds",
        "verdict",
    ];
    let mut table = Table::new(headers);
    for figure in figures {
        let mean = figure.mean();
        let end = |end: usize| Cell::number(mean.and_then(|m| m.ci95).map(|ci| ci[end]), 4);
        let verdict = figure.verdict().map(|verdict| match verdict {
            Verdict::Agrees => "agrees",
            Verdict::HigherHere => "higher_here",
            Verdict::LowerHere => "lower_here",
        });
        table.row([
            text(&figure.quantity),
            text(&figure.place),
            figure.printed(),
            Cell::number(mean.map(|mean| mean.mean), 4),
            end(0),
            end(1),
            Cell::Count(mean.map_or(0, |mean| mean.count as u64)),
            verdict.map_or(Cell::Missing, text),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(printed: f64, decimals: usize, values: &[Option<f64>]) -> Figure {
        Figure {
            quantity: "U".into(),
            place: format!("{printed}"),
            printed: Some(printed),
            decimals,
            values: values.to_vec(),
        }
    }

    #[test]
    fn cells_are_means_with_half_of_their_interval_and_the_seeds_that_have_one() {
        let all = [Some(0.40), Some(0.44), Some(0.38), Some(0.42)];
        assert_eq!(figure(0.5, 3, &all).ours(), text("0.410 ± 0.041"));
        let some = [Some(0.40), None, Some(0.44)];
        assert_eq!(figure(0.5, 1, &some).ours(), text("0.4 ± 0.3 (2)"));
        assert_eq!(figure(24.0, 0, &[Some(24.0)]).ours(), text("24.0"));
        assert_eq!(figure(0.5, 3, &[None, None]).ours(), Cell::Missing);
    }

    #[test]
    fn a_printed_figure_is_judged_by_where_one_more_seed_would_fall() {
        // .41 ± .0919, to the printed decimals
        let values = [Some(0.40), Some(0.44), Some(0.38), Some(0.42)];
        let cases = [
            (0.319, Verdict::Agrees),
            (0.502, Verdict::Agrees),
            (0.317, Verdict::HigherHere),
            (0.503, Verdict::LowerHere),
        ];
        for (printed, expected) in cases {
            assert_eq!(
                figure(printed, 3, &values).verdict(),
                Some(expected),
                "{printed}"
            );
        }
        assert_eq!(figure(0.5, 3, &values[..1]).verdict(), None);
        // Bins that are the same with every seed agree with themselves alone.
        let alike = [Some(8.0), Some(8.0)];
        assert_eq!(figure(8.0, 0, &alike).verdict(), Some(Verdict::Agrees));
        assert_eq!(figure(9.0, 0, &alike).verdict(), Some(Verdict::LowerHere));
        let figures = [
            figure(0.4, 3, &values),
            figure(0.2, 3, &values),
            figure(0.9, 3, &[None]),
        ];
        assert_eq!(
            sentence("U", &figures),
            "U: agrees in 0.4; higher here in 0.2; not judged in 0.9"
        );
    }
}
