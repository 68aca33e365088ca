//! What the papers print, to be set beside what was measured here. Nothing is ever tuned to these numbers.

/// One environment in Tables 1 and 2 of Duckett & Nehmzow, *Mobile robot self-localisation and measurement of performance
/// in middle-scale environments* (1998).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Duckett1998 {
    /// A to F.
    pub environment: &'static str,
    /// Table 1: metres around.
    pub route_m: f64,
    /// Table 1: bins of 2 m.
    pub bins: usize,
    /// Table 1.
    pub trials: usize,
    /// Table 1: places in the map of evidence-based localisation.
    pub places: usize,
    /// Table 2: how far evidence-based localisation goes until U(L|R) = 0.9, metres.
    pub evidence_distance_m: f64,
    /// Table 2: mean U(L|R) and mean H(L|R), nats, of the landmark classifier.
    pub landmarks: [f64; 2],
    /// Table 2: the same of dead reckoning.
    pub dead_reckoning: [f64; 2],
}

/// All six.
pub const DUCKETT_1998: [Duckett1998; 6] = {
    const fn row(
        environment: &'static str,
        (route_m, bins, trials, places): (f64, usize, usize, usize),
        evidence_distance_m: f64,
        landmarks: [f64; 2],
        dead_reckoning: [f64; 2],
    ) -> Duckett1998 {
        Duckett1998 {
            environment,
            route_m,
            bins,
            trials,
            places,
            evidence_distance_m,
            landmarks,
            dead_reckoning,
        }
    }
    [
        row(
            "A",
            (60.0, 24, 298, 88),
            0.0,
            [0.925, 0.227],
            [0.663, 1.013],
        ),
        row(
            "B",
            (54.0, 14, 263, 71),
            3.8,
            [0.814, 0.487],
            [0.724, 0.719],
        ),
        row(
            "C",
            (146.0, 40, 474, 185),
            13.6,
            [0.739, 0.980],
            [0.785, 0.807],
        ),
        row("D", (23.0, 8, 232, 33), 0.5, [0.878, 0.236], [0.786, 0.413]),
        row(
            "E",
            (51.0, 14, 248, 61),
            3.0,
            [0.776, 0.585],
            [0.864, 0.355],
        ),
        row(
            "F",
            (51.0, 14, 249, 61),
            4.7,
            [0.690, 0.808],
            [0.686, 0.819],
        ),
    ]
};

/// One environment in Tables 1 and 2 of Duckett & Nehmzow, *Performance comparison of landmark recognition systems for
/// navigating mobile robots* (2000).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Duckett2000 {
    /// A to D.
    pub environment: &'static str,
    /// Table 1: N_R.
    pub responses: usize,
    /// Table 2: U(L|R), in the order of [`DUCKETT_2000_SYSTEMS`].
    pub coefficient: [f64; 6],
}

/// All four.
pub const DUCKETT_2000: [Duckett2000; 4] = {
    const fn row(
        environment: &'static str,
        responses: usize,
        coefficient: [f64; 6],
    ) -> Duckett2000 {
        Duckett2000 {
            environment,
            responses,
            coefficient,
        }
    }
    [
        row("A", 16, [0.554, 0.573, 0.650, 0.719, 0.732, 0.806]),
        row("B", 25, [0.552, 0.669, 0.715, 0.770, 0.879, 0.850]),
        row("C", 42, [0.462, 0.538, 0.551, 0.502, 0.644, 0.632]),
        row("D", 32, [0.220, 0.265, 0.350, 0.340, 0.487, 0.439]),
    ]
};

/// One system in Table 2 of the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Duckett2000System {
    /// As the paper abbreviates it.
    pub printed: &'static str,
    /// The recogniser's name here.
    pub name: &'static str,
    /// T: time a match, in units of RCE's 18 µs on a Sparcstation 20.
    pub cost: f64,
}

/// All six, in the order of Table 2. Its mean of ART2, 0.509, does not follow from its own row, whose mean is 0.511.
pub const DUCKETT_2000_SYSTEMS: [Duckett2000System; 6] = {
    const fn system(printed: &'static str, name: &'static str, cost: f64) -> Duckett2000System {
        Duckett2000System {
            printed,
            name,
            cost,
        }
    }
    [
        system("RCE", "rce", 1.0),
        system("ART2", "art2", 218.0),
        system("NstNbr", "nearest", 1.0),
        system("GCS", "growing_cells", 1.0),
        system("OccGrd", "grid_match", 13_051.0),
        system("OHM", "histogram_match", 31.0),
    ]
};

/// Table 3 of the same: p of the paired t-test for each pair of systems, the first earlier in Table 2 than the second.
/// Printed is max(0.01, p rounded to two digits).
pub const DUCKETT_2000_P: [(&str, &str, f64); 15] = [
    ("RCE", "ART2", 0.06),
    ("RCE", "NstNbr", 0.01),
    ("RCE", "GCS", 0.04),
    ("RCE", "OccGrd", 0.01),
    ("RCE", "OHM", 0.01),
    ("ART2", "NstNbr", 0.04),
    ("ART2", "GCS", 0.16),
    ("ART2", "OccGrd", 0.01),
    ("ART2", "OHM", 0.01),
    ("NstNbr", "GCS", 0.60),
    ("NstNbr", "OccGrd", 0.01),
    ("NstNbr", "OHM", 0.01),
    ("GCS", "OccGrd", 0.05),
    ("GCS", "OHM", 0.01),
    ("OccGrd", "OHM", 0.90),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// H(L) = H(L|R) / (1 − U(L|R)), whichever system it is worked out from: five rows agree, C's is impossible.
    #[test]
    fn table_2_of_1998_has_one_entropy_an_environment() {
        for row in DUCKETT_1998 {
            let entropy = |[u, h]: [f64; 2]| h / (1.0 - u);
            let (one, other) = (entropy(row.landmarks), entropy(row.dead_reckoning));
            assert!((one - other).abs() < 0.03, "{row:?}: {one} {other}");
            let possible = one.min(other) <= (row.bins as f64).ln() + 0.01;
            assert_eq!(possible, row.environment != "C", "{row:?}");
        }
    }

    #[test]
    fn table_2_of_2000_has_the_printed_means() {
        let printed = [0.447, 0.509, 0.567, 0.582, 0.686, 0.682];
        for (system, printed) in printed.into_iter().enumerate() {
            let mean = DUCKETT_2000
                .iter()
                .map(|row| row.coefficient[system])
                .sum::<f64>()
                / 4.0;
            let agrees = (mean - printed).abs() < 0.001;
            let name = DUCKETT_2000_SYSTEMS[system].printed;
            assert_eq!(agrees, name != "ART2", "{name}: {mean} {printed}");
        }
    }
}

