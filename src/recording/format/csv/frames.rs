//! Pictures beside a table: a column names them, and each becomes the values of the channel `camera`.

use super::{Numbered, row::Row};
use crate::{delimited::Delimited, recording::image};
use rayon::prelude::*;
use std::path::Path;

/// Are the cells of a column names? They are if the first one that isn't empty is no number.
pub(super) fn are_named_in(table: &Delimited, column: usize) -> bool {
    let mut reader = table.reader();
    let rows = reader.byte_records().filter_map(Result::ok);
    let mut cells = rows.filter_map(|row| Some(row.get(column)?.to_vec()));
    let first = cells.find(|cell| !cell.is_empty());
    let is_number = |cell: &[u8]| {
        std::str::from_utf8(cell).is_ok_and(|cell| table.number::<f64>(cell).is_some())
    };
    first.is_some_and(|cell| !is_number(&cell))
}

/// Adds the pictures' values to their rows; a row whose picture can't be read is damaged. `table` lies where the names
/// start from.
pub(super) fn add(table: &Path, rows: &mut [Numbered]) {
    let folder = table.parent().unwrap_or(Path::new(""));
    rows.par_iter_mut().for_each(|numbered| {
        if let Ok(row) = &mut numbered.row
            && let Err(fault) = add_one(folder, row)
        {
            numbered.row = Err(fault);
        }
    });
}

fn add_one(folder: &Path, row: &mut Row) -> Result<(), String> {
    match &row.frame {
        None => {
            let width = image::channel().width;
            row.values.extend(std::iter::repeat_n(f32::NAN, width));
        }
        Some(name) => {
            let picture = image::read_frame(&folder.join(name)).map_err(|fault| {
                let shown: String = name.chars().take(80).collect();
                format!("frame `{}` {fault}", shown.escape_debug())
            })?;
            row.values.extend(image::features(&picture));
        }
    }
    Ok(())
}
