//! What the user wants to see on the terminal: colours, and how much beside the results.

use clap::{
    ColorChoice,
    builder::styling::{AnsiColor, Style},
};
use std::{
    io::{IsTerminal, stderr},
    sync::OnceLock,
};

/// Options of every command.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct Options {
    /// Colours in help and messages: where a terminal shows them, always, or never. NO_COLOR turns them off, too.
    #[arg(
        long,
        global = true,
        value_name = "WHEN",
        default_value = "auto",
        help_heading = "Terminal"
    )]
    pub color: ColorChoice,

    /// No progress and no notes; warnings and what was lost are still said.
    #[arg(long, global = true, help_heading = "Terminal")]
    pub quiet: bool,

    /// End when this process does, which is the one that started this one: nobody else would take the result.
    #[arg(long, global = true, hide = true, value_name = "PID")]
    pub ends_with_parent: Option<u32>,
}

static CHOSEN: OnceLock<Options> = OnceLock::new();

/// Keeps what the user chose, once, before anything is said.
pub(super) fn choose(options: Options) {
    CHOSEN.get_or_init(|| options);
}

/// Are progress and notes not wanted?
pub(super) fn is_quiet() -> bool {
    CHOSEN.get().is_some_and(|options| options.quiet)
}

/// The choice of colours as far as it can be seen before arguments are parsed, for the help and faults of the call itself.
pub(super) fn color_of(arguments: impl Iterator<Item = String>) -> ColorChoice {
    let arguments: Vec<String> = arguments.collect();
    let word = arguments.iter().enumerate().find_map(|(at, argument)| {
        let value = argument.strip_prefix("--color=");
        value.or_else(|| {
            let next = arguments.get(at + 1).filter(|_| argument == "--color");
            next.map(String::as_str)
        })
    });
    match word {
        Some("always") => ColorChoice::Always,
        Some("never") => ColorChoice::Never,
        _ => ColorChoice::Auto,
    }
}

/// Letters of a message that are shown: the rest is what a file said at length.
const LONGEST: usize = 2000;

/// A message on one line, whatever a file said: control characters as escapes, the middle of what is too long left out.
pub(super) fn fit(line: &str) -> String {
    let mut one: String = line
        .chars()
        .flat_map(|c| match c.is_control() && c != '\t' {
            true => c.escape_debug().collect::<Vec<_>>(),
            false => vec![c],
        })
        .collect();
    let letters = one.chars().count();
    if letters > LONGEST {
        let start: String = one.chars().take(LONGEST / 2).collect();
        let end: String = one.chars().skip(letters - LONGEST / 2).collect();
        one = format!("{start} … {end}");
    }
    one
}

/// A message with its first word (`error:`, `warning:`, …) in colour, where that is wanted.
pub(super) fn painted(line: &str) -> String {
    let wanted = match CHOSEN
        .get()
        .map_or(ColorChoice::Auto, |options| options.color)
    {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => {
            stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
        }
    };
    let Some((word, rest)) = line.split_once(": ").filter(|_| wanted) else {
        return line.to_string();
    };
    let colour = match word {
        "error" => AnsiColor::Red,
        "warning" | "dropped" => AnsiColor::Yellow,
        "note" => AnsiColor::Cyan,
        _ => return line.to_string(),
    };
    let style = Style::new().bold().fg_color(Some(colour.into()));
    format!("{style}{word}:{style:#} {rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_without_escapes_and_not_endless() {
        assert_eq!(
            fit("error: a\nb\u{1b}[31m\tc"),
            "error: a\\nb\\u{1b}[31m\tc"
        );
        let long = fit(&format!(
            "error: {}; expected a number",
            "x".repeat(100_000)
        ));
        assert!(long.chars().count() < 2010 && long.ends_with("; expected a number"));
    }

    #[test]
    fn the_colour_is_seen_before_the_arguments_are_parsed() {
        let seen = |line: &str| color_of(line.split(' ').map(String::from));
        assert_eq!(seen("ballmark --color never import"), ColorChoice::Never);
        assert_eq!(seen("ballmark import --color=always"), ColorChoice::Always);
        assert_eq!(seen("ballmark import --color"), ColorChoice::Auto);
        assert_eq!(seen("ballmark import never"), ColorChoice::Auto);
    }
}
