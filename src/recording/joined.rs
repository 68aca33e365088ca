//! Several recordings of the same building as one: more runs to learn from.

use super::{Channel, Columns, Recording};
use crate::{
    error::{Error, Result},
    storage,
};
use ndarray::{Axis, concatenate};

impl Recording {
    /// The runs of several recordings, one recording after the other, in one frame of reference. Runs are counted on, so
    /// none is taken for a part of another. The dataset's checksum becomes that of the parts' checksums.
    ///
    /// # Errors
    /// Where none is given, or their channels differ (but for the maximum, of which the greatest holds), or only some have a
    /// compass or lie along a route; the message names the recording, counted from 1.
    ///
    /// ```
    /// use ballmark::{recording::Recording, seed::Seed, world::corridor};
    /// let config = corridor::CorridorConfig { runs: 2, ..Default::default() };
    /// let (monday, tuesday) = (corridor::thrun1998(Seed(1), &config)?, corridor::thrun1998(Seed(2), &config)?);
    /// let both = Recording::joined(vec![monday.clone(), tuesday])?;
    /// assert_eq!(both.runs().len(), 4);
    /// assert_eq!(both.poses()[0], monday.poses()[0]);
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn joined(recordings: Vec<Recording>) -> Result<Recording> {
        let mut all = recordings.into_iter().map(Recording::into_columns);
        let Some(mut joined) = all.next() else {
            return Err(Error::work("no recording to join; expected at least one"));
        };
        let mut parts = vec![joined.dataset_sha256.clone()];
        for (i, next) in all.enumerate() {
            check(&joined, &next, "the first").map_err(|fault| {
                Error::work(format!(
                    "recording {} of those to be joined: {fault}",
                    i + 2
                ))
            })?;
            parts.push(next.dataset_sha256.clone());
            append(&mut joined, next)?;
        }
        if parts.len() > 1 {
            let parts: Option<Vec<String>> = parts.into_iter().collect();
            joined.dataset_sha256 = parts.map(|parts| storage::sha256(parts.concat().as_bytes()));
            joined.source_sha256 = None;
        }
        Recording::new(joined)
    }
}

/// What keeps a recording from being joined to the first one, which `first_name` stands for.
pub(super) fn check(
    first: &Columns,
    next: &Columns,
    first_name: &str,
) -> std::result::Result<(), String> {
    let kind = |c: &Channel| (c.name.clone(), c.width, c.unit.clone());
    if !first
        .channels
        .iter()
        .map(kind)
        .eq(next.channels.iter().map(kind))
    {
        return Err(format!(
            "channels {}; expected those of {first_name}: {}",
            listed(&next.channels),
            listed(&first.channels)
        ));
    }
    let mut pairs = first.channels.iter().zip(&next.channels);
    if let Some((channel, _)) = pairs.find(|(a, b)| a.bearing_rad != b.bearing_rad) {
        return Err(format!(
            "channel `{}`: its bearings differ from those of {first_name}; expected the same",
            channel.name
        ));
    }
    let mut pairs = first.channels.iter().zip(&next.channels);
    let differ = |(a, b): &(&Channel, &Channel)| {
        (0..a.width).any(|value| a.offset_of(value) != b.offset_of(value))
    };
    if let Some((channel, _)) = pairs.find(differ) {
        return Err(format!(
            "channel `{}`: its `offset_m` differs from that of {first_name}; expected the same",
            channel.name
        ));
    }
    for (what, in_first, in_next) in [
        (
            "a compass",
            first.compass_rad.is_some(),
            next.compass_rad.is_some(),
        ),
        ("a route", first.route_m.is_some(), next.route_m.is_some()),
    ] {
        if in_first != in_next {
            let only = match in_next {
                true => format!("here and not in {first_name}"),
                false => format!("in {first_name} and not here"),
            };
            return Err(format!(
                "{what} {only}; expected it in all recordings or in none"
            ));
        }
    }
    Ok(())
}

fn listed(channels: &[Channel]) -> String {
    let each = channels
        .iter()
        .map(|c| format!("`{}` ({} values in {})", c.name, c.width, c.unit));
    each.collect::<Vec<_>>().join(", ")
}

