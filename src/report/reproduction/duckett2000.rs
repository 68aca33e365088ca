//! Duckett & Nehmzow (2000): Tables 1 to 3, and Fig. 6.

use super::{
    answers::each,
    figure::{AGREES, Figure, in_rows, sentence},
    order::{Entrant, orders, pairs_sentence},
};
use crate::{
    error::Result,
    experiment::{
        compare::{Comparison, PairedTest},
        over_seeds::Reproduction,
        printed::{DUCKETT_2000, DUCKETT_2000_P, DUCKETT_2000_SYSTEMS, Duckett2000System},
    },
    report::{
        Cell, Priced, Table,
        comparison::{Picture, Reader, Sheet},
        paper::{sheet, text},
        price_plot,
    },
};

/// All tables, the order of the systems, what they cost, and all figures for programs.
pub(super) fn sheets(reproduction: &Reproduction) -> Vec<Sheet> {
    let coefficients: Vec<Vec<Figure>> = (0..DUCKETT_2000_SYSTEMS.len())
        .map(|system| coefficients(reproduction, system))
        .collect();
    let responses: Vec<Vec<Figure>> = DUCKETT_2000_SYSTEMS
        .iter()
        .map(|system| responses(reproduction, system))
        .collect();
    let all: Vec<Figure> = coefficients
        .iter()
        .chain(&responses)
        .flatten()
        .cloned()
        .collect();
    vec![
        sheet(
            "paper_table_2",
            "Table 2, U(L|R), the paper's and ours",
            table_2(&coefficients),
        ),
        sheet(
            "order",
            "Order of the systems, the paper's and ours",
            order(&coefficients),
        ),
        sheet(
            "paper_table_1",
            "Table 1, the number of responses N_R, the paper's and ours",
            table_1(&responses),
        ),
        sheet(
            "paper_table_3",
            "Table 3, the paper's and ours",
            table_3(reproduction),
        ),
        sheet(
            "timing_paper_table_2",
            "Table 2, T, the paper's and ours",
            costs(reproduction),
        ),
        Sheet {
            reader: Reader::Programs,
            ..sheet(
                "paper_figures",
                "All printed figures and ours",
                in_rows(&all),
            )
        },
    ]
}

/// U of one system: in each environment, and their mean, of the seeds with all of them.
fn coefficients(reproduction: &Reproduction, number: usize) -> Vec<Figure> {
    let system = &DUCKETT_2000_SYSTEMS[number];
    let figure = |place: &str, printed, values| Figure {
        quantity: format!("{}: U", system.printed),
        place: place.into(),
        printed: Some(printed),
        decimals: 3,
        values,
    };
    let mut figures: Vec<Figure> = DUCKETT_2000
        .iter()
        .map(|row| {
            let whose = (system.name, row.environment);
            let values = each(
                reproduction,
                |r| r.recognition.as_ref(),
                whose,
                |cell| cell.judgement.uncertainty_coefficient,
            );
            figure(row.environment, row.coefficient[number], values)
        })
        .collect();
    let n = DUCKETT_2000.len() as f64;
    let printed = DUCKETT_2000
        .iter()
        .map(|row| row.coefficient[number])
        .sum::<f64>()
        / n;
    let mean_of = |seed: usize| {
        let sum: Option<f64> = figures.iter().map(|figure| figure.values[seed]).sum();
        sum.map(|sum| sum / n)
    };
    let means = (0..reproduction.comparisons.len()).map(mean_of).collect();
    figures.push(figure("mean", printed, means));
    figures
}

fn responses(reproduction: &Reproduction, system: &Duckett2000System) -> Vec<Figure> {
    let figure = |row: &crate::experiment::printed::Duckett2000| Figure {
        quantity: format!("{}: N_R", system.printed),
        place: row.environment.into(),
        printed: Some(row.responses as f64),
        decimals: 0,
        values: each(
            reproduction,
            |r| r.recognition.as_ref(),
            (system.name, row.environment),
            |cell| Some(cell.responses as f64),
        ),
    };
    DUCKETT_2000.iter().map(figure).collect()
}

fn table_2(coefficients: &[Vec<Figure>]) -> Table {
    let places = DUCKETT_2000.map(|row| row.environment);
    let headers = ["system", "from"].into_iter().chain(places).chain(["mean"]);
    let mut table = Table::new(headers);
    for (system, figures) in DUCKETT_2000_SYSTEMS.iter().zip(coefficients) {
        let printed = figures.iter().map(Figure::printed);
        table.row(
            [text(system.printed), text("paper")]
                .into_iter()
                .chain(printed),
        );
        let ours = figures.iter().map(Figure::ours);
        table.row([text(""), text("here")].into_iter().chain(ours));
    }
    table.caption(
        "–: failed, or not asked. The paper prints 0.509 for ART2's mean; its row gives 0.511",
    );
    table.caption(AGREES);
    for (system, figures) in DUCKETT_2000_SYSTEMS.iter().zip(coefficients) {
        table.caption(sentence(system.printed, figures));
    }
    table
}

fn table_1(responses: &[Vec<Figure>]) -> Table {
    let systems = DUCKETT_2000_SYSTEMS.map(|system| system.printed);
    let mut table = Table::new(["environment", "paper"].into_iter().chain(systems));
    for (number, row) in DUCKETT_2000.iter().enumerate() {
        let ours = responses.iter().map(|figures| figures[number].ours());
        let printed = [text(row.environment), Cell::Count(row.responses as u64)];
        table.row(printed.into_iter().chain(ours));
    }
    table
}

