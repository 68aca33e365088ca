//! Where the robot was: the source of the labels and that of the odometry, out of what a log has.

use super::{
    collector::{Collector, Readings, Stamped, Topic, shown},
    frames::FrameTree,
    message::Kind,
    track::{Lookup, Track, on_the_floor},
};
use crate::geometry::Pose;
use nalgebra::Isometry3;
use std::collections::BTreeMap;

/// Names of a robot's own frame, where its odometry doesn't say it.
const BASES: [&str; 4] = ["base_link", "base_footprint", "base", "base_frame"];

/// Poses over time, and where they come from.
pub(super) struct Source<'a> {
    /// The topic, or the two frames.
    pub name: String,
    /// The topic, where it is one.
    pub topic: Option<&'a str>,
    poses: Poses<'a>,
}

enum Poses<'a> {
    Frames {
        tree: &'a FrameTree,
        above: String,
        base: String,
    },
    Track(Track),
}

impl Source<'_> {
    /// The pose on the floor at a moment.
    pub(super) fn at(&self, stamp_s: f64) -> Lookup<Pose> {
        let pose = match &self.poses {
            Poses::Frames { tree, above, base } => tree
                .pose_in(above, base, stamp_s)
                .unwrap_or(Lookup::Outside),
            Poses::Track(track) => track.at(stamp_s),
        };
        pose.map(|pose| on_the_floor(&pose))
    }

    /// Longest time between two moments without a sample; 0 where frames carry it.
    pub(super) fn longest_silence_s(&self, from_s: f64, to_s: f64) -> f64 {
        match &self.poses {
            Poses::Frames { .. } => 0.0,
            Poses::Track(track) => track.longest_silence_s(from_s, to_s),
        }
    }
}

/// Where a log's poses come from.
pub(super) struct Sources<'a> {
    /// The robot's own frame.
    pub base: String,
    /// In the order in which they are tried; none where the log has no pose but odometry.
    pub labels: Vec<Source<'a>>,
    pub odometry: Option<Source<'a>>,
}

/// The sources of a log. `pose_topic` is the one that the labels are to be taken from, `chosen` the topics to take.
///
/// # Errors
/// Where there is no such topic of poses, in words.
pub(super) fn sources<'a>(
    collector: &'a Collector,
    tree: &'a FrameTree,
    pose_topic: Option<&str>,
    chosen: Option<&[String]>,
) -> Result<Sources<'a>, String> {
    let topics = &collector.topics;
    let wanted = pose_topic.map(|name| named(topics, name)).transpose()?;
    let odometry_topic = odometry_topic(collector, wanted.map(|(name, _)| name), chosen);
    let base = base_frame(odometry_topic.map(|(_, topic)| topic), tree);
    let labels = match wanted {
        Some((name, topic)) => vec![of_topic(name, topic)],
        None => label_sources(collector, tree, &base, odometry_topic.map(|(name, _)| name)),
    };
    let odometry = match odometry_topic {
        Some((name, topic)) => Some(of_topic(name, topic)),
        None => of_odometry_frame(tree, &base),
    };
    Ok(Sources {
        base,
        labels,
        odometry,
    })
}

fn named<'a>(
    topics: &'a BTreeMap<String, Topic>,
    name: &str,
) -> Result<(&'a str, &'a Topic), String> {
    let posed = |topic: &&Topic| matches!(topic.readings, Readings::Poses(_));
    let found = topics.get_key_value(name);
    found
        .filter(|(_, topic)| posed(topic))
        .map(|(name, topic)| (name.as_str(), topic))
        .ok_or_else(|| {
            let there: Vec<String> = topics
                .iter()
                .filter(|(_, topic)| posed(topic))
                .map(|(name, topic)| format!("`{}` ({})", shown(name), topic.type_name))
                .collect();
            let there = match there.is_empty() {
                true => "of which the log has none".to_string(),
                false => there.join(", "),
            };
            format!(
                "no poses on the topic `{}`; expected a topic of PoseStamped, PoseWithCovarianceStamped or Odometry messages: {there}",
                shown(name)
            )
        })
}

fn poses(topic: &Topic) -> &[Stamped<Isometry3<f64>>] {
    match &topic.readings {
        Readings::Poses(poses) => poses,
        _ => &[],
    }
}

