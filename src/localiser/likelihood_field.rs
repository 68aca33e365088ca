//! An ordinary occupancy map as a sensor model: its likelihood field, asked at every cell of a grid.
//!
//! For one heading, a beam's end lies at the same offset from every cell. So the beam's part of ln p(z | ξ) is the field
//! itself, moved by that offset and read once a cell: an image of it, sub-sampled to the grid's spacing. A scan is then a
//! sum of moved images, one a beam, and no pose is ever turned into coordinates.

use crate::{
    belief::{Grid, Places},
    error::{Error, Result},
    geometry::Pose,
    mapping::{Beam, LikelihoodField},
};
use rayon::prelude::*;
use std::{f64::consts::TAU, ops::Range, sync::Arc};

/// A likelihood field, ready to be asked at all cells of one grid in the plane.
///
/// ```
/// use ballmark::{belief::{Grid, GridConfig, Places}, geometry::Pose, localiser::likelihood_field::FieldOverGrid};
/// use ballmark::mapping::{Beam, LikelihoodField, LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig};
/// # use ballmark::recording::{Channel, Columns, Recording};
/// # let laser = Channel { name: "laser".into(), width: 1, unit: "m".into(), bearing_rad: Some(vec![0.0]), maximum: None, offset_m: None };
/// # let recording = Recording::new(Columns { channels: vec![laser], values: ndarray::array![[2.0], [2.0]], stamp_s: vec![0.0, 1.0],
/// #     pose: vec![Pose::new(0.1, 0.1, 0.0); 2], odometry: vec![Pose::default(); 2], run: vec![0, 0], ..Columns::default() })?;
/// let map = OccupancyMap::from_scans(&recording, &[0, 1], &OccupancyMapConfig::default())?;
/// let field = LikelihoodField::new(&map, &LikelihoodFieldConfig::default())?;
/// let grid = std::sync::Arc::new(Grid::over(&Places::of(&recording), &GridConfig::default())?);
/// let over_grid = FieldOverGrid::new(&field, &grid)?;
/// let said = over_grid.log_likelihood(&[Beam { ahead_m: 2.0, left_m: 0.0 }]);
/// let here = grid.cell_at(&Places::of(&recording), 0).unwrap();
/// assert!(said[here] > -0.1 && said.iter().all(|l| *l <= said[here] + 0.05));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct FieldOverGrid {
    grid: Arc<Grid>,
    spans: Vec<Span>,
    /// Cells of all spans together.
    padded: usize,
    images: Images,
}

/// Cells of one row of the grid, from its first to its last, those between that are no cells of the grid as well.
struct Span {
    row: i64,
    column: i64,
    /// Where it lies among the cells of all spans.
    padded: Range<usize>,
    /// Its first site, and the place in the span of every site of the grid.
    first_site: usize,
    sites: Vec<u32>,
}

/// A gap in a row that is longer than this many cells begins another span.
const LONGEST_GAP: i64 = 32;

/// The field, sub-sampled to the grid's spacing: an image for each of the places within a cell that a beam can end at.
struct Images {
    /// Places within a cell on either axis.
    within: i64,
    /// Edge of such a place, in metres.
    fine_m: f64,
    /// Column and row of the images' first cell in the grid's numbering.
    first: [i64; 2],
    width: usize,
    height: usize,
    /// Image by image, each row by row: ln p of a beam's end, less that of one outside of the map.
    values: Vec<f32>,
    outside: f32,
}

impl FieldOverGrid {
    /// Prepares a field for a grid.
    ///
    /// # Errors
    /// Where the grid lies along a route: a likelihood field asks for poses in the plane.
    pub fn new(field: &LikelihoodField, grid: &Arc<Grid>) -> Result<Self> {
        let Places::Plane(poses) = &**grid.places() else {
            return Err(Error::work(
                "likelihood field: the grid lies along a route; expected one in the plane",
            ));
        };
        let sites = grid.len() / grid.headings();
        let (spans, padded) = spans(&poses[..sites], grid.cell_m());
        Ok(Self {
            images: Images::new(field, grid.cell_m()),
            grid: Arc::clone(grid),
            spans,
            padded,
        })
    }

