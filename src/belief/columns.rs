//! Neighbours along the columns of a lattice, in stretches of rows: so columns are blurred a row at a time.

use super::{
    combination::{self, Part, combine},
    kernel::Kernel,
    lattice::{Lattice, Run},
    support::Layer,
};
use std::ops::Range;

/// Which sites lie in one column without a gap between them.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// Number of sites between each site and the next gap, to the north and to the south.
    north: Vec<u32>,
    south: Vec<u32>,
    /// The smallest of these in each run.
    least: Vec<u32>,
    /// For each run, all others that reach it within `reach` rows.
    links: Vec<Vec<Link>>,
    reach: usize,
}

/// Neighbouring sites of one run, and as many of another that lie `distance` rows away from them.
#[derive(Debug, Clone)]
struct Link {
    distance: usize,
    sites: Range<usize>,
    other: Range<usize>,
    other_run: usize,
}

impl Link {
    /// The same from the other run's side.
    fn reversed(&self, run: usize) -> Self {
        Self {
            distance: self.distance,
            sites: self.other.clone(),
            other: self.sites.clone(),
            other_run: run,
        }
    }
}

impl Columns {
    /// Pairs of sites up to `reach` rows apart.
    pub(super) fn new(lattice: &Lattice, reach: usize) -> Self {
        let (mut next, mut cursor) = (Vec::new(), 0);
        for run in lattice.runs() {
            let mut links = Vec::new();
            let columns = run.column..run.end_column();
            for (north_run, offset, north) in lattice.overlaps(&mut cursor, run.row + 1, columns) {
                let from = run.sites.start + offset;
                links.push(Link {
                    distance: 1,
                    sites: from..from + north.len(),
                    other: north,
                    other_run: north_run,
                });
            }
            next.push(links);
        }
        let (mut north, mut south) = (vec![0; lattice.len()], vec![0; lattice.len()]);
        for link in next.iter().flatten() {
            for (s, n) in link.sites.clone().zip(link.other.clone()) {
                south[n] = south[s] + 1;
            }
        }
        for link in next.iter().rev().flatten() {
            for (s, n) in link.sites.clone().zip(link.other.clone()) {
                north[s] = north[n] + 1;
            }
        }
        let mut links: Vec<Vec<Link>> = (0..next.len())
            .map(|run| links_of_run(&next, run, reach))
            .collect();
        // From north to south, so that a run still has only its links to the north.
        for run in (0..links.len()).rev() {
            for number in 0..links[run].len() {
                let link = &links[run][number];
                let (other_run, reversed) = (link.other_run, link.reversed(run));
                links[other_run].push(reversed);
            }
        }
        let least = |run: &Run| {
            let free = north[run.sites.clone()]
                .iter()
                .chain(&south[run.sites.clone()]);
            free.copied().min().unwrap_or(0)
        };
        Self {
            least: lattice.runs().iter().map(least).collect(),
            north,
            south,
            links,
            reach,
        }
    }

    /// Rows that a linked pair is apart at most.
    pub(super) fn reach(&self) -> usize {
        self.reach
    }

    /// Blurs each column of `source` into `target`, between the gaps that end it. What would pass a gap stays where it was.
    #[inline(always)]
    pub(super) fn blur(
        &self,
        lattice: &Lattice,
        kernel: &Kernel,
        source: &Layer,
        target: &mut Layer,
    ) {
        target.forget();
        let spans = lattice.runs().iter().map(|run| source.span(&run.sites));
        let spans: Vec<Range<usize>> = spans.collect();
        let mut parts = Vec::new();
        for (number, span) in spans.iter().enumerate() {
            parts.clear();
            if !span.is_empty() {
                parts.push(Part {
                    weight: kernel.weight(0),
                    at: span.start,
                    masses: source.mass(span.clone()),
                });
            }
            for link in self.links[number]
                .iter()
                .filter(|link| link.distance <= kernel.radius())
            {
                let span = &spans[link.other_run];
                let part = link.other.start.max(span.start)..link.other.end.min(span.end);
                if !part.is_empty() {
                    parts.push(Part {
                        weight: kernel.weight(link.distance),
                        at: link.sites.start + (part.start - link.other.start),
                        masses: source.mass(part),
                    });
                }
            }
            if let Some(stretch) = combination::reach(&parts) {
                combine(&parts, stretch.start, target.mass_mut(stretch.clone()));
                if (self.least[number] as usize) < kernel.radius() {
                    self.add_what_stays(kernel, span, source, target);
                }
            }
        }
    }

