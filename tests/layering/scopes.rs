//! What a file defines, brings in and names, module by module: test-only parts are passed over.

use super::source::{Token, module_of, tokens};
use std::collections::{BTreeMap, BTreeSet};

/// A file as far as names go.
pub struct Scanned {
    /// The file's own module and those written out inside it.
    pub modules: BTreeMap<Vec<String>, Scope>,
    /// Every path that the file uses.
    pub named: Vec<Used>,
    /// Modules that are declared for tests only.
    pub test_modules: Vec<Vec<String>>,
}

/// The names of one module.
#[derive(Default)]
pub struct Scope {
    pub imports: Vec<Import>,
    /// Modules whose items are all brought in.
    pub globs: Vec<Vec<String>>,
    /// Items that are defined here.
    pub items: BTreeSet<String>,
}

/// A name that `use` brings in, and what it leads to: from `crate` on, or from the module's own names.
#[derive(Clone)]
pub struct Import {
    pub name: String,
    pub path: Vec<String>,
    public: bool,
    line: usize,
}

/// A path, the module that it is named in, and the line.
pub struct Used {
    pub module: Vec<String>,
    pub path: Vec<String>,
    pub line: usize,
}

/// Words that name an item that stands behind them.
const DEFINES: [&str; 8] = [
    "fn", "struct", "enum", "union", "trait", "type", "const", "static",
];

/// Reads a file.
pub fn scan(file: &str, text: &str) -> Scanned {
    let all = tokens(text);
    let (tokens, tests) = without_tests(&all);
    let word = |i: usize| tokens.get(i).map_or("", |t: &&Token| t.text.as_str());
    let is_name = |i: usize| word(i).starts_with(|c: char| c.is_alphabetic() || c == '_');
    let mut module = module_of(file);
    let test_modules = tests
        .into_iter()
        .map(|name| [&module[..], &[name]].concat());
    let test_modules = test_modules.collect();
    let mut modules = BTreeMap::from([(module.clone(), Scope::default())]);
    let mut named = Vec::new();
    let mut words: BTreeMap<Vec<String>, BTreeSet<&str>> = BTreeMap::new();
    let mut opened = vec![0]; // depth of braces at which each module that we are in begins
    let (mut depth, mut i) = (0, 0);
    while i < tokens.len() {
        let scope = modules.entry(module.clone()).or_default();
        let (line, at_module) = (tokens[i].line, opened.last() == Some(&depth));
        if word(i) == "mod" && word(i + 2) == "{" {
            module.push(word(i + 1).to_string());
            depth += 1;
            opened.push(depth);
            i += 3;
        } else if word(i) == "use" && (is_name(i + 1) || ["{", "::"].contains(&word(i + 1))) {
            let public = i > 0 && ["pub", ")"].contains(&word(i - 1));
            let mut leaves = Vec::new();
            i = use_tree(&tokens, i + 1, &[], &module, &mut leaves);
            for (name, path) in leaves {
                if name == "*" {
                    if !public {
                        // No item is called so: the glob counts for the module's own file.
                        let path = [&path[..], &[name]].concat();
                        named.push(Used {
                            module: module.clone(),
                            path,
                            line,
                        });
                    }
                    scope.globs.push(path);
                } else {
                    scope.imports.push(Import {
                        name,
                        path,
                        public,
                        line,
                    });
                }
            }
        } else if at_module && DEFINES.contains(&word(i)) && is_name(i + 1) && word(i + 1) != "fn" {
            scope.items.insert(word(i + 1).to_string());
            i += 2;
        } else if is_name(i) {
            let before = i.checked_sub(1).map_or("", word);
            let mut path = vec![word(i).to_string()];
            while word(i + 1) == "::" && is_name(i + 2) {
                path.push(word(i + 2).to_string());
                i += 2;
            }
            if path.len() == 1 {
                words.entry(module.clone()).or_default().insert(word(i));
            } else if before != "::" {
                words
                    .entry(module.clone())
                    .or_default()
                    .insert(tokens[i - 2 * (path.len() - 1)].text.as_str());
                named.push(Used {
                    module: module.clone(),
                    path: full(&module, &path),
                    line,
                });
            }
            i += 1;
        } else {
            match word(i) {
                "{" => depth += 1,
                "}" => {
                    if opened.len() > 1 && opened.last() == Some(&depth) {
                        opened.pop();
                        module.pop();
                    }
                    depth -= 1;
                }
                _ => {}
            }
            i += 1;
        }
    }
    // What is brought in privately is used; what is brought in for others is where the file names it besides.
    for (module, scope) in &modules {
        let is_used = |import: &&Import| {
            let by_name = |words: &BTreeSet<&str>| words.contains(import.name.as_str());
            !import.public || words.get(module).is_some_and(by_name)
        };
        named.extend(scope.imports.iter().filter(is_used).map(|import| Used {
            module: module.clone(),
            path: import.path.clone(),
            line: import.line,
        }));
    }
    Scanned {
        modules,
        named,
        test_modules,
    }
}

