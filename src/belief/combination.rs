//! Weighted sums of stretches of masses that begin and end at different sites of a row.

use std::ops::Range;

/// Masses that count with a weight, the first of them at site `at`.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    pub weight: f64,
    pub at: usize,
    pub masses: &'a [f64],
}

impl Part<'_> {
    /// The site after its last.
    fn end(&self) -> usize {
        self.at + self.masses.len()
    }
}

/// The stretch from the first site that any part reaches to the last.
pub(super) fn reach(parts: &[Part]) -> Option<Range<usize>> {
    let start = parts.iter().map(|part| part.at).min()?;
    let end = parts.iter().map(Part::end).max()?;
    Some(start..end)
}

/// Makes the target, of which the first is site `first`, the weighted sum of the parts. Each sum is taken in the order of
/// the parts, so parts of zeros that are left out change no bit.
#[inline(always)]
pub(super) fn combine(parts: &[Part], first: usize, target: &mut [f64]) {
    let (mut start, mut end) = (first, first + target.len());
    for part in parts {
        start = start.max(part.at);
        end = end.min(part.end());
    }
    if start >= end {
        return combine_some(parts, first, target);
    }
    let (before, rest) = target.split_at_mut(start - first);
    let (common, after) = rest.split_at_mut(end - start);
    combine_some(parts, first, before);
    combine_all(parts, start, common);
    combine_some(parts, end, after);
}

/// Where some parts are and others are not: one part after the other.
#[inline(always)]
fn combine_some(parts: &[Part], first: usize, target: &mut [f64]) {
    target.fill(0.0);
    for part in parts {
        let start = part.at.max(first);
        let end = part.end().min(first + target.len());
        if start < end {
            let masses = &part.masses[start - part.at..end - part.at];
            for (t, mass) in target[start - first..].iter_mut().zip(masses) {
                *t += part.weight * mass;
            }
        }
    }
}

/// Where all parts are: all parts of some sites after the other, their sums in registers.
#[inline(always)]
fn combine_all(parts: &[Part], first: usize, target: &mut [f64]) {
    let (many, rest) = target.as_chunks_mut::<32>();
    let (some, ones) = rest.as_chunks_mut::<8>();
    let site = sum_up(parts, first, many);
    let site = sum_up(parts, site, some);
    sum_up(parts, site, ones.as_chunks_mut::<1>().0);
}

/// Sums up `N` sites at once, from `site` on; returns the site after the last.
#[inline(always)]
fn sum_up<const N: usize>(parts: &[Part], mut site: usize, target: &mut [[f64; N]]) -> usize {
    for together in target {
        let mut sums = [0.0; N];
        for part in parts {
            let masses = &part.masses[site - part.at..][..N];
            for (sum, mass) in sums.iter_mut().zip(masses) {
                *sum += part.weight * mass;
            }
        }
        *together = sums;
        site += N;
    }
    site
}