    /// ln p(z | ξ) of some beams at every cell, taken as independent of each other: the sum over them.
    pub fn log_likelihood(&self, beams: &[Beam]) -> Vec<f32> {
        let headings = self.grid.headings();
        let sites = self.grid.len() / headings;
        let mut all = vec![0.0; self.grid.len()];
        all.par_chunks_mut(sites)
            .enumerate()
            .for_each(|(heading, out)| {
                let (sin, cos) = (heading as f64 * TAU / headings as f64).sin_cos();
                let ends: Vec<End> = beams
                    .iter()
                    .map(|beam| {
                        let east_m = cos * beam.ahead_m - sin * beam.left_m;
                        let north_m = sin * beam.ahead_m + cos * beam.left_m;
                        self.images.end(east_m, north_m)
                    })
                    .collect();
                self.one_heading(&ends, out);
            });
        all
    }

    fn one_heading(&self, ends: &[End], out: &mut [f32]) {
        let mut sums = vec![0.0f32; self.padded];
        for span in &self.spans {
            let sums = &mut sums[span.padded.clone()];
            for end in ends {
                self.images.add(end, span, sums);
            }
            let outside = ends.len() as f32 * self.images.outside;
            for (i, &place) in span.sites.iter().enumerate() {
                out[span.first_site + i] = sums[place as usize] + outside;
            }
        }
    }
}

/// Where a beam ends relative to a cell: which image, and by how many cells it is moved.
struct End {
    image: usize,
    columns: i64,
    rows: i64,
}

impl Images {
    fn new(field: &LikelihoodField, cell_m: f64) -> Self {
        let within = (cell_m / field.cell_m()).round().max(1.0);
        let fine_m = cell_m / within;
        let within = within as i64;
        let (low, high) = field.bounds_m();
        let first = low.map(|v| (v / cell_m).floor() as i64);
        let size = [0, 1].map(|axis| ((high[axis] / cell_m).ceil() as i64 - first[axis]).max(1));
        let (width, height) = (size[0] as usize, size[1] as usize);
        let outside = field.outside();
        let mut values = vec![0.0; (within * within) as usize * width * height];
        values
            .par_chunks_mut(width * height)
            .enumerate()
            .for_each(|(image, values)| {
                let (east, north) = (image as i64 % within, image as i64 / within);
                for (cell, value) in values.iter_mut().enumerate() {
                    let column = first[0] + (cell % width) as i64;
                    let row = first[1] + (cell / width) as i64;
                    let centre =
                        |cell: i64, place: i64| ((cell * within + place) as f64 + 0.5) * fine_m;
                    *value = field.at(centre(column, east), centre(row, north)) - outside;
                }
            });
        Self {
            within,
            fine_m,
            first,
            width,
            height,
            values,
            outside,
        }
    }

    /// The end of a beam that goes so far east and north from the centre of a cell.
    fn end(&self, east_m: f64, north_m: f64) -> End {
        // From the cell's south-west corner, in places within a cell.
        let place = |way_m: f64| (0.5 * self.within as f64 + way_m / self.fine_m).floor() as i64;
        let (east, north) = (place(east_m), place(north_m));
        let image = north.rem_euclid(self.within) * self.within + east.rem_euclid(self.within);
        End {
            image: image as usize,
            columns: east.div_euclid(self.within),
            rows: north.div_euclid(self.within),
        }
    }

    /// Adds the image of a beam's end to the cells of a span.
    fn add(&self, end: &End, span: &Span, sums: &mut [f32]) {
        let row = span.row + end.rows - self.first[1];
        if row < 0 || row >= self.height as i64 {
            return; // outside of the map, and so nothing
        }
        let column = span.column + end.columns - self.first[0];
        let from = column.max(0);
        let to = (column + sums.len() as i64).min(self.width as i64);
        if from >= to {
            return;
        }
        let image = (end.image * self.height + row as usize) * self.width;
        let moved = &self.values[image + from as usize..image + to as usize];
        let sums = &mut sums[(from - column) as usize..(to - column) as usize];
        for (sum, value) in sums.iter_mut().zip(moved) {
            *sum += value;
        }
    }
}

