//! A local grid as two histograms, and how well two of them match under the best translation.
//!
//! Duckett & Nehmzow (2000), *Occupancy Histogram Matching*: how many cells of each column are occupied, empty and unknown,
//! and how many of each row. Matching two such histograms costs a 64th of matching the grids. The sums are of bytes, side by
//! side for all translations at once, so that a register holds as many translations as it has bytes.
//! `benches/matching.rs`, one core of a Xeon with AVX-512: 0.5 µs a place for all 2 × 128 translations, where a plain loop takes
//! 60 µs and the sums of minima alone 0.3 µs, which is the limit: reading the place from memory takes a tenth of that.

use super::occupancy::{CELLS, States};
use crate::simd::{self, Kernel};
use serde::{Deserialize, Serialize};

/// Kinds of cells that are counted: occupied, empty, unknown, in this order.
const KINDS: usize = 3;

/// Translations of one histogram against another: number t moves it by 63 − t elements. At the last, −64, nothing overlaps.
const TRANSLATIONS: usize = 2 * CELLS;

/// The match of a histogram with itself: every cell of the grid.
pub const FULL_MATCH: u32 = (CELLS * CELLS) as u32;

/// O_j, E_j and U_j of the columns or the rows j of a grid. The three of an element add up to 64.
/// In a file: the numbers of occupied and of empty cells, a pair an element.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[u8; 2]>", into = "Vec<[u8; 2]>")]
pub struct Histogram {
    /// `[kind, element]`
    counts: [[u8; CELLS]; KINDS],
}

impl Histogram {
    fn from_fn(count: impl Fn(usize) -> [u32; 2]) -> Self {
        // At most 64, so the casts lose nothing.
        let known: [[u8; 2]; CELLS] = std::array::from_fn(|j| count(j).map(|n| n as u8));
        let counts = [
            known.map(|[occupied, _]| occupied),
            known.map(|[_, empty]| empty),
            known.map(|[occupied, empty]| CELLS as u8 - occupied - empty),
        ];
        Self { counts }
    }

    fn reversed(mut self) -> Self {
        self.counts.iter_mut().for_each(|kind| kind.reverse());
        self
    }

    /// The histogram moved `by` elements towards higher ones; what moves in is unknown.
    pub fn moved(&self, by: i32) -> Self {
        Self::from_fn(|j| match usize::try_from(j as i64 - i64::from(by)) {
            Ok(from) if from < CELLS => [0, 1].map(|kind| self.counts[kind][from].into()),
            _ => [0, 0],
        })
    }

    /// Match(T^a, T^b) = Σ_j min(O_j^a, O_j^b) + min(E_j^a, E_j^b) + min(U_j^a, U_j^b), of 4096.
    pub fn match_with(&self, other: &Self) -> u32 {
        let pairs = self
            .counts
            .iter()
            .flatten()
            .zip(other.counts.iter().flatten());
        pairs.map(|(&a, &b)| u32::from(a.min(b))).sum()
    }
}

impl From<Histogram> for Vec<[u8; 2]> {
    fn from(histogram: Histogram) -> Self {
        let [occupied, empty, _] = histogram.counts;
        occupied
            .into_iter()
            .zip(empty)
            .map(<[u8; 2]>::from)
            .collect()
    }
}

impl TryFrom<Vec<[u8; 2]>> for Histogram {
    type Error = String;

    fn try_from(known: Vec<[u8; 2]>) -> Result<Self, String> {
        let fits = |[o, e]: &[u8; 2]| usize::from(*o) + usize::from(*e) <= CELLS;
        if known.len() != CELLS || !known.iter().all(fits) {
            return Err(format!(
                "an occupancy histogram of {} elements; expected {CELLS} of at most {CELLS} known cells",
                known.len()
            ));
        }
        Ok(Self::from_fn(|j| known[j].map(u32::from)))
    }
}

/// A place's signature: the histogram over columns (x) and the one over rows (y) of its grid.
///
/// ```
/// use ballmark::recogniser::{histogram::{HistogramPair, Sought, FULL_MATCH}, occupancy::{State, States}};
/// let wall = States::from_fn(|x, y| match x {
///     40 => State::Occupied,
///     _ if x < 40 && y > 3 => State::Empty,
///     _ => State::Unknown,
/// });
/// let place = HistogramPair::of(&wall);
/// let itself = Sought::new(&place, 5).best_match(&place);
/// assert_eq!((itself.x, itself.y), (FULL_MATCH, FULL_MATCH)); // 4096 each
/// assert_eq!(itself.product(), 16_777_216);
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HistogramPair {
    /// Over columns.
    pub x: Histogram,
    /// Over rows.
    pub y: Histogram,
}

impl HistogramPair {
    /// The histograms of a grid.
    pub fn of(states: &States) -> Self {
        let mut columns = [[0; CELLS]; 2];
        for (counts, plane) in columns.iter_mut().zip([&states.occupied, &states.empty]) {
            for row in plane {
                for (x, count) in counts.iter_mut().enumerate() {
                    *count += ((row >> x) & 1) as u32;
                }
            }
        }
        let rows = |y: usize| [&states.occupied, &states.empty].map(|plane| plane[y].count_ones());
        Self {
            x: Histogram::from_fn(|x| [columns[0][x], columns[1][x]]),
            y: Histogram::from_fn(rows),
        }
    }

    /// The histograms of [`States::quarter_turn`].
    pub fn quarter_turn(self) -> Self {
        Self {
            x: self.y.reversed(),
            y: self.x,
        }
    }
}

/// How well two places match, each direction under its own best translation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PairMatch {
    /// Match(T_x^S, T_x^i), up to 4096.
    pub x: u32,
    /// Match(T_y^S, T_y^i), up to 4096.
    pub y: u32,
}

