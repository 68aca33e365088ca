//! Where in a TOML text the key stands that a message is about.

use std::ops::Range;
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

/// A value in the text, and where its key begins.
#[derive(Clone, Copy)]
struct Entry<'a> {
    offset: usize,
    value: &'a DeValue<'a>,
}

/// The offset of the key, or else of the table, that a message names; none where the text has neither.
///
/// The table is named first: `[name]` or `[outer.name]`, `[[name]] 2` (from 1) or ``[[name]] `its name` ``, or plain
/// `name:`. Behind it stands the key: `inner.key = …`, `inner.key: …` or a word in backticks.
pub(super) fn offset(text: &str, message: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let root = DeValue::Table(root.into_inner());
    let whole = Entry {
        offset: 0,
        value: &root,
    };
    let (mut scope, mut rest) = (None, message);
    while let Some((table, behind)) = leading_table(scope.unwrap_or(whole), rest) {
        (scope, rest) = (Some(table), behind);
    }
    let within = scope.unwrap_or(whole);
    let mut keys = leading_paths(rest).into_iter().chain(leading_word(rest));
    let key = keys.find_map(|key| {
        let mut path: Vec<&str> = key.split('.').collect();
        loop {
            // The part before the key may be the name of what the table configures, and stand nowhere in the text.
            let found = below(within, &path);
            if found.is_some() || path.len() < 2 || scope.is_none() {
                return found;
            }
            path.remove(0);
        }
    });
    key.or(scope).map(|entry| entry.offset)
}

/// The table that a message begins with, and what follows it.
fn leading_table<'a, 'm>(within: Entry<'a>, message: &'m str) -> Option<(Entry<'a>, &'m str)> {
    let (table, rest) = if let Some(rest) = message.strip_prefix("[[") {
        let (name, rest) = rest.split_once("]]")?;
        let (which, rest) = rest.split_once(':')?;
        let elements = elements(child(within, name)?);
        let which = which.trim().split([',', ' ']).next().unwrap_or("");
        let named = |entry: &&Entry| {
            let name = entry
                .value
                .get("name")
                .and_then(|name| name.get_ref().as_str());
            name == Some(which.trim_matches('`'))
        };
        let element = match which.parse::<usize>() {
            Ok(number) => elements.get(number.checked_sub(1)?),
            Err(_) => elements.iter().find(named),
        };
        (*element?, rest)
    } else if let Some(rest) = message.strip_prefix('[') {
        let (path, rest) = rest.split_once(']')?;
        let table = path.split('.').try_fold(within, child)?;
        (table, rest.trim_start_matches(':'))
    } else {
        let (name, rest) = message.split_once(": ")?;
        let table = child(within, name)?;
        matches!(table.value, DeValue::Table(_)).then_some((table, rest))?
    };
    Some((table, rest.trim_start()))
}

/// The keys of a message that begins `inner.key = …`, `inner.key: …` or `inner.key, inner.other: …`.
fn leading_paths(message: &str) -> Vec<&str> {
    let (keys, _) = message.split_once([':', '=']).unwrap_or_default();
    let is_path = |key: &&str| {
        let of_path = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        !key.is_empty() && key.chars().all(of_path)
    };
    let keys: Vec<&str> = keys.split(',').map(str::trim).collect();
    match keys.iter().all(is_path) {
        true => keys,
        false => Vec::new(),
    }
}

/// The key of a message that begins "`key` …".
fn leading_word(message: &str) -> Option<&str> {
    let (word, _) = message.strip_prefix('`')?.split_once('`')?;
    (!word.is_empty() && !word.contains(' ')).then_some(word)
}

/// The only entry below a table whose path ends so; none where there are several, as the message doesn't say which.
fn below<'a>(table: Entry<'a>, path: &[&str]) -> Option<Entry<'a>> {
    if let Some(direct) = path.iter().try_fold(table, |table, key| child(table, key)) {
        return Some(direct);
    }
    let mut found = children(table).filter_map(|inner| below(inner, path));
    let first = found.next();
    first.filter(|_| found.next().is_none())
}

