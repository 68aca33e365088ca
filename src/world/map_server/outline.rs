//! Edges between cells of a map that are of different kinds.

use ndarray::Array2;

/// An edge from one corner of cells to another, each `[column, row]`.
pub(super) type Edge = [[usize; 2]; 2];

/// Every edge between neighbours that `parts` says are apart, as long as it goes straight on: first those along rows, from
/// below, then those along columns, from the left. Beyond the picture there are no cells. None where they are more than `most`.
pub(super) fn edges<T: Copy>(
    cells: &Array2<T>,
    parts: impl Fn(Option<T>, Option<T>) -> bool,
    most: usize,
) -> Option<Vec<Edge>> {
    let (rows, columns) = cells.dim();
    // The cell before a row's or column's number is the one below or to the left of its line.
    let cell = |row: Option<usize>, column: Option<usize>| cells.get((row?, column?)).copied();
    let mut edges = Vec::new();
    for line in 0..=rows {
        let wall = |column| {
            let below = cell(line.checked_sub(1), Some(column));
            parts(below, cell(Some(line), Some(column)))
        };
        let along = stretches(columns, wall);
        edges.extend(along.map(|[from, to]| [[from, line], [to, line]]));
        if edges.len() > most {
            return None;
        }
    }
    for line in 0..=columns {
        let wall = |row| {
            let left = cell(Some(row), line.checked_sub(1));
            parts(left, cell(Some(row), Some(line)))
        };
        let along = stretches(rows, wall);
        edges.extend(along.map(|[from, to]| [[line, from], [line, to]]));
        if edges.len() > most {
            return None;
        }
    }
    Some(edges)
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
