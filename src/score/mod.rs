//! How much a response tells about the true location, whatever the responses are called: this room knows no robot.
//!
//! Pairs of location and response fill a [`Contingency`] table; its [`Entropies`] give the uncertainty coefficient
//! U(L|R) of Duckett & Nehmzow (1998), in [0, 1]. The plain coefficient flatters small samples: independent locations and
//! responses, 50 × 16 labels, 100 rows, average U = 0.50. So it never stands alone here: [`corrected_coefficient`] is
//! 0 on average for a response that knows nothing, [`permutation_p`] says how likely chance reaches the table's value,
//! and [`Interval`] how far another sample of trials may differ. Where a location is a place in the plane, [`Binning`] makes
//! a label of it. [`Responses`] are read from a CSV file of any system's, and a [`Verdict`] says all this of them. Who answers with probabilities is judged by [`PosteriorScore`]; whether one system is better than another,
//! [`PairedT`] says, and [`holm`] whether it still is among many.

mod binning;
mod bootstrap;
mod contingency;
mod correction;
mod holm;
mod judgement;
mod paired_t;
mod posterior;
mod responses;
mod uncertainty;
mod verdict;

pub use binning::Binning;
pub use bootstrap::Interval;
pub use contingency::{Contingency, Counts};
pub use correction::{corrected_coefficient, expected_mutual_information, permutation_p};
pub use holm::holm;
pub use judgement::{Effort, Judgement};
pub use paired_t::PairedT;
pub use posterior::PosteriorScore;
pub use responses::Responses;
pub use uncertainty::Entropies;
pub use verdict::{AtDistance, Verdict};
