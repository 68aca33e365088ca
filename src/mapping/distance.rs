//! Exact Euclidean distances on a raster, by lower envelopes of parabolas (Felzenszwalb & Huttenlocher, *Distance
//! Transforms of Sampled Functions*, 2012): linear in the number of cells.

use rayon::prelude::*;

/// Distance of every cell from the nearest `occupied` one, in cells, `[row, column]` row by row; infinite where none is.
pub(super) fn distances(occupied: &[bool], width: usize) -> Vec<f32> {
    let height = occupied.len() / width.max(1);
    // Along the rows: distance to the nearest occupied cell of the row.
    let mut square = vec![f32::INFINITY; occupied.len()];
    let rows = square.par_chunks_mut(width.max(1));
    rows.zip(occupied.par_chunks(width.max(1)))
        .for_each(|(square, occupied)| {
            let mut last = f32::INFINITY;
            for (d, &is_occupied) in square.iter_mut().zip(occupied) {
                last = if is_occupied { 0.0 } else { last + 1.0 };
                *d = last;
            }
            let mut last = f32::INFINITY;
            for d in square.iter_mut().rev() {
                last = if *d == 0.0 { 0.0 } else { last + 1.0 };
                *d = d.min(last);
                *d *= *d;
            }
        });
    // Along the columns: the lower envelope of the parabolas that stand on the rows' squares.
    let columns: Vec<Vec<f32>> = (0..width)
        .into_par_iter()
        .map(|column| {
            let along: Vec<f32> = (0..height)
                .map(|row| square[row * width + column])
                .collect();
            envelope(&along)
        })
        .collect();
    let mut distance = square;
    for (column, values) in columns.iter().enumerate() {
        for (row, value) in values.iter().enumerate() {
            distance[row * width + column] = value.sqrt();
        }
    }
    distance
}

/// min over j of (i − j)² + f(j), for every i.
fn envelope(f: &[f32]) -> Vec<f32> {
    // Parabolas of the envelope, and where each begins to be the lowest.
    let mut lowest: Vec<usize> = Vec::new();
    let mut begins: Vec<f64> = Vec::new();
    let value = |j: usize| f64::from(f[j]) + (j * j) as f64;
    for j in (0..f.len()).filter(|&j| f[j].is_finite()) {
        let mut begin = f64::NEG_INFINITY;
        while let (Some(&last), Some(&last_begins)) = (lowest.last(), begins.last()) {
            begin = (value(j) - value(last)) / (2.0 * (j - last) as f64);
            if begin > last_begins {
                break;
            }
            lowest.pop();
            begins.pop();
            begin = f64::NEG_INFINITY;
        }
        lowest.push(j);
        begins.push(begin);
    }
    let mut at = 0;
    (0..f.len())
        .map(|i| {
            while at + 1 < lowest.len() && begins[at + 1] <= i as f64 {
                at += 1;
            }
            match lowest.get(at) {
                Some(&j) => i.abs_diff(j).pow(2) as f32 + f[j],
                None => f32::INFINITY,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use rand::RngExt;

    #[test]
    fn distances_are_those_of_the_nearest_occupied_cell() {
        let mut random = Seed(3).stream("raster");
        for (width, height, share) in [
            (17, 9, 0.05),
            (1, 12, 0.2),
            (12, 1, 0.2),
            (8, 8, 0.0),
            (5, 5, 1.0),
        ] {
            let occupied: Vec<bool> = (0..width * height)
                .map(|_| random.random_range(0.0..1.0) < share)
                .collect();
            let found = distances(&occupied, width);
            for (cell, found) in found.iter().enumerate() {
                let nearest = (0..occupied.len())
                    .filter(|&other| occupied[other])
                    .map(|other| {
                        let dx = (cell % width).abs_diff(other % width);
                        let dy = (cell / width).abs_diff(other / width);
                        ((dx * dx + dy * dy) as f32).sqrt()
                    })
                    .fold(f32::INFINITY, f32::min);
                assert!(
                    *found == nearest || (found - nearest).abs() < 1e-4,
                    "{width}×{height}, cell {cell}: {found}, not {nearest}"
                );
            }
        }
    }
}
