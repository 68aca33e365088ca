//! stub
use super::arrays::Arrays;
use crate::error::{Error, Result};
use std::path::Path;
pub(super) fn write(_path: &Path, _meta: &str, _arrays: &Arrays) -> Result<()> {
    Err(Error::work("stub"))
}
pub(super) fn read(_path: &Path, _bytes: &[u8]) -> Result<(String, Arrays)> {
    Err(Error::work("stub"))
}
