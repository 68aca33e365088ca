//! Is a route driven one way only?

use super::{Columns, Recording};

/// Most of the way that may lead back: labels are not exact, and robots swerve.
const MAX_BACK: f64 = 0.1;

impl Recording {
    /// Does the coordinate along the route grow, run by run, on nearly all of the way? A belief along a route knows no
    /// heading and no way round from its end to its beginning, so a route that is driven both ways, or in laps, is for it
    /// none. True where there is no route.
    ///
    /// ```
    /// use ballmark::{seed::Seed, world::corridor};
    /// let config = corridor::CorridorConfig { runs: 1, spacing_m: 2.0 };
    /// let corridor = corridor::thrun1998(Seed(1), &config)?;
    /// assert!(corridor.goes_one_way());
    /// assert!(corridor.in_the_plane().route_m().is_none());
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn goes_one_way(&self) -> bool {
        let Some(route) = self.route_m() else {
            return true;
        };
        let (mut forwards, mut backwards) = (0.0, 0.0);
        for range in self.runs() {
            for pair in route[range].windows(2) {
                match pair[1] - pair[0] {
                    step if step < 0.0 => backwards -= step,
                    step => forwards += step,
                }
            }
        }
        backwards <= MAX_BACK * (forwards + backwards)
    }

    /// The same without its coordinate along a route: its places are poses in the plane.
    pub fn in_the_plane(self) -> Self {
        Self {
            columns: Columns {
                route_m: None,
                ..self.columns
            },
        }
    }
}
