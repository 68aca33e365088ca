//! A page of keys in Markdown, from the types that configurations are read into.

use crate::{
    defaults::Defaults,
    source::{Item, Member},
    words::{cased, cell, empty, kind, last_name, line, prose, shown, unit, unwrapped, written},
};
use std::fmt::Write as _;
use toml::Value;

/// Everything that the source says.
pub struct Source {
    pub items: Vec<Item>,
    pub defaults: Defaults,
}

/// A page, and what stands on it.
pub struct Page {
    pub text: String,
    /// Names of the types whose keys it tells.
    pub types: Vec<String>,
    /// Sections by path, type and defaults: kinds share some, which are told once.
    told: Vec<(String, String, Option<Value>)>,
}

/// What a section is made of.
pub struct Section<'a> {
    /// As it stands in the file: `train.descent`; empty: the keys above all sections.
    pub path: String,
    /// One of many: `[[dataset]]`.
    pub is_list: bool,
    pub item: &'a Item,
    /// Values of the keys left out, where the type can be asked.
    pub default: Option<Value>,
    /// A second set of them, and what it is called.
    pub other: Option<(&'a str, Value)>,
}

/// What a key's row and the lines and sections below the table are made of.
struct Key<'a> {
    kind: String,
    default: String,
    /// Values that it takes, a line each.
    values: Vec<String>,
    section: Option<Section<'a>>,
}

/// Types whose keys are told on another page: how a key of this type reads.
const ELSEWHERE: [(&str, &str); 2] = [
    (
        "Recipe",
        "table, its keys are those of [`[train]`](train.md)",
    ),
    (
        "recogniser::Config",
        "table: `kind` and the constants of [a recogniser](systems.md#recognisers)",
    ),
];

/// Fields that a file cannot have.
const NOT_IN_FILES: [(&str, &str); 2] = [
    ("LandmarksConfig", "door"),
    ("LandmarksConfig", "ceiling_light"),
];

impl Page {
    /// A page that begins so.
    pub fn new(text: String) -> Self {
        let (types, told) = (Vec::new(), Vec::new());
        Self { text, types, told }
    }
}

impl Section<'_> {
    fn heading(&self) -> String {
        let (open, close) = if self.is_list {
            ("[[", "]]")
        } else {
            ("[", "]")
        };
        format!("`{open}{}{close}`", self.path)
    }
}

impl Source {
    /// The type of that name: in this file, else in its folder, else the only one there is.
    pub fn find(&self, name: &str, file: &str) -> Option<&Item> {
        let named = |item: &&Item| item.name == name && item.is_public && item.is_config();
        let all: Vec<&Item> = self.items.iter().filter(named).collect();
        let folder = |file: &str| file.rsplit_once('/').map(|(folder, _)| folder.to_string());
        let here = all.iter().find(|item| item.file == file);
        let near = all.iter().find(|item| folder(&item.file) == folder(file));
        match (here.or(near), all.as_slice()) {
            (Some(item), _) => Some(item),
            (None, []) => None,
            (None, [only]) => Some(only),
            (None, several) => {
                let files: Vec<&String> = several.iter().map(|item| &item.file).collect();
                panic!("{file}: {name} may be that of any of {files:?}")
            }
        }
    }

    /// Writes a section and those within it.
    pub fn write(&self, page: &mut Page, section: Section) {
        let Section { item, path, .. } = &section;
        let same = (path.clone(), item.name.clone(), section.default.clone());
        if !path.is_empty() && page.told.contains(&same) {
            return;
        }
        page.told.push(same);
        page.types.push(item.name.clone());
        if !path.is_empty() {
            let _ = writeln!(page.text, "\n## {}", section.heading());
        }
        let _ = writeln!(page.text, "\n{}", prose(&item.doc));
        let (mut rows, mut values, mut below) = (String::new(), String::new(), Vec::new());
        for member in &item.members {
            let hidden = NOT_IN_FILES.contains(&(item.name.as_str(), member.name.as_str()));
            if !hidden && member.serde("skip").is_none() {
                let key = self.key(&section, member);
                rows.push_str(&self.row(&section, member, &key));
                if !key.values.is_empty() {
                    let _ = writeln!(
                        values,
                        "\nValues of `{}`:{}",
                        member.name,
                        key.values.join("\n")
                    );
                }
                below.extend(key.section);
            }
        }
        let (other, line) = match &section.other {
            Some((name, _)) => (format!(" {name} |"), "---|"),
            None => (String::new(), ""),
        };
        match rows.is_empty() {
            true => page.text.push_str("\nIt has no keys.\n"),
            false => {
                let _ = write!(
                    page.text,
                    "\n| key | type | default |{other} unit | meaning |\n|---|---|---|{line}---|---|\n{rows}"
                );
            }
        }
        page.text.push_str(&values);
        for inner in below {
            self.write(page, inner);
        }
    }

