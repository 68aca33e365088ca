//! A square lattice of which only some sites count: the floor that a belief lies on.

use crate::{
    error::{Error, Result},
    geometry::Pose,
};
use std::{collections::HashSet, ops::Range};

/// Column and row of a site are at most this far from 0, so that sums of them stay exact as integers and as `f64`.
const FARTHEST: f64 = 1e12;

/// Sites in rows from south to north, each row from west to east; a route is one row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lattice {
    cell_m: f64,
    /// Where the corner of column 0, row 0 lies, in metres.
    origin_m: [f64; 2],
    /// (row, column), sorted.
    sites: Vec<(i64, i64)>,
    /// Stretches of neighbouring sites of one row, sorted as the sites are.
    rows: Vec<Run>,
    extent: usize,
}

/// A stretch of neighbouring sites of one row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Run {
    pub(super) row: i64,
    /// Of its first site.
    pub(super) column: i64,
    pub(super) sites: Range<usize>,
}

impl Run {
    /// The column after its last.
    pub(super) fn end_column(&self) -> i64 {
        self.column + self.sites.len() as i64
    }
}

impl Lattice {
    /// One row of sites that covers `from_m` to `to_m`.
    pub(super) fn line(from_m: f64, to_m: f64, cell_m: f64, most_sites: usize) -> Result<Self> {
        let cells = ((to_m - from_m) / cell_m - 1e-9).ceil().max(1.0);
        if !cells.is_finite() || cells > most_sites as f64 {
            return Err(too_many(&format!("{cells}"), cell_m, most_sites));
        }
        let sites = (0..cells as i64).map(|column| (0, column)).collect();
        Ok(Self::of_sites(sites, cell_m, [from_m, 0.0]))
    }

    /// The sites whose centre is within `margin_m` of some pose, and those that hold a pose.
    pub(super) fn around(
        poses: &[Pose],
        cell_m: f64,
        margin_m: f64,
        most_sites: usize,
    ) -> Result<Self> {
        let reach = margin_m / cell_m;
        // A disc holds about π·reach² sites: refuse before filling it.
        let least = (reach * reach * 3.0).ceil();
        if least > most_sites as f64 {
            return Err(too_many(&format!("{least}"), cell_m, most_sites));
        }
        let mut sites = HashSet::new();
        for (index, pose) in poses.iter().enumerate() {
            let (x, y) = (pose.x_m / cell_m, pose.y_m / cell_m);
            if !pose.is_finite() || x.abs().max(y.abs()) >= FARTHEST {
                return Err(Error::work(format!(
                    "grid: snapshot {index} lies at ({}, {}) m, more than {FARTHEST:e} cells of {cell_m} m from the origin",
                    pose.x_m, pose.y_m
                )));
            }
            sites.insert((y.floor() as i64, x.floor() as i64));
            for row in (y - reach).floor() as i64..=(y + reach).floor() as i64 {
                for column in (x - reach).floor() as i64..=(x + reach).floor() as i64 {
                    let (dx, dy) = (column as f64 + 0.5 - x, row as f64 + 0.5 - y);
                    if dx * dx + dy * dy <= reach * reach {
                        sites.insert((row, column));
                    }
                }
            }
            if sites.len() > most_sites {
                let so_far = format!("more than {}", sites.len());
                return Err(too_many(&so_far, cell_m, most_sites));
            }
        }
        let mut sites: Vec<_> = sites.into_iter().collect();
        sites.sort_unstable();
        Ok(Self::of_sites(sites, cell_m, [0.0, 0.0]))
    }

    fn of_sites(sites: Vec<(i64, i64)>, cell_m: f64, origin_m: [f64; 2]) -> Self {
        let rows = stretches(sites.len(), |i| sites[i])
            .map(|run| Run {
                row: sites[run.start].0,
                column: sites[run.start].1,
                sites: run,
            })
            .collect();
        let span = |along: fn(&(i64, i64)) -> i64| {
            let (low, high) = (sites.iter().map(along).min(), sites.iter().map(along).max());
            low.zip(high).map_or(0, |(low, high)| (high - low) as usize)
        };
        Self {
            cell_m,
            origin_m,
            extent: 1 + span(|s| s.0).max(span(|s| s.1)),
            sites,
            rows,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.sites.len()
    }

    /// Edge of a site, in metres.
    pub(super) fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Largest distance between two columns or two rows: nothing can be shifted or blurred farther.
    pub(super) fn extent(&self) -> usize {
        self.extent
    }

    /// Centre of a site, in metres.
    pub(super) fn centre_m(&self, site: usize) -> (f64, f64) {
        let (row, column) = self.sites[site];
        (
            self.origin_m[0] + (column as f64 + 0.5) * self.cell_m,
            self.origin_m[1] + (row as f64 + 0.5) * self.cell_m,
        )
    }

    /// The site that holds a point, if any.
    pub(super) fn site_at(&self, x_m: f64, y_m: f64) -> Option<usize> {
        let index = |v: f64, origin: f64| ((v - origin) / self.cell_m).floor() as i64;
        let wanted = (index(y_m, self.origin_m[1]), index(x_m, self.origin_m[0]));
        self.sites.binary_search(&wanted).ok()
    }

    /// Stretches of neighbouring sites of one row, from south to north, each row from west to east.
    pub(super) fn runs(&self) -> &[Run] {
        &self.rows
    }

    /// (number of a run, offset, sites) for all runs that lie in `columns` of `row` or begin or end there: the sites are those
    /// in `columns`, the first of them at `offset` from the first column.
    ///
    /// `cursor` is 0 at first and then belongs to calls that ask for one row after the other, from south to north, and in a
    /// row from west to east.
    pub(super) fn overlaps(
        &self,
        cursor: &mut usize,
        row: i64,
        columns: Range<i64>,
    ) -> impl Iterator<Item = (usize, usize, Range<usize>)> {
        while let Some(run) = self.rows.get(*cursor)
            && (run.row, run.end_column()) <= (row, columns.start)
        {
            *cursor += 1;
        }
        let candidates = self.rows.iter().enumerate().skip(*cursor);
        let end = columns.end;
        candidates
            .take_while(move |(_, run)| run.row == row && run.column < end)
            .map(move |(number, run)| {
                let low = columns.start.max(run.column);
                let high = columns.end.min(run.end_column());
                let first = run.sites.start + (low - run.column) as usize;
                let sites = first..first + (high - low) as usize;
                (number, (low - columns.start) as usize, sites)
            })
    }
}

/// The maximal stretches of 0..`length` in which `line` stays and `step` grows by one.
fn stretches(
    length: usize,
    place: impl Fn(usize) -> (i64, i64),
) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    (1..=length).filter_map(move |i| {
        let goes_on = i < length && {
            let ((line, step), (next_line, next_step)) = (place(i - 1), place(i));
            line == next_line && step + 1 == next_step
        };
        (!goes_on).then(|| std::mem::replace(&mut start, i)..i)
    })
}

fn too_many(count: &str, cell_m: f64, most: usize) -> Error {
    Error::usage(format!(
        "grid: {count} cells of {cell_m} m on the floor; expected at most {most} (a larger cell_m, a smaller margin_m, fewer headings or a larger most_cells)"
    ))
}
