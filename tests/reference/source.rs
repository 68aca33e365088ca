//! Reading structs and enums out of Rust source as rustfmt leaves it: names, types, doc comments and attributes.

use std::{fs, path::Path};

/// A struct with named fields, or an enum.
#[derive(Debug)]
pub struct Item {
    /// File it stands in, `src/…` with slashes.
    pub file: String,
    pub name: String,
    pub is_enum: bool,
    /// Seen from outside its file.
    pub is_public: bool,
    /// Doc comment, a line each.
    pub doc: Vec<String>,
    pub attributes: String,
    /// Fields or variants.
    pub members: Vec<Member>,
}

/// A field of a struct, or a variant of an enum.
#[derive(Debug, Default)]
pub struct Member {
    pub name: String,
    /// Of a field its type; of a variant what is in its brackets.
    pub of_type: String,
    pub doc: Vec<String>,
    pub attributes: String,
}

/// All structs and enums below a folder.
pub fn items(folder: &Path) -> Vec<Item> {
    let mut files = Vec::new();
    collect(folder, &mut files);
    files.sort();
    let mut found = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file).expect("source is text");
        let file = file
            .strip_prefix(folder.parent().expect("src has a parent"))
            .expect("files are in the folder");
        found.extend(items_of(&file.to_string_lossy().replace('\\', "/"), &text));
    }
    found
}

fn collect(folder: &Path, files: &mut Vec<std::path::PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of source") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

/// The structs and enums of one file.
pub fn items_of(file: &str, text: &str) -> Vec<Item> {
    let mut found = Vec::new();
    let mut lines = text.lines();
    let mut before = Member::default();
    while let Some(line) = lines.next() {
        if described(line, &mut lines, &mut before) {
            continue;
        }
        let noted = std::mem::take(&mut before);
        let Some((is_enum, name)) = head(line) else {
            continue;
        };
        let members = match line.ends_with('{') {
            true => members(&mut lines, is_enum),
            false => Vec::new(),
        };
        found.push(Item {
            file: file.into(),
            name: name.into(),
            is_enum,
            is_public: line.starts_with("pub"),
            doc: noted.doc,
            attributes: noted.attributes,
            members,
        });
    }
    found
}

/// Notes a line that describes what follows it: a doc comment or an attribute, which may go on over more lines.
fn described<'a>(
    line: &str,
    lines: &mut impl Iterator<Item = &'a str>,
    before: &mut Member,
) -> bool {
    let line = line.trim();
    if let Some(doc) = line.strip_prefix("///") {
        before.doc.push(doc.strip_prefix(' ').unwrap_or(doc).into());
        return true;
    }
    if !line.starts_with("#[") {
        return line.starts_with("//") && !line.starts_with("//!");
    }
    let mut attribute = line.to_string();
    while attribute.matches('[').count() > attribute.matches(']').count() {
        attribute.push_str(lines.next().expect("an attribute ends").trim());
    }
    before.attributes.push_str(&attribute);
    true
}

/// Is it a struct or an enum that begins on this line, and how is it called? Macros' `$name` is none.
fn head(line: &str) -> Option<(bool, &str)> {
    let mut words = line.split_whitespace();
    let mut word = words.next()?;
    if word.starts_with("pub") {
        word = words.next()?;
    }
    let is_enum = match word {
        "struct" => false,
        "enum" => true,
        _ => return None,
    };
    let name = words.next()?;
    let end = name
        .find(|c: char| !(c.is_alphanumeric() || c == '_'))
        .unwrap_or(name.len());
    (end > 0 && !line.starts_with(' ')).then_some((is_enum, &name[..end]))
}

fn members<'a>(lines: &mut impl Iterator<Item = &'a str>, is_enum: bool) -> Vec<Member> {
    let mut found: Vec<Member> = Vec::new();
    let mut before = Member::default();
    while let Some(line) = lines.next() {
        if line == "}" {
            break;
        }
        // Deeper lines are fields of a variant.
        if line.starts_with("     ") || line == "    }," || described(line, lines, &mut before) {
            continue;
        }
        let mut member = std::mem::take(&mut before);
        let line = line.trim().trim_end_matches(',');
        let line = line.strip_prefix("pub(crate) ").unwrap_or(line);
        let line = line.strip_prefix("pub(super) ").unwrap_or(line);
        let line = line.strip_prefix("pub ").unwrap_or(line);
        let (name, rest) = match is_enum {
            true => line.split_once(['(', ' ', '=']).unwrap_or((line, "")),
            false => line.split_once(": ").unwrap_or((line, "")),
        };
        member.name = name.trim().into();
        member.of_type = rest
            .trim()
            .trim_end_matches(if is_enum { ')' } else { ' ' })
            .into();
        found.push(member);
    }
    found
}

impl Item {
    /// The words of a serde attribute: `Some("")` for `default`, `Some("f")` for `default = "f"`.
    pub fn serde(&self, key: &str) -> Option<String> {
        serde(&self.attributes, key)
    }

    pub fn is_config(&self) -> bool {
        self.attributes.contains("Serialize") || self.attributes.contains("Deserialize")
    }
}

impl Member {
    pub fn serde(&self, key: &str) -> Option<String> {
        serde(&self.attributes, key)
    }
}

fn serde(attributes: &str, key: &str) -> Option<String> {
    attributes.split("#[").find_map(|attribute| {
        let inner = attribute.strip_prefix("serde(")?;
        let inner = &inner[..inner.rfind(')')?];
        inner.split(',').find_map(|part| {
            let part = part.trim();
            match part.split_once('=') {
                Some((name, value)) => {
                    (name.trim() == key).then(|| value.trim().trim_matches('"').to_string())
                }
                None => (part == key).then(String::new),
            }
        })
    })
}
