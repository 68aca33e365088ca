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
    /// Stretches of neighbouring sites of one row.
    rows: Vec<Run>,
    /// Sites column by column, and the stretches of neighbours in that order.
    column_order: Vec<usize>,
    columns: Vec<Range<usize>>,
}

#[derive(Debug, Clone, PartialEq)]
struct Run {
    row: i64,
    column: i64,
    sites: Range<usize>,
}

impl Run {
    fn end_column(&self) -> i64 {
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
        let mut column_order: Vec<usize> = (0..sites.len()).collect();
        column_order.sort_unstable_by_key(|&site| (sites[site].1, sites[site].0));
        let columns = stretches(sites.len(), |i| {
            let (row, column) = sites[column_order[i]];
            (column, row)
        })
        .collect();
        Self {
            cell_m,
            origin_m,
            sites,
            rows,
            column_order,
            columns,
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
        let rows = self.sites.iter().map(|s| s.0);
        let columns = self.sites.iter().map(|s| s.1);
        let span = |low: Option<i64>, high: Option<i64>| {
            low.zip(high).map_or(0, |(low, high)| (high - low) as usize)
        };
        1 + span(rows.clone().min(), rows.max()).max(span(columns.clone().min(), columns.max()))
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

    /// Adds `weight` times `source`, moved by whole sites, to `target`; what leaves the lattice is dropped.
    pub(super) fn add_shifted(
        &self,
        source: &[f64],
        target: &mut [f64],
        columns: i64,
        rows: i64,
        weight: f64,
    ) {
        for run in &self.rows {
            // Where this stretch comes from, in whole sites.
            let (row, from, to) = (
                run.row - rows,
                run.column - columns,
                run.end_column() - columns,
            );
            let first = self
                .rows
                .partition_point(|other| (other.row, other.end_column()) <= (row, from));
            for other in &self.rows[first..] {
                if other.row != row || other.column >= to {
                    break;
                }
                let (low, high) = (from.max(other.column), to.min(other.end_column()));
                let length = (high - low) as usize;
                let into = run.sites.start + (low - from) as usize;
                let out_of = other.sites.start + (low - other.column) as usize;
                let pairs = target[into..into + length]
                    .iter_mut()
                    .zip(&source[out_of..out_of + length]);
                pairs.for_each(|(t, s)| *t += weight * s);
            }
        }
    }

    /// Calls `each` with (stretch of a row, room for its result), for all rows.
    pub(super) fn along_rows(
        &self,
        source: &[f64],
        target: &mut [f64],
        mut each: impl FnMut(&[f64], &mut [f64]),
    ) {
        for run in &self.rows {
            each(&source[run.sites.clone()], &mut target[run.sites.clone()]);
        }
    }

    /// The same for all columns; `source` is used as room to work in.
    pub(super) fn along_columns(
        &self,
        source: &mut [f64],
        target: &mut [f64],
        mut each: impl FnMut(&[f64], &mut [f64]),
    ) {
        for (t, &site) in target.iter_mut().zip(&self.column_order) {
            *t = source[site];
        }
        for stretch in &self.columns {
            each(&target[stretch.clone()], &mut source[stretch.clone()]);
        }
        for (s, &site) in source.iter().zip(&self.column_order) {
            target[site] = *s;
        }
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
