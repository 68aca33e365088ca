//! Where one local grid lies on another: the translation under which most cells agree.
//!
//! Duckett & Nehmzow (2000) match grids as in Yamauchi & Langley, *Place recognition in dynamic environments* (1997):
//! [`hill_climb`] searches the translations. They print no evaluation function; ours counts the cells of the stored grid whose
//! state (occupied, empty, unknown) is that of the cell on them, where cells outside are unknown. So it is to grids what
//! their histogram match is to histograms.
//!
//! [`SoughtGrid::align`] finds the best of all translations within reach, and with certainty, by a bound: in every column,
//! no more occupied cells can agree than the lesser of the two grids' numbers of them, whatever the grid is moved up or
//! down; likewise empty cells, and likewise rows. Only translations whose bound reaches the best agreement found so far are
//! looked at, 64 cells at a time.

use super::{
    histogram::{Histogram, HistogramPair, Padded, Sought, Sums, TRANSLATIONS},
    occupancy::{CELLS, State, States},
    vectors::{Kernel, widest},
};

const SIDE: i32 = CELLS as i32;
const ALL: i32 = SIDE * SIDE;

/// A translation and what it is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Alignment {
    /// Cells that the sought grid is moved to the right.
    pub right: i32,
    /// Cells that it is moved upwards.
    pub up: i32,
    /// Number of the 4096 cells whose states agree.
    pub agreement: u32,
}

impl Alignment {
    /// More cells agree; or as many, and it is the shorter movement (then the one further down, then to the left).
    fn beats(&self, other: &Self) -> bool {
        let rank = |a: &Self| (a.right * a.right + a.up * a.up, a.up, a.right);
        self.agreement > other.agreement
            || self.agreement == other.agreement && rank(self) < rank(other)
    }
}

/// Number of cells of `stored` whose state is that of the cell of `sought` that lies on them, cell by cell.
pub fn agreement(stored: &[State], sought: &[State], right: i32, up: i32) -> u32 {
    let mut agreeing = 0;
    for y in 0..SIDE {
        for x in 0..SIDE {
            let (from_x, from_y) = (x - right, y - up);
            let within = (0..SIDE).contains(&from_x) && (0..SIDE).contains(&from_y);
            let moved = match within {
                true => sought[(from_y * SIDE + from_x) as usize],
                false => State::Unknown,
            };
            agreeing += u32::from(stored[(y * SIDE + x) as usize] == moved);
        }
    }
    agreeing
}

/// Steepest ascent from a translation `(right, up)`: to the best of the eight around it, as long as that is better.
/// Translations stay within `reach` cells in x and in y. Grids are 64 × 64 cells, row by row.
pub fn hill_climb(stored: &[State], sought: &[State], start: (i32, i32), reach: i32) -> Alignment {
    struct Cells<'a>(&'a [State], &'a [State]);
    impl Overlay for Cells<'_> {
        fn at(&self, right: i32, up: i32) -> Alignment {
            Alignment {
                right,
                up,
                agreement: agreement(self.0, self.1, right, up),
            }
        }
    }
    climb(start, reach, &Cells(stored, sought))
}

/// One grid on another. (No closure: it would not be compiled for wide vectors.)
trait Overlay {
    fn at(&self, right: i32, up: i32) -> Alignment;
}

#[inline(always)]
fn climb(start: (i32, i32), reach: i32, overlay: &impl Overlay) -> Alignment {
    let mut best = overlay.at(start.0, start.1);
    loop {
        let here = best;
        for up in (here.up - 1).max(-reach)..=(here.up + 1).min(reach) {
            for right in (here.right - 1).max(-reach)..=(here.right + 1).min(reach) {
                let next = overlay.at(right, up);
                if next.beats(&best) {
                    best = next;
                }
            }
        }
        if best == here {
            return here;
        }
    }
}

/// A place's grid, with its histograms.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredGrid {
    states: States,
    histograms: HistogramPair,
    known: i32,
}

impl From<States> for StoredGrid {
    fn from(states: States) -> Self {
        Self {
            histograms: HistogramPair::of(&states),
            known: states.known() as i32,
            states,
        }
    }
}

impl StoredGrid {
    /// The grid.
    pub fn states(&self) -> &States {
        &self.states
    }
}

