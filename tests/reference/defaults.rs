//! Default values as the source writes them, for types that can't be asked because they are read and never written.

use std::collections::BTreeMap;

/// `impl Default for …` and functions without arguments, by name.
#[derive(Debug, Default)]
pub struct Defaults {
    /// Expression of every field, by type and field.
    fields: BTreeMap<(String, String), String>,
    /// Expression that a function returns, by file and function.
    functions: BTreeMap<(String, String), String>,
}

impl Defaults {
    /// Notes those of one file.
    pub fn note(&mut self, file: &str, text: &str) {
        let mut of_type = None;
        let mut lines = text.lines().peekable();
        while let Some(line) = lines.next() {
            if let Some(rest) = line.strip_prefix("impl Default for ") {
                of_type = Some(rest.trim_end_matches(" {").to_string());
            } else if line == "}" {
                of_type = None;
            } else if let Some(name) = line.strip_prefix("fn ").and_then(|l| l.split_once("() ->"))
            {
                let body = lines.next().unwrap_or("").trim().to_string();
                let key = (file.to_string(), name.0.to_string());
                self.functions.insert(key, body);
            } else if let (Some(of_type), Some((field, value))) = (&of_type, field(line)) {
                let key = (of_type.clone(), field.to_string());
                self.fields.insert(key, value.to_string());
            }
        }
    }

    /// What a field has in `impl Default` of its type.
    pub fn field(&self, of_type: &str, field: &str) -> Option<&str> {
        let key = (of_type.to_string(), field.to_string());
        self.fields.get(&key).map(String::as_str)
    }

    /// What a function gives; `Light::default().size_m` is looked up.
    pub fn function(&self, file: &str, name: &str) -> Option<&str> {
        let key = (file.to_string(), name.to_string());
        let body = self.functions.get(&key)?;
        match body.split_once("::default().") {
            Some((of_type, of_field)) => self.field(of_type, of_field),
            None => Some(body),
        }
    }
}

/// `            name: value,` within `Self { … }`.
fn field(line: &str) -> Option<(&str, &str)> {
    let inner = line.strip_prefix("            ")?;
    let (name, value) = inner.split_once(": ")?;
    let is_name = name.chars().all(|c| c.is_alphanumeric() || c == '_');
    is_name.then(|| (name, value.trim_end_matches(',')))
}