fn child<'a>(table: Entry<'a>, name: &str) -> Option<Entry<'a>> {
    let DeValue::Table(keys) = table.value else {
        return None;
    };
    let (key, value) = keys
        .iter()
        .find(|(key, _)| key.get_ref().as_ref() == name)?;
    Some(entry(key.span(), value))
}

fn children<'a>(table: Entry<'a>) -> Box<dyn Iterator<Item = Entry<'a>> + 'a> {
    match table.value {
        DeValue::Table(keys) => Box::new(keys.iter().map(|(key, value)| entry(key.span(), value))),
        DeValue::Array(_) => Box::new(elements(table).into_iter()),
        _ => Box::new(std::iter::empty()),
    }
}

fn elements<'a>(array: Entry<'a>) -> Vec<Entry<'a>> {
    match array.value {
        DeValue::Array(values) => values
            .iter()
            .map(|value| entry(value.span(), value))
            .collect(),
        _ => Vec::new(),
    }
}

fn entry<'a>(at: Range<usize>, value: &'a Spanned<DeValue<'a>>) -> Entry<'a> {
    Entry {
        offset: at.start,
        value: value.get_ref(),
    }
}

#[cfg(test)]
mod tests {
    use crate::{error::Error, toml_file::TomlFile};

    const TEXT: &str = "\
seed = 1
[train.descent]
steps = 0
queries = 5

[robot]
speed_m_per_s = -1
[materials.glass]
reflectivity = 7
[[wall]]
points = []
[[wall]]
closed = 3
[[wall.door]]
at_m = 4
[[system]]
name = \"one\"
spacing_m = 1
[[system]]
kind = \"bayes\"
name = \"two\"
spacing_m = 2
map = { k = 0 }
";

    #[track_caller]
    fn line_of(message: &str) -> Option<usize> {
        let located = TomlFile::from_text(TEXT)
            .locate(Error::usage(message))
            .to_string();
        assert!(located.ends_with(message), "{located}");
        let line = located.strip_prefix("line ")?.split(':').next()?;
        line.parse().ok()
    }

    #[test]
    fn keys_are_found_however_a_message_names_them() {
        for (message, line) in [
            ("seed = 1: expected 2", 1),
            ("train.descent.steps = 0: expected at least 1", 3),
            ("descent.steps = 0: expected at least 1", 3),
            ("[train]: descent.steps = 0: expected at least 1", 3),
            ("robot: `speed_m_per_s` is -1; expected more than 0", 7),
            ("[robot]: `speed_m_per_s` is -1; expected more than 0", 7),
            ("[materials.glass]: `reflectivity` is 7; expected 0 to 1", 9),
            ("[[wall]] 2: `closed` is 3", 13),
            ("[[wall]] 2, door 1: `at_m` is 4", 15),
            ("[[system]] `one`: nearest.spacing_m = 1: expected 2", 18),
            ("[[system]] `two`: nearest.spacing_m = 2: expected 2", 22),
            ("[[system]] `two`: map.k = 0: expected 1", 23),
        ] {
            assert_eq!(line_of(message), Some(line), "{message}");
        }
    }

    #[test]
    fn a_key_at_its_default_is_placed_in_its_table_or_nowhere() {
        for (message, line) in [
            ("[robot]: `radius_m` is 0; expected more than 0", Some(6)),
            (
                "[[system]] `two`: bayes.model: none; expected a file",
                Some(19),
            ),
            ("localise.trials = 0: expected 1", None),
            ("nothing is asked of the systems", None),
            (
                "spacing_m = 1: one of two, and the message doesn't say which",
                None,
            ),
        ] {
            assert_eq!(line_of(message), line, "{message}");
        }
    }
}
