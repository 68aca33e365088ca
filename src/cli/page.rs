//! The page of a report: `index.html` in the folder that the results go to.

use super::files::write_text;
use crate::{
    error::Result,
    report::{Page, page},
};
use std::{ffi::OsString, path::Path, sync::OnceLock};

/// What a report's page is called.
pub(super) const PAGE: &str = "index.html";

/// What the file is called that has all that decided a result.
pub(super) const CONFIG: &str = "config.json";

static CALL: OnceLock<String> = OnceLock::new();

/// Keeps the call's arguments, the program's name the first of them, once.
pub(super) fn remember(arguments: &[OsString]) {
    let words = arguments.iter().skip(1).map(|a| a.to_string_lossy());
    let words: Vec<String> = words.map(|word| quoted(&word)).collect();
    CALL.get_or_init(|| format!("ballmark {}", words.join(" ")));
}

/// The call as a shell understands it.
pub(super) fn call() -> Option<String> {
    CALL.get().cloned()
}

/// Writes a page to a folder that exists.
pub(super) fn write_page(folder: &Path, content: &Page) -> Result<()> {
    write_text(&folder.join(PAGE), &page(content)?)
}

/// A word as a shell takes it for one.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+%@".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_string(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_split_them() {
        assert_eq!(quoted("--out=a/b-1.npz"), "--out=a/b-1.npz");
        assert_eq!(quoted("it's here"), "'it'\\''s here'");
        assert_eq!(quoted(""), "''");
    }
}
