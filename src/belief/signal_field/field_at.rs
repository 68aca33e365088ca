//! A signal field worked out at many places, ready to be asked for the likelihood of a snapshot.

use super::{
    SignalField,
    likelihood::{self, BLOCK, Term},
    reading_model::ReadingModel,
    readings::check_finite,
    regression::Visits,
};
use crate::{
    belief::Places,
    error::{Error, Result},
    recording::Channel,
};
use ndarray::ArrayView1;
use rayon::prelude::*;

/// Weight with which the share of all snapshots that have a value speaks for a place.
const PRESENCE_WEIGHT: f64 = 0.1;

/// Presence is kept between this and 1 less this.
const LEAST_PRESENCE: f64 = 1e-3;

/// [`SignalField`] at some places: mean and presence of every value, from [`SignalField::at`].
#[derive(Debug, Clone)]
pub struct SignalFieldAt {
    channels: Vec<Channel>,
    models: Vec<ReadingModel>,
    /// For each value that is ever missing, which plane holds its presence.
    presence: Vec<Option<usize>>,
    places: usize,
    /// Sites that what follows is kept for: places, but for headings.
    sites: usize,
    /// Headings kept: 1 where they share.
    headings: usize,
    /// [`BLOCK`] sites each, `[heading, plane, site]`: means of all values, NaN where nothing is known, then presences.
    blocks: Vec<Vec<f32>>,
}

impl SignalFieldAt {
    pub(super) fn new(field: &SignalField, places: &Places) -> Result<Self> {
        let visits = &field.visits;
        match (visits.places(), places) {
            (Places::Route(_), Places::Route(_)) | (Places::Plane(_), Places::Plane(_)) => {}
            _ => {
                return Err(Error::work(
                    "signal field: its snapshots lie along a route and the places asked for in the plane, or the other way round",
                ));
            }
        }
        check_finite(places)?;
        let sites = sites(places);
        let headings = Headings::new(visits, places, sites);
        let mut planes = field.models.len();
        let presence = field
            .models
            .iter()
            .map(|model| {
                model.is_ever_missing.then(|| {
                    planes += 1;
                    planes - 1
                })
            })
            .collect();
        let mut at = Self {
            channels: field.channels.clone(),
            models: field.models.clone(),
            presence,
            places: places.len(),
            sites,
            headings: headings.kept(),
            blocks: Vec::new(),
        };
        at.blocks = (0..sites.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| at.block(visits, places, &headings, block))
            .collect();
        Ok(at)
    }

    /// Planes of one block and heading.
    fn planes(&self) -> usize {
        self.models.len() + self.presence.iter().flatten().count()
    }

    fn block(
        &self,
        visits: &Visits,
        places: &Places,
        headings: &Headings,
        block: usize,
    ) -> Vec<f32> {
        let planes = self.planes();
        let mut data = vec![0.0; self.headings * planes * BLOCK];
        let (mut near, mut turned) = (Vec::new(), Vec::new());
        let mut sums = vec![0.0; visits.columns()];
        for (lane, site) in (block * BLOCK..self.sites).take(BLOCK).enumerate() {
            let pose = places.pose(site);
            visits.near(pose.x_m, pose.y_m, &mut near);
            for (heading, data) in data.chunks_mut(planes * BLOCK).enumerate() {
                match headings {
                    Headings::OfGrid(factors) => {
                        visits.turned(&near, &factors[heading], &mut turned);
                    }
                    Headings::OfPlaces => visits.turned_to(&near, pose.heading_rad, &mut turned),
                }
                visits.sum(&turned, &mut sums);
                for (value, model) in self.models.iter().enumerate() {
                    data[value * BLOCK + lane] = visits.mean(&sums, value).unwrap_or(f32::NAN);
                    if let Some(plane) = self.presence[value] {
                        let (there, all) = visits.weights(&sums, value);
                        let there = f64::from(there) + PRESENCE_WEIGHT * model.presence;
                        let share = there / (f64::from(all) + PRESENCE_WEIGHT);
                        let share = share.clamp(LEAST_PRESENCE, 1.0 - LEAST_PRESENCE);
                        data[plane * BLOCK + lane] = share as f32;
                    }
                }
            }
        }
        data
    }

    /// Number of places.
    pub fn len(&self) -> usize {
        self.places
    }

    /// Was no place asked for?
    pub fn is_empty(&self) -> bool {
        self.places == 0
    }

    /// The sensors whose readings these are, in their order.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Number of values of a snapshot.
    pub fn values(&self) -> usize {
        self.models.len()
    }