/// A grid to be found on others, each translation within reach of it.
///
/// ```
/// use ballmark::recogniser::{alignment::SoughtGrid, occupancy::{State, States}};
/// let door = |at: usize| States::from_fn(|x, y| match (x, y) {
///     (_, 40) if (at..at + 6).contains(&x) => State::Empty,
///     (_, 40) => State::Occupied,
///     (_, 20..40) => State::Empty,
///     _ => State::Unknown,
/// });
/// let sought = SoughtGrid::new(&door(20), 16);
/// let found = sought.align(&door(25).into(), 0).unwrap();
/// assert_eq!((found.right, found.up), (5, 0));
/// assert_eq!(sought.align(&door(25).into(), found.agreement), None); // nothing is better than that
/// ```
#[derive(Debug, Clone)]
pub struct SoughtGrid {
    /// Rows with as many unknown ones below and above them.
    occupied: [u64; 3 * CELLS],
    empty: [u64; 3 * CELLS],
    histograms: Sought,
    reach: i32,
    /// Known cells that a translation leaves within the grid, row by row from `up = reach` and `right = reach` downwards.
    kept: Vec<i16>,
}

impl SoughtGrid {
    /// For translations of up to `reach` cells in x and in y, at most 63.
    pub fn new(states: &States, reach: usize) -> Self {
        let reach = reach.min(CELLS - 1) as i32;
        let padded = |plane: &[u64; CELLS]| {
            let mut rows = [0; 3 * CELLS];
            rows[CELLS..2 * CELLS].copy_from_slice(plane);
            rows
        };
        Self {
            occupied: padded(&states.occupied),
            empty: padded(&states.empty),
            histograms: Sought::new(&HistogramPair::of(states)),
            reach,
            kept: kept(states, reach),
        }
    }

    /// The best translation, if it makes more than `least` cells agree. Of several equally good ones, the shortest.
    pub fn align(&self, stored: &StoredGrid, least: u32) -> Option<Alignment> {
        struct Align<'a>(&'a SoughtGrid, &'a StoredGrid, u32);
        impl Kernel for Align<'_> {
            type Output = Option<Alignment>;

            #[inline(always)]
            fn run(self) -> Self::Output {
                align(self.0, self.1, self.2)
            }
        }
        widest(Align(self, stored, least))
    }

    /// No translation makes more cells of `stored` agree than this many.
    pub fn bound(&self, stored: &StoredGrid) -> u32 {
        struct Bound<'a>(&'a SoughtGrid, &'a StoredGrid);
        impl Kernel for Bound<'_> {
            type Output = u32;

            #[inline(always)]
            fn run(self) -> u32 {
                let bounds = bounds(self.0, self.1);
                bounds[greatest(&bounds)] as u32
            }
        }
        widest(Bound(self, stored))
    }

    /// [`hill_climb`] on bit planes: the same ascent, to the same end.
    pub fn hill_climb(&self, stored: &StoredGrid, start: (i32, i32)) -> Alignment {
        struct Climb<'a>(&'a SoughtGrid, &'a StoredGrid, (i32, i32));
        impl Kernel for Climb<'_> {
            type Output = Alignment;

            #[inline(always)]
            fn run(self) -> Alignment {
                let Self(sought, stored, start) = self;
                climb(start, sought.reach, &Planes(&stored.states, sought))
            }
        }
        widest(Climb(self, stored, start))
    }

    /// Translation number `index` of `bounds` and `kept`.
    #[inline(always)]
    fn translation(&self, index: usize) -> (i32, i32) {
        let side = 2 * self.reach + 1;
        (
            self.reach - index as i32 % side,
            self.reach - index as i32 / side,
        )
    }
}

/// Bounded search: climbs from the translation of greatest bound, then looks at whatever else may be better.
#[inline(always)]
fn align(sought: &SoughtGrid, stored: &StoredGrid, least: u32) -> Option<Alignment> {
    let bounds = bounds(sought, stored);
    let first = greatest(&bounds);
    // No grid has more cells than that, so nothing is lost and the sum below can't overflow.
    let least = least.min(ALL as u32);
    if bounds[first] as u32 <= least {
        return None;
    }
    let overlay = Planes(&stored.states, sought);
    let mut best = climb(sought.translation(first), sought.reach, &overlay);
    let mut needed = best.agreement.max(least + 1) as i16;
    for (index, &bound) in bounds.iter().enumerate() {
        if bound >= needed {
            let (right, up) = sought.translation(index);
            let next = overlay.at(right, up);
            if next.beats(&best) {
                best = next;
                needed = needed.max(best.agreement as i16);
            }
        }
    }
    (best.agreement > least).then_some(best)
}

#[inline(always)]
fn greatest(bounds: &[i16]) -> usize {
    let mut most = i16::MIN;
    for &bound in bounds {
        most = if bound > most { bound } else { most };
    }
    bounds.iter().position(|&b| b == most).unwrap_or(0)
}

