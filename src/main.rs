//! The command `ballmark`; everything it does is in the library's `cli`.

// A training step makes and drops arrays of some hundred kilobytes; the system's allocator gives their pages back each
// time and takes new ones, which costs more than the sums in them.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    ballmark::cli::run()
}
