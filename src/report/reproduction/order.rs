//! In which order systems come, and with how many seeds.

use crate::report::{Cell, Table, paper::text};

/// One system's worth in one environment, higher is better.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entrant {
    pub name: String,
    /// As printed.
    pub printed: Option<f64>,
    /// Ours, one a seed.
    pub values: Vec<Option<f64>>,
}

impl Entrant {
    /// Of the seeds that have one.
    fn mean(&self) -> Option<f64> {
        let values: Vec<f64> = self.values.iter().copied().flatten().collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }
}

/// Systems by their worth, best first; those without one are left out.
fn order(entrants: &[Entrant], worth: impl Fn(&Entrant) -> Option<f64>) -> Vec<usize> {
    let mut ranked: Vec<(usize, f64)> = entrants
        .iter()
        .enumerate()
        .filter_map(|(number, entrant)| Some((number, worth(entrant)?)))
        .collect();
    ranked.sort_by(|a, b| b.1.total_cmp(&a.1));
    ranked.into_iter().map(|(number, _)| number).collect()
}

/// With how many seeds each system of an order is worth no less than the next.
fn holds_in(entrants: &[Entrant], order: &[usize]) -> usize {
    let seeds = entrants.first().map_or(0, |entrant| entrant.values.len());
    let worth = |number: usize, seed: usize| entrants[number].values[seed];
    let holds = |seed: &usize| {
        order.windows(2).all(|pair| {
            let (first, second) = (worth(pair[0], *seed), worth(pair[1], *seed));
            matches!((first, second), (Some(first), Some(second)) if first >= second)
        })
    };
    (0..seeds).filter(holds).count()
}

/// The paper's order and ours, by means, of each environment, with how many seeds agree.
pub(super) fn orders(environments: &[(String, Vec<Entrant>)]) -> Table {
    let mut table = Table::new(["environment", "by", "order", "seeds"]);
    for (environment, entrants) in environments {
        let seeds = entrants.first().map_or(0, |entrant| entrant.values.len());
        let printed = order(entrants, |entrant| entrant.printed);
        let ours = order(entrants, Entrant::mean);
        for (name, by, order) in [(environment.as_str(), "paper", printed), ("", "here", ours)] {
            let names: Vec<&str> = order.iter().map(|&n| entrants[n].name.as_str()).collect();
            let holds = match order.len() {
                0 | 1 => Cell::Missing,
                _ => text(format!("{} of {seeds}", holds_in(entrants, &order))),
            };
            table.row([text(name), text(by), text(names.join(" > ")), holds]);
        }
    }
    table.caption("by printed figures, and by means over the seeds; seeds = with how many of them the whole order holds");
    table
}

/// Does the paper's order of each two hold by ours? A sentence: by means, with every seed's say.
pub(super) fn pairs_sentence(environments: &[(String, Vec<Entrant>)]) -> Option<String> {
    let (mut pairs, mut alike) = (0, 0);
    let mut against = Vec::new();
    for (environment, entrants) in environments {
        let printed = order(entrants, |entrant| entrant.printed);
        for (rank, &first) in printed.iter().enumerate() {
            for &second in &printed[rank + 1..] {
                if entrants[first].printed == entrants[second].printed {
                    continue;
                }
                let means = [first, second].map(|number| entrants[number].mean());
                let [Some(ahead), Some(behind)] = means else {
                    continue;
                };
                pairs += 1;
                if ahead >= behind {
                    alike += 1;
                } else {
                    let names = [first, second].map(|number| entrants[number].name.as_str());
                    against.push(format!("{environment}: {} > {}", names[0], names[1]));
                }
            }
        }
    }
    let listed = match against.len() {
        0 => String::new(),
        1..=6 => format!("; not {}", against.join(", ")),
        _ => format!("; not {} of them", against.len()),
    };
    (pairs > 0).then(|| {
        format!(
            "of {pairs} pairs that the paper's figures rank, our means rank {alike} alike{listed}"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entrant(name: &str, printed: f64, values: [Option<f64>; 3]) -> Entrant {
        Entrant {
            name: name.into(),
            printed: Some(printed),
            values: values.to_vec(),
        }
    }

    #[test]
    fn orders_are_by_means_and_hold_with_the_seeds_that_have_them() {
        let entrants = vec![
            entrant("a", 0.9, [Some(0.5), Some(0.6), Some(0.1)]),
            entrant("b", 0.8, [Some(0.4), Some(0.9), Some(0.7)]),
            entrant("c", 0.7, [Some(0.3), Some(0.2), None]),
        ];
        let environments = [("A".to_string(), entrants)];
        let csv = orders(&environments).csv();
        // Means: a 0.4, b 0.667, c 0.25. a > b > c with the first seed; b > a > c with the second; the third has no c.
        assert_eq!(
            csv,
            "environment,by,order,seeds\nA,paper,a > b > c,1 of 3\n,here,b > a > c,1 of 3\n"
        );
        assert_eq!(
            pairs_sentence(&environments).unwrap(),
            "of 3 pairs that the paper's figures rank, our means rank 2 alike; not A: a > b"
        );
    }
}
