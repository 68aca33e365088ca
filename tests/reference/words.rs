//! Types, values and documentation in the words of somebody who writes a configuration.

use crate::source::{Item, Member};
use std::fmt::Write as _;
use toml::Value;

/// Text that may be read in place of a type, as the type's own documentation says it after this word.
const WRITTEN: &str = "Written ";

/// A type in words.
pub fn kind(of_type: &str) -> String {
    if let Some(inner) = of_type.strip_prefix("Option<") {
        return kind(inner.trim_end_matches('>'));
    }
    if let Some(inner) = of_type.strip_prefix("Vec<") {
        return format!(
            "list of {}",
            plural(inner.strip_suffix('>').unwrap_or(inner))
        );
    }
    if let Some(inner) = of_type.strip_prefix("BTreeMap<String, ") {
        return format!("table: names and {}", plural(inner.trim_end_matches('>')));
    }
    if let Some((inner, number)) = of_type.strip_prefix('[').and_then(|t| t.split_once("; ")) {
        return format!("{} {}", number.trim_end_matches(']'), plural(inner));
    }
    match last_name(of_type) {
        "f64" | "f32" => "number",
        "usize" | "u64" | "u32" | "u8" => "whole number",
        "bool" => "true or false",
        "String" => "text",
        "PathBuf" => "file name",
        "Value" | "Table" => "table",
        other => panic!("the type `{other}` is not understood; teach tests/reference about it"),
    }
    .into()
}

fn plural(of_type: &str) -> String {
    let one = kind(of_type);
    match one.strip_prefix("list") {
        Some(rest) => format!("lists{rest}"),
        None if one.starts_with(|c: char| c.is_ascii_digit()) => format!("lists of {one}"),
        None => format!("{one}s"),
    }
}

/// What the empty value of a type reads as.
pub fn empty(of_type: &str) -> &'static str {
    match of_type {
        "bool" => "false",
        "String" | "PathBuf" => "\"\"",
        "f64" | "f32" => "0.0",
        "usize" | "u64" | "u32" => "0",
        _ if of_type.starts_with("Vec<") => "[]",
        _ => "none",
    }
}

/// Is it a list, perhaps, and of what?
pub fn unwrapped(of_type: &str) -> (bool, &str) {
    for (wrapper, is_list) in [
        ("Option<", false),
        ("Vec<", true),
        ("BTreeMap<String, ", false),
    ] {
        if let Some(inner) = of_type.strip_prefix(wrapper) {
            let (more, inner) = unwrapped(inner.strip_suffix('>').unwrap_or(inner));
            return (is_list || more, inner);
        }
    }
    (false, of_type)
}

/// A type's name without the way to it.
pub fn last_name(of_type: &str) -> &str {
    of_type.rsplit("::").next().unwrap_or(of_type)
}

/// A variant as it is written.
pub fn cased(of: &Item, variant: &Member) -> String {
    if let Some(name) = variant.serde("rename") {
        return name;
    }
    let mut words = String::new();
    let style = of.serde("rename_all").unwrap_or_default();
    for (i, c) in variant.name.chars().enumerate() {
        match (c.is_uppercase() && i > 0, style.as_str()) {
            (true, "snake_case") => words.push('_'),
            (true, "kebab-case") => words.push('-'),
            _ => {}
        }
        words.push(c);
    }
    if style.is_empty() {
        words
    } else {
        words.to_lowercase()
    }
}

/// How a type that is read from a text is written, if its documentation says so.
pub fn written(of: &Item) -> Option<String> {
    of.serde("try_from")?;
    let said = line(&of.doc);
    let (_, how) = said.split_once(WRITTEN)?;
    Some(how.trim().to_string())
}

/// Documentation as one line.
pub fn line(doc: &[String]) -> String {
    prose(doc).replace('\n', " ")
}

/// Documentation as Markdown without code examples and links into the code.
pub fn prose(doc: &[String]) -> String {
    let mut text = String::new();
    let mut in_code = false;
    for line in doc {
        if line.starts_with("```") {
            in_code = !in_code;
        } else if line.starts_with("# ") {
            break; // "# Errors": of no interest to who writes a file
        } else if !in_code {
            text.push_str(line);
            text.push('\n');
        }
    }
    without_links(text.trim())
}

/// `[`Recipe::default`]` and `[words](path)` lose their brackets.
fn without_links(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, from)) = rest.split_once('[') {
        out.push_str(before);
        let Some((inner, behind)) = from.split_once(']') else {
            return out + "[" + from;
        };
        match behind.split_once(')') {
            Some((_, behind_link)) if behind.starts_with('(') => {
                out.push_str(inner);
                rest = behind_link;
            }
            _ if inner.starts_with('`') && inner.ends_with('`') => {
                let _ = write!(out, "`{}`", last_name(inner.trim_matches('`')));
                rest = behind;
            }
            _ => {
                out.push('[');
                rest = from;
            }
        }
    }
    out + rest
}

/// A value as it would be written.
pub fn shown(value: &Value) -> String {
    match value {
        Value::Float(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
            format!("{number:.1}")
        }
        Value::Float(number) => format!("{number}"),
        Value::Array(values) => {
            let all: Vec<String> = values.iter().map(shown).collect();
            format!("[{}]", all.join(", "))
        }
        Value::Table(_) => String::new(),
        other => other.to_string(),
    }
}

/// A default as it stands in a table.
pub fn cell(value: &str) -> String {
    match value {
        "" | "none" | "required" => value.into(),
        other => format!("`{}`", other.replace('|', "\\|")),
    }
}

/// The unit that the end of a key names.
pub fn unit(key: &str) -> &'static str {
    const UNITS: [(&str, &str); 8] = [
        ("_m_per_s", "m/s"),
        ("_rad_per_m", "rad/m"),
        ("_rad_per_s", "rad/s"),
        ("_per_m", ""),
        ("_m", "m"),
        ("_rad", "rad"),
        ("_deg", "°"),
        ("_s", "s"),
    ];
    let found = UNITS.iter().find(|(end, _)| key.ends_with(end));
    found.map_or("", |(_, unit)| unit)
}