/// What no translation can exceed, one after the other. With K the known cells, of the stored grid a and of the sought one
/// b moved: agreeing = (O∩O) + (E∩E) + (U∩U), and |U∩U| = 4096 − |K_a| − |K_b| + |K_a∩K_b|. The overlaps are bounded by the
/// histograms; all else is exact.
#[inline(always)]
fn bounds(sought: &SoughtGrid, stored: &StoredGrid) -> Vec<i16> {
    let in_x = overlaps(&stored.histograms.x, &sought.histograms.x);
    let in_y = overlaps(&stored.histograms.y, &sought.histograms.y);
    let side = 2 * sought.reach as usize + 1;
    let from = CELLS - 1 - sought.reach as usize;
    let unknown = (ALL - stored.known) as i16;
    let (agreed_x, known_x) = (&in_x.0[from..from + side], &in_x.1[from..from + side]);
    let mut bounds = vec![0; side * side];
    for k in 0..side {
        let (agreed_y, known_y) = (in_y.0[from + k], in_y.1[from + k]);
        let kept = &sought.kept[k * side..(k + 1) * side];
        let row = &mut bounds[k * side..(k + 1) * side];
        for i in 0..side {
            let agreed = agreed_x[i].min(agreed_y) as i16;
            let known = known_x[i].min(known_y) as i16;
            row[i] = unknown - kept[i] + agreed + known;
        }
    }
    bounds
}

/// For every translation: Σ_j min(O_j, O_j) + min(E_j, E_j), and Σ_j min(K_j, K_j) of the known cells.
#[inline(always)]
fn overlaps(stored: &Histogram, sought: &Padded) -> (Sums, Sums) {
    let (mut agreed, mut known) = ([0; TRANSLATIONS], [0; TRANSLATIONS]);
    for j in 0..CELLS {
        let occupied = &sought.0[0][j..j + TRANSLATIONS];
        let empty = &sought.0[1][j..j + TRANSLATIONS];
        let (o, e) = (stored.counts[0][j], stored.counts[1][j]);
        for t in 0..TRANSLATIONS {
            let both = o.min(occupied[t]) + e.min(empty[t]);
            let either = (o + e).min(occupied[t] + empty[t]);
            agreed[t] += u16::from(both);
            known[t] += u16::from(either);
        }
    }
    (agreed, known)
}

/// Bit planes, overlaid a row at a time.
struct Planes<'a>(&'a States, &'a SoughtGrid);

impl Overlay for Planes<'_> {
    /// As [`agreement`].
    #[inline(always)]
    fn at(&self, right: i32, up: i32) -> Alignment {
        let Self(stored, sought) = self;
        let below = (SIDE - up) as usize;
        let occupied = &sought.occupied[below..below + CELLS];
        let empty = &sought.empty[below..below + CELLS];
        let (to_higher, to_lower) = (right.max(0) as u32, (-right).max(0) as u32);
        let mut differing = 0;
        for y in 0..CELLS {
            let occupied = (occupied[y] << to_higher) >> to_lower;
            let empty = (empty[y] << to_higher) >> to_lower;
            let other = (stored.occupied[y] ^ occupied) | (stored.empty[y] ^ empty);
            differing += u64::from(other.count_ones());
        }
        Alignment {
            right,
            up,
            agreement: ALL as u32 - differing as u32,
        }
    }
}

/// Known cells that each translation leaves within the grid, by their number in all rectangles from the lower left corner.
fn kept(states: &States, reach: i32) -> Vec<i16> {
    let mut corner = vec![[0i16; CELLS + 1]; CELLS + 1];
    for y in 0..CELLS {
        let row = states.occupied[y] | states.empty[y];
        let mut along = 0;
        for x in 0..CELLS {
            along += ((row >> x) & 1) as i16;
            corner[y + 1][x + 1] = corner[y][x + 1] + along;
        }
    }
    // Of the cells from..to, those that a move keeps within 0..64.
    let stays = |by: i32| ((-by).max(0) as usize, (SIDE - by.max(0)) as usize);
    let downwards = || (-reach..=reach).rev();
    downwards()
        .flat_map(|up| downwards().map(move |right| (right, up)))
        .map(|(right, up)| {
            let ((left, end), (below, top)) = (stays(right), stays(up));
            corner[top][end] - corner[top][left] - corner[below][end] + corner[below][left]
        })
        .collect()
}

#[cfg(test)]
mod tests;
