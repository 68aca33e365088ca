//! A key of a configuration by its path: `train.descent.steps`, or `system.ball.spacing_m` in a list of tables.

use toml::{Table, Value};

/// Sets the value at a dotted path, over what stands there. Tables that are missing are made; of a list of tables, the next word of the
/// path says which: its `name`, or its `kind` where it has none, or its number from 1.
///
/// # Errors
/// In words, where a word of the path leads nowhere.
pub(super) fn set(table: &mut Table, path: &str, value: Value) -> Result<(), String> {
    let (word, rest) = match path.split_once('.') {
        None => {
            table.insert(path.to_string(), value);
            return Ok(());
        }
        Some(split) => split,
    };
    if word.is_empty() || rest.is_empty() {
        return Err("expected words between dots".into());
    }
    let inner = table
        .entry(word.to_string())
        .or_insert_with(|| Value::Table(Table::new()));
    match inner {
        Value::Table(inner) => set(inner, rest, value),
        Value::Array(elements) => {
            let (element, rest) = element(elements, word, rest)?;
            match element {
                Value::Table(inner) => set(inner, rest, value),
                _ => Err(format!("`{word}` is no list of tables")),
            }
        }
        _ => Err(format!("`{word}` is no table that could have `{rest}`")),
    }
}

/// The element that the beginning of a path names, and the rest of the path. Names may have dots in them.
fn element<'a, 'p>(
    elements: &'a mut [Value],
    list: &str,
    path: &'p str,
) -> Result<(&'a mut Value, &'p str), String> {
    let name = |element: &Value| {
        let word = |key: &str| Some(element.get(key)?.as_str()?.to_string());
        word("name").or_else(|| word("kind")).or_else(|| {
            // A dataset goes by its file.
            let file = word("file").or_else(|| word("world"))?;
            let stem = std::path::Path::new(&file).file_stem()?;
            Some(stem.to_string_lossy().into_owned())
        })
    };
    let names: Vec<Option<String>> = elements.iter().map(name).collect();
    let behind = |name: &str| path.strip_prefix(name)?.strip_prefix('.');
    let named = names.iter().enumerate().filter_map(|(at, name)| {
        let name = name.as_deref()?;
        Some((at, name.len(), behind(name)?))
    });
    if let Some((at, _, rest)) = named.max_by_key(|(_, length, _)| *length) {
        return Ok((&mut elements[at], rest));
    }
    let number = path.split_once('.');
    let number = number.and_then(|(word, rest)| Some((word.parse::<usize>().ok()?, rest)));
    if let Some((number, rest)) = number
        && (1..=elements.len()).contains(&number)
    {
        return Ok((&mut elements[number - 1], rest));
    }
    let names: Vec<String> = names.into_iter().flatten().collect();
    Err(format!(
        "no [[{list}]] that `{path}` begins with and a key behind it; expected one of {}, or a number from 1",
        names.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml::toml;

    #[test]
    fn paths_lead_into_tables_and_lists_of_tables() {
        let mut config = toml! {
            [train]
            steps = 5
            [[system]]
            kind = "ball"
            [[system]]
            kind = "nearest"
            name = "every 0.5 m"
        };
        let mut set = |path: &str| set(&mut config, path, 7.into());
        set("train.steps").unwrap();
        set("train.descent.rate").unwrap();
        set("system.ball.train.features").unwrap();
        set("system.every 0.5 m.spacing_m").unwrap();
        set("system.2.reach_m").unwrap();
        assert_eq!(
            config,
            toml! {
                [train]
                steps = 7
                descent = { rate = 7 }
                [[system]]
                kind = "ball"
                train = { features = 7 }
                [[system]]
                kind = "nearest"
                name = "every 0.5 m"
                spacing_m = 7
                reach_m = 7
            }
        );
    }

    #[test]
    fn a_path_that_leads_nowhere_says_so() {
        let config = toml! {
            steps = 5
            [[system]]
            kind = "ball"
        };
        for (path, part) in [
            ("system.bal.k", "no [[system]] that `bal.k`"),
            ("system.2.k", "expected one of ball"),
            ("system.ball", "no [[system]]"),
            ("steps.first", "`steps` is no table"),
            ("other..k", "words between dots"),
        ] {
            let fault = set(&mut config.clone(), path, 1.into()).unwrap_err();
            assert!(fault.contains(part), "{path}: {fault}");
        }
    }
}
