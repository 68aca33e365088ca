//! What the user says about a log that the log doesn't say itself.

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
    /// The topic whose poses are the labels, in logs of ROS, instead of [the usual ones](super::format::ros).
    pub pose_topic: Option<String>,
    /// The sensor topics to take, in logs of ROS, instead of all of them; a topic of odometry among them is the one taken.
    pub topics: Option<Vec<String>>,
}
