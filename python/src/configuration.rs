//! A configuration: a TOML file, or JSON of a Python dict with the same sections.

use crate::faults::raised;
use ballmark::{experiment::configuration::Experiment, learning::recipe::NamedRecipe};
use pyo3::{PyResult, exceptions::PyValueError};
use std::{io::Write, path::Path};

/// Reads a file of that name, or JSON behind the word `json:`; nothing at all is the default configuration.
pub fn read(source: Option<String>, recipe: Option<&str>) -> PyResult<Experiment> {
    let named = |name: &str| -> PyResult<NamedRecipe> {
        let found = serde_json::from_value(serde_json::Value::from(name));
        found.map_err(|e| PyValueError::new_err(format!("recipe: {e}")))
    };
    let recipe = recipe.map(named).transpose()?;
    let Some(text) = source else {
        return Experiment::read(None, recipe).map_err(raised);
    };
    let Some(json) = text.strip_prefix("json:") else {
        return Experiment::read(Some(Path::new(&text)), recipe).map_err(raised);
    };
    let wrong = |e: String| PyValueError::new_err(format!("config: {e}"));
    let value: serde_json::Value = serde_json::from_str(json).map_err(|e| wrong(e.to_string()))?;
    let toml = toml::to_string(&value).map_err(|e| wrong(e.to_string()))?;
    let mut file = tempfile::Builder::new()
        .prefix("config-")
        .suffix(".toml")
        .tempfile()
        .map_err(|e| wrong(e.to_string()))?;
    file.write_all(toml.as_bytes())
        .map_err(|e| wrong(e.to_string()))?;
    Experiment::read(Some(file.path()), recipe).map_err(raised)
}
