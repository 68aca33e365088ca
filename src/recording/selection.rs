//! Which of a log's sensors are taken: columns of a table, or channels and single values of any other log, by name.

use super::Columns;
use ndarray::Axis;

/// Names in an error about a name that isn't there.
const NAMED: usize = 12;

/// Names of sensors to take and to leave out; `*` stands for any letters.
///
/// ```
/// use ballmark::recording::selection::Selection;
/// let wifi = Selection { take: vec!["WAP*".into()], leave: vec!["WAP999".into()] };
/// assert!(wifi.keeps(&["WAP001"]) && !wifi.keeps(&["WAP999"]) && !wifi.keeps(&["FLOOR"]));
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Selection {
    /// Sensors to take; none named: all.
    pub take: Vec<String>,
    /// Sensors to leave out, also of those.
    pub leave: Vec<String>,
}

impl Selection {
    /// Does it leave anything out?
    pub fn is_part(&self) -> bool {
        !(self.take.is_empty() && self.leave.is_empty())
    }

    /// Is a sensor taken that goes by any of these names?
    pub fn keeps(&self, names: &[&str]) -> bool {
        let any = |patterns: &[String]| {
            patterns
                .iter()
                .any(|pattern| names.iter().any(|name| matches(pattern, name)))
        };
        (self.take.is_empty() || any(&self.take)) && !any(&self.leave)
    }

    /// # Errors
    /// The first pattern that no sensor's name matches, in words; `sensors` are the names that each goes by.
    pub fn check<'a>(
        &self,
        sensors: impl Iterator<Item = Vec<&'a str>> + Clone,
    ) -> std::result::Result<(), String> {
        for pattern in self.take.iter().chain(&self.leave) {
            let mut names = sensors.clone().flatten();
            if !names.any(|name| matches(pattern, name)) {
                let known: Vec<String> = sensors
                    .clone()
                    .filter_map(|names| Some(names.first()?.escape_debug().to_string()))
                    .collect();
                let more = match known.len().saturating_sub(NAMED) {
                    0 => String::new(),
                    more => format!(" and {more} more"),
                };
                return Err(format!(
                    "no sensor is called `{}`; there are {}{more}",
                    pattern.escape_debug(),
                    known[..known.len().min(NAMED)].join(", ")
                ));
            }
        }
        Ok(())
    }

    /// Takes channels by `NAME` and single values by `NAME.NUMBER`, counted from 0, out of a log.
    ///
    /// # Errors
    /// As [`check`](Self::check), and where nothing is left.
    pub fn apply(&self, columns: &mut Columns) -> std::result::Result<(), String> {
        if !self.is_part() {
            return Ok(());
        }
        let numbered: Vec<(usize, usize, String)> = columns
            .channels
            .iter()
            .enumerate()
            .flat_map(|(at, channel)| {
                (0..channel.width).map(move |k| (at, k, format!("{}.{k}", channel.name)))
            })
            .collect();
        let names = numbered
            .iter()
            .map(|(at, _, name)| vec![columns.channels[*at].name.as_str(), name.as_str()]);
        self.check(names.clone())?;
        let kept: Vec<bool> = names.map(|names| self.keeps(&names)).collect();
        if !kept.contains(&true) {
            return Err("no sensor is left; expected at least one".into());
        }
        let positions: Vec<usize> = (0..kept.len()).filter(|k| kept[*k]).collect();
        columns.values = columns.values.select(Axis(1), &positions);
        let mut channels = std::mem::take(&mut columns.channels);
        let mut first = 0;
        for channel in &mut channels {
            let kept = &kept[first..first + channel.width];
            first += channel.width;
            let part = |all: &mut Vec<f64>| {
                let mut kept = kept.iter();
                all.retain(|_| kept.next().copied().unwrap_or(false));
            };
            channel.bearing_rad.iter_mut().for_each(part);
            channel.offset_m.iter_mut().for_each(part);
            channel.width = kept.iter().filter(|kept| **kept).count();
        }
        channels.retain(|channel| channel.width > 0);
        columns.channels = channels;
        Ok(())
    }
}

/// Does a name match a pattern in which `*` stands for any letters?
fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let Some(mut rest) = name.strip_prefix(parts.next().unwrap_or_default()) else {
        return false;
    };
    let Some(last) = parts.next_back() else {
        return rest.is_empty();
    };
    for part in parts {
        match rest.find(part) {
            None => return false,
            Some(at) => rest = &rest[at + part.len()..],
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Channel;

    #[test]
    fn a_star_stands_for_any_letters() {
        for (pattern, name, is_match) in [
            ("a", "a", true),
            ("a", "ab", false),
            ("a*", "ab", true),
            ("*b", "ab", true),
            ("a*c*e", "abcde", true),
            ("a*c*e", "abde", false),
            ("a*a", "a", false),
            ("*", "", true),
        ] {
            assert_eq!(matches(pattern, name), is_match, "{pattern} {name}");
        }
    }

    #[test]
    fn single_values_leave_their_bearing_too() {
        let channel = |name: &str, bearings: Option<Vec<f64>>, width| Channel {
            name: name.into(),
            width,
            unit: "m".into(),
            bearing_rad: bearings,
            ..Channel::default()
        };
        let all = Columns {
            channels: vec![
                channel("laser", Some(vec![-1.0, 0.0, 1.0]), 3),
                channel("light", None, 1),
            ],
            values: ndarray::array![[1.0, 2.0, 3.0, 4.0]],
            ..Columns::default()
        };
        let leave = |leave: &str| {
            let mut columns = all.clone();
            let selection = Selection {
                leave: vec![leave.into()],
                ..Selection::default()
            };
            selection.apply(&mut columns).map(|()| columns)
        };
        let part = leave("laser.1").unwrap();
        assert_eq!(part.channels[0].bearing_rad, Some(vec![-1.0, 1.0]));
        assert_eq!(part.values, ndarray::array![[1.0, 3.0, 4.0]]);
        let light = leave("laser").unwrap();
        assert_eq!((light.channels.len(), light.values[[0, 0]]), (1, 4.0));
        assert!(
            leave("sonar")
                .unwrap_err()
                .contains("no sensor is called `sonar`; there are laser, laser")
        );
        assert!(leave("l*").unwrap_err().contains("no sensor is left"));
    }
}
