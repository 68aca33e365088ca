//! Tables of a report: every format of each in a folder, and what of them a terminal shows.

use super::files::write_text;
use crate::{
    error::Result,
    report::comparison::{Reader, Sheet},
};
use std::path::Path;

/// Every table in every format, with what holds for all of them below it.
pub(super) fn write_sheets(folder: &Path, sheets: &[Sheet], captions: &[String]) -> Result<()> {
    for sheet in sheets {
        let mut table = sheet.table.clone();
        let csv = table.csv();
        write_text(&folder.join(format!("{}.csv", sheet.name)), &csv)?;
        if sheet.reader == Reader::Programs {
            continue;
        }
        let text = format!("{}\n\n{}", sheet.title, table.text());
        write_text(&folder.join(format!("{}.txt", sheet.name)), &text)?;
        table.caption(&sheet.title);
        for line in captions {
            table.caption(line);
        }
        write_text(
            &folder.join(format!("{}.md", sheet.name)),
            &table.markdown(),
        )?;
        write_text(&folder.join(format!("{}.tex", sheet.name)), &table.latex())?;
    }
    Ok(())
}

/// The tables that can be looked at, each below its title.
pub(super) fn sheets_text(sheets: &[Sheet]) -> String {
    let everyone = |sheet: &&Sheet| sheet.reader == Reader::Everyone;
    let shown = sheets.iter().filter(everyone);
    shown
        .map(|sheet| format!("{}\n\n{}\n", sheet.title, sheet.table.text()))
        .collect()
}