/// The data sets of Thrun (1998), as the worlds call them.
pub const THRUN_1998_SETS: [&str; 3] = ["d1", "d2", "d3"];

/// A row of Table 3 of Thrun, *Bayesian Landmark Learning for Mobile Robot Localization* (1998): error reduction at ±2 m in per cent
/// and the half-width of its 95 % interval, of D-1, D-2 and D-3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thrun1998Row {
    /// `door`, `ceiling_light` or `ball`.
    pub approach: &'static str,
    /// n.
    pub features: usize,
    /// None where the table has a dash.
    pub reduction: [Option<[f64; 2]>; 3],
}

/// Thrun (1998), Table 3.
pub const THRUN_1998_TABLE_3: [Thrun1998Row; 6] = [
    Thrun1998Row {
        approach: "door",
        features: 1,
        reduction: [Some([8.3, 1.1]), Some([1.4, 1.5]), None],
    },
    Thrun1998Row {
        approach: "ceiling_light",
        features: 1,
        reduction: [None, None, Some([15.6, 1.4])],
    },
    Thrun1998Row {
        approach: "ball",
        features: 1,
        reduction: [Some([14.9, 1.3]), Some([14.2, 1.6]), Some([21.0, 1.7])],
    },
    Thrun1998Row {
        approach: "ball",
        features: 2,
        reduction: [Some([33.5, 1.9]), Some([36.7, 1.9]), Some([34.5, 2.0])],
    },
    Thrun1998Row {
        approach: "ball",
        features: 3,
        reduction: [Some([39.7, 2.0]), Some([36.3, 2.3]), Some([41.5, 1.8])],
    },
    Thrun1998Row {
        approach: "ball",
        features: 4,
        reduction: [Some([41.7, 2.5]), Some([36.7, 1.9]), Some([42.9, 1.6])],
    },
];

/// What the text of Thrun (1998), 5.2.1, and Table 3 tell of Fig. 3, whose curves are printed without numbers: data set (from 0), approach, half
/// width of the prior in metres, error reduction in per cent. Of D-2, the text gives 9.78 % for doors as the most of all priors.
pub const THRUN_1998_FIG_3: [(usize, &str, f64, f64); 13] = [
    (0, "door", 2.0, 8.31),
    (0, "ball", 2.0, 14.9),
    (0, "door", 50.0, 5.02),
    (0, "ball", 50.0, 36.9),
    (1, "door", 2.0, 1.4),
    (1, "ball", 2.0, 14.2),
    (1, "door", 5.0, 9.78),
    (1, "ball", 5.0, 15.6),
    (1, "door", 89.0, 0.0),
    (1, "ball", 89.0, 27.5),
    (2, "ceiling_light", 2.0, 15.6),
    (2, "ball", 2.0, 21.0),
    (2, "ball", 50.0, 39.5),
];

/// What Thrun (1998), 5.2.4, tells of Fig. 6 (D-1): metres after which BaLL's mean error is below 1 m, the error of doors after 30 m, and
/// the metres after which BaLL is as accurate.
pub const THRUN_1998_FIG_6: [f64; 3] = [9.5, 7.46, 4.0];

/// What Thrun (1998), 5.2.4, tells of readings and bits, each with its decimals. 2.93 follows from its numbers as 3.52 does, and the two
/// predictions from these; it prints 3.5 and 23.
pub const THRUN_1998_READINGS: [(&str, f64, usize); 7] = [
    ("readings until the mean error is below 1 m", 19.0, 0),
    ("bits: log2 of the length in metres", 6.48, 2),
    ("bits: log2 of the mean error at the start", 5.4, 2),
    ("readings a bit, by length", 2.93, 2),
    ("readings a bit, by error", 3.52, 2),
    ("predicted for twice the length, by length", 21.93, 1),
    ("predicted for twice the length, by error", 22.52, 1),
];

/// What Ruiz-Mayor, Triviño & Bailador, *A performance metric for mobile robot localization* (2006), 4.3 and 4.4, print of all three runs
/// together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ruizmayor2006 {
    /// Largest position and heading error, centimetres and degrees.
    pub largest: [f64; 2],
    /// What 95 % of them stay within.
    pub p95: [f64; 2],
    /// Optimal estimates, per cent.
    pub optimal: f64,
    /// C_XY, C_T and C_XYT, per cent.
    pub correction: [f64; 3],
}

/// As printed.
pub const RUIZMAYOR_2006: Ruizmayor2006 = Ruizmayor2006 {
    largest: [34.0, 7.2],
    p95: [20.4, 5.7],
    optimal: 53.2,
    correction: [88.0, 95.0, 84.0],
};
