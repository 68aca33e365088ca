//! Reading Rust source just well enough to know which paths a file names: comments and strings don't count.

/// A word, `::`, or one character of punctuation, and the line it stands on.
#[derive(Debug, PartialEq)]
pub struct Token {
    pub text: String,
    pub line: usize,
}

/// A path named in a file, in full: `crate::…`, `super::…` and `self::…` resolved, groups unfolded.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Named {
    pub line: usize,
    /// `crate` or the name of another crate, then the modules and the item.
    pub path: Vec<String>,
}

/// The tokens of a source text without comments, strings and characters.
pub fn tokens(text: &str) -> Vec<Token> {
    let chars: Vec<char> = text.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\0');
    let (mut i, mut line, mut found) = (0, 1, Vec::new());
    while i < chars.len() {
        let start = i;
        let word = at(i).is_alphanumeric() || at(i) == '_';
        match (at(i), at(i + 1)) {
            ('/', '/') => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1;
                }
            }
            ('/', '*') => i = end_of_block_comment(&chars, i),
            ('"', _) => i = end_of_string(&chars, i),
            ('\'', '\\') => {
                i += 3;
                while i < chars.len() && at(i) != '\'' {
                    i += 1;
                }
                i += 1;
            }
            ('\'', _) if at(i + 2) == '\'' => i += 3,
            (':', ':') => {
                found.push((line, "::".to_string()));
                i += 2;
            }
            _ if word => {
                while at(i).is_alphanumeric() || at(i) == '_' {
                    i += 1;
                }
                let name: String = chars[start..i].iter().collect();
                match end_of_raw_string(&chars, i) {
                    Some(end) if ["r", "br", "cr"].contains(&name.as_str()) => i = end,
                    _ => found.push((line, name)),
                }
            }
            (other, _) => {
                if !other.is_whitespace() {
                    found.push((line, other.to_string()));
                }
                i += 1;
            }
        }
        let end = i.min(chars.len());
        line += chars[start..end].iter().filter(|&&c| c == '\n').count();
    }
    let token = |(line, text)| Token { text, line };
    found.into_iter().map(token).collect()
}

fn end_of_block_comment(chars: &[char], start: usize) -> usize {
    let (mut i, mut depth) = (start + 2, 1);
    while i < chars.len() && depth > 0 {
        match (chars[i], chars.get(i + 1)) {
            ('/', Some('*')) => (i, depth) = (i + 2, depth + 1),
            ('*', Some('/')) => (i, depth) = (i + 2, depth - 1),
            _ => i += 1,
        }
    }
    i
}

fn end_of_string(chars: &[char], start: usize) -> usize {
    let mut i = start + 1;
    while i < chars.len() && chars[i] != '"' {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    i + 1
}

/// From behind the `r` of `r"…"` or `r#"…"#`; none where it isn't one.
fn end_of_raw_string(chars: &[char], start: usize) -> Option<usize> {
    let hashes = chars[start..].iter().take_while(|&&c| c == '#').count();
    let mut i = start + hashes;
    if chars.get(i) != Some(&'"') {
        return None;
    }
    loop {
        i += 1;
        let behind = i + 1;
        let closing = chars.get(behind..behind + hashes);
        match chars.get(i) {
            None => return Some(i),
            Some('"') if closing.is_some_and(|c| c.iter().all(|&c| c == '#')) => {
                return Some(behind + hashes);
            }
            Some(_) => {}
        }
    }
}

/// The module that a file is: `src/world/corridor/plan.rs` is `crate::world::corridor::plan`.
pub fn module_of(file: &str) -> Vec<String> {
    let inner = file.trim_start_matches("src/").trim_end_matches(".rs");
    let mut module: Vec<String> = vec!["crate".into()];
    module.extend(inner.split('/').map(String::from));
    if ["mod", "lib", "main"].contains(&inner.rsplit('/').next().unwrap_or("")) {
        module.pop();
    }
    module
}

/// Every path of two or more parts that a file names.
pub fn named(file: &str, text: &str) -> Vec<Named> {
    let tokens = tokens(text);
    let word = |i: usize| tokens.get(i).map_or("", |t: &Token| t.text.as_str());
    let mut module = module_of(file);
    let mut depth = 0;
    let mut inner_modules = Vec::new(); // the depth at which each `mod name { … }` around us was opened
    let mut found = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let is_name = word(i).starts_with(|c: char| c.is_alphabetic() || c == '_');
        if word(i) == "mod" && word(i + 2) == "{" {
            module.push(word(i + 1).to_string());
            inner_modules.push(depth);
            (i, depth) = (i + 3, depth + 1);
        } else if word(i) == "use" && ["crate", "self", "super", "{"].contains(&word(i + 1)) {
            i = unfold(&tokens, i + 1, &[], &module, &mut found);
        } else if is_name && word(i + 1) == "::" {
            i = unfold(&tokens, i, &[], &module, &mut found);
        } else {
            match word(i) {
                "{" => depth += 1,
                "}" => {
                    depth -= 1;
                    if inner_modules.last() == Some(&depth) {
                        inner_modules.pop();
                        module.pop();
                    }
                }
                _ => {}
            }
            i += 1;
        }
    }
    found
}

/// Unfolds the path or group that begins at token `i` below `stem`; returns where it ends.
fn unfold(
    tokens: &[Token],
    mut i: usize,
    stem: &[String],
    module: &[String],
    found: &mut Vec<Named>,
) -> usize {
    let word = |i: usize| tokens.get(i).map_or("", |t: &Token| t.text.as_str());
    let line = tokens.get(i).map_or(0, |t| t.line);
    let mut path = stem.to_vec();
    loop {
        match word(i) {
            "{" => {
                i += 1;
                while i < tokens.len() && word(i) != "}" {
                    let before = i;
                    i = unfold(tokens, i, &path, module, found);
                    if word(i) == "as" {
                        i += 2;
                    }
                    if word(i) == "," || i == before {
                        i += 1;
                    }
                }
                return i + 1;
            }
            "self" if !path.is_empty() => {} // `use a::{self}` names a
            "super" if path.is_empty() => {
                path = module.to_vec();
                path.pop();
            }
            "super" => {
                path.pop();
            }
            "self" => path = module.to_vec(),
            name => path.push(name.to_string()),
        }
        i += 1;
        let goes_on = word(i + 1) == "{"
            || word(i + 1) == "*"
            || word(i + 1).starts_with(|c: char| c.is_alphabetic() || c == '_');
        if word(i) != "::" || !goes_on {
            break; // the end, or `::<…>` behind a function's name
        }
        i += 1;
    }
    found.push(Named { line, path });
    i
}