fn append(joined: &mut Columns, next: Columns) -> Result<()> {
    joined.values = concatenate(Axis(0), &[joined.values.view(), next.values.view()])
        .map_err(|e| Error::work(format!("values to be joined: {e}")))?;
    for (channel, other) in joined.channels.iter_mut().zip(&next.channels) {
        channel.maximum = match (channel.maximum, other.maximum) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
    }
    let greatest = joined.run.iter().max().copied().unwrap_or(0);
    let least = next.run.iter().min().copied().unwrap_or(0);
    let on = |run: &i64| {
        run.wrapping_sub(least)
            .wrapping_add(greatest)
            .wrapping_add(1)
    };
    joined.run.extend(next.run.iter().map(on));
    joined.stamp_s.extend(next.stamp_s);
    joined.pose.extend(next.pose);
    joined.odometry.extend(next.odometry);
    for (mine, theirs) in [
        (&mut joined.compass_rad, next.compass_rad),
        (&mut joined.route_m, next.route_m),
    ] {
        if let (Some(mine), Some(theirs)) = (mine, theirs) {
            mine.extend(theirs);
        }
    }
    let sources = [joined.source.take(), next.source];
    let sources: Vec<String> = sources.into_iter().flatten().collect();
    joined.source = (!sources.is_empty()).then(|| sources.join(", "));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use ndarray::Array2;

    /// Two runs of five snapshots along a route, with a reading that never returned.
    fn recording(shift: f32) -> Recording {
        let laser = Channel {
            name: "laser".into(),
            width: 2,
            unit: "m".into(),
            bearing_rad: Some(vec![0.0, 1.0]),
            maximum: Some(10.0 + f64::from(shift)),
            offset_m: None,
        };
        let pose: Vec<Pose> = (0..10).map(|k| Pose::new(f64::from(k), 0.0, 0.0)).collect();
        let mut values = Array2::from_shape_fn((10, 2), |(k, c)| (k + c) as f32 + shift);
        values[[3, 1]] = f32::NAN;
        Recording::new(Columns {
            channels: vec![laser],
            values,
            stamp_s: (0..10).map(f64::from).collect(),
            odometry: pose.clone(),
            pose,
            run: (0..10).map(|k| k / 5 - 1).collect(),
            route_m: Some((0..10).map(|k| f64::from(k) + f64::from(shift)).collect()),
            ..Columns::default()
        })
        .unwrap()
    }

    #[test]
    fn nothing_is_lost_and_no_run_runs_into_another() {
        let (a, b) = (recording(0.0), recording(0.5));
        let both = Recording::joined(vec![a.clone(), b.clone(), a.clone()]).unwrap();
        assert_eq!(both.len(), 2 * a.len() + b.len());
        assert_eq!(both.runs().len(), 6);
        assert_eq!(both.channels()[0].maximum, Some(10.5));
        assert_eq!(both.snapshot(a.len()).pose, b.snapshot(0).pose);
        assert_eq!(
            both.route_m().unwrap()[a.len() + 3],
            b.route_m().unwrap()[3]
        );
        let alone = Recording::joined(vec![a.clone()]).unwrap();
        let bits = |r: &Recording| r.values().mapv(f32::to_bits); // NaN is not NaN's equal
        assert_eq!(bits(&alone), bits(&a));
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let refused = |change: &dyn Fn(&mut Columns)| {
            let mut columns = recording(0.5).into_columns();
            change(&mut columns);
            let other = Recording::new(columns).unwrap();
            Recording::joined(vec![recording(0.0), other])
                .unwrap_err()
                .to_string()
        };
        let route = refused(&|c| c.route_m = None);
        assert!(
            route.contains("recording 2") && route.contains("a route in the first and not here"),
            "{route}"
        );
        let channel = refused(&|c| c.channels[0].name = "other".into());
        assert!(channel.contains("`other`") && channel.contains("expected those of the first"));
        let bearings = refused(&|c| c.channels[0].bearing_rad = Some(vec![0.0, 1.5]));
        assert!(
            bearings.contains("`laser`: its bearings differ"),
            "{bearings}"
        );
        assert!(Recording::joined(Vec::new()).is_err());
    }
}