/// The tokens outside of items marked `#[cfg(test)]`, and the names of modules so marked that are files of their own.
fn without_tests(tokens: &[Token]) -> (Vec<&Token>, Vec<String>) {
    const MARK: [&str; 7] = ["#", "[", "cfg", "(", "test", ")", "]"];
    let word = |i: usize| tokens.get(i).map_or("", |t: &Token| t.text.as_str());
    let (mut kept, mut modules, mut i) = (Vec::new(), Vec::new(), 0);
    while i < tokens.len() {
        if !MARK
            .iter()
            .enumerate()
            .all(|(k, part)| word(i + k) == *part)
        {
            kept.push(&tokens[i]);
            i += 1;
            continue;
        }
        i += MARK.len();
        let mut depth = 0;
        while i < tokens.len() {
            match word(i) {
                "mod" if depth == 0 && word(i + 2) == ";" => modules.push(word(i + 1).to_string()),
                "{" | "(" | "[" => depth += 1,
                "}" | ")" | "]" => depth -= 1,
                _ => {}
            }
            i += 1;
            if depth == 0 && [";", "}"].contains(&word(i - 1)) {
                break;
            }
        }
    }
    (kept, modules)
}

/// Unfolds what stands behind `use`, or in a group of it, from token `i` on, below `stem`; returns where it ends. A name
/// that is brought in as `_` serves methods only and is told by what it was called.
fn use_tree(
    tokens: &[&Token],
    mut i: usize,
    stem: &[String],
    module: &[String],
    leaves: &mut Vec<(String, Vec<String>)>,
) -> usize {
    let word = |i: usize| tokens.get(i).map_or("", |t: &&Token| t.text.as_str());
    let mut path = stem.to_vec();
    if word(i) == "::" {
        path.push(String::new()); // another crate, whatever modules there are
        i += 1;
    }
    loop {
        match word(i) {
            "{" => {
                i += 1;
                while i < tokens.len() && word(i) != "}" {
                    let before = i;
                    i = use_tree(tokens, i, &path, module, leaves);
                    if word(i) == "," || i == before {
                        i += 1;
                    }
                }
                return i + 1;
            }
            "*" => {
                leaves.push(("*".into(), full(module, &path)));
                return i + 1;
            }
            "self" if !path.is_empty() => {} // `a::{self}` brings in a
            part => path.push(part.to_string()),
        }
        i += 1;
        if word(i) != "::" {
            break;
        }
        i += 1;
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if word(i) == "as" {
        if word(i + 1) != "_" {
            name = word(i + 1).to_string();
        }
        i += 2;
    }
    leaves.push((name, full(module, &path)));
    i
}

/// A path from `crate` on where it begins with `crate`, `self` or `super`; others as they stand.
fn full(module: &[String], path: &[String]) -> Vec<String> {
    let mut place: Vec<String> = match path.first().map(String::as_str) {
        Some("self" | "super") => module.to_vec(),
        _ => return path.to_vec(),
    };
    let mut rest = path;
    while let Some((first, behind)) = rest.split_first() {
        match first.as_str() {
            "self" => {}
            "super" => {
                place.pop();
            }
            _ => break,
        }
        rest = behind;
    }
    place.extend(rest.iter().cloned());
    place
}
