//! The one error of the crate: a kind that decides the exit status and one line a person can act on.

use std::{fmt, io, path::Path};

/// What every fallible function of the crate returns.
pub type Result<T> = std::result::Result<T, Error>;

/// What went wrong, in one line that names the file, the place in it, the fault and what was expected.
///
/// ```
/// let error = ballmark::Error::input("walk.csv", "line 7", "column `x_m` holds `abc`; expected metres as a number");
/// assert!(error.is_input());
/// assert_eq!(error.to_string(), "walk.csv: line 7: column `x_m` holds `abc`; expected metres as a number");
/// ```
#[derive(Debug)]
pub struct Error {
    kind: Kind,
    message: String,
    source: Option<io::Error>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Usage,
    Input,
    Io,
    Work,
    Cancelled,
}

impl Error {
    /// The call itself is wrong: an argument or a configuration key.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(Kind::Usage, message.into())
    }

    /// A file's content is wrong: `file`, the `place` in it (line, array, key), and the `fault` with what was expected.
    pub fn input(
        file: impl AsRef<Path>,
        place: impl fmt::Display,
        fault: impl fmt::Display,
    ) -> Self {
        Self::new(
            Kind::Input,
            format!("{}: {place}: {fault}", file.as_ref().display()),
        )
    }

    /// A file as a whole is wrong (empty, of another format).
    pub fn file(file: impl AsRef<Path>, fault: impl fmt::Display) -> Self {
        Self::new(Kind::Input, format!("{}: {fault}", file.as_ref().display()))
    }

    /// The operating system refused: `action` is a verb phrase such as "cannot write".
    pub fn io(action: &str, file: impl AsRef<Path>, source: io::Error) -> Self {
        let message = format!("{}: {action}: {source}", file.as_ref().display());
        Self {
            kind: Kind::Io,
            message,
            source: Some(source),
        }
    }

    /// The input is well formed, but the work asked for can't be done with it.
    pub fn work(message: impl Into<String>) -> Self {
        Self::new(Kind::Work, message.into())
    }

    /// The caller asked for an end before there was a result.
    pub fn cancelled(message: impl Into<String>) -> Self {
        Self::new(Kind::Cancelled, message.into())
    }

    fn new(kind: Kind, message: String) -> Self {
        Self {
            kind,
            message,
            source: None,
        }
    }

    /// The same error, its message preceded by the name of the file that it comes from.
    pub fn in_file(self, file: impl AsRef<Path>) -> Self {
        self.context(file.as_ref().display())
    }

    /// The same error, its message preceded by what it is about: a key, a system, a file.
    pub fn context(mut self, what: impl fmt::Display) -> Self {
        self.message = format!("{what}: {}", self.message);
        self
    }

    /// The same error, its message followed by what to do.
    pub fn followed_by(mut self, what: impl fmt::Display) -> Self {
        self.message = format!("{}; {what}", self.message);
        self
    }

    /// Is the call at fault (exit status 2)?
    pub fn is_usage(&self) -> bool {
        self.kind == Kind::Usage
    }

    /// Is the content of a file at fault?
    pub fn is_input(&self) -> bool {
        self.kind == Kind::Input
    }

    /// Did the operating system refuse to read or write?
    pub fn is_io(&self) -> bool {
        self.kind == Kind::Io
    }

    /// Did the caller ask for an end before there was a result?
    pub fn is_cancelled(&self) -> bool {
        self.kind == Kind::Cancelled
    }

    /// Was the other end of a pipe closed (`ballmark … | head`)? Then there is nothing to complain about.
    pub fn is_broken_pipe(&self) -> bool {
        self.source
            .as_ref()
            .is_some_and(|source| source.kind() == io::ErrorKind::BrokenPipe)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.source.as_ref().map(|source| source as _)
    }
}
