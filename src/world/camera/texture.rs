//! Spots on surfaces: the same place has the same spots in every run.

/// How much brighter or darker than its mean a surface is at a place, in standard deviations.
///
/// Value noise: random numbers on a square lattice, smoothly interpolated. `sheet` tells surfaces apart, `at` is the
/// place on it in grains. Over a whole surface the mean is 0 and the variance 1.
pub(super) fn spots(sheet: u64, at: [f64; 2]) -> f64 {
    let cell = at.map(f64::floor);
    let [across, up] = [0, 1].map(|axis| {
        let share = at[axis] - cell[axis];
        share * share * (3.0 - 2.0 * share)
    });
    let [column, row] = cell.map(|index| index as i64);
    let corner = |right: i64, above: i64| value(sheet, column + right, row + above);
    let below = corner(0, 0) * (1.0 - across) + corner(1, 0) * across;
    let above = corner(0, 1) * (1.0 - across) + corner(1, 1) * across;
    // The mean of w² + (1 − w)² over w = 3 t² − 2 t³ is 26/35: what interpolation on one axis leaves of the variance.
    (below * (1.0 - up) + above * up) * 35.0 / 26.0
}

/// A number for whatever the parts tell: a sheet for each surface.
pub(super) fn sheet(parts: [f64; 3]) -> u64 {
    parts.iter().fold(0, |seed, part| {
        // Thousandths, not split where round numbers lie, so that rounding never tears a surface in two.
        mixed(seed ^ ((part * 1000.0 + 0.37).floor() as i64 as u64))
    })
}

/// A random number of variance 1, uniform in ±√3.
fn value(sheet: u64, column: i64, row: i64) -> f64 {
    let bits = mixed(mixed(sheet ^ column as u64) ^ row as u64);
    let share = (bits >> 11) as f64 / (1_u64 << 53) as f64;
    (2.0 * share - 1.0) * 3_f64.sqrt()
}

/// Scrambles 64 bits (the finaliser of SplitMix64: Steele, Lea & Flood, *Fast splittable pseudorandom number
/// generators*, 2014).
fn mixed(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spots_have_mean_0_and_variance_1_and_are_continuous() {
        let count = 400;
        let at = |index: usize| 0.37 + index as f64 * 0.41;
        let (mut sum, mut squares) = (0.0, 0.0);
        for column in 0..count {
            for row in 0..count {
                let spot = spots(9, [at(column), -at(row)]);
                let beside = spots(9, [at(column) + 1e-6, -at(row)]);
                assert!((spot - beside).abs() < 1e-4);
                sum += spot;
                squares += spot * spot;
            }
        }
        let count = (count * count) as f64;
        // Some 27,000 cells: a standard error of about 0.006.
        assert!((sum / count).abs() < 0.03, "{}", sum / count);
        assert!((squares / count - 1.0).abs() < 0.05, "{}", squares / count);
    }

    #[test]
    fn sheets_differ_and_rounding_does_not_tear_them() {
        assert_eq!(
            sheet([0.0, 1.2, 3.0]),
            sheet([1e-12, 1.2 - 1e-12, 3.0 + 1e-12])
        );
        assert_ne!(sheet([0.0, 1.2, 3.0]), sheet([0.0, 1.2, 3.1]));
        assert_ne!(spots(1, [0.5, 0.5]), spots(2, [0.5, 0.5]));
    }
}
