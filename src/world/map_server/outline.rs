//! The outline of occupied cells.

use ndarray::Array2;

/// An edge from one corner of cells to another, each `[column, row]`.
pub(super) type Edge = [[usize; 2]; 2];

/// Every edge between an occupied cell and one that isn't (or none at all), as long as it goes straight on: first those
/// along rows, from below, then those along columns, from the left.
pub(super) fn edges(occupied: &Array2<bool>) -> Vec<Edge> {
    let (rows, columns) = occupied.dim();
    // The cell before a row's or column's number is the one below or to the left of its line.
    let taken = |row: Option<usize>, column: Option<usize>| match (row, column) {
        (Some(row), Some(column)) => occupied.get((row, column)).copied().unwrap_or(false),
        _ => false,
    };
    let mut edges = Vec::new();
    for line in 0..=rows {
        let wall =
            |column| taken(line.checked_sub(1), Some(column)) != taken(Some(line), Some(column));
        let along = stretches(columns, wall);
        edges.extend(along.map(|[from, to]| [[from, line], [to, line]]));
    }
    for line in 0..=columns {
        let wall = |row| taken(Some(row), line.checked_sub(1)) != taken(Some(row), Some(line));
        let along = stretches(rows, wall);
        edges.extend(along.map(|[from, to]| [[line, from], [line, to]]));
    }
    edges
}

/// First and past-the-last of each unbroken stretch of numbers below `count` that are walls.
fn stretches(count: usize, wall: impl Fn(usize) -> bool) -> impl Iterator<Item = [usize; 2]> {
    let mut found = Vec::new();
    let mut start = None;
    for at in 0..=count {
        match (at < count && wall(at), start) {
            (true, None) => start = Some(at),
            (false, Some(from)) => {
                found.push([from, at]);
                start = None;
            }
            _ => (),
        }
    }
    found.into_iter()
}
