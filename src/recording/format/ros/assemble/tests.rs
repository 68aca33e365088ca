use super::*;
use crate::recording::format::ros::{
    collector::Stamped,
    message::{Kind, Range, Scan, Transform},
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

fn stamped<T>(stamp_s: f64, frame: usize, value: T) -> Stamped<T> {
    Stamped {
        stamp_s,
        logged_s: stamp_s + 100.0,
        frame,
        value,
    }
}

fn at(x_m: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x_m, 0.0, 0.0), UnitQuaternion::identity())
}

fn scan(ranges: &[f32]) -> Scan {
    Scan {
        first_rad: -0.5,
        step_rad: 0.5,
        nearest_m: 0.1,
        farthest_m: 8.0,
        ranges: ranges.to_vec(),
    }
}

/// A log of some topics; frame 0 is the robot's.
struct Log(Collector<'static>);

impl Log {
    fn new() -> Self {
        let mut collector = Collector::new(None);
        collector.frames = vec!["base_link".into(), "odom".into(), "map".into()];
        Log(collector)
    }

    fn topic(mut self, name: &str, type_name: &str, readings: Readings) -> Self {
        let topic = Topic {
            type_name: type_name.into(),
            kind: Kind::named(type_name),
            readings,
            child: None,
        };
        self.0.topics.insert(name.into(), topic);
        self
    }

    /// Scans of three beams at some times.
    fn scans(self, name: &str, stamps_s: &[f64]) -> Self {
        let scans = stamps_s
            .iter()
            .map(|s| stamped(*s, 0, scan(&[1.0, *s as f32, 9.0])));
        let readings = Readings::Scans(scans.collect());
        self.topic(name, "sensor_msgs/LaserScan", readings)
    }

    fn poses(self, name: &str, type_name: &str, frame: usize, poses: &[(f64, f64)]) -> Self {
        let poses = poses.iter().map(|(s, x_m)| stamped(*s, frame, at(*x_m)));
        self.topic(name, type_name, Readings::Poses(poses.collect()))
    }

    fn odometry(self, poses: &[(f64, f64)]) -> Self {
        self.poses("/odom", "nav_msgs/Odometry", 1, poses)
    }

    fn located(self, name: &str, poses: &[(f64, f64)]) -> Self {
        self.poses(name, "geometry_msgs/PoseStamped", 2, poses)
    }

    fn transforms(mut self, parent: &str, child: &str, poses: &[(f64, f64)]) -> Self {
        for (stamp_s, x_m) in poses {
            let transform = Transform {
                stamp_s: *stamp_s,
                parent: parent.into(),
                child: child.into(),
                parent_from_child: at(*x_m),
            };
            self.0.transforms.add(transform, false);
        }
        self
    }

    fn read(self) -> ImportedLog {
        assemble(self.0, &LogOptions::default()).unwrap()
    }
}

fn x_m(poses: &[Pose]) -> Vec<f64> {
    poses.iter().map(|p| (p.x_m * 1e6).round() / 1e6).collect()
}

const DRIVE: [(f64, f64); 4] = [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (3.0, 3.0)];

#[test]
fn odometry_alone_is_taken_with_a_warning() {
    let log = Log::new()
        .scans("/scan", &[0.5, 1.5])
        .odometry(&DRIVE)
        .read();
    assert_eq!(x_m(log.recording.poses()), [0.5, 1.5]);
    assert_eq!(log.odometry, OdometrySource::Poses);
    let mut warnings = log.account.warning_counts().keys();
    assert!(warnings.any(|w| w.contains("only poses are odometry (`/odom`)")));
    // So it is where tf has nothing but an odometry frame.
    let log = Log::new()
        .scans("/scan", &[0.5])
        .transforms("odom", "base_link", &DRIVE)
        .read();
    assert_eq!(
        (x_m(log.recording.poses()), log.odometry),
        (vec![0.5], OdometrySource::Poses)
    );
    let none = assemble(Log::new().scans("/scan", &[0.5]).0, &LogOptions::default());
    let fault = none.unwrap_err();
    assert!(
        fault.contains("no source of poses") && fault.contains("tf map → base_link"),
        "{fault}"
    );
}

#[test]
fn the_map_of_tf_comes_before_a_topic_and_a_goal_is_no_pose() {
    let log = || {
        Log::new()
            .scans("/scan", &[0.5, 1.5])
            .odometry(&DRIVE)
            .located("/move_base_simple/goal", &[(0.0, 50.0), (3.0, 50.0)])
            .located(
                "/tracker",
                &[(0.0, 20.0), (3.0, 23.0), (0.5, 20.5), (1.5, 21.5)],
            )
    };
    assert_eq!(x_m(log().read().recording.poses()), [20.5, 21.5]);
    let with_tf = log()
        .transforms("map", "odom", &[(0.0, 10.0), (1.0, 10.0), (2.0, 10.0)])
        .transforms("odom", "base_link", &DRIVE);
    let read = with_tf.read();
    assert_eq!(x_m(read.recording.poses()), [10.5, 11.5]);
    assert_eq!(x_m(&read.recording.columns().odometry), [0.5, 1.5]);
    assert_eq!(read.odometry, OdometrySource::Interpolated);
    assert_eq!(
        read.account.passed_over_counts()["geometry_msgs/PoseStamped"],
        6
    );
    // A tf that ends before the drive begins leaves it to the topic.
    let stale = log().transforms("map", "base_link", &[(-9.0, 0.0), (-8.0, 0.0)]);
    assert_eq!(x_m(stale.read().recording.poses()), [20.5, 21.5]);
    let options = LogOptions {
        pose_topic: Some("/elsewhere".into()),
        ..LogOptions::default()
    };
    let fault = assemble(log().0, &options).unwrap_err();
    assert!(
        fault.contains("`/elsewhere`") && fault.contains("`/tracker`"),
        "{fault}"
    );
}

#[test]
fn a_hole_in_the_poses_is_a_loss_and_their_ends_a_warning() {
    let poses = [(0.0, 0.0), (1.0, 1.0), (5.0, 5.0), (6.0, 6.0)];
    let log = Log::new()
        .scans("/scan", &[-2.0, 0.5, 3.0, 5.5, 6.4, 8.0])
        .located("/tracker", &poses)
        .read();
    assert_eq!(x_m(log.recording.poses()), [0.5, 5.5, 6.0]);
    assert_eq!(log.account.lost_count(), 1);
    assert!(
        log.account.lost_records()[0].contains("stamped 3.000"),
        "{:?}",
        log.account
    );
    let outside = &log.account.warning_counts()["`/scan` outside of the poses' time, passed over"];
    assert_eq!(
        (*outside, log.account.used_counts()["sensor_msgs/LaserScan"]),
        (2, 3)
    );
}

#[test]
fn other_sensors_join_by_time_and_scans_of_another_width_are_lost() {
    let range = |infrared, range| Range {
        infrared,
        nearest_m: 0.1,
        farthest_m: 4.0,
        range,
    };
    let ranges = |infrared, all: &[(f64, f32)]| {
        let readings = all.iter().map(|(s, r)| stamped(*s, 0, range(infrared, *r)));
        Readings::Ranges(readings.collect())
    };
    let mut log = Log::new()
        .scans("/scan", &[0.5, 1.0, 1.5, 3.0])
        .scans("/back/scan", &[0.6, 1.4])
        .odometry(&DRIVE)
        .topic(
            "/b",
            "sensor_msgs/Range",
            ranges(false, &[(0.4, 2.0), (3.0, 5.0)]),
        )
        .topic(
            "/a",
            "sensor_msgs/Range",
            ranges(false, &[(0.4, 1.0), (3.0, 1.5)]),
        )
        .topic("/c", "sensor_msgs/Range", ranges(true, &[(0.4, 0.05)]));
    if let Some(Topic {
        readings: Readings::Scans(scans),
        ..
    }) = log.0.topics.get_mut("/scan")
    {
        scans[1].value.ranges.push(1.0);
    }
    let log = log.read();
    let c = log.recording.columns();
    let channels: Vec<_> = c
        .channels
        .iter()
        .map(|c| (c.name.as_str(), c.width))
        .collect();
    // `/back/scan` is the first by name, so it leads.
    assert_eq!(
        channels,
        [("laser", 3), ("scan", 3), ("sonar", 2), ("infrared", 1)]
    );
    assert_eq!(c.stamp_s, [0.6, 1.4]);
    let seen =
        |k: usize| -> Vec<String> { c.values.row(k).iter().map(|v| v.to_string()).collect() };
    assert_eq!(
        seen(0),
        ["1", "0.6", "NaN", "1", "0.5", "NaN", "1", "2", "NaN"]
    );
    assert_eq!(
        seen(1),
        ["1", "1.4", "NaN", "1", "1.5", "NaN", "NaN", "NaN", "NaN"]
    );
    assert_eq!(log.account.lost_count(), 1);
    assert!(log.account.lost_records()[0].contains("4 readings; expected 3"));
    assert_eq!(
        log.account.warning_counts()["snapshot without readings of `sonar`"],
        1
    );
    assert_eq!(c.channels[2].bearing_rad, Some(vec![0.0, 0.0]));
}

#[test]
fn clocks_are_put_in_order_and_named() {
    let log = Log::new()
        .scans("/scan", &[1.5, 0.5, 0.5])
        .odometry(&DRIVE)
        .read();
    assert_eq!(log.recording.columns().stamp_s, [0.5, 0.5, 1.5]);
    let warnings = log.account.warning_counts();
    assert_eq!(warnings["/scan stamped before the one ahead of it"], 1);
    assert_eq!(warnings["/scan stamped like the one ahead of it"], 1);
    // Stamps that nobody set: the time of logging, here 100 s later, is what is left.
    let log = Log::new()
        .scans("/scan", &[0.0, 0.0])
        .odometry(&[(99.6, 0.0), (100.4, 1.0)])
        .read();
    assert_eq!(log.recording.columns().stamp_s, [100.0, 100.0]);
}

#[test]
fn jumps_and_long_silences_begin_new_runs() {
    let jump = [(0.0, 0.0), (1.0, 0.0), (1.1, 30.0), (3.0, 30.0)];
    let log = Log::new()
        .scans("/scan", &[0.5, 1.0, 1.1, 1.5])
        .located("/tracker", &jump)
        .odometry(&DRIVE)
        .read();
    assert_eq!(log.recording.columns().run, [0, 0, 1, 1]);
    // Who stands still for a minute without odometry may have been carried there.
    let still = [(0.0, 0.0), (1.0, 0.0), (60.0, 0.0), (61.0, 0.0)];
    let log = Log::new()
        .scans("/scan", &[0.5, 60.5])
        .odometry(&still)
        .read();
    assert_eq!(log.recording.columns().run, [0, 1]);
    let through: Vec<(f64, f64)> = (0..=61)
        .map(|k| (f64::from(k), f64::from(k) / 30.0))
        .collect();
    let log = Log::new()
        .scans("/scan", &[0.5, 60.5])
        .odometry(&through)
        .read();
    assert_eq!(log.recording.columns().run, [0, 0]);
}

#[test]
fn the_user_decides_on_maxima_and_topics() {
    let ranges = |options: &LogOptions| {
        let log = Log::new().scans("/scan", &[0.5, 2.5]).odometry(&DRIVE);
        assemble(log.0, options).unwrap().recording
    };
    let near = ranges(&LogOptions {
        max_range_m: Some(2.0),
        ..LogOptions::default()
    });
    assert_eq!(near.channels()[0].maximum, Some(2.0));
    assert!(near.values()[[1, 1]].is_nan() && near.values()[[0, 1]] == 0.5);
    let far = ranges(&LogOptions {
        max_range_m: Some(20.0),
        ..LogOptions::default()
    });
    assert_eq!(far.values()[[0, 2]], 9.0, "beyond what the messages state");
}