fn of_topic<'a>(name: &'a str, topic: &Topic) -> Source<'a> {
    let samples = poses(topic).iter().map(|pose| (pose.stamp_s, pose.value));
    Source {
        name: format!("`{}`", shown(name)),
        topic: Some(name),
        poses: Poses::Track(Track::new(samples.collect())),
    }
}

fn of_frames<'a>(tree: &'a FrameTree, above: &str, base: &str) -> Source<'a> {
    Source {
        name: format!("tf {} → {}", shown(above), shown(base)),
        topic: None,
        poses: Poses::Frames {
            tree,
            above: above.to_string(),
            base: base.to_string(),
        },
    }
}

/// The topic of odometry: not the one of the labels, none that names itself the truth, rather one whose poses lie in an
/// odometry frame; of several the first by name.
fn odometry_topic<'a>(
    collector: &'a Collector,
    label: Option<&str>,
    chosen: Option<&[String]>,
) -> Option<(&'a str, &'a Topic)> {
    let candidates: Vec<(&str, &Topic)> = collector
        .topics
        .iter()
        .map(|(name, topic)| (name.as_str(), topic))
        .filter(|(name, topic)| {
            topic.kind == Some(Kind::Odometry) && !poses(topic).is_empty() && Some(*name) != label
        })
        .collect();
    let is_chosen = |name: &str| chosen.is_some_and(|all| all.iter().any(|t| t == name));
    if let Some(found) = candidates.iter().find(|(name, _)| is_chosen(name)) {
        return Some(*found);
    }
    let drifts = |topic: &Topic| {
        let frame = poses(topic).first().map(|pose| pose.frame);
        frame.is_some_and(|frame| collector.frames[frame].contains("odom"))
    };
    let raw = candidates.iter().filter(|(name, _)| !is_truth(name));
    raw.min_by_key(|(_, topic)| !drifts(topic)).copied()
}

fn is_truth(name: &str) -> bool {
    name.contains("truth")
}

fn base_frame(odometry: Option<&Topic>, tree: &FrameTree) -> String {
    let stated = odometry.and_then(|topic| topic.child.as_deref());
    let usual = BASES.into_iter().find(|frame| tree.has(frame));
    match (stated, usual) {
        (Some(stated), _) if tree.is_empty() || tree.has(stated) => stated.to_string(),
        (_, Some(usual)) => usual.to_string(),
        (stated, None) => match tree.children("odom")[..] {
            [only] => only.to_string(),
            _ => stated.unwrap_or(BASES[0]).to_string(),
        },
    }
}

fn label_sources<'a>(
    collector: &'a Collector,
    tree: &'a FrameTree,
    base: &str,
    odometry: Option<&str>,
) -> Vec<Source<'a>> {
    let mut labels = Vec::new();
    let above = tree.ancestors(base);
    let root = above[above.len() - 1];
    if above.len() > 1 && above.contains(&"map") {
        labels.push(of_frames(tree, "map", base));
    } else if above.len() > 1 && !root.contains("odom") {
        labels.push(of_frames(tree, root, base));
    }
    // Truth by its name, then what a localiser says, then any other pose; of several of a kind the fullest.
    let rank = |name: &str, kind: Option<Kind>| match kind {
        Some(Kind::Odometry) if is_truth(name) && Some(name) != odometry => Some(0),
        Some(Kind::PoseWithCovariance) if !is_wish(name) => Some(1),
        Some(Kind::Pose) if !is_wish(name) => Some(2),
        _ => None,
    };
    let topics = collector.topics.iter().filter_map(|(name, topic)| {
        let n = poses(topic).len();
        let rank = rank(name, topic.kind).filter(|_| n > 0)?;
        Some(((rank, usize::MAX - n), name.as_str(), topic))
    });
    let mut topics: Vec<_> = topics.collect();
    topics.sort_by_key(|(order, name, _)| (*order, *name));
    labels.extend(
        topics
            .into_iter()
            .map(|(_, name, topic)| of_topic(name, topic)),
    );
    labels
}

/// Where somebody wants the robot to be, or thinks it is: no pose that it had.
fn is_wish(topic: &str) -> bool {
    let name = topic.rsplit('/').next().unwrap_or(topic);
    name == "initialpose" || name.contains("goal") || name.contains("target")
}

fn of_odometry_frame<'a>(tree: &'a FrameTree, base: &str) -> Option<Source<'a>> {
    let above = tree.ancestors(base);
    let frame = above.iter().skip(1).find(|frame| frame.contains("odom"))?;
    Some(of_frames(tree, frame, base))
}
