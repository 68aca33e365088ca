//! What the user says about a log that the log doesn't say itself.

use super::{bearings::Bearings, selection::Selection};

/// A step longer than this that odometry knows nothing of is a gap in a log, in metres.
pub const GAP_M: f64 = 5.0;

/// How a log of any format is taken. By default as it says itself.
///
/// ```
/// use ballmark::recording::{format::Format, log_options::LogOptions};
/// let log = b"time_s,x_m,y_m,heading_rad,sonar\n0,0,0,0,3.5\n1,0,0,0,9.5\n";
/// let options = LogOptions { max_range_m: Some(5.0), ..LogOptions::default() };
/// let read = Format::named("csv")?.read("walk.csv".as_ref(), log, &options)?;
/// assert!(read.recording.values()[[1, 0]].is_nan());
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct LogOptions {
    /// Reading in metres from which on there was no return, instead of the log's own, for all channels in metres.
    pub max_range_m: Option<f64>,
    /// Sensors to take: columns of a table by their name in its header, channels of other logs.
    pub sensors: Selection,
    /// Units by channel, in place of those that the log states; lengths come out in metres.
    pub units: Vec<(String, String)>,
    /// Bearings by channel.
    pub bearings: Vec<(String, Bearings)>,
    /// How far from the robot's middle the sensors of a channel sit, in metres along their bearings.
    pub offsets_m: Vec<(String, f64)>,
    /// A new run begins where the robot is farther than this from where it was a snapshot before, and odometry doesn't say
    /// so, in metres; none: [`GAP_M`].
    pub gap_m: Option<f64>,
    /// Poses will come from [elsewhere](super::posed): a log without any is taken all the same, its snapshots at the origin.
    pub poses_elsewhere: bool,
    /// The topic whose poses are the labels, in logs of ROS, instead of [the usual ones](super::format::ros).
    pub pose_topic: Option<String>,
    /// The sensor topics to take, in logs of ROS, instead of all of them; a topic of odometry among them is the one taken.
    pub topics: Option<Vec<String>>,
}

impl LogOptions {
    /// Where runs part, in metres.
    pub(super) fn gap_or_usual_m(&self) -> f64 {
        self.gap_m.unwrap_or(GAP_M)
    }
}
