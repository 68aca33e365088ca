//! Models as files: read and written whole; graphs are read here, and written by [`onnx`].

use super::{
    arrays::{Arrays, EXPECTED},
    layout, npz, onnx, safetensors,
    trained_model::Model,
};
use crate::{
    error::{Error, Result},
    storage,
};
use std::path::Path;

impl Model {
    /// Reads a model from a `.safetensors` or `.npz` file, or from a graph that was exported as `.onnx`; the content says which it is.
    ///
    /// # Errors
    /// Where the file is none of them, is damaged, or lacks an array; the message names it.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(path, &storage::read_file(path)?)
    }

    /// Reads a model from the bytes of its file; `path` is for messages only.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        let (meta, arrays) = contents(path, bytes)?;
        layout::model(path, &meta, &arrays)
    }

    /// Is this a name that [`Model::write`] knows a container for, and could a file be made there? Asked before the
    /// work, not after it.
    ///
    /// # Errors
    /// Where its ending is neither `.safetensors` nor `.npz` (the call is wrong), or its folder is none.
    pub fn check_name(path: &Path) -> Result<()> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("safetensors" | "npz") => storage::check_target(path).map(|_| ()),
            _ => Err(Error::usage(format!(
                "{}: no such model format; expected a name ending in .safetensors or .npz",
                path.display()
            ))),
        }
    }

    /// Writes the model, whole or not at all; the container follows from the file name's ending.
    ///
    /// # Errors
    /// Where the ending is neither `.safetensors` nor `.npz` (a wrong call), or the file can't be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        put_down(path, &self.meta()?, &layout::arrays(self, path))
    }

    pub(super) fn meta(&self) -> Result<String> {
        serde_json::to_string(&self.header).map_err(|e| Error::work(format!("model header: {e}")))
    }
}

/// JSON and arrays of a file, whatever contains them.
pub(super) fn contents(path: &Path, bytes: &[u8]) -> Result<(String, Arrays)> {
    if bytes.is_empty() {
        return Err(Error::file(
            path,
            format!("the file is empty; expected {EXPECTED}"),
        ));
    }
    match bytes {
        zip if zip.starts_with(b"PK") => npz::read(path, zip),
        graph if onnx::is_graph(graph) => onnx::read(path, graph),
        other => safetensors::read(path, other),
    }
}

/// Writes JSON and arrays, whole or not at all, in the container that the file name's ending says.
pub(super) fn put_down(path: &Path, meta: &str, arrays: &Arrays) -> Result<()> {
    Model::check_name(path)?;
    match path.extension().is_some_and(|e| e == "npz") {
        true => npz::write(path, meta, arrays),
        false => safetensors::write(path, meta, arrays),
    }
}
