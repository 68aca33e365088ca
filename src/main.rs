//! The command `ballmark`; everything it does is in the library's `cli`.

fn main() -> std::process::ExitCode {
    ballmark::cli::run()
}