fn order(coefficients: &[Vec<Figure>]) -> Table {
    let places = DUCKETT_2000
        .iter()
        .map(|row| row.environment)
        .chain(["mean"]);
    let entrants = |column: usize| -> Vec<Entrant> {
        let all = DUCKETT_2000_SYSTEMS.iter().zip(coefficients);
        all.map(|(system, figures)| Entrant {
            name: system.printed.into(),
            printed: figures[column].printed,
            values: figures[column].values.clone(),
        })
        .collect()
    };
    let environments: Vec<(String, Vec<Entrant>)> = places
        .enumerate()
        .map(|(column, place)| (place.to_string(), entrants(column)))
        .collect();
    let mut table = orders(&environments);
    for environment in &environments {
        let sentence = pairs_sentence(std::slice::from_ref(environment));
        sentence
            .into_iter()
            .for_each(|line| table.caption(format!("{}: {line}", environment.0)));
    }
    table
}

/// The test between two systems, its sign that of the first less the second.
fn test_of(comparison: &Comparison, one: &str, other: &str) -> Option<PairedTest> {
    let record = &comparison.record;
    let names = |test: &PairedTest| test.systems.map(|n| record.systems[n].name.as_str());
    let mut tests = record.recognition_tests.iter();
    let test = tests.find(|test| names(test) == [one, other] || names(test) == [other, one])?;
    let mut test = test.clone();
    if names(&test) != [one, other] {
        test.t = test.t.map(|t| -t);
    }
    Some(test)
}

fn table_3(reproduction: &Reproduction) -> Table {
    let mut table = Table::new([
        "pair",
        "p, paper",
        "p, here",
        "t, here",
        "p < .05",
        "after Holm",
    ]);
    for (one, other, printed) in DUCKETT_2000_P {
        let tests: Vec<Option<PairedTest>> = reproduction
            .comparisons
            .iter()
            .map(|comparison| test_of(comparison, one, other))
            .collect();
        let figure = |decimals, value: fn(&PairedTest) -> Option<f64>| Figure {
            quantity: String::new(),
            place: String::new(),
            printed: None,
            decimals,
            values: tests
                .iter()
                .map(|test| test.as_ref().and_then(value))
                .collect(),
        };
        let share = |value: fn(&PairedTest) -> Option<f64>| {
            let below = tests.iter().flatten().filter_map(value);
            let below = below.filter(|p| *p < 0.05).count();
            text(format!("{below} of {}", tests.len()))
        };
        table.row([
            text(format!("{one} – {other}")),
            Cell::Number(printed, 2),
            figure(3, |test| test.p).ours(),
            figure(2, |test| test.t).ours(),
            share(|test| test.p),
            share(|test| test.p_holm),
        ]);
    }
    table.caption("Student's t-test for paired samples over the environments, two-sided, with each seed; t > 0: the first is better;");
    table.caption("the paper prints max(0.01, p), and corrects for no number of tests; last columns: with how many seeds p is below .05");
    table
}

/// Time a match in units of the nearest neighbour's, over the environments, one a seed.
fn times(reproduction: &Reproduction, name: &str) -> Vec<Option<f64>> {
    let mean = |comparison: &Comparison, kind: &str| -> Option<f64> {
        let record = &comparison.record;
        let section = record.recognition.as_ref()?;
        let is_kind = |&system: &usize| record.systems[system].kind == kind;
        let row = section.systems.iter().position(is_kind)?;
        let times = comparison.timing.seconds_per_match.get(row)?;
        let times: Vec<f64> = times.iter().flatten().copied().collect();
        (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
    };
    let of = |comparison| {
        let unit = mean(comparison, "nearest").filter(|&seconds| seconds > 0.0)?;
        Some(mean(comparison, name)? / unit)
    };
    reproduction.comparisons.iter().map(of).collect()
}

fn costs(reproduction: &Reproduction) -> Table {
    let mut table = Table::new(["system", "T, paper", "T, here"]);
    for system in &DUCKETT_2000_SYSTEMS {
        let figure = Figure {
            quantity: "T".into(),
            place: String::new(),
            printed: Some(system.cost),
            decimals: 1,
            values: times(reproduction, system.name),
        };
        table.row([
            text(system.printed),
            Cell::Number(system.cost, 0),
            figure.ours(),
        ]);
    }
    table.caption("time a match in units of the nearest neighbour's; measured on this machine while seeds run side by side, so not the same from call to call");
    table
}

/// Fig. 6: quality against cost; small points are environments.
pub(super) fn pictures(reproduction: &Reproduction) -> Result<Vec<Picture>> {
    let mean = |values: Vec<Option<f64>>| {
        let values: Vec<f64> = values.into_iter().flatten().collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let systems = DUCKETT_2000_SYSTEMS.iter().enumerate();
    let priced: Vec<Priced> = systems
        .filter_map(|(number, system)| {
            let mut figures = coefficients(reproduction, number);
            figures.pop(); // the mean
            Some(Priced {
                name: system.printed.into(),
                price: mean(times(reproduction, system.name))?,
                worth: figures
                    .into_iter()
                    .filter_map(|figure| mean(figure.values))
                    .collect(),
            })
        })
        .collect();
    let title = format!("Fig. 6: mean of {} seeds", reproduction.seeds.count);
    let label = "time a match, in units of the nearest neighbour's";
    Ok(vec![(
        "timing_figure_6".into(),
        price_plot(&title, label, "U(L|R)", &priced)?,
    )])
}
