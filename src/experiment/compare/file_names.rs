//! Names of files after names of datasets and systems.

/// What files after these names may be called: ASCII letters, digits, `-` and `_`, and no two alike, also where a file
/// system takes capitals for small letters.
pub fn file_names<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut made: Vec<String> = Vec::new();
    for name in names {
        let plain = |c: char| match c {
            c if c.is_ascii_alphanumeric() || c == '-' => c,
            _ => '_',
        };
        let stem: String = name.chars().take(60).map(plain).collect();
        let numbered = |number: usize| match number {
            1 => stem.clone(),
            number => format!("{stem}-{number}"),
        };
        let free = |name: &String| !made.iter().any(|other| other.eq_ignore_ascii_case(name));
        // One of them is free, as each other name takes one at most.
        let name = (1..=made.len() + 1).map(numbered).find(free);
        made.push(name.unwrap_or_else(|| made.len().to_string()));
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_plain_and_differ() {
        let names = ["A, \"b\"", "A, 'b'", "../x", "a__-b_", "é", ""];
        let made = file_names(names.into_iter());
        assert_eq!(made, ["A___b_", "A___b_-2", "___x", "a__-b_", "_", ""]);
        assert_eq!(
            file_names(["a", "A", "a-2"].into_iter()),
            ["a", "A-2", "a-2-2"]
        );
    }
}