    /// What a field is to who writes a file.
    fn key<'a>(&'a self, section: &Section<'a>, member: &Member) -> Key<'a> {
        let item = section.item;
        let (is_list, inner) = unwrapped(&member.of_type);
        let asked = section.default.as_ref().and_then(|v| v.get(&member.name));
        let default = self.default(section, member, asked);
        let plain = |kind: String, default: String| Key {
            kind,
            default,
            values: Vec::new(),
            section: None,
        };
        if member.serde("flatten").is_some() {
            return plain("word".into(), "required".into());
        }
        if let Some((_, reads)) = ELSEWHERE.iter().find(|(name, _)| *name == inner) {
            return plain((*reads).into(), String::new());
        }
        let Some(of) = self.find(last_name(inner), &item.file) else {
            return plain(kind(&member.of_type), default);
        };
        if of.is_enum {
            let how = written(of);
            let one = if how.is_some() { "text" } else { "word" };
            let kind = if is_list {
                format!("list of {one}s")
            } else {
                one.to_string()
            };
            let variant = |v: &Member| format!("- `\"{}\"`: {}", cased(of, v), line(&v.doc));
            let values = match how {
                Some(how) => vec![format!(" {how}")],
                None => ["\n".to_string()]
                    .into_iter()
                    .chain(of.members.iter().map(variant))
                    .collect(),
            };
            return Key {
                kind,
                default,
                values,
                section: None,
            };
        }
        let by_name = if member.of_type.starts_with("BTreeMap<") {
            ".NAME"
        } else {
            ""
        };
        let path = match section.path.as_str() {
            "" => format!("{}{by_name}", member.name),
            path => format!("{path}.{}{by_name}", member.name),
        };
        let other = section.other.as_ref();
        let inner = Section {
            path,
            is_list,
            item: of,
            default: asked.filter(|_| !is_list).cloned(),
            other: other.and_then(|(name, v)| Some((*name, v.get(&member.name)?.clone()))),
        };
        let may_be_missing = is_list || member.of_type.starts_with("Option<");
        Key {
            kind: format!("table, see {}", inner.heading()),
            default: if may_be_missing {
                "none".into()
            } else {
                String::new()
            },
            values: Vec::new(),
            section: Some(inner),
        }
    }

    fn row(&self, section: &Section, member: &Member, key: &Key) -> String {
        let name = match member.serde("flatten") {
            Some(_) => "kind",
            None => &member.name,
        };
        let mut meaning = self.meaning(member, section.item);
        if let Some(former) = member.serde("alias") {
            let _ = write!(meaning, " Formerly `{former}`, which is still read.");
        }
        if member.serde("flatten").is_some() {
            meaning.push_str(" [All kinds](systems.md).");
        }
        let other = match &section.other {
            Some((_, values)) if key.section.is_none() => {
                let value = self.default(section, member, values.get(&member.name));
                let differs = value != key.default && !key.default.is_empty();
                format!(" {} |", if differs { cell(&value) } else { String::new() })
            }
            Some(_) => "  |".into(),
            None => String::new(),
        };
        format!(
            "| `{name}` | {} | {} |{other} {} | {} |\n",
            key.kind,
            cell(&key.default),
            unit(name),
            meaning.replace('|', "\\|")
        )
    }

    /// What a key means; where its documentation only points at another one (`See [`Look::colour`]`), what that says.
    fn meaning(&self, member: &Member, item: &Item) -> String {
        let doc = member.doc.join(" ");
        let pointed = doc
            .strip_prefix("See [`")
            .and_then(|d| d.strip_suffix("`]."));
        let same = pointed.and_then(|target| {
            let (of_type, field) = target.split_once("::").unwrap_or((target, &member.name));
            let of = self.find(of_type, &item.file).or_else(|| {
                let mut all = self.items.iter();
                all.find(|i| i.name == of_type && i.file.starts_with("src/world/"))
            })?;
            of.members.iter().find(|m| m.name == field)
        });
        line(same.map_or(&member.doc, |same| &same.doc))
    }

    /// What a key that is left out counts as, as it would be written; `none` where nothing could be written.
    fn default(&self, section: &Section, member: &Member, asked: Option<&Value>) -> String {
        let item = section.item;
        if let Some(value) = asked {
            return shown(value);
        }
        if member.of_type.starts_with("Option<") || section.default.is_some() {
            return "none".into();
        }
        let literal = match member.serde("default") {
            Some(function) if !function.is_empty() => self.defaults.function(&item.file, &function),
            Some(_) => None,
            None if item.serde("default").is_none() => return "required".into(),
            None => self.defaults.field(&item.name, &member.name),
        };
        if let Some(literal) = literal {
            return self.literal(literal, item);
        }
        let of = self.find(last_name(&member.of_type), &item.file);
        let first = of.and_then(|of| {
            Some((
                of,
                of.members
                    .iter()
                    .find(|m| m.attributes.contains("#[default]"))?,
            ))
        });
        match first {
            Some((of, variant)) => format!("\"{}\"", cased(of, variant)),
            None => empty(&member.of_type).into(),
        }
    }

    /// A Rust expression as TOML.
    fn literal(&self, expression: &str, item: &Item) -> String {
        let expression = expression
            .trim_end_matches(".into()")
            .trim_end_matches(".to_string()");
        match expression {
            "None" => return "none".into(),
            "Vec::new()" => return "[]".into(),
            "String::new()" => return "\"\"".into(),
            _ => {}
        }
        if let Some((of_type, variant)) = expression.split_once("::")
            && let Some(of) = self.find(of_type, &item.file)
            && let Some(variant) = of.members.iter().find(|member| member.name == variant)
        {
            return format!("\"{}\"", cased(of, variant));
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || "\"[]., -_".contains(c);
        assert!(
            expression.chars().all(plain),
            "{}: the default `{expression}` is not understood; teach tests/reference about it",
            item.name
        );
        expression.to_string()
    }
}
