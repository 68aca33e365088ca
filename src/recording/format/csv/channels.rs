//! Which sensor columns form a channel, with its unit and bearings.

use super::column_name::{Column, Spelling, Stated, column, shown};
use crate::recording::Channel;
use std::collections::{BTreeMap, HashMap};

/// Channels that are in metres where nothing else is said.
const IN_METRES: [&str; 4] = ["laser", "rear_laser", "sonar", "infrared"];

/// A channel in the making.
struct Group<'a> {
    name: &'a str,
    spelling: Option<Spelling>,
    columns: Vec<(usize, &'a Column<'a>)>,
}

/// The channels of a table, and where their values stand.
pub(super) struct Channels {
    pub channels: Vec<Channel>,
    /// Columns of the channels' values, side by side.
    pub values: Vec<usize>,
    /// What to know about how columns were taken.
    pub notes: Vec<String>,
}

/// The channels that sensor columns form, in the order of their first columns. `is_part` says that columns were left out on
/// purpose, so that numbers may be missing.
pub(super) fn channels(
    sensors: &[(usize, &str)],
    is_part: bool,
) -> std::result::Result<Channels, String> {
    let columns = sensors
        .iter()
        .map(|(position, name)| column(*position, name));
    let columns: Vec<Column> = columns.collect::<std::result::Result<_, _>>()?;
    let loose = taken_together(&columns);
    let mut groups: Vec<Group> = Vec::new();
    let mut found: HashMap<(&str, Option<Spelling>), usize> = HashMap::new();
    for column in &columns {
        let numbered = column
            .numbered
            .filter(|n| n.spelling.is_certain() || loose.contains_key(&(n.stem, n.spelling)));
        let (name, spelling, number) = match numbered {
            Some(n) => (n.stem, Some(n.spelling), n.number),
            None => (column.name, None, 0),
        };
        let at = *found.entry((name, spelling)).or_insert_with(|| {
            groups.push(Group {
                name,
                spelling,
                columns: Vec::new(),
            });
            groups.len() - 1
        });
        groups[at].columns.push((number, column));
    }
    let mut all = Channels {
        channels: Vec::new(),
        values: Vec::new(),
        notes: Vec::new(),
    };
    for mut group in groups {
        group.columns.sort_by_key(|(number, _)| *number);
        if let Some(spelling) = group.spelling {
            if let Some(fault) = numbers_at_fault(&group, spelling, is_part) {
                return Err(fault);
            }
            let (first, last) = (
                group.columns[0].1.name,
                group.columns[group.columns.len() - 1].1.name,
            );
            let gaps = loose.get(&(group.name, spelling)).copied().unwrap_or(false);
            if spelling == Spelling::Bare || gaps {
                let left_out = if gaps {
                    ", with numbers left out between them"
                } else {
                    ""
                };
                all.notes.push(format!(
                    "columns {} to {} are taken for one channel `{}` of {} values{left_out}",
                    shown(first),
                    shown(last),
                    shown(group.name),
                    group.columns.len()
                ));
            }
        }
        all.values
            .extend(group.columns.iter().map(|(_, column)| column.position));
        all.channels.push(channel(&group)?);
    }
    Ok(all)
}

/// Stems whose loosely numbered columns are one channel, and whether numbers are left out: where they count from 0 or 1 without
/// a gap, or zeros were put before them.
fn taken_together<'a>(columns: &[Column<'a>]) -> HashMap<(&'a str, Spelling), bool> {
    let mut stems: HashMap<(&str, Spelling), Vec<&Column>> = HashMap::new();
    for column in columns {
        if let Some(n) = column.numbered.filter(|n| !n.spelling.is_certain()) {
            stems.entry((n.stem, n.spelling)).or_default().push(column);
        }
    }
    let together = stems.into_iter().filter_map(|(key, members)| {
        let numbers: BTreeMap<usize, usize> = members
            .iter()
            .filter_map(|c| Some((c.numbered?.number, c.numbered?.padded.unwrap_or(0))))
            .collect();
        let same_unit = members
            .iter()
            .all(|c| c.stated.unit == members[0].stated.unit);
        let (first, last) = (*numbers.keys().next()?, *numbers.keys().next_back()?);
        let gaps = first > 1 || last - first + 1 != numbers.len();
        let padded = numbers.values().any(|digits| *digits > 0);
        // `s_0` alone says by its number that it is the first of a channel of one.
        let enough = members.len() > 1 || key.1 == Spelling::Underscore && first == 0;
        let whole = numbers.len() == members.len() && same_unit && enough;
        (whole && (!gaps || padded)).then_some((key, gaps))
    });
    together.collect()
}

/// What is wrong with the numbers of a channel's columns.
fn numbers_at_fault(group: &Group, spelling: Spelling, is_part: bool) -> Option<String> {
    if !spelling.is_certain() {
        return None;
    }
    let start = group.columns[0].0.min(1);
    let expected = (start..).zip(&group.columns);
    let (expected, _) = expected
        .clone()
        .zip(&group.columns)
        .map(|((expected, _), (number, _))| (expected, *number))
        .find(|(expected, number)| expected != number)?;
    let repeated = group.columns.windows(2).any(|pair| pair[0].0 == pair[1].0);
    (repeated || !is_part).then(|| {
        format!(
            "columns of channel `{}` leave out or repeat `{}`; expected each number once, from 0 or 1 on",
            shown(group.name),
            shown(&spelling.column(group.name, expected)),
        )
    })
}