    /// The share that no link carries away.
    #[inline(always)]
    fn add_what_stays(
        &self,
        kernel: &Kernel,
        span: &Range<usize>,
        source: &Layer,
        target: &mut Layer,
    ) {
        let targets = target.mass_mut(span.clone()).iter_mut();
        let masses = targets.zip(source.mass(span.clone()));
        let free = self.north[span.clone()]
            .iter()
            .zip(&self.south[span.clone()]);
        for ((t, s), (&north, &south)) in masses.zip(free) {
            *t += (kernel.beyond(north as usize) + kernel.beyond(south as usize)) * s;
        }
    }
}

/// All links that lead north from `run`, given those of each run that lead one row north.
fn links_of_run(next: &[Vec<Link>], run: usize, reach: usize) -> Vec<Link> {
    if reach == 0 {
        return Vec::new();
    }
    let mut links = next[run].clone();
    let mut first = 0;
    for distance in 2..=reach {
        let last = links.len();
        for number in first..last {
            let link = links[number].clone();
            for on in &next[link.other_run] {
                let start = on.sites.start.max(link.other.start);
                let end = on.sites.end.min(link.other.end);
                if start < end {
                    let from = link.sites.start + (start - link.other.start);
                    let to = on.other.start + (start - on.sites.start);
                    links.push(Link {
                        distance,
                        sites: from..from + (end - start),
                        other: to..to + (end - start),
                        other_run: on.other_run,
                    });
                }
            }
        }
        if last == links.len() {
            break;
        }
        first = last;
    }
    links
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::{
        laws::{bend, grid},
        places::Places,
        support::BLOCK,
    };

    /// Site by site: mass goes `d` rows on where all sites between are there, and else stays.
    #[test]
    fn each_column_is_blurred_between_its_gaps() {
        let grid = grid(&bend());
        let lattice = grid.lattice();
        let Places::Plane(cells) = &**grid.places() else {
            unreachable!()
        };
        let beside = |site: usize, rows: f64| {
            lattice.site_at(cells[site].x_m, cells[site].y_m + rows * lattice.cell_m())
        };
        let n = lattice.len();
        let all: Vec<f64> = (0..n).map(|i| (i * i % 17 + 1) as f64).collect();
        let some = all.iter().enumerate();
        let some = some.map(|(i, m)| if i / 70 == 1 { *m } else { 0.0 });
        for (mass, variance) in [(all.clone(), 0.1), (some.collect(), 0.5), (all, 30.0)] {
            let kernel = Kernel::gaussian(variance, lattice.extent());
            let mut expected = vec![0.0; n];
            for (site, mass) in mass.iter().enumerate() {
                expected[site] += kernel.weight(0) * mass;
                for side in [1.0, -1.0] {
                    let mut lands = Some(site);
                    for d in 1..=kernel.radius() {
                        lands = lands.and_then(|from| beside(from, side));
                        expected[lands.unwrap_or(site)] += kernel.weight(d) * mass;
                    }
                }
            }
            let blocks = n.div_ceil(BLOCK);
            let (mut mass, mut blurred) = (mass, vec![f64::NAN; n]);
            let (mut held, mut blurred_held) = (vec![true; blocks], vec![false; blocks]);
            let source = Layer::new(&mut mass, &mut held);
            let mut target = Layer::new(&mut blurred, &mut blurred_held);
            let columns = Columns::new(lattice, kernel.radius());
            columns.blur(lattice, &kernel, &source, &mut target);
            for (site, e) in expected.iter().enumerate() {
                let got = if blurred_held[site / BLOCK] {
                    blurred[site]
                } else {
                    0.0
                };
                assert!(
                    (got - e).abs() < 1e-12,
                    "{variance}, site {site}: {got} not {e}"
                );
            }
        }
    }
}
