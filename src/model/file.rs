//! Models as files: read and written whole, in either container.

use super::{arrays::EXPECTED, layout, npz, safetensors, trained_model::Model};
use crate::{
    error::{Error, Result},
    storage,
};
use std::path::Path;

impl Model {
    /// Reads a model from a `.safetensors` or `.npz` file; the content says which of the two it is.
    ///
    /// # Errors
    /// Where the file is neither, is damaged, or lacks an array; the message names it.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(path, &storage::read_file(path)?)
    }

    /// Reads a model from the bytes of its file; `path` is for messages only.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        if bytes.is_empty() {
            return Err(Error::file(
                path,
                format!("the file is empty; expected {}", EXPECTED),
            ));
        }
        let (meta, arrays) = if bytes.starts_with(b"PK") {
            npz::read(path, bytes)?
        } else {
            safetensors::read(path, bytes)?
        };
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
        Self::check_name(path)?;
        if path.extension().is_some_and(|e| e == "npz") {
            npz::write(path, &self.meta()?, &layout::arrays(self, path))
        } else {
            safetensors::write(path, &self.meta()?, &layout::arrays(self, path))
        }
    }

    pub(super) fn meta(&self) -> Result<String> {
        serde_json::to_string(&self.header).map_err(|e| Error::work(format!("model header: {e}")))
    }
}
