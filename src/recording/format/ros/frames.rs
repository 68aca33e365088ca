//! The frames of a robot, and how one lies in another: what tf says.

use super::{
    message::Transform,
    track::{Lookup, Track},
};
use nalgebra::Isometry3;
use std::collections::BTreeMap;

/// Frames above one another that no robot has.
const DEEPEST: usize = 64;
/// Different pairs of frames that are kept.
const PAIRS: usize = 4096;

/// Transforms as they come in.
#[derive(Debug, Default)]
pub(super) struct TransformLog {
    /// By child and parent: what holds always, and what held when.
    pairs: BTreeMap<(String, String), Pair>,
}

#[derive(Debug, Default)]
struct Pair {
    fixed: Option<Isometry3<f64>>,
    moving: Vec<(f64, Isometry3<f64>)>,
}

impl TransformLog {
    /// Notes a transform; `fixed` says that it holds always. False where it can't be kept: one too many.
    pub(super) fn add(&mut self, transform: Transform, fixed: bool) -> bool {
        let key = (transform.child, transform.parent);
        if self.pairs.len() >= PAIRS && !self.pairs.contains_key(&key) {
            return false;
        }
        let pair = self.pairs.entry(key).or_default();
        if fixed {
            pair.fixed = Some(transform.parent_from_child);
        } else {
            pair.moving
                .push((transform.stamp_s, transform.parent_from_child));
        }
        true
    }

    /// The tree that they make, and what is odd about it.
    pub(super) fn into_tree(self) -> (FrameTree, Vec<String>) {
        let mut tree = FrameTree::default();
        let mut oddities = Vec::new();
        let mut weights: BTreeMap<String, usize> = BTreeMap::new();
        for ((child, parent), pair) in self.pairs {
            let weight = pair.moving.len() + usize::from(pair.fixed.is_some());
            if let Some(other) = weights.get(&child) {
                oddities.push(format!(
                    "frame `{child}` with two parents, the one of more transforms is used"
                ));
                if weight <= *other {
                    continue;
                }
            }
            weights.insert(child.clone(), weight);
            let link = match pair.fixed {
                Some(fixed) if pair.moving.is_empty() => Link::Fixed(fixed),
                _ => Link::Moving(Track::new(pair.moving)),
            };
            tree.links.insert(child, (parent, link));
        }
        (tree, oddities)
    }
}

/// Each frame with its parent.
#[derive(Debug, Default)]
pub(super) struct FrameTree {
    links: BTreeMap<String, (String, Link)>,
}

#[derive(Debug)]
enum Link {
    Fixed(Isometry3<f64>),
    Moving(Track),
}

impl FrameTree {
    pub(super) fn is_empty(&self) -> bool {
        self.links.is_empty()
    }

    /// Is it a frame here?
    pub(super) fn has(&self, frame: &str) -> bool {
        self.links.contains_key(frame) || self.links.values().any(|(parent, _)| parent == frame)
    }

    /// The frames whose parent this one is, in the order of their names.
    pub(super) fn children(&self, frame: &str) -> Vec<&str> {
        let links = self.links.iter();
        let children = links.filter(|(_, (parent, _))| parent == frame);
        children.map(|(child, _)| child.as_str()).collect()
    }

    /// A frame and those above it, up to the root. A ring ends where it closes.
    pub(super) fn ancestors<'a>(&'a self, frame: &'a str) -> Vec<&'a str> {
        let mut chain = vec![frame];
        while let Some((parent, _)) = self.links.get(chain[chain.len() - 1]) {
            if chain.contains(&parent.as_str()) || chain.len() >= DEEPEST {
                break;
            }
            chain.push(parent);
        }
        chain
    }

    /// The pose of a frame in one above it at a moment; `None` where it isn't below it.
    pub(super) fn pose_in(
        &self,
        above: &str,
        frame: &str,
        stamp_s: f64,
    ) -> Option<Lookup<Isometry3<f64>>> {
        self.chained(above, frame, |link| match link {
            Link::Fixed(pose) => Lookup::Found(*pose),
            Link::Moving(track) => track.at(stamp_s),
        })
    }