impl PairMatch {
    /// M_i = Match(T_x^S, T_x^i) × Match(T_y^S, T_y^i), up to 4096².
    pub fn product(&self) -> u32 {
        self.x * self.y
    }
}

/// A histogram among elements of which nothing is known, so that moving it is reading it from elsewhere.
#[derive(Debug, Clone)]
struct Padded([[u8; CELLS + TRANSLATIONS]; KINDS]);

impl Padded {
    fn new(histogram: &Histogram) -> Self {
        let mut kinds = [[0; CELLS + TRANSLATIONS]; KINDS];
        kinds[2] = [CELLS as u8; CELLS + TRANSLATIONS];
        for (padded, counts) in kinds.iter_mut().zip(&histogram.counts) {
            padded[CELLS - 1..][..CELLS].copy_from_slice(counts);
        }
        Self(kinds)
    }
}

/// Sums for every translation, in the order that [`widen`] leaves them in.
type Sums = [u16; TRANSLATIONS];
type Bytes = [u8; TRANSLATIONS];

/// The histograms of a scan, ready to be matched with those of many places.
#[derive(Debug, Clone)]
pub struct Sought {
    x: Padded,
    y: Padded,
    /// All bits for translations within reach, none for the others, in the order of sums.
    within: Sums,
}

impl Sought {
    /// For this scan, to be moved by up to `reach` elements to either side, at most 63.
    pub fn new(scan: &HistogramPair, reach: usize) -> Self {
        let is_within = |t: usize| t.abs_diff(CELLS - 1) <= reach.min(CELLS - 1);
        let mut within = [0; TRANSLATIONS];
        widen(
            &mut within,
            &std::array::from_fn(|t| u8::from(is_within(t))),
        );
        Self {
            x: Padded::new(&scan.x),
            y: Padded::new(&scan.y),
            within: within.map(|is_within| if is_within > 0 { u16::MAX } else { 0 }),
        }
    }

    /// The best match with a place over all translations within reach in x, and in y. The place's histograms stand still, the
    /// scan's move; elements of the place that the scan's no longer reach are compared with unknown cells.
    pub fn best_match(&self, place: &HistogramPair) -> PairMatch {
        let mut one = [PairMatch { x: 0, y: 0 }];
        self.best_matches(std::slice::from_ref(place), &mut one);
        one[0]
    }

    /// [`Sought::best_match`] with many places, one after the other into `matches`, as far as both reach.
    pub fn best_matches(&self, places: &[HistogramPair], matches: &mut [PairMatch]) {
        struct All<'a>(&'a Sought, &'a [HistogramPair], &'a mut [PairMatch]);
        impl Kernel for All<'_> {
            type Output = ();

            #[inline(always)]
            fn run(self) {
                let Self(sought, places, matches) = self;
                for (place, best) in places.iter().zip(matches) {
                    best.x = greatest(&match_sums(&place.x, &sought.x), &sought.within);
                    best.y = greatest(&match_sums(&place.y, &sought.y), &sought.within);
                }
            }
        }
        simd::run(All(self, places, matches));
    }
}

/// The greatest of the sums within reach.
#[inline(always)]
fn greatest(sums: &Sums, within: &Sums) -> u32 {
    let mut best = 0;
    for (&sum, &within) in sums.iter().zip(within) {
        let sum = sum & within;
        best = if sum > best { sum } else { best };
    }
    best.into()
}

/// Match of the stored histogram with the sought one under every translation, in the order that [`widen`] leaves them in. All
/// of them are made whatever the reach: fewer take no less time, side by side as they are.
#[inline(always)]
fn match_sums(stored: &Histogram, sought: &Padded) -> Sums {
    let mut sums = [0; TRANSLATIONS];
    let mut j = 0;
    // An element adds at most 64 to the sum of minima: three fit a byte.
    while j + 3 <= CELLS {
        let mut bytes = [0; TRANSLATIONS];
        add_minima(&mut bytes, stored, sought, j);
        add_minima(&mut bytes, stored, sought, j + 1);
        add_minima(&mut bytes, stored, sought, j + 2);
        widen(&mut sums, &bytes);
        j += 3;
    }
    while j < CELLS {
        let mut bytes = [0; TRANSLATIONS];
        add_minima(&mut bytes, stored, sought, j);
        widen(&mut sums, &bytes);
        j += 1;
    }
    sums
}

/// Adds the minima of element j. Moved by 63 − t, element j of the sought histogram is the one that stood at j + t − 63,
/// which padding puts at j + t.
#[inline(always)]
fn add_minima(bytes: &mut Bytes, stored: &Histogram, sought: &Padded, j: usize) {
    let [occupied, empty, unknown] = &sought.0;
    let occupied = &occupied[j..j + TRANSLATIONS];
    let empty = &empty[j..j + TRANSLATIONS];
    let unknown = &unknown[j..j + TRANSLATIONS];
    let (o, e, u) = (
        stored.counts[0][j],
        stored.counts[1][j],
        stored.counts[2][j],
    );
    for t in 0..TRANSLATIONS {
        bytes[t] += o.min(occupied[t]) + e.min(empty[t]) + u.min(unknown[t]);
    }
}

/// Adds bytes to wider sums, two translations' at a time. Which sum is whose depends on the machine's order of bytes, but is the
/// same for all.
#[inline(always)]
fn widen(sums: &mut Sums, bytes: &Bytes) {
    let pairs: [u16; TRANSLATIONS / 2] = bytemuck::cast(*bytes);
    let (of_low, of_high) = sums.split_at_mut(TRANSLATIONS / 2);
    for i in 0..TRANSLATIONS / 2 {
        of_low[i] += pairs[i] & 0xff;
        of_high[i] += pairs[i] >> 8;
    }
}

#[cfg(test)]
mod tests;
