//! Neighbours along the columns of a lattice, in stretches of rows: so columns are blurred a row at a time.

use super::{kernel::Kernel, lattice::Lattice, support::Layer};
use std::ops::Range;

/// Which sites lie in one column without a gap between them.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// Number of sites between each site and the next gap, to the north and to the south.
    north: Vec<u32>,
    south: Vec<u32>,
    /// All pairs of sites up to `reach` rows apart.
    links: Vec<Link>,
    reach: usize,
}

/// Neighbouring sites of one run, and as many of another run that lie `distance` rows to the north of them.
#[derive(Debug, Clone)]
struct Link {
    distance: usize,
    south: Range<usize>,
    south_run: usize,
    north: Range<usize>,
    north_run: usize,
}

impl Columns {
    /// Pairs of sites up to `reach` rows apart.
    pub(super) fn new(lattice: &Lattice, reach: usize) -> Self {
        let (mut next, mut cursor) = (Vec::new(), 0);
        for (number, run) in lattice.runs().iter().enumerate() {
            let mut links = Vec::new();
            let columns = run.column..run.end_column();
            for (north_run, offset, north) in lattice.overlaps(&mut cursor, run.row + 1, columns) {
                let from = run.sites.start + offset;
                links.push(Link {
                    distance: 1,
                    south: from..from + north.len(),
                    south_run: number,
                    north,
                    north_run,
                });
            }
            next.push(links);
        }
        let (mut north, mut south) = (vec![0; lattice.len()], vec![0; lattice.len()]);
        for link in next.iter().flatten() {
            for (s, n) in link.south.clone().zip(link.north.clone()) {
                south[n] = south[s] + 1;
            }
        }
        for link in next.iter().rev().flatten() {
            for (s, n) in link.south.clone().zip(link.north.clone()) {
                north[s] = north[n] + 1;
            }
        }
        Self {
            north,
            south,
            links: (0..next.len())
                .flat_map(|run| links_of_run(&next, run, reach))
                .collect(),
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
        target.clear();
        let spans = lattice.runs().iter().map(|run| source.span(&run.sites));
        let spans: Vec<Range<usize>> = spans.collect();
        for span in spans.iter().filter(|span| !span.is_empty()) {
            self.add_what_stays(kernel, span, source, target);
        }
        for link in &self.links {
            if link.distance > kernel.radius() {
                continue;
            }
            let weight = kernel.weight(link.distance);
            for (run, from, to) in [
                (link.south_run, &link.south, link.north.start),
                (link.north_run, &link.north, link.south.start),
            ] {
                let part = from.start.max(spans[run].start)..from.end.min(spans[run].end);
                if !part.is_empty() {
                    let at = to + (part.start - from.start);
                    target.add(at, source.mass(part), weight);
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
        const TOGETHER: usize = 16;
        let targets = target.mass_mut(span.clone()).chunks_mut(TOGETHER);
        let sources = source.mass(span.clone()).chunks(TOGETHER);
        let free = self.north[span.clone()]
            .chunks(TOGETHER)
            .zip(self.south[span.clone()].chunks(TOGETHER));
        for ((targets, sources), (north, south)) in targets.zip(sources).zip(free) {
            let least = north.iter().chain(south).min();
            let masses = targets.iter_mut().zip(sources);
            if least.is_some_and(|&least| least as usize >= kernel.radius()) {
                for (t, s) in masses {
                    *t += kernel.weight(0) * s;
                }
            } else {
                for ((t, s), (&n, &south)) in masses.zip(north.iter().zip(south)) {
                    let beyond = kernel.beyond(n as usize) + kernel.beyond(south as usize);
                    *t += (kernel.weight(0) + beyond) * s;
                }
            }
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
            for on in &next[link.north_run] {
                let start = on.south.start.max(link.north.start);
                let end = on.south.end.min(link.north.end);
                if start < end {
                    let from = link.south.start + (start - link.north.start);
                    let to = on.north.start + (start - on.south.start);
                    links.push(Link {
                        distance,
                        south: from..from + (end - start),
                        south_run: run,
                        north: to..to + (end - start),
                        north_run: on.north_run,
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