    /// How a sensor's frame lies in the robot's: by what was said nearest to a moment. `None` where nothing connects them.
    pub(super) fn mounting(
        &self,
        base: &str,
        sensor: &str,
        stamp_s: f64,
    ) -> Option<Isometry3<f64>> {
        let above_base = self.ancestors(base);
        let shared = self
            .ancestors(sensor)
            .into_iter()
            .find(|frame| above_base.contains(frame))?;
        let nearest = |frame: &str| {
            let pose = self.chained(shared, frame, |link| match link {
                Link::Fixed(pose) => Lookup::Found(*pose),
                Link::Moving(track) => track
                    .nearest(stamp_s)
                    .map_or(Lookup::Outside, Lookup::Found),
            });
            pose.and_then(Lookup::found)
        };
        Some(nearest(base)?.inverse() * nearest(sensor)?)
    }

    fn chained(
        &self,
        above: &str,
        frame: &str,
        pose: impl Fn(&Link) -> Lookup<Isometry3<f64>>,
    ) -> Option<Lookup<Isometry3<f64>>> {
        let chain = self.ancestors(frame);
        let end = chain.iter().position(|name| *name == above)?;
        let mut sum = Lookup::Found(Isometry3::identity());
        for name in &chain[..end] {
            let (_, link) = self.links.get(*name)?;
            sum = pose(link).and(sum).map(|(upper, lower)| upper * lower);
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::format::ros::track::on_the_floor;

    fn transform(parent: &str, child: &str, stamp_s: f64, x_m: f64) -> Transform {
        Transform {
            stamp_s,
            parent: parent.into(),
            child: child.into(),
            parent_from_child: Isometry3::translation(x_m, 0.0, 0.0),
        }
    }

    #[test]
    fn transforms_add_up_from_frame_to_frame() {
        let mut log = TransformLog::default();
        for stamp_s in [0.0, 1.0] {
            assert!(log.add(transform("map", "odom", stamp_s, 10.0), false));
            log.add(transform("odom", "base", stamp_s, stamp_s), false);
        }
        log.add(transform("base", "mast", 0.0, 0.3), true);
        log.add(transform("mast", "laser", 0.0, 0.2), true);
        let (tree, oddities) = log.into_tree();
        assert!(oddities.is_empty());
        assert_eq!(
            tree.ancestors("laser"),
            ["laser", "mast", "base", "odom", "map"]
        );
        let pose = tree.pose_in("map", "base", 0.25).unwrap().found().unwrap();
        assert!((on_the_floor(&pose).x_m - 10.25).abs() < 1e-12);
        let mounting = tree.mounting("base", "laser", 7.0).unwrap();
        assert!((mounting.translation.x - 0.5).abs() < 1e-12);
        assert_eq!(tree.pose_in("map", "base", 9.0), Some(Lookup::Outside));
        assert_eq!(tree.pose_in("base", "map", 0.0), None);
        assert!(tree.mounting("base", "elsewhere", 0.0).is_none());
    }

    #[test]
    fn rings_and_second_parents_end_nowhere() {
        let mut log = TransformLog::default();
        log.add(transform("a", "b", 0.0, 1.0), false);
        log.add(transform("b", "a", 0.0, 1.0), false);
        log.add(transform("c", "b", 0.0, 1.0), false);
        log.add(transform("c", "b", 1.0, 1.0), false);
        let (tree, oddities) = log.into_tree();
        assert_eq!(oddities.len(), 1);
        assert_eq!(tree.ancestors("a"), ["a", "b", "c"]);
        let mut log = TransformLog::default();
        log.add(transform("a", "b", 0.0, 1.0), false);
        log.add(transform("b", "a", 0.0, 1.0), false);
        assert_eq!(log.into_tree().0.ancestors("a"), ["a", "b"]);
    }
}
