//! Which differences between systems are more than chance, over datasets.

use super::record::{PairedTest, Section};
use crate::{
    experiment::recognition::{RecognitionConfig, RecognitionRecord},
    score::{PairedT, holm},
};

/// Student's t-test for paired samples of every pair of systems, their samples the uncertainty coefficients on the datasets
/// where both have one (Duckett & Nehmzow 2000, Table 3), with the p-values as they are and corrected for their number.
pub(super) fn paired_tests(
    section: &Section<RecognitionConfig, RecognitionRecord>,
) -> Vec<PairedTest> {
    let coefficient = |system: usize, dataset: usize| {
        let done = section.cells[system][dataset].done()?;
        done.judgement.uncertainty_coefficient
    };
    let mut tests = Vec::new();
    for (a, &first) in section.systems.iter().enumerate() {
        for (b, &second) in section.systems.iter().enumerate().skip(a + 1) {
            let datasets = 0..section.cells[a].len();
            let (of_a, of_b): (Vec<f64>, Vec<f64>) = datasets
                .filter_map(|d| coefficient(a, d).zip(coefficient(b, d)))
                .unzip();
            let test = PairedT::of(&of_a, &of_b);
            tests.push(PairedTest {
                systems: [first, second],
                n: of_a.len(),
                t: test.as_ref().map(|test| test.t),
                p: test.as_ref().map(|test| test.p),
                p_holm: None,
            });
        }
    }
    let p: Vec<Option<f64>> = tests.iter().map(|test| test.p).collect();
    for (test, corrected) in tests.iter_mut().zip(holm(&p)) {
        test.p_holm = corrected;
    }
    tests
}
