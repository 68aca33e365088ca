//! Many tests at once: p-values that stay true however many pairs of systems a table compares.

/// p-values adjusted by Holm's step-down rule (Holm, *A simple sequentially rejective multiple test procedure*,
/// Scandinavian Journal of Statistics 6, 1979): calling those at most α significant, one errs anywhere in the whole
/// table with a probability of at most α, however the tests depend on one another.
///
/// The k-th smallest of m is multiplied by m − k + 1, and is never below the one before it nor above 1. A test that
/// there is none of (`None`, or NaN, which no test gives) is not counted among the m and stays `None`.
///
/// ```
/// use ballmark::score::holm;
/// // Of three tests the first alone holds at .05: twice .03 is more.
/// let adjusted = holm(&[Some(0.01), Some(0.03), None, Some(0.04)]);
/// assert_eq!(adjusted, [Some(0.03), Some(0.06), None, Some(0.06)]);
/// ```
pub fn holm(p: &[Option<f64>]) -> Vec<Option<f64>> {
    let known = |k: usize| p[k].filter(|p| !p.is_nan()).map(|p| (p, k));
    let mut ascending: Vec<(f64, usize)> = (0..p.len()).filter_map(known).collect();
    ascending.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut adjusted = vec![None; p.len()];
    let mut least = 0.0_f64;
    for (passed, &(p, k)) in ascending.iter().enumerate() {
        let remaining = (ascending.len() - passed) as f64;
        least = least.max((remaining * p).min(1.0));
        adjusted[k] = Some(least);
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(p: &[f64], expected: &[f64]) {
        let p: Vec<Option<f64>> = p.iter().copied().map(Some).collect();
        let adjusted = holm(&p);
        assert_eq!(adjusted.len(), expected.len());
        for (ours, theirs) in adjusted.iter().zip(expected) {
            let ours = ours.unwrap();
            assert!((ours - theirs).abs() < 1e-12, "{ours} {theirs}");
        }
    }

    /// statsmodels 0.15.0, `statsmodels.stats.multitest.multipletests(p, method='holm')`.
    #[test]
    fn agrees_with_statsmodels() {
        assert_near(&[0.01, 0.04, 0.03, 0.005], &[0.03, 0.06, 0.06, 0.02]);
        let ties = [0.04, 0.04, 0.04, 0.9, 0.0001];
        assert_near(&ties, &[0.16, 0.16, 0.16, 0.9, 0.0005]);
        assert_near(&[0.5, 0.6, 0.9], &[1.0, 1.0, 1.0]);
        // The fifteen of Duckett & Nehmzow's Table 3, before rounding: of twelve at most .05, two are left.
        let p = [
            0.05559888141,
            0.00595639185898,
            0.0366902336918,
            0.0069694942089,
            0.00319721549594,
            0.0434667082748,
            0.161957164341,
            0.00718213309942,
            0.00953068450975,
            0.599104006056,
            0.00838164322972,
            0.00778737927829,
            0.0455344202989,
            0.00293657849401,
            0.898110318342,
        ];
        let theirs = [
            0.260800249649,
            0.0774330941668,
            0.256831635843,
            0.0836339305068,
            0.0447610169431,
            0.260800249649,
            0.485871493022,
            0.0836339305068,
            0.0836339305068,
            1.0,
            0.0836339305068,
            0.0836339305068,
            0.260800249649,
            0.0440486774102,
            1.0,
        ];
        assert_near(&p, &theirs);
    }

    #[test]
    fn tests_that_there_are_none_of_count_for_nothing() {
        assert_eq!(holm(&[]), []);
        assert_eq!(holm(&[None, None]), [None, None]);
        assert_eq!(holm(&[None, Some(0.5), None]), [None, Some(0.5), None]);
        assert_eq!(holm(&[Some(f64::NAN), Some(0.5)]), [None, Some(0.5)]);
    }
}
