//! `ballmark view`: where the page of a report is, and a browser to look at it.

use super::{Outcome, page::PAGE, print};
use crate::error::{Error, Result};
use std::{
    path::{Path, PathBuf, absolute},
    process::{Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

/// Say where the page of a report is; --open shows it in the browser.
///
/// Every command that judges writes a page, index.html, to the folder that its --out (of trajectory: --report) names. It
/// is one file that needs nothing else: no network, no server. Nothing is sent or opened unless --open asks for it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  printf 'location,response\\nhall,1\\nhall,1\\ndoor,2\\ndoor,1\\n' > answers.csv
  ballmark score answers.csv --out scored
  ballmark view scored")]
pub struct Arguments {
    /// Folder of a report.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Start the browser that this system shows pages with.
    #[arg(long)]
    open: bool,
}

pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let folder = &arguments.folder;
    let page = match folder.is_dir() {
        true => folder.join(PAGE),
        false => folder.clone(), // the page itself, perhaps
    };
    let is_page = page.file_name().is_some_and(|name| name == PAGE);
    if !(page.is_file() && is_page) {
        return Err(Error::file(
            folder,
            format!("no {PAGE} here; expected a folder that --out of a command wrote a report to"),
        ));
    }
    let page = absolute(&page).map_err(|e| Error::io("cannot find", &page, e))?;
    print(&format!("{}\n", page.display()))?;
    if arguments.open {
        open(&page)?;
    }
    Ok(Outcome::Done)
}

/// What shows a file in the user's browser.
#[cfg(target_os = "macos")]
const OPENER: [&str; 1] = ["open"];
#[cfg(windows)]
const OPENER: [&str; 4] = ["cmd", "/C", "start", ""];
#[cfg(not(any(target_os = "macos", windows)))]
const OPENER: [&str; 1] = ["xdg-open"];

/// So long a browser may take to say that it can't be started; one that stays is none of our business.
const PATIENCE: Duration = Duration::from_secs(3);

fn open(page: &Path) -> Result<()> {
    let failed = |why: String| {
        let program = OPENER[0];
        let page = page.display();
        Error::work(format!(
            "cannot show {page}: {program}: {why}; expected a browser (open the file in one by hand)"
        ))
    };
    let mut opener = Command::new(OPENER[0])
        .args(&OPENER[1..])
        .arg(page)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|e| failed(e.to_string()))?;
    let started = Instant::now();
    while started.elapsed() < PATIENCE {
        match opener.try_wait() {
            Ok(None) => sleep(Duration::from_millis(50)),
            Ok(Some(status)) if status.success() => return Ok(()),
            Ok(Some(status)) => return Err(failed(status.to_string())),
            Err(e) => return Err(failed(e.to_string())),
        }
    }
    Ok(())
}
