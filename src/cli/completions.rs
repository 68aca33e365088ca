//! `ballmark completions` and `ballmark man`: what shells and man(1) read.

use super::{Outcome, print};
use crate::error::{Error, Result};
use clap::Command;
use clap_complete::{Shell, generate};
use std::path::PathBuf;

/// Print what makes a shell complete this command's words.
///
/// Bash: `ballmark completions bash > ~/.local/share/bash-completion/completions/ballmark`. Zsh: a file `_ballmark` in a folder
/// of `$fpath`. Fish: `~/.config/fish/completions/ballmark.fish`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark completions bash")]
pub struct Completions {
    /// Shell to complete for.
    #[arg(value_enum)]
    shell: Shell,
}

/// Write the manual pages: `ballmark.1`, and one for each command.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark man --out man1")]
pub struct Man {
    /// Folder to write to.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub fn completions(arguments: &Completions, mut command: Command) -> Result<Outcome> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut command, "ballmark", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}

pub fn man(arguments: &Man, command: Command) -> Result<Outcome> {
    let folder = &arguments.out;
    std::fs::create_dir_all(folder).map_err(|e| Error::io("cannot create", folder, e))?;
    let command = command.disable_help_subcommand(true);
    let pages = 1 + command.get_subcommands().count();
    clap_mangen::generate_to(command, folder).map_err(|e| Error::io("cannot write", folder, e))?;
    print(&format!("{pages} pages in {}\n", folder.display()))?;
    Ok(Outcome::Done)
}