    /// Memory that the field takes, in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.blocks.iter().map(Vec::len).sum::<usize>() * size_of::<f32>()
    }

    /// The mean of a value at a place, in the unit of the readings; that of all snapshots where no reading was taken near.
    pub fn mean(&self, place: usize, value: usize) -> f64 {
        let model = &self.models[value];
        let standardised = f64::from(self.entry(place, value));
        match standardised.is_nan() {
            true => model.mean,
            false => model.mean + model.deviation * standardised,
        }
    }

    /// Probability that a place has a reading of a value: 1 where none was ever missing.
    pub fn presence(&self, place: usize, value: usize) -> f64 {
        match self.presence[value] {
            Some(plane) => f64::from(self.entry(place, plane)),
            None => 1.0,
        }
    }

    fn entry(&self, place: usize, plane: usize) -> f32 {
        let site = place % self.sites;
        let heading = (place / self.sites) % self.headings;
        let row = heading * self.planes() + plane;
        self.blocks[site / BLOCK][row * BLOCK + site % BLOCK]
    }

    /// ln P(z | ξ) of one snapshot's raw readings `[value]`, those of the field's channels in their order, at every place.
    /// What is not finite is missing.
    ///
    /// It is finite at every place, as no reading is worse than an outlier. Densities are those of readings counted in
    /// deviations over all snapshots.
    ///
    /// # Errors
    /// Where there are more or fewer values than the field has.
    pub fn log_likelihood(&self, values: ArrayView1<f32>) -> Result<Vec<f64>> {
        if values.len() != self.models.len() {
            return Err(Error::work(format!(
                "signal field: expected {} values a snapshot, found {}",
                self.models.len(),
                values.len()
            )));
        }
        let (terms, constant) = self.terms(values);
        let planes = self.planes();
        let of_blocks: Vec<Vec<f32>> = self
            .blocks
            .par_iter()
            .map(|block| {
                let headings = block.chunks(planes * BLOCK);
                headings
                    .flat_map(|planes| likelihood::sum(&terms, planes))
                    .collect()
            })
            .collect();
        let mut all = Vec::with_capacity(self.places);
        for heading in 0..self.places.checked_div(self.sites).unwrap_or(0) {
            let kept = heading % self.headings;
            for (block, sums) in of_blocks.iter().enumerate() {
                let sites = BLOCK.min(self.sites - block * BLOCK);
                let sums = &sums[kept * BLOCK..][..sites];
                all.extend(sums.iter().map(|&sum| f64::from(sum) + constant));
            }
        }
        Ok(all)
    }

    /// What each value adds to the sum, and what they add everywhere.
    fn terms(&self, values: ArrayView1<f32>) -> (Vec<Term>, f64) {
        let (mut terms, mut constant) = (Vec::new(), 0.0);
        for (value, (&reading, model)) in values.iter().zip(&self.models).enumerate() {
            if model.presence == 0.0 {
                continue; // never read: nothing is known of it
            }
            let presence = self.presence[value];
            if reading.is_finite() {
                let (term, everywhere) = Term::read(value, presence, reading, model);
                terms.push(term);
                constant += everywhere;
            } else if let Some(presence) = presence {
                terms.push(Term::missing(presence));
            }
        }
        (terms, constant)
    }
}

/// Whose heading counts.
enum Headings {
    /// For every heading of a grid, the factor of every training snapshot; where heading plays no part, a single empty list.
    OfGrid(Vec<Vec<f32>>),
    /// Every place its own.
    OfPlaces,
}

impl Headings {
    fn new(visits: &Visits, places: &Places, sites: usize) -> Self {
        if !visits.has_headings() {
            return Headings::OfGrid(vec![Vec::new()]);
        }
        if sites == places.len() {
            return Headings::OfPlaces;
        }
        let firsts = (0..places.len()).step_by(sites);
        let factors = firsts.map(|first| visits.factors(places.pose(first).heading_rad));
        Headings::OfGrid(factors.collect())
    }

    fn kept(&self) -> usize {
        match self {
            Headings::OfGrid(factors) => factors.len(),
            Headings::OfPlaces => 1,
        }
    }
}

/// After how many places the same points come again, with another heading that they all share: the sites of a grid. All
/// places where they do not.
fn sites(places: &Places) -> usize {
    let Places::Plane(poses) = places else {
        return places.len();
    };
    let Some(first) = poses.first() else {
        return 0;
    };
    let is_at = |a: &crate::Pose, b: &crate::Pose| a.x_m == b.x_m && a.y_m == b.y_m;
    let again = poses[1..].iter().position(|pose| is_at(pose, first));
    let sites = again.map_or(poses.len(), |before| before + 1);
    let repeats = poses.chunks(sites).all(|chunk| {
        chunk.len() == sites
            && chunk
                .iter()
                .zip(poses)
                .all(|(a, b)| is_at(a, b) && a.heading_rad == chunk[0].heading_rad)
    });
    if repeats { sites } else { poses.len() }
}