fn channel(group: &Group) -> std::result::Result<Channel, String> {
    let stated = |of: fn(&Stated) -> Option<f64>| -> Option<Vec<f64>> {
        let numbers = group.columns.iter().map(|(_, column)| of(&column.stated));
        numbers.collect()
    };
    let some = group
        .columns
        .iter()
        .any(|(_, c)| c.stated.bearing_deg.is_some());
    let bearing_deg = stated(|s| s.bearing_deg);
    if some && bearing_deg.is_none() {
        return Err(format!(
            "some columns of channel `{}` state a bearing; expected all or none",
            shown(group.name)
        ));
    }
    let offset_m = group
        .columns
        .iter()
        .map(|(_, c)| c.stated.offset_m.unwrap_or(0.0));
    let offset_m: Vec<f64> = offset_m.collect();
    let metres = IN_METRES.contains(&group.name) || group.name.ends_with("_m");
    let unit = group.columns.iter().find_map(|(_, c)| c.stated.unit);
    Ok(Channel {
        name: group.name.to_string(),
        width: group.columns.len(),
        unit: unit
            .unwrap_or(if metres { "m" } else { "as recorded" })
            .to_string(),
        bearing_rad: bearing_deg.map(|all| all.iter().map(|deg| deg.to_radians()).collect()),
        maximum: None,
        offset_m: offset_m.iter().any(|m| *m != 0.0).then_some(offset_m),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[&str]) -> std::result::Result<Channels, String> {
        let sensors: Vec<(usize, &str)> = names.iter().copied().enumerate().collect();
        channels(&sensors, false)
    }

    fn shapes(names: &[&str]) -> Vec<(String, usize)> {
        let found = named(names).unwrap();
        let shapes = found.channels.into_iter().map(|c| (c.name, c.width));
        shapes.collect()
    }

    #[test]
    fn numbers_in_every_usual_spelling_make_one_channel() {
        for names in [
            ["s.0", "s.1", "s.2"],
            ["s.1", "s.2", "s.3"],
            ["s_0", "s_1", "s_2"],
            ["s_1", "s_2", "s_3"],
            ["s[0]", "s[1]", "s[2]"],
            ["s(1)", "s(2)", "s(3)"],
            ["s0", "s1", "s2"],
            ["s001", "s002", "s003"],
            ["s27", "s028", "s100"],
            ["s[0][mm]", "s[1][mm]", "s[2][mm]"],
        ] {
            assert_eq!(shapes(&names), [("s".to_string(), 3)], "{names:?}");
        }
        let order = named(&["s10", "s9", "s8", "s7", "s6", "s5", "s4", "s3", "s2", "s1"]).unwrap();
        assert_eq!(order.values, [9, 8, 7, 6, 5, 4, 3, 2, 1, 0]);
    }

    #[test]
    fn numbers_that_may_be_names_are_left_alone() {
        let one = |name: &str| (name.to_string(), 1);
        assert_eq!(
            shapes(&["gas_2", "co2", "pm10", "pm25"]),
            ["gas_2", "co2", "pm10", "pm25"].map(one)
        );
        assert_eq!(shapes(&["t_1[C]", "t_2[F]"]), ["t_1", "t_2"].map(one));
        assert_eq!(shapes(&["s_0"]), [one("s")]);
    }

    #[test]
    fn bearings_and_offsets_may_stand_in_the_header() {
        let found = named(&[
            "sonar.0[mm @ 0 + 0.2m]",
            "sonar.1[mm@-22.5deg + 0.2]",
            "light[lux]",
        ])
        .unwrap();
        let sonar = &found.channels[0];
        assert_eq!((sonar.name.as_str(), sonar.unit.as_str()), ("sonar", "mm"));
        assert_eq!(sonar.bearing_rad, Some(vec![0.0, -22.5_f64.to_radians()]));
        assert_eq!(sonar.offset_m, Some(vec![0.2, 0.2]));
        assert_eq!(found.channels[1].unit, "lux");
        let none = named(&["s.0[@90]", "s.1[@-90]"]).unwrap();
        assert_eq!(
            (
                none.channels[0].unit.as_str(),
                none.channels[0].offset_m.is_none()
            ),
            ("as recorded", true)
        );
    }

    #[test]
    fn wrong_names_are_refused() {
        for (names, part) in [
            (vec!["a.0", "a.2"], "repeat `a.1`"),
            (vec!["a[1]", "a[1]"], "repeat `a[2]`"),
            (vec!["a.2"], "repeat `a.1`"),
            (vec!["a.0[m@x]"], "NAME[UNIT @ DEGREES]"),
            (vec!["a.0[m@1]", "a.1[m]"], "all or none"),
        ] {
            let fault = named(&names).err().unwrap();
            assert!(fault.contains(part), "{fault}");
        }
        let sensors = [(0, "a.0"), (1, "a.2")];
        assert_eq!(channels(&sensors, true).unwrap().channels[0].width, 2);
    }

    #[test]
    fn many_names_take_no_longer_than_their_number() {
        let names: Vec<String> = (0..100_000).map(|k| format!("column{k}x")).collect();
        let sensors: Vec<(usize, &str)> = names.iter().map(String::as_str).enumerate().collect();
        assert_eq!(channels(&sensors, false).unwrap().channels.len(), 100_000);
    }
}
