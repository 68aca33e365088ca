//! How much responses say about the true location, whatever their labels are: nothing here depends on a robot.
//!
//! Pairs of location and response fill a [`Contingency`] table; its [`Entropies`] give the uncertainty coefficient
//! U(L|R) of Duckett & Nehmzow (1998), in [0, 1]. Chance raises the plain coefficient of small samples: independent locations and
//! responses, 50 × 16 labels, 100 rows, average U = 0.50. So three more figures go with it: [`corrected_coefficient`] is
//! 0 on average for responses that are independent of the location, [`permutation_p`] says how likely chance reaches the table's value,
//! and [`Interval`] how far another sample of trials may differ. Where a location is a place in the plane, [`Binning`] makes
//! a label of it. [`Responses`] are read from a CSV file of any system's, and a [`Verdict`] says all this of them. Who answers with probabilities is judged by [`PosteriorScore`]; whether one system is better than another,
//! [`PairedT`] says, and [`holm`] whether it still is among many. A
//! [`ClusteredMean`] has an interval over runs or stretches, since trials of one stretch resemble each other, a [`MeanInterval`] one over a few repetitions.
//!
//! Who answers with poses is judged by [`trajectory`] (absolute and relative errors against a reference) and, where estimates
//! before and after correction are known, by [`prediction_correction`].

mod answer_count;
mod auroc;
mod binning;
mod bootstrap;
mod clustered;
mod contingency;
mod correction;
mod holm;
mod judgement;
mod label_notes;
mod mean_interval;
mod paired_t;
mod posterior;
pub mod prediction_correction;
mod responses;
pub mod trajectory;
mod uncertainty;
mod verdict;

pub use answer_count::AnswerCount;
pub use auroc::Auroc;
pub use binning::Binning;
pub use bootstrap::Interval;
pub use clustered::{ClusteredMean, FEW};
pub(crate) use clustered::{intervals, percentiles};
pub use contingency::{Contingency, Counts};
pub use correction::{corrected_coefficient, expected_mutual_information, permutation_p};
pub use holm::holm;
pub use judgement::{Caution, Effort, Judgement};
pub use mean_interval::MeanInterval;
pub use paired_t::PairedT;
pub use posterior::PosteriorScore;
pub use responses::{ColumnNames, Responses};
pub use uncertainty::Entropies;
pub use verdict::{AtDistance, Verdict};
