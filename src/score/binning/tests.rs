use super::*;
use std::f64::consts::LN_2;

/// A trace of `n` points that wanders over a few metres: no two grids cut it alike.
fn wandering(n: usize) -> Vec<[f64; 2]> {
    (0..n)
        .map(|k| k as f64)
        .map(|k| [5.0 * (0.31 * k).sin() + 0.04 * k, 3.0 * (0.17 * k).cos()])
        .collect()
}

fn turned(points: &[[f64; 2]], degrees: f64) -> Vec<[f64; 2]> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    points
        .iter()
        .map(|[x, y]| [cos * x - sin * y, sin * x + cos * y])
        .collect()
}

/// Fewest bins and, for those, the greatest entropy, from the definition alone.
fn by_enumeration(points: &[[f64; 2]], size_m: f64) -> (usize, f64) {
    let n = points.len() as f64;
    let centre = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / n);
    let mut best = (usize::MAX, 0.0);
    for degree in 0..90 {
        let centred: Vec<[f64; 2]> = points
            .iter()
            .map(|p| [p[0] - centre[0], p[1] - centre[1]])
            .collect();
        let straight = turned(&centred, -f64::from(degree));
        for i in 0..40 {
            for j in 0..40 {
                let mut times = HashMap::new();
                for p in &straight {
                    let along = |axis: usize, k: i32| {
                        ((p[axis] - size_m * f64::from(k) / 40.0) / size_m).floor() as i64
                    };
                    *times.entry((along(0, i), along(1, j))).or_insert(0.0) += 1.0;
                }
                let entropy = -times.values().map(|t| t / n * (t / n).ln()).sum::<f64>();
                if times.len() < best.0 || times.len() == best.0 && entropy > best.1 {
                    best = (times.len(), entropy);
                }
            }
        }
    }
    best
}

#[test]
fn finds_what_trying_every_grid_finds() {
    for size_m in [0.9, 2.0, 3.7] {
        let points = wandering(37);
        let binning = Binning::search(&points, size_m).unwrap();
        let (bins, entropy) = by_enumeration(&points, size_m);
        assert_eq!(binning.bins(), bins, "{size_m}");
        assert!((binning.entropy() - entropy).abs() < 1e-12, "{size_m}");
    }
}

#[test]
fn fewest_bins_come_first_and_then_the_greatest_entropy() {
    // 21 points on 4 m. Bins of 2 m cut them in two only if they end between the tenth and the twelfth.
    let line: Vec<[f64; 2]> = (0..21).map(|k| [0.2 * f64::from(k), 0.0]).collect();
    let binning = Binning::search(&line, 3.0).unwrap();
    // Along a diagonal a square is 4.2 m long, so one is enough.
    assert_eq!((binning.bins(), binning.entropy()), (1, 0.0));
    let binning = Binning::search(&line, 2.5).unwrap();
    assert_eq!(binning.bins(), 2);
    let halves = -(10.0 / 21.0 * (10_f64 / 21.0).ln() + 11.0 / 21.0 * (11_f64 / 21.0).ln());
    assert!((binning.entropy() - halves).abs() < 1e-12 && halves < LN_2);
}

#[test]
fn a_block_of_squares_is_found_at_any_angle() {
    // 3 × 2 squares of 2 m, nine points in each, the outermost 1 cm from the edges.
    let place_m = |square: u32, step: u32| 2.0 * f64::from(square) + 0.01 + 0.99 * f64::from(step);
    let block: Vec<[f64; 2]> = (0..54)
        .map(|k| [place_m(k / 18, k % 3), place_m(k / 9 % 2, k / 3 % 3)])
        .collect();
    for degrees in [0.0, 17.0, 45.0, 62.0, 90.0, 203.0] {
        let binning = Binning::search(&turned(&block, degrees), 2.0).unwrap();
        assert_eq!(binning.occupancy(), [9; 6], "{degrees}");
        assert!((binning.orientation_rad().to_degrees() - degrees % 90.0).abs() < 1e-9);
    }
}

#[test]
fn the_figures_do_not_depend_on_where_the_map_has_its_axes() {
    let points = wandering(150);
    let here = Binning::search(&points, 2.0).unwrap();
    for degrees in [1.0, 45.0, 90.0, 180.0, 303.0] {
        let turned_points: Vec<[f64; 2]> = turned(&points, degrees)
            .iter()
            .map(|[x, y]| [x + 8_000.0, y - 300.0])
            .collect();
        let again = Binning::search(&turned_points, 2.0).unwrap();
        assert_eq!(again.bins(), here.bins(), "{degrees}");
        assert!((again.entropy() - here.entropy()).abs() < 1e-9, "{degrees}");
    }
}

#[test]
fn points_are_in_their_bins_and_other_places_outside() {
    let points = wandering(150);
    let binning = Binning::search(&points, 2.0).unwrap();
    let mut occupancy = vec![0; binning.bins()];
    let mut entered = 0;
    for &point in &points {
        let bin = binning.bin_of(point).unwrap();
        assert!(bin <= entered, "numbered in order of the first visit");
        entered = entered.max(bin + 1);
        occupancy[bin] += 1;
    }
    assert_eq!(occupancy, binning.occupancy());
    // Around a corner of the grid, four squares meet.
    let [x, y] = binning.corner_m();
    let (sin, cos) = binning.orientation_rad().sin_cos();
    let around = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(a, b)| {
        let (a, b) = (1e-6 * a, 1e-6 * b);
        binning
            .grid
            .square([x + cos * a - sin * b, y + sin * a + cos * b])
    });
    for (index, square) in around.iter().enumerate() {
        assert!(!around[..index].contains(square), "{around:?}");
    }
    for far in [[1e3, 0.0], [-1e300, 1e300], [f64::NAN, 0.0]] {
        assert_eq!(binning.bin_of(far), None);
    }
}

#[test]
fn any_number_of_threads_finds_the_same_grid() {
    let points = wandering(300);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| Binning::search(&points, 1.3).unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn what_cannot_be_binned_is_told() {
    for (points, size_m, usage, expected) in [
        (vec![[0.0, 0.0]], 0.0, true, "bins of 0 m"),
        (vec![[0.0, 0.0]], f64::NAN, true, "bins of NaN m"),
        (vec![[0.0, 0.0], [1e6, 0.0]], 2.0, true, "up to 2000 bins"),
        (vec![], 2.0, false, "no points"),
        (
            vec![[0.0, 0.0], [0.0, f64::INFINITY]],
            2.0,
            false,
            "point 1",
        ),
    ] {
        let error = Binning::search(&points, size_m).unwrap_err();
        assert_eq!(error.is_usage(), usage, "{error}");
        assert!(error.to_string().contains(expected), "{error}");
    }
    let one = Binning::search(&[[3.0, 4.0]; 5], 2.0).unwrap();
    assert_eq!((one.bins(), one.entropy()), (1, 0.0));
}