/// The rows of a grid's sites, given by their poses of one heading, and the number of their cells.
fn spans(sites: &[Pose], cell_m: f64) -> (Vec<Span>, usize) {
    let at = |pose: &Pose| [pose.y_m, pose.x_m].map(|v| (v / cell_m - 0.5).round() as i64);
    let mut spans: Vec<Span> = Vec::new();
    let mut padded = 0;
    for (site, pose) in sites.iter().enumerate() {
        let [row, column] = at(pose);
        match spans.last_mut() {
            Some(span)
                if span.row == row
                    && column - (span.column + span.padded.len() as i64) <= LONGEST_GAP =>
            {
                let place = (column - span.column) as usize;
                padded = span.padded.start + place + 1;
                span.padded.end = padded;
                span.sites.push(place as u32);
            }
            _ => {
                spans.push(Span {
                    row,
                    column,
                    padded: padded..padded + 1,
                    first_site: site,
                    sites: vec![0],
                });
                padded += 1;
            }
        }
    }
    (spans, padded)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        belief::GridConfig,
        mapping::{LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig},
        recogniser::test_world::test_world,
    };

    /// Brute force: every cell, every beam, by coordinates.
    #[test]
    fn sums_of_moved_images_are_the_field_at_every_pose() {
        let recording = test_world();
        let snapshots: Vec<usize> = (0..recording.len()).collect();
        for cell_m in [0.25, 0.3] {
            let map = OccupancyMap::from_scans(
                &recording,
                &snapshots,
                &OccupancyMapConfig {
                    margin_m: 2.0, // so that some beams end outside
                    ..OccupancyMapConfig::default()
                },
            )
            .unwrap();
            let field = LikelihoodField::new(&map, &LikelihoodFieldConfig::default()).unwrap();
            let config = GridConfig {
                cell_m,
                headings: 7,
                margin_m: 0.6,
                ..GridConfig::default()
            };
            let grid = Arc::new(Grid::over(&Places::of(&recording), &config).unwrap());
            let over_grid = FieldOverGrid::new(&field, &grid).unwrap();
            let beams = field
                .beams(recording.channels(), &recording.observation(17))
                .unwrap();
            assert!(beams.len() > 8);
            let found = over_grid.log_likelihood(&beams);
            let Places::Plane(poses) = &**grid.places() else {
                unreachable!("a grid in the plane")
            };
            // By coordinates, the end of a beam taken to the middle of the place that it falls into.
            let fine_m = over_grid.images.fine_m;
            let middle = |v: f64| ((v / fine_m).floor() + 0.5) * fine_m;
            let by_coordinates = |pose: &Pose| -> f32 {
                let (sin, cos) = pose.heading_rad.sin_cos();
                let of_beam = |beam: &Beam| {
                    let x_m = pose.x_m + cos * beam.ahead_m - sin * beam.left_m;
                    let y_m = pose.y_m + sin * beam.ahead_m + cos * beam.left_m;
                    field.at(middle(x_m), middle(y_m))
                };
                beams.iter().map(of_beam).sum()
            };
            let differ = poses
                .iter()
                .zip(&found)
                .filter(|(pose, found)| (by_coordinates(pose) - **found).abs() > 1e-3)
                .count();
            // Where an end lies on a border, rounding may take it to either side.
            assert!(differ * 100 < found.len(), "{differ} of {}", found.len());
            // The best cell is at the truth.
            let best = (0..found.len())
                .max_by(|&a, &b| found[a].total_cmp(&found[b]))
                .unwrap();
            assert!(poses[best].distance_m(&recording.poses()[17]) < 0.5);
        }
    }
}
