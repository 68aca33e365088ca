//! Which sensor columns form a channel: numbered columns in the spellings that people use, their units and bearings.

use crate::recording::Channel;
use std::collections::{BTreeMap, HashMap};

/// Channels that are in metres where nothing else is said.
const IN_METRES: [&str; 4] = ["laser", "rear_laser", "sonar", "infrared"];
/// Characters of a name that a message quotes.
const SHOWN: usize = 40;

/// How a number stands behind a channel's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Spelling {
    /// `sonar.3`
    Dot,
    /// `sonar[3]`
    Bracket,
    /// `sonar(3)`
    Parenthesis,
    /// `sonar_3`
    Underscore,
    /// `sonar3`, `WAP003`
    Bare,
}

impl Spelling {
    /// Is a number in this spelling nothing but a number? `gas_2` and `co2` may be names of their own.
    fn is_certain(self) -> bool {
        matches!(self, Self::Dot | Self::Bracket | Self::Parenthesis)
    }

    fn column(self, name: &str, number: usize) -> String {
        match self {
            Self::Dot => format!("{name}.{number}"),
            Self::Bracket => format!("{name}[{number}]"),
            Self::Parenthesis => format!("{name}({number})"),
            Self::Underscore => format!("{name}_{number}"),
            Self::Bare => format!("{name}{number}"),
        }
    }
}

/// A sensor column: where it stands, what it is called, and what its name says in brackets.
struct Column<'a> {
    position: usize,
    name: &'a str,
    stated: Stated<'a>,
    numbered: Option<Numbered<'a>>,
}

#[derive(Clone, Copy)]
struct Numbered<'a> {
    stem: &'a str,
    number: usize,
    spelling: Spelling,
    /// Digits, where zeros were put before the number.
    padded: Option<usize>,
}

/// What a name states in brackets: `[mm @ 22.5 + 0.2]` is the unit, the bearing in degrees and the offset in metres.
#[derive(Default, Clone, Copy)]
struct Stated<'a> {
    unit: Option<&'a str>,
    bearing_deg: Option<f64>,
    offset_m: Option<f64>,
}

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

/// Takes a column's name apart: what it states in brackets, and its number.
fn column<'a>(position: usize, whole: &'a str) -> std::result::Result<Column<'a>, String> {
    let bracketed = whole
        .strip_suffix(']')
        .and_then(|name| name.rsplit_once('['));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let (name, stated) = match bracketed {
        Some((name, text)) if !is_number(text.trim()) && !name.is_empty() => {
            let stated = stated(text).ok_or_else(|| {
                format!(
                    "column `{}`: expected NAME[UNIT], NAME[UNIT @ DEGREES] or NAME[UNIT @ DEGREES + METRES]",
                    shown(whole)
                )
            })?;
            (name.trim_end(), stated)
        }
        _ => (whole, Stated::default()),
    };
    Ok(Column {
        position,
        name,
        stated,
        numbered: numbered(name),
    })
}

fn stated(text: &str) -> Option<Stated<'_>> {
    let (unit, direction) = match text.split_once('@') {
        None => (text, None),
        Some((unit, direction)) => (unit, Some(direction)),
    };
    let unit = Some(unit.trim()).filter(|unit| !unit.is_empty());
    let Some(direction) = direction else {
        return Some(Stated {
            unit,
            ..Stated::default()
        });
    };
    let (bearing, offset) = match direction
        .split_once('+')
        .filter(|(b, _)| !b.trim().is_empty())
    {
        None => (direction, None),
        Some((bearing, offset)) => (bearing, Some(offset)),
    };
    let number = |text: &str, units: [&str; 2]| {
        let text = text.trim();
        let bare = units.iter().find_map(|unit| text.strip_suffix(unit));
        let number = bare.unwrap_or(text).trim().parse::<f64>().ok();
        number.filter(|n| n.is_finite())
    };
    Some(Stated {
        unit,
        bearing_deg: Some(number(bearing, ["deg", "°"])?),
        offset_m: match offset {
            None => None,
            Some(offset) => Some(number(offset, ["m", " m"])?),
        },
    })
}

fn numbered(name: &str) -> Option<Numbered<'_>> {
    let closed = |end: char, start: char| {
        let (stem, number) = name.strip_suffix(end)?.rsplit_once(start)?;
        Some((stem, number.trim()))
    };
    let bare = || {
        let digits = name.bytes().rev().take_while(u8::is_ascii_digit).count();
        Some(name.split_at(name.len() - digits)).filter(|_| digits > 0)
    };
    let is_number = |(stem, number): &(&str, &str)| {
        !stem.is_empty() && !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())
    };
    let tried = [
        (name.rsplit_once('.'), Spelling::Dot),
        (closed(']', '['), Spelling::Bracket),
        (closed(')', '('), Spelling::Parenthesis),
        (name.rsplit_once('_'), Spelling::Underscore),
        (bare(), Spelling::Bare),
    ];
    let mut found = tried
        .into_iter()
        .filter_map(|(cut, spelling)| Some((cut.filter(is_number)?, spelling)));
    let ((stem, digits), spelling) = found.next()?;
    Some(Numbered {
        stem,
        number: digits.parse().ok()?,
        spelling,
        padded: (digits.len() > 1 && digits.starts_with('0')).then_some(digits.len()),
    })
}

/// A column's name without what it states in brackets, and without its number: what it may also be called.
pub(super) fn bare_and_stem(whole: &str) -> (&str, Option<&str>) {
    let bare = column(0, whole).map_or(whole, |column| column.name);
    (bare, numbered(bare).map(|n| n.stem))
}

/// A name as messages quote it.
pub(super) fn shown(name: &str) -> String {
    let cut: String = name.chars().take(SHOWN).collect();
    let rest = if cut.len() < name.len() { "…" } else { "" };
    format!("{}{rest}", cut.escape_debug())
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
